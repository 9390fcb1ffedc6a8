//! The stages of trials.

use super::{Added, Stages};
use crate::data::rows::{TrackRow, TrialRow};
use crate::policies::{self, ModelNeed, PolicyEntry};
use crate::runner::campaign::points_of;
use crate::runner::failure::Failure;
use crate::runner::jobs::trials::{Condition, PartHandles, REACH, ReachParams, TRACK, TrackParams};
use crate::specs::{Training, TrialCell, TrialMode};

impl Stages<'_> {
    /// Goal reaching in one cell; seed and training of the rows are filled in by whoever publishes them.
    pub(crate) fn reach(&mut self, cell: &TrialCell, training: &Training) -> Added<Vec<TrialRow>> {
        let (entry, condition) = self.condition(cell, "reach")?;
        let inputs = (self.part_handles(entry, cell, training)?, self.targets()?);
        let TrialCell { mode, gp_points, real_points, .. } = cell.clone();
        let params = ReachParams { condition, options: self.spec.reach, mode, gp_points, real_points };
        self.graph.stage(&REACH, self.label(&format!("{} {}", cell.policy, cell.mode)), params, inputs)
    }

    /// Path tracking of one policy; seed and training of the rows are filled in by whoever publishes them.
    pub(crate) fn track(&mut self, cell: &TrialCell, training: &Training) -> Added<Vec<TrackRow>> {
        let (entry, condition) = self.condition(cell, "track")?;
        let inputs = (self.part_handles(entry, cell, training)?, self.path()?);
        let params = TrackParams { condition, options: self.spec.track };
        self.graph.stage(&TRACK, self.label(&format!("{} tracks", cell.policy)), params, inputs)
    }

    fn condition(&self, cell: &TrialCell, task: &str) -> Result<(&'static PolicyEntry, Condition), Failure> {
        let unknown = |what: &str| Failure { stage: task.to_owned(), status: format!("unknown {what}") };
        let outside = &self.spec.policies.outside;
        let entry = policies::find_with(&cell.policy, outside).ok_or_else(|| unknown(&cell.policy))?;
        let mode: &TrialMode = self.spec.modes.get(&cell.mode).ok_or_else(|| unknown(&cell.mode))?;
        let condition = Condition {
            policy: cell.policy.clone(),
            outside: self.parts.outside.get(&cell.policy).cloned(),
            options: self.parts.policies.clone(),
            plant: self.parts.plant.clone(),
            effects: mode.effects.clone(),
            feedback: mode.feedback,
            step_s: self.step_s(),
            seed: self.seed.child(task).0,
        };
        Ok((entry, condition))
    }

    fn part_handles(
        &mut self,
        entry: &PolicyEntry,
        cell: &TrialCell,
        training: &Training,
    ) -> Result<PartHandles, Failure> {
        let (mut networks, mut error) = (Vec::new(), None);
        for need in entry.needs {
            match need {
                ModelNeed::Network(network) => {
                    networks.push(self.network(network, training, points_of(network, cell))?);
                }
                ModelNeed::ErrorModel => error = Some(self.gp(training, cell.gp_points)?),
            }
        }
        Ok((networks, error))
    }
}
