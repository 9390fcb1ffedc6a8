//! Refinement levels of a rod's resolution: more cells and more polynomials.

use super::grid::element_ends;
use crate::rod::params::resolution::Resolution;
use crate::rod::params::rod_params::RodParams;

/// How often the grid may be refined: cells to a sixteenth, and polynomials that end at every jump of the material.
pub(crate) const MOST_REFINEMENTS: u32 = 4;
/// Polynomials added by the first refinement; each further one adds two more than the one before.
const MORE_MODES: usize = 4;
/// About as many polynomial coefficients may the levels from the second on have.
const MOST_UNKNOWNS: [usize; MOST_REFINEMENTS as usize - 1] = [250, 400, 600];
/// Refinement stops at cells of this share of the length.
const MOST_CELLS: f64 = 300.0;

impl RodParams {
    /// The same rod with `base` refined `level` times: cells are halved and polynomials added each time. From the second
    /// time on polynomials end at every jump of the material; many elements get fewer polynomials each.
    pub(crate) fn refined(&self, base: &Resolution, level: u32) -> RodParams {
        let mut params = RodParams { resolution: *base, ..self.clone() };
        if level == 0 {
            return params;
        }
        let k = level as usize - 1;
        let more: usize = (0..=k).map(|k| MORE_MODES + 2 * k).sum();
        let (mut bending, mut others) = (usize::MAX, usize::MAX);
        if level > 1 {
            params.resolution.split_elements = true;
            let own = MOST_UNKNOWNS[k - 1] / (element_ends(&params).len() - 1);
            // Half as many again for two bending moments as for each of the four other components.
            others = (own / 7).max(1 + k);
            bending = others + others / 2;
        }
        params.resolution = Resolution {
            cell_m: (base.cell_m / f64::from(1 << level)).max(self.length_m() / MOST_CELLS).min(base.cell_m),
            bending_modes: bending.min(base.bending_modes + more),
            torsion_modes: others.min(base.torsion_modes + more),
            shear_modes: others.min(base.shear_modes + more),
            axial_modes: others.min(base.axial_modes + more),
            ..params.resolution
        };
        params
    }
}
