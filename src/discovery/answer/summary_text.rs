//! Texts of the answer, from computed values only.

use super::evidence::Evidence;
use super::verdict::Objection;
use crate::data::findings::{PlaceRow, Verdict};
use crate::discovery::goodness_of_fit::kernel_ridge::ResidualPattern;
use crate::discovery::goodness_of_fit::test_result::{FitTest, TestResult};
use crate::discovery::mistakes::mislabelled::Mistake;

/// Held-out error of the answer in two parts whose squares add up, metres.
pub(crate) struct BaselineShare {
    /// The part shared with the baseline.
    pub(crate) shared_m: f64,
    /// The rest.
    pub(crate) apart_m: f64,
}

/// Caveat of a named delay, seconds, which may be the tracker's clock instead.
pub(crate) fn delay_caveat(time_s: f64) -> String {
    format!(
        "These data do not distinguish a delay of the robot by {time_s:.3} s from a tracker's \
         clock that lags the clock of the commands by the same time: check the clocks before the \
         drive."
    )
}

/// Caveat of an effect that single trials tell, on a robot of which the model leaves `model_form_m`
/// anyway.
pub(crate) fn by_trials_caveat(model_form_m: f64) -> String {
    format!(
        "The calibrated model has a residual of up to {:.1} mm on this robot as built, and over \
         all rows together this effect is not significant against it. The effect is named because \
         its amplitudes in single trials are larger than in the baseline; its interval is that of \
         these amplitudes.",
        1e3 * model_form_m
    )
}

/// Summary of an answer that is a mistake.
fn mistake_summary(mistake: &Mistake, error_name: &str) -> String {
    let (before_mm, after_mm) = (1e3 * mistake.before_m, 1e3 * mistake.after_m);
    let source = if mistake.of_baseline { "baseline indicates" } else { "data indicate" };
    format!(
        "The {source} a mistake of recording or set-up: if {}, the {error_name}{} is {after_mm:.2} \
         mm instead of {before_mm:.2} mm. No effect was searched, and the model was not changed.",
        mistake.what,
        mistake.in_baseline()
    )
}

/// Summary in one or two sentences.
pub(crate) fn summary(evidence: &Evidence) -> String {
    let Evidence { error_name, search, .. } = evidence;
    let pattern = &evidence.residuals.pattern;
    if let Some(mistake) = &evidence.mistake {
        return mistake_summary(mistake, error_name);
    }
    let (before_mm, after_mm) = (evidence.gap.before_m * 1e3, evidence.gap.after_m * 1e3);
    let floor_mm = evidence.residuals.noise.rms_m() * 1e3;
    let floor = if evidence.residuals.noise_is_bound {
        format!("at most {floor_mm:.2} mm (from {})", evidence.residuals.noise_from)
    } else {
        format!("{floor_mm:.2} mm")
    };
    let shared = search.shared.as_ref().map_or_else(String::new, |BaselineShare { shared_m, apart_m }| {
        format!(
            " {:.2} mm of the remaining error also appears in the baseline and is not attributed \
             to a missing effect; the rest is {:.2} mm.",
            1e3 * shared_m,
            1e3 * apart_m
        )
    });
    let remaining = evidence.decision.remaining.as_ref().map_or_else(String::new, |test| {
        let remaining = failed_test(test);
        format!(" The named effects do not explain the whole residual: {remaining}. {pattern}")
    });
    let held_out = format!(
        "On held-out trials the {error_name} falls from {before_mm:.2} mm to {after_mm:.2} mm; the \
         noise floor is {floor}.{shared}{remaining}"
    );
    match evidence.decision.verdict {
        Verdict::Consistent => format!(
            "The data are consistent with the model, measurement noise and calibration \
             uncertainty: {error_name} {before_mm:.2} mm on held-out trials, noise floor \
             {floor}."
        ),
        Verdict::Named => {
            let names: Vec<&str> =
                search.effects.iter().map(|effect| effect.name.as_str()).collect();
            format!("The model lacks {}. {held_out}", names.join(" and "))
        }
        Verdict::Ambiguous => format!(
            "An effect is missing; these data do not determine whether it is {}. `model.yaml` \
             contains the most likely one, the first. {held_out}",
            search.set_names.join(" or ")
        ),
        Verdict::Unexplained => {
            let gap = if before_mm > floor_mm {
                "The model error exceeds the noise"
            } else {
                "The residual has the mean size of noise but is not noise"
            };
            let best = search.best_name.as_ref().map_or_else(
                || "No candidate improves the fit enough to be named".to_owned(),
                |name| format!("The best candidate is {name}"),
            );
            format!(
                "{gap} ({before_mm:.2} mm on held-out trials, noise floor {floor}), and \
                 no effect of the catalogue explains it. {pattern} {best}, but {}.",
                search.objection
            )
        }
    }
}

