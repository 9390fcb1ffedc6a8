//! Errors in a spec, with their location.

use super::path::KeyPath;
use std::fmt;

/// A location in the user's input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SourceLocation {
    /// A position in a file; line and column are counted from 1.
    File {
        /// The file, as the user named it.
        file: String,
        /// Line.
        line: usize,
        /// Column.
        column: usize,
    },
    /// An override on the command line, such as `--set gp.starts=3`.
    Option(String),
}

impl fmt::Display for SourceLocation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SourceLocation::File { file, line, column } => write!(out, "{file}:{line}:{column}"),
            SourceLocation::Option(option) => out.write_str(option),
        }
    }
}

/// Why a spec is refused: one error with location, key, what was found and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpecError {
    /// A file on the command line is missing or unreadable.
    #[error("{file}: found {found}, expected {expected}")]
    File {
        /// The file, as the user named it.
        file: String,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// The text is not YAML.
    #[error("{place}: found {found}, expected {expected}")]
    Syntax {
        /// Where the parser gave up.
        place: SourceLocation,
        /// What it found there.
        found: String,
        /// What it expected.
        expected: String,
    },
    /// A key is unknown or missing, or its value is of the wrong type, unit or range.
    #[error("{place}: {key}: found {found}, expected {expected}")]
    Key {
        /// Location of the key or its value.
        place: SourceLocation,
        /// Path of the key.
        key: KeyPath,
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// Several faults, each a line of its own.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: "))]
    Several(Vec<SpecError>),
}

impl SpecError {
    /// One error for all of these, of which there is at least one.
    pub(in crate::specs) fn of_all(mut faults: Vec<SpecError>) -> SpecError {
        match faults.len() {
            1 => faults.remove(0),
            _ => SpecError::Several(faults),
        }
    }
}
