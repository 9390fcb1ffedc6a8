//! The robot of a model file: plain numbers as a lab would measure them, and the rod that they make.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{finite, non_negative};
use crate::base::BadOption;
use crate::rod::{CompressibleSection, PointMass, Resolution, RodParams, Span, Taper, Tendon, TendonPath, TipLoad};

/// Most sections, disks and cells: far beyond any robot, and within any memory.
const MOST_PARTS: usize = 10_000;
/// Most polynomials a component.
const MOST_MODES: usize = 50;

/// A tendon-driven robot; as a whole it defaults to the nominal robot of `models/nominal.yaml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// The elastic backbone.
    pub backbone: Backbone,
    /// Compressible sections of the spine.
    #[serde(default)]
    pub sections: Sections,
    /// Rigid disks.
    #[serde(default)]
    pub disks: Disks,
    /// Tendons.
    pub tendons: Tendons,
    /// Gravity in the world frame, m/s².
    #[serde(default = "earth")]
    pub gravity_m_s2: [f64; 3],
    /// Bending damping over bending stiffness, s.
    #[serde(default = "damping")]
    pub damping_time_s: f64,
    /// Quadratic drag per length on each body axis, N s²/m³.
    #[serde(default)]
    pub drag_n_s2_m3: f64,
    /// Position of the base, metres.
    #[serde(default)]
    pub base_m: [f64; 3],
    /// Rotation vector of the base, rad.
    #[serde(default)]
    pub base_rotation_rad: [f64; 3],
    /// Numerical resolution.
    #[serde(default)]
    pub resolution: Resolution,
}

fn earth() -> [f64; 3] {
    [-9.81, 0.0, 0.0]
}

fn damping() -> f64 {
    0.03
}

/// A round backbone of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Backbone {
    /// Length, metres.
    pub length_m: f64,
    /// Radius of the cross-section, metres.
    pub radius_m: f64,
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio ν; the shear modulus is E / (2 (1 + ν)).
    pub poisson_ratio: f64,
    /// Density, kg/m³.
    #[serde(default)]
    pub density_kg_m3: f64,
    /// Measured axial stiffness, N, in place of E·A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axial_stiffness_n: Option<f64>,
    /// Measured shear stiffness, N, in place of G·A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear_stiffness_n: Option<f64>,
    /// Measured bending stiffness, N m², in place of E·I.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bending_stiffness_n_m2: Option<f64>,
    /// Measured torsional stiffness, N m², in place of G·J.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsion_stiffness_n_m2: Option<f64>,
}

/// Compressible sections, with the disks between them filling the rest of the backbone evenly (paper, Fig. 1b).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sections {
    /// How many.
    pub count: usize,
    /// Relaxed length of each, metres.
    pub length_m: f64,
    /// Shortening of each per compressive force, m/N.
    pub compliance_m_per_n: f64,
    /// Force beyond which they shorten no more, N.
    pub saturation_n: f64,
}

/// Rigid disks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disks {
    /// How many.
    pub count: usize,
    /// Mass of each, kg.
    pub mass_kg: f64,
    /// Where they sit, metres from the base. Left out: one more than there are sections fill the backbone between
    /// the sections, each spread over its thickness; any other number is lumped at equal distances up to the tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub positions_m: Option<Vec<f64>>,
}

/// Tendons, all at one radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tendons {
    /// Distance from the backbone, metres.
    pub radius_m: f64,
    /// Angle of each from x towards y, degrees.
    pub angles_deg: Vec<f64>,
    /// How much each is tightened at home, metres.
    #[serde(default)]
    pub pretension_m: f64,
    /// Stretch of a whole tendon per tension, m/N.
    #[serde(default)]
    pub compliance_m_per_n: f64,
    /// Length over which a tendon stretches at home, metres: what the drive winds up stretches no more. Left out: the
    /// drive moves the whole tendon along.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elastic_length_m: Option<f64>,
    /// Where each ends, metres from the base; left out: at the tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends_m: Option<Vec<f64>>,
}

