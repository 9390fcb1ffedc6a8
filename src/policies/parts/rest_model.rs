//! The nominal model at rest, moved into the real workspace by the error model where there is one,
//! and its inverse by Gauss-Newton steps on the model's own derivatives.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::actuator_limits::largest_change_m;
use super::bounded_step::{BoundedStep, unevenness};
use crate::base::{Displacements, Point3, RestPose, TendonLayout, TipModel, distance_m};
use crate::policies::ErrorModel;

/// Largest change of a bend in a Gauss-Newton step, as an angle: about the size over which the
/// derivatives hold.
const MAX_STEP_RAD: f64 = 0.5;
/// The inverse is found when a step changes no component of the bend by more than this.
const STEP_TOLERANCE_RAD: f64 = 5e-4;
/// Damping of the steps, metres of tip for each metre of bend: far below the 3 to 5 of a robot that
/// bends.
const DAMPING: f64 = 0.2;
/// Evaluations of the model to come back within the travel.
const MAX_PROJECTIONS: usize = 3;

/// Changes of the trusted size of a bounded step after a worse and after a better pose.
const TRUST_AFTER_WORSE: f64 = 0.4;
const TRUST_AFTER_BETTER: f64 = 2.0;

/// Steps to the bend that is nearest to a target, from home.
const NEAREST_STEPS: usize = 40;

/// The distance from each target to the nearest place where the tip of a model comes to rest, by
/// bending with pulls of at most `travel_m`, metres. Infinite where the model has no equilibrium at
/// home.
pub fn nearest_at_rest_m(
    model: Box<dyn TipModel>,
    layout: TendonLayout,
    travel_m: f64,
    targets_m: &[Point3],
) -> Vec<f64> {
    let mut model = RestModel::new(model, None, layout, travel_m, 0.0);
    let straight_m = vec![0.0; model.bends()];
    let mut nearest = |target_m: &Point3| {
        model.restart();
        let home = model.expect(&straight_m)?;
        Some(distance_m(&model.inverse(home, target_m, NEAREST_STEPS).pose.tip_m, target_m))
    };
    targets_m.iter().map(|target_m| nearest(target_m).unwrap_or(f64::INFINITY)).collect()
}

/// What is expected of the robot at rest under a bend.
#[derive(Clone)]
pub(crate) struct ExpectedPose {
    pub(crate) bend_m: Vec<f64>,
    pub(crate) pulls_m: Displacements,
    pub(crate) tip_m: Point3,
}

/// What the search for a target has led to.
pub(crate) struct InversePose {
    /// The pose that is nearest to it.
    pub(crate) pose: ExpectedPose,
    /// Whether the model had no pose wherever the search went.
    pub(crate) lost: bool,
}

/// A model of the robot at rest.
pub(crate) struct RestModel {
    model: Box<dyn TipModel>,
    error: Option<Arc<dyn ErrorModel>>,
    layout: TendonLayout,
    travel_m: f64,
    slack_m: f64,
    /// Whether followers are let out.
    let_out: bool,
    /// For a model that takes displacements, what of them bends no segment evenly.
    unevenness: Option<DMatrix<f64>>,
}

impl RestModel {
    pub(crate) fn new(
        model: Box<dyn TipModel>,
        error: Option<Arc<dyn ErrorModel>>,
        layout: TendonLayout,
        travel_m: f64,
        slack_m: f64,
    ) -> RestModel {
        let unevenness = model.takes_displacements().then(|| unevenness(&layout));
        RestModel { model, error, layout, travel_m, slack_m, let_out: false, unevenness }
    }

    /// Whether a bend is the displacement of each tendon.
    pub(crate) fn takes_displacements(&self) -> bool {
        self.unevenness.is_some()
    }

    /// An angle of bending as a displacement, metres.
    fn at_lever_m(&self, angle_rad: f64) -> f64 {
        angle_rad * self.model.lever_m()
    }

    /// Number of components of a bend.
    pub(crate) fn bends(&self) -> usize {
        self.model.bends()
    }

    /// Forgets the trial.
    pub(crate) fn restart(&mut self) {
        self.model.restart();
        self.let_out = false;
    }

    /// From now on tendons that follow are let out. The Gaussian process has seen them as the model
    /// has them, so that without feedback they stay so.
    pub(crate) fn let_out(&mut self) {
        self.let_out = true;
    }

