//! Reading and checking a recording.

use super::optional::{self, ColumnGroup};
use super::{Actuation, DriveTrack, Extra, Pose, RecordedWrench, Recording};
use super::{columns, drives, points};
use crate::base::Rows;
use crate::data::table::{Cells, Table};
use crate::data::{DataError, RecordingSource};

pub(super) const TIP: [&str; 3] = ["tip_x_m", "tip_y_m", "tip_z_m"];
pub(super) const TIP_Q: [&str; 4] = ["tip_qw", "tip_qx", "tip_qy", "tip_qz"];
pub(super) const BASE: [&str; 3] = ["base_x_m", "base_y_m", "base_z_m"];
pub(super) const BASE_Q: [&str; 4] = ["base_qw", "base_qx", "base_qy", "base_qz"];
pub(super) const FORCE: [&str; 3] = ["tip_force_x_n", "tip_force_y_n", "tip_force_z_n"];
pub(super) const GRAVITY: [&str; 3] = ["gravity_x_m_s2", "gravity_y_m_s2", "gravity_z_m_s2"];
pub(super) const MOMENT: [&str; 3] = ["tip_moment_x_nm", "tip_moment_y_nm", "tip_moment_z_nm"];

/// Tolerance on the start time, for rounding, seconds.
const START_TOLERANCE_S: f64 = 1e-9;

/// What has to be in a file.
pub(super) struct Expected {
    /// The tip or another tracked point.
    pub(super) measured: bool,
    /// What its times are like.
    pub(super) times: Times,
}

/// The times that a file has to have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Times {
    /// 0 at the start of each trial, and increasing within it.
    Increasing,
    /// The same, unless all rows are marked as poses at rest.
    IncreasingUnlessAtRest,
    /// Any.
    Any,
}

/// Reads and checks a file, or columns in memory.
pub(super) fn recording(
    source: RecordingSource,
    expected: &Expected,
) -> Result<Recording, DataError> {
    let table: &Table = &*source.table()?;
    if table.rows == 0 {
        let (found, expected) = ("no rows", "at least one row");
        return Err(DataError::Empty { file: table.file.clone(), found, expected });
    }
    columns::refuse_missing(table, expected)?;
    let trial = trials(table)?;
    let at_rest = optional::flags(table, "at_rest", "1 for a pose at rest, otherwise 0")?;
    let all_at_rest = at_rest.as_ref().is_some_and(|rows| rows.iter().all(|at_rest| *at_rest));
    let in_time = match expected.times {
        Times::Increasing => true,
        Times::IncreasingUnlessAtRest => !all_at_rest,
        Times::Any => false,
    };
    let time_s = times(table, &trial, in_time)?;
    let drives = drives::read(table)?;
    let (actuation, commands) = commands(table, &drives)?;
    let valid = optional::flags(table, "valid", "1, or 0 where tracking was lost")?;
    let points = points::read(table)?;
    // Where tracking was lost, measured cells may be empty; beside other points also where the tip
    // alone was not seen.
    let unseen = (!points.is_empty()).then(|| vec![false; table.rows]);
    let measured = |names: &[&'static str], required| ColumnGroup {
        table,
        names: names.to_vec(),
        required,
        lost: unseen.as_deref().or(valid.as_deref()),
    };
    let applied = |names: &[&'static str]| ColumnGroup {
        table,
        names: names.to_vec(),
        required: false,
        lost: None,
    };

    let tip_m = measured(&TIP, expected.measured && points.is_empty()).read::<3>()?;
    let tip_quaternion = measured(&TIP_Q, false).quaternions()?;
    let base_q = measured(&BASE_Q, table.column(BASE[0]).is_some()).quaternions()?;
    let base_m = measured(&BASE, base_q.is_some()).read::<3>()?;
    let base = base_m.zip(base_q).map(|(positions, turns)| {
        let poses = positions.into_iter().zip(turns);
        poses.map(|(position_m, quaternion)| Pose { position_m, quaternion }).collect()
    });
    let load: Vec<&'static str> = FORCE.into_iter().chain(MOMENT).collect();
    let tip_load = applied(&load).read::<6>()?.map(|rows| rows.into_iter().map(tip_load).collect());
    let known_load_kg = optional::masses(table, "known_load_kg")?;
    let gravity_m_s2 = applied(&GRAVITY).read::<3>()?;
    same_in_trial(table, &trial, gravity_m_s2.as_deref())?;
    let pattern = optional::labels(table, "pattern");
    let extra = extra(table, actuation, commands.width());
    Ok(Recording {
        actuation,
        trial,
        time_s,
        commands,
        drives,
        tip_m,
        tip_quaternion,
        base,
        known_load_kg,
        valid,
        at_rest,
        tip_load,
        gravity_m_s2,
        points,
        pattern,
        extra,
    })
}

