//! Calibration of a model from a recording (paper, section III-B: Young's modulus from known tendon tensions and the
//! tracked tip, with Poisson's ratio fixed).

use nalgebra::DMatrix;

use crate::base::{BadOption, Point3};
use crate::data::Recording;
use crate::effects::{Model, ModelParameter, Robot, Variable, VariationError};
use crate::math::optimise::least_squares;
use crate::rod::PoseRates;
use crate::tasks::{RecordingWithRates, SimulationOptions, TaskError, simulate_recording, simulate_with_rates};

/// A parameter of a robot that can be calibrated; all are positive and fitted on a logarithmic scale.
pub struct CalibrationParameter {
    /// Its name: the key in the model file.
    pub name: &'static str,
    /// Its path in a model file.
    path: &'static str,
    /// Its field of a robot.
    field: fn(&mut Robot) -> &mut f64,
}

/// The parameters that `--fit` accepts.
pub static CALIBRATION_PARAMETERS: &[CalibrationParameter] = &[
    CalibrationParameter {
        name: "youngs_modulus_pa",
        path: "robot.backbone.youngs_modulus_pa",
        field: |robot| &mut robot.backbone.youngs_modulus_pa,
    },
    CalibrationParameter {
        name: "compliance_m_per_n",
        path: "robot.sections.compliance_m_per_n",
        field: |robot| &mut robot.sections.compliance_m_per_n,
    },
    CalibrationParameter { name: "disk_mass_kg", path: "robot.disks.mass_kg", field: |robot| &mut robot.disks.mass_kg },
    CalibrationParameter {
        name: "tendon_radius_m",
        path: "robot.tendons.radius_m",
        field: |robot| &mut robot.tendons.radius_m,
    },
    CalibrationParameter {
        name: "damping_time_s",
        path: "robot.damping_time_s",
        field: |robot| &mut robot.damping_time_s,
    },
    CalibrationParameter {
        name: "length_m",
        path: "robot.backbone.length_m",
        field: |robot| &mut robot.backbone.length_m,
    },
];

/// A parameter that moves no tip by more than [`TIP_ACCURACY_M`] when it changes by this share is not observable.
const SEEN_SHARE: f64 = 1e-3;
/// Accuracy of a simulated tip, metres: the rod's tolerance.
const TIP_ACCURACY_M: f64 = 1e-8;
/// Relative change of a parameter for finite differences of whole trials.
const TRIAL_STEP: f64 = 1e-3;

/// One calibrated parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibratedValue {
    /// Its name.
    pub name: &'static str,
    /// Best value, in the unit of its name.
    pub value: f64,
    /// 95 % interval.
    pub interval_95: [f64; 2],
}

/// The result of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The model with the best values.
    pub model: Model,
    /// The fitted parameters.
    pub numbers: Vec<CalibratedValue>,
    /// Root mean square distance between simulated and measured tip before the fit, metres.
    pub before_m: f64,
    /// The same after the fit, metres.
    pub after_m: f64,
    /// Number of compared rows.
    pub rows: usize,
}

