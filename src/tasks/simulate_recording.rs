//! Simulates the commands of a recording: the measurements that the model predicts.

use std::ops::Range;

use nalgebra::Vector3;

use super::record::point_tracks;
use crate::base::{Observation, Plant, PlantError, Seed, TendonCommand};
use crate::data::recording::Extra;
use crate::data::{Actuation, Recording};
use crate::effects::{EffectSpec, Model, Variable, VariationError};
use crate::plants::{Simulated, SimulatedOptions};
use crate::rod::{PoseRates, TipWrench};

/// How commands are simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationOptions {
    /// Each row is the equilibrium under its own command. Otherwise the robot moves, and a row is its state at the beginning
    /// of the row's command.
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

/// Simulates all trials of `commands`. Rows that the solver could not solve are not valid, with the solver's status in the
/// column `solver_status`; without `at_rest` this holds for the rest of the trial.
pub fn simulate_recording(model: &Model, commands: &Recording, options: &SimulationOptions) -> Recording {
    let mut columns = SimulatedColumns::new(model, commands);
    for (number, rows) in commands.trials() {
        let trial = SimulatedTrial::new(commands, rows.start, |hung| Simulated::new(model, hung, options.plant()));
        trial.fill(&mut columns, commands, (number, rows), options);
    }
    columns.into_recording(commands)
}

/// The result of [`simulate_with_rates`].
#[derive(Clone, Debug)]
pub struct RecordingWithRates {
    /// The result of [`simulate_recording`].
    pub recording: Recording,
    /// For each row, the derivatives of the tip and of the model's tracked points (in the order of their names, that of
    /// [`Recording::points`]) with respect to each variable that is not left out; empty for a row without a solution.
    pub rates: Vec<Vec<PoseRates>>,
    /// Indices of the variables without a derivative along a motion.
    pub left_out: Vec<usize>,
}

/// [`simulate_recording`] with the derivatives of each row's tip and tracked points with respect to each of `variables`.
///
/// # Errors
/// [`VariationError`] for an unknown variable.
pub fn simulate_with_rates(
    model: &Model,
    commands: &Recording,
    options: &SimulationOptions,
    variables: &[Variable],
) -> Result<RecordingWithRates, VariationError> {
    let mut columns = SimulatedColumns::new(model, commands);
    let mut left_out = Vec::new();
    for (number, rows) in commands.trials() {
        let hung = hung(commands, rows.start);
        let varied = Simulated::varied_where_possible(model, hung.as_slice(), options.plant(), variables)?;
        left_out = varied.1;
        let trial = SimulatedTrial::new(commands, rows.start, |_| varied.0);
        trial.fill(&mut columns, commands, (number, rows), options);
    }
    let rates = std::mem::take(&mut columns.rates);
    Ok(RecordingWithRates { recording: columns.into_recording(commands), rates, left_out })
}

impl SimulationOptions {
    fn plant(&self) -> SimulatedOptions {
        SimulatedOptions { noise_m: self.noise_m, travel_m: self.travel_m, ..SimulatedOptions::default() }
    }
}

/// The mass on the tip in a trial's first row, as an effect.
fn hung(commands: &Recording, first_row: usize) -> Option<EffectSpec> {
    let hung_kg = commands.known_load_kg.as_ref().map_or(0.0, |load| load[first_row]);
    (hung_kg > 0.0).then(|| EffectSpec::tip_load(hung_kg))
}

/// The columns of a simulated recording.
struct SimulatedColumns {
    seen: Vec<Option<(Observation, f64)>>,
    status: Vec<String>,
    /// Derivatives of the tip and the tracked points.
    rates: Vec<Vec<PoseRates>>,
    tendons: usize,
    /// Names of the tracked points.
    points: Vec<String>,
}

impl SimulatedColumns {
    fn new(model: &Model, commands: &Recording) -> SimulatedColumns {
        let rows = commands.len();
        SimulatedColumns {
            seen: vec![None; rows],
            status: vec!["converged".to_owned(); rows],
            rates: vec![Vec::new(); rows],
            tendons: commands.tendons(),
            points: model.tracking.names(),
        }
    }

    /// Sets the failure of those of `rows` that have neither an observation nor another failure.
    fn set_failure(&mut self, rows: Range<usize>, error: &PlantError) {
        let name = match error {
            PlantError::Solver(name) => name.as_str(),
            PlantError::Refused(_) => "refused",
            PlantError::Stopped(_) => "stopped",
            PlantError::Unseen { .. } => "unseen",
            PlantError::NotRecorded(_) => "not_recorded",
        };
        for row in rows.filter(|&row| self.seen[row].is_none()) {
            if self.status[row] == "converged" {
                name.clone_into(&mut self.status[row]);
            }
        }
    }

