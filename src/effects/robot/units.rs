//! Ranges that no robot leaves, and the unit that was likely meant where a number does.
//!
//! These bounds catch wrong units; they are orders of magnitude wider than any robot. A fit may
//! cross them: only what somebody has written is held to them.

use super::{Checked, MAX_PARTS, Robot, at};
use crate::base::BadOption;

/// A quantity: the range that no robot leaves, the range of most, and other units that people write
/// it in.
pub(crate) struct UnitRange {
    /// Its unit in model files.
    unit: &'static str,
    /// Whether it can be negative; the checks of ranges tell of a negative number that cannot.
    signed: bool,
    /// The range that no robot leaves, as messages show it.
    expected: &'static str,
    /// That range; the magnitude of the number counts.
    hard: [f64; 2],
    /// The range of most robots.
    usual: [f64; 2],
    /// Other units and how much each is in `unit`, the likeliest first.
    others: OtherUnits,
}

const LENGTHS: OtherUnits = &[("mm", 1e-3), ("cm", 1e-2), ("µm", 1e-6)];
const TIMES: OtherUnits = &[("ms", 1e-3)];

const LENGTH: UnitRange =
    UnitRange::unsigned("m", LENGTHS, "0.002 to 20, in metres", [2e-3, 20.0], [0.05, 3.0]);
const RADIUS: UnitRange =
    UnitRange::unsigned("m", LENGTHS, "0.00001 to 0.5, in metres", [1e-5, 0.5], [3e-4, 0.05]);
const TENDON_RADIUS: UnitRange =
    UnitRange::unsigned("m", LENGTHS, "0.00001 to 1, in metres", [1e-5, 1.0], [1e-3, 0.2]);
const PRETENSION: UnitRange =
    UnitRange::signed("m", LENGTHS, "up to 0.1, in metres of tendon", [0.0, 0.1], [0.0, 0.02]);
const PLACE: UnitRange =
    UnitRange::signed("m", LENGTHS, "up to 50, in metres", [0.0, 50.0], [0.0, 10.0]);
const YOUNGS_MODULUS: UnitRange = UnitRange::unsigned(
    "Pa",
    &[("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3)],
    "5e3 to 2e12, in Pa",
    [5e3, 2e12],
    [1e5, 3e11],
);
const DENSITY: UnitRange = UnitRange::unsigned(
    "kg/m³",
    &[("g/cm³", 1e3)],
    "0, or 5 to 1e5, in kg/m³",
    [5.0, 1e5],
    [50.0, 2e4],
);
pub(crate) const MASS: UnitRange =
    UnitRange::unsigned("kg", &[("g", 1e-3)], "up to 15, in kg", [0.0, 15.0], [0.0, 2.0]);
pub(crate) const FORCE: UnitRange =
    UnitRange::signed("N", &[("mN", 1e-3)], "up to 1000, in N", [0.0, 1e3], [0.0, 100.0]);
pub(crate) const SHIFT: UnitRange =
    UnitRange::signed("m", LENGTHS, "up to 0.5, in metres", [0.0, 0.5], [0.0, 0.1]);
pub(crate) const ANGLE: UnitRange = UnitRange::signed(
    "rad",
    &[("degrees", std::f64::consts::PI / 180.0)],
    "up to 6.3, in radians",
    [0.0, 6.3],
    [0.0, 3.2],
);
pub(crate) const COMPLIANCE: UnitRange = UnitRange::unsigned(
    "m/N",
    &[("mm/N", 1e-3), ("µm/N", 1e-6)],
    "up to 0.05, in m/N",
    [0.0, 0.05],
    [0.0, 0.01],
);
const GRAVITY: UnitRange = UnitRange::signed(
    "m/s²",
    &[("mm/s²", 1e-3), ("cm/s²", 1e-2)],
    "up to 30, in m/s²",
    [0.0, 30.0],
    [0.0, 12.0],
);
const DAMPING_TIME: UnitRange =
    UnitRange::unsigned("s", TIMES, "up to 20, in seconds", [0.0, 20.0], [0.0, 2.0]);
const DRIVE_TIME: UnitRange =
    UnitRange::unsigned("s", TIMES, "up to 10, in seconds", [0.0, 10.0], [0.0, 1.0]);
const BENDING: UnitRange = UnitRange::unsigned(
    "N m²",
    &[("N mm²", 1e-6)],
    "1e-10 to 1e4, in N m²",
    [1e-10, 1e4],
    [1e-6, 1e2],
);

/// Names of units, and how much each is in the unit of the range.
type OtherUnits = &'static [(&'static str, f64)];

