//! Control of the robot in ticks: homing, commands, observations.

use super::Hardware;
use super::trial_log::{LoggedStep, TrialLog};
use crate::base::{Observation, Plant, PlantError, Seed, TendonCommand};
use crate::hardware::axes::AXES;
use crate::hardware::realtime::{Priority, RealTime};
use crate::hardware::rig::MoveError;
use crate::hardware::safety::GuardState;

/// Longest duration of homing and of the way home, s.
const MAX_HOMING_S: f64 = 120.0;
/// Longest wait for a pose after a tick, s.
const MAX_POSE_WAIT_S: f64 = 0.03;
/// Share of a tick by which a command may be late without shifting the following ticks, beyond the
/// wait for the pose of the last tick. Later ones occur only if `max_late_ticks` is raised.
const MAX_UNSHIFTED_SHARE: f64 = 0.3;

impl Hardware {
    /// Homes the robot unless it is homed, and moves its tendons home.
    pub(super) fn go_home(&mut self) -> Result<(), PlantError> {
        self.rests_at_home = false;
        self.supervised.rig().set_expected_tip(None);
        let deadline_s = self.supervised.clock.now_s() + MAX_HOMING_S;
        if *self.supervised.rig().state() == GuardState::Idle {
            let now_s = self.supervised.clock.now_s();
            self.supervised.rig().start(now_s).map_err(plant_error)?;
        }
        self.wait_until_active(self.event_count(), deadline_s)?;
        loop {
            let events = self.event_count();
            let tick_s = self.supervised.clock.now_s() + self.step_s;
            let step_s = self.step_s;
            let arrived = self.supervised.wait(deadline_s, |rig, now_s| match rig.state() {
                GuardState::Active => match rig.step_towards_home(step_s, now_s) {
                    Err(error) if error.is_temporary() => None,
                    other => Some(other.map_err(plant_error)),
                },
                state => stop_error(state).map(Err),
            });
            let arrived = arrived.unwrap_or_else(|| Err(self.stop_overdue("the way home")))?;
            self.supervised.clock.sleep_until(tick_s);
            self.wait_until_active(events, deadline_s)?;
            if arrived {
                return Ok(());
            }
        }
    }

    /// Waits until the robot is active and, if it was held after its first `events` events, has
    /// ended its moves; true if it was held.
    pub(super) fn wait_until_active(
        &self,
        events: usize,
        deadline_s: f64,
    ) -> Result<bool, PlantError> {
        let ended = self.supervised.wait(deadline_s, |rig, _| {
            let was_held = rig.events().iter().skip(events).any(|event| event.state == "held");
            match rig.state() {
                GuardState::Active => (!was_held || rig.stands()).then_some(Ok(was_held)),
                state => stop_error(state).map(Err),
            }
        });
        ended.unwrap_or_else(|| Err(self.stop_overdue("a hold or homing")))
    }

    /// Number of events so far.
    pub(super) fn event_count(&self) -> usize {
        self.supervised.rig().events().len()
    }

    /// Stops a robot that exceeded a time limit.
    pub(super) fn stop_overdue(&self, what: &str) -> PlantError {
        let message = format!("{what} exceeded its time limit; inspect the robot");
        let now_s = self.supervised.clock.now_s();
        self.supervised.rig().stop(message.clone(), now_s);
        PlantError::Stopped(message)
    }

    /// Refuses a command before the model moves, so that both stay where they are. The model
    /// decides how far following tendons go. The others must keep the limits of single tendons in
    /// the ticks that they need: a tendon that has followed so far may have a long way to go.
    fn check_commands(&self, commands: &[TendonCommand]) -> Result<(), PlantError> {
        let last_m = self.supervised.rig().commanded_m();
        let pulls_m: Vec<f64> = commands
            .iter()
            .zip(last_m)
            .map(|(command, last_m)| command.pull_m_or(last_m))
            .collect();
        let admitted = if commands.contains(&TendonCommand::Follow) {
            let ticks = self.safety.ticks(&pulls_m, &last_m, self.step_s).max(1);
            self.safety.check_each_tendon(&pulls_m, &last_m, self.step_s * ticks as f64, ticks)
        } else {
            self.safety.check_in_ticks(&pulls_m, &last_m, self.step_s).map(|_| ())
        };
        admitted.map_err(|refusal| PlantError::Refused(refusal.to_string()))
    }

