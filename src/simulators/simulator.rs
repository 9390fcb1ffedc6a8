//! A robot between imitated motors and an imitated tracker, in a thread of its own.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::controller::SimulatedController;
use super::tracker::SimulatedTracker;
use crate::base::Seed;
use crate::hardware::axes::{AXES, AxesOptions};
use crate::hardware::clock::Clock;
use crate::hardware::tracking::RigidPose;

/// How often the imitations are looked after, s: twice as often as a tracker sends.
const STEP_S: f64 = 0.005;

/// What hangs between the motors and the tracker.
pub trait SimulatedRobot: Send {
    /// Moves the tendons to `pulls_m` within `duration_s` (both since the last call); where the tip is then, in the base
    /// frame.
    fn advance(&mut self, pulls_m: &[f64; AXES], duration_s: f64) -> RigidPose;
    /// A weight of `load_kg` hangs on the tip from now on, and nothing else.
    fn hang_weight(&mut self, _load_kg: f64) {}
}

/// Motors, robot and tracker of a rehearsal.
pub struct Simulator {
    /// The imitated controller.
    pub controller: SimulatedController,
    /// The imitated tracker.
    pub tracker: SimulatedTracker,
    /// Where the base stands, as the tracker sees it.
    pub base: RigidPose,
    robot: Box<dyn SimulatedRobot>,
    axes: AxesOptions,
    /// From the frame of the base to what the tracker sees of the tip.
    view: TrackerView,
    now_s: f64,
    /// When a screw last moved, s.
    moved_s: f64,
    last_screws_mm: [f64; AXES],
    interventions: Vec<(f64, Intervention)>,
}

/// From the base's body and the tip in the base frame to the tip's body, as the tracker sees them.
pub type TrackerView = Box<dyn Fn(&RigidPose, &RigidPose) -> RigidPose + Send>;

/// Something that is done to a simulator.
pub type Intervention = Box<dyn FnOnce(&mut Simulator) + Send>;

impl Simulator {
    /// A simulator at rest; `seen` says where the tracker sees the tip's body, given where it sees the base's and where the
    /// tip is in the base frame.
    pub fn new(
        controller: SimulatedController,
        tracker: SimulatedTracker,
        robot: Box<dyn SimulatedRobot>,
        axes: AxesOptions,
        view: TrackerView,
    ) -> Simulator {
        let last_screws_mm = controller.position_mm();
        Simulator {
            controller,
            tracker,
            base: RigidPose::default(),
            robot,
            axes,
            view,
            now_s: 0.0,
            moved_s: 0.0,
            last_screws_mm,
            interventions: Vec::new(),
        }
    }

    /// Does `plan` at `time_s`.
    pub fn schedule(&mut self, time_s: f64, intervention: Intervention) {
        self.interventions.push((time_s, intervention));
    }

    /// A weight of `load_kg` hangs on the tip from now on, and nothing else.
    pub fn hang_weight(&mut self, load_kg: f64) {
        self.robot.hang_weight(load_kg);
    }

    /// All that is left to chance is `seed`'s from now on.
    pub fn reseed(&mut self, seed: Seed) {
        self.controller.reseed(seed);
        self.tracker.reseed(seed);
    }

    /// When a screw last moved, s.
    pub fn moved_s(&self) -> f64 {
        self.moved_s
    }

    /// Everything goes on until `now_s`.
    pub fn step(&mut self, now_s: f64) {
        while let Some(due) = self.interventions.iter().position(|(time_s, _)| *time_s <= now_s) {
            let (_, intervention) = self.interventions.swap_remove(due);
            intervention(self);
        }
        self.controller.step(now_s);
        let screws_mm = self.controller.position_mm();
        if screws_mm != self.last_screws_mm {
            (self.moved_s, self.last_screws_mm) = (now_s, screws_mm);
        }
        let pulls_m = self.axes.pulls_m(&screws_mm);
        let tip = self.robot.advance(&pulls_m, now_s - self.now_s);
        let view = (self.view)(&self.base, &tip);
        self.tracker.step(now_s, &view, &self.base);
        self.now_s = now_s;
    }
}

/// A simulator that goes on by itself until it is dropped.
pub struct RunningSimulator {
    simulator: Arc<Mutex<Simulator>>,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl RunningSimulator {
    /// Lets `simulator` go on with `clock`.
    ///
    /// # Errors
    /// When the system refuses the thread.
    pub fn start(simulator: Simulator, clock: Arc<dyn Clock>) -> io::Result<RunningSimulator> {
        let (simulator, over) = (Arc::new(Mutex::new(simulator)), Arc::new(AtomicBool::new(false)));
        clock.join();
        let thread = std::thread::Builder::new().name("rehearsal".to_owned()).spawn({
            let (simulator, over) = (Arc::clone(&simulator), Arc::clone(&over));
            move || {
                while !over.load(Ordering::SeqCst) {
                    let now_s = clock.now_s();
                    lock(&simulator).step(now_s);
                    clock.sleep_until(now_s + STEP_S);
                    // Alone on a clock of its own it would never wait, and keep a processor from everybody else.
                    std::thread::yield_now();
                }
                clock.leave();
            }
        })?;
        Ok(RunningSimulator { simulator, over, thread: Some(thread) })
    }

    /// The simulator, which stands still as long as the guard lives.
    pub fn lock(&self) -> MutexGuard<'_, Simulator> {
        lock(&self.simulator)
    }
}

fn lock(simulator: &Mutex<Simulator>) -> MutexGuard<'_, Simulator> {
    simulator.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for RunningSimulator {
    fn drop(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            // A rehearsal that failed has nothing left to end.
            let _ = thread.join();
        }
    }
}
