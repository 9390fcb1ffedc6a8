//! Weights that are hung on the tip between two trials.

use super::{Hardware, operator};
use crate::base::PlantError;
use crate::effects::{Driven, EffectSpec};
use crate::hardware::safety::GuardState;

/// Longest that both bodies are waited for once hands have gone, s.
const SEEN_S: f64 = 10.0;
/// Longest that the axes are waited for at home, s.
const STAND_S: f64 = 5.0;

impl Hardware {
    /// Has a weight of `load_kg` hung on the tip, in place of whatever hangs there, for the trials from now on. In a
    /// rehearsal the imitated robot is given it. A robot on a bench is brought home and parked, whoever is there is asked
    /// for `what` unless it is done already (`None`), and both bodies have to be seen again.
    ///
    /// # Errors
    /// In words: a robot that is stopped, nobody there, or bodies that are not seen.
    pub fn hang_weight(&mut self, load_kg: f64, what: Option<&str>) -> Result<(), String> {
        if let Some(rehearsal) = &self.rehearsal {
            rehearsal.with_simulator(|simulator| simulator.hang_weight(load_kg));
        } else if let Some(what) = what {
            self.park().map_err(|error| error.to_string())?;
            operator::ask_operator(what)?;
            let now_s = self.supervised.clock.now_s();
            let seen = self.supervised.wait(now_s + SEEN_S, |rig, now_s| rig.fresh_tip(now_s));
            seen.ok_or("the tracker does not see base and tip; make both bodies visible")?;
        }
        let hung: Vec<EffectSpec> = (load_kg > 0.0).then(|| EffectSpec::tip_load(load_kg)).into_iter().collect();
        self.model = Driven::new(&self.unloaded_model, &hung);
        self.supervised.rig().set_expected_tip(None);
        Ok(())
    }

    /// Brings a robot home that has moved, and lets hands and heads come between it and the cameras until the next trial.
    fn park(&mut self) -> Result<(), PlantError> {
        if *self.supervised.rig().state() == GuardState::Idle {
            return Ok(());
        }
        self.go_home()?;
        let now_s = self.supervised.clock.now_s();
        let parked = self.supervised.wait(now_s + STAND_S, |rig, now_s| rig.park(now_s).then_some(()));
        parked.ok_or_else(|| PlantError::Stopped("the axes do not come to rest at home; look at the robot".to_owned()))
    }
}
