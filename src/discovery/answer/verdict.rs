//! Decides the verdict (docs/method/search.md, "The verdict"): `consistent`, `named`, `ambiguous` or
//! `unexplained`.

use crate::data::findings::Verdict;
use crate::discovery::goodness_of_fit::test_result::TestResult;

/// What the verdict is decided from.
pub(crate) enum VerdictEvidence {
    /// A mistake of recording or set-up explains the gap; no effect was sought.
    Mistake,
    /// The best set of effects with its tests.
    BestSet(SetEvidence),
}

/// Evidence for and against the best set of effects, which is empty if nothing is missing.
#[derive(Clone, Copy, Default)]
pub(crate) struct SetEvidence {
    /// Number of effects in the set.
    pub(crate) effects: usize,
    /// The goodness-of-fit test that the set fails on the training trials.
    pub(crate) failed_test: Option<TestResult>,
    /// Whether the set explains most of the gap of a robot that the model does not describe
    /// exactly. It is then named although something remains.
    pub(crate) explains_gap: bool,
    /// Whether other sets fit equally well.
    pub(crate) has_rivals: bool,
    /// Whether the error on the baseline is as large as the motion, so that the model does not
    /// describe the robot as built in this set-up.
    pub(crate) misses_baseline: bool,
    /// Result on the held-out trials. They are not asked of a set that the training trials reject.
    pub(crate) held_out: HeldOutResult,
}

/// What held-out trials say of a set.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum HeldOutResult {
    /// They do not contradict it.
    #[default]
    Supported,
    /// The model with the set cannot be simulated on them.
    CannotSimulate,
    /// The set increases their error.
    Worse,
    /// They scatter more about the fitted values, but other values within the intervals remove the
    /// difference.
    Tolerated(TestResult),
    /// They scatter significantly more than the training trials.
    Scattered(TestResult),
}

/// Why the best set is not the answer.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Objection {
    /// A failed test.
    Test(TestResult),
    /// Nothing was added, and the model does not describe the baseline either.
    Baseline,
    /// The model with the set cannot be simulated on held-out trials.
    CannotSimulate,
    /// The set increases the held-out error.
    Worse,
}

/// The verdict and what speaks against more.
pub(crate) struct Decision {
    pub(crate) verdict: Verdict,
    /// For `unexplained`: the objection to the best set. None beside a mistake.
    pub(crate) objection: Option<Objection>,
    /// For `named` and `ambiguous`: the test that shows that something remains beside the effects.
    pub(crate) remaining: Option<TestResult>,
}

impl Decision {
    /// Whether effects are added to the model.
    pub(crate) fn names_effects(&self) -> bool {
        matches!(self.verdict, Verdict::Named | Verdict::Ambiguous)
    }

    /// Whether nothing significant remains.
    pub(crate) fn is_complete(&self) -> bool {
        self.verdict != Verdict::Unexplained && self.remaining.is_none()
    }
}

impl SetEvidence {
    /// Whether a failed test only shows that something remains beside the effects.
    fn may_leave_something(&self) -> bool {
        self.explains_gap && self.effects > 0
    }

    /// Whether the training trials alone reject the set.
    pub(crate) fn is_rejected_in_training(&self) -> bool {
        self.failed_test.is_some() && !self.may_leave_something()
    }

    /// The objection to the set, if there is one.
    fn objection(&self) -> Option<Objection> {
        if self.is_rejected_in_training() {
            return self.failed_test.map(Objection::Test);
        }
        // What both recordings share is not attributed to an effect, and must not count as nothing.
        if self.misses_baseline && self.effects == 0 {
            return Some(Objection::Baseline);
        }
        match self.held_out {
            HeldOutResult::CannotSimulate => Some(Objection::CannotSimulate),
            HeldOutResult::Worse => Some(Objection::Worse),
            HeldOutResult::Scattered(test) if !self.may_leave_something() => {
                Some(Objection::Test(test))
            }
            HeldOutResult::Scattered(_)
            | HeldOutResult::Tolerated(_)
            | HeldOutResult::Supported => None,
        }
    }
}

