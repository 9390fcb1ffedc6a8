//! Numbers that a model does not use, since others stand in their place.

use super::number::FitNumber;
use super::path::like;
use crate::calibration::error::CalibrationError;
use crate::effects::{Model, ModelParameter};

/// Keys, and those that take their place where a model has them.
const INSTEAD: &[(&str, &[&str])] = &[
    (
        "robot.backbone.youngs_modulus_pa",
        &[
            "robot.backbone.pieces[*].youngs_modulus_pa",
            "robot.backbone.pieces[*].bending_stiffness_n_m2",
            "robot.backbone.bending_stiffness_n_m2",
        ],
    ),
    ("robot.backbone.bending_stiffness_n_m2", &["robot.backbone.pieces[*].bending_stiffness_n_m2"]),
    ("robot.backbone.torsion_stiffness_n_m2", &["robot.backbone.pieces[*].torsion_stiffness_n_m2"]),
    ("robot.backbone.axial_stiffness_n", &["robot.backbone.pieces[*].axial_stiffness_n"]),
    ("robot.backbone.shear_stiffness_n", &["robot.backbone.pieces[*].shear_stiffness_n"]),
    ("robot.backbone.density_kg_m3", &["robot.backbone.pieces[*].density_kg_m3"]),
    ("robot.backbone.poisson_ratio", &["robot.backbone.pieces[*].poisson_ratio"]),
    ("robot.tendons.radius_m", &["robot.tendons.radii_m[*]", "robot.tendons.paths[*]*.x_m"]),
    ("robot.disks.mass_kg", &["robot.disks.masses_kg[*]"]),
];

/// Refuses a number whose change changes nothing in the model.
///
/// # Errors
/// [`CalibrationError::Idle`] says what stands in its place.
pub(crate) fn check(model: &Model, numbers: &[FitNumber]) -> Result<(), CalibrationError> {
    // Two rods with the same text are the same to the solver.
    let rod = format!("{:?}", model.rod(&[]));
    for number in numbers {
        let unused = |member: &ModelParameter| {
            let path = member.path();
            // What acts on commands and measurements is not in the rod.
            path.starts_with("robot.")
                && path != "robot.drive_time_s"
                && is_idle(model, member, &rod)
        };
        if number.members.iter().all(unused) {
            let path = number.members[0].path();
            let reason = instead(model, path).map_or_else(
                || "; other numbers replace it".to_owned(),
                |other| format!(": {other}"),
            );
            return Err(CalibrationError::Idle { name: number.name.clone(), reason });
        }
    }
    Ok(())
}

/// Whether the rod is the same with another value.
fn is_idle(model: &Model, member: &ModelParameter, rod: &str) -> bool {
    let (Ok(value), Ok(scale)) = (member.value(model), member.scale(model)) else { return false };
    // At the end of its range a number can only move one way.
    [0.01, -0.01].iter().all(|step| {
        let changed = member
            .with_value(model, value + step * scale)
            .ok()
            .filter(|changed| changed.check().is_ok());
        changed.is_none_or(|changed| format!("{:?}", changed.rod(&[])) == rod)
    })
}

/// What stands in the place of the number at `path`, as part of a sentence.
pub(crate) fn instead(model: &Model, path: &str) -> Option<String> {
    let (_, others) = INSTEAD.iter().find(|(key, _)| *key == path)?;
    let all = ModelParameter::all(model);
    let replacement =
        others.iter().find(|other| all.iter().any(|parameter| like(other, parameter.path())))?;
    Some(format!("this model uses `{replacement}` instead; fit `{replacement}`"))
}
