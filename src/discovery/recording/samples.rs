//! Samples of a recording: the commands of every trial, and what was tracked in each row: the tip
//! and points along the body.

use super::blocks::{Block, Playing, blocks, duration_s};
use crate::base::{Point3, Rows};
use crate::data::{Actuation, Recording, recording};
use crate::effects::Starts;
use crate::rod::TipWrench;

/// Commands of one trial, to be simulated.
#[derive(Clone, Debug)]
pub(crate) struct TrialCommands {
    /// Number of the trial in the recording, or of the block into which the recording is divided.
    pub(crate) number: u64,
    /// Row of the recording with the first command.
    pub(crate) first_row: usize,
    /// State at the start; none for the model's `tracking.starts`.
    pub(crate) starts: Option<Starts>,
    /// One row a command. Of a motion without the last command of the trial, whose result is not
    /// recorded.
    pub(crate) commands: Rows,
    /// Duration of each command, seconds; none for poses at rest.
    pub(crate) durations_s: Vec<f64>,
    /// Whether every command is held until the robot rests.
    pub(crate) at_rest: bool,
    /// Whether commands are tensions.
    pub(crate) tensions: bool,
    /// Known weight on the tip, kilograms.
    pub(crate) known_load_kg: f64,
    /// Gravity, where it is not the model's.
    pub(crate) gravity_m_s2: Option<[f64; 3]>,
    /// Other load on the tip during each command.
    pub(crate) tip_loads: Option<Vec<TipWrench>>,
}

impl TrialCommands {
    /// Commands of a motion under the model's gravity, without any load.
    pub(crate) fn new(commands: Rows, durations_s: Vec<f64>) -> TrialCommands {
        TrialCommands {
            number: 0,
            first_row: 0,
            starts: None,
            commands,
            durations_s,
            at_rest: false,
            tensions: false,
            known_load_kg: 0.0,
            gravity_m_s2: None,
            tip_loads: None,
        }
    }
}

/// What was tracked at one place of the body in one row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Index of its trial in [`Samples::trials`].
    pub(crate) trial: usize,
    /// Number of commands of its trial that were played before it, or in poses at rest before its
    /// own command.
    pub(crate) row: usize,
    /// Index of the point in the model's `tracking.points`; none for the tip.
    pub(crate) point: Option<usize>,
    /// Time in the trial, seconds.
    pub(crate) time_s: f64,
    /// Measured position of the tip or point, metres.
    pub(crate) position_m: Point3,
    /// Velocity of the same simulated place, m/s; zero unless the clocks of tracker and commands
    /// are uncertain.
    pub(crate) velocity_m_s: Point3,
}

impl Sample {
    /// A sample of the tip that was not measured.
    pub(crate) fn of_tip(trial: usize, row: usize, time_s: f64) -> Sample {
        Sample { trial, row, point: None, time_s, position_m: [0.0; 3], velocity_m_s: [0.0; 3] }
    }
}

/// All samples of a recording, trial by trial, in a trial place by place: the tip, then the points
/// in the model's order. Residual vectors have three values a sample: x, y, z.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    pub(crate) trials: Vec<TrialCommands>,
    pub(crate) rows: Vec<Sample>,
    /// Median time between rows, seconds.
    pub(crate) step_s: f64,
    /// Median time between tracked rows, seconds: longer if the tracker is slower than the drives.
    pub(crate) tracked_step_s: f64,
    /// Whether all trials start at home, so that their first rows repeat one measurement.
    pub(crate) at_home: bool,
    /// Standard deviation of the offset between the clocks of tracker and commands, seconds; none
    /// where they agree.
    pub(crate) clock_deviation_s: Option<f64>,
}

impl Samples {
    /// Tips of a checked recording whose trials start as the model says. Trials without any tracked
    /// tip are excluded.
    pub(crate) fn new(measured: &Recording) -> Samples {
        let alone = |(number, rows): (u64, std::ops::Range<usize>)| {
            let block = Block { number, lead_in: rows.start, rows, starts: Starts::Home };
            (block, None)
        };
        Samples::of_blocks(measured, &[], measured.trials().into_iter().map(alone), false)
    }

    /// Samples of the [`blocks`] of a checked recording: the tip, and the points of these names,
    /// the model's `tracking.points`, that were tracked. Blocks in which nothing was seen are
    /// excluded.
    pub(crate) fn played(measured: &Recording, points: &[String], playing: Playing) -> Samples {
        let each = blocks(measured, playing).into_iter().map(|block| {
            let starts = Some(block.starts);
            (block, starts)
        });
        let samples = Samples::of_blocks(measured, points, each, playing.at_rest);
        Samples { at_home: playing.starts == Starts::Home && !playing.at_rest, ..samples }
    }