    /// What is expected under a bend; nothing where the model has no pose or a value is not finite.
    pub(crate) fn expect(&mut self, bend_m: &[f64]) -> Option<ExpectedPose> {
        let RestPose { mut pulls_m, tip_m } = self.model.at_rest(bend_m).ok()?;
        let tip_m = self.corrected_m(&pulls_m, &tip_m);
        if !self.takes_displacements() {
            self.let_followers_out(bend_m, &mut pulls_m);
        }
        let finite = tip_m.iter().chain(&pulls_m).all(|value| value.is_finite());
        finite.then(|| ExpectedPose { bend_m: bend_m.to_vec(), pulls_m, tip_m })
    }

    /// Where the tip is expected after the robot has been commanded this pose for `duration_s`
    /// seconds: of a model that knows rest only, at rest. Nothing where the model cannot be moved
    /// on.
    pub(crate) fn follow(&mut self, pose: &ExpectedPose, duration_s: f64) -> Option<Point3> {
        let Some(tip_m) = self.model.follow(&pose.bend_m, duration_s).ok()? else {
            return Some(pose.tip_m);
        };
        let tip_m = self.corrected_m(&pose.pulls_m, &tip_m);
        tip_m.iter().all(|value| value.is_finite()).then_some(tip_m)
    }

    /// The model's tip as the error model moves it into the real workspace.
    fn corrected_m(&self, pulls_m: &[f64], tip_m: &Point3) -> Point3 {
        // e = p_sim − p_exp (eq. 20).
        let error_m = self.error.as_ref().map_or([0.0; 3], |error| error.error_m(pulls_m, tip_m));
        std::array::from_fn(|axis| tip_m[axis] - error_m[axis])
    }

    fn let_followers_out(&self, bend_m: &[f64], pulls_m: &mut [f64]) {
        // What follows in the model may be taut in the robot: it is let out, little by little as
        // the bend leaves it.
        let slack_m = if self.let_out { self.slack_m } else { 0.0 };
        for (tendon, [cos, sin], segment) in placed(&self.layout) {
            let across_m = -(cos * bend_m[2 * segment] + sin * bend_m[2 * segment + 1]);
            pulls_m[tendon] -= across_m.clamp(0.0, slack_m);
        }
    }

    /// The same of the bend nearby that no tendon has to be pulled beyond the travel for.
    fn expect_within(&mut self, mut bend_m: Vec<f64>) -> Option<ExpectedPose> {
        for _ in 0..MAX_PROJECTIONS {
            let pose = self.expect(&bend_m)?;
            let beyond = pose.pulls_m.iter().map(|pull_m| (pull_m - self.travel_m).max(0.0));
            let beyond_m: Vec<f64> = beyond.collect();
            if beyond_m.iter().all(|beyond_m| *beyond_m <= self.at_lever_m(STEP_TOLERANCE_RAD)) {
                return Some(pose);
            }
            for (tendon, [cos, sin], segment) in placed(&self.layout) {
                bend_m[2 * segment] -= cos * beyond_m[tendon];
                bend_m[2 * segment + 1] -= sin * beyond_m[tendon];
            }
        }
        self.expect(&bend_m)
    }

    /// J: derivative of the model's tip with respect to the bend, 3 rows.
    pub(crate) fn jacobian(&mut self, bend_m: &[f64]) -> Option<DMatrix<f64>> {
        let rates = self.model.tip_per_bend(bend_m).ok()?;
        let finite = rates.iter().flatten().all(|rate| rate.is_finite());
        finite.then(|| DMatrix::from_fn(3, rates.len(), |row, column| rates[column][row]))
    }

