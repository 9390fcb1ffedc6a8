//! `spinebench import csv` and `spinebench import mcap`: files of any logger, by a map.

use super::import::{SettingNames, print_doubts};
use super::outputs::check_recording;
use super::simulate::written;
use super::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::import::mapped::{ClockFit, MappedImport, SourceKind, import_bag, import_text};
use spinebench::runner::Progress;
use spinebench::specs::read_map;
use std::path::{Path, PathBuf};

/// Import text files of any logger by a map of columns, units, axes, rates and clocks.
///
/// The map is a YAML file (`spinebench schema map`, docs/importing.md). The rows of the recording are those of the commands;
/// poses of another file, rate or clock are interpolated at their times. An offset between the clocks is given in the map, or
/// estimated from the motion and printed with its interval.
#[derive(Args)]
pub(super) struct CsvImport {
    /// Text files, in the order in which the map counts them.
    #[arg(value_name = "LOG.csv", required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    by: ByMap,
}

/// Import a bag of ROS 2 (MCAP) by a map of topics and fields.
///
/// Messages in CDR: PoseStamped, TransformStamped, TFMessage, Odometry, JointState and Float64MultiArray. The map is as for
/// `import csv`, with `topic` in place of `file`.
#[derive(Args)]
pub(super) struct McapImport {
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
}

impl CsvImport {
    pub(super) fn execute(self, progress: &Progress) -> CommandResult {
        let map = read_map(&self.by.map, SourceKind::Text(self.logs.len())).map_err(CommandError::bad_input)?;
        check_recording(&self.by.out, 0)?;
        let found = import_text(&self.logs, &map).map_err(CommandError::bad_input)?;
        finish(&found, &self.by.out, progress)
    }
}

impl McapImport {
    pub(super) fn execute(self, progress: &Progress) -> CommandResult {
        let map = read_map(&self.by.map, SourceKind::Bag).map_err(CommandError::bad_input)?;
        check_recording(&self.by.out, 0)?;
        let found = import_bag(&self.bag, &map).map_err(CommandError::bad_input)?;
        finish(&found, &self.by.out, progress)
    }
}

const KEYS: SettingNames = SettingNames {
    axes: "`tracking.axes` ",
    bodies: "`tracking.base` and `tracking.tip`",
    clock: "add it to `tracking.clock.offset_s`",
};

/// Prints notes and writes the recording.
fn finish(found: &MappedImport, out: &Path, progress: &Progress) -> CommandResult {
    check_recording(out, found.recording.len())?;
    found.recording.write(out).map_err(CommandError::bad_input)?;
    if let Some(clock) = &found.clock {
        print_clock(clock);
    }
    if let Some(imported) = &found.imported {
        if imported.lost > 0 {
            let (lost, all, out) = (imported.lost, found.recording.len(), out.display());
            eprintln!("note: {lost} of {all} rows were not tracked; they have valid = 0 in {out}");
        }
        print_doubts(&imported.doubts, &found.recording, &KEYS);
    }
    progress.say(&written(out, &found.recording));
    Ok(())
}

fn print_clock(clock: &ClockFit) {
    let ClockFit { offset_s, interval_95_s: [low_s, high_s], lag_s, explained } = clock;
    eprintln!(
        "note: the tracker's times are shifted by {offset_s:.4} s (95 % interval {low_s:.4} to {high_s:.4} s): at this offset \
         the commands, with a lag of {lag_s:.3} s, explain {:.1} % of the tip's motion; a dead time of the drive is part of it",
        100.0 * explained
    );
}
