//! The covariance of a kernel expression, `k = Σ_t σ_t² Π_f k_f`, and its derivatives.

use super::covariance::TrainingPoints;
use super::expression::KernelExpression;
use super::kernels::{Component, FACTORS, Hyperparameter, PairRow, STATIONARY};
use crate::base::Rows;
use crate::learn::LearnError;

/// An expression on samples of a known width. Its hyper-parameters are the logarithms of the signal
/// variance of each product, then of those of each factor.
pub(super) struct Composite {
    leaves: Vec<Leaf>,
    products: Vec<Vec<usize>>,
}

struct Leaf {
    component: &'static dyn Component,
    /// The inputs that it sees, from 0.
    inputs: Vec<usize>,
    /// Where its hyper-parameters begin, and how many they are.
    from: usize,
    count: usize,
}

/// The training points of one row of a Gram matrix.
#[derive(Clone, Copy)]
pub(super) struct PointRun<'a> {
    pub(super) points: &'a TrainingPoints,
    /// Number of the first one.
    pub(super) from: usize,
    /// Place in the run of the point whose row it is; `None` for a new point.
    pub(super) self_index: Option<usize>,
}

/// Values and derivatives of the factors for one row of the Gram matrix.
pub(super) struct RowRates {
    values: Vec<Vec<f64>>,
    rates: Vec<Vec<Vec<f64>>>,
}

impl Composite {
    /// The covariance of `expression` on samples of `inputs` inputs.
    pub(super) fn new(
        expression: &KernelExpression,
        inputs: usize,
    ) -> Result<Composite, LearnError> {
        // The signal variances of the products come first.
        let mut from = expression.products.len();
        let mut leaves = Vec::new();
        for factor in &expression.factors {
            let unknown = || LearnError::Setting {
                key: "kernel",
                found: factor.kernel.to_owned(),
                expected: "registered kernels",
            };
            let mut registered = STATIONARY.iter().chain(FACTORS).copied();
            let component = registered
                .find(|component| component.name() == factor.kernel)
                .ok_or_else(unknown)?;
            let inputs = factor.inputs.of(inputs)?;
            let count = component.hyperparameters(inputs.len()).len();
            leaves.push(Leaf { component, inputs, from, count });
            from += count;
        }
        Ok(Composite { leaves, products: expression.products.clone() })
    }

    /// Number of hyper-parameters without the noise.
    pub(super) fn len(&self) -> usize {
        self.products.len() + self.leaves.iter().map(|leaf| leaf.count).sum::<usize>()
    }

    /// The hyper-parameters without the noise, with names of their own.
    pub(super) fn hyperparameters(&self) -> Vec<Hyperparameter> {
        let signal = |product: &Vec<usize>| {
            let names: Vec<&str> =
                product.iter().map(|&leaf| self.leaves[leaf].component.name()).collect();
            Hyperparameter::signal_variance(format!("signal variance of {}", names.join(" * ")))
        };
        let of_leaves = self.leaves.iter().flat_map(|leaf| {
            let of_leaf = move |parameter: Hyperparameter| Hyperparameter {
                name: format!("{} of {}", parameter.name, leaf.component.name()),
                ..parameter
            };
            leaf.component.hyperparameters(leaf.inputs.len()).into_iter().map(of_leaf)
        });
        self.products.iter().map(signal).chain(of_leaves).collect()
    }

