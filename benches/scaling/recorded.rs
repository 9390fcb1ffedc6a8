//! What stages took and how large their results are, by kind, from the store of a run.

use spinebench::runner::Store;
use std::collections::BTreeMap;

/// Stages of one kind.
#[derive(Clone, Debug, Default)]
pub struct Kind {
    /// What each took, s.
    pub wall_s: Vec<f64>,
    /// Mean size of a result, bytes.
    pub bytes: f64,
    entries: usize,
}

/// All kinds.
pub struct Recorded(BTreeMap<String, Kind>);

impl Recorded {
    pub fn of(store: &Store) -> Result<Recorded, String> {
        let mut kinds: BTreeMap<String, Kind> = BTreeMap::new();
        for entry in store.entries().map_err(|error| error.to_string())? {
            let kind = kinds.entry(entry.stage).or_default();
            kind.wall_s.extend(entry.note.map(|note| note.timing.wall_s));
            kind.bytes += entry.bytes as f64;
            kind.entries += 1;
        }
        kinds.values_mut().for_each(|kind| kind.bytes /= kind.entries as f64);
        if kinds.is_empty() {
            Err("the run has stored nothing".to_owned())
        } else {
            Ok(Recorded(kinds))
        }
    }

    /// What stage number `number` takes: the recorded times of its kind in turn.
    pub fn wall_s(&self, kind: &str, number: usize) -> f64 {
        self.0
            .get(kind)
            .filter(|kind| !kind.wall_s.is_empty())
            .map_or(0.0, |kind| kind.wall_s[number % kind.wall_s.len()])
    }

    pub fn bytes(&self, kind: &str) -> f64 {
        self.0.get(kind).map_or(0.0, |kind| kind.bytes)
    }
}
