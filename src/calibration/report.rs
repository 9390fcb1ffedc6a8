//! What a calibration says of its result.

use super::compare::blocks::Blocks;
use super::fit::optimum::CalibrationProblem;
use super::numbers::idle::instead;
use super::validate::residuals;
use super::{ErrorLaw, FitNumber, Fitted, Uncertain};
use crate::data::calibration::{
    CalibratedNumber, CalibrationFindings, HeldOutError, NoiseAndMisfit, TradeOff,
};

/// Correlation beyond which two numbers trade against each other: one of them known, the other's
/// interval would be less than half as wide.
const TRADES: f64 = 0.87;
/// Pairs that are told.
const MAX_PAIRS: usize = 20;

/// Everything but the model.
pub(super) fn findings(
    problem: &CalibrationProblem,
    fitted: &Fitted,
    uncertain: &Uncertain,
    blocks: &Blocks,
    held_out: Option<HeldOutError>,
) -> CalibrationFindings {
    let best = &fitted.best;
    let numbers: Vec<CalibratedNumber> = problem
        .numbers
        .iter()
        .enumerate()
        .map(|(k, number)| calibrated(number, best.x[k], uncertain.half[k]))
        .collect();
    let start_positions =
        problem.at(&vec![0.0; best.x.len()]).map(|model| problem.comparison.positions(&model));
    let before_m = start_positions.map_or(f64::NAN, |positions| {
        let solved = positions.iter().filter(|at| at.is_some()).count();
        (problem.residual_m(&positions).norm_squared() / solved.max(1) as f64).sqrt()
    });
    let mut limitations = limitations(problem, fitted, uncertain, blocks, &numbers);
    limitations.extend(held_out.iter().flat_map(range_ends));
    CalibrationFindings {
        trade_offs: trade_offs(problem.numbers, uncertain),
        rows: problem.comparison.rows(),
        positions: best.positions.len(),
        unsolved: best.positions.iter().filter(|at| at.is_none()).count(),
        before_m,
        after_m: best.rms_m(),
        noise: fitted.noise.as_ref().map(|(noise, rms_m, misfit)| NoiseAndMisfit {
            noise_m: noise.rms_m,
            from: noise.from.to_owned(),
            pairs: noise.pairs,
            ratio: rms_m / noise.rms_m,
            beyond_noise: misfit.is_some(),
        }),
        likelihood: if fitted.likelihood == ErrorLaw::Normal { "normal" } else { "student_t" }
            .to_owned(),
        outliers: fitted.outliers,
        held_out,
        residual_groups: residuals::groups(problem.comparison, blocks, best),
        stages: Vec::new(),
        limitations,
        numbers,
    }
}

fn calibrated(number: &FitNumber, x: f64, half: f64) -> CalibratedNumber {
    // The coordinate may run against the value, so the ends are sorted below.
    let ends = [number.value((x - half).max(number.low())), number.value(x + half)];
    CalibratedNumber {
        name: number.name.clone(),
        unit: number.unit().to_owned(),
        start: number.value(0.0),
        value: number.value(x),
        low: ends[0].min(ends[1]),
        high: ends[0].max(ends[1]),
        prior_deviation: number.deviation,
        determined: half.is_finite(),
    }
}

fn trade_offs(numbers: &[FitNumber], uncertain: &Uncertain) -> Vec<TradeOff> {
    let mut pairs = Vec::new();
    for first in 0..numbers.len() {
        for second in first + 1..numbers.len() {
            let correlation = uncertain.correlation[(first, second)];
            if correlation.abs() > TRADES {
                let name = |k: usize| numbers[k].name.clone();
                pairs.push(TradeOff { first: name(first), second: name(second), correlation });
            }
        }
    }
    pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    pairs.truncate(MAX_PAIRS);
    pairs
}

/// What a user must know, most important first.
fn limitations(
    problem: &CalibrationProblem,
    fitted: &Fitted,
    uncertain: &Uncertain,
    blocks: &Blocks,
    numbers: &[CalibratedNumber],
) -> Vec<String> {
    let mut told = Vec::new();
    let best = &fitted.best;
    match &fitted.noise {
        Some((noise, rms_m, Some(_))) => told.push(format!(
            "The error of the model is {:.3} mm, the noise {:.3} mm (from {}). The model has an \
             error that no values of these numbers remove. {}",
            1e3 * rms_m,
            1e3 * noise.rms_m,
            noise.from,
            widening(uncertain, blocks)
        )),
        Some(_) => {}
        None => told.push(
            "The noise of this recording cannot be estimated: the recording has no rows at rest \
             and too few consecutive rows. The intervals are valid if the model is correct."
                .to_owned(),
        ),
    }
    for (number, fitted) in
        problem.numbers.iter().zip(numbers).filter(|(_, fitted)| !fitted.determined)
    {
        let why = number.members.iter().find_map(|member| instead(problem.model, member.path()));
        let why = why.map_or_else(String::new, |why| format!(": {why}"));
        told.push(format!("This recording does not determine {}{why}.", fitted.name));
    }
    let held = problem.numbers.iter().enumerate().filter(|(k, number)| best.x[*k] <= number.low());
    for (_, number) in held {
        told.push(format!(
            "The estimate of {} is at its bound, {}.",
            number.name,
            number.value(number.low())
        ));
    }
    if fitted.outliers > 0 {
        told.push(format!(
            "{} of {} positions are outliers (beyond 6 robust standard deviations from the model); \
             see the column `weight` of residuals.csv.",
            fitted.outliers,
            best.positions.len()
        ));
    }
    let unsolved = best.positions.iter().filter(|at| at.is_none()).count();
    if unsolved > 0 {
        told.push(format!(
            "{unsolved} of {} positions have no solution in the model.",
            best.positions.len()
        ));
    }
    if fitted.restarted {
        told.push(
            "A start other than the model's values converged to a better fit: the problem has \
             several minima."
                .to_owned(),
        );
    }
    if !best.converged {
        told.push("The fit stopped before it converged.".to_owned());
    }
    told
}

/// What became of the hyper-parameters of the models that this one is compared with.
fn range_ends(held_out: &HeldOutError) -> impl Iterator<Item = String> {
    held_out.models.iter().filter(|model| !model.at_range_end.is_empty()).map(|model| {
        let (name, ends) = (&model.name, &model.at_range_end);
        format!(
            "In the comparison, the {name} has hyper-parameters at an end of their range (with the \
             number of fits): {ends}."
        )
    })
}

fn widening(uncertain: &Uncertain, blocks: &Blocks) -> String {
    if uncertain.widened {
        let (count, kind) = (blocks.names.len(), blocks.kind);
        return format!(
            "The intervals include the scatter between the {count} {kind}s. They are valid for \
             this model only."
        );
    }
    "The intervals are valid for this model only and do not include its error.".to_owned()
}
