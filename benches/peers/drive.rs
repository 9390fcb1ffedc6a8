//! The robots and what drives them: the same for every peer.

use std::path::Path;

use nalgebra::Vector3;
use rand::RngExt;
use spinebench::base::Seed;
use spinebench::rod::{Drive, RodParams};
use spinebench::specs;

/// How often the tip is compared, s.
pub const SAMPLE_S: f64 = 0.05;
/// Time between two commands of the paper's robot, s.
const TICK_S: f64 = 0.2;
/// Largest change of a commanded tendon between two commands, metres, and largest pull.
const MOST_STEP_M: f64 = 0.003;
const MOST_PULL_M: f64 = 0.03;
/// Ends of the two ramps of Till's example, s, and the displacement between them, metres.
const RAMP_ENDS_S: [f64; 4] = [3.652, 3.967, 17.63, 17.94];
const RAMP_M: f64 = 0.01619;

/// Drive values of all tendons at given times, with straight lines between: metres pulled in, or
/// newtons.
#[derive(Clone, Debug)]
pub struct Series {
    pub times_s: Vec<f64>,
    pub values: Vec<Vec<f64>>,
    /// Whether the values are tensions.
    pub tensions: bool,
    /// Whether the drive changes its speed with a jump at these times, so that time steps should
    /// end there.
    pub kinks: bool,
}

impl Series {
    /// Values at `time_s`; held before the first and after the last time.
    pub fn at(&self, time_s: f64) -> Vec<f64> {
        let next = self.times_s.partition_point(|&time| time <= time_s);
        if next == 0 || next == self.times_s.len() {
            return self.values[next.saturating_sub(1)].clone();
        }
        let (from, to) = (self.times_s[next - 1], self.times_s[next]);
        let share = (time_s - from) / (to - from);
        let between = |(a, b): (&f64, &f64)| a + share * (b - a);
        self.values[next - 1].iter().zip(&self.values[next]).map(between).collect()
    }

    /// The same as the rod's commands.
    pub fn drives(&self, time_s: f64) -> Vec<Drive> {
        let drive = |value: f64| {
            if self.tensions { Drive::Tension(value.max(0.0)) } else { Drive::Pull(value) }
        };
        self.at(time_s).into_iter().map(drive).collect()
    }
}

/// A robot and what it is put through.
#[derive(Clone, Debug)]
pub struct Case {
    pub name: &'static str,
    pub params: RodParams,
    pub series: Series,
    pub duration_s: f64,
}

impl Case {
    /// Times at which tips are compared: every 50 ms, the start included.
    pub fn samples_s(&self) -> Vec<f64> {
        (0..=(self.duration_s / SAMPLE_S).round() as usize).map(|k| k as f64 * SAMPLE_S).collect()
    }
}

fn shipped(name: &str) -> Result<RodParams, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name);
    Ok(specs::read_model(&path).map_err(|error| error.to_string())?.rod(&[]))
}

/// Till, Aloi & Rucker's dynamic tendon example, 25 s.
pub fn till() -> Result<Case, String> {
    let pulls = [0.0, 0.0, RAMP_M, RAMP_M, 0.0];
    let series = Series {
        times_s: [0.0].into_iter().chain(RAMP_ENDS_S).collect(),
        values: pulls.iter().map(|&pull| vec![pull]).collect(),
        tensions: false,
        kinks: true,
    };
    // The reference series ends at 24.95 s.
    Ok(Case { name: "till", params: shipped("till_dynamic.yaml")?, series, duration_s: 24.95 })
}

/// The limit of that example for ever finer steps in space and time: tip at the samples, planar (x,
/// z).
pub fn till_limit() -> Result<Vec<Vector3<f64>>, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/reference/rod/till_dynamic_example_limit.csv");
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut tips = Vec::new();
    for line in text.lines().skip(1) {
        let values: Vec<f64> =
            line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        // The row before time zero is the state at rest once more.
        if let [t, x, z, ..] = values[..]
            && t >= 0.0
        {
            tips.push(Vector3::new(x, 0.0, z));
        }
    }
    Ok(tips)
}

/// The paper's robot explored at random, 10 s: every 0.2 s the point of the actuation plane moves
/// by at most 3 mm a tendon, two tendons are pulled towards it and the opposite ones are let out by
/// as much; the lead screws move at constant speed in between.
pub fn paper() -> Result<Case, String> {
    let duration_s = 10.0;
    let mut random = Seed(1).child("peers").rng();
    let mut bend = [0.0_f64; 2];
    let mut series =
        Series { times_s: vec![0.0], values: vec![vec![0.0; 4]], tensions: false, kinks: true };
    for tick in 1..=(duration_s / TICK_S).round() as usize {
        for value in &mut bend {
            let change = random.random_range(-MOST_STEP_M..=MOST_STEP_M);
            let next = *value + change;
            *value = if next.abs() > MOST_PULL_M { *value - change } else { next };
        }
        series.times_s.push(tick as f64 * TICK_S);
        series.values.push(vec![bend[0], bend[1], -bend[0], -bend[1]]);
    }
    Ok(Case { name: "paper", params: shipped("nominal.yaml")?, series, duration_s })
}

/// The paper's robot without what some peers cannot do (no compressible spine, no damping), driven
/// by smooth tensions for 1 s.
pub fn tension() -> Result<Case, String> {
    let mut params = shipped("nominal.yaml")?;
    params.sections.clear();
    params.damping_time_s = 0.0;
    let at = |t: f64| {
        let rise = |t: f64| 0.5 - 0.5 * (std::f64::consts::PI * t.clamp(0.0, 1.0)).cos();
        vec![4.0 + 3.0 * rise(t), 2.0 + 2.0 * rise(2.0 * t - 0.5), 0.0, 0.0]
    };
    let times_s: Vec<f64> = (0..=1000).map(|k| 0.001 * f64::from(k)).collect();
    let values = times_s.iter().map(|&t| at(t)).collect();
    let series = Series { times_s, values, tensions: true, kinks: false };
    Ok(Case { name: "paper_tension", params, series, duration_s: 1.0 })
}
