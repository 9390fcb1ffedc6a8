//! Columns of other people's tables, by name or number.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;

use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

use super::iso8601::{IsoTime, time_of_day_ns};
use super::map::RowConditions;
use super::units::{LengthUnit, TimeUnit};
use crate::data::DataError;
use crate::data::error::{listed, shown};

/// A column of a table: its name, or its number counted from 1.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(untagged)]
pub enum ColumnName {
    /// By the header, or the field of a message.
    Name(String),
    /// By its place.
    Number(usize),
}

impl fmt::Display for ColumnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ColumnName::Name(name) => write!(f, "`{name}`"),
            ColumnName::Number(number) => write!(f, "number {number}"),
        }
    }
}

impl<'de> Deserialize<'de> for ColumnName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<ColumnName, D::Error> {
        struct NameOrNumber;
        impl Visitor<'_> for NameOrNumber {
            type Value = ColumnName;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of a column, or its number from 1")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<ColumnName, E> {
                Ok(ColumnName::Name(name.to_owned()))
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<ColumnName, E> {
                match usize::try_from(number) {
                    Ok(number) if number > 0 => Ok(ColumnName::Number(number)),
                    _ => Err(E::invalid_value(de::Unexpected::Unsigned(number), &self)),
                }
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<ColumnName, E> {
                u64::try_from(number)
                    .map_err(|_| E::invalid_value(de::Unexpected::Signed(number), &self))
                    .and_then(|number| self.visit_u64(number))
            }
        }
        deserializer.deserialize_any(NameOrNumber)
    }
}

impl schemars::JsonSchema for ColumnName {
    fn schema_name() -> Cow<'static, str> {
        "ColumnName".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "A column: its name (of a topic: the path of a field), or its number \
                            counted from 1.",
            "anyOf": [{ "type": "string" }, { "type": "integer", "minimum": 1 }],
        })
    }
}

/// The cells of one column.
#[derive(Clone, Debug)]
pub(crate) enum LogCells {
    /// Text with `.` as its decimal sign.
    Text(Vec<String>),
    /// Numbers; not a number where there was none.
    Numbers(Vec<f64>),
    /// Times, nanoseconds.
    Nanoseconds(Vec<i64>),
}

/// A table of somebody's file: rows of a text file, or messages of a topic.
#[derive(Clone, Debug)]
pub(crate) struct LogTable {
    /// The file.
    pub(crate) file: PathBuf,
    /// Lines before the header, and comments, with their numbers.
    pub(crate) preamble: Vec<(usize, String)>,
    /// Units in the line after the header, one a column, with that line's number.
    pub(crate) units: Option<(usize, Vec<String>)>,
    /// Where the header stands: `line 3`, or the topic.
    pub(crate) header: String,
    /// Whether columns have names.
    pub(crate) named: bool,
    /// The columns.
    pub(crate) columns: Vec<(String, LogCells)>,
    /// Where each row stands: the number of its line or message.
    pub(crate) rows: Vec<usize>,
    /// What a row is called: `line`, or `/topic, message`.
    pub(crate) row_word: String,
    /// What the kind of message says, for a topic.
    pub(crate) topic: Option<TopicColumns>,
    /// The first row of the whole table, where these are some of its rows.
    pub(crate) first_of_all: Option<Box<LogTable>>,
}

/// Columns of a kind of message that need no map.
#[derive(Clone, Debug, Default)]
pub(crate) struct TopicColumns {
    /// The time.
    pub(crate) time: String,
    /// Prefix of a position's x, y and z, for messages with a pose.
    pub(crate) position: Option<String>,
    /// Prefix of an orientation's w, x, y and z.
    pub(crate) orientation: Option<String>,
}

impl LogTable {
    /// Place of a row, for messages.
    pub(crate) fn place(&self, row: usize) -> String {
        format!("{} {}", self.row_word, self.rows[row])
    }

    /// Whether this is a topic of a bag.
    pub(crate) fn is_topic(&self) -> bool {
        self.topic.is_some()
    }

    /// The column of a message's own time.
    pub(crate) fn own_time(&self) -> String {
        self.topic.as_ref().map_or(String::new(), |topic| topic.time.clone())
    }

    /// The columns of a message's own position and orientation (w, x, y, z).
    pub(crate) fn own_pose(&self) -> (Option<[ColumnName; 3]>, Option<[ColumnName; 4]>) {
        let part = |prefix: &str, axis: &str| {
            ColumnName::Name(if prefix.is_empty() {
                axis.to_owned()
            } else {
                format!("{prefix}.{axis}")
            })
        };
        let topic = self.topic.as_ref();
        let position = topic
            .and_then(|topic| topic.position.as_deref())
            .map(|prefix| ["x", "y", "z"].map(|axis| part(prefix, axis)));
        let orientation = topic.and_then(|topic| topic.orientation.as_deref());
        (position, orientation.map(|prefix| ["w", "x", "y", "z"].map(|axis| part(prefix, axis))))
    }

