//! Fit of a candidate set with one member added: start from the linear prediction, fit roughly,
//! then fully.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::base::counted;

use super::screening::{LinearPrediction, LinearScreen, ScreenedResidual, best_of_each};
use super::state::ScoredSet;
use crate::discovery::fit::candidate::{SetMember, in_default_convention, neighbouring_choices};
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::fit::sensitivities::Sensitivity;

impl FitProblem<'_> {
    /// Predicted gain in score.
    pub(crate) fn predicted_score(&self, prediction: &LinearPrediction) -> f64 {
        prediction.gain - self.penalty(std::slice::from_ref(&prediction.member))
    }

    /// Penalty of a set: the Bayesian information criterion for its parameters, a term for their
    /// choice among all candidates, and the prior of its sizes.
    pub(crate) fn penalty(&self, members: &[SetMember]) -> f64 {
        // EBIC (Chen & Chen 2008): p ln 3N for the numbers and 2 ln K for the choice among K.
        let numbers = (3.0 * self.samples.len() as f64).ln();
        let open = self.open.iter().filter(|open| **open).count().max(1);
        let choice = 2.0 * (open as f64).ln();
        members
            .iter()
            .map(|member| {
                let candidate = &self.candidates[member.candidate];
                candidate.freedom() as f64 * numbers
                    + choice
                    + candidate.implausibility(&member.values)
            })
            .sum()
    }

    /// Linear predictions for the candidates that are in neither `from` nor `without`, best first.
    pub(crate) fn predictions(
        &self,
        from: &FittedSet,
        without: &[usize],
        sensitivities: &[Sensitivity],
    ) -> Vec<LinearPrediction> {
        let NuisanceFit { noise, residual_m, .. } = &from.nuisance_fit;
        let residual = ScreenedResidual { noise, residual_m };
        let screen = LinearScreen::new(
            self.candidates,
            self.samples,
            self.nuisances,
            residual,
            &from.jacobian,
        );
        let mut predictions = best_of_each(screen.predictions(sensitivities));
        predictions.retain(|prediction| {
            let candidate = prediction.member.candidate;
            self.open[candidate] && !from.has(candidate) && !without.contains(&candidate)
        });
        predictions
    }

    /// `base` with each predicted member added, fitted at coarse resolution; scores below
    /// `min_score` are of no use.
    pub(crate) fn rough_additions(
        &self,
        base: &ScoredSet,
        predictions: &[&LinearPrediction],
        sensitivities: &[Sensitivity],
        min_score: f64,
    ) -> Vec<ScoredSet> {
        let coarse = FitProblem { model: self.coarse, ..self.clone() };
        // Deviances compare only at one resolution, so the base is played coarsely, too.
        let Some(start) = coarse.resimulate(&base.fitted) else { return Vec::new() };
        let fit = |prediction: &&LinearPrediction| {
            let penalty = self.penalty(std::slice::from_ref(&prediction.member));
            // A fit that cannot reach this deviance is of no use.
            let target_deviance = start.nuisance_fit.deviance - (min_score - base.score) - penalty;
            let added = coarse.starting_point(&start, &prediction.member)?;
            // A scanned effect responds to no small step, so only a derivative at its size helps.
            let jacobian = if self.candidates[prediction.member.candidate].is_scanned() {
                coarse.differentiate(&added)?
            } else {
                let extended = coarse.extended_jacobian(
                    &start,
                    &prediction.member,
                    &sensitivities[prediction.sensitivity],
                );
                if start.members.is_empty() {
                    extended
                } else {
                    coarse.with_fresh_sizes(&added, extended)
                }
            };
            let fitted = coarse.rough_fit(added, jacobian, target_deviance)?;
            let last = fitted.members.len() - 1;
            // Choices such as places have no derivative; try their neighbours.
            let fitted = coarse.with_best_choice(fitted, last, target_deviance);
            // The members of the base may have moved, too.
            let penalty = self.penalty(&fitted.members) - self.penalty(&start.members);
            let score =
                base.score + start.nuisance_fit.deviance - fitted.nuisance_fit.deviance - penalty;
            Some(ScoredSet { fitted, score, exact: false })
        };
        predictions.par_iter().filter_map(counted(fit)).collect()
    }

    /// Approximate Jacobian of `base` with `member`: that of the fit, extended by the sensitivity.
    pub(crate) fn extended_jacobian(
        &self,
        base: &FittedSet,
        member: &SetMember,
        sensitivity: &Sensitivity,
    ) -> DMatrix<f64> {
        let candidate = &self.candidates[member.candidate];
        let (base_columns, sizes) = (base.jacobian.ncols(), candidate.sizes());
        let fitted = candidate.fitted();
        let mut slopes =
            base.jacobian.clone().resize_horizontally(base_columns + fitted.len(), 0.0);
        for (k, parameter) in fitted.into_iter().enumerate() {
            if let Some(size) = sizes.iter().position(|&size| size == parameter) {
                slopes.set_column(
                    base_columns + k,
                    &(sensitivity.columns.column(size) * candidate.probe(parameter)),
                );
            }
        }
        slopes
    }

    /// The Jacobian with fresh columns for the sizes of the last member: with a strong effect in
    /// the set the sensitivity can change.
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

    /// `base` with the predicted member, reduced where a smaller amount fits better; none if it
    /// cannot be simulated.
    fn starting_point(&self, base: &FittedSet, predicted: &SetMember) -> Option<FittedSet> {
        let nothing = self.candidates[predicted.candidate].without_size(&predicted.values);
        let part = |share: f64| {
            let between =
                nothing.iter().zip(&predicted.values).map(|(n, v)| n + share * (v - n)).collect();
            let member = SetMember { values: between, ..*predicted };
            self.evaluate(base.members.iter().cloned().chain([member]).collect())
        };
        let mut best: Option<FittedSet> = None;
        for start in [1.0, 0.5, 0.25].into_iter().filter_map(part) {
            // The first amount that improves is taken: a descent goes on from there.
            if start.nuisance_fit.deviance < base.nuisance_fit.deviance {
                return Some(start);
            }
            match &best {
                Some(best) if best.nuisance_fit.deviance <= start.nuisance_fit.deviance => break,
                _ => best = Some(start),
            }
        }
        best
    }

    /// Full fit from nearby values, with the best choice of every member.
    pub(crate) fn fit_fully(&self, near: &FittedSet) -> Option<FittedSet> {
        let near = match in_default_convention(self.candidates, &near.members) {
            Some(members) => &self.with_fresh_jacobian(self.evaluate(members)?)?,
            None => near,
        };
        let mut best = self.refit(near.members.clone(), near.jacobian.clone())?;
        for k in 0..best.members.len() {
            let with_best_choice = self.with_best_choice(best.clone(), k, f64::INFINITY);
            if with_best_choice.members != best.members {
                best = self.refit(with_best_choice.members, with_best_choice.jacobian)?;
            }
        }
        Some(best)
    }

    /// Moves every choice of member `k` (such as a position) to its neighbours as long as a rough
    /// fit improves.
    fn with_best_choice(&self, mut best: FittedSet, k: usize, target_deviance: f64) -> FittedSet {
        loop {
            let fits = neighbouring_choices(self.candidates, &best.members, k)
                .into_iter()
                .filter_map(|values| {
                    let mut members = best.members.clone();
                    members[k].values = values;
                    self.rough_fit(self.evaluate(members)?, best.jacobian.clone(), target_deviance)
                });
            let next =
                fits.min_by(|a, b| a.nuisance_fit.deviance.total_cmp(&b.nuisance_fit.deviance));
            match next.filter(|next| next.nuisance_fit.deviance < best.nuisance_fit.deviance) {
                Some(next) => best = next,
                None => return best,
            }
        }
    }
}
