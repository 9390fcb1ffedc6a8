//! Random robots under random commands: every answer converged and right, or refused by name.

mod common;

use std::collections::BTreeMap;

use common::oracle::judge;
use common::random_robot::{Case, case};
use spinebench::base::Seed;
use spinebench::rod::{Rod, Status};

/// Draws of the quick campaign, and how many of them the oracle judges.
const QUICK: u64 = 250;
const JUDGED_QUICK: u64 = 60;

/// How a draw ended.
struct Outcome {
    status: Status,
    off_m: Option<f64>,
}

/// Settles the robot of one draw from a cold start. The answer is finite or has another name than converged; the oracle
/// judges it if `judged`.
fn settle(case: &Case, judged: bool) -> Outcome {
    let mut rod = Rod::new(case.params.clone());
    rod.set_tip_load(case.load);
    let status = rod.settle(&case.drives);
    if status != Status::Converged {
        return Outcome { status, off_m: None };
    }
    assert!(rod.tip_m().iter().all(|x| x.is_finite()), "{case:?}");
    assert!(rod.tensions_n().iter().all(|t| t.is_finite() && *t >= 0.0), "{case:?}");
    assert!(rod.residual_m().is_finite() && rod.space_error_m().is_finite());
    let verdict = if judged { judge(case, &rod) } else { None };
    let off_m = verdict.filter(|verdict| verdict.open < 1e-9).map(|verdict| {
        let turned = (verdict.rotation - rod.tip_rotation()).norm() * case.params.length_m();
        (verdict.tip_m - rod.tip_m()).norm().max(0.1 * turned)
    });
    Outcome { status, off_m }
}

fn tolerance_m(case: &Case) -> f64 {
    // Docs: rods whose material remembers are held to a hundred times the tolerance.
    let share = if case.params.memory.is_empty() { 1.0 } else { 100.0 };
    share * case.params.resolution.static_tolerance_m
}

#[test]
fn converged_statics_agree_with_an_independent_solver() {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let (mut judged, mut wrong) = (0, Vec::new());
    for k in 0..QUICK {
        let case = case(Seed(11).index(k));
        let outcome = settle(&case, k < JUDGED_QUICK);
        *counts.entry(outcome.status.name()).or_default() += 1;
        if let Some(off_m) = outcome.off_m {
            judged += 1;
            if off_m > tolerance_m(&case) {
                wrong.push((k, off_m));
            }
        }
    }
    println!("{counts:?}, {judged} judged");
    assert!(wrong.is_empty(), "draws off by more than the tolerance: {wrong:?}");
    assert!(judged > JUDGED_QUICK / 2, "only {judged} judged");
}
