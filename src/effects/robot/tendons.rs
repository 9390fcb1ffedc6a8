//! Tendons as a lab would measure them.

use serde::{Deserialize, Serialize};

use super::{Checked, MAX_PARTS, PerTendon, at, refuse};
use crate::base::{BadOption, PlacedTendon, TendonLayout};
use crate::rod::{PRESLIDING_M, PathPoint, Tendon, TendonPath};

/// Tendons, at a constant radius unless another key is given. Lists have one entry per tendon.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tendons {
    /// Distance from the backbone at the base, metres.
    pub radius_m: f64,
    /// Angle of each from x towards y, degrees.
    pub angles_deg: Vec<f64>,
    /// Distance of each at the base, metres, in place of `radius_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radii_m: Option<Vec<f64>>,
    /// Distance of all tendons at places along the backbone, in order, linear in between; constant
    /// beyond the last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profile: Vec<RadiusPoint>,
    /// Rotation of each tendon about the backbone per length, from x towards y, rad/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twists_rad_m: Option<Vec<f64>>,
    /// Path of each tendon instead of radius and angle: points in order, linear in between. An
    /// empty path does not change a tendon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paths: Option<Vec<Vec<OffsetPoint>>>,
    /// Pretension of each at home as a displacement, metres: one number, or one per tendon, which
    /// also sets the zero of each drive.
    #[serde(default)]
    pub pretension_m: PerTendon,
    /// Stretch of a whole tendon per tension, m/N: one number, or one per tendon.
    #[serde(default)]
    pub compliance_m_per_n: PerTendon,
    /// Length over which a tendon stretches at home, metres; the wound-up part does not stretch.
    /// Default: the drive moves the whole tendon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elastic_length_m: Option<f64>,
    /// Place where each leaves its sheath, metres from the base; default: the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts_m: Option<Vec<f64>>,
    /// End of each, metres from the base; default: the tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends_m: Option<Vec<f64>>,
}

/// Distance of the tendons from the backbone at one place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RadiusPoint {
    /// Distance from the base, metres.
    pub s_m: f64,
    /// Distance from the backbone, metres.
    pub radius_m: f64,
}

/// Offset of a tendon at one place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OffsetPoint {
    /// Distance from the base, metres.
    pub s_m: f64,
    /// Offset from the backbone along x, metres.
    pub x_m: f64,
    /// Offset along y, metres.
    pub y_m: f64,
}

impl Tendons {
    /// Refuses numbers that make no tendons on a backbone of `length_m`.
    pub(super) fn check(&self, length_m: f64) -> Checked {
        let at = |result| at("tendons", result);
        let count = self.angles_deg.len();
        at(BadOption::unless_positive("radius_m", self.radius_m))?;
        at(refuse(
            !self.angles_deg.is_empty(),
            "angles_deg",
            &self.angles_deg,
            "at least one angle",
        ))?;
        at(BadOption::unless_all_finite("angles_deg", &self.angles_deg))?;
        at(each(
            "radii_m",
            self.radii_m.as_ref(),
            count,
            &|r| r > 0.0,
            "one number above 0 per tendon",
        ))?;
        at(each(
            "twists_rad_m",
            self.twists_rad_m.as_ref(),
            count,
            &f64::is_finite,
            "one number per tendon",
        ))?;
        at(each_of("pretension_m", &self.pretension_m, count, &BadOption::unless_finite))?;
        at(each_of(
            "compliance_m_per_n",
            &self.compliance_m_per_n,
            count,
            &BadOption::unless_not_negative,
        ))?;
        at(BadOption::unless_positive_or_null("elastic_length_m", self.elastic_length_m))?;
        let inside = |s: f64| s > 0.0 && s <= length_m;
        at(each(
            "ends_m",
            self.ends_m.as_ref(),
            count,
            &inside,
            "one place per tendon, each within the backbone",
        ))?;
        let expected = "one place per tendon, each on the backbone";
        at(each(
            "starts_m",
            self.starts_m.as_ref(),
            count,
            &|s| s >= 0.0 && s < length_m,
            expected,
        ))?;
        let passes = (0..count).all(|i| self.start_m(i) < self.end_m(i, length_m));
        at(refuse(passes, "starts_m", &self.starts_m, "places before the tendons' ends"))?;
        self.check_profile()?;
        self.check_paths()
    }

    fn check_profile(&self) -> Checked {
        at(
            "tendons",
            refuse(
                self.profile.len() <= MAX_PARTS,
                "profile",
                &self.profile.len(),
                "up to 10,000 places",
            ),
        )?;
        let mut before = 0.0;
        for (index, point) in self.profile.iter().enumerate() {
            let path = format!("tendons.profile[{index}]");
            let further = point.s_m.is_finite() && point.s_m > before;
            further_out(&path, point.s_m, further)?;
            at(
                &path,
                refuse(point.radius_m.is_finite(), "radius_m", &point.radius_m, "a finite number"),
            )?;
            before = point.s_m;
        }
        Ok(())
    }

    fn check_paths(&self) -> Checked {
        let Some(paths) = &self.paths else { return Ok(()) };
        let complete = paths.len() == self.angles_deg.len()
            && paths.iter().all(|path| path.len() <= MAX_PARTS);
        at(
            "tendons",
            refuse(complete, "paths", &paths.len(), "one path per tendon, of up to 10,000 points"),
        )?;
        for (tendon, points) in paths.iter().enumerate() {
            let mut before = f64::NEG_INFINITY;
            for (index, point) in points.iter().enumerate() {
                let path = format!("tendons.paths[{tendon}][{index}]");
                let further = point.s_m >= 0.0 && point.s_m.is_finite() && point.s_m > before;
                further_out(&path, point.s_m, further)?;
                at(&path, BadOption::unless_finite("x_m", point.x_m))?;
                at(&path, BadOption::unless_finite("y_m", point.y_m))?;
                before = point.s_m;
            }
        }
        Ok(())
    }