/// Smaller p-values are not reported: no test's assumptions hold that well.
const MIN_WRITTEN_P_VALUE: f64 = 1e-9;

/// Objection to a set of effects, as a clause after "but"; with the held-out error before and
/// after, metres.
pub(crate) fn objection(objection: &Objection, held_out_m: [f64; 2]) -> String {
    match objection {
        Objection::Test(test) => failed_test(test),
        Objection::Baseline => "the model does not describe the baseline either".to_owned(),
        Objection::CannotSimulate => {
            "the model with it cannot be simulated on the held-out trials".to_owned()
        }
        Objection::Worse => {
            let [before_mm, after_mm] = held_out_m.map(|error_m| 1e3 * error_m);
            // More digits where two would show the same number twice.
            let digits = if after_mm - before_mm < 0.01 { 4 } else { 2 };
            format!(
                "it increases the error on held-out trials from {before_mm:.digits$} mm to \
                 {after_mm:.digits$} mm"
            )
        }
    }
}

/// What a failed test shows, as a clause.
fn failed_test(result: &TestResult) -> String {
    let (more_mm, beyond_mm) = (1e3 * result.more_m, 1e3 * result.beyond_m);
    let all_mm = more_mm.hypot(beyond_mm);
    let chance = match result.p_value {
        p_value if p_value < MIN_WRITTEN_P_VALUE => format!("p < {MIN_WRITTEN_P_VALUE:e}"),
        p_value => format!("p = {p_value:.1e}"),
    };
    match result.test {
        FitTest::CrossTrial => {
            format!("{more_mm:.2} mm of its residual can be predicted from other trials ({chance})")
        }
        FitTest::Variance => {
            format!(
                "its residual is {all_mm:.2} mm, where the noise floor is {beyond_mm:.2} mm \
                 ({chance})"
            )
        }
        FitTest::SlowVariance => format!(
            "its residual is more strongly correlated between samples than tracker noise and is \
             {all_mm:.2} mm, where the noise floor is {beyond_mm:.2} mm ({chance})"
        ),
        FitTest::Levene => format!(
            "its residual is {all_mm:.2} mm in the worst trial and {beyond_mm:.2} mm in the median \
             trial ({chance})"
        ),
        FitTest::LackOfFit => {
            format!("its mean error over repeated measurements is {more_mm:.2} mm ({chance})")
        }
        FitTest::Score => {
            format!(
                "small amounts of all effects together explain {more_mm:.2} mm of its residual \
                 ({chance})"
            )
        }
        FitTest::Spearman => format!(
            "its residual is {all_mm:.2} mm where it moves the tip most and {beyond_mm:.2} mm \
             where it moves the tip least ({chance})"
        ),
        FitTest::HeldOut => format!(
            "its residual is {all_mm:.2} mm on held-out trials and {beyond_mm:.2} mm on the fitted \
             trials ({chance})"
        ),
    }
}

/// Caveat if held-out trials scatter more, but other values within the intervals remove the
/// difference.
pub(crate) fn held_out_caveat(test: &TestResult) -> String {
    let [all_mm, fit_mm] =
        [test.more_m.hypot(test.beyond_m), test.beyond_m].map(|size_m| 1e3 * size_m);
    format!(
        "With the fitted values the residual is {all_mm:.2} mm on held-out trials and {fit_mm:.2} \
         mm on the fitted trials; other values within the 95 % intervals remove this difference. \
         The kind of the effect is better determined than its size: fitted trials with other \
         motions would determine the size."
    )
}

