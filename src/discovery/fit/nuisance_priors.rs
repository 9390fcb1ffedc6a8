//! Numbers that are uncertain of any robot: how the tip answers to each of them within its uncertainty, and what that leaves
//! out where they are as far off as an estimate has them.

use nalgebra::DVector;
use rayon::prelude::*;

use super::candidate::{Hypothesis, Member, effects};
use super::nuisance::{Column, Nuisances};
use super::simulate::tips;
use crate::discovery::options::Options;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::effects::{EffectSpec, Model};

/// The numbers that are uncertain beside some effects.
pub(crate) struct Uncertain<'a> {
    hypotheses: &'a [Hypothesis],
    numbers: Vec<Number>,
    /// What plays are exact to, metres.
    exact_m: f64,
}

/// One of them: a size of a hypothesis, about the values at which that does nothing.
struct Number {
    hypothesis: usize,
    null: Vec<f64>,
    size: usize,
    deviation: f64,
    /// Whether a member has replaced it: whatever it is then does nothing.
    replaced: bool,
}

/// A number is believed to be off by so many standard deviations at most, and the tip's answer is taken between there and as
/// far to the other side. A usual size of an effect is far beyond that, and the tip answers to it otherwise: a rod that is
/// damped less swings, and one that is damped much more says nothing of how.
const FARTHEST: f64 = 3.0;

/// Answers are taken between this share of a usual size to either side at least, or steps in time would show in them.
const SEEN: f64 = 0.25;

