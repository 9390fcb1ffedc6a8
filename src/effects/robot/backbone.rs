//! The backbone as a lab would measure it.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Checked, MAX_PARTS, at, refuse, within};
use crate::base::{BadOption, is_default};
use crate::rod::{Span, Taper};

/// A round backbone of one material and one cross-section, unless `pieces` is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Backbone {
    /// Length, metres.
    pub length_m: f64,
    /// Radius of the cross-section, metres.
    pub radius_m: f64,
    /// Radius of the bore of a tube, metres; 0 is solid.
    #[serde(default, skip_serializing_if = "is_default")]
    pub inner_radius_m: f64,
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
    /// Pieces from base to tip of a non-uniform backbone; omitted keys of a piece have the values
    /// above.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<Piece>,
}

/// A piece of a backbone. Radii and the properties computed from them change along it, radii
/// linearly; a measured stiffness applies at its start and changes in proportion to the computed
/// one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Piece {
    /// End, metres from the base; the piece begins at the end of the previous one.
    pub end_m: f64,
    /// Radius at its start, metres; default: that at the end of the previous piece, for the first
    /// piece the backbone's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Radius at its end, metres; default: as at its start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_radius_m: Option<f64>,
    /// Radius of the bore at its start, metres; default: as for `radius_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inner_radius_m: Option<f64>,
    /// Radius of the bore at its end, metres; default: as at its start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_inner_radius_m: Option<f64>,
    /// Young's modulus E, Pa.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub youngs_modulus_pa: Option<f64>,
    /// Poisson's ratio.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poisson_ratio: Option<f64>,
    /// Density, kg/m³.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<f64>,
    /// Measured axial stiffness, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axial_stiffness_n: Option<f64>,
    /// Measured shear stiffness, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear_stiffness_n: Option<f64>,
    /// Measured bending stiffness, N m²; the mean of the two axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bending_stiffness_n_m2: Option<f64>,
    /// Measured torsional stiffness, N m².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsion_stiffness_n_m2: Option<f64>,
    /// (k₁ − k₂)/(k₁ + k₂) of the bending stiffnesses about the two principal axes.
    #[serde(default)]
    pub anisotropy: f64,
    /// Angle of the first (stiffer, where `anisotropy` is positive) principal axis from x towards
    /// y, degrees.
    #[serde(default)]
    pub principal_angle_deg: f64,
    /// Curvature about x and y and twist without load, rad/m. Tendon displacements are zero in this
    /// shape.
    #[serde(default)]
    pub rest_curvature_rad_m: [f64; 3],
}

/// Radii at the two ends of a piece.
struct Radii {
    outer: [f64; 2],
    inner: [f64; 2],
}

impl Backbone {
    /// Refuses numbers that make no backbone.
    pub(super) fn check(&self) -> Checked {
        let at = |result| at("backbone", result);
        at(BadOption::unless_positive("length_m", self.length_m))?;
        at(BadOption::unless_positive("radius_m", self.radius_m))?;
        at(bore("inner_radius_m", self.inner_radius_m, self.radius_m))?;
        at(BadOption::unless_positive("youngs_modulus_pa", self.youngs_modulus_pa))?;
        at(poisson(self.poisson_ratio))?;
        at(BadOption::unless_not_negative("density_kg_m3", self.density_kg_m3))?;
        at(BadOption::unless_positive_or_null("axial_stiffness_n", self.axial_stiffness_n))?;
        at(BadOption::unless_positive_or_null("shear_stiffness_n", self.shear_stiffness_n))?;
        at(BadOption::unless_positive_or_null(
            "bending_stiffness_n_m2",
            self.bending_stiffness_n_m2,
        ))?;
        at(BadOption::unless_positive_or_null(
            "torsion_stiffness_n_m2",
            self.torsion_stiffness_n_m2,
        ))?;
        let Some(last) = self.pieces.last() else { return Ok(()) };
        at(refuse(
            self.pieces.len() <= MAX_PARTS,
            "pieces",
            &self.pieces.len(),
            "a list of up to 10,000 pieces",
        ))?;
        let mut start_m = 0.0;
        for (index, (piece, radii)) in self.pieces.iter().zip(self.radii()).enumerate() {
            let path = format!("backbone.pieces[{index}]");
            piece.check(start_m, &radii).map_err(|error| (path, error))?;
            start_m = piece.end_m;
        }
        let complete = (last.end_m - self.length_m).abs() <= 1e-9 * self.length_m;
        let expected = "the last piece to end at the backbone's `length_m`";
        refuse(complete, "end_m", &last.end_m, expected)
            .map_err(|error| (format!("backbone.pieces[{}]", self.pieces.len() - 1), error))
    }

