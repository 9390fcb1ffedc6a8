//! Models played on the commands of samples.

use rayon::prelude::*;

use super::samples::{Samples, TrialCommands};
use crate::effects::{EffectSpec, Model, Trial, replay};

/// First looks and rough fits are played with a tolerance that is larger by this: what they are followed by corrects them.
const COARSER: f64 = 10.0;

/// `model` with coarser steps in time, which take half as long.
pub(super) fn coarse(model: &Model) -> Model {
    let mut coarse = model.clone();
    coarse.robot.resolution.motion_tolerance_m *= COARSER;
    coarse
}

/// Where `model` with `extra` effects has the tip in every sample, three numbers a sample, metres; none where it cannot
/// follow the commands. Trials run beside each other.
pub(super) fn tips(model: &Model, extra: &[EffectSpec], samples: &Samples) -> Option<Vec<f64>> {
    let played: Vec<Vec<[f64; 3]>> =
        samples.trials.par_iter().map(|trial| play(model, extra, trial)).collect::<Option<_>>()?;
    Some(samples.rows.iter().flat_map(|row| played[row.trial][row.row]).collect())
}

fn play(model: &Model, extra: &[EffectSpec], trial: &TrialCommands) -> Option<Vec<[f64; 3]>> {
    let commands = Trial {
        commands: &trial.commands,
        durations_s: &trial.durations_s,
        tensions: trial.tensions,
        at_rest: false,
        tip_loads: trial.tip_loads.as_deref(),
    };
    let hung = (trial.known_load_kg > 0.0).then(|| EffectSpec::tip_load(trial.known_load_kg));
    let extra: Vec<EffectSpec> = extra.iter().cloned().chain(hung).collect();
    let tips = replay(model, &extra, &commands, &[]).ok()?.tips_m;
    tips.iter().flatten().all(|x| x.is_finite()).then_some(tips)
}
