//! Refinement level of a rod and the estimated error of its grid.

use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;

use crate::rod::equations::material::Section;
use crate::rod::equations::system::RodEquations;
use crate::rod::params::resolution::Resolution;

/// Refinement level and estimated discretisation error.
#[derive(Clone, Debug)]
pub(crate) struct GridLevel {
    /// Requested resolution.
    pub(crate) base: Resolution,
    /// Number of refinements.
    pub(crate) level: u32,
    /// Estimated tip error due to the grid, metres.
    pub(crate) error_m: f64,
    /// Largest rotational compliance along the rod, 1/(N m²).
    pub(crate) max_turning_compliance: f64,
    /// The same polynomials on twice as many cells, built on first use.
    halved: Arc<OnceLock<RodEquations>>,
    /// The last shape that was reconstructed.
    pub(crate) confirmed: Option<ConfirmedShape>,
}

impl GridLevel {
    pub(crate) fn new(system: &RodEquations) -> GridLevel {
        let max_turning_compliance =
            system.sections.iter().map(Section::max_turning_compliance).fold(0.0, f64::max);
        GridLevel {
            base: system.params.resolution,
            level: 0,
            error_m: 0.0,
            max_turning_compliance,
            halved: Arc::default(),
            confirmed: None,
        }
    }

    /// `system` with the same polynomials on twice as many cells.
    pub(crate) fn halved(&self, system: &RodEquations) -> &RodEquations {
        self.halved.get_or_init(|| {
            RodEquations::on(system.grid.halved(&system.params.resolution), system.params.clone())
        })
    }
}

/// A shape whose error was confirmed by reconstruction, and the ratio of that error to its
/// estimate.
#[derive(Clone, Debug)]
pub(crate) struct ConfirmedShape {
    pub(crate) tip_m: Vector3<f64>,
    pub(crate) taut: Vec<bool>,
    pub(crate) ratio: f64,
}
