//! Concatenation of several recordings of one robot.

use std::collections::{BTreeSet, HashSet};
use std::ops::Range;

use super::{Actuation, DriveTrack, PointTrack, Pose, Recording};
use crate::base::Rows;

/// Recordings that cannot be concatenated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found {found}, expected {expected}, as in the recordings before it")]
pub struct RecordingMismatch {
    /// Number of the recording, from 0.
    pub index: usize,
    found: String,
    expected: String,
}

impl Recording {
    /// Concatenates the trials of all `parts`; trials are renumbered from 0 where numbers repeat.
    /// Columns that only some recordings have are filled with their default (tracked, no load, base
    /// or point unseen, no label) or omitted (orientation, unknown columns).
    ///
    /// # Errors
    /// [`RecordingMismatch`] when tendons or kind of command differ, and when only some give the
    /// gravity.
    pub fn joined(parts: &[Recording]) -> Result<Recording, RecordingMismatch> {
        let kind = |part: &Recording| {
            let unit = if part.actuation == Actuation::Lengths { "lengths" } else { "tensions" };
            let columns: Vec<String> = part.drives.iter().map(DriveTrack::column).collect();
            match columns.as_slice() {
                [] => format!("{} tendons driven by {unit}", part.tendons()),
                all => format!("commands of drives ({})", all.join(", ")),
            }
        };
        let Some(first) = parts.first() else { return Ok(Recording::new(Actuation::Lengths, 0)) };
        if let Some(index) = parts.iter().position(|part| kind(part) != kind(first)) {
            return Err(RecordingMismatch {
                index,
                found: kind(&parts[index]),
                expected: kind(first),
            });
        }
        let gravity = |part: &Recording| match part.gravity_m_s2 {
            Some(_) => "columns gravity_x_m_s2…".to_owned(),
            None => "no columns gravity_x_m_s2…".to_owned(),
        };
        if let Some(index) = parts.iter().position(|part| gravity(part) != gravity(first)) {
            return Err(RecordingMismatch {
                index,
                found: gravity(&parts[index]),
                expected: gravity(first),
            });
        }
        if parts.len() == 1 {
            return Ok(first.clone());
        }
        let mut joined = Recording::new(first.actuation, first.tendons());
        joined.trial = trial_numbers(parts);
        joined.time_s = parts.iter().flat_map(|part| part.time_s.iter().copied()).collect();
        let mut commands = Rows::new(first.tendons());
        parts.iter().flat_map(|part| part.commands.iter()).for_each(|row| commands.push(row));
        joined.commands = commands;
        let drive = |(index, drive): (usize, &DriveTrack)| DriveTrack {
            displacement: parts
                .iter()
                .flat_map(|part| part.drives[index].displacement.clone())
                .collect(),
            ..drive.clone()
        };
        joined.drives = first.drives.iter().enumerate().map(drive).collect();
        let measured = parts.iter().all(|part| part.tip_m.is_some() || !part.points.is_empty());
        joined.tip_m = if measured {
            column_of_some(parts, |part| part.tip_m.clone(), [f64::NAN; 3])
        } else {
            column_of_all(parts, |part| part.tip_m.clone())
        };
        joined.tip_quaternion = column_of_all(parts, |part| part.tip_quaternion.clone());
        joined.base = column_of_some(parts, |part| part.base.clone(), UNSEEN);
        joined.valid = column_of_some(parts, |part| part.valid.clone(), true);
        joined.at_rest = column_of_some(parts, |part| part.at_rest.clone(), false);
        joined.known_load_kg = column_of_some(parts, |part| part.known_load_kg.clone(), 0.0);
        joined.tip_load =
            column_of_some(parts, |part| part.tip_load.clone(), super::RecordedWrench::default());
        joined.gravity_m_s2 = column_of_all(parts, |part| part.gravity_m_s2.clone());
        joined.pattern = column_of_some(parts, |part| part.pattern.clone(), String::new());
        joined.points = points_of_all(parts);
        Ok(joined)
    }

