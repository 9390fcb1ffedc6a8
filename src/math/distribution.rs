//! Tails and quantiles of the usual distributions.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// Probability that a χ² variable of `freedom` degrees is above `value`; 1 where there is none.
pub fn chi_squared_above(value: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |law| law.sf(value.max(0.0)))
}

/// Probability that an F variable of (`above`, `below`) degrees of freedom is above `value`; 1
/// where there is none.
pub fn f_above(value: f64, above: f64, below: f64) -> f64 {
    FisherSnedecor::new(above, below).map_or(1.0, |law| law.sf(value.max(0.0)))
}

/// Probability that a standard normal variable is above `value`.
pub fn normal_above(value: f64) -> f64 {
    Normal::standard().sf(value)
}

/// The value below which a standard normal variable is with this probability; not a number outside
/// 0 to 1.
pub fn normal_quantile(probability: f64) -> f64 {
    if (0.0..=1.0).contains(&probability) {
        Normal::standard().inverse_cdf(probability)
    } else {
        f64::NAN
    }
}

/// Half-width of a 95 % interval in standard deviations, Student's t with `freedom` degrees of
/// freedom.
pub fn student_95(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |law| law.inverse_cdf(0.975))
}

/// Probability that a Student's t variable with `freedom` degrees of freedom is farther from 0 than
/// `value`; 1 where there is none.
pub fn student_beyond(value: f64, freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(1.0, |law| 2.0 * law.sf(value.abs()))
}

/// Wilson's 95 % interval of a proportion, `hits` of `all` (Wilson, J. Am. Stat. Assoc. 22, 1927).
pub fn wilson_95(hits: u64, all: u64) -> [f64; 2] {
    if all == 0 {
        return [0.0, 1.0];
    }
    let (n, z) = (all as f64, 1.959_963_984_540_054_f64);
    let share = hits as f64 / n;
    let middle = share + z * z / (2.0 * n);
    let half = z * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z * z / n;
    [((middle - half) / scale).max(0.0), ((middle + half) / scale).min(1.0)]
}

/// p-values corrected for multiple tests, controlling the family-wise error rate (Holm, Scand. J.
/// Stat. 6, 1979).
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut corrected = vec![1.0; p_values.len()];
    let mut largest = 0.0_f64;
    for (rank, &index) in order.iter().enumerate() {
        // Step-down: a value is never below those of smaller p-values.
        largest = largest.max(p_values[index] * (p_values.len() - rank) as f64).min(1.0);
        corrected[index] = largest;
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_values_come_back() {
        assert!((chi_squared_above(3.841, 1.0) - 0.05).abs() < 1e-4);
        assert!((f_above(2.348, 10.0, 20.0) - 0.05).abs() < 1e-3);
        assert!((normal_above(1.96) - 0.025).abs() < 1e-4);
        assert!((normal_quantile(0.975) - 1.959_964).abs() < 1e-6 && normal_quantile(1.5).is_nan());
        assert!((student_95(10.0) - 2.228).abs() < 1e-3);
        assert!((student_beyond(-2.228, 10.0) - 0.05).abs() < 1e-4);
    }

    #[test]
    fn wilsons_interval_is_the_published_one() {
        let [low, high] = wilson_95(8, 10);
        assert!((low - 0.490).abs() < 1e-3 && (high - 0.943).abs() < 1e-3, "{low} {high}");
        assert_eq!(wilson_95(0, 0), [0.0, 1.0]);
    }

    #[test]
    fn holm_keeps_the_order_and_never_lowers() {
        assert_eq!(holm(&[0.01, 0.04, 0.03]), [0.03, 0.06, 0.06]);
        assert_eq!(holm(&[0.9, 0.8]), [1.0, 1.0]);
    }
}
