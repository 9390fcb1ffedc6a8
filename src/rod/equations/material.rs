//! Constitutive law at a Gauss point: strains from the elastic internal wrench.

use crate::rod::discretisation::cell::GAUSS;
use crate::rod::params::rod_params::RodParams;

/// Components in the body frame. Strains: curvature and twist u (rad/m), then v (shear, shear,
/// stretch). Wrenches: moments, then forces.
pub(crate) type Components = [f64; 6];

/// Compliances of the cross-section at one Gauss point.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    /// Rest curvature and twist, rad/m.
    pub(crate) rest: [f64; 3],
    /// The same of the shape on which the tendons' lengths were set to zero.
    pub(crate) home: [f64; 3],
    /// Bending compliance about x, coupled, about y, 1/(N m²).
    pub(crate) bend: [f64; 3],
    /// Torsional compliance, 1/(N m²).
    pub(crate) twist: f64,
    /// Shear compliance, 1/N.
    pub(crate) shear: f64,
    /// Axial compliance without the compressible section, 1/N.
    pub(crate) axial: f64,
    /// Axial compliance that the compressible section adds, 1/N.
    pub(crate) spine: f64,
    /// Compressive force at which the section is fully shortened, N.
    pub(crate) saturation_n: f64,
    /// Viscous stiffness of each strain, N m² s and N s.
    pub(crate) viscosity: Components,
    /// Mean bending stiffness, N m².
    pub(crate) bending_n_m2: f64,
    /// Mass per length, kg/m.
    pub(crate) mass_kg_m: f64,
}

/// Derivative of the strains with respect to the wrench: two coupled bending axes, the rest
/// diagonal.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Compliance {
    pub(crate) bend: [f64; 3],
    pub(crate) diagonal: [f64; 4],
}

impl Compliance {
    /// Compliance times a wrench; the matrix is symmetric.
    #[inline(always)]
    pub(crate) fn apply(&self, w: &Components) -> Components {
        let [a, b, c] = self.bend;
        let [t, s1, s2, z] = self.diagonal;
        [a * w[0] + b * w[1], b * w[0] + c * w[1], t * w[2], s1 * w[3], s2 * w[4], z * w[5]]
    }

    /// Column `component` of the matrix.
    #[inline(always)]
    pub(crate) fn column(&self, component: usize) -> Components {
        let mut unit = [0.0; 6];
        unit[component] = 1.0;
        self.apply(&unit)
    }
}

impl Section {
    /// The law at `position_m` of the rod.
    pub(crate) fn new(params: &RodParams, position_m: f64) -> Section {
        let span = params.span_at(position_m);
        let (sin, cos) = span.principal_angle_rad.sin_cos();
        let [k1, k2] = span.bending_n_m2;
        let (c1, c2) = (1.0 / k1, 1.0 / k2);
        let section = params.sections.iter().find(|section| {
            (section.start_m..section.start_m + section.length_m).contains(&position_m)
        });
        let spine = section.map_or(0.0, |section| section.compliance_m_per_n / section.length_m);
        let axial = 1.0 / span.axial_n;
        let bending = 0.5 * (k1 + k2);
        let damping_s = params.damping_time_s;
        Section {
            rest: span.rest_curvature_rad_m.into(),
            home: span.home_curvature_rad_m.into(),
            // Compliance tensor of the principal axes, turned by their angle.
            bend: [
                c1 * cos * cos + c2 * sin * sin,
                (c1 - c2) * sin * cos,
                c1 * sin * sin + c2 * cos * cos,
            ],
            twist: 1.0 / span.torsion_n_m2,
            shear: 1.0 / span.shear_n,
            axial,
            spine,
            saturation_n: section.map_or(f64::INFINITY, |section| section.saturation_n),
            viscosity: [
                damping_s * bending,
                damping_s * bending,
                damping_s * span.torsion_n_m2,
                damping_s * span.shear_n,
                damping_s * span.shear_n,
                // Kelvin–Voigt: the viscous stiffness is damping time times the elastic one.
                damping_s / (axial + spine),
            ],
            bending_n_m2: bending,
            mass_kg_m: span.mass_kg_m + span.spread_mass_kg_m,
        }
    }