/// Fits the parameters `names` so that the simulated tip of `measured` agrees with the measured one. Rows without tracking
/// are left out. `at_rest`: each row is a pose at rest.
///
/// # Errors
/// [`TaskError`] for an unknown name, a parameter that is zero in the model, too few rows, or commands that the model
/// cannot simulate.
pub fn calibrate(
    model: &Model,
    measured: &Recording,
    names: &[String],
    at_rest: bool,
) -> Result<Calibration, TaskError> {
    let fields: Vec<&CalibrationParameter> = names.iter().map(|name| adjustable(name)).collect::<Result<_, _>>()?;
    let tips = measured.tip_m.as_ref().ok_or(TaskError::NotFinite("the recording has no tip"))?;
    let rows: Vec<usize> =
        (0..measured.len()).filter(|&row| measured.is_valid(row) && tips[row].iter().all(|x| x.is_finite())).collect();
    if 3 * rows.len() <= fields.len() {
        return Err(TaskError::TooFew { what: "tracked rows", asked: fields.len() / 3 + 1, available: rows.len() });
    }
    let mut start_robot = model.robot.clone();
    let values: Vec<f64> = fields.iter().map(|field| *(field.field)(&mut start_robot)).collect();
    for (index, (field, &value)) in fields.iter().zip(&values).enumerate() {
        BadOption::unless_positive(field.name, value)?;
        if names[..index].contains(&names[index]) {
            return Err(TaskError::Repeated(field.name));
        }
    }
    // Logarithms of the factors of the values: a parameter that is not observable keeps its value exactly.
    let start = vec![0.0; fields.len()];
    let with = |logs: &[f64]| {
        let mut candidate = model.clone();
        for (field, log) in fields.iter().zip(logs) {
            *(field.field)(&mut candidate.robot) *= log.exp();
        }
        candidate
    };
    let options = SimulationOptions { at_rest, ..SimulationOptions::default() };
    let residuals = |logs: &[f64]| {
        let candidate = with(logs);
        // A step may leave the range of a parameter, or of two together (sections longer than the backbone).
        candidate.check().ok()?;
        let simulated = simulate_recording(&candidate, measured, &options).tip_m?;
        let all: Vec<f64> = rows
            .iter()
            .flat_map(|&row| (0..3).map(move |axis| (row, axis)))
            .map(|(r, a)| simulated[r][a] - tips[r][a])
            .collect();
        all.iter().all(|value| value.is_finite()).then_some(all)
    };
    let per_row = |all: &[f64]| (all.iter().map(|r| r * r).sum::<f64>() / rows.len() as f64).sqrt();
    let not_simulated = TaskError::NotFinite("the model cannot simulate these commands");
    let before_m = per_row(&residuals(&start).ok_or_else(|| not_simulated.clone())?);
    let derivative = |logs: &[f64]| {
        let rates = tip_rates(&with(logs), measured, &options, &fields)?;
        let slope = |row: usize, k: usize| rates[k][rows[row / 3]][row % 3] * values[k] * logs[k].exp();
        let jacobian = DMatrix::from_fn(3 * rows.len(), fields.len(), slope);
        Some(least_squares::unseen_left_out(jacobian, SEEN_SHARE, TIP_ACCURACY_M))
    };
    let fit = least_squares::fit(&residuals, &derivative, &start).ok_or_else(|| not_simulated.clone())?;
    let numbers = (0..fields.len()).map(|k| CalibratedValue {
        name: fields[k].name,
        value: values[k] * fit.parameters[k].exp(),
        interval_95: fit.interval_95[k].map(|log| values[k] * log.exp()),
    });
    Ok(Calibration {
        numbers: numbers.collect(),
        before_m,
        after_m: per_row(&residuals(&fit.parameters).ok_or(not_simulated)?),
        rows: rows.len(),
        model: with(&fit.parameters),
    })
}

/// For each parameter, the derivative of the tip in each row, metres per unit of the parameter. `None` when the model cannot
/// simulate the commands.
fn tip_rates(
    model: &Model,
    commands: &Recording,
    options: &SimulationOptions,
    fields: &[&CalibrationParameter],
) -> Option<Vec<Vec<Point3>>> {
    let parameter = |field: &&CalibrationParameter| ModelParameter::named(model, field.path);
    let parameters: Vec<ModelParameter> = fields.iter().map(parameter).collect::<Result<_, _>>().ok()?;
    let variables: Vec<Variable> = parameters.iter().cloned().map(Variable::Parameter).collect();
    let RecordingWithRates { rates, left_out, .. } = simulate_with_rates(model, commands, options, &variables).ok()?;
    let simulated = |candidate: &Model| -> Result<Vec<Point3>, VariationError> {
        Ok(simulate_recording(candidate, commands, options).tip_m.unwrap_or_default())
    };
    let mut columns = Vec::new();
    for (k, parameter) in parameters.iter().enumerate() {
        if left_out.contains(&k) {
            columns.push(parameter.differences(model, TRIAL_STEP, &simulated).ok()?);
        } else {
            let column = k - left_out.iter().filter(|&&other| other < k).count();
            // Rows without a solution have no derivative and are not compared.
            let rate =
                |row: &Vec<PoseRates>| row.get(column).map_or([f64::NAN; 3], |rates| rates.tip.position_m.into());
            columns.push(rates.iter().map(rate).collect());
        }
    }
    Some(columns)
}

fn adjustable(name: &str) -> Result<&'static CalibrationParameter, TaskError> {
    CALIBRATION_PARAMETERS
        .iter()
        .find(|field| field.name == name)
        .ok_or_else(|| TaskError::UnknownName(name.to_owned()))
}