/// Caveat on a significant residual within the expected law errors, metres.
pub(crate) fn tolerated_caveat(residual_m: f64) -> String {
    format!(
        "The residual is not only noise: small amounts of all effects together would explain at \
         least {:.2} mm more. This is small compared with the named effects. The robot may follow \
         a law that differs slightly from the catalogue's, or a small further effect may be \
         missing.",
        1e3 * residual_m
    )
}

/// Caveat on uncertain parameters that explain so much, metres, where they are so many `deviations`
/// off.
pub(crate) fn strained_caveat(explained_m: f64, deviations: f64) -> String {
    format!(
        "The uncertain parameters of the model explain {:.2} mm of the error on held-out trials, \
         and one of them differs from its expected value by {deviations:.0} standard deviations: \
         further effects are probably missing, each smaller than `least_share` of those named. \
         `least_share: 0.01` with a larger `most_effects` lets the search add them.",
        1e3 * explained_m
    )
}

/// What the fit assumes of the rest before trials: the `share` of the relaxation that is outstanding
/// at their start, with its standard deviation, and the relaxation time.
pub(crate) fn unrelaxed_caveat(share: f64, deviation: f64, time_s: f64) -> String {
    let half_width = NORMAL_95 * deviation;
    let rested_s = time_s * share.clamp(f64::MIN_POSITIVE, 1.0).recip().ln();
    let unknown = "The rest time at home before trials is not recorded.";
    if share < half_width {
        return format!(
            "{unknown} The data are consistent with a fully relaxed robot: at most {:.0} % of the \
             relaxation under its own weight was outstanding when trials began.",
            100.0 * (share + half_width).clamp(0.0, 1.0)
        );
    }
    format!(
        "{unknown} When trials began, {:.0} % (± {:.0}) of the relaxation under its own weight was \
         outstanding, as for a straight robot after {rested_s:.2} s at home: `tracking: \
         {{rested_s: {rested_s:.2}}}` reproduces such trials.",
        100.0 * share,
        100.0 * half_width
    )
}

/// Half of the 95 % interval of a normal law, in standard deviations.
const NORMAL_95: f64 = 1.96;

/// Patterns that predict less than this share of the squares are not reported.
const MIN_PREDICTED_SHARE: f64 = 0.1;

/// Pattern of an unexplained residual, with the shares of squares that each pattern predicts, best
/// first.
pub(crate) fn pattern(foretold: &[(ResidualPattern, f64)], places: &[PlaceRow]) -> String {
    let depends = match foretold.first() {
        Some((pattern, share)) if *share >= MIN_PREDICTED_SHARE => {
            let shares = foretold
                .iter()
                .map(|(pattern, share)| format!("{:.0} % by {}", 100.0 * share, pattern.name()));
            let shares: Vec<String> = shares.collect();
            format!(
                "{} Share of the squared residual that other trials predict: {}.",
                pattern.description(),
                shares.join(", ")
            )
        }
        _ => {
            "The residual differs between trials, and no trial predicts another. Possible causes: \
             contact, a part that moves or slips, or a tracker noisier than its repeated samples."
                .to_owned()
        }
    };
    let single = places.iter().filter(|row| row.by != "all" && row.axis != "all");
    let worst =
        single.max_by(|a, b| (a.rms_before_m / a.floor_m).total_cmp(&(b.rms_before_m / b.floor_m)));
    worst.map_or_else(
        || depends.clone(),
        |row| {
            let times = row.rms_before_m / row.floor_m;
            format!(
                "{depends} It is largest along {} for {}, {}: {times:.1} times the noise floor.",
                row.axis, row.by, row.place
            )
        },
    )
}

impl ResidualPattern {
    fn description(self) -> &'static str {
        match self {
            ResidualPattern::Constant => {
                "The residual is nearly constant, as from a shift of the tracking frame."
            }
            ResidualPattern::Pose => {
                "The residual depends on the pose, as from a load, a stiffness or a geometry error."
            }
            ResidualPattern::History => {
                "The residual depends on the motion history, as from friction, backlash or a delay."
            }
            ResidualPattern::Time => {
                "The residual depends on the time in the trial, as from drift, creep or slip."
            }
        }
    }

    fn name(self) -> &'static str {
        match self {
            ResidualPattern::Constant => "a constant",
            ResidualPattern::Pose => "pose",
            ResidualPattern::History => "history",
            ResidualPattern::Time => "time",
        }
    }
}