    fn of_blocks(
        measured: &Recording,
        points: &[String],
        blocks: impl Iterator<Item = (Block, Option<Starts>)>,
        at_rest: bool,
    ) -> Samples {
        let mut trials = Vec::new();
        let mut rows = Vec::new();
        let (mut steps_s, mut tracked_steps_s) = (Vec::new(), Vec::new());
        let places = places(measured, points);
        for (block, starts) in blocks {
            let seen_at = |positions_m: &[Point3]| -> Vec<usize> {
                let seen = |row: &usize| {
                    measured.is_valid(*row) && positions_m[*row].iter().all(|x| x.is_finite())
                };
                block.rows.clone().filter(seen).collect()
            };
            let tracked: Vec<Vec<usize>> =
                places.iter().map(|(_, positions_m)| seen_at(positions_m)).collect();
            if tracked.iter().all(Vec::is_empty) {
                continue;
            }
            // A row holds the tip at the beginning of its command, so the last command has no
            // result.
            let steps = block.lead_in..block.rows.end - 1;
            let played = block.lead_in..block.rows.end - usize::from(!at_rest);
            let mut commands = Rows::new(measured.tendons());
            played.clone().for_each(|row| commands.push(measured.commands.row(row)));
            let durations_s: Vec<f64> = steps.map(|row| duration_s(measured, row)).collect();
            steps_s.extend_from_slice(&durations_s);
            for rows in &tracked {
                tracked_steps_s.extend(
                    rows.windows(2).map(|two| measured.time_s[two[1]] - measured.time_s[two[0]]),
                );
            }
            trials.push(TrialCommands {
                number: block.number,
                first_row: block.lead_in,
                starts,
                commands,
                durations_s: if at_rest { Vec::new() } else { durations_s },
                at_rest,
                tensions: measured.actuation == Actuation::Tensions,
                known_load_kg: measured
                    .known_load_kg
                    .as_ref()
                    .map_or(0.0, |load| load[block.rows.start]),
                gravity_m_s2: measured
                    .gravity_m_s2
                    .as_ref()
                    .map(|gravity| gravity[block.rows.start]),
                tip_loads: measured
                    .tip_load
                    .as_ref()
                    .map(|loads| loads[played].iter().map(tip_load).collect()),
            });
            let trial = trials.len() - 1;
            for (&(point, positions_m), tracked) in places.iter().zip(tracked) {
                rows.extend(tracked.into_iter().map(|row| Sample {
                    trial,
                    row: row - block.lead_in,
                    point,
                    time_s: measured.time_s[row],
                    position_m: positions_m[row],
                    velocity_m_s: [0.0; 3],
                }));
            }
        }
        let step_s = middle(&mut steps_s).unwrap_or(1.0);
        let tracked_step_s = middle(&mut tracked_steps_s).unwrap_or(step_s);
        Samples { trials, rows, step_s, tracked_step_s, at_home: true, clock_deviation_s: None }
    }

    /// Samples of the trials with these indices, in that order.
    pub(crate) fn of_trials(&self, kept: &[usize]) -> Samples {
        let ranges = self.ranges();
        // Trials are numbered anew by their place in the selection.
        let of = |(trial, &index): (usize, &usize)| {
            self.rows[ranges[index].clone()].iter().map(move |row| Sample { trial, ..*row })
        };
        let rows = kept.iter().enumerate().flat_map(of).collect();
        Samples {
            trials: kept.iter().map(|&index| self.trials[index].clone()).collect(),
            rows,
            ..*self
        }
    }

    /// What the rms error of these samples is called.
    pub(crate) fn error_name(&self) -> &'static str {
        if self.rows.iter().all(|row| row.point.is_none()) {
            "rms tip error"
        } else {
            "rms error of all tracked places"
        }
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Rows of each trial as index ranges.
    pub(crate) fn ranges(&self) -> Vec<std::ops::Range<usize>> {
        let start = |trial: usize| self.rows.partition_point(|row| row.trial < trial);
        (0..self.trials.len()).map(|trial| start(trial)..start(trial + 1)).collect()
    }

    /// Measured position minus `simulated_m`, three values a sample, metres.
    pub(crate) fn residual(&self, simulated_m: &[f64]) -> Vec<f64> {
        self.rows
            .iter()
            .flat_map(|row| row.position_m)
            .zip(simulated_m)
            .map(|(measured_m, simulated_m)| measured_m - simulated_m)
            .collect()
    }

    /// Velocity of the simulated places, three values a sample, m/s.
    pub(crate) fn velocity_m_s(&self) -> Vec<f64> {
        self.rows.iter().flat_map(|row| row.velocity_m_s).collect()
    }