impl UnitRange {
    const fn unsigned(
        unit: &'static str,
        others: OtherUnits,
        expected: &'static str,
        hard: [f64; 2],
        usual: [f64; 2],
    ) -> UnitRange {
        UnitRange { unit, signed: false, expected, hard, usual, others }
    }

    const fn signed(
        unit: &'static str,
        others: OtherUnits,
        expected: &'static str,
        hard: [f64; 2],
        usual: [f64; 2],
    ) -> UnitRange {
        UnitRange { signed: true, ..UnitRange::unsigned(unit, others, expected, hard, usual) }
    }

    /// Refuses a number that no robot has; names the unit in which it would be usual.
    pub(crate) fn check(&self, key: &'static str, value: f64) -> Result<(), BadOption> {
        let size = value.abs();
        let checked_elsewhere = size == 0.0 || !size.is_finite() || (value < 0.0 && !self.signed);
        let good = checked_elsewhere || (self.hard[0]..=self.hard[1]).contains(&size);
        BadOption::unless(good, key, self.with_likely_unit(value), self.expected)
    }

    /// The number, with the unit that was likely meant.
    fn with_likely_unit(&self, value: f64) -> String {
        let usual = |factor: f64| (self.usual[0]..=self.usual[1]).contains(&(value.abs() * factor));
        match self.others.iter().find(|(_, factor)| usual(*factor)) {
            Some((unit, factor)) => {
                format!(
                    "{value} (if that is in {unit}, write {} {})",
                    short(value * factor),
                    self.unit
                )
            }
            None => value.to_string(),
        }
    }

    /// How many decades `value` is outside the range of most robots.
    fn unusual_decades(&self, value: f64) -> f64 {
        let size = value.abs();
        if size == 0.0 {
            return 0.0;
        }
        let below = if self.usual[0] > 0.0 { (self.usual[0] / size).log10() } else { 0.0 };
        below.max((size / self.usual[1]).log10()).max(0.0)
    }
}

/// A number as a person would write it: `4e9`, `0.3`.
fn short(value: f64) -> String {
    if (1e-4..1e5).contains(&value.abs()) {
        format!("{}", (value * 1e9).round() / 1e9)
    } else {
        format!("{value:e}")
    }
}

