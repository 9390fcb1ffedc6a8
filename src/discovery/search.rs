//! The search for the effects that are missing: one after the other, then each against all others in its place, then
//! without each.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::hypothesis::Member;
use super::refit::{Fitted, Study};
use super::responses::Response;
use super::samples::rms_m;
use super::screen::{Promise, screen};

/// How far the search goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Effects at most.
    pub(super) most_effects: usize,
    /// Score that an effect must add to be taken.
    pub(super) least_score: f64,
    /// Distance that an effect must move the tip, over the noise floor.
    pub(super) least_size: f64,
    /// The same for one effect more, over what those found before it do together.
    pub(super) least_share: f64,
    /// Sets whose scores are nearer are rivals.
    pub(super) rival_score: f64,
    /// Whether every hypothesis is refitted, whatever it promises at a first look.
    pub(super) thorough: bool,
}

/// A set of effects that was fitted, with its score.
#[derive(Clone, Debug)]
pub(super) struct Scored {
    pub(super) fitted: Fitted,
    /// Fall of the deviance since the model as given, less what its parameters and their choice cost.
    pub(super) score: f64,
}

/// What the search ends with.
pub(super) struct Found {
    /// The best set; empty when nothing is missing.
    pub(super) best: Scored,
    /// The model as given.
    pub(super) null: Scored,
    /// All sets that were fitted.
    pub(super) tried: Vec<Scored>,
    /// What every hypothesis promises at a first look, with the score that it would have.
    pub(super) looked_at: Vec<(Promise, f64)>,
    /// The answers of the tip that the looks went by.
    pub(super) responses: Vec<Response>,
}

/// Refits at a time at most.
const WIDTH: usize = 8;
/// Promises are taken to be right to this share of the best, or to so much.
const PROMISE_SHARE: f64 = 0.7;
const PROMISE_SLACK: f64 = 30.0;
/// A rough fit is taken to be right to this share of what the best one adds, or to so much.
const LEADING_SHARE: f64 = 0.4;
const LEADING_SLACK: f64 = 40.0;
/// A first look may be wrong by this share of the size.
const NEARLY: f64 = 0.7;
/// A first look that promises less than this, score and all, is not followed up; nor is a rough fit that is worse than
/// what it was to improve by this and by what makes a rival.
const HOPELESS: f64 = -6.0;

