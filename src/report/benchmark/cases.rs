//! Blind cases read: what was answered, in the words of the confusion matrix.

use crate::data::findings::CaseRow;

use crate::report::discovery::answer::closed;

/// What an answer comes to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum AnswerClass {
    /// One effect was named.
    Named(String),
    /// Several effects were named together.
    Several,
    /// No more than noise.
    Consistent,
    /// A group that holds the truth.
    GroupWith,
    /// A group that does not.
    GroupWithout,
    /// A group where the truth was not on offer.
    Group,
    /// A gap that nothing explains.
    Unexplained,
    /// No answer.
    Failed,
}

impl AnswerClass {
    /// Answers other than a single name, in the order of their columns.
    pub(crate) const OTHERS: [AnswerClass; 7] = [
        AnswerClass::Several,
        AnswerClass::GroupWith,
        AnswerClass::GroupWithout,
        AnswerClass::Group,
        AnswerClass::Unexplained,
        AnswerClass::Consistent,
        AnswerClass::Failed,
    ];

    /// Reads a case.
    pub(crate) fn of(case: &CaseRow) -> AnswerClass {
        match case.verdict.as_str() {
            "named" if case.answer.contains(" + ") => AnswerClass::Several,
            "named" => AnswerClass::Named(case.answer.clone()),
            "consistent" => AnswerClass::Consistent,
            "ambiguous" if case.group == "inside" => AnswerClass::Group,
            "ambiguous" if case.in_group => AnswerClass::GroupWith,
            "ambiguous" => AnswerClass::GroupWithout,
            "unexplained" => AnswerClass::Unexplained,
            _ => AnswerClass::Failed,
        }
    }

    /// Its name in tables and pictures.
    pub(crate) fn name(&self) -> &str {
        match self {
            AnswerClass::Named(name) => name,
            AnswerClass::Several => "several effects",
            AnswerClass::Consistent => "consistent",
            AnswerClass::GroupWith => "group with the truth",
            AnswerClass::GroupWithout => "group without it",
            AnswerClass::Group => "a group",
            AnswerClass::Unexplained => "unexplained",
            AnswerClass::Failed => "failed",
        }
    }
}

/// Whether anything was said to be missing.
pub(crate) fn alarmed(case: &CaseRow) -> bool {
    matches!(case.verdict.as_str(), "named" | "ambiguous" | "unexplained")
}

/// Whether the hidden effects are of the catalogue.
pub(crate) fn in_catalogue(case: &CaseRow) -> bool {
    matches!(case.group.as_str(), "single" | "pair")
}

/// Part of the squared held-out error beyond noise that the answer took away.
pub(crate) fn gap_closed(case: &CaseRow) -> Option<f64> {
    closed(case.before_m, case.after_m, case.floor_m)
}

/// Finite values once each, ascending.
pub(crate) fn ascending(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}
