//! Alternatives to naming the effect: refit the stiffness alone, or the paper's Gaussian process on
//! the residual.

use crate::base::Rows;
use crate::discovery::fit::candidate::{SetMember, effect_specs};
use crate::discovery::fit::gauss_newton::FittedSet;
use crate::discovery::fit::simulate::tips;
use crate::discovery::problem::Problem;
use crate::discovery::recording::covariates::sample_covariates;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::learn::gp::{Gp, GpConfig};

/// Training points of the Gaussian process, as many as the paper's.
const GP_POINTS: usize = 100;

/// Rms error of both alternatives on held-out trials, metres; none if a fit fails.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alternatives {
    /// Young's modulus refitted.
    pub stiffness_only_m: Option<f64>,
    /// The paper's Gaussian process: residual over four commands and the simulated tip, 100 points.
    pub gp_m: Option<f64>,
}

impl Problem<'_> {
    /// Both alternatives; `null`: fit without effects.
    pub(crate) fn alternatives(&self, null: &FittedSet) -> Alternatives {
        Alternatives { stiffness_only_m: self.stiffness_only_m(null), gp_m: self.gp_m(null) }
    }

    fn stiffness_only_m(&self, null: &FittedSet) -> Option<f64> {
        let fit_problem = self.fit_problem();
        let candidate =
            self.candidates.iter().position(|one| one.card.name == "bending_stiffness")?;
        let start =
            SetMember { candidate, values: self.candidates[candidate].variants().swap_remove(0) };
        let sensitivity =
            self.sensitivities.iter().find(|sensitivity| sensitivity.candidate == candidate)?;
        // One number is nearly linear: the first look's derivative spares a new Jacobian.
        let jacobian = fit_problem.extended_jacobian(null, &start, sensitivity);
        let fitted =
            fit_problem.rough_fit(fit_problem.evaluate(vec![start])?, jacobian, f64::INFINITY)?;
        let simulated_m =
            tips(&self.model, &effect_specs(&self.candidates, &fitted.members)?, &self.held_out)?;
        Some(rms_m(&self.held_out.residual(&simulated_m)))
    }

    fn gp_m(&self, null: &FittedSet) -> Option<f64> {
        // Evenly spaced rows cover all training trials.
        let every = self.training.len().div_ceil(GP_POINTS).max(1);
        let chosen: Vec<usize> = (0..self.training.len()).step_by(every).collect();
        let training_inputs = gp_inputs(&self.training, &null.simulated_m);
        let mut outputs = Rows::new(3);
        self.training.residual(&null.simulated_m).chunks_exact(3).for_each(|row| outputs.push(row));
        let gp = Gp::fit(
            &training_inputs.select(&chosen),
            &outputs.select(&chosen),
            &GpConfig::default(),
        )
        .ok()?;
        let predicted =
            gp.mean_rows(&gp_inputs(&self.held_out, &self.held_out_simulated_m)).ok()?;
        let residual_m = self.held_out.residual(&self.held_out_simulated_m);
        Some(rms_m(
            &residual_m.iter().zip(predicted.values()).map(|(r, p)| r - p).collect::<Vec<f64>>(),
        ))
    }
}

/// Commands in force and simulated tip, one row a sample.
pub(crate) fn gp_inputs(samples: &Samples, simulated_m: &[f64]) -> Rows {
    let covariates = sample_covariates(samples, simulated_m);
    let mut rows = Rows::new(covariates.first().map_or(0, |at| at.command.len() + 3));
    for at in &covariates {
        rows.push(&at.command.iter().copied().chain(at.position_m).collect::<Vec<f64>>());
    }
    rows
}
