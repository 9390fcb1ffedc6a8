//! Receding horizon on the nominal rod: the disturbance estimate and the Gaussian process say where
//! the robot differs from the rod, Gauss-Newton steps on the rod's derivatives find the bend at the
//! target, and the horizon plans the moves to it.
//!
//! The rod is taken at rest: it is damped within a few hundredths of a second, a tick lasts a fifth
//! of one. What it has not settled of a move counts as noise of the measurement
//! ([`DisturbanceOptions::lag_per_motion`]).

use nalgebra::DMatrix;

use crate::base::{BadOption, Point3, PolicyError, distance_m};
use crate::policies::parts::actuator_limits::{LimitOptions, largest_change_m};
use crate::policies::parts::disturbance::{DisturbanceFilter, DisturbanceOptions};
use crate::policies::parts::horizon::first_move_m;
use crate::policies::parts::rest_model::{ExpectedPose, InversePose, RestModel};
use crate::policies::parts::single_controller::{ControlLaw, Demand, SingleController};
use crate::policies::parts::tip_tracker::TipReading;
use crate::policies::{
    Deserialize, ModelAccess, ModelNeed, PolicyEntry, PolicyOptions, Serialize, SeriesLabel,
};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "mpc",
    label: SeriesLabel::text("MPC"),
    footnote: "receding horizon on the nominal rod with the Gaussian process.",
    needs: &[ModelNeed::ErrorModel],
    model: ModelAccess::AtRest,
    make: |mut parts, options| {
        let error = Some(parts.error("mpc")?);
        let (travel_m, slack_m) = (options.limits.travel_m, options.mpc.slack_m);
        let model =
            RestModel::new(parts.tip_model("mpc")?, error, parts.layout("mpc")?, travel_m, slack_m);
        Ok(Box::new(SingleController::new(
            RecedingHorizon::new(model, options.mpc, options),
            "",
            options,
        )))
    },
    ..PolicyEntry::PLAIN
};

/// Options of the receding horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MpcOptions {
    /// Ticks that are planned, 1 to 50.
    pub horizon: usize,
    /// Weight of a move's square beside that of the tip's error, metres of tip for each metre of
    /// bend, squared.
    pub move_weight: f64,
    /// Gauss-Newton steps of the inverse in a tick, 1 to 50; the first tick at a target takes four
    /// times as many.
    pub inverse_steps: usize,
    /// Additional release of a following tendon compared with the model, so that it stays slack if
    /// the robot differs.
    pub slack_m: f64,
    /// How the disturbance is estimated.
    pub disturbance: DisturbanceOptions,
    /// The policy has settled when no component of the bend is farther than this from the bend at
    /// the target, metres,
    pub settled_pull_m: f64,
    /// and the standard deviation of the disturbance is no larger than this, metres.
    pub settled_sd_m: f64,
}

impl Default for MpcOptions {
    fn default() -> Self {
        MpcOptions {
            horizon: 10,
            move_weight: 1.0,
            inverse_steps: 3,
            slack_m: 0.003,
            disturbance: DisturbanceOptions::default(),
            settled_pull_m: 0.0002,
            settled_sd_m: 0.0003,
        }
    }
}

impl MpcOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_within("horizon", self.horizon, 1..=50, "a whole number from 1 to 50")?;
        BadOption::unless_not_negative("move_weight", self.move_weight)?;
        BadOption::unless_within(
            "inverse_steps",
            self.inverse_steps,
            1..=50,
            "a whole number from 1 to 50",
        )?;
        BadOption::unless_not_negative("slack_m", self.slack_m)?;
        self.disturbance.check()?;
        BadOption::unless_positive("settled_pull_m", self.settled_pull_m)?;
        BadOption::unless_positive("settled_sd_m", self.settled_sd_m)
    }
}

