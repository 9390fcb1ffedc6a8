//! A recording as a linear problem, for methods that `discover` is compared with: what the model
//! leaves, and the linear responses of the tip to a little of every effect, as the screening of the
//! search has them.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::answer::alternatives::gp_inputs;
use super::error::DiscoveryError;
use super::fit::ar1_noise::MIN_SIGMA_M;
use super::fit::sensitivities::{Sensitivity, sensitivities};
use super::mistakes::excluded_rows::PreparedRecording;
use super::noise_floor::NoiseFloor;
use super::options::Options;
use super::problem::Problem;
use super::recording::samples::Samples;
use super::recording::validate;
use crate::base::Rows;
use crate::data::Recording;
use crate::effects::Model;

/// What a linear regression of the residual can know of a recording.
#[derive(Clone, Debug)]
pub struct LinearProblem {
    /// Trials for fitting: those that the search fits. Their residual is without what the prior of
    /// the nuisance parameters expects.
    pub training: LinearRows,
    /// Held-out trials with their whole residual.
    pub held_out: LinearRows,
    /// Effect of each response column, with the tendon if it acts on one.
    pub effects: Vec<String>,
    /// Tip change per unit of each nuisance parameter in the training trials.
    pub nuisances: DMatrix<f64>,
    /// Prior precision of the nuisance parameters.
    pub nuisance_precision: DMatrix<f64>,
    /// Noise by axis, metres, from repeats and neighbours.
    pub noise_m: f64,
}

/// Samples of some trials. Vectors and matrices have three rows a sample.
#[derive(Clone, Debug)]
pub struct LinearRows {
    /// Samples of each trial.
    pub trials: Vec<Range<usize>>,
    /// Measured minus simulated tip, metres.
    pub residual_m: DVector<f64>,
    /// Tip change over parameter change of each effect, for each of its shapes, places and sizes.
    pub responses: DMatrix<f64>,
    /// Commands in force and simulated tip, one row a sample.
    pub inputs: Rows,
}

/// The linear problem of a `measured` recording; arguments as those of [`super::discover`].
///
/// # Errors
/// [`DiscoveryError`] if the model cannot be compared with the recording.
pub fn linear_problem(
    model: &Model,
    measured: &Recording,
    baseline: Option<&Recording>,
    options: &Options,
) -> Result<LinearProblem, DiscoveryError> {
    options.check()?;
    let measured = PreparedRecording::new(model, measured, options);
    let baseline = baseline
        .map(|baseline| PreparedRecording::new(model, baseline, options).in_step(model, options));
    validate::check_measured(&measured.kept, &measured.samples)?;
    let problem = Problem::new(model, measured.samples.clone(), baseline.as_ref(), options)?;
    Ok(linear(&problem))
}

fn linear(problem: &Problem) -> LinearProblem {
    let open = problem.fit_problem().open;
    let of_held_out =
        sensitivities(&problem.coarse, &problem.candidates, &[], &|_| true, &problem.held_out);
    // A variant that cannot be simulated in some trials is no column.
    let in_both = |one| Some((one, of_held_out.iter().find(|other| other.is_small_step_of(one))?));
    let pairs: Vec<(&Sensitivity, &Sensitivity)> = problem
        .sensitivities
        .iter()
        .filter(|one| open[one.candidate])
        .filter_map(in_both)
        .collect();
    let effects = pairs
        .iter()
        .flat_map(|(one, _)| vec![problem.candidates[one.candidate].label(); one.columns.ncols()]);
    let residual_m = problem.training.residual(&problem.simulated_m);
    let null = problem.nuisances.explain(&problem.training, &residual_m, 0.0);
    let floor = NoiseFloor::estimate(&problem.training, &null, &problem.simulated_m);
    let training = rows(
        &problem.training,
        &problem.simulated_m,
        problem.nuisances.residual_by_prior(&residual_m),
        pairs.iter().map(|(one, _)| &one.columns),
    );
    let held_out = rows(
        &problem.held_out,
        &problem.held_out_simulated_m,
        problem.held_out.residual(&problem.held_out_simulated_m),
        pairs.iter().map(|(_, other)| &other.columns),
    );
    LinearProblem {
        training,
        held_out,
        effects: effects.collect(),
        nuisances: problem.nuisances.columns.clone(),
        nuisance_precision: problem.nuisances.precision.clone(),
        noise_m: (floor.rms_m() / 3.0_f64.sqrt()).max(MIN_SIGMA_M),
    }
}

/// Rows of `samples`, which the model simulates at `simulated_m`, with this residual and these
/// responses.
fn rows<'a>(
    samples: &Samples,
    simulated_m: &[f64],
    residual_m: Vec<f64>,
    responses: impl Iterator<Item = &'a DMatrix<f64>>,
) -> LinearRows {
    let columns: Vec<_> = responses.flat_map(|one| one.column_iter()).collect();
    let none = || DMatrix::zeros(residual_m.len(), 0);
    LinearRows {
        trials: samples.ranges(),
        responses: if columns.is_empty() { none() } else { DMatrix::from_columns(&columns) },
        residual_m: residual_m.into(),
        inputs: gp_inputs(samples, simulated_m),
    }
}
