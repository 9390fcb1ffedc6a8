//! Cross-sections must not pass through each other.

use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

impl Rod {
    /// [`SolveStatus::Crushed`] if cross-sections interpenetrate, on the axis or at a taut tendon.
    /// What a slack tendon runs through bears on nothing.
    pub(crate) fn check_interpenetration(&self) -> SolveStatus {
        if self.min_stretch() > 0.0 { SolveStatus::Converged } else { SolveStatus::Crushed }
    }

    /// Least local length of the backbone, or of the axial part of a taut tendon's path, per
    /// relaxed length.
    pub(crate) fn min_stretch(&self) -> f64 {
        let count = self.system.params.tendons.len();
        let mut min_stretch = f64::INFINITY;
        for (g, strain) in self.state.shape.strain.iter().enumerate() {
            min_stretch = min_stretch.min(strain[5]);
            for (guide, taut) in
                self.system.guides[g * count..(g + 1) * count].iter().zip(&self.state.taut)
            {
                let [x, y] = guide.offset_m;
                if guide.present && *taut {
                    min_stretch = min_stretch.min(strain[5] + strain[0] * y - strain[1] * x);
                }
            }
        }
        min_stretch
    }
}
