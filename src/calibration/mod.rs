//! Calibration of a model from recordings (paper, section III-B: Young's modulus from known tendon
//! tensions and the tracked tip): any numbers of the model file, fitted to every tracked point,
//! with what the fit leaves and what it does not tell. Methods: `docs/reference/calibration.md`.

mod auto;
mod compare;
mod error;
mod fit;
mod numbers;
mod recordings;
mod report;
mod select;
mod validate;

use crate::data::calibration::{CalibrationFindings, SightingRow};
use crate::effects::Model;
use compare::{noise, robust};
use fit::{optimum, starts};
use numbers::{entry, idle};
use validate::{residuals, validation};

use compare::blocks::{Blocks, SightingSplit};
use compare::comparison::Comparison;
use compare::noise::{Misfit, NoiseEstimate};
use compare::way_back::way_back_differs;
use fit::intervals::{Uncertain, uncertainty};
use fit::optimum::{CalibrationProblem, Optimum};
use numbers::number::FitNumber;
use select::{NumberGroup, Selection};

pub use compare::blocks::HoldOut;
pub use compare::robust::ErrorLaw;
pub use error::CalibrationError;
pub use numbers::entry::SHORT_NAMES;
pub(crate) use numbers::path::like;
pub use recordings::Recordings;

/// The entry that stands for a staged set of numbers.
pub const AUTO: &str = "auto";

/// What to fit and how.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationOptions {
    /// Numbers to fit: short names, or paths of the model file, with `*` for groups, `=start` and
    /// `~deviation`; or only [`AUTO`].
    pub fit: Vec<String>,
    /// Whether an entry stays only where it lowers the cross-validated error, as with [`AUTO`].
    pub select: bool,
    /// Each row is a pose at rest.
    pub at_rest: bool,
    /// What to hold out of the fit.
    pub hold_out: HoldOut,
    /// Distribution of the errors; none: normal, and Student's t where there are outliers.
    pub likelihood: Option<ErrorLaw>,
    /// Whether to find the error on unseen rows, and that of other models.
    pub validate: bool,
}

impl CalibrationOptions {
    /// Fits `names` to all rows.
    pub fn of(names: &[&str], at_rest: bool) -> CalibrationOptions {
        CalibrationOptions {
            fit: names.iter().map(|name| (*name).to_owned()).collect(),
            select: false,
            at_rest,
            hold_out: HoldOut::CrossValidated,
            likelihood: None,
            validate: false,
        }
    }
}

/// The result of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The model with the best values.
    pub model: Model,
    /// What was found.
    pub findings: CalibrationFindings,
    /// Every position of the fit with its error.
    pub sightings: Vec<SightingRow>,
}

/// A fit with what is known of its errors.
struct Fitted {
    best: Optimum,
    likelihood: ErrorLaw,
    outliers: usize,
    restarted: bool,
    noise: Option<(NoiseEstimate, f64, Option<Misfit>)>,
}

