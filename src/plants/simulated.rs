//! The simulated robot: the Cosserat rod with the effects of a model on it, measured by a noisy
//! tracker.

use std::collections::BTreeMap;

use rand_distr::{Distribution, Normal};
use serde::{Deserialize, Serialize};

use super::{PlantOptions, RobotSize, check_commands};
use crate::base::{
    BadOption, Generator, Observation, Plant, PlantError, Seed, TendonCommand, TendonLayout,
};
use crate::effects::{DriveGains, DrivenModel, EffectSpec, Model, Robot, Variable, VariationError};
use crate::rod::{PoseRates, Rod, RodParams, TipWrench};

/// Settings of a simulated robot besides its model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SimulatedOptions {
    /// Duration of one control step, s.
    pub step_s: f64,
    /// Standard deviation of the tracking noise per axis, metres.
    pub noise_m: f64,
    /// Commands beyond this displacement are refused, metres.
    pub travel_m: f64,
}

impl Default for SimulatedOptions {
    fn default() -> Self {
        SimulatedOptions { step_s: 0.2, noise_m: 0.0, travel_m: 0.06 }
    }
}

impl SimulatedOptions {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("step_s", self.step_s)?;
        BadOption::unless_positive("travel_m", self.travel_m)?;
        BadOption::unless_not_negative("noise_m", self.noise_m)
    }
}

/// A simulated robot as a spec gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulatedSpec {
    /// The model; in a spec, the name of a model file.
    pub model: Model,
    /// Standard deviation of the tracking noise per axis, metres.
    #[serde(default)]
    pub noise_m: f64,
    /// Commands beyond this displacement are refused, metres.
    #[serde(default = "travel_m")]
    pub travel_m: f64,
}

/// Tracking noise above this indicates a wrong unit, metres.
const MAX_NOISE_M: f64 = 0.05;

fn travel_m() -> f64 {
    SimulatedOptions::default().travel_m
}

impl SimulatedSpec {
    /// A robot that follows a model, measured with this noise in metres.
    pub fn new(model: Model, noise_m: f64) -> SimulatedSpec {
        SimulatedSpec { model, noise_m, travel_m: travel_m() }
    }

    fn options(&self, step_s: f64) -> SimulatedOptions {
        SimulatedOptions { step_s, noise_m: self.noise_m, travel_m: self.travel_m }
    }
}

impl PlantOptions for SimulatedSpec {
    const MODEL_KEYS: &'static [&'static str] = &["model"];
    const TAKES_EFFECTS: bool = true;

    fn check(&self) -> Result<(), (String, BadOption)> {
        self.options(1.0).check().map_err(|error| (String::new(), error))?;
        if self.noise_m > MAX_NOISE_M {
            let found =
                format!("{} (if that is in mm, write {} m)", self.noise_m, self.noise_m * 1e-3);
            let expected = "0 to 0.05, in metres of tracking noise";
            return Err((String::new(), BadOption { key: "noise_m", found, expected }));
        }
        self.model.check_written("model")
    }

    fn tendons(&self) -> usize {
        self.model.robot.tendons.angles_deg.len()
    }

    fn tendon_layout(&self) -> TendonLayout {
        self.model.robot.tendon_layout()
    }

    fn drive_gains(&self) -> BTreeMap<String, DriveGains> {
        self.model.drive_gains()
    }

    fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        Ok(Box::new(Simulated::new(&self.model, &[], self.options(step_s))))
    }

    fn remove_noise(&mut self) {
        self.noise_m = 0.0;
    }

    fn add_effects(&mut self, effects: &[EffectSpec]) {
        self.model.effects.extend_from_slice(effects);
    }

    fn noise_m(&self) -> Option<f64> {
        Some(self.noise_m)
    }

    fn travel_m(&self) -> Option<f64> {
        Some(self.travel_m)
    }

    fn may_be_paper_robot(&self) -> bool {
        let (robot, paper) = (&self.model.robot, Robot::default());
        robot.backbone.length_m == paper.backbone.length_m
            && robot.tendons.radius_m == paper.tendons.radius_m
            && robot.tendons.angles_deg == paper.tendons.angles_deg
    }

    fn size(&self) -> Option<RobotSize> {
        let robot = &self.model.robot;
        Some(RobotSize { lever_m: robot.lever_m(), length_m: robot.backbone.length_m })
    }

    fn model(&self) -> Option<&Model> {
        Some(&self.model)
    }

    fn example() -> Option<Self> {
        Some(SimulatedSpec::new(Model::default(), 0.0))
    }
}

/// A Cosserat rod as a [`Plant`].
pub struct Simulated {
    driven: DrivenModel,
    options: SimulatedOptions,
    time_s: f64,
    noise: Generator,
    /// Apart from that of the tip, which does not depend on what else is tracked.
    point_noise: Generator,
    /// Names of the tracked points.
    points: Vec<String>,
    layout: TendonLayout,
}

impl Simulated {
    /// A robot that follows a checked model, with `extra` effects (such as a load for some trials)
    /// on top.
    pub fn new(model: &Model, extra: &[EffectSpec], options: SimulatedOptions) -> Simulated {
        Simulated::of(DrivenModel::new(model, extra), model, options)
    }