/// Refuses a gravity that changes within a trial.
fn same_in_trial(
    table: &Table,
    trial: &[u64],
    gravity_m_s2: Option<&[[f64; 3]]>,
) -> Result<(), DataError> {
    let Some(all) = gravity_m_s2 else { return Ok(()) };
    let changed = |&row: &usize| trial[row] == trial[row - 1] && all[row] != all[row - 1];
    let Some(row) = (1..table.rows).find(changed) else { return Ok(()) };
    let axis = (0..3).find(|&axis| all[row][axis] != all[row - 1][axis]).unwrap_or(0);
    let expected = format!(
        "{}, as in the previous row: gravity is constant within a trial",
        all[row - 1][axis]
    );
    Err(table.cell_error(row, GRAVITY[axis], expected))
}

fn tip_load([fx, fy, fz, mx, my, mz]: [f64; 6]) -> RecordedWrench {
    RecordedWrench { force_n: [fx, fy, fz], moment_nm: [mx, my, mz] }
}

/// A column that must be there.
fn needed<'a>(table: &'a Table, name: &str) -> Result<&'a Cells, DataError> {
    table.column(name).ok_or_else(|| optional::missing(table, name))
}

/// Trial numbers; the rows of a trial must be contiguous.
fn trials(table: &Table) -> Result<Vec<u64>, DataError> {
    let cells = needed(table, "trial")?;
    let mut trials: Vec<u64> = Vec::with_capacity(table.rows);
    let mut earlier = std::collections::BTreeSet::new();
    for row in 0..table.rows {
        let number = whole_number(cells, row);
        let number =
            number.ok_or_else(|| table.cell_error(row, "trial", "a trial number: 0, 1, 2, …"))?;
        if trials.last() != Some(&number) && !earlier.insert(number) {
            return Err(table.cell_error(
                row,
                "trial",
                "a new trial: the rows of a trial must be contiguous",
            ));
        }
        trials.push(number);
    }
    Ok(trials)
}

/// A whole number, also as numpy and pandas write one that they hold as a float: `1.0`.
fn whole_number(cells: &Cells, row: usize) -> Option<u64> {
    let whole = |number: f64| {
        let is_whole = number >= 0.0 && number.fract() == 0.0 && number < 2f64.powi(53);
        is_whole.then_some(number as u64)
    };
    match cells {
        Cells::Integers(cells) => u64::try_from(cells[row]).ok(),
        Cells::Unsigned(cells) => Some(cells[row]),
        Cells::Text(cells) => {
            let text = cells[row].trim();
            text.parse().ok().or_else(|| text.parse().ok().and_then(whole))
        }
        Cells::Numbers(cells) => whole(cells[row]),
        Cells::Flags(_) => None,
    }
}

/// Times: finite and, with `in_time`, 0 at the start of each trial and increasing within it.
fn times(table: &Table, trial: &[u64], in_time: bool) -> Result<Vec<f64>, DataError> {
    const NAME: &str = "time_s";
    let cells = needed(table, NAME)?;
    let mut times: Vec<f64> = Vec::with_capacity(table.rows);
    for row in 0..table.rows {
        let time_s = optional::finite(cells, row)
            .ok_or_else(|| table.cell_error(row, NAME, "seconds, a number"))?;
        let is_first = row == 0 || trial[row] != trial[row - 1];
        if !in_time {
            times.push(time_s);
            continue;
        }
        if is_first && time_s.abs() > START_TOLERANCE_S {
            return Err(table.cell_error(
                row,
                NAME,
                format!("0 at the start of trial {}", trial[row]),
            ));
        }
        if !is_first && time_s <= times[row - 1] {
            let expected = format!(
                "more than {}, the time of the previous row: time increases within a trial",
                times[row - 1]
            );
            return Err(table.cell_error(row, NAME, expected));
        }
        times.push(time_s);
    }
    Ok(times)
}

