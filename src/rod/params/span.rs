//! Cross-sections of the backbone, constant or tapered along a span.

use nalgebra::Vector3;

/// Linear-elastic cross-section of the backbone and its rest shape over part of the length. The
/// values hold at the span's start; `taper` says how they change along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Where the span ends, metres from the base; it begins where the one before ends.
    pub end_m: f64,
    /// Bending stiffnesses E·I about the two principal axes, N m².
    pub bending_n_m2: [f64; 2],
    /// Angle of the first principal axis from x towards y, radians.
    pub principal_angle_rad: f64,
    /// Torsional stiffness G·J, N m².
    pub torsion_n_m2: f64,
    /// Shear stiffness G·A, N.
    pub shear_n: f64,
    /// Axial stiffness E·A, N.
    pub axial_n: f64,
    /// Curvature and twist when unloaded, rad/m (body axes).
    pub rest_curvature_rad_m: Vector3<f64>,
    /// Curvature and twist of the shape at which the tendon lengths are zero, rad/m: the rest
    /// curvature as designed.
    pub home_curvature_rad_m: Vector3<f64>,
    /// Mass of the backbone per length, kg/m.
    pub mass_kg_m: f64,
    /// Additional uniformly distributed mass, kg/m.
    pub spread_mass_kg_m: f64,
    /// How the cross-section widens or narrows along the span.
    pub taper: Taper,
}

/// Outer and inner radius at both ends of a span, linear in between. Only ratios matter. Axial and
/// shear stiffness and mass scale with the area, bending and torsional stiffness with the second
/// moment of area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taper {
    /// Outer radius at the start and the end of the span.
    pub outer: [f64; 2],
    /// Inner radius there.
    pub inner: [f64; 2],
}

impl Taper {
    /// The same cross-section all along.
    pub const NONE: Taper = Taper { outer: [1.0; 2], inner: [0.0; 2] };

    /// Area and second moment of area at `share` of the span over those at its start.
    fn ratios(&self, share: f64) -> (f64, f64) {
        let between = |[from, to]: [f64; 2]| from + (to - from) * share;
        let (outer, inner) = (between(self.outer), between(self.inner));
        let ratio = |power: i32| {
            (outer.powi(power) - inner.powi(power))
                / (self.outer[0].powi(power) - self.inner[0].powi(power))
        };
        // Areas go with the square, second moments with the fourth power of the radius.
        if *self == Taper::NONE { (1.0, 1.0) } else { (ratio(2), ratio(4)) }
    }
}

impl Span {
    /// A solid round cross-section of one material up to `end_m`, straight when unloaded.
    pub fn round(
        end_m: f64,
        radius_m: f64,
        youngs_modulus_pa: f64,
        shear_modulus_pa: f64,
        mass_kg_m: f64,
    ) -> Span {
        let area = std::f64::consts::PI * radius_m * radius_m;
        let second_moment = 0.25 * area * radius_m * radius_m;
        Span {
            end_m,
            bending_n_m2: [youngs_modulus_pa * second_moment; 2],
            principal_angle_rad: 0.0,
            // The polar second moment of a circle is twice the axial one.
            torsion_n_m2: 2.0 * shear_modulus_pa * second_moment,
            shear_n: shear_modulus_pa * area,
            axial_n: youngs_modulus_pa * area,
            rest_curvature_rad_m: Vector3::zeros(),
            home_curvature_rad_m: Vector3::zeros(),
            mass_kg_m,
            spread_mass_kg_m: 0.0,
            taper: Taper::NONE,
        }
    }

    /// The remainder of a span that began at `start_m`, from `position_m` on: same end, properties
    /// at the new start.
    pub(super) fn from(&self, start_m: f64, position_m: f64) -> Span {
        if self.taper == Taper::NONE {
            return self.clone();
        }
        let share = (position_m - start_m) / (self.end_m - start_m);
        let (area, second_moment) = self.taper.ratios(share);
        let remaining = |[from, to]: [f64; 2]| [from + (to - from) * share, to];
        Span {
            bending_n_m2: self.bending_n_m2.map(|stiffness| stiffness * second_moment),
            torsion_n_m2: self.torsion_n_m2 * second_moment,
            shear_n: self.shear_n * area,
            axial_n: self.axial_n * area,
            mass_kg_m: self.mass_kg_m * area,
            taper: Taper { outer: remaining(self.taper.outer), inner: remaining(self.taper.inner) },
            ..self.clone()
        }
    }
}
