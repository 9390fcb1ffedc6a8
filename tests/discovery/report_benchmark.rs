//! The blind benchmark's figures and tables.

use crate::support::report_rows::cases::cases;
#[allow(dead_code)]
use crate::support::text_overlap::assert_apart;
use spinebench::data::findings::CaseRow;
use spinebench::report::{Published, figure};

fn render(cases: Vec<CaseRow>) -> Vec<(String, Vec<u8>)> {
    let published = Published { cases, ..Published::default() };
    let files = (figure("discovery").unwrap().render)(&published).unwrap();
    files.into_iter().map(|file| (file.name, file.bytes)).collect()
}

fn text(files: &[(String, Vec<u8>)], name: &str) -> String {
    String::from_utf8(files.iter().find(|(known, _)| known == name).unwrap().1.clone()).unwrap()
}

/// The line of `summary.csv` of a measure over all cases: cases, value, low, high.
fn measured(csv: &str, measure: &str) -> Vec<f64> {
    let line = csv
        .lines()
        .find(|line| line.starts_with("all,") && line.contains(&format!("{measure},")))
        .unwrap();
    line.split(',').skip(2).take(4).map(|cell| cell.trim().parse().unwrap_or(f64::NAN)).collect()
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn shares_are_counted_from_the_cases() {
    let all = cases(2);
    let files = render(all.clone());
    let csv = text(&files, "summary.csv");
    let share = |about: &dyn Fn(&CaseRow) -> bool, holds: &dyn Fn(&CaseRow) -> bool| {
        let about: Vec<&CaseRow> = all.iter().filter(|case| about(case)).collect();
        [
            about.len() as f64,
            about.iter().filter(|case| holds(case)).count() as f64 / about.len() as f64,
        ]
    };
    let wide = |case: &CaseRow| case.group == "single" && case.shift_m >= 0.002;
    // More than stiffness is off, and a refit of it has been made.
    let refitted =
        |case: &CaseRow| case.truth != "bending_stiffness" && case.stiffness_only_m.is_finite();
    let catalogue = |case: &CaseRow| case.group == "single" || case.group == "pair";
    for (measure, expected) in [
        (
            "single effects of 2 mm and more named right",
            share(&wide, &|case| case.answer == case.truth),
        ),
        ("… or in the answer’s group", share(&wide, &|case| case.in_group)),
        (
            "pairs named exactly",
            share(&|case| case.group == "pair", &|case| case.answer == case.truth),
        ),
        (
            "false alarms",
            share(&|case| case.group == "nothing", &|case| case.verdict != "consistent"),
        ),
        (
            "unknown and outside the span: unexplained",
            share(&|case| case.group == "outside", &|case| case.verdict == "unexplained"),
        ),
        ("cases without an answer", share(&|_| true, &|case| case.verdict.starts_with("failed"))),
        (
            "better than a GP (any size)",
            share(&|case| catalogue(case) && case.gp_m.is_finite(), &|case| {
                case.after_m < case.gp_m
            }),
        ),
        (
            "better than a GP (2 mm and more)",
            share(
                &|case| catalogue(case) && case.gp_m.is_finite() && case.shift_m >= 0.002,
                &|case| case.after_m < case.gp_m,
            ),
        ),
        (
            "better than stiffness refitted (any size)",
            share(&|case| catalogue(case) && refitted(case), &|case| {
                case.after_m < case.stiffness_only_m
            }),
        ),
        (
            "better than stiffness refitted (2 mm and more)",
            share(&|case| catalogue(case) && refitted(case) && case.shift_m >= 0.002, &|case| {
                case.after_m < case.stiffness_only_m
            }),
        ),
    ] {
        let found = measured(&csv, measure);
        assert!(
            (found[0] - expected[0]).abs() < 0.5 && (found[1] - expected[1]).abs() < 1e-8,
            "{measure}: {found:?}"
        );
        assert!(
            found[2] <= found[1] && found[1] <= found[3] && found[3] - found[2] < 0.7,
            "{measure}: {found:?}"
        );
    }
    for better in csv.lines().filter(|line| line.contains(",better than")) {
        assert_eq!(better.contains("always"), better.contains("(2 mm and more)"), "{better}");
    }
    let covered: u64 = all.iter().map(|case| case.covered).sum();
    let found = measured(&csv, "95 % intervals that hold the truth");
    assert!((found[1] - covered as f64 / (2 * all.len()) as f64).abs() < 1e-8);
    for part in ["400 samples", "100 samples", "noise 0.5 mm", "noise 1 mm"] {
        assert!(csv.contains(part), "{part}");
    }
}

#[test]
fn the_confusion_matrix_holds_every_case_once() {
    let all = cases(1);
    let csv = text(&render(all.clone()), "confusion.csv");
    let total: u64 = csv
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(3).unwrap().parse::<u64>().unwrap())
        .sum();
    assert_eq!(total, all.len() as u64);
    let wrong = all
        .iter()
        .filter(|case| case.truth == "tip_load" && case.answer == "distributed_mass")
        .count();
    assert!(
        wrong == 0 || csv.contains(&format!("single,tip_load,distributed_mass,{wrong},0")),
        "{csv}"
    );
}

#[test]
fn the_same_cases_give_the_same_bytes() {
    let files = render(cases(2));
    assert!(files == render(cases(2)));
    // Left there to be looked at.
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("discovery").join("blind");
    std::fs::create_dir_all(&folder).unwrap();
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.join(name), bytes).unwrap());
}

#[test]
fn texts_stay_apart() {
    let one = |keep: usize| cases(1).into_iter().take(keep).collect::<Vec<_>>();
    let mut odd = cases(1);
    odd.iter_mut()
        .for_each(|case| case.truth = case.truth.replace("tip_load", &"wörter ".repeat(40)));
    for rows in [cases(3), cases(1), one(1), odd] {
        for (name, bytes) in render(rows).iter().filter(|(name, _)| name.ends_with(".svg")) {
            assert_apart(name, bytes);
        }
    }
}

#[test]
fn strange_cases_do_not_stop_it() {
    let mut rows = cases(1);
    for row in &mut rows {
        (row.shift_m, row.after_m, row.floor_m, row.strength_error) =
            (f64::NAN, f64::INFINITY, 0.0, f64::NAN);
        (row.intervals, row.covered) = (0, 0);
        row.verdict = "failed: <why>".to_owned();
    }
    rows[0].group = "something else".to_owned();
    let files = render(rows);
    let svg = text(&files, "discovery.svg");
    assert!(!svg.contains("<why"));
    let csv = text(&files, "summary.csv");
    assert!(!csv.contains("NaN") && !csv.contains("inf"), "{csv}");
    assert_eq!(measured(&csv, "cases without an answer")[1], 1.0);
}
