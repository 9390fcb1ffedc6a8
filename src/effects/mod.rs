//! The catalogue of physical effects that a model may lack. The same effect opens a gap in a
//! simulated "real" robot and closes it in a model. Names and parameters are those of the outside
//! interface; each effect is one file of `catalogue/` and one line in `catalogue!` there, which
//! declares its module.

mod catalogue;
mod driven;
mod model;
mod robot;

use std::fmt::Debug;

use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Observation};
use crate::rod::RodParams;

pub use catalogue::{CATALOGUE, EffectSpec, card};
pub use driven::driven_model::DrivenModel;
pub use driven::replay::{ReplayError, Replayed, Trial, replay};
pub use model::obstacles::{Capsule, Cylinder, ObstacleSpec, Plane, Sphere};
pub use model::parameter::{ModelParameter, ParameterError, Variable, VariationError};
pub use model::robot_model::{Model, check_effect_units, check_effects};
pub use model::tendon_drive::{DriveGains, TendonDrive, check_drives, drive_gains};
pub use model::tracking::{BodyPoint, Starts, Tracking};
pub use robot::{
    Backbone, Disks, Frame, Load, OffsetPoint, OnePlace, PerTendon, Piece, RadiusPoint, Robot,
    Sections, Spread, Tendons,
};

/// A physical effect. Every hook does nothing unless an effect fills it in.
///
/// ```text
/// impl Effect for TipLoad {
///     fn check(&self) -> Result<(), BadOption> { … }
///     fn modify_rod(&self, rod: &mut RodParams) { rod.masses.push(…) }
/// }
/// ```
pub trait Effect: CloneEffect + Send + Sync + Debug {
    /// Refuses parameters out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first parameter out of range.
    fn check(&self) -> Result<(), BadOption>;
    /// Changes the parameters of the rod.
    fn modify_rod(&self, _rod: &mut RodParams) {}
    /// Whether it adds a payload, which effects on the robot's own parameters must not change.
    /// Payloads are applied last, so that the order of a list does not matter.
    fn is_payload(&self) -> bool {
        false
    }
    /// Changes the drive positions after a motion to `pulls_m` (metres) at constant speed that took
    /// `dt_s` seconds. An infinite `dt_s` means rest.
    fn modify_command(&mut self, _pulls_m: &mut [f64], _dt_s: f64) {}
    /// Whether drive positions change while a command is held.
    fn has_lag(&self) -> bool {
        false
    }
    /// Whether a pose at rest depends on the commands before it, other than through a moment law of
    /// the rod.
    fn has_memory_at_rest(&self) -> bool {
        false
    }
    /// Changes the measurement.
    fn observe(&self, _seen: &mut Observation) {}
    /// Clears the history at the start of a trial.
    fn reset(&mut self) {}
    /// The tendon (from 1) of an effect on one tendon.
    fn tendon(&self) -> Option<usize> {
        None
    }
    /// The segment (from 1) of an effect on one segment.
    fn segment(&self) -> Option<usize> {
        None
    }
}

/// Copies an effect with its history; every effect that is `Clone` has it.
pub trait CloneEffect {
    /// The copy.
    fn boxed_clone(&self) -> Box<dyn Effect>;
}

impl<E: Effect + Clone + 'static> CloneEffect for E {
    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Effect> {
    fn clone(&self) -> Self {
        (**self).boxed_clone()
    }
}

/// A parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in YAML; components of a vector carry an index.
    pub name: &'static str,
    /// Its unit; `1` for a plain ratio.
    pub unit: &'static str,
    /// The value at which the effect changes nothing (or the default of a secondary parameter).
    pub null: f64,
    /// Its role when the effect is fitted to data.
    pub seek: Seek,
}

impl Parameter {
    /// A segment of the robot, or all of it.
    pub(crate) const SEGMENT: Parameter =
        Parameter { name: "segment", unit: "number", null: 0.0, seek: Seek::Segment };

    /// Its name without the index of a component.
    pub fn vector(&self) -> &'static str {
        self.name.split('[').next().unwrap_or(self.name)
    }
}

/// Role of a parameter when its effect is fitted to data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seek {
    /// Amplitude of the effect: fitted from its null value, with this first step.
    Size(f64),
    /// The same for a non-monotonic response: starts from the best of these values.
    Scanned(f64, &'static [f64]),
    /// Amplitude that replaces this number of the robot, which is its null value.
    Replaces(&'static str, f64),
    /// Shape parameter: started at each of these values, then fitted.
    Shape(&'static [f64]),
    /// Arc length along the robot, metres.
    Place,
    /// Distance of something fixed in the world, with this first step: fitted from where residuals
    /// point to.
    Distance(f64),
    /// What else says where it is, with this step.
    Located(f64),
    /// Which tendon, from 1.
    Tendon,
    /// Which segment, from 1, where the null value is 1: such an effect is sought on robots with
    /// several. Where that is 0, 0 is the whole robot.
    Segment,
    /// A flag: 1 or 0.
    Flag,
    /// A flag that says how the other parameters describe the same law.
    Convention,
}

/// Catalogue entry of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Card {
    /// Its name in YAML and findings.
    pub name: &'static str,
    /// What is missing from a model without it.
    pub missing: &'static str,
    /// Its equation in plain text.
    pub equation: &'static str,
    /// Where the equation is from.
    pub source: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Scale by which its sizes change from one recording of a robot to the next: a Cauchy prior,
    /// of the logarithm of a ratio; none: any size is as plausible.
    pub usual_change: Option<f64>,
    /// Effects with a similar response at the tip.
    pub confused_with: &'static [&'static str],
}
