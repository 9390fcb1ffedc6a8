//! `spinebench cache`.

use crate::cli::program::shared::{CacheArgs, print_all};
use crate::cli::{CommandError, CommandResult};
use clap::{Args, Subcommand};
use spinebench::runner::stages::codes;
use spinebench::runner::{Digest, EntryState, Store, StoredEntry};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Duration;

/// List, measure, check and prune the stored results of stages.
#[derive(Args)]
pub(crate) struct CacheCommand {
    #[command(subcommand)]
    action: CacheAction,
    #[command(flatten)]
    cache: CacheArgs,
}

#[derive(Subcommand)]
enum CacheAction {
    /// List every entry: kind of stage, key, size, age, whether the present code reads it, label.
    List {
        /// List only this kind of stage.
        #[arg(long, value_name = "STAGE")]
        stage: Option<String>,
    },
    /// Print the number and size of entries by kind of stage.
    Size,
    /// Read and check every entry; exit with status 1 when one is damaged.
    Verify,
    /// Remove damaged entries, entries that other code computed, and unfinished files of dead
    /// processes.
    Prune {
        /// Also remove entries older than this many days.
        #[arg(long, value_name = "DAYS")]
        older_than: Option<f64>,
        /// Print what would be removed, and remove nothing.
        #[arg(long)]
        dry_run: bool,
    },
}

impl CacheCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let store = self.cache.store();
        let unreadable = |error| {
            CommandError::BadInput(format!(
                "{}: found {error}, expected a store",
                store.root().display()
            ))
        };
        let entries = store.entries().map_err(unreadable)?;
        let mut text = String::new();
        let outcome = match &self.action {
            CacheAction::List { stage } => {
                list(&entries, stage.as_deref(), &mut text);
                Ok(())
            }
            CacheAction::Size => {
                size(&entries, &mut text);
                Ok(())
            }
            CacheAction::Verify => verify(&store, &entries, &mut text),
            CacheAction::Prune { older_than, dry_run } => {
                prune(&store, &entries, *older_than, *dry_run, &mut text)
            }
        };
        print_all(text.as_bytes());
        outcome
    }
}

fn list(entries: &[StoredEntry], stage: Option<&str>, text: &mut String) {
    let codes = codes();
    for entry in entries.iter().filter(|entry| stage.is_none_or(|stage| entry.stage == stage)) {
        let state = if entry.state(&codes) == EntryState::Current { "current" } else { "stale" };
        let label = entry.note.as_ref().map_or("", |note| note.label.as_str());
        let (stage, key, bytes, age) =
            (&entry.stage, entry.key.short(), entry.bytes, days(entry.age));
        let _ = writeln!(text, "{stage:16} {key} {bytes:>10} B {age:8.2} days {state:7} {label}");
    }
}

fn size(entries: &[StoredEntry], text: &mut String) {
    let codes: BTreeMap<&str, Digest> = codes();
    let mut kinds: BTreeMap<&str, [u64; 4]> = BTreeMap::new();
    for entry in entries {
        let counts = kinds.entry(&entry.stage).or_default();
        let stale = entry.state(&codes) == EntryState::Stale;
        let add = [1, entry.bytes, u64::from(stale), if stale { entry.bytes } else { 0 }];
        counts.iter_mut().zip(add).for_each(|(count, add)| *count += add);
    }
    let mut line = |kind: &str, [count, bytes, stale, stale_bytes]: [u64; 4]| {
        let (all, old) = (megabytes(bytes), megabytes(stale_bytes));
        let _ = writeln!(
            text,
            "{kind:16} {count:7} entries {all:10.3} MB, stale {stale:7} {old:10.3} MB"
        );
    };
    let mut sum = [0; 4];
    for (kind, counts) in kinds {
        line(kind, counts);
        sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    line("all", sum);
}

fn verify(store: &Store, entries: &[StoredEntry], text: &mut String) -> CommandResult {
    let damaged: Vec<(&StoredEntry, String)> =
        entries.iter().filter_map(|entry| Some((entry, store.damage(entry)?))).collect();
    for (entry, reason) in &damaged {
        let _ = writeln!(text, "{} {}: {reason}", entry.stage, entry.key.short());
    }
    let good = entries.len() - damaged.len();
    let _ = writeln!(text, "{good} good, {} damaged", damaged.len());
    match damaged.len() {
        0 => Ok(()),
        count => Err(CommandError::Failed(format!(
            "{count} entries are damaged; the next run recomputes them"
        ))),
    }
}

fn prune(
    store: &Store,
    entries: &[StoredEntry],
    older_than: Option<f64>,
    dry_run: bool,
    text: &mut String,
) -> CommandResult {
    if let Some(found) = older_than.filter(|days| !(days.is_finite() && *days >= 0.0)) {
        refuse!("--older-than: found {found}, expected a number of days");
    }
    let codes = codes();
    let useless = |entry: &&StoredEntry| {
        let too_old = older_than.is_some_and(|limit| days(entry.age) > limit);
        too_old || entry.state(&codes) == EntryState::Stale || store.damage(entry).is_some()
    };
    let useless: Vec<&StoredEntry> = entries.iter().filter(useless).collect();
    let leftover_files = store.leftovers().map_err(CommandError::failed)?;
    let bytes = useless
        .iter()
        .map(|entry| entry.bytes)
        .chain(leftover_files.iter().map(|(_, bytes)| *bytes))
        .sum();
    if !dry_run {
        useless.iter().try_for_each(|entry| store.remove(entry)).map_err(CommandError::failed)?;
        leftover_files
            .iter()
            .try_for_each(|(path, _)| std::fs::remove_file(path))
            .map_err(CommandError::failed)?;
    }
    let (entries, leftovers, megabytes) = (useless.len(), leftover_files.len(), megabytes(bytes));
    let verb = if dry_run { "would remove" } else { "removed" };
    let _ = writeln!(
        text,
        "{verb} {entries} entries and {leftovers} unfinished files, {megabytes:.3} MB"
    );
    Ok(())
}

fn days(age: Duration) -> f64 {
    age.as_secs_f64() / 86_400.0
}

#[allow(clippy::cast_precision_loss)] // a size for display
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
