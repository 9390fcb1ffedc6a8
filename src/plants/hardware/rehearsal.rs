//! A rehearsal: simulators of the motors and the tracker around a simulated robot, behind the real
//! drivers.

use std::sync::Arc;

use crate::base::{Seed, TendonCommand};
use crate::effects::{DrivenModel, EffectSpec, Model};
use crate::hardware::axes::AXES;
use crate::hardware::clock::Clock;
use crate::hardware::interrupt::Interrupt;
use crate::hardware::rig::min_acceleration_mm_s2;
use crate::hardware::serial::SerialLine;
use crate::hardware::tracking::{Mounting, RigidPose, TrackingSettings};
use crate::simulators::{
    ControllerOptions, RehearsalClock, RunningSimulator, SimulatedController, SimulatedRobot,
    SimulatedTracker, Simulator, TrackerFault, TrackerOptions, pipe,
};

use super::options::{HardwareOptions, RehearsalOptions};

/// Speed (mm/min) of the simulated axes.
const AXIS_SPEED_MM_MIN: f64 = 3000.0;
/// Acceleration (mm/s²) of the simulated axes, sufficient for steps of 3 mm at 5 Hz; shorter ticks
/// take more.
const AXIS_ACCELERATION_MM_S2: f64 = 500.0;

/// Interval of gaps of the simulated tracker, s.
const GAP_INTERVAL_S: f64 = 3.0;

/// The running simulators of a rehearsal.
pub struct Rehearsal {
    // Dropped first, while its clock still runs.
    running: RunningSimulator,
    clock: Arc<dyn Clock>,
    interrupt: Interrupt,
}

impl Rehearsal {
    /// Starts the simulators and registers the calling thread with their clock, which would
    /// otherwise advance without it. Returns the rehearsal, the driver's end of the serial line,
    /// and the settings of the tracker's client.
    pub(super) fn open(
        options: &HardwareOptions,
        rehearsal: &RehearsalOptions,
        step_s: f64,
        seed: Seed,
    ) -> Result<(Rehearsal, Box<dyn SerialLine>, TrackingSettings), String> {
        let clock: Arc<dyn Clock> = Arc::new(RehearsalClock::default());
        // A pseudo-terminal delivers with a delay, which is late on a clock that does not wait for
        // it.
        let (simulator_end, driver_end) = pipe();
        let (simulator, tracking) =
            build_simulator(options, rehearsal, step_s, Box::new(simulator_end), seed)?;
        clock.join();
        let running = RunningSimulator::start(simulator, Arc::clone(&clock))
            .map_err(|error| error.to_string())?;
        Ok((
            Rehearsal { running, clock, interrupt: Interrupt::default() },
            Box::new(driver_end),
            tracking,
        ))
    }

    /// The clock of the simulators.
    pub(super) fn clock(&self) -> Arc<dyn Clock> {
        Arc::clone(&self.clock)
    }

    /// A request to end this rehearsal, as Ctrl-C ends a program.
    pub fn interrupt(&self) -> Interrupt {
        self.interrupt.clone()
    }

    /// Calls `what` with the locked simulator, for example to inject a fault.
    pub fn with_simulator<T>(&self, what: impl FnOnce(&mut Simulator) -> T) -> T {
        what(&mut self.running.lock())
    }
}

