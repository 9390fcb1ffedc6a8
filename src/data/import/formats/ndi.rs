//! The CSV of NDI's tools (Aurora, Polaris, Vega): a row a frame with the number of tools and, for
//! each tool, its name, frame, status, quaternion `Q0`…`Qz`, position `Tx`…`Tz` in mm and error.
//! The columns of a tool begin anew with each `Q0`. Lost tools have another status than `OK`.

use std::path::Path;

use super::frames::{self, ExportColumns, OrientationCells, TableBodies};
use crate::data::import::Export;
use crate::data::import::mapped::{LogTable, TextFormat, parse_delimited};
use crate::data::{DataError, csv};

/// What a tracked tool's status says.
const TRACKED: &[&str] =
    &["ok", "enabled", "partially out of volume", "partiallyoutofvolume", "valid"];
const EXPECTED: &str = "the columns `Q0`, `Qx`, `Qy`, `Qz`, `Tx`, `Ty`, `Tz` for each tool, as \
                        NDI's tools write them (for other columns: `import csv` with a map)";

/// Reads an export. `rate_hz`: of the frames, for a file without times.
pub(super) fn parse(path: &Path, bytes: &[u8], rate_hz: Option<f64>) -> Result<Export, DataError> {
    let text = csv::decode(path, bytes)?;
    let has_tool = |line: &str| line.split(',').any(|cell| cell.trim().eq_ignore_ascii_case("q0"));
    let Some(header) = text.lines().position(has_tool) else {
        return Err(csv::line_error(path, 1, "no column `Q0`", EXPECTED));
    };
    let format = TextFormat { skip_lines: header, ..TextFormat::default() };
    let table = parse_delimited(path, bytes, &format)?;
    let columns = tools(&table, header + 1)?;
    let time_s = times_s(&table, rate_hz)?;
    frames::export(&[TableBodies { table: &table, time_s, columns }], table.header.clone())
}

/// The columns of all tools.
fn tools(table: &LogTable, header: usize) -> Result<Vec<ExportColumns>, DataError> {
    let is = |column: usize, name: &str| {
        table.columns.get(column).is_some_and(|(known, _)| known.eq_ignore_ascii_case(name))
    };
    let starts: Vec<usize> = (0..table.columns.len()).filter(|&column| is(column, "Q0")).collect();
    let mut begin = 0;
    let mut tools: Vec<ExportColumns> = Vec::new();
    for q0 in starts {
        let names = ["Qx", "Qy", "Qz", "Tx", "Ty", "Tz"];
        if !names.iter().enumerate().all(|(place, name)| is(q0 + 1 + place, name)) {
            let found = format!("other columns after `Q0` (column {})", q0 + 1);
            return Err(csv::line_error(&table.file, header, found, EXPECTED));
        }
        let of_tool = begin..q0;
        let before = |names: &[&str]| {
            of_tool.clone().rev().find(|&column| {
                let known = table.columns[column].0.to_lowercase();
                names.iter().any(|name| known.starts_with(name))
            })
        };
        let name = name(table, before(&["porthandle", "port", "tool"]), tools.len() + 1);
        let twice = tools.iter().filter(|tool| tool.name == name).count();
        tools.push(ExportColumns {
            name: if twice == 0 { name } else { format!("{name} {}", tools.len() + 1) },
            position: std::array::from_fn(|axis| q0 + 4 + axis),
            unit_m: 1e-3,
            orientation: OrientationCells::Quaternion(std::array::from_fn(|part| q0 + part)),
            status: before(&["transformstatus", "state", "status"]).map(|column| (column, TRACKED)),
        });
        begin = q0 + 7;
    }
    Ok(tools)
}

/// The name of a tool: what stands in its rows, without what belongs to its serial number, or the
/// header, or its place.
fn name(table: &LogTable, column: Option<usize>, place: usize) -> String {
    let Some(column) = column else { return format!("tool {place}") };
    let cells = (0..table.rows.len()).map(|row| table.text(column, row).into_owned());
    let written = cells.into_iter().find(|cell| !cell.is_empty());
    let is_number = |text: &String| text.parse::<f64>().is_ok();
    match written {
        Some(cell) if !is_number(&cell) => cell,
        Some(number) => format!("{} {number}", table.columns[column].0),
        None => table.columns[column].0.clone(),
    }
}

