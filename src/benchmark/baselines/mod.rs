//! Methods that `discover` is compared with, on the same recording and the same linear responses of
//! the model (docs/evidence/blind_benchmark.md, "Beside other methods").

mod answers;
mod methods;
mod regression;

pub use answers::{BaselineAnswer, BaselineAnswers};

use crate::discovery::LinearProblem;
use methods::{FeatureLibrary, gp_detects};

/// What the methods say of a recording.
pub fn baseline_answers(problem: &LinearProblem) -> BaselineAnswers {
    let catalogue = FeatureLibrary::catalogue(problem);
    BaselineAnswers {
        sparse: catalogue.sparse(problem),
        ridge: catalogue.ridge(problem),
        library: FeatureLibrary::polynomials(problem).sparse(problem),
        gp_detects: gp_detects(problem),
    }
}

#[cfg(test)]
mod tests;
