//! Blocks of a recording, each simulated and held out on its own: trials, or parts of a recording
//! without several.

use std::ops::Range;

use crate::data::Recording;
use crate::effects::Starts;

/// Parts into which a recording of one trial is divided.
const STRETCHES: usize = 8;
/// Fewest rows of such a part.
const MIN_ROWS: usize = 8;
/// Commands before a block that are played first, so that the robot arrives in motion and with its
/// history: seconds, and rows of a recording of poses at rest.
const LEAD_IN_S: f64 = 5.0;
const LEAD_IN_ROWS: usize = 10;
/// Time for which the last command before a trial is held, seconds.
const HELD_S: f64 = 5.0;

/// How the rows of a recording follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Playing {
    /// State at the start of a trial.
    pub(crate) starts: Starts,
    /// Every row is a pose at rest under its own command.
    pub(crate) at_rest: bool,
}

/// Rows that are simulated in one piece.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    /// Number of the trial, or of the part where trials are divided.
    pub(crate) number: u64,
    /// First row whose command is played: before `rows` where the block goes on from what was
    /// before.
    pub(crate) lead_in: usize,
    /// Rows that are compared.
    pub(crate) rows: Range<usize>,
    /// State at the start of the first command.
    pub(crate) starts: Starts,
}

/// What the blocks of a recording are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockKind {
    Trial,
    Pattern,
    Stretch,
}

/// The kind of the blocks of `measured`.
pub(crate) fn kind(measured: &Recording, playing: Playing) -> BlockKind {
    let trials = measured.trials();
    let labels = measured.pattern.as_deref().unwrap_or_default();
    if playing.at_rest && labels.windows(2).any(|two| two[0] != two[1]) {
        BlockKind::Pattern
    } else if trials.len() == 1 && measured.len() >= STRETCHES * MIN_ROWS {
        BlockKind::Stretch
    } else {
        BlockKind::Trial
    }
}

/// The blocks of `measured`: with poses at rest the runs of one `pattern` where there are several,
/// else the trials; a single trial is divided evenly.
pub(crate) fn blocks(measured: &Recording, playing: Playing) -> Vec<Block> {
    let trials = measured.trials();
    let labels = measured.pattern.as_deref().unwrap_or_default();
    let numbered =
        |ranges: Vec<Range<usize>>| (0..).zip(ranges).collect::<Vec<(u64, Range<usize>)>>();
    let (parts, goes_on) = match kind(measured, playing) {
        BlockKind::Pattern => {
            let of_trial = |(_, rows): &(u64, Range<usize>)| runs(labels, rows.clone());
            (numbered(trials.iter().flat_map(of_trial).collect()), true)
        }
        BlockKind::Stretch => {
            let bound = |part: usize| part * measured.len() / STRETCHES;
            (numbered((0..STRETCHES).map(|part| bound(part)..bound(part + 1)).collect()), true)
        }
        BlockKind::Trial => (trials, playing.starts == Starts::Continue),
    };
    let block = |(number, rows): (u64, Range<usize>)| {
        let lead_in = if goes_on { lead_in(measured, rows.start, playing) } else { rows.start };
        let starts =
            // With commands before it a block starts in motion, from a rest under the first of
            // them.
            if lead_in < rows.start || playing.starts == Starts::Anywhere { Starts::Anywhere } else { Starts::Home };
        Block { number, lead_in, rows, starts }
    };
    parts.into_iter().map(block).collect()
}

/// What a reader of the answer must know of how `measured` was played, as sentences.
pub(crate) fn caveats(measured: &Recording, playing: Playing) -> Vec<String> {
    let parts = match kind(measured, playing) {
        BlockKind::Trial => None,
        BlockKind::Pattern => Some("runs of one pattern".to_owned()),
        BlockKind::Stretch => Some(format!("{STRETCHES} stretches of time")),
    };
    let divided = parts.map(|parts| {
        let before = if playing.at_rest {
            format!("{LEAD_IN_ROWS} poses")
        } else {
            format!("{LEAD_IN_S} seconds")
        };
        format!(
            "The recording was divided into {parts}, which are used as trials; each is simulated \
             from {before} before its start, so earlier motion has no influence."
        )
    });
    let at_rest = playing.at_rest.then(|| {
        "Every row was treated as a pose at rest under its own command: effects that appear only \
         in motion were not searched."
            .to_owned()
    });
    at_rest.into_iter().chain(divided).collect()
}

