//! The robot of a model file: measurable quantities, and the rod built from them.

mod backbone;
mod disks;
mod loads;
mod tendons;
pub(super) mod units;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

pub use backbone::{Backbone, Piece};
pub use disks::{Disks, Sections};
pub use loads::{Frame, Load, OnePlace, Spread};
pub use tendons::{OffsetPoint, RadiusPoint, Tendons};

pub use crate::base::PerTendon;
use crate::base::{BadOption, TendonLayout};
use crate::rod::{ContactSurface, Resolution, RodParams, TipWrench};

/// Upper bound on sections, disks and cells.
const MAX_PARTS: usize = 10_000;
/// Upper bound on polynomials per component.
const MAX_MODES: usize = 50;

/// Result of a check: the path of the key below `robot`, and the expected range.
type Checked = Result<(), (String, BadOption)>;

/// A tendon-driven robot; as a whole it defaults to the nominal robot of `models/nominal.yaml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
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
    /// Time in which the drives execute a command, at constant speed, s; for a command that is held
    /// for a shorter time, that time.
    #[serde(default = "drive_time")]
    pub drive_time_s: f64,
    /// Quadratic drag per length on each body axis, N s²/m³.
    #[serde(default)]
    pub drag_n_s2_m3: f64,
    /// Position of the base, metres.
    #[serde(default)]
    pub base_m: [f64; 3],
    /// Rotation vector of the base, rad.
    #[serde(default)]
    pub base_rotation_rad: [f64; 3],
    /// Distance from the backbone's axis of the surface that touches obstacles, metres; default:
    /// the backbone's radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_radius_m: Option<f64>,
    /// Constant loads besides weight.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<Load>,
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

/// Fast enough not to affect the tip one tick later (`docs/method/rod.md`). It must not be zero: with
/// jumping tendons the time discretisation has no limit.
fn drive_time() -> f64 {
    0.02
}

impl Default for Robot {
    /// The paper's robot: length, sections, compliance, saturation, E and ν are the paper's, the
    /// rest is assumed.
    fn default() -> Self {
        Robot {
            backbone: Backbone {
                length_m: 0.22,
                radius_m: 0.002,
                youngs_modulus_pa: 2.33e9,
                poisson_ratio: 0.3897,
                density_kg_m3: 1200.0,
                ..Backbone::default()
            },
            sections: Sections {
                count: 11,
                length_m: 0.01,
                compliance_m_per_n: 2e-4,
                saturation_n: 20.0,
            },
            disks: Disks { count: 12, mass_kg: 0.004, ..Disks::default() },
            tendons: Tendons {
                radius_m: 0.02,
                angles_deg: vec![0.0, 90.0, 180.0, 270.0],
                pretension_m: PerTendon::Same(5e-4),
                ..Tendons::default()
            },
            gravity_m_s2: earth(),
            damping_time_s: damping(),
            drive_time_s: drive_time(),
            drag_n_s2_m3: 0.0,
            base_m: [0.0; 3],
            base_rotation_rad: [0.0; 3],
            contact_radius_m: None,
            loads: Vec::new(),
            resolution: Resolution::default(),
        }
    }
}

impl Robot {
    /// Refuses numbers that make no robot.
    ///
    /// # Errors
    /// The path of the key below `robot`, and the range that it left.
    pub fn check(&self) -> Checked {
        let length_m = self.backbone.length_m;
        self.backbone.check()?;
        self.sections.check(length_m)?;
        self.disks.check(length_m)?;
        self.tendons.check(length_m)?;
        at("", BadOption::unless_all_finite("gravity_m_s2", &self.gravity_m_s2))?;
        at("", BadOption::unless_not_negative("damping_time_s", self.damping_time_s))?;
        at("", BadOption::unless_positive("drive_time_s", self.drive_time_s))?;
        at("", BadOption::unless_not_negative("drag_n_s2_m3", self.drag_n_s2_m3))?;
        at("", BadOption::unless_all_finite("base_m", &self.base_m))?;
        at("", BadOption::unless_all_finite("base_rotation_rad", &self.base_rotation_rad))?;
        at(
            "",
            self.contact_radius_m.map_or(Ok(()), |radius_m| {
                BadOption::unless_not_negative("contact_radius_m", radius_m)
            }),
        )?;
        let fits = self.contact_radius_m.is_none_or(|radius_m| radius_m < length_m);
        let (radius_m, expected) =
            (self.contact_radius_m.unwrap_or_default(), "a radius less than the backbone's length");
        at("", refuse(fits, "contact_radius_m", &radius_m, expected))?;
        for (index, load) in self.loads.iter().enumerate() {
            at(&format!("loads[{index}].{}", load.name()), load.check(length_m))?;
        }
        self.check_resolution()
    }

