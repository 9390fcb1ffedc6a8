//! Derivatives of the tip against finite differences of whole runs: commands, loads, every number
//! of a robot and of every effect, at rest and in motion.

mod at_rest;
mod motion;
mod numbers;
mod points;
mod support;

use spinebench::base::PlantError;
use spinebench::effects::{ReplayError, Trial, Variable, VariationError, replay};
use support::{Commands, SIZE_M, rows, shipped};

#[test]
fn what_cannot_be_played_is_named() {
    let model = shipped("nominal");
    let commands = Commands::loops(&model, SIZE_M, false);
    let short = Trial { durations_s: &[0.2], ..commands.trial() };
    let error = replay(&model, &[], &short, &[]).unwrap_err();
    assert_eq!(error.to_string(), "durations: found 1, expected one per command, 12");
    let fifth = [Variable::Force(0), Variable::Command { tendon: 4, commands: 0..1 }];
    let error = replay(&model, &[], &commands.trial(), &fifth).unwrap_err();
    assert_eq!(error, ReplayError::Variation(VariationError::Missing(1)));
    let narrow = rows(&[[0.0; 3]]);
    let trial = Trial { commands: &narrow, durations_s: &[0.2], ..commands.trial() };
    let error = replay(&model, &[], &trial, &[]).unwrap_err();
    assert!(matches!(error, ReplayError::Plant(PlantError::Refused(_))), "{error}");
}