impl Default for Robot {
    /// The paper's robot: length, sections, compliance, saturation, E and ν are the paper's, the rest is assumed.
    fn default() -> Self {
        Robot {
            backbone: Backbone {
                length_m: 0.22,
                radius_m: 0.002,
                youngs_modulus_pa: 2.33e9,
                poisson_ratio: 0.3897,
                density_kg_m3: 1200.0,
                axial_stiffness_n: None,
                shear_stiffness_n: None,
                bending_stiffness_n_m2: None,
                torsion_stiffness_n_m2: None,
            },
            sections: Sections { count: 11, length_m: 0.01, compliance_m_per_n: 2e-4, saturation_n: 20.0 },
            disks: Disks { count: 12, mass_kg: 0.004, positions_m: None },
            tendons: Tendons {
                radius_m: 0.02,
                angles_deg: vec![0.0, 90.0, 180.0, 270.0],
                pretension_m: 5e-4,
                compliance_m_per_n: 0.0,
                elastic_length_m: None,
                ends_m: None,
            },
            gravity_m_s2: earth(),
            damping_time_s: damping(),
            drag_n_s2_m3: 0.0,
            base_m: [0.0; 3],
            base_rotation_rad: [0.0; 3],
            resolution: Resolution::default(),
        }
    }
}

impl Robot {
    /// Refuses numbers that make no robot.
    ///
    /// # Errors
    /// The path of the key below `robot`, and the range that it left.
    pub fn check(&self) -> Result<(), (&'static str, BadOption)> {
        let at = |path: &'static str, result: Result<(), BadOption>| result.map_err(|error| (path, error));
        let b = &self.backbone;
        at("backbone", BadOption::unless_positive("length_m", b.length_m))?;
        at("backbone", BadOption::unless_positive("radius_m", b.radius_m))?;
        at("backbone", BadOption::unless_positive("youngs_modulus_pa", b.youngs_modulus_pa))?;
        at("backbone", within("poisson_ratio", b.poisson_ratio, -1.0, 0.5, "a number above -1 and up to 0.5"))?;
        at("backbone", non_negative("density_kg_m3", b.density_kg_m3))?;
        at("backbone", BadOption::unless_positive_or_null("axial_stiffness_n", b.axial_stiffness_n))?;
        at("backbone", BadOption::unless_positive_or_null("shear_stiffness_n", b.shear_stiffness_n))?;
        at("backbone", BadOption::unless_positive_or_null("bending_stiffness_n_m2", b.bending_stiffness_n_m2))?;
        at("backbone", BadOption::unless_positive_or_null("torsion_stiffness_n_m2", b.torsion_stiffness_n_m2))?;
        self.check_sections()?;
        at("disks", non_negative("mass_kg", self.disks.mass_kg))?;
        at("disks", refuse(self.disks.count <= MOST_PARTS, "count", &self.disks.count, "a whole number up to 10,000"))?;
        if let Some(positions) = &self.disks.positions_m {
            let inside =
                positions.len() == self.disks.count && positions.iter().all(|&s| (0.0..=b.length_m).contains(&s));
            at("disks", refuse(inside, "positions_m", positions, "one place per disk, each within the backbone"))?;
        }
        self.check_tendons()?;
        at("", self.gravity_m_s2.iter().try_for_each(|&g| finite("gravity_m_s2", g)))?;
        at("", non_negative("damping_time_s", self.damping_time_s))?;
        at("", non_negative("drag_n_s2_m3", self.drag_n_s2_m3))?;
        at("", self.base_m.iter().try_for_each(|&x| finite("base_m", x)))?;
        at("", self.base_rotation_rad.iter().try_for_each(|&x| finite("base_rotation_rad", x)))?;
        self.check_resolution()
    }

