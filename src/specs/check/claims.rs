//! Checks of claims: each must be about something that the experiment runs.

use crate::policies::networks;
use crate::specs::document::error::SpecError;
use crate::specs::document::merged::Document;
use crate::specs::document::mismatch::one_of;
use crate::specs::document::path::KeyPath;
use crate::specs::experiment::cells::{gp_sizes, reach_cells};
use crate::specs::experiment::claims::{ClaimMetric, ReachCell, Relation};
use crate::specs::experiment::spec::Experiment;

/// Refuses the first claim that the experiment's rows cannot decide; of another robot none is judged.
pub(crate) fn check(experiment: &Experiment, document: &Document) -> Result<(), SpecError> {
    let mut names: Vec<&str> = Vec::new();
    for (index, claim) in experiment.claims.iter().enumerate() {
        let path = KeyPath::default().key("claims").item(index);
        if names.contains(&claim.claim.as_str()) {
            return Err(document.wrong(&path.key("claim"), "a name that no other claim has"));
        }
        names.push(&claim.claim);
        let path = path.key("relation");
        check_numbers(&claim.relation, document, &path)?;
        let is_judged = experiment.is_of_paper_robot();
        for (below, metric) in
            metric_paths(&claim.relation, &path).into_iter().filter(|_| is_judged)
        {
            check_metric(&metric, experiment)
                .map_err(|expected| document.wrong(&below, expected))?;
        }
    }
    Ok(())
}

/// The metrics of a relation, each with its path.
fn metric_paths(relation: &Relation, path: &KeyPath) -> Vec<(KeyPath, ClaimMetric)> {
    let keys = match relation {
        Relation::Less { .. } => vec![path.key("less").key("left"), path.key("less").key("right")],
        Relation::Between { .. } => vec![path.key("between").key("metric")],
        Relation::Near { .. } => vec![path.key("near").key("metric")],
        Relation::Falls { values, .. } => {
            let path = path.key("falls").key("values");
            (0..values.len()).map(|index| path.item(index)).collect()
        }
        Relation::NoGain { beyond, .. } => {
            let path = path.key("no_gain");
            let beyond = (0..beyond.len()).map(|index| path.key("beyond").item(index));
            std::iter::once(path.key("from")).chain(beyond).collect()
        }
        Relation::Alike { metrics, .. } => {
            (0..metrics.len()).map(|index| path.key("alike").key("metrics").item(index)).collect()
        }
    };
    keys.into_iter().zip(relation.metrics()).collect()
}

/// Checks ranges and lengths.
fn check_numbers(
    relation: &Relation,
    document: &Document,
    path: &KeyPath,
) -> Result<(), SpecError> {
    let unless = |holds: bool, path: KeyPath, expected: &str| {
        if holds { Ok(()) } else { Err(document.wrong(&path, expected)) }
    };
    let sweepable = |metric: &ClaimMetric| {
        matches!(metric, ClaimMetric::ReachMean(_) | ClaimMetric::ReachSd(_))
    };
    match relation {
        Relation::Less { times, .. } => {
            unless(*times > 0.0, path.key("less").key("times"), "a factor above 0")
        }
        Relation::Between { low, high, .. } => {
            unless(low < high, path.key("between").key("low"), "less than `high`")
        }
        Relation::Near { tolerance, .. } => {
            unless(*tolerance > 0.0, path.key("near").key("tolerance"), "a tolerance above 0")
        }
        Relation::Falls { metric, values, .. } => {
            let path = path.key("falls");
            unless(values.len() > 1, path.key("values"), "at least two sizes")?;
            unless(sweepable(metric), path.key("metric"), "`reach_mean` or `reach_sd`")
        }
        Relation::NoGain { metric, beyond, margin, .. } => {
            let path = path.key("no_gain");
            unless(!beyond.is_empty(), path.key("beyond"), "at least one size")?;
            unless(*margin > 0.0, path.key("margin"), "a margin above 0")?;
            unless(sweepable(metric), path.key("metric"), "`reach_mean` or `reach_sd`")
        }
        Relation::Alike { metrics, times } => {
            let path = path.key("alike");
            unless(metrics.len() > 1, path.key("metrics"), "at least two metrics")?;
            unless(*times > 1.0, path.key("times"), "a factor above 1")
        }
    }
}

/// Checks that the experiment yields this metric; the error is what was expected.
fn check_metric(metric: &ClaimMetric, experiment: &Experiment) -> Result<(), String> {
    let runs = &experiment.runs;
    match metric {
        ClaimMetric::ReachMean(cell) | ClaimMetric::ReachSd(cell) => check_cell(cell, experiment),
        ClaimMetric::NetworkMae { network, .. } => {
            let names: Vec<&str> = networks().iter().map(|network| network.name).collect();
            if names.contains(&network.as_str()) { Ok(()) } else { Err(one_of(&names)) }
        }
        ClaimMetric::GpError { points } => {
            let fitted = gp_sizes(experiment);
            let is_fitted = usize::try_from(*points).is_ok_and(|points| fitted.contains(&points));
            if is_fitted { Ok(()) } else { Err(format!("one of the fitted sizes {fitted:?}")) }
        }
        ClaimMetric::TrackMean { policy }
        | ClaimMetric::TrackTime { policy }
        | ClaimMetric::TrackOscillation { policy }
        | ClaimMetric::TrackStart { policy } => match &runs.track {
            Some(track) if track.policies.contains(policy) => Ok(()),
            _ => Err("a policy of `runs.track`".to_owned()),
        },
        ClaimMetric::GapRms { .. } if runs.gap.is_some() => Ok(()),
        ClaimMetric::GapRms { .. } => Err("`runs.gap`, which this needs".to_owned()),
    }
}

fn check_cell(cell: &ReachCell, experiment: &Experiment) -> Result<(), String> {
    let cells = reach_cells(experiment);
    let fits = |wanted: Option<u64>, size: u64| wanted.is_none_or(|wanted| wanted == size);
    let matching = cells.iter().filter(|candidate| {
        candidate.policy == cell.policy
            && candidate.mode == cell.mode
            && fits(cell.gp_points, candidate.gp_points)
            && fits(cell.real_points, candidate.real_points)
    });
    match matching.count() {
        1 => Ok(()),
        0 => Err("trials that `runs.reach` makes".to_owned()),
        several => Err(format!("`gp_points` or `real_points`, as {several} cells fit")),
    }
}
