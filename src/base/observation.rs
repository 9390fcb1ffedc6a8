//! Commands to a robot and observations of it.

/// Displacement of each tendon at the drive, in metres: 0 at home, positive pulls (takes tendon out
/// of the robot).
pub type Displacements = Vec<f64>;

/// A position in the base frame, in metres: x up (against gravity), z along the straight robot.
pub type Point3 = [f64; 3];

/// A tracked point on a robot's body at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// Position, metres; not a number where it was not seen.
    pub position_m: Point3,
    /// Orientation of the body there as a unit quaternion (w, x, y, z), where the plant measures
    /// it.
    pub quaternion: Option<[f64; 4]>,
}

/// Observation of a robot at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Time since the trial began, seconds.
    pub time_s: f64,
    /// Measured tip position, metres.
    pub tip_m: Point3,
    /// Measured tip orientation as a unit quaternion (w, x, y, z), where the plant measures it.
    pub tip_quaternion: Option<[f64; 4]>,
    /// Further tracked points, in the order of [`crate::base::Plant::points`].
    pub points: Vec<SeenPoint>,
    /// Displacements in force during the interval that ended at `time_s`: commanded ones, or for a
    /// following tendon the one that the robot's shape asked for.
    pub pulls_m: Displacements,
    /// Tendon tensions in newtons (0 when slack), where the plant knows them.
    pub tensions_n: Option<Vec<f64>>,
    /// False where tracking was lost.
    pub valid: bool,
}

impl Observation {
    /// All measured positions, the tip first, to be changed.
    pub fn positions_m(&mut self) -> impl Iterator<Item = &mut Point3> {
        std::iter::once(&mut self.tip_m)
            .chain(self.points.iter_mut().map(|point| &mut point.position_m))
    }
}

/// Euclidean distance between two points, metres.
pub fn distance_m(a: &Point3, b: &Point3) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}
