//! Tables and figures: pure functions from published rows to bytes. A figure is one file and one line in `figures!`.
//! This module cannot reach the code that computed the rows, so every figure can be redrawn from `results/`.

pub mod calibration;
mod cells;
mod controllers_table;
pub mod discovery;
mod drawing;
pub mod markup;
mod order;
pub mod page;
pub mod page_counts;
pub mod paper;
mod peers_labels;
mod peers_table;
mod population_table;
mod published;
mod repair_table;
pub mod style;
mod summarise;
mod sweep_comparisons;
mod sweep_rows;

use std::path::Path;

use crate::data::{DataError, write_atomic};

pub use published::{Published, published_rows};
pub use summarise::{OSCILLATION_WINDOW_S, reach_summary, track_summary};
pub use sweep_comparisons::{SweptPoint, comparisons};
pub use sweep_rows::{SweepCell, SweepTable, gp_sweep, reach_sweep, response_sweep, track_sweep};

/// The folder of a rendered file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFolder {
    /// `plots/`: PNG and SVG.
    Plots,
    /// `results/<experiment>/`: CSV, Markdown, LaTeX.
    Results,
}

/// A rendered file.
#[derive(Clone, Debug, PartialEq)]
pub struct Artifact {
    /// File name.
    pub name: String,
    /// Its folder.
    pub folder: OutputFolder,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Why a figure could not be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReportError {
    /// The rows for the figure are missing.
    #[error("{figure}: no rows: found no {needs}, expected at least one")]
    NoRows {
        /// The figure.
        figure: &'static str,
        /// The rows that it needs.
        needs: &'static str,
    },
    /// Rows to be averaged belong to different experiments.
    #[error("{figure}: found rows of {found}, expected one {expected}")]
    Mixed {
        /// The figure.
        figure: &'static str,
        /// The values found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// The drawing backend failed.
    #[error("{figure}: cannot draw: {reason}")]
    Draw {
        /// The figure.
        figure: &'static str,
        /// Its message.
        reason: String,
    },
    /// A table could not be written.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// One entry of the registry.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Name, also the stem of its files.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// Renders rows to files: the same rows give the same bytes; missing rows are an error.
    pub render: fn(&Published) -> Result<Vec<Artifact>, ReportError>,
}

impl Figure {
    /// An error where the rows that it needs are missing.
    fn needs(&self, rows: &'static str, missing: bool) -> Result<(), ReportError> {
        if missing { Err(ReportError::NoRows { figure: self.name, needs: rows }) } else { Ok(()) }
    }

    /// These files, and the PNG and SVG of the drawing.
    fn files(&self, mut files: Vec<Artifact>, canvas: &drawing::Canvas) -> Result<Vec<Artifact>, ReportError> {
        files.extend(pictures(self.name, self.name, canvas)?);
        Ok(files)
    }
}

macro_rules! figures {
    ($($module:ident::FIGURE),* $(,)?) => {
        $(mod $module;)*

        /// Every figure and table, in the order of the paper.
        pub const FIGURES: &[Figure] = &[$($module::FIGURE),*];
    };
}

figures! {
    table1::FIGURE,
    fig5::FIGURE,
    fig6::FIGURE,
    fig8::FIGURE,
    claims::FIGURE,
    sweep::FIGURE,
    peers::FIGURE,
    peers_learning::FIGURE,
    benchmark::FIGURE,
    scaling::FIGURE,
    controllers::FIGURE,
    repair::FIGURE,
    population::FIGURE,
    gp_coverage::FIGURE,
    data_efficiency::FIGURE,
}

/// The figure called `name`.
pub fn figure(name: &str) -> Option<&'static Figure> {
    FIGURES.iter().find(|figure| figure.name == name)
}

/// Writes artifacts to their folders, each atomically.
///
/// # Errors
/// [`DataError::Write`] for the first file that cannot be written.
pub fn write(artifacts: &[Artifact], results: &Path, plots: &Path) -> Result<(), DataError> {
    for artifact in artifacts {
        let folder = match artifact.folder {
            OutputFolder::Plots => plots,
            OutputFolder::Results => results,
        };
        write_atomic(&folder.join(&artifact.name), &artifact.bytes)?;
    }
    Ok(())
}

/// PNG and SVG of a drawing.
fn pictures(figure: &'static str, stem: &str, canvas: &drawing::Canvas) -> Result<[Artifact; 2], ReportError> {
    let failed = |error: drawing::PaintError| ReportError::Draw { figure, reason: error.to_string() };
    let file = |end: &str, bytes| Artifact { name: format!("{stem}.{end}"), folder: OutputFolder::Plots, bytes };
    Ok([file("png", drawing::png(canvas).map_err(failed)?), file("svg", drawing::svg(canvas).map_err(failed)?)])
}

/// A CSV for `results/<experiment>/`.
fn csv<R: serde::Serialize>(name: &str, rows: &[R]) -> Result<Artifact, ReportError> {
    let bytes = crate::data::tables::to_csv(Path::new(name), rows)?;
    Ok(Artifact { name: name.to_owned(), folder: OutputFolder::Results, bytes })
}

/// A CSV of rows, unless there are none.
fn some_csv<R: serde::Serialize>(name: &str, rows: &[R]) -> Result<Option<Artifact>, ReportError> {
    if rows.is_empty() { Ok(None) } else { csv(name, rows).map(Some) }
}

/// A text file for `results/<experiment>/`.
fn text(name: &str, text: String) -> Artifact {
    Artifact { name: name.to_owned(), folder: OutputFolder::Results, bytes: text.into_bytes() }
}
