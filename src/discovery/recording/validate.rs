//! Minimum requirements on a recording, and its limitations.

use super::samples::Samples;
use crate::data::Recording;
use crate::discovery::error::DiscoveryError;

/// Minimum number of tracked rows.
const FEWEST_SAMPLES: usize = 30;
/// Minimum number of tracked rows in the training part and in the held-out part.
const FEWEST_TO_FIT: usize = 15;
const FEWEST_TO_PROVE: usize = 5;
/// One trial to fit and one to hold out.
const FEWEST_TRIALS: usize = 2;
/// Below these numbers the answer carries a limitation.
const FEW_SAMPLES: usize = 100;
const FEW_TRIALS: usize = 4;

/// Refuses a recording that contains no information about the robot.
pub(crate) fn check(measured: &Recording, samples: &Samples) -> Result<(), DiscoveryError> {
    let tracked = samples.len();
    if tracked < FEWEST_SAMPLES {
        return Err(DiscoveryError::TooFew { what: "tracked rows", found: tracked, least: FEWEST_SAMPLES, why: "" });
    }
    let rows = measured.len();
    if (1..rows).all(|row| measured.commands.row(row) == measured.commands.row(0)) {
        let expected = "commands that move the robot";
        return Err(DiscoveryError::Constant { column: "tendon_1_m…", rows, expected });
    }
    let first_m = |point: Option<usize>| samples.rows.iter().find(|row| row.point == point).map(|row| row.position_m);
    if samples.rows.iter().all(|row| Some(row.position_m) == first_m(row.point)) {
        let expected = "a tip that moves with the commands (is the tracker frozen?)";
        return Err(DiscoveryError::Constant { column: "tip_x_m,tip_y_m,tip_z_m", rows: tracked, expected });
    }
    Ok(())
}

/// Refuses a recording with too few trials to hold one out.
pub(crate) fn check_trials(samples: &Samples) -> Result<(), DiscoveryError> {
    let trials = samples.trials.len();
    if trials < FEWEST_TRIALS {
        let why = ": one is held out for the test";
        return Err(DiscoveryError::TooFew { what: "tracked trials", found: trials, least: FEWEST_TRIALS, why });
    }
    Ok(())
}

/// Refuses a split whose parts are too small.
pub(crate) fn check_parts(fit: &Samples, held_out: &Samples) -> Result<(), DiscoveryError> {
    let [to_fit, to_prove] = [fit, held_out].map(Samples::len);
    if to_fit < FEWEST_TO_FIT {
        let why = ": the other trials are held out for the test";
        return Err(DiscoveryError::TooFew { what: "tracked rows to fit", found: to_fit, least: FEWEST_TO_FIT, why });
    }
    if to_prove < FEWEST_TO_PROVE {
        let what = "tracked rows in held-out trials";
        return Err(DiscoveryError::TooFew { what, found: to_prove, least: FEWEST_TO_PROVE, why: "" });
    }
    Ok(())
}

/// Limitations of the data. `asked`: the samples that were used.
pub(crate) fn limitations(measured: &Recording, asked: &Samples) -> Vec<String> {
    let mut found = Vec::new();
    let rows = measured.len();
    let tracked = (0..rows).filter(|&row| measured.is_valid(row) && measured.is_seen(row)).count();
    if tracked < rows {
        found.push(format!("Tracking was lost in {} of {rows} rows; these rows were excluded.", rows - tracked));
    }
    if asked.len() < FEW_SAMPLES {
        found.push(format!("Only {} samples: only strong effects can be told apart.", asked.len()));
    }
    if asked.trials.len() == FEWEST_TRIALS {
        found.push(
            "Two trials, of which one is held out: the cross-trial test needs at least two fitted trials.".to_owned(),
        );
    } else if asked.trials.len() < FEW_TRIALS {
        found.push(format!(
            "Only {} trials: an effect that appears in one of them cannot be told from chance.",
            asked.trials.len()
        ));
    }
    let copies = measured.copies();
    if !copies.is_empty() {
        let numbers = copies.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
        found.push(format!(
            "Exact copies of other trials are no independent evidence and make the noise floor too small: trials \
         {numbers}."
        ));
    }
    if measured.base.is_none() {
        found.push(
            "The base was not tracked: at the tip, a tilted base and a rotated tracking frame cannot be told \
         apart."
                .to_owned(),
        );
    }
    found
}
