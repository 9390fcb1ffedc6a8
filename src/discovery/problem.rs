//! The discovery problem: the model, its samples, its candidates and its nuisance parameters.

use super::error::DiscoveryError;
use super::fit::baseline::SimulatedRecording;
use super::fit::candidate::{CandidateEffect, SetMember, catalogue_candidates};
use super::fit::gauss_newton::FitProblem;
use super::fit::nuisance::{NuisanceColumn, Nuisances};
use super::fit::nuisance_priors::UncertainParameters;
use super::fit::obstacle_hint::obstacle_hint;
use super::fit::{baseline, sensitivities, simulate};
use super::mistakes::excluded_rows::PreparedRecording;
use super::noise_floor::NoiseFloor;
use super::noise_floor::model_form::ModelForm;
use super::noise_floor::trial_starts;
use super::options::{Options, SearchLimits};
use super::recording::samples::{Samples, rms_m};
use super::recording::{holdout, validate};
use crate::effects::Model;

/// The problem that a discovery solves.
pub(crate) struct Problem<'a> {
    pub(crate) options: &'a Options,
    /// The model as given.
    pub(crate) given_model: &'a Model,
    /// The model, calibrated on the baseline if there is one, with the resolution of the options.
    pub(crate) model: Model,
    /// The same model at a coarse resolution.
    pub(crate) coarse: Model,
    pub(crate) base: Option<Baseline>,
    pub(crate) candidates: Vec<CandidateEffect>,
    /// All samples, the training samples and the held-out samples.
    pub(crate) all: Samples,
    pub(crate) training: Samples,
    pub(crate) held_out: Samples,
    pub(crate) simulated_m: Vec<f64>,
    pub(crate) held_out_simulated_m: Vec<f64>,
    pub(crate) sensitivities: Vec<sensitivities::Sensitivity>,
    pub(crate) nuisances: Nuisances,
    /// Whether markers on the base show the base pose of the model.
    pub(crate) base_matches_model: bool,
    /// What the model leaves on this robot beyond noise although nothing is missing, rms, metres.
    pub(crate) model_form_m: f64,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(
        given_model: &'a Model,
        all: Samples,
        baseline: Option<&PreparedRecording>,
        options: &'a Options,
    ) -> Result<Problem<'a>, DiscoveryError> {
        // The order below matters: trials are put aside before anything is fitted.
        let mut model = simulate::search_resolution(given_model, options);
        let mut candidates = catalogue_candidates(&model);
        candidates.iter_mut().for_each(|candidate| candidate.resolve_times(all.tracked_step_s));
        let (trained, held_out) = holdout::split(&all, options.held_out_share);
        let (training, held_out) = (all.of_trials(&trained), all.of_trials(&held_out));
        validate::check_parts(&training, &held_out)?;
        // The baseline calibrates `model`, so all that is simulated comes after it.
        let base = match baseline {
            Some(recording) => Some(
                Baseline::new(&mut model, &candidates, recording, options, all.clock_deviation_s)
                    .map_err(|error| DiscoveryError::Baseline(Box::new(error)))?,
            ),
            None => None,
        };
        let simulated_m = simulate_model(&model, &training)?;
        let held_out_simulated_m = simulate_model(&model, &held_out)?;
        let coarse = simulate::coarse(&model);
        // No small amount of contact leads to an obstacle, so the residual must point to one.
        let rows = simulate::body_rows(&coarse, &training, &training.residual(&simulated_m));
        if let Some(hint) =
            rows.and_then(|rows| obstacle_hint(&rows, model.robot.backbone.length_m))
        {
            candidates.iter_mut().for_each(|candidate| candidate.start_at(&hint));
        }
        let sensitivities =
            sensitivities::sensitivities(&coarse, &candidates, &[], &|_| true, &training);
        let columns =
            uncertain(options, &candidates, &[], base.as_ref()).columns(&model, &[], &training);
        let nuisances = nuisances(base.as_ref(), &training, &simulated_m, &columns);
        let model_form_m = base.as_ref().map_or(options.model_form_m, |base| base.form.worst_m);
        Ok(Problem {
            options,
            given_model,
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
            model_form_m,
        })
    }

    pub(crate) fn fit_problem(&self) -> FitProblem<'_> {
        // Candidates that the user excludes, that cannot be seen here, or that nothing leads to are
        // closed.
        let open = |candidate: &CandidateEffect| {
            let name = candidate.card.name;
            let contradicted = self.base_matches_model && name == "base_tilt";
            let needs_time = self.all.at_rest() && ONLY_IN_MOTION.contains(&name);
            candidate.has_start()
                && !contradicted
                && !needs_time
                && !self.options.left_out.iter().any(|left_out| left_out == name)
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

    /// Nuisance parameters in `samples` given the `members`; `simulated_m` is the tip without them.
    /// A strong effect changes the sensitivities of the others.
    pub(crate) fn nuisances_with(
        &self,
        members: &[SetMember],
        samples: &Samples,
        simulated_m: &[f64],
    ) -> Nuisances {
        let columns = self.uncertain(members).columns(&self.model, members, samples);
        nuisances(self.base.as_ref(), samples, simulated_m, &columns)
    }

    /// The uncertain parameters given the `members`.
    pub(crate) fn uncertain(&self, members: &[SetMember]) -> UncertainParameters<'_> {
        uncertain(self.options, &self.candidates, members, self.base.as_ref())
    }

    /// Limits of the search on this robot.
    pub(crate) fn limits(&self) -> SearchLimits {
        self.options.limits(&self.model, self.model_form_m)
    }

    /// Residual, metres, below which nothing is missing whatever the noise: a share of the robot's
    /// length, or what the model leaves on this robot anyway.
    pub(crate) fn model_error_m(&self) -> f64 {
        self.options.least_m(&self.model).max(self.options.form_margin * self.model_form_m)
    }

    /// Smallest relevant residual, metres, given a noise floor of `floor_m`.
    pub(crate) fn least_relevant_m(&self, floor_m: f64) -> f64 {
        self.model_error_m().max(self.options.least_foretold * floor_m)
    }

    /// Model error that is expected of the laws of the effects that move the tip to `simulated_m`,
    /// metres.
    pub(crate) fn law_error_m(&self, simulated_m: &[f64]) -> f64 {
        self.options.least_share * rms_m(&self.displacement_m(simulated_m))
    }

    /// Tip displacement by effects that move the tip to `simulated_m`, three values a sample,
    /// metres.
    pub(crate) fn displacement_m(&self, simulated_m: &[f64]) -> Vec<f64> {
        simulated_m.iter().zip(&self.simulated_m).map(|(with, without)| with - without).collect()
    }
}

