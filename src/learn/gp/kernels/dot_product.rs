//! The interface of kernels of the scaled dot product `x·y = Σ_d x_d y_d / l_d²`, and what follows
//! from it for all of them.

use super::component::{Component, Hyperparameter, PairRow};

/// A kernel and its derivatives at `x·y`, `x·x`, `y·y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DotValue {
    /// `k(x, y)`.
    pub value: f64,
    /// Derivatives with respect to `x·y`, `x·x` and `y·y`.
    pub slopes: [f64; 3],
}

/// Formula of a kernel of the dot product: the whole content of its file.
pub trait DotFormula: Send + Sync {
    /// Name in specs.
    const NAME: &'static str;

    /// The kernel at the products `[x·y, x·x, y·y]`.
    fn at(products: [f64; 3]) -> DotValue;
}

/// `[x·y, x·x, y·y]` of the point y with every point x.
fn products(scales: &[f64], row: &PairRow, count: usize) -> Vec<[f64; 3]> {
    let mut out = vec![[0.0; 3]; count];
    for ((values, centre), scale) in row.each().zip(scales) {
        let y = centre / scale;
        for (products, x) in out.iter_mut().zip(values) {
            let x = x / scale;
            products[0] += x * y;
            products[1] += x * x;
            products[2] += y * y;
        }
    }
    out
}

impl<F: DotFormula> Component for F {
    fn name(&self) -> &'static str {
        F::NAME
    }

    fn hyperparameters(&self, inputs: usize) -> Vec<Hyperparameter> {
        (0..inputs).map(Hyperparameter::scale).collect()
    }

    fn values(&self, parameters: &[f64], row: &PairRow, out: &mut [f64]) {
        let products = products(parameters, row, out.len());
        out.iter_mut().zip(products).for_each(|(out, products)| *out = F::at(products).value);
    }

    fn rates(&self, parameters: &[f64], row: &PairRow, out: &mut [Vec<f64>]) {
        let products = products(parameters, row, out.first().map_or(0, Vec::len));
        let slopes: Vec<[f64; 3]> =
            products.into_iter().map(|products| F::at(products).slopes).collect();
        for (((values, centre), scale), rates) in row.each().zip(parameters).zip(out) {
            let y = centre / scale;
            for ((rate, x), slopes) in rates.iter_mut().zip(values).zip(&slopes) {
                let x = x / scale;
                // Every product falls with the square of the scale, hence −2 in the logarithm.
                *rate = -2.0 * (slopes[0] * x * y + slopes[1] * x * x + slopes[2] * y * y);
            }
        }
    }

    fn variance(&self, parameters: &[f64], at: &[f64]) -> f64 {
        let squared: f64 = at.iter().zip(parameters).map(|(x, scale)| (x / scale).powi(2)).sum();
        F::at([squared; 3]).value
    }
}
