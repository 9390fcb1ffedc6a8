//! Checks of a CSV before parsing: text, one header line, the same number of cells in every line. A
//! parser that repairs such faults silently would hide a damaged recording.

use std::borrow::Cow;
use std::path::Path;

use super::DataError;
use super::table::{Table, parse_csv};
use super::text::decode_text;

const EXPECTED_ROWS: &str = "a header line and at least one row";

/// Checks the text line by line, then parses it.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Table, DataError> {
    let text = decode(path, bytes)?;
    let text = text.trim_end_matches(['\n', '\r']);
    let mut lines = text.lines();
    let header = lines.next().filter(|header| !header.trim().is_empty());
    let Some(header) = header else {
        return Err(DataError::Empty {
            file: path.to_owned(),
            found: "no header",
            expected: EXPECTED_ROWS,
        });
    };
    let width = check_header(path, header)?;
    let mut rows = 0;
    for (index, line) in lines.enumerate() {
        check_line(path, index + 2, line, width)?;
        rows += 1;
    }
    if rows == 0 {
        return Err(DataError::Empty {
            file: path.to_owned(),
            found: "a header and no rows",
            expected: EXPECTED_ROWS,
        });
    }
    let parsed: Table = parse_csv(path, text)?;
    if parsed.rows != rows || parsed.columns.len() != width {
        let reason = format!(
            "{rows} lines of {width} cells were read as {} lines of {}",
            parsed.rows,
            parsed.columns.len()
        );
        return Err(DataError::Read { file: path.to_owned(), reason });
    }
    Ok(parsed)
}

/// The bytes as text, without a byte-order mark.
pub(super) fn decode<'a>(path: &Path, bytes: &'a [u8]) -> Result<Cow<'a, str>, DataError> {
    decode_text(bytes)
        .map_err(|(line, expected)| line_error(path, line, "bytes that are not text", expected))
}

/// Number of columns; each must have a name of its own.
fn check_header(path: &Path, header: &str) -> Result<usize, DataError> {
    let names = split(header).ok_or_else(|| unclosed(path, 1))?;
    for (index, name) in names.iter().enumerate() {
        let found = if name.trim().is_empty() {
            format!("no name for column {}", index + 1)
        } else if names[..index].contains(name) {
            "a second column of this name".to_owned()
        } else {
            continue;
        };
        let column = (*name).to_owned();
        return Err(DataError::Column {
            file: path.to_owned(),
            place: "line 1",
            column,
            found,
            expected: "one name per column".to_owned(),
        });
    }
    Ok(names.len())
}

fn check_line(path: &Path, number: usize, line: &str, width: usize) -> Result<(), DataError> {
    if line.trim().is_empty() {
        return Err(line_error(path, number, "an empty line", format!("{width} cells")));
    }
    let cells = split(line).ok_or_else(|| unclosed(path, number))?.len();
    if cells != width {
        return Err(line_error(
            path,
            number,
            format!("{cells} cells"),
            format!("{width} as in the header"),
        ));
    }
    Ok(())
}

/// The raw cells of a line; none when a quotation mark is not closed within it.
pub(super) fn split(line: &str) -> Option<Vec<&str>> {
    let mut cells = Vec::new();
    let (mut start, mut quoted) = (0, false);
    for (index, byte) in line.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b',' if !quoted => {
                cells.push(&line[start..index]);
                start = index + 1;
            }
            _ => {}
        }
    }
    cells.push(&line[start..]);
    (!quoted).then_some(cells)
}

/// The error for a line with an odd number of quotation marks.
pub(super) fn unclosed(path: &Path, number: usize) -> DataError {
    line_error(path, number, "a quotation mark that is not closed", "cells without line breaks")
}

/// The error for a line, counted from 1.
pub(super) fn line_error(
    path: &Path,
    number: usize,
    found: impl Into<String>,
    expected: impl Into<String>,
) -> DataError {
    let place = format!("line {number}");
    DataError::Line { file: path.to_owned(), place, found: found.into(), expected: expected.into() }
}
