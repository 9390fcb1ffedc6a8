//! Which samples are the inducing points.

use super::rates::CovarianceAt;
use crate::learn::gp::covariance::{Covariance, TrainingPoints};
use crate::math::vectorised;

/// Share of the largest variance below which a sample tells nothing that the chosen ones do not.
const MIN_VARIANCE_SHARE: f64 = 1e-10;

/// Numbers of at most `count` points: each the one whose value those chosen before leave least
/// certain under the covariance with these hyper-parameters (Burt, Rasmussen & van der Wilk 2020,
/// section 4.2.2). It is a Cholesky decomposition with pivoting, which ends early when every point
/// is known: a linear kernel has no more than its rank.
pub(crate) fn greedy_conditional_variance(
    covariance: &Covariance,
    theta: &[f64],
    points: &TrainingPoints,
    count: usize,
) -> Vec<usize> {
    let n = points.n;
    let at = CovarianceAt::new(covariance, theta);
    let prepared = at.prepare(points);
    let mut remaining = vec![0.0; n];
    at.diagonal(points, &mut remaining, &mut vec![0.0; n]);
    let min_variance =
        MIN_VARIANCE_SHARE * remaining.iter().fold(0.0_f64, |max, variance| max.max(*variance));
    let mut factor: Vec<f64> = Vec::with_capacity(n * count.min(n));
    let mut chosen = Vec::with_capacity(count.min(n));
    while chosen.len() < count.min(n) {
        // The point that the chosen ones explain least is the next pivot.
        let next = (1..n).fold(0, |best, i| if remaining[i] > remaining[best] { i } else { best });
        if remaining[next] <= min_variance {
            break;
        }
        let mut column = vec![0.0; n];
        at.row(&prepared, 0, &prepared.point(next), &mut column);
        subtract_explained(&factor, next, &mut column);
        // A column of the pivoted Cholesky factor; its squares are what the point explains of
        // others.
        let root = remaining[next].sqrt();
        column.iter_mut().zip(&mut remaining).for_each(|(value, remaining)| {
            *value /= root;
            *remaining -= *value * *value;
        });
        // Rounding would leave a trace here, and the point could be chosen twice.
        remaining[next] = 0.0;
        factor.extend_from_slice(&column);
        chosen.push(next);
    }
    chosen
}

/// Subtracts from `column` the columns of `factor`, each times its value in row `pivot`; four at
/// once, because the column is read and written for each.
fn subtract_explained(factor: &[f64], pivot: usize, column: &mut [f64]) {
    let n = column.len();
    let (fours, tail) = factor.split_at(factor.len() / (4 * n) * (4 * n));
    vectorised!({
        for four in fours.chunks_exact(4 * n) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| &four[k * n..(k + 1) * n]);
            let [wa, wb, wc, wd] = [a[pivot], b[pivot], c[pivot], d[pivot]];
            for ((((value, a), b), c), d) in column.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *value -= wa * a + wb * b + wc * c + wd * d;
            }
        }
        for single in tail.chunks_exact(n) {
            let weight = single[pivot];
            column.iter_mut().zip(single).for_each(|(value, entry)| *value -= weight * entry);
        }
    });
}
