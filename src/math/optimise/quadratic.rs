//! Box-constrained convex quadratic programs of few unknowns.

/// The `d` within `room` that minimises `gᵀd + ½ dᵀBd`, for symmetric `b` (row-major); `None` when
/// B is not positive definite. Active-set method (Nocedal & Wright, section 16.5): unknowns that
/// would leave the box are fixed at its bound; those with a negative multiplier are released.
pub(crate) fn minimise_quadratic(b: &[f64], g: &[f64], room: &[(f64, f64)]) -> Option<Vec<f64>> {
    let n = g.len();
    let mut fixed: Vec<Option<f64>> = vec![None; n];
    let mut d = vec![0.0; n];
    // A limit on changes of the active set: rounding could make it cycle.
    for _ in 0..4 * n + 4 {
        // The minimum of the free unknowns, with the others at their bounds.
        let free: Vec<usize> = (0..n).filter(|&i| fixed[i].is_none()).collect();
        let reduced_gradient = |i: usize| {
            g[i] + (0..n).filter_map(|j| fixed[j].map(|w| b[i * n + j] * w)).sum::<f64>()
        };
        let matrix: Vec<f64> =
            free.iter().flat_map(|&i| free.iter().map(move |&j| b[i * n + j])).collect();
        let rhs: Vec<f64> = free.iter().map(|&i| -reduced_gradient(i)).collect();
        let solved = solve_spd(&matrix, &rhs)?;
        free.iter().zip(&solved).for_each(|(&i, s)| d[i] = s.clamp(room[i].0, room[i].1));
        let outside = |(&i, s): (&usize, &f64)| (*s < room[i].0 || *s > room[i].1).then_some(i);
        let leaving: Vec<usize> = free.iter().zip(&solved).filter_map(outside).collect();
        if !leaving.is_empty() {
            leaving.into_iter().for_each(|i| fixed[i] = Some(d[i]));
            continue;
        }
        // A fixed unknown is released where the model falls towards the inside of the box.
        let model_gradient = |i: usize| g[i] + (0..n).map(|j| b[i * n + j] * d[j]).sum::<f64>();
        let descent = |i: &usize| match fixed[*i] {
            Some(w) if w <= room[*i].0 => -model_gradient(*i),
            Some(_) => model_gradient(*i),
            None => 0.0,
        };
        let released =
            (0..n).filter(|i| descent(i) > 1e-12).max_by(|a, b| descent(a).total_cmp(&descent(b)));
        match released {
            Some(i) => fixed[i] = None,
            None => break,
        }
    }
    Some(d)
}

/// Solves `A x = b` for symmetric `a` (row-major, n×n); `None` when `a` is not positive definite.
fn solve_spd(a: &[f64], b: &[f64]) -> Option<Vec<f64>> {
    let n = b.len();
    // Cholesky, then forward and backward substitution.
    let mut l = a.to_vec();
    for j in 0..n {
        for i in j..n {
            let dot: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            let value = a[i * n + j] - dot;
            if i == j {
                if value.is_nan() || value <= 0.0 {
                    return None;
                }
                l[j * n + j] = value.sqrt();
            } else {
                l[i * n + j] = value / l[j * n + j];
            }
        }
    }
    let mut x = b.to_vec();
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
        x[i] = (x[i] - dot) / l[i * n + i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
        x[i] = (x[i] - dot) / l[i * n + i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_hold_and_let_go() {
        let b = [2.0, 1.0, 1.0, 2.0];
        let free = minimise_quadratic(&b, &[-3.0, -3.0], &[(-9.0, 9.0); 2]).unwrap();
        assert!((free[0] - 1.0).abs() < 1e-14 && (free[1] - 1.0).abs() < 1e-14);
        let held = minimise_quadratic(&b, &[-3.0, -3.0], &[(-9.0, 0.5), (-9.0, 9.0)]).unwrap();
        assert!((held[0] - 0.5).abs() < 1e-14 && (held[1] - 1.25).abs() < 1e-14);
        // Both leave the box at first; the second must come back.
        let b = [1.0, -0.9, -0.9, 1.0];
        let d = minimise_quadratic(&b, &[-1.0, -0.5], &[(-1.0, 0.1), (-1.0, 2.0)]).unwrap();
        assert!((d[0] - 0.1).abs() < 1e-14 && (d[1] - 0.59).abs() < 1e-14, "{d:?}");
    }

    #[test]
    fn solves_and_refuses() {
        let x = solve_spd(&[4.0, 1.0, 1.0, 3.0], &[1.0, 2.0]).unwrap();
        assert!((x[0] - 1.0 / 11.0).abs() < 1e-15 && (x[1] - 7.0 / 11.0).abs() < 1e-15);
        assert!(solve_spd(&[1.0, 2.0, 2.0, 1.0], &[1.0, 1.0]).is_none());
    }
}
