//! What a map says: which columns of other people's files hold what, in which units, along which
//! axes and on which clock.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::cell_match::CellMatch;
use super::columns::ColumnName;
use super::units::{AngleUnit, CommandUnit, LengthUnit, MassUnit, TimeUnit};
use crate::base::PerTendon;
use crate::data::import::Axes;

/// A map from the columns of a logger's files, or from the topics of a bag, to a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportMap {
    /// Format of the text files.
    #[serde(default)]
    pub text: TextFormat,
    /// Names of files that contain one trial each.
    pub trial_files: Option<TrialFilesMap>,
    /// Commands: one row of the recording for each of their rows.
    pub commands: CommandsMap,
    /// Tracking; without it the recording contains only commands.
    pub tracking: Option<TrackingMap>,
}

/// Names of files that contain one trial each. `{trial}` stands for the trial's number or name, `*`
/// for any characters and `?` for one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrialFilesMap {
    /// Names of the files of commands, such as `run_{trial}.csv`.
    pub commands: String,
    /// Names of the files of tracking, if they are separate.
    pub tracking: Option<String>,
}

/// Format of a text file. A byte-order mark is ignored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TextFormat {
    /// Separator of cells: one character; a space means any number of spaces and tabs.
    pub delimiter: String,
    /// Decimal sign: `.` or `,`.
    pub decimal: String,
    /// Beginning of comment lines.
    pub comment: Option<String>,
    /// The table begins after the line whose first cell is this, and ends at an empty line; by
    /// default the whole file is the table.
    pub block: Option<String>,
    /// Number of ignored lines before the header.
    pub skip_lines: usize,
    /// Whether the first line contains the names of the columns; otherwise columns are named by
    /// their numbers.
    pub header: bool,
    /// Lines of the header. The names of a column in them are joined by a space; a name in an upper
    /// line also applies to the empty cells to its right: `tip` above `TX` is `tip TX`.
    pub header_lines: usize,
    /// Whether a line of units follows the header. They are compared with those of the map.
    pub units_line: bool,
}

impl Default for TextFormat {
    fn default() -> Self {
        TextFormat {
            delimiter: ",".into(),
            decimal: ".".into(),
            comment: None,
            block: None,
            skip_lines: 0,
            header: true,
            header_lines: 1,
            units_line: false,
        }
    }
}

/// Location of the commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CommandsMap {
    /// Number of the file on the command line, from 1.
    #[serde(default = "first")]
    pub file: usize,
    /// Topic of a bag.
    pub topic: Option<String>,
    /// Format of this file; overrides the map's `text`.
    pub text: Option<TextFormat>,
    /// Condition on cells that selects the rows with commands.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, CellMatch>")]
    pub conditions: RowConditions,
    /// Time of each row; by default that of the bag's messages. Rows of a text file without times
    /// are poses at rest.
    pub time: Option<TimeMap>,
    /// Treatment of rows with equal times.
    #[serde(default)]
    pub repeated: RepeatedStamps,
    /// Column with the number or name of the trial; by default all rows are one trial.
    pub trial: Option<ColumnName>,
    /// A new trial begins after a gap of more than this between rows, s.
    pub trial_gap_s: Option<f64>,
    /// Commands of tendons.
    pub tendons: Option<TendonsMap>,
    /// Commands of drives by the drives' names, instead of commands of tendons.
    #[serde(default)]
    pub drives: BTreeMap<String, DriveMap>,
    /// Column of labels by which rows can be held out.
    pub pattern: Option<ColumnName>,
    /// Known weight on the tip.
    pub known_load: Option<LoadColumn>,
}

fn first() -> usize {
    1
}

