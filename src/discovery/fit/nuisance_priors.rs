//! Numbers that are uncertain of any robot: how the tip sensitivities to each of them within its uncertainty, and what that leaves
//! out where they are as far off as an estimate has them.

use nalgebra::DVector;
use rayon::prelude::*;

use super::candidate::{CandidateEffect, SetMember, effect_specs};
use super::nuisance::{NuisanceColumn, Nuisances};
use super::simulate::tips;
use crate::discovery::options::Options;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::effects::{EffectSpec, Model};

/// The parameters that are uncertain beside some effects.
pub(crate) struct UncertainParameters<'a> {
    candidates: &'a [CandidateEffect],
    parameters: Vec<UncertainParameter>,
    /// What plays are exact to, metres.
    exact_m: f64,
}

/// One of them: a size of a candidate, about the values at which that does nothing.
struct UncertainParameter {
    candidate: usize,
    null: Vec<f64>,
    size: usize,
    deviation: f64,
    /// Whether a member has replaced it: whatever it is then does nothing.
    replaced: bool,
}

/// A number is believed to be off by so many standard deviations at most, and the tip's sensitivity_of is taken between there and as
/// far to the other side. A usual size of an effect is far beyond that, and the tip sensitivities to it otherwise: a rod that is
/// damped less swings, and one that is damped much more says nothing of how.
const FARTHEST: f64 = 3.0;

/// Answers are taken between this share of a usual size to either side at least, or steps in time would show in them.
const SEEN: f64 = 0.25;

