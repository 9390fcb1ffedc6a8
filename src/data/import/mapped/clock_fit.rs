//! The offset between the tracker's clock and that of the commands, from the motion:
//! cross-correlation of the tip with commands that reach it through a linear response of second
//! order (a least-squares fit at every offset and response), and its interval by the
//! delete-one-block jackknife (Künsch 1989).

use super::step_response::StepResponse;
use super::tip_motion::{
    BLOCKS, CommandSteps, MIN_FRAMES, OffsetCandidate, RESOLUTION_S, TipMotion,
};
use crate::base::Point3;

/// An estimated offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockFit {
    /// Seconds that are added to the tracker's times.
    pub offset_s: f64,
    /// Its 95 % interval, seconds.
    pub interval_95_s: [f64; 2],
    /// Mean delay of the response from command to tip that was fitted with it, seconds.
    pub lag_s: f64,
    /// Share of the tip's squares that the commands explain at this offset.
    pub explained: f64,
    /// Longest dead time of the drive that the interval covers, seconds. The offset is that of a
    /// drive without one; a drive that waits makes the tip late as a clock does, and the offset too
    /// small by so much.
    pub dead_time_s: f64,
}

impl ClockFit {
    /// The same for a drive that may wait before it moves.
    pub(super) fn with_dead_time(self, dead_time_s: f64) -> ClockFit {
        let [low_s, high_s] = self.interval_95_s;
        ClockFit { interval_95_s: [low_s, high_s + dead_time_s], dead_time_s, ..self }
    }

    /// The same between clocks of which one began otherwise.
    pub(super) fn shifted(self, by_s: f64) -> ClockFit {
        let interval_95_s = self.interval_95_s.map(|limit_s| limit_s + by_s);
        ClockFit { offset_s: self.offset_s + by_s, interval_95_s, ..self }
    }
}

/// 97.5 % quantile of Student's t with one degree of freedom less than there are blocks.
const STUDENT_T_975: f64 = 2.262_157;
/// How much of the fitted lag an offset may be off by: the first motion of the response is gentle,
/// that of a tendon robot's tip is a jump, and of one with a slow drive gentler still. Of robots
/// that answer otherwise it was 0.36 at most.
const FIRST_MOTION_SHARE: f64 = 0.5;
/// Most frames that are looked at over all offsets, and around the best ones.
const MAX_COARSE_FRAMES: usize = 1500;
const MAX_FINE_FRAMES: usize = 8000;
/// Most offsets that are tried.
const MAX_OFFSETS: usize = 20_000;
/// Least share of the tip's squares that commands must explain.
const MIN_EXPLAINED: f64 = 0.2;
/// Peaks that are looked at closely.
const MAX_PEAKS: usize = 5;
/// A second offset is as good as the first when it leaves at most this many times as much.
const MAX_RIVAL_RATIO: f64 = 1.2;
/// Responses from which the search starts.
const START_RESPONSES: [StepResponse; 4] = [
    StepResponse { time_s: 0.01, damping: 2.0 },
    StepResponse { time_s: 0.03, damping: 0.5 },
    StepResponse { time_s: 0.06, damping: 1.0 },
    StepResponse { time_s: 0.2, damping: 1.0 },
];
/// Resolution while offsets compete, seconds.
const COARSE_RESOLUTION_S: f64 = 2e-3;

/// Offsets with a local optimum of the fit, best first.
fn peaks(motion: &TipMotion, offsets_s: &[f64]) -> Vec<f64> {
    let response = StepResponse { time_s: 0.25 * motion.step_s, damping: 1.0 };
    let states = motion.states(response);
    let unexplained_at = |offset_s: &f64| {
        motion.blocks(*offset_s, response, &states, 1).map_or(1.0, |all| all[0].unexplained())
    };
    let unexplained: Vec<f64> = offsets_s.iter().map(unexplained_at).collect();
    let at = |k: usize| unexplained.get(k).copied().unwrap_or(1.0);
    let is_minimum = |k: &usize| {
        unexplained[*k] < 1.0
            && unexplained[*k] <= at(k + 1)
            && (*k == 0 || unexplained[*k] < unexplained[*k - 1])
    };
    let mut peaks: Vec<usize> = (0..unexplained.len()).filter(is_minimum).collect();
    peaks.sort_by(|a, b| unexplained[*a].total_cmp(&unexplained[*b]));
    peaks.into_iter().take(MAX_PEAKS).map(|k| offsets_s[k]).collect()
}

