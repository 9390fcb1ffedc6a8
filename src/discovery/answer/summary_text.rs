//! The answer in words: only what was computed.

use crate::data::findings::{Findings, Gap, PlaceRow, Verdict};
use crate::discovery::goodness_of_fit::kernel_ridge::ResidualPattern;
use crate::discovery::goodness_of_fit::test_result::{FitTest, TestResult};

/// What the summary says beside the findings.
pub(crate) struct SummaryContext<'a> {
    /// Sets between which the data cannot tell, the likeliest first.
    pub(crate) sets: &'a [String],
    /// The candidate that would be the answer, if any is better than none, …
    pub(crate) refused: Option<String>,
    /// … but for what speaks objection it.
    pub(crate) objection: &'a str,
    /// What a baseline has, too.
    pub(crate) shared: Option<BaselineShare>,
}

/// What is left of the held-out trials with the answer, in two parts whose squares add up, metres.
pub(crate) struct BaselineShare {
    /// What the baseline has, too.
    pub(crate) shared_m: f64,
    /// The rest.
    pub(crate) apart_m: f64,
}

/// The answer in a sentence or two.
pub(crate) fn summary(findings: &Findings, beside: &SummaryContext) -> String {
    let SummaryContext { sets, refused, objection, .. } = beside;
    let (before_mm, after_mm) = (findings.gap.before_m * 1e3, findings.gap.after_m * 1e3);
    let floor_mm = findings.noise_floor_m * 1e3;
    let names = findings.effects.iter().map(|effect| effect.name.as_str()).collect::<Vec<_>>();
    let shared = beside.shared.as_ref().map_or_else(String::new, |BaselineShare { shared_m, apart_m }| {
        format!(
            " Of what is left, {:.2} mm are in the baseline, too, and no discovery; without that it is {:.2} mm.",
            1e3 * shared_m,
            1e3 * apart_m
        )
    });
    let held_out = format!(
        "On trials that took no part in this, the tip error goes from {before_mm:.2} mm to {after_mm:.2} mm; noise alone is {floor_mm:.2} mm.{shared}"
    );
    match findings.verdict {
        Verdict::Consistent => format!(
            "The data show no more than noise and what is not known exactly of any robot: {before_mm:.2} mm on held-out trials, noise alone {floor_mm:.2} mm."
        ),
        Verdict::Named => format!("The model lacks {}. {held_out}", names.join(" and ")),
        Verdict::Ambiguous => format!(
            "Something is missing, and these data cannot tell whether it is {}. The first is the likeliest, and in the model. {held_out}",
            sets.join(" or ")
        ),
        Verdict::Unexplained => {
            let gap =
                if before_mm > floor_mm { "There is a gap" } else { "More than noise is left, if not everywhere" };
            let best = refused.as_ref().map_or_else(
                || "No candidate does enough to be named".to_owned(),
                |refused| format!("The best candidate is {refused}"),
            );
            format!(
                "{gap} ({before_mm:.2} mm on held-out trials, noise alone {floor_mm:.2} mm), and nothing in the catalogue explains it. {} {best}, and yet {objection}.",
                findings.pattern
            )
        }
    }
}

/// No test's assumptions hold so well that smaller chances mean anything.
const LEAST_CHANCE: f64 = 1e-9;

