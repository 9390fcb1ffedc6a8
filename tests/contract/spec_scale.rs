//! Displacements and lengths of a spec follow the levers and the length of its robot.

use spinebench::specs::{Experiment, ExperimentSet};
use spinebench::tasks::PointLayout;
use std::path::Path;

/// Reads `text` as a spec of its own that extends a shipped one.
fn read(base: &str, text: &str) -> ExperimentSet {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("spec.yaml");
    let text = text.replace("MODELS", &root.join("models").display().to_string());
    let base = root.join("experiments").join(base);
    std::fs::write(&file, format!("extends: {}\nname: scaled\n{text}", base.display())).unwrap();
    ExperimentSet::read(&file, &[], &[]).unwrap_or_else(|error| panic!("{error}"))
}

const V4: &str = "model: {simulated: {model: MODELS/real/v4.yaml}}\n\
                  plant: {simulated: {model: MODELS/real/v4.yaml}}\n";

fn travels_m(spec: &Experiment) -> [f64; 4] {
    let points_m = match spec.gp_points.layout {
        PointLayout::Grid(grid) => grid.max_pull_m,
        PointLayout::Walk { max_pull_m, .. } => max_pull_m,
    };
    let (explore, sweep) = (&spec.explore, &spec.targets.sweep);
    [explore.max_pull_m, points_m, sweep.max_pull_m, spec.policies.limits.travel_m]
}

#[test]
fn the_papers_robot_keeps_its_numbers() {
    let set = read("paper.yaml", "");
    let spec = &set.experiment;
    assert_eq!(travels_m(spec), [0.03; 4]);
    assert_eq!(spec.explore.max_step_m, 0.003);
    assert_eq!(spec.policies.limits.max_step_m, Some(0.003));
    assert_eq!(spec.policies.mpc, Default::default());
    assert_eq!(spec.policies.model_integral, Default::default());
    assert_eq!(spec.policies.online_jacobian, Default::default());
    assert_eq!(spec.policies.a, Default::default());
    assert_eq!(spec.path, Default::default());
    assert_eq!(spec.targets, Default::default());
    assert!(set.notes.is_empty(), "{:?}", set.notes);
}

#[test]
fn a_robot_of_small_levers_gets_its_travel_from_them() {
    let set = read("paper.yaml", V4);
    let spec = &set.experiment;
    // 1.5 rad over the smallest lever, 3.9 mm.
    assert_eq!(travels_m(spec), [0.0058; 4]);
    assert_eq!(spec.policies.limits.max_step_m, Some(0.00058));
    assert_eq!(spec.policies.mpc.slack_m, 0.00058);
    // `paper.yaml` says 3 mm for its own robot.
    assert_eq!(spec.explore.max_step_m, 0.00058);
    let [note] = set.notes.as_slice() else { panic!("{:?}", set.notes) };
    assert!(note.contains("explore.max_step_m 0.00058"), "{note}");
    assert!(!note.contains("bend a segment"), "{note}");
}

#[test]
fn what_is_resolved_is_the_same_experiment() {
    let spec = read("smoke.yaml", V4).experiment;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("spec.yaml");
    std::fs::write(&file, spinebench::specs::to_yaml(&spec).unwrap()).unwrap();
    let again = ExperimentSet::read(&file, &[], &[]).unwrap();
    assert_eq!(again.experiment, spec);
    assert!(again.notes.is_empty(), "{:?}", again.notes);
}

#[test]
fn one_travel_holds_for_all_sections_that_say_none() {
    let spec =
        read("smoke.yaml", &format!("{V4}travel_m: 0.006\nexplore: {{max_pull_m: 0.004}}\n"));
    assert_eq!(travels_m(&spec.experiment), [0.004, 0.006, 0.006, 0.006]);
    assert_eq!(spec.experiment.explore.max_step_m, 0.0006);
    let nominal = read("smoke.yaml", "travel_m: 0.02\n").experiment;
    assert_eq!(travels_m(&nominal), [0.02; 4]);
    assert_eq!(nominal.policies.limits.max_step_m, Some(0.002));
}

#[test]
fn commands_that_bend_a_segment_far_are_noted() {
    let text = format!("{V4}travel_m: 0.03\n");
    let set = read("paper.yaml", &text);
    let note = set.notes.iter().find(|note| note.contains("bend a segment by up to 7.7 rad"));
    let note = note.unwrap_or_else(|| panic!("{:?}", set.notes));
    assert!(
        note.contains("policies.limits.travel_m") && note.contains("`travel_m: 0.0058`"),
        "{note}"
    );
}
