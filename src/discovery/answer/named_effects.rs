//! The effects of an answer with their values, intervals and rivals.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Number, Value};

use crate::data::findings::FoundEffect;
use crate::data::tables::round_significant;
use crate::discovery::fit::candidate::{SetMember, candidate_set};
use crate::discovery::fit::gauss_newton::FitProblem;
use crate::discovery::search::{ScoredSet, SearchOutcome};
use crate::effects::Seek;

/// Significant digits of written values.
pub(crate) const DIGITS: usize = 6;

/// A candidate that can replace a member of the best set, with the set in which it does.
#[derive(Clone, Copy)]
pub(crate) struct Rival<'a> {
    candidate: usize,
    set: &'a ScoredSet,
}

/// The effects of an answer.
#[derive(Default)]
pub(crate) struct NamedEffects {
    /// Effects of the best set, then those of its rivals.
    pub(crate) effects: Vec<FoundEffect>,
    /// The best set and its rivals.
    pub(crate) sets: Vec<Vec<SetMember>>,
}

impl SetMember {
    /// The member with values as written.
    pub(crate) fn rounded(&self) -> SetMember {
        let values = self.values.iter().map(|&value| round_significant(value, DIGITS)).collect();
        SetMember { values, ..*self }
    }
}

impl SearchOutcome {
    /// The best set with values as written.
    pub(crate) fn rounded_members(&self) -> Vec<SetMember> {
        self.best.fitted.members.iter().map(SetMember::rounded).collect()
    }

    /// For each member of the best set, the candidates that can replace it.
    pub(crate) fn rivals(&self, rival_score: f64) -> Vec<Vec<Rival<'_>>> {
        let members = &self.best.fitted.members;
        let best_candidates = candidate_set(members);
        let mut rivals: Vec<Vec<Rival>> = vec![Vec::new(); members.len()];
        for set in self.tried.iter().filter(|scored| self.is_rival(scored, rival_score)) {
            let rival_candidates = candidate_set(&set.fitted.members);
            for &candidate in rival_candidates.difference(&best_candidates) {
                for (replacements, member) in rivals.iter_mut().zip(members) {
                    let is_listed = replacements.iter().any(|rival| rival.candidate == candidate);
                    // A candidate replaces a member only in a set that does without this member.
                    if !rival_candidates.contains(&member.candidate) && !is_listed {
                        replacements.push(Rival { candidate, set });
                    }
                }
            }
        }
        rivals
    }

    /// Posterior probability of a candidate: share of the fitted sets, weighted by exp(score / 2),
    /// that contain it. Where trials decide, all sets that fit them equally well have the same.
    fn confidence(&self, candidate: usize) -> f64 {
        if let Some(evidence) = &self.by_trials {
            return 1.0 / (1.0 + evidence.equals.len() as f64);
        }
        let mut scores: BTreeMap<BTreeSet<usize>, f64> = BTreeMap::new();
        for scored in self.tried.iter().chain([&self.null]) {
            // A set may be fitted from several starts; its best score counts once.
            let best = scores.entry(candidate_set(&scored.fitted.members)).or_insert(scored.score);
            *best = best.max(scored.score);
        }
        // A set that is not worth naming may fit far better than the answer.
        let largest = scores.values().copied().fold(f64::NEG_INFINITY, f64::max);
        // exp(score / 2) approximates the marginal likelihood (Schwarz, Annals of Statistics 6,
        // 1978).
        let weight = |score: &f64| (0.5 * (score - largest)).exp();
        let all: f64 = scores.values().map(weight).sum();
        scores
            .iter()
            .filter(|(set, _)| set.contains(&candidate))
            .map(|(_, score)| weight(score))
            .sum::<f64>()
            / all
    }
}