impl<'a> UncertainParameters<'a> {
    /// The parameters that are uncertain beside the `members`, each by so many times what the options say. They are as many
    /// beside any members, as a baseline tells of all of them.
    pub(crate) fn new(
        options: &Options,
        candidates: &'a [CandidateEffect],
        members: &[SetMember],
        times: f64,
    ) -> UncertainParameters<'a> {
        let replaced = |own: &CandidateEffect| {
            own.replaces() && members.iter().any(|member| candidates[member.candidate].card.name == own.card.name)
        };
        let mut parameters = Vec::new();
        for one in &options.uncertain {
            let about = candidates.iter().enumerate().filter(|(_, own)| own.card.name == one.effect);
            for (number, candidate) in about {
                for null in candidate.variants() {
                    let asked = |size: &usize| candidate.card.parameters[*size].vector() == one.parameter;
                    parameters.extend(candidate.sizes().into_iter().filter(asked).map(|size| UncertainParameter {
                        candidate: number,
                        null: null.clone(),
                        size,
                        deviation: times * one.deviation,
                        replaced: replaced(candidate),
                    }));
                }
            }
        }
        UncertainParameters { candidates, parameters, exact_m: options.motion_tolerance_m }
    }

    /// How the tip of `model` with the `members` sensitivities to each of them, with its standard deviation. As without the members
    /// where it cannot be simulated_m with them; zero where it cannot be simulated_m at all.
    pub(crate) fn columns(&self, model: &Model, members: &[SetMember], samples: &Samples) -> Vec<NuisanceColumn> {
        let beside = |members: &[SetMember]| -> Vec<Option<Vec<f64>>> {
            let known = effect_specs(self.candidates, members);
            let here = known.as_ref().and_then(|known| tips(model, known, samples));
            let (Some(known), Some(here)) = (known, here) else { return vec![None; self.parameters.len()] };
            let sensitivity_of = |number: &UncertainParameter| self.sensitivity(number, model, &known, samples, &here);
            self.parameters.par_iter().map(sensitivity_of).collect()
        };
        let mut sensitivities = beside(members);
        if !members.is_empty() && sensitivities.iter().any(Option::is_none) {
            sensitivities =
                sensitivities.into_iter().zip(beside(&[])).map(|(with, without)| with.or(without)).collect();
        }
        let zero = || vec![0.0; 3 * samples.len()];
        let each = sensitivities.into_iter().zip(&self.parameters);
        each.map(|(sensitivity_of, number)| (sensitivity_of.unwrap_or_else(zero), number.deviation)).collect()
    }

    /// The tip's sensitivity_of to one of them, between both sides as far as it can be simulated_m there.
    fn sensitivity(
        &self,
        number: &UncertainParameter,
        model: &Model,
        known: &[EffectSpec],
        samples: &Samples,
        here: &[f64],
    ) -> Option<Vec<f64>> {
        if number.replaced {
            return Some(vec![0.0; here.len()]);
        }
        let side = |step: f64| {
            let (effect, moved) = self.moved(number, step)?;
            Some((tips(model, &[known, &[effect]].concat(), samples)?, moved))
        };
        let usual = self.candidates[number.candidate].probe(number.size).abs();
        let step = (FARTHEST * number.deviation).max(SEEN * usual);
        let (high, low) = (side(step), side(-step));
        let still = (here.to_vec(), 0.0);
        let ((high, up), (low, down)) = (high.unwrap_or_else(|| still.clone()), low.unwrap_or(still));
        (up > down).then(|| high.iter().zip(&low).map(|(high, low)| (high - low) / (up - down)).collect())
    }

    /// The `nuisances`, of which they are the first, linear about where these `amounts` have them, as far as that can be simulated_m
    /// and is seen beside what plays are off by. `play`: where the model has the tip with more effects, `here` without more.
    pub(crate) fn linearised_at(
        &self,
        nuisances: Nuisances,
        amounts: &DVector<f64>,
        here: &[f64],
        play: &dyn Fn(&[EffectSpec]) -> Option<Vec<f64>>,
    ) -> Nuisances {
        let offset = || {
            let (off, told) = self.effects_at(&nuisances, amounts)?;
            Some(DVector::from_vec(play(&off)?) - DVector::from_column_slice(here) - told)
        };
        match offset().filter(|offset| rms_m(offset.as_slice()) >= self.exact_m) {
            Some(offset) => nuisances.with_offset(offset),
            None => nuisances,
        }
    }

    /// The effects that put them where these `amounts` of the `nuisances` have them, and what those say that this does to the
    /// tip.
    fn effects_at(&self, nuisances: &Nuisances, amounts: &DVector<f64>) -> Option<(Vec<EffectSpec>, DVector<f64>)> {
        let mut told = DVector::zeros(nuisances.columns.nrows());
        let mut all = Vec::new();
        for (k, number) in self.parameters.iter().enumerate().filter(|(_, number)| !number.replaced) {
            let most = FARTHEST * number.deviation;
            let (effect, moved) = self.moved(number, (amounts[k] - nuisances.mean[k]).clamp(-most, most))?;
            all.push(effect);
            told += moved * nuisances.columns.column(k);
        }
        Some((all, told))
    }

    /// The effect of one of them moved by `step`, no farther than its range reaches, and how far that was.
    fn moved(&self, number: &UncertainParameter, step: f64) -> Option<(EffectSpec, f64)> {
        let candidate = &self.candidates[number.candidate];
        let there = candidate.moved_within(&number.null, number.size, step);
        Some((candidate.effect(&there)?, candidate.step(&number.null, &there, number.size)))
    }
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

    /// A rod that is damped less swings as one that is damped much more does not tell.
    #[test]
    fn answers_are_those_within_the_uncertainty_and_bend_where_numbers_are_far_off() {
        let (model, candidates, samples) = setting();
        let uncertain = UncertainParameters::new(&Options::default(), &candidates, &[], 1.0);
        let nuisances = Nuisances::independent(3 * samples.len(), &uncertain.columns(&model, &[], &samples));
        let own = damping(&candidates);
        let mut amounts = DVector::zeros(uncertain.parameters.len());
        amounts[uncertain.parameters.iter().position(|number| number.candidate == own).unwrap()] = -0.009;
        let less = [SetMember { candidate: own, values: vec![0.021] }];
        let [here, there] = [&[][..], &less].map(|members: &[SetMember]| {
            DVector::from_vec(tips(&model, &effect_specs(&candidates, members).unwrap(), &samples).unwrap())
        });
        let moved = there - &here;
        let off_m = |told: &DVector<f64>| rms_m((&moved - told).as_slice());
        let linear = &nuisances.columns * &amounts;
        let (effects, told) = uncertain.effects_at(&nuisances, &amounts).unwrap();
        let offset = DVector::from_vec(tips(&model, &effects, &samples).unwrap()) - &here - told;
        let much = sensitivities(&model, &candidates, &[], &|asked| asked.card.name == "damping", &samples);
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
            let uncertain = UncertainParameters::new(&Options::default(), &candidates, members, 1.0);
            let columns = uncertain.columns(&model, members, &samples);
            let nuisances = Nuisances::independent(3 * samples.len(), &columns);
            let (off, _) = uncertain.effects_at(&nuisances, &DVector::from_element(columns.len(), 1e-6)).unwrap();
            [columns.len(), columns.iter().filter(|(column, _)| rms_m(column) > 0.0).count(), off.len()]
        };
        let replaced = SetMember { candidate: damping(&candidates), values: vec![0.02] };
        let stiffness = candidates.iter().position(|candidate| candidate.card.name == "bending_stiffness").unwrap();
        let added = SetMember { candidate: stiffness, values: vec![1.2] };
        // One tendon is slack in these trials.
        assert_eq!([beside(&[]), beside(&[replaced]), beside(&[added])], [[14, 13, 14], [14, 12, 13], [14, 13, 14]]);
    }
}
