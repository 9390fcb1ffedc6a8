//! The tables of two runs, value by value. Rows are matched by the columns that tell them apart, so
//! that runs with other numbers of repetitions can be compared.

use super::compare::is_close;
use super::provenance::first_parting;
use crate::data::DataError;
use crate::data::tables::{Beside, read_csv, read_text_columns};
use crate::rows::experiment::StageRow;
use crate::rows::table_descriptions;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// Columns that differ from run to run.
const CLOCKS: [&str; 2] = ["wall_s", "cpu_s"];
/// In the place of a value: this run alone has the table, row or column.
const THERE: &str = "there";
/// The trail of a run, which is compared stage by stage.
const TRAIL: &str = "stages";

/// A value that differs between two runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunDifference {
    /// The experiment.
    pub experiment: String,
    /// Name of the table without its ending; none where one run lacks the experiment.
    pub table: Option<String>,
    /// Row of the first run, from 0; of the second where the first lacks it.
    pub row: Option<usize>,
    /// The columns that tell the row apart with their values.
    pub key: String,
    /// The column; none where a run lacks the row.
    pub column: Option<String>,
    /// Value in the first run; none where it lacks it.
    pub first: Option<String>,
    /// Value in the second run; none where it lacks it.
    pub second: Option<String>,
    /// Second less first, of numbers.
    pub difference: Option<f64>,
}

/// Where two runs differ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunComparison {
    /// What differs.
    pub differences: Vec<RunDifference>,
    /// The first stage whose result differs; none where all are the same or no run tells.
    pub first_stage: Option<String>,
    /// Number of tables that were compared.
    pub tables: usize,
}

/// Folders of tables by experiment: those below `folder/results`, or `folder` itself.
pub fn experiments_of_run(folder: &Path) -> BTreeMap<String, PathBuf> {
    let results = folder.join("results");
    let places: Vec<PathBuf> = if results.is_dir() {
        std::fs::read_dir(results)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path())
            .collect()
    } else {
        vec![folder.to_owned()]
    };
    let named = |place: PathBuf| {
        let name = place.canonicalize().ok()?.file_name()?.to_string_lossy().into_owned();
        place.join("spec.yaml").is_file().then_some((name, place))
    };
    places.into_iter().filter_map(named).collect()
}

/// Compares two runs; `share` is the share of the larger of two numbers by which they may differ.
///
/// # Errors
/// [`DataError`] for a table that cannot be read.
pub fn compare_runs(
    first: &BTreeMap<String, PathBuf>,
    second: &BTreeMap<String, PathBuf>,
    share: f64,
) -> Result<RunComparison, DataError> {
    let mut comparison = RunComparison::default();
    let names: BTreeSet<&String> = first.keys().chain(second.keys()).collect();
    for name in names {
        let about = RunDifference { experiment: name.clone(), ..RunDifference::default() };
        match (first.get(name), second.get(name)) {
            (Some(ours), Some(theirs)) => comparison.add(&about, ours, theirs, share)?,
            (ours, _) => comparison.differences.push(about.only(ours.is_some())),
        }
    }
    Ok(comparison)
}

impl RunDifference {
    /// The first run alone has it, or the second.
    fn only(self, is_first: bool) -> RunDifference {
        let there = |is_there: bool| is_there.then(|| THERE.to_owned());
        RunDifference { first: there(is_first), second: there(!is_first), ..self }
    }
}

impl RunComparison {
    /// The tables of one experiment.
    fn add(
        &mut self,
        about: &RunDifference,
        ours: &Path,
        theirs: &Path,
        share: f64,
    ) -> Result<(), DataError> {
        let (here, there) = (tables(ours), tables(theirs));
        let names: BTreeSet<&String> = here.keys().chain(there.keys()).collect();
        for name in names {
            let about = RunDifference { table: Some(name.clone()), ..about.clone() };
            let (Some(one), Some(other)) = (here.get(name), there.get(name)) else {
                self.differences.push(about.only(here.contains_key(name)));
                continue;
            };
            self.tables += 1;
            if name == TRAIL {
                let (before, now): (Vec<StageRow>, Vec<StageRow>) =
                    (read_csv(one)?, read_csv(other)?);
                self.first_stage = self.first_stage.take().or(first_parting(
                    &before,
                    &now,
                    ["first run", "second run"],
                ));
            } else {
                let columns = [read_text_columns(one)?, read_text_columns(other)?];
                differences(&about, &columns, share, &mut self.differences);
            }
        }
        Ok(())
    }
}

/// The tables of a folder by name.
fn tables(folder: &Path) -> BTreeMap<String, PathBuf> {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let table = |file: PathBuf| {
        let is_table = file.extension().is_some_and(|end| end == "csv" || end == "parquet");
        let name = file.file_stem()?.to_string_lossy().into_owned();
        is_table.then_some((name, file))
    };
    files.filter_map(|entry| table(entry.path())).collect()
}

