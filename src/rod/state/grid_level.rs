//! What a rod knows of its discretisation: its refinement level and the error that it was judged to have.

use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;

use crate::rod::equations::material::Section;
use crate::rod::equations::system::RodEquations;
use crate::rod::params::resolution::Resolution;

/// What a rod knows of its discretisation.
#[derive(Clone, Debug)]
pub(crate) struct GridLevel {
    /// Resolution that was asked for.
    pub(crate) base: Resolution,
    /// How often it has been refined.
    pub(crate) level: u32,
    /// What the grid may put the tip off by, metres.
    pub(crate) error_m: f64,
    /// Largest compliance against turning anywhere, 1/(N m²).
    pub(crate) softest: f64,
    /// The same polynomials on twice as many cells, once they have been asked for.
    halved: Arc<OnceLock<RodEquations>>,
    /// The last shape that was reconstructed.
    pub(crate) confirmed: Option<ConfirmedShape>,
}

impl GridLevel {
    pub(crate) fn new(system: &RodEquations) -> GridLevel {
        let softest = system.sections.iter().map(Section::softest_turn).fold(0.0, f64::max);
        GridLevel {
            base: system.params.resolution,
            level: 0,
            error_m: 0.0,
            softest,
            halved: Arc::default(),
            confirmed: None,
        }
    }

    /// `system` with the same polynomials on twice as many cells.
    pub(crate) fn halved(&self, system: &RodEquations) -> &RodEquations {
        self.halved
            .get_or_init(|| RodEquations::on(system.grid.halved(&system.params.resolution), system.params.clone()))
    }

    /// A rod that starts anew does not know its earlier shapes.
    pub(crate) fn forget(&mut self) {
        self.confirmed = None;
    }
}

/// A shape whose error has been told by its reconstruction, and by how much that exceeded what was estimated.
#[derive(Clone, Debug)]
pub(crate) struct ConfirmedShape {
    pub(crate) tip_m: Vector3<f64>,
    pub(crate) taut: Vec<bool>,
    pub(crate) ratio: f64,
}
