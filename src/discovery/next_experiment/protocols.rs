//! Protocols that a laboratory can record next, from poses that the recording has shown to be safe.

use crate::base::Rows;

/// A trial of a protocol.
pub(crate) struct ProtocolTrial {
    pub(crate) commands: Rows,
    /// Weight on the tip, kilograms.
    pub(crate) load_kg: f64,
}

/// A protocol.
pub(crate) struct Protocol {
    pub(crate) name: &'static str,
    pub(crate) what: String,
    /// Manual set-up time, minutes.
    pub(crate) setup_min: f64,
    pub(crate) trials: Vec<ProtocolTrial>,
    /// Duration of a command, seconds.
    pub(crate) step_s: f64,
    /// Gravity in the base frame, m/s², if the base is mounted differently.
    pub(crate) gravity_m_s2: Option<[f64; 3]>,
}

/// Range of the recorded commands.
pub(crate) struct CommandRange {
    /// Recorded commands of all trials.
    poses: Vec<Vec<f64>>,
    /// Duration of a command, seconds.
    step_s: f64,
    /// Largest recorded change of one tendon in that time.
    step: f64,
}

/// Commands a trial, and the minimum duration of each, seconds.
const COMMANDS: usize = 50;
const MIN_COMMAND_S: f64 = 0.2;
/// Poses of a path.
const CORNERS: usize = 6;
/// A common laboratory weight.
const WEIGHT_KG: f64 = 0.02;

/// All protocols, four trials each.
pub(crate) fn protocols(range: &CommandRange, gravity_m_s2: [f64; 3]) -> Vec<Protocol> {
    let path = |first: usize| range.path(&range.corners(first), range.step);
    let four = |commands: &dyn Fn(usize) -> Rows| -> Vec<ProtocolTrial> {
        (0..4).map(|k| ProtocolTrial { commands: commands(k), load_kg: 0.0 }).collect()
    };
    let protocol = |name, what: &str, setup_min, trials| {
        let what = what.to_owned();
        Protocol { name, what, setup_min, trials, step_s: range.step_s, gravity_m_s2: None }
    };
    let (mounted, gravity_m_s2) = remounted(gravity_m_s2);
    let load_kg = |k: usize| if k % 2 == 1 { WEIGHT_KG } else { 0.0 };
    let weighed =
        (0..4).map(|k| ProtocolTrial { commands: path(k / 2), load_kg: load_kg(k) }).collect();
    let looped = |k: usize| {
        // Two corners make a loop that fits three times into a trial.
        let corners: Vec<Vec<f64>> = range.corners(k).into_iter().take(2).collect();
        range.path(&[corners.clone(), corners.clone(), corners].concat(), range.step)
    };
    let paced = |k: usize| {
        let corners: Vec<Vec<f64>> = range.corners(k / 2).into_iter().take(2).collect();
        range.path(&corners, if k.is_multiple_of(2) { range.step } else { range.step / 3.0 })
    };
    let stay = format!(
        "Go to four far poses and hold each for {:.0} s in total",
        COMMANDS as f64 * range.step_s
    );
    vec![
        protocol(
            "known_weight",
            "Run four trials, the second and fourth with 20 g on the tip",
            2.0,
            weighed,
        ),
        Protocol {
            gravity_m_s2: Some(gravity_m_s2),
            ..protocol(
                "base_remounted",
                &format!("{mounted} and run four trials"),
                5.0,
                four(&path),
            )
        },
        protocol("dwell", &stay, 0.5, four(&|k| range.dwell(k))),
        protocol(
            "repeated_loop",
            "Run one loop three times in each of four trials",
            0.5,
            four(&looped),
        ),
        protocol(
            "slow_and_fast",
            "Run two paths, each at full speed and at a third of the speed",
            0.5,
            four(&paced),
        ),
        protocol(
            "reversals",
            "Bend out and back three times with growing amplitude, in four directions",
            0.5,
            four(&|k| range.reversals(k)),
        ),
        protocol("far_poses", "Go through the farthest poses in four trials", 0.5, four(&path)),
    ]
}

/// Another mounting of the base, as text, and its gravity in the base frame.
fn remounted([x, y, z]: [f64; 3]) -> (&'static str, [f64; 3]) {
    // A base turned about its own axis would not change gravity along that axis.
    if x.hypot(y) < z.abs() {
        return ("Lay the base on its side, so that gravity pulls along −x,", [-z.abs(), y, x]);
    }
    ("Rotate the base by 90° about its axis", [-y, x, z])
}

