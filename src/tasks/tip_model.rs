//! The model of an experiment as controllers may ask it: where the tip comes to rest.

use super::displaced_rod::DisplacedRod;
use crate::base::{
    Displacements, NoRestPose, PlantError, Point3, RestPose, Seed, TendonLayout, TipModel,
};
use crate::effects::Model;
use crate::plants::{
    ConstantCurvature, ConstantCurvatureOptions, PlantSpec, Simulated, SimulatedOptions,
    SimulatedSpec,
};
use crate::rod::Direction;

/// Whether controllers may ask this model.
pub fn has_tip_model(model: &PlantSpec) -> bool {
    matches!(model, PlantSpec::Simulated(_) | PlantSpec::ConstantCurvature(_))
}

/// The model as controllers may ask it; nothing for a plant without equations, such as a recording.
/// A robot of one segment is loaded by tensions. With several segments a tension bends all that its
/// tendon passes, and slack tendons hold none of them back: there the drives' displacements are the
/// question.
pub fn tip_model(model: &PlantSpec) -> Option<Box<dyn TipModel>> {
    match model {
        PlantSpec::Simulated(spec) if spec.model.robot.tendon_layout().segments.len() > 1 => {
            Some(Box::new(DisplacedRod::new(&at_control_accuracy(&spec.model))))
        }
        PlantSpec::Simulated(spec) => Some(Box::new(RodTip::new(spec))),
        PlantSpec::ConstantCurvature(options) => Some(Box::new(ConstantCurvatureTip(**options))),
        _ => None,
    }
}

/// Change of a tension by which the stiffness at home is measured, newtons; the rod is solved to
/// far less.
const PROBE_N: f64 = 0.01;
/// Allowed tip error of the model's grid, metres: far below what any model of a robot is good for,
/// and the rod need not refine its grid, which would take most of the tick.
const STATIC_TOLERANCE_M: f64 = 1e-4;

/// The model on a grid that is as fine as a controller needs.
fn at_control_accuracy(model: &Model) -> Model {
    let mut model = model.clone();
    let resolution = &mut model.robot.resolution;
    resolution.static_tolerance_m = resolution.static_tolerance_m.max(STATIC_TOLERANCE_M);
    model
}

/// Change of a bend for the derivative of constant curvature, metres.
const PROBE_M: f64 = 1e-6;

/// A tendon whose share of a bend is no more than this lies across it, metres.
const ACROSS_M: f64 = 1e-9;

/// The rod with the effects of its model, loaded by tensions: under them the tip moves smoothly,
/// while a displacement has no effect as long as its tendon is slack.
struct RodTip {
    plant: Simulated,
    layout: TendonLayout,
    lever_m: f64,
    /// Tension for each metre of bend, newtons; measured at home before the first question.
    stiffness_n_per_m: Option<f64>,
}

/// A load of the rod: the tension of each tendon, and its derivative with respect to each component
/// of the bend.
struct BendTensions {
    tensions_n: Vec<f64>,
    per_bend: Vec<Vec<f64>>,
}

impl RodTip {
    fn new(spec: &SimulatedSpec) -> RodTip {
        let options = SimulatedOptions { travel_m: spec.travel_m, ..SimulatedOptions::default() };
        let plant = Simulated::new(&at_control_accuracy(&spec.model), &[], options);
        let robot = &spec.model.robot;
        RodTip {
            plant,
            layout: robot.tendon_layout(),
            lever_m: robot.lever_m(),
            stiffness_n_per_m: None,
        }
    }

    fn load(&self, bend_m: &[f64], stiffness_n_per_m: f64) -> BendTensions {
        let tendons = self.layout.segments.iter().map(Vec::len).sum();
        let mut load = BendTensions {
            tensions_n: vec![0.0; tendons],
            per_bend: vec![vec![0.0; tendons]; bend_m.len()],
        };
        for (segment, tendons) in self.layout.segments.iter().enumerate() {
            for placed in tendons {
                let (sin, cos) = placed.angle_deg.to_radians().sin_cos();
                let along_m = cos * bend_m[2 * segment] + sin * bend_m[2 * segment + 1];
                // Across the bend a tendon is loaded on one side of zero: the derivative is the
                // mean of both sides.
                let share = if along_m.abs() <= ACROSS_M {
                    0.5
                } else {
                    f64::from(u8::from(along_m > 0.0))
                };
                load.tensions_n[placed.tendon] += stiffness_n_per_m * along_m.max(0.0);
                load.per_bend[2 * segment][placed.tendon] = share * stiffness_n_per_m * cos;
                load.per_bend[2 * segment + 1][placed.tendon] = share * stiffness_n_per_m * sin;
            }
        }
        load
    }

