//! A robot on a bench: four lead screws, a tracker, and the guard between them and whoever decides.

mod hands;
mod line;
mod options;
mod rehearsal;
mod timing;

use std::sync::Arc;

pub use options::{HardwareOptions, RehearsalOptions};
pub use rehearsal::Stage;
pub use timing::Timing;

use crate::base::{Observation, Plant, PlantError, Point3, Seed, TendonCommand};
use crate::effects::Driven;
use crate::hardware::axes::AXES;
use crate::hardware::clock::{Clock, WallClock};
use crate::hardware::grbl::Controller;
use crate::hardware::interrupt::Interrupt;
use crate::hardware::rig::{Event, NotMoved, Parts, Rig, slowest_axis_mm_min};
use crate::hardware::safety::{Latch, Refusal, SafetyLimits, State};
use crate::hardware::tracking::{Tracking, TrackingStatus};
use crate::hardware::wire::{SerialWire, Wire};

use hands::Claim;
use line::Line;

/// Longest that homing and the way home may take, s.
const HOMING_S: f64 = 120.0;
/// A tick whose robot is held or whose controller is busy is waited for this long, s; the guard stops the robot before.
const PATIENCE_S: f64 = 2.0;
/// A command that needs more ticks than this is a mistake.
const MOST_TICKS: usize = 4;
/// Longest that a pose is waited for after a tick, s.
const POSE_S: f64 = 0.03;

/// A hardware robot as a [`Plant`].
pub struct Hardware {
    line: Line,
    /// What the model says the robot does: how tendons follow, where the tip may be.
    model: Driven,
    step_s: f64,
    settle_s: f64,
    safety: SafetyLimits,
    /// When the trial began and when its next tick is due, on the rig's clock, s.
    trial_s: f64,
    due_s: f64,
    timing: Timing,
    /// The imitations behind the drivers, in a rehearsal.
    stage: Option<Stage>,
    /// The right to use the robot, where there is one. Given back last.
    claim: Option<Claim>,
}

impl Hardware {
    /// Opens the motors and the tracker of `options`, or imitations of both for a rehearsal; moves nothing.
    ///
    /// # Errors
    /// In words: a stop that nobody has looked at, a port, a setting or a body that is not as it should be.
    pub fn open(options: &HardwareOptions, step_s: f64, seed: Seed) -> Result<Hardware, String> {
        match &options.rehearsal {
            Some(rehearsal) => {
                let (stage, wire, tracking) = Stage::open(options, rehearsal, seed)?;
                let clock = stage.clock();
                let parts = Opened { wire, clock, latch: None, interrupt: stage.interrupt() };
                let mut plant = Hardware::of(options, &tracking, step_s, parts)?;
                plant.stage = Some(stage);
                Ok(plant)
            }
            None => {
                let latch = Latch::new(&Latch::folder(), &options.name);
                if let Some(reason) = latch.read() {
                    return Err(format!(
                        "robot `{}` is stopped: {reason}; look at it, then `spinebench arm`",
                        options.name
                    ));
                }
                let claim = Claim::new(&options.attached)?;
                let wire = SerialWire::open(&options.motion.port, options.motion.baud)
                    .map_err(|error| format!("{}: cannot open the port: {error}", options.motion.port))?;
                let interrupt = Interrupt::of_process().map_err(|error| error.to_string())?;
                let parts =
                    Opened { wire: Box::new(wire), clock: Arc::new(WallClock::new()), latch: Some(latch), interrupt };
                let mut plant = Hardware::of(options, &options.tracking, step_s, parts)?;
                plant.claim = Some(claim);
                Ok(plant)
            }
        }
    }

