//! `spinebench import`.

use super::import_map::{CsvImport, McapImport};
use super::simulate::written;
use crate::cli::program::outputs::check_recording;
use crate::cli::{CommandError, CommandResult};
use clap::{Args, Subcommand, ValueEnum};
use spinebench::data::import::{
    Axes, BadAxes, Body, Export, ExportFormat, ImportOptions, Imported, ImportedBodies, Log,
    SettingNames, TipFrame, import,
};
use spinebench::runner::Progress;
use std::path::PathBuf;

/// Import files of other systems as a recording: exports of motion capture systems, text files of
/// any logger, bags.
#[derive(Args)]
pub(crate) struct ImportCommand {
    #[command(subcommand)]
    from: From,
}

#[derive(Subcommand)]
enum From {
    /// Import OptiTrack Motive's CSV export (format versions 1.2x): rigid bodies or single markers.
    ///
    /// The tip is expressed relative to the base body's pivot and interpolated at the times of the
    /// commands; rows without tracking get valid = 0. A column export_time_s (the export's time at
    /// each row) or --offset-s relates the log to the export's clock.
    Motive(FromExport),
    /// Import the CSV export of Vicon Nexus or Tracker: objects, segments or trajectories.
    ///
    /// Frame 1 is at 0 s. Rotations of four numbers are quaternions. Rotations of three numbers are
    /// ambiguous and are not read. Otherwise as `import motive`.
    Vicon(FromExport),
    /// Import the TSV export of Qualisys Track Manager: rigid bodies (6D) or markers (3D).
    ///
    /// Reads the rotation matrix, not the angles. Otherwise as `import motive`.
    Qualisys(FromExport),
    /// Import the CSV of NDI's tools for Aurora, Polaris and Vega.
    ///
    /// Tools have the names of their ports or tools in the file. Otherwise as `import motive`.
    Ndi(FromExport),
    /// Import the markers of a C3D file, which most motion capture systems write.
    ///
    /// Otherwise as `import motive` with single markers.
    C3d(FromExport),
    Csv(CsvImport),
    Mcap(McapImport),
}

#[derive(Args)]
struct FromExport {
    /// Export of the motion capture system.
    #[arg(value_name = "EXPORT")]
    export: PathBuf,
    /// Commands: a recording, with or without tip columns; CSV or Parquet.
    #[arg(long, value_name = "LOG.csv")]
    commands: PathBuf,
    /// Recording to write; CSV or Parquet.
    #[arg(long, value_name = "REC.csv")]
    out: PathBuf,
    /// Rigid body or marker on the base [default: `base`, or the only one whose name begins with
    /// it].
    #[arg(long, value_name = "NAME")]
    base: Option<String>,
    /// Rigid body or marker on the tip [default: `tip`, or the only one whose name begins with it].
    #[arg(long, value_name = "NAME")]
    tip: Option<String>,
    /// Rigid bodies or markers along the robot, as `NAME` or `NAME=EXPORT NAME`: columns
    /// point_NAME_x_m … in the recording, NAME in the model's tracking.points.
    #[arg(long, value_name = "NAME[=EXPORT NAME],…", value_delimiter = ',')]
    points: Vec<String>,
    /// Export time at which each trial began, seconds, one number per trial. For a log with a
    /// column wall_time_s (one clock for all trials): the export time of the first row.
    #[arg(long, value_name = "S[,S…]", value_delimiter = ',', allow_hyphen_values = true, value_parser = seconds)]
    offset_s: Vec<f64>,
    /// Axes of the base frame (x up, z along the straight robot) in the export's. By default
    /// Motive's y is up and the robot lies along its z; other exports' axes are those of the robot.
    #[arg(long)]
    axes: Option<Axes>,
    /// Frame rate in Hz, for exports without one (NDI).
    #[arg(long, value_name = "HZ", value_parser = rate)]
    rate_hz: Option<f64>,
    /// Frame in which the tip is expressed.
    #[arg(long, value_enum, default_value_t = TipFrameArg::Base)]
    frame: TipFrameArg,
    /// Longest gap between tracked frames across which poses are interpolated, seconds.
    #[arg(long, value_name = "S", default_value_t = 0.05, value_parser = gap)]
    max_gap_s: f64,
}

#[derive(Clone, Copy, ValueEnum)]
enum TipFrameArg {
    /// Axes of the base body: a rotated tracking frame has no influence.
    Base,
    /// Axes of the tracking frame, which must be level: a tilt of the base appears in the tip
    /// positions.
    Tracking,
}

/// Angle between base and tracking frame above which the choice of frame is reported, degrees.
const MIN_REPORTED_TURN_DEG: f64 = 0.5;

impl ImportCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        match self.from {
            From::Motive(export) => export.execute(ExportFormat::Motive, progress),
            From::Vicon(export) => export.execute(ExportFormat::Vicon, progress),
            From::Qualisys(export) => export.execute(ExportFormat::Qualisys, progress),
            From::Ndi(export) => export.execute(ExportFormat::Ndi, progress),
            From::C3d(export) => export.execute(ExportFormat::C3d, progress),
            From::Csv(csv) => csv.execute(progress),
            From::Mcap(mcap) => mcap.execute(progress),
        }
    }
}

