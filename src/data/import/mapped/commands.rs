//! Commands of a table.

use super::columns::LogTable;
use super::map::{CommandsMap, DriveMap, RepeatedStamps, TendonMeasure, TendonsMap, ZeroAt};
use super::time::{self, NS, Stamps};
use super::units::{CommandKind, CommandUnit};
use crate::base::Rows;
use crate::data::recording::{DriveTrack, DriveUnit, Extra};
use crate::data::{Actuation, DataError, Recording};

/// Commands, and when each of their rows was.
pub(crate) struct TimedCommands {
    /// The commands.
    pub(crate) recording: Recording,
    /// Time of each row on its own clock, nanoseconds.
    pub(crate) stamps_ns: Vec<i64>,
    /// Whether the times were dates, and then whether in a known zone.
    pub(crate) is_zoned: Option<bool>,
    /// Rows that a later one at the same time has replaced.
    pub(crate) repeated: usize,
    /// Whether the rows are poses at rest, without times.
    pub(crate) at_rest: bool,
}

/// Column with the name or number of a trial that is told by a name.
pub(crate) const TRIAL_NAME: &str = "trial_name";

/// Time between poses at rest, which have no times.
const AT_REST_STEP_NS: i64 = NS as i64;

/// Reads the commands.
///
/// # Errors
/// [`DataError`] names file, line and column.
pub(crate) fn read(table: &LogTable, map: &CommandsMap) -> Result<TimedCommands, DataError> {
    let chosen = table.rows_where(&map.conditions, "commands.where")?;
    let mut table: &LogTable = &chosen;
    let mut stamps = row_stamps(table, map)?;
    let last_rows;
    let mut repeated = 0;
    if map.repeated == RepeatedStamps::Last {
        let kept = last_of_each_time(table, map, &stamps.ns)?;
        repeated = table.rows.len() - kept.len();
        last_rows = table.select(&kept);
        table = &last_rows;
        stamps = row_stamps(table, map)?;
    }
    let (trial, trial_names) = trials(table, map, &stamps.ns)?;
    let rows = table.rows.len();
    let starts: Vec<usize> = {
        let mut start = 0;
        let begin = |row: usize| {
            if row > 0 && trial[row] != trial[row - 1] {
                start = row;
            }
            start
        };
        (0..rows).map(begin).collect()
    };
    check_order(table, &stamps, &starts)?;
    let Stamps { ns: stamps_ns, is_zoned, .. } = stamps;
    let mut recording = Recording::new(Actuation::Lengths, 0);
    recording.time_s =
        (0..rows).map(|row| (stamps_ns[row] - stamps_ns[starts[row]]) as f64 / NS).collect();
    recording.trial = trial;
    if let Some(tendons) = &map.tendons {
        (recording.actuation, recording.commands) = tendon_rows(table, tendons, &starts)?;
    }
    let drive = |(name, drive): (&String, &DriveMap)| drive_track(table, name, drive, &starts);
    recording.drives = map.drives.iter().map(drive).collect::<Result<_, _>>()?;
    if let Some(name) = &map.pattern {
        let column = table.column(name, "commands.pattern")?;
        recording.pattern =
            Some((0..rows).map(|row| table.text(column, row).into_owned()).collect());
    }
    if let Some(load) = &map.known_load {
        let column = table.column(&load.column, "commands.known_load.column")?;
        let mass = |row| match table.finite(column, row)? {
            mass if mass >= 0.0 => Ok(mass * load.unit.kilograms()),
            _ => Err(table.wrong(column, row, "a mass, 0 or more")),
        };
        recording.known_load_kg = Some((0..rows).map(mass).collect::<Result<_, DataError>>()?);
    }
    if let Some(names) = trial_names {
        recording.extra.push((TRIAL_NAME.to_owned(), Extra::Text(names)));
    }
    let at_rest = has_no_times(table, map);
    recording.at_rest = at_rest.then(|| vec![true; rows]);
    Ok(TimedCommands { recording, stamps_ns, is_zoned, repeated, at_rest })
}

