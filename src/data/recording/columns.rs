//! The columns that a recording lacks, all of them at once: who mends a file by its errors mends it
//! once.

use std::collections::BTreeSet;

use super::read::{BASE, BASE_Q, Expected, FORCE, GRAVITY, MOMENT, TIP, TIP_Q, highest_tendon};
use super::{Actuation, drives, points};
use crate::data::DataError;
use crate::data::table::Table;

/// Most missing columns that are named.
const MAX_NAMED: usize = 12;

/// Refuses a table that lacks several columns; what lacks one is told by who reads the column.
pub(super) fn refuse_missing(table: &Table, expected: &Expected) -> Result<(), DataError> {
    let missing = missing(table, expected);
    let [first, _, ..] = missing.as_slice() else { return Ok(()) };
    let named: Vec<String> =
        missing.iter().take(MAX_NAMED).map(|name| format!("`{name}`")).collect();
    let further = missing.len().saturating_sub(MAX_NAMED);
    let further = if further > 0 { format!(" and {further} more") } else { String::new() };
    let expected = format!("the columns {}{further}", named.join(", "));
    Err(table.header_error(first, format!("only {}", table.header()), &expected))
}

/// The columns that are required, or belong to a group of which another one is there.
fn missing(table: &Table, expected: &Expected) -> Vec<String> {
    let names = table.columns.iter().map(|(name, _)| name.as_str());
    let points: BTreeSet<&str> = names.clone().filter_map(points::name_of).collect();
    let has = |name: &str| table.column(name).is_some();
    let some = |group: &[&str]| group.iter().any(|name| has(name));
    let mut wanted: Vec<String> = vec!["trial".to_owned(), "time_s".to_owned()];
    wanted.extend(commands(table, names.clone().any(|name| drives::drive_of(name).is_some())));
    let load = [FORCE, MOMENT].concat();
    let groups: [(&[&str], bool); 6] = [
        (&TIP, some(&TIP) || (expected.measured && points.is_empty())),
        (&TIP_Q, some(&TIP_Q)),
        (&BASE, some(&BASE) || some(&BASE_Q)),
        (&BASE_Q, has(BASE[0]) || some(&BASE_Q)),
        (&load, some(&load)),
        (&GRAVITY, some(&GRAVITY)),
    ];
    let needed = groups.iter().filter(|(_, is_needed)| *is_needed);
    wanted.extend(needed.flat_map(|(group, _)| group.iter().map(|name| (*name).to_owned())));
    wanted.extend(points.iter().flat_map(|point| points::columns(point, has)));
    wanted.retain(|name| !has(name));
    wanted
}

/// The columns of commands up to the highest tendon, if they are of one kind.
fn commands(table: &Table, has_drives: bool) -> Vec<String> {
    let [lengths, tensions] = [Actuation::Lengths, Actuation::Tensions]
        .map(|actuation| (highest_tendon(table, actuation), actuation));
    match (lengths, tensions) {
        ((0, _), (0, _)) if has_drives => Vec::new(),
        ((0, actuation), (0, _)) => vec![actuation.column(0)],
        ((tendons, actuation), (0, _)) | ((0, _), (tendons, actuation)) => {
            // The file may claim a tendon number of 10¹².
            let columns = (0..tendons).map(|tendon| actuation.column(tendon));
            columns.take(table.columns.len() + MAX_NAMED).collect()
        }
        _ => Vec::new(),
    }
}