    fn settle(&mut self, tensions_n: &[f64]) -> Result<(Displacements, Point3), PlantError> {
        let observation = self.plant.apply_tensions(tensions_n, true)?;
        Ok((observation.pulls_m, observation.tip_m))
    }

    /// The tension that displaces the first tendon by a metre, as it is at home.
    fn stiffness_n_per_m(&mut self) -> Result<f64, PlantError> {
        if let Some(measured) = self.stiffness_n_per_m {
            return Ok(measured);
        }
        self.restart();
        // At home all tensions are zero, whatever the stiffness: 1 is a placeholder.
        let mut tensions_n = self.load(&vec![0.0; self.bends()], 1.0).tensions_n;
        let (before_m, _) = self.settle(&tensions_n)?;
        tensions_n[0] += PROBE_N;
        let (after_m, _) = self.settle(&tensions_n)?;
        // One stiffness for all tendons makes a bend in metres comparable with displacements.
        let stiffness = PROBE_N / (after_m[0] - before_m[0]);
        if !(stiffness.is_finite() && stiffness > 0.0) {
            return Err(PlantError::Solver(
                "the tension of a tendon does not displace it".to_owned(),
            ));
        }
        self.stiffness_n_per_m = Some(stiffness);
        Ok(stiffness)
    }

    fn pose(&mut self, bend_m: &[f64]) -> Result<RestPose, PlantError> {
        let stiffness = self.stiffness_n_per_m()?;
        let (pulls_m, tip_m) = self.settle(&self.load(bend_m, stiffness).tensions_n)?;
        Ok(RestPose { pulls_m, tip_m })
    }

    fn rates(&mut self, bend_m: &[f64]) -> Result<Vec<Point3>, PlantError> {
        let stiffness = self.stiffness_n_per_m()?;
        let BendTensions { tensions_n, per_bend } = self.load(bend_m, stiffness);
        self.settle(&tensions_n)?;
        let directions: Vec<Direction> = (0..tensions_n.len()).map(Direction::Tension).collect();
        // The derivative is taken on a copy: the plant hands its rod out to be read.
        let rates = self.plant.rod().clone().tip_jacobian(&directions);
        let rates = rates
            .ok_or_else(|| PlantError::Solver("the tangent at rest is singular".to_owned()))?;
        let tip_rate = |per_bend: &Vec<f64>| {
            let parts = rates.iter().zip(per_bend).map(|(rate, share)| rate.position_m * *share);
            // Chain rule: tip per tension times tension per bend.
            parts.sum::<nalgebra::Vector3<f64>>().into()
        };
        Ok(per_bend.iter().map(tip_rate).collect())
    }

    /// The answer, or the reason; what a failed solve leaves behind is no start for the next.
    fn answer<T>(&mut self, result: Result<T, PlantError>) -> Result<T, NoRestPose> {
        if result.is_err() {
            self.restart();
        }
        result.map_err(|error| NoRestPose(error.to_string()))
    }
}

impl TipModel for RodTip {
    fn bends(&self) -> usize {
        2 * self.layout.segments.len()
    }

    fn lever_m(&self) -> f64 {
        self.lever_m
    }

    fn restart(&mut self) {
        self.plant.reset_slack(Seed(0));
    }

    fn at_rest(&mut self, bend_m: &[f64]) -> Result<RestPose, NoRestPose> {
        let pose = self.pose(bend_m);
        self.answer(pose)
    }

    fn tip_per_bend(&mut self, bend_m: &[f64]) -> Result<Vec<Point3>, NoRestPose> {
        let rates = self.rates(bend_m);
        self.answer(rates)
    }
}

