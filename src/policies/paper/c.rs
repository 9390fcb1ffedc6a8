//! Policy C (section IV-F, Fig. 7c): A, with "the correction from control policy B when position
//! error is large".
//!
//! Both controllers watch every tick, so that the memories of both networks know what the robot
//! did; one of them gives the command. A stretch under one controller is a leg. A leg ends when its
//! controller has settled and, if the error is above e_c, the tip has come to rest (or the leg's
//! budget is spent); then [`SwitchingController::judge`] decides. It cannot go on for ever: each
//! target allows a bounded number of changes, and a change that would not alter the command (L_A ≈
//! L_B) is not made.

use super::a::AlgorithmTwo;
use crate::base::{Action, BadOption, Observation, Point3, Policy, PolicyError, distance_m};
use crate::policies::parts::actuator_limits::{ActuatorLimits, largest_change_m};
use crate::policies::parts::inverse_network::InverseNetworkController;
use crate::policies::parts::single_controller::{ControlLaw, Demand};
use crate::policies::parts::tip_tracker::TipTracker;
use crate::policies::{
    Deserialize, INVERSE, INVERSE_B, ModelNeed, PolicyEntry, Serialize, SeriesLabel,
};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "c",
    label: SeriesLabel::text("C"),
    needs: &[ModelNeed::Network(&INVERSE), ModelNeed::ErrorModel, ModelNeed::Network(&INVERSE_B)],
    closed_loop_only: true,
    make: |mut parts, options| {
        let model = parts.inverse("c", &INVERSE)?;
        let error = parts.error("c")?;
        let generated = parts.inverse("c", &INVERSE_B)?;
        Ok(Box::new(SwitchingController {
            options: options.c,
            a: AlgorithmTwo::new(model, error, options),
            b: InverseNetworkController::new(generated, options),
            tip_tracker: TipTracker::default(),
            limits: ActuatorLimits::new(options.limits),
            last_tip_m: None,
            branch: Branch::A,
            leg: ControllerLeg::default(),
        }))
    },
    ..PolicyEntry::PLAIN
};

/// Time at which C compares the error with e_c.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum SwitchCheck {
    /// At the end of a leg ("the final position tracking error").
    #[default]
    Final,
    /// At every tick: B while the error is above e_c, else A.
    EveryTick,
}

/// First controller at a new target.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum StartBranch {
    /// A ("mainly relies on control policy A").
    #[default]
    A,
    /// The controller of the last command.
    Last,
}

/// Behaviour if both controllers ended a leg at this target with an error above e_c.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum AfterBoth {
    /// Use the controller with the smaller error.
    #[default]
    Better,
    /// Keep the active controller.
    Stay,
    /// Alternate until the permitted switches are used.
    Alternate,
}

/// Choices about C that the paper does not specify.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct COptions {
    /// e_c: above this error the policy switches to the other controller; the paper's 0.015 m.
    pub switch_threshold_m: f64,
    /// The check on L_A and L_B: no switch if they differ by at most this in every tendon.
    pub same_command_m: f64,
    /// The tip is at rest when its measured motion in one tick is at most this.
    pub rest_m: f64,
    /// Ticks after which a leg ends even if its controller has not settled.
    pub leg_ticks: usize,
    /// Permitted number of switches at one target.
    pub max_switches: usize,
    /// When the error is compared with e_c.
    pub check: SwitchCheck,
    /// First controller at a new target.
    pub start: StartBranch,
    /// Behaviour if neither controller reached e_c.
    pub after_both: AfterBoth,
}

impl Default for COptions {
    fn default() -> Self {
        COptions {
            switch_threshold_m: 0.015,
            // About 1 mm at the tip.
            same_command_m: 0.0002,
            // In 95 % of ticks the noise of a resting tip is below it.
            rest_m: 0.002,
            leg_ticks: 40,
            // Two tries tell all that a third could (docs/method/decisions.md).
            max_switches: 2,
            check: SwitchCheck::Final,
            start: StartBranch::A,
            after_both: AfterBoth::Better,
        }
    }
}

impl COptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("switch_threshold_m", self.switch_threshold_m)?;
        BadOption::unless_positive("same_command_m", self.same_command_m)?;
        BadOption::unless_positive("rest_m", self.rest_m)?;
        BadOption::unless_counted("leg_ticks", self.leg_ticks)
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Branch {
    A,
    B,
}

