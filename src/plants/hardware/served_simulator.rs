//! Simulated motors and tracker for other programs: a serial port and UDP ports of this computer,
//! by the wall clock.

use super::HardwareOptions;
use super::rehearsal::build_simulator;
use crate::base::Seed;
use crate::hardware::clock::{Clock, WallClock};
use crate::hardware::serial::TtyLine;
use crate::simulators::Simulator;

/// Time step of the simulators, s.
const STEP_S: f64 = 0.002;
/// Ticks that the simulated motors are fast enough for, s: programs with shorter ones have to raise
/// their acceleration, as that of real ones.
const TICK_S: f64 = 0.2;

/// Simulators that advance while [`ServedSimulator::step`] is called.
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
    /// A message, if there is no rehearsal or the system refuses a port.
    pub fn open(options: &HardwareOptions, seed: Seed) -> Result<ServedSimulator, String> {
        let rehearsal = options
            .rehearsal
            .as_ref()
            .ok_or("found no `rehearsal`, expected the model to simulate")?;
        let (serial, port) =
            TtyLine::served().map_err(|error| format!("cannot open a pseudo-terminal: {error}"))?;
        let (simulator, tracking) =
            build_simulator(options, rehearsal, TICK_S, Box::new(serial), seed)?;
        let mut plant =
            HardwareOptions { tracking, rehearsal: None, attached: Vec::new(), ..options.clone() };
        plant.motion.port = port;
        Ok(ServedSimulator { simulator, clock: WallClock::new(), due_s: 0.0, plant })
    }

    /// The plant through which other programs use the simulators.
    pub fn plant(&self) -> &HardwareOptions {
        &self.plant
    }

    /// The simulator.
    pub fn simulator(&mut self) -> &mut Simulator {
        &mut self.simulator
    }

    /// Waits until the next step is due and simulates until now; returns the time since opening, s.
    pub fn step(&mut self) -> f64 {
        self.clock.sleep_until(self.due_s);
        let now_s = self.clock.now_s();
        self.simulator.step(now_s);
        self.due_s = f64::max(self.due_s + STEP_S, now_s);
        now_s
    }
}
