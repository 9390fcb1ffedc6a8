//! Scores of an answer against the sealed truth.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::baselines::BaselineAnswers;
use super::injection::injected_effects::{
    InjectedEffect, effect_label, null_value, size, tendon_parameter,
};
use super::options::{CaseBatch, CaseGroup};
use super::truth::Truth;
use crate::data::findings::{CaseRow, Findings, FoundEffect, IntervalRow, OR, Verdict};
use crate::effects::{Model, Parameter, card};
use crate::math::summary::quantile;

/// Answer to a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseAnswer {
    /// The verdict.
    pub verdict: Verdict,
    /// Named effects, or those that the data cannot tell apart.
    pub effects: Vec<AnsweredEffect>,
    /// Held-out error of the given model, metres.
    pub before_m: f64,
    /// With the effects, metres.
    pub after_m: f64,
    /// With the stiffness refitted, metres; NaN if the fit failed.
    pub stiffness_only_m: f64,
    /// With the paper's Gaussian process on the residual, metres; NaN if the fit failed.
    pub gp_m: f64,
    /// Estimated noise floor, metres.
    pub floor_m: f64,
}

/// An effect of an answer. Parameters by their card names, vectors by component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AnsweredEffect {
    /// Its name.
    pub name: String,
    /// Values.
    pub values: BTreeMap<String, f64>,
    /// 95 % intervals.
    pub intervals: BTreeMap<String, [f64; 2]>,
    /// Posterior probability, as `discover` reports it.
    pub confidence: f64,
}

impl CaseAnswer {
    /// From findings and the held-out errors of both alternatives, metres.
    pub fn new(
        findings: &Findings,
        stiffness_only_m: Option<f64>,
        gp_m: Option<f64>,
    ) -> CaseAnswer {
        CaseAnswer {
            verdict: findings.verdict,
            effects: findings.effects.iter().map(AnsweredEffect::new).collect(),
            before_m: findings.gap.before_m,
            after_m: findings.gap.after_m,
            stiffness_only_m: stiffness_only_m.unwrap_or(f64::NAN),
            gp_m: gp_m.unwrap_or(f64::NAN),
            floor_m: findings.noise_floor_m,
        }
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            self.effects.iter().map(|effect| effect.name.clone()).collect();
        names.sort_unstable();
        names
    }

    /// Probability of each effect: its confidence, over their sum where that is more than one (the
    /// effects of a set are each sure). Nothing where no effect is named.
    fn probabilities(&self) -> BTreeMap<String, f64> {
        let sum: f64 = self.effects.iter().map(|effect| effect.confidence).sum();
        let probability = |effect: &AnsweredEffect| effect.confidence / sum.max(1.0);
        self.effects.iter().map(|effect| (effect.label(), probability(effect))).collect()
    }
}

impl AnsweredEffect {
    fn new(effect: &FoundEffect) -> AnsweredEffect {
        let mut values = BTreeMap::new();
        let mut intervals = BTreeMap::new();
        let ends = |value: &Value| Some([value.get(0)?.as_f64()?, value.get(1)?.as_f64()?]);
        for (name, value) in &effect.parameters {
            match value {
                Value::Array(items) => items.iter().enumerate().for_each(|(k, item)| {
                    values.extend(item.as_f64().map(|number| (format!("{name}[{k}]"), number)));
                }),
                value => values.extend(value.as_f64().map(|number| (name.clone(), number))),
            }
        }
        for (name, value) in &effect.interval_95 {
            match value {
                Value::Array(items) if items.iter().any(Value::is_array) => {
                    items.iter().enumerate().for_each(|(k, item)| {
                        intervals.extend(ends(item).map(|ends| (format!("{name}[{k}]"), ends)));
                    });
                }
                value => intervals.extend(ends(value).map(|ends| (name.clone(), ends))),
            }
        }
        let (name, confidence) = (effect.name.clone(), effect.confidence);
        AnsweredEffect { name, values, intervals, confidence }
    }

    /// Its name, with its tendon if it acts on one.
    fn label(&self) -> String {
        let card = card(&self.name);
        let tendon = card.and_then(|card| {
            self.values.get(card.parameters[tendon_parameter(card)?].name).copied()
        });
        effect_label(&self.name, tendon)
    }
}

/// A case without its truth.
#[derive(Clone, Copy, Debug)]
pub struct CaseSetting<'a> {
    /// Number of the case.
    pub number: u64,
    /// The batch that it belongs to.
    pub batch: &'a CaseBatch,
    /// Correlation of consecutive noise samples.
    pub correlation: f64,
}

