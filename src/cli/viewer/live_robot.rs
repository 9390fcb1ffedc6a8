//! The robot of the live view: a model with effects that come and go, driven by sliders.

use serde::{Deserialize, Serialize};

use spinebench::base::{PlacedTendon, PlantError, TendonCommand, TendonLayout};
use spinebench::data::scene::{SceneFrame, SceneRobot};
use spinebench::effects::{CATALOGUE, Card, DrivenModel, EffectSpec, Model, Parameter, Seek};
use spinebench::report::scene::{LiveControl, LiveEffect, LiveParameter, LiveView};
use spinebench::tasks::{scene_frame, scene_robot, tracked_at_stations};

/// What a page asks for: all of it, each time.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(super) struct SliderState {
    /// Displacement of each drive, or tendon, metres or radians.
    pub(super) displacements: Vec<f64>,
    /// Whether the equilibrium is shown, not the motion.
    pub(super) at_rest: bool,
    /// The effects that are on.
    pub(super) effects: Vec<SwitchedEffect>,
    /// Whether the robot restarts at home.
    #[serde(default)]
    pub(super) restart: bool,
}

/// An effect that is on.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct SwitchedEffect {
    name: String,
    /// One value a parameter, in the order of the catalogue.
    values: Vec<f64>,
}

/// What a page is answered.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct LiveAnswer {
    /// The robot, where it has changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) robot: Option<SceneRobot>,
    /// Its pose, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) frame: Option<SceneFrame>,
    /// Indices of the tendons that are slack.
    pub(super) slack: Vec<usize>,
    /// Whether other tensions of rigid tendons would hold the same pose.
    pub(super) undetermined: bool,
    /// The solver's status, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) status: Option<String>,
    /// What is wrong, for the user.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) error: Option<String>,
    /// Simulated seconds a second.
    pub(super) pace: f64,
    /// Whether the robot has restarted.
    pub(super) restarted: bool,
}

/// A robot that answers sliders.
pub(super) struct LiveRobot {
    /// The model without those of its effects that have sliders.
    bare: Model,
    /// The model as shown.
    driven: DrivenModel,
    state: SliderState,
    time_s: f64,
    /// Why there is no pose now.
    failure: Option<PlantError>,
    /// Why the effects that were asked for cannot be.
    refusal: Option<String>,
    /// Whether the pose is the equilibrium under the commands.
    settled: bool,
}

/// The first displacement of a slider's end, radians of bending.
const BEND_RAD: f64 = 1.2;
/// Angles that differ by less are one, degrees.
const SAME_ANGLE_DEG: f64 = 1.0;
/// Steps of a slider.
const STEPS: f64 = 200.0;
/// Halvings between a value that is allowed and one that is not.
const HALVINGS: usize = 12;
/// First steps of a fit from null to the end of a parameter's slider.
const RANGE: f64 = 10.0;

impl LiveRobot {
    /// The robot of a checked model, at home, with what its page needs.
    pub(super) fn new(name: &str, model: &Model) -> (LiveRobot, LiveView) {
        let effects: Vec<LiveEffect> =
            CATALOGUE.iter().filter_map(|card| live_effect(card, model)).collect();
        let mut bare = model.clone();
        for effect in effects.iter().filter(|effect| effect.on) {
            if let Some(index) =
                bare.effects.iter().position(|spec| spec.card().name == effect.name)
            {
                bare.effects.remove(index);
            }
        }
        let robot = scene_robot(model);
        let driven = DrivenModel::new(&tracked_at_stations(model, &robot), &[]);
        let controls = controls(model);
        let state =
            SliderState { displacements: vec![0.0; controls.len()], ..SliderState::default() };
        let live = LiveRobot {
            bare,
            driven,
            state,
            time_s: 0.0,
            failure: None,
            refusal: None,
            settled: false,
        };
        (live, LiveView { name: name.to_owned(), robot, controls, effects })
    }

    /// Takes what the page asks for; an answer where the robot is another one, or cannot be.
    pub(super) fn ask(&mut self, asked: SliderState) -> Option<LiveAnswer> {
        if asked.displacements.len() != self.state.displacements.len() {
            self.refusal = Some("the page belongs to another model".to_owned());
            return Some(self.refused());
        }
        let rebuilds = asked.effects != self.state.effects
            || asked.restart
            || self.time_s == 0.0
            || self.failure.is_some();
        self.settled = false;
        self.state = asked;
        rebuilds.then(|| self.rebuild())
    }

    /// The robot with the effects that are on, at its start.
    fn rebuild(&mut self) -> LiveAnswer {
        let model = match self.with_effects() {
            Ok(model) => model,
            Err(words) => {
                self.refusal = Some(words);
                return self.refused();
            }
        };
        self.refusal = None;
        let robot = scene_robot(&model);
        self.driven = DrivenModel::new(&tracked_at_stations(&model, &robot), &[]);
        self.time_s = 0.0;
        self.failure = self.begin().err();
        self.state.restart = false;
        let failed = self.failure.as_ref().map(failed);
        LiveAnswer { robot: Some(robot), restarted: true, ..failed.unwrap_or_default() }
    }

