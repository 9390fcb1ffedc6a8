//! Do trials that a fit has not seen speak against it? What a right law leaves there is the noise that it left in the trials of
//! the fit; a law that only imitates what it was shown leaves more (an F test of the two
//! variances, with as many degrees of freedom as the noise's correlation leaves).

use super::nuisance::Explained;
use super::question::Question;
use crate::math::distribution::f_above;

/// Scatter of held-out trials over that of the fit below which no law is refuted: none is exact.
const MUCH_MORE: f64 = 1.15;

impl Question<'_> {
    /// Whether the held-out trials, in which the fit behind `explained` has the tip at `played`, hold more than its noise.
    pub(super) fn refuted(&self, explained: &Explained, played: &[f64]) -> bool {
        let known = &self.nuisances_proof * &explained.amounts;
        let left: Vec<f64> = self.proof.residual(played).iter().zip(known.iter()).map(|(r, k)| r - k).collect();
        let noise = &explained.noise;
        let squares: f64 = left.iter().enumerate().map(|(k, left)| (left / noise.sigma_m[k % 3]).powi(2)).sum();
        let ratio = squares / (3.0 * self.proof.len() as f64);
        let (above, below) = (noise.independent(self.proof.len()), noise.independent(self.fit.len()));
        ratio > MUCH_MORE * MUCH_MORE && f_above(ratio, 3.0 * above, 3.0 * below) < self.options.false_alarm
    }
}
