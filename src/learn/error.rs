//! Errors of fits, training and prediction.

/// Why a fit, a training or a prediction was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LearnError {
    /// A number in the samples is not finite.
    #[error("{table}: row {row}, column {column} is not finite ({value})")]
    NotFinite {
        /// `inputs` or `outputs`.
        table: &'static str,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// What stands there.
        value: f64,
    },
    /// Fewer rows than the method can work with.
    #[error("too few rows: found {found}, expected at least {needed} ({why})")]
    TooFewRows {
        /// Rows given.
        found: usize,
        /// Rows needed.
        needed: usize,
        /// What needs them.
        why: &'static str,
    },
    /// Inputs and outputs differ in length, or a query has another width than the training rows.
    #[error("{what}: found {found}, expected {expected}")]
    Shape {
        /// What was counted.
        what: &'static str,
        /// Count found.
        found: usize,
        /// Count expected.
        expected: usize,
    },
    /// A setting is out of its range.
    #[error("{key}: found {found}, expected {expected}")]
    Setting {
        /// Name of the setting, as in the YAML.
        key: &'static str,
        /// Its value.
        found: String,
        /// Its range.
        expected: &'static str,
    },
    /// The start rows of the sequences are not strictly increasing row numbers.
    #[error(
        "sequences: start row {found} at place {place}, expected increasing row numbers below \
         {rows}"
    )]
    Sequences {
        /// Place in the list.
        place: usize,
        /// Row number there.
        found: usize,
        /// Rows in the table.
        rows: usize,
    },
    /// No hyper-parameters were found under which the Gram matrix is positive definite.
    #[error("output {output}: the covariance matrix is not positive definite at any start")]
    NotPositiveDefinite {
        /// Output, from 0.
        output: usize,
    },
    /// The training diverged.
    #[error("the training loss is not finite in epoch {epoch}")]
    Diverged {
        /// Epoch, from 1.
        epoch: usize,
    },
}

impl LearnError {
    /// Error unless as many as expected were counted.
    pub fn unless_shape(
        what: &'static str,
        found: usize,
        expected: usize,
    ) -> Result<(), LearnError> {
        if found == expected { Ok(()) } else { Err(LearnError::Shape { what, found, expected }) }
    }

    /// Error unless all `values` of a row are finite.
    pub(crate) fn unless_finite(
        table: &'static str,
        row: usize,
        values: &[f64],
    ) -> Result<(), LearnError> {
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(column) => {
                Err(LearnError::NotFinite { table, row, column, value: values[column] })
            }
        }
    }

    /// Error unless `valid`.
    pub(crate) fn unless_setting(
        valid: bool,
        key: &'static str,
        found: impl ToString,
        expected: &'static str,
    ) -> Result<(), LearnError> {
        if valid {
            Ok(())
        } else {
            Err(LearnError::Setting { key, found: found.to_string(), expected })
        }
    }
}
