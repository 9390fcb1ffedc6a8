//! The published figures, drawn again from the published rows.

use super::results::{Files, all_claims, draw, figure_context};
use super::sweep;
use crate::data::calibration::CalibrationFindings;
use crate::report::calibration::{CalibrationReport, MAP_CAPTION, calibration_pictures};
use crate::report::{OutputFolder, Published, ReportError, figures};
use crate::specs::ExperimentSet;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The pictures below `plots/` that the rows in `folder` (`results/<name>`) suffice for, and in
/// words those that they do not: of an experiment the figures of its spec, of other folders every
/// figure whose rows are there.
///
/// # Errors
/// The file that cannot be read, or the figure that cannot be drawn, in words.
pub fn redraw(folder: &Path) -> Result<(Files, Vec<String>), String> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let published = Published::read(folder).map_err(|error| error.to_string())?;
    let spec = folder.join("spec.yaml");
    let (mut files, notices) = if spec.is_file() {
        let set = ExperimentSet::read(&spec, &[], &[]).map_err(|error| error.to_string())?;
        experiment_pictures(&set, published)
    } else {
        (other_pictures(folder, &published)?, Vec::new())
    };
    files.retain(|path, _| path.starts_with("plots"));
    if files.is_empty() && notices.is_empty() {
        return Ok((files, vec![format!("{name}: no rows of a figure")]));
    }
    Ok((files, notices))
}

/// The picture of all published claims in `out/results`.
///
/// # Errors
/// The table that cannot be read, in words.
pub fn redraw_claims(out: &Path) -> Result<Files, String> {
    let mut files = all_claims(out, &BTreeMap::new()).map_err(|error| error.to_string())?;
    files.retain(|path, _| path.starts_with("plots"));
    Ok(files)
}

fn experiment_pictures(set: &ExperimentSet, published: Published) -> (Files, Vec<String>) {
    let mut files = Files::new();
    let experiment = &set.experiment;
    let name = &experiment.name;
    let notices = if set.sweep.is_empty() {
        let published = Published { context: figure_context(experiment), ..published };
        draw(name, &experiment.figures, &published, &mut files)
    } else {
        draw(name, &[sweep::FIGURE.to_owned()], &published, &mut files)
    };
    (files, notices)
}

/// Pictures of what no experiment computed: comparisons with other programs, and calibrations.
fn other_pictures(folder: &Path, published: &Published) -> Result<Files, String> {
    let mut files = Files::new();
    for figure in figures() {
        match (figure.render)(published) {
            Ok(artifacts) => {
                let pictures =
                    artifacts.into_iter().filter(|file| file.folder == OutputFolder::Plots);
                files.extend(pictures.map(|file| (Path::new("plots").join(file.name), file.bytes)));
            }
            Err(ReportError::NoRows { .. }) => {}
            Err(error) => return Err(error.to_string()),
        }
    }
    for robot in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        files.extend(calibrated(&robot.path())?);
    }
    Ok(files)
}

/// The pictures of a calibration that its findings suffice for: `plots/real/ROBOT_errors.png` from
/// `results/real/ROBOT/calibration.json`.
fn calibrated(folder: &Path) -> Result<Files, String> {
    let file = folder.join("calibration.json");
    let Ok(text) = std::fs::read_to_string(&file) else { return Ok(Files::new()) };
    let findings: CalibrationFindings =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file.display()))?;
    let report = CalibrationReport { findings: &findings, sightings: &[] };
    let pictures = calibration_pictures(&report).map_err(|error| error.to_string())?;
    let part = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let plots = PathBuf::from("plots").join(part(folder.parent().unwrap_or(folder)));
    let place = |name: String| plots.join(format!("{}_{name}", part(folder)));
    // The positions behind a published map are not published: it stays, with its caption.
    let map = (place("map.md".to_owned()), format!("{MAP_CAPTION}\n").into_bytes());
    Ok(pictures.into_iter().map(|file| (place(file.name), file.bytes)).chain([map]).collect())
}