    /// Radii of the pieces.
    fn radii(&self) -> Vec<Radii> {
        let (mut outer, mut inner) = (self.radius_m, self.inner_radius_m);
        let piece = |piece: &Piece| {
            let ends = |start: &mut f64, from: Option<f64>, to: Option<f64>| {
                let from = from.unwrap_or(*start);
                *start = to.unwrap_or(from);
                [from, *start]
            };
            Radii {
                outer: ends(&mut outer, piece.radius_m, piece.end_radius_m),
                inner: ends(&mut inner, piece.inner_radius_m, piece.end_inner_radius_m),
            }
        };
        self.pieces.iter().map(piece).collect()
    }

    /// Radius at a distance from the base, metres.
    pub fn radius_at_m(&self, s_m: f64) -> f64 {
        let mut start_m = 0.0;
        for (piece, radii) in self.pieces.iter().zip(self.radii()) {
            if s_m <= piece.end_m {
                let share = (s_m - start_m) / (piece.end_m - start_m);
                return radii.outer[0] + share * (radii.outer[1] - radii.outer[0]);
            }
            start_m = piece.end_m;
        }
        self.radii().last().map_or(self.radius_m, |radii| radii.outer[1])
    }

    /// Cross-sections from base to tip.
    pub(super) fn spans(&self) -> Vec<Span> {
        if self.pieces.is_empty() {
            let radii = Radii { outer: [self.radius_m; 2], inner: [self.inner_radius_m; 2] };
            return vec![self.span(&Piece { end_m: self.length_m, ..Piece::default() }, &radii)];
        }
        let mut spans: Vec<Span> = self
            .pieces
            .iter()
            .zip(self.radii())
            .map(|(piece, radii)| self.span(piece, &radii))
            .collect();
        if let Some(last) = spans.last_mut() {
            last.end_m = self.length_m;
        }
        spans
    }

    /// Multiplies the bending stiffness all along by `scale`: Young's modulus, or what was measured
    /// in its place.
    pub(crate) fn scale_bending(&mut self, scale: f64) {
        let pieces = self.pieces.iter_mut();
        match &mut self.bending_stiffness_n_m2 {
            Some(measured) => {
                *measured *= scale;
                pieces.for_each(|piece| {
                    piece
                        .bending_stiffness_n_m2
                        .iter_mut()
                        .for_each(|stiffness| *stiffness *= scale)
                });
            }
            None => {
                self.youngs_modulus_pa *= scale;
                pieces.for_each(|piece| {
                    let stiffnesses = piece
                        .bending_stiffness_n_m2
                        .iter_mut()
                        .chain(piece.youngs_modulus_pa.iter_mut());
                    stiffnesses.for_each(|stiffness| *stiffness *= scale);
                });
            }
        }
    }

    /// A piece, with what it leaves out taken from the whole.
    fn span(&self, piece: &Piece, radii: &Radii) -> Span {
        let [area, second_moment] =
            [disc, second_moment_of_disc].map(|of| of(radii.outer[0]) - of(radii.inner[0]));
        let youngs_modulus_pa = piece.youngs_modulus_pa.unwrap_or(self.youngs_modulus_pa);
        let shear_modulus_pa =
            youngs_modulus_pa / (2.0 * (1.0 + piece.poisson_ratio.unwrap_or(self.poisson_ratio)));
        let measured = |of_piece: Option<f64>, of_backbone: Option<f64>, computed: f64| {
            of_piece.or(of_backbone).unwrap_or(computed)
        };
        let bending = measured(
            piece.bending_stiffness_n_m2,
            self.bending_stiffness_n_m2,
            youngs_modulus_pa * second_moment,
        );
        let rest = Vector3::from(piece.rest_curvature_rad_m);
        let uniform = radii.outer[0] == radii.outer[1] && radii.inner[0] == radii.inner[1];
        Span {
            end_m: piece.end_m,
            bending_n_m2: [bending * (1.0 + piece.anisotropy), bending * (1.0 - piece.anisotropy)],
            principal_angle_rad: piece.principal_angle_deg.to_radians(),
            // The polar moment of a round section is twice its second moment.
            torsion_n_m2: measured(
                piece.torsion_stiffness_n_m2,
                self.torsion_stiffness_n_m2,
                2.0 * shear_modulus_pa * second_moment,
            ),
            shear_n: measured(
                piece.shear_stiffness_n,
                self.shear_stiffness_n,
                shear_modulus_pa * area,
            ),
            axial_n: measured(
                piece.axial_stiffness_n,
                self.axial_stiffness_n,
                youngs_modulus_pa * area,
            ),
            rest_curvature_rad_m: rest,
            home_curvature_rad_m: rest,
            mass_kg_m: piece.density_kg_m3.unwrap_or(self.density_kg_m3) * area,
            spread_mass_kg_m: 0.0,
            taper: if uniform {
                Taper::NONE
            } else {
                Taper { outer: radii.outer, inner: radii.inner }
            },
        }
    }
}

