//! Uncertain parameters of the robot as nuisance parameters: their sensitivities within the
//! uncertainty, and the nonlinear remainder at estimated values.

use nalgebra::DVector;
use rayon::prelude::*;

use crate::base::counted;

use super::candidate::{CandidateEffect, SetMember, effect_specs};
use super::nuisance::{NuisanceColumn, Nuisances};
use super::simulate::{coarse, tips};
use crate::discovery::options::Options;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::effects::{EffectSpec, Model};

/// The uncertain parameters given some effects.
pub(crate) struct UncertainParameters<'a> {
    candidates: &'a [CandidateEffect],
    parameters: Vec<UncertainParameter>,
    /// Accuracy of simulations, metres.
    exact_m: f64,
}

/// One uncertain parameter: a size of a candidate about its null value.
struct UncertainParameter {
    candidate: usize,
    null: Vec<f64>,
    size: usize,
    deviation: f64,
    /// Whether a member replaces it, so that it has no influence.
    replaced: bool,
}

/// Largest assumed deviation in standard deviations. Sensitivities are differences between both
/// ends of this range: at the usual size of an effect the response can differ (reduced damping
/// oscillates, strong damping does not).
const MAX_DEVIATIONS: f64 = 3.0;

/// Prior deviation of the share of the relaxation under the robot's own weight that is outstanding
/// at the start of trials: from none (at rest for good) to all of it (straight a moment ago).
const UNRELAXED_DEVIATION: f64 = 0.5;

/// Minimum difference step over the usual size, so that time-stepping errors do not dominate.
const MIN_STEP_SHARE: f64 = 0.25;

