//! Where nothing is hidden, or nothing that the catalogue has, or not quite that.

use spinebench::data::findings::Verdict;
use spinebench::discovery::{Options, discover};

use super::hidden::{NOISE_M, chain, found, from_benchmark, names, nominal, recorded};

#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    for (seed, correlation) in [(7, 0.0), (8, 0.6)] {
        let found = found(&recorded("[]", 4, seed, correlation), &Options::default());
        assert_eq!(found.findings.verdict, Verdict::Consistent, "{}", found.findings.summary);
        assert!(found.findings.effects.is_empty() && found.model.effects.is_empty());
        let floor = found.findings.noise_floor_m / (3.0_f64.sqrt() * NOISE_M);
        assert!((0.8..1.2).contains(&floor), "{floor}");
        assert_eq!(found.findings.gap.before_m, found.findings.gap.after_m);
    }
}

/// Case 942 of experiments/discovery_full.yaml: the zero of a drive stands for its gain, in many
/// ways a little badly, and worst where it does most.
#[test]
#[ignore = "make campaign"]
fn what_only_resembles_the_gap_is_unexplained() {
    let options = Options { left_out: vec!["actuator_gain".to_owned()], ..Options::default() };
    let found = found(&from_benchmark("case_942.csv"), &options);
    assert_eq!(found.findings.verdict, Verdict::Unexplained, "{}", found.findings.summary);
    assert_eq!(found.findings.candidates[0].name.split(' ').next(), Some("actuator_offset"));
    let said = "where it moves the tip most";
    assert!(found.findings.summary.contains(said), "{}", found.findings.summary);
    let refused: Vec<_> =
        found.findings.candidates.iter().filter(|one| one.why_not.contains(said)).collect();
    assert!(refused.len() == 1 && refused[0].name.starts_with("actuator_offset"), "{refused:?}");
}

/// Dry friction as another simulator has it, which does not yield before it slips, is near enough
/// to ours.
#[test]
#[ignore = "make campaign"]
fn a_law_that_is_nearly_the_robots_is_named() {
    let friction =
        discover(&nominal(), &chain("r40.csv"), Some(&chain("baseline.csv")), &Options::default())
            .unwrap();
    assert_eq!(names(&friction), ["friction"], "{}", friction.findings.summary);
}

/// A spine that softens where it has been bent is told by laws of the catalogue that leave more
/// than noise.
#[test]
#[ignore = "make campaign"]
fn what_a_law_that_is_only_like_the_robots_leaves_is_said() {
    let softening =
        discover(&nominal(), &chain("r18.csv"), Some(&chain("baseline.csv")), &Options::default())
            .unwrap();
    let said = &softening.findings.limitations;
    assert!(
        said.iter().any(|said| said.contains("not only noise")),
        "{}: {said:?}",
        softening.findings.summary
    );
}
