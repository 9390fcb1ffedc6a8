//! A cheap four-tendon robot of constant curvature, for tests and smoke runs: Webster & Jones 2010
//! (eq. 2 with one section), a first-order lag between command and shape, and a constant gap to
//! open on purpose.

use rand_distr::{Distribution, Normal};
use serde::{Deserialize, Serialize};

use super::{PlantOptions, RobotSize, check_commands};
use crate::base::{
    BadOption, Generator, Observation, Plant, PlantError, Point3, Seed, TendonCommand,
};

const TENDONS: usize = 4;
/// Below this bending angle (rad) the series of (1 − cos θ)/θ² and sin θ/θ is exact to rounding.
const SMALL_ANGLE_RAD: f64 = 1e-4;

/// Settings of [`ConstantCurvature`]; the defaults are the paper's robot with the contract's
/// assumed routing radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ConstantCurvatureOptions {
    /// Length of the backbone.
    pub length_m: f64,
    /// Distance of the tendons from the backbone.
    pub tendon_radius_m: f64,
    /// Time constant of the lag between command and shape; 0 follows at once.
    pub lag_s: f64,
    /// Duration of one step.
    pub step_s: f64,
    /// Constant added to the tip: the gap `p_exp − p_sim`.
    pub shift_m: Point3,
    /// Standard deviation of the measurement noise per axis.
    pub noise_m: f64,
    /// Commands beyond this displacement are refused.
    pub travel_m: f64,
}

impl Default for ConstantCurvatureOptions {
    fn default() -> Self {
        ConstantCurvatureOptions {
            length_m: 0.22,
            tendon_radius_m: 0.02,
            lag_s: 0.08,
            step_s: 0.2,
            shift_m: [0.0; 3],
            noise_m: 0.0,
            travel_m: 0.05,
        }
    }
}

impl PlantOptions for ConstantCurvatureOptions {
    fn check(&self) -> Result<(), (String, BadOption)> {
        ConstantCurvature::new(*self).map(|_| ()).map_err(|error| (String::new(), error))
    }

    fn tendons(&self) -> usize {
        TENDONS
    }

    fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        let options = ConstantCurvatureOptions { step_s, ..*self };
        Ok(Box::new(ConstantCurvature::new(options).map_err(|error| error.to_string())?))
    }

    fn remove_noise(&mut self) {
        self.noise_m = 0.0;
    }

    fn size(&self) -> Option<RobotSize> {
        Some(RobotSize { lever_m: self.tendon_radius_m, length_m: self.length_m })
    }

    fn example() -> Option<Self> {
        Some(ConstantCurvatureOptions::default())
    }
}

/// The plant: its state is the bending vector (θ_x, θ_y) in radians, towards +x and +y.
pub struct ConstantCurvature {
    options: ConstantCurvatureOptions,
    bend_rad: [f64; 2],
    time_s: f64,
    noise: Generator,
}

impl ConstantCurvature {
    /// A robot with these settings.
    ///
    /// # Errors
    /// [`BadOption`] for a length, radius, step or travel that is not positive, or a negative lag
    /// or noise.
    pub fn new(options: ConstantCurvatureOptions) -> Result<Self, BadOption> {
        BadOption::unless_positive("length_m", options.length_m)?;
        BadOption::unless_positive("tendon_radius_m", options.tendon_radius_m)?;
        BadOption::unless_positive("step_s", options.step_s)?;
        BadOption::unless_positive("travel_m", options.travel_m)?;
        BadOption::unless_not_negative("lag_s", options.lag_s)?;
        BadOption::unless_not_negative("noise_m", options.noise_m)?;
        Ok(ConstantCurvature { options, bend_rad: [0.0; 2], time_s: 0.0, noise: Seed(0).rng() })
    }