    fn check_sections(&self) -> Result<(), (&'static str, BadOption)> {
        let s = &self.sections;
        if s.count == 0 {
            return Ok(());
        }
        let at = |result: Result<(), BadOption>| result.map_err(|error| ("sections", error));
        at(refuse(s.count <= MOST_PARTS, "count", &s.count, "a whole number up to 10,000"))?;
        at(BadOption::unless_positive("length_m", s.length_m))?;
        at(non_negative("compliance_m_per_n", s.compliance_m_per_n))?;
        at(BadOption::unless_positive("saturation_n", s.saturation_n))?;
        let fits = s.count as f64 * s.length_m <= self.backbone.length_m * (1.0 + 1e-9);
        at(refuse(fits, "length_m", &s.length_m, "sections that together are no longer than the backbone"))?;
        let shortens = s.compliance_m_per_n * s.saturation_n < s.length_m;
        at(refuse(shortens, "saturation_n", &s.saturation_n, "a section that keeps some length at this force"))
    }

    fn check_tendons(&self) -> Result<(), (&'static str, BadOption)> {
        let t = &self.tendons;
        let at = |result: Result<(), BadOption>| result.map_err(|error| ("tendons", error));
        at(BadOption::unless_positive("radius_m", t.radius_m))?;
        at(refuse(!t.angles_deg.is_empty(), "angles_deg", &t.angles_deg, "at least one angle"))?;
        at(t.angles_deg.iter().try_for_each(|&angle| finite("angles_deg", angle)))?;
        at(finite("pretension_m", t.pretension_m))?;
        at(non_negative("compliance_m_per_n", t.compliance_m_per_n))?;
        at(BadOption::unless_positive_or_null("elastic_length_m", t.elastic_length_m))?;
        let Some(ends) = &t.ends_m else { return Ok(()) };
        let length = self.backbone.length_m;
        let inside = ends.len() == t.angles_deg.len() && ends.iter().all(|&s| s > 0.0 && s <= length);
        at(refuse(inside, "ends_m", ends, "one place per tendon, each within the backbone"))
    }

    fn check_resolution(&self) -> Result<(), (&'static str, BadOption)> {
        let r = &self.resolution;
        let at = |result: Result<(), BadOption>| result.map_err(|error| ("resolution", error));
        at(BadOption::unless_positive("cell_m", r.cell_m))?;
        let cells = self.backbone.length_m / r.cell_m;
        at(refuse(cells <= MOST_PARTS as f64, "cell_m", &r.cell_m, "at most 10,000 cells along the backbone"))?;
        at(BadOption::unless_positive("time_step_s", r.time_step_s))?;
        let counts = [
            ("bending_modes", r.bending_modes),
            ("torsion_modes", r.torsion_modes),
            ("shear_modes", r.shear_modes),
            ("axial_modes", r.axial_modes),
        ];
        counts.into_iter().try_for_each(|(key, count)| {
            at(BadOption::unless_counted(key, count))?;
            at(refuse(count <= MOST_MODES, key, &count, "a whole number from 1 to 50"))
        })
    }

    /// The rod without effects.
    pub fn rod(&self) -> RodParams {
        let b = &self.backbone;
        let area = std::f64::consts::PI * b.radius_m * b.radius_m;
        let second_moment = 0.25 * area * b.radius_m * b.radius_m;
        let shear_modulus = b.youngs_modulus_pa / (2.0 * (1.0 + b.poisson_ratio));
        let span = Span {
            end_m: b.length_m,
            bending_n_m2: [b.bending_stiffness_n_m2.unwrap_or(b.youngs_modulus_pa * second_moment); 2],
            principal_angle_rad: 0.0,
            torsion_n_m2: b.torsion_stiffness_n_m2.unwrap_or(2.0 * shear_modulus * second_moment),
            shear_n: b.shear_stiffness_n.unwrap_or(shear_modulus * area),
            axial_n: b.axial_stiffness_n.unwrap_or(b.youngs_modulus_pa * area),
            rest_curvature_rad_m: Vector3::zeros(),
            home_curvature_rad_m: Vector3::zeros(),
            mass_kg_m: b.density_kg_m3 * area,
            spread_mass_kg_m: 0.0,
            taper: Taper::NONE,
        };
        let mut rod = RodParams {
            spans: vec![span],
            sections: self.compressible_sections(),
            masses: Vec::new(),
            tendons: self.tendons(),
            gravity_m_s2: Vector3::from(self.gravity_m_s2),
            base_m: Vector3::from(self.base_m),
            base_rotation_rad: Vector3::from(self.base_rotation_rad),
            damping_time_s: self.damping_time_s,
            drag_n_s2_m3: self.drag_n_s2_m3,
            tip_load: TipLoad::default(),
            point_loads: Vec::new(),
            line_loads: Vec::new(),
            memory: Vec::new(),
            resolution: self.resolution,
        };
        self.add_disks(&mut rod);
        rod
    }

