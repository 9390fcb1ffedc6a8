//! Damping of alternating Newton corrections. Dry friction laws have kinks, and each branch may send the iteration to
//! the other one indefinitely (semismooth Newton methods need damping for global convergence; Facchinei & Pang,
//! Finite-Dimensional Variational Inequalities and Complementarity Problems, 2003, section 8.3).

use nalgebra::DVector;

use crate::rod::equations::system::RodEquations;

/// A correction reverses the previous one if the cosine between them is below this …
const BACK: f64 = -0.5;
/// … and its size is at least this share of the previous one.
const AS_LARGE: f64 = 0.3;
/// A correction larger than the previous one by this factor has changed branch as well.
const GROWN: f64 = 1.5;
/// After this many changes of branch the share no longer doubles but grows …
const FEW: i32 = 6;
/// … by a factor that decays geometrically with this ratio, so that no cycle persists.
const CALMER: f64 = 0.8;
/// Smallest share of a correction.
const MIN_SHARE: f64 = 0.05;

/// The share of a correction that is applied, from the history of corrections.
#[derive(Clone, Debug)]
pub(crate) struct NewtonDamping {
    /// The last correction, whole, with its size in metres.
    last: Option<(DVector<f64>, f64)>,
    share: f64,
    /// Changes of branch so far.
    turns: i32,
}

impl NewtonDamping {
    /// Starts with full corrections.
    pub(crate) fn new() -> NewtonDamping {
        NewtonDamping { last: None, share: 1.0, turns: 0 }
    }

    /// The share of the correction `step` of `size` metres to apply: half the previous share after a change of branch,
    /// otherwise a larger one.
    pub(crate) fn share(&mut self, system: &RodEquations, step: &DVector<f64>, size: f64) -> f64 {
        let turns = self.last.as_ref().is_some_and(|(last, last_size)| {
            let norms = (system.product_m2(last, last) * system.product_m2(step, step)).sqrt();
            let back = system.product_m2(last, step) < BACK * norms && size > AS_LARGE * last_size;
            back || size > GROWN * last_size
        });
        self.turns += i32::from(turns);
        let by = if turns { 0.5 } else { 1.0 + CALMER.powi((self.turns - FEW).max(0)) };
        self.share = (by * self.share).clamp(MIN_SHARE, 1.0);
        self.last = Some((step.clone(), size));
        self.share
    }
}