/// Simulated motors at the other end of `serial` that are fast enough for ticks of `step_s`, a
/// simulated robot and tracker, and the settings of the tracker's client.
pub(super) fn build_simulator(
    options: &HardwareOptions,
    rehearsal: &RehearsalOptions,
    step_s: f64,
    serial: Box<dyn SerialLine>,
    seed: Seed,
) -> Result<(Simulator, TrackingSettings), String> {
    let mut controller_options = ControllerOptions { seed: seed.0, ..ControllerOptions::default() };
    let acceleration_mm_s2 = min_acceleration_mm_s2(&options.safety, step_s).ceil();
    let axis_settings =
        [(110, AXIS_SPEED_MM_MIN), (120, AXIS_ACCELERATION_MM_S2.max(acceleration_mm_s2))];
    for (first, value) in axis_settings {
        controller_options
            .settings
            .extend((first..first + 4).map(|number| (number, value.to_string())));
    }
    controller_options.settings.insert(23, options.motion.homing_directions.to_string());
    let controller = SimulatedController::new(serial, controller_options);
    let tracker_options =
        TrackerOptions { noise_m: rehearsal.noise_m, seed, ..TrackerOptions::default() };
    let mut tracker = SimulatedTracker::new(tracker_options)
        .map_err(|error| format!("cannot start the simulated tracker: {error}"))?;
    let network = tracker.settings().map_err(|error| error.to_string())?;
    let faults = [
        (rehearsal.loss, TrackerFault::Loss(rehearsal.loss)),
        (rehearsal.jitter_s, TrackerFault::Jitter(rehearsal.jitter_s)),
        (
            rehearsal.gap_s,
            TrackerFault::Gaps { every_s: GAP_INTERVAL_S, lasting_s: rehearsal.gap_s },
        ),
    ];
    faults
        .into_iter()
        .filter(|(amount, _)| *amount > 0.0)
        .for_each(|(_, fault)| tracker.inject(fault));
    let tracking = TrackingSettings {
        up_axis: options.tracking.up_axis,
        alignment: options.tracking.alignment,
        tip_offset: options.tracking.tip_offset,
        ..network
    };
    let truth = TrackingSettings {
        alignment: rehearsal.alignment.unwrap_or(tracking.alignment),
        ..tracking.clone()
    };
    let mounting = Mounting::of(&truth);
    let body = RehearsalRobot::new(&rehearsal.model, &options.attached);
    let tip_body = Box::new(move |base: &RigidPose, tip: &RigidPose| mounting.tip_body(base, tip));
    Ok((Simulator::new(controller, tracker, Box::new(body), options.axes, tip_body), tracking))
}

/// A simulated robot whose tendons are moved by simulated lead screws.
struct RehearsalRobot {
    model: Model,
    attached: Vec<EffectSpec>,
    driven: DrivenModel,
    /// Time since the robot was last advanced, s.
    waiting_s: f64,
    tip: RigidPose,
    pulls_m: [f64; AXES],
    /// Time without a change, s.
    unchanged_s: f64,
}

/// Time step of the robot, s: lead screws are slow compared with it.
const STEP_S: f64 = 0.02;
/// Time after which a robot with constant tendons is at rest, s.
const AT_REST_S: f64 = 2.0;

impl RehearsalRobot {
    fn new(model: &Model, attached: &[EffectSpec]) -> RehearsalRobot {
        let mut robot = RehearsalRobot {
            model: model.clone(),
            attached: attached.to_vec(),
            driven: DrivenModel::new(model, attached),
            waiting_s: 0.0,
            tip: RigidPose::default(),
            pulls_m: [0.0; AXES],
            unchanged_s: 0.0,
        };
        // Before homing the screws have arbitrary positions; the robot starts with its tendons at
        // home.
        let _ = robot.driven.home();
        robot.update_tip();
        robot
    }

    fn commands(&self) -> [TendonCommand; AXES] {
        self.pulls_m.map(TendonCommand::Pull)
    }

    fn update_tip(&mut self) {
        let observation = self.driven.observation(&self.commands(), 0.0);
        self.tip = RigidPose {
            position_m: observation.tip_m,
            quaternion: observation.tip_quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0]),
        };
    }
}

/// Displacement beyond which tendons are off their spools, metres; the robot then keeps its shape.
const OFF_SPOOL_M: f64 = 0.06;

impl SimulatedRobot for RehearsalRobot {
    fn advance(&mut self, pulls_m: &[f64; AXES], duration_s: f64) -> RigidPose {
        self.waiting_s += duration_s;
        if self.waiting_s < STEP_S - 1e-9 {
            return self.tip;
        }
        let moved = *pulls_m != self.pulls_m;
        self.unchanged_s = if moved { 0.0 } else { self.unchanged_s + self.waiting_s };
        if self.unchanged_s < AT_REST_S && pulls_m.iter().all(|pull_m| pull_m.abs() < OFF_SPOOL_M) {
            self.pulls_m = *pulls_m;
            // A rod without an equilibrium keeps its shape, as if stuck.
            if self.driven.advance(&self.commands(), self.waiting_s).is_ok() {
                self.update_tip();
            }
        }
        self.waiting_s = 0.0;
        self.tip
    }

    /// The weight is applied quasi-statically: the robot is at rest under it at once.
    fn hang_weight(&mut self, load_kg: f64) {
        let load = (load_kg > 0.0).then(|| EffectSpec::tip_load(load_kg));
        let all: Vec<EffectSpec> = self.attached.iter().cloned().chain(load).collect();
        self.driven = DrivenModel::new(&self.model, &all);
        let rests = self.driven.home().and_then(|()| self.driven.settle(&self.commands()));
        if rests.is_ok() {
            self.update_tip();
        }
        self.unchanged_s = 0.0;
    }
}
