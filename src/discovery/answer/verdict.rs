//! Decides the verdict: `consistent`, `named`, `ambiguous` or `unexplained`, with the effects, their intervals and
//! their rivals.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Number, Value};

use super::summary_text;
use crate::data::findings::{Candidate, FoundEffect, Verdict};
use crate::data::tables::round_significant;
use crate::discovery::fit::candidate::{CandidateEffect, SetMember, candidate_set};
use crate::discovery::fit::gauss_newton::FitProblem;
use crate::discovery::goodness_of_fit::test_result::TestResult;
use crate::discovery::search::{ScoredSet, SearchOutcome};
use crate::effects::Seek;

/// The decision.
pub(crate) struct Decision {
    pub(crate) verdict: Verdict,
    /// Members added to the model; empty if none.
    pub(crate) members: Vec<SetMember>,
    pub(crate) effects: Vec<FoundEffect>,
    /// For `ambiguous`: sets that fit equally well.
    pub(crate) rivals: Vec<Vec<SetMember>>,
    /// Objection to the best set, if it is not the answer or not all of it.
    pub(crate) objection: String,
}

impl Decision {
    /// A decision that adds nothing to the model.
    fn without_effects(verdict: Verdict, objection: String) -> Decision {
        Decision { verdict, members: Vec::new(), effects: Vec::new(), rivals: Vec::new(), objection }
    }

    /// The decision after an objection.
    pub(crate) fn refuted(objection: String) -> Decision {
        Decision::without_effects(Verdict::Unexplained, objection)
    }
}

/// Significant digits of written values.
const DIGITS: usize = 6;
/// Maximum number of listed candidates.
const LISTED: usize = 30;

