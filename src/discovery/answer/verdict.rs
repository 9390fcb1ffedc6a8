//! From the search to the answer: its verdict, the effects with their intervals, and the words for them.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Number, Value};

use super::summary_text;
use crate::data::findings::{Candidate, FoundEffect, Verdict};
use crate::data::tables::round_significant;
use crate::discovery::fit::candidate::{Hypothesis, Member, set_of};
use crate::discovery::fit::gauss_newton::Study;
use crate::discovery::goodness_of_fit::Sign;
use crate::discovery::search::{Found, Scored};
use crate::effects::Seek;

/// What the search says of the effects.
pub(crate) struct Answer {
    pub(crate) verdict: Verdict,
    /// Members to be added to the model; empty where nothing is.
    pub(crate) members: Vec<Member>,
    pub(crate) effects: Vec<FoundEffect>,
    /// Where these data cannot tell: the sets that fit equally well.
    pub(crate) rivals: Vec<Vec<Member>>,
    /// Where the best set is not the answer: what speaks against it.
    pub(crate) against: String,
}

impl Answer {
    /// Nothing is added to the model.
    fn nothing(verdict: Verdict, against: String) -> Answer {
        Answer { verdict, members: Vec::new(), effects: Vec::new(), rivals: Vec::new(), against }
    }

    /// What an answer becomes once so much speaks against it.
    pub(crate) fn refuted(against: String) -> Answer {
        Answer::nothing(Verdict::Unexplained, against)
    }
}

/// Significant digits of what is written.
const DIGITS: usize = 6;
/// Candidates that are listed.
const LISTED: usize = 30;