/// The verdict.
pub(crate) fn decide(evidence: &VerdictEvidence) -> Decision {
    let set = match evidence {
        VerdictEvidence::Mistake => {
            return Decision { verdict: Verdict::Unexplained, objection: None, remaining: None };
        }
        VerdictEvidence::BestSet(set) => set,
    };
    // 1. An objection outweighs everything else.
    if let Some(objection) = set.objection() {
        return Decision {
            verdict: Verdict::Unexplained,
            objection: Some(objection),
            remaining: None,
        };
    }
    // 2. No objection to the model as given: nothing is missing.
    if set.effects == 0 {
        return Decision { verdict: Verdict::Consistent, objection: None, remaining: None };
    }
    // 3. Effects are named; rivals make the name ambiguous.
    let verdict = if set.has_rivals { Verdict::Ambiguous } else { Verdict::Named };
    let scattered = match set.held_out {
        HeldOutResult::Scattered(test) => Some(test),
        _ => None,
    };
    // 4. A failed test that is no objection shows that the answer is incomplete.
    Decision { verdict, objection: None, remaining: set.failed_test.or(scattered) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::goodness_of_fit::test_result::FitTest;

    const FAILED: TestResult =
        TestResult { test: FitTest::Variance, p_value: 1e-6, more_m: 1e-3, beyond_m: 1e-3 };

    fn of(set: SetEvidence) -> (Verdict, bool) {
        let decision = decide(&VerdictEvidence::BestSet(set));
        assert_eq!(decision.objection.is_some(), decision.verdict == Verdict::Unexplained);
        (decision.verdict, decision.is_complete())
    }

    #[test]
    fn tests_rivals_and_held_out_trials_decide() {
        let none = SetEvidence::default();
        let one = SetEvidence { effects: 1, ..none };
        assert_eq!(of(none), (Verdict::Consistent, true));
        assert_eq!(of(one), (Verdict::Named, true));
        assert_eq!(of(SetEvidence { has_rivals: true, ..one }), (Verdict::Ambiguous, true));
        for held_out in
            [HeldOutResult::Worse, HeldOutResult::CannotSimulate, HeldOutResult::Scattered(FAILED)]
        {
            assert_eq!(
                of(SetEvidence { held_out, ..one }),
                (Verdict::Unexplained, false),
                "{held_out:?}"
            );
        }
        assert_eq!(
            of(SetEvidence { held_out: HeldOutResult::Tolerated(FAILED), ..one }),
            (Verdict::Named, true)
        );
        assert_eq!(
            of(SetEvidence { failed_test: Some(FAILED), ..one }),
            (Verdict::Unexplained, false)
        );
        assert_eq!(decide(&VerdictEvidence::Mistake).verdict, Verdict::Unexplained);
        let misses_baseline = true;
        assert_eq!(of(SetEvidence { misses_baseline, ..none }), (Verdict::Unexplained, false));
        assert_eq!(of(SetEvidence { misses_baseline, ..one }), (Verdict::Named, true));
    }

    #[test]
    fn an_effect_that_explains_the_gap_is_named_although_something_remains() {
        let explains_gap = SetEvidence { effects: 1, explains_gap: true, ..SetEvidence::default() };
        assert_eq!(
            of(SetEvidence { failed_test: Some(FAILED), ..explains_gap }),
            (Verdict::Named, false)
        );
        let held_out = HeldOutResult::Scattered(FAILED);
        assert_eq!(of(SetEvidence { held_out, ..explains_gap }), (Verdict::Named, false));
        let held_out = HeldOutResult::Worse;
        assert_eq!(of(SetEvidence { held_out, ..explains_gap }), (Verdict::Unexplained, false));
        // Without an effect there is nothing that could explain the gap.
        let nothing = SetEvidence { effects: 0, failed_test: Some(FAILED), ..explains_gap };
        assert_eq!(of(nothing), (Verdict::Unexplained, false));
    }
}
