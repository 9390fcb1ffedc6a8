//! Shorter corrections where Newton's method goes back and forth: the laws of dry friction have kinks, and each branch may
//! send the iteration to the other one for ever (semismooth Newton methods need such a damping to converge from afar;
//! Facchinei & Pang, Finite-Dimensional Variational Inequalities and Complementarity Problems, 2003, section 8.3).

use nalgebra::DVector;

use crate::rod::equations::system::RodEquations;

/// A correction undoes the one before if the cosine between them is below this …
const BACK: f64 = -0.5;
/// … and it is at least this share of it.
const AS_LARGE: f64 = 0.3;
/// One that is so many times as large as the one before leads to another branch as well.
const GROWN: f64 = 1.5;
/// After so many of either, shares are doubled no more but grow …
const FEW: i32 = 6;
/// … by ever less, by this factor each time, so that no cycle lasts.
const CALMER: f64 = 0.8;
/// Of a correction no less than this is taken.
const LEAST_SHARE: f64 = 0.05;

/// How much of a correction is taken, from what those before it did.
#[derive(Clone, Debug)]
pub(crate) struct NewtonDamping {
    /// The last correction, whole, with its size in metres.
    last: Option<(DVector<f64>, f64)>,
    share: f64,
    /// How often corrections have led from one branch to another.
    turns: i32,
}

impl NewtonDamping {
    /// All of the first correction.
    pub(crate) fn new() -> NewtonDamping {
        NewtonDamping { last: None, share: 1.0, turns: 0 }
    }

    /// What of the correction `step` of `size` metres is to be taken: half the share of the one before if it leads to
    /// another branch, more than that if not.
    pub(crate) fn share(&mut self, system: &RodEquations, step: &DVector<f64>, size: f64) -> f64 {
        let turns = self.last.as_ref().is_some_and(|(last, last_size)| {
            let norms = (system.product_m2(last, last) * system.product_m2(step, step)).sqrt();
            let back = system.product_m2(last, step) < BACK * norms && size > AS_LARGE * last_size;
            back || size > GROWN * last_size
        });
        self.turns += i32::from(turns);
        let by = if turns { 0.5 } else { 1.0 + CALMER.powi((self.turns - FEW).max(0)) };
        self.share = (by * self.share).clamp(LEAST_SHARE, 1.0);
        self.last = Some((step.clone(), size));
        self.share
    }
}
