//! `spinebench calibrate`.

use super::shared::StartsArg;
use super::simulate::{one_gravity, read_measured_tip};
use super::{CommandError, CommandResult};
use clap::Args;
use spinebench::calibration::{CALIBRATION_PARAMETERS, calibrate};
use spinebench::data::write_atomic;
use spinebench::specs::{model_text, read_model};
use spinebench::tasks::TaskError;
use std::path::PathBuf;

/// Fit Young's modulus (and what --fit names) to a recording.
#[derive(Args)]
pub(super) struct CalibrateCommand {
    /// Model to start from.
    #[arg(long, value_name = "MODEL.yaml")]
    model: PathBuf,
    /// Recording of the robot: tendon tensions (`tendon_1_n`…) or displacements (`tendon_1_m`…), and the tip.
    #[arg(long, value_name = "REC.csv")]
    measured: PathBuf,
    /// Model to write.
    #[arg(long, value_name = "MODEL2.yaml")]
    out: PathBuf,
    /// Parameters to fit (comma-separated).
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', default_value = "youngs_modulus_pa", value_parser = names())]
    fit: Vec<String>,
    /// Treat every row of the recording as a pose at rest.
    #[arg(long = "static")]
    at_rest: bool,
    #[command(flatten)]
    starts: StartsArg,
}

fn names() -> clap::builder::PossibleValuesParser {
    CALIBRATION_PARAMETERS.iter().map(|field| field.name).collect::<Vec<_>>().into()
}

impl CalibrateCommand {
    pub(super) fn execute(self) -> CommandResult {
        let model = self.starts.applied(read_model(&self.model).map_err(CommandError::bad_input)?);
        let measured = read_measured_tip(&self.measured, &model, self.at_rest)?;
        one_gravity(&self.measured, &measured, &model)?;
        if !self.at_rest {
            measured.check_duration(&self.measured).map_err(CommandError::bad_input)?;
        }
        let found = calibrate(&model, &measured, &self.fit, self.at_rest).map_err(|error| {
            let file = if matches!(error, TaskError::Option(_)) { &self.model } else { &self.measured };
            CommandError::bad_input(format!("{}: {error}", file.display()))
        })?;
        let text = model_text(&found.model).map_err(CommandError::failed)?;
        write_atomic(&self.out, text.as_bytes()).map_err(CommandError::bad_input)?;
        if let Some(words) = model.tracking.starts.told() {
            println!("{words}");
        }
        for number in &found.numbers {
            let [low, high] = number.interval_95;
            println!("{}: {:.5e}, 95 % interval {low:.5e} to {high:.5e}", number.name, number.value);
            if high.is_infinite() {
                println!("  this recording does not determine it");
            }
        }
        let (before_mm, after_mm) = (found.before_m * 1e3, found.after_m * 1e3);
        println!("rms tip error over {} rows: {before_mm:.3} mm before, {after_mm:.3} mm after", found.rows);
        Ok(())
    }
}
