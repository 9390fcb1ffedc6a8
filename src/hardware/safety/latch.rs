//! The latch: a stop is stored in a file and outlives the program, until a person has inspected the
//! robot.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::guard::StopReason;

/// Latch and log of one robot, and whether its position is trusted.
#[derive(Clone, Debug)]
pub struct Latch {
    stop_file: PathBuf,
    rehome_file: PathBuf,
    log: PathBuf,
}

impl Latch {
    /// Latch and log of the robot `name` in `folder`, which is created with the first line.
    pub fn new(folder: &Path, name: &str) -> Latch {
        let file = |ending: &str| folder.join(format!("{name}.{ending}"));
        Latch { stop_file: file("stopped"), rehome_file: file("rehome"), log: file("log") }
    }

    /// Folder for the state of this user's programs (`XDG_STATE_HOME`, or `.local/state` in the
    /// home folder).
    pub fn folder() -> PathBuf {
        let state_home = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
        let home = || {
            std::env::var_os("HOME")
                .map_or_else(std::env::temp_dir, |home| Path::new(&home).join(".local/state"))
        };
        state_home.filter(|path| path.is_absolute()).unwrap_or_else(home).join("spinebench")
    }

    /// Why the robot is stopped, if it is. A latch that cannot be read counts as a stop.
    pub fn read(&self) -> Option<String> {
        read(&self.stop_file)
    }

    /// Why homing is required whatever the controller reports; none if it is not. A file that
    /// cannot be read counts as present.
    pub fn homing_required(&self) -> Option<String> {
        read(&self.rehome_file)
    }

    /// Requires homing before the next motion, also of later programs.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn require_homing(&self, why: &str) -> io::Result<()> {
        self.write_file(&self.rehome_file, why)
    }

    /// Notes that the axes have been homed.
    ///
    /// # Errors
    /// When the file cannot be removed.
    pub fn clear_homing_required(&self) -> io::Result<()> {
        match fs::remove_file(&self.rehome_file) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    fn write_file(&self, file: &Path, line: &str) -> io::Result<()> {
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(file, format!("{line}\n"))
    }

    /// Stops the robot for this and all later programs, requires homing, and logs it: any fault may
    /// have cost steps.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn stop(&self, reason: &StopReason) -> io::Result<()> {
        let line = format!("{} UTC: {} [{}]", utc(SystemTime::now()), reason.what, reason.kind);
        // The latch first: the log is informative only, and its disk may be full.
        let (latched, homing_required) =
            (self.write_file(&self.stop_file, &line), self.require_homing(&line));
        // Both files are tried before either error is returned.
        latched.and(homing_required)?;
        self.write(&format!("stopped: {line}; {}", reason.remedy))
    }

    /// Arms the robot again and logs it; returns the reason of the stop. Homing remains required.
    ///
    /// # Errors
    /// When the file cannot be removed.
    pub fn release(&self) -> io::Result<Option<String>> {
        let Some(reason) = self.read() else { return Ok(None) };
        fs::remove_file(&self.stop_file)?;
        self.write(&format!("armed by the operator: {} UTC", utc(SystemTime::now())))?;
        Ok(Some(reason))
    }

    /// Adds a line to the log.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, line: &str) -> io::Result<()> {
        if let Some(folder) = self.log.parent() {
            fs::create_dir_all(folder)?;
        }
        writeln!(fs::OpenOptions::new().create(true).append(true).open(&self.log)?, "{line}")
    }

    /// Path of the log.
    pub fn log(&self) -> &Path {
        &self.log
    }
}

fn read(file: &Path) -> Option<String> {
    match fs::read_to_string(file) {
        Ok(text) => Some(text.trim().to_owned()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => Some(format!("{}: {error}", file.display())),
    }
}

/// Date and time of day (Howard Hinnant's civil-from-days algorithm).
fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    // Days since 1 March of year 0, so that the leap day ends a year.
    let (days, second_of_day) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let era = days / 146_097;
    let day_of_era = days % 146_097;
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!(
        "{year:04}-{month:02}-{day:02} {:02}:{:02}:{:02}",
        second_of_day / 3600,
        second_of_day / 60 % 60,
        second_of_day % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_latch_that_cannot_be_read_holds() {
        let folder = tempfile::tempdir().unwrap();
        let latch = Latch::new(folder.path(), "robot");
        assert_eq!(latch.read(), None);
        std::fs::write(folder.path().join("robot.stopped"), [0xff, 0xfe]).unwrap();
        assert!(latch.read().is_some());
    }

    #[test]
    fn arming_does_not_bring_the_position_back() {
        let folder = tempfile::tempdir().unwrap();
        let latch = Latch::new(folder.path(), "robot");
        let reason = StopReason {
            kind: "tip",
            what: "somewhere else".to_owned(),
            remedy: "look".to_owned(),
        };
        latch.stop(&reason).unwrap();
        assert!(latch.release().unwrap().is_some() && latch.read().is_none());
        assert!(latch.homing_required().is_some_and(|why| why.contains("somewhere else")));
        latch.clear_homing_required().unwrap();
        latch.clear_homing_required().unwrap();
        assert_eq!(latch.homing_required(), None);
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        let at = |seconds: u64| utc(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970-01-01 00:00:00");
        assert_eq!(at(951_827_696), "2000-02-29 12:34:56");
        assert_eq!(at(4_107_542_399), "2100-02-28 23:59:59");
    }
}