    /// The calling thread has joined the clock.
    fn of(
        options: &HardwareOptions,
        tracking: &crate::hardware::tracking::TrackingSettings,
        step_s: f64,
        opened: Opened,
    ) -> Result<Hardware, String> {
        let Opened { wire, clock, latch, interrupt } = opened;
        let controller = Controller::open(wire, &options.motion, clock.as_ref()).map_err(|fault| fault.to_string());
        let tracking = Tracking::open(tracking.clone(), clock.as_ref()).map_err(|fault| fault.to_string());
        let ready = controller.and_then(|controller| {
            fast_enough(&controller, &options.safety, step_s)?;
            Ok((controller, tracking?))
        });
        let (controller, tracking) = ready.inspect_err(|_| clock.leave())?;
        let parts = Parts {
            controller,
            tracking,
            axes: options.axes,
            limits: options.safety,
            late_s: options.motion.late_s,
            latch,
            interrupt,
        };
        Ok(Hardware {
            line: Line::new(Rig::new(parts), clock),
            model: Driven::new(&options.model, &[]),
            step_s,
            settle_s: options.settle_s,
            safety: options.safety,
            trial_s: 0.0,
            due_s: 0.0,
            timing: Timing::default(),
            stage: None,
            claim: None,
        })
    }

    /// What has happened to the robot so far.
    pub fn events(&self) -> Vec<Event> {
        self.line.rig().events().to_vec()
    }

    /// Time on the rig's clock, s: that of [`Hardware::events`].
    pub fn now_s(&self) -> f64 {
        self.line.clock.now_s()
    }

    /// How well the loop has kept time.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// The imitations behind the drivers, in a rehearsal.
    pub fn stage(&self) -> Option<&Stage> {
        self.stage.as_ref()
    }

    /// Where the model puts the tip now, metres.
    pub fn expected_m(&self) -> Point3 {
        self.model.observation(&[TendonCommand::Pull(0.0); AXES], 0.0).tip_m
    }

    /// What motors and tracker say about themselves, the tracker after `watch_s`; moves nothing.
    pub fn examine(&mut self, watch_s: f64) -> Examined {
        self.line.clock.sleep_until(self.line.clock.now_s() + watch_s);
        // Where the tip should be while nothing has been pulled; a model without rest says nothing.
        let _ = self.model.home();
        let home_m = self.expected_m();
        let rig = self.line.rig();
        Examined {
            controller: format!("{} {}", rig.controller().machine().firmware, rig.controller().machine().version),
            homed: rig.controller().homed(),
            position_mm: rig.controller().state().position_mm,
            server: rig.tracking().server(),
            tracking: rig.tracking().status().clone(),
            tip: rig.tracking().latest().map(|pose| pose.position_m),
            home_m,
        }
    }

    /// Looks at the rig for a moment.
    pub fn look<T>(&self, what: impl FnOnce(&Rig) -> T) -> T {
        what(&self.line.rig())
    }

    /// Homes the robot unless it is homed, and brings its tendons home.
    fn go_home(&mut self) -> Result<(), PlantError> {
        self.line.rig().expect(None);
        let deadline_s = self.line.clock.now_s() + HOMING_S;
        if *self.line.rig().state() == State::Idle {
            let now_s = self.line.clock.now_s();
            self.line.rig().begin(now_s).map_err(refused)?;
        }
        self.until_active(deadline_s)?;
        loop {
            let tick_s = self.line.clock.now_s() + self.step_s;
            let step_s = self.step_s;
            let arrived = self.line.wait(deadline_s, |rig, now_s| match rig.towards_home(step_s, now_s) {
                Err(NotMoved::Busy) => None,
                other => Some(other),
            });
            let arrived = arrived.ok_or_else(|| late("the way home"))?;
            self.line.clock.sleep_until(tick_s);
            self.until_active(deadline_s)?;
            if arrived.map_err(refused)? {
                return Ok(());
            }
        }
    }

    /// Waits while the robot homes or is held.
    fn until_active(&self, deadline_s: f64) -> Result<bool, PlantError> {
        let mut held = false;
        let ended = self.line.wait(deadline_s, |rig, _| match rig.state() {
            State::Active => Some(Ok(())),
            State::Held { .. } => {
                held = true;
                None
            }
            state => stopped(state).map(Err),
        });
        ended.unwrap_or_else(|| Err(late("a hold or homing"))).map(|()| held)
    }

