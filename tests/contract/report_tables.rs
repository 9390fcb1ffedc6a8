//! Published rows: structs to CSV and back.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};
use spinebench::data::packed::csv_of;
use spinebench::data::{DataError, tables};
use spinebench::report::page::splice;
use spinebench::rows::experiment::{ClaimRow, GapRow, NetworkRow};
use spinebench::rows::table_descriptions;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Row {
    zeta: u64,
    alpha: f64,
    name: String,
    settled: bool,
    shift: i32,
    note: Option<f64>,
    #[serde(default)]
    since: String,
}

fn row(zeta: u64, alpha: f64) -> Row {
    Row {
        zeta,
        alpha,
        name: "a, \"b\"".to_owned(),
        settled: zeta.is_multiple_of(2),
        shift: -3,
        note: None,
        since: String::new(),
    }
}

#[test]
fn columns_stand_in_the_order_of_the_struct_and_numbers_are_rounded() {
    let bytes =
        tables::to_csv(Path::new("t.csv"), &[row(u64::MAX, 0.1 + 0.2), row(2, 1.0 / 3.0)]).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "zeta,alpha,name,settled,shift,note,since");
    assert_eq!(lines[1], "18446744073709551615,0.3,\"a, \"\"b\"\"\",false,-3,,");
    assert_eq!(lines[2], "2,0.333333333,\"a, \"\"b\"\"\",true,-3,,");
}

#[test]
fn rows_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep/rows.csv");
    let rows = vec![row(7, 0.25), Row { note: Some(1.5), ..row(8, -1e-7) }];
    tables::write_csv(&path, &rows).unwrap();
    assert_eq!(tables::read_csv::<Row>(&path).unwrap(), rows);

    let network = NetworkRow {
        seed: 1,
        training: "paper".to_owned(),
        network: "inverse".to_owned(),
        points: 10_000,
        epochs: 76,
        validation_mae_m: 0.0024,
        paper_mae_m: f64::NAN,
    };
    tables::write_csv(&path, std::slice::from_ref(&network)).unwrap();
    let back: Vec<NetworkRow> = tables::read_csv(&path).unwrap();
    assert!(back[0].paper_mae_m.is_nan() && back[0].validation_mae_m == network.validation_mae_m);
}

#[test]
fn faults_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rows.csv");
    let error = |text: &str| {
        fs::write(&path, text).unwrap();
        tables::read_csv::<Row>(&path).unwrap_err().to_string()
    };
    let header = "zeta,alpha,name,settled,shift,note\n";
    let found = error(&format!("{header}1,2,x,true,0,\n-1,2,x,true,0,\n"));
    assert!(
        found.contains("line 3, column `zeta`: found `-1`, expected 0 or a positive whole number"),
        "{found}"
    );
    let found = error(&format!("{header}1,2 mm,x,true,0,\n"));
    assert!(found.contains("line 2, column `alpha`: found `2 mm`, expected a number"), "{found}");
    let found = error("zeta,alpha,settled,shift,note\n1,2,true,0,\n");
    assert!(found.contains("column `name`: found only zeta, alpha"), "{found}");
    let found = error("zeta,alpha,name,settled,shift,note,more\n1,2,x,true,0,,1\n");
    assert!(found.contains("column `more`: found it, expected no such column"), "{found}");
    assert!(matches!(tables::write_csv::<Row>(&path, &[]), Err(DataError::Write { .. })));
    assert!(matches!(tables::to_csv(&path, &[(1, 2)]), Err(DataError::Write { .. })));
}

#[test]
fn tables_of_an_earlier_build_lack_what_has_a_default() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rows.csv");
    fs::write(&path, "zeta,alpha,name,settled,shift,note\n2,0.5,x,true,-3,\n").unwrap();
    let back: Vec<Row> = tables::read_csv(&path).unwrap();
    assert_eq!(back, [Row { name: "x".to_owned(), ..row(2, 0.5) }]);
}

