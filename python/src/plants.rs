//! A plant of an environment: what was last seen of it and its status.

use spinebench::base::{Observation, Plant, PlantError, Seed};
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::specs::PlantSpec;

use crate::errors::Fault;
use crate::model::effects_of;
use crate::rod::shape_m;

/// A plant; a simulated one shows its shape.
enum Body {
    Simulated(Box<Simulated>),
    Other(Box<dyn Plant>),
}

impl Body {
    fn new(spec: &PlantSpec, step_s: f64) -> Result<Body, Fault> {
        match spec {
            PlantSpec::Simulated(spec) => {
                let options =
                    SimulatedOptions { step_s, noise_m: spec.noise_m, travel_m: spec.travel_m };
                Ok(Body::Simulated(Box::new(Simulated::new(&spec.model, &[], options))))
            }
            other => Ok(Body::Other(other.build(step_s).map_err(Fault::words)?)),
        }
    }

    fn plant(&mut self) -> &mut dyn Plant {
        match self {
            Body::Simulated(plant) => plant.as_mut(),
            Body::Other(plant) => plant.as_mut(),
        }
    }
}

/// One robot: the plant, what was last seen of it, and its status.
pub(crate) struct Robot {
    body: Body,
    seen: Option<Observation>,
    pub(crate) status: String,
}

/// Status of a robot that can move.
pub(crate) const OK: &str = "ok";

impl Robot {
    pub(crate) fn new(spec: &PlantSpec, step_s: f64) -> Result<Robot, Fault> {
        Ok(Robot { body: Body::new(spec, step_s)?, seen: None, status: "closed".to_owned() })
    }

    /// Brings it home, with `effects` (JSON; empty for none) beside those of `spec`.
    pub(crate) fn reset(
        &mut self,
        spec: &PlantSpec,
        step_s: f64,
        seed: u64,
        effects: &str,
    ) -> Result<(), Fault> {
        if !effects.is_empty() {
            self.body = Body::new(&extended(spec, effects)?, step_s)?;
        }
        let outcome = self.body.plant().reset(Seed(seed));
        self.seen = None;
        self.note(outcome);
        Ok(())
    }

    /// One step; a robot whose status is not `ok` stays as it is.
    pub(crate) fn step(&mut self, pulls_m: &[f64]) {
        if self.status == OK {
            let outcome = self.body.plant().step(pulls_m);
            self.note(outcome);
        }
    }

    /// Takes note of an observation or of the reason why there is none.
    fn note(&mut self, outcome: Result<Observation, PlantError>) {
        match outcome {
            Ok(seen) => {
                OK.clone_into(&mut self.status);
                self.seen = Some(seen);
            }
            Err(PlantError::Solver(status)) => self.status = status,
            Err(other) => self.status = other.to_string(),
        }
    }

    /// The tip that was last seen, metres; not a number before.
    pub(crate) fn tip_m(&self) -> [f64; 3] {
        self.seen.as_ref().map_or([f64::NAN; 3], |seen| seen.tip_m)
    }

    /// Displacements of the tendons, metres; none before the robot was seen.
    pub(crate) fn pulls_m(&self) -> &[f64] {
        self.seen.as_ref().map_or(&[], |seen| &seen.pulls_m)
    }

    /// Positions (n, 3) along a simulated robot, metres.
    pub(crate) fn shape_m(&self, n: usize) -> Option<Vec<f64>> {
        match &self.body {
            Body::Simulated(plant) => Some(shape_m(plant.rod(), n)),
            Body::Other(_) => None,
        }
    }
}

/// The plant with further effects (JSON).
pub(crate) fn extended(spec: &PlantSpec, effects: &str) -> Result<PlantSpec, Fault> {
    if !spec.takes_effects() {
        let expected = "none: effects cannot be added to this plant";
        return Err(Fault::argument("randomise", "effects", expected));
    }
    let extended = spec.with_effects(&effects_of("randomise", effects)?);
    extended.check().map_err(|(path, bad)| {
        Fault::argument(&format!("randomise: {path}.{}", bad.key), bad.found, bad.expected)
    })?;
    Ok(extended)
}