impl FitProblem<'_> {
    /// Decides the verdict. `plain`: fit problem of the search, for rivals; `sign`: failed goodness-of-fit test of the
    /// best set; `most`: whether that set explains most of the gap of a robot that the model does not describe exactly,
    /// so that it is named although something remains.
    pub(crate) fn decide(
        &self,
        plain: &FitProblem,
        found: &SearchOutcome,
        (sign, most): (Option<TestResult>, bool),
        rival_score: f64,
    ) -> Decision {
        let members: Vec<SetMember> = found.best.fitted.members.iter().map(|member| self.rounded(member)).collect();
        let objection = sign.map_or_else(String::new, |sign| summary_text::objection(&sign));
        if sign.is_some() && (members.is_empty() || !most) {
            return Decision::refuted(objection);
        }
        if members.is_empty() {
            return Decision::without_effects(Verdict::Consistent, String::new());
        }
        let rivals = self.rivals(found, rival_score);
        let mut effects: Vec<FoundEffect> =
            (0..members.len()).map(|k| self.found_effect(&found.best, k, found)).collect();
        for (k, effect) in effects.iter_mut().enumerate() {
            effect.confusable_with = rivals[k].iter().map(|&(rival, _)| self.rival_label(rival, &members[k])).collect();
        }
        let verdict = if rivals.iter().all(Vec::is_empty) { Verdict::Named } else { Verdict::Ambiguous };
        let mut listed = candidate_set(&members);
        for &(rival, scored) in rivals.iter().flatten() {
            let place = scored.fitted.members.iter().position(|member| member.candidate == rival);
            if let Some(place) = place.filter(|_| listed.insert(rival)) {
                let mut effect = plain.found_effect(scored, place, found);
                let replaced =
                    members.iter().zip(&rivals).filter(|(_, instead)| instead.iter().any(|&(other, _)| other == rival));
                let own = &scored.fitted.members[place];
                effect.confusable_with = replaced.map(|(member, _)| self.rival_label(member.candidate, own)).collect();
                effects.push(effect);
            }
        }
        let mut sets = vec![members.clone()];
        for (_, rival) in rivals.iter().flatten() {
            if !sets.contains(&rival.fitted.members) {
                sets.push(rival.fitted.members.clone());
            }
        }
        Decision { verdict, members, effects, rivals: sets, objection }
    }

    /// The member with values as written, six significant digits.
    fn rounded(&self, member: &SetMember) -> SetMember {
        let values = member.values.iter().map(|&value| round_significant(value, DIGITS)).collect();
        SetMember { values, ..*member }
    }

    /// Name of a rival of `member`, with its tendon if the names are equal.
    fn rival_label(&self, rival: usize, member: &SetMember) -> String {
        let [rival, own] = [rival, member.candidate].map(|number| &self.candidates[number]);
        if rival.card.name == own.card.name { rival.label() } else { rival.card.name.to_owned() }
    }

    /// For each member of the best set, the candidates that can replace it, with their sets.
    fn rivals<'f>(&self, found: &'f SearchOutcome, rival_score: f64) -> Vec<Vec<(usize, &'f ScoredSet)>> {
        let best = &found.best;
        let own = candidate_set(&best.fitted.members);
        let mut rivals: Vec<Vec<(usize, &ScoredSet)>> = vec![Vec::new(); best.fitted.members.len()];
        for scored in found.tried.iter().filter(|scored| found.is_rival(scored, rival_score)) {
            let theirs = candidate_set(&scored.fitted.members);
            for &other in theirs.difference(&own) {
                for (instead, member) in rivals.iter_mut().zip(&best.fitted.members) {
                    let known = instead.iter().any(|(known, _)| *known == other);
                    if !theirs.contains(&member.candidate) && !known {
                        instead.push((other, scored));
                    }
                }
            }
        }
        rivals
    }

    fn found_effect(&self, scored: &ScoredSet, k: usize, found: &SearchOutcome) -> FoundEffect {
        let member = &scored.fitted.members[k];
        let candidate = &self.candidates[member.candidate];
        let intervals = self.intervals(&scored.fitted, k);
        let mut parameters = BTreeMap::new();
        let mut interval_95 = BTreeMap::new();
        for (index, parameter) in candidate.card.parameters.iter().enumerate() {
            let value = member.values[index];
            let shown = match parameter.seek {
                Seek::Tendon => Value::from(value as u64),
                Seek::Flag => Value::Bool(value != 0.0),
                _ => rounded_number(value),
            };
            insert_parameter(&mut parameters, parameter.name, shown);
            if parameter.seek == Seek::Flag {
                continue;
            }
            if let Some(&[low, high]) = intervals.get(&index) {
                // What single trials tell differs more than noise does where the model is not exact.
                let half = found.by_trials.as_ref().map_or(0.0, |evidence| evidence.half_width)
                    * (value - parameter.null).abs();
                let [low, high] = [low.min(value - half), high.max(value + half)];
                insert_parameter(
                    &mut interval_95,
                    parameter.name,
                    Value::Array(vec![rounded_number(low), rounded_number(high)]),
                );
            }
        }
        FoundEffect {
            name: candidate.card.name.to_owned(),
            parameters,
            interval_95,
            confidence: self.confidence(member.candidate, found),
            confusable_with: Vec::new(),
        }
    }

    /// Posterior probability of a candidate: share of the fitted sets, weighted by exp(score / 2), that contain it. Where
    /// trials decide, all sets that fit them equally well have the same.
    fn confidence(&self, candidate: usize, found: &SearchOutcome) -> f64 {
        if let Some(evidence) = &found.by_trials {
            return 1.0 / (1.0 + evidence.equals.len() as f64);
        }
        let mut scores: BTreeMap<BTreeSet<usize>, f64> = BTreeMap::new();
        for scored in found.tried.iter().chain([&found.null]) {
            let best = scores.entry(candidate_set(&scored.fitted.members)).or_insert(scored.score);
            *best = best.max(scored.score);
        }
        // A set that is not worth naming may fit far better than the answer.
        let top = scores.values().copied().fold(f64::NEG_INFINITY, f64::max);
        let weight = |score: &f64| (0.5 * (score - top)).exp();
        let all: f64 = scores.values().map(weight).sum();
        scores.iter().filter(|(set, _)| set.contains(&candidate)).map(|(_, score)| weight(score)).sum::<f64>() / all
    }

    /// The candidates, best first; `after_m` returns the leave-one-out error of a set.
    pub(crate) fn candidate_rows(
        &self,
        found: &SearchOutcome,
        answer: &Decision,
        rival_score: f64,
        after_m: &dyn Fn(&ScoredSet) -> f64,
    ) -> Vec<Candidate> {
        let mut tried: Vec<&ScoredSet> = found.tried.iter().chain([&found.null]).collect();
        tried.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut listed: Vec<Candidate> = Vec::new();
        let mut seen = BTreeSet::new();
        for scored in tried {
            if listed.len() < LISTED && seen.insert(candidate_set(&scored.fitted.members)) {
                let name = set_name(self.candidates, &scored.fitted.members);
                let why_not = self.why_not(found, answer, scored, rival_score);
                let parameters = parameter_text(self.candidates, &scored.fitted.members);
                listed.push(Candidate { name, score: scored.score, after_m: after_m(scored), why_not, parameters });
            }
        }
        // Every effect of the catalogue is listed.
        for (prediction, score) in &found.screened {
            if seen.insert(BTreeSet::from([prediction.member.candidate])) {
                let name = set_name(self.candidates, std::slice::from_ref(&prediction.member));
                let left = (-prediction.gain / (6.0 * self.samples.len() as f64)).exp();
                let after_m =
                    left * crate::discovery::recording::samples::rms_m(&found.null.fitted.nuisance_fit.residual_m);
                let why_not = "not fitted: the linear screening predicts no more than this".to_owned();
                listed.push(Candidate { name, score: *score, after_m, why_not, parameters: String::new() });
            }
        }
        listed
    }

    fn why_not(&self, found: &SearchOutcome, answer: &Decision, scored: &ScoredSet, rival_score: f64) -> String {
        let best = &found.best;
        let own: Vec<SetMember> = scored.fitted.members.iter().map(|member| self.rounded(member)).collect();
        if own == answer.members && answer.verdict != Verdict::Unexplained {
            return String::new();
        }
        let behind = best.score - scored.score;
        if answer.verdict == Verdict::Unexplained && scored.fitted.members == best.fitted.members {
            let rank = if own.is_empty() { "no candidate is better" } else { "the best candidate" };
            return format!("{rank}, but {}", answer.objection);
        }
        if scored.fitted.members.len() > best.fitted.members.len() {
            let why = if behind < 0.0 {
                "improves the fit by too little to be named"
            } else {
                "does not justify its parameters"
            };
            return format!("the additional effect {why}");
        }
        if found.is_rival(scored, rival_score) {
            return "fits equally well: these data cannot tell the two apart".to_owned();
        }
        if found.by_trials.is_some() {
            return "does not fit unseen trials better by more than the model leaves on this robot anyway".to_owned();
        }
        format!("fits worse: score lower by {behind:.0}")
    }
}