/// Rows of a case in the tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScoredCase {
    /// The case.
    pub row: CaseRow,
    /// Scored intervals: those of correctly named effects.
    pub intervals: Vec<IntervalRow>,
}

/// Answers to one recording.
#[derive(Clone, Copy, Debug)]
pub struct CaseAnswers<'a> {
    /// That of `discover`.
    pub discover: &'a CaseAnswer,
    /// Those of the methods of comparison.
    pub baselines: &'a BaselineAnswers,
}

/// Scores an answered case.
pub fn score(
    setting: CaseSetting,
    model: &Model,
    truth: &Truth,
    CaseAnswers { discover: answer, baselines }: CaseAnswers,
) -> ScoredCase {
    let mut row = row(setting, Some(truth));
    let mut intervals = Vec::new();
    row.verdict = answer.verdict.name().to_owned();
    row.answer = answer.names().join(" + ");
    (row.right, row.in_group) = is_right(setting.batch.group, truth, answer);
    if row.right {
        let errors: Vec<f64> = truth
            .hidden
            .iter()
            .filter_map(|hidden| strength_error(model, hidden, answer))
            .collect();
        row.strength_error = if errors.is_empty() { f64::NAN } else { quantile(&errors, 0.5) };
        // Parameters of another law are not comparable.
        let comparable = truth.hidden.iter().filter(|hidden| !hidden.other_law);
        intervals = comparable.flat_map(|hidden| self::intervals(&row, hidden, answer)).collect();
    }
    row.intervals = intervals.len() as u64;
    row.covered = intervals.iter().filter(|interval| interval.covered).count() as u64;
    row.before_m = answer.before_m;
    row.after_m = answer.after_m;
    row.stiffness_only_m = answer.stiffness_only_m;
    row.gp_m = answer.gp_m;
    row.floor_m = answer.floor_m;
    row.isolation = isolation(truth, &answer.probabilities());
    add_baselines(&mut row, truth, baselines);
    ScoredCase { row, intervals }
}

/// A case without an answer, with the reason. `truth`: if it is known.
pub fn failed(setting: CaseSetting, truth: Option<&Truth>, why: &str) -> ScoredCase {
    let row = CaseRow { verdict: format!("failed: {why}"), ..row(setting, truth) };
    ScoredCase { row, intervals: Vec::new() }
}

fn row(CaseSetting { number, batch, correlation }: CaseSetting, truth: Option<&Truth>) -> CaseRow {
    CaseRow {
        case: number,
        group: batch.group.name().to_owned(),
        truth: truth.map_or_else(String::new, Truth::name),
        shift_m: truth.map_or(f64::NAN, |truth| truth.shift_m),
        noise_m: batch.noise_m,
        correlation,
        samples: batch.samples as u64,
        verdict: String::new(),
        answer: String::new(),
        right: false,
        in_group: false,
        imitations: truth.map_or_else(String::new, |truth| truth.imitations.join(OR)),
        strength_error: f64::NAN,
        intervals: 0,
        covered: 0,
        before_m: f64::NAN,
        after_m: f64::NAN,
        stiffness_only_m: f64::NAN,
        gp_m: f64::NAN,
        floor_m: f64::NAN,
        isolation: f64::NAN,
        sparse_answer: String::new(),
        sparse_isolation: f64::NAN,
        sparse_m: f64::NAN,
        ridge_detects: false,
        ridge_isolation: f64::NAN,
        ridge_m: f64::NAN,
        library_detects: false,
        library_m: f64::NAN,
        gp_detects: false,
    }
}

/// What the methods of comparison say.
fn add_baselines(row: &mut CaseRow, truth: &Truth, answers: &BaselineAnswers) {
    let BaselineAnswers { sparse, ridge, library, gp_detects } = answers;
    let names: Vec<&str> = sparse.probabilities.keys().map(String::as_str).collect();
    row.sparse_answer = names.join(" + ");
    row.sparse_isolation = isolation(truth, &sparse.probabilities);
    row.sparse_m = sparse.left_m;
    row.ridge_detects = ridge.detects;
    row.ridge_isolation = isolation(truth, &ridge.probabilities);
    row.ridge_m = ridge.left_m;
    row.library_detects = library.detects;
    row.library_m = library.left_m;
    row.gp_detects = *gp_detects;
}

/// Probability given to what is hidden: one minus the total variation distance between the
/// probabilities of effects and equal ones of the hidden effects. For one hidden effect that is its
/// probability. Not a number where nothing of the catalogue is hidden, or it is not on offer.
fn isolation(truth: &Truth, probabilities: &BTreeMap<String, f64>) -> f64 {
    let is_on_offer = |hidden: &InjectedEffect| !truth.left_out.contains(&hidden.name);
    if truth.unknown.is_some() || truth.hidden.is_empty() || !truth.hidden.iter().all(is_on_offer) {
        return f64::NAN;
    }
    let equal = 1.0 / truth.hidden.len() as f64;
    let given =
        |hidden: &InjectedEffect| probabilities.get(&hidden.label()).map_or(0.0, |p| p.min(equal));
    truth.hidden.iter().map(given).sum()
}

