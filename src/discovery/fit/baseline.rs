//! Calibration on a baseline, a recording of the robot as built, and the errors that it shares with
//! the measured recording (model form, tracking frame, settling), which are not attributed to an
//! effect.

use std::collections::BTreeSet;

use nalgebra::DMatrix;

use super::candidate::{CandidateEffect, SetMember};
use super::gauss_newton::FitProblem;
use super::nuisance::{NuisanceColumn, Nuisances};
use crate::discovery::recording::covariates::{Covariates, sample_covariates};
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// Effects that scale the calibrated parameters.
const CALIBRATED: [&str; 2] = ["bending_stiffness", "spine_compressibility"];

/// Expected model-form error by axis and term, metres.
const FORM_M: f64 = 5e-4;
/// The same for terms of the tip's motion.
const MOTION_FORM_M: f64 = 2e-4;

/// Lower bound of the speed by which motion terms are scaled, m/s.
const MIN_SPEED_M_S: f64 = 5e-5;

/// Factors by which calibration multiplied parameters of the model.
#[derive(Clone, Copy)]
pub(crate) struct CalibrationFactors {
    pub(crate) bending_stiffness: f64,
    pub(crate) compliance: f64,
}

/// Calibrates `model` on `baseline`; returns the calibrated model and its factors. None if the
/// model cannot be simulated.
pub(crate) fn calibrate(
    model: &Model,
    candidates: &[CandidateEffect],
    baseline: &Samples,
    nuisances: &Nuisances,
) -> Option<(Model, CalibrationFactors)> {
    // This fit never searches, so no candidate needs to be closed.
    let open = vec![true; candidates.len()];
    let fit_problem =
        FitProblem { model, coarse: model, candidates, open, samples: baseline, nuisances };
    let start = CALIBRATED.iter().filter_map(|name| {
        let candidate = candidates.iter().position(|candidate| candidate.card.name == *name)?;
        Some(SetMember { candidate, values: candidates[candidate].variants().swap_remove(0) })
    });
    let fitted = fit_problem.fit(start.collect())?;
    let [bending_stiffness, compliance] = CALIBRATED.map(|name| {
        let member =
            fitted.members.iter().find(|member| candidates[member.candidate].card.name == name);
        member.map_or(1.0, |member| member.values[0])
    });
    let mut model = model.clone();
    model.robot.backbone.scale_bending(bending_stiffness);
    model.robot.sections.compliance_m_per_n *= compliance;
    model.check().is_ok().then_some((model, CalibrationFactors { bending_stiffness, compliance }))
}

/// Basis of a smooth model-form error as a function of position and motion of each tracked place.
struct ModelFormBasis {
    /// The places: the tip (none) and points.
    places: Vec<(Option<usize>, PlaceBasis)>,
}

/// Basis of one place.
struct PlaceBasis {
    middle_m: [f64; 3],
    spread_m: [f64; 3],
    speed_m_s: f64,
}

impl ModelFormBasis {
    /// Basis scaled to the covariates of a baseline.
    fn new(covariates: &[Covariates]) -> ModelFormBasis {
        let points: BTreeSet<Option<usize>> = covariates.iter().map(|at| at.point).collect();
        let basis = |point: Option<usize>| {
            let in_place: Vec<&Covariates> =
                covariates.iter().filter(|at| at.point == point).collect();
            (point, PlaceBasis::new(&in_place))
        };
        ModelFormBasis { places: points.into_iter().map(basis).collect() }
    }

    /// Terms in every sample, three values a sample, with their prior standard deviations.
    fn columns(&self, covariates: &[Covariates]) -> Vec<NuisanceColumn> {
        self.places.iter().flat_map(|(point, basis)| basis.columns(*point, covariates)).collect()
    }
}

impl PlaceBasis {
    fn new(covariates: &[&Covariates]) -> PlaceBasis {
        let column =
            |axis: usize| covariates.iter().map(|at| at.position_m[axis]).collect::<Vec<f64>>();
        let moving: Vec<f64> = covariates.iter().flat_map(|at| at.velocity_m_s).collect();
        PlaceBasis {
            middle_m: std::array::from_fn(|axis| crate::math::summary::mean(&column(axis))),
            spread_m: std::array::from_fn(|axis| {
                crate::math::summary::standard_deviation(&column(axis)).max(1e-4)
            }),
            speed_m_s: crate::math::summary::root_mean_square(&moving).max(MIN_SPEED_M_S),
        }
    }

