//! The tracker's clock in an answer.

use crate::data::findings::{Findings, FoundEffect};
use crate::discovery::mistakes::clock_offset::ClockOffset;

impl ClockOffset {
    /// Adds the offset to an answer. One that was estimated is the first thing to read.
    pub(crate) fn tell(&self, findings: &mut Findings) {
        if self.deviation_s().is_some() {
            findings.summary = format!("{} {}", self.sentence(), findings.summary);
        }
        findings.limitations.push(self.sentence());
        findings.clock_offset_s = Some(self.offset_s);
        findings.clock_offset_interval_95 = Some(self.interval_95);
    }
}

/// The time of a delay and its interval, seconds.
fn delay_of(effect: &FoundEffect) -> Option<(f64, [f64; 2])> {
    let time_s = effect.parameters.get("time_s")?.as_f64()?;
    let ends = effect.interval_95.get("time_s").and_then(serde_json::Value::as_array);
    let ends = ends.and_then(|ends| Some([ends.first()?.as_f64()?, ends.get(1)?.as_f64()?]));
    Some((time_s, ends.unwrap_or([time_s, time_s])))
}

/// A named `delay` may be the tracker's clock instead, which the data cannot tell: says so, with the same number.
pub(crate) fn tell_delay(findings: &mut Findings) {
    let Some(delay) = findings.effects.iter().find(|effect| effect.name == "delay") else { return };
    let Some((time_s, [low_s, high_s])) = delay_of(delay) else { return };
    findings.clock_offset_s = Some(-time_s);
    findings.clock_offset_interval_95 = Some([-high_s, -low_s]);
    findings.limitations.push(format!(
        "A delay of the robot by {time_s:.3} s and a tracker's clock that is as much behind that of the commands are the \
         same in these data: check the clocks before the drive."
    ));
}
