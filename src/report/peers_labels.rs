//! Names of simulators and robots in the comparison, and their order.

/// Simulators in their order, and their names in the figure.
const PEERS: [(&str, &str); 5] = [
    ("spinebench", "spinebench"),
    ("till_2019", "Till et al. 2019, their solver"),
    ("till_2019_tuned", "Till et al. 2019, Jacobian kept, RK4"),
    ("mujoco", "MuJoCo hinge chain"),
    ("pyelastica", "PyElastica"),
];

/// Position of a simulator in [`PEERS`]; an unknown one follows the last.
pub(super) fn rank(peer: &str) -> usize {
    PEERS.iter().position(|(known, _)| *known == peer).unwrap_or(PEERS.len())
}

/// Name of a simulator.
pub(super) fn name(peer: &str) -> String {
    PEERS.iter().find(|(known, _)| *known == peer).map_or(peer, |(_, words)| *words).to_owned()
}

/// These simulators in the order of [`PEERS`], unknown ones last.
pub(super) fn order<'a>(seen: &[&'a str]) -> Vec<&'a str> {
    let mut peers = seen.to_vec();
    peers.sort_by_key(|peer| rank(peer));
    peers
}

/// Name of a robot.
pub(super) fn title(robot: &str) -> String {
    match robot {
        "till" => "Till et al.’s example".to_owned(),
        "paper" => "paper’s robot, lengths".to_owned(),
        "paper_tension" => "no spine, no damping".to_owned(),
        other => other.to_owned(),
    }
}
