//! Tables and figures: pure functions from published rows to bytes. A figure is one file and one
//! name in the `figures!` of its room. This module cannot reach the code that computed the rows, so
//! every figure can be redrawn from `results/`.

/// The figures of a room, in the order of the page that shows them; each is a module here with its
/// `FIGURE`.
macro_rules! figures {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*

        /// The figures of this room.
        pub(super) const FIGURES: &[crate::report::Figure] = &[$($module::FIGURE),*];
    };
}

mod benchmark;
pub mod calibration;
mod cells;
mod control;
pub mod discovery;
mod drawing;
mod effect_picture;
mod html;
pub mod league;
mod order;
pub mod overview;
pub mod page;
pub mod paper;
mod peers;
mod published;
pub mod scene;
pub mod style;
mod sweep;

use std::path::Path;

use crate::data::{DataError, write_atomic};

pub use effect_picture::{EffectCurve, EffectPicture, EffectView};
pub use paper::claim_lines::claim_sentence;
pub use paper::summarise::{OSCILLATION_WINDOW_S, reach_summary, track_summary};
pub use published::{FigureContext, Published, published_rows};
pub use sweep::comparisons::{SweptPoint, comparisons};
pub use sweep::rows::{SweepCell, SweepTable, gp_sweep, reach_sweep, response_sweep, track_sweep};

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

    /// These files, and those of the drawing.
    fn files(
        &self,
        mut files: Vec<Artifact>,
        caption: &str,
        draw: impl Fn(f64) -> drawing::Canvas,
    ) -> Result<Vec<Artifact>, ReportError> {
        files.extend(captioned(self.name, self.name, caption, draw)?);
        Ok(files)
    }
}

/// Every figure and table, those of the paper first.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    [paper::FIGURES, &[sweep::FIGURE], peers::FIGURES, &[benchmark::FIGURE], control::FIGURES]
        .into_iter()
        .flatten()
}

/// The figure called `name`.
pub fn figure(name: &str) -> Option<&'static Figure> {
    figures().find(|figure| figure.name == name)
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

/// A file in `plots/`.
fn plot(stem: &str, end: &str, bytes: Vec<u8>) -> Artifact {
    Artifact { name: format!("{stem}{end}"), folder: OutputFolder::Plots, bytes }
}

/// PNG and SVG of a drawing.
fn pictures(
    figure: &'static str,
    stem: &str,
    canvas: &drawing::Canvas,
) -> Result<[Artifact; 2], ReportError> {
    let failed =
        |error: drawing::PaintError| ReportError::Draw { figure, reason: error.to_string() };
    Ok([
        plot(stem, ".png", drawing::png(canvas).map_err(failed)?),
        plot(stem, ".svg", drawing::svg(canvas).map_err(failed)?),
    ])
}

/// A published picture: PNG and SVG over the page, an SVG over one column, and the caption.
fn captioned(
    figure: &'static str,
    stem: &str,
    caption: &str,
    draw: impl Fn(f64) -> drawing::Canvas,
) -> Result<Vec<Artifact>, ReportError> {
    let mut files = pictures(figure, stem, &draw(style::PAGE_WIDTH))?.to_vec();
    let column = drawing::printed_svg(&draw(style::COLUMN_WIDTH))
        .map_err(|error| ReportError::Draw { figure, reason: error.to_string() })?;
    files.push(plot(stem, "_column.svg", column));
    files.push(plot(stem, ".md", format!("{caption}\n").into_bytes()));
    Ok(files)
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
