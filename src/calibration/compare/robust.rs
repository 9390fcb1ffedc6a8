//! Weights of sightings. Student's t with four degrees of freedom in three coordinates bounds the
//! influence of outliers and has 95 % efficiency for normal noise; it is fitted by iterated
//! reweighting, which is the EM algorithm (Lange, Little & Taylor 1989, J. Am. Stat. Assoc. 84,
//! 881).

use nalgebra::DVector;

use super::comparison::Positions;
use crate::math::summary::quantile;

/// Degrees of freedom of Student's t, as Lange et al. recommend where there is too little to
/// estimate them.
const FREEDOM: f64 = 4.0;
/// Distances beyond this many robust standard deviations of a coordinate are outliers: less than
/// one in a million for normal noise in three coordinates.
const OUTLIER: f64 = 6.0;
/// Median of the distance of three-dimensional normal noise, in standard deviations of a
/// coordinate.
const MEDIAN_DISTANCE: f64 = 1.538_172;

/// Distribution of the errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorLaw {
    /// Normal: least squares.
    Normal,
    /// Student's t with four degrees of freedom.
    StudentT,
}

/// Weight of each sighting and variance of one coordinate, m².
pub(crate) fn weights(
    likelihood: ErrorLaw,
    residual_m: &DVector<f64>,
    positions: &Positions,
    fitted: usize,
) -> (Vec<f64>, f64) {
    let solved = positions.iter().filter(|at| at.is_some()).count();
    let freedom = (3.0 * solved as f64 - fitted as f64).max(1.0);
    let ones: Vec<f64> = positions.iter().map(|at| f64::from(u8::from(at.is_some()))).collect();
    let variance_m2 = residual_m.norm_squared() / freedom;
    if likelihood == ErrorLaw::Normal || variance_m2 == 0.0 {
        return (ones, variance_m2);
    }
    let squares: Vec<f64> =
        (0..positions.len()).map(|index| residual_m.rows(3 * index, 3).norm_squared()).collect();
    // Start from the median: outliers would blow up the first variance and hide among the rest.
    let mut variance_m2 = robust_deviation_m(residual_m, positions).powi(2).max(1e-6 * variance_m2);
    let mut weights = ones.clone();
    for _ in 0..50 {
        // E step: w = (ν + 3) / (ν + d²/σ²); M step below.
        let weight =
            |(one, square): (&f64, &f64)| one * (FREEDOM + 3.0) / (FREEDOM + square / variance_m2);
        weights = ones.iter().zip(&squares).map(weight).collect();
        variance_m2 =
            weights.iter().zip(&squares).map(|(weight, square)| weight * square).sum::<f64>()
                / freedom;
    }
    (weights, variance_m2)
}

/// Standard deviation of a coordinate from the median distance, metres.
pub(crate) fn robust_deviation_m(residual_m: &DVector<f64>, positions: &Positions) -> f64 {
    quantile(&distances_m(residual_m, positions), 0.5) / MEDIAN_DISTANCE
}

/// Sightings too far from the model to belong to the same noise.
pub(crate) fn outliers(residual_m: &DVector<f64>, positions: &Positions) -> Vec<usize> {
    let limit_m = OUTLIER * robust_deviation_m(residual_m, positions);
    let far = |index: &usize| residual_m.rows(3 * index, 3).norm() > limit_m;
    (0..positions.len()).filter(far).collect()
}

fn distances_m(residual_m: &DVector<f64>, positions: &Positions) -> Vec<f64> {
    let solved = (0..positions.len()).filter(|&index| positions[index].is_some());
    solved.map(|index| residual_m.rows(3 * index, 3).norm()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outlier_is_found_and_hardly_counts() {
        let mut residual = DVector::from_fn(300, |k, _| 1e-3 * (12.9898 * k as f64).sin());
        residual[30] = 0.04;
        let positions: Positions = vec![Some([0.0; 3]); 100];
        assert_eq!(outliers(&residual, &positions), [10]);
        let (weights, variance) = weights(ErrorLaw::StudentT, &residual, &positions, 2);
        assert!(weights[10] < 0.01 && weights[11] > 0.7, "{weights:?}");
        assert!((0.3e-3..1.2e-3).contains(&variance.sqrt()), "{variance}");
    }
}
