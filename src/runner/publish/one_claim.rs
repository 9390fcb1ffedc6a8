//! One claim of the paper: the stages behind its number, and its verdict from them alone.

use super::claims::evaluate;
use super::provenance::with_inputs;
use crate::data::DataError;
use crate::rows::experiment::{ClaimRow, StageRow};
use crate::runner::campaign::{Campaign, CampaignEntry, Repetition};
use crate::runner::execute::outcomes::Outcomes;
use crate::runner::graph::Handle;
use crate::specs::{ClaimMetric, PaperClaim};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

impl CampaignEntry {
    /// The stages whose results the number of a claim is made of.
    pub fn wanted_for(&self, claim: &PaperClaim) -> BTreeSet<usize> {
        let metrics = claim.relation.metrics();
        let repetitions = self.points.iter().flat_map(|point| &point.repetitions);
        repetitions
            .flat_map(|repetition| metrics.iter().flat_map(|metric| repetition.wanted_for(metric)))
            .collect()
    }

    /// The claim judged from the results of [`CampaignEntry::wanted_for`]: one row a kind of
    /// training.
    ///
    /// # Errors
    /// [`DataError::Write`] for rows that make no table.
    pub fn judged(
        &self,
        claim: &PaperClaim,
        outcomes: &Outcomes,
    ) -> Result<Vec<ClaimRow>, DataError> {
        let mut rows = Vec::new();
        for point in &self.points {
            let tables = point.tables(outcomes).as_published(Path::new("results"))?;
            let seeds: Vec<u64> =
                point.repetitions.iter().map(|repetition| repetition.seed).collect();
            let trainings: Vec<String> = point.experiment.training.keys().cloned().collect();
            let name = &self.experiment.name;
            rows.extend(evaluate(name, std::slice::from_ref(claim), &tables, &seeds, &trainings));
        }
        Ok(rows)
    }
}

impl Repetition {
    /// The stages whose results a metric is made of.
    fn wanted_for(&self, metric: &ClaimMetric) -> Vec<usize> {
        let trained = self.trained.iter();
        match metric {
            ClaimMetric::ReachMean(wanted) | ClaimMetric::ReachSd(wanted) => trained
                .flat_map(|cells| &cells.reach)
                .filter(|(cell, _)| wanted.includes(cell))
                .map(|(_, stage)| stage.number())
                .collect(),
            ClaimMetric::NetworkMae { network, points } => trained
                .flat_map(|cells| &cells.networks)
                .filter(|(description, size, _)| {
                    description.name == network.as_str()
                        && points.is_none_or(|points| points == *size as u64)
                })
                .map(|(_, _, stage)| stage.number())
                .collect(),
            // The number of points is known when the process is fitted.
            ClaimMetric::GpError { .. } => {
                self.gps.iter().map(|(_, stage)| stage.number()).collect()
            }
            ClaimMetric::TrackMean { policy }
            | ClaimMetric::TrackTime { policy }
            | ClaimMetric::TrackOscillation { policy }
            | ClaimMetric::TrackStart { policy } => trained
                .flat_map(|cells| &cells.track)
                .filter(|(cell, _)| cell.policy == *policy)
                .map(|(_, stage)| stage.number())
                .collect(),
            ClaimMetric::GapRms { .. } => self.gap.map(Handle::number).into_iter().collect(),
        }
    }
}

/// Number of stages that a claim needs, those before it included, and the processor time that the
/// published trail notes for them, seconds.
pub fn published_cost(
    campaign: &Campaign,
    wanted: &BTreeSet<usize>,
    trail: &[StageRow],
) -> (usize, f64) {
    let times: HashMap<(&str, &str), f64> =
        trail.iter().map(|row| ((row.stage.as_str(), row.label.as_str()), row.cpu_s)).collect();
    let needed = with_inputs(campaign, wanted.clone());
    let cpu_s = needed.iter().filter_map(|&number| {
        let (stage, label, _) = campaign.graph.describe(number);
        times.get(&(stage, label))
    });
    (needed.len(), cpu_s.sum())
}