/// Separation in standard deviations above which rivals are told apart.
const CLEAR_SEPARATION: f64 = 3.0;

/// What to record next.
pub(crate) fn next_measurement(evidence: &Evidence) -> String {
    if let Some(mistake) = &evidence.mistake {
        let recordings =
            if mistake.of_baseline { "recordings or their" } else { "recording or its" };
        return format!(
            "Correct the {recordings} set-up ({}), then run `discover` again.",
            mistake.what
        );
    }
    if let Some(mistake) = &evidence.possible_mistake {
        return format!("Check the set-up ({}), then run `discover` again.", mistake.what);
    }
    if let Some(error) = evidence.leading_baseline_error() {
        return error.advice();
    }
    if let Some(first) = evidence.search.next_experiments.first().map(|next| &next.proposal) {
        let doubt = if first.separation < CLEAR_SEPARATION {
            format!(
                "; the predictions differ by only {:.1} standard deviations, so it may have to be \
                 repeated",
                first.separation
            )
        } else {
            String::new()
        };
        return format!(
            "{} (about {:.0} min; commands in {}{doubt}).",
            first.what, first.minutes, first.file
        );
    }
    let next = match evidence.decision.verdict {
        Verdict::Consistent => "No further recording is needed: the model explains these data.",
        Verdict::Named => "No further recording is needed to distinguish candidates.",
        Verdict::Ambiguous => {
            "Record the same commands again with a known weight on the tip in half of the trials."
        }
        Verdict::Unexplained => {
            "Record repeats of one trial, a slow and a fast one, and one with a known weight, to \
             find what the residual depends on."
        }
    };
    next.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_speaks_against_an_answer_is_told_in_sizes_that_can_be_compared() {
        let clause = |test, p_value| {
            failed_test(&TestResult { test, p_value, more_m: 4e-4, beyond_m: 3e-4 })
        };
        for (test, said) in [
            (FitTest::CrossTrial, "0.40 mm of its residual can be predicted"),
            (FitTest::Variance, "its residual is 0.50 mm, where the noise floor is 0.30 mm"),
            (FitTest::SlowVariance, "and is 0.50 mm, where the noise floor is 0.30 mm"),
            (FitTest::Levene, "0.50 mm in the worst trial and 0.30 mm in the median trial"),
            (FitTest::LackOfFit, "mean error over repeated measurements is 0.40 mm"),
            (FitTest::Score, "explain 0.40 mm"),
            (
                FitTest::Spearman,
                "0.50 mm where it moves the tip most and 0.30 mm where it moves the tip least",
            ),
            (FitTest::HeldOut, "0.50 mm on held-out trials and 0.30 mm on the fitted trials"),
        ] {
            let clause = clause(test, 4.8e-5);
            assert!(clause.contains(said) && clause.ends_with("(p = 4.8e-5)"), "{clause}");
        }
        assert!(clause(FitTest::LackOfFit, 0.0).ends_with("(p < 1e-9)"));
    }

    #[test]
    fn the_rest_before_trials_is_told_as_a_time_or_as_complete() {
        let told = unrelaxed_caveat(0.7, 0.02, 6.0);
        assert!(told.contains("70 % (± 4)") && told.contains("{rested_s: 2.14}"), "{told}");
        assert!(unrelaxed_caveat(1.1, 0.02, 6.0).contains("{rested_s: 0.00}"));
        assert!(unrelaxed_caveat(0.02, 0.02, 6.0).contains("at most 6 %"));
    }

    #[test]
    fn a_pattern_is_the_best_of_those_that_foretell_enough() {
        let told = pattern(&[(ResidualPattern::Time, 0.92), (ResidualPattern::Pose, 0.4)], &[]);
        assert!(told.starts_with("The residual depends on the time"), "{told}");
        assert!(told.ends_with("predict: 92 % by time, 40 % by pose."), "{told}");
        let none = pattern(&[(ResidualPattern::Pose, 0.05), (ResidualPattern::Time, 0.0)], &[]);
        assert!(none.starts_with("The residual differs between trials"), "{none}");
    }
}
