//! Recordings whose tips were measured at other times than their rows say.

use super::{PointTrack, Recording};
use crate::base::Rows;

/// Times closer than this are the same, seconds.
const SAME_TIME_S: f64 = 1e-9;

/// A row of the shifted recording.
struct ShiftedRow {
    time_s: f64,
    /// Row whose command is in force.
    command: usize,
    /// Row whose tip was measured now.
    tip: Option<usize>,
}

impl Recording {
    /// The recording with every tip `offset_s` later than its row says, and every command where it
    /// was. Commands keep a row of their own, without a tip where none was measured; a tip from
    /// before the trial is dropped. Tips, points, base poses, loads and `valid` are kept, other
    /// columns are not.
    #[must_use]
    pub fn with_tips_later(&self, offset_s: f64) -> Recording {
        let mut shifted = Recording::new(self.actuation, self.tendons());
        let mut rows = Vec::new();
        for (number, range) in self.trials() {
            let trial_rows = shifted_rows(&self.time_s[range.clone()], offset_s);
            shifted.trial.extend(std::iter::repeat_n(number, trial_rows.len()));
            rows.extend(trial_rows.into_iter().map(|row| ShiftedRow {
                command: range.start + row.command,
                tip: row.tip.map(|tip| range.start + tip),
                ..row
            }));
        }
        shifted.time_s = rows.iter().map(|row| row.time_s).collect();
        let mut commands = Rows::new(self.tendons());
        rows.iter().for_each(|row| commands.push(self.commands.row(row.command)));
        shifted.commands = commands;
        let tip = |row: &ShiftedRow| {
            row.tip.zip(self.tip_m.as_ref()).map_or([f64::NAN; 3], |(tip, tips)| tips[tip])
        };
        shifted.tip_m = Some(rows.iter().map(tip).collect());
        shifted.points = self.points.iter().map(|point| shifted_point(point, &rows)).collect();
        shifted.valid =
            Some(rows.iter().map(|row| row.tip.is_some_and(|tip| self.is_valid(tip))).collect());
        shifted.base = self
            .base
            .as_ref()
            .map(|base| rows.iter().map(|row| base[row.tip.unwrap_or(row.command)]).collect());
        shifted.known_load_kg = self
            .known_load_kg
            .as_ref()
            .map(|load| rows.iter().map(|row| load[row.command]).collect());
        shifted.gravity_m_s2 = self
            .gravity_m_s2
            .as_ref()
            .map(|gravity| rows.iter().map(|row| gravity[row.command]).collect());
        shifted.tip_load =
            self.tip_load.as_ref().map(|load| rows.iter().map(|row| load[row.command]).collect());
        shifted
    }
}

/// A tracked point in the rows of the shifted recording, without its orientation.
fn shifted_point(point: &PointTrack, rows: &[ShiftedRow]) -> PointTrack {
    let position = |row: &ShiftedRow| row.tip.map_or([f64::NAN; 3], |tip| point.position_m[tip]);
    PointTrack {
        name: point.name.clone(),
        position_m: rows.iter().map(position).collect(),
        quaternion: None,
    }
}

/// Rows of one trial with commands at `time_s` and tips `offset_s` later.
fn shifted_rows(time_s: &[f64], offset_s: f64) -> Vec<ShiftedRow> {
    let mut rows: Vec<ShiftedRow> = time_s
        .iter()
        .enumerate()
        .map(|(row, &time_s)| ShiftedRow { time_s, command: row, tip: None })
        .collect();
    for (tip, &at_s) in time_s.iter().enumerate() {
        let measured_s = at_s + offset_s;
        if measured_s < -SAME_TIME_S {
            continue;
        }
        // At equal times the tip is measured before the command acts, as in every recording.
        match rows.iter().position(|row| (row.time_s - measured_s).abs() < SAME_TIME_S) {
            Some(same_time) => rows[same_time].tip = Some(tip),
            None => {
                let place = rows.partition_point(|row| row.time_s < measured_s);
                let command = rows[place - 1].command;
                rows.insert(place, ShiftedRow { time_s: measured_s, command, tip: Some(tip) });
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Actuation;

    fn recorded() -> Recording {
        let mut recording = Recording::new(Actuation::Lengths, 1);
        let mut tips_m = Vec::new();
        for (trial, row) in [(4, 0), (4, 1), (4, 2), (7, 0), (7, 1)] {
            recording.trial.push(trial);
            recording.time_s.push(0.2 * f64::from(row));
            recording.commands.push(&[f64::from(row)]);
            tips_m.push([f64::from(row), trial as f64, 0.0]);
        }
        let point =
            PointTrack { name: "mid".to_owned(), position_m: tips_m.clone(), quaternion: None };
        recording.points = vec![point];
        recording.tip_m = Some(tips_m);
        recording
    }

    fn shown(shifted: &Recording) -> Vec<(u64, f64, f64, Option<f64>)> {
        let tip = |row: usize| {
            let tip_m = shifted.is_valid(row).then(|| shifted.tip_m.as_ref().unwrap()[row]);
            let point_m = shifted.points[0].is_seen(row).then(|| shifted.points[0].position_m[row]);
            assert_eq!(point_m, tip_m, "points move with the tip");
            tip_m.map(|tip_m| tip_m[0])
        };
        let row = |row: usize| {
            (
                shifted.trial[row],
                (shifted.time_s[row] * 1e3).round(),
                shifted.commands.row(row)[0],
                tip(row),
            )
        };
        (0..shifted.len()).map(row).collect()
    }

    #[test]
    fn tips_move_and_commands_stay() {
        let between = [
            (4, 0.0, 0.0, None),
            (4, 50.0, 0.0, Some(0.0)),
            (4, 200.0, 1.0, None),
            (4, 250.0, 1.0, Some(1.0)),
            (4, 400.0, 2.0, None),
            (4, 450.0, 2.0, Some(2.0)),
            (7, 0.0, 0.0, None),
            (7, 50.0, 0.0, Some(0.0)),
            (7, 200.0, 1.0, None),
            (7, 250.0, 1.0, Some(1.0)),
        ];
        assert_eq!(shown(&recorded().with_tips_later(0.05)), between);
    }

    #[test]
    fn a_whole_step_needs_one_row_more() {
        let later = shown(&recorded().with_tips_later(0.2));
        assert_eq!(
            later[..4],
            [
                (4, 0.0, 0.0, None),
                (4, 200.0, 1.0, Some(0.0)),
                (4, 400.0, 2.0, Some(1.0)),
                (4, 600.0, 2.0, Some(2.0))
            ]
        );
        let earlier = shown(&recorded().with_tips_later(-0.2));
        assert_eq!(
            earlier[..3],
            [(4, 0.0, 0.0, Some(1.0)), (4, 200.0, 1.0, Some(2.0)), (4, 400.0, 2.0, None)]
        );
    }
}
