//! When each row of a table was.

use super::columns::{ColumnName, LogCells, LogTable};
use super::iso8601::zone_s;
use super::map::{FrameRate, TimeMap};
use super::units::TimeUnit;
use crate::data::DataError;

/// Nanoseconds in a second.
pub(crate) const NS: f64 = 1e9;
const DAY_NS: i64 = 86_400_000_000_000;

/// Times of all rows of a table.
pub(crate) struct Stamps {
    /// Their column, where they have one.
    column: Option<usize>,
    /// Nanoseconds.
    pub(crate) ns: Vec<i64>,
    /// Whether the times are dates, and then whether in a known zone.
    pub(crate) is_zoned: Option<bool>,
}

impl Stamps {
    /// Rows without times, one after another.
    pub(crate) fn of_rows(table: &LogTable, step_ns: i64) -> Stamps {
        let ns = (0..table.rows.len()).map(|row| row as i64 * step_ns).collect();
        Stamps { column: None, ns, is_zoned: None }
    }

    /// The error for the time of a row.
    pub(crate) fn wrong(
        &self,
        table: &LogTable,
        row: usize,
        found: Option<String>,
        expected: impl Into<String>,
    ) -> DataError {
        match self.column {
            Some(column) => table.wrong_as(column, row, found, expected),
            None => DataError::Line {
                file: table.file.clone(),
                place: table.place(row),
                found: found.unwrap_or_else(|| format!("{} s", self.ns[row] as f64 / NS)),
                expected: expected.into(),
            },
        }
    }
}

/// Reads the times of all rows; those of a topic without a map are the messages' own. `key`: the
/// map's key of these times.
///
/// # Errors
/// [`DataError`] names file, line and column.
pub(crate) fn stamps(
    table: &LogTable,
    time: Option<&TimeMap>,
    key: &str,
) -> Result<Stamps, DataError> {
    let topic_time = TimeMap {
        column: Some(ColumnName::Name(table.own_time())),
        unit: TimeUnit::Ns,
        ..TimeMap::default()
    };
    let time = time.unwrap_or(&topic_time);
    if let Some(rate) = &time.rate_hz {
        return frames(table, time, rate, key);
    }
    if !time.sum.is_empty() {
        return sum(table, time, key);
    }
    let name = time.column.clone().unwrap_or_else(|| ColumnName::Name(String::new()));
    let column = table.column(&name, &format!("{key}.column"))?;
    if time.unit == TimeUnit::Iso8601 {
        return dates(table, time, column);
    }
    let rows = 0..table.rows.len();
    let mut ns: Vec<i64> =
        rows.map(|row| table.nanoseconds(column, row, time.unit)).collect::<Result<_, _>>()?;
    if time.unit == TimeUnit::TimeOfDay {
        count_days(&mut ns);
    }
    check_set(table, column, &ns)?;
    Ok(Stamps { column: Some(column), ns, is_zoned: None })
}

/// Refuses the stamp 0 of a message, which is one that nobody has set.
fn check_set(table: &LogTable, column: usize, ns: &[i64]) -> Result<(), DataError> {
    let is_stamp = matches!(table.columns[column].1, LogCells::Nanoseconds(_));
    let unset = ns.iter().position(|stamp| *stamp == 0).filter(|_| is_stamp);
    unset.map_or(Ok(()), |row| {
        let expected = "a time other than 0; `time: {column: log_time}` in the map uses the time \
                        at which the message was recorded";
        Err(table.wrong(column, row, expected))
    })
}

