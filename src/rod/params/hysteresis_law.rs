//! Internal bending moments that depend on the history of the curvature.

use std::fmt::Debug;

/// State of one law at one Gauss point; its meaning belongs to the law. All zeros is the virgin
/// state.
pub type HistoryState = [f64; 4];

/// A bending moment about the two body axes and its derivative with respect to the curvature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HistoryMoment {
    /// Moment that resists the curvature, N m.
    pub moment_nm: [f64; 2],
    /// d moment / d curvature, N m².
    pub tangent_n_m2: [[f64; 2]; 2],
}

/// A law that adds a history-dependent moment to the elastic one. Effects implement it.
pub trait MomentLaw: Send + Sync + Debug {
    /// Whether it acts on the cross-section this far from the base, metres. Where it begins or ends
    /// a tendon ends, so that no cell of the grid holds both.
    fn acts_at(&self, _position_m: f64) -> bool {
        true
    }

    /// Moment at curvature `curvature_rad_m` (change from the unloaded shape, body axes x and y)
    /// when the history up to the start of the step is `state`. `bending_n_m2` is the mean bending
    /// stiffness there.
    fn moment(
        &self,
        state: &HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
    ) -> HistoryMoment;

    /// The moment after a rest of `rested_s` seconds (infinite: all rate-dependent parts have
    /// relaxed) at `curvature_rad_m`; [`MomentLaw::commit`] with the same duration follows.
    fn settled(
        &self,
        state: &HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
        _rested_s: f64,
    ) -> HistoryMoment {
        self.moment(state, curvature_rad_m, bending_n_m2)
    }

    /// Updates the history after a step that ended at `curvature_rad_m`. An infinite `dt_s` means
    /// complete relaxation.
    fn commit(
        &self,
        state: &mut HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
        dt_s: f64,
    );
}
