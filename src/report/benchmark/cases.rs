//! Classes of answers in the confusion matrix.

use crate::data::findings::CaseRow;

use crate::report::discovery::answer::closed;

/// Class of an answer.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum AnswerClass {
    /// One effect was named.
    Named(String),
    /// Several effects were named together.
    Several,
    /// `consistent`.
    Consistent,
    /// A group that contains the truth.
    GroupWith,
    /// A group that does not contain it.
    GroupWithout,
    /// A group for a case whose truth is excluded from the catalogue.
    Group,
    /// `unexplained`.
    Unexplained,
    /// No answer.
    Failed,
}

impl AnswerClass {
    /// Classes other than a single name, in column order.
    pub(crate) const OTHERS: [AnswerClass; 7] = [
        AnswerClass::Several,
        AnswerClass::GroupWith,
        AnswerClass::GroupWithout,
        AnswerClass::Group,
        AnswerClass::Unexplained,
        AnswerClass::Consistent,
        AnswerClass::Failed,
    ];

    /// Class of a case's answer.
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

    /// Name in tables and figures.
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

/// Whether the answer reports a missing effect.
pub(crate) fn alarmed(case: &CaseRow) -> bool {
    matches!(case.verdict.as_str(), "named" | "ambiguous" | "unexplained")
}

/// Whether the injected effects are in the catalogue.
pub(crate) fn in_catalogue(case: &CaseRow) -> bool {
    matches!(case.group.as_str(), "single" | "pair")
}

/// Share of the squared held-out error beyond noise that the answer removes.
pub(crate) fn gap_closed(case: &CaseRow) -> Option<f64> {
    closed(case.before_m, case.after_m, case.floor_m)
}