impl FromExport {
    fn execute(self, format: ExportFormat, progress: &Progress) -> CommandResult {
        let export = format.read(&self.export, self.rate_hz).map_err(CommandError::bad_input)?;
        let base = body(&export, self.base.as_deref(), "base")?;
        let tip = body(&export, self.tip.as_deref(), "tip")?;
        if std::ptr::eq(base, tip) {
            let (file, name) = (self.export.display(), &base.name);
            refuse!("{file}: found `{name}` as base and as tip, expected two different bodies");
        }
        let points =
            self.points.iter().map(|named| point(&export, named)).collect::<Result<Vec<_>, _>>()?;
        let twice = |(k, (name, _)): (usize, &(String, &Body))| {
            points[..k].iter().any(|(earlier, _)| earlier == name)
        };
        if let Some((name, _)) =
            points.iter().enumerate().find(|indexed| twice(*indexed)).map(|(_, point)| point)
        {
            refuse!("--points: found `{name}` twice, expected each name once");
        }
        let bodies = ImportedBodies { base, tip, points };
        let log = Log::read(&self.commands, &self.offset_s).map_err(CommandError::bad_input)?;
        let frame = match self.frame {
            TipFrameArg::Base => TipFrame::Base,
            TipFrameArg::Tracking => TipFrame::Tracking,
        };
        let options = ImportOptions {
            axes: self
                .axes
                .map_or_else(|| format.usual_axes().parse(), Ok)
                .map_err(|error: BadAxes| CommandError::BadInput(format!("--axes: {error}")))?,
            frame,
            max_gap_s: self.max_gap_s,
            gap_key: "--max-gap-s",
        };
        check_recording(&self.out, export.time_s.len())?;
        let imported = import(&export, &bodies, &log, &options).map_err(CommandError::bad_input)?;
        imported.recording.write(&self.out).map_err(CommandError::bad_input)?;
        self.print_notes(&export, base, &imported);
        progress.say(&written(&self.out, &imported.recording));
        Ok(())
    }

    /// Prints notes about missing frames, lost rows and the base's rotation.
    fn print_notes(&self, export: &Export, base: &Body, imported: &Imported) {
        let frames = export.time_s.len();
        if let Some(promised) = export.promised_frames.filter(|&promised| promised > frames) {
            let file = export.file.display();
            eprintln!("note: {file} has {frames} of the {promised} frames that its header states");
        }
        if !export.unread_orientations.is_empty() {
            eprintln!(
                "note: the rotations of {} have three numbers each; the file does not define their \
                 meaning, so they are not read",
                export.unread_orientations.join(", ")
            );
        }
        imported.notes(&OPTIONS).iter().for_each(|note| eprintln!("note: {note}"));
        if !base.has_orientation {
            eprintln!(
                "note: `{}` is a single marker: the tip is expressed along the tracking frame's \
                 axes, and a tilt of the base is not measured",
                base.name
            );
        }
        let turn_deg = imported.base_turn_rad.to_degrees();
        if turn_deg > MIN_REPORTED_TURN_DEG {
            let (axes_words, alternative) = match self.frame {
                TipFrameArg::Base => ("the base's", "--frame tracking includes a tilt of the base"),
                TipFrameArg::Tracking => {
                    ("the tracking frame's", "--frame base removes a rotated tracking frame")
                }
            };
            eprintln!(
                "note: the base body is rotated by {turn_deg:.1}° relative to the tracking frame; \
                 the tip is expressed along {axes_words} axes ({alternative})"
            );
        }
    }
}

const OPTIONS: SettingNames = SettingNames {
    axes: "--axes ",
    bodies: "--base and --tip",
    base: "--base",
    home: "the log of commands",
    clock: "subtract it from --offset-s or export_time_s",
    rows: "",
};

/// The body of this name; without one, the only body whose name begins with `usual`.
fn body<'a>(export: &'a Export, name: Option<&str>, usual: &str) -> Result<&'a Body, CommandError> {
    let body = match name {
        Some(name) => export.body(name),
        None => export.body_like(usual),
    };
    body.map_err(|error| CommandError::BadInput(format!("{error} (--{usual} NAME)")))
}

/// A point along the robot: its name in the recording, and its body or marker.
fn point<'a>(export: &'a Export, named: &str) -> Result<(String, &'a Body), CommandError> {
    let (name, asset) = named.split_once('=').unwrap_or((named, named));
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.is_empty() || !name.chars().all(is_plain) {
        refuse!(
            "--points: found `{name}`, expected a name of letters, digits and _, such as \
             `p1=Marker 1`"
        );
    }
    let body = export
        .body(asset)
        .map_err(|error| CommandError::BadInput(format!("{error} (--points {name}={asset})")))?;
    Ok((name.to_owned(), body))
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("found `{text}`, expected seconds"))
}

fn rate(text: &str) -> Result<f64, String> {
    seconds(text)
        .ok()
        .filter(|rate_hz| *rate_hz > 0.0)
        .ok_or_else(|| format!("found `{text}`, expected a frame rate in Hz, above 0"))
}

fn gap(text: &str) -> Result<f64, String> {
    seconds(text)
        .ok()
        .filter(|gap_s| *gap_s >= 0.0)
        .ok_or_else(|| format!("found `{text}`, expected seconds, 0 or more"))
}
