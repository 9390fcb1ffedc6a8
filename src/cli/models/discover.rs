//! `spinebench discover`.

use super::several::{mismatch, poses_at_rest, refuse_twins};
use crate::cli::program::interrupted::exit_on_interrupt;
use crate::cli::program::outputs::{REPORT_BYTES, check_folder};
use crate::cli::program::shared::StartsArg;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use clap::builder::PossibleValuesParser;
use spinebench::base::Seed;
use spinebench::data::{Recording, read_text};
use spinebench::discovery::{
    Discovery, DiscoveryError, Options, Question, Round, Rounds, RoundsError, discover_until_named,
    with_step_listener,
};
use spinebench::effects::{CATALOGUE, Model};
use spinebench::report::discovery::{DiscoverySources, GivenRecordings, is_commands, write_folder};
use spinebench::runner::{AskedDiscovery, Progress, discovery_files};
use spinebench::specs::{
    PlantSpec, SimulatedSpec, files_behind, read_model, read_options, read_plant,
};
use spinebench::tasks::{SimulationOptions, read_to_explain, simulate_recording};
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Find the effect that a model lacks: compare it with measured data, name the effect, fit it and
/// add it to the model.
#[derive(Args)]
pub(crate) struct DiscoverCommand {
    /// Model of the robot.
    #[arg(long, value_name = "MODEL.yaml")]
    model: PathBuf,
    /// Recordings to explain (CSV or Parquet).
    #[arg(long, value_name = "REC.csv", num_args = 1.., required = true)]
    measured: Vec<PathBuf>,
    /// Recording of the robot as built. Calibrate the model on it and ignore errors that both
    /// recordings share.
    #[arg(long, value_name = "REC.csv")]
    baseline: Option<PathBuf>,
    /// Write findings.json, model.yaml, report.html, figures and tables to this folder.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Read settings of the search, such as `most_effects: 2`, from this file; see
    /// docs/reference/discovery.md.
    #[arg(long, value_name = "OPTIONS.yaml")]
    options: Option<PathBuf>,
    /// Exclude these effects from the search (comma-separated).
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = names())]
    leave_out: Vec<String>,
    /// While the verdict is `ambiguous`, record the proposed next measurement on this simulated
    /// plant.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: Option<PathBuf>,
    /// Maximum number of recordings on the plant.
    #[arg(long, default_value_t = 3, requires = "plant")]
    rounds: u64,
    #[command(flatten)]
    starts: StartsArg,
    /// Treat every row as a pose at rest under its own command; ignore the times.
    #[arg(long = "static")]
    at_rest: bool,
}

/// Recordings that were made on the way, with their files.
type RecordedFiles = Vec<(PathBuf, Recording)>;

fn names() -> PossibleValuesParser {
    CATALOGUE.iter().map(|card| card.name).collect::<Vec<_>>().into()
}

impl DiscoverCommand {
    pub(crate) fn execute(self, progress: &Arc<Progress>) -> CommandResult {
        self.check_out()?;
        let written = read_model(&self.model).map_err(CommandError::bad_input)?;
        let model = self.starts.applied(written.clone());
        let mut options = match &self.options {
            Some(file) => read_options(file).map_err(CommandError::bad_input)?,
            None => Options::default(),
        };
        options.left_out.extend(self.leave_out.iter().cloned());
        options.at_rest |= self.at_rest;
        let parts: Vec<Recording> = self
            .measured
            .iter()
            .map(|file| read_to_explain(file, &model, options.at_rest))
            .collect::<Result<_, _>>()
            .map_err(CommandError::bad_input)?;
        refuse_twins(&self.measured, &parts)?;
        let measured =
            Recording::joined(&parts).map_err(|error| mismatch(&self.measured, &error))?;
        let baseline = self
            .baseline
            .as_ref()
            .map(|file| read_to_explain(file, &model, options.at_rest))
            .transpose();
        let baseline = baseline.map_err(CommandError::bad_input)?;
        let files = self.measured.iter().chain(&self.baseline).map(PathBuf::as_path);
        options.at_rest =
            poses_at_rest(options.at_rest, files.zip(parts.iter().chain(&baseline)), progress)?;
        self.refuse_own_baseline(&measured, baseline.as_ref())?;
        let plant = self.plant.as_ref().map(|file| simulated(file, &model)).transpose()?;
        check_folder(&self.out, REPORT_BYTES)?;
        exit_on_interrupt(
            "interrupted; nothing was written. The same command starts again from the beginning",
        );
        let files: Vec<&Path> = self.measured.iter().map(PathBuf::as_path).collect();
        let mut given = GivenRecordings::new(&files, &parts, baseline.as_ref());
        let question = Question { model: &model, baseline: baseline.as_ref(), options: &options };
        let (mut answer, measured, recorded) =
            self.answer(question, measured, &mut given, plant.as_ref(), progress)?;
        progress.done();
        answer.findings.limitations.extend(model.tracking.starts.told().map(str::to_owned));
        answer.findings.limitations.extend(written.unusual_number(&self.model));
        // The model is written as it was given, whatever `--starts` says.
        answer.model.tracking.clone_from(&written.tracking);
        // A file that cannot be read any more counts as empty.
        let model_text = read_text(&self.model).unwrap_or_default();
        let sources = DiscoverySources::new(
            &self.model,
            &given,
            self.baseline.as_deref(),
            self.further_options(options.at_rest),
        );
        let asked = AskedDiscovery {
            model: &written,
            model_text: &model_text,
            measured: &measured,
            at_rest: options.at_rest,
            sources: &sources,
        };
        self.write(&answer, &asked, &recorded)?;
        if !progress.is_quiet() {
            println!("{}", answer.findings.summary);
            println!("next: {}", answer.findings.next_measurement);
            println!("{}", self.out.join("report.html").display());
        }
        Ok(())
    }

