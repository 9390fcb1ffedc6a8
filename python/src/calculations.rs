//! Calculations on recordings and specs: simulate, calibrate, discover, run. Results are JSON, columns
//! and CSV, which `spinebench/_calculations.py` makes objects of.

use std::fmt::Display;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use spinebench::calibration::{AUTO, CalibrationOptions, ErrorLaw, HoldOut, Recordings, calibrate};
use spinebench::data::{DataError, Recording, tables};
use spinebench::discovery::{
    Options, Question, Round, Rounds, RoundsError, discover_until_named, with_step_listener,
};
use spinebench::effects::Model;
use spinebench::report::discovery::{DiscoverySources, GivenRecordings};
use spinebench::specs::read_options;
use spinebench::tasks::{
    SimulationOptions, are_at_rest, read_commands, read_to_calibrate, read_to_explain,
    simulate_recording,
};

use crate::calls::{long, long_watched};
use crate::discovered::{WrittenDiscovery, written};
use crate::errors::Fault;
use crate::model::{GivenModel, PyModel};
use crate::recordings::{NamedRecording, PyColumn, PyRecording, columns};

/// An error about a file, with its name.
pub(crate) fn about(file: &Path, error: impl Display) -> Fault {
    Fault::words(format!("{}: {error}", file.display()))
}

pub(crate) fn json<T: serde::Serialize>(value: &T) -> Result<String, Fault> {
    serde_json::to_string(value).map_err(|error| Fault::Run(error.to_string()))
}

