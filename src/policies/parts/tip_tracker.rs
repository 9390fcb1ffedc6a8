//! What a policy knows of the tip: the last valid measurement, and whether it is new.

use crate::base::{Observation, Point3, PolicyError};

/// The newest valid measurement.
#[derive(Default)]
pub(crate) struct TipTracker {
    last: Option<(f64, Point3)>,
}

/// One look at the robot.
#[derive(Clone, Copy)]
pub(crate) struct TipReading {
    pub(crate) tip_m: Point3,
    /// When it was measured, seconds.
    pub(crate) time_s: f64,
    /// True when this is a measurement that was not there at the last tick. In open loop, and where
    /// tracking is lost, the picture stays as it was.
    pub(crate) fresh: bool,
}

impl TipTracker {
    pub(crate) fn reset(&mut self) {
        self.last = None;
    }

    /// Checks the inputs of a tick and says what is new in them.
    pub(crate) fn read(
        &mut self,
        seen: &Observation,
        target_m: &Point3,
    ) -> Result<TipReading, PolicyError> {
        PolicyError::unless_finite("target", target_m)?;
        if !seen.valid {
            let (time_s, tip_m) = self.last.ok_or(PolicyError::NoMeasurement)?;
            return Ok(TipReading { tip_m, time_s, fresh: false });
        }
        PolicyError::unless_finite("measured tip", seen.tip_m.iter().chain([&seen.time_s]))?;
        let fresh = self.last.is_none_or(|(time_s, _)| time_s != seen.time_s);
        self.last = Some((seen.time_s, seen.tip_m));
        Ok(TipReading { tip_m: seen.tip_m, time_s: seen.time_s, fresh })
    }
}
