//! Control by a Jacobian that is estimated while the robot moves (Yip & Camarillo 2014), here by a
//! Kalman filter: each row of the Jacobian is a random walk, and each motion measures it along its
//! own direction. No data are collected before.

use nalgebra::{DMatrix, DVector};

use crate::base::{BadOption, Point3, PolicyError};
use crate::policies::parts::bends::BendDirections;
use crate::policies::parts::single_controller::{ControlLaw, Demand, SingleController};
use crate::policies::parts::tip_tracker::TipReading;
use crate::policies::{Deserialize, ModelAccess, PolicyEntry, Serialize, SeriesLabel};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "online_jacobian",
    label: SeriesLabel::text("online Jacobian"),
    footnote: "Jacobian estimated in motion, without model and data.",
    model: ModelAccess::Tendons,
    closed_loop_only: true,
    make: |parts, options| {
        let bends = BendDirections::new(parts.layout("online_jacobian")?, options.limits);
        let controller = JacobianController::new(bends, options.online_jacobian);
        Ok(Box::new(SingleController::new(controller, "", options)))
    },
    ..PolicyEntry::PLAIN
};

/// Options of the control by an estimated Jacobian.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OnlineJacobianOptions {
    /// Share of the measured error that a tick removes according to the Jacobian: above 0, at most
    /// 1.
    pub gain: f64,
    /// First guess: how far the tip moves towards a tendon for each metre of its displacement,
    /// metres.
    pub first_gain: f64,
    /// Standard deviation of that guess, metres per metre.
    pub first_sd: f64,
    /// How much the Jacobian may change for each metre of displacement, metres per metre.
    pub drift_per_m: f64,
    /// Standard deviation of the tracking noise on an axis.
    pub noise_m: f64,
    /// The policy has settled when the displacement that the Jacobian requires is below this.
    pub settled_pull_m: f64,
}

impl Default for OnlineJacobianOptions {
    fn default() -> Self {
        OnlineJacobianOptions {
            gain: 0.4,
            first_gain: 4.0,
            first_sd: 2.0,
            drift_per_m: 100.0,
            noise_m: 0.0005,
            settled_pull_m: 0.0002,
        }
    }
}

impl OnlineJacobianOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_share("gain", self.gain)?;
        BadOption::unless_positive("first_gain", self.first_gain)?;
        BadOption::unless_positive("first_sd", self.first_sd)?;
        BadOption::unless_positive("drift_per_m", self.drift_per_m)?;
        BadOption::unless_positive("noise_m", self.noise_m)?;
        BadOption::unless_positive("settled_pull_m", self.settled_pull_m)
    }
}

/// Damping of the inverse, as a share of the first guess of the Jacobian.
const DAMPING_SHARE: f64 = 0.05;

struct JacobianController {
    bends: BendDirections,
    options: OnlineJacobianOptions,
    bend_m: Vec<f64>,
    /// Tip per bend: three rows.
    jacobian: DMatrix<f64>,
    /// Covariance of each row; the rows are measured along the same directions.
    covariance: DMatrix<f64>,
    /// Bend and tip at the last measurement.
    last: Option<(Vec<f64>, Point3)>,
}

impl JacobianController {
    fn new(bends: BendDirections, options: OnlineJacobianOptions) -> JacobianController {
        let count = bends.len();
        let (jacobian, covariance) = (DMatrix::zeros(3, count), DMatrix::zeros(count, count));
        let bend_m = vec![0.0; count];
        let mut controller =
            JacobianController { bends, options, bend_m, jacobian, covariance, last: None };
        controller.reset();
        controller
    }

    /// One step of the filter: the tip moved from the last measurement to `tip_m`.
    fn learn(&mut self, tip_m: &Point3) {
        let Some((bend_m, from_m)) = &self.last else { return };
        let moved_m = DVector::from_iterator(
            bend_m.len(),
            self.bend_m.iter().zip(bend_m).map(|(to, from)| to - from),
        );
        let distance_m = moved_m.norm();
        if distance_m == 0.0 {
            return;
        }
        // Prediction: each entry may have changed in proportion to the motion.
        let drift = (self.options.drift_per_m * distance_m).powi(2);
        (0..bend_m.len()).for_each(|index| self.covariance[(index, index)] += drift);
        let seen_m =
            DVector::from_iterator(3, tip_m.iter().zip(from_m).map(|(to, from)| to - from));
        let along = &self.covariance * &moved_m;
        // K = P h / (hᵀ P h + r), with twice the noise: both ends of the motion are measured.
        let gain = &along / (moved_m.dot(&along) + 2.0 * self.options.noise_m.powi(2));
        let surprise_m = seen_m - &self.jacobian * &moved_m;
        self.jacobian += surprise_m * gain.transpose();
        // P ← P − K hᵀ P.
        self.covariance -= gain * along.transpose();
    }

    /// The change of the bend that takes the tip by `error_m`, damped where the Jacobian is nearly
    /// singular.
    fn change_m(&self, error_m: Point3) -> Option<Vec<f64>> {
        let transposed = self.jacobian.transpose();
        let damping = (DAMPING_SHARE * self.options.first_gain).powi(2);
        let count = self.bend_m.len();
        let normal = &transposed * &self.jacobian + damping * DMatrix::identity(count, count);
        let change_m = normal.cholesky()?.solve(&(transposed * DVector::from_row_slice(&error_m)));
        Some(change_m.iter().copied().collect())
    }
}

impl ControlLaw for JacobianController {
    fn reset(&mut self) {
        let OnlineJacobianOptions { first_gain, first_sd, .. } = self.options;
        self.bend_m.fill(0.0);
        // Components alternate between x and y; the tip moves with those of its own axis.
        self.jacobian = DMatrix::from_fn(3, self.bend_m.len(), |row, column| {
            if row == column % 2 { first_gain } else { 0.0 }
        });
        self.covariance =
            first_sd.powi(2) * DMatrix::identity(self.bend_m.len(), self.bend_m.len());
        self.last = None;
    }

    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        let error_m = std::array::from_fn(|axis| target_m[axis] - reading.tip_m[axis]);
        if reading.fresh {
            self.learn(&reading.tip_m);
            self.last = Some((self.bend_m.clone(), reading.tip_m));
        }
        let change_m =
            self.change_m(error_m).ok_or(PolicyError::NotFinite("estimated Jacobian"))?;
        let settled = change_m.iter().all(|change_m| change_m.abs() <= self.options.settled_pull_m);
        // Without a new measurement the error is not known: the command stays.
        if reading.fresh {
            let change_m: Vec<f64> =
                change_m.iter().map(|change_m| self.options.gain * change_m).collect();
            self.bends.advance(&mut self.bend_m, &change_m);
        }
        Ok(Demand { pulls_m: self.bends.pulls_m(&self.bend_m), settled })
    }
}
