//! The moves of a receding horizon: min Σ_k |b_k − b*|²_M + w|Δ_k|² over the moves Δ_k of the
//! coming ticks, each component of a move within ±`step_m`, where M = JᵀJ weighs the bend by what
//! it moves of the tip. Projected gradient with Nesterov's momentum, from all moves zero; the
//! problem is convex.

use nalgebra::DMatrix;

/// Iterations: the first move of twenty ticks is found to a micrometre.
const ITERATIONS: usize = 400;

/// The first move, metres, of those that take the bend to one that is `left_m` away.
pub(crate) fn first_move_m(
    metric: &DMatrix<f64>,
    remaining_m: &[f64],
    ticks: usize,
    weight: f64,
    step_m: f64,
) -> Vec<f64> {
    let count = remaining_m.len();
    // The trace bounds the largest eigenvalue of a positive semidefinite matrix.
    let eigenvalue_bound = metric.diagonal().sum();
    // Largest curvature of the sum: that of the map from moves to bends has norm below
    // ticks(ticks + 1)/2.
    let curvature = 2.0 * (eigenvalue_bound * (ticks * (ticks + 1)) as f64 / 2.0 + weight);
    let mut moves = vec![0.0; ticks * count];
    let (mut extrapolated, mut momentum) = (moves.clone(), 1.0_f64);
    for _ in 0..ITERATIONS {
        let gradient = gradient(metric, remaining_m, &extrapolated, weight);
        // A gradient step of one over the curvature, projected onto the permitted moves.
        let next: Vec<f64> = extrapolated
            .iter()
            .zip(&gradient)
            .map(|(value, slope)| (value - slope / curvature).clamp(-step_m, step_m))
            .collect();
        // Nesterov: t' = (1 + √(1 + 4 t²)) / 2, extrapolation by (t − 1) / t'.
        let following = 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt());
        let share = (momentum - 1.0) / following;
        extrapolated =
            next.iter().zip(&moves).map(|(next, last)| next + share * (next - last)).collect();
        (moves, momentum) = (next, following);
    }
    moves.truncate(count);
    moves
}

fn gradient(metric: &DMatrix<f64>, remaining_m: &[f64], moves: &[f64], weight: f64) -> Vec<f64> {
    let count = remaining_m.len();
    let mut overshoot_m: Vec<f64> = remaining_m.iter().map(|remaining_m| -remaining_m).collect();
    // The slope of each tick's own error, and from the end on the sum of those after it.
    let mut slopes = Vec::with_capacity(moves.len());
    for step in moves.chunks_exact(count) {
        overshoot_m.iter_mut().zip(step).for_each(|(overshoot, change)| *overshoot += change);
        for row in 0..count {
            let sum: f64 =
                (0..count).map(|column| metric[(row, column)] * overshoot_m[column]).sum();
            slopes.push(2.0 * sum);
        }
    }
    for index in (0..slopes.len().saturating_sub(count)).rev() {
        slopes[index] += slopes[index + count];
    }
    slopes.iter().zip(moves).map(|(slope, change)| slope + 2.0 * weight * change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_weight_the_target_is_reached_at_once_or_at_full_speed() {
        let metric = DMatrix::from_row_slice(2, 2, &[16.0, 1.0, 1.0, 9.0]);
        let near = first_move_m(&metric, &[0.001, -0.001], 5, 0.0, 0.003);
        assert!((near[0] - 0.001).abs() < 1e-6 && (near[1] + 0.001).abs() < 1e-6, "{near:?}");
        let far = first_move_m(&metric, &[0.02, -0.02], 5, 0.0, 0.003);
        assert!((far[0] - 0.003).abs() < 1e-9 && (far[1] + 0.003).abs() < 1e-9, "{far:?}");
    }

    #[test]
    fn a_single_tick_with_weight_has_the_solution_of_the_normal_equations() {
        let metric = DMatrix::from_row_slice(1, 1, &[4.0]);
        let step = first_move_m(&metric, &[0.001], 1, 4.0, 0.003);
        assert!((step[0] - 0.0005).abs() < 1e-9, "{step:?}");
    }
}
