//! Published rows: structs to CSV and back.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use spinebench::data::rows::{ClaimRow, GapRow, NetworkRow};
use spinebench::data::{DataError, tables};

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
    let bytes = tables::to_csv(Path::new("t.csv"), &[row(u64::MAX, 0.1 + 0.2), row(2, 1.0 / 3.0)]).unwrap();
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
    assert!(found.contains("line 3, column `zeta`: found `-1`, expected 0 or a positive whole number"), "{found}");
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
        claim: "c".to_owned(),
        statement: "words".to_owned(),
        training: "paper".to_owned(),
        paper: 1.0,
        ours: 2.0,
        low_95: f64::NAN,
        high_95: f64::NAN,
        unit: "m".to_owned(),
        seeds: 1,
        verdict: "undecided".to_owned(),
    };
    let text = String::from_utf8(tables::to_csv(Path::new("c.csv"), &[claim]).unwrap()).unwrap();
    assert_eq!(text.lines().nth(1).unwrap(), "c,words,paper,1.0,2.0,,,m,1,undecided");
}

#[test]
fn rounding_keeps_what_is_not_a_number() {
    assert_eq!(tables::round_significant(123_456.789, 4), 123_500.0);
    assert_eq!(tables::round_significant(-0.000_123_456, 2), -0.000_12);
    assert_eq!(tables::round_significant(0.0, 3), 0.0);
    assert!(tables::round_significant(f64::NAN, 3).is_nan());
}