/// Half of the 95 % interval of the `best` offset, seconds.
fn jackknife_half_width_s(fine: &TipMotion, best: OffsetCandidate) -> f64 {
    // Delete-one-block jackknife of B blocks: the variance is (B − 1)/B Σ (offset without a block −
    // their mean)².
    let offset_without = |block| fine.polished(best, Some(block)).offset_s;
    let left_out_s: Vec<f64> = (0..BLOCKS).map(offset_without).collect();
    let mean_s = left_out_s.iter().sum::<f64>() / BLOCKS as f64;
    let squares: f64 = left_out_s.iter().map(|offset_s| (offset_s - mean_s).powi(2)).sum();
    let statistical_s =
        STUDENT_T_975 * (squares * (BLOCKS - 1) as f64 / BLOCKS as f64).sqrt().max(RESOLUTION_S);
    statistical_s + FIRST_MOTION_SHARE * best.response.mean_delay_s()
}

/// An offset one step away that fits alike. A lag can make up for an offset where the motion has one
/// frequency.
fn rival_by_lag_s(coarse: &TipMotion, best: OffsetCandidate, every_s: f64) -> Option<f64> {
    let shifted = |shift_s: f64| OffsetCandidate { offset_s: best.offset_s + shift_s, ..best };
    let fits = [-coarse.step_s, coarse.step_s].map(|shift_s| {
        coarse.refined(shifted(shift_s), [every_s, COARSE_RESOLUTION_S], None, true)
    });
    let rival = fits.iter().find(|fit| fit.unexplained <= MAX_RIVAL_RATIO * best.unexplained);
    rival.map(|fit| fit.offset_s)
}

