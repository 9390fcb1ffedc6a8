//! Spearman test: does the residual grow with the displacement by the set? Tracker noise does not.
//! An imitation is worst where it moves the tip most, even in a single trial. Rank correlation
//! (Spearman, Am. J. Psychol. 15, 1904), robust against outliers and heavy tails.

use super::test_result::{FitTest, TestResult};
use crate::discovery::fit::ar1_noise::Ar1Noise;
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::recording::samples::rms_m;
use crate::math::distribution::f_above;
use crate::math::summary::mean;

/// The test on the residual of `nuisance_fit`; `moved`: displacement by the set (three values a
/// sample, metres). The size is the excess of the third of the samples that move most over the
/// third that move least.
pub(crate) fn spearman_test(nuisance_fit: &NuisanceFit, moved: &[f64]) -> TestResult {
    let distances_m = |values: &[f64]| -> Vec<f64> { values.chunks_exact(3).map(rms_m).collect() };
    let (residual_m, moved_m) = (distances_m(&nuisance_fit.residual_m), distances_m(moved));
    let mut order: Vec<usize> = (0..residual_m.len()).collect();
    order.sort_by(|&a, &b| moved_m[a].total_cmp(&moved_m[b]));
    // The size of what grows: the squares of the outer thirds.
    let third = (order.len() / 3).max(1);
    let square_m2 = |rows: &[usize]| {
        mean(&rows.iter().map(|&row| residual_m[row].powi(2)).collect::<Vec<f64>>())
    };
    let (smallest, largest) =
        (square_m2(&order[..third]), square_m2(&order[order.len() - third..]));
    // Correlated samples count for fewer; squares are correlated by the square.
    let memory =
        Ar1Noise { correlation: nuisance_fit.noise.correlation.powi(2), ..nuisance_fit.noise };
    let freedom = memory.independent(residual_m.len()) - 2.0;
    TestResult {
        test: FitTest::Spearman,
        p_value: chance(rank_correlation(&residual_m, &moved_m), freedom),
        more_m: (largest - smallest).max(0.0).sqrt(),
        beyond_m: smallest.sqrt(),
    }
}

/// Tail probability by Student's t.
fn chance(correlation: f64, freedom: f64) -> f64 {
    // t² = r² (n − 2) / (1 − r²), whose law is F(1, n − 2).
    let square = correlation * correlation * freedom.max(1.0)
        / (1.0 - correlation * correlation).max(f64::MIN_POSITIVE);
    let beyond = 0.5 * f_above(square, 1.0, freedom.max(1.0));
    // One-sided: a residual that shrinks with the effect is no imitation.
    if correlation > 0.0 { beyond } else { 1.0 - beyond }
}

/// Rank correlation; 0 if one of both is constant.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let middle = 0.5 * (a.len() as f64 - 1.0);
    let centred = |values: &[f64]| -> Vec<f64> {
        ranks(values).into_iter().map(|rank| rank - middle).collect()
    };
    let (a, b) = (centred(a), centred(b));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale = (product(&a, &a) * product(&b, &b)).sqrt();
    if scale > 0.0 { product(&a, &b) / scale } else { 0.0 }
}

/// Ranks from 0; ties share theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for equal in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let shared = first as f64 + 0.5 * (equal.len() as f64 - 1.0);
        equal.iter().for_each(|&row| ranks[row] = shared);
        first += equal.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::discovery::recording::samples::{Samples, white_noise};

    const NOISE_M: f64 = 5e-4;

    /// Six trials of fifty samples with growing displacement, noise of this correlation, and an
    /// error of this share of the displacement with random sign.
    fn tested(correlation: f64, share: f64, seed: u64) -> TestResult {
        let samples = Samples::alike(6, 50);
        let mut residual_m = samples.noise(NOISE_M, correlation, seed);
        let mut side = white_noise(1.0, 1000 + seed);
        let moved: Vec<f64> =
            samples.rows.iter().flat_map(|row| [2e-4 * row.row as f64, 0.0, 0.0]).collect();
        residual_m
            .iter_mut()
            .zip(&moved)
            .for_each(|(left, moved)| *left += share * moved * side().signum());
        let noise = Ar1Noise { sigma_m: [NOISE_M; 3], correlation };
        spearman_test(
            &NuisanceFit { noise, amounts: DVector::zeros(0), residual_m, deviance: 0.0 },
            &moved,
        )
    }

    #[test]
    fn an_error_that_grows_is_seen_and_noise_is_not() {
        for correlation in [0.0, 0.6] {
            let even: Vec<f64> =
                (0..200).map(|seed| tested(correlation, 0.0, seed).p_value).collect();
            let low = even.iter().filter(|p| **p < 0.05).count();
            assert!((2..20).contains(&low), "{correlation}: {low} of 200 below 0.05");
        }
        let growing = tested(0.0, 0.15, 1);
        assert!(growing.p_value < 1e-6, "{}", growing.p_value);
        // The last third moves by 8.2 mm rms.
        assert!((growing.more_m / (0.15 * 8.2e-3) - 1.0).abs() < 0.2, "{}", growing.more_m);
        assert!(
            (growing.beyond_m / (3.0_f64.sqrt() * NOISE_M) - 1.0).abs() < 0.2,
            "{}",
            growing.beyond_m
        );
    }

    #[test]
    fn ranks_are_shared_and_what_never_moves_tells_nothing() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0]), [2.5, 0.0, 2.5, 1.0]);
        assert!((rank_correlation(&[1.0, 2.0, 3.0], &[1.0, 8.0, 27.0]) - 1.0).abs() < 1e-12);
        assert_eq!(rank_correlation(&[1.0, 2.0, 3.0], &[0.0; 3]), 0.0);
    }
}