impl Robot {
    /// Refuses numbers that no robot has, as a wrong unit makes them.
    ///
    /// # Errors
    /// As [`Robot::check`].
    pub fn check_units(&self) -> Checked {
        self.unit_faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// All numbers that no robot has, each with its path; where every number by itself is one that
    /// robots have, those that do not go together.
    pub fn unit_faults(&self) -> Vec<(String, BadOption)> {
        let checked = self
            .quantities()
            .into_iter()
            .filter_map(|(path, key, value, quantity)| at(&path, quantity.check(key, value)).err());
        let mut faults: Vec<(String, BadOption)> = Vec::new();
        for (path, fault) in checked {
            // Of a list one number tells the unit.
            if !faults.iter().any(|(other, told)| *other == path && told.key == fault.key) {
                faults.push((path, fault));
            }
        }
        if faults.is_empty() {
            let checks = [self.check_slender(), self.check_disk_mass(), self.check_angles()];
            faults.extend(checks.into_iter().filter_map(Result::err));
        }
        faults
    }

    /// The key that is furthest outside the range of most robots, and its value; `None` where all
    /// are usual.
    pub fn suspect(&self) -> Option<(String, f64)> {
        let doubt = |(path, key, value, quantity): (String, &str, f64, &UnitRange)| {
            let dot = if path.is_empty() { "" } else { "." };
            (quantity.unusual_decades(value), format!("robot.{path}{dot}{key}"), value)
        };
        let all = self.quantities().into_iter().map(doubt);
        let worst = all.max_by(|one, other| one.0.total_cmp(&other.0))?;
        (worst.0 > 0.0).then_some((worst.1, worst.2))
    }

    /// Every number whose unit can be mistaken: path below `robot`, key, value, quantity.
    fn quantities(&self) -> Vec<(String, &'static str, f64, &'static UnitRange)> {
        let (backbone, tendons) = (&self.backbone, &self.tendons);
        let mut all: Vec<(String, &'static str, f64, &'static UnitRange)> = Vec::new();
        let mut add =
            |path: &str, key, value, quantity| all.push((path.to_owned(), key, value, quantity));
        add("backbone", "length_m", backbone.length_m, &LENGTH);
        add("backbone", "radius_m", backbone.radius_m, &RADIUS);
        let measured = [
            backbone.axial_stiffness_n,
            backbone.shear_stiffness_n,
            backbone.torsion_stiffness_n_m2,
        ];
        // Where every stiffness was measured, Young's modulus has no influence.
        if measured.iter().any(Option::is_none) || backbone.bending_stiffness_n_m2.is_none() {
            add("backbone", "youngs_modulus_pa", backbone.youngs_modulus_pa, &YOUNGS_MODULUS);
        }
        add("backbone", "density_kg_m3", backbone.density_kg_m3, &DENSITY);
        let bending = [
            ("bending_stiffness_n_m2", backbone.bending_stiffness_n_m2),
            ("torsion_stiffness_n_m2", backbone.torsion_stiffness_n_m2),
        ];
        for (key, stiffness) in bending {
            stiffness.into_iter().for_each(|stiffness| add("backbone", key, stiffness, &BENDING));
        }
        for (index, piece) in backbone.pieces.iter().enumerate() {
            let path = format!("backbone.pieces[{index}]");
            piece
                .radius_m
                .into_iter()
                .for_each(|radius_m| add(&path, "radius_m", radius_m, &RADIUS));
            piece
                .youngs_modulus_pa
                .into_iter()
                .for_each(|e| add(&path, "youngs_modulus_pa", e, &YOUNGS_MODULUS));
            piece
                .density_kg_m3
                .into_iter()
                .for_each(|density| add(&path, "density_kg_m3", density, &DENSITY));
        }
        add("tendons", "radius_m", tendons.radius_m, &TENDON_RADIUS);
        let radii_m = tendons.radii_m.iter().flatten();
        radii_m.for_each(|&radius_m| add("tendons", "radii_m", radius_m, &TENDON_RADIUS));
        tendons
            .pretension_m
            .values()
            .iter()
            .for_each(|&m| add("tendons", "pretension_m", m, &PRETENSION));
        tendons
            .compliance_m_per_n
            .values()
            .iter()
            .for_each(|&c| add("tendons", "compliance_m_per_n", c, &COMPLIANCE));
        add("disks", "mass_kg", if self.disks.count > 0 { self.disks.mass_kg } else { 0.0 }, &MASS);
        self.disks
            .masses_kg
            .iter()
            .flatten()
            .for_each(|&mass_kg| add("disks", "masses_kg", mass_kg, &MASS));
        if self.sections.count > 0 {
            add("sections", "compliance_m_per_n", self.sections.compliance_m_per_n, &COMPLIANCE);
        }
        self.gravity_m_s2.iter().for_each(|&g| add("", "gravity_m_s2", g, &GRAVITY));
        add("", "damping_time_s", self.damping_time_s, &DAMPING_TIME);
        add("", "drive_time_s", self.drive_time_s, &DRIVE_TIME);
        self.base_m.iter().for_each(|&x| add("", "base_m", x, &PLACE));
        self.base_rotation_rad.iter().for_each(|&x| add("", "base_rotation_rad", x, &ANGLE));
        all
    }

    /// Radii are smaller than the length: one of them is in another unit where they are not.
    fn check_slender(&self) -> Checked {
        let length_m = self.backbone.length_m;
        let radii = [
            ("backbone", self.backbone.radius_m, &RADIUS),
            ("tendons", self.tendons.radius_m, &TENDON_RADIUS),
        ];
        for (path, radius_m, quantity) in radii {
            if radius_m >= length_m {
                let found = format!(
                    "{}, which is not less than the robot's length of {length_m} m",
                    quantity.with_likely_unit(radius_m)
                );
                at(
                    path,
                    Err(BadOption {
                        key: "radius_m",
                        found,
                        expected: "a radius in metres, less than `length_m`",
                    }),
                )?;
            }
        }
        Ok(())
    }

    /// Disks that together would have to be denser than lead are in another unit.
    fn check_disk_mass(&self) -> Checked {
        let disks = &self.disks;
        let all_kg = disks
            .masses_kg
            .as_ref()
            .map_or(disks.count as f64 * disks.mass_kg, |masses| masses.iter().sum());
        let widest_m = self.tendons.widest_m().max(self.backbone.radius_m);
        let lead_kg = LEAD_KG_M3
            * std::f64::consts::PI
            * (DISK_OVER_TENDON * widest_m).powi(2)
            * self.backbone.length_m;
        // More disks than a model may have are told by their number.
        if all_kg <= lead_kg || disks.count > MAX_PARTS {
            return Ok(());
        }
        let (key, value) = match &disks.masses_kg {
            Some(masses) => ("masses_kg", masses.iter().copied().fold(0.0, f64::max)),
            None => ("mass_kg", disks.mass_kg),
        };
        let found = format!("{value} (if that is in g, write {} kg)", short(value * 1e-3));
        at(
            "disks",
            Err(BadOption {
                key,
                found,
                expected: "a total disk mass below that of lead disks of this size, in kg",
            }),
        )
    }

    /// Tendons that all lie within a few degrees of each other are in radians.
    fn check_angles(&self) -> Checked {
        let angles = &self.tendons.angles_deg;
        // Angles that are written in radians are at most 2π.
        let all_small = angles.iter().all(|angle| angle.abs() <= 6.3);
        let apart = angles.iter().any(|angle| (angle - angles[0]).abs() > 0.5);
        if !(all_small && apart) || self.tendons.paths.is_some() {
            return Ok(());
        }
        let degrees: Vec<f64> = angles.iter().map(|angle| angle.to_degrees().round()).collect();
        let found = format!("{angles:?} (if that is in radians, write {degrees:?})");
        at(
            "tendons",
            Err(BadOption {
                key: "angles_deg",
                found,
                expected: "tendons around the backbone, in degrees",
            }),
        )
    }
}

/// Density of lead, kg/m³.
const LEAD_KG_M3: f64 = 11_340.0;
/// Radius of a disk over that of the tendons, at most.
const DISK_OVER_TENDON: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::PerTendon;

