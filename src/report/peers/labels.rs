//! Names of simulators and robots in the comparison, and their order.

use crate::report::order::Labels;

/// Simulators in their order, and their names in the figure.
pub(crate) const PEERS: Labels = Labels(&[
    ("spinebench", "spinebench"),
    ("till_2019", "Till et al. 2019, their solver"),
    ("till_2019_tuned", "Till et al. 2019, Jacobian kept, RK4"),
    ("mujoco", "MuJoCo hinge chain"),
    ("pyelastica", "PyElastica"),
]);

/// Names of robots.
pub(crate) const ROBOTS: Labels = Labels(&[
    ("till", "Till et al.’s example"),
    ("paper", "paper’s robot, lengths"),
    ("paper_tension", "no spine, no damping"),
]);
