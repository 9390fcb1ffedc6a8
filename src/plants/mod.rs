//! Things that move. A plant is one file and one line of `plants!`: its module, its name in specs
//! and the type of its options, which implements [`PlantOptions`].

mod changing;

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use changing::{Changing, RobotChange};
pub use constant_curvature::{ConstantCurvature, ConstantCurvatureOptions};
pub use external::{External, ExternalOptions};
pub use hardware::{Hardware, HardwareOptions};
pub use replay::{Replay, ReplayOptions};
pub use simulated::{Simulated, SimulatedOptions, SimulatedSpec};

use crate::base::{BadOption, Plant, PlantError, TendonCommand, TendonLayout};
use crate::effects::{DriveGains, EffectSpec, Model};

/// Refuses another number of tendons, and displacements that are not finite or beyond the travel.
fn check_commands(
    commands: &[TendonCommand],
    tendons: usize,
    travel_m: f64,
) -> Result<(), PlantError> {
    if commands.len() != tendons {
        let found = commands.len();
        return Err(PlantError::Refused(format!("{found} tendons, expected {tendons}")));
    }
    for (index, command) in commands.iter().enumerate() {
        if let TendonCommand::Pull(pull_m) = command
            && (pull_m.is_nan() || pull_m.abs() > travel_m)
        {
            return Err(PlantError::Refused(format!(
                "tendon {}: a displacement of {pull_m} m, expected at most ±{travel_m} m",
                index + 1
            )));
        }
    }
    Ok(())
}

/// What a kind of plant states about itself: the options that a spec gives it, and what follows
/// from them.
pub trait PlantOptions:
    Clone + PartialEq + Serialize + for<'de> Deserialize<'de> + schemars::JsonSchema
{
    /// Keys below the plant's own under which the name of a model file may stand, with dots between
    /// keys.
    const MODEL_KEYS: &'static [&'static str] = &[];
    /// True for a robot behind motor controller and tracker: it cannot stand for the model of an
    /// experiment.
    const DRIVES_HARDWARE: bool = false;
    /// True when effects can be added to it.
    const TAKES_EFFECTS: bool = false;

    /// Refuses settings out of range.
    ///
    /// # Errors
    /// The path below the plant's key under which the key stands (empty: directly below), and the
    /// first field out of range.
    fn check(&self) -> Result<(), (String, BadOption)>;

    /// Number of tendons.
    fn tendons(&self) -> usize;

    /// Which tendons bend which part, and where they lie.
    fn tendon_layout(&self) -> TendonLayout {
        TendonLayout::ring(self.tendons())
    }

    /// The robot, moving in steps of `step_s` seconds.
    ///
    /// # Errors
    /// What is out of range or not as it should be, in words.
    fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String>;

    /// What the robot depends on besides these options, such as the content of a file that they
    /// name. It is part of the key of every stored result of this robot.
    fn identity(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes the names of files relative to `folder`.
    fn resolve_files(&mut self, _folder: &Path) {}

    /// Takes the measurement noise away.
    fn remove_noise(&mut self) {}

    /// Adds effects, where [`PlantOptions::TAKES_EFFECTS`].
    fn add_effects(&mut self, _effects: &[EffectSpec]) {}

    /// The drives through which commands reach the tendons, by name; none where commands are those
    /// of tendons alone.
    fn drive_gains(&self) -> BTreeMap<String, DriveGains> {
        BTreeMap::new()
    }

    /// Standard deviation of the tracking noise, metres, where a spec's limit for it holds.
    fn noise_m(&self) -> Option<f64> {
        None
    }

    /// Largest displacement of a tendon, metres, where an experiment's commands must stay within
    /// it.
    fn travel_m(&self) -> Option<f64> {
        None
    }

    /// Whether it may be the paper's robot: false where its length or the place of its tendons is
    /// another one.
    fn may_be_paper_robot(&self) -> bool {
        true
    }

    /// Its levers and its length, where a model tells them.
    fn size(&self) -> Option<RobotSize> {
        None
    }

    /// The model that it is made of, or what is believed of it, where effects of a population can
    /// be added to that.
    fn model(&self) -> Option<&Model> {
        None
    }

    /// A plant that does the same each time it is built and needs nothing but this program:
    /// contract tests run it.
    fn example() -> Option<Self> {
        None
    }
}

/// What displacements and lengths are in proportion to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotSize {
    /// Smallest distance of a tendon from the backbone, metres.
    pub lever_m: f64,
    /// Length of the backbone, metres.
    pub length_m: f64,
}

/// One kind of plant.
pub struct PlantEntry {
    /// Name in specs.
    pub name: &'static str,
    /// An instance for contract tests, where there is one.
    pub example: fn() -> Option<PlantSpec>,
}

