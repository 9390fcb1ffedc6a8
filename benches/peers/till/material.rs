//! The cross-sections of the rod, one piece for each stretch of one material.

use nalgebra::Vector3;
use spinebench::rod::RodParams;

use super::{Settings, Space};

/// A stretch of one material.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) length_m: f64,
    /// Integration cells.
    pub(super) cells: usize,
    /// Shear stiffness, N.
    pub(super) shear_n: f64,
    /// Axial compliance of the backbone, 1/N.
    pub(super) axial_per_n: f64,
    /// Axial compliance that the compressible spine adds, 1/N.
    pub(super) spine_per_n: f64,
    /// Compressive force beyond which it adds no more, N.
    pub(super) saturation_n: f64,
    /// Bending, bending and twisting stiffness, N m².
    pub(super) turning_n_m2: Vector3<f64>,
    /// Viscous stiffness of the linear strains, N s.
    pub(super) linear_viscosity: Vector3<f64>,
    /// Viscous stiffness of the angular strains, N m² s.
    pub(super) turning_viscosity: Vector3<f64>,
    /// Mass per length, kg/m.
    pub(super) mass_kg_m: f64,
    /// Rotary inertia per length, kg m.
    pub(super) inertia_kg_m: Vector3<f64>,
}

impl Piece {
    /// Places at which this piece needs the past.
    pub(super) fn records(&self, space: Space) -> usize {
        match space {
            Space::Euler => self.cells + 1,
            Space::Rk4 => 2 * self.cells + 1,
        }
    }

    /// Elastic force for the linear strains `v`, and its derivative (diagonal).
    pub(super) fn force(&self, v: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let stretch = v.z - 1.0;
        let soft = self.axial_per_n + self.spine_per_n;
        let (axial, stiffness) = if stretch < -soft * self.saturation_n {
            (
                (stretch + self.spine_per_n * self.saturation_n) / self.axial_per_n,
                1.0 / self.axial_per_n,
            )
        } else {
            (stretch / soft, 1.0 / soft)
        };
        let shear = self.shear_n;
        (Vector3::new(shear * v.x, shear * v.y, axial), Vector3::new(shear, shear, stiffness))
    }
}

/// Cuts the rod wherever its material changes and spreads the nodes over the pieces by their
/// lengths.
pub(super) fn pieces(params: &RodParams, settings: &Settings) -> Vec<Piece> {
    let length = params.length_m();
    let mut cuts: Vec<f64> = vec![0.0, length];
    cuts.extend(params.spans.iter().map(|span| span.end_m));
    cuts.extend(params.sections.iter().flat_map(|s| [s.start_m, s.start_m + s.length_m]));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|b, a| *b - *a < 1e-9);
    let all = (settings.nodes.max(2) - 1) as f64;
    let piece = |ends: &[f64]| {
        let (length_m, middle) = (ends[1] - ends[0], 0.5 * (ends[0] + ends[1]));
        let cells = (all * length_m / length).round().max(1.0) as usize;
        piece_at(params, middle, Piece { length_m, cells, ..blank() }, settings)
    };
    cuts.windows(2).map(piece).collect()
}

fn blank() -> Piece {
    let zero = Vector3::zeros();
    Piece {
        length_m: 0.0,
        cells: 1,
        shear_n: 0.0,
        axial_per_n: 0.0,
        spine_per_n: 0.0,
        saturation_n: f64::INFINITY,
        turning_n_m2: zero,
        linear_viscosity: zero,
        turning_viscosity: zero,
        mass_kg_m: 0.0,
        inertia_kg_m: zero,
    }
}

fn piece_at(params: &RodParams, middle_m: f64, shape: Piece, settings: &Settings) -> Piece {
    let span = params.span_at(middle_m);
    let section =
        params.sections.iter().find(|s| (s.start_m..s.start_m + s.length_m).contains(&middle_m));
    let axial_per_n = 1.0 / span.axial_n;
    let spine_per_n = section.map_or(0.0, |s| s.compliance_m_per_n / s.length_m);
    let [first, second] = span.bending_n_m2;
    let turning = Vector3::new(first, second, span.torsion_n_m2);
    let time = params.damping_time_s;
    let linear_time = if settings.linear_damping { time } else { 0.0 };
    // I = A · E I / E A.
    let inertia = if settings.rotary_inertia {
        (span.mass_kg_m + span.spread_mass_kg_m) * first / span.axial_n
    } else {
        0.0
    };
    let bending = 0.5 * (first + second);
    Piece {
        shear_n: span.shear_n,
        axial_per_n,
        spine_per_n,
        saturation_n: section.map_or(f64::INFINITY, |s| s.saturation_n),
        turning_n_m2: turning,
        linear_viscosity: Vector3::new(
            span.shear_n,
            span.shear_n,
            1.0 / (axial_per_n + spine_per_n),
        ) * linear_time,
        turning_viscosity: Vector3::new(bending, bending, span.torsion_n_m2) * time,
        mass_kg_m: span.mass_kg_m + span.spread_mass_kg_m,
        inertia_kg_m: Vector3::new(inertia, inertia, 2.0 * inertia),
        ..shape
    }
}
