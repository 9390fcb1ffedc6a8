//! Rehearsals that tests play on.

use spinebench::base::Seed;
use spinebench::effects::Model;
use spinebench::plants::Hardware;
use spinebench::plants::hardware::{HardwareOptions, RehearsalOptions};
use spinebench::specs::read_model;

/// Control step of all rehearsals, s.
pub(crate) const STEP_S: f64 = 0.2;

/// A model that ships with the project.
pub(crate) fn shipped(name: &str) -> Model {
    let models = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    read_model(&models.join(format!("{name}.yaml"))).unwrap()
}

/// A rehearsal with the nominal robot, which is what is believed about it as well.
pub(crate) fn options() -> HardwareOptions {
    let model = shipped("nominal");
    HardwareOptions {
        rehearsal: Some(RehearsalOptions {
            model: model.clone(),
            noise_m: 0.0,
            loss: 0.0,
            jitter_s: 0.0,
            gap_s: 0.0,
            alignment: None,
        }),
        ..HardwareOptions::of("rehearsed", model)
    }
}

/// The rehearsal, opened.
pub(crate) fn open(options: &HardwareOptions, seed: u64) -> Hardware {
    Hardware::open(options, STEP_S, Seed(seed)).unwrap()
}
