//! Imitated motors and an imitated tracker for other programs: a serial port and UDP ports of this computer, by the wall
//! clock.

use super::HardwareOptions;
use super::rehearsal::build_simulator;
use crate::base::Seed;
use crate::hardware::clock::{Clock, WallClock};
use crate::hardware::serial::TtyLine;
use crate::simulators::Simulator;

/// How often the imitations are looked after, s.
const STEP_S: f64 = 0.002;

/// Imitations that live as long as somebody calls [`ServedSimulator::step`].
pub struct ServedSimulator {
    simulator: Simulator,
    clock: WallClock,
    due_s: f64,
    plant: HardwareOptions,
}

impl ServedSimulator {
    /// Opens the ports for the rehearsal in `options`.
    ///
    /// # Errors
    /// In words, when there is no rehearsal or the system refuses a port.
    pub fn open(options: &HardwareOptions, seed: Seed) -> Result<ServedSimulator, String> {
        let rehearsal = options.rehearsal.as_ref().ok_or("found no `rehearsal`, expected what is to be imitated")?;
        let (serial, port) = TtyLine::served().map_err(|error| format!("no pseudo-terminal: {error}"))?;
        let (simulator, tracking) = build_simulator(options, rehearsal, Box::new(serial), seed)?;
        let mut plant = HardwareOptions { tracking, rehearsal: None, attached: Vec::new(), ..options.clone() };
        plant.motion.port = port;
        Ok(ServedSimulator { simulator, clock: WallClock::new(), due_s: 0.0, plant })
    }

    /// The plant that other programs name to use the imitations.
    pub fn plant(&self) -> &HardwareOptions {
        &self.plant
    }

    /// The imitations.
    pub fn simulator(&mut self) -> &mut Simulator {
        &mut self.simulator
    }

    /// Waits until the imitations are due and does all that happens until now; the time since they were opened, s.
    pub fn step(&mut self) -> f64 {
        self.clock.sleep_until(self.due_s);
        let now_s = self.clock.now_s();
        self.simulator.step(now_s);
        self.due_s = f64::max(self.due_s + STEP_S, now_s);
        now_s
    }
}
