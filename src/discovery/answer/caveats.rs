//! Caveats of an answer: what calibration changed, and which candidates were excluded.

use std::collections::BTreeSet;

use super::evidence::Evidence;
use crate::data::findings::Verdict;
use crate::discovery::fit::baseline;
use crate::discovery::fit::candidate::CandidateEffect;
use crate::discovery::mistakes::mislabelled::{LARGE_SHARE, measured_motion_m};
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
            .chain(self.baseline_error().map(|error| error.sentence()))
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

    /// The error of the calibrated model on the baseline, if it is unusually large.
    pub(crate) fn baseline_error(&self) -> Option<BaselineError> {
        let base = self.base.as_ref()?;
        let error_m = rms_m(&base.samples.residual(&base.simulated_m));
        let floor_m = NoiseFloor::from_repeats(&base.samples, 0.0).rms_m();
        let motion_m = measured_motion_m(&base.samples);
        let is_unusual = error_m > MAX_USUAL_BASELINE_M.max(MAX_USUAL_BASELINE_FLOORS * floor_m);
        is_unusual.then_some(BaselineError { error_m, motion_m })
    }
}

/// An unusually large error of the calibrated model on the baseline, rms, beside the motion of the
/// tip there, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BaselineError {
    error_m: f64,
    motion_m: f64,
}

impl BaselineError {
    /// Whether it is as large as the motion itself: the model does not describe this set-up.
    pub(crate) fn is_motion(&self) -> bool {
        self.error_m >= LARGE_SHARE * self.motion_m
    }

    /// What the reader must know, as a sentence.
    pub(crate) fn sentence(&self) -> String {
        let [error_mm, motion_mm] = [self.error_m, self.motion_m].map(|size_m| 1e3 * size_m);
        let cause = if self.is_motion() {
            "the set-up of both recordings (axes, tendons, units, home, origin) or the model is \
             wrong"
        } else {
            "the baseline may be of another robot, or both recordings contain an effect that the \
             model lacks"
        };
        format!(
            "After calibration the error on the baseline is still {error_mm:.1} mm, where the tip \
             moves by {motion_mm:.0} mm (rms): {cause}."
        )
    }

    /// What to do next.
    pub(crate) fn advice(&self) -> String {
        format!(
            "Find the cause of the error of {:.1} mm on the baseline: check the set-up, and run \
             `discover` on the baseline alone.",
            1e3 * self.error_m
        )
    }
}

impl Evidence {
    /// The error on the baseline, if it must be read before the verdict: `consistent` only says
    /// that nothing has changed since, and an error as large as the motion refutes the model.
    pub(crate) fn leading_baseline_error(&self) -> Option<BaselineError> {
        let is_consistent = self.decision.verdict == Verdict::Consistent;
        self.baseline_error.filter(|error| is_consistent || error.is_motion())
    }
}
