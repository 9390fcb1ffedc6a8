//! Some rows of a recording.

use super::{DriveTrack, Extra, PointTrack, Recording};
use crate::base::Rows;

impl Recording {
    /// These rows, in this order.
    pub fn rows(&self, rows: &[usize]) -> Recording {
        let mut commands = Rows::new(self.tendons());
        rows.iter().for_each(|&row| commands.push(self.commands.row(row)));
        let extra = |cells: &Extra| match cells {
            Extra::Integers(cells) => Extra::Integers(picked(cells, rows)),
            Extra::Numbers(cells) => Extra::Numbers(picked(cells, rows)),
            Extra::Text(cells) => Extra::Text(picked(cells, rows)),
        };
        let point = |track: &PointTrack| PointTrack {
            name: track.name.clone(),
            position_m: picked(&track.position_m, rows),
            quaternion: track.quaternion.as_ref().map(|all| picked(all, rows)),
        };
        let drive = |drive: &DriveTrack| DriveTrack {
            displacement: picked(&drive.displacement, rows),
            ..drive.clone()
        };
        Recording {
            actuation: self.actuation,
            trial: picked(&self.trial, rows),
            time_s: picked(&self.time_s, rows),
            commands,
            drives: self.drives.iter().map(drive).collect(),
            tip_m: self.tip_m.as_ref().map(|all| picked(all, rows)),
            tip_quaternion: self.tip_quaternion.as_ref().map(|all| picked(all, rows)),
            base: self.base.as_ref().map(|all| picked(all, rows)),
            known_load_kg: self.known_load_kg.as_ref().map(|all| picked(all, rows)),
            valid: self.valid.as_ref().map(|all| picked(all, rows)),
            at_rest: self.at_rest.as_ref().map(|all| picked(all, rows)),
            tip_load: self.tip_load.as_ref().map(|all| picked(all, rows)),
            gravity_m_s2: self.gravity_m_s2.as_ref().map(|all| picked(all, rows)),
            points: self.points.iter().map(point).collect(),
            pattern: self.pattern.as_ref().map(|all| picked(all, rows)),
            extra: self.extra.iter().map(|(name, cells)| (name.clone(), extra(cells))).collect(),
        }
    }
}

fn picked<T: Clone>(all: &[T], rows: &[usize]) -> Vec<T> {
    rows.iter().map(|&row| all[row].clone()).collect()
}