    /// Tip without gap and noise for a bending vector, metres.
    pub fn tip_m(options: &ConstantCurvatureOptions, bend_rad: [f64; 2]) -> Point3 {
        let [bend_x, bend_y] = bend_rad;
        let angle = bend_x.hypot(bend_y);
        let (across, along) = if angle < SMALL_ANGLE_RAD {
            (0.5 - angle * angle / 24.0, 1.0 - angle * angle / 6.0)
        } else {
            ((1.0 - angle.cos()) / (angle * angle), angle.sin() / angle)
        };
        [
            options.length_m * across * bend_x,
            options.length_m * across * bend_y,
            options.length_m * along,
        ]
    }

    /// Displacements that bend the robot so that its tip lies in the direction of `tip_m`: the
    /// inverse of [`ConstantCurvature::tip_m`] for points on the workspace, metres.
    pub fn pulls_m(options: &ConstantCurvatureOptions, tip_m: &Point3) -> Vec<f64> {
        let across = tip_m[0].hypot(tip_m[1]);
        // The chord of an arc leaves the base at half the angle by which the arc turns.
        let angle = 2.0 * across.atan2(tip_m[2]);
        let (cos, sin) =
            if across > 0.0 { (tip_m[0] / across, tip_m[1] / across) } else { (1.0, 0.0) };
        let pull = options.tendon_radius_m * angle;
        vec![pull * cos, pull * sin, -pull * cos, -pull * sin]
    }

    fn observe(&mut self, pulls_m: Vec<f64>) -> Observation {
        let mut tip_m = Self::tip_m(&self.options, self.bend_rad);
        // A standard deviation of zero is valid, so the distribution always exists.
        let noise = Normal::new(0.0, self.options.noise_m).ok();
        for (value, shift) in tip_m.iter_mut().zip(self.options.shift_m) {
            *value += shift + noise.as_ref().map_or(0.0, |normal| normal.sample(&mut self.noise));
        }
        Observation {
            time_s: self.time_s,
            tip_m,
            tip_quaternion: None,
            points: Vec::new(),
            pulls_m,
            tensions_n: None,
            valid: true,
        }
    }

    /// Bending about one axis that an opposite pair of tendons asks for, radians. Tendons only
    /// pull, so of two commanded ones the one pulled further decides and the other is slack.
    fn commanded_rad(&self, towards: TendonCommand, away: TendonCommand) -> f64 {
        let radius = self.options.tendon_radius_m;
        match (towards, away) {
            (TendonCommand::Pull(near), TendonCommand::Pull(far)) if near < far => -far / radius,
            (TendonCommand::Pull(near), _) => near / radius,
            (TendonCommand::Follow, TendonCommand::Pull(far)) => -far / radius,
            (TendonCommand::Follow, TendonCommand::Follow) => 0.0,
        }
    }
}

impl Plant for ConstantCurvature {
    fn tendons(&self) -> usize {
        TENDONS
    }

    fn step_s(&self) -> f64 {
        self.options.step_s
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        self.bend_rad = [0.0; 2];
        self.time_s = 0.0;
        self.noise = seed.rng();
        Ok(self.observe(vec![0.0; TENDONS]))
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        check_commands(commands, TENDONS, self.options.travel_m)?;
        let target_rad = [
            self.commanded_rad(commands[0], commands[2]),
            self.commanded_rad(commands[1], commands[3]),
        ];
        // The exact solution of the lag over one step.
        let share = if self.options.lag_s > 0.0 {
            -(-self.options.step_s / self.options.lag_s).exp_m1()
        } else {
            1.0
        };
        for (bend, target) in self.bend_rad.iter_mut().zip(target_rad) {
            *bend += share * (target - *bend);
        }
        self.time_s += self.options.step_s;
        let radius = self.options.tendon_radius_m;
        let [bend_x, bend_y] = self.bend_rad;
        let shape = [radius * bend_x, radius * bend_y, -radius * bend_x, -radius * bend_y];
        let pulls_m =
            commands.iter().zip(shape).map(|(command, followed_m)| command.pull_m_or(followed_m));
        Ok(self.observe(pulls_m.collect()))
    }
}