    fn into_recording(self, commands: &Recording) -> Recording {
        let lost = [f64::NAN; 3];
        let numbers = |value: &dyn Fn(&(Observation, f64)) -> f64| -> Extra {
            Extra::Numbers(self.seen.iter().map(|seen| seen.as_ref().map_or(f64::NAN, value)).collect())
        };
        let mut extra: Vec<(String, Extra)> = Vec::new();
        for tendon in 0..self.tendons {
            let tension = |(seen, _): &(Observation, f64)| seen.tensions_n.as_ref().map_or(f64::NAN, |all| all[tendon]);
            extra.push((format!("tension_{}_n", tendon + 1), numbers(&tension)));
        }
        extra.push(("solver_residual_m".to_owned(), numbers(&|(_, residual)| *residual)));
        extra.push(("solver_status".to_owned(), Extra::Text(self.status.clone())));
        let carried = commands.extra.iter().filter(|(name, _)| extra.iter().all(|(own, _)| own != name));
        let extra = carried.cloned().chain(extra.iter().cloned()).collect();
        let tips = self.seen.iter().map(|seen| seen.as_ref().map_or(lost, |(seen, _)| seen.tip_m));
        let turns = self
            .seen
            .iter()
            .map(|seen| seen.as_ref().and_then(|(seen, _)| seen.tip_quaternion).unwrap_or([f64::NAN; 4]));
        let valid: Vec<bool> = self.seen.iter().map(Option::is_some).collect();
        let seen: Vec<Option<&Observation>> =
            self.seen.iter().map(|seen| seen.as_ref().map(|(seen, _)| seen)).collect();
        Recording {
            tip_m: Some(tips.collect()),
            tip_quaternion: Some(turns.collect()),
            valid: valid.contains(&false).then_some(valid),
            points: point_tracks(&self.points, &seen),
            extra,
            ..commands.clone()
        }
    }
}

/// The state of one trial.
struct SimulatedTrial {
    plant: Simulated,
    actuation: Actuation,
    /// Mass on the tip at the start of the trial, kg.
    hung_kg: f64,
}

impl SimulatedTrial {
    /// The robot with the mass on its tip in this trial.
    fn new(commands: &Recording, first_row: usize, plant: impl FnOnce(&[EffectSpec]) -> Simulated) -> SimulatedTrial {
        let hung_kg = commands.known_load_kg.as_ref().map_or(0.0, |load| load[first_row]);
        let plant = plant(hung(commands, first_row).as_slice());
        SimulatedTrial { plant, actuation: commands.actuation, hung_kg }
    }

    /// Simulates the rows and sets the failure of those without a solution.
    fn fill(
        mut self,
        columns: &mut SimulatedColumns,
        commands: &Recording,
        (number, rows): (u64, Range<usize>),
        options: &SimulationOptions,
    ) {
        let seed = options.seed.index(number);
        if let Err(error) = self.run(commands, rows.clone(), options.at_rest, seed, columns) {
            columns.set_failure(rows, &error);
        }
    }

    fn run(
        &mut self,
        commands: &Recording,
        rows: Range<usize>,
        at_rest: bool,
        seed: Seed,
        columns: &mut SimulatedColumns,
    ) -> Result<(), PlantError> {
        let mut seen = match self.actuation {
            Actuation::Lengths => self.plant.reset(seed)?,
            Actuation::Tensions => {
                self.plant.reset_slack(seed);
                self.plant.apply_tensions(&vec![0.0; commands.tendons()], true)?
            }
        };
        for row in rows.clone() {
            self.load(commands, row);
            if at_rest {
                // Rows are independent: one without an equilibrium does not affect the others.
                match self.command(commands.commands.row(row), true) {
                    Ok(pose) => seen = pose,
                    Err(error) => {
                        columns.set_failure(row..row + 1, &error);
                        continue;
                    }
                }
            }
            columns.seen[row] = Some((seen.clone(), self.plant.rod().residual_m()));
            columns.rates[row] = self.plant.pose_rates();
            if !at_rest && row + 1 < rows.end {
                self.plant.set_step_s(commands.time_s[row + 1] - commands.time_s[row]);
                seen = self.command(commands.commands.row(row), false)?;
            }
        }
        Ok(())
    }

    /// Applies the row's load to the tip: its force and moment, and the change of the hung mass since the start of the
    /// trial (the inertia of the change is neglected).
    fn load(&mut self, commands: &Recording, row: usize) {
        let mut extra = TipWrench::default();
        if let Some(loads) = &commands.tip_load {
            extra.force_n = Vector3::from(loads[row].force_n);
            extra.moment_nm = Vector3::from(loads[row].moment_nm);
        }
        let added_kg = commands.known_load_kg.as_ref().map_or(0.0, |hung| hung[row] - self.hung_kg);
        self.plant.set_extra_tip_load_of(&|rod| TipWrench {
            force_n: extra.force_n + added_kg * rod.gravity_m_s2,
            moment_nm: extra.moment_nm,
        });
    }

    fn command(&mut self, command: &[f64], at_rest: bool) -> Result<Observation, PlantError> {
        match (self.actuation, at_rest) {
            (Actuation::Tensions, _) => self.plant.apply_tensions(command, at_rest),
            (Actuation::Lengths, false) => self.plant.step(command),
            (Actuation::Lengths, true) => {
                let pulls: Vec<TendonCommand> = command.iter().map(|&pull| TendonCommand::Pull(pull)).collect();
                self.plant.settle(&pulls)
            }
        }
    }
}
