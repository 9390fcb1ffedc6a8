//! Simulates the commands of a recording: the measurements that the model predicts.

use std::convert::Infallible;

use super::simulated_columns::SimulatedColumns;
use super::simulated_trial::{SimulatedTrial, SimulationOptions, hung_mass, model_of_trial};
use crate::data::Recording;
use crate::effects::{Model, Starts, Variable, VariationError};
use crate::plants::Simulated;
use crate::rod::PoseRates;

/// Simulates all trials of `commands`, which start as the model's `tracking.starts` says. Rows that
/// the solver could not solve are not valid, with the solver's status in the column
/// `solver_status`; without `at_rest` this holds for the rest of the trial. Commands of drives are
/// converted with the model's gains.
pub fn simulate_recording(
    model: &Model,
    commands: &Recording,
    options: &SimulationOptions,
) -> Recording {
    let commands = &*commands.driven_by(&model.drive_gains(), model.robot.tendons.angles_deg.len());
    let mut columns = SimulatedColumns::new(model, commands, options.at_rest);
    let Ok(()) = simulate_trials::<Infallible>(
        model.tracking.starts,
        commands,
        options,
        &mut columns,
        &mut |row| {
            let (model, hung) = (model_of_trial(model, commands, row), hung_mass(commands, row));
            Ok(Simulated::new(&model, hung.as_slice(), options.plant()))
        },
    );
    columns.into_recording(commands)
}

/// The result of [`simulate_with_rates`].
#[derive(Clone, Debug)]
pub struct RecordingWithRates {
    /// The result of [`simulate_recording`].
    pub recording: Recording,
    /// For each row, the derivatives of the tip and of the model's tracked points (in the order of
    /// their names, that of [`Recording::points`]) with respect to each variable that is not left
    /// out; empty for a row without a solution.
    pub rates: Vec<Vec<PoseRates>>,
    /// Indices of the variables without a derivative along a motion.
    pub left_out: Vec<usize>,
}

/// [`simulate_recording`] with the derivatives of each row's tip and tracked points with respect to
/// each of `variables`. Where the recording gives the gravity, that of the model has no influence.
///
/// # Errors
/// [`VariationError`] for an unknown variable.
pub fn simulate_with_rates(
    model: &Model,
    commands: &Recording,
    options: &SimulationOptions,
    variables: &[Variable],
) -> Result<RecordingWithRates, VariationError> {
    let commands = &*commands.driven_by(&model.drive_gains(), model.robot.tendons.angles_deg.len());
    let mut columns = SimulatedColumns::new(model, commands, options.at_rest);
    let mut left_out = Vec::new();
    simulate_trials::<VariationError>(
        model.tracking.starts,
        commands,
        options,
        &mut columns,
        &mut |first_row| {
            let (model, hung) =
                (model_of_trial(model, commands, first_row), hung_mass(commands, first_row));
            let (robot, without_rate) = Simulated::varied_where_possible(
                &model,
                hung.as_slice(),
                options.plant(),
                variables,
            )?;
            left_out = without_rate;
            Ok(robot)
        },
    )?;
    let mut rates = std::mem::take(&mut columns.rates);
    if commands.gravity_m_s2.is_some() {
        let with_rate = (0..variables.len()).filter(|index| !left_out.contains(index));
        for (column, _) in with_rate.enumerate().filter(|&(_, index)| is_gravity(&variables[index]))
        {
            // The recording's gravity replaces the model's, so that number moves nothing.
            rates.iter_mut().filter_map(|row| row.get_mut(column)).for_each(PoseRates::clear);
        }
    }
    Ok(RecordingWithRates { recording: columns.into_recording(commands), rates, left_out })
}

fn is_gravity(variable: &Variable) -> bool {
    matches!(variable, Variable::Parameter(parameter) if parameter.path().starts_with("robot.gravity_m_s2"))
}

/// Simulates trial by trial; `robot` builds the robot of the trial that begins with a row.
fn simulate_trials<E>(
    starts: Starts,
    commands: &Recording,
    options: &SimulationOptions,
    columns: &mut SimulatedColumns,
    robot: &mut dyn FnMut(usize) -> Result<Simulated, E>,
) -> Result<(), E> {
    let mut previous: Option<SimulatedTrial> = None;
    for (number, rows) in commands.trials() {
        let trial = match previous.take() {
            // The same robot goes on; else each trial builds its own, with its load.
            Some(previous) if starts == Starts::Continue => previous.next(rows.clone()),
            _ => SimulatedTrial::new(commands, rows.clone(), starts, robot(rows.start)?),
        };
        previous = Some(trial.fill(columns, options, number));
    }
    Ok(())
}
