//! Cross-validated error.

use super::sparse::SparseLikelihood;
use super::{FoldOrder, Gp};

impl Gp {
    /// Cross-validated mean absolute error of each output, in its unit: folds and their order as
    /// configured, every row predicted by a process that has not seen its fold but keeps the
    /// hyper-parameters fitted to all rows (which makes it exact without a fit per fold).
    pub fn cross_validation_mae(&self) -> Vec<f64> {
        let n = self.points();
        let folds = self.folds();
        let (points, columns) = Self::prepare(&self.inputs, &self.outputs);
        let mae = |(c, posterior): (usize, &super::Posterior)| {
            let sum: f64 = if self.config.approximation.is_exact() {
                folds.iter().flat_map(|fold| posterior.held_out_errors(fold)).map(f64::abs).sum()
            } else {
                let likelihood = SparseLikelihood::of(self, c, &points, &columns[c]);
                folds.iter().flat_map(|fold| likelihood.held_out_errors(fold)).map(f64::abs).sum()
            };
            // Errors are standardised; back to the output's unit.
            sum / n as f64 * self.output_standardiser.scale(c)
        };
        self.posteriors.iter().enumerate().map(mae).collect()
    }

    /// The row numbers of each fold.
    fn folds(&self) -> Vec<Vec<usize>> {
        let n = self.points();
        let count = self.config.folds.min(n);
        match self.config.fold_order {
            FoldOrder::Blocks => {
                (0..count).map(|f| (f * n / count..(f + 1) * n / count).collect()).collect()
            }
            FoldOrder::Interleaved => (0..count).map(|f| (f..n).step_by(count).collect()).collect(),
        }
    }
}
