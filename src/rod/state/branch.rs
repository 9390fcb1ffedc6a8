//! How equilibria are connected.

/// How an equilibrium is connected with the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RestBranch {
    /// The rod stays stable while the loads change from the ones to the others.
    #[default]
    Same,
    /// It loses stability at a bifurcation: further equilibria begin there, and the rod is in one
    /// of them.
    Bifurcation,
    /// Its equilibrium ends at a limit point, and it has snapped through to a distant one.
    SnapThrough,
}

impl RestBranch {
    /// Name used in recordings.
    pub fn name(self) -> &'static str {
        match self {
            RestBranch::Same => "same",
            RestBranch::Bifurcation => "bifurcation",
            RestBranch::SnapThrough => "snap_through",
        }
    }
}
