//! A set of candidates with one member more, fitted: from what the member predictions, first roughly, then as well as can be.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::screening::{LinearPrediction, LinearScreen, best_of_each};
use super::state::ScoredSet;
use crate::discovery::fit::candidate::SetMember;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::sensitivities::Sensitivity;

impl FitProblem<'_> {
    /// What a prediction would add to the score.
    pub(crate) fn predicted_score(&self, prediction: &LinearPrediction) -> f64 {
        prediction.gain - self.penalty(std::slice::from_ref(&prediction.member))
    }

    /// Penalty of a set: half of it, the Bayesian information criterion, for its parameters, the rest for their choice
    /// among all candidates.
    pub(crate) fn penalty(&self, members: &[SetMember]) -> f64 {
        let numbers = (3.0 * self.samples.len() as f64).ln();
        let open = self.open.iter().filter(|open| **open).count().max(1);
        let choice = 2.0 * (open as f64).ln();
        members.iter().map(|member| self.candidates[member.candidate].freedom() as f64 * numbers + choice).sum()
    }

    /// What the candidates that are not in `from` and not in `without` prediction beside it, the best first.
    pub(crate) fn predictions(
        &self,
        from: &FittedSet,
        without: &[usize],
        sensitivities: &[Sensitivity],
    ) -> Vec<LinearPrediction> {
        let left = (&from.nuisance_fit.noise, from.nuisance_fit.residual_m.as_slice());
        let screen = LinearScreen::new(self.candidates, self.samples, self.nuisances, left, &from.jacobian);
        let mut predictions = best_of_each(screen.predictions(sensitivities));
        predictions.retain(|prediction| {
            let own = prediction.member.candidate;
            self.open[own] && !from.has(own) && !without.contains(&own)
        });
        predictions
    }

    /// `base` with each of the promised members, simulated_m coarsely on both sides; a score below `enough` is of no use.
    pub(crate) fn rough_additions(
        &self,
        base: &ScoredSet,
        predictions: &[&LinearPrediction],
        sensitivities: &[Sensitivity],
        enough: f64,
    ) -> Vec<ScoredSet> {
        let coarse = FitProblem { model: self.coarse, ..self.clone() };
        let Some(start) = coarse.resimulate(&base.fitted) else { return Vec::new() };
        let fit = |prediction: &&LinearPrediction| {
            let costs = self.penalty(std::slice::from_ref(&prediction.member));
            let wanted = start.nuisance_fit.deviance - (enough - base.score) - costs;
            let begun = coarse.starting_point(&start, &prediction.member)?;
            let jacobian = if self.candidates[prediction.member.candidate].is_scanned() {
                coarse.differentiate(&begun)?
            } else {
                let known = coarse.known_jacobian(&start, &prediction.member, &sensitivities[prediction.sensitivity]);
                if start.members.is_empty() { known } else { coarse.with_fresh_sizes(&begun, known) }
            };
            let fitted = coarse.rough_fit(begun, jacobian, wanted)?;
            let last = fitted.members.len() - 1;
            let fitted = coarse.with_best_choice(fitted, last, wanted);
            let score = base.score + start.nuisance_fit.deviance - fitted.nuisance_fit.deviance - costs;
            Some(ScoredSet { fitted, score, exact: false })
        };
        predictions.par_iter().filter_map(fit).collect()
    }

    /// What is known of the derivatives of `base` with `member` besides: those of the fit, and the first look's.
    pub(crate) fn known_jacobian(
        &self,
        base: &FittedSet,
        member: &SetMember,
        sensitivity: &Sensitivity,
    ) -> DMatrix<f64> {
        let candidate = &self.candidates[member.candidate];
        let (known, sizes) = (base.jacobian.ncols(), candidate.sizes());
        let fitted = candidate.fitted();
        let mut slopes = base.jacobian.clone().resize_horizontally(known + fitted.len(), 0.0);
        for (k, parameter) in fitted.into_iter().enumerate() {
            if let Some(size) = sizes.iter().position(|&size| size == parameter) {
                slopes.set_column(known + k, &(sensitivity.columns.column(size) * candidate.probe(parameter)));
            }
        }
        slopes
    }

    /// The derivatives of a fit with those over the sizes of its last member taken anew: beside much of another effect the
    /// tip may answer otherwise than was seen at first.
    fn with_fresh_sizes(&self, fitted: &FittedSet, mut slopes: DMatrix<f64>) -> DMatrix<f64> {
        let (last, coordinates) = (fitted.members.len() - 1, self.coordinates(&fitted.members));
        let sizes = self.candidates[fitted.members[last].candidate].sizes();
        for (at, &(member, parameter)) in coordinates.iter().enumerate() {
            if member == last
                && sizes.contains(&parameter)
                && let Some(slope) = self.jacobian_column(fitted, at)
            {
                slopes.set_column(at, &slope);
            }
        }
        slopes
    }

    /// `base` with the promised member, nearer to nothing where the tip's answer is so far from linear that less of it fits
    /// better; none where the model can play none of it.
    fn starting_point(&self, base: &FittedSet, promised: &SetMember) -> Option<FittedSet> {
        let nothing = self.candidates[promised.candidate].without_size(&promised.values);
        let part = |share: f64| {
            let between = nothing.iter().zip(&promised.values).map(|(n, v)| n + share * (v - n)).collect();
            let member = SetMember { values: between, ..*promised };
            self.evaluate(base.members.iter().cloned().chain([member]).collect())
        };
        let mut best: Option<FittedSet> = None;
        for begun in [1.0, 0.5, 0.25].into_iter().filter_map(part) {
            if begun.nuisance_fit.deviance < base.nuisance_fit.deviance {
                return Some(begun);
            }
            match &best {
                Some(best) if best.nuisance_fit.deviance <= begun.nuisance_fit.deviance => break,
                _ => best = Some(begun),
            }
        }
        best
    }

    /// The fit from near it, with every choice where it fits best.
    pub(crate) fn fit_fully(&self, near: &FittedSet) -> Option<FittedSet> {
        let mut best = self.refit(near.members.clone(), near.jacobian.clone())?;
        for k in 0..best.members.len() {
            let with_best_choice = self.with_best_choice(best.clone(), k, f64::INFINITY);
            if with_best_choice.members != best.members {
                best = self.refit(with_best_choice.members, with_best_choice.jacobian)?;
            }
        }
        Some(best)
    }

    /// The fit with every choice of member `k` (such as a place) moved to its neighbours while that helps, roughly.
    fn with_best_choice(&self, mut best: FittedSet, k: usize, wanted: f64) -> FittedSet {
        let candidate = &self.candidates[best.members[k].candidate];
        loop {
            let fits = candidate.neighbouring_choices(&best.members[k].values).into_iter().filter_map(|values| {
                let mut members = best.members.clone();
                members[k].values = values;
                self.rough_fit(self.evaluate(members)?, best.jacobian.clone(), wanted)
            });
            let next = fits.min_by(|a, b| a.nuisance_fit.deviance.total_cmp(&b.nuisance_fit.deviance));
            match next.filter(|next| next.nuisance_fit.deviance < best.nuisance_fit.deviance) {
                Some(next) => best = next,
                None => return best,
            }
        }
    }
}
