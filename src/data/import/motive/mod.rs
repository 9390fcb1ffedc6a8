//! The CSV export of OptiTrack's Motive (format versions 1.2x): rigid bodies and single markers
//! over time. Columns are found by their header, not by position; other assets (bones, markers of a
//! body) are skipped.

mod header;
mod meta;
mod read;

pub(crate) use read::export as parse;

/// A line with its number in the file, from 1.
struct ExportLine<'a> {
    number: usize,
    cells: Vec<std::borrow::Cow<'a, str>>,
}

impl ExportLine<'_> {
    /// The cell, without spaces around it; empty beyond the end.
    fn cell(&self, index: usize) -> &str {
        self.cells.get(index).map_or("", |cell| cell.trim())
    }

    /// Number of cells up to the last that holds something.
    fn filled(&self) -> usize {
        self.cells.iter().rposition(|cell| !cell.trim().is_empty()).map_or(0, |last| last + 1)
    }
}