/// Whether the rows are poses at rest.
fn has_no_times(table: &LogTable, map: &CommandsMap) -> bool {
    map.time.is_none() && !table.is_topic()
}

/// Times of the rows; of poses at rest a second apart.
fn row_stamps(table: &LogTable, map: &CommandsMap) -> Result<Stamps, DataError> {
    if has_no_times(table, map) {
        return Ok(Stamps::of_rows(table, AT_REST_STEP_NS));
    }
    time::stamps(table, map.time.as_ref(), "commands.time")
}

/// The rows without those after which another row of their trial has the same time.
fn last_of_each_time(
    table: &LogTable,
    map: &CommandsMap,
    ns: &[i64],
) -> Result<Vec<usize>, DataError> {
    let trial = map.trial.as_ref().map(|name| table.column(name, "commands.trial")).transpose()?;
    let same_trial =
        |row: usize| trial.is_none_or(|trial| table.text(trial, row) == table.text(trial, row + 1));
    let is_last = |row: &usize| row + 1 == ns.len() || ns[*row] != ns[row + 1] || !same_trial(*row);
    Ok((0..ns.len()).filter(is_last).collect())
}

/// Refuses times that do not increase in a trial.
fn check_order(table: &LogTable, stamps: &Stamps, starts: &[usize]) -> Result<(), DataError> {
    for row in (0..starts.len()).filter(|&row| starts[row] != row) {
        let (before_ns, ns) = (stamps.ns[row - 1], stamps.ns[row]);
        if ns == before_ns {
            let expected = format!(
                "a later time than in {} (`commands.repeated: last` in the map keeps the last row \
                 of each time)",
                table.place(row - 1)
            );
            return Err(stamps.wrong(table, row, None, expected));
        }
        if ns < before_ns {
            let expected = "a later time than in the previous row: time increases within a trial";
            return Err(stamps.wrong(table, row, None, expected));
        }
    }
    Ok(())
}

/// Numbers of the trial of each row, and names where the trials have names.
type TrialRows = (Vec<u64>, Option<Vec<String>>);

/// Trial of each row: numbers of the column, or names in the order of the file, or parts between
/// gaps.
fn trials(table: &LogTable, map: &CommandsMap, stamps_ns: &[i64]) -> Result<TrialRows, DataError> {
    let Some(name) = &map.trial else {
        let Some(gap_s) = map.trial_gap_s else { return Ok((vec![0; stamps_ns.len()], None)) };
        let mut trial = 0;
        let follow = |row: usize| {
            let step_ns = if row == 0 { 0 } else { stamps_ns[row] - stamps_ns[row - 1] };
            trial += u64::from(step_ns as f64 > gap_s * NS);
            trial
        };
        return Ok(((0..stamps_ns.len()).map(follow).collect(), None));
    };
    let column = table.column(name, "commands.trial")?;
    let mut labels: Vec<String> = Vec::new();
    for row in 0..table.rows.len() {
        let label = table.text(column, row);
        if labels.last().is_some_and(|last| *last == label) {
            continue;
        }
        if label.is_empty() || labels.iter().any(|earlier| *earlier == label) {
            return Err(table.wrong(
                column,
                row,
                "a new trial: the rows of a trial must be contiguous",
            ));
        }
        labels.push(label.into_owned());
    }
    let label_numbers = trial_numbers(labels.iter().map(String::as_str));
    let names = label_numbers
        .is_none()
        .then(|| (0..table.rows.len()).map(|row| table.text(column, row).into_owned()).collect());
    let numbers = label_numbers.unwrap_or_else(|| (0..labels.len() as u64).collect());
    let number_of_row = |row| {
        let place = labels.iter().position(|label| *label == table.text(column, row));
        place.map_or(0, |place| numbers[place])
    };
    Ok(((0..table.rows.len()).map(number_of_row).collect(), names))
}

