//! One answer of each verdict: what `make check` asks of `discover` while one works.

use spinebench::data::findings::Verdict;
use spinebench::discovery::Options;

use super::hidden::{found, names, recorded};

#[test]
fn named() {
    let found = found(&recorded("- tip_load: {mass_kg: 0.01}", 4, 0, 0.0), &Options::default());
    assert_eq!(found.findings.verdict, Verdict::Named, "{}", found.findings.summary);
    assert_eq!((names(&found), found.model.effects.len()), (vec!["tip_load"], 1));
}

#[test]
fn consistent() {
    let found = found(&recorded("[]", 4, 7, 0.0), &Options::default());
    assert_eq!(found.findings.verdict, Verdict::Consistent, "{}", found.findings.summary);
    assert!(found.findings.effects.is_empty() && found.model.effects.is_empty());
}

/// A gram on the tip looks like a heavier rod.
#[test]
fn ambiguous() {
    let found = found(&recorded("- tip_load: {mass_kg: 0.0012}", 3, 0, 0.0), &Options::default());
    assert_eq!(found.findings.verdict, Verdict::Ambiguous, "{}", found.findings.summary);
    assert!(names(&found).contains(&"tip_load") && names(&found).len() > 1, "{:?}", names(&found));
    assert_eq!(found.model.effects.len(), 1, "the most likely one");
}

/// What is in no catalogue is not given a name that is.
#[test]
fn unexplained() {
    let options = Options { left_out: vec!["actuator_offset".to_owned()], ..Options::default() };
    let found =
        found(&recorded("- actuator_offset: {tendon: 3, offset_m: 0.003}", 4, 3, 0.0), &options);
    assert_eq!(found.findings.verdict, Verdict::Unexplained, "{}", found.findings.summary);
    assert!(found.findings.effects.is_empty() && found.model.effects.is_empty());
    assert!(!found.findings.pattern.is_empty());
}
