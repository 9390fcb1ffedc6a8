//! Log of the simulators, on standard output and in a file.

use crate::cli::CommandError;
use spinebench::simulators::Simulator;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Time without motion after which the screws stand, s.
const STANDSTILL_S: f64 = 0.05;

/// A log on standard output and, in full detail, in a file with the columns
/// `time_s,what,x_mm,y_mm,z_mm,a_mm` (screw positions).
pub(super) struct SimulatorLog {
    file: Option<(PathBuf, File)>,
    moving: bool,
}

impl SimulatorLog {
    pub(super) fn open(path: Option<&Path>) -> Result<SimulatorLog, CommandError> {
        let failed = |path: &Path, error| {
            CommandError::BadInput(format!("{}: cannot be written: {error}", path.display()))
        };
        let open = |path: &Path| -> Result<(PathBuf, File), CommandError> {
            let mut file = File::create(path).map_err(|error| failed(path, error))?;
            writeln!(file, "time_s,what,x_mm,y_mm,z_mm,a_mm")
                .map_err(|error| failed(path, error))?;
            Ok((path.to_owned(), file))
        };
        Ok(SimulatorLog { file: path.map(open).transpose()?, moving: false })
    }

    /// Records what has happened since the last call.
    pub(super) fn record_changes(
        &mut self,
        now_s: f64,
        simulator: &mut Simulator,
    ) -> Result<(), CommandError> {
        for heard in simulator.controller.take_received() {
            // Standard output shows holds and resets; the file has every move as well.
            let text = match heard.as_str() {
                "!" => Some("held"),
                "~" => Some("resumed"),
                "^X" => Some("reset"),
                "$H" => Some("homing"),
                _ => None,
            };
            if let Some(text) = text {
                println!("{now_s:9.3} s  {text}");
            }
            self.write(now_s, &format!("heard {heard}"), simulator)?;
        }
        let moving = simulator.moved_s() > 0.0 && now_s - simulator.moved_s() < STANDSTILL_S;
        if moving != self.moving {
            self.moving = moving;
            self.write(now_s, if moving { "moves" } else { "stands" }, simulator)?;
        }
        Ok(())
    }

    /// Records a command from standard input.
    pub(super) fn record_command(
        &mut self,
        now_s: f64,
        what: &str,
        simulator: &Simulator,
    ) -> Result<(), CommandError> {
        println!("{now_s:9.3} s  {what}");
        self.write(now_s, &format!("done {what}"), simulator)
    }

    fn write(&mut self, now_s: f64, what: &str, simulator: &Simulator) -> Result<(), CommandError> {
        let Some((path, file)) = &mut self.file else { return Ok(()) };
        let [x_mm, y_mm, z_mm, a_mm] = simulator.controller.position_mm();
        // Received text may contain anything; commas and quotes would break the table.
        let what = what.replace([',', '"'], " ");
        writeln!(file, "{now_s:.3},{what},{x_mm:.4},{y_mm:.4},{z_mm:.4},{a_mm:.4}").map_err(
            |error| CommandError::Failed(format!("{}: cannot be written: {error}", path.display())),
        )
    }
}
