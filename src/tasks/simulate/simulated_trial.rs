//! One trial of a simulated recording.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::Vector3;

use super::simulated_columns::{SimulatedColumns, SolutionDetail};
use crate::base::{Observation, Plant, PlantError, Seed, TendonCommand, interruption_point};
use crate::data::{Actuation, Recording};
use crate::effects::{EffectSpec, Model, Starts};
use crate::plants::{Simulated, SimulatedOptions};
use crate::rod::{SolveStatus, TipWrench};

/// How commands are simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationOptions {
    /// Each row is the equilibrium under its own command. Otherwise the robot moves, and a row is
    /// its state at the beginning of the row's command.
    pub at_rest: bool,
    /// Standard deviation of the tracking noise per axis, metres.
    pub noise_m: f64,
    /// Largest allowed displacement, metres.
    pub travel_m: f64,
    /// Seed of the noise.
    pub seed: Seed,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        SimulationOptions { at_rest: false, noise_m: 0.0, travel_m: f64::INFINITY, seed: Seed(0) }
    }
}

impl SimulationOptions {
    /// Options of the plant that plays the commands.
    pub(super) fn plant(&self) -> SimulatedOptions {
        SimulatedOptions {
            noise_m: self.noise_m,
            travel_m: self.travel_m,
            ..SimulatedOptions::default()
        }
    }
}

/// The mass on the tip in a trial's first row, as an effect.
pub(crate) fn hung_mass(commands: &Recording, first_row: usize) -> Option<EffectSpec> {
    let hung_kg = commands.known_load_kg.as_ref().map_or(0.0, |load| load[first_row]);
    (hung_kg > 0.0).then(|| EffectSpec::tip_load(hung_kg))
}

/// The model under the gravity of the trial that begins with this row.
pub(crate) fn model_of_trial<'a>(
    model: &'a Model,
    commands: &Recording,
    first_row: usize,
) -> Cow<'a, Model> {
    match &commands.gravity_m_s2 {
        None => Cow::Borrowed(model),
        Some(gravity_m_s2) => {
            let mut model = model.clone();
            model.robot.gravity_m_s2 = gravity_m_s2[first_row];
            Cow::Owned(model)
        }
    }
}

/// The state of one trial.
pub(crate) struct SimulatedTrial<'a> {
    plant: Simulated,
    commands: &'a Recording,
    rows: Range<usize>,
    starts: Starts,
    /// Last row of the trial before, whose end is the state now.
    previous_row: Option<usize>,
    /// Mass on the tip when the robot was built, kg.
    hung_kg: f64,
}

