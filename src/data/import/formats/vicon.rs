//! The CSV export of Vicon Nexus and Tracker: blocks that a line with their name begins and an
//! empty line ends, each with its rate, the names of its bodies, those of its columns and a line of
//! units. Devices and model outputs are passed over.

use std::path::Path;

use super::frames::{self, ExportColumns, OrientationCells, TableBodies};
use crate::data::import::Export;
use crate::data::import::mapped::{LogTable, TextFormat, parse_delimited};
use crate::data::{DataError, csv};

/// Blocks that hold bodies or markers.
const BLOCKS: [&str; 6] =
    ["Objects", "Segments", "Trajectories", "Markers", "Labeled Trajectories", "Unlabeled Markers"];
const EXPECTED: &str = "a block `Objects`, `Segments` or `Trajectories` of Vicon's CSV export";

/// Reads an export.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Export, DataError> {
    let text = csv::decode(path, bytes)?;
    let firsts =
        text.lines().map(|line| line.split([',', '\t']).next().unwrap_or("").trim_matches('"'));
    let firsts: Vec<&str> = firsts.map(str::trim).collect();
    let is_tabs = text.lines().nth(2).is_some_and(|line| line.contains('\t'));
    let mut tables = Vec::new();
    for block in BLOCKS.into_iter().filter(|block| firsts.contains(block)) {
        let format = TextFormat {
            delimiter: if is_tabs { "\t" } else { "," }.to_owned(),
            block: Some(block.to_owned()),
            skip_lines: 1,
            header_lines: 2,
            units_line: true,
            ..TextFormat::default()
        };
        let table = parse_delimited(path, bytes, &format)?;
        let rate_hz = table.number_in_preamble(block, "the line after the name of a block")?;
        tables.push((table, rate_hz));
    }
    if tables.is_empty() {
        let found = firsts.iter().find(|first| !first.is_empty());
        let found = found.map_or("nothing".to_owned(), |first| format!("`{first}`"));
        return Err(csv::line_error(path, 1, found, EXPECTED));
    }
    let mut unread = Vec::new();
    let mut bodies = Vec::new();
    for (table, rate_hz) in &tables {
        let columns = bodies_of(table, &mut unread)?;
        bodies.push(TableBodies { table, time_s: times_s(table, *rate_hz)?, columns });
    }
    let place = tables.first().map(|(table, _)| table.header.clone()).unwrap_or_default();
    let mut export = frames::export(&bodies, place)?;
    export.unread_orientations = unread;
    Ok(export)
}

/// Times of the frames; frame 1 is at 0.
fn times_s(table: &LogTable, rate_hz: f64) -> Result<Vec<f64>, DataError> {
    let frame = table.column_named("Frame")?;
    (0..table.rows.len()).map(|row| Ok((table.finite(frame, row)? - 1.0) / rate_hz)).collect()
}

/// The bodies of a block: their columns are called `NAME TX`, or `NAME X` of a marker.
fn bodies_of(table: &LogTable, unread: &mut Vec<String>) -> Result<Vec<ExportColumns>, DataError> {
    let mut bodies = Vec::new();
    for (x, (name, _)) in table.columns.iter().enumerate() {
        let Some((body, axis)) = name.rsplit_once(' ') else { continue };
        let prefix = match axis {
            "TX" => "T",
            "X" => "",
            _ => continue,
        };
        let column = |axis: &str| {
            let name = format!("{body} {axis}");
            let mut later = table.columns.iter().enumerate();
            later.find(|(_, (known, _))| *known == name).map(|(place, _)| place)
        };
        let part = |axis: char| table.column_named(&format!("{body} {prefix}{axis}"));
        let position = [x, part('Y')?, part('Z')?];
        let rotation = ["RW", "RX", "RY", "RZ"].map(column);
        let orientation = match rotation {
            [Some(w), Some(x), Some(y), Some(z)] => OrientationCells::Quaternion([w, x, y, z]),
            [None, Some(_), ..] => {
                unread.push(body.to_owned());
                OrientationCells::None
            }
            _ => OrientationCells::None,
        };
        let unit_m = table.length_unit_m(x)?;
        bodies.push(ExportColumns {
            name: body.to_owned(),
            position,
            unit_m,
            orientation,
            status: None,
        });
    }
    Ok(bodies)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "Devices\n1000\n,,Force,\nFrame,Sub Frame,Fx,Fy\n,,N,N\n1,0,5,6\n1,1,5,6\n\n\
                        Objects\n100\n,,base:base,,,,,,,tip:tip,,,,,,\n\
                        Frame,Sub Frame,RX,RY,RZ,RW,TX,TY,TZ,RX,RY,RZ,RW,TX,TY,TZ\n\
                        ,,,,,,mm,mm,mm,,,,,mm,mm,mm\n\
                        11,0,0,0,0,1,10,20,5,0,0,0.6,0.8,30,20,225\n\
                        12,0,0,0,0,1,10,20,5,,,,,,,\n\n\
                        Trajectories\n100\n,,lab:m1,,\nFrame,Sub Frame,X,Y,Z\n,,m,m,m\n\
                        12,0,0.1,0.2,0.3\n13,0,,,\n";

    #[test]
    fn objects_and_markers_of_a_file_are_read_with_their_units() {
        let export = parse(Path::new("v.csv"), FILE.as_bytes()).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(export.time_s.iter().zip([0.1, 0.11, 0.12]).all(|(a, b)| close(*a, b)));
        let tip = export.body_like("tip").unwrap();
        let pose = tip.poses[0].unwrap();
        assert!(close(pose.position_m[2], 0.225) && pose.quaternion == [0.8, 0.0, 0.0, 0.6]);
        assert_eq!((tip.poses[1], tip.poses[2], tip.has_orientation), (None, None, true));
        let marker = export.body("lab:m1").unwrap();
        assert_eq!(marker.poses[1].unwrap().position_m, [0.1, 0.2, 0.3]);
        assert_eq!((marker.poses[0], marker.poses[2], marker.has_orientation), (None, None, false));
    }

    #[test]
    fn three_numbers_of_a_rotation_are_told_and_other_files_refused() {
        let angles = FILE.replace("RX,RY,RZ,RW,", "RX,RY,RZ,R,");
        let export = parse(Path::new("v.csv"), angles.as_bytes()).unwrap();
        assert_eq!(export.unread_orientations, ["base:base", "tip:tip"]);
        let said = |text: &str| parse(Path::new("v.csv"), text.as_bytes()).unwrap_err().to_string();
        assert!(said("Format Version,1.23\n").contains("found `Format Version`, expected a block"));
        let no_rate = FILE.replace("Objects\n100", "Objects\nfast");
        assert!(said(&no_rate).contains("no number after `Objects`"), "{}", said(&no_rate));
        let feet = FILE.replace("mm,mm,mm,,", "ft,mm,mm,,");
        assert!(said(&feet).contains("found the unit `ft`"), "{}", said(&feet));
    }
}
