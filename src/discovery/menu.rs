//! What a lab can record next: commands built from poses that the recording has shown to be safe.

use crate::base::Rows;

/// Something to record.
pub(super) struct Dish {
    pub(super) name: &'static str,
    pub(super) what: String,
    /// Set-up by hand, minutes.
    pub(super) setup_min: f64,
    /// Commands of each trial, and the weight that hangs on the tip, kilograms.
    pub(super) trials: Vec<(Rows, f64)>,
    /// Whether the base is turned so that gravity pulls along −y, across where it pulled.
    pub(super) remounted: bool,
}

/// The recorded range that commands may use.
pub(super) struct Range {
    /// Recorded commands, all trials.
    poses: Vec<Vec<f64>>,
    /// The largest change of one tendon from one command to the next that was recorded.
    step: f64,
}

/// Commands to each trial.
const LENGTH: usize = 50;
/// Poses that a path visits.
const CORNERS: usize = 6;
/// A weight that labs have and robots bear.
const WEIGHT_KG: f64 = 0.02;

/// The menu: every entry takes four trials.
pub(super) fn menu(range: &Range) -> Vec<Dish> {
    let path = |first: usize| range.path(&range.corners(first), range.step);
    let four = |trial: &dyn Fn(usize) -> Rows| -> Vec<(Rows, f64)> { (0..4).map(|k| (trial(k), 0.0)).collect() };
    let dish =
        |name, what: &str, setup_min, trials| Dish { name, what: what.to_owned(), setup_min, trials, remounted: false };
    let weighed = (0..4).map(|k| (path(k / 2), if k % 2 == 1 { WEIGHT_KG } else { 0.0 })).collect();
    let looped = |k: usize| {
        let corners: Vec<Vec<f64>> = range.corners(k).into_iter().take(2).collect();
        range.path(&[corners.clone(), corners.clone(), corners].concat(), range.step)
    };
    let paced = |k: usize| {
        let corners: Vec<Vec<f64>> = range.corners(k / 2).into_iter().take(2).collect();
        range.path(&corners, if k.is_multiple_of(2) { range.step } else { range.step / 3.0 })
    };
    vec![
        dish("known_weight", "Play four trials, the second and fourth with 20 g on the tip", 2.0, weighed),
        Dish {
            remounted: true,
            ..dish("base_remounted", "Turn the base a quarter about its axis and play four trials", 5.0, four(&path))
        },
        dish("dwell", "Go to four far poses and stay there for eight seconds", 0.5, four(&|k| range.dwell(k))),
        dish("repeated_loop", "Play one loop three times over, in four trials", 0.5, four(&looped)),
        dish("slow_and_fast", "Play two paths, each fast and at a third of the speed", 0.5, four(&paced)),
        dish(
            "reversals",
            "Bend out and back three times with growing amplitude, in four directions",
            0.5,
            four(&|k| range.reversals(k)),
        ),
        dish("far_poses", "Go through the farthest poses one after the other, in four trials", 0.5, four(&path)),
    ]
}

impl Range {
    /// The range of recorded commands, trial by trial.
    pub(super) fn new<'a>(trials: impl Iterator<Item = &'a Rows>) -> Range {
        let mut range = Range { poses: Vec::new(), step: 0.0 };
        for trial in trials {
            let rows: Vec<&[f64]> = trial.iter().collect();
            for pair in rows.windows(2) {
                range.step = range.step.max(farthest(pair[0], pair[1]));
            }
            range.poses.extend(rows.into_iter().map(<[f64]>::to_vec));
        }
        range
    }

    /// Recorded poses far from each other, from the `first`-farthest from home on (farthest-point sampling).
    fn corners(&self, first: usize) -> Vec<Vec<f64>> {
        let home = vec![0.0; self.poses.first().map_or(0, Vec::len)];
        let mut chosen: Vec<Vec<f64>> = vec![home];
        for _ in 0..first + CORNERS {
            let nearest =
                |pose: &Vec<f64>| chosen.iter().map(|known| farthest(pose, known)).fold(f64::INFINITY, f64::min);
            match self.poses.iter().max_by(|a, b| nearest(a).total_cmp(&nearest(b))) {
                Some(pose) => chosen.push(pose.clone()),
                None => break,
            }
        }
        chosen.split_off((1 + first).min(chosen.len()))
    }

    /// From home through `corners` in steps of at most `step`, then staying.
    fn path(&self, corners: &[Vec<f64>], step: f64) -> Rows {
        let width = corners.first().map_or(0, Vec::len);
        let mut at = vec![0.0; width];
        let mut rows = Rows::new(width);
        for corner in corners {
            let steps = (farthest(&at, corner) / step.max(1e-9)).ceil().max(1.0) as usize;
            let from = at.clone();
            for k in 1..=steps {
                let share = k as f64 / steps as f64;
                at = from.iter().zip(corner).map(|(a, b)| a + share * (b - a)).collect();
                if rows.len() < LENGTH {
                    rows.push(&at);
                }
            }
        }
        while rows.len() < LENGTH {
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
        let turns = [1.0 / 3.0, 0.0, 2.0 / 3.0, 0.0, 1.0, 0.0];
        self.path(&turns.map(scaled), self.step)
    }
}

/// The largest difference of any tendon.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