macro_rules! plants {
    ($($visibility:vis $module:ident: $variant:ident($options:ty)),* $(,)?) => {
        $($visibility mod $module;)*

        /// A robot: the model, or the plant that represents the real one.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case", deny_unknown_fields)]
        pub enum PlantSpec {
            $(#[doc = concat!("See `plants::", stringify!($module), "`.")] $variant(Box<$options>),)*
        }

        /// Every kind of plant.
        pub static REGISTRY: &[PlantEntry] = &[$(PlantEntry {
            name: stringify!($module),
            example: || <$options>::example().map(|options| PlantSpec::$variant(Box::new(options))),
        }),*];

        impl PlantSpec {
            /// Name of the kind of robot, as in specs.
            pub fn kind(&self) -> &'static str {
                match self { $(PlantSpec::$variant(_) => stringify!($module)),* }
            }

            /// Where below a plant's own place the names of model files may stand, with dots
            /// between keys.
            pub fn model_keys() -> Vec<String> {
                let mut keys = Vec::new();
                $(keys.extend(<$options>::MODEL_KEYS.iter().map(|key| format!("{}.{key}", stringify!($module))));)*
                keys
            }

            /// Checks every range.
            ///
            /// # Errors
            /// The path below which the key stands, and the first field out of range.
            pub fn check(&self) -> Result<(), (String, BadOption)> {
                let checked = match self { $(PlantSpec::$variant(options) => options.check()),* };
                let kind = self.kind();
                let below = |path: String| if path.is_empty() { kind.to_owned() } else { format!("{kind}.{path}") };
                checked.map_err(|(path, error)| (below(path), error))
            }

            /// Number of tendons.
            pub fn tendons(&self) -> usize {
                match self { $(PlantSpec::$variant(options) => options.tendons()),* }
            }

            /// Which tendons bend which part, and where they lie.
            pub fn tendon_layout(&self) -> TendonLayout {
                match self { $(PlantSpec::$variant(options) => options.tendon_layout()),* }
            }

            /// The tendons of each drive by its name, where commands are those of drives.
            pub fn drive_gains(&self) -> BTreeMap<String, DriveGains> {
                match self { $(PlantSpec::$variant(options) => options.drive_gains()),* }
            }

            /// True for robots to which effects can be added.
            pub fn takes_effects(&self) -> bool {
                match self { $(PlantSpec::$variant(_) => <$options>::TAKES_EFFECTS),* }
            }

            /// True for a robot behind motor controller and tracker, real or rehearsed.
            pub fn drives_hardware(&self) -> bool {
                match self { $(PlantSpec::$variant(_) => <$options>::DRIVES_HARDWARE),* }
            }

            /// Standard deviation of the tracking noise, metres, where a spec's limit for it holds.
            pub fn noise_m(&self) -> Option<f64> {
                match self { $(PlantSpec::$variant(options) => options.noise_m()),* }
            }

            /// Largest displacement of a tendon, metres, where an experiment's commands must stay
            /// within it.
            pub fn travel_m(&self) -> Option<f64> {
                match self { $(PlantSpec::$variant(options) => options.travel_m()),* }
            }

            /// Whether it may be the paper's robot.
            pub fn may_be_paper_robot(&self) -> bool {
                match self { $(PlantSpec::$variant(options) => options.may_be_paper_robot()),* }
            }

            /// Its levers and its length, where a model tells them.
            pub fn size(&self) -> Option<RobotSize> {
                match self { $(PlantSpec::$variant(options) => options.size()),* }
            }

            /// The model to which effects of a population can be added.
            pub fn model(&self) -> Option<&Model> {
                match self { $(PlantSpec::$variant(options) => options.model()),* }
            }

            /// What the robot depends on besides its options: part of the key of its stored
            /// results.
            pub fn identity(&self) -> Vec<u8> {
                match self { $(PlantSpec::$variant(options) => options.identity()),* }
            }

            /// The robot, moving in steps of `step_s` seconds. A real robot is waited for until no
            /// other stage uses it.
            ///
            /// # Errors
            /// What is out of range or not as it should be, in words.
            pub fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
                match self { $(PlantSpec::$variant(options) => options.build(step_s)),* }
            }

            /// Takes the names of files relative to `folder`.
            pub fn resolve_files(&mut self, folder: &Path) {
                match self { $(PlantSpec::$variant(options) => options.resolve_files(folder)),* }
            }

            /// The same robot, measured without noise.
            #[must_use]
            pub fn without_noise(&self) -> PlantSpec {
                let mut plant = self.clone();
                match &mut plant { $(PlantSpec::$variant(options) => options.remove_noise()),* }
                plant
            }

            /// The same robot with further effects, where it takes any.
            #[must_use]
            pub fn with_effects(&self, effects: &[EffectSpec]) -> PlantSpec {
                let mut plant = self.clone();
                match &mut plant { $(PlantSpec::$variant(options) => options.add_effects(effects)),* }
                plant
            }
        }
    };
}

plants! {
    simulated: Simulated(SimulatedSpec),
    constant_curvature: ConstantCurvature(ConstantCurvatureOptions),
    pub hardware: Hardware(HardwareOptions),
    replay: Replay(ReplayOptions),
    external: External(ExternalOptions),
}
