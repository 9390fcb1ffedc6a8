//! Commands to a robot and observations of it.

/// Displacement of each tendon at the drive, in metres: 0 at home, positive pulls (takes tendon out of the robot).
pub type Displacements = Vec<f64>;

/// A position in the base frame, in metres: x up (against gravity), z along the straight robot.
pub type Point3 = [f64; 3];

/// Observation of a robot at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Time since the trial began, seconds.
    pub time_s: f64,
    /// Measured tip position, metres.
    pub tip_m: Point3,
    /// Measured tip orientation as a unit quaternion (w, x, y, z), where the plant measures it.
    pub tip_quaternion: Option<[f64; 4]>,
    /// Displacements in force during the interval that ended at `time_s`: commanded ones, or for a following
    /// tendon the one that the robot's shape asked for.
    pub pulls_m: Displacements,
    /// Tendon tensions in newtons (0 when slack), where the plant knows them.
    pub tensions_n: Option<Vec<f64>>,
    /// False where tracking was lost.
    pub valid: bool,
}

/// Euclidean distance between two points, metres.
pub fn distance_m(a: &Point3, b: &Point3) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}
