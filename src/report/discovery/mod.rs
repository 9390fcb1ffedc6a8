//! Report of a discovery: one page with its figures, the figures as files, and the tables behind
//! them. Pure functions: equal findings give equal bytes.

pub(super) mod answer;
mod appendix;
mod arrows;
mod evidence;
mod folder;
pub(super) mod format;
mod gap;
mod given;
mod heat;
mod map;
mod model_diff;
pub(super) mod page;
mod quantity;
mod residuals;
mod scale;

use super::style::PAGE_WIDTH;
use super::{Artifact, ReportError, pictures, some_csv, text};
use crate::data::findings::{Findings, PlaceRow, ResidualRow};
use crate::data::scene::Scene;

pub use folder::{folder_files, is_commands, write_folder};
pub use given::{DiscoverySources, GivenRecordings};
pub use scale::SIGNIFICANCE_LEVEL;

/// Catalogue texts of an effect, as plain text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EffectText {
    /// Name in models and findings.
    pub name: String,
    /// What a model without it lacks, as a phrase.
    pub missing: String,
    /// Its equation in plain text.
    pub equation: String,
    /// Source of the equation.
    pub source: String,
}

/// Input of the report.
#[derive(Clone, Copy, Debug)]
pub struct DiscoveryReport<'a> {
    /// The files of the question.
    pub sources: &'a DiscoverySources,
    /// The findings.
    pub findings: &'a Findings,
    /// Every sample's residual, before and after.
    pub residuals: &'a [ResidualRow],
    /// The residual map, in display order.
    pub places: &'a [PlaceRow],
    /// Whether the model was calibrated on a baseline; "before" then refers to the calibrated
    /// model.
    pub calibrated: bool,
    /// Texts of the effects; only those of named effects are used.
    pub effects: &'a [EffectText],
    /// The given model as YAML.
    pub model_before: &'a str,
    /// The written model as YAML from the same writer; the report shows the lines that differ.
    pub model_after: &'a str,
    /// The robot on a held-out trial, before and after, with what was measured.
    pub scenes: &'a [Scene],
}

impl DiscoveryReport<'_> {
    /// Whether the effects changed the model.
    fn changed(&self) -> bool {
        let sample_changed = |row: &ResidualRow| {
            row.before_m()
                .iter()
                .zip(row.after_m())
                .any(|(before, after)| after.is_finite() && *before != after)
        };
        let place_changed =
            |row: &PlaceRow| row.rms_after_m.is_finite() && row.rms_after_m != row.rms_before_m;
        let gap = &self.findings.gap;
        gap.after_m.is_finite() && gap.after_m != gap.before_m
            || self.residuals.iter().any(sample_changed)
            || self.places.iter().any(place_changed)
    }

    /// Name of the model without the effects.
    fn before(&self) -> &'static str {
        if self.calibrated { "calibrated model" } else { "model as given" }
    }

    /// Catalogue texts of an effect.
    fn text_of(&self, name: &str) -> Option<&EffectText> {
        self.effects.iter().find(|text| text.name == name)
    }
}

/// A figure of the page: name, and drawing function of the width.
type PageFigure = (&'static str, fn(&DiscoveryReport, f64) -> Option<super::drawing::Canvas>);

/// The figures in page order.
const DRAWINGS: [PageFigure; 3] =
    [("map", map::draw), ("gap", gap::draw), ("residuals", residuals::draw)];

/// Everything that `discover` writes for people: `report.html`, the figures `map`, `gap` and
/// `residuals` as PNG and SVG, and `disagreement.csv`, `residuals.csv` and `candidates.csv`. A
/// figure or table that has nothing to show is left out.
///
/// # Errors
/// [`ReportError::Draw`] when a figure cannot be painted, [`ReportError::Data`] when a table cannot
/// be written.
pub fn artifacts(report: &DiscoveryReport) -> Result<Vec<Artifact>, ReportError> {
    let mut files = vec![text("report.html", page::page(report)?)];
    for (name, draw) in DRAWINGS {
        if let Some(canvas) = draw(report, PAGE_WIDTH) {
            files.extend(pictures(name, name, &canvas)?);
        }
    }
    files.extend(some_csv("disagreement.csv", report.places)?);
    files.extend(some_csv("residuals.csv", report.residuals)?);
    files.extend(some_csv("candidates.csv", &report.findings.candidates)?);
    Ok(files)
}
