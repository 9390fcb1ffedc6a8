//! The stages of trials.

use super::{Added, Stages, points_of};
use crate::policies::{self, ModelAccess, ModelNeed, PolicyEntry};
use crate::rows::cell::CellLabel;
use crate::rows::experiment::{ReachTrial, TrackSample};
use crate::rows::responses::{PaceLap, ResponseTrial};
use crate::runner::graph::failure::Failure;
use crate::runner::jobs::parts::identified::Identified;
use crate::runner::jobs::trials::reach_track::{
    Condition, PartHandles, REACH, ReachParams, TRACK, TrackParams,
};
use crate::runner::jobs::trials::responses::{PACE, PaceParams, RESPONSE, ResponseParams};
use crate::specs::{PaceRun, Training, TrialMode};

impl Stages<'_> {
    /// Goal reaching in one cell.
    pub(crate) fn reach(
        &mut self,
        cell: &CellLabel,
        training: &Training,
    ) -> Added<Vec<ReachTrial>> {
        let (entry, condition) = self.condition(cell, "reach")?;
        let inputs = (self.part_handles(entry, cell, training)?, self.targets()?);
        let params = ReachParams { condition, options: self.spec.reach };
        self.graph.stage(
            &REACH,
            self.label(&format!("{} {}", cell.policy, cell.mode)),
            params,
            inputs,
        )
    }

    /// Path tracking of one policy.
    pub(crate) fn track(
        &mut self,
        cell: &CellLabel,
        training: &Training,
    ) -> Added<Vec<TrackSample>> {
        let (entry, condition) = self.condition(cell, "track")?;
        let inputs = (self.part_handles(entry, cell, training)?, self.path()?);
        let params = TrackParams { condition, options: self.spec.track };
        self.graph.stage(&TRACK, self.label(&format!("{} tracks", cell.policy)), params, inputs)
    }

    /// Responses in one cell.
    pub(crate) fn response(
        &mut self,
        cell: &CellLabel,
        training: &Training,
        duration_s: f64,
    ) -> Added<Vec<ResponseTrial>> {
        let (entry, condition) = self.condition(cell, "response")?;
        let inputs = (self.part_handles(entry, cell, training)?, self.targets()?);
        let params = ResponseParams { condition, quiet: self.quiet(), duration_s };
        self.graph.stage(
            &RESPONSE,
            self.label(&format!("{} {} responds", cell.policy, cell.mode)),
            params,
            inputs,
        )
    }

    /// Laps of one policy.
    pub(crate) fn pace(
        &mut self,
        cell: &CellLabel,
        training: &Training,
        run: &PaceRun,
    ) -> Added<Vec<PaceLap>> {
        let (entry, condition) = self.condition(cell, "pace")?;
        let inputs = (self.part_handles(entry, cell, training)?, self.path()?);
        let trial = ResponseParams { condition, quiet: self.quiet(), duration_s: run.lead_in_s };
        let params = PaceParams { trial, lap_s: run.lap_s, speeds: run.speeds.clone() };
        self.graph.stage(
            &PACE,
            self.label(&format!("{} {} laps", cell.policy, cell.mode)),
            params,
            inputs,
        )
    }

    /// The robot without noise beside the one that is measured; there is none on a bench.
    fn quiet(&self) -> Option<Identified> {
        (!self.spec.plant.drives_hardware()).then(|| self.parts.quiet.clone())
    }

    fn condition(
        &self,
        cell: &CellLabel,
        task: &str,
    ) -> Result<(&'static PolicyEntry, Condition), Failure> {
        let unknown =
            || Failure { stage: task.to_owned(), status: format!("unknown {}", cell.mode) };
        let mode = self.spec.modes.get(&cell.mode).ok_or_else(unknown)?;
        self.condition_in(&cell.policy, mode, task)
    }

    /// The policy called `policy` in a mode.
    pub(super) fn condition_in(
        &self,
        policy: &str,
        mode: &TrialMode,
        task: &str,
    ) -> Result<(&'static PolicyEntry, Condition), Failure> {
        let unknown = || Failure { stage: task.to_owned(), status: format!("unknown {policy}") };
        let entry = policies::find_with(policy, &self.spec.policies.outside).ok_or_else(unknown)?;
        let condition = Condition {
            policy: policy.to_owned(),
            outside: self.parts.outside.get(policy).cloned(),
            options: self.parts.policies.clone(),
            plant: self.parts.plant.clone(),
            model: (entry.model != ModelAccess::None).then(|| self.parts.model.clone()),
            effects: mode.effects.clone(),
            change: mode.change.clone(),
            feedback: mode.feedback,
            step_s: self.step_s(),
            seed: self.seed.child(task).0,
        };
        Ok((entry, condition))
    }

    pub(super) fn part_handles(
        &mut self,
        entry: &PolicyEntry,
        cell: &CellLabel,
        training: &Training,
    ) -> Result<PartHandles, Failure> {
        let (mut networks, mut error) = (Vec::new(), None);
        for need in entry.needs {
            match need {
                ModelNeed::Network(network) => {
                    networks.push(self.network(network, training, points_of(network, cell))?);
                }
                ModelNeed::ErrorModel => error = Some(self.gp(training, cell.gp_points as usize)?),
            }
        }
        Ok((networks, error))
    }
}
