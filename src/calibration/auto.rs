//! The groups of numbers that `--fit auto` tries, in the order in which a laboratory would.

use super::select::NumberGroup;
use crate::effects::{Model, PerTendon};

/// Groups for a robot at rest or in motion. What the model file leaves out is passed over.
pub(super) fn stages(model: &Model, at_rest: bool) -> Vec<NumberGroup> {
    let length_m = model.robot.backbone.length_m;
    let radius_m = model.robot.tendons.radius_m;
    let prior = |path: &str, deviation: f64| format!("{path}~{deviation}");
    let mut stages = vec![
        stage("pose of the base", &["robot.base_m[*]", "robot.base_rotation_rad[*]"]),
        stage("drive gains", &["drives.*.gains[*]"]),
        stage(
            "stiffness",
            &[
                "robot.backbone.youngs_modulus_pa",
                "robot.backbone.bending_stiffness_n_m2",
                "robot.backbone.pieces[*].youngs_modulus_pa",
                "robot.backbone.pieces[*].bending_stiffness_n_m2",
            ],
        ),
        stage("compliance of the sections", &["robot.sections.compliance_m_per_n"]),
        stage("pretension", &["robot.tendons.pretension_m", "robot.tendons.pretension_m[+]"]),
        stage(
            "compliance of the tendons",
            &["robot.tendons.compliance_m_per_n", "robot.tendons.compliance_m_per_n[+]"],
        ),
        stage(
            "pretension of each tendon",
            &[&prior("robot.tendons.pretension_m[*]", 0.01 * length_m)],
        )
        // One number for all must become a list before its entries can be named.
        .prepared(|model| {
            each(&mut model.robot.tendons.pretension_m, model.robot.tendons.angles_deg.len())
        }),
        stage("compliance of each tendon", &["robot.tendons.compliance_m_per_n[*]"]).prepared(
            |model| {
                each(
                    &mut model.robot.tendons.compliance_m_per_n,
                    model.robot.tendons.angles_deg.len(),
                )
            },
        ),
        // A weak prior keeps what the data hardly tell near the drawing: ten degrees, a tenth of
        // the distance.
        stage("turn of all holes", &["robot.tendons.angles_deg[+]"]),
        stage("angle of each hole", &[&prior("robot.tendons.angles_deg[*]", 10.0)]),
        stage("distance of the holes", &["robot.tendons.radius_m"]),
        stage("distance of each hole", &[&prior("robot.tendons.radii_m[*]", 0.1 * radius_m)])
            .prepared(|model| {
                let tendons = &mut model.robot.tendons;
                let radius_m = tendons.radius_m;
                tendons.radii_m.get_or_insert_with(|| vec![radius_m; tendons.angles_deg.len()]);
            }),
        stage(
            "place of the tracked points",
            &[
                &prior("tracking.points.*.offset_m[*]", 0.05 * length_m),
                &prior("tracking.points.*.s_m", 0.05 * length_m),
            ],
        ),
        stage(
            "torsional stiffness",
            &[
                "robot.backbone.torsion_stiffness_n_m2",
                "robot.backbone.pieces[*].torsion_stiffness_n_m2",
            ],
        ),
        stage("rest curvature", &["robot.backbone.pieces[*].rest_curvature_rad_m[*]"]),
        stage("anisotropy", &["robot.backbone.pieces[*].anisotropy"]),
        stage("mass", &["robot.backbone.density_kg_m3", "robot.disks.mass_kg"]),
        stage("gravity", &["robot.gravity_m_s2[*]~3"]),
        stage("effects", &["effects[*].*"]),
    ];
    if !at_rest {
        stages.push(stage("damping", &["robot.damping_time_s"]));
    }
    stages
}

fn stage(name: &str, entries: &[&str]) -> NumberGroup {
    let entries = entries.iter().map(|entry| (*entry).to_owned()).collect();
    NumberGroup { name: name.to_owned(), entries, prepare: |_| {} }
}

impl NumberGroup {
    /// The same, after writing keys into the model.
    fn prepared(self, prepare: fn(&mut Model)) -> NumberGroup {
        NumberGroup { prepare, ..self }
    }
}

/// Writes a number for all tendons as a list.
fn each(numbers: &mut PerTendon, count: usize) {
    *numbers = PerTendon::Each((0..count).map(|tendon| numbers.of(tendon)).collect());
}