    /// The pose whose expected tip is nearest to `tip_m`, by at most `steps` steps from `from`. A
    /// step to where the model has no pose is halved; the pose of the last step that had one is
    /// returned.
    pub(crate) fn inverse(
        &mut self,
        from: ExpectedPose,
        tip_m: &Point3,
        steps: usize,
    ) -> InversePose {
        if let Some(unevenness) = self.unevenness.clone() {
            return self.inverse_within_travel(from, tip_m, steps, &unevenness);
        }
        let mut best = from;
        let (mut asked, mut answered) = (false, false);
        let mut share = 1.0;
        let mut step_m: Option<Vec<f64>> = None;
        for _ in 0..steps {
            let Some(full_m) = step_m.take().or_else(|| self.step_m(&best, tip_m)) else {
                asked = true;
                break;
            };
            if share * full_m.iter().fold(0.0_f64, |largest_m, step_m| largest_m.max(step_m.abs()))
                <= self.at_lever_m(STEP_TOLERANCE_RAD)
            {
                break;
            }
            asked = true;
            let bend_m: Vec<f64> = best
                .bend_m
                .iter()
                .zip(&full_m)
                .map(|(bend_m, step)| bend_m + share * step)
                .collect();
            match self.expect_within(bend_m) {
                Some(next) => (best, answered) = (next, true),
                None => (share, step_m) = (0.5 * share, Some(full_m)),
            }
        }
        InversePose { pose: best, lost: asked && !answered }
    }

    /// [`RestModel::inverse`] for a model that takes displacements: a step that leads to no better
    /// pose is taken back and tried shorter. It asks for at most `steps` poses.
    fn inverse_within_travel(
        &mut self,
        from: ExpectedPose,
        tip_m: &Point3,
        steps: usize,
        unevenness: &DMatrix<f64>,
    ) -> InversePose {
        let max_step_m = self.at_lever_m(MAX_STEP_RAD);
        let tolerance_m = self.at_lever_m(STEP_TOLERANCE_RAD);
        let away_m = |from_m: &Point3| std::array::from_fn(|axis| tip_m[axis] - from_m[axis]);
        // A model with memory goes on from another pose than in the last tick.
        let from = self.expect(&from.bend_m).unwrap_or(from);
        let (mut best, mut trust_m) = (from, max_step_m);
        let (mut asked, mut answered) = (0, false);
        while asked < steps {
            let Some(jacobian) = self.jacobian(&best.bend_m) else {
                asked += 1;
                break;
            };
            let (pulls_m, error_m) = (best.bend_m.clone(), away_m(&best.tip_m));
            let step = BoundedStep::new(&jacobian, &error_m, unevenness, &pulls_m, self.travel_m);
            let cost = step.cost(&pulls_m, &error_m);
            let mut better = None;
            while better.is_none() && asked < steps {
                let next_m = step.next_m(trust_m);
                if largest_change_m(&pulls_m, &next_m) <= tolerance_m {
                    break;
                }
                asked += 1;
                let pose = self.expect(&next_m);
                answered |= pose.is_some();
                better = pose.filter(|pose| step.cost(&pose.bend_m, &away_m(&pose.tip_m)) < cost);
                if better.is_none() {
                    trust_m *= TRUST_AFTER_WORSE;
                }
            }
            let Some(next) = better else { break };
            best = next;
            trust_m = (TRUST_AFTER_BETTER * trust_m).min(max_step_m);
        }
        InversePose { pose: best, lost: asked > 0 && !answered }
    }

    /// A damped Gauss-Newton step that takes the tip to `tip_m`, within the trusted size.
    fn step_m(&mut self, from: &ExpectedPose, tip_m: &Point3) -> Option<Vec<f64>> {
        let jacobian = self.jacobian(&from.bend_m)?;
        let error_m =
            DVector::from_iterator(3, tip_m.iter().zip(from.tip_m).map(|(to, from)| to - from));
        let count = from.bend_m.len();
        let normal =
            jacobian.transpose() * &jacobian + DAMPING.powi(2) * DMatrix::identity(count, count);
        let step_m = normal.cholesky()?.solve(&(jacobian.transpose() * error_m));
        let share = (self.at_lever_m(MAX_STEP_RAD) / step_m.amax()).min(1.0);
        Some(step_m.iter().map(|value| share * value).collect())
    }
}

/// Each tendon with cosine and sine of its angle and its segment.
fn placed(layout: &TendonLayout) -> impl Iterator<Item = (usize, [f64; 2], usize)> {
    layout.segments.iter().enumerate().flat_map(|(segment, tendons)| {
        tendons.iter().map(move |placed| {
            let (sin, cos) = placed.angle_deg.to_radians().sin_cos();
            (placed.tendon, [cos, sin], segment)
        })
    })
}
