//! The TSV export of Qualisys Track Manager: lines of `KEY<tab>VALUES`, perhaps a line of column
//! names, and the frames, of markers (`DATA_INCLUDED 3D`) or rigid bodies (`6D`). A body has x, y,
//! z, three angles, the residual and the rotation matrix column by column. Positions are in mm.

use std::path::Path;

use super::frames::{self, ExportColumns, OrientationCells, TableBodies};
use crate::data::import::Export;
use crate::data::import::mapped::{LogTable, TextFormat, parse_delimited};
use crate::data::{DataError, csv};

/// Columns of a rigid body.
const BODY_COLUMNS: usize = 16;
const MARKER_COLUMNS: usize = 3;
const EXPECTED: &str = "`MARKER_NAMES` or `BODY_NAMES`, as in the TSV export of Qualisys Track \
                        Manager";

/// Reads an export.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Export, DataError> {
    let text = csv::decode(path, bytes)?;
    let is_number = |cell: &str| cell.trim().parse::<f64>().is_ok();
    let is_key = |line: &&str| {
        let key = line.split('\t').next().unwrap_or_default();
        !key.is_empty()
            && key.chars().all(|c| c.is_ascii_uppercase() || c == '_' || c.is_ascii_digit())
            && !is_number(key)
    };
    let keys = text.lines().take_while(|line| is_key(line) || is_lower_key(line)).count();
    let next = text.lines().nth(keys).unwrap_or_default();
    let named = next.split('\t').any(|cell| !cell.trim().is_empty() && !is_number(cell));
    let format = TextFormat {
        delimiter: "\t".to_owned(),
        skip_lines: keys + usize::from(named),
        header: false,
        ..TextFormat::default()
    };
    let table = parse_delimited(path, bytes, &format)?;
    let value = |key: &str| {
        let mut lines = table.preamble.iter();
        lines.find_map(|(line, text)| Some((*line, text.strip_prefix(key)?.strip_prefix('\t')?)))
    };
    let has_bodies = value("BODY_NAMES").is_some();
    let Some((line, names)) = value("BODY_NAMES").or_else(|| value("MARKER_NAMES")) else {
        return Err(csv::line_error(path, 1, format!("the keys {}", listed(&table)), EXPECTED));
    };
    let names = names.split('\t').map(|name| name.trim().trim_matches('"'));
    let names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
    let width = if has_bodies { BODY_COLUMNS } else { MARKER_COLUMNS };
    let before = table.columns.len().checked_sub(width * names.len());
    // Frame and time stand before the bodies, or nothing does.
    let Some(before @ (0 | 2)) = before else {
        let found = format!("{} columns for {} names", table.columns.len(), names.len());
        let expected = format!("{width} per name, after `Frame` and `Time` if present");
        return Err(csv::line_error(path, table.rows[0], found, expected));
    };
    let rate_hz = table.number_in_preamble("FREQUENCY", "the header")?;
    let time_s = (0..table.rows.len()).map(|row| match before {
        0 => Ok(row as f64 / rate_hz),
        _ => table.finite(1, row),
    });
    let time_s = time_s.collect::<Result<Vec<f64>, DataError>>()?;
    let columns = names.iter().enumerate().map(|(place, name)| {
        let first = before + place * width;
        ExportColumns {
            name: (*name).to_owned(),
            position: std::array::from_fn(|axis| first + axis),
            unit_m: 1e-3,
            orientation: if has_bodies {
                // After the angles and the residual.
                OrientationCells::Matrix(std::array::from_fn(|element| first + 7 + element))
            } else {
                OrientationCells::None
            },
            status: None,
        }
    });
    let bodies = TableBodies { table: &table, time_s, columns: columns.collect() };
    let mut export = frames::export(&[bodies], format!("line {line}"))?;
    let promised = value("NO_OF_FRAMES").and_then(|(_, text)| text.trim().parse().ok());
    export.promised_frames = promised;
    Ok(export)
}

/// Lines of the header whose key is written otherwise.
fn is_lower_key(line: &&str) -> bool {
    ["EVENT", "TRAJECTORY_TYPES", "DESCRIPTION"].iter().any(|key| line.starts_with(key))
}

fn listed(table: &LogTable) -> String {
    let first = |text: &String| format!("`{}`", text.split('\t').next().unwrap_or_default());
    let keys: Vec<String> = table.preamble.iter().map(|(_, text)| first(text)).collect();
    if keys.is_empty() { "of none".to_owned() } else { keys.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_have_times_by_their_rate_or_by_their_column() {
        let head = "NO_OF_FRAMES\t3\nNO_OF_MARKERS\t2\nFREQUENCY\t50\nTIME_STAMP\t2020-01-22, \
                    17:47:17\t22107.9\nDATA_INCLUDED\t3D\nMARKER_NAMES\tbase\ttip\n";
        let rows = ["0\t0\t0\t1\t2\t200", "10\t0\t0\t1\t2\t201"];
        let plain = format!("{head}{}\n{}\n", rows[0], rows[1]);
        let export = parse(Path::new("q.tsv"), plain.as_bytes()).unwrap();
        assert_eq!((&export.time_s[..], export.promised_frames), (&[0.0, 0.02][..], Some(3)));
        let base = export.body("base").unwrap();
        assert_eq!((base.poses[0], base.poses[1].unwrap().position_m[0]), (None, 0.01));
        let named = format!(
            "{head}Frame\tTime\tbase X\tbase Y\tbase Z\ttip X\ttip Y\ttip Z\n7\t0.14\t{}\n8\t0.16\t{}\n",
            rows[0], rows[1]
        );
        let export = parse(Path::new("q.tsv"), named.as_bytes()).unwrap();
        assert_eq!(export.time_s, [0.14, 0.16]);
        assert_eq!(export.body("tip").unwrap().poses[1].unwrap().position_m, [1e-3, 2e-3, 0.201]);
    }

    #[test]
    fn the_matrix_of_a_body_stands_column_by_column() {
        // A turn by 0.3 rad about x: r32 = sin stands before r23 = -sin.
        let (sine, cosine) = 0.3_f64.sin_cos();
        let body = format!(
            "5\t6\t7\t17.2\t0\t0\t0.4\t1\t0\t0\t0\t{cosine}\t{sine}\t0\t{}\t{cosine}",
            -sine
        );
        let text = format!("FREQUENCY\t100\nDATA_INCLUDED\t6D\nBODY_NAMES\ttip\n{body}\n");
        let export = parse(Path::new("q.tsv"), text.as_bytes()).unwrap();
        let [w, x, y, z] = export.body("tip").unwrap().poses[0].unwrap().quaternion;
        assert!((w - 0.15_f64.cos()).abs() < 1e-12 && (x - 0.15_f64.sin()).abs() < 1e-12);
        assert!(y.abs() < 1e-12 && z.abs() < 1e-12);
        let said = |text: &str| parse(Path::new("q.tsv"), text.as_bytes()).unwrap_err().to_string();
        let bent = text.replace("7\t17.2\t0\t0\t0.4\t1\t", "7\t17.2\t0\t0\t0.4\t2\t");
        assert!(said(&bent).contains("nine elements of a rotation matrix"), "{}", said(&bent));
        let other = text.replace("BODY_NAMES", "BODIES");
        assert!(
            said(&other).contains("expected `MARKER_NAMES` or `BODY_NAMES`"),
            "{}",
            said(&other)
        );
        let narrow = "FREQUENCY\t100\nBODY_NAMES\ttip\n1\t2\t3\n";
        assert!(said(narrow).contains("3 columns for 1 names"), "{}", said(narrow));
    }
}
