//! Blind cases read: what was answered, in the words of the confusion matrix.

use crate::data::findings::CaseRow;

use crate::report::discovery::answer::closed;

/// What an answer comes to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Answer {
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

impl Answer {
    /// Answers other than a single name, in the order of their columns.
    pub(crate) const OTHERS: [Answer; 7] = [
        Answer::Several,
        Answer::GroupWith,
        Answer::GroupWithout,
        Answer::Group,
        Answer::Unexplained,
        Answer::Consistent,
        Answer::Failed,
    ];

    /// Reads a case.
    pub(crate) fn of(case: &CaseRow) -> Answer {
        match case.verdict.as_str() {
            "named" if case.answer.contains(" + ") => Answer::Several,
            "named" => Answer::Named(case.answer.clone()),
            "consistent" => Answer::Consistent,
            "ambiguous" if case.group == "inside" => Answer::Group,
            "ambiguous" if case.in_group => Answer::GroupWith,
            "ambiguous" => Answer::GroupWithout,
            "unexplained" => Answer::Unexplained,
            _ => Answer::Failed,
        }
    }

    /// Its name in tables and pictures.
    pub(crate) fn name(&self) -> &str {
        match self {
            Answer::Named(name) => name,
            Answer::Several => "several effects",
            Answer::Consistent => "consistent",
            Answer::GroupWith => "group with the truth",
            Answer::GroupWithout => "group without it",
            Answer::Group => "a group",
            Answer::Unexplained => "unexplained",
            Answer::Failed => "failed",
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
