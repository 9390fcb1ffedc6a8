//! What a map says: which columns of other people's files hold what, in which units, along which
//! axes and on which clock.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::cell_match::CellMatch;
use super::columns::ColumnName;
use super::units::{AngleUnit, CommandUnit, LengthUnit, MassUnit, TimeUnit};
use crate::data::import::Axes;

/// A map from the columns of a logger's files, or from the topics of a bag, to a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportMap {
    /// How the text files are written.
    #[serde(default)]
    pub text: TextFormat,
    /// Names of files that hold one trial each.
    pub trial_files: Option<TrialFilesMap>,
    /// Commands: one row of the recording for each of their rows.
    pub commands: CommandsMap,
    /// Tracking; without it the recording holds commands alone.
    pub tracking: Option<TrackingMap>,
}

/// Names of files that hold one trial each. `{trial}` stands for the trial's number or name, `*`
/// for any characters and `?` for one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrialFilesMap {
    /// Names of the files of commands, such as `run_{trial}.csv`.
    pub commands: String,
    /// Names of the files of tracking, where they are others.
    pub tracking: Option<String>,
}

/// How a text file is written. A byte-order mark is passed over.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TextFormat {
    /// What stands between cells: one character; a space stands for any number of spaces and tabs.
    pub delimiter: String,
    /// Decimal sign: `.` or `,`.
    pub decimal: String,
    /// Lines that begin so are comments.
    pub comment: Option<String>,
    /// The table begins after the line whose first cell is this, and ends at an empty line; by
    /// default the whole file is the table.
    pub block: Option<String>,
    /// Lines before the header that are passed over.
    pub skip_lines: usize,
    /// Whether the first line holds the names of the columns; without, columns are named by their
    /// numbers.
    pub header: bool,
    /// Lines of the header. The names of a column in them are joined by a space; a name in an upper
    /// line is that of the empty cells to its right, too: `tip` above `TX` is `tip TX`.
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

/// Where the commands are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CommandsMap {
    /// Which of the files on the command line, counted from 1.
    #[serde(default = "first")]
    pub file: usize,
    /// Topic of a bag.
    pub topic: Option<String>,
    /// How this file is written, in place of the map's `text`.
    pub text: Option<TextFormat>,
    /// The rows of a table of several things that hold commands: the cells that they have.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, CellMatch>")]
    pub conditions: RowConditions,
    /// When each row was; by default that of a bag's messages. Rows of a text file without times
    /// are poses at rest.
    pub time: Option<TimeMap>,
    /// What to do with rows at one time.
    #[serde(default)]
    pub repeated: RepeatedStamps,
    /// Column with the number or name of the trial; by default all rows are one trial.
    pub trial: Option<ColumnName>,
    /// A new trial begins after a gap of more than this between rows, s.
    pub trial_gap_s: Option<f64>,
    /// Commands of tendons.
    pub tendons: Option<TendonsMap>,
    /// Commands of drives by the drives' names, in place of those of tendons.
    #[serde(default)]
    pub drives: BTreeMap<String, DriveMap>,
    /// Column of labels by which rows can be held out.
    pub pattern: Option<ColumnName>,
    /// Weight that was hung on the tip on purpose.
    pub known_load: Option<LoadColumn>,
}

fn first() -> usize {
    1
}

/// When each row was: a column of times, a sum of columns, or frames at a rate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TimeMap {
    /// The column of times; with `rate_hz` that of frame numbers.
    pub column: Option<ColumnName>,
    /// Unit of the times.
    pub unit: TimeUnit,
    /// Zone of dates that are written without one, such as `+01:00` or `Z`.
    pub zone: Option<String>,
    /// Columns whose times are added up, in place of `column`: seconds and nanoseconds, or hours,
    /// minutes and seconds, which begin anew at midnight.
    pub sum: Vec<TimePart>,
    /// The rows are frames at this rate, Hz.
    pub rate_hz: Option<FrameRate>,
    /// Number of the frame at time 0; by default that of the first row of the file.
    pub first_frame: Option<i64>,
}

/// A column that holds a part of the time.
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

/// Conditions on the cells of a row: each column holds this text or number.
pub type RowConditions = BTreeMap<ColumnName, CellMatch>;

/// What to do with rows of commands at one time.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum RepeatedStamps {
    /// They are an error.
    #[default]
    Refuse,
    /// The last row counts.
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
    /// One column a tendon, in the order of the model's tendons.
    pub columns: Vec<ColumnName>,
    /// Their unit.
    #[serde(default)]
    pub unit: CommandUnit,
    /// Metres per radian of a drum or per encoder count, for units of angles and counts; for others
    /// a factor. One number, or one a tendon.
    pub scale: Option<Vec<f64>>,
    /// What the numbers mean.
    #[serde(default)]
    pub measure: TendonMeasure,
    /// Which number is home.
    pub zero: Option<ZeroAt>,
    /// The numbers at home, one a tendon, in the column's unit, in place of `zero`.
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
    /// Which number is home.
    #[serde(default)]
    pub zero: ZeroAt,
    /// The number at home, in the column's unit, in place of `zero`.
    pub home: Option<f64>,
}

