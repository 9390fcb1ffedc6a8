//! How many numbers the data can carry: groups of numbers are added one after the other, and stay
//! only where they lower the blocked cross-validation error.

use super::compare::blocks::Blocks;
use super::compare::comparison::Comparison;
use super::compare::robust::ErrorLaw;
use super::error::CalibrationError;
use super::fit::optimum::{CalibrationProblem, ROUGHLY_CONVERGED};
use super::numbers::entry::numbers;
use super::numbers::idle;
use super::numbers::number::FitNumber;
use super::validate::validation::without;
use crate::base::distance_m;
use crate::data::calibration::FitStage;
use crate::effects::{EffectSpec, Model};

/// Positions on which groups are compared at most.
const SOME: usize = 500;
/// A group must lower the cross-validated error to less than this share.
const LOWER: f64 = 0.99;
/// Steps of a fit.
const STEPS: usize = 12;
/// Rounds over the groups that were left out.
const ROUNDS: usize = 2;

/// A group of numbers that are added together.
#[derive(Clone, Debug)]
pub(super) struct NumberGroup {
    pub(super) name: String,
    /// Entries as `--fit` has them.
    pub(super) entries: Vec<String>,
    /// Writes keys into the model that the entries name, and that leave its meaning unchanged.
    pub(super) prepare: fn(&mut Model),
    /// An effect that the numbers belong to, where the model has none of its name.
    pub(super) effect: Option<EffectSpec>,
}

impl NumberGroup {
    /// Numbers that the model has.
    pub(super) fn new(name: &str, entries: &[&str]) -> NumberGroup {
        let entries = entries.iter().map(|entry| (*entry).to_owned()).collect();
        NumberGroup { name: name.to_owned(), entries, prepare: |_| {}, effect: None }
    }

    /// The model with the keys that the entries name.
    fn prepared(&self, model: &Model) -> Model {
        let mut model = model.clone();
        (self.prepare)(&mut model);
        let missing = |effect: &&EffectSpec| {
            model.effects.iter().all(|other| other.card().name != effect.card().name)
        };
        let effect = self.effect.iter().find(missing).cloned();
        model.effects.extend(effect);
        model
    }
}

/// What was selected.
pub(super) struct Selection {
    /// The model with the keys that the numbers need.
    pub(super) model: Model,
    pub(super) numbers: Vec<FitNumber>,
    /// Coordinates to start from.
    pub(super) start: Vec<f64>,
    pub(super) stages: Vec<FitStage>,
}

/// A model with some numbers and the coordinates of a fit.
struct SelectionStep {
    model: Model,
    numbers: Vec<FitNumber>,
    x: Vec<f64>,
    error_m: f64,
}

/// Adds `stages` to nothing.
///
/// # Errors
/// [`CalibrationError`] when the model cannot simulate the commands, or when no stage lowers the
/// error.
pub(super) fn select(
    model: &Model,
    comparison: &Comparison,
    blocks: &Blocks,
    stages: &[NumberGroup],
) -> Result<Selection, CalibrationError> {
    let wanted = if comparison.at_rest { SOME } else { comparison.sightings.len() };
    let (some, kept) = comparison.thinned(wanted);
    let blocks = blocks.only(&kept);
    let given_m = rms_m(&some, &some.positions(model));
    let mut best = SelectionStep {
        model: model.clone(),
        numbers: Vec::new(),
        x: Vec::new(),
        error_m: given_m,
    };
    let mut told = vec![FitStage {
        name: "as given".to_owned(),
        numbers: 0,
        cross_validated_m: given_m,
        kept: true,
    }];
    let mut waiting: Vec<&NumberGroup> = stages.iter().collect();
    let mut last = None;
    for _ in 0..ROUNDS {
        let before = waiting.len();
        for stage in std::mem::take(&mut waiting) {
            let next = match added(&best, stage, &some, &blocks) {
                Ok(next) => next,
                Err(error) => {
                    last = Some(error);
                    continue;
                }
            };
            let Some(next) = next else { continue };
            // The first fit of all that the model as given does not solve for is judged against
            // that.
            let keep = next.error_m < LOWER * best.error_m || best.error_m.is_nan();
            let (numbers, cross_validated_m) = (next.numbers.len(), next.error_m);
            told.push(FitStage {
                name: stage.name.clone(),
                numbers,
                cross_validated_m,
                kept: keep,
            });
            if keep {
                best = next;
            } else {
                // A group may help once another one is in.
                waiting.push(stage);
            }
        }
        if waiting.is_empty() || waiting.len() == before {
            break;
        }
    }
    if best.numbers.is_empty() {
        let none =
            "none of the groups of numbers lowers the cross-validated error of the model as given";
        return Err(last.unwrap_or_else(|| CalibrationError::HoldOut(none.to_owned())));
    }
    Ok(Selection { model: best.model, numbers: best.numbers, start: best.x, stages: told })
}

