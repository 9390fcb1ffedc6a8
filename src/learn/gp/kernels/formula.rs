//! The interface of a kernel file, and what follows from it for every kernel.

use crate::math::vectorised;

/// Whether each input has a length-scale of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lengths {
    /// One length-scale per input (automatic relevance determination).
    PerInput,
    /// One length-scale for all inputs.
    Shared,
}

/// A positive parameter that a kernel has besides signal variance and length-scales.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeParameter {
    /// Standard symbol or name.
    pub name: &'static str,
    /// Where the search starts.
    pub start: f64,
    /// Range of the search.
    pub bounds: (f64, f64),
}

/// Correlation `c(s)` and its derivative `dc/ds` at one scaled squared distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At {
    /// `c(s)`, 1 at s = 0.
    pub correlation: f64,
    /// `dc/ds`, finite at s = 0.
    pub slope: f64,
}

/// A kernel's formula: the whole content of its file.
///
/// ```
/// use spinebench::learn::gp::kernels::{At, Formula, Kernel, Lengths, ShapeParameter};
/// struct Cauchy;
/// impl Formula for Cauchy {
///     const NAME: &'static str = "cauchy";
///     const LENGTHS: Lengths = Lengths::Shared;
///     #[inline(always)]
///     fn at(s: f64, _shape: &[f64]) -> At {
///         let correlation = 1.0 / (1.0 + s);
///         At { correlation, slope: -correlation * correlation }
///     }
/// }
/// let mut s = [1.0];
/// Cauchy.correlations(&[], &mut s);
/// assert_eq!(s, [0.5]);
/// ```
pub trait Formula: Send + Sync {
    /// Name in specs and tables.
    const NAME: &'static str;
    /// Length-scales per input or shared.
    const LENGTHS: Lengths;
    /// Further parameters.
    const SHAPES: &'static [ShapeParameter] = &[];

    /// Correlation and slope at the scaled squared distance `s`. Mark it `#[inline(always)]`.
    fn at(s: f64, shape: &[f64]) -> At;

    /// `dc / d ln(shape[index])` at `s`.
    fn shape_slope(_s: f64, _shape: &[f64], _index: usize) -> f64 {
        0.0
    }
}

/// A covariance function as the Gaussian process sees it: whole rows at a time, implemented for
/// every [`Formula`].
pub trait Kernel: Send + Sync {
    /// Name in specs and tables.
    fn name(&self) -> &'static str;
    /// Length-scales per input or shared.
    fn lengths(&self) -> Lengths;
    /// Parameters besides signal variance and length-scales.
    fn shapes(&self) -> &'static [ShapeParameter];
    /// Replaces scaled squared distances by correlations.
    fn correlations(&self, shape: &[f64], s: &mut [f64]);
    /// Replaces scaled squared distances by correlations and writes `dc/ds` beside them.
    fn slopes(&self, shape: &[f64], s: &mut [f64], slopes: &mut [f64]);
    /// Replaces scaled squared distances by `dc / d ln(shape[index])`.
    fn shape_slopes(&self, shape: &[f64], index: usize, s: &mut [f64]);
}

impl<F: Formula> Kernel for F {
    fn name(&self) -> &'static str {
        F::NAME
    }

    fn lengths(&self) -> Lengths {
        F::LENGTHS
    }

    fn shapes(&self) -> &'static [ShapeParameter] {
        F::SHAPES
    }

    fn correlations(&self, shape: &[f64], s: &mut [f64]) {
        vectorised!(s.iter_mut().for_each(|s| *s = F::at(*s, shape).correlation));
    }

    fn slopes(&self, shape: &[f64], s: &mut [f64], slopes: &mut [f64]) {
        vectorised!({
            for (s, slope) in s.iter_mut().zip(slopes) {
                let at = F::at(*s, shape);
                *s = at.correlation;
                *slope = at.slope;
            }
        });
    }

    fn shape_slopes(&self, shape: &[f64], index: usize, s: &mut [f64]) {
        s.iter_mut().for_each(|s| *s = F::shape_slope(*s, shape, index));
    }
}