/// What speaks objection a set of effects, to follow its name and "and yet".
pub(crate) fn objection(sign: &TestResult) -> String {
    let (more_mm, beyond_mm) = (1e3 * sign.more_m, 1e3 * sign.beyond_m);
    let all_mm = more_mm.hypot(beyond_mm);
    let chance = match sign.p_value {
        p_value if p_value < LEAST_CHANCE => format!("chance below {LEAST_CHANCE:e}"),
        p_value => format!("chance {p_value:.1e}"),
    };
    match sign.test {
        FitTest::CrossTrial => format!("other trials foretell {more_mm:.2} mm of what it leaves ({chance})"),
        FitTest::Variance => {
            format!("the tip scatters about it by {all_mm:.2} mm, where noise alone is {beyond_mm:.2} mm ({chance})")
        }
        FitTest::SlowVariance => format!(
            "what it leaves hardly changes from one sample to the next, as no tracker's noise does, and is {all_mm:.2} mm, where noise alone is {beyond_mm:.2} mm ({chance})"
        ),
        FitTest::Levene => {
            format!("it leaves {all_mm:.2} mm in its worst trial, {beyond_mm:.2} mm in the middle one ({chance})")
        }
        FitTest::LackOfFit => {
            format!("it is {more_mm:.2} mm off in the mean where the same was measured again ({chance})")
        }
        FitTest::Score => {
            format!("a little of every effect together explains {more_mm:.2} mm of what it leaves ({chance})")
        }
        FitTest::Spearman => {
            format!("it leaves {all_mm:.2} mm where it moves the tip most, {beyond_mm:.2} mm where least ({chance})")
        }
        FitTest::HeldOut => {
            format!(
                "held-out trials scatter about it by {all_mm:.2} mm, those of its fit by {beyond_mm:.2} mm ({chance})"
            )
        }
    }
}

/// That an answer makes held-out trials worse, and by how much, to follow its name and "and yet".
pub(crate) fn worse_on_held_out(gap: &Gap) -> String {
    let [before_mm, after_mm] = [gap.before_m, gap.after_m].map(|error_m| 1e3 * error_m);
    let digits = if after_mm - before_mm < 0.01 { 4 } else { 2 };
    format!("it makes held-out trials worse: {after_mm:.digits$} mm instead of {before_mm:.digits$} mm")
}

/// What is said where held-out trials scatter more than those of the fit, whose numbers are known too little for that to
/// refute them.
pub(crate) fn held_out_caveat(sign: &TestResult) -> String {
    let [all_mm, fit_mm] = [sign.more_m.hypot(sign.beyond_m), sign.beyond_m].map(|size_m| 1e3 * size_m);
    format!(
        "Held-out trials scatter by {all_mm:.2} mm about the answer with these numbers, those that it was fitted to by \
         {fit_mm:.2} mm; with other numbers within the intervals they do not. What is missing is known better than how \
         much of it: trials that move the robot otherwise, in the part that is fitted, would tell."
    )
}

/// What is said of so much that is certainly left beside an answer, metres, and no more than laws may be off by.
pub(crate) fn tolerated_caveat(residual_m: f64) -> String {
    format!(
        "What is left is not all noise: a little of every effect together would explain at least {:.2} mm more. It is \
         little beside what is named, so the robot may follow a law that is not quite the catalogue's, but something \
         small may be missing, too.",
        1e3 * residual_m
    )
}

/// A pattern that predicts less than this share of the squares is none.
const LEAST_SHARE: f64 = 0.1;

/// What the unexplained gap looks like, with the shares of its squares that each pattern `foretold`, the best first.
pub(crate) fn pattern(foretold: &[(ResidualPattern, f64)], places: &[PlaceRow]) -> String {
    let depends = match foretold.first() {
        Some((pattern, share)) if *share >= LEAST_SHARE => {
            let told = |(pattern, share): &(ResidualPattern, f64)| {
                format!("{:.0} % by {}", 100.0 * share, pattern_name(*pattern))
            };
            let each: Vec<String> = foretold.iter().map(told).collect();
            format!("{} Other trials predict, of its squares, {}.", describe_pattern(*pattern), each.join(", "))
        }
        _ => "It differs from trial to trial: none of them predicts another, as from a contact, from something that \
              moves or slips, or from a tracker noisier than its repeats."
            .to_owned(),
    };
    let single = places.iter().filter(|row| row.by != "all" && row.axis != "all");
    let worst = single.max_by(|a, b| (a.rms_before_m / a.floor_m).total_cmp(&(b.rms_before_m / b.floor_m)));
    worst.map_or_else(
        || depends.clone(),
        |row| {
            let times = row.rms_before_m / row.floor_m;
            format!(
                "{depends} It is largest along {} for {}, {}: {times:.1} times the noise.",
                row.axis, row.by, row.place
            )
        },
    )
}

