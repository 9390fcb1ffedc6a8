//! `spinebench calibrate`.

use super::several::{mismatch, poses_at_rest, refuse_twins};
use crate::cli::program::interrupted::exit_on_interrupt;
use crate::cli::program::outputs::{REPORT_BYTES, check_folder, check_yaml};
use crate::cli::program::shared::StartsArg;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::calibration::{
    AUTO, Calibration, CalibrationError, CalibrationOptions, ErrorLaw, HoldOut, Recordings,
    calibrate,
};
use spinebench::data::calibration::{CalibrationFindings, HeldOutError};
use spinebench::data::{Recording, write_atomic};
use spinebench::effects::Model;
use spinebench::report::calibration::{CalibrationReport, calibration_artifacts};
use spinebench::report::write;
use spinebench::runner::Progress;
use spinebench::specs::{model_text, read_model};
use spinebench::tasks::read_to_calibrate;
use std::path::PathBuf;

/// Fit Young's modulus (and what --fit names) to recordings.
#[derive(Args)]
pub(crate) struct CalibrateCommand {
    /// Model to start from.
    #[arg(long, value_name = "MODEL.yaml")]
    model: PathBuf,
    /// Recordings of the robot: tendon tensions (`tendon_1_n`…) or displacements (`tendon_1_m`…),
    /// tracked positions, and known loads (`known_load_kg`, `tip_force_x_n`…) of each recording.
    #[arg(long, value_name = "REC.csv", required = true, num_args = 1..)]
    measured: Vec<PathBuf>,
    /// Model to write.
    #[arg(long, value_name = "MODEL2.yaml")]
    out: PathBuf,
    /// Fit these numbers of the model file (comma-separated): paths such as
    /// `robot.tendons.angles_deg[3]`, groups with `*`, `PATH=start` and `PATH~deviation`; or
    /// `auto`, which adds groups in stages and keeps those that the data support. See
    /// docs/reference/calibration.md.
    #[arg(long, value_name = "PATH,…", value_delimiter = ',', default_value = "youngs_modulus_pa")]
    fit: Vec<String>,
    /// Keep an entry of --fit only if it lowers the blocked cross-validation error.
    #[arg(long)]
    select: bool,
    /// Treat every row of the recording as a pose at rest.
    #[arg(long = "static")]
    at_rest: bool,
    #[command(flatten)]
    starts: StartsArg,
    /// Hold this share of the trials (or patterns) out of the fit.
    #[arg(long, value_name = "SHARE", value_parser = share, conflicts_with = "hold_out_patterns")]
    hold_out: Option<f64>,
    /// Hold the rows of these patterns out of the fit (comma-separated; `*` stands for any text).
    /// Of several recordings `400g/circle`, or `400g/*` for all of 400g.csv.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    hold_out_patterns: Vec<String>,
    /// Assume this distribution of the errors. Default: normal, or Student's t if least squares
    /// leaves outliers.
    #[arg(long, value_name = "NAME", value_parser = ["normal", "student_t"])]
    likelihood: Option<String>,
    /// Write calibration.json, report.html, figures and tables to this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| *share > 0.0 && *share < 1.0);
    share.ok_or_else(|| "expected a number between 0 and 1".to_owned())
}