impl CommandRange {
    /// Range of the recorded commands; rows are `recorded_s` seconds apart.
    pub(crate) fn new<'a>(trials: impl Iterator<Item = &'a Rows>, recorded_s: f64) -> CommandRange {
        // Commands last as long as a whole number of recorded rows, so that speeds compare.
        let held = (MIN_COMMAND_S / recorded_s).round().max(1.0);
        let mut range = CommandRange { poses: Vec::new(), step_s: held * recorded_s, step: 0.0 };
        for trial in trials {
            let rows: Vec<&[f64]> = trial.iter().collect();
            for pair in rows.windows((held as usize + 1).min(rows.len()).max(1)) {
                range.step = range.step.max(farthest(pair[0], pair[pair.len() - 1]));
            }
            range.poses.extend(rows.into_iter().map(<[f64]>::to_vec));
        }
        if range.step == 0.0 {
            // Each trial holds one command, reached from home in one step.
            let far = range.poses.iter().map(|pose| farthest(pose, &vec![0.0; pose.len()]));
            range.step = far.fold(0.0, f64::max);
        }
        range
    }

    /// Recorded poses far from each other, starting from the `first`-farthest from home
    /// (farthest-point sampling).
    fn corners(&self, first: usize) -> Vec<Vec<f64>> {
        let home = vec![0.0; self.poses.first().map_or(0, Vec::len)];
        let mut chosen: Vec<Vec<f64>> = vec![home];
        for _ in 0..first + CORNERS {
            let nearest = |pose: &Vec<f64>| {
                chosen.iter().map(|other| farthest(pose, other)).fold(f64::INFINITY, f64::min)
            };
            match self.poses.iter().max_by(|a, b| nearest(a).total_cmp(&nearest(b))) {
                Some(pose) => chosen.push(pose.clone()),
                None => break,
            }
        }
        chosen.split_off((1 + first).min(chosen.len()))
    }

    /// From home through `corners` in steps of at most `step`, then constant.
    fn path(&self, corners: &[Vec<f64>], step: f64) -> Rows {
        let width = corners.first().map_or(0, Vec::len);
        let mut at = vec![0.0; width];
        let mut rows = Rows::new(width);
        for corner in corners {
            // No faster than the recording has shown to be safe.
            let steps = (farthest(&at, corner) / step.max(1e-9)).ceil().max(1.0) as usize;
            let from = at.clone();
            for k in 1..=steps {
                let share = k as f64 / steps as f64;
                at = from.iter().zip(corner).map(|(a, b)| a + share * (b - a)).collect();
                rows.push(&at);
                if rows.len() == COMMANDS {
                    return rows;
                }
            }
        }
        while rows.len() < COMMANDS {
            rows.push(&at);
        }
        rows
    }

    fn dwell(&self, k: usize) -> Rows {
        self.path(&self.corners(k).into_iter().take(1).collect::<Vec<_>>(), self.step)
    }

    fn reversals(&self, k: usize) -> Rows {
        let far = self.corners(k).into_iter().next().unwrap_or_default();
        let scaled = |share: f64| -> Vec<f64> { far.iter().map(|x| share * x).collect() };
        // Growing reversals separate backlash, of fixed width, from hysteresis.
        let turns = [1.0 / 3.0, 0.0, 2.0 / 3.0, 0.0, 1.0, 0.0];
        self.path(&turns.map(scaled), self.step)
    }
}

