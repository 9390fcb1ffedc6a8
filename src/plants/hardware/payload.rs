//! Weights that are hung on the tip between two trials.

use super::{Hardware, operator};
use crate::base::PlantError;
use crate::effects::{DrivenModel, EffectSpec};
use crate::hardware::safety::GuardState;

/// Longest wait until both bodies are tracked again, s.
const MAX_TRACKING_WAIT_S: f64 = 10.0;
/// Longest wait until the axes stand at home, s.
const MAX_STANDING_WAIT_S: f64 = 5.0;

impl Hardware {
    /// Hangs a weight of `load_kg` on the tip, in place of whatever hangs there, for the following
    /// trials. In a rehearsal the simulated robot takes it. A real robot is brought home and
    /// parked, the operator is asked for `what` unless it is done already (`None`), and both bodies
    /// must be tracked again.
    ///
    /// # Errors
    /// A message: the robot is stopped, no operator answers, or bodies are not tracked.
    pub fn hang_weight(&mut self, load_kg: f64, what: Option<&str>) -> Result<(), String> {
        if let Some(rehearsal) = &self.rehearsal {
            rehearsal.with_simulator(|simulator| simulator.hang_weight(load_kg));
        } else if let Some(what) = what {
            self.park().map_err(|error| error.to_string())?;
            operator::ask_operator(what)?;
            let now_s = self.supervised.clock.now_s();
            let tracked = self
                .supervised
                .wait(now_s + MAX_TRACKING_WAIT_S, |rig, now_s| rig.fresh_tip(now_s));
            tracked.ok_or("base and tip are not tracked; make both bodies visible")?;
        }
        let load: Vec<EffectSpec> =
            (load_kg > 0.0).then(|| EffectSpec::tip_load(load_kg)).into_iter().collect();
        self.model = DrivenModel::new(&self.unloaded_model, &load);
        (self.rests_at_home, self.home_tips) = (false, None);
        self.supervised.rig().set_expected_tip(None);
        Ok(())
    }

    /// Brings the robot home and parks it, so that a person may work on it until the next trial.
    fn park(&mut self) -> Result<(), PlantError> {
        if *self.supervised.rig().state() == GuardState::Idle {
            return Ok(());
        }
        self.go_home()?;
        let now_s = self.supervised.clock.now_s();
        let parked = self
            .supervised
            .wait(now_s + MAX_STANDING_WAIT_S, |rig, now_s| rig.park(now_s).then_some(()));
        parked.ok_or_else(|| {
            PlantError::Stopped(
                "the axes do not come to rest at home; inspect the robot".to_owned(),
            )
        })
    }
}
