//! The effects: one file and one line of `catalogue!` each. The line declares the module.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Number, Value};

use super::{Card, Effect, Seek};

macro_rules! catalogue {
    ($($module:ident :: $effect:ident),* $(,)?) => {
        $(mod $module;)*

        /// An effect as it stands in YAML: its name and its parameters.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum EffectSpec {
            $(#[doc = concat!("See `", stringify!($module), "`.")] $effect($module::$effect)),*
        }

        impl EffectSpec {
            /// Builds the effect.
            pub fn build(&self) -> Box<dyn Effect> {
                match self { $(EffectSpec::$effect(effect) => Box::new(effect.clone())),* }
            }

            /// Its catalogue entry.
            pub fn card(&self) -> &'static Card {
                match self { $(EffectSpec::$effect(_) => &$module::CARD),* }
            }
        }

        /// All effects.
        pub static CATALOGUE: &[&Card] = &[$(&$module::CARD),*];
    };
}

catalogue! {
    tip_load::TipLoad,
    distributed_mass::DistributedMass,
    tip_force::TipForce,
    base_tilt::BaseTilt,
    frame_shift::FrameShift,
    bending_stiffness::BendingStiffness,
    anisotropic_stiffness::AnisotropicStiffness,
    precurvature::Precurvature,
    soft_section::SoftSection,
    spine_compressibility::SpineCompressibility,
    friction::Friction,
    hysteresis::Hysteresis,
    creep::Creep,
    damping::Damping,
    delay::Delay,
    backlash::Backlash,
    actuator_gain::ActuatorGain,
    actuator_offset::ActuatorOffset,
    tendon_stretch::TendonStretch,
    tendon_angle::TendonAngle,
    tendon_radius::TendonRadius,
    tendon_friction::TendonFriction,
    servo_lag::ServoLag,
    contact::Contact,
    pretension::Pretension,
}

/// For `skip_serializing_if`: the whole robot is no segment.
fn is_whole(segment: &usize) -> bool {
    *segment == 0
}

/// The entry called `name`.
pub fn card(name: &str) -> Option<&'static Card> {
    CATALOGUE.iter().find(|card| card.name == name).copied()
}

impl EffectSpec {
    /// The effect of `card` with these values, one per parameter in the order of the card; `None`
    /// when a value is out of range. Fields that the card does not list take their defaults.
    pub fn from_card(card: &Card, values: &[f64]) -> Option<EffectSpec> {
        let mut fields = Map::new();
        for (parameter, &value) in card.parameters.iter().zip(values) {
            let number = match parameter.seek {
                Seek::Tendon | Seek::Segment => Value::from(value as u64),
                Seek::Flag | Seek::Convention => Value::Bool(value != 0.0),
                _ => Value::Number(Number::from_f64(value)?),
            };
            match parameter.name.split_once('[') {
                None => fields.insert(parameter.name.to_owned(), number),
                Some((vector, _)) => {
                    match fields.entry(vector).or_insert_with(|| Value::Array(Vec::new())) {
                        Value::Array(components) => {
                            components.push(number);
                            continue;
                        }
                        _ => return None,
                    }
                }
            };
        }
        let spec: EffectSpec = serde_json::from_value(Value::Object(Map::from_iter([(
            card.name.to_owned(),
            fields.into(),
        )])))
        .ok()?;
        spec.build().check().is_ok().then_some(spec)
    }

    /// Its relaxation time, s; none unless it matters how long a robot has rested.
    pub fn relaxation_time_s(&self) -> Option<f64> {
        match self {
            EffectSpec::Creep(creep) => Some(creep.time_s),
            _ => None,
        }
    }

    /// A mass hung on the tip, kg.
    pub fn tip_load(mass_kg: f64) -> EffectSpec {
        EffectSpec::TipLoad(tip_load::TipLoad { mass_kg })
    }
}
