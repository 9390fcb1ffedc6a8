//! A set of hypotheses with one member more, fitted: from what the member promises, first roughly, then as well as can be.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Scored;
use super::screening::{Promise, Screen, best_of_each};
use crate::discovery::fit::candidate::Member;
use crate::discovery::fit::gauss_newton::{Fitted, Study};
use crate::discovery::fit::sensitivities::Response;

impl Study<'_> {
    /// What a promise would add to the score.
    pub(crate) fn promised(&self, promise: &Promise) -> f64 {
        promise.gain - self.penalty(std::slice::from_ref(&promise.member))
    }

    /// Penalty of a set: half of it, the Bayesian information criterion, for its parameters, the rest for their choice
    /// among all hypotheses.
    pub(crate) fn penalty(&self, members: &[Member]) -> f64 {
        let numbers = (3.0 * self.samples.len() as f64).ln();
        let open = self.open.iter().filter(|open| **open).count().max(1);
        let choice = 2.0 * (open as f64).ln();
        members.iter().map(|member| self.hypotheses[member.hypothesis].freedom() as f64 * numbers + choice).sum()
    }

    /// What the hypotheses that are not in `from` and not in `without` promise beside it, the best first.
    pub(crate) fn promises(&self, from: &Fitted, without: &[usize], responses: &[Response]) -> Vec<Promise> {
        let left = (&from.explained.noise, from.explained.left_m.as_slice());
        let screen = Screen::new(self.hypotheses, self.samples, self.nuisances, left, &from.jacobian);
        let mut promises = best_of_each(screen.promises(responses));
        promises.retain(|promise| {
            let own = promise.member.hypothesis;
            self.open[own] && !from.has(own) && !without.contains(&own)
        });
        promises
    }

    /// `base` with each of the promised members, played coarsely on both sides; a score below `enough` is of no use.
    pub(crate) fn roughly_with(
        &self,
        base: &Scored,
        promises: &[&Promise],
        responses: &[Response],
        enough: f64,
    ) -> Vec<Scored> {
        let coarse = Study { model: self.coarse, ..self.clone() };
        let Some(start) = coarse.again(&base.fitted) else { return Vec::new() };
        let fit = |promise: &&Promise| {
            let costs = self.penalty(std::slice::from_ref(&promise.member));
            let wanted = start.explained.deviance - (enough - base.score) - costs;
            let begun = coarse.begun(&start, &promise.member)?;
            let jacobian = if self.hypotheses[promise.member.hypothesis].rises_and_falls() {
                coarse.derivative(&begun)?
            } else {
                let known = coarse.known_slopes(&start, &promise.member, &responses[promise.response]);
                if start.members.is_empty() { known } else { coarse.renewed(&begun, known) }
            };
            let fitted = coarse.rough_fit(begun, jacobian, wanted)?;
            let last = fitted.members.len() - 1;
            let fitted = coarse.placed(fitted, last, wanted);
            let score = base.score + start.explained.deviance - fitted.explained.deviance - costs;
            Some(Scored { fitted, score, exact: false })
        };
        promises.par_iter().filter_map(fit).collect()
    }

    /// What is known of the derivatives of `base` with `member` besides: those of the fit, and the first look's.
    pub(crate) fn known_slopes(&self, base: &Fitted, member: &Member, response: &Response) -> DMatrix<f64> {
        let hypothesis = &self.hypotheses[member.hypothesis];
        let (known, sizes) = (base.jacobian.ncols(), hypothesis.sizes());
        let fitted = hypothesis.fitted();
        let mut slopes = base.jacobian.clone().resize_horizontally(known + fitted.len(), 0.0);
        for (k, parameter) in fitted.into_iter().enumerate() {
            if let Some(size) = sizes.iter().position(|&size| size == parameter) {
                slopes.set_column(known + k, &(response.columns.column(size) * hypothesis.probe(parameter)));
            }
        }
        slopes
    }

    /// The derivatives of a fit with those over the sizes of its last member taken anew: beside much of another effect the
    /// tip may answer otherwise than was seen at first.
    fn renewed(&self, fitted: &Fitted, mut slopes: DMatrix<f64>) -> DMatrix<f64> {
        let (last, coordinates) = (fitted.members.len() - 1, self.coordinates(&fitted.members));
        let sizes = self.hypotheses[fitted.members[last].hypothesis].sizes();
        for (at, &(member, parameter)) in coordinates.iter().enumerate() {
            if member == last
                && sizes.contains(&parameter)
                && let Some(slope) = self.slope(fitted, at)
            {
                slopes.set_column(at, &slope);
            }
        }
        slopes
    }

    /// `base` with the promised member, nearer to nothing where the tip's answer is so far from linear that less of it fits
    /// better; none where the model can play none of it.
    fn begun(&self, base: &Fitted, promised: &Member) -> Option<Fitted> {
        let nothing = self.hypotheses[promised.hypothesis].without(&promised.values);
        let part = |share: f64| {
            let between = nothing.iter().zip(&promised.values).map(|(n, v)| n + share * (v - n)).collect();
            let member = Member { values: between, ..*promised };
            self.at(base.members.iter().cloned().chain([member]).collect())
        };
        let mut best: Option<Fitted> = None;
        for begun in [1.0, 0.5, 0.25].into_iter().filter_map(part) {
            if begun.explained.deviance < base.explained.deviance {
                return Some(begun);
            }
            match &best {
                Some(best) if best.explained.deviance <= begun.explained.deviance => break,
                _ => best = Some(begun),
            }
        }
        best
    }

    /// The fit from near it, with every choice where it fits best.
    pub(crate) fn settled(&self, near: &Fitted) -> Option<Fitted> {
        let mut best = self.refit(near.members.clone(), near.jacobian.clone())?;
        for k in 0..best.members.len() {
            let placed = self.placed(best.clone(), k, f64::INFINITY);
            if placed.members != best.members {
                best = self.refit(placed.members, placed.jacobian)?;
            }
        }
        Some(best)
    }

    /// The fit with every choice of member `k` (such as a place) moved to its neighbours while that helps, roughly.
    fn placed(&self, mut best: Fitted, k: usize, wanted: f64) -> Fitted {
        let hypothesis = &self.hypotheses[best.members[k].hypothesis];
        loop {
            let fits = hypothesis.neighbours(&best.members[k].values).into_iter().filter_map(|values| {
                let mut members = best.members.clone();
                members[k].values = values;
                self.rough_fit(self.at(members)?, best.jacobian.clone(), wanted)
            });
            let next = fits.min_by(|a, b| a.explained.deviance.total_cmp(&b.explained.deviance));
            match next.filter(|next| next.explained.deviance < best.explained.deviance) {
                Some(next) => best = next,
                None => return best,
            }
        }
    }
}