/// Whether the answer is right, and whether it contains the truth.
fn is_right(group: CaseGroup, truth: &Truth, answer: &CaseAnswer) -> (bool, bool) {
    match group {
        CaseGroup::Nothing => both(answer.verdict == Verdict::Consistent),
        CaseGroup::Outside => both(answer.verdict == Verdict::Unexplained),
        // The true effect is excluded from the catalogue, so `ambiguous` and `unexplained` are
        // right.
        CaseGroup::Inside => {
            let group = answer.verdict == Verdict::Ambiguous;
            (group || answer.verdict == Verdict::Unexplained, group)
        }
        CaseGroup::Single | CaseGroup::Pair => {
            let mut names: Vec<&str> =
                truth.hidden.iter().map(|hidden| hidden.name.as_str()).collect();
            names.sort_unstable();
            let all_answered =
                truth.hidden.iter().all(|hidden| answered_effect(hidden, answer).is_some());
            let right = answer.verdict == Verdict::Named && answer.names() == names && all_answered;
            // A group lists the effects of all its sets, each with its tendon.
            (right, right || answer.verdict == Verdict::Ambiguous && all_answered)
        }
    }
}

fn both(right: bool) -> (bool, bool) {
    (right, right)
}

/// The effect of the answer with the same name and, if it acts on one, the same tendon.
fn answered_effect<'a>(
    hidden: &InjectedEffect,
    answer: &'a CaseAnswer,
) -> Option<&'a AnsweredEffect> {
    let card = hidden.card()?;
    let is_answer = |answered: &&AnsweredEffect| {
        let same_tendon = tendon_parameter(card).is_none_or(|index| {
            answered
                .values
                .get(card.parameters[index].name)
                .is_some_and(|tendon| *tendon == hidden.values[index])
        });
        answered.name == hidden.name && same_tendon
    };
    answer.effects.iter().find(is_answer)
}

/// Relative error of the size vector of an effect.
fn strength_error(model: &Model, hidden: &InjectedEffect, answer: &CaseAnswer) -> Option<f64> {
    let (card, answered) = (hidden.card()?, answered_effect(hidden, answer)?);
    let truth = as_answered(hidden, answered);
    let (mut error_square, mut size_square) = (0.0, 0.0);
    for (parameter, value) in card.parameters.iter().zip(truth) {
        if size(parameter).is_some() {
            error_square += (answered.values.get(parameter.name)? - value).powi(2);
            size_square += (value - null_value(parameter, model)).powi(2);
        }
    }
    (size_square > 0.0).then(|| (error_square / size_square).sqrt())
}

/// Intervals of the parameters of an effect with the true values.
fn intervals(row: &CaseRow, hidden: &InjectedEffect, answer: &CaseAnswer) -> Vec<IntervalRow> {
    let (Some(card), Some(answered)) = (hidden.card(), answered_effect(hidden, answer)) else {
        return Vec::new();
    };
    let interval_row = |(parameter, truth): (&Parameter, f64)| {
        let &[low, high] = answered.intervals.get(parameter.name)?;
        Some(IntervalRow {
            case: row.case,
            samples: row.samples,
            effect: hidden.name.clone(),
            parameter: parameter.name.to_owned(),
            truth,
            value: *answered.values.get(parameter.name)?,
            low,
            high,
            covered: (low..=high).contains(&truth),
        })
    };
    card.parameters.iter().zip(as_answered(hidden, answered)).filter_map(interval_row).collect()
}

/// True values in the convention of the answer: axes a quarter turn apart with opposite ratio are
/// equal, and so are axes half a turn apart.
fn as_answered(hidden: &InjectedEffect, answered: &AnsweredEffect) -> Vec<f64> {
    use std::f64::consts::{FRAC_PI_2, PI};
    let mut values = hidden.values.clone();
    if hidden.name != "anisotropic_stiffness" {
        return values;
    }
    let (Some(ratio), Some(angle)) =
        (answered.values.get("ratio"), answered.values.get("angle_rad"))
    else {
        return values;
    };
    if ratio.signum() != values[0].signum() {
        values = vec![-values[0], values[1] + FRAC_PI_2];
    }
    values[1] += ((angle - values[1]) / PI).round() * PI;
    values
}