/// Time of each row: a column of times, a sum of columns, or frames at a rate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TimeMap {
    /// The column of times; with `rate_hz` that of frame numbers.
    pub column: Option<ColumnName>,
    /// Unit of the times.
    pub unit: TimeUnit,
    /// Zone of dates that are written without one, such as `+01:00` or `Z`.
    pub zone: Option<String>,
    /// Columns whose times are added, instead of `column`: seconds and nanoseconds, or hours,
    /// minutes and seconds, which restart at midnight.
    pub sum: Vec<TimePart>,
    /// The rows are frames at this rate, Hz.
    pub rate_hz: Option<FrameRate>,
    /// Number of the frame at time 0; by default that of the first row of the file.
    pub first_frame: Option<i64>,
}

/// A column with a part of the time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimePart {
    /// The column.
    pub column: ColumnName,
    /// Its unit.
    pub unit: TimeUnit,
}

/// The rate of frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged)]
pub enum FrameRate {
    /// Hz.
    Hz(f64),
    /// The first number after this word in the lines before the header, or in comments there.
    Word(String),
}

/// Conditions on the cells of a row: each column contains this text or number.
pub type RowConditions = BTreeMap<ColumnName, CellMatch>;

/// Treatment of command rows with equal times.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum RepeatedStamps {
    /// Report an error.
    #[default]
    Refuse,
    /// Keep the last row.
    Last,
}

/// A column of masses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadColumn {
    /// The column.
    pub column: ColumnName,
    /// Its unit.
    #[serde(default)]
    pub unit: MassUnit,
}

/// Commands of all tendons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TendonsMap {
    /// One column per tendon, in the order of the model's tendons.
    pub columns: Vec<ColumnName>,
    /// Their unit.
    #[serde(default)]
    pub unit: CommandUnit,
    /// Metres of tendon per radian of a drum (whatever the unit of angle) or per encoder count; for
    /// other units a factor. One number, or one per tendon.
    pub scale: Option<PerTendon>,
    /// Meaning of the numbers.
    #[serde(default)]
    pub measure: TendonMeasure,
    /// Number at home.
    pub zero: Option<ZeroAt>,
    /// The numbers at home, one per tendon, in the column's unit; overrides `zero`.
    pub home: Option<Vec<f64>>,
}

/// Commands of one drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveMap {
    /// The column.
    pub column: ColumnName,
    /// Its unit.
    #[serde(default)]
    pub unit: CommandUnit,
    /// Radians per encoder count; for other units a factor.
    pub scale: Option<f64>,
    /// Number at home.
    #[serde(default)]
    pub zero: ZeroAt,
    /// The number at home, in the column's unit; overrides `zero`.
    pub home: Option<f64>,
}

/// Meaning of a tendon's number.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum TendonMeasure {
    /// Length of tendon pulled out of the robot: more pulls.
    #[default]
    Pulled,
    /// Released length of tendon: more releases.
    Released,
    /// Length of tendon in the robot: less pulls. Home is the first row unless `zero` or `home` is
    /// given.
    Length,
}

/// Position of home in a column.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum ZeroAt {
    /// At the number 0.
    #[default]
    Zero,
    /// At the number in the first row of the file.
    FirstRow,
    /// At the number in the first row of each trial.
    TrialStart,
}

/// Location of the tracked poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackingMap {
    /// Number of the file on the command line, from 1; by default the last.
    pub file: Option<usize>,
    /// Topic of a bag, for all bodies without a topic.
    pub topic: Option<String>,
    /// Format of this file; overrides the map's `text`.
    pub text: Option<TextFormat>,
    /// Time of each row; without it the rows are those of the commands.
    pub time: Option<TimeMap>,
    /// Unit of positions.
    #[serde(default)]
    pub unit: LengthUnit,
    /// The recording's axes (x up, z along the straight robot) in terms of the tracker's, such as
    /// `x=+y,y=-x,z=+z` for a tracker with y up.
    #[serde(default = "same_axes")]
    pub axes: String,
    /// Whether the tracker's axes are left-handed (as in game engines).
    #[serde(default)]
    pub left_handed: bool,
    /// Order of the four columns of an orientation.
    #[serde(default)]
    pub quaternion: QuaternionOrder,
    /// Meaning of the three `angles` of a body; required if a body has them.
    pub euler: Option<EulerMap>,
    /// The tip.
    pub tip: BodyMap,
    /// The base; without it positions are measured from `origin` along the tracker's axes.
    pub base: Option<BodyMap>,
    /// Position of the base along the tracker's axes, in the unit of positions, if the base is not
    /// tracked.
    pub origin: Option<[f64; 3]>,
    /// Further points along the body, by their names in the recording.
    #[serde(default)]
    pub points: BTreeMap<String, BodyMap>,
    /// Axes of the tip position if the base is tracked.
    #[serde(default)]
    pub frame: FrameChoice,
    /// Column that is 0 if tracking was lost.
    pub valid: Option<ColumnName>,
    /// Number in a position that means lost tracking. Empty cells and NaN always mean lost
    /// tracking.
    pub lost_value: Option<f64>,
    /// Longest gap between tracked rows across which poses are interpolated, s.
    #[serde(default = "bridged")]
    pub max_gap_s: f64,
    /// The tracker's clock.
    #[serde(default)]
    pub clock: ClockMap,
}

