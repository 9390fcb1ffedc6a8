//! What a control tick costs: `cargo bench --bench control` prints the median, the 99th percentile
//! and the largest time that each policy without networks takes to decide, on the reference robot
//! and targets all over its workspace.

use std::sync::Arc;
use std::time::Instant;

use spinebench::base::Seed;
use spinebench::learn::gp::{Gp, GpConfig};
use spinebench::learn::selection::Selection;
use spinebench::plants::PlantSpec;
use spinebench::policies::{self, GpError, PolicyOptions, PolicyParts};
use spinebench::specs::Experiment;
use spinebench::tasks::{GpPointsOptions, gp_points, tip_model};

const TICKS: usize = 40;

fn error_model(model: &PlantSpec, robot: &PlantSpec) -> GpError {
    let (mut model, mut robot) = (model.build(0.2).unwrap(), robot.build(0.2).unwrap());
    let pool =
        gp_points(model.as_mut(), robot.as_mut(), &GpPointsOptions::default(), Seed(1)).unwrap();
    let points = pool.points();
    let chosen = points.select(&Selection::Clusters.choose(&points.inputs, 100, Seed(1)).unwrap());
    let gp = Gp::fit(&chosen.inputs, &chosen.errors_m, &GpConfig::default()).unwrap();
    GpError::new(gp, 4).unwrap()
}

fn main() {
    let file =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/controllers.yaml");
    let experiment = Experiment::read(&file, &[]).unwrap();
    let (model, robot) = (&experiment.model, &experiment.plant);
    let error = Arc::new(error_model(model, robot));
    for name in ["integral", "online_jacobian", "model_integral", "mpc"] {
        let parts =
            PolicyParts::default().with_error(error.clone()).with_layout(model.tendon_layout());
        let parts = parts.with_tip_model(tip_model(model).unwrap());
        let mut policy =
            policies::build(policies::find(name).unwrap(), parts, &PolicyOptions::default())
                .unwrap();
        let mut plant = robot.build(0.2).unwrap();
        let mut times_ms = Vec::new();
        for target in 0..25 {
            let (sin, cos) = (2.4 * f64::from(target)).sin_cos();
            let across_m = 0.018 * f64::from(target).sqrt();
            let target_m = [across_m * cos, across_m * sin, 0.21 - 2.0 * across_m * across_m];
            policy.reset();
            let mut seen = plant.reset(Seed(target as u64)).unwrap();
            for _ in 0..TICKS {
                let start = Instant::now();
                let action = policy.act(&seen, &target_m).unwrap();
                times_ms.push(1e3 * start.elapsed().as_secs_f64());
                seen = plant.step(&action.pulls_m).unwrap();
            }
        }
        times_ms.sort_by(f64::total_cmp);
        let at = |share: f64| times_ms[((times_ms.len() - 1) as f64 * share) as usize];
        println!(
            "{name}: median {:.3} ms, p99 {:.3} ms, largest {:.3} ms",
            at(0.5),
            at(0.99),
            at(1.0)
        );
    }
}