    /// The answer to what cannot be: the robot stays as it was.
    fn refused(&self) -> LiveAnswer {
        LiveAnswer { error: self.refusal.clone(), ..LiveAnswer::default() }
    }

    /// Home after a restart, else at rest under the commands.
    fn begin(&mut self) -> Result<(), PlantError> {
        self.driven.home()?;
        if self.state.restart { Ok(()) } else { self.driven.settle(&self.commands()) }
    }

    /// Goes on by `step_s`; no answer where nothing moves.
    pub(super) fn step(&mut self, step_s: f64) -> Option<LiveAnswer> {
        if self.failure.is_some() || self.state.at_rest && self.settled {
            return None;
        }
        let commands = self.commands();
        let moved = if self.state.at_rest {
            self.driven.settle(&commands)
        } else {
            self.driven.advance(&commands, step_s)
        };
        self.settled = self.state.at_rest;
        self.time_s += step_s;
        Some(self.answer(moved, &commands))
    }

    fn answer(&mut self, moved: Result<(), PlantError>, commands: &[TendonCommand]) -> LiveAnswer {
        if let Err(error) = moved {
            let answer = failed(&error);
            self.failure = Some(error);
            return answer;
        }
        let split = self.driven.tension_split();
        let slack = split.slack.iter().enumerate().filter(|(_, is_slack)| **is_slack);
        let slack = slack.map(|(tendon, _)| tendon).collect();
        let mut frame = scene_frame(&self.driven.observation(commands, self.time_s));
        frame.time_s = self.time_s;
        frame.tensions_n = split.tensions_n;
        let rod = self.driven.rod();
        let facts = [
            (true, "converged"),
            (rod.contact().is_some(), ", touches an obstacle"),
            (rod.self_contact().is_some(), ", touches itself"),
        ];
        let status =
            facts.into_iter().filter(|(holds, _)| *holds).map(|(_, words)| words).collect();
        LiveAnswer {
            frame: Some(frame.rounded()),
            slack,
            undetermined: !split.is_determined,
            status: Some(status),
            error: self.refusal.clone(),
            pace: 1.0,
            ..LiveAnswer::default()
        }
    }

    /// Displacement of each tendon under those of the sliders.
    fn commands(&self) -> Vec<TendonCommand> {
        let displacements = &self.state.displacements;
        let gains = self.bare.drive_gains();
        if gains.is_empty() {
            return displacements.iter().map(|&pull| TendonCommand::Pull(pull)).collect();
        }
        let mut pulls = vec![0.0; self.bare.robot.tendons.angles_deg.len()];
        for (tendons, displacement) in gains.values().zip(displacements) {
            tendons.iter().for_each(|(tendon, gain)| pulls[*tendon] += gain * displacement);
        }
        pulls.into_iter().map(TendonCommand::Pull).collect()
    }

    /// The model with the effects that are on.
    fn with_effects(&self) -> Result<Model, String> {
        let mut model = self.bare.clone();
        for SwitchedEffect { name, values } in &self.state.effects {
            let card = spinebench::effects::card(name).ok_or(format!("unknown effect {name}"))?;
            let spec = EffectSpec::from_card(card, values)
                .ok_or_else(|| format!("{name}: a parameter is out of range"))?;
            model.effects.push(spec);
        }
        model.check().map_err(|(path, error)| format!("{path}: {error}"))?;
        Ok(model)
    }
}

/// The answer to commands without a solution.
fn failed(error: &PlantError) -> LiveAnswer {
    let words = format!(
        "No solution at this time ({error}). Tip, tensions and picture are those before. Move a \
         slider to restart from home."
    );
    LiveAnswer { status: Some(error.to_string()), error: Some(words), ..LiveAnswer::default() }
}

/// A slider for each drive, or for each tendon where the model has no drives.
fn controls(model: &Model) -> Vec<LiveControl> {
    let travel_m = BEND_RAD * model.robot.lever_m();
    if model.drives.is_empty() {
        let tendons = 1..=model.robot.tendons.angles_deg.len();
        let layout = model.robot.tendon_layout();
        let tendon = |k: usize| LiveControl {
            name: format!("tendon_{k}"),
            unit: "m",
            travel: travel_m,
            opposite: opposite(&layout, k - 1),
        };
        return tendons.map(tendon).collect();
    }
    let drive = |(name, gains): (String, Vec<(usize, f64)>)| {
        let largest = gains.iter().map(|(_, gain)| gain.abs()).fold(0.0, f64::max);
        let travel = travel_m / largest.max(f64::MIN_POSITIVE);
        // A drive of metres moves its tendons by about as much.
        let unit = if (0.2..=5.0).contains(&largest) { "m" } else { "rad" };
        LiveControl { name, unit, travel, opposite: None }
    };
    model.drive_gains().into_iter().map(drive).collect()
}

