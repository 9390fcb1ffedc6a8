//! What a blind case shows of itself.

use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::commands::Commands;
use super::drawing::{CaseDesign, true_tips_m};
use super::error::BenchmarkError;
use super::truth::Truth;
use crate::base::{Point3, Seed};
use crate::data::{Actuation, Recording};

/// A recording without its label, and what is taken out of the catalogue for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PublicCase {
    /// What the drives were told.
    pub commands: Commands,
    /// Measured tips, sample by sample, metres.
    pub tips_m: Vec<Point3>,
    /// Effects that may not be named.
    pub left_out: Vec<String>,
}

/// Plays the commands on the true robot and measures with noise, of this correlation from one
/// sample to the next.
///
/// # Errors
/// [`BenchmarkError::NoRobot`] when the robot cannot follow.
pub fn measure_case(
    robot: &CaseDesign,
    truth: &Truth,
    commands: &Commands,
    correlation: f64,
) -> Result<PublicCase, BenchmarkError> {
    let unplayable = || BenchmarkError::NoRobot { what: truth.name(), tried: 1 };
    let mut tips_m = true_tips_m(robot, truth, commands).ok_or_else(unplayable)?;
    let counts = commands.trials.iter().map(crate::base::Rows::len);
    add_noise(&mut tips_m, counts, robot.noise_m, correlation, Seed(robot.seed).child("noise"));
    Ok(PublicCase { commands: commands.clone(), tips_m, left_out: truth.left_out.clone() })
}

/// Adds AR(1) noise with this standard deviation by axis, metres, and this correlation of
/// consecutive samples. `trials`: number of samples of each trial; trials are independent.
pub fn add_noise(
    tips_m: &mut [Point3],
    trials: impl Iterator<Item = usize>,
    noise_m: f64,
    correlation: f64,
    seed: Seed,
) {
    let mut random = seed.rng();
    // Innovations of this standard deviation keep the variance of the process at 1.
    let innovation_share = (1.0 - correlation * correlation).sqrt();
    let mut start = 0;
    for count in trials {
        let mut state = [0.0_f64; 3];
        for (row, tip) in tips_m[start..start + count].iter_mut().enumerate() {
            for (axis, value) in tip.iter_mut().enumerate() {
                let drawn: f64 = StandardNormal.sample(&mut random);
                state[axis] = if row == 0 {
                    drawn
                } else {
                    correlation * state[axis] + innovation_share * drawn
                };
                *value += noise_m * state[axis];
            }
        }
        start += count;
    }
}

impl PublicCase {
    /// The case as a recording.
    pub fn recording(&self) -> Recording {
        let tendons = self.commands.trials.first().map_or(0, crate::base::Rows::width);
        let mut recording = Recording::new(Actuation::Lengths, tendons);
        for (number, trial) in self.commands.trials.iter().enumerate() {
            for (row, pulls_m) in trial.iter().enumerate() {
                recording.trial.push(number as u64);
                recording.time_s.push(row as f64 * self.commands.step_s);
                recording.commands.push(pulls_m);
            }
        }
        recording.tip_m = Some(self.tips_m.clone());
        recording
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_asked_size_and_correlation() {
        for correlation in [0.0, 0.6] {
            let mut tips = vec![[0.0; 3]; 20_000];
            add_noise(&mut tips, [10_000, 10_000].into_iter(), 5e-4, correlation, Seed(3));
            let column = |axis: usize| tips.iter().map(|tip| tip[axis]).collect::<Vec<f64>>();
            for axis in 0..3 {
                let all = column(axis);
                let variance = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
                let next: f64 =
                    all.windows(2).map(|two| two[0] * two[1]).sum::<f64>() / all.len() as f64;
                assert!((variance.sqrt() / 5e-4 - 1.0).abs() < 0.03, "{}", variance.sqrt());
                assert!((next / variance - correlation).abs() < 0.03, "{}", next / variance);
            }
        }
    }
}