/// The robot of constant curvature. Its tendons have no tension, and none is ever slack.
struct ConstantCurvatureTip(ConstantCurvatureOptions);

impl ConstantCurvatureTip {
    fn tip_m(&self, bend_m: [f64; 2]) -> Point3 {
        let tip_m =
            ConstantCurvature::tip_m(&self.0, bend_m.map(|pull_m| pull_m / self.0.tendon_radius_m));
        std::array::from_fn(|axis| tip_m[axis] + self.0.shift_m[axis])
    }
}

impl TipModel for ConstantCurvatureTip {
    fn bends(&self) -> usize {
        2
    }

    fn lever_m(&self) -> f64 {
        self.0.tendon_radius_m
    }

    fn at_rest(&mut self, bend_m: &[f64]) -> Result<RestPose, NoRestPose> {
        let [a, b] = two(bend_m)?;
        Ok(RestPose { pulls_m: vec![a, b, -a, -b], tip_m: self.tip_m([a, b]) })
    }

    fn tip_per_bend(&mut self, bend_m: &[f64]) -> Result<Vec<Point3>, NoRestPose> {
        let [a, b] = two(bend_m)?;
        let rate = |da: f64, db: f64| {
            let (ahead_m, behind_m) = (self.tip_m([a + da, b + db]), self.tip_m([a - da, b - db]));
            std::array::from_fn(|axis| (ahead_m[axis] - behind_m[axis]) / (2.0 * PROBE_M))
        };
        Ok(vec![rate(PROBE_M, 0.0), rate(0.0, PROBE_M)])
    }
}

fn two(bend_m: &[f64]) -> Result<[f64; 2], NoRestPose> {
    bend_m
        .try_into()
        .map_err(|_| NoRestPose(format!("a bend of {} components, expected 2", bend_m.len())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::distance_m;
    use crate::base::{Plant, TendonCommand};
    use crate::plants::PlantOptions;

    fn example() -> Box<SimulatedSpec> {
        Box::new(SimulatedSpec::example().unwrap())
    }

    /// The derivatives are those of the poses.
    fn assert_rates(model: &mut dyn TipModel, bend_m: [f64; 2]) {
        let pose = model.at_rest(&bend_m).unwrap();
        let rates = model.tip_per_bend(&bend_m).unwrap();
        for component in 0..2 {
            let change_m = 1e-4_f64.copysign(bend_m[component]);
            let mut ahead_m = bend_m;
            ahead_m[component] += change_m;
            let ahead = model.at_rest(&ahead_m).unwrap();
            let tip: Point3 =
                std::array::from_fn(|axis| (ahead.tip_m[axis] - pose.tip_m[axis]) / change_m);
            assert!(
                distance_m(&rates[component], &tip) < 0.1,
                "{bend_m:?} {component}: {rates:?}, {tip:?}"
            );
        }
    }

    #[test]
    fn derivatives_are_those_of_the_poses() {
        for model in [PlantSpec::Simulated(example()), PlantSpec::ConstantCurvature(Box::default())]
        {
            let mut model = tip_model(&model).unwrap();
            for bend_m in [[0.01, 0.005], [-0.02, 0.001], [0.001, -0.015], [-0.005, -0.02]] {
                assert_rates(model.as_mut(), bend_m);
            }
        }
    }

    #[test]
    fn the_displacements_of_a_pose_bring_the_robot_there() {
        let spec = example();
        let mut model = tip_model(&PlantSpec::Simulated(spec.clone())).unwrap();
        let mut robot = Simulated::new(&spec.model, &[], SimulatedOptions::default());
        for bend_m in [[0.012, -0.004], [-0.01, 0.0], [0.003, 0.015]] {
            let pose = model.at_rest(&bend_m).unwrap();
            robot.reset(Seed(1)).unwrap();
            let pulls: Vec<TendonCommand> =
                pose.pulls_m.iter().map(|&pull_m| TendonCommand::Pull(pull_m)).collect();
            let seen = robot.settle(&pulls).unwrap();
            assert!(distance_m(&seen.tip_m, &pose.tip_m) < 1e-5, "{bend_m:?}: {seen:?}, {pose:?}");
        }
    }
}