/// The commands: `tendon_1_m`… or `tendon_1_n`…, without a gap in the numbers; none where there are
/// `drives`.
fn commands(table: &Table, drives: &[DriveTrack]) -> Result<(Actuation, Rows), DataError> {
    let lengths = highest_tendon(table, Actuation::Lengths);
    let tensions = highest_tendon(table, Actuation::Tensions);
    if let (Some(drive), true) = (drives.first(), lengths + tensions > 0) {
        let found = "commands of drives and of tendons".to_owned();
        return Err(table.header_error(&drive.column(), found, "one of the two"));
    }
    let (actuation, tendons) = match (lengths, tensions) {
        (0, 0) if !drives.is_empty() => return Ok((Actuation::Lengths, Rows::new(0))),
        (0, 0) => return Err(optional::missing(table, "tendon_1_m")),
        (tendons, 0) => (Actuation::Lengths, tendons),
        (0, tendons) => (Actuation::Tensions, tendons),
        _ => {
            let found = "commands as lengths and as tensions".to_owned();
            let expected = "one of the two (measured tensions are named tension_1_n…)";
            return Err(table.header_error(
                &Actuation::Tensions.column(tensions - 1),
                found,
                expected,
            ));
        }
    };
    // Stops at the first gap: the file may claim a tendon number of 10¹².
    let (mut names, mut columns) = (Vec::new(), Vec::new());
    for tendon in 0..tendons {
        names.push(actuation.column(tendon));
        columns.push(needed(table, &actuation.column(tendon))?);
    }
    let expected = match actuation {
        Actuation::Lengths => "metres, a number",
        Actuation::Tensions => "newtons, a number",
    };
    let mut rows = Rows::new(tendons);
    let mut values = vec![0.0; tendons];
    for row in 0..table.rows {
        for (tendon, cells) in columns.iter().enumerate() {
            let value = optional::finite(cells, row);
            values[tendon] =
                value.ok_or_else(|| table.cell_error(row, &names[tendon], expected))?;
        }
        rows.push(&values);
    }
    Ok((actuation, rows))
}

/// The highest tendon number among the columns of this kind of command; 0 when there is none.
pub(super) fn highest_tendon(table: &Table, actuation: Actuation) -> usize {
    table.columns.iter().filter_map(|(name, _)| tendon_number(name, actuation)).max().unwrap_or(0)
}

fn tendon_number(name: &str, actuation: Actuation) -> Option<usize> {
    let number = name.strip_prefix("tendon_")?;
    let number: usize = number.rsplit_once('_')?.0.parse().ok()?;
    (number > 0 && actuation.column(number - 1) == name).then_some(number)
}

/// Columns beyond the format.
fn extra(table: &Table, actuation: Actuation, tendons: usize) -> Vec<(String, Extra)> {
    let single = ["trial", "time_s", "known_load_kg", "valid", "at_rest", "pattern"];
    let groups: [&[&str]; 7] = [&TIP, &TIP_Q, &BASE, &BASE_Q, &FORCE, &MOMENT, &GRAVITY];
    let is_of_format = |name: &str| {
        single.contains(&name)
            || groups.iter().any(|group| group.contains(&name))
            || points::name_of(name).is_some()
            || drives::drive_of(name).is_some()
            || tendon_number(name, actuation).is_some_and(|number| number <= tendons)
    };
    let unknown = table.columns.iter().filter(|(name, _)| !is_of_format(name));
    unknown.map(|(name, cells)| (name.clone(), carried(cells))).collect()
}

fn carried(cells: &Cells) -> Extra {
    match cells {
        Cells::Integers(cells) => Extra::Integers(cells.clone()),
        Cells::Unsigned(cells) => Extra::Text(cells.iter().map(u64::to_string).collect()),
        Cells::Numbers(cells) => Extra::Numbers(cells.clone()),
        Cells::Flags(cells) => Extra::Integers(cells.iter().map(|&flag| i64::from(flag)).collect()),
        Cells::Text(cells) => Extra::Text(cells.clone()),
    }
}