fn same_axes() -> String {
    Axes::SAME.to_owned()
}

fn bridged() -> f64 {
    0.05
}

/// A tracked body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyMap {
    /// Topic of a bag, if it differs from that of `tracking`.
    pub topic: Option<String>,
    /// Name of the child frame, or of the item of a list, in a message that holds several.
    pub child: Option<String>,
    /// Condition on cells that selects the rows of this body in a table of several bodies.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, CellMatch>")]
    pub conditions: RowConditions,
    /// Columns of x, y and z; by default those of the topic's kind of message.
    pub position: Option<[ColumnName; 3]>,
    /// Columns of the unit quaternion; by default those of the topic's kind of message, if it has
    /// any.
    pub orientation: Option<[ColumnName; 4]>,
    /// Columns of three Euler angles instead of a quaternion, in the order of
    /// `tracking.euler.order`.
    pub angles: Option<[ColumnName; 3]>,
}

/// Order of a quaternion's parts.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum QuaternionOrder {
    /// w, x, y, z.
    #[default]
    Wxyz,
    /// x, y, z, w.
    Xyzw,
}

/// Convention of Euler angles. There is no default, because conventions differ between trackers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EulerMap {
    /// Axes of the three rotations, in the order of execution.
    pub order: EulerOrder,
    /// Axes of the second and third rotation.
    pub rotation: EulerRotation,
    /// Unit of the angles.
    pub unit: AngleUnit,
}

/// Axes of three successive rotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum EulerOrder {
    Xyz,
    Xzy,
    Yxz,
    Yzx,
    Zxy,
    Zyx,
    Xyx,
    Xzx,
    Yxy,
    Yzy,
    Zxz,
    Zyz,
}

/// Axes of the second and third rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EulerRotation {
    /// The axes of the body, rotated by the preceding rotations.
    Intrinsic,
    /// The fixed axes of the tracker.
    Extrinsic,
}

/// Axes of the tip position.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum FrameChoice {
    /// Axes of the base body: a rotated tracking frame has no influence.
    #[default]
    Base,
    /// Axes of the tracking frame, which must be level: a tilt of the base appears in the tip
    /// positions.
    Tracking,
}

/// Relation of the tracker's clock to the clock of the commands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ClockMap {
    /// Both use the same clock.
    #[default]
    Same,
    /// Seconds added to the tracker's times.
    OffsetS(f64),
    /// The tracker's first row is this many seconds after the first command.
    FirstRowAfterS(f64),
    /// The offset is estimated from the motion, within these limits.
    Estimate(OffsetRange),
}

/// Limits of an unknown offset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OffsetRange {
    /// Smallest offset, s; by default the offset at which the tracking ends at half of the
    /// commands.
    pub from_s: Option<f64>,
    /// Largest offset, s; by default the offset at which the tracking begins at half of the
    /// commands.
    pub to_s: Option<f64>,
    /// Largest dead time of the drive, s. The motion does not distinguish it from an offset; the
    /// interval includes it.
    pub dead_time_s: f64,
}