impl<'a> SimulatedTrial<'a> {
    /// The first trial of a robot, with the mass on its tip in this trial.
    pub(crate) fn new(
        commands: &'a Recording,
        rows: Range<usize>,
        starts: Starts,
        plant: Simulated,
    ) -> SimulatedTrial<'a> {
        let hung_kg = commands.known_load_kg.as_ref().map_or(0.0, |load| load[rows.start]);
        SimulatedTrial { plant, commands, rows, starts, previous_row: None, hung_kg }
    }

    /// The next trial of the same robot, which goes on where this one has ended.
    pub(crate) fn next(self, rows: Range<usize>) -> SimulatedTrial<'a> {
        SimulatedTrial { previous_row: Some(self.rows.end - 1), rows, ..self }
    }

    /// Simulates the rows and sets the failure of those without a solution.
    pub(crate) fn fill(
        mut self,
        columns: &mut SimulatedColumns,
        options: &SimulationOptions,
        number: u64,
    ) -> Self {
        if let Err(error) = self.run(options.at_rest, options.seed.index(number), columns) {
            columns.set_failure(self.rows.clone(), &error);
        }
        self
    }

    fn run(
        &mut self,
        at_rest: bool,
        seed: Seed,
        columns: &mut SimulatedColumns,
    ) -> Result<(), PlantError> {
        let commands = self.commands;
        let mut observation = self.start_or_flutter(at_rest, seed, columns)?;
        for row in self.rows.clone() {
            interruption_point();
            // Before the command: the load acts during the row.
            self.load(row);
            if at_rest {
                // Rows are independent: one without an equilibrium does not affect the others.
                match self.command(row, true) {
                    Ok(pose) => observation = Some(pose),
                    Err(error) => {
                        columns.set_failure(row..row + 1, &error);
                        continue;
                    }
                }
            }
            if let Some(observation) = &observation {
                columns.observed[row] =
                    Some((observation.clone(), SolutionDetail::of(self.plant.rod())));
            }
            columns.rates[row] = self.plant.pose_rates();
            if !at_rest && row + 1 < self.rows.end {
                self.plant.set_step_s(commands.time_s[row + 1] - commands.time_s[row]);
                observation = Some(self.command(row, false)?);
            }
        }
        Ok(())
    }

    /// [`SimulatedTrial::start`]; a motion may start from an equilibrium about which oscillations
    /// grow, which its first row says.
    fn start_or_flutter(
        &mut self,
        at_rest: bool,
        seed: Seed,
        columns: &mut SimulatedColumns,
    ) -> Result<Option<Observation>, PlantError> {
        match self.start(at_rest, seed) {
            Err(PlantError::Solver(status)) if status == SolveStatus::Flutters.name() => {
                if at_rest {
                    return Ok(None);
                }
                columns.set_status(self.rows.start, SolveStatus::Flutters);
                Ok(Some(self.plant.seen()))
            }
            started => started,
        }
    }

    /// Brings the robot to the state in which the trial starts, and observes it where that is the
    /// first row's.
    fn start(&mut self, at_rest: bool, seed: Seed) -> Result<Option<Observation>, PlantError> {
        let commands = self.commands;
        if let Some(previous_row) = self.previous_row {
            self.plant.begin_trial(seed);
            // Rows at rest follow one another without anything in between.
            return if at_rest { Ok(None) } else { self.command(previous_row, true).map(Some) };
        }
        match (self.starts, commands.actuation) {
            (Starts::Anywhere, _) => {
                self.plant.reset_away(seed);
                if at_rest {
                    return Ok(None);
                }
                self.load(self.rows.start);
                let first = self.command(self.rows.start, true)?;
                self.plant.restart_count();
                Ok(Some(first))
            }
            (_, Actuation::Lengths) => self.plant.reset(seed).map(Some),
            (_, Actuation::Tensions) => {
                // Under tensions the tendons have no length to start from.
                self.plant.reset_slack(seed);
                self.plant.apply_tensions(&vec![0.0; commands.tendons()], true).map(Some)
            }
        }
    }

    /// Applies the row's load to the tip: its force and moment, and the change of the hung mass
    /// since the robot was built (the inertia of the change is neglected).
    fn load(&mut self, row: usize) {
        let commands = self.commands;
        let mut wrench = TipWrench::default();
        if let Some(loads) = &commands.tip_load {
            wrench.force_n = Vector3::from(loads[row].force_n);
            wrench.moment_nm = Vector3::from(loads[row].moment_nm);
        }
        let added_kg =
            commands.known_load_kg.as_ref().map_or(0.0, |load_kg| load_kg[row] - self.hung_kg);
        self.plant.set_extra_tip_load_of(&|rod| TipWrench {
            force_n: wrench.force_n + added_kg * rod.gravity_m_s2,
            moment_nm: wrench.moment_nm,
        });
    }

    fn command(&mut self, row: usize, at_rest: bool) -> Result<Observation, PlantError> {
        let command = self.commands.commands.row(row);
        self.plant.set_drive_displacements(self.commands.drive_displacements(row));
        match (self.commands.actuation, at_rest) {
            (Actuation::Tensions, _) => self.plant.apply_tensions(command, at_rest),
            (Actuation::Lengths, false) => self.plant.step(command),
            (Actuation::Lengths, true) => {
                let pulls: Vec<TendonCommand> =
                    command.iter().map(|&pull| TendonCommand::Pull(pull)).collect();
                self.plant.settle(&pulls)
            }
        }
    }
}
