//! Robots of a league: kinds with hidden effects that a seed draws.

use std::path::Path;

use super::LeagueError;
use super::track::{Engine, ReadTrack, Task};
use crate::base::{Point3, Seed};
use crate::benchmark::Population;
use crate::data::Recording;
use crate::effects::{EffectSpec, Model};
use crate::plants::{ExternalOptions, PlantSpec, RobotChange, SimulatedSpec};
use crate::runner::Digest;
use crate::specs::{read_model, suited_travel_m};

/// What draws the robots: public for the development robots, secret for the sealed ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RobotSeed {
    /// A number that everybody knows.
    Public(u64),
    /// The secret of a season, 32 bytes.
    Sealed([u8; 32]),
}

impl RobotSeed {
    /// The seed of a robot: its draw tells nothing of the others.
    fn of(&self, track: &str, kind: &str, number: u64) -> Seed {
        let mut text = match self {
            RobotSeed::Public(number) => format!("public {number}").into_bytes(),
            RobotSeed::Sealed(secret) => secret.to_vec(),
        };
        text.extend(format!(" {track} {kind} {number}").bytes());
        seed_of(&Digest::of(&text))
    }
}

/// The seed that a digest begins with.
pub(super) fn seed_of(digest: &Digest) -> Seed {
    let first: [u8; 8] = std::array::from_fn(|index| digest.bytes()[index]);
    // 63 bits: a whole number of any YAML reader.
    Seed(u64::from_le_bytes(first) >> 1)
}

/// Name of the engine of real robots.
pub const MEASURED: &str = "measured";

/// The recordings of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotQuestion {
    /// Measured, with noise: what is given.
    pub given: Recording,
    /// Commands whose tips are asked for; without rows where none are.
    pub asked: Recording,
    /// The tips after them, metres; of a simulated robot without noise.
    pub tips_m: Vec<Point3>,
}

/// A robot of the league.
#[derive(Clone, Debug)]
pub struct LeagueRobot {
    /// Name: its kind and number.
    pub name: String,
    /// Its family.
    pub family: String,
    /// Name of the engine that plays it.
    pub engine: String,
    /// Root of its trials; of a real robot, from the digest of its recording.
    pub seed: Seed,
    /// The model without the hidden effects.
    pub nominal: Model,
    /// The hidden effects.
    pub effects: Vec<EffectSpec>,
    /// Weight of the mode `closed_load`, kilograms.
    pub load_kg: f64,
    /// Its change during a trial.
    pub change: Option<RobotChange>,
    /// The robot as it is played; of a real robot, its nominal model.
    pub plant: PlantSpec,
    /// What was measured of a real robot.
    pub measured: Option<RobotQuestion>,
}

impl LeagueRobot {
    /// Length of its backbone, metres: errors are divided by it.
    pub fn length_m(&self) -> f64 {
        self.nominal.robot.backbone.length_m
    }

    /// The travel of its tendons, metres.
    pub fn travel_m(&self) -> f64 {
        suited_travel_m(self.plant.size())
    }

    /// The model with the hidden effects.
    pub fn true_model(&self) -> Model {
        let mut model = self.nominal.clone();
        model.effects.extend_from_slice(&self.effects);
        model
    }
}

/// The robots of a track that `seed` draws.
///
/// # Errors
/// [`LeagueError::Input`] for a model that cannot be read.
pub fn draw(read: &ReadTrack, seed: &RobotSeed) -> Result<Vec<LeagueRobot>, LeagueError> {
    let mut robots = Vec::new();
    for (kind, description) in &read.kinds {
        let nominal =
            read_model(&read.robots_folder.join(&description.model)).map_err(LeagueError::input)?;
        for number in 1..=read.track.robots_each {
            let seed = seed.of(&read.name, kind, number);
            let engine = description.engine.as_ref();
            let drawn = |population: &Population, part: &str| {
                let population = of_kind(population, &description.effects);
                let drawn = population.draw(&nominal, seed.child(part));
                drawn.into_iter().map(|effect| effect.spec).collect::<Vec<EffectSpec>>()
            };
            let effects = drawn(&read.track.hidden, "hidden");
            let change = match &read.track.task {
                Task::Laps { change: Some(change), .. } => Some(RobotChange {
                    between_s: change.between_s,
                    effects: drawn(&change.effects, "change"),
                }),
                _ => None,
            };
            let plant = plant(read, engine, &nominal, &effects);
            robots.push(LeagueRobot {
                name: format!("{kind}_{number}"),
                family: description.family.clone(),
                engine: engine.map_or("rod", |engine| &engine.name).to_owned(),
                seed,
                nominal: nominal.clone(),
                effects,
                load_kg: description.load_kg,
                change,
                plant,
                measured: None,
            });
        }
    }
    Ok(robots)
}

/// The population without what cannot be hidden in a kind of robot.
fn of_kind(population: &Population, effects: &[String]) -> Population {
    let mut of_kind = population.clone();
    if !effects.is_empty() {
        of_kind.effects = match population.effects.as_slice() {
            [] => effects.to_vec(),
            named => named.iter().filter(|name| effects.contains(name)).cloned().collect(),
        };
        of_kind.most_effects = of_kind.most_effects.min(of_kind.effects.len());
        of_kind.least_effects = of_kind.least_effects.min(of_kind.most_effects);
    }
    of_kind
}

fn plant(
    read: &ReadTrack,
    engine: Option<&Engine>,
    nominal: &Model,
    effects: &[EffectSpec],
) -> PlantSpec {
    let noise_m = read.track.noise_m;
    let Some(engine) = engine else {
        let mut model = nominal.clone();
        model.effects.extend_from_slice(effects);
        return PlantSpec::Simulated(Box::new(SimulatedSpec::new(model, noise_m)));
    };
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let in_folder = |name: &str| {
        let place = read.robots_folder.join(name);
        if place.is_file() { absolute(&place).display().to_string() } else { name.to_owned() }
    };
    let options = ExternalOptions {
        command: engine.command.iter().map(|argument| in_folder(argument)).collect(),
        options: engine.options.clone(),
        files: engine.files.iter().map(|file| absolute(&read.robots_folder.join(file))).collect(),
        effects: effects.to_vec(),
        noise_m,
        ..ExternalOptions::of(nominal.clone())
    };
    PlantSpec::External(Box::new(options))
}
