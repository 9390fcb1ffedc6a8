//! Diagnostics: what motors and tracker report about themselves.

use super::Hardware;
use crate::base::Point3;
use crate::hardware::axes::AXES;
use crate::hardware::realtime::{Priority, RealTime};
use crate::hardware::tracking::TrackingStatus;

/// Diagnostics of motors and tracker.
#[derive(Clone, Debug)]
pub struct Diagnostics {
    /// Firmware and version of the controller.
    pub controller: String,
    /// The alarm that the controller is in, 0 if its number is unknown. Being not homed is no alarm
    /// here.
    pub alarm: Option<u16>,
    /// Limit switches that are closed.
    pub closed_switches: [bool; AXES],
    /// Whether the axes are homed.
    pub homed: bool,
    /// Positions of the axes, millimetres.
    pub position_mm: [f64; AXES],
    /// Name and version of the tracking server.
    pub server: String,
    /// Counts and measures of the tracking.
    pub tracking: TrackingStatus,
    /// Measured tip position, metres; none if it was not tracked.
    pub tip: Option<Point3>,
    /// Tip position at home predicted by the model, metres.
    pub home_m: Point3,
    /// Whether the control loop has real-time priority; none in a rehearsal.
    pub real_time: Option<bool>,
}

impl Hardware {
    /// Collects the diagnostics, those of the tracker over `watch_s`; moves nothing.
    pub fn run_diagnostics(&mut self, watch_s: f64) -> Diagnostics {
        self.supervised.clock.sleep_until(self.supervised.clock.now_s() + watch_s);
        // Predicts the tip with all tendons at home; a model without an equilibrium predicts
        // nothing.
        let _ = self.model.home();
        let home_m = self.expected_m();
        let real_time = self
            .supervised
            .clock
            .is_real()
            .then(|| RealTime::new(Priority::ControlLoop).is_granted());
        let now_s = self.supervised.clock.now_s();
        let rig = self.supervised.rig();
        Diagnostics {
            controller: format!(
                "{} {}",
                rig.controller().info().firmware,
                rig.controller().info().version
            ),
            alarm: rig.controller().alarm(),
            closed_switches: rig.controller().state().pins.limits,
            homed: rig.controller().homed(),
            position_mm: rig.controller().state().position_mm,
            server: rig.tracking().server(),
            tracking: rig.tracking().status().clone(),
            tip: rig.fresh_tip(now_s).map(|pose| pose.position_m),
            home_m,
            real_time,
        }
    }
}