    /// The options that decide about the answer, beside the files, as they are typed.
    fn further_options(&self, at_rest: bool) -> Vec<String> {
        let file = self.options.iter().map(|file| format!("--options {}", file.display()));
        let left_out = self.leave_out.iter().map(|name| format!("--leave-out {name}"));
        let at_rest = at_rest.then(|| "--static".to_owned());
        file.chain(left_out).chain(at_rest).collect()
    }

    /// Refuses an output path that is a file, and a folder in which an output would overwrite an
    /// input.
    fn check_out(&self) -> CommandResult {
        let refuse = |found: String, expected: &str| {
            Err(CommandError::BadInput(format!(
                "{}: found {found}, expected {expected}",
                self.out.display()
            )))
        };
        if let Some(there) =
            self.out.ancestors().find(|place| place.exists()).filter(|place| !place.is_dir())
        {
            let what = if there == self.out {
                "a file".to_owned()
            } else {
                format!("the file {}", there.display())
            };
            return refuse(what, "a folder, or a path that does not exist");
        }
        let Ok(out) = self.out.canonicalize() else { return Ok(()) };
        let specs = [Some(&self.model), self.options.as_ref(), self.plant.as_ref()];
        let behind = specs.into_iter().flatten().flat_map(|file| files_behind(file));
        for file in self.measured.iter().chain(&self.baseline).cloned().chain(behind) {
            let Ok(place) = file.canonicalize() else { continue };
            let name = place
                .file_name()
                .map(|name| name.to_string_lossy().into_owned())
                .unwrap_or_default();
            if place.parent() == Some(&*out) && is_written(&name) {
                return refuse(format!("input file {name} in it"), "a folder without input files");
            }
        }
        Ok(())
    }

    /// Refuses a baseline that contains the whole recording.
    fn refuse_own_baseline(
        &self,
        measured: &Recording,
        baseline: Option<&Recording>,
    ) -> CommandResult {
        match (&self.baseline, baseline) {
            (Some(file), Some(baseline)) if baseline.holds(measured) => {
                Err(CommandError::BadInput(format!(
                    "{}: found all trials of the measured recording, expected a separate recording \
                     of the robot as built",
                    file.display()
                )))
            }
            _ => Ok(()),
        }
    }

    /// The answer, with more recordings from the plant as long as it is ambiguous; all that was
    /// measured, and these recordings with their files.
    fn answer(
        &self,
        question: Question,
        measured: Recording,
        given: &mut GivenRecordings,
        plant: Option<&SimulatedSpec>,
        progress: &Arc<Progress>,
    ) -> Result<(Discovery, Recording, RecordedFiles), CommandError> {
        let mut files = Vec::new();
        let record = |round: &Round| -> Result<Option<Recording>, Infallible> {
            // The plant file defines the base pose, so the base cannot be remounted.
            let (Some(plant), Some(next)) = (plant, round.proposal_without_remounting()) else {
                return Ok(None);
            };
            if !progress.is_quiet() {
                println!("round {}: {}", round.number, round.answer.findings.summary);
                println!("recording on the plant: {}", next.proposal.what);
            }
            let play_options = SimulationOptions {
                at_rest: false,
                noise_m: plant.noise_m,
                travel_m: plant.travel_m,
                // The seed differs from that of recordings made by an earlier call.
                seed: Seed(question.options.seed)
                    .child("plant")
                    .index(round.measured.trials().len() as u64),
            };
            let mut recorded = simulate_recording(&plant.model, &next.commands, &play_options);
            recorded.forget_orientations();
            recorded.extra.clear();
            let file =
                self.out.join(format!("recorded_{}_{}.csv", round.number, next.proposal.name));
            given.extend(&file, &recorded);
            files.push(file);
            Ok(Some(recorded))
        };
        let steps = Arc::clone(progress);
        let rounds = with_step_listener(
            move |step| steps.step(step),
            || discover_until_named(question, measured, self.rounds as usize, record),
        )
        .map_err(|error| match error {
            RoundsError::Discovery { error, measured } => {
                self.refusal(&error, question.model, &measured, &given.trials)
            }
            RoundsError::Mismatch(error) => CommandError::failed(error),
            RoundsError::Record(never) => match never {},
        })?;
        let Rounds { mut answer, recorded, measured, .. } = rounds;
        answer.findings.limitations.extend(given.limitations(&measured));
        Ok((answer, measured, files.into_iter().zip(recorded).collect()))
    }

