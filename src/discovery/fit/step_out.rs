//! A better fit beyond where derivatives lead.

use nalgebra::DVector;

use super::gauss_newton::{FitProblem, FittedSet};

/// How far ahead is looked, in standard deviations: as far as an interval would reach, and well beyond. Where the tip jumps,
/// deviations say little of how far that is.
const AHEAD: [f64; 4] = [2.0, 6.0, 20.0, 60.0];
/// A fall of the deviance that is worth going there.
const WORTH: f64 = 1.0;
/// Better fits at most, one from the other.
const MOST_FITS: usize = 4;

impl FitProblem<'_> {
    /// `fitted`, or what fits better along one of its coordinates, the others following, where the best fit by its
    /// derivatives should not be: a tip that jumps (tendons that become taut) has derivatives that say little of what lies
    /// beyond.
    pub(crate) fn step_out(&self, mut fitted: FittedSet) -> FittedSet {
        for _ in 0..MOST_FITS {
            let better = self.find_better(&fitted).and_then(|ahead| self.refit(ahead.members, ahead.jacobian));
            match better.filter(|better| better.nuisance_fit.deviance < fitted.nuisance_fit.deviance - WORTH) {
                Some(better) => fitted = better,
                None => break,
            }
        }
        fitted
    }

    /// Something better along one of the coordinates.
    fn find_better(&self, fitted: &FittedSet) -> Option<FittedSet> {
        let covariance = self.covariance(fitted)?;
        (0..covariance.ncols()).find_map(|at| {
            let deviation = covariance[(at, at)].max(f64::MIN_POSITIVE).sqrt();
            // The others go with it as the curvature at the fit has them.
            let together = covariance.column(at) / deviation;
            let ways = AHEAD.into_iter().flat_map(|ahead| [ahead, -ahead]);
            ways.into_iter().find_map(|ahead| self.best_along_step(fitted, at, ahead * &together))
        })
    }

    /// The best at `step`, and twice as far each time as long as it becomes better; none where that is not better than
    /// `fitted`.
    fn best_along_step(&self, fitted: &FittedSet, at: usize, mut step: DVector<f64>) -> Option<FittedSet> {
        let mut best: Option<FittedSet> = None;
        loop {
            let members = self.moved(&fitted.members, &step);
            let least = best.as_ref().map_or(fitted.nuisance_fit.deviance - WORTH, |best| best.nuisance_fit.deviance);
            match self.fit_holding(fitted, at, members, least).filter(|there| there.nuisance_fit.deviance < least) {
                Some(there) => best = Some(there),
                None => return best,
            }
            step *= 2.0;
        }
    }
}
