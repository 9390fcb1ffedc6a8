//! Report of a calibration: one page with its figures, the figures as files, and the tables behind
//! them. Pure functions: equal findings give equal bytes.

mod errors;
mod map;
mod page;

use super::drawing::Canvas;
use super::style::PAGE_WIDTH;
use super::{Artifact, ReportError, captioned, csv, some_csv, text};
use crate::data::calibration::{CalibrationFindings, SightingRow};

/// Input of the report.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationReport<'a> {
    /// The findings.
    pub findings: &'a CalibrationFindings,
    /// Every position of the fit with its error.
    pub sightings: &'a [SightingRow],
}

/// A figure of the page: name, and drawing function of the width.
type CalibrationFigure = (&'static str, fn(&CalibrationReport, f64) -> Option<Canvas>);

/// The figures in page order.
const DRAWINGS: [CalibrationFigure; 2] = [("errors", errors::draw), ("map", map::draw)];

/// What the map shows.
pub const MAP_CAPTION: &str = "Measured positions (grey), the positions that the fitted model \
                               simulates for the same commands (blue) and the error between them \
                               (red), seen from the side, from above and along the robot, in mm. A \
                               sample of positions at even intervals is drawn.";

/// Everything that `calibrate --report` writes: `calibration.json`, `report.html`, the figures as
/// PNG and SVG, and the tables `numbers.csv`, `trade_offs.csv`, `stages.csv`, `residual_groups.csv`
/// and `residuals.csv`. What is empty is left out.
///
/// # Errors
/// [`ReportError`] when a figure cannot be painted or a table cannot be written.
pub fn calibration_artifacts(report: &CalibrationReport) -> Result<Vec<Artifact>, ReportError> {
    let findings = report.findings;
    let json = serde_json::to_string_pretty(findings).map_err(|error| ReportError::Draw {
        figure: "calibration.json",
        reason: error.to_string(),
    })?;
    let mut files =
        vec![text("calibration.json", json + "\n"), text("report.html", page::page(report)?)];
    files.extend(calibration_pictures(report)?);
    files.push(csv("numbers.csv", &findings.numbers)?);
    files.push(csv("residual_groups.csv", &findings.residual_groups)?);
    files.push(csv("residuals.csv", report.sightings)?);
    files.extend(some_csv("trade_offs.csv", &findings.trade_offs)?);
    files.extend(some_csv("stages.csv", &findings.stages)?);
    Ok(files)
}

/// The figures of the page as files.
///
/// # Errors
/// [`ReportError::Draw`] when a figure cannot be painted.
pub fn calibration_pictures(report: &CalibrationReport) -> Result<Vec<Artifact>, ReportError> {
    let mut files = Vec::new();
    for (name, draw) in DRAWINGS {
        if draw(report, PAGE_WIDTH).is_some() {
            let drawing = |width| draw(report, width).unwrap_or_else(|| Canvas::new(width, 1.0));
            files.extend(captioned(name, name, &caption(name, report.findings), drawing)?);
        }
    }
    Ok(files)
}

/// What a figure shows, in words.
fn caption(name: &str, findings: &CalibrationFindings) -> String {
    if name == "map" {
        return MAP_CAPTION.to_owned();
    }
    let (positions, how) = findings
        .held_out
        .as_ref()
        .map_or((0, String::new()), |held_out| (held_out.positions, held_out.how.clone()));
    let noise = match &findings.noise {
        Some(noise) => format!(" Broken line: noise of the measurement, from {}.", noise.from),
        None => String::new(),
    };
    format!(
        "Root mean square distance in mm between predicted and measured positions, of the fitted \
         model and of other models, on {positions} positions that were not used in the fit \
         ({how}).{noise}"
    )
}