/// Effects that poses at rest do not show.
const ONLY_IN_MOTION: [&str; 4] = ["creep", "damping", "delay", "servo_lag"];

/// The baseline, after the model was calibrated on it.
pub(crate) struct Baseline {
    pub(crate) samples: Samples,
    /// Scatter of its first tip positions, if trial starts were excluded because of it.
    pub(crate) starts: Option<NoiseFloor>,
    pub(crate) simulated_m: Vec<f64>,
    /// Uncertain parameters, with the uncertainty before calibration.
    columns: Vec<NuisanceColumn>,
    /// What the calibrated model leaves.
    pub(crate) form: ModelForm,
    /// Calibration factors, if calibration increased the likelihood of the baseline.
    pub(crate) factors: Option<baseline::CalibrationFactors>,
}

/// Uncertainty before calibration over that after it (docs/method/search.md, "What is uncertain of any
/// robot").
const BEFORE_CALIBRATION: f64 = 10.0;

/// A model beside the baseline, calibrated or not.
struct SimulatedBaseline {
    simulated_m: Vec<f64>,
    columns: Vec<NuisanceColumn>,
}

impl SimulatedBaseline {
    fn deviance(&self, samples: &Samples) -> f64 {
        let nuisances = Nuisances::independent(self.simulated_m.len(), &self.columns);
        nuisances.explain(samples, &samples.residual(&self.simulated_m), 0.0).deviance
    }
}