/// Steps of the inverse at a new target, in those of a tick.
const STEPS_AT_NEW_TARGET: usize = 4;
/// Largest gain of the disturbance where model and robot may swing: slower than their swings.
const MAX_GAIN_IN_MOTION: f64 = 0.2;
/// Displacements of a plan beyond this many travels are none that the drives come near to.
const MAX_TRAVELS: f64 = 1.5;
/// Evaluations of the model to find the move that takes the drive to its limit.
const MAX_SCALINGS: usize = 4;
/// Share of the limit that is as good as the limit.
const MIN_SHARE_OF_LIMIT: f64 = 0.96;
/// Bends that differ by less are the same, metres.
const BEND_TOLERANCE_M: f64 = 1e-9;

/// The controller with its state between ticks.
pub(crate) struct RecedingHorizon {
    model: RestModel,
    options: MpcOptions,
    limits: LimitOptions,
    disturbance: DisturbanceFilter,
    /// What is expected under the command in force; nothing before the first tick.
    in_force: Option<ExpectedPose>,
    /// Where the tip was expected at the last tick.
    before_m: Option<Point3>,
    /// When the tip was last measured, seconds.
    measured_s: f64,
    /// The bend at the target, as of the last tick.
    goal: Option<(Point3, ExpectedPose)>,
}

impl RecedingHorizon {
    pub(crate) fn new(
        model: RestModel,
        options: MpcOptions,
        all: &PolicyOptions,
    ) -> RecedingHorizon {
        let disturbance = DisturbanceFilter::new(options.disturbance);
        let disturbance = if model.takes_displacements() {
            disturbance.with_max_gain(MAX_GAIN_IN_MOTION)
        } else {
            disturbance
        };
        RecedingHorizon {
            model,
            options,
            limits: all.limits,
            disturbance,
            in_force: None,
            before_m: None,
            measured_s: 0.0,
            goal: None,
        }
    }

    /// The pose at the target, with the present disturbance.
    fn goal(
        &mut self,
        in_force: &ExpectedPose,
        target_m: &Point3,
    ) -> Result<ExpectedPose, PolicyError> {
        let offset_m = self.disturbance.offset_m;
        let aim_m: Point3 = std::array::from_fn(|axis| target_m[axis] - offset_m[axis]);
        let (from, same_target) = match self.goal.take() {
            Some((last_m, goal)) => (goal, last_m == *target_m),
            None => (in_force.clone(), false),
        };
        let steps = if same_target { 1 } else { STEPS_AT_NEW_TARGET } * self.options.inverse_steps;
        let InversePose { pose: goal, lost } = self.model.inverse(from, &aim_m, steps);
        if lost && !same_target {
            return Err(PolicyError::PlanFailed(
                "the model has no equilibrium on the path to the target".to_owned(),
            ));
        }
        let farthest_m =
            goal.pulls_m.iter().fold(0.0_f64, |most_m, pull_m| most_m.max(pull_m.abs()));
        if farthest_m > MAX_TRAVELS * self.limits.travel_m {
            return Err(PolicyError::PlanFailed(format!(
                "the plan displaces a tendon by {:.4} m, expected at most {:.4} m, {MAX_TRAVELS} \
                 times the travel",
                farthest_m,
                MAX_TRAVELS * self.limits.travel_m
            )));
        }
        self.goal = Some((*target_m, goal.clone()));
        Ok(goal)
    }

    /// The pose at home and its tip, where a trial begins.
    fn home(&mut self) -> Result<(ExpectedPose, Point3), PolicyError> {
        let straight_m = vec![0.0; self.model.bends()];
        let mut home = self.model.expect(&straight_m).ok_or_else(|| {
            PolicyError::PlanFailed("the model has no equilibrium at home".to_owned())
        })?;
        // The drives stand at zero, where the model's tendons follow without tension.
        home.pulls_m.fill(0.0);
        let expected_m = self.follow(&home, f64::INFINITY)?;
        Ok((home, expected_m))
    }

    /// Where the tip is expected after this command for `duration_s` seconds.
    fn follow(&mut self, pose: &ExpectedPose, duration_s: f64) -> Result<Point3, PolicyError> {
        self.model.follow(pose, duration_s).ok_or_else(|| {
            PolicyError::PlanFailed(
                "the model does not follow the commands of the robot".to_owned(),
            )
        })
    }