/// Names of the effects of a set, joined.
pub(crate) fn set_name(candidates: &[CandidateEffect], members: &[SetMember]) -> String {
    if members.is_empty() {
        return "nothing missing".to_owned();
    }
    members.iter().map(|member| candidates[member.candidate].label()).collect::<Vec<_>>().join(" + ")
}

/// Parameters of a set as `effect.parameter=value`, joined.
fn parameter_text(candidates: &[CandidateEffect], members: &[SetMember]) -> String {
    let of = |member: &SetMember| {
        let card = candidates[member.candidate].card;
        let each = card.parameters.iter().zip(&member.values);
        let told = each.map(|(own, &value)| format!("{}.{}={}", card.name, own.name, round_significant(value, DIGITS)));
        told.collect::<Vec<String>>().join("; ")
    };
    members.iter().map(of).collect::<Vec<String>>().join("; ")
}

fn rounded_number(value: f64) -> Value {
    Number::from_f64(round_significant(value, DIGITS)).map_or(Value::Null, Value::Number)
}

/// Inserts a value under its name; components of a vector (`name[k]`, in order) into a list.
fn insert_parameter(map: &mut BTreeMap<String, Value>, name: &str, value: Value) {
    match name.split_once('[') {
        None => {
            map.insert(name.to_owned(), value);
        }
        Some((vector, _)) => {
            let list = map.entry(vector.to_owned()).or_insert_with(|| Value::Array(Vec::new()));
            if let Value::Array(items) = list {
                items.push(value);
            }
        }
    }
}
