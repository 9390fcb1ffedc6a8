//! A robot that another program serves, a simulator or a bench, by requests in lines of JSON
//! (`docs/reference/protocols.md`).

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use rand_distr::{Distribution, Normal};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::{PlantOptions, RobotSize, check_commands};
use crate::base::{
    BadOption, Generator, LinePeer, Observation, PeerError, Plant, PlantError, Seed, SeenPoint,
    TendonCommand, TendonLayout, printable,
};
use crate::effects::{EffectSpec, Model};

/// Version of the protocol.
const PROTOCOL: u64 = 1;

/// Settings of a robot that another program serves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExternalOptions {
    /// What is believed of the robot: its tendons and its size. In a spec, the name of a model file.
    pub model: Model,
    /// The program that serves it on its standard input and output, with its arguments. Names of
    /// files count from the folder of the plant file; in an experiment, from the folder in which
    /// this program runs. Several processes may run at once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub command: Vec<String>,
    /// In place of `command`: the address of a server on this machine, as `127.0.0.1:5000`. It
    /// serves one client at a time; the others wait for their first answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub address: Option<SocketAddr>,
    /// What the program is told in its first request; the program gives it a meaning.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub options: Map<String, Value>,
    /// Files besides those in `command` that the robot depends on: a change of one is another
    /// robot.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<PathBuf>,
    /// Effects of the catalogue that the program adds to its robot.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
    /// Standard deviation of the noise per axis that is added to each tip, metres.
    #[serde(default)]
    pub noise_m: f64,
    /// Commands beyond this displacement are refused, metres.
    #[serde(default = "travel_m")]
    pub travel_m: f64,
    /// Time for the first answer, seconds.
    #[serde(default = "start_s")]
    pub start_s: f64,
    /// Time for each further answer, seconds.
    #[serde(default = "answer_s")]
    pub answer_s: f64,
    /// Most commands of one stage of trials; `null`: no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_commands: Option<u64>,
}

fn travel_m() -> f64 {
    0.06
}

fn start_s() -> f64 {
    600.0
}

fn answer_s() -> f64 {
    10.0
}

impl ExternalOptions {
    /// A robot of this model with the defaults, without a program.
    pub fn of(model: Model) -> ExternalOptions {
        ExternalOptions {
            model,
            command: Vec::new(),
            address: None,
            options: Map::new(),
            files: Vec::new(),
            effects: Vec::new(),
            noise_m: 0.0,
            travel_m: travel_m(),
            start_s: start_s(),
            answer_s: answer_s(),
            max_commands: None,
        }
    }
}

impl PlantOptions for ExternalOptions {
    const MODEL_KEYS: &'static [&'static str] = &["model"];
    const TAKES_EFFECTS: bool = true;

    fn check(&self) -> Result<(), (String, BadOption)> {
        let here = |error| (String::new(), error);
        let one = self.command.is_empty() == self.address.is_some();
        let expected = "a program and its arguments, or `address`";
        BadOption::unless(one, "command", self.command.join(" "), expected).map_err(here)?;
        let local = self.address.is_none_or(|address| address.ip().is_loopback());
        let address = self.address.map(|address| address.to_string()).unwrap_or_default();
        BadOption::unless(local, "address", address, "an address of this machine, 127.0.0.1:PORT")
            .map_err(here)?;
        BadOption::unless_not_negative("noise_m", self.noise_m).map_err(here)?;
        BadOption::unless_positive("travel_m", self.travel_m).map_err(here)?;
        BadOption::unless_positive("start_s", self.start_s).map_err(here)?;
        BadOption::unless_positive("answer_s", self.answer_s).map_err(here)?;
        self.model.check_written("model")
    }

    fn tendons(&self) -> usize {
        self.model.robot.tendons.angles_deg.len()
    }

    fn tendon_layout(&self) -> TendonLayout {
        self.model.robot.tendon_layout()
    }

    fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        Ok(Box::new(External::start(self, step_s).map_err(|error| error.to_string())?))
    }

    /// The content of the files that the command names and of `files`. One that cannot be read
    /// fails the stages that start it.
    fn identity(&self) -> Vec<u8> {
        let named = self.command.iter().map(Path::new).filter(|name| name.extension().is_some());
        named
            .chain(self.files.iter().map(PathBuf::as_path))
            .flat_map(|file| std::fs::read(file).unwrap_or_default())
            .collect()
    }

    fn resolve_files(&mut self, folder: &Path) {
        for argument in &mut self.command {
            let place = folder.join(&*argument);
            if place.is_file() {
                *argument = place.display().to_string();
            }
        }
        for file in &mut self.files {
            *file = folder.join(&*file);
        }
    }

    fn remove_noise(&mut self) {
        self.noise_m = 0.0;
    }

    fn add_effects(&mut self, effects: &[EffectSpec]) {
        self.effects.extend_from_slice(effects);
    }

    fn noise_m(&self) -> Option<f64> {
        Some(self.noise_m)
    }

    fn travel_m(&self) -> Option<f64> {
        Some(self.travel_m)
    }

    fn size(&self) -> Option<RobotSize> {
        let robot = &self.model.robot;
        Some(RobotSize { lever_m: robot.lever_m(), length_m: robot.backbone.length_m })
    }

    fn model(&self) -> Option<&Model> {
        Some(&self.model)
    }
}

/// The robot, while its program runs.
pub struct External {
    options: ExternalOptions,
    peer: LinePeer,
    points: Vec<String>,
    step_s: f64,
    commands_left: u64,
    noise: Generator,
}

