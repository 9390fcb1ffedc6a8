//! What imports print about what looks like a mistake in a log.

use spinebench::data::Recording;
use spinebench::data::import::ImportDoubts;
use std::path::Path;

/// The tip follows a command after this at the latest, seconds; later the clocks may be apart.
const MAX_ONSET_S: f64 = 0.08;
/// … and never this much before it, seconds.
const MAX_LEAD_S: f64 = 0.02;

/// What notes call the settings that would mend a mistake.
pub(crate) struct SettingNames {
    /// Prefix of the axes.
    pub(crate) axes: &'static str,
    /// The two bodies.
    pub(crate) bodies: &'static str,
    /// How to shift the clock by a time.
    pub(crate) clock: &'static str,
}

/// Prints a note about rows without tracking.
pub(crate) fn print_lost(lost: usize, all: usize, out: &Path) {
    if lost > 0 {
        eprintln!(
            "note: {lost} of {all} rows were not tracked; they have valid = 0 in {}",
            out.display()
        );
    }
}

/// Prints notes about what looks like a mistake.
pub(crate) fn print_doubts(doubts: &ImportDoubts, recording: &Recording, names: &SettingNames) {
    let SettingNames { axes: key, bodies, clock } = names;
    if doubts.exchanged {
        eprintln!(
            "note: the base body moves and the tip body hardly does; are {bodies} exchanged?"
        );
    }
    if let (Some(home_m), Some(axes)) = (doubts.home_m, doubts.axes) {
        let [x, y, z] = home_m.map(|x| 1e3 * x);
        eprintln!(
            "note: at the start of the trials the tip is at ({x:.0}, {y:.0}, {z:.0}) mm, where no \
             robot that lies along z has it; {key}{axes} would turn it along z, or {bodies} are \
             exchanged"
        );
    }
    if let Some((away_m, row)) = doubts.base_moves {
        let (trial, time_s) = (recording.trial[row], recording.time_s[row]);
        eprintln!(
            "note: the base moves by up to {:.1} mm (trial {trial} at {time_s} s); the robot's \
             model has a base at rest",
            1e3 * away_m
        );
    }
    match doubts.onset_s {
        Some(onset_s) if onset_s < -MAX_LEAD_S => eprintln!(
            "note: the tip begins to move {:.2} s before its commands: the tracker's clock is \
             ahead of the log's by at least that ({clock})",
            -onset_s
        ),
        Some(onset_s) if onset_s > MAX_ONSET_S => eprintln!(
            "note: the tip begins to follow its commands {onset_s:.2} s late: the tracker's clock \
             is behind the log's, or the drive is late"
        ),
        _ => {}
    }
}
