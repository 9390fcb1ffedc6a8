//! The files of all experiments of a campaign: rendered first, then written.

use super::manifest::Manifest;
use super::provenance::provenance;
use super::results::{Files, Publication, all_claims, put, write_files};
use crate::rows::experiment::ClaimRow;
use crate::runner::campaign::{Campaign, CampaignEntry};
use crate::runner::execute::outcomes::Outcomes;
use crate::runner::store::Store;
use std::collections::BTreeMap;
use std::path::Path;

/// What the manifest of an experiment says of its run besides its stages.
pub struct RunFacts<'a> {
    /// Revision of the repository when the run began.
    pub revision: &'a str,
    /// Number of threads of a stage of an experiment.
    pub threads: &'a dyn Fn(&CampaignEntry) -> usize,
    /// Duration of the run, seconds.
    pub wall_s: f64,
}

/// Renders all files of all experiments, then writes them below `out`.
///
/// # Errors
/// The experiment and what cannot be rendered or written, in words.
pub fn publish_all(
    campaign: &Campaign,
    outcomes: &Outcomes,
    store: &Store,
    out: &Path,
    run: &RunFacts,
) -> Result<Vec<Publication>, String> {
    let words = |error: &dyn std::error::Error| error.to_string();
    let mut published = Vec::new();
    let mut files = Files::new();
    let mut claims: BTreeMap<String, Vec<ClaimRow>> = BTreeMap::new();
    for entry in &campaign.entries {
        let name = entry.experiment.name.clone();
        let publication = entry.publish(outcomes).map_err(|error| format!("{name}: {error}"))?;
        let manifest = Manifest::new(campaign, entry, outcomes, store, run);
        let folder = Path::new("results").join(&name);
        files.insert(folder.join("manifest.yaml"), manifest.to_yaml()?);
        let trail = provenance(campaign, entry, outcomes, store);
        put(&mut files, &folder, &trail).map_err(|error| words(&error))?;
        files.extend(publication.files.clone());
        claims.insert(name, publication.claims.clone());
        published.push(publication);
    }
    files.extend(all_claims(out, &claims).map_err(|error| words(&error))?);
    write_files(out, &files).map_err(|error| words(&error))?;
    Ok(published)
}
