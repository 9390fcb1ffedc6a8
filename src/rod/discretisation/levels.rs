//! Refinement levels of a rod's resolution: more cells and more polynomials.

use super::grid::element_ends;
use crate::rod::params::resolution::Resolution;
use crate::rod::params::rod_params::RodParams;

/// Most refinement levels: cells down to a sixteenth, elements that end at every jump of the
/// material.
pub(crate) const MAX_REFINEMENTS: u32 = 4;
/// Polynomials that the first level adds; each further level adds two more than the one before.
const FIRST_ADDED_MODES: usize = 4;
/// Approximate bound on the number of polynomial coefficients from level 2 on.
const MAX_UNKNOWNS: [usize; MAX_REFINEMENTS as usize - 1] = [250, 400, 600];
/// Most cells along the length.
const MAX_CELLS: f64 = 300.0;

impl RodParams {
    /// The same rod at refinement level `level` of `base`: each level halves the cells and adds
    /// polynomials. From level 2 on, elements end at every jump of the material, and many elements
    /// get fewer polynomials each.
    pub(crate) fn refined(&self, base: &Resolution, level: u32) -> RodParams {
        let mut params = RodParams { resolution: *base, ..self.clone() };
        if level == 0 {
            return params;
        }
        let k = level as usize - 1;
        let added_modes: usize = (0..=k).map(|k| FIRST_ADDED_MODES + 2 * k).sum();
        let (mut bending, mut others) = (usize::MAX, usize::MAX);
        if level > 1 {
            params.resolution.split_elements = true;
            // Many short elements need few polynomials each: the jumps are at their ends.
            let modes_per_element = MAX_UNKNOWNS[k - 1] / (element_ends(&params).len() - 1);
            // 1.5 times as many polynomials for the two bending moments as for the four other
            // components: 2 · 1.5 + 4 = 7.
            others = (modes_per_element / 7).max(1 + k);
            bending = others + others / 2;
        }
        params.resolution = Resolution {
            cell_m: (base.cell_m / f64::from(1 << level))
                .max(self.length_m() / MAX_CELLS)
                .min(base.cell_m),
            bending_modes: bending.min(base.bending_modes + added_modes),
            torsion_modes: others.min(base.torsion_modes + added_modes),
            shear_modes: others.min(base.shear_modes + added_modes),
            axial_modes: others.min(base.axial_modes + added_modes),
            ..params.resolution
        };
        params
    }
}
