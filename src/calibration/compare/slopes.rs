//! Derivatives of what a model says of the compared positions, in parallel.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::comparison::{Comparison, Part, Positions, tracks};
use crate::base::{InterruptRequest, Point3, counted};
use crate::calibration::numbers::number::FitNumber;
use crate::effects::{Model, ModelParameter, Variable, VariationError};
use crate::rod::PoseRates;
use crate::tasks::{RecordingWithRates, simulate_with_rates};

/// The numbers of a single part are shared out: every share repeats the motion of the model itself.
const SHARES: usize = 2;
/// Relative change of a number for differences of whole trials.
const TRIAL_STEP: f64 = 1e-3;
impl Comparison<'_> {
    /// What `model` says, and the derivative of it (three rows a sighting) with respect to the
    /// coordinates of `numbers` at `x`; rows of zeros where there is no solution. `None` when a
    /// number cannot be varied.
    pub(crate) fn with_slopes(
        &self,
        model: &Model,
        numbers: &[FitNumber],
        x: &[f64],
    ) -> Option<(Positions, DMatrix<f64>)> {
        let variables: Vec<&ModelParameter> =
            numbers.iter().flat_map(|number| &number.members).collect();
        // A single part would leave all threads but one idle.
        let shares = if self.parts.len() == 1 { SHARES } else { 1 };
        let share = variables.len().div_ceil(shares).max(1);
        let jobs: Vec<(&Part, &[&ModelParameter])> = self
            .parts
            .iter()
            .flat_map(|part| variables.chunks(share).map(move |some| (part, some)))
            .collect();
        let request = InterruptRequest::current();
        let slopes_of = |(part, some): &(&Part, &[&ModelParameter])| {
            request.within(|| self.part_slopes(part, model, some))
        };
        let each: Vec<PartSlopes> =
            jobs.par_iter().map(counted(slopes_of)).collect::<Option<_>>()?;
        let each: Vec<PartSlopes> =
            each.chunks(variables.len().div_ceil(share)).map(joined).collect();
        let mut positions = vec![None; self.sightings.len()];
        let mut slopes = DMatrix::zeros(3 * self.sightings.len(), numbers.len());
        for (part, part_slopes) in self.parts.iter().zip(&each) {
            for (&(index, _), (at_m, rates)) in part.sightings.iter().zip(part_slopes) {
                positions[index] = *at_m;
                let mut rates = rates.iter();
                for (column, number) in numbers.iter().enumerate() {
                    for (member, rate) in rates.by_ref().take(number.members.len()).enumerate() {
                        let slope = number.slope(member, x[column]);
                        (0..3).for_each(|axis| {
                            slopes[(3 * index + axis, column)] += slope * rate[axis]
                        });
                    }
                }
            }
        }
        Some((positions, slopes))
    }

    /// For each sighting of a part: position, and its derivative with respect to each variable.
    fn part_slopes(
        &self,
        part: &Part,
        model: &Model,
        parameters: &[&ModelParameter],
    ) -> Option<PartSlopes> {
        let (varied, commands) = self.driven(part, model);
        let variables: Vec<Variable> =
            parameters.iter().map(|&parameter| Variable::Parameter(parameter.clone())).collect();
        let RecordingWithRates { recording, rates, left_out } =
            simulate_with_rates(&varied, &commands, &self.options(), &variables).ok()?;
        let mut positions = vec![None; self.sightings.len()];
        self.take(part, &tracks(&recording), &mut positions);
        let simulated = |candidate: &Model| -> Result<Vec<Point3>, VariationError> {
            let mut there = vec![None; self.sightings.len()];
            self.take(part, &tracks(&self.simulated(part, candidate)), &mut there);
            Ok(part
                .sightings
                .iter()
                .map(|&(index, _)| there[index].unwrap_or([f64::NAN; 3]))
                .collect())
        };
        let mut differences = Vec::new();
        for &variable in &left_out {
            differences.push(parameters[variable].differences(model, TRIAL_STEP, &simulated).ok()?);
        }
        let seen = part.sightings.iter().enumerate().map(|(k, &(index, row))| {
            let solved = positions[index];
            let name = &self.markers[self.sightings[index].marker];
            let point = model.tracking.names().iter().position(|other| other == name);
            let mut along = 0;
            let rate = |variable: usize| -> Point3 {
                // Variables that have no exact derivative were differenced over the whole trial.
                let far = left_out.iter().position(|&other| other == variable);
                let rate = far.map_or_else(
                    || {
                        along += 1;
                        rates[row]
                            .get(along - 1)
                            .map_or([f64::NAN; 3], |rate| marker_rate(rate, point))
                    },
                    |far| differences[far][k],
                );
                if solved.is_some() && rate.iter().all(|x| x.is_finite()) { rate } else { [0.0; 3] }
            };
            (solved, (0..parameters.len()).map(rate).collect())
        });
        Some(seen.collect())
    }
}

/// The shares of one part side by side.
fn joined(shares: &[PartSlopes]) -> PartSlopes {
    let mut all = shares[0].clone();
    for share in &shares[1..] {
        all.iter_mut().zip(share).for_each(|((_, rates), (_, more))| rates.extend(more));
    }
    all
}

/// Position and derivatives of the sightings of a part.
type PartSlopes = Vec<(Option<Point3>, Vec<Point3>)>;

/// Derivative of the position of the tip, or of a point by its place among those of the model.
fn marker_rate(rates: &PoseRates, point: Option<usize>) -> Point3 {
    point.map_or(&rates.tip, |point| &rates.points[point]).position_m.into()
}
