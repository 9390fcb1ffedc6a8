//! The header rows of an export: the columns of each body.

use std::path::Path;

use super::ExportLine;
use super::meta::Rotation;
use crate::data::DataError;
use crate::data::csv::line_error;

/// Layout of the columns.
#[derive(Debug)]
pub(crate) struct ExportLayout {
    /// Number of cells in a row.
    pub(crate) width: usize,
    /// Column of the time.
    pub(crate) time: usize,
    /// Rigid bodies.
    pub(crate) bodies: Vec<BodyColumns>,
    /// Single markers.
    pub(crate) markers: Vec<BodyColumns>,
    /// Line of the names.
    pub(crate) names_line: usize,
}

/// Columns of a rigid body or a marker.
#[derive(Debug)]
pub(crate) struct BodyColumns {
    pub(crate) name: String,
    /// x, y, z.
    pub(crate) position: Vec<usize>,
    /// In the order of [`Rotation::parts`]; empty for a marker without orientation.
    pub(crate) rotation: Vec<usize>,
}

/// Header rows that describe the columns.
struct HeaderRows<'a> {
    kinds: &'a ExportLine<'a>,
    names: &'a ExportLine<'a>,
    ids: Option<&'a ExportLine<'a>>,
    quantities: &'a ExportLine<'a>,
    parts: &'a ExportLine<'a>,
}

/// Whether this is the last row of the header: `Frame,Time (Seconds),…`. A body may be called
/// `Frame` too.
pub(crate) fn is_last(line: &ExportLine) -> bool {
    let mut cells = (0..line.cells.len()).map(|index| line.cell(index).to_ascii_lowercase());
    cells.clone().any(|cell| cell == "frame") && cells.any(|cell| cell.starts_with("time"))
}

/// Reads the rows of the header, `rows` without empty ones, of which `parts` is the last.
pub(crate) fn layout(
    path: &Path,
    rows: &[ExportLine],
    parts: &ExportLine,
    rotation: Rotation,
) -> Result<ExportLayout, DataError> {
    let time = (0..parts.cells.len()).find(|&index| is_time(parts.cell(index)));
    let time = time.ok_or_else(|| {
        line_error(
            path,
            parts.number,
            "no column `Time (Seconds)`",
            "`Frame,Time (Seconds),X,Y,Z,…`",
        )
    })?;
    let header_rows = header_rows(path, rows, parts)?;
    let bodies = bodies(path, &header_rows, rotation)?;
    let markers = markers(&header_rows, rotation);
    if bodies.is_empty() && markers.is_empty() {
        let kinds = kinds(header_rows.kinds);
        let found = format!("only {kinds}, no column of a `Rigid Body` or a `Marker`");
        let expected = "rigid bodies or markers: enable them in the export";
        return Err(line_error(path, header_rows.kinds.number, found, expected));
    }
    let width = rows.iter().chain([parts]).map(|line| line.cells.len()).max().unwrap_or(0);
    Ok(ExportLayout { width, time, bodies, markers, names_line: header_rows.names.number })
}

fn is_time(cell: &str) -> bool {
    cell.eq_ignore_ascii_case("Time (Seconds)") || cell.eq_ignore_ascii_case("Time")
}

/// Some versions label the rows in a cell before the first number; others rely on their order.
fn header_rows<'a>(
    path: &Path,
    rows: &'a [ExportLine<'a>],
    parts: &'a ExportLine<'a>,
) -> Result<HeaderRows<'a>, DataError> {
    let leading: Vec<usize> = (0..parts.cells.len())
        .filter(|&index| {
            let cell = parts.cell(index).to_ascii_lowercase();
            cell == "frame" || cell.starts_with("time")
        })
        .collect();
    let labelled = |label: &str| {
        rows.iter()
            .find(|row| leading.iter().any(|&index| row.cell(index).eq_ignore_ascii_case(label)))
    };
    let [first, second, middle @ .., quantities] = rows else {
        let found = format!("{} rows between the first line and this one", rows.len());
        return Err(line_error(
            path,
            parts.number,
            found,
            "rows of types, names and `Rotation` or `Position`",
        ));
    };
    let any_label = ["Type", "Name", "ID"].iter().any(|label| labelled(label).is_some());
    if !any_label {
        return Ok(HeaderRows {
            kinds: first,
            names: second,
            ids: middle.first(),
            quantities,
            parts,
        });
    }
    let needed = |label: &str| {
        labelled(label).ok_or_else(|| {
            line_error(path, first.number, format!("no row `{label}`"), "rows `Type`, `Name`")
        })
    };
    Ok(HeaderRows {
        kinds: needed("Type")?,
        names: needed("Name")?,
        ids: labelled("ID"),
        quantities,
        parts,
    })
}

