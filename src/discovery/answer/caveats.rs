//! Caveats of an answer: what calibration changed, and which candidates were excluded.

use std::collections::BTreeSet;

use crate::data::findings::Verdict;
use crate::discovery::fit::baseline;
use crate::discovery::fit::candidate::CandidateEffect;
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::noise_floor::trial_starts;
use crate::discovery::problem::{Problem, simulate_model};
use crate::discovery::recording::samples::rms_m;
use crate::effects::Model;

/// Calibration factors above this are suspicious (docs/method/search.md, "What is uncertain of any
/// robot").
const MAX_USUAL_FACTOR: f64 = 1.3;

/// Text on the calibration.
fn calibration_caveat(factors: &baseline::CalibrationFactors, named: bool) -> String {
    let written = if named {
        "contains these values"
    } else {
        "does not contain these values, because no effect was added"
    };
    let is_large = |factor: f64| factor.max(1.0 / factor) > MAX_USUAL_FACTOR;
    let doubt = if is_large(factors.bending_stiffness) || is_large(factors.compliance) {
        " Such factors are large for a calibration: the baseline may contain an effect that the \
         model lacks."
    } else {
        ""
    };
    format!(
        "The model was calibrated on the baseline: bending stiffness times {:.4}, section \
         compliance times {:.4}. `before_m` is the error of the calibrated model; `model.yaml` \
         {written}.{doubt}",
        factors.bending_stiffness, factors.compliance
    )
}

/// A baseline residual above this size, metres, and above this multiple of the noise is suspicious.
const MAX_USUAL_BASELINE_M: f64 = 2e-3;
const MAX_USUAL_BASELINE_FLOORS: f64 = 3.0;

impl Problem<'_> {
    /// Caveats of an answer.
    pub(crate) fn caveats(&self, verdict: Verdict) -> Vec<String> {
        let calibrated = self.base.as_ref().map(|base| match base.factors {
            Some(factors) => {
                calibration_caveat(&factors, matches!(verdict, Verdict::Named | Verdict::Ambiguous))
            }
            None => {
                "Calibration does not increase the likelihood of the baseline: the model is used \
                 as given."
                    .to_owned()
            }
        });
        let base_markers = self.base_matches_model.then(|| {
            "Markers on the base show the base pose of the model: `base_tilt` was excluded from \
             the search."
                .to_owned()
        });
        let fixed: BTreeSet<&str> = self
            .candidates
            .iter()
            .filter(|one| self.is_fixed(one))
            .map(|one| one.card.name)
            .collect();
        let fixed = fixed.into_iter().filter(|_| verdict != Verdict::Consistent).map(|name| {
            format!("The model already contains `{name}`; the search cannot reduce it.")
        });
        let starts = self
            .base
            .as_ref()
            .and_then(|base| base.starts.as_ref())
            .map(trial_starts::baseline_starts_caveat);
        calibrated
            .into_iter()
            .chain(starts)
            .chain(self.baseline_caveat())
            .chain(base_markers)
            .chain(fixed)
            .collect()
    }

    /// Whether the model has the effect and no candidate reduces it.
    fn is_fixed(&self, candidate: &CandidateEffect) -> bool {
        let is_in_model =
            self.model.effects.iter().any(|effect| effect.card().name == candidate.card.name);
        is_in_model
            && candidate
                .variants()
                .first()
                .is_some_and(|nothing| candidate.is_at_range_end(nothing))
    }

    /// Caveat if `model` cannot be simulated at its own resolution.
    pub(crate) fn resolution_caveat(&self, model: &Model) -> Option<String> {
        simulate_model(model, &self.all).err().map(|_| {
            "`model.yaml` cannot be simulated with these commands at its own resolution, which \
             differs from that of the fit: use a coarser `robot.resolution` in `simulate`."
                .to_owned()
        })
    }

    /// Caveat if the calibrated model does not fit the baseline.
    fn baseline_caveat(&self) -> Option<String> {
        let base = self.base.as_ref()?;
        let residual_m = rms_m(&base.samples.residual(&base.simulated_m));
        let floor_m = NoiseFloor::from_repeats(&base.samples, 0.0).rms_m();
        (residual_m > MAX_USUAL_BASELINE_M.max(MAX_USUAL_BASELINE_FLOORS * floor_m)).then(|| {
            format!(
                "After calibration the error on the baseline is still {:.1} mm: the baseline may \
                 be of another robot, or both recordings contain an effect that the model lacks.",
                1e3 * residual_m
            )
        })
    }
}
