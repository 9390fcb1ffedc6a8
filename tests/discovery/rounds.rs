//! The loop ambiguous → record the proposed experiment → ask again.

use std::convert::Infallible;

use spinebench::data::Recording;
use spinebench::data::findings::Verdict;
use spinebench::discovery::{
    Options, Question, Round, Rounds, RoundsError, discover, discover_until_named,
};
use spinebench::effects::Model;
use spinebench::tasks::{SimulationOptions, simulate_recording};

use super::hidden::{NOISE_M, nominal, recorded, trials, twin};

fn asked(
    measured: Recording,
    max_rounds: usize,
    record: impl FnMut(&Round) -> Result<Option<Recording>, Infallible>,
) -> Result<Rounds, RoundsError<Infallible>> {
    let (model, options) = (nominal(), Options::default());
    let question = Question { model: &model, baseline: None, options: &options };
    discover_until_named(question, measured, max_rounds, record)
}

/// A gram on the tip looks like a heavier rod until the proposed experiment is recorded, once at
/// most here.
#[test]
fn an_ambiguous_answer_is_asked_again_with_the_proposed_recording() {
    let first = recorded("- tip_load: {mass_kg: 0.0012}", 3, 0, 0.0);
    let truth = Model {
        effects: crate::support::rods::effects("- tip_load: {mass_kg: 0.0012}"),
        ..nominal()
    };
    let mut calls = 0;
    let rounds = asked(first.clone(), 1, |round| {
        calls += 1;
        assert_eq!((round.number, round.answer.findings.verdict), (1, Verdict::Ambiguous));
        assert_eq!(round.measured.trials().len(), 3);
        let next = round.proposal_without_remounting().unwrap();
        let options = SimulationOptions { noise_m: NOISE_M, ..SimulationOptions::default() };
        let mut recording = simulate_recording(&truth, &next.commands, &options);
        recording.forget_orientations();
        recording.extra.clear();
        Ok(Some(recording))
    });
    let rounds = rounds.unwrap();
    assert_eq!((calls, rounds.earlier.len(), rounds.recorded.len()), (1, 1, 1));
    let all = rounds.recorded[0].trials().len() + first.trials().len();
    assert_eq!(rounds.measured.trials().len(), all, "the last answer is that of all recordings");
    assert_eq!(
        rounds.earlier[0].findings,
        discover(&nominal(), &first, None, &Options::default()).unwrap().findings
    );
}

#[test]
fn the_loop_ends_without_a_recording_and_refuses_data_that_allow_no_answer() {
    let none = |_: &Round| Ok(None);
    let few = trials(&twin("nothing"), 0, 1);
    let refused = asked(few.clone(), 3, none).unwrap_err();
    assert!(
        matches!(refused, RoundsError::Discovery { ref measured, .. } if **measured == few),
        "{refused}"
    );
    let rounds = asked(recorded("[]", 4, 7, 0.0), 3, |_| {
        unreachable!("a consistent answer needs no recording")
    });
    assert_eq!(rounds.unwrap().answer.findings.verdict, Verdict::Consistent);
}