impl<'a> UncertainParameters<'a> {
    /// The uncertain parameters given the `members`, with `times` the deviation of the options.
    /// Their number does not depend on the members, since a baseline describes all of them.
    pub(crate) fn new(
        options: &Options,
        candidates: &'a [CandidateEffect],
        members: &[SetMember],
        times: f64,
    ) -> UncertainParameters<'a> {
        let replaced = |candidate: &CandidateEffect| {
            let is_same =
                |member: &SetMember| candidates[member.candidate].card.name == candidate.card.name;
            candidate.replaces() && members.iter().any(is_same)
        };
        let mut parameters = Vec::new();
        for one in &options.uncertain {
            let about = candidates
                .iter()
                .enumerate()
                .filter(|(_, candidate)| candidate.card.name == one.effect);
            for (number, candidate) in about {
                for null in candidate.variants() {
                    let is_named =
                        |size: &usize| candidate.card.parameters[*size].vector() == one.parameter;
                    parameters.extend(candidate.sizes().into_iter().filter(is_named).map(|size| {
                        UncertainParameter {
                            candidate: number,
                            null: null.clone(),
                            size,
                            deviation: times * one.deviation,
                            replaced: replaced(candidate),
                        }
                    }));
                }
            }
        }
        UncertainParameters { candidates, parameters, exact_m: options.motion_tolerance_m }
    }

    /// Place of the unrelaxed share at the start of trials among the columns.
    pub(crate) fn unrelaxed_column(&self) -> usize {
        self.parameters.len()
    }

    /// Place of the tracker's clock among the columns, where it is uncertain.
    pub(crate) fn clock_column(&self) -> usize {
        self.parameters.len() + 1
    }

    /// Sensitivities of `model` with the `members` to each parameter, with its standard deviation,
    /// to the share that is unrelaxed at the start of trials, and at last to the tracker's clock
    /// where that is uncertain. Taken without the members if
    /// they cannot be simulated; zero if nothing can be simulated.
    pub(crate) fn columns(
        &self,
        model: &Model,
        members: &[SetMember],
        samples: &Samples,
    ) -> Vec<NuisanceColumn> {
        // A derivative within a prior need not be sharper than the prior: the coarse model is two
        // to three times faster, and these are most simulations of a robot with many tendons.
        let model = &coarse(model);
        let beside = |members: &[SetMember]| -> Vec<Option<Vec<f64>>> {
            let effects = effect_specs(self.candidates, members);
            let base_m = effects.as_ref().and_then(|effects| tips(model, effects, samples));
            let (Some(effects), Some(base_m)) = (effects, base_m) else {
                return vec![None; self.parameters.len() + 1];
            };
            let sensitivity_of = |number: &UncertainParameter| {
                self.sensitivity(number, model, &effects, samples, &base_m)
            };
            let unrelaxed = || unrelaxed(model, &effects, samples, &base_m);
            let of_parameters = self.parameters.par_iter().map(counted(sensitivity_of));
            of_parameters.chain(rayon::iter::once(()).map(|()| unrelaxed())).collect()
        };
        // A strong effect changes these answers, so they are taken beside the members.
        let mut sensitivities = beside(members);
        if !members.is_empty() && sensitivities.iter().any(Option::is_none) {
            sensitivities =
                // A combination that cannot be played falls back to the model alone.
                sensitivities.into_iter().zip(beside(&[])).map(|(with, without)| with.or(without)).collect();
        }
        let zero = || vec![0.0; 3 * samples.len()];
        let deviations = self.parameters.iter().map(|number| number.deviation);
        let each = sensitivities.into_iter().zip(deviations.chain([UNRELAXED_DEVIATION]));
        let columns = each
            .map(|(sensitivity_of, deviation)| (sensitivity_of.unwrap_or_else(zero), deviation));
        let clock =
            samples.clock_deviation_s.map(|deviation_s| (samples.velocity_m_s(), deviation_s));
        columns.chain(clock).collect()
    }

    /// Sensitivity to one parameter by a central difference, as far as it can be simulated.
    fn sensitivity(
        &self,
        number: &UncertainParameter,
        model: &Model,
        effects: &[EffectSpec],
        samples: &Samples,
        base_m: &[f64],
    ) -> Option<Vec<f64>> {
        // The column stays, as zeros, because a baseline counts its columns without members.
        if number.replaced {
            return Some(vec![0.0; base_m.len()]);
        }
        let side = |step: f64| {
            let (effect, moved) = self.moved(number, step)?;
            Some((tips(model, &[effects, &[effect]].concat(), samples)?, moved))
        };
        let usual = self.candidates[number.candidate].probe(number.size).abs();
        // A wide difference averages over the range in which the parameter may lie.
        let step = (MAX_DEVIATIONS * number.deviation).max(MIN_STEP_SHARE * usual);
        let (high, low) = (side(step), side(-step));
        // A side that cannot be simulated is replaced by the model as it is: a one-sided
        // difference.
        let unmoved = (base_m.to_vec(), 0.0);
        let ((high, up), (low, down)) =
            (high.unwrap_or_else(|| unmoved.clone()), low.unwrap_or(unmoved));
        (up > down)
            .then(|| high.iter().zip(&low).map(|(high, low)| (high - low) / (up - down)).collect())
    }

    /// The `nuisances`, linearised at these `amounts`, if that can be simulated and the remainder
    /// exceeds the simulation accuracy. `play`: simulated tip with more effects, `base_m` without.
    pub(crate) fn linearised_at(
        &self,
        nuisances: Nuisances,
        amounts: &DVector<f64>,
        base_m: &[f64],
        play: &dyn Fn(&[EffectSpec]) -> Option<Vec<f64>>,
    ) -> Nuisances {
        let offset = || {
            let (effects, linear_m) = self.effects_at(&nuisances, amounts)?;
            Some(DVector::from_vec(play(&effects)?) - DVector::from_column_slice(base_m) - linear_m)
        };
        match offset().filter(|offset| rms_m(offset.as_slice()) >= self.exact_m) {
            Some(offset) => nuisances.with_offset(offset),
            None => nuisances,
        }
    }

    /// Effects at these `amounts` of the `nuisances`, and their linear prediction of the tip
    /// change.
    fn effects_at(
        &self,
        nuisances: &Nuisances,
        amounts: &DVector<f64>,
    ) -> Option<(Vec<EffectSpec>, DVector<f64>)> {
        let mut linear_m = DVector::zeros(nuisances.columns.nrows());
        let mut all = Vec::new();
        for (k, number) in self.parameters.iter().enumerate().filter(|(_, number)| !number.replaced)
        {
            // Farther out the estimate stands for something else, and the play might fail.
            let max = MAX_DEVIATIONS * number.deviation;
            let (effect, moved) =
                self.moved(number, (amounts[k] - nuisances.mean[k]).clamp(-max, max))?;
            all.push(effect);
            // The range may have cut the move, so the linear part follows what was played.
            linear_m += moved * nuisances.columns.column(k);
        }
        Some((all, linear_m))
    }

    /// The effect moved by `step` within its valid range, and the distance moved.
    fn moved(&self, number: &UncertainParameter, step: f64) -> Option<(EffectSpec, f64)> {
        let candidate = &self.candidates[number.candidate];
        let there = candidate.moved_within(&number.null, number.size, step);
        Some((candidate.effect(&there)?, candidate.step(&number.null, &there, number.size)))
    }
}

