//! A row-major table of numbers, used for samples throughout the crate.

use serde::{Deserialize, Serialize};

/// `len` rows of `width` numbers each, row after row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    width: usize,
    values: Vec<f64>,
}

impl Rows {
    /// An empty table of rows of `width` numbers.
    pub fn new(width: usize) -> Self {
        Rows { width, values: Vec::new() }
    }

    /// Appends a row.
    ///
    /// # Panics
    /// When `row` is not `width` long: a programming error.
    pub fn push(&mut self, row: &[f64]) {
        assert_eq!(row.len(), self.width, "a row with a wrong number of cells");
        self.values.extend_from_slice(row);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// True when there is no row.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Numbers in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Row number `index`.
    pub fn row(&self, index: usize) -> &[f64] {
        &self.values[index * self.width..(index + 1) * self.width]
    }

    /// All rows in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.width.max(1))
    }

    /// The rows with these indices, in that order.
    pub fn select(&self, indices: &[usize]) -> Rows {
        let mut out = Rows::new(self.width);
        for &index in indices {
            out.push(self.row(index));
        }
        out
    }

    /// All numbers, row-major.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}