    /// Refuses a command before the model moves, so that both stay where they are. How far tendons that follow go is for
    /// the model to say.
    fn admit(&self, commands: &[TendonCommand]) -> Result<(), PlantError> {
        let last_m = self.line.rig().commanded_m();
        let pulls_m: Vec<f64> = commands.iter().map(pull_m).collect();
        let ticks = self.safety.ticks(&pulls_m, &last_m, self.step_s).clamp(1, MOST_TICKS);
        match self.safety.admit(&pulls_m, &last_m, self.step_s * ticks as f64, ticks) {
            Err(Refusal::Beyond { .. }) if commands.contains(&TendonCommand::Follow) => Ok(()),
            other => other.map_err(|refusal| PlantError::Refused(refusal.to_string())),
        }
    }

    /// Moves the tendons to `pulls_m` in as many ticks as the limits ask for; true if the robot was held on the way.
    fn carry_out(&mut self, pulls_m: &[f64], begin_s: f64) -> Result<bool, PlantError> {
        let from_m = self.line.rig().commanded_m();
        let ticks = self.safety.ticks(pulls_m, &from_m, self.step_s).max(1);
        let mut held = false;
        for tick in 1..=ticks {
            let share = tick as f64 / ticks as f64;
            let there_m: Vec<f64> =
                pulls_m.iter().zip(&from_m).map(|(to, from)| share * to + (1.0 - share) * from).collect();
            self.send(&there_m)?;
            let end_s = begin_s + self.step_s * tick as f64;
            self.line.clock.sleep_until(end_s);
            self.timing.jitter_s.push(self.line.clock.now_s() - end_s);
            held |= self.until_active(end_s + PATIENCE_S)?;
            self.due_s = end_s;
        }
        Ok(held)
    }

    /// Sends the command of a tick that is due, as soon as the robot is active and the controller has room for it.
    fn send(&mut self, pulls_m: &[f64]) -> Result<(), PlantError> {
        let (step_s, called_s) = (self.step_s, self.line.clock.now_s());
        let sent = self.line.wait(called_s + PATIENCE_S, |rig, now_s| match rig.state() {
            State::Active => match rig.command(pulls_m, step_s, now_s) {
                // The next look at the state names what is in the way.
                Err(NotMoved::Busy | NotMoved::Not(_)) => None,
                other => Some(other.map_err(refused)),
            },
            state => stopped(state).map(Err),
        });
        self.timing.latency_s.push(self.line.clock.now_s() - called_s);
        sent.unwrap_or_else(|| Err(late("room in the controller's queue")))
    }

    /// What the tracker sees now; not valid where it sees nothing.
    fn observe(&self, pulls_m: Vec<f64>) -> Observation {
        let asked_s = self.line.clock.now_s();
        let between = self.line.wait(asked_s + POSE_S, |rig, _| rig.tip_at(asked_s));
        // Where several frames are lost in a row, the last one does as long as the guard believes it.
        let pose = between.or_else(|| self.line.rig().fresh_tip(asked_s));
        Observation {
            time_s: asked_s - self.trial_s,
            tip_m: pose.as_ref().map_or([f64::NAN; 3], |pose| pose.position_m),
            tip_quaternion: pose.as_ref().map(|pose| pose.quaternion),
            pulls_m,
            tensions_n: None,
            valid: pose.is_some(),
        }
    }
}

/// What motors and tracker say about themselves.
#[derive(Clone, Debug)]
pub struct Examined {
    /// Kind and version of the controller.
    pub controller: String,
    /// Whether the axes know where they are.
    pub homed: bool,
    /// Where they are, millimetres.
    pub position_mm: [f64; AXES],
    /// Name and version of the tracking server.
    pub server: String,
    /// How its frames have come.
    pub tracking: TrackingStatus,
    /// The tip, metres; none if it has not been seen.
    pub tip: Option<Point3>,
    /// Where the model puts the tip at home, metres.
    pub home_m: Point3,
}