/// Times of the rows: seconds and nanoseconds, or frames at a rate.
fn times_s(table: &LogTable, rate_hz: Option<f64>) -> Result<Vec<f64>, DataError> {
    let find = |name: &str| {
        table.columns.iter().position(|(known, _)| known.to_lowercase().starts_with(name))
    };
    let rows = 0..table.rows.len();
    if let Some((seconds, nanoseconds)) = find("timespec_s").zip(find("timespec_ns")) {
        let stamp = |row: usize| Ok((table.finite(seconds, row)?, table.finite(nanoseconds, row)?));
        let stamps = rows.map(stamp).collect::<Result<Vec<(f64, f64)>, DataError>>()?;
        let (first_s, first_ns) = stamps[0];
        let since = |(s, ns): &(f64, f64)| (s - first_s) + 1e-9 * (ns - first_ns);
        return Ok(stamps.iter().map(since).collect());
    }
    let refuse = |found: &str, expected: &str| {
        let (file, place) = (table.file.clone(), table.header.clone());
        let (found, expected) = (found.to_owned(), expected.to_owned());
        Err(DataError::Line { file, place, found, expected })
    };
    let Some(frame) = find("frame") else {
        return refuse("no column `Frame`", "a column `Frame` or `timespec_s` and `timespec_ns`");
    };
    let Some(rate_hz) = rate_hz else {
        return refuse("frames without a rate", "--rate-hz (40 for an Aurora, 60 for a Polaris)");
    };
    let first = table.finite(frame, 0)?;
    rows.map(|row| Ok((table.finite(frame, row)? - first) / rate_hz)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "#Tools,ToolInfo,Frame#,PortHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,Tx,Ty,Tz,\
                        Error,#Markers,ToolInfo,Frame#,PortHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,\
                        Tx,Ty,Tz,Error,#Markers\n\
                        2,a s/n:1,100,Port:0A,0,OK,1,0,0,0,1,2,3,0.1,0,b s/n:2,100,Port:0B,0,OK,0.8,\
                        0,0,0.6,4,5,6,0.1,0\n\
                        2,a s/n:1,104,Port:0A,0,OK,1,0,0,0,1,2,3,0.1,0,b s/n:2,104,Port:0B,0,\
                        Missing,,,,,,,,,0\n";

    #[test]
    fn tools_are_told_by_their_ports_and_lost_ones_by_their_status() {
        let export = parse(Path::new("n.csv"), FILE.as_bytes(), Some(40.0)).unwrap();
        assert_eq!(export.time_s, [0.0, 0.1]);
        let tip = export.body("Port:0B").unwrap();
        let pose = tip.poses[0].unwrap();
        assert_eq!(
            (pose.position_m, pose.quaternion),
            ([0.004, 0.005, 0.006], [0.8, 0.0, 0.0, 0.6])
        );
        assert_eq!((tip.poses[1], export.bodies.len()), (None, 2));
    }

    #[test]
    fn times_stand_in_the_file_or_come_from_the_rate() {
        let said =
            |text: &str| parse(Path::new("n.csv"), text.as_bytes(), None).unwrap_err().to_string();
        assert!(said(FILE).contains("found frames without a rate, expected --rate-hz"));
        assert!(said("a,b\n1,2\n").contains("no column `Q0`"));
        let timed = "Tools,ToolInfo,timespec_s,timespec_ns,Status,Q0,Qx,Qy,Qz,Tx,Ty,Tz\n\
                     1,a,1700000000,950000000,OK,1,0,0,0,1,2,3\n1,a,1700000001,0,OK,1,0,0,0,1,2,3\n";
        let export = parse(Path::new("n.csv"), timed.as_bytes(), None).unwrap();
        assert!((export.time_s[1] - 0.05).abs() < 1e-9, "{:?}", export.time_s);
    }
}
