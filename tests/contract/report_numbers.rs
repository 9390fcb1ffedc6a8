//! The numbers in tables and summaries, against values worked out by hand.

use crate::support::report_rows::{claims, gaps, published, table, tracks};
use spinebench::base::Outcome;
use spinebench::data::tables;
use spinebench::report::{
    FigureContext, Published, ReportError, figure, paper, reach_summary, track_summary,
};
use spinebench::rows::experiment::{GapSummaryRow, NetworkRow, ReachTrial, TrialRow};

fn file(figure_name: &str, rows: &Published, name: &str) -> String {
    let files = (figure(figure_name).unwrap().render)(rows).unwrap();
    let file = files.into_iter().find(|file| file.name == name).unwrap();
    String::from_utf8(file.bytes).unwrap()
}

/// Trials of policy A in closed loop with these errors: (seed, error).
fn trials(errors_m: &[(u64, f64)]) -> Vec<TrialRow> {
    let pattern = table(1)
        .into_iter()
        .find(|row| row.cell.policy == "a" && row.cell.mode == "closed")
        .unwrap();
    errors_m
        .iter()
        .map(|&(seed, error_m)| TrialRow {
            seed,
            value: ReachTrial { error_m, ..pattern.value.clone() },
            ..pattern.clone()
        })
        .collect()
}

#[test]
fn means_and_spreads_are_over_targets_within_seeds_and_intervals_over_seeds() {
    let row = &reach_summary(&trials(&[(0, 0.01), (0, 0.03), (1, 0.02), (1, 0.06)]))[0];
    assert!((row.mean_m - 0.03).abs() < 1e-15, "mean of 0.02 and 0.04");
    // Variances 2e-4 and 8e-4 within the seeds; their mean is 5e-4.
    assert!((row.sd_m - 5e-4f64.sqrt()).abs() < 1e-15);
    // Two means 0.02 apart: half of it is the standard error 0.01; t at 1 degree of freedom is
    // 12.7062.
    assert!((row.high_95_m - row.mean_m - 12.706_204_7 * 0.01).abs() < 1e-8);
    assert_eq!((row.seeds, row.trials, row.failed), (2, 4, 0));
    assert_eq!((row.paper_mean_m, row.paper_sd_m), (0.0151, 0.00859));
    let once = &reach_summary(&trials(&[(0, 0.01), (0, 0.03)]))[0];
    assert!(once.low_95_m.is_nan() && once.high_95_m.is_nan());
}

#[test]
fn failed_trials_are_counted_and_left_out() {
    let mut rows = trials(&[(0, 0.01), (0, 0.03), (0, f64::NAN)]);
    rows[2].status = Outcome::Failed("no_equilibrium".to_owned());
    let row = &reach_summary(&rows)[0];
    assert_eq!((row.trials, row.failed), (2, 1));
    assert!((row.mean_m - 0.02).abs() < 1e-15);
    let published = Published { trials: rows, ..Published::default() };
    assert!(file("table1", &published, "table1.md").contains("1 trials without an error value"));
}

#[test]
fn a_cell_never_mixes_sizes_of_data() {
    let mut rows = trials(&[(0, 0.01), (0, 0.03)]);
    rows[1].cell.gp_points = 200;
    let error =
        (figure("table1").unwrap().render)(&Published { trials: rows, ..Published::default() })
            .unwrap_err();
    assert!(matches!(error, ReportError::Mixed { .. }), "{error}");
}

#[test]
fn the_table_prints_as_the_paper_does() {
    let rows = Published { trials: table(2), ..Published::default() };
    let markdown = file("table1", &rows, "table1.md");
    let lines: Vec<&str> = markdown.lines().collect();
    assert_eq!(
        lines[0],
        "| Controller |  | Open-loop (m) | Closed-loop (m) | Closed-loop with load (m) |"
    );
    assert_eq!(
        lines[2],
        "| **A** | paper | 0.02640(0.01247) | 0.01510(0.00859) | 0.02962(0.01185) |"
    );
    assert_eq!(lines[8], "| **C** | paper | N/A | 0.01091(0.00461) | 0.02807(0.00961) |");
    assert!(lines[9].starts_with("|  | ours, networks stopped at the paper’s errors | N/A | 0.0"));
    assert_eq!(
        lines[11],
        "| **π<sub>real</sub>** | paper | 0.03186(0.01314) | 0.014987(0.00837) | 0.03279(0.01277) |"
    );
    let tex = file("table1", &rows, "table1.tex");
    assert!(tex.contains("C & N/A & 0.01091(0.00461) & 0.02807(0.00961) \\\\"), "{tex}");
    assert!(tex.is_ascii(), "LaTeX of any age reads it");
    assert_eq!(tex.matches("\\midrule").count(), 3);
}

#[test]
fn a_policy_for_closed_loop_only_is_not_applicable_in_open_loop() {
    let mut rows = trials(&[(0, 0.01), (0, 0.03)]);
    rows.iter_mut().for_each(|row| row.cell.policy = "mine".into());
    let outside =
        r#"{"mine": {"python": {"file": "m.py", "class": "M", "closed_loop_only": true}}}"#;
    let context = FigureContext {
        outside: serde_json::from_str(outside).unwrap(),
        ..FigureContext::default()
    };
    let ours = "ours, networks stopped at the paper’s errors";
    let table = |context: FigureContext| {
        let rows = Published { trials: rows.clone(), context, ..Published::default() };
        ["table1.md", "table1.tex"].map(|name| file("table1", &rows, name))
    };
    let [markdown, tex] = table(context);
    assert!(markdown.contains(&format!("| {ours} | N/A | 0.02000(0.01414) | – |")), "{markdown}");
    assert!(tex.contains("mine & N/A & 0.02000(0.01414) & -- "), "{tex}");
    let [markdown, _] = table(FigureContext::default());
    assert!(markdown.contains(&format!("| {ours} | – | 0.02000(0.01414) | – |")), "{markdown}");
}

