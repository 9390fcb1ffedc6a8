//! The interface of what a kernel expression is made of: a covariance of one factor, whole rows at
//! a time.

use super::{Kernel, Lengths};
use crate::learn::gp::covariance::TrainingPoints;

/// A positive hyper-parameter of a covariance, searched by its logarithm. Ranges are in
/// standardised units.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperparameter {
    /// Standard symbol or name.
    pub name: String,
    /// Where the search starts.
    pub start: f64,
    /// Range of the search.
    pub bounds: (f64, f64),
    /// Range of further starts.
    pub plausible: (f64, f64),
    /// Whether it is a length-scale of a stationary kernel, which may grow without bound.
    pub is_length: bool,
}

impl Hyperparameter {
    /// One that is no length-scale.
    pub(super) fn plain(
        name: impl Into<String>,
        start: f64,
        bounds: (f64, f64),
        plausible: (f64, f64),
    ) -> Hyperparameter {
        Hyperparameter { name: name.into(), start, bounds, plausible, is_length: false }
    }

    /// A signal variance.
    pub(crate) fn signal_variance(name: String) -> Hyperparameter {
        Hyperparameter::plain(name, 1.0, (1e-3, 1e3), (0.3, 10.0))
    }

    /// A length-scale.
    pub(crate) fn length(name: String) -> Hyperparameter {
        Hyperparameter {
            name,
            start: 1.0,
            bounds: (1e-2, 1e3),
            plausible: (0.3, 30.0),
            is_length: true,
        }
    }

    /// The noise variance.
    pub(crate) fn noise_variance(noise_floor: f64) -> Hyperparameter {
        Hyperparameter::plain("noise variance", 0.1, (noise_floor * noise_floor, 10.0), (1e-4, 0.3))
    }

    /// A scale of an input, from which a dot product counts: not stationary, so searched as it is.
    pub(super) fn scale(input: usize) -> Hyperparameter {
        Hyperparameter {
            is_length: false,
            bounds: (1e-1, 1e3),
            ..Hyperparameter::length(format!("scale {}", input + 1))
        }
    }
}

/// One point and a run of training points, of which a factor sees some of the inputs.
pub struct PairRow<'a> {
    pub(crate) points: &'a TrainingPoints,
    /// The inputs that the factor sees, from 0.
    pub(crate) inputs: &'a [usize],
    /// Number of the first of the training points.
    pub(crate) from: usize,
    /// The point, all inputs.
    pub(crate) at: &'a [f64],
    /// Place in the run of the training point that the point itself is.
    pub(crate) self_index: Option<usize>,
}

impl PairRow<'_> {
    /// For each input that the factor sees: its values at the training points, and at the point.
    pub(super) fn each(&self) -> impl Iterator<Item = (&[f64], f64)> {
        self.inputs.iter().map(|&d| (&self.points.input(d)[self.from..], self.at[d]))
    }
}

/// A factor of a covariance function.
pub trait Component: Send + Sync {
    /// Name in expressions.
    fn name(&self) -> &'static str;
    /// Hyper-parameters on so many inputs; none unless stated.
    fn hyperparameters(&self, _inputs: usize) -> Vec<Hyperparameter> {
        Vec::new()
    }
    /// Writes the covariances of the point with the run of training points.
    fn values(&self, parameters: &[f64], row: &PairRow, out: &mut [f64]);
    /// Writes the derivative of each of them with respect to the logarithm of each hyper-parameter,
    /// one row a hyper-parameter.
    fn rates(&self, _parameters: &[f64], _row: &PairRow, _out: &mut [Vec<f64>]) {}
    /// Covariance of a new point with itself, 1 unless stated; `at` holds the inputs that the
    /// factor sees.
    fn variance(&self, _parameters: &[f64], _at: &[f64]) -> f64 {
        1.0
    }
}

/// A registered stationary kernel as a factor.
pub(crate) struct Stationary(pub(crate) &'static dyn Kernel);

impl Stationary {
    fn squared_distances(lengths: &[f64], row: &PairRow, s: &mut [f64]) {
        s.fill(0.0);
        for (k, (values, centre)) in row.each().enumerate() {
            let length = lengths[k.min(lengths.len() - 1)];
            s.iter_mut().zip(values).for_each(|(s, x)| *s += ((x - centre) / length).powi(2));
        }
    }

    fn split<'a>(&self, parameters: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        parameters.split_at(parameters.len() - self.0.shapes().len())
    }
}

impl Component for Stationary {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn hyperparameters(&self, inputs: usize) -> Vec<Hyperparameter> {
        let lengths = match self.0.lengths() {
            Lengths::PerInput => {
                (1..=inputs).map(|d| Hyperparameter::length(format!("length {d}"))).collect()
            }
            Lengths::Shared => vec![Hyperparameter::length("length".to_owned())],
        };
        let shape = |shape: &super::ShapeParameter| {
            Hyperparameter::plain(
                shape.name,
                shape.start,
                shape.bounds,
                (shape.start / 4.0, shape.start * 4.0),
            )
        };
        lengths.into_iter().chain(self.0.shapes().iter().map(shape)).collect()
    }

    fn values(&self, parameters: &[f64], row: &PairRow, out: &mut [f64]) {
        let (lengths, shapes) = self.split(parameters);
        Self::squared_distances(lengths, row, out);
        self.0.correlations(shapes, out);
    }

    fn rates(&self, parameters: &[f64], row: &PairRow, out: &mut [Vec<f64>]) {
        let (lengths, shapes) = self.split(parameters);
        let count = out.first().map_or(0, Vec::len);
        let mut s = vec![0.0; count];
        Self::squared_distances(lengths, row, &mut s);
        let (of_lengths, of_shapes) = out.split_at_mut(lengths.len());
        for (index, rates) in of_shapes.iter_mut().enumerate() {
            rates.copy_from_slice(&s);
            self.0.shape_slopes(shapes, index, rates);
        }
        let mut slopes = vec![0.0; count];
        self.0.slopes(shapes, &mut s, &mut slopes);
        of_lengths.iter_mut().for_each(|rates| rates.fill(0.0));
        for (k, (values, centre)) in row.each().enumerate() {
            let k = k.min(lengths.len() - 1);
            for ((rate, x), slope) in of_lengths[k].iter_mut().zip(values).zip(&slopes) {
                *rate -= 2.0 * slope * ((x - centre) / lengths[k]).powi(2);
            }
        }
    }
}