/// The tendon (from 0) that ends where this one does, on the other side of the backbone.
fn opposite(layout: &TendonLayout, tendon: usize) -> Option<usize> {
    let segment = layout.segments.iter().find(|all| all.iter().any(|one| one.tendon == tendon))?;
    let own_deg = segment.iter().find(|one| one.tendon == tendon)?.angle_deg;
    let apart_deg =
        |one: &&PlacedTendon| ((one.angle_deg - own_deg).rem_euclid(360.0) - 180.0).abs();
    segment.iter().find(|one| apart_deg(one) < SAME_ANGLE_DEG).map(|one| one.tendon)
}

/// The sliders of an effect; `None` for one that this robot cannot have.
fn live_effect(card: &'static Card, model: &Model) -> Option<LiveEffect> {
    let given = model.effects.iter().find(|spec| spec.card().name == card.name);
    let given = given.map(|spec| serde_json::to_value(spec).unwrap_or_default());
    let first: Vec<f64> = card.parameters.iter().map(|one| first_value(one, model)).collect();
    let fits = |values: &[f64]| {
        EffectSpec::from_card(card, values)
            .is_some_and(|spec| Model { effects: vec![spec], ..model.clone() }.check().is_ok())
    };
    if !fits(&first) && given.is_none() {
        return None;
    }
    let parameter = |(index, parameter): (usize, &Parameter)| {
        let value = given
            .as_ref()
            .and_then(|given| given_value(&given[card.name], parameter.name))
            .unwrap_or(first[index]);
        let allowed = |candidate: f64| {
            let mut values = first.clone();
            values[index] = candidate;
            fits(&values)
        };
        let [low, high] = range(parameter, model, first[index])
            .map(|end| furthest_allowed(first[index], end, &allowed));
        let whole =
            matches!(parameter.seek, Seek::Tendon | Seek::Segment | Seek::Flag | Seek::Convention);
        LiveParameter {
            name: parameter.name.to_owned(),
            unit: parameter.unit.to_owned(),
            low: low.min(value),
            high: high.max(value),
            step: if whole { 1.0 } else { (high - low) / STEPS },
            value,
        }
    };
    Some(LiveEffect {
        name: card.name.to_owned(),
        missing: card.missing.to_owned(),
        on: given.is_some(),
        parameters: card.parameters.iter().enumerate().map(parameter).collect(),
    })
}

/// `end`, or the place nearest to it that is allowed, seen from a place that is.
fn furthest_allowed(allowed_place: f64, end: f64, allowed: &dyn Fn(f64) -> bool) -> f64 {
    if allowed(end) {
        return end;
    }
    let (mut inside, mut outside) = (allowed_place, end);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (inside + outside);
        *(if allowed(middle) { &mut inside } else { &mut outside }) = middle;
    }
    inside
}

/// Number of a model's effect.
fn given_value(effect: &serde_json::Value, name: &str) -> Option<f64> {
    let value = match name.split_once('[') {
        Some((vector, index)) => {
            &effect[vector][index.trim_end_matches(']').parse::<usize>().ok()?]
        }
        None => &effect[name],
    };
    value.as_f64().or_else(|| value.as_bool().map(f64::from))
}

/// Where a slider begins: a size that can be seen, and a place on the robot.
fn first_value(parameter: &Parameter, model: &Model) -> f64 {
    match parameter.seek {
        Seek::Size(step) => parameter.null + 2.0 * step,
        Seek::Scanned(_, values) | Seek::Shape(values) => values[values.len() / 2],
        Seek::Replaces(_, step) => step,
        Seek::Place => 0.5 * model.robot.backbone.length_m,
        // A surface beside the robot.
        Seek::Distance(_) => 0.15 * model.robot.backbone.length_m,
        Seek::Located(_) if parameter.unit == "m" => 0.7 * model.robot.backbone.length_m,
        Seek::Located(_) => 0.0,
        Seek::Tendon => 1.0,
        Seek::Segment | Seek::Flag | Seek::Convention => parameter.null,
    }
}

/// Ends of a slider.
fn range(parameter: &Parameter, model: &Model, first: f64) -> [f64; 2] {
    let length_m = model.robot.backbone.length_m;
    let layout = model.robot.tendon_layout();
    match parameter.seek {
        Seek::Size(step) => {
            let reach = RANGE * step.abs();
            [parameter.null - reach, parameter.null + reach]
        }
        Seek::Scanned(_, values) | Seek::Shape(values) => {
            [0.0, 2.0 * values.iter().copied().fold(first, f64::max)]
        }
        Seek::Replaces(_, step) => [0.0, RANGE * step],
        Seek::Place => [0.0, length_m],
        Seek::Distance(_) => [0.05 * length_m, length_m],
        Seek::Located(_) if parameter.unit == "rad" => {
            [-std::f64::consts::PI, std::f64::consts::PI]
        }
        Seek::Located(_) if parameter.unit == "m" => [0.0, length_m],
        Seek::Located(step) => [0.0, RANGE * step],
        Seek::Tendon => [1.0, layout.segments.iter().map(Vec::len).sum::<usize>() as f64],
        Seek::Segment => [parameter.null, layout.segments.len() as f64],
        Seek::Flag | Seek::Convention => [0.0, 1.0],
    }
}