    /// The tendons by where they end, from base to tip.
    pub(super) fn layout(&self, length_m: f64) -> TendonLayout {
        let mut ends_m: Vec<f64> =
            (0..self.angles_deg.len()).map(|i| self.end_m(i, length_m)).collect();
        ends_m.sort_by(f64::total_cmp);
        // Ends that differ by rounding alone are of one segment.
        ends_m.dedup_by(|a, b| (*a - *b).abs() < 1e-6 * length_m);
        let ending = |end_m: f64| {
            let ends_here = |&i: &usize| (self.end_m(i, length_m) - end_m).abs() < 1e-6 * length_m;
            let placed = |tendon| PlacedTendon { tendon, angle_deg: self.angle_deg(tendon) };
            (0..self.angles_deg.len()).filter(ends_here).map(placed).collect()
        };
        TendonLayout { segments: ends_m.into_iter().map(ending).collect() }
    }

    /// Angle at which a tendon starts, degrees.
    fn angle_deg(&self, i: usize) -> f64 {
        let first_point = self.paths.as_ref().and_then(|paths| paths[i].first());
        first_point.map_or(self.angles_deg[i], |point| point.y_m.atan2(point.x_m).to_degrees())
    }

    /// Largest distance of a tendon from the backbone, metres.
    pub(super) fn widest_m(&self) -> f64 {
        let profile = self.profile.iter().map(|point| point.radius_m.abs());
        let paths = self.paths.iter().flatten().flatten().map(|point| point.x_m.hypot(point.y_m));
        let radii = self.radii_m.iter().flatten().copied();
        std::iter::once(self.radius_m).chain(radii).chain(profile).chain(paths).fold(0.0, f64::max)
    }

    /// Smallest distance of a tendon from the backbone where it starts, metres.
    pub(super) fn lever_m(&self) -> f64 {
        let at_start_m = |i: usize| {
            let first_point = self.paths.as_ref().and_then(|paths| paths[i].first());
            let radius_m = self.radii_m.as_ref().map_or(self.radius_m, |radii| radii[i]);
            first_point.map_or(radius_m, |point| point.x_m.hypot(point.y_m))
        };
        (0..self.angles_deg.len()).map(at_start_m).fold(f64::INFINITY, f64::min)
    }

    fn start_m(&self, i: usize) -> f64 {
        self.starts_m.as_ref().map_or(0.0, |starts| starts[i])
    }

    fn end_m(&self, i: usize, length_m: f64) -> f64 {
        self.ends_m.as_ref().map_or(length_m, |ends| ends[i])
    }

    /// The tendons on a backbone of `length_m`.
    pub(super) fn tendons(&self, length_m: f64) -> Vec<Tendon> {
        let tendon = |i: usize| Tendon {
            path: self.path(i),
            start_m: self.start_m(i),
            end_m: self.end_m(i, length_m),
            pretension_m: self.pretension_m.of(i),
            compliance_m_per_n: self.compliance_m_per_n.of(i),
            friction_coefficient: 0.0,
            presliding_m: PRESLIDING_M,
            elastic_length_m: self.elastic_length_m.unwrap_or(f64::INFINITY),
        };
        (0..self.angles_deg.len()).map(tendon).collect()
    }

    fn path(&self, i: usize) -> TendonPath {
        let path = self.paths.as_ref().map_or(&[][..], |paths| &paths[i]);
        let points = if path.is_empty() {
            let (sin, cos) = exact_sin_cos_deg(self.angles_deg[i]);
            let at = |s_m: f64, radius_m: f64| PathPoint {
                s_m,
                offset_m: [radius_m * cos, radius_m * sin],
            };
            let base = at(0.0, self.radii_m.as_ref().map_or(self.radius_m, |radii| radii[i]));
            let further = self.profile.iter().map(|point| at(point.s_m, point.radius_m));
            std::iter::once(base).chain(further).collect()
        } else {
            path.iter()
                .map(|point| PathPoint { s_m: point.s_m, offset_m: [point.x_m, point.y_m] })
                .collect()
        };
        TendonPath {
            points,
            twist_rad_m: self.twists_rad_m.as_ref().map_or(0.0, |twists| twists[i]),
        }
    }
}

/// Refuses a list that has not one good number a tendon.
fn each(
    key: &'static str,
    list: Option<&Vec<f64>>,
    count: usize,
    good: &dyn Fn(f64) -> bool,
    expected: &'static str,
) -> Result<(), BadOption> {
    let Some(list) = list else { return Ok(()) };
    let all = list.len() == count && list.iter().all(|&value| value.is_finite() && good(value));
    refuse(all, key, list, expected)
}

/// Refuses a list of another length than the number of tendons, and numbers that are not `good`.
fn each_of(
    key: &'static str,
    numbers: &PerTendon,
    count: usize,
    good: &dyn Fn(&'static str, f64) -> Result<(), BadOption>,
) -> Result<(), BadOption> {
    refuse(
        numbers.fits(count),
        key,
        &numbers.values(),
        "a number, or a list of one number per tendon",
    )?;
    numbers.values().iter().try_for_each(|&value| good(key, value))
}

/// Sine and cosine that are exact at multiples of 90 degrees, so that a symmetric robot stays
/// symmetric.
fn exact_sin_cos_deg(angle: f64) -> (f64, f64) {
    match angle.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}

/// Refuses a place `s_m` along a tendon that does not lie `further` out than the one before.
fn further_out(path: &str, s_m: f64, further: bool) -> Checked {
    at(path, refuse(further, "s_m", &s_m, "a place further from the base than the one before"))
}