    /// The column that the key `key` of the map names.
    ///
    /// # Errors
    /// [`DataError::Line`] when there is no such column, or several.
    pub(crate) fn column(&self, name: &ColumnName, key: &str) -> Result<usize, DataError> {
        let refuse = |found: String| {
            let expected = if key.contains(' ') {
                format!("the column {name} of {key}")
            } else {
                format!("the column {name} that `{key}` of the map names")
            };
            Err(DataError::Line {
                file: self.file.clone(),
                place: self.header.clone(),
                found,
                expected,
            })
        };
        let all = || {
            let names = listed(self.columns.iter().map(|(name, _)| format!("`{name}`")));
            let hint = if self.columns.len() == 1 { " (is another delimiter used?)" } else { "" };
            format!("{names}{hint}")
        };
        match name {
            ColumnName::Number(number) if *number <= self.columns.len() => Ok(number - 1),
            ColumnName::Number(_) => refuse(format!("{} columns", self.columns.len())),
            ColumnName::Name(_) if !self.named => refuse("columns without names".to_owned()),
            ColumnName::Name(name) => {
                let mut fitting =
                    (0..self.columns.len()).filter(|&column| self.columns[column].0 == *name);
                match (fitting.next(), fitting.next()) {
                    (Some(column), None) => Ok(column),
                    (Some(_), Some(_)) => refuse("several columns of this name".to_owned()),
                    (None, _) => refuse(format!("only {}", all())),
                }
            }
        }
    }

