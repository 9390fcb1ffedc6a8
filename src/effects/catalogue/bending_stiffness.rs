//! Error of the bending stiffness.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// Bending stiffness about both axes times `scale`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BendingStiffness {
    /// Factor on E·I, 1 changes nothing.
    pub scale: f64,
    /// Segment, from 1 at the base; 0: the whole robot.
    #[serde(default, skip_serializing_if = "super::is_whole")]
    pub segment: usize,
}

pub(crate) const CARD: Card = Card {
    name: "bending_stiffness",
    missing: "different bending stiffness E·I",
    equation: "E I → scale · E I",
    source: "Euler–Bernoulli beam",
    parameters: &[
        Parameter { name: "scale", unit: "1", null: 1.0, seek: Seek::Size(0.1) },
        Parameter::SEGMENT,
    ],
    usual_change: Some(0.3),
    confused_with: &["soft_section", "distributed_mass", "spine_compressibility"],
};

impl Effect for BendingStiffness {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("scale", self.scale)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let [start_m, end_m] = rod.segment_m(self.segment);
        for span in rod.spans_between(start_m, end_m) {
            span.bending_n_m2 = span.bending_n_m2.map(|stiffness| stiffness * self.scale);
        }
    }

    fn segment(&self) -> Option<usize> {
        Some(self.segment)
    }
}