impl Branch {
    pub(crate) fn other(self) -> Branch {
        match self {
            Branch::A => Branch::B,
            Branch::B => Branch::A,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Branch::A => "a",
            Branch::B => "b",
        }
    }
}

/// What has happened at the present target.
#[derive(Default)]
struct ControllerLeg {
    target_m: Option<Point3>,
    ticks: usize,
    switches: usize,
    /// Error at the end of the last leg under A and under B, metres.
    ended_m: [Option<f64>; 2],
    /// As of the last measurement there is no reason to change.
    finished: bool,
}

struct SwitchingController {
    options: COptions,
    a: AlgorithmTwo,
    b: InverseNetworkController,
    tip_tracker: TipTracker,
    limits: ActuatorLimits,
    last_tip_m: Option<Point3>,
    branch: Branch,
    leg: ControllerLeg,
}

impl SwitchingController {
    fn begin_target(&mut self, target_m: &Point3) {
        if self.leg.target_m == Some(*target_m) {
            return;
        }
        self.leg = ControllerLeg { target_m: Some(*target_m), ..ControllerLeg::default() };
        if self.options.start == StartBranch::A {
            self.branch = Branch::A;
        }
    }

    fn switch(&mut self) {
        self.branch = self.branch.other();
        self.leg.switches += 1;
        self.leg.ticks = 0;
    }

    /// The rule at the end of a leg: stay (and be done with this target) or change.
    fn judge(&mut self, error_m: f64, same_command: bool) {
        self.leg.ended_m[self.branch as usize] = Some(error_m);
        let change = error_m > self.options.switch_threshold_m
            && !same_command
            && self.leg.switches < self.options.max_switches
            && match (self.leg.ended_m[self.branch.other() as usize], self.options.after_both) {
                (None, _) | (_, AfterBoth::Alternate) => true,
                (Some(_), AfterBoth::Stay) => false,
                (Some(other_m), AfterBoth::Better) => other_m < error_m,
            };
        if change { self.switch() } else { self.leg.finished = true }
    }

    /// Decides who gives this tick's command. `settled` is of the controller in charge,
    /// `same_command` of both.
    fn choose(&mut self, error_m: f64, at_rest: bool, settled: bool, same_command: bool) {
        match self.options.check {
            SwitchCheck::Final => {
                let near = error_m <= self.options.switch_threshold_m;
                if (settled && (near || at_rest)) || self.leg.ticks >= self.options.leg_ticks {
                    self.judge(error_m, same_command);
                }
            }
            SwitchCheck::EveryTick => {
                let due =
                    if error_m > self.options.switch_threshold_m { Branch::B } else { Branch::A };
                if due != self.branch
                    && !same_command
                    && self.leg.switches < self.options.max_switches
                {
                    self.switch();
                } else if settled && at_rest {
                    self.leg.finished = true;
                }
            }
        }
    }
}

impl Policy for SwitchingController {
    fn reset(&mut self) {
        self.a.reset();
        self.b.reset();
        self.tip_tracker.reset();
        self.limits.reset();
        self.last_tip_m = None;
        self.branch = Branch::A;
        self.leg = ControllerLeg::default();
    }

    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError> {
        let reading = self.tip_tracker.read(seen, target_m)?;
        self.begin_target(target_m);
        let demand = [self.a.decide(reading, target_m)?, self.b.decide(reading, target_m)?];
        // Nothing new was measured: neither the error nor the rest can be judged.
        if reading.fresh {
            let moved_m =
                self.last_tip_m.map_or(f64::INFINITY, |last_m| distance_m(&last_m, &reading.tip_m));
            self.last_tip_m = Some(reading.tip_m);
            let [of_a, of_b] = &demand;
            let same_command =
                largest_change_m(&of_a.pulls_m, &of_b.pulls_m) <= self.options.same_command_m;
            let Demand { pulls_m, settled } = &demand[self.branch as usize];
            let settled = *settled && self.limits.limit(pulls_m, &seen.pulls_m)?.arrived;
            let error_m = distance_m(&reading.tip_m, target_m);
            self.leg.finished = false;
            self.choose(error_m, moved_m <= self.options.rest_m, settled, same_command);
        }
        self.leg.ticks += 1;
        let chosen = &demand[self.branch as usize];
        let limited = self.limits.apply(&chosen.pulls_m, &seen.pulls_m)?;
        let settled = self.leg.finished && limited.arrived;
        Ok(Action { pulls_m: limited.pulls_m, settled, branch: self.branch.name() })
    }
}
