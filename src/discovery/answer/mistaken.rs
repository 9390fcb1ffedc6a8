//! The evidence of a recording with a mistake in it: no effect is sought and nothing is added.

use super::evidence::{Evidence, ResidualEvidence, SearchEvidence, metric};
use super::residual_map::{residual_map, residual_rows};
use super::verdict::{VerdictEvidence, decide};
use crate::data::findings::{Gap, MissingTest, Verdict};
use crate::discovery::error::DiscoveryError;
use crate::discovery::fit::ar1_noise::{Ar1Noise, MIN_SIGMA_M};
use crate::discovery::mistakes::excluded_rows::PreparedRecording;
use crate::discovery::mistakes::mislabelled::Mistake;
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::options::Options;
use crate::discovery::problem::simulate_model;
use crate::discovery::recording::covariates::sample_covariates;
use crate::discovery::recording::samples::rms_m;
use crate::discovery::recording::{holdout, validate};
use crate::effects::Model;
use crate::math::distribution::chi_squared_above;

impl Evidence {
    /// The evidence for the `mistake` in a recording of `model`.
    pub(crate) fn of_mistake(
        model: &Model,
        measured: &PreparedRecording,
        mistake: Mistake,
        options: &Options,
    ) -> Result<Evidence, DiscoveryError> {
        let PreparedRecording { original, samples, .. } = measured;
        let simulated_m = simulate_model(model, samples)?;
        let (_, held_out) = holdout::split(samples, options.held_out_share);
        let residual_m = samples.residual(&simulated_m);
        // Without repeats, what remains beside the mistake bounds the noise.
        let floor_m = NoiseFloor::from_repeats(samples, 0.0).rms_m();
        let floor_m = if floor_m.is_finite() && floor_m > 0.0 { floor_m } else { mistake.after_m };
        let sigma_m = (floor_m / 3.0_f64.sqrt()).max(MIN_SIGMA_M);
        let noise = Ar1Noise { sigma_m: [sigma_m; 3], correlation: 0.0 };
        let (covariates, points) =
            (sample_covariates(samples, &simulated_m), model.tracking.names());
        let is_held_out = |trial: usize| held_out.contains(&trial);
        let rows = residual_rows(samples, &points, [&residual_m, &residual_m], &is_held_out);
        let held_out_m: Vec<f64> =
            rows.iter().filter(|row| row.held_out).flat_map(|row| row.before_m()).collect();
        let before_m = rms_m(&held_out_m);
        // Without a fit the residual is compared with the noise alone: a χ² test.
        let squares: f64 = residual_m.iter().map(|r| (r / sigma_m).powi(2)).sum();
        let explained_share = 1.0 - (mistake.after_m / mistake.before_m).powi(2);
        let rms_m = if mistake.of_baseline { rms_m(&residual_m) } else { mistake.before_m };
        let missing = MissingTest {
            rms_m,
            foretold_m: rms_m * explained_share.max(0.0).sqrt(),
            p_value: chi_squared_above(squares, residual_m.len() as f64),
        };
        Ok(Evidence {
            decision: decide(&VerdictEvidence::Mistake),
            clock: None,
            gap: Gap {
                metric: metric(samples),
                held_out_trials: held_out
                    .iter()
                    .map(|&trial| samples.trials[trial].number)
                    .collect(),
                before_m,
                // Nothing was added to the model, so the gap stays.
                after_m: before_m,
            },
            error_name: samples.error_name(),
            left_m: (before_m.powi(2) - noise.rms_m().powi(2)).max(0.0).sqrt(),
            model_form_m: options.model_form_m,
            residuals: ResidualEvidence {
                noise,
                noise_from: "repeats before any fit".to_owned(),
                noise_is_bound: false,
                places: residual_map(&covariates, &points, &rows, &noise),
                rows,
                missing_before: missing.clone(),
                missing_after: missing,
                pattern: format!(
                    "The residual{} is consistent with this mistake: {}.",
                    mistake.in_baseline(),
                    mistake.what
                ),
            },
            limitations: validate::limitations(original, samples),
            search: SearchEvidence::default(),
            model: model.clone(),
            mistake: Some(mistake),
            possible_mistake: None,
            baseline_error: None,
        })
    }

    /// The same evidence with a mistake that explains most of the gap as well. It stands before the
    /// summary if nothing else explains the gap.
    pub(crate) fn beside(mut self, mistake: Mistake) -> Evidence {
        self.limitations.push(self.possible_sentence(&mistake));
        let is_open = self.decision.verdict == Verdict::Unexplained;
        Evidence { possible_mistake: is_open.then_some(mistake), ..self }
    }

    /// What a mistake would explain, as a sentence.
    pub(crate) fn possible_sentence(&self, mistake: &Mistake) -> String {
        format!(
            "A mistake of set-up may be the cause: if {}, the {} is {:.2} mm instead of {:.2} mm.",
            mistake.what,
            self.error_name,
            1e3 * mistake.after_m,
            1e3 * mistake.before_m
        )
    }
}

impl Mistake {
    /// Where it is, as a phrase after a noun; empty for the measured recording.
    pub(crate) fn in_baseline(&self) -> &'static str {
        if self.of_baseline { " of the baseline" } else { "" }
    }
}
