//! Imitations of the motors and the tracker around a simulated robot, behind the real drivers.

use std::sync::Arc;

use crate::base::{Seed, TendonCommand};
use crate::effects::{Driven, EffectSpec, Model};
use crate::hardware::axes::AXES;
use crate::hardware::clock::Clock;
use crate::hardware::interrupt::Interrupt;
use crate::hardware::serial::SerialLine;
use crate::hardware::tracking::{Mounting, RigidPose, TrackingSettings};
use crate::simulators::{
    ControllerOptions, RehearsalClock, RunningSimulator, SimulatedController, SimulatedRobot, SimulatedTracker,
    Simulator, TrackerFault, TrackerOptions, pipe,
};

use super::options::{HardwareOptions, RehearsalOptions};

/// Speeds (mm/min) and accelerations (mm/s²) of the imitated axes: what steps of 3 mm at 5 Hz need.
const FAST: [(u16, &str); 8] = [
    (110, "3000"),
    (111, "3000"),
    (112, "3000"),
    (113, "3000"),
    (120, "500"),
    (121, "500"),
    (122, "500"),
    (123, "500"),
];

/// What a rehearsal plays on.
pub struct Rehearsal {
    // Dropped first, while its clock still runs.
    running: RunningSimulator,
    clock: Arc<dyn Clock>,
    interrupt: Interrupt,
}

impl Rehearsal {
    /// Opens the imitations and joins their clock for the calling thread, which would else go on without it: the stage, the
    /// driver's end of the serial line, and what the tracker's client has to know.
    pub(super) fn open(
        options: &HardwareOptions,
        rehearsal: &RehearsalOptions,
        seed: Seed,
    ) -> Result<(Rehearsal, Box<dyn SerialLine>, TrackingSettings), String> {
        let clock: Arc<dyn Clock> = Arc::new(RehearsalClock::new());
        // A pseudo-terminal would deliver when it pleases, which is late on a clock that does not wait for it.
        let (theirs, ours) = pipe();
        let (simulator, tracking) = build_simulator(options, rehearsal, Box::new(theirs), seed)?;
        clock.join();
        let running = RunningSimulator::start(simulator, Arc::clone(&clock)).map_err(|error| error.to_string())?;
        Ok((Rehearsal { running, clock, interrupt: Interrupt::new() }, Box::new(ours), tracking))
    }

    /// What the imitations go by.
    pub(super) fn clock(&self) -> Arc<dyn Clock> {
        Arc::clone(&self.clock)
    }

    /// A request to end this rehearsal, as Ctrl-C is one to end a program.
    pub fn interrupt(&self) -> Interrupt {
        self.interrupt.clone()
    }

    /// Does something to the imitations, such as breaking one.
    pub fn with_simulator<T>(&self, what: impl FnOnce(&mut Simulator) -> T) -> T {
        what(&mut self.running.lock())
    }
}

/// Motors at the other end of `wire`, a tracker and a robot between them, and what the tracker's client has to know.
pub(super) fn build_simulator(
    options: &HardwareOptions,
    rehearsal: &RehearsalOptions,
    serial: Box<dyn SerialLine>,
    seed: Seed,
) -> Result<(Simulator, TrackingSettings), String> {
    let mut imitated = ControllerOptions { seed: seed.0, ..ControllerOptions::default() };
    for (number, value) in FAST {
        imitated.settings.insert(number, value.to_owned());
    }
    imitated.settings.insert(23, options.motion.homing_directions.to_string());
    let controller = SimulatedController::new(serial, imitated);
    let imitated = TrackerOptions { noise_m: rehearsal.noise_m, seed, ..TrackerOptions::default() };
    let mut tracker =
        SimulatedTracker::new(imitated).map_err(|error| format!("no tracker on this computer: {error}"))?;
    let network = tracker.settings().map_err(|error| error.to_string())?;
    if rehearsal.loss > 0.0 {
        tracker.inject(TrackerFault::Loss(rehearsal.loss));
    }
    let tracking = TrackingSettings {
        up_axis: options.tracking.up_axis,
        alignment: options.tracking.alignment,
        tip_offset: options.tracking.tip_offset,
        ..network
    };
    let truth = TrackingSettings { alignment: rehearsal.alignment.unwrap_or(tracking.alignment), ..tracking.clone() };
    let mounting = Mounting::of(&truth);
    let body = RehearsalRobot::new(&rehearsal.model, &options.attached);
    let seen = Box::new(move |base: &RigidPose, tip: &RigidPose| mounting.tip_body(base, tip));
    Ok((Simulator::new(controller, tracker, Box::new(body), options.axes, seen), tracking))
}