    /// Rows of the recording that the trials cover.
    pub(crate) fn recorded_rows(&self) -> Vec<usize> {
        let of = |trial: &TrialCommands| {
            trial.first_row..trial.first_row + trial.commands.len() + usize::from(!trial.at_rest)
        };
        self.trials.iter().flat_map(of).collect()
    }

    /// Index of the command that led to a sample; none for the start of a motion.
    pub(crate) fn command_of(&self, sample: &Sample) -> Option<usize> {
        if self.trials[sample.trial].at_rest { Some(sample.row) } else { sample.row.checked_sub(1) }
    }

    /// Whether the samples are poses at rest.
    pub(crate) fn at_rest(&self) -> bool {
        self.trials.iter().any(|trial| trial.at_rest)
    }

    /// Time since the previous sample of the same trial and place, in median tracker steps; none
    /// for the first.
    pub(crate) fn steps_since_last(&self, row: usize) -> Option<f64> {
        let sample = &self.rows[row];
        let before = self.rows[..row]
            .last()
            .filter(|before| (before.trial, before.point) == (sample.trial, sample.point))?;
        Some((sample.time_s - before.time_s) / self.tracked_step_s)
    }

    /// Rows whose previous sample is in the same trial, of the same place and at most
    /// [`MAX_CONSECUTIVE_STEPS`] before.
    pub(crate) fn consecutive_rows(&self) -> Vec<usize> {
        let is_close = |&row: &usize| {
            self.steps_since_last(row).is_some_and(|steps| steps < MAX_CONSECUTIVE_STEPS)
        };
        (0..self.len()).filter(is_close).collect()
    }
}

/// What was tracked: the tip, and the points of a model whose names these are, with the position in
/// each row.
fn places<'a>(measured: &'a Recording, points: &[String]) -> Vec<(Option<usize>, &'a [Point3])> {
    let tip = measured.tip_m.as_deref().map(|tips_m| (None, tips_m));
    let tracked = |(index, name): (usize, &String)| {
        Some((Some(index), measured.point(name)?.position_m.as_slice()))
    };
    tip.into_iter().chain(points.iter().enumerate().filter_map(tracked)).collect()
}

/// Samples farther apart than this many median steps are not consecutive.
const MAX_CONSECUTIVE_STEPS: f64 = 1.5;

/// Independent normal numbers of this standard deviation.
#[cfg(test)]
pub(crate) fn white_noise(size_m: f64, seed: u64) -> impl FnMut() -> f64 {
    let mut random = crate::base::Seed(seed).rng();
    move || {
        let drawn: f64 = rand_distr::Distribution::sample(&rand_distr::StandardNormal, &mut random);
        size_m * drawn
    }
}

#[cfg(test)]
impl Samples {
    /// Trials of equal length, 0.2 s a sample: one tendon that is pulled further in each row, the
    /// tip at the origin.
    pub(crate) fn alike(trials: usize, samples: usize) -> Samples {
        let mut commands = Rows::new(1);
        (1..samples).for_each(|k| commands.push(&[k as f64]));
        let trial = |number: u64| TrialCommands {
            number,
            first_row: number as usize * samples,
            ..TrialCommands::new(commands.clone(), vec![0.2; samples - 1])
        };
        let sample =
            |k: usize| Sample::of_tip(k / samples, k % samples, 0.2 * (k % samples) as f64);
        Samples {
            trials: (0..trials as u64).map(trial).collect(),
            rows: (0..trials * samples).map(sample).collect(),
            step_s: 0.2,
            tracked_step_s: 0.2,
            at_home: true,
            clock_deviation_s: None,
        }
    }

    /// AR(1) noise of this standard deviation and correlation, independent by trial, three values a
    /// sample.
    pub(crate) fn noise(&self, size_m: f64, correlation: f64, seed: u64) -> Vec<f64> {
        let (mut noise, mut last) = (white_noise(size_m, seed), [0.0; 3]);
        let mut next = |sample: &Sample| {
            let kept = if sample.row == 0 { 0.0 } else { correlation };
            last = last.map(|before| kept * before + (1.0 - kept * kept).sqrt() * noise());
            last
        };
        self.rows.iter().flat_map(&mut next).collect()
    }
}

/// The median, the upper one of two.
fn middle(steps_s: &mut [f64]) -> Option<f64> {
    steps_s.sort_by(f64::total_cmp);
    steps_s.get(steps_s.len() / 2).copied()
}

fn tip_load(load: &recording::RecordedWrench) -> TipWrench {
    TipWrench { force_n: load.force_n.into(), moment_nm: load.moment_nm.into() }
}

/// Root mean square length of the vectors in `residual`.
pub(crate) fn rms_m(residual: &[f64]) -> f64 {
    (residual.iter().map(|r| r * r).sum::<f64>() / (residual.len() as f64 / 3.0).max(1.0)).sqrt()
}