/// What a tendon's number means.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum TendonMeasure {
    /// Tendon taken out of the robot: more pulls.
    #[default]
    Pulled,
    /// Tendon let out: more releases.
    Released,
    /// Length of tendon that is left in the robot: less pulls. Home is the first row unless `zero`
    /// or `home` says otherwise.
    Length,
}

/// Where home is in a column.
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

/// Where the tracked poses are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackingMap {
    /// Which of the files on the command line, counted from 1; by default the last.
    pub file: Option<usize>,
    /// Topic of a bag, for all bodies that name none.
    pub topic: Option<String>,
    /// How this file is written, in place of the map's `text`.
    pub text: Option<TextFormat>,
    /// When each row was; without it the rows are those of the commands.
    pub time: Option<TimeMap>,
    /// Unit of positions.
    #[serde(default)]
    pub unit: LengthUnit,
    /// The recording's axes (x up, z along the straight robot) in terms of the tracker's, such as
    /// `x=+y,y=-x,z=+z` for a tracker with y up.
    #[serde(default = "same_axes")]
    pub axes: String,
    /// The tracker's axes are left-handed (as those of game engines are).
    #[serde(default)]
    pub left_handed: bool,
    /// Order of the four columns of an orientation.
    #[serde(default)]
    pub quaternion: QuaternionOrder,
    /// What the three `angles` of a body mean; needed where a body has them.
    pub euler: Option<EulerMap>,
    /// The tip.
    pub tip: BodyMap,
    /// The base; without it positions are measured from `origin` along the tracker's axes.
    pub base: Option<BodyMap>,
    /// The base in the tracker's frame, in the unit of positions, where it is not tracked.
    pub origin: Option<[f64; 3]>,
    /// Further points along the body, by their names in the recording.
    #[serde(default)]
    pub points: BTreeMap<String, BodyMap>,
    /// Axes along which the tip is given where the base is tracked.
    #[serde(default)]
    pub frame: FrameChoice,
    /// Column that is 0 where tracking was lost.
    pub valid: Option<ColumnName>,
    /// Number that stands in a position where tracking was lost. Empty cells and NaN always mean
    /// that.
    pub lost_value: Option<f64>,
    /// Interpolate between tracked rows up to this far apart, s.
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
    /// Topic of a bag, where it is not that of `tracking`.
    pub topic: Option<String>,
    /// Name of the child frame, or of the item of a list, in a message that holds several.
    pub child: Option<String>,
    /// The rows of a table of several bodies that hold this one: the cells that they have.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, CellMatch>")]
    pub conditions: RowConditions,
    /// Columns of x, y and z; by default those of the topic's kind of message.
    pub position: Option<[ColumnName; 3]>,
    /// Columns of the unit quaternion; by default those of the topic's kind of message, if it has
    /// any.
    pub orientation: Option<[ColumnName; 4]>,
    /// Columns of three Euler angles in place of a quaternion, in the order of
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

/// Meaning of Euler angles. Nothing is assumed: conventions differ from tracker to tracker.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EulerMap {
    /// Axes of the three rotations, in the order in which they are carried out.
    pub order: EulerOrder,
    /// About which axes they are carried out.
    pub rotation: EulerRotation,
    /// Unit of the angles.
    pub unit: AngleUnit,
}

/// Axes of three rotations that follow one another.
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

/// About which axes the second and third rotation are carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EulerRotation {
    /// About the axes of the body, which the rotations before have turned.
    Intrinsic,
    /// About the axes of the tracker, which stand still.
    Extrinsic,
}

/// Axes along which the tip is given.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum FrameChoice {
    /// Those of the base body: a rotated tracking frame has no influence.
    #[default]
    Base,
    /// Those of the tracking frame, which must be level: a tilted base shows at the tip.
    Tracking,
}

/// How the tracker's clock stands to that of the commands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ClockMap {
    /// They are one clock.
    #[default]
    Same,
    /// Seconds that are added to the tracker's times.
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
    /// Smallest offset, s; by default the one at which the tracking ends when half of the commands
    /// are over.
    pub from_s: Option<f64>,
    /// Largest offset, s; by default the one at which the tracking begins then.
    pub to_s: Option<f64>,
    /// Longest time for which the drive may wait before it moves, s. Motion does not tell it from
    /// an offset; the interval covers it.
    pub dead_time_s: f64,
}