    /// Data that allow no answer, with the file that they are in and the number of a trial there;
    /// with all files where it is all of them.
    fn refusal(
        &self,
        error: &DiscoveryError,
        model: &Model,
        measured: &Recording,
        trials: &[(PathBuf, u64)],
    ) -> CommandError {
        let hint = match error {
            DiscoveryError::CannotFollow(_) | DiscoveryError::Baseline(_) => {
                model.unusual_number(&self.model)
            }
            _ => None,
        };
        let hint = hint.map_or_else(String::new, |words| format!("; {words}"));
        let refused = |file: &Path, error: &DiscoveryError| {
            CommandError::BadInput(format!("{}: {error}{hint}", file.display()))
        };
        let all = || {
            self.measured
                .iter()
                .map(|file| file.display().to_string())
                .collect::<Vec<_>>()
                .join(", ")
        };
        match error {
            DiscoveryError::Baseline(_) => {
                refused(self.baseline.as_ref().unwrap_or(&self.model), error)
            }
            DiscoveryError::Option(_) => {
                refused(self.options.as_ref().unwrap_or(&self.model), error)
            }
            DiscoveryError::CannotFollow(number) => {
                let place = measured.trials().iter().position(|(other, _)| other == number);
                let is_measured = |(file, _): &&(PathBuf, u64)| self.measured.contains(file);
                match place.and_then(|place| trials.get(place)).filter(is_measured) {
                    Some((file, number_there)) => {
                        refused(file, &DiscoveryError::CannotFollow(*number_there))
                    }
                    None => CommandError::BadInput(format!("{}: {error}{hint}", all())),
                }
            }
            _ => CommandError::BadInput(format!("{}: {error}", all())),
        }
    }

    /// Writes all outputs after all of them are computed; `findings.json` last.
    fn write(
        &self,
        answer: &Discovery,
        asked: &AskedDiscovery,
        recorded: &[(PathBuf, Recording)],
    ) -> CommandResult {
        let files = discovery_files(answer, asked).map_err(CommandError::failed)?;
        std::fs::create_dir_all(&self.out)
            .map_err(|error| CommandError::failed(format!("{}: {error}", self.out.display())))?;
        for (file, recording) in recorded {
            recording.write(file).map_err(CommandError::failed)?;
        }
        write_folder(&self.out, &files).map_err(CommandError::failed)
    }
}

/// Whether `discover` writes a file of this name.
fn is_written(name: &str) -> bool {
    let always =
        ["findings.json", "model.yaml", "residuals.csv", "disagreement.csv", "candidates.csv"];
    always.contains(&name)
        || is_commands(name)
        || name.starts_with("recorded_") && name.ends_with(".csv")
}

/// Reads a simulated plant with as many tendons as the model.
fn simulated(file: &Path, model: &Model) -> Result<SimulatedSpec, CommandError> {
    let refuse = |found: String, expected: String| {
        CommandError::BadInput(format!("{}: found {found}, expected {expected}", file.display()))
    };
    match read_plant(file).map_err(CommandError::bad_input)? {
        PlantSpec::Simulated(plant) => {
            let plant = *plant;
            let (tendons, expected) =
                (plant.model.robot.tendons.angles_deg.len(), model.robot.tendons.angles_deg.len());
            if tendons == expected {
                return Ok(plant);
            }
            Err(refuse(
                format!("{tendons} tendons"),
                format!("{expected}, the number of tendons of the model"),
            ))
        }
        other => Err(refuse(other.kind().to_owned(), "a simulated plant".to_owned())),
    }
}
