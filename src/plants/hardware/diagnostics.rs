//! What motors and tracker say about themselves.

use super::Hardware;
use crate::base::Point3;
use crate::hardware::axes::AXES;
use crate::hardware::realtime::{Priority, RealTime};
use crate::hardware::tracking::TrackingStatus;

/// What motors and tracker say about themselves.
#[derive(Clone, Debug)]
pub struct Diagnostics {
    /// Kind and version of the controller.
    pub controller: String,
    /// Whether the axes know where they are.
    pub homed: bool,
    /// Where they are, millimetres.
    pub position_mm: [f64; AXES],
    /// Name and version of the tracking server.
    pub server: String,
    /// How its frames have come.
    pub tracking: TrackingStatus,
    /// The tip, metres; none if it has not been seen.
    pub tip: Option<Point3>,
    /// Where the model puts the tip at home, metres.
    pub home_m: Point3,
    /// Whether the loop may go before everything else on this computer; none where time waits for it.
    pub real_time: Option<bool>,
}

impl Hardware {
    /// What motors and tracker say about themselves, the tracker after `watch_s`; moves nothing.
    pub fn run_diagnostics(&mut self, watch_s: f64) -> Diagnostics {
        self.supervised.clock.sleep_until(self.supervised.clock.now_s() + watch_s);
        // Where the tip should be while nothing has been pulled; a model without rest says nothing.
        let _ = self.model.home();
        let home_m = self.expected_m();
        let real_time = self.supervised.clock.is_real().then(|| RealTime::new(Priority::Loop).is_granted());
        let now_s = self.supervised.clock.now_s();
        let rig = self.supervised.rig();
        Diagnostics {
            controller: format!("{} {}", rig.controller().machine().firmware, rig.controller().machine().version),
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