    /// Terms in the samples of this place; zero in all others.
    fn columns(&self, point: Option<usize>, covariates: &[Covariates]) -> Vec<NuisanceColumn> {
        let in_place = |terms: &dyn Fn(&Covariates) -> Vec<f64>| -> Vec<Vec<f64>> {
            let each = |at: &Covariates| {
                let terms = terms(at);
                // Each place of the body has its own model-form error.
                if at.point == point { terms } else { vec![0.0; terms.len()] }
            };
            covariates.iter().map(each).collect()
        };
        let terms = in_place(&|at| self.terms(at));
        let moving = in_place(&|at| at.velocity_m_s.map(|v| v / self.speed_m_s).to_vec());
        let mut columns = Vec::new();
        for (table, deviation) in [(&terms, FORM_M), (&moving, MOTION_FORM_M)] {
            for term in 0..table.first().map_or(0, Vec::len) {
                for axis in 0..3 {
                    let value =
                        |row: usize, a: usize| if a == axis { table[row][term] } else { 0.0 };
                    columns.push((
                        (0..3 * table.len()).map(|k| value(k / 3, k % 3)).collect(),
                        deviation,
                    ));
                }
            }
        }
        columns
    }

    /// Monomials up to degree three in the position.
    fn terms(&self, at: &Covariates) -> Vec<f64> {
        let x: [f64; 3] = std::array::from_fn(|axis| {
            // Cubic terms explode outside the recorded poses; three deviations bound them.
            ((at.position_m[axis] - self.middle_m[axis]) / self.spread_m[axis]).clamp(-3.0, 3.0)
        });
        let mut terms = vec![1.0];
        for i in 0..3 {
            terms.push(x[i]);
            for j in i..3 {
                terms.push(x[i] * x[j]);
                // At the bound of three deviations a cubic term is then as large as a square one.
                terms.extend((j..3).map(|k| x[i] * x[j] * x[k] / 3.0));
            }
        }
        terms
    }
}

/// A recording beside the model.
#[derive(Clone, Copy)]
pub(crate) struct SimulatedRecording<'a> {
    pub(crate) samples: &'a Samples,
    /// Simulated tip, three values a sample, metres.
    pub(crate) simulated_m: &'a [f64],
    /// Columns of the uncertain parameters.
    pub(crate) columns: &'a [NuisanceColumn],
}

/// Nuisance parameters of the baseline itself: uncertain parameters and model form, by their
/// priors.
pub(crate) fn baseline_nuisances(baseline: SimulatedRecording) -> Nuisances {
    let SimulatedRecording { samples, simulated_m, columns } = baseline;
    let covariates = sample_covariates(samples, simulated_m);
    let form = ModelFormBasis::new(&covariates);
    let all: Vec<NuisanceColumn> =
        columns.iter().cloned().chain(form.columns(&covariates)).collect();
    Nuisances::independent(simulated_m.len(), &all)
}

/// Nuisance parameters of the measured recording after the baseline: uncertain parameters and model
/// form.
pub(crate) fn calibrated_nuisances(
    baseline: SimulatedRecording,
    recording: SimulatedRecording,
) -> Nuisances {
    let SimulatedRecording { samples, simulated_m, .. } = baseline;
    // The scales are those of the baseline, so that its amounts mean the same in both recordings.
    let form = ModelFormBasis::new(&sample_covariates(samples, simulated_m));
    let before = baseline_nuisances(baseline);
    let nuisance_fit = before.explain(samples, &samples.residual(simulated_m), 0.0);
    let precision = before.information(&nuisance_fit.noise.whitened(samples, &before.columns));
    // The posterior of the baseline is the prior of the measured recording.
    let SimulatedRecording { samples, simulated_m, columns: uncertain } = recording;
    let covariates = sample_covariates(samples, simulated_m);
    let form = form.columns(&covariates);
    let all: Vec<&NuisanceColumn> = uncertain.iter().chain(&form).collect();
    let columns = DMatrix::from_fn(simulated_m.len(), all.len(), |row, k| all[k].0[row]);
    Nuisances::new(columns, nuisance_fit.amounts, precision)
}