/// Plays commands on a model; returns the columns of the recording.
#[pyfunction]
pub(crate) fn _simulate(
    py: Python<'_>,
    model: GivenModel,
    commands: PyRecording,
    at_rest: bool,
    noise_m: f64,
    seed: u64,
) -> PyResult<Vec<PyColumn>> {
    if !(noise_m.is_finite() && noise_m >= 0.0) {
        let expected = "a finite number of at least 0, in metres";
        return Err(Fault::argument("noise_m", noise_m.to_string(), expected).into());
    }
    let model = model.0.model;
    long(py, move |stop| {
        let commands = commands.named()?;
        let read = read_commands(commands.source(), &model, at_rest)?;
        let options = SimulationOptions {
            at_rest,
            noise_m,
            seed: spinebench::base::Seed(seed),
            ..SimulationOptions::default()
        };
        let simulated = stop.within(|| simulate_recording(&model, &read, &options));
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
    model: GivenModel,
    measured: Vec<PyRecording>,
    arguments: CalibrationArguments,
) -> PyResult<(PyModel, String, Vec<u8>)> {
    let (model, options) = (model.0.model, arguments.options()?);
    long(py, move |stop| {
        let measured = named(measured)?;
        let read = |one: &NamedRecording| read_to_calibrate(one.source(), &model, options.at_rest);
        let parts: Vec<Recording> = measured.iter().map(read).collect::<Result<_, _>>()?;
        let files: Vec<&Path> = measured.iter().map(|one| one.source().name()).collect();
        let at_rest = are_at_rest(options.at_rest, files.iter().copied().zip(&parts))?;
        let options = CalibrationOptions { at_rest, ..options };
        let whole =
            Recordings::new(&files, &parts).map_err(|error| about(files[error.index], &error))?;
        let found = stop
            .within(|| calibrate(&model, &whole, &options))
            .map_err(|error| about(files[0], error))?;
        let sightings = tables::to_csv(Path::new("sightings.csv"), &found.sightings)?;
        Ok((PyModel::from(found.model), json(&found.findings)?, sightings))
    })
}

/// What a discovery is asked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct DiscoverArguments {
    measured: Vec<PyRecording>,
    baseline: Option<PyRecording>,
    options: Option<std::path::PathBuf>,
    leave_out: Vec<String>,
    at_rest: bool,
    max_rounds: usize,
}

/// The steps of a discovery: their number so far, and the last one.
#[derive(Clone, Default)]
struct Steps(Arc<Mutex<(usize, String)>>);

impl Steps {
    fn add(&self, step: &str) {
        let mut steps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *steps = (steps.0 + 1, step.to_owned());
    }

    fn last(&self) -> (usize, String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Reads recordings that a discovery explains.
fn reader(
    model: &Model,
    at_rest: bool,
) -> impl Fn(&NamedRecording) -> Result<Recording, DataError> {
    move |recording| read_to_explain(recording.source(), model, at_rest)
}

/// What a discovery is asked about, as it was read.
struct DiscoveryInput {
    settings: Options,
    measured: Vec<NamedRecording>,
    whole: Recording,
    baseline: Option<Recording>,
    given: GivenRecordings,
    baseline_name: Option<PathBuf>,
    /// The options as the program takes them.
    further: Vec<String>,
}

fn discovery_input(model: &PyModel, arguments: DiscoverArguments) -> Result<DiscoveryInput, Fault> {
    let DiscoverArguments { measured, baseline, options, leave_out, at_rest, .. } = arguments;
    let mut settings = options.as_deref().map_or_else(|| Ok(Options::default()), read_options)?;
    let file = options.iter().map(|file| format!("--options {}", file.display()));
    let left_out = leave_out.iter().map(|name| format!("--leave-out {name}"));
    let mut further: Vec<String> = file.chain(left_out).collect();
    settings.left_out.extend(leave_out);
    settings.at_rest |= at_rest;
    let read = reader(&model.model, settings.at_rest);
    let measured = named(measured)?;
    let parts: Vec<Recording> = measured.iter().map(&read).collect::<Result<_, _>>()?;
    let whole = Recording::joined(&parts)
        .map_err(|error| about(measured[error.index].source().name(), &error))?;
    let of_baseline = baseline.map(PyRecording::named).transpose()?;
    let files = measured.iter().chain(&of_baseline).map(|one| one.source().name());
    let baseline = of_baseline.as_ref().map(&read).transpose()?;
    settings.at_rest =
        are_at_rest(settings.at_rest, files.clone().zip(parts.iter().chain(&baseline)))?;
    further.extend(settings.at_rest.then(|| "--static".to_owned()));
    let files: Vec<&Path> = files.take(parts.len()).collect();
    let given = GivenRecordings::new(&files, &parts, baseline.as_ref());
    let baseline_name = of_baseline.as_ref().map(|one| one.source().name().to_owned());
    Ok(DiscoveryInput { settings, measured, whole, baseline, given, baseline_name, further })
}

/// Finds what a model lacks. While the answer is ambiguous, `record` gets it with the commands of
/// its proposals and returns a new recording, or None. `tell` hears of each step: its number and
/// name. Returns the answer of each round.
#[pyfunction]
pub(crate) fn _discover(
    py: Python<'_>,
    model: GivenModel,
    arguments: DiscoverArguments,
    record: Option<Py<PyAny>>,
    tell: Option<Py<PyAny>>,
) -> PyResult<Vec<WrittenDiscovery>> {
    let (steps, mut told) = (Steps::default(), 0);
    let heard = steps.clone();
    let watch = move |py: Python<'_>| {
        let (number, step) = heard.last();
        if let Some(tell) = tell.as_ref().filter(|_| number > told) {
            told = number;
            tell.bind(py).call1((number, step))?;
        }
        Ok(())
    };
    let model = model.0;
    long_watched(py, watch, move |stop| {
        let max_rounds = arguments.max_rounds;
        let DiscoveryInput {
            settings,
            measured,
            whole,
            baseline,
            mut given,
            baseline_name,
            further,
        } = discovery_input(&model, arguments)?;
        let read = reader(&model.model, settings.at_rest);
        let sources = |given: &GivenRecordings| {
            let file = model.file.as_ref().map_or(Path::new("model.yaml"), |file| &file.name);
            DiscoverySources::new(file, given, baseline_name.as_deref(), further.clone())
        };
        let mut earlier: Vec<WrittenDiscovery> = Vec::new();
        let stop = stop.clone();
        // A search that nobody waits for ends at its next step.
        let step = move |step: &str| {
            if stop.raised() {
                resume_unwind(Box::new("interrupted"));
            }
            steps.add(step);
        };
        let ask = |round: &Round| -> Result<Option<Recording>, PyErr> {
            let Some(record) = &record else { return Ok(None) };
            let proposals = round.answer.next_experiments.iter();
            let commands: Vec<Vec<PyColumn>> =
                proposals.map(|next| columns(&next.commands)).collect::<Result<_, Fault>>()?;
            let shown = (round.measured, settings.at_rest);
            let limitations = given.limitations(round.measured);
            let answer = written(round.answer, &model, shown, limitations, &sources(&given))?;
            let recorded: Option<PyRecording> =
                Python::attach(|py| record.bind(py).call1((answer.clone(), commands))?.extract())?;
            let Some(recorded) = recorded.map(PyRecording::named).transpose()? else {
                return Ok(None);
            };
            let added = read(&recorded).map_err(Fault::from)?;
            given.extend(recorded.source().name(), &added);
            earlier.push(answer);
            Ok(Some(added))
        };
        let question =
            Question { model: &model.model, baseline: baseline.as_ref(), options: &settings };
        match with_step_listener(step, || discover_until_named(question, whole, max_rounds, ask)) {
            Ok(Rounds { answer, measured, .. }) => {
                let shown = (&measured, settings.at_rest);
                let limitations = given.limitations(&measured);
                earlier.push(written(&answer, &model, shown, limitations, &sources(&given))?);
                Ok(Ok(earlier))
            }
            Err(RoundsError::Record(exception)) => Ok(Err(exception)),
            Err(RoundsError::Mismatch(error)) => Err(Fault::words(error)),
            Err(RoundsError::Discovery { error, .. }) => {
                Err(about(measured[0].source().name(), error))
            }
        }
    })?
}
