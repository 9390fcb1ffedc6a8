//! Tendons: path, ends and compliance.

/// A tendon through guide holes, from the base or a more distal point to its anchor. It transmits
/// tension only.
#[derive(Clone, Debug, PartialEq)]
pub struct Tendon {
    /// Path through the cross-sections.
    pub path: TendonPath,
    /// Where it leaves its sheath, metres from the base. It exerts no load on the rod proximal to
    /// this point.
    pub start_m: f64,
    /// Where it is anchored, metres from the base.
    pub end_m: f64,
    /// Displacement at home, metres, before the first command.
    pub pretension_m: f64,
    /// Compliance of the whole tendon at home, m/N.
    pub compliance_m_per_n: f64,
    /// Elastic length at home, metres; the part that is pulled in no longer stretches. Infinite:
    /// the compliance does not depend on the displacement.
    pub elastic_length_m: f64,
    /// Coefficient of friction in its guides (capstan equation); 0 without friction.
    pub friction_coefficient: f64,
    /// Displacement of the drive that mobilises this friction from none to all, metres.
    pub presliding_m: f64,
}

/// Displacement that mobilises a tendon's friction where nothing else is known, metres.
pub const PRESLIDING_M: f64 = 3e-4;

/// Offset from the backbone as a function of arc length s: linear between `points`, constant
/// outside them, and rotated by `twist_rad_m`·s about the backbone (a helix).
#[derive(Clone, Debug, PartialEq)]
pub struct TendonPath {
    /// At least one, in order of s.
    pub points: Vec<PathPoint>,
    /// Turn from x towards y per length, rad/m.
    pub twist_rad_m: f64,
}

/// A point of a tendon's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Distance from the base along the relaxed rod, metres.
    pub s_m: f64,
    /// Offset from the backbone along the body axes x and y, metres.
    pub offset_m: [f64; 2],
}

impl Tendon {
    /// A tendon parallel to the backbone from the base to `end_m`; it does not stretch and is just
    /// straight at home.
    pub fn parallel(offset_m: [f64; 2], end_m: f64) -> Tendon {
        Tendon {
            path: TendonPath::parallel(offset_m),
            start_m: 0.0,
            end_m,
            pretension_m: 0.0,
            compliance_m_per_n: 0.0,
            elastic_length_m: f64::INFINITY,
            friction_coefficient: 0.0,
            presliding_m: PRESLIDING_M,
        }
    }

    /// Whether it has friction in its guides.
    pub(crate) fn has_friction(&self) -> bool {
        self.friction_coefficient > 0.0
    }

    /// Compliance after `pull_m` has been pulled in, m/N.
    pub(crate) fn compliance_at(&self, pull_m: f64) -> f64 {
        self.compliance_m_per_n * (1.0 - pull_m / self.elastic_length_m)
    }

    /// Arc lengths at which the rod's internal wrench may jump due to this tendon: its ends and the
    /// kinks of its path, metres.
    pub(crate) fn borders_m(&self) -> Vec<f64> {
        let mut borders = vec![self.start_m, self.end_m];
        let inside = |s: f64| s > self.start_m && s < self.end_m;
        borders.extend(self.path.points.iter().map(|point| point.s_m).filter(|&s| inside(s)));
        borders
    }
}

impl TendonPath {
    /// A path of constant offset.
    pub fn parallel(offset_m: [f64; 2]) -> TendonPath {
        TendonPath { points: vec![PathPoint { s_m: 0.0, offset_m }], twist_rad_m: 0.0 }
    }

    /// Multiplies every offset.
    pub fn scale(&mut self, factor: f64) {
        self.points
            .iter_mut()
            .for_each(|point| point.offset_m = point.offset_m.map(|offset| offset * factor));
    }

    /// Turns the whole path about the backbone, from x towards y.
    pub fn turn(&mut self, angle_rad: f64) {
        self.points.iter_mut().for_each(|point| point.offset_m = turned(point.offset_m, angle_rad));
    }

    /// Offset in metres and its change per length at `position_m`.
    pub fn at(&self, position_m: f64) -> ([f64; 2], [f64; 2]) {
        let next = self.points.iter().position(|point| point.s_m > position_m);
        let (offset, slope) = match next {
            // Outside its points a path goes on parallel to the backbone.
            None => (self.points.last().map_or([0.0; 2], |point| point.offset_m), [0.0; 2]),
            Some(0) => (self.points[0].offset_m, [0.0; 2]),
            Some(next) => {
                let (from, to) = (self.points[next - 1], self.points[next]);
                let slope: [f64; 2] = std::array::from_fn(|k| {
                    (to.offset_m[k] - from.offset_m[k]) / (to.s_m - from.s_m)
                });
                (
                    std::array::from_fn(|k| from.offset_m[k] + slope[k] * (position_m - from.s_m)),
                    slope,
                )
            }
        };
        if self.twist_rad_m == 0.0 {
            return (offset, slope);
        }
        // d/ds Rz(ωs) r = Rz(ωs) (r′ + ω ẑ × r)
        let [x, y] = offset;
        let helix = [slope[0] - self.twist_rad_m * y, slope[1] + self.twist_rad_m * x];
        let angle = self.twist_rad_m * position_m;
        (turned(offset, angle), turned(helix, angle))
    }
}

fn turned([x, y]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}
