//! `spinebench plan`.

use crate::cli::CommandResult;
use crate::cli::program::shared::{CacheArgs, SpecArgs, print_all};
use clap::Args;
use spinebench::runner::{Campaign, CampaignEntry, Need, plan};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Print the expanded runs and the numbers of stored and missing stages; run nothing.
#[derive(Args)]
pub(crate) struct PlanCommand {
    #[command(flatten)]
    specs: SpecArgs,
    #[command(flatten)]
    cache: CacheArgs,
}

impl PlanCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let campaign = self.specs.campaign(|note| eprintln!("note: {note}"))?;
        let needs = plan(&campaign.graph, &self.cache.store(), &campaign.wanted());
        let mut text = String::new();
        for entry in &campaign.entries {
            describe(entry, &needs, &mut text);
        }
        stages(&campaign, &needs, &mut text);
        print_all(text.as_bytes());
        // Dropping a hundred thousand stages takes a tenth of the run time, and the process ends
        // here.
        std::mem::forget(campaign);
        Ok(())
    }
}

fn describe(entry: &CampaignEntry, needs: &[Need], text: &mut String) {
    let experiment = &entry.experiment;
    let cells = entry.cells();
    let to_compute = cells.iter().filter(|cell| needs[cell.stage] == Need::Compute).count();
    let (name, seeds, all) = (&experiment.name, experiment.seeds, cells.len());
    let _ = writeln!(
        text,
        "{name}: {all} runs over {seeds} seeds, {} stored, {to_compute} left",
        all - to_compute
    );
    for cell in cells {
        let state = if needs[cell.stage] == Need::Compute { "left" } else { "stored" };
        let _ = writeln!(text, "  {state:6} {}", cell.label);
    }
}

/// Stored and missing stages by kind; a stage that several runs share counts once.
fn stages(campaign: &Campaign, needs: &[Need], text: &mut String) {
    let mut kinds: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (number, need) in needs.iter().enumerate() {
        let counts = kinds.entry(campaign.graph.describe(number).0).or_default();
        match need {
            Need::None => {}
            Need::Cached => counts[0] += 1,
            Need::Compute => counts[1] += 1,
        }
    }
    let [stored, to_compute] =
        kinds.values().fold([0, 0], |sum, counts| [sum[0] + counts[0], sum[1] + counts[1]]);
    let _ = writeln!(text, "stages: {stored} stored, {to_compute} left");
    for (kind, [stored, to_compute]) in kinds {
        let _ = writeln!(text, "  {kind:16} {stored:6} stored {to_compute:6} left");
    }
}
