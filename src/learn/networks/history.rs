//! The last rows of inputs, side by side. Before a sequence's first row stands that row itself: a
//! robot at rest.

/// Rows of standardised inputs, the newest first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct InputHistory {
    columns: usize,
    rows: Vec<f32>,
    is_empty: bool,
}

impl InputHistory {
    pub(super) fn new(columns: usize, rows: usize) -> Self {
        InputHistory { columns, rows: vec![0.0; columns * rows], is_empty: true }
    }

    /// Begins a sequence.
    pub(super) fn reset(&mut self) {
        self.is_empty = true;
    }

    /// Takes the next row; all rows, the newest first.
    pub(super) fn push(&mut self, row: impl Iterator<Item = f32>) -> &[f32] {
        let (columns, len) = (self.columns, self.rows.len());
        // Shift by one row, so that the newest stays in front.
        self.rows.copy_within(..len - columns, columns);
        self.rows.iter_mut().zip(row).for_each(|(saved, new)| *saved = new);
        if std::mem::take(&mut self.is_empty) {
            let (newest, older) = self.rows.split_at_mut(columns);
            older.chunks_exact_mut(columns).for_each(|row| row.copy_from_slice(newest));
        }
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_row_stands_first_and_a_sequence_begins_at_rest() {
        let mut history = InputHistory::new(2, 3);
        assert_eq!(history.push([1.0, 2.0].into_iter()), [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
        assert_eq!(history.push([3.0, 4.0].into_iter()), [3.0, 4.0, 1.0, 2.0, 1.0, 2.0]);
        assert_eq!(history.push([5.0, 6.0].into_iter()), [5.0, 6.0, 3.0, 4.0, 1.0, 2.0]);
        history.reset();
        assert_eq!(history.push([7.0, 8.0].into_iter()), [7.0, 8.0, 7.0, 8.0, 7.0, 8.0]);
    }
}