    fn parameters<'a>(&self, leaf: &Leaf, natural: &'a [f64]) -> &'a [f64] {
        &natural[leaf.from..leaf.from + leaf.count]
    }

    /// Writes the covariances of the point `at` with a run of training points. `natural` are the
    /// hyper-parameters, not their logarithms.
    pub(super) fn row(&self, natural: &[f64], run: PointRun, at: &[f64], out: &mut [f64]) {
        let PointRun { points, from, self_index } = run;
        let values: Vec<Vec<f64>> = self
            .leaves
            .iter()
            .map(|leaf| {
                let row = PairRow { points, inputs: &leaf.inputs, from, at, self_index };
                let mut values = vec![0.0; out.len()];
                leaf.component.values(self.parameters(leaf, natural), &row, &mut values);
                values
            })
            .collect();
        out.fill(0.0);
        let mut product = vec![0.0; out.len()];
        for (factors, signal) in self.products.iter().zip(natural) {
            product.fill(*signal);
            for &leaf in factors {
                product
                    .iter_mut()
                    .zip(&values[leaf])
                    .for_each(|(product, value)| *product *= value);
            }
            out.iter_mut().zip(&product).for_each(|(out, product)| *out += product);
        }
    }

    /// Covariance of a new point with itself.
    pub(super) fn variance(&self, natural: &[f64], at: &[f64]) -> f64 {
        let of_leaf = |leaf: &Leaf| {
            let inputs: Vec<f64> = leaf.inputs.iter().map(|&d| at[d]).collect();
            leaf.component.variance(self.parameters(leaf, natural), &inputs)
        };
        let values: Vec<f64> = self.leaves.iter().map(of_leaf).collect();
        let product = |(factors, signal): (&Vec<usize>, &f64)| {
            factors.iter().fold(*signal, |product, &leaf| product * values[leaf])
        };
        self.products.iter().zip(natural).map(product).sum()
    }

    /// Values and derivatives of the factors, for [`Composite::rate`].
    pub(super) fn row_rates(&self, natural: &[f64], run: PointRun, at: &[f64]) -> RowRates {
        let PointRun { points, from, self_index } = run;
        let count = points.n - from;
        let mut all = RowRates { values: Vec::new(), rates: Vec::new() };
        for leaf in &self.leaves {
            let row = PairRow { points, inputs: &leaf.inputs, from, at, self_index };
            let (mut values, mut rates) = (vec![0.0; count], vec![vec![0.0; count]; leaf.count]);
            let parameters = self.parameters(leaf, natural);
            leaf.component.values(parameters, &row, &mut values);
            leaf.component.rates(parameters, &row, &mut rates);
            all.values.push(values);
            all.rates.push(rates);
        }
        all
    }

    /// Writes the derivative of a row of the Gram matrix with respect to the logarithm of
    /// hyper-parameter `k`.
    pub(super) fn rate(&self, natural: &[f64], row: &RowRates, k: usize, out: &mut [f64]) {
        out.fill(0.0);
        let mut product = vec![0.0; out.len()];
        for (t, factors) in self.products.iter().enumerate() {
            // A factor may stand in several products, each of which then changes.
            let varied = factors.iter().find(|&&leaf| {
                let leaf = &self.leaves[leaf];
                (leaf.from..leaf.from + leaf.count).contains(&k)
            });
            if t != k && varied.is_none() {
                continue;
            }
            product.fill(natural[t]);
            for &leaf in factors {
                // Product rule: the factor that depends on k is replaced by its derivative.
                let values = match varied {
                    Some(&varied) if varied == leaf => &row.rates[leaf][k - self.leaves[leaf].from],
                    _ => &row.values[leaf],
                };
                product.iter_mut().zip(values).for_each(|(product, value)| *product *= value);
            }
            out.iter_mut().zip(&product).for_each(|(out, product)| *out += product);
        }
    }
}

impl KernelExpression {
    /// Names of the hyper-parameters on samples of `inputs` inputs, without the noise: the signal
    /// variance of each product, then those of each factor.
    ///
    /// # Errors
    /// [`LearnError::Setting`] for inputs that the samples do not have.
    pub fn hyperparameter_names(&self, inputs: usize) -> Result<Vec<String>, LearnError> {
        Ok(Composite::new(self, inputs)?
            .hyperparameters()
            .into_iter()
            .map(|parameter| parameter.name)
            .collect())
    }

    /// The Gram matrix of `samples` (N × N, without the noise of the process) under `parameters`,
    /// in the order of [`KernelExpression::hyperparameter_names`]. Inputs count as they are, not
    /// standardised.
    ///
    /// # Errors
    /// [`LearnError`] for inputs that the samples do not have or another number of parameters.
    pub fn gram(&self, samples: &Rows, parameters: &[f64]) -> Result<Rows, LearnError> {
        let composite = Composite::new(self, samples.width())?;
        LearnError::unless_shape(
            "hyper-parameters of a kernel",
            parameters.len(),
            composite.len(),
        )?;
        let points = TrainingPoints::of(samples);
        let mut out = Rows::new(points.n);
        let mut row = vec![0.0; points.n];
        for j in 0..points.n {
            let run = PointRun { points: &points, from: 0, self_index: Some(j) };
            composite.row(parameters, run, samples.row(j), &mut row);
            out.push(&row);
        }
        Ok(out)
    }
}
