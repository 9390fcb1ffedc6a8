//! The answer to a recording with a mistake in it: nothing is sought and nothing is added.

use super::Discovery;
use super::alternatives::Alternatives;
use super::residual_map;
use super::residual_rows::residual_rows;
use crate::data::Recording;
use crate::data::findings::{Findings, Gap, MissingTest, Noise, Verdict};
use crate::discovery::fit::ar1_noise::{Ar1Noise, LEAST_SIGMA_M};
use crate::discovery::mistakes::mislabelled::Mistake;
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::options::Options;
use crate::discovery::recording::covariates::sample_covariates;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::discovery::recording::{holdout, validate};
use crate::effects::Model;
use crate::math::distribution::chi_squared_above;

/// The answer `mistake` to `measured`, whose `samples` the `model` predicts at `simulated_m` (three values each, metres).
pub(crate) fn mistaken(
    model: &Model,
    measured: &Recording,
    (samples, simulated_m): (&Samples, &[f64]),
    mistake: &Mistake,
    options: &Options,
) -> Discovery {
    let (_, held_out) = holdout::split(samples, options.held_out_share);
    let residual_m = samples.residual(simulated_m);
    let floor_m = NoiseFloor::from_repeats(samples, 0.0).rms_m();
    let floor_m = if floor_m.is_finite() && floor_m > 0.0 { floor_m } else { mistake.after_m };
    let sigma_m = [(floor_m / 3.0_f64.sqrt()).max(LEAST_SIGMA_M); 3];
    let noise = Ar1Noise { sigma_m, correlation: 0.0 };
    let (covariates, points) = (sample_covariates(samples, simulated_m), model.tracking.names());
    let places = residual_map::residual_map((&covariates, &points), &residual_m, &residual_m, &noise);
    let is_held_out = |trial: usize| held_out.contains(&trial);
    let residuals = residual_rows(samples, &points, [&residual_m, &residual_m], &is_held_out);
    let unseen = residuals.iter().filter(|row| row.held_out);
    let before_m =
        rms_m(&unseen.flat_map(|row| [row.before_x_m, row.before_y_m, row.before_z_m]).collect::<Vec<f64>>());
    let squares: f64 = residual_m.iter().map(|r| (r / sigma_m[0]).powi(2)).sum();
    let missing = MissingTest {
        rms_m: mistake.before_m,
        foretold_m: (mistake.before_m.powi(2) - mistake.after_m.powi(2)).max(0.0).sqrt(),
        p_value: chi_squared_above(squares, residual_m.len() as f64),
    };
    let what = &mistake.what;
    let findings = Findings {
        verdict: Verdict::Unexplained,
        effects: Vec::new(),
        noise_floor_m: noise.rms_m(),
        explained_share: None,
        explained_share_interval_95: None,
        left_m: (before_m.powi(2) - noise.rms_m().powi(2)).max(0.0).sqrt(),
        complete: false,
        model_form_m: options.model_form_m,
        gap: Gap {
            metric: format!("{} on held-out trials", samples.error_name()),
            held_out_trials: held_out.iter().map(|&trial| samples.trials[trial].number).collect(),
            before_m,
            after_m: before_m,
        },
        disagreement: residual_map::disagreements(&places),
        candidates: Vec::new(),
        next_measurement: format!("Correct the recording or its set-up ({what}), then run `discover` again."),
        summary: summary(mistake, samples.error_name()),
        noise: Noise { sigma_m, correlation: 0.0, from: "repeats before any fit".to_owned() },
        missing_before: missing.clone(),
        missing_after: missing,
        pattern: format!("The residual is what it would be if {what}."),
        limitations: validate::limitations(measured, samples),
        excluded_rows: Vec::new(),
        clock_offset_s: None,
        clock_offset_interval_95: None,
        proposals: Vec::new(),
    };
    let alternatives = Alternatives::default();
    let (model, next_experiments, calibrated) = (model.clone(), Vec::new(), false);
    Discovery { findings, model, residuals, places, alternatives, next_experiments, calibrated }
}

fn summary(mistake: &Mistake, error: &str) -> String {
    let (before_mm, after_mm, what) = (1e3 * mistake.before_m, 1e3 * mistake.after_m, &mistake.what);
    format!(
        "This is a mistake of recording or set-up rather than physics: if {what}, the {error} is {after_mm:.2} mm \
         instead of {before_mm:.2} mm. No effect was sought and nothing was added to the model."
    )
}