/// What differs between two tables.
fn differences(
    about: &RunDifference,
    [ours, theirs]: &[Vec<Beside>; 2],
    share: f64,
    found: &mut Vec<RunDifference>,
) {
    let cells = |columns: &[Beside], name: &str| {
        columns.iter().find(|(column, _)| column == name).map(|(_, cells)| cells.clone())
    };
    let names = ours.iter().chain(theirs).map(|(name, _)| name.as_str());
    let mut seen = BTreeSet::new();
    let names: Vec<&str> = names.filter(|name| seen.insert(*name)).collect();
    let keys = [ours, theirs].map(|columns| row_keys(about, columns, [ours, theirs]));
    let places: HashMap<&str, usize> =
        keys[1].iter().enumerate().map(|(row, key)| (key.as_str(), row)).collect();
    let of_row = |row: usize, key: &str| RunDifference {
        row: Some(row),
        key: key.to_owned(),
        ..about.clone()
    };
    for name in names.iter().filter(|name| !CLOCKS.contains(name)) {
        let about = RunDifference { column: Some((*name).to_owned()), ..about.clone() };
        let (Some(one), Some(other)) = (cells(ours, name), cells(theirs, name)) else {
            found.push(about.only(cells(ours, name).is_some()));
            continue;
        };
        for (row, key) in keys[0].iter().enumerate() {
            let Some(&place) = places.get(key.as_str()) else { continue };
            if let Some(difference) = different(&one[row], &other[place], share) {
                found.push(RunDifference {
                    column: Some((*name).to_owned()),
                    first: Some(one[row].clone()),
                    second: Some(other[place].clone()),
                    difference,
                    ..of_row(row, key)
                });
            }
        }
    }
    let here: BTreeSet<&String> = keys[0].iter().collect();
    let lacking = |(_, key): &(usize, &String)| !places.contains_key(key.as_str());
    found.extend(
        keys[0].iter().enumerate().filter(lacking).map(|(row, key)| of_row(row, key).only(true)),
    );
    let added = keys[1].iter().enumerate().filter(|(_, key)| !here.contains(key));
    found.extend(added.map(|(row, key)| of_row(row, key).only(false)));
}

/// What tells each row apart: its key where both tables have the columns of a known one, which no
/// two rows share, else its number.
fn row_keys(about: &RunDifference, columns: &[Beside], both: [&Vec<Beside>; 2]) -> Vec<String> {
    let count = columns.first().map_or(0, |(_, cells)| cells.len());
    let has =
        |name: &str| both.iter().all(|columns| columns.iter().any(|(column, _)| column == name));
    let file = format!("{}.csv", about.table.as_deref().unwrap_or_default());
    // Swept fields tell rows apart, too.
    let swept = columns.iter().map(|(name, _)| name.clone()).filter(|name| name.contains('.'));
    let swept: Vec<String> = swept.collect();
    for table in table_descriptions().filter(|table| table.file == file) {
        let named = swept.iter().cloned().chain(table.key().map(str::to_owned));
        let named: Vec<String> = named.collect();
        if !named.iter().all(|name| has(name)) {
            continue;
        }
        let key = |row: usize| {
            let of = |name: &String| {
                let cells = columns.iter().find(|(column, _)| column == name);
                format!("{name}={}", cells.map_or("", |(_, cells)| cells[row].as_str()))
            };
            named.iter().map(of).collect::<Vec<_>>().join(" ")
        };
        let keys: Vec<String> = (0..count).map(key).collect();
        if keys.iter().collect::<BTreeSet<_>>().len() == count {
            return keys;
        }
    }
    (0..count).map(|row| format!("row {row}")).collect()
}

/// `None` where two cells are the same; else how much numbers differ.
fn different(first: &str, second: &str, share: f64) -> Option<Option<f64>> {
    if first == second {
        return None;
    }
    let (Ok(one), Ok(other)) = (first.parse::<f64>(), second.parse::<f64>()) else {
        return Some(None);
    };
    let same = one == other || share > 0.0 && is_close(one, other, share);
    (!same).then_some(Some(other - one))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(folder: &Path, name: &str, gap: &str) -> BTreeMap<String, PathBuf> {
        let place = folder.join(name).join("results/tiny");
        std::fs::create_dir_all(&place).unwrap();
        std::fs::write(place.join("spec.yaml"), "name: tiny\n").unwrap();
        std::fs::write(place.join("gp_coverage.csv"), gap).unwrap();
        experiments_of_run(&folder.join(name))
    }

    #[test]
    fn rows_are_matched_by_their_key_and_numbers_by_the_tolerance() {
        let folder = tempfile::tempdir().unwrap();
        let header = "seed,training,points,axis,promised,covered,unseen\n";
        let first = run(folder.path(), "a", &format!("{header}0,any,100,x,0.9,0.5,7\n"));
        let more = format!("{header}1,any,100,x,0.9,0.4,7\n0,any,100,x,0.9,0.6,7\n");
        let second = run(folder.path(), "b", &more);
        let found = compare_runs(&first, &second, 0.0).unwrap();
        assert_eq!(found.tables, 1);
        let [value, row] = found.differences.as_slice() else { panic!("{found:?}") };
        assert_eq!((value.column.as_deref(), value.row), (Some("covered"), Some(0)));
        assert!((value.difference.unwrap() - 0.1).abs() < 1e-12);
        assert_eq!((row.second.as_deref(), row.first.as_deref()), (Some("there"), None));
        assert!(row.key.contains("seed=1"), "{}", row.key);
        assert_eq!(compare_runs(&first, &second, 0.5).unwrap().differences.len(), 1);
        assert!(compare_runs(&first, &first, 0.0).unwrap().differences.is_empty());
    }
}
