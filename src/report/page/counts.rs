//! Published values in the prose of a page, so that a sentence cannot contradict the table that it
//! is about. `<!-- count:FILE; COLUMN=VALUE; … -->48<!-- end -->` is the number of rows in which
//! every condition holds, and `<!-- cell:COLUMN of FILE; COLUMN=VALUE; … -->reproduced<!-- end -->`
//! the cell of the only such row.

use std::path::Path;

use crate::data::tables::{Beside, read_text_columns};

const COUNT: &str = "<!-- count:";
const CELL: &str = "<!-- cell:";
const CLOSE: &str = " -->";
const END: &str = "<!-- end -->";

/// `text` with every count and cell read again from the tables, whose names are relative to
/// `folder`.
///
/// # Errors
/// The marker and what is wrong with it, in words: no end, no such table or column, no condition,
/// not one row.
pub fn recounted(text: &str, folder: &Path) -> Result<String, String> {
    let counted = replaced(text, COUNT, |marker| {
        let (_, rows) = rows(marker, folder)?;
        Ok(rows.len().to_string())
    })?;
    replaced(&counted, CELL, |marker| cell(marker, folder))
}

/// `text` with what stands after each marker of a kind replaced.
fn replaced(
    text: &str,
    begin: &str,
    value: impl Fn(&str) -> Result<String, String>,
) -> Result<String, String> {
    let mut pieces = text.split(begin);
    let mut page = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let marker = piece.split(CLOSE).next().unwrap_or_default();
        let marker_error = |words: String| format!("{begin}{marker}{CLOSE}: {words}");
        let (_, rest) = piece
            .split_once(CLOSE)
            .ok_or_else(|| marker_error("found no end of the marker".into()))?;
        let (_, after) = rest.split_once(END).ok_or_else(|| {
            marker_error(format!("found no `{END}` after the marker, expected one"))
        })?;
        let value = value(marker).map_err(marker_error)?;
        page.push_str(&format!("{begin}{marker}{CLOSE}{value}{END}{after}"));
    }
    Ok(page)
}

/// The columns of the table that a marker names, and the numbers of the rows that meet its
/// conditions.
fn rows(marker: &str, folder: &Path) -> Result<(Vec<Beside>, Vec<usize>), String> {
    let mut parts = marker.split(';').map(str::trim);
    let file = parts.next().unwrap_or_default();
    let columns = read_text_columns(&folder.join(file)).map_err(|error| error.to_string())?;
    let conditions = parts
        .map(|part| RowCondition::parse(part, &columns))
        .collect::<Result<Vec<_>, String>>()?;
    let count = columns.first().map_or(0, |(_, cells)| cells.len());
    let holds = |row: &usize| conditions.iter().all(|condition| condition.holds(*row));
    let rows = (0..count).filter(holds).collect();
    Ok((columns, rows))
}

/// The cell of the column that a marker names first, in the only row that meets its conditions.
fn cell(marker: &str, folder: &Path) -> Result<String, String> {
    let (name, marker) = marker
        .split_once(" of ")
        .ok_or_else(|| "found no ` of `, expected COLUMN of FILE".to_owned())?;
    let (columns, rows) = rows(marker, folder)?;
    let [row] = rows[..] else {
        return Err(format!("found {} such rows, expected one", rows.len()));
    };
    let column = columns.iter().find(|(column, _)| column == name);
    let (_, cells) = column.ok_or_else(|| format!("found no column `{name}` in the table"))?;
    Ok(cells[row].clone())
}

/// A condition on a row.
struct RowCondition<'a> {
    cells: &'a [String],
    wanted: Wanted<'a>,
}

enum Wanted<'a> {
    /// This text, or one that begins so.
    Text(&'a str),
    Beginning(&'a str),
    AtLeast(f64),
}

impl<'a> RowCondition<'a> {
    /// `COLUMN=VALUE`, `COLUMN=BEGINNING*` or `COLUMN>=NUMBER`.
    fn parse(text: &'a str, columns: &'a [Beside]) -> Result<RowCondition<'a>, String> {
        let malformed = || {
            format!("found `{text}`, expected COLUMN=VALUE, COLUMN=BEGINNING* or COLUMN>=NUMBER")
        };
        let (name, wanted) = match text.split_once(">=") {
            Some((name, number)) => {
                (name, Wanted::AtLeast(number.parse().map_err(|_| malformed())?))
            }
            None => {
                let (name, value) = text.split_once('=').ok_or_else(malformed)?;
                (name, value.strip_suffix('*').map_or(Wanted::Text(value), Wanted::Beginning))
            }
        };
        let column = columns.iter().find(|(column, _)| column == name);
        let (_, cells) = column.ok_or_else(|| format!("found no column `{name}` in the table"))?;
        Ok(RowCondition { cells, wanted })
    }

    fn holds(&self, row: usize) -> bool {
        let cell = self.cells[row].as_str();
        match self.wanted {
            Wanted::Text(text) => cell == text,
            Wanted::Beginning(text) => cell.starts_with(text),
            Wanted::AtLeast(number) => cell.parse::<f64>().is_ok_and(|cell| cell >= number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_those_of_the_table_and_a_second_call_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let table =
            "claim,verdict,ours\na_1,reproduced,0.5\na_2,not reproduced,2\nb_1,reproduced,\n";
        std::fs::write(folder.path().join("t.csv"), table).unwrap();
        let page = "Of <!-- count:t.csv -->0<!-- end -->, <!-- count:t.csv; verdict=reproduced; \
                    claim=a_* -->9<!-- end --> hold; <!-- count:t.csv; ours>=0.5 --><!-- end -->, \
                    <!-- count:t.csv; verdict=not reproduced -->x<!-- end -->.";
        let once = recounted(page, folder.path()).unwrap();
        let plain: String =
            once.split("-->").map(|part| part.split("<!--").next().unwrap()).collect();
        assert_eq!(plain, "Of 3, 1 hold; 2, 1.");
        assert_eq!(recounted(&once, folder.path()).unwrap(), once);
        let cell = "it is <!-- cell:verdict of t.csv; claim=a_1 --><!-- end -->.";
        assert!(recounted(cell, folder.path()).unwrap().contains("-->reproduced<!--"));
        for bad in [
            "<!-- cell:verdict of t.csv -->1<!-- end -->",
            "<!-- cell:verdict -->1<!-- end -->",
            "<!-- count:t.csv -->1",
            "<!-- count:u.csv -->1<!-- end -->",
            "<!-- count:t.csv; x=1 -->1<!-- end -->",
        ] {
            assert!(recounted(bad, folder.path()).unwrap_err().starts_with("<!-- c"), "{bad}");
        }
    }
}