    fn check_resolution(&self) -> Checked {
        let r = &self.resolution;
        let at = |result| at("resolution", result);
        at(BadOption::unless_positive("cell_m", r.cell_m))?;
        let cells = self.backbone.length_m / r.cell_m;
        at(refuse(
            cells <= MAX_PARTS as f64,
            "cell_m",
            &r.cell_m,
            "at most 10,000 cells along the backbone",
        ))?;
        at(BadOption::unless_positive("time_step_s", r.time_step_s))?;
        let positive = r.static_tolerance_m > 0.0;
        at(refuse(
            positive,
            "static_tolerance_m",
            &r.static_tolerance_m,
            "a number above 0, or infinity",
        ))?;
        let (tolerance_m, expected) =
            (r.motion_tolerance_m, "a positive number, or .inf for equal steps");
        at(refuse(tolerance_m > 0.0, "motion_tolerance_m", &tolerance_m, expected))?;
        let counts = [
            ("bending_modes", r.bending_modes),
            ("torsion_modes", r.torsion_modes),
            ("shear_modes", r.shear_modes),
            ("axial_modes", r.axial_modes),
        ];
        counts.into_iter().try_for_each(|(key, count)| {
            at(BadOption::unless_counted(key, count))?;
            at(refuse(count <= MAX_MODES, key, &count, "a whole number from 1 to 50"))
        })
    }

    /// Which tendons bend which part, and where they lie.
    pub fn tendon_layout(&self) -> TendonLayout {
        self.tendons.layout(self.backbone.length_m)
    }

    /// Smallest distance of a tendon from the backbone at the base, metres: its displacement where
    /// the robot bends by a radian.
    pub fn lever_m(&self) -> f64 {
        self.tendons.lever_m()
    }

    /// The rod without effects.
    pub fn rod(&self) -> RodParams {
        let mut rod = RodParams {
            spans: self.backbone.spans(),
            sections: self.compressible_sections(),
            masses: Vec::new(),
            tendons: self.tendons.tendons(self.backbone.length_m),
            gravity_m_s2: Vector3::from(self.gravity_m_s2),
            base_m: Vector3::from(self.base_m),
            base_rotation_rad: Vector3::from(self.base_rotation_rad),
            damping_time_s: self.damping_time_s,
            drag_n_s2_m3: self.drag_n_s2_m3,
            tip_load: TipWrench::default(),
            point_loads: Vec::new(),
            line_loads: Vec::new(),
            contact: ContactSurface {
                radius_m: self.contact_radius_m.unwrap_or(self.backbone.radius_m),
                ..ContactSurface::default()
            },
            moment_laws: Vec::new(),
            rested_s: f64::INFINITY,
            resolution: self.resolution,
        };
        self.add_disks(&mut rod);
        self.loads.iter().for_each(|load| load.apply(&mut rod));
        rod
    }
}

/// Adds the path below `robot` to an error.
fn at(path: &str, result: Result<(), BadOption>) -> Checked {
    result.map_err(|error| (path.to_owned(), error))
}

fn within(
    key: &'static str,
    value: f64,
    above: f64,
    up_to: f64,
    expected: &'static str,
) -> Result<(), BadOption> {
    refuse(value > above && value <= up_to, key, &value, expected)
}

fn refuse(
    good: bool,
    key: &'static str,
    found: &dyn std::fmt::Debug,
    expected: &'static str,
) -> Result<(), BadOption> {
    BadOption::unless(good, key, format!("{found:?}"), expected)
}
