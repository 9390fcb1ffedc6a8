//! Checks of `runs.repair`.

use super::discovery::check_entries;
use super::experiment::{Checker, is_name};
use crate::plants::PlantSpec;
use crate::policies::{self, ModelAccess};
use crate::specs::document::error::SpecError;
use crate::specs::document::path::KeyPath;
use crate::specs::experiment::claims::Size;
use crate::specs::experiment::repair::RepairRun;
use crate::tasks::SimulatedBy;

/// Rows that a discovery asks for at least.
const MIN_ROWS: usize = 30;

impl Checker<'_> {
    /// A robot to which effects can be added, changes that it takes, and enough rows to tell them
    /// by.
    pub(super) fn repair(&self, run: &RepairRun, path: &KeyPath) -> Result<(), SpecError> {
        let (root, spec) = (KeyPath::default(), self.experiment);
        let rod = matches!(spec.model, PlantSpec::Simulated(_));
        self.unless(rod, &root.key("model"), "a simulated rod, which `runs.repair` requires")?;
        let simulated = matches!(spec.plant, PlantSpec::Simulated(_));
        self.unless(
            simulated,
            &root.key("plant"),
            "a simulated robot, which `runs.repair` changes",
        )?;
        let by_rod = spec.gp_points.p_sim == SimulatedBy::Rod;
        self.unless(
            by_rod,
            &root.key("gp_points").key("p_sim"),
            "`rod`, because `runs.repair` repairs the rod model",
        )?;
        self.changes(run, &path.key("changes"))?;
        self.policies(std::slice::from_ref(&run.worker), &path.key("worker"))?;
        self.gp_sizes(&[run.gp_points], &path.key("gp_points"))?;
        let real = run.real_points.map(|points| vec![points]);
        let worker = std::slice::from_ref(&run.worker);
        self.sizes(worker, Size::RealPoints, real.as_deref(), &path.key("real_points"))?;
        let (recordings_path, recordings) = (path.key("recordings"), run.recordings);
        let rows = recordings.rows;
        self.unless((2..=10_000).contains(&rows), &recordings_path.key("rows"), "2 to 10000 rows")?;
        for (key, trials) in
            [("trials_before", recordings.trials_before), ("trials_after", recordings.trials_after)]
        {
            let enough = (2..=1000).contains(&trials) && trials * rows >= MIN_ROWS;
            let expected = "2 to 1000 trials with at least 30 rows in all, which a discovery \
                            requires";
            self.unless(enough, &recordings_path.key(key), expected)?;
        }
        self.checked(&path.key("monitor"), run.monitor.check())?;
        check_entries(self.document, &run.discovery, &path.key("discovery"))?;
        self.checked(&path.key("discovery"), run.discovery.check())?;
        self.checked(&path.key("identification"), run.identification_options().check())?;
        self.unless(
            !run.cells.is_empty(),
            &path.key("cells"),
            "at least one product of policies and modes",
        )?;
        self.cells(&run.cells, &path.key("cells"))?;
        self.asks_no_model(run, &path.key("cells"))
    }

    /// The repaired model is found during the run, while a policy that asks the model is handed the
    /// spec's.
    fn asks_no_model(&self, run: &RepairRun, path: &KeyPath) -> Result<(), SpecError> {
        for (index, sweep) in run.cells.iter().enumerate() {
            for (number, name) in sweep.policies.iter().enumerate() {
                let asks_model =
                    policies::find(name).is_some_and(|entry| entry.model == ModelAccess::AtRest);
                let path = path.item(index).key("policies").item(number);
                self.unless(
                    !asks_model,
                    &path,
                    "a policy that does not use the model directly, because `runs.repair` replaces \
                     the model",
                )?;
            }
        }
        Ok(())
    }

    fn changes(&self, run: &RepairRun, path: &KeyPath) -> Result<(), SpecError> {
        self.unless(!run.changes.is_empty(), path, "at least one change")?;
        for (name, effects) in &run.changes {
            let path = path.key(name);
            self.unless(is_name(name), &path, "a name of letters, digits, `_` and `-`")?;
            self.unless(!effects.is_empty(), &path, "at least one effect")?;
            self.effects(effects, &path)?;
        }
        Ok(())
    }
}
