//! A simulated robot between a simulated controller and a simulated tracker, in a thread of its
//! own.

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

/// Time step, s: twice the rate of a tracker.
const STEP_S: f64 = 0.005;

/// The robot between the motors and the tracker.
pub trait SimulatedRobot: Send {
    /// Moves the tendons to `pulls_m` within `duration_s` (both since the last call); returns the
    /// pose of the tip in the base frame.
    fn advance(&mut self, pulls_m: &[f64; AXES], duration_s: f64) -> RigidPose;
    /// Replaces whatever hangs on the tip by a weight of `load_kg`.
    fn hang_weight(&mut self, _load_kg: f64) {}
}

/// Simulated motors, robot and tracker of a rehearsal.
pub struct Simulator {
    /// The simulated controller.
    pub controller: SimulatedController,
    /// The simulated tracker.
    pub tracker: SimulatedTracker,
    /// Pose of the base body in the tracker's frame.
    pub base: RigidPose,
    robot: Box<dyn SimulatedRobot>,
    axes: AxesOptions,
    /// Computes the pose of the tip body in the tracker's frame.
    view: TrackerView,
    now_s: f64,
    /// When a screw last moved, s.
    moved_s: f64,
    last_screws_mm: [f64; AXES],
    interventions: Vec<(f64, Intervention)>,
}

/// Pose of the tip's body in the tracker's frame, given the pose of the base's body there and the
/// tip in the base frame.
pub type TrackerView = Box<dyn Fn(&RigidPose, &RigidPose) -> RigidPose + Send>;

/// A scheduled change of a simulator, such as a fault.
pub type Intervention = Box<dyn FnOnce(&mut Simulator) + Send>;

impl Simulator {
    /// A simulator at rest; `view` computes the pose of the tip's body in the tracker's frame,
    /// given the pose of the base's body there and the tip in the base frame.
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

    /// Applies `intervention` at `time_s`.
    pub fn schedule(&mut self, time_s: f64, intervention: Intervention) {
        self.interventions.push((time_s, intervention));
    }

    /// Replaces whatever hangs on the tip by a weight of `load_kg`.
    pub fn hang_weight(&mut self, load_kg: f64) {
        self.robot.hang_weight(load_kg);
    }

    /// Draws all random numbers from `seed` from now on.
    pub fn reseed(&mut self, seed: Seed) {
        self.controller.reseed(seed);
        self.tracker.reseed(seed);
    }

    /// When a screw last moved, s.
    pub fn moved_s(&self) -> f64 {
        self.moved_s
    }

    /// Simulates until `now_s`.
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
        let tip_body = (self.view)(&self.base, &tip);
        self.tracker.step(now_s, &tip_body, &self.base);
        self.now_s = now_s;
    }
}

/// A simulator in a thread of its own, which ends when it is dropped.
pub struct RunningSimulator {
    simulator: Arc<Mutex<Simulator>>,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl RunningSimulator {
    /// Runs `simulator` by `clock`.
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
                    // Alone on its clock this thread would never wait, and would occupy a
                    // processor.
                    std::thread::yield_now();
                }
                clock.leave();
            }
        })?;
        Ok(RunningSimulator { simulator, over, thread: Some(thread) })
    }

    /// The simulator, which is paused while the guard lives.
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
            // A simulator that panicked has nothing left to end.
            let _ = thread.join();
        }
    }
}
