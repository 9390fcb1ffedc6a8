//! The groups of numbers that `--fit auto` tries, in the order in which a laboratory would.

use super::select::NumberGroup;
use crate::effects::{EffectSpec, Model, PerTendon, Seek, card};

/// Effects with a memory, which are tried where the way back differs from the way out; the last
/// needs time.
const WITH_MEMORY: [&str; 4] = ["tendon_friction", "hysteresis", "backlash", "creep"];

/// Groups for a robot at rest or in motion, whose way back `differs` from the way out or does not.
/// What the model file leaves out is passed over.
pub(super) fn stages(model: &Model, at_rest: bool, differs: bool) -> Vec<NumberGroup> {
    let length_m = model.robot.backbone.length_m;
    let mut stages = vec![
        NumberGroup::new("pose of the base", &["robot.base_m[*]", "robot.base_rotation_rad[*]"]),
        NumberGroup::new("drive gains", &["drives.*.gains[*]"]),
        NumberGroup::new(
            "stiffness",
            &[
                "robot.backbone.youngs_modulus_pa",
                "robot.backbone.bending_stiffness_n_m2",
                "robot.backbone.pieces[*].youngs_modulus_pa",
                "robot.backbone.pieces[*].bending_stiffness_n_m2",
            ],
        ),
        NumberGroup::new("compliance of the sections", &["robot.sections.compliance_m_per_n"]),
    ];
    stages.extend(of_tendons(model));
    stages.extend([
        NumberGroup::new(
            "place of the tracked points",
            &[
                &prior("tracking.points.*.offset_m[*]", 0.05 * length_m),
                &prior("tracking.points.*.s_m", 0.05 * length_m),
            ],
        ),
        NumberGroup::new(
            "torsional stiffness",
            &[
                "robot.backbone.torsion_stiffness_n_m2",
                "robot.backbone.pieces[*].torsion_stiffness_n_m2",
            ],
        ),
        NumberGroup::new("rest curvature", &["robot.backbone.pieces[*].rest_curvature_rad_m[*]"]),
        NumberGroup::new("anisotropy", &["robot.backbone.pieces[*].anisotropy"]),
        NumberGroup::new("mass", &["robot.backbone.density_kg_m3", "robot.disks.mass_kg"]),
        NumberGroup::new("gravity", &["robot.gravity_m_s2[*]~3"]),
        NumberGroup::new("effects", &["effects[*].*"]),
    ]);
    stages.extend(in_time_or_with_memory(at_rest, differs));
    stages
}

/// An entry with a prior.
fn prior(path: &str, deviation: f64) -> String {
    format!("{path}~{deviation}")
}

/// Groups of the tendons and their holes.
fn of_tendons(model: &Model) -> Vec<NumberGroup> {
    let length_m = model.robot.backbone.length_m;
    let radius_m = model.robot.tendons.radius_m;
    vec![
        NumberGroup::new(
            "pretension",
            &["robot.tendons.pretension_m", "robot.tendons.pretension_m[+]"],
        ),
        NumberGroup::new(
            "compliance of the tendons",
            &["robot.tendons.compliance_m_per_n", "robot.tendons.compliance_m_per_n[+]"],
        ),
        NumberGroup::new(
            "pretension of each tendon",
            &[&prior("robot.tendons.pretension_m[*]", 0.01 * length_m)],
        )
        // One number for all must become a list before its entries can be named.
        .after(|model| {
            each(&mut model.robot.tendons.pretension_m, model.robot.tendons.angles_deg.len())
        }),
        NumberGroup::new("compliance of each tendon", &["robot.tendons.compliance_m_per_n[*]"])
            .after(|model| {
                each(
                    &mut model.robot.tendons.compliance_m_per_n,
                    model.robot.tendons.angles_deg.len(),
                )
            }),
        // A weak prior keeps what the data hardly tell near the drawing: ten degrees, a tenth of
        // the distance.
        NumberGroup::new("turn of all holes", &["robot.tendons.angles_deg[+]"]),
        NumberGroup::new("angle of each hole", &[&prior("robot.tendons.angles_deg[*]", 10.0)]),
        NumberGroup::new("distance of the holes", &["robot.tendons.radius_m"]),
        NumberGroup::new(
            "distance of each hole",
            &[&prior("robot.tendons.radii_m[*]", 0.1 * radius_m)],
        )
        .after(|model| {
            let tendons = &mut model.robot.tendons;
            let radius_m = tendons.radius_m;
            tendons.radii_m.get_or_insert_with(|| vec![radius_m; tendons.angles_deg.len()]);
        }),
    ]
}

/// What a pose at rest says nothing of, and effects with a memory.
fn in_time_or_with_memory(at_rest: bool, differs: bool) -> Vec<NumberGroup> {
    let memory = if at_rest { &WITH_MEMORY[..3] } else { &WITH_MEMORY };
    let memory = memory.iter().filter(|_| differs);
    let mut stages: Vec<NumberGroup> =
        memory.filter_map(|name| NumberGroup::of_effect(name)).collect();
    if !at_rest {
        stages.push(NumberGroup::new("damping", &["robot.damping_time_s"]));
    }
    stages
}

impl NumberGroup {
    /// The same, after writing keys into the model.
    fn after(self, prepare: fn(&mut Model)) -> NumberGroup {
        NumberGroup { prepare, ..self }
    }

    /// The numbers of an effect of the catalogue, from the first values that a search would try.
    fn of_effect(name: &str) -> Option<NumberGroup> {
        let card = card(name)?;
        let first = card.parameters.iter().map(|parameter| match parameter.seek {
            Seek::Size(step) => step,
            Seek::Shape(values) => values[0],
            _ => parameter.null,
        });
        let effect = EffectSpec::from_card(card, &first.collect::<Vec<_>>());
        let numbers = NumberGroup::new(&name.replace('_', " "), &[&format!("effects[*].{name}.*")]);
        Some(NumberGroup { effect, ..numbers })
    }
}

/// Writes a number for all tendons as a list.
fn each(numbers: &mut PerTendon, count: usize) {
    *numbers = PerTendon::Each((0..count).map(|tendon| numbers.of(tendon)).collect());
}
