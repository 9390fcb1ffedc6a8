//! A problem: the model, its samples, and what has been found out about them before anything is named.

use super::error::DiscoveryError;
use super::fit::candidate::{CandidateEffect, SetMember, catalogue_candidates};
use super::fit::gauss_newton::FitProblem;
use super::fit::nuisance::{NuisanceColumn, Nuisances};
use super::fit::nuisance_priors::UncertainParameters;
use super::fit::{baseline, sensitivities, simulate};
use super::noise_floor::NoiseFloor;
use super::noise_floor::trial_starts;
use super::options::Options;
use super::recording::samples::{Samples, rms_m};
use super::recording::{holdout, validate};
use crate::data::Recording;
use crate::effects::Model;

/// What an answer is sought for, and what has been found out on the way.
pub(crate) struct Problem<'a> {
    pub(crate) options: &'a Options,
    /// The model, calibrated on the baseline where there is one, simulated_m with the precision of the options.
    pub(crate) model: Model,
    /// The same, simulated_m coarsely.
    pub(crate) coarse: Model,
    pub(crate) base: Option<Baseline>,
    pub(crate) candidates: Vec<CandidateEffect>,
    /// All samples that are asked about, those of the fit, and the held_out.
    pub(crate) all: Samples,
    pub(crate) training: Samples,
    pub(crate) held_out: Samples,
    pub(crate) simulated_m: Vec<f64>,
    pub(crate) held_out_simulated_m: Vec<f64>,
    pub(crate) sensitivities: Vec<sensitivities::Sensitivity>,
    pub(crate) nuisances: Nuisances,
    /// Whether markers on the base show it standing as in the model.
    pub(crate) base_matches_model: bool,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(
        model: &Model,
        all: Samples,
        baseline: Option<&Recording>,
        options: &'a Options,
    ) -> Result<Problem<'a>, DiscoveryError> {
        let mut model = model.clone();
        let resolution = &mut model.robot.resolution;
        resolution.motion_tolerance_m = options.motion_tolerance_m;
        // Trials begin at rest, and go on from there on the grid that was asked for.
        resolution.static_tolerance_m = f64::INFINITY;
        resolution.cell_m = resolution.cell_m.max(options.cell_m);
        resolution.blended = true;
        let candidates = catalogue_candidates(&model);
        let (kept, held_out) = holdout::split(&all, options.held_out_share);
        let (training, held_out) = (all.of_trials(&kept), all.of_trials(&held_out));
        validate::check_parts(&training, &held_out)?;
        let base = match baseline {
            Some(recording) => Some(
                Baseline::new(&mut model, &candidates, recording, options)
                    .map_err(|error| DiscoveryError::Baseline(Box::new(error)))?,
            ),
            None => None,
        };
        let simulated_m = simulate_model(&model, &training)?;
        let held_out_simulated_m = simulate_model(&model, &held_out)?;
        let coarse = simulate::coarse(&model);
        let sensitivities = sensitivities::sensitivities(&coarse, &candidates, &[], &|_| true, &training);
        let columns = uncertain(options, &candidates, &[], base.as_ref()).columns(&model, &[], &training);
        let nuisances = nuisances(base.as_ref(), &training, &simulated_m, &columns);
        Ok(Problem {
            options,
            model,
            coarse,
            base,
            candidates,
            all,
            training,
            held_out,
            simulated_m,
            held_out_simulated_m,
            sensitivities,
            nuisances,
            base_matches_model: false,
        })
    }

    pub(crate) fn fit_problem(&self) -> FitProblem<'_> {
        let open = |candidate: &CandidateEffect| {
            let name = candidate.card.name;
            let contradicted = self.base_matches_model && name == "base_tilt";
            !contradicted && !self.options.left_out.iter().any(|left_out| left_out == name)
        };
        FitProblem {
            model: &self.model,
            coarse: &self.coarse,
            candidates: &self.candidates,
            open: self.candidates.iter().map(open).collect(),
            samples: &self.training,
            nuisances: &self.nuisances,
        }
    }

    /// What may differ a little from the model with the `members`, in `samples` where it has the tip at `simulated_m` without
    /// them: with much of an effect the tip answers to the rest otherwise than without.
    pub(crate) fn nuisances_with(&self, members: &[SetMember], samples: &Samples, simulated_m: &[f64]) -> Nuisances {
        let columns = self.uncertain(members).columns(&self.model, members, samples);
        nuisances(self.base.as_ref(), samples, simulated_m, &columns)
    }

    /// The numbers that are uncertain beside the `members`.
    pub(crate) fn uncertain(&self, members: &[SetMember]) -> UncertainParameters<'_> {
        uncertain(self.options, &self.candidates, members, self.base.as_ref())
    }

    /// Whether what a baseline has in common with the recording is no discovery.
    pub(crate) fn has_baseline(&self) -> bool {
        self.base.is_some()
    }

    /// Whether the model that everything is asked of was changed by the baseline.
    pub(crate) fn is_calibrated(&self) -> bool {
        self.base.as_ref().is_some_and(|base| base.factors.is_some())
    }

    /// What is left beside noise of this size, metres, matters beyond so much.
    pub(crate) fn least_relevant_m(&self, floor_m: f64) -> f64 {
        self.options.least_m(&self.model).max(self.options.least_foretold * floor_m)
    }

    /// What the laws of the effects that bring the tip to `simulated_m` are off by, at their best, metres.
    pub(crate) fn law_error_m(&self, simulated_m: &[f64]) -> f64 {
        self.options.least_share * rms_m(&self.displacement_m(simulated_m))
    }

    /// By how much effects that bring the tip to `simulated_m` move it, three numbers a sample, metres.
    pub(crate) fn displacement_m(&self, simulated_m: &[f64]) -> Vec<f64> {
        simulated_m.iter().zip(&self.simulated_m).map(|(with, without)| with - without).collect()
    }
}

