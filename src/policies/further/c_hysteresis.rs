//! Policy C without its chatter: the controllers of C, with a time that each stays in charge at
//! least, a second and lower threshold below which nothing is changed back, and a memory of which
//! controller did better where. The paper names chatter as C's weakness and proposes such a memory.

use crate::base::{Action, BadOption, Observation, Point3, Policy, PolicyError, distance_m};
use crate::policies::paper::a::AlgorithmTwo;
use crate::policies::paper::c::Branch;
use crate::policies::parts::actuator_limits::ActuatorLimits;
use crate::policies::parts::inverse_network::InverseNetworkController;
use crate::policies::parts::single_controller::ControlLaw;
use crate::policies::parts::tip_tracker::TipTracker;
use crate::policies::{
    Deserialize, INVERSE, INVERSE_B, ModelNeed, PolicyEntry, Serialize, SeriesLabel,
};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "c_hysteresis",
    label: SeriesLabel::text("C + hysteresis"),
    footnote: "C with dwell time, hysteresis and a memory of regions.",
    needs: &[ModelNeed::Network(&INVERSE), ModelNeed::ErrorModel, ModelNeed::Network(&INVERSE_B)],
    closed_loop_only: true,
    make: |mut parts, options| {
        let model = parts.inverse("c_hysteresis", &INVERSE)?;
        let error = parts.error("c_hysteresis")?;
        let generated = parts.inverse("c_hysteresis", &INVERSE_B)?;
        Ok(Box::new(SteadySwitch {
            options: options.c_hysteresis,
            a: AlgorithmTwo::new(model, error, options),
            b: InverseNetworkController::new(generated, options),
            tip_tracker: TipTracker::default(),
            limits: ActuatorLimits::new(options.limits),
            last_tip_m: None,
            charge: Branch::A,
            dwelt: 0,
            target_m: None,
            tried_m: [None; 2],
            memory: Vec::new(),
        }))
    },
    ..PolicyEntry::PLAIN
};

/// Options of C with hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CHysteresisOptions {
    /// At rest with an error above this, the policy switches to the other controller.
    pub switch_above_m: f64,
    /// Below this error the active controller is kept; at most `switch_above_m`.
    pub stay_below_m: f64,
    /// Minimum number of ticks with one controller, for any targets.
    pub dwell_ticks: usize,
    /// The tip is at rest when its measured motion in a tick is at most this.
    pub rest_m: f64,
    /// A target within this distance of an earlier one starts with the controller that had the
    /// smaller error there.
    pub region_m: f64,
}

impl Default for CHysteresisOptions {
    fn default() -> Self {
        CHysteresisOptions {
            switch_above_m: 0.004,
            stay_below_m: 0.002,
            dwell_ticks: 10,
            rest_m: 0.002,
            region_m: 0.02,
        }
    }
}

impl CHysteresisOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("switch_above_m", self.switch_above_m)?;
        BadOption::unless_positive("stay_below_m", self.stay_below_m)?;
        let ordered = self.stay_below_m <= self.switch_above_m;
        BadOption::unless(ordered, "stay_below_m", self.stay_below_m, "at most `switch_above_m`")?;
        BadOption::unless_counted("dwell_ticks", self.dwell_ticks)?;
        BadOption::unless_positive("rest_m", self.rest_m)?;
        BadOption::unless_positive("region_m", self.region_m)
    }
}

struct SteadySwitch {
    options: CHysteresisOptions,
    a: AlgorithmTwo,
    b: InverseNetworkController,
    tip_tracker: TipTracker,
    limits: ActuatorLimits,
    last_tip_m: Option<Point3>,
    charge: Branch,
    /// Ticks since the last change.
    dwelt: usize,
    target_m: Option<Point3>,
    /// Error at rest at this target under each controller, metres.
    tried_m: [Option<f64>; 2],
    /// Targets, and which controller did better there.
    memory: Vec<(Point3, Branch)>,
}

impl SteadySwitch {
    fn begin_target(&mut self, target_m: &Point3) {
        if self.target_m == Some(*target_m) {
            return;
        }
        self.target_m = Some(*target_m);
        self.tried_m = [None; 2];
        let near =
            |(at_m, _): &&(Point3, Branch)| distance_m(at_m, target_m) <= self.options.region_m;
        let nearby = self.memory.iter().filter(near);
        let nearest = nearby.min_by(|one, other| {
            distance_m(&one.0, target_m).total_cmp(&distance_m(&other.0, target_m))
        });
        if let Some(&(_, better)) = nearest {
            self.change_to(better);
        }
    }

    /// Changes the controller, unless the one in charge has not been there long enough.
    fn change_to(&mut self, branch: Branch) {
        if branch != self.charge && self.dwelt >= self.options.dwell_ticks {
            self.charge = branch;
            self.dwelt = 0;
        }
    }

    /// The rule at rest. Returns whether nothing is left to try.
    fn judge(&mut self, error_m: f64, target_m: &Point3) -> bool {
        self.tried_m[self.charge as usize] = Some(error_m);
        let other = self.charge.other();
        match self.tried_m[other as usize] {
            _ if error_m <= self.options.stay_below_m => self.remember(target_m, self.charge),
            None if error_m <= self.options.switch_above_m => {}
            None => {
                self.change_to(other);
                return false;
            }
            Some(other_m) if other_m < error_m - self.options.stay_below_m => {
                self.remember(target_m, other);
                self.change_to(other);
                return false;
            }
            Some(_) => self.remember(target_m, self.charge),
        }
        true
    }

    fn remember(&mut self, target_m: &Point3, better: Branch) {
        self.memory.retain(|(at_m, _)| distance_m(at_m, target_m) > 0.5 * self.options.region_m);
        self.memory.push((*target_m, better));
    }
}

impl Policy for SteadySwitch {
    fn reset(&mut self) {
        self.a.reset();
        self.b.reset();
        self.tip_tracker.reset();
        self.limits.reset();
        self.last_tip_m = None;
        self.charge = Branch::A;
        self.dwelt = 0;
        self.target_m = None;
        self.tried_m = [None; 2];
        self.memory.clear();
    }

    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError> {
        let reading = self.tip_tracker.read(seen, target_m)?;
        self.begin_target(target_m);
        let demand = [self.a.decide(reading, target_m)?, self.b.decide(reading, target_m)?];
        let mut finished = false;
        if reading.fresh {
            let moved_m =
                self.last_tip_m.map_or(f64::INFINITY, |last_m| distance_m(&last_m, &reading.tip_m));
            self.last_tip_m = Some(reading.tip_m);
            let in_charge = &demand[self.charge as usize];
            let arrived = self.limits.limit(&in_charge.pulls_m, &seen.pulls_m)?.arrived;
            if arrived && in_charge.settled && moved_m <= self.options.rest_m {
                finished = self.judge(distance_m(&reading.tip_m, target_m), target_m);
            }
        }
        self.dwelt += 1;
        let limited = self.limits.apply(&demand[self.charge as usize].pulls_m, &seen.pulls_m)?;
        Ok(Action {
            pulls_m: limited.pulls_m,
            settled: finished && limited.arrived,
            branch: self.charge.name(),
        })
    }
}
