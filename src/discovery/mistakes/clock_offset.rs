//! An offset of the tracker's clock from that of the commands.
//!
//! A tip that moves before its command is no physics: the tracker's clock is ahead, or the log
//! contains command and tip of the same time. The other sign is what the effect `delay` is, and is
//! left to it.

use super::excluded_rows::coarse_model;
use super::time_scan::TimeScan;
use crate::data::Recording;
use crate::discovery::fit::simulate;
use crate::discovery::options::Options;
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// Offsets are searched up to this many steps.
const MAX_STEPS: usize = 3;
/// … in this many parts of a step.
const PARTS_PER_STEP: usize = 8;
/// By how much the squares must shrink against every fit that only follows the commands. Recordings
/// of an independent chain with friction, delay, payload or anisotropy stay below 1.02.
const MIN_RATIO: f64 = 1.3;
/// Fewest rows.
const MIN_ROWS: usize = 30;
/// Effects that slow the robot shift the estimate by this, seconds (one standard deviation).
const LAG_BIAS_S: f64 = 0.02;
/// A whole step within this share of it is a log that holds command and tip of the same moment.
const ONE_STEP_TOLERANCE: f64 = 0.1;
/// 95 % quantile of chi-squared with one degree of freedom.
const CHI_SQUARED_95: f64 = 3.84;
/// Steps of the refinement by golden section.
const REFINEMENTS: usize = 24;
/// Step in time of the velocity, seconds.
const VELOCITY_STEP_S: f64 = 0.02;
const GOLDEN: f64 = 0.618_033_988_749_895;

/// An offset of the tracker's clock, positive when it is ahead: a tip was measured this long after
/// its row's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockOffset {
    pub(crate) offset_s: f64,
    pub(crate) interval_95: [f64; 2],
    /// Whether it is one step of the recording.
    pub(crate) is_one_step: bool,
}

/// The offset of `measured` if tips move before their commands do.
pub(crate) fn find(model: &Model, measured: &Recording, options: &Options) -> Option<ClockOffset> {
    let scan = TimeScan::new(&coarse_model(model, options), measured)
        .filter(|scan| scan.len() >= MIN_ROWS)?;
    // 1. The squares at every offset, each after a fit that follows the commands.
    let part_s = scan.step_s / PARTS_PER_STEP as f64;
    let squares = |offset_s: f64| scan.fit(offset_s, false).map(|fit| fit.squares_m2);
    let each: Vec<f64> = (0..=MAX_STEPS * PARTS_PER_STEP)
        .map(|part| squares(part as f64 * part_s))
        .collect::<Option<_>>()?;
    let best = (0..each.len()).min_by(|a, b| each[*a].total_cmp(&each[*b]))?;
    // 2. Only a clear minimum inside the range is a clock: an effect that slows the robot does not
    //    lead its commands. The lagging fit stands for effects that change when the robot moves.
    if best == 0
        || best + 1 == each.len()
        || scan.fit(0.0, true)?.squares_m2 < MIN_RATIO * each[best]
    {
        return None;
    }
    // 3. Refine the minimum.
    let around = [best - 1, best + 1].map(|part| part as f64 * part_s);
    let offset_s = golden_section(around, &|offset_s| squares(offset_s).unwrap_or(f64::INFINITY));
    let fit = scan.fit(offset_s, false)?;
    // 4. The squares grow as a parabola around the least; correlated residuals count for less.
    let rises_m2 = [-part_s, part_s]
        .map(|step_s| squares(offset_s + step_s).unwrap_or(f64::INFINITY) - fit.squares_m2);
    // Second difference, an estimate of the second derivative.
    let curvature = (rises_m2[0] + rises_m2[1]) / (part_s * part_s);
    let correlation = fit.correlation.clamp(0.0, 0.9);
    // An AR(1) residual inflates the variance by (1 + ρ)/(1 − ρ).
    let variance_m2 =
        fit.squares_m2 / (3 * scan.len()) as f64 * (1.0 + correlation) / (1.0 - correlation);
    let half_s = (2.0 * CHI_SQUARED_95 * variance_m2 / curvature.max(f64::MIN_POSITIVE))
        .sqrt()
        .hypot(2.0 * LAG_BIAS_S);
    // 5. An offset of one step is a log that holds command and tip of the same moment.
    let is_one_step = (offset_s - scan.step_s).abs() < half_s.max(ONE_STEP_TOLERANCE * scan.step_s);
    let offset_s = if is_one_step { scan.step_s } else { offset_s };
    Some(ClockOffset { offset_s, interval_95: [offset_s - half_s, offset_s + half_s], is_one_step })
}

