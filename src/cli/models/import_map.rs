//! `spinebench import csv` and `spinebench import mcap`: files of any logger, by a map.

use super::simulate::written;
use crate::cli::program::outputs::check_recording;
use crate::cli::{CommandError, CommandResult};
use clap::{Args, ValueEnum};
use spinebench::data::import::mapped::{
    ClockFit, ImportMap, LogFiles, MappedImport, RepeatedStamps, SourceKind, TrialClock,
    import_bag, import_text,
};
use spinebench::runner::Progress;
use spinebench::specs::read_map;
use std::path::{Path, PathBuf};

/// Import text files of any logger by a map of columns, units, axes, rates and clocks.
///
/// The map is a YAML file (`spinebench schema map`, docs/reference/importing.md). The recording has
/// one row per command. Poses from another file, or with another rate or clock, are interpolated at
/// the command times. An offset between the clocks is given in the map, or estimated from the
/// motion and printed with its interval.
#[derive(Args)]
pub(crate) struct CsvImport {
    /// Text files, in the order in which the map numbers them. If the map has `trial_files`, which
    /// selects the files of the trials: a folder, or names with * and ?.
    #[arg(value_name = "LOG.csv", required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    by: ByMap,
}

/// Import a bag of ROS 2 (MCAP) by a map of topics and fields.
///
/// Reads CDR messages of any type whose definition is in the bag. The map is that of `import csv`,
/// with `topic` instead of `file`.
#[derive(Args)]
pub(crate) struct McapImport {
    /// Bag.
    #[arg(value_name = "BAG.mcap")]
    bag: PathBuf,
    #[command(flatten)]
    by: ByMap,
}

#[derive(Args)]
struct ByMap {
    /// Map of columns or topics, YAML.
    #[arg(long, value_name = "MAP.yaml")]
    map: PathBuf,
    /// Recording to write; CSV or Parquet.
    #[arg(long, value_name = "REC.csv")]
    out: PathBuf,
    /// Treatment of command rows with equal times; overrides `commands.repeated` of the map.
    #[arg(long, value_enum)]
    repeated: Option<RepeatedArg>,
}

#[derive(Clone, Copy, ValueEnum)]
enum RepeatedArg {
    /// Report an error.
    Refuse,
    /// Keep the last row.
    Last,
}

impl ByMap {
    fn read(&self, source: SourceKind) -> Result<ImportMap, CommandError> {
        let mut map = read_map(&self.map, source).map_err(CommandError::bad_input)?;
        match self.repeated {
            Some(RepeatedArg::Refuse) => map.commands.repeated = RepeatedStamps::Refuse,
            Some(RepeatedArg::Last) => map.commands.repeated = RepeatedStamps::Last,
            None => {}
        }
        Ok(map)
    }
}

impl CsvImport {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let logs = LogFiles::find(&self.logs).map_err(CommandError::bad_input)?;
        let map = self.by.read(SourceKind::from(&logs))?;
        check_recording(&self.by.out, 0)?;
        let mapped = import_text(&logs.files, &map).map_err(CommandError::bad_input)?;
        finish(&mapped, &self.by.out, progress)
    }
}

impl McapImport {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let map = self.by.read(SourceKind::Bag)?;
        check_recording(&self.by.out, 0)?;
        let mapped = import_bag(&self.bag, &map).map_err(CommandError::bad_input)?;
        finish(&mapped, &self.by.out, progress)
    }
}

/// Prints notes and writes the recording.
fn finish(mapped: &MappedImport, out: &Path, progress: &Progress) -> CommandResult {
    check_recording(out, mapped.recording.len())?;
    mapped.recording.write(out).map_err(CommandError::bad_input)?;
    mapped.clocks.iter().for_each(print_clock);
    mapped.notes().iter().for_each(|note| eprintln!("note: {note}"));
    progress.say(&written(out, &mapped.recording));
    Ok(())
}

fn print_clock(TrialClock { trial, fit }: &TrialClock) {
    let ClockFit { offset_s, interval_95_s: [low_s, high_s], lag_s, explained, dead_time_s } = fit;
    let prefix = trial.map_or(String::new(), |trial| format!("trial {trial}: "));
    let dead_time = if *dead_time_s > 0.0 {
        format!("The interval includes a dead time of the drive of up to {dead_time_s} s.")
    } else {
        "A dead time of the drive increases the estimated shift by that time; a recording does not \
         distinguish the two (`tracking.clock.estimate.dead_time_s` widens the interval)."
            .to_owned()
    };
    eprintln!(
        "note: {prefix}the tracker's times are shifted by {offset_s:.4} s (95 % interval \
         {low_s:.4} to {high_s:.4} s): at this offset the commands, with a lag of {lag_s:.3} s, \
         explain {:.1} % of the tip's motion. {dead_time}",
        100.0 * explained
    );
}