/// What [`Hardware::of`] drives.
struct Opened {
    wire: Box<dyn Wire>,
    clock: Arc<dyn Clock>,
    latch: Option<Latch>,
    interrupt: Interrupt,
}

/// The displacement that a command asks for; of a tendon that follows, none yet.
fn pull_m(command: &TendonCommand) -> f64 {
    match *command {
        TendonCommand::Pull(pull_m) => pull_m,
        TendonCommand::Follow => 0.0,
    }
}

/// Why a stopped robot does nothing.
fn stopped(state: &State) -> Option<PlantError> {
    let State::Stopped { cause, .. } = state else { return None };
    Some(PlantError::Stopped(format!("{}; {}", cause.what, cause.remedy)))
}

/// Refuses axes that are too slow for the largest step in the time that a tick has for it.
fn fast_enough(controller: &Controller, safety: &SafetyLimits, step_s: f64) -> Result<(), String> {
    let needed_mm_min = slowest_axis_mm_min(safety, step_s);
    let speeds = controller.machine().max_speed_mm_min;
    match speeds.iter().position(|&speed| speed < needed_mm_min) {
        None => Ok(()),
        Some(axis) => Err(format!(
            "setting ${}: found {} mm/min, expected at least {needed_mm_min:.0} for steps of {} m in {step_s} s",
            110 + axis,
            speeds[axis],
            safety.max_step_m
        )),
    }
}

fn refused(error: NotMoved) -> PlantError {
    match error {
        NotMoved::Not(_) => PlantError::Stopped(error.to_string()),
        NotMoved::Refused(_) | NotMoved::Gate(_) | NotMoved::Busy => PlantError::Refused(error.to_string()),
    }
}

fn late(what: &str) -> PlantError {
    PlantError::Stopped(format!("{what} took longer than it may; look at the robot"))
}

impl Plant for Hardware {
    fn tendons(&self) -> usize {
        AXES
    }

    fn step_s(&self) -> f64 {
        self.step_s
    }

    /// The robot is brought home and rests there. Its noise is its own: the seed is not used.
    fn reset(&mut self, _seed: Seed) -> Result<Observation, PlantError> {
        self.go_home()?;
        self.model.home()?;
        let rested_s = self.line.clock.now_s() + self.settle_s;
        self.line.clock.sleep_until(rested_s);
        self.until_active(rested_s + PATIENCE_S)?;
        let home = [TendonCommand::Pull(0.0); AXES];
        self.line.rig().expect(Some(self.model.observation(&home, 0.0).tip_m));
        self.trial_s = self.line.clock.now_s();
        self.due_s = self.trial_s;
        Ok(self.observe(vec![0.0; AXES]))
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        let now_s = self.line.clock.now_s();
        if now_s > self.due_s + 0.5 * self.step_s {
            self.timing.missed += 1;
        }
        self.admit(commands)?;
        // The model goes first: it says how far the tendons that follow have to move.
        self.model.advance(commands, self.step_s)?;
        let believed = self.model.observation(commands, 0.0);
        let travel_m = self.safety.travel_m;
        let follow = |(command, pull_m): (&TendonCommand, &f64)| match command {
            TendonCommand::Follow => pull_m.clamp(-travel_m, travel_m),
            TendonCommand::Pull(asked_m) => *asked_m,
        };
        let pulls_m: Vec<f64> = commands.iter().zip(&believed.pulls_m).map(follow).collect();
        self.line.rig().expect(Some(believed.tip_m));
        if self.carry_out(&pulls_m, f64::max(self.due_s, now_s))? {
            self.timing.held += 1;
        }
        let seen = self.observe(pulls_m);
        Ok(seen)
    }
}