impl CalibrateCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let model = self.starts.applied(read_model(&self.model).map_err(CommandError::bad_input)?);
        let parts: Vec<Recording> = self
            .measured
            .iter()
            .map(|file| read_to_calibrate(file, &model, self.at_rest))
            .collect::<Result<_, _>>()
            .map_err(CommandError::bad_input)?;
        refuse_twins(&self.measured, &parts)?;
        let files = self.measured.iter().map(PathBuf::as_path);
        let at_rest = poses_at_rest(self.at_rest, files.zip(&parts), progress)?;
        let measured = Recordings::new(&self.measured, &parts)
            .map_err(|error| mismatch(&self.measured, &error))?;
        check_yaml(&self.out)?;
        self.report.as_ref().map_or(Ok(()), |folder| check_folder(folder, REPORT_BYTES))?;
        exit_on_interrupt(
            "interrupted; nothing was written. The same command starts again from the beginning",
        );
        progress.step("fitting");
        let calibration = calibrate(&model, &measured, &self.options(at_rest))
            .map_err(|error| self.refusal(&error, &model))?;
        progress.done();
        let text = model_text(&calibration.model).map_err(CommandError::failed)?;
        let report = CalibrationReport {
            findings: &calibration.findings,
            sightings: &calibration.sightings,
        };
        let files = calibration_artifacts(&report).map_err(CommandError::failed)?;
        write_atomic(&self.out, text.as_bytes()).map_err(CommandError::bad_input)?;
        if let Some(folder) = &self.report {
            std::fs::create_dir_all(folder).map_err(|error| {
                CommandError::BadInput(format!("{}: {error}", folder.display()))
            })?;
            write(&files, folder, folder).map_err(CommandError::bad_input)?;
        }
        if let Some(words) = model.tracking.starts.told() {
            println!("{words}");
        }
        print(&calibration);
        if let Some(words) = model.unusual_number(&self.model) {
            println!("note: {words}");
        }
        if let Some(folder) = &self.report {
            println!("{}", folder.join("report.html").display());
        }
        progress.say(&format!("wrote {}", self.out.display()));
        Ok(())
    }

    fn options(&self, at_rest: bool) -> CalibrationOptions {
        let hold_out = match self.hold_out {
            Some(share) => HoldOut::Share(share),
            None if self.hold_out_patterns.is_empty() => HoldOut::CrossValidated,
            None => HoldOut::Patterns(self.hold_out_patterns.clone()),
        };
        let likelihood = self.likelihood.as_deref().map(|name| match name {
            "student_t" => ErrorLaw::StudentT,
            _ => ErrorLaw::Normal,
        });
        let select = self.select;
        let validate = self.report.is_some() || select || self.fit == [AUTO];
        CalibrationOptions {
            fit: self.fit.clone(),
            select,
            at_rest,
            hold_out,
            likelihood,
            validate,
        }
    }

    /// An error with the file or the argument that it is about.
    fn refusal(&self, error: &CalibrationError, model: &Model) -> CommandError {
        let place = match error {
            CalibrationError::Entry { .. } | CalibrationError::Repeated(_) => "--fit".to_owned(),
            CalibrationError::Unknown { .. }
            | CalibrationError::NoNumber { .. }
            | CalibrationError::Idle { .. }
            | CalibrationError::Option(_) => self.model.display().to_string(),
            _ => {
                let files: Vec<String> =
                    self.measured.iter().map(|file| file.display().to_string()).collect();
                files.join(", ")
            }
        };
        let unusual = match error {
            CalibrationError::NotSimulated { .. } => model.unusual_number(&self.model),
            _ => None,
        };
        let hint = unusual.map_or_else(String::new, |words| format!("; {words}"));
        CommandError::BadInput(format!("{place}: {error}{hint}"))
    }
}

/// Prints the result.
fn print(calibration: &Calibration) {
    let CalibrationFindings { numbers, before_m, after_m, positions, rows, .. } =
        &calibration.findings;
    for number in numbers {
        let (name, value, low, high) = (&number.name, number.value, number.low, number.high);
        println!("{name}: {value:.5e}, 95 % interval {low:.5e} to {high:.5e}");
        if !number.determined {
            println!("  not determined by this recording");
        }
    }
    let (before_mm, after_mm) = (before_m * 1e3, after_m * 1e3);
    let what = if positions == rows { "tip error" } else { "error of all points" };
    println!("rms {what} over {rows} rows: {before_mm:.3} mm before, {after_mm:.3} mm after");
    for stage in &calibration.findings.stages {
        let kept = if stage.kept { "kept" } else { "left out" };
        let error_mm = 1e3 * stage.cross_validated_m;
        println!(
            "  {:<32} {:3} numbers, cross-validated {error_mm:8.3} mm: {kept}",
            stage.name, stage.numbers
        );
    }
    if let Some(held_out) = &calibration.findings.held_out {
        print_held_out(held_out);
    }
    for pair in &calibration.findings.trade_offs {
        println!(
            "the estimates of {} and {} are strongly correlated ({:.3})",
            pair.first, pair.second, pair.correlation
        );
    }
    for limitation in &calibration.findings.limitations {
        println!("note: {limitation}");
    }
}

fn print_held_out(held_out: &HeldOutError) {
    println!("rms error on {} unseen positions ({}):", held_out.positions, held_out.how);
    for model in &held_out.models {
        println!("  {:<24} {:8.3} mm", model.name, 1e3 * model.rms_m);
    }
}