    /// Moves the tendons to `pulls_m` in as many ticks as the limits require; true if the robot was
    /// held meanwhile. The command was given at `called_s`, the first tick begins at `begin_s`.
    fn drive_in_ticks(
        &mut self,
        pulls_m: &[f64],
        called_s: f64,
        begin_s: f64,
    ) -> Result<bool, PlantError> {
        let from_m = self.supervised.rig().commanded_m();
        let ticks = self.safety.ticks(pulls_m, &from_m, self.step_s).max(1);
        let (mut was_held, mut called_s) = (false, called_s);
        self.due_s = begin_s;
        for tick in 1..=ticks {
            let share = tick as f64 / ticks as f64;
            let tick_pulls_m: Vec<f64> = pulls_m
                .iter()
                .zip(&from_m)
                .map(|(to, from)| share * to + (1.0 - share) * from)
                .collect();
            (was_held, called_s) =
                (self.drive_tick(&tick_pulls_m, called_s)? || was_held, self.now_s());
        }
        Ok(was_held)
    }

    /// Executes the tick that is due; true if the robot was held meanwhile.
    fn drive_tick(&mut self, pulls_m: &[f64], called_s: f64) -> Result<bool, PlantError> {
        let begin_s = self.due_s;
        self.send(pulls_m, called_s)?;
        self.check_late("the command", begin_s, self.now_s(), self.pose_wait_s)?;
        let end_s = begin_s + self.step_s;
        self.supervised.clock.sleep_until(end_s);
        let now_s = self.now_s();
        self.timing.jitter.push(now_s - end_s);
        let was_held = self.wait_until_active(self.seen_events, end_s + self.patience_s)?;
        self.check_late("the end of the tick", end_s, now_s, 0.0)?;
        // After a hold the ticks go on from the time at which the robot has ended its move.
        self.due_s = if was_held { self.now_s() } else { end_s };
        (self.seen_events, self.pose_wait_s) = (self.event_count(), 0.0);
        Ok(was_held)
    }

    /// Sends the command of a tick once the robot is active and the controller's queue has room.
    fn send(&mut self, pulls_m: &[f64], called_s: f64) -> Result<(), PlantError> {
        let (step_s, now_s) = (self.step_s, self.supervised.clock.now_s());
        let sent = self.supervised.wait(now_s + self.patience_s, |rig, now_s| match rig.state() {
            GuardState::Active => match rig.command(pulls_m, step_s, now_s) {
                // The next check of the state reports the reason.
                Err(error) if error.is_temporary() => None,
                other => Some(other.map_err(plant_error)),
            },
            state => stop_error(state).map(Err),
        });
        self.timing.latency.push(self.supervised.clock.now_s() - called_s);
        sent.unwrap_or_else(|| Err(self.stop_overdue("room in the controller's queue")))
    }

    /// The tracker's measurement at the end of the last tick; not valid without a pose.
    fn observe(&mut self, pulls_m: Vec<f64>) -> Observation {
        let due_s = self.due_s;
        let between =
            self.supervised.wait(self.now_s() + MAX_POSE_WAIT_S, |rig, _| rig.tip_at(due_s));
        // If several frames in a row are lost, the last pose is used while it is plausible.
        let pose = between.or_else(|| self.supervised.rig().fresh_tip(due_s));
        self.pose_wait_s = (self.now_s() - due_s).clamp(0.0, MAX_POSE_WAIT_S);
        Observation {
            time_s: due_s - self.trial_s,
            tip_m: pose.as_ref().map_or([f64::NAN; 3], |pose| pose.position_m),
            tip_quaternion: pose.as_ref().map(|pose| pose.quaternion),
            points: Vec::new(),
            pulls_m,
            tensions_n: None,
            valid: pose.is_some(),
        }
    }
}

