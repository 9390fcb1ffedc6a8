//! Minimum requirements on a recording, and its limitations.

use super::samples::Samples;
use crate::data::Recording;
use crate::discovery::error::DiscoveryError;

/// Minimum number of tracked rows.
const MIN_SAMPLES: usize = 30;
/// Minimum number of tracked rows in the training part and in the held-out part.
const MIN_TRAINING_SAMPLES: usize = 15;
const MIN_HELD_OUT_SAMPLES: usize = 5;
/// One trial to fit and one to hold out.
const MIN_TRIALS: usize = 2;
/// Below these numbers the answer carries a limitation.
const FEW_SAMPLES: usize = 100;
const FEW_TRIALS: usize = 4;

/// Refuses a recording that contains no information about the robot.
pub(crate) fn check(measured: &Recording, samples: &Samples) -> Result<(), DiscoveryError> {
    let tracked = samples.len();
    if tracked < MIN_SAMPLES {
        return Err(DiscoveryError::TooFew {
            what: "tracked rows",
            found: tracked,
            least: MIN_SAMPLES,
            why: "",
        });
    }
    let rows = measured.len();
    if (1..rows).all(|row| measured.commands.row(row) == measured.commands.row(0)) {
        let expected = "commands that move the robot";
        return Err(DiscoveryError::Constant { column: "tendon_1_m…", rows, expected });
    }
    // Each tracked place has its own first position; a frozen tracker repeats all of them.
    let first_m = |point: Option<usize>| {
        samples.rows.iter().find(|row| row.point == point).map(|row| row.position_m)
    };
    if samples.rows.iter().all(|row| Some(row.position_m) == first_m(row.point)) {
        let expected = "a tip that moves with the commands (is the tracker frozen?)";
        return Err(DiscoveryError::Constant {
            column: "tip_x_m,tip_y_m,tip_z_m",
            rows: tracked,
            expected,
        });
    }
    Ok(())
}

/// The same of the measured recording, which needs trials to hold out.
pub(crate) fn check_measured(
    measured: &Recording,
    samples: &Samples,
) -> Result<(), DiscoveryError> {
    check(measured, samples)?;
    let trials = samples.trials.len();
    if trials < MIN_TRIALS {
        let why = ": one is held out for the test";
        return Err(DiscoveryError::TooFew {
            what: "tracked trials",
            found: trials,
            least: MIN_TRIALS,
            why,
        });
    }
    Ok(())
}

/// Refuses a split whose parts are too small.
pub(crate) fn check_parts(training: &Samples, held_out: &Samples) -> Result<(), DiscoveryError> {
    let [to_fit, to_prove] = [training, held_out].map(Samples::len);
    if to_fit < MIN_TRAINING_SAMPLES {
        let why = ": the other trials are held out for the test";
        return Err(DiscoveryError::TooFew {
            what: "tracked rows to fit",
            found: to_fit,
            least: MIN_TRAINING_SAMPLES,
            why,
        });
    }
    if to_prove < MIN_HELD_OUT_SAMPLES {
        let what = "tracked rows in held-out trials";
        return Err(DiscoveryError::TooFew {
            what,
            found: to_prove,
            least: MIN_HELD_OUT_SAMPLES,
            why: "",
        });
    }
    Ok(())
}

/// Limitations of the data, of which these `samples` were used.
pub(crate) fn limitations(measured: &Recording, samples: &Samples) -> Vec<String> {
    let mut sentences = Vec::new();
    let rows = measured.len();
    let tracked = (0..rows).filter(|&row| measured.is_valid(row) && measured.is_seen(row)).count();
    if tracked < rows {
        sentences.push(format!(
            "Tracking was lost in {} of {rows} rows; these rows were excluded.",
            rows - tracked
        ));
    }
    if samples.len() < FEW_SAMPLES {
        sentences.push(format!(
            "Only {} samples: only strong effects can be distinguished.",
            samples.len()
        ));
    }
    if samples.trials.len() == MIN_TRIALS {
        sentences.push(
            "Two trials, of which one is held out: the cross-trial test needs at least two fitted \
             trials."
                .to_owned(),
        );
    } else if samples.trials.len() < FEW_TRIALS {
        sentences.push(format!(
            "Only {} trials: an effect that appears in one of them cannot be distinguished from \
             chance.",
            samples.trials.len()
        ));
    }
    let copies = measured.copies();
    if !copies.is_empty() {
        let numbers = copies.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
        sentences.push(format!(
            "Exact copies of other trials are not independent evidence and make the noise floor \
             too small: trials {numbers}."
        ));
    }
    if measured.base.is_none() {
        sentences.push(
            "The base was not tracked: at the tip, a tilted base and a rotated tracking frame \
             cannot be distinguished."
                .to_owned(),
        );
    }
    sentences
}
