//! The tracker's clock in an answer.

use super::Discovery;
use crate::data::findings::{Findings, FoundEffect, Verdict};
use crate::discovery::mistakes::clock_offset::ClockOffset;
use crate::effects::Model;

impl ClockOffset {
    /// Adds the offset to the answer in shifted tips, and gives its residuals the times of the recording. The delay that
    /// the search found corrects the offset and is no effect. An answer without it is no answer: something else has
    /// taken its place.
    pub(crate) fn tell(mut self, told: &mut Discovery, given: &Model) {
        told.residuals.iter_mut().for_each(|row| row.time_s -= self.searched_s());
        if !self.is_one_step {
            match take_delay(told) {
                Some((delay_s, [low_s, high_s])) => {
                    let searched_s = self.searched_s();
                    self.offset_s = searched_s - delay_s;
                    self.interval_95 = [searched_s - high_s, searched_s - low_s];
                    self.tell_rest(told);
                }
                None => self.withhold(told, given),
            }
        }
        told.findings.clock_offset_s = Some(self.offset_s);
        told.findings.clock_offset_interval_95 = Some(self.interval_95);
        told.findings.limitations.push(self.sentence());
    }

    /// The summary without the delay.
    fn tell_rest(&self, told: &mut Discovery) {
        let findings = &mut told.findings;
        let names: Vec<&str> = findings.effects.iter().map(|effect| effect.name.as_str()).collect();
        let (before_mm, after_mm) = (1e3 * findings.gap.before_m, 1e3 * findings.gap.after_m);
        let lacks = if names.is_empty() {
            "With it corrected the data are consistent with the model.".to_owned()
        } else {
            format!("With it corrected the model lacks {}.", names.join(" and "))
        };
        if names.is_empty() {
            findings.verdict = Verdict::Consistent;
        }
        findings.summary = format!(
            "The tracker's clock is {:.3} s ahead of that of the commands. {lacks} On held-out trials the rms tip error \
             falls from {before_mm:.2} mm to {after_mm:.2} mm; the noise floor is {:.2} mm.",
            self.offset_s,
            1e3 * findings.noise_floor_m
        );
    }

    /// Withdraws the answer, and says first what is wrong.
    fn withhold(&self, told: &mut Discovery, given: &Model) {
        let findings = &mut told.findings;
        findings.verdict = Verdict::Unexplained;
        findings.effects.clear();
        findings.gap.after_m = findings.gap.before_m;
        findings.proposals.clear();
        findings.summary =
            format!("{} No set of effects explains the rest; nothing was added to the model.", self.sentence());
        findings.next_measurement = "Correct the clock of the recording, then run `discover` again.".to_owned();
        told.model.clone_from(given);
        told.next_experiments.clear();
        for row in &mut told.residuals {
            (row.after_x_m, row.after_y_m, row.after_z_m) = (row.before_x_m, row.before_y_m, row.before_z_m);
        }
    }
}

/// Takes a named delay with its interval out of an answer, seconds.
fn take_delay(told: &mut Discovery) -> Option<(f64, [f64; 2])> {
    if told.findings.verdict != Verdict::Named {
        return None;
    }
    let place = told.findings.effects.iter().position(|effect| effect.name == "delay")?;
    let delay = delay_of(&told.findings.effects[place])?;
    told.findings.effects.remove(place);
    let last = told.model.effects.iter().rposition(|effect| effect.card().name == "delay")?;
    told.model.effects.remove(last);
    Some(delay)
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