/// Largest difference of any tendon.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACROSS: [f64; 3] = [-9.81, 0.0, 0.0];

    #[test]
    fn another_mount_turns_gravity_to_where_it_did_not_pull() {
        for gravity in [ACROSS, [0.0, 0.0, -9.81], [0.0, 0.0, 9.81], [3.0, -6.0, 2.0]] {
            let (mounted, there) = remounted(gravity);
            let size = |g: [f64; 3]| g.map(|x| x * x).iter().sum::<f64>().sqrt();
            assert!((size(gravity) - size(there)).abs() < 1e-12);
            let across = |k: usize| gravity[k] * there[k];
            assert!((across(0) + across(1)).abs() < 1e-12, "{mounted}: {there:?}");
            assert!(
                size([gravity[0] - there[0], gravity[1] - there[1], gravity[2] - there[2]])
                    > 0.9 * size(gravity)
            );
        }
    }

    /// Two recorded trials of four tendons, two of which pull at a time.
    fn recorded() -> Vec<Rows> {
        let trial = |phase: f64| {
            let mut rows = Rows::new(4);
            for k in 0..40 {
                let angle = 0.3 * f64::from(k) + phase;
                let (x, y) = (8e-3 * angle.cos(), 8e-3 * (0.6 * angle).sin());
                rows.push(&[x.max(0.0), y.max(0.0), (-x).max(0.0), (-y).max(0.0)]);
            }
            rows
        };
        vec![trial(0.0), trial(1.0)]
    }

    #[test]
    fn commands_go_no_farther_and_no_faster_than_what_was_recorded() {
        let trials = recorded();
        let range = CommandRange::new(trials.iter(), 0.2);
        let most = trials.iter().flat_map(Rows::iter).flatten().copied().fold(0.0, f64::max);
        let all = protocols(&range, ACROSS);
        assert_eq!(all.len(), 7);
        for protocol in &all {
            assert_eq!(protocol.trials.len(), 4, "{}", protocol.name);
            for rows in protocol.trials.iter().map(|trial| &trial.commands) {
                assert_eq!(rows.len(), COMMANDS, "{}", protocol.name);
                let mut at = vec![0.0; 4];
                for row in rows.iter() {
                    assert!(
                        farthest(&at, row) < range.step + 1e-12,
                        "{}: {at:?} to {row:?}",
                        protocol.name
                    );
                    assert!(
                        row.iter().all(|x| (0.0..=most).contains(x)),
                        "{}: {row:?}",
                        protocol.name
                    );
                    at = row.to_vec();
                }
            }
            let weights: Vec<f64> = protocol.trials.iter().map(|trial| trial.load_kg).collect();
            let weighed = if protocol.name == "known_weight" { WEIGHT_KG } else { 0.0 };
            assert_eq!(weights, [0.0, weighed, 0.0, weighed], "{}", protocol.name);
            assert_eq!(protocol.gravity_m_s2.is_some(), protocol.name == "base_remounted");
        }
    }

    /// Weights hung on the tendons one after the other: each trial holds one command.
    #[test]
    fn a_command_held_from_the_start_is_a_step_from_home() {
        let trial = |pull_n: f64| {
            let mut rows = Rows::new(4);
            (0..40).for_each(|_| rows.push(&[pull_n, 0.0, 0.0, 0.0]));
            rows
        };
        let trials = [trial(5.0), trial(2.0)];
        let range = CommandRange::new(trials.iter(), 0.2);
        assert_eq!(range.step, 5.0);
        for protocol in protocols(&range, ACROSS) {
            assert!(
                protocol.trials.iter().all(|trial| trial.commands.len() == COMMANDS),
                "{}",
                protocol.name
            );
            let most = protocol
                .trials
                .iter()
                .flat_map(|trial| trial.commands.iter())
                .map(|row| row[0])
                .fold(0.0, f64::max);
            assert!((2.0..=5.0).contains(&most), "{}: {most}", protocol.name);
        }
    }

    /// Commands streamed at the rate of the tracker are not proposed at that rate.
    #[test]
    fn what_was_recorded_fast_is_not_played_fast() {
        let (slow, mut fast) = (recorded(), Vec::new());
        for trial in &slow {
            let mut rows = Rows::new(4);
            trial.iter().for_each(|row| (0..20).for_each(|_| rows.push(row)));
            fast.push(rows);
        }
        let [slow, fast] =
            [CommandRange::new(slow.iter(), 0.2), CommandRange::new(fast.iter(), 0.01)];
        assert_eq!((slow.step, slow.step_s), (fast.step, fast.step_s));
        assert_eq!(
            protocols(&slow, ACROSS)[2].trials[0].commands,
            protocols(&fast, ACROSS)[2].trials[0].commands
        );
    }

    #[test]
    fn a_loop_comes_again_a_dwell_stays_and_reversals_grow() {
        let trials = recorded();
        let range = CommandRange::new(trials.iter(), 0.2);
        let protocol = |name: &str| {
            protocols(&range, ACROSS)
                .into_iter()
                .find(|protocol| protocol.name == name)
                .unwrap()
                .trials
                .swap_remove(0)
                .commands
        };
        let dwell: Vec<Vec<f64>> = protocol("dwell").iter().map(<[f64]>::to_vec).collect();
        assert!(
            dwell[COMMANDS - 40..].iter().all(|row| *row == dwell[COMMANDS - 1])
                && dwell[COMMANDS - 1] != dwell[0]
        );
        let slow_and_fast = protocols(&range, ACROSS)
            .into_iter()
            .find(|protocol| protocol.name == "slow_and_fast")
            .unwrap()
            .trials;
        let fastest = |rows: &Rows| {
            (1..COMMANDS).map(|k| farthest(rows.row(k - 1), rows.row(k))).fold(0.0, f64::max)
        };
        assert!(fastest(&slow_and_fast[1].commands) < 0.4 * fastest(&slow_and_fast[0].commands));
        let out: Vec<f64> = protocol("reversals")
            .iter()
            .map(|row| row.iter().copied().fold(0.0, f64::max))
            .collect();
        let peaks: Vec<f64> = (1..COMMANDS - 1)
            .filter(|&k| out[k] > out[k - 1] && out[k] > out[k + 1])
            .map(|k| out[k])
            .collect();
        assert_eq!(peaks.len(), 3, "{out:?}");
        assert!(peaks.is_sorted() && (peaks[0] / peaks[2] - 1.0 / 3.0).abs() < 1e-9, "{peaks:?}");
        let corner = range.corners(0).swap_remove(0);
        assert!(protocol("repeated_loop").iter().filter(|row| **row == corner[..]).count() >= 2);
    }
}
