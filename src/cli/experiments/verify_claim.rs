//! `spinebench verify --claim`.

use crate::cli::program::interrupted::exit_on_interrupt;
use crate::cli::{CommandError, CommandResult};
use spinebench::report::overview::duration;
use spinebench::report::{claim_sentence, published_rows};
use spinebench::rows::experiment::ClaimRow;
use spinebench::runner::{self, Campaign, CampaignEntry, Progress, RunOptions, Standard, Store};
use spinebench::specs::{ExperimentSet, PaperClaim, nearest};
use std::path::Path;

/// Reruns what the number of a claim needs, in an empty store, and compares its rows with the
/// published ones.
pub(super) fn verify_claim(
    claim: &str,
    experiments: Vec<(ExperimentSet, Standard)>,
    results: &Path,
    threads: usize,
    progress: &Progress,
) -> CommandResult {
    let named = |set: &ExperimentSet| set.experiment.claims.iter().any(|one| one.claim == claim);
    let judged = |set: &ExperimentSet| set.sweep.is_empty() && set.experiment.population.is_none();
    let known: Vec<String> = experiments
        .iter()
        .filter(|(set, _)| judged(set))
        .flat_map(|(set, _)| set.experiment.claims.iter().map(|one| one.claim.clone()))
        .collect();
    let found: Vec<_> =
        experiments.into_iter().filter(|(set, _)| named(set) && judged(set)).collect();
    if found.is_empty() {
        let nearest = nearest(claim, known.iter().map(String::as_str));
        let hint = nearest.map_or(String::new(), |name| format!("; did you mean `{name}`?"));
        refuse!(
            "--claim: found the unknown claim `{claim}`, expected a claim of {}{hint}",
            results.join("claims.csv").display()
        );
    }
    let [(set, standard)] = <[_; 1]>::try_from(found).map_err(|found| {
        let count = found.len();
        CommandError::BadInput(format!(
            "--claim: found `{claim}`, which {count} experiments contain, expected a claim of {} \
             that exactly one experiment contains; name the experiment",
            results.join("claims.csv").display()
        ))
    })?;
    let campaign = Campaign::expand([set]).map_err(CommandError::bad_input)?;
    let entry = &campaign.entries[0];
    let stated: Vec<&PaperClaim> =
        entry.experiment.claims.iter().filter(|one| one.claim == claim).collect();
    let folder = results.join(&entry.experiment.name);
    let read = |error: spinebench::data::DataError| CommandError::bad_input(error);
    let published: Vec<ClaimRow> = published_rows(&folder).map_err(read)?;
    let found = rerun(&campaign, entry, stated[0], &folder, threads, progress)?;
    let mut wrong = Vec::new();
    for row in &found {
        let same = |other: &&ClaimRow| other.claim == row.claim && other.training == row.training;
        let said = claim_sentence(row);
        match published.iter().find(same) {
            Some(before) if is_same(before, row, standard) => {
                progress.say(&format!("{said}; as published"));
            }
            Some(before) => wrong.push(format!("{said}; published: {}", claim_sentence(before))),
            None => wrong.push(format!("{said}; not published")),
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(CommandError::Failed(wrong.join("\n"))) }
}

/// The rows of the claim, from stages computed now.
fn rerun(
    campaign: &Campaign,
    entry: &CampaignEntry,
    claim: &PaperClaim,
    folder: &Path,
    threads: usize,
    progress: &Progress,
) -> Result<Vec<ClaimRow>, CommandError> {
    let wanted = entry.wanted_for(claim);
    let trail = published_rows(folder).unwrap_or_default();
    let (stages, cpu_s) = runner::published_cost(campaign, &wanted, &trail);
    progress.say(&format!(
        "{}: {}: {stages} of {} stages, {} of processor time in the published run",
        claim.claim,
        claim.relation.quantity(),
        campaign.graph.len(),
        duration(cpu_s)
    ));
    let scratch = tempfile::Builder::new()
        .prefix("spinebench-verify-")
        .tempdir()
        .map_err(|error| CommandError::Failed(format!("cannot create a folder: {error}")))?;
    exit_on_interrupt(
        "interrupted; nothing was compared. The same command starts again from the beginning",
    );
    let wanted: Vec<usize> = wanted.into_iter().collect();
    let outcomes = runner::execute(
        &campaign.graph,
        &Store::at(scratch.path()),
        &wanted,
        &RunOptions::new(threads, progress),
    )
    .map_err(CommandError::failed)?;
    if let Some(failure) = outcomes.failures.first() {
        return Err(CommandError::failed(failure));
    }
    entry.judged(claim, &outcomes).map_err(CommandError::failed)
}

/// Whether the numbers and the verdict are the same.
fn is_same(published: &ClaimRow, found: &ClaimRow, standard: Standard) -> bool {
    let share = match standard {
        Standard::Bytes => 0.0,
        Standard::Numbers(share) => share,
    };
    let numbers = |row: &ClaimRow| [row.ours, row.low_95, row.high_95];
    let close = |(one, other): (f64, f64)| {
        (one.is_nan() && other.is_nan())
            // Published numbers have nine significant digits.
            || (one - other).abs() <= share.max(1e-8) * one.abs().max(other.abs())
    };
    numbers(published).into_iter().zip(numbers(found)).all(close)
        && published.verdict == found.verdict
        && published.seeds == found.seeds
}