#[test]
fn another_robots_table_has_no_line_of_the_paper() {
    let context = FigureContext { is_paper_robot: false, ..FigureContext::default() };
    let mut rows = Published { trials: table(2), context, ..Published::default() };
    let markdown = file("table1", &rows, "table1.md");
    assert!(!markdown.contains("| paper |") && !markdown.contains("0.01247"), "{markdown}");
    assert!(!file("table1", &rows, "table1.tex").contains("emph{paper}"));
    let summary = file("table1", &rows, "summary.csv");
    assert!(summary.lines().skip(1).all(|line| line.ends_with(",,")), "{summary}");
    // What ended before it reached the paper's errors was not stopped by them.
    rows.networks.push(NetworkRow {
        seed: 0,
        training: "paper".into(),
        network: "inverse".into(),
        points: 100,
        epochs: 6,
        validation_mae_m: 0.009,
        paper_mae_m: 0.0024,
    });
    let markdown = file("table1", &rows, "table1.md");
    assert!(
        markdown.contains("ours, networks that did not reach the paper’s errors"),
        "{markdown}"
    );
    assert!(!markdown.contains("stopped at"), "{markdown}");
}

#[test]
fn the_papers_table_has_no_open_loop_for_c() {
    assert_eq!(paper::printed::table_1("c", "open"), None);
    assert_eq!(paper::printed::TABLE_1.len(), 11);
}

#[test]
fn sweeps_have_the_papers_numbers_at_its_sizes_only() {
    let summary = reach_summary(&published("fig6", 1).trials);
    let with: Vec<(u64, u64)> = summary
        .iter()
        .filter(|row| row.paper_mean_m.is_finite())
        .map(|row| (row.cell.gp_points, row.cell.real_points))
        .collect();
    assert_eq!(
        with,
        [
            (100, 0),
            (100, 0),
            (0, 10_000),
            (0, 10_000),
            (100, 0),
            (100, 0),
            (0, 10_000),
            (0, 10_000)
        ]
    );
    let sizes: Vec<u64> = summary[..7].iter().map(|row| row.cell.gp_points).collect();
    assert_eq!(sizes, [50, 100, 200, 400, 600, 800, 1000]);
}

#[test]
fn the_gap_is_simulated_minus_real_along_each_axis() {
    let mut rows = gaps(2);
    for (row, shift_m) in rows.iter_mut().zip([0.003, -0.001]) {
        (row.gap.real_x_m, row.gap.real_y_m, row.gap.real_z_m) =
            (row.gap.sim_x_m - shift_m, row.gap.sim_y_m, row.gap.sim_z_m + 0.004);
    }
    let text = file("fig5", &Published { gaps: rows, ..Published::default() }, "summary.csv");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("summary.csv");
    std::fs::write(&path, text).unwrap();
    let summary: Vec<GapSummaryRow> = tables::read_csv(&path).unwrap();
    let near = |one: f64, other: f64| assert!((one - other).abs() < 1e-9, "{one} {other}");
    near(summary[0].mean_m, 0.001);
    near(summary[0].rms_m, 5e-6f64.sqrt());
    near(summary[0].max_m, 0.003);
    near(summary[2].mean_m, -0.004);
    near(summary[3].max_m, 0.005);
    assert_eq!(
        summary.iter().map(|row| row.axis.as_str()).collect::<Vec<_>>(),
        ["x", "y", "z", "distance"]
    );
}

#[test]
fn tracking_is_summarised_run_by_run() {
    let mut rows: Vec<_> =
        tracks(1).into_iter().filter(|row| row.policy == "c" && row.training == "paper").collect();
    for row in &mut rows {
        // A swing of ±2 mm about a slow drift, 1.25 s a period.
        row.sample.error_m = 0.01
            + 1e-5 * row.sample.step as f64
            + 0.002 * (0.8 * std::f64::consts::TAU * row.sample.time_s).sin();
        row.sample.branch = if row.sample.step < 100 { "a" } else { "b" }.to_owned();
    }
    for (index, row) in rows.iter_mut().enumerate() {
        row.sample.path_point = index as u64 / 10; // the first point is left after ten steps
    }
    let start_m = rows[9].sample.error_m;
    rows[300].sample.status = Outcome::Failed("lost".to_owned());
    rows.reverse();
    let summary = track_summary(&rows);
    assert_eq!(summary.len(), 1);
    assert_eq!(
        (summary[0].switches, summary[0].steps, summary[0].status.as_str()),
        (1, 980, "lost")
    );
    assert_eq!(
        (summary[0].start_error_m, summary[0].completion_time_s),
        (start_m, rows[0].sample.time_s)
    );
    assert!((summary[0].oscillation_m - 0.004).abs() < 1e-4, "{}", summary[0].oscillation_m);
}

#[test]
fn claims_are_told_in_words() {
    let text = file("claims", &Published { claims: claims(), ..Published::default() }, "claims.md");
    let line =
        "| < 0 mm | −4.10 mm | paper’s errors | −3.28 [−4.72, −1.85] mm | 10 | **reproduced** |";
    assert!(text.contains(line), "{text}");
    assert!(text.starts_with("Verdicts: 6 reproduced, 6 not reproduced, 6 undecided."), "{text}");
}
