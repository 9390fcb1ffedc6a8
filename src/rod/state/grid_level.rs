//! What a rod knows of its discretisation: its refinement level and the error that it was judged to have.

use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;

use crate::rod::equations::material::Section;
use crate::rod::equations::system::System;
use crate::rod::params::resolution::Resolution;

/// What a rod knows of its discretisation.
#[derive(Clone, Debug)]
pub(crate) struct Space {
    /// Resolution that was asked for.
    pub(crate) base: Resolution,
    /// How often it has been refined.
    pub(crate) level: u32,
    /// What the grid may put the tip off by, metres.
    pub(crate) error_m: f64,
    /// Largest compliance against turning anywhere, 1/(N m²).
    pub(crate) softest: f64,
    /// The same polynomials on twice as many cells, once they have been asked for.
    halved: Arc<OnceLock<System>>,
    /// The last shape that was reconstructed.
    pub(crate) confirmed: Option<Confirmed>,
}

impl Space {
    pub(crate) fn new(system: &System) -> Space {
        let softest = system.sections.iter().map(Section::softest_turn).fold(0.0, f64::max);
        Space {
            base: system.params.resolution,
            level: 0,
            error_m: 0.0,
            softest,
            halved: Arc::default(),
            confirmed: None,
        }
    }

    /// `system` with the same polynomials on twice as many cells.
    pub(crate) fn halved(&self, system: &System) -> &System {
        self.halved.get_or_init(|| System::on(system.grid.halved(&system.params.resolution), system.params.clone()))
    }

    /// A rod that starts anew does not know its earlier shapes.
    pub(crate) fn forget(&mut self) {
        self.confirmed = None;
    }
}

/// A shape whose error has been told by its reconstruction, and by how much that exceeded what was estimated.
#[derive(Clone, Debug)]
pub(crate) struct Confirmed {
    pub(crate) tip_m: Vector3<f64>,
    pub(crate) taut: Vec<bool>,
    pub(crate) ratio: f64,
}