impl Study<'_> {
    /// Looks for the set of hypotheses that explains the samples best, one that pays for its parameters (extended
    /// Bayesian information criterion, Chen & Chen, Biometrika 95, 2008).
    pub(super) fn search(&self, mut responses: Vec<Response>, limits: &Limits) -> Option<Found> {
        let null = Scored { fitted: self.null()?, score: 0.0 };
        let promises = self.promises(&null.fitted, &[], &responses);
        if promises.iter().any(|promise| self.promised(promise) > limits.least_score + HOPELESS) {
            responses.extend(self.farther(&null.fitted, &promises, &responses));
        }
        Some(self.enlarged(null.clone(), null, Vec::new(), responses, limits))
    }

    /// Goes on from what a search has found, thoroughly: other single effects first, then more of them.
    pub(super) fn search_again(&self, found: Found, limits: &Limits) -> Found {
        let Found { mut best, null, mut tried, responses, .. } = found;
        let limits = Limits { thorough: true, ..*limits };
        if !best.fitted.members.is_empty() {
            let single = self.with_another(&null, &null, &responses, &limits, &mut tried);
            best = single.filter(|single| single.score > best.score).unwrap_or(best);
        }
        self.enlarged(best, null, tried, responses, &limits)
    }

    /// `best` with more effects, as long as each is worth having.
    fn enlarged(
        &self,
        mut best: Scored,
        null: Scored,
        mut tried: Vec<Scored>,
        responses: Vec<Response>,
        limits: &Limits,
    ) -> Found {
        while best.fitted.members.len() < limits.most_effects {
            let Some(next) = self.with_another(&best, &null, &responses, limits, &mut tried) else { break };
            best = self.swapped(next, &null, &responses, limits, &mut tried);
        }
        best = self.pruned(best, &null, limits, &mut tried);
        let looked_at = self.promises(&null.fitted, &[], &responses).into_iter().map(|promise| {
            let score = self.promised(&promise);
            (promise, score)
        });
        Found { best, tried, looked_at: looked_at.collect(), null, responses }
    }

    /// What a promise would add to the score.
    fn promised(&self, promise: &Promise) -> f64 {
        promise.gain - self.penalty(std::slice::from_ref(&promise.member))
    }

    /// Penalty of a set: half of it, the Bayesian information criterion, for its parameters, the rest for their choice
    /// among all hypotheses.
    fn penalty(&self, members: &[Member]) -> f64 {
        let numbers = (3.0 * self.samples.len() as f64).ln();
        let open = self.open.iter().filter(|open| **open).count().max(1);
        let choice = 2.0 * (open as f64).ln();
        members.iter().map(|member| self.hypotheses[member.hypothesis].freedom() as f64 * numbers + choice).sum()
    }

    fn scored(&self, fitted: Fitted, null: &Scored) -> Scored {
        let score = null.fitted.explained.deviance - fitted.explained.deviance - self.penalty(&fitted.members);
        Scored { fitted, score }
    }

    /// Fits `base` with each of the promising hypotheses besides: all roughly, which goes to `tried`, then the leading ones as
    /// well as can be.
    fn fitted_with(
        &self,
        base: &Scored,
        promises: &[Promise],
        responses: &[Response],
        null: &Scored,
        limits: &Limits,
        tried: &mut Vec<Scored>,
    ) -> Vec<Scored> {
        let Some(first) = promises.first() else { return Vec::new() };
        let (enough, width) = if limits.thorough {
            (f64::NEG_INFINITY, usize::MAX)
        } else {
            (first.gain - (PROMISE_SHARE * first.gain).max(PROMISE_SLACK), WIDTH)
        };
        let kept: Vec<&Promise> = promises.iter().take(width).filter(|promise| promise.gain >= enough).collect();
        let rough = self.roughly_with(base, &kept, responses);
        let top = rough.iter().map(|scored| scored.score).fold(base.score, f64::max);
        let leading = (top - (LEADING_SHARE * (top - base.score)).max(LEADING_SLACK))
            .max(base.score + HOPELESS - limits.rival_score);
        let (mut rough, others): (Vec<Scored>, Vec<Scored>) =
            rough.into_iter().partition(|scored| scored.score >= leading);
        tried.extend(others);
        rough.sort_by(|a, b| b.score.total_cmp(&a.score));
        rough.truncate(WIDTH);
        let finish = |scored: Scored| Some(self.scored(self.settled(scored.fitted.members)?, null));
        let finished: Vec<Scored> = rough.into_par_iter().filter_map(finish).collect();
        tried.extend(finished.iter().cloned());
        finished
    }

    /// `base` with each of the promised members, played coarsely on both sides.
    fn roughly_with(&self, base: &Scored, promises: &[&Promise], responses: &[Response]) -> Vec<Scored> {
        let coarse = Study { model: self.coarse, ..self.clone() };
        let Some(start) = coarse.again(&base.fitted) else { return Vec::new() };
        let fit = |promise: &&Promise| {
            let member = coarse.begun(&start, &promise.member);
            let jacobian = coarse.known_slopes(&start, &member, &responses[promise.response]);
            let all: Vec<Member> = start.members.iter().cloned().chain([member]).collect();
            let fitted = coarse.rough_fit(all, jacobian)?;
            let gain = start.explained.deviance - fitted.explained.deviance;
            let score = base.score + gain - self.penalty(std::slice::from_ref(&promise.member));
            Some(Scored { fitted, score })
        };
        promises.par_iter().filter_map(fit).collect()
    }

    /// What is known of the derivatives of `base` with `member` besides: those of the fit, and the first look's.
    fn known_slopes(&self, base: &Fitted, member: &Member, response: &Response) -> DMatrix<f64> {
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

    /// The promised member, nearer to nothing where the tip's answer is so far from linear that less of it fits better.
    fn begun(&self, base: &Fitted, promised: &Member) -> Member {
        let nothing = self.hypotheses[promised.hypothesis].without(&promised.values);
        let part = |share: f64| {
            let between = nothing.iter().zip(&promised.values).map(|(n, v)| n + share * (v - n)).collect();
            Member { values: between, ..*promised }
        };
        let mut best: Option<(f64, Member)> = None;
        for share in [1.0, 0.5, 0.25] {
            let member = part(share);
            let Some(deviance) = self.deviance(&base.members, &member) else { continue };
            if deviance < base.explained.deviance {
                return member;
            }
            match &best {
                Some((least, _)) if *least <= deviance => break,
                _ => best = Some((deviance, member)),
            }
        }
        best.map_or_else(|| promised.clone(), |(_, member)| member)
    }

    /// The fit, with every choice (such as a place) moved to its neighbours while that helps.
    fn settled(&self, start: Vec<Member>) -> Option<Fitted> {
        let mut best = self.fit(start)?;
        for k in 0..best.members.len() {
            loop {
                let hypothesis = &self.hypotheses[best.members[k].hypothesis];
                let beside = hypothesis.neighbours(&best.members[k].values);
                let fits = beside.into_iter().filter_map(|values| {
                    let mut members = best.members.clone();
                    members[k].values = values;
                    self.rough_fit(members, best.jacobian.clone())
                });
                let next = fits.min_by(|a, b| a.explained.deviance.total_cmp(&b.explained.deviance));
                match next.filter(|next| next.explained.deviance < best.explained.deviance) {
                    Some(next) => best = self.fit(next.members)?,
                    None => break,
                }
            }
        }
        Some(best)
    }

    fn promises(&self, from: &Fitted, without: &[usize], responses: &[Response]) -> Vec<Promise> {
        let mut promises =
            screen(self.hypotheses, responses, self.samples, self.nuisances, &from.explained, &from.jacobian);
        promises.retain(|promise| {
            let taken = |member: &Member| member.hypothesis == promise.member.hypothesis;
            let open = self.open[promise.member.hypothesis];
            open && !from.members.iter().any(taken) && !without.contains(&promise.member.hypothesis)
        });
        promises
    }

    /// The best set with one member more, if it is worth having.
    fn with_another(
        &self,
        best: &Scored,
        null: &Scored,
        responses: &[Response],
        limits: &Limits,
        tried: &mut Vec<Scored>,
    ) -> Option<Scored> {
        let mut promises = self.promises(&best.fitted, &[], responses);
        let least_m = limits.least_size * best.fitted.explained.noise.rms_m();
        promises.retain(|promise| {
            let score = self.promised(promise);
            limits.thorough || score > limits.least_score + HOPELESS && promise.size_m > NEARLY * least_m
        });
        let fits = self.fitted_with(best, &promises, responses, null, limits, tried);
        let moves = |next: &Scored| -> f64 {
            let moved = next.fitted.played.iter().zip(&best.fitted.played).map(|(there, here)| there - here);
            rms_m(&moved.collect::<Vec<f64>>())
        };
        // The laws of the effects found so far are right to a share of what they do: that much is no other effect's.
        let known: Vec<f64> = best.fitted.played.iter().zip(&null.fitted.played).map(|(a, b)| a - b).collect();
        let inexact_m = limits.least_share * rms_m(&known);
        let worth = |next: &Scored| {
            let least_m = inexact_m.max(limits.least_size * next.fitted.explained.noise.rms_m());
            moves(next) >= least_m && next.score >= best.score + limits.least_score
        };
        fits.into_iter().filter(worth).max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// The set with a member exchanged, as long as that helps: what was taken first may stand for two others.
    fn swapped(
        &self,
        mut best: Scored,
        null: &Scored,
        responses: &[Response],
        limits: &Limits,
        tried: &mut Vec<Scored>,
    ) -> Scored {
        if best.fitted.members.len() < 2 {
            return best;
        }
        loop {
            let mut better: Option<Scored> = None;
            for out in 0..best.fitted.members.len() {
                let mut rest = best.fitted.members.clone();
                let gone = rest.remove(out);
                let Some(without) = self.fit(rest).and_then(|fitted| self.sharpened(fitted)) else { continue };
                let without = self.scored(without, null);
                let mut promises = self.promises(&without.fitted, &[gone.hypothesis], responses);
                promises.truncate(WIDTH / 2);
                let fits = self.fitted_with(&without, &promises, responses, null, limits, tried);
                let top = fits.into_iter().max_by(|a, b| a.score.total_cmp(&b.score));
                if let Some(top) = top.filter(|top| top.score > better.as_ref().map_or(best.score, |b| b.score)) {
                    better = Some(top);
                }
            }
            match better {
                Some(next) => best = next,
                None => return best,
            }
        }
    }

    /// The set without the members that do not pay for themselves.
    fn pruned(&self, mut best: Scored, null: &Scored, limits: &Limits, tried: &mut Vec<Scored>) -> Scored {
        let mut k = 0;
        while best.fitted.members.len() > 1 && k < best.fitted.members.len() {
            let mut rest = best.fitted.members.clone();
            rest.remove(k);
            match self.fit(rest).map(|fitted| self.scored(fitted, null)) {
                Some(fewer) if fewer.score + limits.least_score > best.score => best = fewer,
                Some(fewer) => {
                    tried.push(fewer);
                    k += 1;
                }
                None => k += 1,
            }
        }
        best
    }
}