fn describe_pattern(pattern: ResidualPattern) -> &'static str {
    match pattern {
        ResidualPattern::Constant => "The gap is much the same everywhere, as from a shift of the frame.",
        ResidualPattern::Pose => "The gap depends on where the robot is, as from a load, a stiffness or a geometry.",
        ResidualPattern::History => "The gap depends on how the robot got there, as from friction, play or a delay.",
        ResidualPattern::Time => "The gap depends on how long a trial has lasted, as from drift, creep or slipping.",
    }
}

/// What a pattern goes by.
fn pattern_name(pattern: ResidualPattern) -> &'static str {
    match pattern {
        ResidualPattern::Constant => "a constant",
        ResidualPattern::Pose => "pose",
        ResidualPattern::History => "history",
        ResidualPattern::Time => "time",
    }
}

/// Rivals whose predictions are so many standard deviations apart will be told from each other.
const CLEAR: f64 = 3.0;

/// What to record next.
pub(crate) fn next_measurement(findings: &Findings) -> String {
    if let Some(first) = findings.proposals.first() {
        let little = if first.separation < CLEAR {
            format!(
                "; it moves them apart by {:.1} standard deviations only, so more of it may be needed",
                first.separation
            )
        } else {
            String::new()
        };
        return format!("{} (about {:.0} min; commands in {}{little}).", first.what, first.minutes, first.file);
    }
    match findings.verdict {
        Verdict::Consistent => "Nothing is needed: these data are nuisance_fit.".to_owned(),
        Verdict::Named => "Nothing is needed to tell candidates apart.".to_owned(),
        Verdict::Ambiguous => {
            "The same commands again with a known weight on the tip in half of the trials.".to_owned()
        }
        Verdict::Unexplained => {
            "Repeats of one trial, a slow and a fast one, and one with a known weight, to see what the rest depends on."
                .to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_speaks_against_an_answer_is_told_in_sizes_that_can_be_compared() {
        let told = |test, p_value| objection(&TestResult { test, p_value, more_m: 4e-4, beyond_m: 3e-4 });
        for (test, said) in [
            (FitTest::CrossTrial, "foretell 0.40 mm"),
            (FitTest::Variance, "by 0.50 mm, where noise alone is 0.30 mm"),
            (FitTest::SlowVariance, "is 0.50 mm, where noise alone is 0.30 mm"),
            (FitTest::Levene, "0.50 mm in its worst trial, 0.30 mm in the middle one"),
            (FitTest::LackOfFit, "0.40 mm off in the mean"),
            (FitTest::Score, "explains 0.40 mm"),
            (FitTest::Spearman, "0.50 mm where it moves the tip most, 0.30 mm where least"),
            (FitTest::HeldOut, "by 0.50 mm, those of its fit by 0.30 mm"),
        ] {
            let told = told(test, 4.8e-5);
            assert!(told.contains(said) && told.ends_with("(chance 4.8e-5)"), "{told}");
        }
        assert!(told(FitTest::LackOfFit, 0.0).ends_with("(chance below 1e-9)"));
    }

    #[test]
    fn a_pattern_is_the_best_of_those_that_foretell_enough() {
        let told = pattern(&[(ResidualPattern::Time, 0.92), (ResidualPattern::Pose, 0.4)], &[]);
        assert!(told.starts_with("The gap depends on how long"), "{told}");
        assert!(told.ends_with("of its squares, 92 % by time, 40 % by pose."), "{told}");
        let none = pattern(&[(ResidualPattern::Pose, 0.05), (ResidualPattern::Time, 0.0)], &[]);
        assert!(none.starts_with("It differs from trial to trial"), "{none}");
    }
}
