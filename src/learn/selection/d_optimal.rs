//! Sequential D-optimal design for a full quadratic: each point is the one that raises the
//! determinant of the information matrix most (Wynn 1970; Atkinson, Donev & Tobias 2007, ch. 12),
//! which is where the fit so far is least certain.

use super::largest;
use crate::base::{Rows, Seed};

/// Information on every coefficient before the first point, so that the matrix has an inverse.
const RIDGE: f64 = 1e-6;

pub(super) fn choose(inputs: &Rows, count: usize, _seed: Seed) -> Vec<usize> {
    let features: Vec<Vec<f64>> = inputs.iter().map(quadratic).collect();
    let size = features[0].len();
    // The inverse of the information matrix, updated by Sherman & Morrison's formula.
    let mut inverse: Vec<Vec<f64>> = (0..size)
        .map(|a| (0..size).map(|b| if a == b { 1.0 / RIDGE } else { 0.0 }).collect())
        .collect();
    let mut chosen: Vec<usize> = Vec::with_capacity(count);
    while chosen.len() < count {
        let gains: Vec<f64> =
            features
                .iter()
                .enumerate()
                .map(|(i, row)| {
                    if chosen.contains(&i) {
                        -1.0
                    } else {
                        dot(row, &times(&inverse, row)).max(0.0)
                    }
                })
                .collect();
        // det(M + x xᵀ) = det(M) (1 + xᵀ M⁻¹ x): the largest variance gains most.
        let next = largest(&gains);
        let along = times(&inverse, &features[next]);
        let share = 1.0 / (1.0 + gains[next]);
        for (row, a) in inverse.iter_mut().zip(&along) {
            row.iter_mut().zip(&along).for_each(|(entry, b)| *entry -= share * a * b);
        }
        chosen.push(next);
    }
    chosen
}

/// 1, every input and every product of two.
fn quadratic(row: &[f64]) -> Vec<f64> {
    let products = (0..row.len()).flat_map(|a| (a..row.len()).map(move |b| row[a] * row[b]));
    std::iter::once(1.0).chain(row.iter().copied()).chain(products).collect()
}

fn times(matrix: &[Vec<f64>], vector: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| dot(row, vector)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