fn bodies(
    path: &Path,
    header_rows: &HeaderRows,
    rotation: Rotation,
) -> Result<Vec<BodyColumns>, DataError> {
    let places = |((name, _), columns): &((&str, &str), Vec<usize>)| {
        let find = |quantity, part| place(path, header_rows, name, columns, (quantity, part));
        Ok(BodyColumns {
            name: (*name).to_owned(),
            position: ["X", "Y", "Z"]
                .iter()
                .map(|part| find("Position", part))
                .collect::<Result<_, _>>()?,
            rotation: rotation
                .parts()
                .iter()
                .map(|part| find("Rotation", part))
                .collect::<Result<_, _>>()?,
        })
    };
    of_kind(header_rows, "Rigid Body").iter().map(places).collect()
}

/// Markers with one position; others are passed over.
fn markers(header_rows: &HeaderRows, rotation: Rotation) -> Vec<BodyColumns> {
    let places = |((name, _), columns): &((&str, &str), Vec<usize>)| {
        let all = |quantity: &str, parts: &[&str]| -> Option<Vec<usize>> {
            let only_column = |part: &&str| match matching(header_rows, columns, (quantity, part))[..]
            {
                [index] => Some(index),
                _ => None,
            };
            parts.iter().map(only_column).collect()
        };
        let position = all("Position", &["X", "Y", "Z"])?;
        let rotation = all("Rotation", rotation.parts()).unwrap_or_default();
        Some(BodyColumns { name: (*name).to_owned(), position, rotation })
    };
    of_kind(header_rows, "Marker").iter().filter_map(places).collect()
}

/// Columns of each asset of a kind. Assets of the same name are distinguished by their ID.
fn of_kind<'a>(header_rows: &HeaderRows<'a>, kind: &str) -> Vec<((&'a str, &'a str), Vec<usize>)> {
    let mut columns: Vec<((&str, &str), Vec<usize>)> = Vec::new();
    let fits = |index: &usize| header_rows.kinds.cell(*index).eq_ignore_ascii_case(kind);
    for index in (0..header_rows.kinds.cells.len()).filter(fits) {
        let key =
            (header_rows.names.cell(index), header_rows.ids.map_or("", |ids| ids.cell(index)));
        match columns.iter_mut().find(|(other, _)| *other == key) {
            Some((_, indices)) => indices.push(index),
            None => columns.push((key, vec![index])),
        }
    }
    columns
}

/// Those of `columns` that hold this part of this quantity.
fn matching(
    header_rows: &HeaderRows,
    columns: &[usize],
    (quantity, part): (&str, &str),
) -> Vec<usize> {
    let fits = |index: &usize| {
        header_rows.quantities.cell(*index).eq_ignore_ascii_case(quantity)
            && header_rows.parts.cell(*index).eq_ignore_ascii_case(part)
    };
    columns.iter().copied().filter(fits).collect()
}

/// The one column of a body that holds this part of this quantity.
fn place(
    path: &Path,
    header_rows: &HeaderRows,
    name: &str,
    columns: &[usize],
    (quantity, part): (&str, &str),
) -> Result<usize, DataError> {
    let indices = matching(header_rows, columns, (quantity, part));
    if let [index] = indices[..] {
        return Ok(index);
    }
    Err(DataError::Cell {
        file: path.to_owned(),
        place: format!("line {}", header_rows.parts.number),
        column: format!("{name} {quantity} {part}"),
        found: if indices.is_empty() {
            "no such column".to_owned()
        } else {
            format!("{} such columns", indices.len())
        },
        expected: "one for every rigid body".to_owned(),
    })
}

/// The kinds of columns that there are, for a message.
fn kinds(line: &ExportLine) -> String {
    let mut kinds: Vec<String> = Vec::new();
    for index in 0..line.cells.len() {
        let kind = format!("`{}`", line.cell(index));
        if !line.cell(index).is_empty()
            && !line.cell(index).eq_ignore_ascii_case("Type")
            && !kinds.contains(&kind)
        {
            kinds.push(kind);
        }
    }
    if kinds.is_empty() { "empty cells".to_owned() } else { kinds.join(", ") }
}