/// Tip change if trials begin with the straight robot brought home a moment ago in place of one at
/// rest there; zero where nothing relaxes in time.
fn unrelaxed(
    model: &Model,
    effects: &[EffectSpec],
    samples: &Samples,
    base_m: &[f64],
) -> Option<Vec<f64>> {
    let mut all = effects.iter().chain(&model.effects);
    if all.all(|effect| effect.relaxation_time_s().is_none()) {
        return Some(vec![0.0; base_m.len()]);
    }
    let mut fresh = model.clone();
    fresh.tracking.rested_s = Some(0.0);
    let there_m = tips(&fresh, effects, samples)?;
    Some(there_m.iter().zip(base_m).map(|(there, base)| there - base).collect())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::data::Recording;
    use crate::discovery::fit::candidate::catalogue_candidates;
    use crate::discovery::fit::sensitivities::sensitivities;

    /// The model, its candidates and two trials of a recording.
    fn setting() -> (Model, Vec<CandidateEffect>, Samples) {
        let mut model = Model::default();
        let resolution = &mut model.robot.resolution;
        (resolution.motion_tolerance_m, resolution.static_tolerance_m) = (3e-5, f64::INFINITY);
        (resolution.cell_m, resolution.blended) = (0.03, true);
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/twin/nothing.csv");
        let samples = Samples::new(&Recording::read(&file).unwrap()).of_trials(&[0, 1]);
        let candidates = catalogue_candidates(&model);
        (model, candidates, samples)
    }

    fn damping(candidates: &[CandidateEffect]) -> usize {
        candidates.iter().position(|candidate| candidate.card.name == "damping").unwrap()
    }

    /// Reduced damping oscillates; strong damping does not predict that.
    #[test]
    fn answers_are_those_within_the_uncertainty_and_bend_where_numbers_are_far_off() {
        let (model, candidates, samples) = setting();
        let uncertain = UncertainParameters::new(&Options::default(), &candidates, &[], 1.0);
        let nuisances =
            Nuisances::independent(3 * samples.len(), &uncertain.columns(&model, &[], &samples));
        let own = damping(&candidates);
        let mut amounts = DVector::zeros(uncertain.parameters.len() + 1);
        amounts[uncertain.parameters.iter().position(|number| number.candidate == own).unwrap()] =
            -0.009;
        let less = [SetMember { candidate: own, values: vec![0.021] }];
        let [here, there] = [&[][..], &less].map(|members: &[SetMember]| {
            DVector::from_vec(
                tips(&model, &effect_specs(&candidates, members).unwrap(), &samples).unwrap(),
            )
        });
        let moved = there - &here;
        let off_m = |told: &DVector<f64>| rms_m((&moved - told).as_slice());
        let linear = &nuisances.columns * &amounts;
        let (effects, told) = uncertain.effects_at(&nuisances, &amounts).unwrap();
        let offset = DVector::from_vec(tips(&model, &effects, &samples).unwrap()) - &here - told;
        let much = sensitivities(
            &model,
            &candidates,
            &[],
            &|asked| asked.card.name == "damping",
            &samples,
        );
        let [by_much, by_little, bent] =
            [&much[0].columns * DVector::from_element(1, -0.009), linear.clone(), linear + offset]
                .map(|told| off_m(&told));
        assert!(
            by_little < 0.6 * by_much && bent < 1e-9,
            "{by_much} {by_little} {bent} of {}",
            rms_m(moved.as_slice())
        );
    }

    #[test]
    fn a_number_that_an_effect_replaces_does_nothing_and_what_is_added_does() {
        let (model, candidates, samples) = setting();
        let beside = |members: &[SetMember]| {
            let uncertain =
                UncertainParameters::new(&Options::default(), &candidates, members, 1.0);
            let columns = uncertain.columns(&model, members, &samples);
            let nuisances = Nuisances::independent(3 * samples.len(), &columns);
            let (off, _) = uncertain
                .effects_at(&nuisances, &DVector::from_element(columns.len(), 1e-6))
                .unwrap();
            [
                columns.len(),
                columns.iter().filter(|(column, _)| rms_m(column) > 0.0).count(),
                off.len(),
            ]
        };
        let replaced = SetMember { candidate: damping(&candidates), values: vec![0.02] };
        let stiffness = candidates
            .iter()
            .position(|candidate| candidate.card.name == "bending_stiffness")
            .unwrap();
        let added = SetMember { candidate: stiffness, values: vec![1.2] };
        // One tendon is slack in these trials.
        assert_eq!(
            [beside(&[]), beside(&[replaced]), beside(&[added])],
            [[15, 13, 14], [15, 12, 13], [15, 13, 14]]
        );
    }
}
