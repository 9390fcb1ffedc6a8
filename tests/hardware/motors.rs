//! Motors that count their steps without moving their tendons: the controller cannot tell, the tip can.

use crate::support::rehearsal::{open, options};
use spinebench::base::{Plant, Seed};
use spinebench::simulators::ControllerFault;

/// One tendon after the other is pulled, as by `doctor --move`: the tip stays where it is, and the axes that moved are named.
#[test]
fn a_pull_without_motion_names_the_axes_that_moved() {
    for (axis, name) in ["X", "Y", "Z", "A"].into_iter().enumerate() {
        let mut plant = open(&options(), 7);
        plant.reset(Seed(1)).unwrap();
        let fault = ControllerFault::SlippingAxis(axis);
        plant.rehearsal().unwrap().with_simulator(|simulator| simulator.controller.inject(fault));
        let words = (1..=12).find_map(|tick| {
            let mut pulls_m = [0.0; 4];
            pulls_m[axis] = 0.002 * f64::from(tick.min(3));
            pulls_m[(axis + 2) % 4] = -pulls_m[axis];
            plant.step(&pulls_m).err().map(|error| error.to_string())
        });
        let words = words.expect("nothing was noticed");
        assert!(words.contains(&format!("{name} by ")), "{words}");
    }
}