#[test]
fn published_rows_are_flat() {
    let gap: Result<Vec<GapRow>, _> = tables::read_csv(Path::new("no such file.csv"));
    assert!(matches!(gap, Err(DataError::Read { .. })));
    let claim = ClaimRow {
        experiment: "table1".into(),
        claim: "c".to_owned(),
        statement: "words".to_owned(),
        quantity: "error of A".to_owned(),
        training: "paper".to_owned(),
        holds_above: f64::NAN,
        holds_below: 0.0,
        paper: 1.0,
        ours: 2.0,
        low_95: f64::NAN,
        high_95: f64::NAN,
        unit: "m".to_owned(),
        seeds: 1,
        verdict: "undecided".to_owned(),
    };
    let text = String::from_utf8(tables::to_csv(Path::new("c.csv"), &[claim]).unwrap()).unwrap();
    assert_eq!(
        text.lines().nth(1).unwrap(),
        "table1,c,words,error of A,paper,,0.0,1.0,2.0,,,m,1,undecided"
    );
}

/// `spinebench page docs/reference/outputs.md` writes them there.
#[test]
fn columns_are_documented_as_their_fields_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/reference/outputs.md")).unwrap();
    for table in table_descriptions() {
        assert!(
            table.columns().all(|column| !column.documentation.trim().is_empty()),
            "{}",
            table.name
        );
        assert!(
            table.key().all(|key| table.columns().any(|column| column.name == key)),
            "{}",
            table.name
        );
        assert!(page.contains(table.file), "{} is not in docs/reference/outputs.md", table.file);
        let marker = format!("columns:{}", table.name);
        if page.contains(&format!("begin:{marker}")) {
            assert_eq!(
                splice(&page, &marker, &table.markdown()).unwrap(),
                page,
                "run `spinebench page docs/reference/outputs.md`"
            );
        }
    }
}

#[test]
fn published_tables_have_these_columns_and_their_keys_tell_rows_apart() {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let mut seen = 0;
    for folder in fs::read_dir(results).unwrap().flatten().filter(|folder| folder.path().is_dir()) {
        for table in table_descriptions().filter(|table| table.file != "summary.csv") {
            let Ok(bytes) = csv_of(&folder.path().join(table.file)) else { continue };
            let text = String::from_utf8(bytes).unwrap();
            let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
            let columns: Vec<&str> = table.columns().map(|column| column.name).collect();
            // Older files lack columns that have a default by now; those of a sweep have the swept
            // fields before them.
            let swept = header.iter().filter(|name| name.contains('.')).count();
            assert!(
                header[swept..].iter().all(|name| columns.contains(name)),
                "{:?}: {header:?}",
                folder.path()
            );
            let own = table.key().filter_map(|key| header.iter().position(|name| *name == key));
            let key: Vec<usize> = (0..swept).chain(own).collect();
            assert_eq!(key.len(), swept + table.key().count(), "{:?}: {header:?}", folder.path());
            // Of plain tables: where a cell is quoted its row is passed over.
            let rows = text.lines().skip(1).filter(|line| !line.contains('"'));
            let keys: Vec<Vec<&str>> = rows
                .map(|line| line.split(',').collect())
                .map(|cells: Vec<&str>| key.iter().map(|&index| cells[index]).collect())
                .collect();
            let distinct: std::collections::HashSet<&Vec<&str>> = keys.iter().collect();
            assert_eq!(distinct.len(), keys.len(), "{:?}: {}", folder.path(), table.file);
            seen += 1;
        }
    }
    assert!(seen > 10);
}

#[test]
fn published_results_stay_light() {
    let git = Command::new("git")
        .args(["ls-files", "-z", "results"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output();
    // Elsewhere than in a repository nobody commits.
    let Some(files) = git.ok().filter(|output| output.status.success()) else { return };
    let files = String::from_utf8(files.stdout).unwrap();
    let sizes = files
        .split_terminator('\0')
        .filter_map(|file| fs::symlink_metadata(file).ok())
        .map(|file| file.len());
    let bytes: u64 = sizes.sum();
    assert!(bytes <= 20_000_000, "{bytes} bytes of results; `make pack`");
}

#[test]
fn rounding_keeps_what_is_not_a_number() {
    assert_eq!(tables::round_significant(123_456.789, 4), 123_500.0);
    assert_eq!(tables::round_significant(-0.000_123_456, 2), -0.000_12);
    assert_eq!(tables::round_significant(0.0, 3), 0.0);
    assert!(tables::round_significant(f64::NAN, 3).is_nan());
}
