//! Refinement levels of a rod's resolution: more cells and more polynomials.

use super::grid::element_ends;
use crate::rod::params::resolution::Resolution;
use crate::rod::params::rod_params::RodParams;

/// Most refinement levels: cells down to a sixteenth, elements that end at every jump of the material.
pub(crate) const MAX_REFINEMENTS: u32 = 4;
/// Polynomials that the first level adds; each further level adds two more than the one before.
const MORE_MODES: usize = 4;
/// Approximate bound on the number of polynomial coefficients from level 2 on.
const MAX_UNKNOWNS: [usize; MAX_REFINEMENTS as usize - 1] = [250, 400, 600];
/// Most cells along the length.
const MAX_CELLS: f64 = 300.0;

impl RodParams {
    /// The same rod at refinement level `level` of `base`: each level halves the cells and adds polynomials. From level
    /// 2 on, elements end at every jump of the material, and many elements get fewer polynomials each.
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
            let own = MAX_UNKNOWNS[k - 1] / (element_ends(&params).len() - 1);
            // 1.5 times as many polynomials for the two bending moments as for the four other components.
            others = (own / 7).max(1 + k);
            bending = others + others / 2;
        }
        params.resolution = Resolution {
            cell_m: (base.cell_m / f64::from(1 << level)).max(self.length_m() / MAX_CELLS).min(base.cell_m),
            bending_modes: bending.min(base.bending_modes + more),
            torsion_modes: others.min(base.torsion_modes + more),
            shear_modes: others.min(base.shear_modes + more),
            axial_modes: others.min(base.axial_modes + more),
            ..params.resolution
        };
        params
    }
}
