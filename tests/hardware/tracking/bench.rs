//! A client and the synthetic tracker on one clock that the test moves by hand.

use std::sync::Mutex;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use spinebench::hardware::clock::Clock;
use spinebench::hardware::tracking::{
    Mounting, RigidPose, TrackerClient, TrackingFault, TrackingSettings,
};
use spinebench::simulators::{SimulatedTracker, TrackerFault, TrackerOptions};

/// Time between polls, s. Frames of 100 Hz arrive just at some of them: a frame that waited to be
/// read would seem later.
const STEP_S: f64 = 0.002;

/// The tip in the robot's base frame, and the base body in Motive's, over time.
pub(crate) type Motion = fn(f64) -> (RigidPose, RigidPose);

pub(crate) fn pose(position_m: [f64; 3], turn_rad: [f64; 3]) -> RigidPose {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn_rad));
    RigidPose::of(&Isometry3::from_parts(Vector3::from(position_m).into(), turn))
}

/// Whether the newest valid sample would not hold a robot.
pub(crate) fn fresh(tracking: &TrackerClient, now_s: f64) -> bool {
    tracking.age_s(now_s) <= 0.05
}

/// Distance of two poses: metres and radians.
pub(crate) fn apart(a: &RigidPose, b: &RigidPose) -> (f64, f64) {
    let between = a.motion().inv_mul(&b.motion());
    (between.translation.vector.norm(), between.rotation.angle())
}

pub(crate) fn at_rest(_: f64) -> (RigidPose, RigidPose) {
    (pose([0.02, -0.03, 0.19], [0.1, 0.2, 0.0]), pose([1.0, 1.2, -0.5], [0.0, 0.4, 0.0]))
}

/// Straight on at constant speed, turning at a constant rate about one axis, before a base that
/// does not move.
pub(crate) fn steady(time_s: f64) -> (RigidPose, RigidPose) {
    let tip =
        pose([0.01 + 0.05 * time_s, 0.02 * time_s, 0.2 - 0.03 * time_s], [0.0, 0.4 * time_s, 0.0]);
    (tip, at_rest(0.0).1)
}

/// Clock and server: the server is served whenever somebody waits.
pub(crate) struct Bench {
    tracker: Mutex<SimulatedTracker>,
    now_s: Mutex<f64>,
    mounting: Mounting,
    motion: Motion,
    pub(crate) settings: TrackingSettings,
}

impl Clock for Bench {
    fn now_s(&self) -> f64 {
        *self.now_s.lock().unwrap()
    }

    fn sleep_until(&self, time_s: f64) {
        let (tip, base) = (self.motion)(time_s);
        let tip_body = self.mounting.tip_body(&base, &tip);
        self.tracker.lock().unwrap().step(time_s, &tip_body, &base);
        *self.now_s.lock().unwrap() = time_s;
    }
}

impl Bench {
    pub(crate) fn new(options: TrackerOptions, motion: Motion) -> Bench {
        Bench::with(options, motion, |_| {})
    }

    pub(crate) fn with(
        options: TrackerOptions,
        motion: Motion,
        change: impl Fn(&mut TrackingSettings),
    ) -> Bench {
        let tracker = SimulatedTracker::new(options).unwrap();
        let mut settings = tracker.settings().unwrap();
        change(&mut settings);
        let (tracker, now_s) = (Mutex::new(tracker), Mutex::new(0.0));
        Bench { tracker, now_s, mounting: Mounting::of(&settings), motion, settings }
    }

    pub(crate) fn open(&self) -> Result<TrackerClient, TrackingFault> {
        TrackerClient::open(self.settings.clone(), self)
    }

    pub(crate) fn inject(&self, fault: TrackerFault) {
        self.tracker.lock().unwrap().inject(fault);
    }

    pub(crate) fn clear_faults(&self) {
        self.tracker.lock().unwrap().clear_faults();
    }

    /// Lets `duration_s` pass in steps of `step_s`, polling after each, and looks at the client
    /// each time.
    pub(crate) fn watch(
        &self,
        tracking: &mut TrackerClient,
        duration_s: f64,
        step_s: f64,
        mut look: impl FnMut(&TrackerClient, f64),
    ) {
        let start_s = self.now_s();
        for k in 1..=(duration_s / step_s).round() as u32 {
            let now_s = start_s + f64::from(k) * step_s;
            self.sleep_until(now_s);
            tracking.poll(now_s);
            look(tracking, now_s);
        }
    }

    pub(crate) fn run(&self, tracking: &mut TrackerClient, duration_s: f64) {
        self.watch(tracking, duration_s, STEP_S, |_, _| {});
    }

    /// Largest distance from the truth of the samples of the next `duration_s`, metres and radians,
    /// and the share of the time that there was a fresh one.
    pub(crate) fn judge(&self, tracking: &mut TrackerClient, duration_s: f64) -> (f64, f64, f64) {
        let (mut worst, mut count) = ((0.0_f64, 0.0_f64), 0);
        self.watch(tracking, duration_s, STEP_S, |tracking, now_s| {
            if let Some(tip) = tracking.latest().filter(|_| fresh(tracking, now_s)) {
                let (m, rad) = apart(&tip.pose(), &(self.motion)(tip.time_s).0);
                worst = (worst.0.max(m), worst.1.max(rad));
                count += 1;
            }
        });
        (worst.0, worst.1, f64::from(count) * STEP_S / duration_s)
    }
}
