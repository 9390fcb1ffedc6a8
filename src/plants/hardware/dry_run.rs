//! Dry run: checks commands against the limits without the robot.

use crate::data::Recording;
use crate::hardware::safety::{CommandRefusal, SafetyLimits};

/// Summary of a recording's commands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DryRun {
    /// Trials.
    pub trials: usize,
    /// Commands that are sent. That of a trial's last row is not: nothing is measured after it.
    pub commands: usize,
    /// Ticks that they take; a command longer than one step takes several.
    pub ticks: usize,
    /// Largest change of a displacement from one command to the next, metres.
    pub largest_step_m: f64,
    /// Row of that change, from 0.
    pub largest_row: usize,
    /// Smallest and largest displacement, metres.
    pub reach_m: [f64; 2],
}

/// The first command that the robot would refuse.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{refusal}")]
pub struct RefusedRow {
    /// Its row, from 0.
    pub row: usize,
    /// Reason.
    pub refusal: CommandRefusal,
}

/// Checks `commands` (displacements) against `limits`, in ticks of `step_s`; every trial starts at
/// home.
///
/// # Errors
/// [`RefusedRow`]: the first command that the robot would refuse.
pub fn dry_run(
    limits: &SafetyLimits,
    commands: &Recording,
    step_s: f64,
) -> Result<DryRun, RefusedRow> {
    let mut summary = DryRun::default();
    for (_, rows) in commands.trials() {
        summary.trials += 1;
        let mut last_m = vec![0.0; commands.tendons()];
        for row in rows.start..rows.end - 1 {
            let pulls_m = commands.commands.row(row);
            let ticks = limits.check_in_ticks(pulls_m, &last_m, step_s);
            summary.ticks += ticks.map_err(|refusal| RefusedRow { row, refusal })?;
            summary.commands += 1;
            let changes = pulls_m.iter().zip(&last_m).map(|(to, from)| (to - from).abs());
            let step_m = changes.fold(0.0, f64::max);
            if step_m > summary.largest_step_m {
                (summary.largest_step_m, summary.largest_row) = (step_m, row);
            }
            let [low, high] = summary.reach_m;
            summary.reach_m = pulls_m
                .iter()
                .fold([low, high], |[low, high], &pull| [low.min(pull), high.max(pull)]);
            last_m = pulls_m.to_vec();
        }
    }
    Ok(summary)
}
