//! Stand-ins for learned models on the constant-curvature robot, whose inverse is known in closed
//! form.
#![allow(dead_code)]

use std::sync::{Arc, Mutex};

use spinebench::base::{Displacements, Observation, Point3, Policy, PolicyError};
use spinebench::learn::gp::Leaving;
use spinebench::plants::{ConstantCurvature, ConstantCurvatureOptions, PlantSpec};
use spinebench::policies::{
    ErrorModel, InverseModel, LearningErrorModel, NetworkDescription, PolicyEntry, PolicyOptions,
    PolicyParts, SampleColumns, TrainingData, build, find, networks,
};
use spinebench::tasks::tip_model;

/// The exact inverse of a robot whose tip is shifted by `shift_m`, with a memory that can be made
/// visible: each tick adds `drift_m` to every displacement.
#[derive(Clone, Default)]
pub(crate) struct AnalyticInverse {
    pub(crate) shift_m: Point3,
    pub(crate) drift_m: f64,
    pub(crate) ticks: usize,
}

impl InverseModel for AnalyticInverse {
    fn reset(&mut self) {
        self.ticks = 0;
    }

    fn pulls(&mut self, _from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError> {
        let unshifted_m = std::array::from_fn(|axis| to_m[axis] - self.shift_m[axis]);
        let pulls_m =
            ConstantCurvature::pulls_m(&ConstantCurvatureOptions::default(), &unshifted_m);
        Ok(pulls_m.into_iter().map(|pull| pull + self.drift_m * self.ticks as f64).collect())
    }

    fn tick(&mut self) {
        self.ticks += 1;
    }
}

/// A model that has gone wrong.
pub(crate) struct BrokenInverse;

impl InverseModel for BrokenInverse {
    fn reset(&mut self) {}

    fn pulls(&mut self, _from_m: &Point3, _to_m: &Point3) -> Result<Displacements, PolicyError> {
        Ok(vec![f64::NAN; 4])
    }
}

/// The same error everywhere.
pub(crate) struct ConstantError(pub(crate) Point3);

impl ErrorModel for ConstantError {
    fn error_m(&self, _pulls_m: &[f64], _p_sim_m: &Point3) -> Point3 {
        self.0
    }

    fn learning(&self, _points: usize, _leaves: Leaving) -> Option<Arc<dyn LearningErrorModel>> {
        Some(Arc::new(MeanError(Mutex::new(vec![self.0]))))
    }
}

/// The mean of an error and of all that were measured after it.
struct MeanError(Mutex<Vec<Point3>>);

impl ErrorModel for MeanError {
    fn error_m(&self, _pulls_m: &[f64], _p_sim_m: &Point3) -> Point3 {
        let all = self.0.lock().unwrap();
        std::array::from_fn(|axis| {
            all.iter().map(|error_m| error_m[axis]).sum::<f64>() / all.len() as f64
        })
    }
}

impl LearningErrorModel for MeanError {
    fn measured(
        &self,
        _pulls_m: &[f64],
        p_sim_m: &Point3,
        tip_m: &Point3,
    ) -> Result<(), PolicyError> {
        self.0.lock().unwrap().push(std::array::from_fn(|axis| p_sim_m[axis] - tip_m[axis]));
        Ok(())
    }

    fn restart(&self) {
        self.0.lock().unwrap().truncate(1);
    }
}

/// An error that grows with the simulated position: a fixed point that is not there after one
/// iteration.
pub(crate) struct GrowingError(pub(crate) f64);

impl ErrorModel for GrowingError {
    fn error_m(&self, _pulls_m: &[f64], p_sim_m: &Point3) -> Point3 {
        [self.0 * p_sim_m[0], self.0 * p_sim_m[1], 0.0]
    }
}

pub(crate) fn negative(shift_m: Point3) -> Point3 {
    shift_m.map(|value| -value)
}

/// Parts for a robot shifted by `shift_m`, all of them exact: for each inverse mapping of any
/// policy the one that its data lead to, and the error model.
pub(crate) fn exact_parts(shift_m: Point3) -> PolicyParts {
    let parts = told_of_model(
        PolicyParts::default().with_error(Arc::new(ConstantError(negative(shift_m)))),
    );
    inverse_mappings().into_iter().fold(parts, |parts, network| {
        let shift_m = if network.data == TrainingData::Simulated { [0.0; 3] } else { shift_m };
        parts.with_inverse(
            network,
            Box::new(AnalyticInverse { shift_m, ..AnalyticInverse::default() }),
        )
    })
}

/// What policies are told of the nominal model: the robot without a shift.
pub(crate) fn told_of_model(parts: PolicyParts) -> PolicyParts {
    let model = PlantSpec::ConstantCurvature(Box::default());
    parts.with_layout(model.tendon_layout()).with_tip_model(tip_model(&model).unwrap())
}

/// The networks of all policies that are inverse mappings.
pub(crate) fn inverse_mappings() -> Vec<&'static NetworkDescription> {
    networks().into_iter().filter(|network| network.outputs == [SampleColumns::Pulls]).collect()
}

pub(crate) fn entry(name: &str) -> &'static PolicyEntry {
    find(name).unwrap_or_else(|| panic!("no policy called {name}"))
}

pub(crate) fn policy(name: &str, parts: PolicyParts, options: &PolicyOptions) -> Box<dyn Policy> {
    build(entry(name), parts, options).unwrap()
}

pub(crate) fn robot(shift_m: Point3) -> ConstantCurvature {
    ConstantCurvature::new(ConstantCurvatureOptions {
        shift_m,
        ..ConstantCurvatureOptions::default()
    })
    .unwrap()
}

/// The tip of the robot shifted by `shift_m` under these pulls towards x and y.
pub(crate) fn reachable(pull_x_m: f64, pull_y_m: f64, shift_m: Point3) -> Point3 {
    let options = ConstantCurvatureOptions::default();
    let tip_m = ConstantCurvature::tip_m(
        &options,
        [pull_x_m / options.tendon_radius_m, pull_y_m / options.tendon_radius_m],
    );
    std::array::from_fn(|axis| tip_m[axis] + shift_m[axis])
}

pub(crate) fn seen(step: usize, tip_m: Point3) -> Observation {
    Observation {
        time_s: 0.2 * step as f64,
        tip_m,
        tip_quaternion: None,
        points: Vec::new(),
        pulls_m: vec![0.0; 4],
        tensions_n: None,
        valid: true,
    }
}
