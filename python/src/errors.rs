//! What goes wrong, and the exception that tells it: one hierarchy, defined in
//! `spinebench/_errors.py`.

use pyo3::prelude::*;
use spinebench::base::PlantError;
use spinebench::data::DataError;
use spinebench::specs::{SourceLocation, SpecError};

/// A fault, before it is an exception: it crosses threads.
#[derive(Debug)]
pub(crate) enum Fault {
    /// Bad input: where it stands, what was found and what was expected.
    Input(Box<InputFault>),
    /// The solver, the plant or a policy failed; the first text is the named status.
    Solver { status: String, message: String },
    /// It ran, and the answer is no, or results could not be written.
    Run(String),
    /// A panic of the library.
    Panic(String),
}

/// Bad input. Empty fields are not known.
#[derive(Debug, Default)]
pub(crate) struct InputFault {
    pub(crate) message: String,
    pub(crate) file: Option<String>,
    pub(crate) line: Option<usize>,
    pub(crate) key: Option<String>,
    pub(crate) found: Option<String>,
    pub(crate) expected: Option<String>,
}

impl Fault {
    /// Bad input of a call: `name` is the argument.
    pub(crate) fn argument(
        name: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fault {
        let (found, expected) = (found.into(), expected.into());
        let message = format!("{name}: found {found}, expected {expected}");
        let (found, expected) = (Some(found), Some(expected));
        Fault::Input(Box::new(InputFault {
            message,
            key: Some(name.to_owned()),
            found,
            expected,
            ..Default::default()
        }))
    }

    /// What a call that nobody waits for any more ends with.
    pub(crate) fn interrupted() -> Fault {
        Fault::Run("interrupted; the computed stages are stored".into())
    }

    /// Bad input that is only words.
    pub(crate) fn words(message: impl std::fmt::Display) -> Fault {
        Fault::Input(Box::new(InputFault { message: message.to_string(), ..Default::default() }))
    }
}

impl From<SpecError> for Fault {
    fn from(error: SpecError) -> Fault {
        let message = error.to_string();
        let first = match error {
            SpecError::Several(faults) => faults.into_iter().next(),
            one => Some(one),
        };
        let mut fault = InputFault { message, ..Default::default() };
        let mut located = |place: SourceLocation| match place {
            SourceLocation::File { file, line, .. } => {
                (fault.file, fault.line) = (Some(file), Some(line))
            }
            SourceLocation::Option(option) => fault.key = Some(option),
        };
        match first {
            Some(SpecError::File { file, found, expected }) => {
                (fault.file, fault.found, fault.expected) =
                    (Some(file), Some(found), Some(expected.to_owned()));
            }
            Some(SpecError::Syntax { place, found, expected }) => {
                located(place);
                (fault.found, fault.expected) = (Some(found), Some(expected));
            }
            Some(SpecError::Key { place, key, found, expected }) => {
                located(place);
                fault.key = Some(key.to_string());
                (fault.found, fault.expected) = (Some(found), Some(expected));
            }
            Some(SpecError::Several(_)) | None => {}
        }
        Fault::Input(Box::new(fault))
    }
}

impl From<DataError> for Fault {
    fn from(error: DataError) -> Fault {
        let mut fault = InputFault { message: error.to_string(), ..Default::default() };
        let number = |place: &str| place.rsplit(' ').next().and_then(|word| word.parse().ok());
        match error {
            DataError::Read { file, .. }
            | DataError::Write { file, .. }
            | DataError::Empty { file, .. } => {
                fault.file = Some(file.display().to_string());
            }
            DataError::Line { file, place, found, expected } => {
                (fault.file, fault.line) = (Some(file.display().to_string()), number(&place));
                (fault.found, fault.expected) = (Some(found), Some(expected));
            }
            DataError::Column { file, place, column, found, expected } => {
                (fault.file, fault.line) = (Some(file.display().to_string()), number(place));
                (fault.key, fault.found, fault.expected) =
                    (Some(column), Some(found), Some(expected));
            }
            DataError::Cell { file, place, column, found, expected } => {
                (fault.file, fault.line) = (Some(file.display().to_string()), number(&place));
                (fault.key, fault.found, fault.expected) =
                    (Some(column), Some(found), Some(expected));
            }
        }
        Fault::Input(Box::new(fault))
    }
}

impl From<PlantError> for Fault {
    fn from(error: PlantError) -> Fault {
        let message = error.to_string();
        match error {
            PlantError::Solver(status) => Fault::Solver { status, message },
            PlantError::Refused(_) => Fault::words(message),
            PlantError::Stopped(_) => Fault::Solver { status: "stopped".into(), message },
            PlantError::Late(_) => Fault::Solver { status: "late".into(), message },
            PlantError::Unseen { .. } => Fault::Solver { status: "tracking_lost".into(), message },
            PlantError::Server(_) => Fault::Solver { status: "server".into(), message },
            PlantError::NotRecorded(_) => Fault::Solver { status: "not_recorded".into(), message },
        }
    }
}

/// Makes the exception of a fault.
fn exception(py: Python<'_>, fault: Fault) -> PyResult<PyErr> {
    let module = py.import("spinebench._errors")?;
    let make = |class: &str, message: String| module.getattr(class)?.call1((message,));
    let error = match fault {
        Fault::Input(input) => {
            let InputFault { message, file, line, key, found, expected } = *input;
            let error = make("InputError", message)?;
            error.setattr("file", file)?;
            error.setattr("line", line)?;
            error.setattr("key", key)?;
            error.setattr("found", found)?;
            error.setattr("expected", expected)?;
            error
        }
        Fault::Solver { status, message } => {
            let error = make("SolverError", message)?;
            error.setattr("status", status)?;
            error
        }
        Fault::Run(message) => make("RunError", message)?,
        Fault::Panic(message) => make("InternalError", message)?,
    };
    Ok(PyErr::from_value(error))
}

impl From<Fault> for PyErr {
    fn from(fault: Fault) -> PyErr {
        Python::attach(|py| exception(py, fault).unwrap_or_else(|error| error))
    }
}
