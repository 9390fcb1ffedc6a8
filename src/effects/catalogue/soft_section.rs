//! One section of reduced bending stiffness, as after damage.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::rod::CompressibleSection;

/// Reduced bending stiffness of the compressible section nearest to a position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SoftSection {
    /// Place along the robot, metres from the base.
    pub position_m: f64,
    /// Factor on the bending stiffness there, 1 changes nothing.
    pub scale: f64,
}

pub(crate) const CARD: Card = Card {
    name: "soft_section",
    missing: "lower stiffness of one section (damage)",
    equation: "E I(s) → scale · E I within the section that holds s",
    source: "local stiffness loss",
    parameters: &[
        Parameter { name: "position_m", unit: "m", null: 0.0, seek: Seek::Place },
        Parameter { name: "scale", unit: "1", null: 1.0, seek: Seek::Size(-0.3) },
    ],
    usual_change: Some(0.3),
    confused_with: &["bending_stiffness", "tendon_stretch", "tendon_radius"],
};

impl Effect for SoftSection {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("position_m", self.position_m)?;
        BadOption::unless_positive("scale", self.scale)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let (start_m, end_m) = section_around(rod, self.position_m);
        for span in rod.spans_between(start_m, end_m) {
            span.bending_n_m2 = span.bending_n_m2.map(|stiffness| stiffness * self.scale);
        }
    }
}

/// The compressible section whose middle is nearest, or 10 mm around the position where there are
/// none.
fn section_around(rod: &RodParams, position_m: f64) -> (f64, f64) {
    let distance = |section: &CompressibleSection| {
        (section.start_m + 0.5 * section.length_m - position_m).abs()
    };
    let nearest = rod.sections.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.map_or_else(
        || ((position_m - 0.005).max(0.0), (position_m + 0.005).min(rod.length_m())),
        |section| (section.start_m, section.start_m + section.length_m),
    )
}