    /// Thickness of a disk when the disks and the sections fill the backbone, metres.
    fn disk_thickness_m(&self) -> f64 {
        let s = &self.sections;
        (self.backbone.length_m - s.count as f64 * s.length_m).max(0.0) / (s.count + 1) as f64
    }

    fn compressible_sections(&self) -> Vec<CompressibleSection> {
        let s = &self.sections;
        let thickness = self.disk_thickness_m();
        let section = |k: usize| CompressibleSection {
            start_m: thickness + k as f64 * (thickness + s.length_m),
            length_m: s.length_m,
            compliance_m_per_n: s.compliance_m_per_n,
            saturation_n: s.saturation_n,
        };
        (0..s.count).map(section).collect()
    }

    fn add_disks(&self, rod: &mut RodParams) {
        let (count, mass_kg) = (self.disks.count, self.disks.mass_kg);
        if let Some(positions) = &self.disks.positions_m {
            return lump(rod, positions.iter().copied(), mass_kg);
        }
        if self.sections.count == 0 || count != self.sections.count + 1 || self.disk_thickness_m() < 1e-6 {
            let step = self.backbone.length_m / count.max(1) as f64;
            return lump(rod, (1..=count).map(|k| k as f64 * step), mass_kg);
        }
        let density = mass_kg / self.disk_thickness_m();
        let mut start_m = 0.0;
        for section in rod.sections.clone() {
            spread(rod, start_m, section.start_m, density);
            start_m = section.start_m + section.length_m;
        }
        spread(rod, start_m, self.backbone.length_m, density);
    }

    fn tendons(&self) -> Vec<Tendon> {
        let t = &self.tendons;
        let tendon = |(i, angle): (usize, &f64)| {
            let (sin, cos) = exact_sin_cos_deg(*angle);
            Tendon {
                path: TendonPath::parallel([t.radius_m * cos, t.radius_m * sin]),
                start_m: 0.0,
                end_m: t.ends_m.as_ref().map_or(self.backbone.length_m, |ends| ends[i]),
                pretension_m: t.pretension_m,
                compliance_m_per_n: t.compliance_m_per_n,
                elastic_length_m: t.elastic_length_m.unwrap_or(f64::INFINITY),
            }
        };
        t.angles_deg.iter().enumerate().map(tendon).collect()
    }
}

/// Spreads a mass per length over part of the rod.
fn spread(rod: &mut RodParams, start_m: f64, end_m: f64, density_kg_m: f64) {
    rod.spans_between(start_m, end_m).for_each(|span| span.spread_mass_kg_m += density_kg_m);
}

/// Puts a mass at each place.
fn lump(rod: &mut RodParams, positions_m: impl Iterator<Item = f64>, mass_kg: f64) {
    rod.masses.extend(positions_m.map(|position_m| PointMass { position_m, mass_kg, inertia_kg_m2: Vector3::zeros() }));
}

/// Sine and cosine that are exact at multiples of 90 degrees, so that a symmetric robot stays symmetric.
fn exact_sin_cos_deg(angle: f64) -> (f64, f64) {
    match angle.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}

fn within(key: &'static str, value: f64, above: f64, up_to: f64, expected: &'static str) -> Result<(), BadOption> {
    refuse(value > above && value <= up_to, key, &value, expected)
}

fn refuse(good: bool, key: &'static str, found: &dyn std::fmt::Debug, expected: &'static str) -> Result<(), BadOption> {
    if good { Ok(()) } else { Err(BadOption { key, found: format!("{found:?}"), expected }) }
}