/// Fits numbers of `model` so that the simulated points of `measured` agree with the measured ones.
/// Rows without tracking are left out.
///
/// # Errors
/// [`CalibrationError`] for a name that is no number of the model, a number without effect, too few
/// data, commands that the model cannot simulate, or nothing to hold out.
pub fn calibrate(
    model: &Model,
    measured: &Recordings,
    options: &CalibrationOptions,
) -> Result<Calibration, CalibrationError> {
    let selects = options.select || options.fit == [AUTO];
    let named = if selects { Vec::new() } else { entry::numbers(model, &options.fit)? };
    idle::check(model, &named)?;
    let whole = Comparison::new(model, measured, options.at_rest)?;
    let all_blocks = Blocks::new(&whole);
    let held = all_blocks.held_out(&options.hold_out)?;
    let (unseen, kept) = all_blocks.parted(&held);
    let comparison = if held.is_empty() { whole.clone() } else { whole.only(&kept) };
    let blocks = all_blocks.only(&kept);
    let chosen = if selects {
        select::select(model, &comparison, &blocks, &stages(model, options, &comparison)?)?
    } else {
        Selection {
            model: model.clone(),
            start: vec![0.0; named.len()],
            numbers: named,
            stages: Vec::new(),
        }
    };
    let Selection { model, numbers, start, stages } = chosen;
    // What was selected may remember.
    let comparison = comparison.with_model(&model);
    let whole = whole.with_model(&model);
    if 3 * comparison.sightings.len() <= numbers.len() {
        let (required, available) = (numbers.len() / 3 + 1, comparison.sightings.len());
        return Err(CalibrationError::TooFew { what: "tracked positions", required, available });
    }
    let normal = CalibrationProblem {
        model: &model,
        numbers: &numbers,
        comparison: &comparison,
        likelihood: ErrorLaw::Normal,
    };
    let fitted = fitted(&normal, &start, options.likelihood)?;
    let problem = CalibrationProblem { likelihood: fitted.likelihood, ..normal };
    let misfit = fitted.noise.as_ref().and_then(|(.., misfit)| *misfit);
    // Blocks only widen intervals where the model errs by more than noise.
    let uncertain = uncertainty(&problem, &fitted.best, misfit.map(|_| blocks.of.as_slice()));
    let held_out = if !held.is_empty() {
        let names = held.iter().map(|&block| all_blocks.names[block].clone()).collect();
        Some(validation::held_out(
            &problem,
            &fitted.best,
            &whole,
            SightingSplit { fitted: &kept, unseen: &unseen },
            (all_blocks.kind, names),
        ))
    } else if options.validate {
        Some(validation::cross_validated(&problem, &fitted.best, &blocks))
    } else {
        None
    };
    let calibrated = problem.at(&fitted.best.x).unwrap_or_else(|| model.clone());
    let findings = CalibrationFindings {
        stages,
        ..report::findings(&problem, &fitted, &uncertain, &blocks, held_out)
    };
    let sightings = residuals::rows(&comparison, &blocks, &fitted.best);
    Ok(Calibration { model: calibrated, findings, sightings })
}

/// The groups of numbers to select from: those of `--fit auto`, or one an entry.
fn stages(
    model: &Model,
    options: &CalibrationOptions,
    comparison: &Comparison,
) -> Result<Vec<NumberGroup>, CalibrationError> {
    if options.fit == [AUTO] {
        return Ok(auto::stages(model, options.at_rest, way_back_differs(comparison)));
    }
    entry::numbers(model, &options.fit)?;
    Ok(options.fit.iter().map(|entry| NumberGroup::new(entry, &[entry])).collect())
}

/// The fit; with Student's t where that is asked for, or where least squares leaves outliers.
fn fitted(
    normal: &CalibrationProblem,
    start: &[f64],
    wanted: Option<ErrorLaw>,
) -> Result<Fitted, CalibrationError> {
    let first = CalibrationProblem { likelihood: wanted.unwrap_or(ErrorLaw::Normal), ..*normal };
    let is_good =
        |best: &Optimum| explained(&first, best).is_none_or(|(.., misfit)| misfit.is_none());
    let (mut best, restarted) = starts::best(&first, start, &is_good)?;
    let mut likelihood = first.likelihood;
    let outliers = robust::outliers(&best.residual_m, &best.positions).len();
    // Where the model itself errs, what lies far out is its error, which least squares must not
    // pass over.
    if wanted.is_none() && outliers > 0 && is_good(&best) {
        let robust = CalibrationProblem { likelihood: ErrorLaw::StudentT, ..*normal };
        best = robust.fit(&best.x, starts::MAX_STEPS, optimum::CONVERGED)?;
        likelihood = ErrorLaw::StudentT;
    }
    let outliers = robust::outliers(&best.residual_m, &best.positions).len();
    let noise = explained(&CalibrationProblem { likelihood, ..*normal }, &best);
    Ok(Fitted { best, likelihood, outliers, restarted, noise })
}

/// The noise, the error that the model leaves without outliers, and the misfit beyond noise.
fn explained(
    problem: &CalibrationProblem,
    best: &Optimum,
) -> Option<(NoiseEstimate, f64, Option<Misfit>)> {
    let noise = noise::noise(problem.comparison, &best.residual_m, &best.positions)?;
    let far = robust::outliers(&best.residual_m, &best.positions);
    let kept: Vec<usize> = (0..best.positions.len())
        .filter(|index| best.positions[*index].is_some() && !far.contains(index))
        .collect();
    let squares: f64 =
        kept.iter().map(|&index| best.residual_m.rows(3 * index, 3).norm_squared()).sum();
    let freedom = (3 * kept.len()) as f64 - problem.numbers.len() as f64;
    // Three coordinates a distance, less the numbers fitted.
    let rms_m = (3.0 * squares / freedom.max(1.0)).sqrt();
    let misfit = noise::misfit(&noise, rms_m, freedom.max(1.0));
    Some((noise, rms_m, misfit))
}
