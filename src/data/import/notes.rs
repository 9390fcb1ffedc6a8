//! What imports say about what looks like a mistake in a log.

use super::Imported;

/// The tip follows a command after this at the latest, seconds; later the clocks may be apart.
const MAX_ONSET_S: f64 = 0.08;
/// … and never this much before it, seconds.
const MAX_LEAD_S: f64 = 0.02;

/// What notes call the settings that would mend a mistake.
#[derive(Clone, Copy, Debug)]
pub struct SettingNames {
    /// Prefix of the axes.
    pub axes: &'static str,
    /// The two bodies.
    pub bodies: &'static str,
    /// The position of the base.
    pub base: &'static str,
    /// Where the commands at home are set.
    pub home: &'static str,
    /// How to shift the clock by a time.
    pub clock: &'static str,
    /// How to choose the rows of a body, where they can be chosen.
    pub rows: &'static str,
}

impl Imported {
    /// Sentences about rows without tracking and about what looks like a mistake.
    pub fn notes(&self, names: &SettingNames) -> Vec<String> {
        let rows = self.recording.len();
        let lost = (self.lost > 0)
            .then(|| format!("{} of {rows} rows were not tracked; they have valid = 0", self.lost));
        lost.into_iter().chain(self.doubts(names)).collect()
    }

    fn doubts(&self, names: &SettingNames) -> Vec<String> {
        let SettingNames { axes: key, bodies, base, home, clock, rows } = names;
        let (doubts, recording) = (&self.doubts, &self.recording);
        let mut notes = Vec::new();
        if doubts.exchanged {
            notes.push(format!(
                "the base body moves and the tip body hardly moves; are {bodies} exchanged?"
            ));
        }
        if let (Some(home_m), Some(axes)) = (doubts.home_m, doubts.axes) {
            let [x, y, z] = home_m.map(|x| 1e3 * x);
            notes.push(format!(
                "at the start of the trials the tip is at ({x:.0}, {y:.0}, {z:.0}) mm, which is \
                 impossible for a straight robot along z; {key}{axes} would rotate it to z, or \
                 {bodies} are exchanged, or the position of the base ({base}) is wrong"
            ));
        }
        if let Some([aside_m, moves_m]) = doubts.aside_m {
            notes.push(format!(
                "at the start of the trials the tip is {:.0} mm beside the z axis, and it never \
                 moves by more than {:.0} mm: the position of the base ({base}) may be wrong",
                1e3 * aside_m,
                1e3 * moves_m
            ));
        }
        if let Some((command_m, row, tendon)) = doubts.away_at_start {
            notes.push(format!(
                "trial {} begins with {:.1} mm at tendon {}: commands are 0 at home, where trials \
                 start unless the model has other `tracking.starts`; see {home}",
                recording.trial[row],
                1e3 * command_m,
                tendon + 1
            ));
        }
        if let Some((away_m, row)) = doubts.base_moves {
            let (trial, time_s) = (recording.trial[row], recording.time_s[row]);
            notes.push(format!(
                "the base moves by up to {:.1} mm (trial {trial} at {time_s} s); the model assumes \
                 a fixed base",
                1e3 * away_m
            ));
        }
        if let Some(jumps_m) = doubts.jumps_m {
            notes.push(format!(
                "the tip repeatedly jumps by {:.0} mm or more between rows and returns, as if the \
                 rows of several bodies were read as one{rows}",
                1e3 * jumps_m
            ));
        }
        match doubts.onset_s {
            Some(onset_s) if onset_s < -MAX_LEAD_S => notes.push(format!(
                "the tip begins to move {:.2} s before its commands: the tracker's clock is ahead \
                 of the log's by at least this time ({clock})",
                -onset_s
            )),
            Some(onset_s) if onset_s > MAX_ONSET_S => notes.push(format!(
                "the tip begins to follow its commands {onset_s:.2} s late: the tracker's clock is \
                 behind the log's, or the drive has a delay"
            )),
            _ => {}
        }
        notes
    }
}
