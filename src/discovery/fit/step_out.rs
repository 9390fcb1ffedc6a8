//! Line search beyond the local optimum, for tips that jump.

use nalgebra::DVector;

use super::gauss_newton::{FitProblem, FittedSet};

/// Search distances in standard deviations, up to far beyond an interval (docs/method/search.md,
/// "Searching sets", step 8).
const DISTANCES_SIGMA: [f64; 4] = [2.0, 6.0, 20.0, 60.0];
/// Minimum decrease of the deviance.
const MIN_DECREASE: f64 = 1.0;
/// Maximum number of successive improvements.
const MAX_FITS: usize = 4;

impl FitProblem<'_> {
    /// `fitted`, or a better fit along one of its coordinates. Derivatives do not predict jumps of
    /// the tip (tendons that become taut).
    pub(crate) fn step_out(&self, mut fitted: FittedSet) -> FittedSet {
        for _ in 0..MAX_FITS {
            // A better place may lead on to the next, so the search starts again from there.
            let better = self
                .find_better(&fitted)
                .and_then(|ahead| self.refit(ahead.members, ahead.jacobian));
            match better.filter(|better| {
                better.nuisance_fit.deviance < fitted.nuisance_fit.deviance - MIN_DECREASE
            }) {
                Some(better) => fitted = better,
                None => break,
            }
        }
        fitted
    }

    /// A better fit along one of the coordinates.
    fn find_better(&self, fitted: &FittedSet) -> Option<FittedSet> {
        let covariance = self.covariance(fitted)?;
        (0..covariance.ncols()).find_map(|at| {
            let deviation = covariance[(at, at)].max(f64::MIN_POSITIVE).sqrt();
            // The other coordinates follow by the curvature at the fit.
            let together = covariance.column(at) / deviation;
            let distances = DISTANCES_SIGMA.into_iter().flat_map(|ahead| [ahead, -ahead]);
            distances
                .into_iter()
                .find_map(|ahead| self.best_along_step(fitted, at, ahead * &together))
        })
    }

    /// Best fit at `step`, doubled as long as it improves; none if it is not better than `fitted`.
    fn best_along_step(
        &self,
        fitted: &FittedSet,
        at: usize,
        mut step: DVector<f64>,
    ) -> Option<FittedSet> {
        let mut best: Option<FittedSet> = None;
        loop {
            let members = self.moved(&fitted.members, &step);
            let deviance =
                best.as_ref().map_or(fitted.nuisance_fit.deviance - MIN_DECREASE, |best| {
                    best.nuisance_fit.deviance
                });
            // Held at the new place, else the fit would slide back to the optimum it came from.
            match self
                .fit_holding(fitted, at, members, deviance)
                .filter(|there| there.nuisance_fit.deviance < deviance)
            {
                Some(there) => best = Some(there),
                None => return best,
            }
            step *= 2.0;
        }
    }
}
