//! Positions of the drives during a command, with the effects on them.

use crate::base::TendonCommand;
use crate::effects::Effect;
use crate::rod::Drive;

/// State of the drives of one rod.
#[derive(Clone, Debug)]
pub(crate) struct DriveState {
    /// Duration of the motion to a new command, s.
    pub(crate) drive_time_s: f64,
    /// Commanded displacements, metres, …
    pub(crate) commanded_m: Vec<f64>,
    /// … and actual ones, with the effects applied.
    pub(crate) actual_m: Vec<f64>,
}

impl DriveState {
    /// Drives of `tendons` tendons, at home.
    pub(crate) fn new(drive_time_s: f64, tendons: usize) -> DriveState {
        let home = vec![0.0; tendons];
        DriveState { drive_time_s, commanded_m: home.clone(), actual_m: home }
    }

    /// The motion to `target_m` and the hold after it, `duration_s` in all, as parts of constant
    /// drive speed with the effects applied.
    pub(crate) fn move_to(
        &mut self,
        effects: &mut [Box<dyn Effect>],
        target_m: Vec<f64>,
        duration_s: f64,
    ) -> DrivePath {
        let ramp_s = self.drive_time_s.min(duration_s);
        // Positions with a lag are curves: one part a ramp. Others are straight on ramp and hold.
        let has_lag = effects.iter().any(|effect| effect.has_lag());
        let count = if has_lag { (duration_s / ramp_s - 1e-9).ceil() } else { 1.0 };
        let parts = if has_lag {
            vec![duration_s / count; count as usize]
        } else {
            vec![ramp_s, duration_s - ramp_s]
        };
        let from_m = std::mem::replace(&mut self.commanded_m, target_m);
        let mut path = DrivePath { ends_s: Vec::new(), positions_m: vec![self.actual_m.clone()] };
        let mut now_s = 0.0;
        for part_s in parts {
            now_s += part_s;
            path.ends_s.push(now_s);
            if part_s > 1e-9 * duration_s {
                let commanded_m = between(&from_m, &self.commanded_m, (now_s / ramp_s).min(1.0));
                self.actual_m = apply_effects(effects, commanded_m, part_s);
            }
            path.positions_m.push(self.actual_m.clone());
        }
        path
    }
}

/// Drive positions during one command, piecewise linear in time.
pub(crate) struct DrivePath {
    pub(crate) ends_s: Vec<f64>,
    /// Positions at the start and at each of these times, metres.
    positions_m: Vec<Vec<f64>>,
}

impl DrivePath {
    /// The drives at `time_s` after the command.
    pub(crate) fn drives(&self, commands: &[TendonCommand], time_s: f64) -> Vec<Drive> {
        let last = self.ends_s.len() - 1;
        let part = self.ends_s.iter().position(|end| time_s < end * (1.0 - 1e-12)).unwrap_or(last);
        let start_s = if part == 0 { 0.0 } else { self.ends_s[part - 1] };
        let length_s = self.ends_s[part] - start_s;
        let share =
            if length_s > 0.0 { ((time_s - start_s) / length_s).clamp(0.0, 1.0) } else { 1.0 };
        drives(commands, &self.positions_m[part], &self.positions_m[part + 1], share)
    }
}

/// Actual drive positions, metres, after a motion to `pulls_m` that took `dt_s` seconds. An
/// infinite `dt_s` means rest.
pub(crate) fn apply_effects(
    effects: &mut [Box<dyn Effect>],
    mut pulls_m: Vec<f64>,
    dt_s: f64,
) -> Vec<f64> {
    effects.iter_mut().for_each(|effect| effect.modify_command(&mut pulls_m, dt_s));
    pulls_m
}

fn between(from_m: &[f64], to_m: &[f64], share: f64) -> Vec<f64> {
    from_m.iter().zip(to_m).map(|(from, to)| from + share * (to - from)).collect()
}

/// Drives at `share` of the way between two displacements, or following.
pub(crate) fn drives(
    commands: &[TendonCommand],
    from_m: &[f64],
    to_m: &[f64],
    share: f64,
) -> Vec<Drive> {
    let drive = |(command, pull): (&TendonCommand, f64)| match command {
        TendonCommand::Pull(_) => Drive::Pull(pull),
        TendonCommand::Follow => Drive::Follow,
    };
    commands.iter().zip(between(from_m, to_m, share)).map(drive).collect()
}