    /// Whether this recording contains every trial of `part`: equal commands, times, tips and
    /// points. Lost ones compare as equal.
    pub fn holds(&self, part: &Recording) -> bool {
        let trials: HashSet<Vec<u64>> =
            self.trials().into_iter().map(|(_, range)| self.bits(range)).collect();
        !part.is_empty()
            && part.trials().into_iter().all(|(_, range)| trials.contains(&part.bits(range)))
    }

    /// Numbers of trials that repeat an earlier one to the last digit (impossible on a real robot).
    pub fn copies(&self) -> Vec<u64> {
        let mut earlier = HashSet::new();
        let repeated = self
            .trials()
            .into_iter()
            .filter(|(_, range)| !earlier.insert(self.bits(range.clone())));
        repeated.map(|(number, _)| number).collect()
    }

    /// Bit patterns of times, commands, tips and points of some rows, for comparison; lost ones
    /// compare as equal.
    fn bits(&self, rows: Range<usize>) -> Vec<u64> {
        let row = |row: usize| -> Vec<u64> {
            let tip = self.tip_m.iter().flat_map(|tip| tip[row]);
            let points = self.points.iter().flat_map(|point| point.position_m[row]);
            let values = [self.time_s[row]]
                .into_iter()
                .chain(self.commands.row(row).iter().copied())
                .chain(tip);
            let values = values.chain(points);
            values
                .map(
                    |value| {
                        if value.is_nan() { f64::NAN.to_bits() } else { (value + 0.0).to_bits() }
                    },
                )
                .collect()
        };
        rows.flat_map(row).collect()
    }
}

/// Pose of markers that were not tracked.
const UNSEEN: Pose = Pose { position_m: [f64::NAN; 3], quaternion: [f64::NAN; 4] };

/// Tracked points of all parts, not a number where a part has not seen one.
fn points_of_all(parts: &[Recording]) -> Vec<PointTrack> {
    let names: BTreeSet<&str> =
        parts.iter().flat_map(|part| &part.points).map(|point| point.name.as_str()).collect();
    let point = |name: &str| PointTrack {
        name: name.to_owned(),
        position_m: column_of_some(
            parts,
            |part| Some(part.point(name)?.position_m.clone()),
            [f64::NAN; 3],
        )
        .unwrap_or_default(),
        quaternion: column_of_some(
            parts,
            |part| part.point(name)?.quaternion.clone(),
            [f64::NAN; 4],
        ),
    };
    names.into_iter().map(point).collect()
}

/// Trial numbers of all rows: those of the recordings, or new ones where two trials have the same.
fn trial_numbers(parts: &[Recording]) -> Vec<u64> {
    let trials: Vec<(u64, usize)> = parts
        .iter()
        .flat_map(Recording::trials)
        .map(|(number, rows)| (number, rows.len()))
        .collect();
    let mut numbers: Vec<u64> = trials.iter().map(|(number, _)| *number).collect();
    numbers.sort_unstable();
    let unique = numbers.windows(2).all(|pair| pair[0] != pair[1]);
    let number = |(index, (recorded, rows)): (usize, &(u64, usize))| {
        std::iter::repeat_n(if unique { *recorded } else { index as u64 }, *rows)
    };
    trials.iter().enumerate().flat_map(number).collect()
}

/// A column that all parts have.
fn column_of_all<T>(
    parts: &[Recording],
    column: impl Fn(&Recording) -> Option<Vec<T>>,
) -> Option<Vec<T>> {
    let columns: Option<Vec<Vec<T>>> = parts.iter().map(column).collect();
    columns.map(|columns| columns.into_iter().flatten().collect())
}

/// A column that some parts have.
fn column_of_some<T: Clone>(
    parts: &[Recording],
    column: impl Fn(&Recording) -> Option<Vec<T>>,
    absent: T,
) -> Option<Vec<T>> {
    let columns: Vec<Option<Vec<T>>> = parts.iter().map(&column).collect();
    columns.iter().any(Option::is_some).then(|| {
        let fill = |(column, part): (Option<Vec<T>>, &Recording)| {
            column.unwrap_or_else(|| vec![absent.clone(); part.len()])
        };
        columns.into_iter().zip(parts).flat_map(fill).collect()
    })
}
