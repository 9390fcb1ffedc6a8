//! What methods of comparison say of a recording.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What a method says of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BaselineAnswer {
    /// Whether it says that something is hidden.
    pub detects: bool,
    /// Probability of each effect, by name with its tendon; empty if it names none.
    pub probabilities: BTreeMap<String, f64>,
    /// Held-out rms error with what it has learnt, metres; that of the model as given if it detects
    /// nothing.
    pub left_m: f64,
}

/// What all methods say of one recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BaselineAnswers {
    /// Sparse regression on the responses to the effects of the catalogue.
    pub sparse: BaselineAnswer,
    /// All effects of the catalogue at once, with a ridge.
    pub ridge: BaselineAnswer,
    /// Sparse regression on polynomials and trigonometric functions of commands and simulated tip.
    pub library: BaselineAnswer,
    /// Whether a Gaussian process foretells unseen trials.
    pub gp_detects: bool,
}
