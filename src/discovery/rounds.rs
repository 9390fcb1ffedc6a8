//! The loop of an ambiguous answer: record the experiment that it proposes, and ask again with both
//! recordings.

use super::{Discovery, DiscoveryError, NextExperiment, Options, discover};
use crate::data::Recording;
use crate::data::findings::Verdict;
use crate::data::recording::RecordingMismatch;
use crate::effects::Model;

/// What a discovery is asked beside the measured recording.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Model of the robot.
    pub model: &'a Model,
    /// Recording of the robot as built.
    pub baseline: Option<&'a Recording>,
    /// Options of every round.
    pub options: &'a Options,
}

/// An ambiguous answer whose proposal may be recorded.
#[derive(Clone, Copy, Debug)]
pub struct Round<'a> {
    /// Number of the round, from 1.
    pub number: usize,
    /// The answer; its `next_experiments` are the proposals, best first.
    pub answer: &'a Discovery,
    /// The recordings of all rounds so far, joined.
    pub measured: &'a Recording,
}

impl Round<'_> {
    /// The best proposal that keeps the base where it is; none if there is none.
    pub fn proposal_without_remounting(&self) -> Option<&NextExperiment> {
        self.answer.next_experiments.iter().find(|next| next.proposal.name != "base_remounted")
    }
}

/// The answers of all rounds.
#[derive(Clone, Debug)]
pub struct Rounds {
    /// The answer of the last round, from all recordings together.
    pub answer: Discovery,
    /// The answers of the rounds before, all of them ambiguous.
    pub earlier: Vec<Discovery>,
    /// The recordings that were added, one after each earlier answer.
    pub recorded: Vec<Recording>,
    /// All recordings, joined: the newest first.
    pub measured: Recording,
}

/// A loop that ended without an answer.
#[derive(Debug, thiserror::Error)]
pub enum RoundsError<E: std::error::Error> {
    /// The data of a round allow no answer.
    #[error("{error}")]
    Discovery {
        /// Why.
        error: DiscoveryError,
        /// The recordings of that round, joined.
        measured: Box<Recording>,
    },
    /// A new recording is of another robot.
    #[error(transparent)]
    Mismatch(RecordingMismatch),
    /// The callback failed.
    #[error(transparent)]
    Record(E),
}

/// Asks `question` of `measured`, and while the answer is ambiguous, records the experiment that
/// tells the rivals apart and asks again of all recordings together.
///
/// `record` returns a recording of one of the proposals; none ends the loop. It is called
/// `max_rounds` times at most.
///
/// # Errors
/// [`RoundsError`] if the data of a round allow no answer, a recording does not fit, or `record`
/// fails.
pub fn discover_until_named<E: std::error::Error>(
    question: Question,
    measured: Recording,
    max_rounds: usize,
    mut record: impl FnMut(&Round) -> Result<Option<Recording>, E>,
) -> Result<Rounds, RoundsError<E>> {
    let Question { model, baseline, options } = question;
    let (mut measured, mut earlier, mut recorded) = (measured, Vec::new(), Vec::new());
    loop {
        let answer = match discover(model, &measured, baseline, options) {
            Ok(answer) => answer,
            Err(error) => {
                return Err(RoundsError::Discovery { error, measured: Box::new(measured) });
            }
        };
        let is_open = answer.findings.verdict == Verdict::Ambiguous
            && !answer.next_experiments.is_empty()
            && recorded.len() < max_rounds;
        let round = Round { number: recorded.len() + 1, answer: &answer, measured: &measured };
        let recording = if is_open { record(&round).map_err(RoundsError::Record)? } else { None };
        let Some(recording) = recording else {
            return Ok(Rounds { answer, earlier, recorded, measured });
        };
        measured =
            Recording::joined(&[recording.clone(), measured]).map_err(RoundsError::Mismatch)?;
        earlier.push(answer);
        recorded.push(recording);
    }
}