    /// Strains under the elastic wrench `w` and their derivative. The spine shortens in proportion
    /// to the axial compression (paper, eq. 14) up to the saturation force.
    #[inline(always)]
    pub(crate) fn strain(&self, w: &Components) -> (Components, Compliance) {
        let [a, b, c] = self.bend;
        let saturated = w[5] < -self.saturation_n;
        let stretch =
            if self.spine == 0.0 { 0.0 } else { self.spine * w[5].max(-self.saturation_n) };
        let strain = [
            self.rest[0] + a * w[0] + b * w[1],
            self.rest[1] + b * w[0] + c * w[1],
            self.rest[2] + self.twist * w[2],
            self.shear * w[3],
            self.shear * w[4],
            1.0 + self.axial * w[5] + stretch,
        ];
        // A fully shortened spine gives way no further.
        let axial = self.axial + if saturated { 0.0 } else { self.spine };
        (
            strain,
            Compliance { bend: self.bend, diagonal: [self.twist, self.shear, self.shear, axial] },
        )
    }

    /// Elastic energy per length under the wrench `w`, J/m (bending, twist, shear, stretch).
    pub(crate) fn energy_j_m(&self, w: &Components) -> f64 {
        let [a, b, c] = self.bend;
        let bend = a * w[0] * w[0] + 2.0 * b * w[0] * w[1] + c * w[1] * w[1];
        let others = self.twist * w[2] * w[2]
            + self.shear * (w[3] * w[3] + w[4] * w[4])
            + self.axial * w[5] * w[5];
        let spine = if self.spine == 0.0 {
            0.0
        } else if w[5] < -self.saturation_n {
            // Beyond saturation the spine keeps its length, and with it its energy.
            self.spine * self.saturation_n * self.saturation_n
        } else {
            self.spine * w[5] * w[5]
        };
        0.5 * (bend + others + spine)
    }

    /// The larger of the bending compliances about the principal axes and the torsional one, 1/(N
    /// m²).
    pub(crate) fn max_turning_compliance(&self) -> f64 {
        let [a, b, c] = self.bend;
        (0.5 * (a + c) + (0.5 * (a - c)).hypot(b)).max(self.twist)
    }

    /// Quadrature error of a cell of length `h` in which the spine begins to saturate, metres of
    /// stretch: the exact integral of the law under an axial force linear between `a` and `b`,
    /// minus the two-point rule.
    pub(crate) fn kink_m(&self, a: f64, b: f64, h: f64) -> f64 {
        // The axial force is extrapolated from the Gauss points to the ends of the cell.
        let half = 0.5 / (2.0 * GAUSS) * (b - a).abs();
        let (low, high) =
            (0.5 * (a + b) - half + self.saturation_n, 0.5 * (a + b) + half + self.saturation_n);
        if self.spine == 0.0 || low >= 0.0 || high <= 0.0 {
            return 0.0;
        }
        // Mean over the cell of the part of a linear force that lies above the kink.
        let exact = 0.5 * high * high / (high - low);
        let rule = 0.5 * ((a + self.saturation_n).max(0.0) + (b + self.saturation_n).max(0.0));
        self.spine * h * (exact - rule)
    }

    /// Change of curvature from the unloaded shape about the two body axes.
    pub(crate) fn bending(&self, strain: &Components) -> [f64; 2] {
        [strain[0] - self.rest[0], strain[1] - self.rest[1]]
    }

    /// Compliance of each wrench component, for scaling.
    pub(crate) fn scales(&self) -> Components {
        let bend = 0.5 * (self.bend[0] + self.bend[2]);
        [bend, bend, self.twist, self.shear, self.shear, self.axial + self.spine]
    }
}
