//! A question: the model, its samples, and what has been found out about them before anything is named.

use super::error::DiscoveryError;
use super::fit::candidate::{Hypothesis, Member, effects, hypotheses};
use super::fit::gauss_newton::{Fitted, Study};
use super::fit::nuisance::{Column, Explained, Nuisances};
use super::fit::nuisance_priors::Uncertain;
use super::fit::{baseline, sensitivities, simulate};
use super::goodness_of_fit::{Sign, Test};
use super::noise_floor::Floor;
use super::noise_floor::trial_starts;
use super::options::Options;
use super::recording::samples::{Samples, rms_m};
use super::recording::{holdout, validate};
use crate::data::Recording;
use crate::effects::{EffectSpec, Model};
use crate::math::distribution::f_above;

/// What an answer is sought for, and what has been found out on the way.
pub(crate) struct Question<'a> {
    pub(crate) options: &'a Options,
    /// The model, calibrated on the baseline where there is one, played with the precision of the options.
    pub(crate) model: Model,
    /// The same, played coarsely.
    pub(crate) coarse: Model,
    pub(crate) base: Option<Base>,
    pub(crate) hypotheses: Vec<Hypothesis>,
    /// All samples that are asked about, those of the fit, and the proof.
    pub(crate) all: Samples,
    pub(crate) fit: Samples,
    pub(crate) proof: Samples,
    pub(crate) played: Vec<f64>,
    pub(crate) played_proof: Vec<f64>,
    pub(crate) responses: Vec<sensitivities::Response>,
    pub(crate) nuisances: Nuisances,
    /// Whether markers on the base show it standing as in the model.
    pub(crate) base_stands: bool,
}

impl<'a> Question<'a> {
    pub(crate) fn new(
        model: &Model,
        all: Samples,
        baseline: Option<&Recording>,
        options: &'a Options,
    ) -> Result<Question<'a>, DiscoveryError> {
        let mut model = model.clone();
        let resolution = &mut model.robot.resolution;
        resolution.motion_tolerance_m = options.motion_tolerance_m;
        // Trials begin at rest, and go on from there on the grid that was asked for.
        resolution.static_tolerance_m = f64::INFINITY;
        resolution.cell_m = resolution.cell_m.max(options.cell_m);
        resolution.blended = true;
        let hypotheses = hypotheses(&model);
        let (kept, held_out) = holdout::split(&all, options.held_out_share);
        let (fit, proof) = (all.of_trials(&kept), all.of_trials(&held_out));
        validate::check_parts(&fit, &proof)?;
        let base = match baseline {
            Some(recording) => Some(
                Base::new(&mut model, &hypotheses, recording, options)
                    .map_err(|error| DiscoveryError::Baseline(Box::new(error)))?,
            ),
            None => None,
        };
        let played = played(&model, &fit)?;
        let played_proof = self::played(&model, &proof)?;
        let coarse = simulate::coarse(&model);
        let responses = sensitivities::responses(&coarse, &hypotheses, &[], &|_| true, &fit);
        let columns = uncertain(options, &hypotheses, &[], base.as_ref()).columns(&model, &[], &fit);
        let nuisances = nuisances(base.as_ref(), &fit, &played, &columns);
        Ok(Question {
            options,
            model,
            coarse,
            base,
            hypotheses,
            all,
            fit,
            proof,
            played,
            played_proof,
            responses,
            nuisances,
            base_stands: false,
        })
    }

    pub(crate) fn study(&self) -> Study<'_> {
        let open = |hypothesis: &Hypothesis| {
            let name = hypothesis.card.name;
            let contradicted = self.base_stands && name == "base_tilt";
            !contradicted && !self.options.left_out.iter().any(|left_out| left_out == name)
        };
        Study {
            model: &self.model,
            coarse: &self.coarse,
            hypotheses: &self.hypotheses,
            open: self.hypotheses.iter().map(open).collect(),
            samples: &self.fit,
            nuisances: &self.nuisances,
        }
    }

    /// What is left of the held-out trials, where the model with the `answer` has the tip at `played`: what is uncertain of
    /// any robot, and what is in common with a baseline, within what the fit leaves of it.
    pub(crate) fn held_out(&self, study: &Study, answer: &Fitted, played: &[f64]) -> Option<Explained> {
        let precision = study.nuisance_precision(answer)?;
        let beside = self.nuisances_beside(&answer.members, &self.proof, &self.played_proof);
        let amounts = &answer.explained.amounts;
        let known = effects(&self.hypotheses, &answer.members).unwrap_or_default();
        let there = |off: &[EffectSpec]| simulate::tips(&self.model, &[&known, off].concat(), &self.proof);
        let nuisances = self.uncertain(&answer.members).bent(beside, amounts, played, &there);
        let nuisances = nuisances.known(amounts.clone(), precision);
        Some(nuisances.explain(&self.proof, &self.proof.residual(played), 0.0))
    }

    /// Whether held-out trials scatter no more about `other` numbers of an answer than the trials of the fit.
    pub(crate) fn bear_out(&self, study: &Study, other: &Fitted) -> bool {
        let known = effects(&self.hypotheses, &other.members);
        let played = known.and_then(|known| simulate::tips(&self.model, &known, &self.proof));
        let unseen = played.and_then(|played| self.held_out(study, other, &played));
        unseen.is_some_and(|unseen| self.held_out_sign(other, &unseen).is_none())
    }

    /// The sign that trials that took no part scatter more about `answer` than those of its fit. `unseen`: what is left of
    /// them.
    pub(crate) fn held_out_sign(&self, answer: &Fitted, unseen: &Explained) -> Option<Sign> {
        let square_m2 = |explained: &Explained| explained.noise.rms_m().powi(2);
        let freedom = |explained: &Explained, samples: &Samples| explained.noise.freedom(samples.len());
        let (there, here) = (square_m2(unseen), square_m2(&answer.explained));
        let above = freedom(unseen, &self.proof);
        let p_value = f_above(there / here, above, freedom(&answer.explained, &self.fit));
        let least_m = self.least_left_m(here.sqrt()).max(self.inexact_m(&answer.played));
        let more_m = (there - here).max(0.0).sqrt();
        let clear = p_value < self.options.false_alarm && more_m > least_m;
        clear.then_some(Sign { test: Test::HeldOut, p_value, more_m, beyond_m: here.sqrt() })
    }

    /// What may differ a little from the model with the `members`, in `samples` where it has the tip at `played` without
    /// them: with much of an effect the tip answers to the rest otherwise than without.
    pub(crate) fn nuisances_beside(&self, members: &[Member], samples: &Samples, played: &[f64]) -> Nuisances {
        let columns = self.uncertain(members).columns(&self.model, members, samples);
        nuisances(self.base.as_ref(), samples, played, &columns)
    }

    /// The numbers that are uncertain beside the `members`.
    pub(crate) fn uncertain(&self, members: &[Member]) -> Uncertain<'_> {
        uncertain(self.options, &self.hypotheses, members, self.base.as_ref())
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
    pub(crate) fn least_left_m(&self, floor_m: f64) -> f64 {
        self.options.least_m(&self.model).max(self.options.least_foretold * floor_m)
    }

    /// What the laws of the effects that bring the tip to `played` are off by, at their best, metres.
    pub(crate) fn inexact_m(&self, played: &[f64]) -> f64 {
        self.options.least_share * rms_m(&self.moved(played))
    }

    /// By how much effects that bring the tip to `played` move it, three numbers a sample, metres.
    pub(crate) fn moved(&self, played: &[f64]) -> Vec<f64> {
        played.iter().zip(&self.played).map(|(with, without)| with - without).collect()
    }
}