/// Estimates the offset between `from_s` and `to_s`.
///
/// # Errors
/// What was found and what was expected, in words.
pub(crate) fn estimate(
    commands: &CommandSteps,
    frames: Vec<(f64, Point3)>,
    from_s: Option<f64>,
    to_s: Option<f64>,
) -> Result<ClockFit, (String, String)> {
    let refuse = |found: String, expected: &str| Err((found, expected.to_owned()));
    let steps: Vec<f64> = commands.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step_s = crate::math::summary::quantile(&steps, 0.5);
    if frames.len() < MIN_FRAMES || steps.len() < MIN_FRAMES / 2 {
        let found = format!("{} tracked frames and {} commands", frames.len(), commands.rows.len());
        return refuse(found, "at least 50 frames and 26 commands, or `clock.offset_s`");
    }
    let (first_s, last_s) = (frames[0].0, frames[frames.len() - 1].0);
    let middle_s = 0.5 * (commands.time_s[0] + commands.time_s[commands.time_s.len() - 1]);
    // Beyond these the tracking does not meet the commands.
    let [lowest_s, highest_s] =
        [commands.time_s[0] - last_s, 2.0 * middle_s - commands.time_s[0] - first_s];
    let low_s = from_s.unwrap_or(middle_s - last_s).clamp(lowest_s, highest_s);
    let high_s = to_s.unwrap_or(middle_s - first_s).clamp(lowest_s, highest_s);
    let motion = TipMotion { commands, frames, step_s };
    let every_s = (0.5 * step_s).max((high_s - low_s) / MAX_OFFSETS as f64).max(1e-3);
    let count = ((high_s - low_s) / every_s).ceil().max(1.0) as usize;
    let offsets_s: Vec<f64> =
        (0..=count).map(|k| (low_s + every_s * k as f64).min(high_s)).collect();
    let (coarse, fine) = (motion.thinned(MAX_COARSE_FRAMES), motion.thinned(MAX_FINE_FRAMES));
    let refined_near = |offset_s: f64| {
        let starts = START_RESPONSES.map(|response| OffsetCandidate {
            offset_s,
            response,
            unexplained: 1.0,
        });
        let ends =
            starts.map(|start| coarse.refined(start, [every_s, COARSE_RESOLUTION_S], None, false));
        ends.into_iter().min_by(|a, b| a.unexplained.total_cmp(&b.unexplained))
    };
    let mut optima: Vec<OffsetCandidate> =
        peaks(&coarse, &offsets_s).into_iter().filter_map(refined_near).collect();
    optima.sort_by(|a, b| a.unexplained.total_cmp(&b.unexplained));
    let Some(&best) = optima.first().filter(|best| 1.0 - best.unexplained >= MIN_EXPLAINED) else {
        let share = optima.first().map_or(0.0, |best| 100.0 * (1.0 - best.unexplained));
        let found = format!(
            "a tip of which the commands explain {share:.0} % of the motion at the best offset"
        );
        return refuse(found, "20 % or more, or `clock.offset_s`");
    };
    let alike = |motion: &str, other_s: f64| {
        let best_s = best.offset_s;
        format!("{motion}: offsets of {best_s:.3} s and {other_s:.3} s fit equally well")
    };
    let is_distinct = |other: &&OffsetCandidate| {
        (other.offset_s - best.offset_s).abs() > 2.0 * every_s.max(step_s)
    };
    if let Some(other) = optima
        .iter()
        .skip(1)
        .find(is_distinct)
        .filter(|other| other.unexplained <= MAX_RIVAL_RATIO * best.unexplained)
    {
        let expected = "narrower limits `clock.estimate.from_s` and `to_s`, or `clock.offset_s`";
        return refuse(alike("a periodic motion", other.offset_s), expected);
    }
    if let Some(other_s) = rival_by_lag_s(&coarse, best, every_s) {
        let expected = "commands of several frequencies, or `clock.offset_s`";
        return refuse(alike("an ambiguous motion", other_s), expected);
    }
    let best = fine.polished(best, None);
    let half_width_s = jackknife_half_width_s(&fine, best);
    Ok(ClockFit {
        offset_s: best.offset_s,
        interval_95_s: [best.offset_s - half_width_s, best.offset_s + half_width_s],
        lag_s: best.response.mean_delay_s(),
        explained: 1.0 - best.unexplained,
        dead_time_s: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use rand_distr::{Distribution, Normal};

    /// Random steps at 5 Hz, and a tip that follows through a lag of 0.08 s, seen at 100 Hz from 2
    /// s before the commands.
    fn motion(seed: u64, repeats: bool) -> (CommandSteps, Vec<(f64, Point3)>) {
        let (mut random, step, noise) =
            (Seed(seed).rng(), Normal::new(0.0, 4e-3).unwrap(), Normal::new(0.0, 3e-4).unwrap());
        let time_s: Vec<f64> = (0..300).map(|row| 0.2 * f64::from(row)).collect();
        let rows: Vec<Vec<f64>> = (0..300)
            .map(|row| {
                let phase = 0.1 * f64::from(row % 20) * std::f64::consts::PI;
                let drawn = [step.sample(&mut random), step.sample(&mut random)];
                let [a, b] = if repeats { [5e-3 * phase.sin(), 5e-3 * phase.cos()] } else { drawn };
                vec![a, b, -a, -b]
            })
            .collect();
        let (mut lag, mut frames) = ([0.0; 2], Vec::new());
        for tick in 0..6400_usize {
            let mut seen = || noise.sample(&mut random);
            frames.push((
                0.01 * tick as f64,
                [4.0 * lag[0] + seen(), 3.9 * lag[1] + seen(), 0.2 + seen()],
            ));
            let row = (tick.saturating_sub(200) / 20).min(299);
            for axis in 0..2 {
                lag[axis] += (rows[row][axis] - lag[axis]) * (1.0 - (-0.01_f64 / 0.08).exp());
            }
        }
        (CommandSteps { time_s, rows }, frames)
    }

    #[test]
    fn an_unknown_offset_is_found_within_its_interval() {
        let mut inside = 0;
        for seed in 0..5 {
            let (commands, mut frames) = motion(seed, false);
            frames.iter_mut().for_each(|(frame_s, _)| *frame_s += 37.123);
            let fit = estimate(&commands, frames, None, None).unwrap();
            // The truth: these frames began 2 s before the commands.
            let [low_s, high_s] = fit.interval_95_s;
            assert!((fit.offset_s + 39.123).abs() < 1e-3, "{fit:?}");
            inside += i32::from((low_s..high_s).contains(&-39.123));
            // Beside the part that is left for a first motion that differs.
            let scatter_s = high_s - low_s - 2.0 * FIRST_MOTION_SHARE * fit.lag_s;
            assert!(scatter_s < 2e-3 && fit.explained > 0.9, "{fit:?}");
            assert!((fit.lag_s - 0.08).abs() < 4e-3, "{fit:?}");
        }
        assert!(inside >= 4, "{inside} of 5");
    }

    #[test]
    fn what_cannot_tell_the_offset_is_refused() {
        // Where motion begins and ends would tell the offset.
        let (commands, mut frames) = motion(1, true);
        frames.retain(|(frame_s, _)| (10.0..50.0).contains(frame_s));
        let said = estimate(&commands, frames.clone(), None, None).unwrap_err().0;
        assert!(said.contains("fit equally well"), "{said}");
        // Within a period a lag makes up for an offset.
        let said = estimate(&commands, frames.clone(), Some(-2.3), Some(-1.9)).unwrap_err().0;
        assert!(said.contains("fit equally well"), "{said}");
        let at_rest = frames.iter().map(|(frame_s, tip)| (*frame_s, [0.0, 0.0, tip[2]])).collect();
        let said = estimate(&commands, at_rest, None, None).unwrap_err().0;
        assert!(said.contains("at the best offset"), "{said}");
        assert!(estimate(&commands, frames[..30].to_vec(), None, None).is_err());
    }
}