    fn refused(change: impl Fn(&mut Robot)) -> String {
        let mut robot = Robot::default();
        change(&mut robot);
        let (path, error) = robot.check_units().unwrap_err();
        format!("{path}.{error}")
    }

    /// A change of the robot, the key that is refused, the words that tell the unit.
    type Case<'a> = (&'a dyn Fn(&mut Robot), &'a str, &'a str);

    #[test]
    fn a_wrong_unit_is_refused_with_the_unit_that_was_meant() {
        let cases: [Case; 12] = [
            (
                &|robot| robot.backbone.youngs_modulus_pa = 4.0,
                "backbone.youngs_modulus_pa",
                "in GPa, write 4e9 Pa",
            ),
            (
                &|robot| robot.backbone.youngs_modulus_pa = 2330.0,
                "backbone.youngs_modulus_pa",
                "in MPa, write 2.33e9 Pa",
            ),
            (&|robot| robot.backbone.radius_m = 1.5, "backbone.radius_m", "in mm, write 0.0015 m"),
            (&|robot| robot.backbone.length_m = 300.0, "backbone.length_m", "in mm, write 0.3 m"),
            (&|robot| robot.backbone.length_m = 22.0, "backbone.length_m", "in cm, write 0.22 m"),
            (
                &|robot| robot.backbone.density_kg_m3 = 1.2,
                "backbone.density_kg_m3",
                "in g/cm³, write 1200 kg/m³",
            ),
            (&|robot| robot.tendons.radius_m = 15.0, "tendons.radius_m", "in mm, write 0.015 m"),
            (&|robot| robot.disks.mass_kg = 3.0, "disks.mass_kg", "in g, write 0.003 kg"),
            (
                &|robot| robot.tendons.pretension_m = PerTendon::Same(0.5),
                "tendons.pretension_m",
                "in mm, write 0.0005 m",
            ),
            (
                &|robot| robot.gravity_m_s2[0] = -9810.0,
                "gravity_m_s2",
                "in mm/s², write -9.81 m/s²",
            ),
            (&|robot| robot.damping_time_s = 30.0, "damping_time_s", "in ms, write 0.03 s"),
            (
                &|robot| robot.tendons.angles_deg = vec![0.0, 2.0944, 4.1888],
                "tendons.angles_deg",
                "write [0.0, 120.0, 240.0]",
            ),
        ];
        for (change, place, meant) in cases {
            let said = refused(change);
            assert!(said.contains(place) && said.contains(meant), "{said}");
        }
    }

    #[test]
    fn all_wrong_units_are_told_at_once() {
        let mut robot = Robot::default();
        robot.backbone.youngs_modulus_pa = 4.0;
        robot.tendons.radius_m = 15.0;
        robot.gravity_m_s2 = [-9810.0, 500.0, 0.0];
        let keys: Vec<&str> = robot.unit_faults().iter().map(|(_, fault)| fault.key).collect();
        assert_eq!(keys, ["youngs_modulus_pa", "radius_m", "gravity_m_s2"]);
    }

    #[test]
    fn the_usual_robot_is_beyond_doubt_and_the_most_unusual_key_is_the_suspect() {
        let mut robot = Robot::default();
        assert_eq!((robot.check_units(), robot.suspect()), (Ok(()), None));
        robot.backbone.youngs_modulus_pa = 8e3;
        robot.tendons.radius_m = 0.21;
        assert_eq!(robot.suspect(), Some(("robot.backbone.youngs_modulus_pa".to_owned(), 8e3)));
    }
}
