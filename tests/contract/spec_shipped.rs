//! The experiments that ship: they parse, what is resolved runs as it is, and their claims are the
//! paper's.

use spinebench::report::paper::printed::TABLE_1;
use spinebench::specs::{ClaimMetric, Experiment, Relation, reach_cells, to_yaml, track_cells};
use std::path::{Path, PathBuf};

fn shipped() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().flatten().map(|file| file.path()).collect();
    // Folders hold what is no experiment, such as the calibration's plant.
    files.retain(|file| file.is_file());
    files.sort();
    assert!(files.len() >= 6, "{files:?}");
    files
}

fn read(name: &str) -> Experiment {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments").join(name);
    Experiment::read(&file, &[]).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_shipped_spec_parses_and_its_resolved_form_is_the_same_experiment() {
    let folder = tempfile::tempdir().unwrap();
    for file in shipped() {
        let experiment = Experiment::read(&file, &[]).unwrap_or_else(|error| panic!("{error}"));
        let resolved = folder.path().join("spec.yaml");
        std::fs::write(&resolved, to_yaml(&experiment).unwrap()).unwrap();
        let again = Experiment::read(&resolved, &[])
            .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert_eq!(again, experiment, "{}", file.display());
        assert_eq!(
            Path::new(&experiment.name),
            Path::new(file.file_stem().unwrap()),
            "an experiment is named as its file"
        );
    }
}

#[test]
fn the_papers_cells_are_all_there_once() {
    let table = reach_cells(&read("table1.yaml"));
    assert_eq!(table.len(), TABLE_1.len(), "C has no open loop, everything else has three modes");
    for (policy, mode, _) in TABLE_1 {
        assert_eq!(
            table.iter().filter(|cell| cell.policy == policy && cell.mode == mode).count(),
            1,
            "{policy} {mode}"
        );
    }
    assert_eq!(reach_cells(&read("fig6.yaml")).len(), 2 * 7 + 2 * 7);
    assert_eq!(track_cells(&read("fig8.yaml")).len(), 4);
}

/// The claims on Table I's numbers say what the table says, with the tolerance that 50 targets
/// leave it.
#[test]
fn table_one_is_claimed_as_it_is_printed() {
    let experiment = read("table1.yaml");
    let t = 2.01; // Student's t, 95 %, 49 degrees of freedom
    for (policy, mode, printed) in TABLE_1 {
        let cases = [
            ("mean", printed.mean_m, printed.sd_m / 50f64.sqrt()),
            ("sd", printed.sd_m, printed.sd_m / 98f64.sqrt()),
        ];
        for (statistic, expected, error) in cases {
            let name = format!("table1_{policy}_{mode}_{statistic}");
            let claim = experiment
                .claims
                .iter()
                .find(|claim| claim.claim == name)
                .unwrap_or_else(|| panic!("{name}"));
            let Relation::Near { metric, figure, tolerance } = &claim.relation else {
                panic!("{name}")
            };
            let (ClaimMetric::ReachMean(cell) | ClaimMetric::ReachSd(cell)) = metric else {
                panic!("{name}")
            };
            assert_eq!((cell.policy.as_str(), cell.mode.as_str()), (policy, mode), "{name}");
            assert_eq!(matches!(metric, ClaimMetric::ReachMean(_)), statistic == "mean", "{name}");
            assert!(
                (figure - expected).abs() < 1e-9 && claim.paper == Some(*figure),
                "{name}: {figure}"
            );
            assert!(
                (tolerance - t * error).abs() < 1e-5,
                "{name}: {tolerance} against {}",
                t * error
            );
        }
    }
}