impl Piece {
    fn check(&self, start_m: f64, radii: &Radii) -> Result<(), BadOption> {
        let ascends = self.end_m.is_finite() && self.end_m > start_m;
        refuse(ascends, "end_m", &self.end_m, "a place beyond the end of the piece before")?;
        for (end, (outer, inner)) in
            [(0, ("radius_m", "inner_radius_m")), (1, ("end_radius_m", "end_inner_radius_m"))]
        {
            BadOption::unless_positive(outer, radii.outer[end])?;
            bore(inner, radii.inner[end], radii.outer[end])?;
        }
        BadOption::unless_positive_or_null("youngs_modulus_pa", self.youngs_modulus_pa)?;
        self.poisson_ratio.map_or(Ok(()), poisson)?;
        self.density_kg_m3
            .map_or(Ok(()), |density| BadOption::unless_not_negative("density_kg_m3", density))?;
        BadOption::unless_positive_or_null("axial_stiffness_n", self.axial_stiffness_n)?;
        BadOption::unless_positive_or_null("shear_stiffness_n", self.shear_stiffness_n)?;
        BadOption::unless_positive_or_null("bending_stiffness_n_m2", self.bending_stiffness_n_m2)?;
        BadOption::unless_positive_or_null("torsion_stiffness_n_m2", self.torsion_stiffness_n_m2)?;
        let both_bend = self.anisotropy > -1.0 && self.anisotropy < 1.0;
        refuse(both_bend, "anisotropy", &self.anisotropy, "a number between -1 and 1")?;
        BadOption::unless_finite("principal_angle_deg", self.principal_angle_deg)?;
        BadOption::unless_all_finite("rest_curvature_rad_m", &self.rest_curvature_rad_m)
    }
}

fn disc(radius: f64) -> f64 {
    std::f64::consts::PI * radius * radius
}

fn second_moment_of_disc(radius: f64) -> f64 {
    0.25 * disc(radius) * radius * radius
}

fn poisson(ratio: f64) -> Result<(), BadOption> {
    within("poisson_ratio", ratio, -1.0, 0.5, "a number above -1 and up to 0.5")
}

fn bore(key: &'static str, inner: f64, outer: f64) -> Result<(), BadOption> {
    refuse(inner >= 0.0 && inner < outer, key, &inner, "a number from 0 to below the outer radius")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Robot;

    #[test]
    fn bending_is_scaled_wherever_it_comes_from() {
        let piece = |end_m, bending_stiffness_n_m2, youngs_modulus_pa| Piece {
            end_m,
            bending_stiffness_n_m2,
            youngs_modulus_pa,
            ..Piece::default()
        };
        let pieces = vec![
            piece(0.05, None, None),
            piece(0.1, Some(0.02), None),
            piece(0.22, None, Some(3e9)),
        ];
        for bending_stiffness_n_m2 in [None, Some(0.03)] {
            let mut robot = Robot::default();
            robot.backbone.pieces.clone_from(&pieces);
            robot.backbone.bending_stiffness_n_m2 = bending_stiffness_n_m2;
            let before = robot.rod();
            robot.backbone.scale_bending(1.3);
            for (span, old) in robot.rod().spans.iter().zip(&before.spans) {
                assert!(
                    (span.bending_n_m2[0] / old.bending_n_m2[0] - 1.3).abs() < 1e-12,
                    "{span:?}"
                );
            }
        }
    }
}
