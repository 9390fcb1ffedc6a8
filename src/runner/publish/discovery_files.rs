//! The folder of a discovery: its report, with the robot on a held-out trial, its tables, proposed
//! commands, and the model.

use std::path::Path;

use crate::data::Recording;
use crate::data::findings::ResidualRow;
use crate::data::scene::Scene;
use crate::discovery::Discovery;
use crate::effects::{CATALOGUE, Model};
use crate::report::ReportError;
use crate::report::discovery::{DiscoveryReport, DiscoverySources, EffectText, folder_files};
use crate::specs::{extended_text, model_text};
use crate::tasks::scene_of_recording;

/// What a discovery was asked.
#[derive(Clone, Copy, Debug)]
pub struct AskedDiscovery<'a> {
    /// The model as given.
    pub model: &'a Model,
    /// Its file as it was written.
    pub model_text: &'a str,
    /// All that was measured.
    pub measured: &'a Recording,
    /// Whether its rows are poses at rest.
    pub at_rest: bool,
    /// The files of the question.
    pub sources: &'a DiscoverySources,
}

/// Why the files of a discovery cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum DiscoveryFilesError {
    /// A page, a figure or a table.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The text of the model.
    #[error("model.yaml: {0}")]
    Model(String),
}

/// Frames of a scene of the report.
const MAX_FRAMES: usize = 100;

/// What `spinebench discover` writes of an answer, by name.
///
/// # Errors
/// [`DiscoveryFilesError`].
pub fn discovery_files(
    answer: &Discovery,
    asked: &AskedDiscovery,
) -> Result<Vec<(String, Vec<u8>)>, DiscoveryFilesError> {
    let added = answer.model.effects.len() - asked.model.effects.len();
    let unwritten = |error: &dyn std::error::Error| DiscoveryFilesError::Model(error.to_string());
    let before = model_text(asked.model).map_err(|error| unwritten(&error))?;
    let (written, after) = if added == 0 {
        (asked.model_text.to_owned(), before.clone())
    } else {
        let extended = extended_text(asked.model_text, &answer.model, added);
        let after = model_text(&answer.model).map_err(|error| unwritten(&error))?;
        (extended.map_err(|error| unwritten(&error))?, after)
    };
    let report = DiscoveryReport {
        sources: asked.sources,
        findings: &answer.findings,
        residuals: &answer.residuals,
        places: &answer.places,
        calibrated: answer.calibrated,
        effects: &effect_texts(),
        model_before: &before,
        model_after: &after,
        scenes: &scenes(answer, asked, added),
    };
    let next = answer.next_experiments.iter();
    let commands: Vec<(&str, &Recording)> =
        next.map(|next| (next.proposal.file.as_str(), &next.commands)).collect();
    Ok(folder_files(&report, &commands, written.into_bytes())?)
}

/// The catalogue's texts.
fn effect_texts() -> Vec<EffectText> {
    let text = |card: &&crate::effects::Card| EffectText {
        name: card.name.to_owned(),
        missing: card.missing.to_owned(),
        equation: card.equation.to_owned(),
        source: card.source.to_owned(),
    };
    CATALOGUE.iter().map(text).collect()
}

/// The robot on one held-out trial, by the model without and with the effects found; none where
/// the model cannot follow the commands.
fn scenes(answer: &Discovery, asked: &AskedDiscovery, added: usize) -> Vec<Scene> {
    let Some(trial) = shown_trial(&answer.residuals) else { return Vec::new() };
    let Some((_, rows)) = asked.measured.trials().into_iter().find(|(number, _)| *number == trial)
    else {
        return Vec::new();
    };
    let recording = asked.measured.rows(&rows.collect::<Vec<usize>>());
    let mut before = answer.model.clone();
    before.effects.truncate(answer.model.effects.len() - added);
    let names: Vec<&str> =
        answer.model.effects[before.effects.len()..].iter().map(|one| one.card().name).collect();
    let first = if answer.calibrated { "calibrated model" } else { "model as given" };
    let mut models = vec![(format!("Trial {trial}: {first}"), before)];
    if added > 0 {
        models.push((format!("Trial {trial}: with {}", names.join(", ")), answer.model.clone()));
    }
    let scene = |(name, model): &(String, Model)| {
        let played =
            scene_of_recording(name, Path::new("measured"), &recording, model, asked.at_rest);
        played.map(|scene| scene.thinned(MAX_FRAMES))
    };
    models.iter().map(scene).collect::<Result<_, _>>().unwrap_or_default()
}

/// The held-out trial with the largest error before; among all trials where none was held out.
fn shown_trial(residuals: &[ResidualRow]) -> Option<u64> {
    let any_held_out = residuals.iter().any(|row| row.held_out);
    let size = |row: &ResidualRow| row.before_m().iter().map(|x| x * x).sum::<f64>();
    let rows = residuals.iter().filter(|row| row.held_out == any_held_out);
    let largest =
        rows.filter(|row| size(row).is_finite()).max_by(|a, b| size(a).total_cmp(&size(b)));
    largest.map(|row| row.trial)
}
