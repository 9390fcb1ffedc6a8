//! Calculations on recordings and specs: simulate, calibrate, discover, run. Results are JSON, columns
//! and CSV, which `spinebench/_calculations.py` makes objects of.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;
use std::time::Instant;

use pyo3::prelude::*;
use spinebench::calibration::{AUTO, CalibrationOptions, ErrorLaw, HoldOut, Recordings, calibrate};
use spinebench::data::{Recording, tables};
use spinebench::discovery::{
    Discovery, Options, Question, Round, RoundsError, discover_until_named, with_step_listener,
};
use spinebench::runner::{self, Campaign, Progress, RunFacts, RunOptions, Store, Style};
use spinebench::specs::{ExperimentSet, read_options};
use spinebench::tasks::{
    SimulationOptions, read_commands, read_to_calibrate, read_to_explain, simulate_recording,
};

use crate::calls::{claim_global_threads, long};
use crate::errors::Fault;
use crate::model::PyModel;
use crate::recordings::{NamedRecording, PyColumn, PyRecording, columns};

/// An error about a file, with its name.
fn about(file: &Path, error: impl Display) -> Fault {
    Fault::words(format!("{}: {error}", file.display()))
}

fn json<T: serde::Serialize>(value: &T) -> Result<String, Fault> {
    serde_json::to_string(value).map_err(|error| Fault::Run(error.to_string()))
}

/// Plays commands on a model; returns the columns of the recording.
#[pyfunction]
pub(crate) fn _simulate(
    py: Python<'_>,
    model: &PyModel,
    commands: PyRecording,
    at_rest: bool,
    noise_m: f64,
    seed: u64,
) -> PyResult<Vec<PyColumn>> {
    if !(noise_m.is_finite() && noise_m >= 0.0) {
        let expected = "a finite number of at least 0, in metres";
        return Err(Fault::argument("noise_m", noise_m.to_string(), expected).into());
    }
    let model = model.clone();
    long(py, move |stop| {
        let commands = commands.named()?;
        let read = read_commands(commands.source(), &model.0, at_rest)?;
        let options = SimulationOptions {
            at_rest,
            noise_m,
            seed: spinebench::base::Seed(seed),
            ..SimulationOptions::default()
        };
        let simulated = stop.within(|| simulate_recording(&model.0, &read, &options));
        columns(&simulated)
    })
}

/// How a model is calibrated.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct CalibrationArguments {
    fit: Vec<String>,
    select: bool,
    at_rest: bool,
    hold_out: Option<f64>,
    hold_out_patterns: Vec<String>,
    likelihood: Option<String>,
    validate: bool,
}

impl CalibrationArguments {
    fn options(self) -> Result<CalibrationOptions, Fault> {
        let hold_out = match self.hold_out {
            Some(share) if !(share > 0.0 && share < 1.0) => {
                return Err(Fault::argument(
                    "hold_out",
                    share.to_string(),
                    "a number between 0 and 1",
                ));
            }
            Some(share) => HoldOut::Share(share),
            None if self.hold_out_patterns.is_empty() => HoldOut::CrossValidated,
            None => HoldOut::Patterns(self.hold_out_patterns),
        };
        let likelihood = match self.likelihood.as_deref() {
            None => None,
            Some("normal") => Some(ErrorLaw::Normal),
            Some("student_t") => Some(ErrorLaw::StudentT),
            Some(other) => {
                return Err(Fault::argument(
                    "likelihood",
                    format!("{other:?}"),
                    "\"normal\", \"student_t\" or None",
                ));
            }
        };
        let validate = self.validate || self.select || self.fit == [AUTO];
        Ok(CalibrationOptions {
            fit: self.fit,
            select: self.select,
            at_rest: self.at_rest,
            hold_out,
            likelihood,
            validate,
        })
    }
}

/// Recordings to be read.
fn named(recordings: Vec<PyRecording>) -> Result<Vec<NamedRecording>, Fault> {
    recordings.into_iter().map(PyRecording::named).collect()
}