/// The place of the least value between two places, by golden section.
fn golden_section([mut low, mut high]: [f64; 2], value: &dyn Fn(f64) -> f64) -> f64 {
    // One inner point of each bracket serves in the next one: one new value a step.
    let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let mut places = inner(low, high);
    let mut values = places.map(value);
    for _ in 0..REFINEMENTS {
        if values[0] < values[1] {
            high = places[1];
            places = inner(low, high);
            values = [value(places[0]), values[0]];
        } else {
            low = places[0];
            places = inner(low, high);
            values = [values[1], value(places[1])];
        }
    }
    0.5 * (low + high)
}

impl ClockOffset {
    /// What the reader must know, as a sentence.
    pub(crate) fn sentence(&self) -> String {
        let ([low, high], offset_s) = (self.interval_95, self.offset_s);
        if self.is_one_step {
            format!(
                "The tip of each row belongs to the end of that row's command, one step of \
                 {offset_s:.3} s later: the log contains command and tip of the same time. All \
                 tips were shifted by one step; shift the log, or record the tip before the \
                 command."
            )
        } else {
            format!(
                "The tracker's clock is about {offset_s:.2} s ahead of the clock of the commands \
                 (95 % interval {low:.2} to {high:.2} s). All tips were shifted by this offset, \
                 and the remaining offset was fitted; correct the clock in the recording."
            )
        }
    }

    /// Standard deviation, seconds; none for an offset of one step, which can be corrected exactly.
    pub(crate) fn deviation_s(&self) -> Option<f64> {
        (!self.is_one_step).then(|| 0.25 * (self.interval_95[1] - self.interval_95[0]))
    }

    /// The same offset, later by `more_s`.
    #[must_use]
    pub(crate) fn later(&self, more_s: f64) -> ClockOffset {
        let interval_95 = self.interval_95.map(|end_s| end_s + more_s);
        ClockOffset { offset_s: self.offset_s + more_s, interval_95, ..*self }
    }

    /// `samples` of a recording whose tips were shifted by this offset, with the velocity that
    /// `model` predicts in each: what is left of the offset is then an uncertain number.
    /// `measured`: the recording before the shift. Unchanged for an offset of one step, and where
    /// the model cannot follow.
    pub(crate) fn uncertain_in(
        &self,
        samples: Samples,
        model: &Model,
        measured: &Recording,
        options: &Options,
    ) -> Samples {
        let Some(deviation_s) = self.deviation_s() else { return samples };
        let coarse = coarse_model(model, options);
        let tips = |offset_s: f64| {
            let moved = options.samples(model, &measured.with_tips_later(offset_s));
            simulate::tips(&coarse, &[], &moved).filter(|tips_m| tips_m.len() == 3 * samples.len())
        };
        // A step beyond the offset itself would need tips from before the recording.
        let step_s = VELOCITY_STEP_S.min(0.5 * self.offset_s);
        let (Some(before), Some(after)) =
            (tips(self.offset_s - step_s), tips(self.offset_s + step_s))
        else {
            return samples;
        };
        let mut samples = Samples { clock_deviation_s: Some(deviation_s), ..samples };
        let each = before.as_chunks::<3>().0.iter().zip(after.as_chunks::<3>().0);
        for (row, (before, after)) in samples.rows.iter_mut().zip(each) {
            row.velocity_m_s =
                std::array::from_fn(|axis| (after[axis] - before[axis]) / (2.0 * step_s));
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::robot;
    use super::*;
    use crate::effects::EffectSpec;

    #[test]
    fn a_clock_that_is_ahead_is_found_beside_a_payload() {
        for offset_s in [0.05, 0.12] {
            let (model, measured) = robot(&[EffectSpec::tip_load(0.01)], offset_s).unwrap();
            let offset = find(&model, &measured, &Options::default()).unwrap();
            let [low, high] = offset.interval_95;
            assert!(
                low < offset_s && offset_s < high && high - low < 0.1,
                "{offset_s}: {offset:?}"
            );
            assert!(!offset.is_one_step);
        }
    }

    #[test]
    fn command_and_tip_of_the_same_moment_are_recognised() {
        let (model, measured) = robot(&[], 0.2).unwrap();
        let offset = find(&model, &measured, &Options::default()).unwrap();
        assert!(offset.is_one_step && (offset.offset_s - 0.2).abs() < 1e-9, "{offset:?}");
    }
}
