//! Samples that repeat one measurement: first rows of trials at home, and samples during a held
//! command.

use crate::discovery::recording::samples::{Samples, TrialCommands};

/// Conditions under which first rows of trials repeat one measurement.
#[derive(PartialEq)]
struct StartConditions {
    load_kg: f64,
    /// Gravity where it is not the model's.
    gravity_m_s2: Option<[f64; 3]>,
    /// The tracked point; none for the tip.
    point: Option<usize>,
}

/// A command that is held.
#[derive(Clone, Copy, PartialEq)]
struct Hold {
    trial: usize,
    point: Option<usize>,
    /// Index at which the command began.
    first: usize,
}

/// Time after which a held command counts as at rest, seconds (docs/method/search.md, "Noise").
const SETTLED_S: f64 = 1.0;

/// Groups of repeated samples: first rows of all trials under the same weight, then each dwell.
pub(crate) fn groups(samples: &Samples) -> Vec<Vec<usize>> {
    let mut groups = starts(samples);
    groups.extend(dwells(samples));
    groups
}

pub(crate) fn is_start(samples: &Samples, group: &[usize]) -> bool {
    group.first().is_some_and(|&row| samples.rows[row].row == 0)
}

/// First rows of trials at one place of the body under the same weight, if there are several. None
/// where trials start anywhere.
pub(crate) fn starts(samples: &Samples) -> Vec<Vec<usize>> {
    let mut starts: Vec<(StartConditions, Vec<usize>)> = Vec::new();
    if !samples.at_home {
        return Vec::new();
    }
    for row in (0..samples.len()).filter(|&row| samples.rows[row].row == 0) {
        let trial = &samples.trials[samples.rows[row].trial];
        let TrialCommands { known_load_kg: load_kg, gravity_m_s2, .. } = *trial;
        let conditions = StartConditions { load_kg, gravity_m_s2, point: samples.rows[row].point };
        match starts.iter_mut().find(|(other, _)| *other == conditions) {
            Some((_, rows)) => rows.push(row),
            None => starts.push((conditions, vec![row])),
        }
    }
    starts.into_iter().map(|(_, rows)| rows).filter(|rows| rows.len() > 1).collect()
}

/// Runs of samples of one place under one command and load after [`SETTLED_S`].
pub(crate) fn dwells(samples: &Samples) -> Vec<Vec<usize>> {
    let start_of_hold: Vec<Vec<usize>> = samples.trials.iter().map(start_of_hold).collect();
    let mut dwells: Vec<Vec<usize>> = Vec::new();
    let mut held: Option<(Hold, f64)> = None;
    let mut run: Vec<usize> = Vec::new();
    // Poses at rest have settled by definition, whatever their times.
    let settled_s = if samples.at_rest() { f64::NEG_INFINITY } else { SETTLED_S };
    for (index, row) in samples.rows.iter().enumerate() {
        let Some(command) = samples.command_of(row) else { continue };
        let hold =
            Hold { trial: row.trial, point: row.point, first: start_of_hold[row.trial][command] };
        if held.is_none_or(|(last, _)| last != hold) {
            held = Some((hold, row.time_s));
            // A new hold ends the run of the last one.
            dwells.push(std::mem::take(&mut run));
        }
        if held.is_some_and(|(_, since_s)| row.time_s - since_s >= settled_s) {
            run.push(index);
        }
    }
    dwells.push(run);
    dwells.retain(|run| run.len() > 1);
    dwells
}

/// For each command of a trial, the index at which the same command and load began.
fn start_of_hold(trial: &TrialCommands) -> Vec<usize> {
    let load = |k: usize| trial.tip_loads.as_ref().map(|loads| loads[k]);
    let mut start_of_hold: Vec<usize> = Vec::with_capacity(trial.commands.len());
    for k in 0..trial.commands.len() {
        let goes_on = k > 0 && is_held(trial, k) && load(k) == load(k - 1);
        start_of_hold.push(if goes_on { start_of_hold[k - 1] } else { k });
    }
    start_of_hold
}

/// Largest change of a command that counts as held in poses at rest, metres or newtons: steps of an
/// encoder.
const HELD_TOLERANCE: f64 = 2e-5;

/// Whether command `k` is the one before it.
fn is_held(trial: &TrialCommands, k: usize) -> bool {
    let (now, before) = (trial.commands.row(k), trial.commands.row(k - 1));
    let is_near =
        || now.iter().zip(before).all(|(now, before)| (now - before).abs() < HELD_TOLERANCE);
    // A motion repeats commands exactly; measured poses at rest carry encoder steps.
    now == before || trial.at_rest && is_near()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;
    use crate::discovery::recording::samples::Sample;
    use crate::rod::TipWrench;

    #[test]
    fn first_rows_repeat_one_measurement_only_at_home_under_one_weight_and_gravity() {
        let mut samples = Samples::alike(4, 3);
        assert_eq!(starts(&samples), [[0, 3, 6, 9]]);
        assert!(starts(&Samples { at_home: false, ..samples.clone() }).is_empty());
        samples.trials[1].gravity_m_s2 = Some([0.0, 0.0, 9.81]);
        samples.trials[3].gravity_m_s2 = Some([0.0, 0.0, 9.81]);
        assert_eq!(starts(&samples), [[0, 6], [3, 9]]);
    }

    #[test]
    fn another_place_of_the_body_is_another_measurement() {
        let mut samples = Samples::alike(2, 30);
        samples.trials.iter_mut().for_each(|trial| {
            trial.commands = Rows::new(1);
            (1..30).for_each(|_| trial.commands.push(&[1.0]));
        });
        let with_point = |trial: usize| {
            let tips: Vec<Sample> =
                samples.rows.iter().filter(|row| row.trial == trial).copied().collect();
            let points: Vec<Sample> =
                tips.iter().map(|tip| Sample { point: Some(0), ..*tip }).collect();
            [tips, points].concat()
        };
        samples.rows = [with_point(0), with_point(1)].concat();
        assert_eq!(starts(&samples), [[0, 60], [30, 90]]);
        assert_eq!(dwells(&samples).iter().map(Vec::len).collect::<Vec<_>>(), [24; 4]);
        assert_eq!((samples.steps_since_last(30), samples.steps_since_last(31)), (None, Some(1.0)));
        assert_eq!(samples.consecutive_rows().len(), 4 * 29);
    }

    #[test]
    fn a_load_that_changes_ends_a_rest_as_a_command_does_that_nobody_saw() {
        let mut samples = Samples::alike(1, 30);
        samples.trials[0].commands = Rows::new(1);
        (1..30).for_each(|_| samples.trials[0].commands.push(&[1.0]));
        assert_eq!(dwells(&samples).iter().map(Vec::len).collect::<Vec<_>>(), [24]);
        let loads = |k: usize| TipWrench {
            force_n: [f64::from(u8::from(k >= 15)), 0.0, 0.0].into(),
            ..TipWrench::default()
        };
        let mut loaded = samples.clone();
        loaded.trials[0].tip_loads = Some((0..29).map(loads).collect());
        assert_eq!(dwells(&loaded).iter().map(Vec::len).collect::<Vec<_>>(), [10, 9]);
        // The command leaves and returns while the tracker sees nothing.
        let mut away = samples;
        away.trials[0].commands = Rows::new(1);
        (1..30).for_each(|k| away.trials[0].commands.push(&[if k == 15 { 2.0 } else { 1.0 }]));
        away.rows.retain(|row| !(14..17).contains(&row.row));
        assert_eq!(dwells(&away).iter().map(Vec::len).collect::<Vec<_>>(), [8, 8]);
    }
}
