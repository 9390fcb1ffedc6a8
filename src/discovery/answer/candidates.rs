//! The table of candidates: every set that was fitted, and why it is not the answer.

use std::collections::BTreeSet;

use super::named_effects::DIGITS;
use super::verdict::Decision;
use crate::data::findings::{Candidate, Verdict};
use crate::data::tables::round_significant;
use crate::discovery::fit::candidate::{CandidateEffect, SetMember, candidate_set};
use crate::discovery::fit::gauss_newton::FitProblem;
use crate::discovery::fit::jackknife;
use crate::discovery::problem::Problem;
use crate::discovery::recording::samples::rms_m;
use crate::discovery::search::{ScoredSet, SearchOutcome};
use crate::math::summary::root_mean_square;

/// Maximum number of fitted sets in the table.
const MAX_FITTED_ROWS: usize = 30;

impl Problem<'_> {
    /// The candidates, best first, with leave-one-out errors. `fit_problem`: that of the final fit
    /// of the best set; `objection`: to the best set, if it is not the answer.
    pub(crate) fn candidate_rows(
        &self,
        fit_problem: &FitProblem,
        outcome: &SearchOutcome,
        decision: &Decision,
        objection: &str,
    ) -> Vec<Candidate> {
        let search_problem = self.fit_problem();
        let after_m = |scored: &ScoredSet| {
            let is_best = scored.fitted.members == outcome.best.fitted.members;
            // The best set alone was fitted again with corrected samples and new nuisance columns.
            let problem = if is_best { fit_problem } else { &search_problem };
            root_mean_square(&jackknife::left_out_errors_m(problem, &scored.fitted))
        };
        let mut tried: Vec<&ScoredSet> = outcome.tried.iter().chain([&outcome.null]).collect();
        tried.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut rows: Vec<Candidate> = Vec::new();
        let mut listed = BTreeSet::new();
        for scored in tried {
            let members = &scored.fitted.members;
            // A set may be fitted from several starts; only its best score is listed.
            if rows.len() < MAX_FITTED_ROWS && listed.insert(candidate_set(members)) {
                rows.push(Candidate {
                    name: set_name(&self.candidates, members),
                    score: scored.score,
                    after_m: after_m(scored),
                    why_not: self.why_not(outcome, decision, scored, objection),
                    parameters: parameter_text(&self.candidates, members),
                });
            }
        }
        // Every effect of the catalogue is listed, fitted or not.
        let before_m = rms_m(&outcome.null.fitted.nuisance_fit.residual_m);
        for (prediction, score) in &outcome.screened {
            if listed.insert(BTreeSet::from([prediction.member.candidate])) {
                // The deviance is 3N ln(squares), so a gain g leaves exp(-g / 3N) of the squares.
                let residual_share = (-prediction.gain / (6.0 * self.training.len() as f64)).exp();
                rows.push(Candidate {
                    name: set_name(&self.candidates, std::slice::from_ref(&prediction.member)),
                    score: *score,
                    after_m: residual_share * before_m,
                    why_not:
                        "not fitted: the linear screening predicts no larger improvement than this \
                         error"
                            .to_owned(),
                    parameters: String::new(),
                });
            }
        }
        rows
    }

    fn why_not(
        &self,
        outcome: &SearchOutcome,
        decision: &Decision,
        scored: &ScoredSet,
        objection: &str,
    ) -> String {
        let (members, best) = (&scored.fitted.members, &outcome.best);
        let is_unexplained = decision.verdict == Verdict::Unexplained;
        let answer = if decision.names_effects() { outcome.rounded_members() } else { Vec::new() };
        let rounded: Vec<SetMember> = members.iter().map(SetMember::rounded).collect();
        if rounded == answer && !is_unexplained {
            return String::new();
        }
        if is_unexplained && *members == best.fitted.members {
            let rank =
                if members.is_empty() { "no candidate is better" } else { "the best candidate" };
            return format!("{rank}, but {objection}");
        }
        if members.len() > best.fitted.members.len() {
            let why = if scored.score > best.score {
                "improves the fit by too little to be named"
            } else {
                "does not justify its parameters"
            };
            return format!("the additional effect {why}");
        }
        if outcome.is_rival(scored, self.options.rival_score) {
            return "fits equally well: these data do not distinguish the two".to_owned();
        }
        if outcome.by_trials.is_some() {
            return "improves unseen trials by no more than the residual of the model on this robot \
                    as built".to_owned();
        }
        format!("fits worse: score lower by {:.0}", best.score - scored.score)
    }
}

/// Names of the effects of a set, joined.
pub(crate) fn set_name(candidates: &[CandidateEffect], members: &[SetMember]) -> String {
    if members.is_empty() {
        return "nothing missing".to_owned();
    }
    members
        .iter()
        .map(|member| candidates[member.candidate].label())
        .collect::<Vec<_>>()
        .join(" + ")
}

/// Parameters of a set as `effect.parameter=value`, joined.
fn parameter_text(candidates: &[CandidateEffect], members: &[SetMember]) -> String {
    let parameters = members.iter().flat_map(|member| {
        let card = candidates[member.candidate].card;
        card.parameters.iter().zip(&member.values).map(|(parameter, &value)| {
            format!("{}.{}={}", card.name, parameter.name, round_significant(value, DIGITS))
        })
    });
    parameters.collect::<Vec<String>>().join("; ")
}