impl FitProblem<'_> {
    /// The effects of the best set, fitted by this problem, and those of its `rivals`, fitted by
    /// that of the search.
    pub(crate) fn named_effects(
        &self,
        search_problem: &FitProblem,
        outcome: &SearchOutcome,
        rivals: &[Vec<Rival>],
    ) -> NamedEffects {
        let members = outcome.rounded_members();
        let mut effects = Vec::new();
        for (index, member) in members.iter().enumerate() {
            let confusable_with = rivals[index]
                .iter()
                .map(|rival| self.rival_label(rival.candidate, member))
                .collect();
            effects.push(FoundEffect {
                confusable_with,
                ..self.found_effect(&outcome.best, index, outcome)
            });
        }
        let mut listed = candidate_set(&members);
        let mut sets = vec![members.clone()];
        for rival in rivals.iter().flatten() {
            let set = &rival.set.fitted.members;
            if !sets.contains(set) {
                sets.push(set.clone());
            }
            let index = set.iter().position(|member| member.candidate == rival.candidate);
            // A rival in several sets is reported once, in the first one.
            let Some(index) = index.filter(|_| listed.insert(rival.candidate)) else { continue };
            let replaced = members.iter().zip(rivals).filter(|(_, replacements)| {
                replacements.iter().any(|other| other.candidate == rival.candidate)
            });
            let confusable_with = replaced
                .map(|(member, _)| self.rival_label(member.candidate, &set[index]))
                .collect();
            effects.push(FoundEffect {
                confusable_with,
                ..search_problem.found_effect(rival.set, index, outcome)
            });
        }
        NamedEffects { effects, sets }
    }

    /// Name of a rival of `member`, with its tendon if the names are equal.
    fn rival_label(&self, rival: usize, member: &SetMember) -> String {
        let [rival, replaced] = [rival, member.candidate].map(|number| &self.candidates[number]);
        if rival.card.name == replaced.card.name {
            rival.label()
        } else {
            rival.card.name.to_owned()
        }
    }

    /// The effect of member `index`, without its rivals.
    fn found_effect(
        &self,
        scored: &ScoredSet,
        index: usize,
        outcome: &SearchOutcome,
    ) -> FoundEffect {
        let member = &scored.fitted.members[index];
        let card = self.candidates[member.candidate].card;
        let intervals = self.intervals(&scored.fitted, index);
        // Amplitudes in single trials differ more than noise does where the model is not exact.
        let half_width = outcome.by_trials.as_ref().map_or(0.0, |evidence| evidence.half_width);
        let mut parameters = BTreeMap::new();
        let mut interval_95 = BTreeMap::new();
        for (number, parameter) in card.parameters.iter().enumerate() {
            let value = member.values[number];
            let written = match parameter.seek {
                // The whole robot is no segment.
                Seek::Segment if value == 0.0 => continue,
                Seek::Tendon | Seek::Segment => Value::from(value as u64),
                Seek::Flag | Seek::Convention => Value::Bool(value != 0.0),
                _ => rounded_number(value),
            };
            insert_parameter(&mut parameters, parameter.name, written);
            let is_number =
                !matches!(parameter.seek, Seek::Flag | Seek::Convention | Seek::Segment);
            let Some(&[low, high]) = intervals.get(&number).filter(|_| is_number) else {
                continue;
            };
            // The half width is relative, and the size is counted from where the effect is nothing.
            let half = half_width * (value - parameter.null).abs();
            let ends = [low.min(value - half), high.max(value + half)];
            insert_parameter(
                &mut interval_95,
                parameter.name,
                Value::Array(ends.map(rounded_number).to_vec()),
            );
        }
        FoundEffect {
            name: card.name.to_owned(),
            parameters,
            interval_95,
            confidence: outcome.confidence(member.candidate),
            confusable_with: Vec::new(),
        }
    }
}

fn rounded_number(value: f64) -> Value {
    Number::from_f64(round_significant(value, DIGITS)).map_or(Value::Null, Value::Number)
}

/// Inserts a value under its name; components of a vector (`name[k]`, in order) into a list.
fn insert_parameter(map: &mut BTreeMap<String, Value>, name: &str, value: Value) {
    let Some((vector, _)) = name.split_once('[') else {
        map.insert(name.to_owned(), value);
        return;
    };
    let list = map.entry(vector.to_owned()).or_insert_with(|| Value::Array(Vec::new()));
    if let Value::Array(items) = list {
        items.push(value);
    }
}