    /// How much a change of each component of the bend counts, and with another one.
    fn metric(&self, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
        // The bend counts by what it moves of the tip at the goal.
        let metric = jacobian.transpose() * jacobian;
        if !self.model.takes_displacements() {
            return metric;
        }
        // Displacements that leave the tip where it is to first order are carried out, too.
        let count = metric.nrows();
        let mean = metric.trace() / count as f64;
        metric + mean * DMatrix::identity(count, count)
    }

    /// The pose after the first move towards `goal`. A move that the drive limits takes the fastest
    /// tendon as far as the drive does in a tick, but no component of the bend past the goal.
    fn next(&mut self, in_force: &ExpectedPose, goal: &ExpectedPose) -> ExpectedPose {
        let MpcOptions { horizon, move_weight, .. } = self.options;
        let step_m = self.limits.max_step_m.unwrap_or(2.0 * self.limits.travel_m);
        let Some(jacobian) = self.model.jacobian(&goal.bend_m) else { return goal.clone() };
        let metric = self.metric(&jacobian);
        let remaining_m: Vec<f64> =
            goal.bend_m.iter().zip(&in_force.bend_m).map(|(to, from)| to - from).collect();
        let mut change_m = first_move_m(&metric, &remaining_m, horizon, move_weight, step_m);
        let limited = change_m.iter().any(|change_m| change_m.abs() >= step_m);
        let mut next = in_force.clone();
        for _ in 0..MAX_SCALINGS {
            let bend_m: Vec<f64> =
                in_force.bend_m.iter().zip(&change_m).map(|(from, change)| from + change).collect();
            let Some(pose) = self.model.expect(&bend_m) else {
                // No equilibrium there: half the way.
                change_m.iter_mut().for_each(|change_m| *change_m *= 0.5);
                continue;
            };
            let largest_m = largest_change_m(&in_force.pulls_m, &pose.pulls_m);
            let at_goal = bend_m
                .iter()
                .zip(&goal.bend_m)
                .all(|(bend, goal)| (bend - goal).abs() <= BEND_TOLERANCE_M);
            next = pose;
            if largest_m <= step_m
                && (!limited || at_goal || largest_m >= MIN_SHARE_OF_LIMIT * step_m)
            {
                break;
            }
            // Into the middle of the accepted band: pulls are not linear in the bend.
            let share = 0.5 * (1.0 + MIN_SHARE_OF_LIMIT) * step_m / largest_m;
            for (change_m, remaining_m) in change_m.iter_mut().zip(&remaining_m) {
                *change_m = (share * *change_m).clamp(-remaining_m.abs(), remaining_m.abs());
            }
        }
        next
    }
}

impl ControlLaw for RecedingHorizon {
    fn reset(&mut self) {
        self.model.restart();
        self.disturbance.reset();
        self.in_force = None;
        self.before_m = None;
        self.goal = None;
    }

    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        let (in_force, expected_m) = match self.in_force.take() {
            Some(in_force) if reading.fresh => {
                let expected_m = self.follow(&in_force, reading.time_s - self.measured_s)?;
                (in_force, expected_m)
            }
            Some(in_force) => {
                let expected_m = in_force.tip_m;
                (in_force, expected_m)
            }
            None => self.home()?,
        };
        if let Some(before_m) = self.before_m.filter(|_| reading.fresh) {
            let moved_m = distance_m(&before_m, &expected_m);
            self.model.let_out();
            self.disturbance.measured(&reading.tip_m, &expected_m, moved_m);
        }
        self.measured_s = reading.time_s;
        let goal = self.goal(&in_force, target_m)?;
        let next = self.next(&in_force, &goal);
        let moved_m = largest_change_m(&in_force.bend_m, &goal.bend_m);
        let disturbance_settled =
            !reading.fresh || self.disturbance.sd_m() <= self.options.settled_sd_m;
        let settled = moved_m <= self.options.settled_pull_m && disturbance_settled;
        let pulls_m = next.pulls_m.clone();
        self.before_m = Some(expected_m);
        self.in_force = Some(next);
        Ok(Demand { pulls_m, settled })
    }
}