    /// The rows that meet all conditions; all rows where there are none. `key`: the map's key of the
    /// conditions.
    ///
    /// # Errors
    /// [`DataError::Line`] when there are none, with what stands in the column.
    pub(crate) fn rows_where(
        &self,
        conditions: &RowConditions,
        key: &str,
    ) -> Result<Cow<'_, LogTable>, DataError> {
        let mut chosen: Vec<usize> = (0..self.rows.len()).collect();
        for (name, value) in conditions {
            let column = self.column(name, key)?;
            let before: BTreeSet<String> =
                chosen.iter().map(|&row| self.text(column, row).into_owned()).collect();
            chosen.retain(|&row| value.is_in(&self.text(column, row)));
            if chosen.is_empty() {
                return Err(DataError::Line {
                    file: self.file.clone(),
                    place: format!("column {name}"),
                    found: format!("only {}", listed(before.iter().map(|cell| shown(cell)))),
                    expected: format!("rows with {value}, as required by `{key}` of the map"),
                });
            }
        }
        if conditions.is_empty() {
            return Ok(Cow::Borrowed(self));
        }
        Ok(Cow::Owned(self.select(&chosen)))
    }

    /// Some of the rows.
    pub(crate) fn select(&self, rows: &[usize]) -> LogTable {
        let first = self.first_of_all.clone();
        let first_of_all = Some(first.unwrap_or_else(|| Box::new(self.copy(&[0]))));
        LogTable { first_of_all, ..self.copy(rows) }
    }

    fn copy(&self, rows: &[usize]) -> LogTable {
        fn of<T: Clone>(cells: &[T], rows: &[usize]) -> Vec<T> {
            rows.iter().map(|&row| cells[row].clone()).collect()
        }
        let columns = self.columns.iter().map(|(name, cells)| {
            let cells = match cells {
                LogCells::Text(cells) => LogCells::Text(of(cells, rows)),
                LogCells::Numbers(cells) => LogCells::Numbers(of(cells, rows)),
                LogCells::Nanoseconds(cells) => LogCells::Nanoseconds(of(cells, rows)),
            };
            (name.clone(), cells)
        });
        LogTable {
            file: self.file.clone(),
            preamble: self.preamble.clone(),
            units: self.units.clone(),
            header: self.header.clone(),
            named: self.named,
            columns: columns.collect(),
            rows: of(&self.rows, rows),
            row_word: self.row_word.clone(),
            topic: self.topic.clone(),
            first_of_all: None,
        }
    }

    /// The first number after `word` in the lines before the header: in its line, or in the next.
    ///
    /// # Errors
    /// [`DataError::Line`] when there is none above 0.
    pub(crate) fn number_in_preamble(&self, word: &str, key: &str) -> Result<f64, DataError> {
        let after_word = |line: usize| {
            let rest = after(&self.preamble[line].1, word)?;
            let next = self.preamble.get(line + 1).map_or("", |(_, text)| text.as_str());
            Some(first_number(rest).or_else(|| first_number(next)))
        };
        let found = (0..self.preamble.len()).find_map(after_word);
        match found {
            Some(Some(number)) if number.is_finite() && number > 0.0 => Ok(number),
            _ => Err(DataError::Line {
                file: self.file.clone(),
                place: format!("before the header in {}", self.header),
                found: match found {
                    None => format!("no word `{word}`"),
                    Some(None) => format!("no number after `{word}`"),
                    Some(Some(number)) => format!("{number} after `{word}`"),
                },
                expected: format!("the rate that `{key}` of the map names, a number above 0"),
            }),
        }
    }

    /// Refuses columns whose unit in the file is another than the map's, `units` in the words of
    /// files and `told` in that of the map.
    pub(crate) fn check_units(
        &self,
        columns: &[usize],
        units: &[&str],
        told: &str,
    ) -> Result<(), DataError> {
        let Some((line, written)) = &self.units else { return Ok(()) };
        for &column in columns {
            let unit = written[column].trim().trim_matches(['[', ']', '(', ')']);
            if !unit.is_empty() && !units.iter().any(|known| unit.eq_ignore_ascii_case(known)) {
                return Err(DataError::Cell {
                    file: self.file.clone(),
                    place: format!("line {line}"),
                    column: self.columns[column].0.clone(),
                    found: format!("the unit {}", shown(unit)),
                    expected: format!("{told} of the map"),
                });
            }
        }
        Ok(())
    }

    /// The columns that the key `key` of the map names; all that are missing are told at once.
    ///
    /// # Errors
    /// As [`LogTable::column`].
    pub(crate) fn find_all(
        &self,
        names: &[ColumnName],
        key: &str,
    ) -> Result<Vec<usize>, DataError> {
        let found: Vec<Result<usize, DataError>> =
            names.iter().map(|name| self.column(name, key)).collect();
        let missing = names.iter().zip(&found).filter(|(_, found)| found.is_err());
        let missing: Vec<String> = missing.map(|(name, _)| name.to_string()).collect();
        let first = found.into_iter().collect::<Result<Vec<usize>, DataError>>();
        match first {
            Err(DataError::Line { file, place, found, .. }) if missing.len() > 1 => {
                let expected =
                    format!("the columns {} that `{key}` of the map names", missing.join(", "));
                Err(DataError::Line { file, place, found, expected })
            }
            other => other,
        }
    }

    /// The column of this name. Errors as [`LogTable::column`].
    pub(crate) fn column_named(&self, name: &str) -> Result<usize, DataError> {
        self.column(&ColumnName::Name(name.to_owned()), "the format")
    }

    /// Metres in the unit that the file writes for a column.
    ///
    /// # Errors
    /// [`DataError::Cell`] for another text than a unit of length.
    pub(crate) fn length_unit_m(&self, column: usize) -> Result<f64, DataError> {
        let (line, written) =
            self.units.as_ref().map_or((0, ""), |(line, units)| (*line, units[column].as_str()));
        let unit = LengthUnit::ALL
            .into_iter()
            .find(|unit| unit.of_commands().spellings().contains(&written.trim()));
        unit.map(LengthUnit::metres).ok_or_else(|| DataError::Cell {
            file: self.file.clone(),
            place: format!("line {line}"),
            column: self.columns[column].0.clone(),
            found: format!("the unit {}", shown(written)),
            expected: "a unit of length: m, cm, mm, um or in".to_owned(),
        })
    }

    /// The text of a cell.
    pub(crate) fn text(&self, column: usize, row: usize) -> Cow<'_, str> {
        match &self.columns[column].1 {
            LogCells::Text(cells) => Cow::Borrowed(&cells[row]),
            LogCells::Numbers(cells) => Cow::Owned(cells[row].to_string()),
            LogCells::Nanoseconds(cells) => Cow::Owned(cells[row].to_string()),
        }
    }

    /// The number in a cell; none where it is empty or NaN.
    ///
    /// # Errors
    /// [`DataError::Cell`] when it is no finite number.
    pub(crate) fn number(&self, column: usize, row: usize) -> Result<Option<f64>, DataError> {
        let number = match &self.columns[column].1 {
            LogCells::Numbers(cells) => Some(cells[row]),
            LogCells::Nanoseconds(cells) => Some(cells[row] as f64),
            LogCells::Text(cells) => match cells[row].as_str() {
                "" => return Ok(None),
                text => text.parse::<f64>().ok(),
            },
        };
        match number {
            Some(number) if number.is_nan() => Ok(None),
            Some(number) if number.is_finite() => Ok(Some(number)),
            _ => Err(self.wrong(
                column,
                row,
                "a number (its decimal sign is `text.decimal` of the map)",
            )),
        }
    }

    /// The numbers of some columns in a row; none where one is missing. Errors as
    /// [`LogTable::number`].
    pub(crate) fn numbers<const N: usize>(
        &self,
        columns: &[usize; N],
        row: usize,
    ) -> Result<Option<[f64; N]>, DataError> {
        let mut numbers = [0.0; N];
        for (value, &column) in numbers.iter_mut().zip(columns) {
            let Some(number) = self.number(column, row)? else { return Ok(None) };
            *value = number;
        }
        Ok(Some(numbers))
    }

    /// The number in a cell that must hold one. Errors as [`LogTable::number`].
    pub(crate) fn finite(&self, column: usize, row: usize) -> Result<f64, DataError> {
        self.number(column, row)?.ok_or_else(|| self.wrong(column, row, "a number"))
    }

    /// The time in a cell, nanoseconds.
    ///
    /// # Errors
    /// [`DataError::Cell`] when it is no number.
    pub(crate) fn nanoseconds(
        &self,
        column: usize,
        row: usize,
        unit: TimeUnit,
    ) -> Result<i64, DataError> {
        let time = match &self.columns[column].1 {
            LogCells::Nanoseconds(cells) => Some(cells[row]),
            LogCells::Numbers(cells) => unit.nanoseconds(&format!("{:e}", cells[row])),
            LogCells::Text(cells) => unit.nanoseconds(&cells[row]),
        };
        time.ok_or_else(|| {
            let is_date = IsoTime::parse(&self.text(column, row)).is_some();
            let hint = if is_date {
                "`unit: iso8601` for dates"
            } else if time_of_day_ns(&self.text(column, row)).is_some() {
                "`unit: time_of_day` for times of day"
            } else if unit == TimeUnit::TimeOfDay {
                return self.wrong(column, row, "a time of day, such as 09:59:59.600");
            } else {
                "its decimal sign is `text.decimal` of the map"
            };
            self.wrong(column, row, format!("a time, a number ({hint})"))
        })
    }

    /// The date and time in a cell.
    ///
    /// # Errors
    /// [`DataError::Cell`] when it is none.
    pub(crate) fn iso_time(&self, column: usize, row: usize) -> Result<IsoTime, DataError> {
        let text = self.text(column, row);
        let expected = if time_of_day_ns(&text).is_some() {
            "a date and time, such as 2024-03-01T10:15:30.25+01:00 (`unit: time_of_day` for times \
             without a date)"
        } else {
            "a date and time, such as 2024-03-01T10:15:30.25+01:00"
        };
        IsoTime::parse(&text).ok_or_else(|| self.wrong(column, row, expected))
    }

    /// The error for a cell.
    pub(crate) fn wrong(
        &self,
        column: usize,
        row: usize,
        expected: impl Into<String>,
    ) -> DataError {
        self.wrong_as(column, row, None, expected)
    }

    /// As [`LogTable::wrong`], with what was found in place of the cell's text.
    pub(crate) fn wrong_as(
        &self,
        column: usize,
        row: usize,
        found: Option<String>,
        expected: impl Into<String>,
    ) -> DataError {
        let found = found.unwrap_or_else(|| shown(&self.text(column, row)));
        let (place, column) = (self.place(row), self.columns[column].0.clone());
        DataError::Cell { file: self.file.clone(), place, column, found, expected: expected.into() }
    }
}

/// What follows a word in a text, upper and lower case alike.
fn after<'a>(text: &'a str, word: &str) -> Option<&'a str> {
    let (lower, word) = (text.to_ascii_lowercase(), word.to_ascii_lowercase());
    let is_letter = |c: char| c.is_alphanumeric() || c == '_';
    lower.match_indices(&word).find_map(|(start, _)| {
        let rest = &text[start + word.len()..];
        let is_whole = !lower[..start].ends_with(is_letter) && !rest.starts_with(is_letter);
        is_whole.then_some(rest)
    })
}

/// The first number in a text.
fn first_number(text: &str) -> Option<f64> {
    let is_other = |c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E'));
    text.split(is_other).find_map(|part| part.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_found_after_a_whole_word() {
        let number = |text: &str, word: &str| after(text, word).map(first_number);
        assert_eq!(number("# Sample rate: 59.94Hz", "sample rate"), Some(Some(59.94)));
        assert_eq!(number("ANALOG_FREQUENCY\t1000", "FREQUENCY"), None);
        assert_eq!(number("FREQUENCY\t120\t1", "FREQUENCY"), Some(Some(120.0)));
        assert_eq!(number("rate fast", "rate"), Some(None));
    }
}