impl<'a> Uncertain<'a> {
    /// The numbers that are uncertain beside the `members`, each by so many times what the options say. They are as many
    /// beside any members, as a baseline tells of all of them.
    pub(crate) fn new(
        options: &Options,
        hypotheses: &'a [Hypothesis],
        members: &[Member],
        times: f64,
    ) -> Uncertain<'a> {
        let replaced = |own: &Hypothesis| {
            own.replaces() && members.iter().any(|member| hypotheses[member.hypothesis].card.name == own.card.name)
        };
        let mut numbers = Vec::new();
        for one in &options.uncertain {
            let about = hypotheses.iter().enumerate().filter(|(_, own)| own.card.name == one.effect);
            for (number, hypothesis) in about {
                for null in hypothesis.variants() {
                    let asked = |size: &usize| hypothesis.card.parameters[*size].vector() == one.parameter;
                    numbers.extend(hypothesis.sizes().into_iter().filter(asked).map(|size| Number {
                        hypothesis: number,
                        null: null.clone(),
                        size,
                        deviation: times * one.deviation,
                        replaced: replaced(hypothesis),
                    }));
                }
            }
        }
        Uncertain { hypotheses, numbers, exact_m: options.motion_tolerance_m }
    }

    /// How the tip of `model` with the `members` answers to each of them, with its standard deviation. As without the members
    /// where it cannot be played with them; zero where it cannot be played at all.
    pub(crate) fn columns(&self, model: &Model, members: &[Member], samples: &Samples) -> Vec<Column> {
        let beside = |members: &[Member]| -> Vec<Option<Vec<f64>>> {
            let known = effects(self.hypotheses, members);
            let here = known.as_ref().and_then(|known| tips(model, known, samples));
            let (Some(known), Some(here)) = (known, here) else { return vec![None; self.numbers.len()] };
            let answer = |number: &Number| self.answer(number, model, &known, samples, &here);
            self.numbers.par_iter().map(answer).collect()
        };
        let mut answers = beside(members);
        if !members.is_empty() && answers.iter().any(Option::is_none) {
            answers = answers.into_iter().zip(beside(&[])).map(|(with, without)| with.or(without)).collect();
        }
        let zero = || vec![0.0; 3 * samples.len()];
        let each = answers.into_iter().zip(&self.numbers);
        each.map(|(answer, number)| (answer.unwrap_or_else(zero), number.deviation)).collect()
    }

    /// The tip's answer to one of them, between both sides as far as it can be played there.
    fn answer(
        &self,
        number: &Number,
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
        let usual = self.hypotheses[number.hypothesis].probe(number.size).abs();
        let step = (FARTHEST * number.deviation).max(SEEN * usual);
        let (high, low) = (side(step), side(-step));
        let still = (here.to_vec(), 0.0);
        let ((high, up), (low, down)) = (high.unwrap_or_else(|| still.clone()), low.unwrap_or(still));
        (up > down).then(|| high.iter().zip(&low).map(|(high, low)| (high - low) / (up - down)).collect())
    }

    /// The `nuisances`, of which they are the first, linear about where these `amounts` have them, as far as that can be played
    /// and is seen beside what plays are off by. `play`: where the model has the tip with more effects, `here` without more.
    pub(crate) fn bent(
        &self,
        nuisances: Nuisances,
        amounts: &DVector<f64>,
        here: &[f64],
        play: &dyn Fn(&[EffectSpec]) -> Option<Vec<f64>>,
    ) -> Nuisances {
        let bend = || {
            let (off, told) = self.at(&nuisances, amounts)?;
            Some(DVector::from_vec(play(&off)?) - DVector::from_column_slice(here) - told)
        };
        match bend().filter(|bend| rms_m(bend.as_slice()) >= self.exact_m) {
            Some(bend) => nuisances.bent(bend),
            None => nuisances,
        }
    }

    /// The effects that put them where these `amounts` of the `nuisances` have them, and what those say that this does to the
    /// tip.
    fn at(&self, nuisances: &Nuisances, amounts: &DVector<f64>) -> Option<(Vec<EffectSpec>, DVector<f64>)> {
        let mut told = DVector::zeros(nuisances.columns.nrows());
        let mut all = Vec::new();
        for (k, number) in self.numbers.iter().enumerate().filter(|(_, number)| !number.replaced) {
            let most = FARTHEST * number.deviation;
            let (effect, moved) = self.moved(number, (amounts[k] - nuisances.mean[k]).clamp(-most, most))?;
            all.push(effect);
            told += moved * nuisances.columns.column(k);
        }
        Some((all, told))
    }

    /// The effect of one of them moved by `step`, no farther than its range reaches, and how far that was.
    fn moved(&self, number: &Number, step: f64) -> Option<(EffectSpec, f64)> {
        let hypothesis = &self.hypotheses[number.hypothesis];
        let there = hypothesis.moved_within(&number.null, number.size, step);
        Some((hypothesis.effect(&there)?, hypothesis.step(&number.null, &there, number.size)))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::data::Recording;
    use crate::discovery::fit::candidate::hypotheses;
    use crate::discovery::fit::sensitivities::responses;

    /// The model, its hypotheses and two trials of a recording.
    fn setting() -> (Model, Vec<Hypothesis>, Samples) {
        let mut model = Model::default();
        let resolution = &mut model.robot.resolution;
        (resolution.motion_tolerance_m, resolution.static_tolerance_m) = (3e-5, f64::INFINITY);
        (resolution.cell_m, resolution.blended) = (0.03, true);
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/twin/nothing.csv");
        let samples = Samples::new(&Recording::read(&file).unwrap()).of_trials(&[0, 1]);
        let hypotheses = hypotheses(&model);
        (model, hypotheses, samples)
    }

    fn damping(hypotheses: &[Hypothesis]) -> usize {
        hypotheses.iter().position(|hypothesis| hypothesis.card.name == "damping").unwrap()
    }

    /// A rod that is damped less swings as one that is damped much more does not tell.
    #[test]
    fn answers_are_those_within_the_uncertainty_and_bend_where_numbers_are_far_off() {
        let (model, hypotheses, samples) = setting();
        let uncertain = Uncertain::new(&Options::default(), &hypotheses, &[], 1.0);
        let nuisances = Nuisances::independent(3 * samples.len(), &uncertain.columns(&model, &[], &samples));
        let own = damping(&hypotheses);
        let mut amounts = DVector::zeros(uncertain.numbers.len());
        amounts[uncertain.numbers.iter().position(|number| number.hypothesis == own).unwrap()] = -0.009;
        let less = [Member { hypothesis: own, values: vec![0.021] }];
        let [here, there] = [&[][..], &less].map(|members: &[Member]| {
            DVector::from_vec(tips(&model, &effects(&hypotheses, members).unwrap(), &samples).unwrap())
        });
        let moved = there - &here;
        let off_m = |told: &DVector<f64>| rms_m((&moved - told).as_slice());
        let linear = &nuisances.columns * &amounts;
        let (effects, told) = uncertain.at(&nuisances, &amounts).unwrap();
        let bend = DVector::from_vec(tips(&model, &effects, &samples).unwrap()) - &here - told;
        let much = responses(&model, &hypotheses, &[], &|asked| asked.card.name == "damping", &samples);
        let [by_much, by_little, bent] =
            [&much[0].columns * DVector::from_element(1, -0.009), linear.clone(), linear + bend]
                .map(|told| off_m(&told));
        assert!(
            by_little < 0.6 * by_much && bent < 1e-9,
            "{by_much} {by_little} {bent} of {}",
            rms_m(moved.as_slice())
        );
    }

    #[test]
    fn a_number_that_an_effect_replaces_does_nothing_and_what_is_added_does() {
        let (model, hypotheses, samples) = setting();
        let beside = |members: &[Member]| {
            let uncertain = Uncertain::new(&Options::default(), &hypotheses, members, 1.0);
            let columns = uncertain.columns(&model, members, &samples);
            let nuisances = Nuisances::independent(3 * samples.len(), &columns);
            let (off, _) = uncertain.at(&nuisances, &DVector::from_element(columns.len(), 1e-6)).unwrap();
            [columns.len(), columns.iter().filter(|(column, _)| rms_m(column) > 0.0).count(), off.len()]
        };
        let replaced = Member { hypothesis: damping(&hypotheses), values: vec![0.02] };
        let stiffness = hypotheses.iter().position(|hypothesis| hypothesis.card.name == "bending_stiffness").unwrap();
        let added = Member { hypothesis: stiffness, values: vec![1.2] };
        // One tendon is slack in these trials.
        assert_eq!([beside(&[]), beside(&[replaced]), beside(&[added])], [[14, 13, 14], [14, 12, 13], [14, 13, 14]]);
    }
}
