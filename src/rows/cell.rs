//! What a row is of: one cell of the product of seeds, trainings, policies, modes and data sizes.

use std::ops::{Deref, DerefMut};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub use crate::base::Outcome;
use crate::data::{TableColumn, TableColumns, TableDescription, TableRow, columns};

columns! {
    /// A policy in a mode with so much data behind it.
    #[derive(Default, Eq, PartialOrd, Ord)]
    pub struct CellLabel {
        /// Name of the policy: `a`, `b`, `c`, `pi_real` …
        pub policy: String,
        /// Name of the mode: `open`, `closed`, `closed_load` (a load at the tip) …
        pub mode: String,
        /// Real points that the Gaussian process was fitted to (0 for policies without one).
        pub gp_points: u64,
        /// Real points that the network was trained on (0 for policies without one).
        pub real_points: u64,
    }
}

/// One of the values that were measured in a cell. On disk the fields of all parts are the columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellRow<T> {
    /// Repetition of the whole experiment, including data and training.
    pub seed: u64,
    /// `paper`: networks stopped at the paper's validation errors; `converged`: trained to
    /// convergence.
    pub training: String,
    /// Policy, mode and data sizes.
    #[serde(rename = "+cell")]
    pub cell: CellLabel,
    /// What was measured.
    #[serde(rename = "+value")]
    pub value: T,
}

/// The first columns of [`CellRow`].
const REPETITION: &[TableColumn] = &[
    TableColumn {
        name: "seed",
        documentation: "Repetition of the whole experiment, including data and training.",
    },
    TableColumn {
        name: "training",
        documentation: "`paper`: networks stopped at the paper's validation errors; `converged`: \
                        trained to convergence.",
    },
];

/// What is measured in a cell, and the table of it.
pub trait CellValue:
    TableColumns + Serialize + DeserializeOwned + Clone + PartialEq + 'static
{
    /// Name of the row type.
    const ROW: &'static str;
    /// Name of the table's file.
    const FILE: &'static str;
    /// What one row is.
    const ABOUT: &'static str;
    /// The columns of its own that tell its rows apart.
    const KEY: &'static [&'static str];

    /// What became of it.
    fn status(&self) -> &Outcome;
}

impl<T: CellValue> TableRow for CellRow<T> {
    const TABLE: TableDescription = TableDescription {
        name: T::ROW,
        file: T::FILE,
        row: T::ABOUT,
        key: &[&["seed", "training", "policy", "mode", "gp_points", "real_points"], T::KEY],
        columns: &[REPETITION, CellLabel::COLUMNS[0], T::COLUMNS[0]],
    };

    fn failed(&self) -> bool {
        !self.value.status().is_ok()
    }
}

impl<T> Deref for CellRow<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for CellRow<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}