/// A simulated robot whose tendons are moved by imitated lead screws.
struct RehearsalRobot {
    model: Model,
    attached: Vec<EffectSpec>,
    driven: Driven,
    /// Time that has passed since the robot was last moved on, s.
    waiting_s: f64,
    tip: RigidPose,
    pulls_m: [f64; AXES],
    /// How long nothing has changed, s.
    still_s: f64,
}

/// The robot is moved on in steps of this length, s: lead screws are slow against it.
const STEP_S: f64 = 0.02;
/// A robot whose tendons have stood still for so long stands as well, s.
const AT_REST_S: f64 = 2.0;

impl RehearsalRobot {
    fn new(model: &Model, attached: &[EffectSpec]) -> RehearsalRobot {
        let mut robot = RehearsalRobot {
            model: model.clone(),
            attached: attached.to_vec(),
            driven: Driven::new(model, attached),
            waiting_s: 0.0,
            tip: RigidPose::default(),
            pulls_m: [0.0; AXES],
            still_s: 0.0,
        };
        // Before homing the screws stand anywhere; the robot's first place is that of its tendons at home.
        let _ = robot.driven.home();
        robot.update_tip();
        robot
    }

    fn commands(&self) -> [TendonCommand; AXES] {
        self.pulls_m.map(TendonCommand::Pull)
    }

    fn update_tip(&mut self) {
        let seen = self.driven.observation(&self.commands(), 0.0);
        self.tip =
            RigidPose { position_m: seen.tip_m, quaternion: seen.tip_quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0]) };
    }
}

/// Beyond this the tendons are off their spools and the robot hangs as it hung, metres.
const OFF_SPOOL_M: f64 = 0.06;

impl SimulatedRobot for RehearsalRobot {
    fn advance(&mut self, pulls_m: &[f64; AXES], duration_s: f64) -> RigidPose {
        self.waiting_s += duration_s;
        if self.waiting_s < STEP_S - 1e-9 {
            return self.tip;
        }
        let moved = *pulls_m != self.pulls_m;
        self.still_s = if moved { 0.0 } else { self.still_s + self.waiting_s };
        if self.still_s < AT_REST_S && pulls_m.iter().all(|pull_m| pull_m.abs() < OFF_SPOOL_M) {
            self.pulls_m = *pulls_m;
            // A rod that finds no equilibrium stays where it was, as one that is stuck.
            if self.driven.advance(&self.commands(), self.waiting_s).is_ok() {
                self.update_tip();
            }
        }
        self.waiting_s = 0.0;
        self.tip
    }

    /// The weight is let down gently: the robot comes to rest under it at once.
    fn hang_weight(&mut self, load_kg: f64) {
        let hung = (load_kg > 0.0).then(|| EffectSpec::tip_load(load_kg));
        let all: Vec<EffectSpec> = self.attached.iter().cloned().chain(hung).collect();
        self.driven = Driven::new(&self.model, &all);
        let rests = self.driven.home().and_then(|()| self.driven.settle(&self.commands()));
        if rests.is_ok() {
            self.update_tip();
        }
        self.still_s = 0.0;
    }
}
