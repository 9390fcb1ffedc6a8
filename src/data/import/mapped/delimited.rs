//! Text files of loggers.

use std::borrow::Cow;
use std::path::Path;

use super::columns::{LogCells, LogTable};
use super::map::TextFormat;
use crate::data::{DataError, csv, file};

/// Reads a text file: comments and the lines before the header are passed over, decimal signs
/// become `.`.
///
/// # Errors
/// [`DataError`] names file and line.
pub(crate) fn read(path: &Path, format: &TextFormat) -> Result<LogTable, DataError> {
    parse(path, &file::read(path)?, format)
}

fn parse(path: &Path, bytes: &[u8], format: &TextFormat) -> Result<LogTable, DataError> {
    let text = csv::decode(path, bytes)?;
    let is_comment = |line: &str| {
        line.trim().is_empty()
            || format
                .comment
                .as_ref()
                .is_some_and(|mark| line.trim_start().starts_with(mark.as_str()))
    };
    let lines =
        text.lines().enumerate().skip(format.skip_lines).filter(|(_, line)| !is_comment(line));
    let mut lines = lines.map(|(index, line)| split(path, index + 1, line, format)).peekable();
    let Some(first) = lines.peek() else {
        let expected = "a header and at least one row";
        return Err(DataError::Empty { file: path.to_owned(), found: "no such lines", expected });
    };
    let (header, mut names) = first.clone()?;
    if format.header {
        lines.next();
    } else {
        names = (1..=names.len()).map(|number| number.to_string()).collect();
    }
    let mut rows = Vec::new();
    let mut columns: Vec<Vec<String>> = vec![Vec::new(); names.len()];
    for line in lines {
        let (number, cells) = line?;
        // Loggers end rows with a delimiter.
        let filled = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        if cells.len() < names.len() || filled > names.len() {
            let hint = if format.decimal == format.delimiter {
                ""
            } else {
                " (see `text.delimiter` of the map)"
            };
            let expected = format!("{} as in line {header}{hint}", names.len());
            return Err(csv::line_error(path, number, format!("{} cells", cells.len()), expected));
        }
        rows.push(number);
        columns.iter_mut().zip(cells).for_each(|(column, cell)| column.push(cell));
    }
    if rows.is_empty() {
        let expected = "at least one row";
        return Err(DataError::Empty {
            file: path.to_owned(),
            found: "a header and no rows",
            expected,
        });
    }
    Ok(LogTable {
        file: path.to_owned(),
        header: format!("line {header}"),
        named: format.header,
        columns: names.into_iter().zip(columns.into_iter().map(LogCells::Text)).collect(),
        rows,
        row_word: "line".to_owned(),
        topic: None,
    })
}

/// Number of the line, and its cells without spaces and quotation marks around them.
fn split(
    path: &Path,
    number: usize,
    line: &str,
    format: &TextFormat,
) -> Result<(usize, Vec<String>), DataError> {
    let delimiter = format.delimiter.chars().next().unwrap_or(',');
    let cells: Vec<&str> = if delimiter == ' ' {
        line.split_whitespace().collect()
    } else {
        let mut quoted = false;
        let parts = line.split(|c| {
            quoted ^= c == '"';
            c == delimiter && !quoted
        });
        let cells = parts.collect();
        if quoted {
            return Err(csv::unclosed(path, number));
        }
        cells
    };
    let clean = |cell: &str| {
        let cell = cell.trim();
        let inner = cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        let cell =
            inner.map_or(Cow::Borrowed(cell), |inner| Cow::Owned(inner.replace("\"\"", "\"")));
        if format.decimal == "," && is_decimal(&cell) {
            cell.replace(',', ".")
        } else {
            cell.into_owned()
        }
    };
    Ok((number, cells.into_iter().map(clean).collect()))
}

/// A number with one decimal comma and no point.
fn is_decimal(cell: &str) -> bool {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, ',' | '+' | '-' | 'e' | 'E');
    cell.matches(',').count() == 1 && cell.chars().all(is_part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str, format: &TextFormat) -> Result<LogTable, String> {
        parse(Path::new("log.txt"), text.as_bytes(), format).map_err(|error| error.to_string())
    }

    #[test]
    fn a_spreadsheet_with_decimal_commas_and_comments_is_read() {
        let format = TextFormat {
            delimiter: ";".into(),
            decimal: ",".into(),
            comment: Some("#".into()),
            skip_lines: 1,
            ..TextFormat::default()
        };
        let text = "\u{feff}Logger 7; 3 axes\r\n# unit: mm\r\nt;\"a;b\";c\r\n0,5;-1,25e-1; x,y \
                    \r\n\r\n1;2;;\r\n";
        let table = table(text, &format).unwrap();
        let names: Vec<&str> = table.columns.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            (names, &table.rows[..], table.header.as_str()),
            (vec!["t", "a;b", "c"], &[4, 6][..], "line 3")
        );
        assert_eq!(
            (table.number(0, 0).unwrap(), table.number(1, 0).unwrap()),
            (Some(0.5), Some(-0.125))
        );
        assert_eq!((table.text(2, 0).as_ref(), table.number(2, 1).unwrap()), ("x,y", None));
        let said = table.number(2, 0).unwrap_err().to_string();
        assert_eq!(
            said,
            "log.txt, line 4, column `c`: found `x,y`, expected a number (its decimal sign is \
             `text.decimal` of the map)"
        );
    }

    #[test]
    fn spaces_and_no_header() {
        let format = TextFormat { delimiter: " ".into(), header: false, ..TextFormat::default() };
        let table = table("  1.0   2\t3\n4 5 6\n", &format).unwrap();
        assert_eq!(
            (table.number(2, 0).unwrap(), table.number(0, 1).unwrap()),
            (Some(3.0), Some(4.0))
        );
    }

    #[test]
    fn lines_of_another_width_are_refused_with_their_number() {
        let read = |text| table(text, &TextFormat::default()).unwrap_err();
        assert!(
            read("a,b\n1,2\n1\n")
                .starts_with("log.txt, line 3: found 1 cells, expected 2 as in line 1")
        );
        assert!(read("a,b\n1,2,3\n").starts_with("log.txt, line 2: found 3 cells"));
        assert!(read("a,\"b\n1,2\n").contains("line 1: found a quotation mark that is not closed"));
        assert!(read("a,b\n").contains("no rows") && read("\n\n").contains("no such lines"));
    }
}
