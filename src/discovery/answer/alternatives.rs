//! Alternatives to naming the effect: refit the stiffness alone, or the paper's Gaussian process on the residual.

use crate::base::Rows;
use crate::discovery::fit::candidate::{CandidateEffect, SetMember, effect_specs};
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::sensitivities::Sensitivity;
use crate::discovery::fit::simulate::tips;
use crate::discovery::recording::covariates::sample_covariates;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::learn::gp::{Gp, GpConfig};

/// Training points of the Gaussian process.
const GP_POINTS: usize = 100;

/// Rms error of both alternatives on held-out trials, metres; none if a fit fails.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alternatives {
    /// Young's modulus refitted.
    pub stiffness_only_m: Option<f64>,
    /// The paper's Gaussian process: residual over four commands and the simulated tip, 100 points.
    pub gp_m: Option<f64>,
}

/// Both alternatives: `fit_problem` has the training samples; `null` and `held_out_simulated_m` are without effects.
pub(crate) fn fit_alternatives(
    fit_problem: &FitProblem,
    sensitivities: &[Sensitivity],
    null: &FittedSet,
    held_out: &Samples,
    held_out_simulated_m: &[f64],
) -> Alternatives {
    Alternatives {
        stiffness_only_m: stiffness_only(fit_problem, sensitivities, null, held_out),
        gp_m: process(fit_problem.samples, &null.simulated_m, held_out, held_out_simulated_m),
    }
}

fn stiffness_only(
    fit_problem: &FitProblem,
    sensitivities: &[Sensitivity],
    null: &FittedSet,
    held_out: &Samples,
) -> Option<f64> {
    let candidate = fit_problem.candidates.iter().position(|h: &CandidateEffect| h.card.name == "bending_stiffness")?;
    let start = SetMember { candidate, values: fit_problem.candidates[candidate].variants().swap_remove(0) };
    let known = sensitivities.iter().find(|sensitivity| sensitivity.candidate == candidate)?;
    let slopes = fit_problem.known_jacobian(null, &start, known);
    let fitted = fit_problem.rough_fit(fit_problem.evaluate(vec![start])?, slopes, f64::INFINITY)?;
    let there = tips(fit_problem.model, &effect_specs(fit_problem.candidates, &fitted.members)?, held_out)?;
    Some(rms_m(&held_out.residual(&there)))
}

fn process(samples: &Samples, simulated_m: &[f64], held_out: &Samples, held_out_simulated_m: &[f64]) -> Option<f64> {
    let every = samples.len().div_ceil(GP_POINTS).max(1);
    let chosen: Vec<usize> = (0..samples.len()).step_by(every).collect();
    let inputs = inputs(samples, simulated_m);
    let mut outputs = Rows::new(3);
    samples.residual(simulated_m).chunks_exact(3).for_each(|row| outputs.push(row));
    let gp = Gp::fit(&inputs.select(&chosen), &outputs.select(&chosen), &GpConfig::default()).ok()?;
    let told = gp.mean_rows(&self::inputs(held_out, held_out_simulated_m)).ok()?;
    let left: Vec<f64> =
        held_out.residual(held_out_simulated_m).iter().zip(told.values()).map(|(r, t)| r - t).collect();
    Some(rms_m(&left))
}

/// Commands in force and simulated tip, one row a sample.
fn inputs(samples: &Samples, simulated_m: &[f64]) -> Rows {
    let covariates = sample_covariates(samples, simulated_m);
    let mut rows = Rows::new(covariates.first().map_or(0, |at| at.command.len() + 3));
    for at in &covariates {
        rows.push(&at.command.iter().copied().chain(at.position_m).collect::<Vec<f64>>());
    }
    rows
}