/// Fits numbers of a model to recordings; returns the model, the findings as JSON, and every
/// position with its error as CSV.
#[pyfunction]
pub(crate) fn _calibrate(
    py: Python<'_>,
    model: &PyModel,
    measured: Vec<PyRecording>,
    arguments: CalibrationArguments,
) -> PyResult<(PyModel, String, Vec<u8>)> {
    let (model, options) = (model.clone(), arguments.options()?);
    long(py, move |stop| {
        let measured = named(measured)?;
        let read =
            |one: &NamedRecording| read_to_calibrate(one.source(), &model.0, options.at_rest);
        let parts: Vec<Recording> = measured.iter().map(read).collect::<Result<_, _>>()?;
        let files: Vec<&Path> = measured.iter().map(|one| one.source().name()).collect();
        let whole =
            Recordings::new(&files, &parts).map_err(|error| about(files[error.index], &error))?;
        let found = stop
            .within(|| calibrate(&model.0, &whole, &options))
            .map_err(|error| about(files[0], error))?;
        let sightings = tables::to_csv(Path::new("sightings.csv"), &found.sightings)?;
        Ok((PyModel(found.model.into()), json(&found.findings)?, sightings))
    })
}

/// An answer for Python: the extended model, the findings as JSON, residuals and residual map as
/// CSV.
type WrittenDiscovery = (PyModel, String, Vec<u8>, Vec<u8>);

fn written(answer: &Discovery) -> Result<WrittenDiscovery, Fault> {
    let residuals = tables::to_csv(Path::new("residuals.csv"), &answer.residuals)?;
    let places = tables::to_csv(Path::new("disagreement.csv"), &answer.places)?;
    Ok((PyModel(answer.model.clone().into()), json(&answer.findings)?, residuals, places))
}

/// What a discovery is asked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct DiscoverArguments {
    measured: Vec<PyRecording>,
    baseline: Option<PyRecording>,
    options: Option<PathBuf>,
    leave_out: Vec<String>,
    at_rest: bool,
    max_rounds: usize,
}

/// Finds what a model lacks. While the answer is ambiguous, `record` gets it with the commands of
/// its proposals and returns a new recording, or None. Returns the answer of each round.
#[pyfunction]
pub(crate) fn _discover(
    py: Python<'_>,
    model: &PyModel,
    arguments: DiscoverArguments,
    record: Option<Py<PyAny>>,
) -> PyResult<Vec<WrittenDiscovery>> {
    let model = model.clone();
    long(py, move |stop| {
        let DiscoverArguments { measured, baseline, options, leave_out, at_rest, max_rounds } =
            arguments;
        let mut settings =
            options.as_deref().map_or_else(|| Ok(Options::default()), read_options)?;
        settings.left_out.extend(leave_out);
        settings.at_rest |= at_rest;
        let read = |recording: &NamedRecording| {
            read_to_explain(recording.source(), &model.0, settings.at_rest)
        };
        let measured = named(measured)?;
        let parts: Vec<Recording> = measured.iter().map(read).collect::<Result<_, _>>()?;
        let whole = Recording::joined(&parts)
            .map_err(|error| about(measured[error.index].source().name(), &error))?;
        let baseline = baseline.map(PyRecording::named).transpose()?;
        let baseline = baseline.as_ref().map(read).transpose()?;
        let stop = stop.clone();
        // A search that nobody waits for ends at its next step.
        let step = move |_: &str| {
            if stop.raised() {
                resume_unwind(Box::new("interrupted"));
            }
        };
        let ask = |round: &Round| -> Result<Option<Recording>, PyErr> {
            let Some(record) = &record else { return Ok(None) };
            let proposals = round.answer.next_experiments.iter();
            let commands: Vec<Vec<PyColumn>> =
                proposals.map(|next| columns(&next.commands)).collect::<Result<_, Fault>>()?;
            let answer = written(round.answer)?;
            let recorded: Option<PyRecording> =
                Python::attach(|py| record.bind(py).call1((answer, commands))?.extract())?;
            let recorded = recorded.map(PyRecording::named).transpose()?;
            Ok(recorded.as_ref().map(read).transpose().map_err(Fault::from)?)
        };
        let question =
            Question { model: &model.0, baseline: baseline.as_ref(), options: &settings };
        match with_step_listener(step, || discover_until_named(question, whole, max_rounds, ask)) {
            Ok(rounds) => {
                let answers = rounds.earlier.iter().chain([&rounds.answer]);
                Ok(Ok(answers.map(written).collect::<Result<Vec<_>, Fault>>()?))
            }
            Err(RoundsError::Record(exception)) => Ok(Err(exception)),
            Err(RoundsError::Mismatch(error)) => Err(Fault::words(error)),
            Err(RoundsError::Discovery { error, .. }) => {
                Err(about(measured[0].source().name(), error))
            }
        }
    })?
}