impl Study<'_> {
    /// The answer, with rivals as `plain` has them, without what is particular to the best; `sign`: that something is
    /// still missing with the best set.
    pub(crate) fn answer(&self, plain: &Study, found: &Found, sign: Option<Sign>, rival_score: f64) -> Answer {
        let members: Vec<Member> = found.best.fitted.members.iter().map(|member| self.rounded(member)).collect();
        if let Some(sign) = sign {
            return Answer::refuted(summary_text::against(&sign));
        }
        if members.is_empty() {
            return Answer::nothing(Verdict::Consistent, String::new());
        }
        let rivals = self.rivals(found, rival_score);
        let mut effects: Vec<FoundEffect> =
            (0..members.len()).map(|k| self.found_effect(&found.best, k, found)).collect();
        for (k, effect) in effects.iter_mut().enumerate() {
            effect.confusable_with = rivals[k].iter().map(|&(rival, _)| self.beside(rival, &members[k])).collect();
        }
        let verdict = if rivals.iter().all(Vec::is_empty) { Verdict::Named } else { Verdict::Ambiguous };
        let mut listed = set_of(&members);
        for &(rival, scored) in rivals.iter().flatten() {
            let place = scored.fitted.members.iter().position(|member| member.hypothesis == rival);
            if let Some(place) = place.filter(|_| listed.insert(rival)) {
                let mut effect = plain.found_effect(scored, place, found);
                let replaced =
                    members.iter().zip(&rivals).filter(|(_, instead)| instead.iter().any(|&(other, _)| other == rival));
                let own = &scored.fitted.members[place];
                effect.confusable_with = replaced.map(|(member, _)| self.beside(member.hypothesis, own)).collect();
                effects.push(effect);
            }
        }
        let mut sets = vec![members.clone()];
        for (_, rival) in rivals.iter().flatten() {
            if !sets.contains(&rival.fitted.members) {
                sets.push(rival.fitted.members.clone());
            }
        }
        Answer { verdict, members, effects, rivals: sets, against: String::new() }
    }

    /// The member with values as they are written: six significant digits, more than any recording holds.
    fn rounded(&self, member: &Member) -> Member {
        let values = member.values.iter().map(|&value| round_significant(value, DIGITS)).collect();
        Member { values, ..*member }
    }

    /// The name of a hypothesis that could stand for `member`, with its tendon if nothing else tells them apart.
    fn beside(&self, rival: usize, member: &Member) -> String {
        let [rival, own] = [rival, member.hypothesis].map(|number| &self.hypotheses[number]);
        if rival.card.name == own.card.name { rival.label() } else { rival.card.name.to_owned() }
    }

    /// For each member of the best set, the hypotheses that could stand in its place, with the set that has them.
    fn rivals<'f>(&self, found: &'f Found, rival_score: f64) -> Vec<Vec<(usize, &'f Scored)>> {
        let best = &found.best;
        let own = set_of(&best.fitted.members);
        let mut rivals: Vec<Vec<(usize, &Scored)>> = vec![Vec::new(); best.fitted.members.len()];
        for scored in found.tried.iter().filter(|scored| scored.rivals(best, rival_score)) {
            let theirs = set_of(&scored.fitted.members);
            for &other in theirs.difference(&own) {
                for (instead, member) in rivals.iter_mut().zip(&best.fitted.members) {
                    let known = instead.iter().any(|(known, _)| *known == other);
                    if !theirs.contains(&member.hypothesis) && !known {
                        instead.push((other, scored));
                    }
                }
            }
        }
        rivals
    }

    fn found_effect(&self, scored: &Scored, k: usize, found: &Found) -> FoundEffect {
        let member = &scored.fitted.members[k];
        let hypothesis = &self.hypotheses[member.hypothesis];
        let intervals = self.intervals(&scored.fitted, k);
        let mut parameters = BTreeMap::new();
        let mut interval_95 = BTreeMap::new();
        for (index, parameter) in hypothesis.card.parameters.iter().enumerate() {
            let value = member.values[index];
            let shown = match parameter.seek {
                Seek::Tendon => Value::from(value as u64),
                Seek::Flag => Value::Bool(value != 0.0),
                _ => number(value),
            };
            put(&mut parameters, parameter.name, shown);
            if parameter.seek == Seek::Flag {
                continue;
            }
            if let Some([low, high]) = intervals.get(&index) {
                put(&mut interval_95, parameter.name, Value::Array(vec![self::number(*low), self::number(*high)]));
            }
        }
        FoundEffect {
            name: hypothesis.card.name.to_owned(),
            parameters,
            interval_95,
            confidence: self.confidence(member.hypothesis, found),
            confusable_with: Vec::new(),
        }
    }

    /// Posterior probability that this hypothesis is among those missing: the share of all sets that were fitted, each at its
    /// best and weighted by exp(score / 2), that hold it.
    fn confidence(&self, hypothesis: usize, found: &Found) -> f64 {
        let mut scores: BTreeMap<BTreeSet<usize>, f64> = BTreeMap::new();
        for scored in found.tried.iter().chain([&found.null]) {
            let best = scores.entry(set_of(&scored.fitted.members)).or_insert(scored.score);
            *best = best.max(scored.score);
        }
        // A set that is not worth having may fit far better than the answer.
        let top = scores.values().copied().fold(f64::NEG_INFINITY, f64::max);
        let weight = |score: &f64| (0.5 * (score - top)).exp();
        let all: f64 = scores.values().map(weight).sum();
        scores.iter().filter(|(set, _)| set.contains(&hypothesis)).map(|(_, score)| weight(score)).sum::<f64>() / all
    }

    /// The candidates, the best first; `after_m` gives the error of a set on trials that its fit has not seen.
    pub(crate) fn candidates(
        &self,
        found: &Found,
        answer: &Answer,
        rival_score: f64,
        after_m: &dyn Fn(&Scored) -> f64,
    ) -> Vec<Candidate> {
        let mut tried: Vec<&Scored> = found.tried.iter().chain([&found.null]).collect();
        tried.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut listed: Vec<Candidate> = Vec::new();
        let mut seen = BTreeSet::new();
        for scored in tried {
            if listed.len() < LISTED && seen.insert(set_of(&scored.fitted.members)) {
                let name = set_name(self.hypotheses, &scored.fitted.members);
                let why_not = self.why_not(found, answer, scored, rival_score);
                listed.push(Candidate { name, score: scored.score, after_m: after_m(scored), why_not });
            }
        }
        // Every effect of the catalogue is accounted for.
        for (promise, score) in &found.looked_at {
            if seen.insert(BTreeSet::from([promise.member.hypothesis])) {
                let name = set_name(self.hypotheses, std::slice::from_ref(&promise.member));
                let left = (-promise.gain / (6.0 * self.samples.len() as f64)).exp();
                let after_m = left * crate::discovery::recording::samples::rms_m(&found.null.fitted.explained.left_m);
                let why_not = "not followed up: a first look, linear, promises no more than this".to_owned();
                listed.push(Candidate { name, score: *score, after_m, why_not });
            }
        }
        listed
    }

    fn why_not(&self, found: &Found, answer: &Answer, scored: &Scored, rival_score: f64) -> String {
        let best = &found.best;
        let own: Vec<Member> = scored.fitted.members.iter().map(|member| self.rounded(member)).collect();
        if own == answer.members && answer.verdict != Verdict::Unexplained {
            return String::new();
        }
        let behind = best.score - scored.score;
        if answer.verdict == Verdict::Unexplained && scored.fitted.members == best.fitted.members {
            let rank = if own.is_empty() { "no candidate is better" } else { "the best of the catalogue" };
            return format!("{rank}, and yet {}", answer.against);
        }
        if scored.fitted.members.len() > best.fitted.members.len() {
            let why = if behind < 0.0 {
                "fits better, but adds too little to be worth a name"
            } else {
                "does not pay for its parameters"
            };
            return format!("one effect more {why}");
        }
        if behind < rival_score {
            return "fits equally well: these data cannot tell".to_owned();
        }
        format!("fits worse: its score is {behind:.0} lower")
    }
}

/// The effects of a set, joined.
pub(crate) fn set_name(hypotheses: &[Hypothesis], members: &[Member]) -> String {
    if members.is_empty() {
        return "nothing missing".to_owned();
    }
    members.iter().map(|member| hypotheses[member.hypothesis].label()).collect::<Vec<_>>().join(" + ")
}

fn number(value: f64) -> Value {
    Number::from_f64(round_significant(value, DIGITS)).map_or(Value::Null, Value::Number)
}

/// Puts a value under its name; components of a vector (`name[k]`, in order) into a list.
fn put(map: &mut BTreeMap<String, Value>, name: &str, value: Value) {
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
