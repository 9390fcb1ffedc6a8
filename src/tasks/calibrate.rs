//! Calibration of a model from a recording (paper, section III-B: Young's modulus from weights hung on tendons and the
//! tracked tip, Poisson's ratio held).

use super::TaskError;
use super::play::{PlayOptions, play};
use crate::base::BadOption;
use crate::data::Recording;
use crate::effects::{Model, Robot};
use crate::math::least_squares::{self, Differences};

/// A number of a robot that can be calibrated; all are positive and fitted on a logarithmic scale.
pub struct Adjustable {
    /// Its name: the key in the model file.
    pub name: &'static str,
    /// Where it stands.
    field: fn(&mut Robot) -> &mut f64,
}

/// Everything that `--fit` can name.
pub static ADJUSTABLE: &[Adjustable] = &[
    Adjustable { name: "youngs_modulus_pa", field: |robot| &mut robot.backbone.youngs_modulus_pa },
    Adjustable { name: "compliance_m_per_n", field: |robot| &mut robot.sections.compliance_m_per_n },
    Adjustable { name: "disk_mass_kg", field: |robot| &mut robot.disks.mass_kg },
    Adjustable { name: "tendon_radius_m", field: |robot| &mut robot.tendons.radius_m },
    Adjustable { name: "damping_time_s", field: |robot| &mut robot.damping_time_s },
    Adjustable { name: "length_m", field: |robot| &mut robot.backbone.length_m },
];

/// Step of the finite differences in the logarithm of a number.
const LOG_STEP: f64 = 1e-3;
/// Accuracy of a played tip, metres: the rod's tolerance.
const TIP_ACCURACY_M: f64 = 1e-8;

const DIFFERENCES: Differences = Differences { step: LOG_STEP, accuracy: TIP_ACCURACY_M };

/// One calibrated number.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// Its name.
    pub name: &'static str,
    /// Best value, in the unit of its name.
    pub value: f64,
    /// 95 % interval.
    pub interval_95: [f64; 2],
}

/// What a calibration found.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The model with the best values.
    pub model: Model,
    /// What was fitted.
    pub numbers: Vec<Calibrated>,
    /// Root mean square distance of the tip from the measured one before, metres.
    pub before_m: f64,
    /// The same after, metres.
    pub after_m: f64,
    /// Rows that were compared.
    pub rows: usize,
}

/// Fits the numbers called `names` so that the played commands of `measured` bring the tip where it was measured. Rows
/// without tracking are left out. `at_rest`: each row is a pose at rest.
///
/// # Errors
/// [`TaskError`] for an unknown name, a number that is zero in the model, too few rows, or a model that cannot play
/// the commands.
pub fn calibrate(
    model: &Model,
    measured: &Recording,
    names: &[String],
    at_rest: bool,
) -> Result<Calibration, TaskError> {
    let fields: Vec<&Adjustable> = names.iter().map(|name| adjustable(name)).collect::<Result<_, _>>()?;
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
    // Logarithms of what the values are multiplied by: a number that is not seen stays as it is to the last digit.
    let start = vec![0.0; fields.len()];
    let with = |logs: &[f64]| {
        let mut candidate = model.clone();
        for (field, log) in fields.iter().zip(logs) {
            *(field.field)(&mut candidate.robot) *= log.exp();
        }
        candidate
    };
    let options = PlayOptions { at_rest, ..PlayOptions::default() };
    let residuals = |logs: &[f64]| {
        let candidate = with(logs);
        // A step may leave the range of a number, or of two together (sections longer than the backbone).
        candidate.check().ok()?;
        let played = play(&candidate, measured, &options).tip_m?;
        let all: Vec<f64> = rows
            .iter()
            .flat_map(|&row| (0..3).map(move |axis| (row, axis)))
            .map(|(r, a)| played[r][a] - tips[r][a])
            .collect();
        all.iter().all(|value| value.is_finite()).then_some(all)
    };
    let per_row = |all: &[f64]| (all.iter().map(|r| r * r).sum::<f64>() / rows.len() as f64).sqrt();
    let unplayable = TaskError::NotFinite("the model cannot play these commands");
    let before_m = per_row(&residuals(&start).ok_or_else(|| unplayable.clone())?);
    let fit = least_squares::fit(&residuals, &start, DIFFERENCES).ok_or_else(|| unplayable.clone())?;
    let numbers = (0..fields.len()).map(|k| Calibrated {
        name: fields[k].name,
        value: values[k] * fit.parameters[k].exp(),
        interval_95: fit.interval_95[k].map(|log| values[k] * log.exp()),
    });
    Ok(Calibration {
        numbers: numbers.collect(),
        before_m,
        after_m: per_row(&residuals(&fit.parameters).ok_or(unplayable)?),
        rows: rows.len(),
        model: with(&fit.parameters),
    })
}

fn adjustable(name: &str) -> Result<&'static Adjustable, TaskError> {
    ADJUSTABLE.iter().find(|field| field.name == name).ok_or_else(|| TaskError::UnknownName(name.to_owned()))
}