/// Dates with their zones.
fn dates(table: &LogTable, time: &TimeMap, column: usize) -> Result<Stamps, DataError> {
    // The check of the map has read the zone.
    let map_zone_s = time.zone.as_deref().and_then(zone_s);
    let mut ns = Vec::with_capacity(table.rows.len());
    let mut all_zoned = None;
    for row in 0..table.rows.len() {
        let time_of_row = table.iso_time(column, row)?;
        let is_zoned = time_of_row.is_zoned() || map_zone_s.is_some();
        if *all_zoned.get_or_insert(is_zoned) != is_zoned {
            let with = if is_zoned { "without" } else { "with" };
            return Err(table.wrong(
                column,
                row,
                format!("a time {with} a zone, as in the previous rows, or `zone` in the map"),
            ));
        }
        let expected = "a date from 1678 to 2261";
        ns.push(
            time_of_row
                .utc_ns(map_zone_s.unwrap_or(0))
                .ok_or_else(|| table.wrong(column, row, expected))?,
        );
    }
    Ok(Stamps { column: Some(column), ns, is_zoned: all_zoned })
}

/// Sums of columns.
fn sum(table: &LogTable, time: &TimeMap, key: &str) -> Result<Stamps, DataError> {
    let mut ns = vec![0_i64; table.rows.len()];
    let mut first_column = None;
    for part in &time.sum {
        let column = table.column(&part.column, &format!("{key}.sum"))?;
        first_column.get_or_insert(column);
        for (row, total) in ns.iter_mut().enumerate() {
            let part_ns = table.nanoseconds(column, row, part.unit)?;
            *total = total
                .checked_add(part_ns)
                .ok_or_else(|| table.wrong(column, row, "a sum below 292 years"))?;
        }
    }
    if time.sum.iter().any(|part| part.unit.is_of_day()) {
        count_days(&mut ns);
    }
    Ok(Stamps { column: first_column, ns, is_zoned: None })
}

/// Adds a day wherever times go back by more than half of one, as they do at midnight.
fn count_days(ns: &mut [i64]) {
    let mut days_ns = 0;
    for row in 1..ns.len() {
        ns[row] += days_ns;
        if ns[row] < ns[row - 1] - DAY_NS / 2 {
            ns[row] += DAY_NS;
            days_ns += DAY_NS;
        }
    }
}

/// Frames at a rate, by their numbers or one after another.
fn frames(
    table: &LogTable,
    time: &TimeMap,
    rate: &FrameRate,
    key: &str,
) -> Result<Stamps, DataError> {
    let rate_hz = match rate {
        FrameRate::Hz(rate_hz) => *rate_hz,
        FrameRate::Word(word) => table.number_in_preamble(word, &format!("{key}.rate_hz"))?,
    };
    let column = time
        .column
        .as_ref()
        .map(|name| table.column(name, &format!("{key}.column")))
        .transpose()?;
    let number = |row: usize| match column {
        None => Ok(row as i64),
        Some(column) => match table.finite(column, row)? {
            number if number.fract() == 0.0 && number.abs() < 2f64.powi(53) => Ok(number as i64),
            _ => Err(table.wrong(column, row, "the number of a frame, a whole number")),
        },
    };
    let numbers = (0..table.rows.len()).map(number).collect::<Result<Vec<i64>, _>>()?;
    // Bodies and commands of one file count from the same frame, whichever rows are theirs.
    let first_of_all = table.first_of_all.as_ref().zip(column);
    let first_of_all = first_of_all.and_then(|(first, column)| first.finite(column, 0).ok());
    let first = time.first_frame.or(first_of_all.map(|number| number as i64));
    let first = first.or(numbers.first().copied()).unwrap_or(0);
    let ns = numbers.iter().map(|number| ((number - first) as f64 / rate_hz * NS).round() as i64);
    Ok(Stamps { column, ns: ns.collect(), is_zoned: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn midnight_adds_a_day_and_a_small_step_back_none() {
        let hour_ns = DAY_NS / 24;
        let mut ns = vec![23 * hour_ns, 23 * hour_ns + 5, 2, 1, 23 * hour_ns, 3];
        count_days(&mut ns);
        let day = |days: i64, ns: i64| days * DAY_NS + ns;
        let expected = vec![
            23 * hour_ns,
            23 * hour_ns + 5,
            day(1, 2),
            day(1, 1),
            day(1, 23 * hour_ns),
            day(2, 3),
        ];
        assert_eq!(ns, expected);
    }
}