/// A baseline, once the model is calibrated on it.
pub(crate) struct Base {
    pub(crate) samples: Samples,
    /// How its first tips scatter, where beginnings of its trials were left out for that.
    pub(crate) starts: Option<Floor>,
    pub(crate) played: Vec<f64>,
    /// What is uncertain, far wider than after a calibration.
    columns: Vec<Column>,
    /// What the calibration multiplied, where it made the baseline likelier.
    pub(crate) factors: Option<baseline::Factors>,
}

/// Before a calibration a number is known this many times worse than after it.
const BEFORE_CALIBRATION: f64 = 10.0;

impl Base {
    fn new(
        model: &mut Model,
        hypotheses: &[Hypothesis],
        recording: &Recording,
        options: &Options,
    ) -> Result<Base, DiscoveryError> {
        let whole = Samples::new(recording);
        validate::check(recording, &whole)?;
        let later = trial_starts::doubtful(&whole, model).map(|starts| (trial_starts::without(&whole), Some(starts)));
        let enough = |(later, _): &(Samples, _)| validate::check(recording, later).is_ok();
        let (samples, starts) = later.filter(enough).unwrap_or((whole, None));
        let look = |model: &Model| -> Result<(Vec<f64>, Vec<Column>), DiscoveryError> {
            let played = played(model, &samples)?;
            let uncertain = Uncertain::new(options, hypotheses, &[], BEFORE_CALIBRATION);
            let columns = uncertain.columns(model, &[], &samples);
            Ok((played, columns))
        };
        let (first, columns) = look(model)?;
        let nuisances = Nuisances::independent(first.len(), &columns);
        let left = |played: &[f64], columns: &[Column]| {
            Nuisances::independent(played.len(), columns).explain(&samples, &samples.residual(played), 0.0).deviance
        };
        if let Some((better, factors)) = baseline::calibrated(model, hypotheses, &samples, &nuisances) {
            let (there, wider) = look(&better)?;
            if left(&there, &wider) < left(&first, &columns) {
                *model = better;
                return Ok(Base { samples, starts, played: there, columns: wider, factors: Some(factors) });
            }
        }
        Ok(Base { samples, starts, played: first, columns, factors: None })
    }
}

/// What is uncertain beside the `members`; with a baseline as wide as it was before that, which tells how wide it is.
fn uncertain<'a>(
    options: &Options,
    hypotheses: &'a [Hypothesis],
    members: &[Member],
    base: Option<&Base>,
) -> Uncertain<'a> {
    Uncertain::new(options, hypotheses, members, if base.is_some() { BEFORE_CALIBRATION } else { 1.0 })
}

/// What may differ a little between the model and the robot in `samples`, where the model has the tip at `played`.
fn nuisances(base: Option<&Base>, samples: &Samples, played: &[f64], uncertain: &[Column]) -> Nuisances {
    match base {
        None => Nuisances::independent(played.len(), uncertain),
        Some(base) => baseline::in_common((&base.samples, &base.played, &base.columns), (samples, played, uncertain)),
    }
}

/// Where `model` has the tip in `samples`, three numbers a sample, metres.
pub(crate) fn played(model: &Model, samples: &Samples) -> Result<Vec<f64>, DiscoveryError> {
    simulate::tips(model, &[], samples).ok_or_else(|| {
        let alone = |k: usize| simulate::tips(model, &[], &samples.of_trials(&[k])).is_none();
        let first = (0..samples.trials.len()).find(|&k| alone(k)).unwrap_or(0);
        DiscoveryError::Unplayable(samples.trials[first].number)
    })
}