/// Where and how specs are run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RunArguments {
    out: PathBuf,
    cache: PathBuf,
    sets: Vec<String>,
    sweeps: Vec<String>,
    jobs: usize,
    /// Policies of this process by name, as entries of a spec, in JSON.
    own: String,
}

/// Reads a spec; with policies of its own in every set of trials.
fn experiments(file: &Path, arguments: &RunArguments) -> Result<ExperimentSet, Fault> {
    let RunArguments { sets, sweeps, own, .. } = arguments;
    let read = ExperimentSet::read(file, sets, sweeps)?;
    let own: BTreeMap<String, serde_json::Value> =
        serde_json::from_str(own).map_err(|error| Fault::Run(error.to_string()))?;
    if own.is_empty() {
        return Ok(read);
    }
    let mut sets = sets.clone();
    sets.extend(own.iter().map(|(name, policy)| format!("policies.outside.{name}={policy}")));
    let with_own = |path: String, policies: &[String]| {
        let more = own.keys().filter(|name| !policies.contains(name));
        let all: Vec<&String> = policies.iter().chain(more).collect();
        format!("{path}.policies={}", serde_json::json!(all))
    };
    let runs = &read.experiment.runs;
    sets.extend(
        runs.reach
            .iter()
            .enumerate()
            .map(|(k, sweep)| with_own(format!("runs.reach[{k}]"), &sweep.policies)),
    );
    sets.extend(runs.track.iter().map(|track| with_own("runs.track".to_owned(), &track.policies)));
    Ok(ExperimentSet::read(file, &sets, sweeps)?)
}

/// Runs specs and writes tables and figures; returns what was computed as JSON.
#[pyfunction]
pub(crate) fn _run(
    py: Python<'_>,
    specs: Vec<PathBuf>,
    arguments: RunArguments,
) -> PyResult<String> {
    claim_global_threads()?;
    long(py, move |stop| {
        let read = |file: &PathBuf| experiments(file, &arguments);
        let experiments = specs.iter().map(read).collect::<Result<Vec<_>, Fault>>()?;
        let RunArguments { out, cache, jobs, .. } = arguments;
        let notes: Vec<Vec<String>> = experiments.iter().map(|set| set.notes.clone()).collect();
        let campaign = Campaign::expand(experiments).map_err(Fault::words)?;
        std::fs::create_dir_all(&out).map_err(|error| about(&out, error))?;
        let (revision, began, store) = (runner::git_revision(), Instant::now(), Store::at(cache));
        let progress = Progress::new(Style::Quiet);
        let options = RunOptions { stop: stop.flag(), ..RunOptions::new(jobs, &progress) };
        let outcomes = runner::execute(&campaign.graph, &store, &campaign.wanted(), &options)
            .map_err(|failure| Fault::Run(failure.to_string()))?;
        stop.check()?;
        let threads = if jobs > 0 { jobs } else { available_parallelism().map_or(1, usize::from) };
        let facts = RunFacts {
            revision: &revision,
            threads: &|_| threads,
            wall_s: began.elapsed().as_secs_f64(),
        };
        let published =
            runner::publish_all(&campaign, &outcomes, &store, &out, &facts).map_err(Fault::Run)?;
        let experiments: Vec<serde_json::Value> = campaign
            .entries
            .iter()
            .zip(&published)
            .zip(&notes)
            .map(|((entry, publication), notes)| {
                let notices: Vec<&String> = notes.iter().chain(&publication.notices).collect();
                serde_json::json!({
                    "name": entry.experiment.name,
                    "files": publication.files.keys().map(|file| out.join(file)).collect::<Vec<_>>(),
                    "failed_trials": publication.failed,
                    "notices": notices,
                })
            })
            .collect();
        let failures: Vec<String> = outcomes.failures.iter().map(ToString::to_string).collect();
        let (computed, cached) = (outcomes.computed, outcomes.cached);
        json(&serde_json::json!({
            "computed": computed, "cached": cached, "failures": failures, "experiments": experiments
        }))
    })
}