    /// The same, with derivatives of the tip with respect to those of `variables` that have them,
    /// and the numbers (from 0) of the others.
    ///
    /// # Errors
    /// [`VariationError`] for a variable that there is not.
    pub fn varied_where_possible(
        model: &Model,
        extra: &[EffectSpec],
        options: SimulatedOptions,
        variables: &[Variable],
    ) -> Result<(Simulated, Vec<usize>), VariationError> {
        let (driven, left_out) = DrivenModel::varied_where_possible(model, extra, variables)?;
        Ok((Simulated::of(driven, model, options), left_out))
    }

    fn of(driven: DrivenModel, model: &Model, options: SimulatedOptions) -> Simulated {
        let [noise, point_noise] = [Seed(0).rng(), Seed(0).rng()];
        Simulated {
            driven,
            options,
            time_s: 0.0,
            noise,
            point_noise,
            points: model.tracking.names(),
            layout: model.robot.tendon_layout(),
        }
    }

    /// The rod itself, for its shape, tensions and energy.
    pub fn rod(&self) -> &Rod {
        self.driven.rod()
    }

    /// Derivatives of the measured tip and of the tracked points with respect to each variable, per
    /// unit of it.
    pub fn pose_rates(&self) -> Vec<PoseRates> {
        self.driven.pose_rates()
    }

    /// Displacements of the model's drives in the next commands; see
    /// [`DrivenModel::set_drive_displacements`].
    pub fn set_drive_displacements(&mut self, displacements: Vec<f64>) {
        self.driven.set_drive_displacements(displacements);
    }

    /// Adds a load at the tip to that of the model, from now on.
    pub fn set_extra_tip_load(&mut self, extra: TipWrench) {
        self.driven.set_extra_tip_load(&|_| extra);
    }

    /// The same with a load that depends on the rod, such as on its gravity.
    pub fn set_extra_tip_load_of(&mut self, load: &dyn Fn(&RodParams) -> TipWrench) {
        self.driven.set_extra_tip_load(load);
    }

    /// Straight, without history, tendons slack: the start of a trial that is driven by tensions.
    pub fn reset_slack(&mut self, seed: Seed) {
        self.begin_trial(seed);
        self.driven.restart();
    }

    /// The same for a trial that does not start at home: the next command is the trial's first one.
    pub fn reset_away(&mut self, seed: Seed) {
        self.begin_trial(seed);
        self.driven.restart_away();
    }

    /// Starts the clock and the noise of a trial and leaves the robot as it is.
    pub fn begin_trial(&mut self, seed: Seed) {
        self.noise = seed.child("tracking").rng();
        self.point_noise = seed.child("tracked_points").rng();
        self.time_s = 0.0;
    }

    /// Counts the next command as the trial's first one again, after the robot has settled under
    /// it.
    pub fn restart_count(&mut self) {
        self.driven.restart_count();
    }

    /// Brings the robot to rest under `commands` instead of at home.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn settle(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        check_commands(commands, self.tendons(), self.options.travel_m)?;
        self.driven.settle(commands)?;
        Ok(self.observe(commands))
    }

    /// What the tracker sees now; a following tendon is reported where its drive is.
    pub fn seen(&mut self) -> Observation {
        self.observe(&vec![TendonCommand::Follow; self.tendons()])
    }

    /// Puts the tendons under tensions in newtons for one step, or at rest for good when `settled`.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn apply_tensions(
        &mut self,
        tensions_n: &[f64],
        settled: bool,
    ) -> Result<Observation, PlantError> {
        if settled {
            self.driven.settle_under(tensions_n)?;
        } else {
            self.driven.advance_under(tensions_n, self.options.step_s)?;
            self.time_s += self.options.step_s;
        }
        Ok(self.seen())
    }

    /// Sets the duration of the next steps, s.
    pub fn set_step_s(&mut self, step_s: f64) {
        self.options.step_s = step_s;
    }

    fn observe(&mut self, commands: &[TendonCommand]) -> Observation {
        let mut observation = self.driven.observation(commands, self.time_s);
        if let Ok(normal) = Normal::new(0.0, self.options.noise_m) {
            observation.tip_m.iter_mut().for_each(|value| *value += normal.sample(&mut self.noise));
            let positions = observation.points.iter_mut().flat_map(|point| &mut point.position_m);
            positions.for_each(|value| *value += normal.sample(&mut self.point_noise));
        }
        observation
    }
}

impl Plant for Simulated {
    fn tendons(&self) -> usize {
        self.rod().params().tendons.len()
    }

    fn tendon_layout(&self) -> TendonLayout {
        self.layout.clone()
    }

    fn points(&self) -> Vec<String> {
        self.points.clone()
    }

    fn step_s(&self) -> f64 {
        self.options.step_s
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        self.reset_slack(seed);
        self.settle(&vec![TendonCommand::Pull(0.0); self.tendons()])
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        check_commands(commands, self.tendons(), self.options.travel_m)?;
        self.driven.advance(commands, self.options.step_s)?;
        self.time_s += self.options.step_s;
        Ok(self.observe(commands))
    }
}
