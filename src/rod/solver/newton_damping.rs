//! Damping of alternating Newton corrections. Dry friction laws have kinks, and each branch may
//! send the iteration to the other one indefinitely (semismooth Newton methods need damping for
//! global convergence; Facchinei & Pang, Finite-Dimensional Variational Inequalities and
//! Complementarity Problems, 2003, section 8.3).

use nalgebra::DVector;

use crate::rod::equations::system::RodEquations;

/// A correction reverses the previous one if the cosine between them is below this …
const REVERSAL_COSINE: f64 = -0.5;
/// … and its size is at least this share of the previous one.
const MIN_REVERSAL_RATIO: f64 = 0.3;
/// A correction larger than the previous one by this factor has changed branch as well.
const MAX_GROWTH_RATIO: f64 = 1.5;
/// After this many changes of branch the share no longer doubles but grows …
const FREE_BRANCH_CHANGES: i32 = 6;
/// … by a factor that decays geometrically with this ratio, so that no cycle persists.
const GROWTH_DECAY: f64 = 0.8;
/// Smallest share of a correction.
const MIN_SHARE: f64 = 0.05;

/// The share of a correction that is applied, from the history of corrections.
#[derive(Clone, Debug)]
pub(crate) struct NewtonDamping {
    /// The last correction, whole, with its size in metres.
    last: Option<(DVector<f64>, f64)>,
    share: f64,
    /// Changes of branch so far.
    branch_changes: i32,
}

impl NewtonDamping {
    /// Starts with full corrections.
    pub(crate) fn new() -> NewtonDamping {
        NewtonDamping { last: None, share: 1.0, branch_changes: 0 }
    }

    /// The share of the correction `step` of `size` metres to apply: half the previous share after
    /// a change of branch, otherwise a larger one.
    pub(crate) fn share(&mut self, system: &RodEquations, step: &DVector<f64>, size: f64) -> f64 {
        let changes_branch = self.last.as_ref().is_some_and(|(last, last_size)| {
            let norms = (system.product_m2(last, last) * system.product_m2(step, step)).sqrt();
            let reverses = system.product_m2(last, step) < REVERSAL_COSINE * norms
                && size > MIN_REVERSAL_RATIO * last_size;
            reverses || size > MAX_GROWTH_RATIO * last_size
        });
        self.branch_changes += i32::from(changes_branch);
        // Growth that decays geometrically bounds the product of all factors.
        let excess = (self.branch_changes - FREE_BRANCH_CHANGES).max(0);
        let factor = if changes_branch { 0.5 } else { 1.0 + GROWTH_DECAY.powi(excess) };
        self.share = (factor * self.share).clamp(MIN_SHARE, 1.0);
        self.last = Some((step.clone(), size));
        self.share
    }
}
