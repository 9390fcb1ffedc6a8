//! Model and robot side by side.

use crate::data::tables::{SIGNIFICANT_DIGITS, round_significant};
use crate::rows::experiment::GapSample;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::tasks::Transitions;

/// A number of samples spread over the exploration.
pub(crate) const GAP: Stage<usize, (Handle<Transitions>, Handle<Transitions>), Vec<GapSample>> =
    Stage {
        kind: StageKind { name: "gap", module: module_path!(), cost_ms: 20 },
        job: |&rows, (model, robot)| {
            let rows = rows.min(model.len());
            Ok((0..rows).map(|row| gap_sample(model, robot, row * model.len() / rows)).collect())
        },
    };

fn gap_sample(model: &Transitions, robot: &Transitions, sample: usize) -> GapSample {
    let (pulls, sim, real) =
        (model.pulls_m.row(sample), model.to_m.row(sample), robot.to_m.row(sample));
    let tendon = |index: usize| pulls.get(index).copied().unwrap_or(f64::NAN);
    let further_tendons: Vec<String> = pulls
        .iter()
        .skip(4)
        .map(|&pull_m| round_significant(pull_m, SIGNIFICANT_DIGITS).to_string())
        .collect();
    GapSample {
        sample: sample as u64,
        tendon_1_m: tendon(0),
        tendon_2_m: tendon(1),
        tendon_3_m: tendon(2),
        tendon_4_m: tendon(3),
        further_tendons_m: further_tendons.join(" "),
        sim_x_m: sim[0],
        sim_y_m: sim[1],
        sim_z_m: sim[2],
        real_x_m: real[0],
        real_y_m: real[1],
        real_z_m: real[2],
    }
}