/// A baseline, once the model is calibrated on it.
pub(crate) struct Baseline {
    pub(crate) samples: Samples,
    /// How its first tips scatter, where beginnings of its trials were left out for that.
    pub(crate) starts: Option<NoiseFloor>,
    pub(crate) simulated_m: Vec<f64>,
    /// What is uncertain, far wider than after a calibration.
    columns: Vec<NuisanceColumn>,
    /// What the calibration multiplied, where it made the baseline likelier.
    pub(crate) factors: Option<baseline::CalibrationFactors>,
}

/// Before a calibration a number is known this many times worse than after it.
const BEFORE_CALIBRATION: f64 = 10.0;

impl Baseline {
    fn new(
        model: &mut Model,
        candidates: &[CandidateEffect],
        recording: &Recording,
        options: &Options,
    ) -> Result<Baseline, DiscoveryError> {
        let whole = Samples::new(recording);
        validate::check(recording, &whole)?;
        let later = trial_starts::scattered_starts(&whole, model)
            .map(|starts| (trial_starts::without_starts(&whole), Some(starts)));
        let enough = |(later, _): &(Samples, _)| validate::check(recording, later).is_ok();
        let (samples, starts) = later.filter(enough).unwrap_or((whole, None));
        let look = |model: &Model| -> Result<(Vec<f64>, Vec<NuisanceColumn>), DiscoveryError> {
            let simulated_m = simulate_model(model, &samples)?;
            let uncertain = UncertainParameters::new(options, candidates, &[], BEFORE_CALIBRATION);
            let columns = uncertain.columns(model, &[], &samples);
            Ok((simulated_m, columns))
        };
        let (first, columns) = look(model)?;
        let nuisances = Nuisances::independent(first.len(), &columns);
        let left = |simulated_m: &[f64], columns: &[NuisanceColumn]| {
            Nuisances::independent(simulated_m.len(), columns)
                .explain(&samples, &samples.residual(simulated_m), 0.0)
                .deviance
        };
        if let Some((better, factors)) = baseline::calibrate(model, candidates, &samples, &nuisances) {
            let (there, wider) = look(&better)?;
            if left(&there, &wider) < left(&first, &columns) {
                *model = better;
                return Ok(Baseline { samples, starts, simulated_m: there, columns: wider, factors: Some(factors) });
            }
        }
        Ok(Baseline { samples, starts, simulated_m: first, columns, factors: None })
    }
}

/// What is uncertain beside the `members`; with a baseline as wide as it was before that, which tells how wide it is.
fn uncertain<'a>(
    options: &Options,
    candidates: &'a [CandidateEffect],
    members: &[SetMember],
    base: Option<&Baseline>,
) -> UncertainParameters<'a> {
    UncertainParameters::new(options, candidates, members, if base.is_some() { BEFORE_CALIBRATION } else { 1.0 })
}

/// What may differ a little between the model and the robot in `samples`, where the model has the tip at `simulated_m`.
fn nuisances(
    base: Option<&Baseline>,
    samples: &Samples,
    simulated_m: &[f64],
    uncertain: &[NuisanceColumn],
) -> Nuisances {
    match base {
        None => Nuisances::independent(simulated_m.len(), uncertain),
        Some(base) => baseline::calibrated_nuisances(
            (&base.samples, &base.simulated_m, &base.columns),
            (samples, simulated_m, uncertain),
        ),
    }
}

/// Where `model` has the tip in `samples`, three numbers a sample, metres.
pub(crate) fn simulate_model(model: &Model, samples: &Samples) -> Result<Vec<f64>, DiscoveryError> {
    simulate::tips(model, &[], samples).ok_or_else(|| {
        let alone = |k: usize| simulate::tips(model, &[], &samples.of_trials(&[k])).is_none();
        let first = (0..samples.trials.len()).find(|&k| alone(k)).unwrap_or(0);
        DiscoveryError::CannotFollow(samples.trials[first].number)
    })
}
