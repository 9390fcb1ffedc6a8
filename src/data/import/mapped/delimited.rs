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

/// Reads the bytes of a file. Errors as [`read`].
pub(crate) fn parse(path: &Path, bytes: &[u8], format: &TextFormat) -> Result<LogTable, DataError> {
    let text = csv::decode(path, bytes)?;
    let mut lines = TableLines::new(path, &text, format)?;
    lines.pass_preamble();
    let Some(first) = lines.next() else {
        let expected = "a header and at least one row";
        return Err(DataError::Empty { file: path.to_owned(), found: "no such lines", expected });
    };
    let mut first = first?;
    let header = first.0;
    let mut data_line = None;
    if format.header {
        for _ in 1..format.header_lines {
            let lower = lines.next().transpose()?;
            first.1 = joined_names(first.1, lower.map(|(_, cells)| cells).unwrap_or_default());
        }
    } else {
        data_line = Some(first.clone());
        first.1 = (1..=first.1.len()).map(|number| number.to_string()).collect();
    }
    let names = first.1;
    let units = if format.units_line { lines.next().transpose()? } else { None };
    let preamble = std::mem::take(&mut lines.preamble);
    let mut rows = Vec::new();
    let mut columns: Vec<Vec<String>> = vec![Vec::new(); names.len()];
    for line in data_line.map(Ok).into_iter().chain(lines) {
        let (number, mut cells) = line?;
        // Loggers end rows with a delimiter, and spreadsheets cut empty cells off.
        let filled = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        if cells.len() < names.len() && format.block.is_none() || filled > names.len() {
            let hint = if format.decimal == format.delimiter {
                ""
            } else if format.comment.is_none() {
                " (see `text.delimiter` of the map; `text.comment` or `text.skip_lines` where lines \
                 before the table are not part of it; `text.block` for several tables)"
            } else {
                " (see `text.delimiter` of the map; `text.block` where the file has several tables)"
            };
            let expected = format!("{} as in line {header}{hint}", names.len());
            return Err(csv::line_error(path, number, format!("{} cells", cells.len()), expected));
        }
        cells.resize(names.len(), String::new());
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
    let units = units.map(|(number, mut cells)| {
        cells.resize(names.len(), String::new());
        (number, cells)
    });
    Ok(LogTable {
        file: path.to_owned(),
        preamble,
        units,
        header: format!("line {header}"),
        named: format.header,
        columns: names.into_iter().zip(columns.into_iter().map(LogCells::Text)).collect(),
        rows,
        row_word: "line".to_owned(),
        topic: None,
        first_of_all: None,
    })
}

/// A line with its number in the file, from 1, and its cells.
type NumberedLine = (usize, Vec<String>);

/// The lines of the table in a file.
struct TableLines<'a> {
    path: &'a Path,
    format: &'a TextFormat,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    /// The line that names the block, lines that are passed over, and comments.
    preamble: Vec<(usize, String)>,
}

impl<'a> TableLines<'a> {
    fn new(
        path: &'a Path,
        text: &'a str,
        format: &'a TextFormat,
    ) -> Result<TableLines<'a>, DataError> {
        let mut lines =
            TableLines { path, format, lines: text.lines().enumerate(), preamble: Vec::new() };
        let Some(name) = &format.block else { return Ok(lines) };
        let mut starts: Vec<String> = Vec::new();
        let mut is_start = true;
        while let Some((index, line)) = lines.lines.next() {
            let cells = split(path, index + 1, line, format)?.1;
            let first = cells.first().cloned().unwrap_or_default();
            if first == *name {
                lines.preamble.push((index + 1, line.to_owned()));
                return Ok(lines);
            }
            if is_start && !first.is_empty() {
                starts.push(format!("`{first}`"));
            }
            is_start = is_blank(&cells);
        }
        Err(DataError::Line {
            file: path.to_owned(),
            place: "all lines".to_owned(),
            found: format!("tables that begin with {}", starts.join(", ")),
            expected: format!(
                "a line that begins with `{name}`, as required by `text.block` of the map"
            ),
        })
    }

    /// Passes over the lines before the header.
    fn pass_preamble(&mut self) {
        let lines = self.lines.by_ref().take(self.format.skip_lines);
        self.preamble.extend(lines.map(|(index, line)| (index + 1, line.to_owned())));
    }
}

impl Iterator for TableLines<'_> {
    type Item = Result<NumberedLine, DataError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (index, line) = self.lines.next()?;
            let mark = self.format.comment.as_ref();
            if mark.is_some_and(|mark| line.trim_start().starts_with(mark.as_str())) {
                self.preamble.push((index + 1, line.to_owned()));
                continue;
            }
            let cells = split(self.path, index + 1, line, self.format);
            match &cells {
                Ok((_, cells)) if self.format.block.is_some() && is_blank(cells) => return None,
                _ if line.trim().is_empty() => continue,
                _ => return Some(cells),
            }
        }
    }
}

fn is_blank(cells: &[String]) -> bool {
    cells.iter().all(String::is_empty)
}

/// Names of two lines of a header: an upper name is that of the empty cells to its right, too.
fn joined_names(upper: Vec<String>, lower: Vec<String>) -> Vec<String> {
    let mut group = String::new();
    let mut names = Vec::new();
    for place in 0..upper.len().max(lower.len()) {
        if let Some(name) = upper.get(place).filter(|name| !name.is_empty()) {
            group.clone_from(name);
        }
        let lower = lower.get(place).map_or("", String::as_str);
        names.push(format!("{group} {lower}").trim().to_owned());
    }
    names
}

/// Number of the line, and its cells without spaces and quotation marks around them.
fn split(
    path: &Path,
    number: usize,
    line: &str,
    format: &TextFormat,
) -> Result<NumberedLine, DataError> {
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
        assert!(
            read("# a log\na,b\n1,2\n").contains("as in line 1 (see")
                && read("# a log\na,b\n1,2\n").contains("`text.comment`")
        );
        assert!(read("a,\"b\n1,2\n").contains("line 1: found a quotation mark that is not closed"));
        assert!(read("a,b\n").contains("no rows") && read("\n\n").contains("no such lines"));
    }
}