/// The model with one stage more, fitted; `None` when the stage has no number that is not fitted
/// already.
fn added(
    before: &SelectionStep,
    stage: &NumberGroup,
    comparison: &Comparison,
    blocks: &Blocks,
) -> Result<Option<SelectionStep>, CalibrationError> {
    let model = stage.prepared(&before.model);
    let comparison = &comparison.clone().with_model(&model);
    let named = stage
        .entries
        .iter()
        .filter_map(|entry| numbers(&model, std::slice::from_ref(entry)).ok())
        .flatten();
    let is_fitted =
        |number: &FitNumber| before.numbers.iter().any(|other| other.members == number.members);
    let acts = |number: &FitNumber| idle::check(&model, std::slice::from_ref(number)).is_ok();
    let new_numbers: Vec<FitNumber> =
        named.filter(|number| !is_fitted(number) && acts(number)).collect();
    // A number for several is replaced by one for each.
    let replaced = |number: &FitNumber| {
        new_numbers
            .iter()
            .any(|new| new.members.iter().any(|member| number.members.contains(member)))
    };
    let stays: Vec<usize> =
        (0..before.x.len()).filter(|&k| !replaced(&before.numbers[k])).collect();
    if new_numbers.is_empty() || 3 * comparison.sightings.len() <= stays.len() + new_numbers.len() {
        return Ok(None);
    }
    let begins = |number: &FitNumber| {
        let earlier = before.numbers.iter().zip(&before.x);
        // An entry of a list begins where the number for all was.
        let path = number.members[0].path();
        let is_entry = |old: &FitNumber| {
            path.strip_prefix(old.members[0].path()).is_some_and(|rest| rest.starts_with('['))
        };
        let value = earlier.into_iter().find_map(|(old, &x)| {
            if is_entry(old) { Some(old.value(x)) } else { old.value_of(&number.members[0], x) }
        });
        value.map_or(0.0, |value| number.coordinate(value))
    };
    let start: Vec<f64> =
        stays.iter().map(|&k| before.x[k]).chain(new_numbers.iter().map(begins)).collect();
    let numbers: Vec<FitNumber> =
        stays.iter().map(|&k| before.numbers[k].clone()).chain(new_numbers).collect();
    let problem = CalibrationProblem {
        model: &model,
        numbers: &numbers,
        comparison,
        likelihood: ErrorLaw::Normal,
    };
    let fit = problem.fit(&start, STEPS, ROUGHLY_CONVERGED)?;
    let mut squares = (0.0, 0_usize);
    for fold in blocks.folds() {
        let (unseen, _) = blocks.parted(&fold);
        // One step from the fit of all rows, in place of a fit for each part.
        let x = without(&problem, &fit, &unseen);
        let part = comparison.only(&unseen);
        let there =
            problem.at(&x).map_or_else(|| vec![None; unseen.len()], |model| part.positions(&model));
        for (sighting, at) in part.sightings.iter().zip(there) {
            // A position that has no solution without its block, or whose numbers are out of range
            // there, counts as far away as the robot is long.
            let error_m =
                at.map_or(model.robot.backbone.length_m, |at| distance_m(&at, &sighting.at_m));
            squares = (squares.0 + error_m * error_m, squares.1 + 1);
        }
    }
    let error_m = (squares.0 / squares.1.max(1) as f64).sqrt();
    Ok(Some(SelectionStep { x: fit.x, error_m, numbers, model }))
}

fn rms_m(comparison: &Comparison, positions: &[Option<[f64; 3]>]) -> f64 {
    let pairs = comparison.sightings.iter().zip(positions);
    let squares: Vec<f64> = pairs
        .filter_map(|(sighting, at)| Some(distance_m(&(*at)?, &sighting.at_m).powi(2)))
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