/// Runs of equal labels among `rows`.
fn runs(labels: &[String], rows: Range<usize>) -> Vec<Range<usize>> {
    let mut start = rows.start;
    let run = |run: &[String]| {
        start += run.len();
        start - run.len()..start
    };
    labels[rows].chunk_by(|a, b| a == b).map(run).collect()
}

/// First row to be played before row `start`: as far back as has influence, under the same weight
/// and gravity.
fn lead_in(measured: &Recording, start: usize, playing: Playing) -> usize {
    let weight = |row: usize| {
        let load_kg = measured.known_load_kg.as_ref().map(|load| load[row]);
        (load_kg, measured.gravity_m_s2.as_ref().map(|gravity| gravity[row]))
    };
    let (mut first, mut before_s) = (start, 0.0);
    // One simulation has one weight and one gravity.
    while first > 0 && weight(first - 1) == weight(start) {
        let is_far =
            if playing.at_rest { start - first >= LEAD_IN_ROWS } else { before_s >= LEAD_IN_S };
        let is_cut = playing.starts != Starts::Continue
            && measured.trial[first - 1] != measured.trial[start];
        if is_far || is_cut {
            break;
        }
        first -= 1;
        before_s += duration_s(measured, first);
    }
    first
}

/// Time for which the command of `row` acts before that of the next row, seconds.
pub(crate) fn duration_s(measured: &Recording, row: usize) -> f64 {
    if measured.trial[row] == measured.trial[row + 1] {
        measured.time_s[row + 1] - measured.time_s[row]
    } else {
        HELD_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Actuation;

    /// A recording of trials with these numbers of rows, 0.5 s apart.
    fn recorded(trials: &[usize]) -> Recording {
        let mut recording = Recording::new(Actuation::Lengths, 1);
        for (trial, rows) in trials.iter().enumerate() {
            for row in 0..*rows {
                recording.trial.push(trial as u64);
                recording.time_s.push(0.5 * row as f64);
                recording.commands.push(&[0.0]);
            }
        }
        recording
    }

    fn told(
        recording: &Recording,
        starts: Starts,
        at_rest: bool,
    ) -> Vec<(u64, usize, Range<usize>, Starts)> {
        let each = blocks(recording, Playing { starts, at_rest });
        each.into_iter()
            .map(|block| (block.number, block.lead_in, block.rows, block.starts))
            .collect()
    }

    #[test]
    fn trials_stand_alone_unless_they_continue() {
        let recording = recorded(&[20, 20]);
        let home = [(0, 0, 0..20, Starts::Home), (1, 20, 20..40, Starts::Home)];
        assert_eq!(told(&recording, Starts::Home, false), home);
        // The last command of the trial before is held for as long as a lead-in is.
        let continued = [(0, 0, 0..20, Starts::Home), (1, 19, 20..40, Starts::Anywhere)];
        assert_eq!(told(&recording, Starts::Continue, false), continued);
    }

    #[test]
    fn a_single_trial_is_divided_and_every_part_arrives_in_motion() {
        let parts = told(&recorded(&[80]), Starts::Home, false);
        assert_eq!(parts.len(), STRETCHES);
        assert_eq!(parts[0], (0, 0, 0..10, Starts::Home));
        assert_eq!(parts[3], (3, 20, 30..40, Starts::Anywhere));
        assert_eq!(told(&recorded(&[40]), Starts::Home, false).len(), 1, "too short to divide");
    }

    #[test]
    fn poses_at_rest_are_parted_by_pattern() {
        let mut recording = recorded(&[30]);
        recording.pattern =
            Some((0..30).map(|row| ["pull", "circle"][row / 20].to_owned()).collect());
        let parts = told(&recording, Starts::Anywhere, true);
        assert_eq!(parts, [(0, 0, 0..20, Starts::Anywhere), (1, 10, 20..30, Starts::Anywhere)]);
    }
}
