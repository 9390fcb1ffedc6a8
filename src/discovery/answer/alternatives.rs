//! What a lab would try instead of naming the effect: stiffness fitted anew, and the paper's Gaussian process on what is
//! left.

use crate::base::Rows;
use crate::discovery::fit::candidate::{Hypothesis, Member, effects};
use crate::discovery::fit::gauss_newton::{Fitted, Study};
use crate::discovery::fit::sensitivities::Response;
use crate::discovery::fit::simulate::tips;
use crate::discovery::recording::covariates::circumstances;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::learn::gp::{Gp, GpConfig};

/// Points that the paper's process learns from.
const GP_POINTS: usize = 100;

/// Error of two other remedies on held-out trials, root mean square, metres; none where a remedy has no answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remedies {
    /// Young's modulus fitted, nothing else.
    pub stiffness_only_m: Option<f64>,
    /// The paper's Gaussian process: residual over four commands and the simulated tip, 100 points.
    pub gp_m: Option<f64>,
}

/// The remedies on the same trials: `study` has those of the fit, `proof` those held out; `null` and `proof_played` are
/// without effects.
pub(crate) fn remedies(
    study: &Study,
    responses: &[Response],
    null: &Fitted,
    proof: &Samples,
    proof_played: &[f64],
) -> Remedies {
    Remedies {
        stiffness_only_m: stiffness_only(study, responses, null, proof),
        gp_m: process(study.samples, &null.played, proof, proof_played),
    }
}

fn stiffness_only(study: &Study, responses: &[Response], null: &Fitted, proof: &Samples) -> Option<f64> {
    let hypothesis = study.hypotheses.iter().position(|h: &Hypothesis| h.card.name == "bending_stiffness")?;
    let start = Member { hypothesis, values: study.hypotheses[hypothesis].variants().swap_remove(0) };
    let known = responses.iter().find(|response| response.hypothesis == hypothesis)?;
    let slopes = study.known_slopes(null, &start, known);
    let fitted = study.rough_fit(study.at(vec![start])?, slopes, f64::INFINITY)?;
    let there = tips(study.model, &effects(study.hypotheses, &fitted.members)?, proof)?;
    Some(rms_m(&proof.residual(&there)))
}

fn process(samples: &Samples, played: &[f64], proof: &Samples, proof_played: &[f64]) -> Option<f64> {
    let every = samples.len().div_ceil(GP_POINTS).max(1);
    let chosen: Vec<usize> = (0..samples.len()).step_by(every).collect();
    let inputs = inputs(samples, played);
    let mut outputs = Rows::new(3);
    samples.residual(played).chunks_exact(3).for_each(|row| outputs.push(row));
    let gp = Gp::fit(&inputs.select(&chosen), &outputs.select(&chosen), &GpConfig::default()).ok()?;
    let told = gp.mean_rows(&self::inputs(proof, proof_played)).ok()?;
    let left: Vec<f64> = proof.residual(proof_played).iter().zip(told.values()).map(|(r, t)| r - t).collect();
    Some(rms_m(&left))
}

/// Commands in force and the simulated tip, a row a sample.
fn inputs(samples: &Samples, played: &[f64]) -> Rows {
    let around = circumstances(samples, played);
    let mut rows = Rows::new(around.first().map_or(0, |at| at.command.len() + 3));
    for at in &around {
        rows.push(&at.command.iter().copied().chain(at.tip_m).collect::<Vec<f64>>());
    }
    rows
}
