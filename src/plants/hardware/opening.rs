//! Opens the motors and the tracker, or simulators of both.

use std::sync::Arc;

use super::operator::RobotLock;
use super::supervised_rig::SupervisedRig;
use super::trial_log::TrialLog;
use super::{Hardware, HardwareOptions, LoopTiming, Rehearsal};
use crate::base::Seed;
use crate::effects::DrivenModel;
use crate::hardware::clock::{Clock, WallClock};
use crate::hardware::grbl::{Controller, MotionSettings};
use crate::hardware::interrupt::Interrupt;
use crate::hardware::rig::{Rig, RigParts, min_acceleration_mm_s2, slowest_axis_mm_min};
use crate::hardware::safety::Latch;
use crate::hardware::serial::{SerialLine, TtyLine};
use crate::hardware::tracking::{TrackerClient, TrackingSettings};

/// Additional wait for a held robot or a busy controller, beyond the guard's own limits, s.
const PATIENCE_S: f64 = 2.0;

impl Hardware {
    /// Opens the motors and the tracker of `options`, or simulators of both for a rehearsal; moves
    /// nothing.
    ///
    /// # Errors
    /// A message: a stored stop, a port, a setting or a body that is not as required.
    pub fn open(options: &HardwareOptions, step_s: f64, seed: Seed) -> Result<Hardware, String> {
        match &options.rehearsal {
            Some(rehearsal) => {
                let (rehearsal, serial, tracking) =
                    Rehearsal::open(options, rehearsal, step_s, seed)?;
                let clock = rehearsal.clock();
                let parts =
                    OpenedDevices { serial, clock, latch: None, interrupt: rehearsal.interrupt() };
                let mut plant = Hardware::with_devices(options, &tracking, step_s, parts)?;
                plant.rehearsal = Some(rehearsal);
                Ok(plant)
            }
            None => Hardware::open_robot(options, step_s),
        }
    }

    fn open_robot(options: &HardwareOptions, step_s: f64) -> Result<Hardware, String> {
        // Read only after the lock is held: the previous user may have stopped the robot.
        let lock = RobotLock::new(&options.attached)?;
        let latch = Latch::new(&Latch::folder(), &options.name);
        if let Some(reason) = latch.read() {
            return Err(format!(
                "robot `{}` is stopped: {reason}; inspect it, then run `spinebench arm`",
                options.name
            ));
        }
        let serial = TtyLine::open(&options.motion.port, options.motion.baud)
            .map_err(|error| no_port(&options.motion.port, &error))?;
        let interrupt = Interrupt::of_process().map_err(|error| error.to_string())?;
        let parts = OpenedDevices {
            serial: Box::new(serial),
            clock: Arc::new(WallClock::new()),
            latch: Some(latch),
            interrupt,
        };
        let mut plant = Hardware::with_devices(options, &options.tracking, step_s, parts)?;
        plant.lock = Some(lock);
        Ok(plant)
    }

    /// Builds the plant from open devices. The calling thread is registered with the clock.
    fn with_devices(
        options: &HardwareOptions,
        tracking: &TrackingSettings,
        step_s: f64,
        opened: OpenedDevices,
    ) -> Result<Hardware, String> {
        let OpenedDevices { serial, clock, latch, interrupt } = opened;
        // Every axis has to be fast enough for the largest step in a tick.
        let motion = MotionSettings {
            min_speed_mm_min: slowest_axis_mm_min(&options.safety, step_s),
            min_acceleration_mm_s2: min_acceleration_mm_s2(&options.safety, step_s),
            ..options.motion.clone()
        };
        let controller =
            Controller::open(serial, &motion, clock.as_ref()).map_err(|fault| fault.to_string());
        let tracking = TrackerClient::open(tracking.clone(), clock.as_ref())
            .map_err(|fault| fault.to_string());
        let ready = match (controller, tracking) {
            (Ok(controller), Ok(tracking)) => Ok((controller, tracking)),
            (Err(one), Err(other)) => Err(format!("{one}; and {other}")),
            (Err(fault), Ok(_)) | (Ok(_), Err(fault)) => Err(fault),
        };
        let (controller, tracking) = ready.inspect_err(|_| clock.leave())?;
        let parts = RigParts {
            controller,
            tracking,
            axes: options.axes,
            limits: options.safety,
            late_s: options.motion.late_s,
            latch,
            interrupt,
        };
        Ok(Hardware {
            supervised: SupervisedRig::new(Rig::new(parts), clock),
            unloaded_model: options.model.clone(),
            model: DrivenModel::new(&options.model, &[]),
            step_s,
            settle_s: options.settle_s,
            safety: options.safety,
            patience_s: PATIENCE_S + options.safety.hold_stop_s.max(options.motion.reply_timeout_s),
            trial_s: 0.0,
            due_s: 0.0,
            seen_events: 0,
            pose_wait_s: 0.0,
            rests_at_home: false,
            home_tips: None,
            trial: TrialLog::default(),
            timing: LoopTiming::default(),
            rehearsal: None,
            lock: None,
        })
    }
}

fn no_port(port: &str, error: &std::io::Error) -> String {
    format!(
        "{port}: cannot open the port: {error}; check the cable, the name, and that no other \
         program uses it"
    )
}

/// The devices of [`Hardware::with_devices`].
struct OpenedDevices {
    serial: Box<dyn SerialLine>,
    clock: Arc<dyn Clock>,
    latch: Option<Latch>,
    interrupt: Interrupt,
}