/// The numbers that labels of trials are; none where one is a name, or where two are the same
/// number.
pub(crate) fn trial_numbers<'a>(labels: impl Iterator<Item = &'a str>) -> Option<Vec<u64>> {
    let number = |label: &str| -> Option<u64> {
        let number = label.parse::<f64>().ok()?;
        (number >= 0.0 && number.fract() == 0.0 && number < 2f64.powi(53)).then_some(number as u64)
    };
    let numbers: Vec<u64> = labels.map(number).collect::<Option<_>>()?;
    let distinct: std::collections::BTreeSet<&u64> = numbers.iter().collect();
    (distinct.len() == numbers.len()).then_some(numbers)
}

/// Number at home of a column, row by row.
struct Home<'a> {
    zero: ZeroAt,
    /// What the map says, in place of `zero`.
    home_number: Option<f64>,
    starts: &'a [usize],
}

impl Home<'_> {
    fn at(&self, numbers: &[f64], row: usize) -> f64 {
        self.home_number.unwrap_or_else(|| match self.zero {
            ZeroAt::Zero => 0.0,
            ZeroAt::FirstRow => numbers[0],
            ZeroAt::TrialStart => numbers[self.starts[row]],
        })
    }
}

/// The finite numbers of a column in a unit.
fn numbers(table: &LogTable, column: usize, unit: CommandUnit) -> Result<Vec<f64>, DataError> {
    table.check_units(&[column], unit.spellings(), &format!("{} as `unit`", unit.word()))?;
    (0..table.rows.len()).map(|row| table.finite(column, row)).collect()
}

fn tendon_rows(
    table: &LogTable,
    map: &TendonsMap,
    starts: &[usize],
) -> Result<(Actuation, Rows), DataError> {
    let (kind, factor) = map.unit.factor();
    let default_zero =
        if map.measure == TendonMeasure::Length { ZeroAt::FirstRow } else { ZeroAt::Zero };
    let sign = if map.measure == TendonMeasure::Pulled { 1.0 } else { -1.0 };
    let found = table.find_all(&map.columns, "commands.tendons.columns")?;
    let mut columns = Vec::new();
    for (tendon, column) in found.into_iter().enumerate() {
        let numbers = numbers(table, column, map.unit)?;
        let home_number = map.home.as_ref().map(|home| home[tendon]);
        let home = Home { zero: map.zero.unwrap_or(default_zero), home_number, starts };
        let scale = map.scale.as_ref().map_or(1.0, |scale| match scale.values() {
            [one] => *one,
            each => each[tendon],
        });
        // The difference to home is 0 there, and not −0.
        let pulled =
            |row: usize| (numbers[row] - home.at(&numbers, row)) * (sign * factor * scale) + 0.0;
        columns.push((0..numbers.len()).map(pulled).collect::<Vec<f64>>());
    }
    let mut rows = Rows::new(columns.len());
    for row in 0..table.rows.len() {
        rows.push(&columns.iter().map(|column| column[row]).collect::<Vec<f64>>());
    }
    let actuation =
        if kind == CommandKind::Tension { Actuation::Tensions } else { Actuation::Lengths };
    Ok((actuation, rows))
}

fn drive_track(
    table: &LogTable,
    name: &str,
    map: &DriveMap,
    starts: &[usize],
) -> Result<DriveTrack, DataError> {
    let (kind, factor) = map.unit.factor();
    let column = table.column(&map.column, &format!("commands.drives.{name}.column"))?;
    let numbers = numbers(table, column, map.unit)?;
    let home = Home { zero: map.zero, home_number: map.home, starts };
    let scale = factor * map.scale.unwrap_or(1.0);
    let displacement = (0..numbers.len())
        .map(|row| (numbers[row] - home.at(&numbers, row)) * scale + 0.0)
        .collect();
    let unit = if kind == CommandKind::Length { DriveUnit::Metres } else { DriveUnit::Radians };
    Ok(DriveTrack { name: name.to_owned(), unit, displacement })
}
