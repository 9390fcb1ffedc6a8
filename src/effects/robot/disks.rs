//! Compressible sections and the rigid disks between them.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Checked, MAX_PARTS, Robot, at, refuse};
use crate::base::{BadOption, is_default};
use crate::rod::{CompressibleSection, DiskSurface, PointMass, RodParams};

/// Compressible sections, with the disks between them filling the rest of the backbone evenly
/// (paper, Fig. 1b).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sections {
    /// How many.
    pub count: usize,
    /// Relaxed length of each, metres.
    pub length_m: f64,
    /// Shortening of each per compressive force, m/N.
    pub compliance_m_per_n: f64,
    /// Force above which they do not shorten further, N.
    pub saturation_n: f64,
}

/// Rigid disks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disks {
    /// How many.
    pub count: usize,
    /// Mass of each, kg.
    pub mass_kg: f64,
    /// Positions, metres from the base. Default: if there is one disk more than sections, the disks
    /// fill the backbone between the sections and are distributed over their thickness; any other
    /// number is lumped at equal distances up to the tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub positions_m: Option<Vec<f64>>,
    /// Mass of each disk, kg, instead of `mass_kg`; only with `positions_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub masses_kg: Option<Vec<f64>>,
    /// Contact radius of the disks, metres; default: no contact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_radius_m: Option<f64>,
    /// Moments of inertia of each lumped disk about its own x, y and z, kg m².
    #[serde(default, skip_serializing_if = "is_default")]
    pub inertia_kg_m2: [f64; 3],
}

impl Sections {
    /// Refuses numbers that make no sections on a backbone of `length_m`.
    pub(super) fn check(&self, length_m: f64) -> Checked {
        if self.count == 0 {
            return Ok(());
        }
        let at = |result| at("sections", result);
        at(refuse(self.count <= MAX_PARTS, "count", &self.count, "a whole number up to 10,000"))?;
        at(BadOption::unless_positive("length_m", self.length_m))?;
        at(BadOption::unless_not_negative("compliance_m_per_n", self.compliance_m_per_n))?;
        at(BadOption::unless_positive("saturation_n", self.saturation_n))?;
        let fits = self.count as f64 * self.length_m <= length_m * (1.0 + 1e-9);
        at(refuse(
            fits,
            "length_m",
            &self.length_m,
            "sections with a total length up to that of the backbone",
        ))?;
        let shortens = self.compliance_m_per_n * self.saturation_n < self.length_m;
        at(refuse(
            shortens,
            "saturation_n",
            &self.saturation_n,
            "a section whose length stays positive at this force",
        ))
    }
}

impl Disks {
    /// Refuses numbers that make no disks on a backbone of `length_m`.
    pub(super) fn check(&self, length_m: f64) -> Checked {
        let at = |result| at("disks", result);
        at(BadOption::unless_not_negative("mass_kg", self.mass_kg))?;
        at(refuse(self.count <= MAX_PARTS, "count", &self.count, "a whole number up to 10,000"))?;
        at(BadOption::unless_positive_or_null("contact_radius_m", self.contact_radius_m))?;
        at(self
            .inertia_kg_m2
            .iter()
            .try_for_each(|&inertia| BadOption::unless_not_negative("inertia_kg_m2", inertia)))?;
        if let Some(positions) = &self.positions_m {
            let inside = positions.len() == self.count
                && positions.iter().all(|s| (0.0..=length_m).contains(s));
            at(refuse(
                inside,
                "positions_m",
                positions,
                "one place per disk, each within the backbone",
            ))?;
        }
        let Some(masses) = &self.masses_kg else { return Ok(()) };
        at(refuse(self.positions_m.is_some(), "masses_kg", masses, "`positions_m` in addition"))?;
        at(refuse(masses.len() == self.count, "masses_kg", masses, "one mass per disk"))?;
        at(masses.iter().try_for_each(|&mass| BadOption::unless_not_negative("masses_kg", mass)))
    }

    fn mass(&self, k: usize, position_m: f64) -> PointMass {
        PointMass {
            position_m,
            mass_kg: self.masses_kg.as_ref().map_or(self.mass_kg, |masses| masses[k]),
            inertia_kg_m2: Vector3::from(self.inertia_kg_m2),
        }
    }
}

impl Robot {
    /// Thickness of a disk when the disks and the sections fill the backbone, metres.
    fn disk_thickness_m(&self) -> f64 {
        let s = &self.sections;
        (self.backbone.length_m - s.count as f64 * s.length_m).max(0.0) / (s.count + 1) as f64
    }

    pub(super) fn compressible_sections(&self) -> Vec<CompressibleSection> {
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

    pub(super) fn add_disks(&self, rod: &mut RodParams) {
        let disks = &self.disks;
        let places = self.disk_places_m(rod);
        if let Some(radius_m) = disks.contact_radius_m {
            let surface = |&[start_m, end_m]: &[f64; 2]| DiskSurface { start_m, end_m, radius_m };
            rod.contact.disks.extend(places.iter().map(surface));
        }
        if self.disks_fill_backbone() {
            let density = disks.mass_kg / self.disk_thickness_m();
            places.iter().for_each(|&[start_m, end_m]| spread(rod, start_m, end_m, density));
        } else {
            rod.masses.extend(
                places.iter().enumerate().map(|(k, &[position_m, _])| disks.mass(k, position_m)),
            );
        }
    }

    /// Whether the disks fill the backbone between the sections.
    fn disks_fill_backbone(&self) -> bool {
        // Thinner disks are lumped: spread, their mass would have no bounded density.
        let one_more = self.sections.count > 0 && self.disks.count == self.sections.count + 1;
        self.disks.positions_m.is_none() && one_more && self.disk_thickness_m() >= 1e-6
    }

    /// Where each disk begins and ends, metres from the base; lumped ones have no thickness.
    pub fn disk_places_m(&self, rod: &RodParams) -> Vec<[f64; 2]> {
        if let Some(positions_m) = &self.disks.positions_m {
            return positions_m.iter().map(|&position_m| [position_m; 2]).collect();
        }
        if !self.disks_fill_backbone() {
            let step_m = self.backbone.length_m / self.disks.count.max(1) as f64;
            return (1..=self.disks.count).map(|k| [k as f64 * step_m; 2]).collect();
        }
        let starts_m = rod.sections.iter().map(|section| section.start_m + section.length_m);
        let ends_m = rod.sections.iter().map(|section| section.start_m);
        let starts_m = std::iter::once(0.0).chain(starts_m);
        starts_m
            .zip(ends_m.chain([self.backbone.length_m]))
            .map(|(start_m, end_m)| [start_m, end_m])
            .collect()
    }
}

/// Spreads a mass per length over part of the rod.
fn spread(rod: &mut RodParams, start_m: f64, end_m: f64, density_kg_m: f64) {
    rod.spans_between(start_m, end_m).for_each(|span| span.spread_mass_kg_m += density_kg_m);
}