/// The error of a stopped robot.
pub(super) fn stop_error(state: &GuardState) -> Option<PlantError> {
    let GuardState::Stopped { reason, .. } = state else { return None };
    Some(PlantError::Stopped(format!("{}; {}", reason.what, reason.remedy)))
}

fn plant_error(error: MoveError) -> PlantError {
    match error {
        MoveError::NotActive(_) | MoveError::Alarm(_) => PlantError::Stopped(error.to_string()),
        MoveError::Refused(_)
        | MoveError::RefusedByDriver(_)
        | MoveError::Busy
        | MoveError::OldPose { .. } => PlantError::Refused(error.to_string()),
    }
}

impl Plant for Hardware {
    fn tendons(&self) -> usize {
        AXES
    }

    fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Brings the robot home and lets it rest. The noise of a rehearsal is drawn from `seed`.
    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        if let Some(rehearsal) = &self.rehearsal {
            rehearsal.with_simulator(|simulator| simulator.reseed(seed));
        }
        self.rest_at_home()?;
        self.check_home_tip()?;
        let home_m = self.expected_m();
        self.supervised.rig().set_expected_tip(Some(home_m));
        self.trial_s = self.now_s();
        (self.due_s, self.seen_events) = (self.trial_s, self.event_count());
        let seen = self.observe(vec![0.0; AXES]);
        let measured_home_m = seen.valid.then_some(seen.tip_m);
        self.trial = TrialLog { home_m, measured_home_m, steps: Vec::new() };
        Ok(seen)
    }

    /// The tip rests where it did first, and every axis has moved its tendon.
    fn verify(&mut self) -> Result<(), PlantError> {
        self.check_axes()?;
        self.rest_at_home()?;
        self.check_home_tip()
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        let now_s = self.supervised.clock.now_s();
        let _priority =
            self.supervised.clock.is_real().then(|| RealTime::new(Priority::ControlLoop));
        if now_s > self.due_s + 0.5 * self.step_s {
            self.timing.missed += 1;
        }
        self.check_commands(commands)?;
        self.check_late("the start of the tick", self.due_s, now_s, self.pose_wait_s)?;
        // The model decides how far following tendons move. A copy goes ahead, as the whole command
        // may be refused.
        let mut model = self.model.clone();
        model.advance(commands, self.step_s)?;
        let predicted = model.observation(commands, 0.0);
        let travel_m = self.safety.travel_m;
        let follow = |(command, pull_m): (&TendonCommand, &f64)| {
            command.pull_m_or(pull_m.clamp(-travel_m, travel_m))
        };
        let pulls_m: Vec<f64> = commands.iter().zip(&predicted.pulls_m).map(follow).collect();
        // The complete command, following tendons included, is checked before anything is sent; it
        // takes as many ticks as it needs.
        let last_m = self.supervised.rig().commanded_m();
        let ticks = self.safety.ticks(&pulls_m, &last_m, self.step_s).max(1);
        let admitted =
            self.safety.check_command(&pulls_m, &last_m, self.step_s * ticks as f64, ticks);
        admitted.map_err(|refusal| PlantError::Refused(refusal.to_string()))?;
        self.model = model;
        self.rests_at_home = false;
        self.supervised.rig().set_expected_tip(Some(predicted.tip_m));
        let unshifted_s = self.pose_wait_s + MAX_UNSHIFTED_SHARE * self.step_s;
        let in_time = now_s <= self.due_s + unshifted_s;
        let begin_s = if in_time { self.due_s } else { now_s };
        if self.drive_in_ticks(&pulls_m, now_s, begin_s)? {
            self.timing.held += 1;
        }
        let seen = self.observe(pulls_m);
        let pulls_m = std::array::from_fn(|axis| seen.pulls_m[axis]);
        let measured_m = seen.valid.then_some(seen.tip_m);
        self.trial.steps.push(LoggedStep { pulls_m, predicted_m: predicted.tip_m, measured_m });
        Ok(seen)
    }
}