impl External {
    /// Starts the program, or connects to it, and tells it what its robot is.
    ///
    /// # Errors
    /// [`PlantError::Server`] without an answer, [`PlantError::Refused`] for another robot than the
    /// model's.
    pub fn start(options: &ExternalOptions, step_s: f64) -> Result<External, PlantError> {
        let mut peer = match options.address {
            Some(address) => LinePeer::connect(address, options.start_s)?,
            None => LinePeer::start(&options.command)?,
        };
        let (settings, effects) = (&options.options, &options.effects);
        let hello = json!({ "hello": {
            "protocol": PROTOCOL, "step_s": step_s, "options": settings, "effects": effects,
        } });
        let answer = peer.ask(&hello, options.start_s)?;
        let robot = checked(&answer, "robot")?;
        let number = |key: &str| robot.get(key).and_then(Value::as_u64);
        let expected = [("protocol", PROTOCOL), ("tendons", options.tendons() as u64)];
        for (key, expected) in expected {
            if number(key) != Some(expected) {
                let found = robot.get(key).unwrap_or(&Value::Null);
                return Err(PlantError::Refused(format!(
                    "the robot's server has `{key}` {found}, expected {expected}"
                )));
            }
        }
        let names = robot.get("points").and_then(Value::as_array).into_iter().flatten();
        let points = names.filter_map(Value::as_str).map(str::to_owned).collect();
        Ok(External {
            options: options.clone(),
            peer,
            points,
            step_s,
            commands_left: options.max_commands.unwrap_or(u64::MAX),
            noise: Seed(0).rng(),
        })
    }

    fn observed(&mut self, request: &Value, pulls_m: Vec<f64>) -> Result<Observation, PlantError> {
        let answer = self.peer.ask(request, self.options.answer_s)?;
        let seen: Seen = Seen::deserialize(checked(&answer, "observe")?)
            .map_err(|error| PeerError::NoJson(format!("`observe`: {error}")))?;
        let (pulls_m, tendons) = (seen.pulls_m.unwrap_or(pulls_m), self.tendons());
        if pulls_m.len() != tendons {
            let found = pulls_m.len();
            let words = format!("`observe.pulls_m`: found {found} numbers, expected {tendons}");
            return Err(PeerError::NoJson(words).into());
        }
        let mut tip_m = seen.tip_m.map(|value| value.unwrap_or(f64::NAN));
        let valid = seen.valid && tip_m.iter().all(|value| value.is_finite());
        if let Ok(normal) = Normal::new(0.0, self.options.noise_m) {
            tip_m.iter_mut().for_each(|value| *value += normal.sample(&mut self.noise));
        }
        let point = |position_m: [Option<f64>; 3]| SeenPoint {
            position_m: position_m.map(|value| value.unwrap_or(f64::NAN)),
            quaternion: None,
        };
        Ok(Observation {
            time_s: seen.time_s,
            tip_m,
            tip_quaternion: seen.tip_quaternion,
            points: seen.points_m.into_iter().map(point).collect(),
            pulls_m,
            tensions_n: seen.tensions_n,
            valid,
        })
    }
}

/// What the program observes, as it is written. `null` stands for a number that was not measured.
#[derive(Deserialize)]
struct Seen {
    time_s: f64,
    tip_m: [Option<f64>; 3],
    tip_quaternion: Option<[f64; 4]>,
    #[serde(default)]
    points_m: Vec<[Option<f64>; 3]>,
    pulls_m: Option<Vec<f64>>,
    tensions_n: Option<Vec<f64>>,
    #[serde(default = "yes")]
    valid: bool,
}

fn yes() -> bool {
    true
}

/// The part `key` of an answer, unless it is an error.
fn checked<'a>(answer: &'a Value, key: &str) -> Result<&'a Value, PlantError> {
    if let Some(error) = answer.get("error") {
        let text = |key: &str| error.get(key).and_then(Value::as_str).unwrap_or_default();
        let message = printable(text("message"), 500);
        return Err(match text("kind") {
            "refused" => PlantError::Refused(message),
            "solver" => PlantError::Solver(message),
            "late" => PlantError::Late(message),
            "unseen" => PlantError::Unseen { steps: 1 },
            _ => PlantError::Stopped(message),
        });
    }
    let missing = || {
        let answer = printable(&answer.to_string(), 80);
        PeerError::NoJson(format!("an answer without `{key}`: {answer}"))
    };
    answer.get(key).ok_or_else(|| missing().into())
}

impl Plant for External {
    fn tendons(&self) -> usize {
        self.options.tendons()
    }

    fn points(&self) -> Vec<String> {
        self.points.clone()
    }

    fn tendon_layout(&self) -> TendonLayout {
        self.options.tendon_layout()
    }

    fn step_s(&self) -> f64 {
        self.step_s
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        self.noise = seed.child("tracking").rng();
        // 53 bits: other languages read larger whole numbers as floating-point ones.
        let request = json!({ "reset": { "seed": seed.0 >> 11 } });
        let home_m = vec![0.0; self.tendons()];
        self.observed(&request, home_m)
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        check_commands(commands, self.tendons(), self.options.travel_m)?;
        self.commands_left = self.commands_left.checked_sub(1).ok_or_else(|| {
            let limit = self.options.max_commands.unwrap_or_default();
            PlantError::Stopped(format!("`max_commands` {limit} is used up"))
        })?;
        let written: Vec<Option<f64>> = commands
            .iter()
            .map(|command| match *command {
                TendonCommand::Pull(pull_m) => Some(pull_m),
                TendonCommand::Follow => None,
            })
            .collect();
        let request = json!({ "command": { "pulls_m": written } });
        // What a following tendon took, the program alone knows.
        let pulls_m = commands.iter().map(|command| command.pull_m_or(f64::NAN)).collect();
        self.observed(&request, pulls_m)
    }
}

impl Drop for External {
    fn drop(&mut self) {
        self.peer.say_goodbye(&json!({ "bye": {} }));
    }
}