impl Baseline {
    fn new(
        model: &mut Model,
        candidates: &[CandidateEffect],
        recording: &PreparedRecording,
        options: &Options,
        clock_deviation_s: Option<f64>,
    ) -> Result<Baseline, DiscoveryError> {
        // Both recordings have the same uncertain numbers; the baseline does not tell the clock of
        // the other.
        let whole = Samples { clock_deviation_s, ..recording.samples.clone() };
        validate::check(&recording.kept, &whole)?;
        // Trials that do not start settled at home lose their first second, if enough remains.
        let scattered = trial_starts::scattered_starts(&whole, model);
        let later = scattered.map(|starts| (trial_starts::without_starts(&whole), Some(starts)));
        let is_enough = |(later, _): &(Samples, _)| validate::check(&recording.kept, later).is_ok();
        let (samples, starts) = later.filter(is_enough).unwrap_or((whole, None));
        let simulate = |model: &Model| -> Result<SimulatedBaseline, DiscoveryError> {
            let simulated_m = simulate_model(model, &samples)?;
            let uncertain = UncertainParameters::new(options, candidates, &[], BEFORE_CALIBRATION);
            let columns = uncertain.columns(model, &[], &samples);
            Ok(SimulatedBaseline { simulated_m, columns })
        };
        let mut simulated = simulate(model)?;
        let mut factors = None;
        let nuisances = Nuisances::independent(simulated.simulated_m.len(), &simulated.columns);
        if let Some((calibrated, new_factors)) =
            baseline::calibrate(model, candidates, &samples, &nuisances)
        {
            // A calibration that does not make the baseline likelier is dropped.
            let there = simulate(&calibrated)?;
            if there.deviance(&samples) < simulated.deviance(&samples) {
                *model = calibrated;
                (simulated, factors) = (there, Some(new_factors));
            }
        }
        let SimulatedBaseline { simulated_m, columns } = simulated;
        let nuisances = baseline::baseline_nuisances(SimulatedRecording {
            samples: &samples,
            simulated_m: &simulated_m,
            columns: &columns,
        });
        let form = ModelForm::new(&samples, &simulated_m, &nuisances);
        Ok(Baseline { samples, starts, simulated_m, columns, form, factors })
    }
}

/// Uncertain parameters given the `members`. With a baseline they have the uncertainty before
/// calibration, which the baseline then reduces.
fn uncertain<'a>(
    options: &Options,
    candidates: &'a [CandidateEffect],
    members: &[SetMember],
    base: Option<&Baseline>,
) -> UncertainParameters<'a> {
    UncertainParameters::new(
        options,
        candidates,
        members,
        if base.is_some() { BEFORE_CALIBRATION } else { 1.0 },
    )
}

/// Nuisance parameters in `samples`; `simulated_m` is the simulated tip.
fn nuisances(
    base: Option<&Baseline>,
    samples: &Samples,
    simulated_m: &[f64],
    uncertain: &[NuisanceColumn],
) -> Nuisances {
    match base {
        None => Nuisances::independent(simulated_m.len(), uncertain),
        Some(base) => baseline::calibrated_nuisances(
            SimulatedRecording {
                samples: &base.samples,
                simulated_m: &base.simulated_m,
                columns: &base.columns,
            },
            SimulatedRecording { samples, simulated_m, columns: uncertain },
        ),
    }
}

/// Simulated tip of `model` in `samples`, three values a sample, metres.
pub(crate) fn simulate_model(model: &Model, samples: &Samples) -> Result<Vec<f64>, DiscoveryError> {
    simulate::tips(model, &[], samples).ok_or_else(|| {
        let alone = |k: usize| simulate::tips(model, &[], &samples.of_trials(&[k])).is_none();
        let first = (0..samples.trials.len()).find(|&k| alone(k)).unwrap_or(0);
        DiscoveryError::CannotFollow(samples.trials[first].number)
    })
}
