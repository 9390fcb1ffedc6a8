//! The columns of a simulated recording.

use std::ops::Range;

use crate::base::{Observation, PlantError};
use crate::data::Recording;
use crate::data::recording::Extra;
use crate::effects::Model;
use crate::rod::{ContactSum, PoseRates, RestBranch, Rod, SolveStatus};
use crate::tasks::record::record_trial::point_tracks;

/// The column that marks rows in which the robot touches itself.
pub const TOUCHES_ITSELF: &str = "touches_itself";

/// What the solver says of one row's solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolutionDetail {
    /// Tip error of the iteration, metres.
    residual_m: f64,
    /// Estimated tip error of the spatial discretisation, metres.
    space_m: f64,
    /// How the equilibrium is connected with the one before.
    branch: RestBranch,
    contact: Option<ContactSum>,
    touches_itself: bool,
}

impl SolutionDetail {
    /// That of the present solution of `rod`.
    pub(crate) fn of(rod: &Rod) -> SolutionDetail {
        SolutionDetail {
            residual_m: rod.residual_m(),
            space_m: rod.space_error_m(),
            branch: rod.branch(),
            contact: rod.contact(),
            touches_itself: rod.self_contact().is_some(),
        }
    }
}

/// The columns of a simulated recording.
pub(crate) struct SimulatedColumns {
    /// What is observed in each row, and the detail of its solution; none without a solution.
    pub(crate) observed: Vec<Option<(Observation, SolutionDetail)>>,
    status: Vec<String>,
    /// Derivatives of the tip and the tracked points.
    pub(crate) rates: Vec<Vec<PoseRates>>,
    tendons: usize,
    /// Names of the tracked points.
    points: Vec<String>,
    /// Whether each row is an equilibrium.
    at_rest: bool,
    /// Whether there is anything to touch.
    has_obstacles: bool,
}

impl SimulatedColumns {
    pub(crate) fn new(model: &Model, commands: &Recording, at_rest: bool) -> SimulatedColumns {
        let rows = commands.len();
        SimulatedColumns {
            observed: vec![None; rows],
            status: vec!["converged".to_owned(); rows],
            rates: vec![Vec::new(); rows],
            tendons: commands.tendons(),
            points: model.tracking.names(),
            at_rest,
            has_obstacles: !model.rod(&[]).contact.obstacles.is_empty(),
        }
    }

    /// Sets the status of a row that has an observation.
    pub(crate) fn set_status(&mut self, row: usize, status: SolveStatus) {
        status.name().clone_into(&mut self.status[row]);
    }

    /// Sets the failure of those of `rows` that have neither an observation nor another failure.
    pub(crate) fn set_failure(&mut self, rows: Range<usize>, error: &PlantError) {
        let name = match error {
            PlantError::Solver(name) => name.as_str(),
            PlantError::Refused(_) => "refused",
            PlantError::Stopped(_) => "stopped",
            PlantError::Late(_) => "late",
            PlantError::Unseen { .. } => "unseen",
            PlantError::Server(_) => "server",
            PlantError::NotRecorded(_) => "not_recorded",
        };
        for row in rows.filter(|&row| self.observed[row].is_none()) {
            // The first failure of a row is its cause.
            if self.status[row] == "converged" {
                name.clone_into(&mut self.status[row]);
            }
        }
    }

    /// The force of all obstacles on the robot, and where: no force and no place without contact.
    fn contact_columns(&self) -> Vec<(String, Extra)> {
        let numbers = |without: f64, value: &dyn Fn(&ContactSum) -> f64| {
            let of_row = |observed: &Option<(Observation, SolutionDetail)>| {
                let Some((_, detail)) = observed else { return f64::NAN };
                detail.contact.as_ref().map_or(without, value)
            };
            Extra::Numbers(self.observed.iter().map(of_row).collect())
        };
        let mut columns = Vec::new();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            columns.push((
                format!("contact_force_{name}_n"),
                numbers(0.0, &|contact| contact.force_n[axis]),
            ));
        }
        columns.push(("contact_s_m".to_owned(), numbers(f64::NAN, &|contact| contact.s_m)));
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            columns.push((
                format!("contact_{name}_m"),
                numbers(f64::NAN, &|contact| contact.place_m[axis]),
            ));
        }
        columns
    }

    /// Tensions, and how each row was solved.
    fn computed_columns(&self) -> Vec<(String, Extra)> {
        let numbers = |value: &dyn Fn(&(Observation, SolutionDetail)) -> f64| -> Extra {
            Extra::Numbers(
                self.observed
                    .iter()
                    .map(|observed| observed.as_ref().map_or(f64::NAN, value))
                    .collect(),
            )
        };
        let mut extra: Vec<(String, Extra)> = Vec::new();
        for tendon in 0..self.tendons {
            let tension = |(observed, _): &(Observation, SolutionDetail)| {
                observed.tensions_n.as_ref().map_or(f64::NAN, |all| all[tendon])
            };
            extra.push((format!("tension_{}_n", tendon + 1), numbers(&tension)));
        }
        extra.push(("solver_residual_m".to_owned(), numbers(&|(_, detail)| detail.residual_m)));
        extra.push(("space_error_m".to_owned(), numbers(&|(_, detail)| detail.space_m)));
        extra.push(("solver_status".to_owned(), Extra::Text(self.status.clone())));
        if self.at_rest {
            let branch = |observed: &Option<(Observation, SolutionDetail)>| {
                observed
                    .as_ref()
                    .map_or(String::new(), |(_, detail)| detail.branch.name().to_owned())
            };
            extra.push((
                "branch".to_owned(),
                Extra::Text(self.observed.iter().map(branch).collect()),
            ));
        }
        if self.has_obstacles {
            extra.extend(self.contact_columns());
        }
        let touches_itself = |observed: &Option<(Observation, SolutionDetail)>| {
            observed.as_ref().is_some_and(|(_, detail)| detail.touches_itself)
        };
        if self.observed.iter().any(touches_itself) {
            let flag = |observed: &Option<(Observation, SolutionDetail)>| {
                f64::from(u8::from(touches_itself(observed)))
            };
            extra.push((
                TOUCHES_ITSELF.to_owned(),
                Extra::Numbers(self.observed.iter().map(flag).collect()),
            ));
        }
        extra
    }

    pub(crate) fn into_recording(self, commands: &Recording) -> Recording {
        let lost = [f64::NAN; 3];
        let extra = self.computed_columns();
        // A column of the commands that the simulation computes anew is replaced.
        let carried = commands
            .extra
            .iter()
            .filter(|(name, _)| extra.iter().all(|(added_name, _)| added_name != name));
        let extra = carried.cloned().chain(extra.iter().cloned()).collect();
        let tips = self
            .observed
            .iter()
            .map(|observed| observed.as_ref().map_or(lost, |(observed, _)| observed.tip_m));
        let orientations = self.observed.iter().map(|observed| {
            observed
                .as_ref()
                .and_then(|(observed, _)| observed.tip_quaternion)
                .unwrap_or([f64::NAN; 4])
        });
        let valid: Vec<bool> = self.observed.iter().map(Option::is_some).collect();
        let observed: Vec<Option<&Observation>> = self
            .observed
            .iter()
            .map(|observed| observed.as_ref().map(|(observed, _)| observed))
            .collect();
        Recording {
            tip_m: Some(tips.collect()),
            tip_quaternion: Some(orientations.collect()),
            valid: valid.contains(&false).then_some(valid),
            at_rest: self.at_rest.then(|| vec![true; commands.len()]),
            points: point_tracks(&self.points, &observed),
            extra,
            ..commands.clone()
        }
    }
}
