//! Sums of a least-squares fit of a tip.

use nalgebra::{DMatrix, DVector};

/// Sums of a least-squares fit: products of all pairs of a constant, the features and the three
/// coordinates of the tip.
#[derive(Clone)]
pub(super) struct FitSums {
    pub(super) width: usize,
    /// The lower triangle, row by row.
    products: Vec<f64>,
}

/// Coordinates of a tip.
pub(super) const AXES: usize = 3;

impl FitSums {
    /// For rows of `width` numbers, the tip's last.
    pub(super) fn new(width: usize) -> FitSums {
        FitSums { width, products: vec![0.0; width * (width + 1) / 2] }
    }

    pub(super) fn add(&mut self, row: &[f64]) {
        let mut products = self.products.iter_mut();
        for (k, a) in row.iter().enumerate() {
            products.by_ref().zip(&row[..=k]).for_each(|(product, b)| *product += a * b);
        }
    }

    pub(super) fn merge(&mut self, other: &FitSums) {
        self.products.iter_mut().zip(&other.products).for_each(|(sum, other)| *sum += other);
    }

    /// Share of the squares about the mean that the fit leaves.
    pub(super) fn unexplained(&self) -> f64 {
        let at = |row: usize, column: usize| self.products[row * (row + 1) / 2 + column];
        let features = self.width - AXES;
        let gram = DMatrix::from_fn(features, features, |row, column| {
            at(row.max(column), row.min(column))
        });
        // Tendons that pull against each other give dependent columns; a small ridge takes none of
        // the fit.
        let ridge = 1e-9 * gram.trace() / features as f64 + f64::MIN_POSITIVE;
        let Some(solver) = (gram + DMatrix::identity(features, features) * ridge).cholesky() else {
            return 1.0;
        };
        let (mut residual, mut total) = (0.0, 0.0);
        for axis in features..self.width {
            let cross = DVector::from_fn(features, |column, _| at(axis, column));
            residual += (at(axis, axis) - cross.dot(&solver.solve(&cross))).max(0.0);
            total += at(axis, axis) - at(axis, 0) * at(axis, 0) / at(0, 0);
        }
        if total > 0.0 { (residual / total).min(1.0) } else { 1.0 }
    }
}
