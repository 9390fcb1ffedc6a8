//! The league: controllers and diagnoses of other laboratories on robots with hidden effects
//! (docs/guide/league.md).
//!
//! Order: `track` (what is asked), `robot` (robots and their hidden effects, by a seed), `measured`
//! (real robots, from recordings), `season` (what is frozen and sealed), `submission`, `instance` (a
//! track on one robot as an ordinary experiment), `questions` (recordings to answer), `score`,
//! `play` (a submission on all robots), `answers` (answers to questions), `board`.

pub mod answers;
pub mod board;
pub mod instance;
pub mod measured;
pub mod play;
pub mod questions;
pub mod robot;
pub mod score;
pub mod season;
pub mod submission;
pub mod track;

/// Why the league cannot do what it is asked to, in words that name file and key.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LeagueError {
    /// Bad input.
    #[error("{0}")]
    Input(String),
    /// A run or a file that failed.
    #[error("{0}")]
    Failed(String),
}

impl LeagueError {
    pub(crate) fn input(words: impl std::fmt::Display) -> LeagueError {
        LeagueError::Input(words.to_string())
    }

    pub(crate) fn failed(words: impl std::fmt::Display) -> LeagueError {
        LeagueError::Failed(words.to_string())
    }
}

/// What [`is_name`] expects, in words.
const NAME: &str = "letters, digits, `_` and `-`, at most 64";

/// Whether a text can name a submission, a season, a track or a robot: files are named after them.
fn is_name(text: &str) -> bool {
    (1..=64).contains(&text.len())
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || "_-".contains(letter))
}
