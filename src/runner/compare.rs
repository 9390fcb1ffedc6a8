//! Results against published ones, to the byte.

use super::results::Files;
use std::path::{Path, PathBuf};

/// The first difference found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Difference {
    /// A file that the rerun makes is not published.
    #[error("{stage}: {}: not published", file.display())]
    Missing {
        /// Stage that the file comes from.
        stage: &'static str,
        /// The file.
        file: PathBuf,
    },
    /// A published file says something else.
    #[error("{stage}: {}:{line}: published `{published}`, found `{found}`", file.display())]
    Changed {
        /// Stage that the file comes from.
        stage: &'static str,
        /// The file.
        file: PathBuf,
        /// First line that differs, from 1.
        line: usize,
        /// That line as published, shortened.
        published: String,
        /// That line now, shortened.
        found: String,
    },
}

/// Tables in the order in which the stages behind them depend on each other.
const ORDER: [(&str, &str); 7] = [
    ("spec.yaml", "spec"),
    ("gap.csv", "collect_real"),
    ("gp.csv", "gp_fit"),
    ("networks.csv", "train"),
    ("waypoints.csv", "waypoints"),
    ("trials.csv", "reach"),
    ("tracks.csv", "track"),
];

/// Compares files with those of the same names below `published`; the first difference is the one whose stage comes
/// first.
///
/// # Errors
/// The first [`Difference`].
pub fn compare(files: &Files, published: &Path) -> Result<(), Difference> {
    let mut paths: Vec<&PathBuf> = files.keys().collect();
    paths.sort_by_key(|path| (rank(path).0, (*path).clone()));
    for path in paths {
        let stage = rank(path).1;
        let found = &files[path];
        match std::fs::read(published.join(path)) {
            Err(_) => return Err(Difference::Missing { stage, file: path.clone() }),
            Ok(bytes) if bytes == *found => {}
            Ok(bytes) => return Err(changed(stage, path, &bytes, found)),
        }
    }
    Ok(())
}

fn rank(path: &Path) -> (usize, &'static str) {
    let name = path.file_name().unwrap_or_default();
    let place = ORDER.iter().position(|(file, _)| name == *file);
    place.map_or((ORDER.len(), "report"), |place| (place, ORDER[place].1))
}

fn changed(stage: &'static str, path: &Path, published: &[u8], found: &[u8]) -> Difference {
    let (published, found) = (String::from_utf8_lossy(published), String::from_utf8_lossy(found));
    let (mut old, mut new) = (published.lines(), found.lines());
    let mut line = 1;
    loop {
        let (before, now) = (old.next(), new.next());
        if before != now || before.is_none() {
            let short = |text: Option<&str>| text.unwrap_or("(end of file)").chars().take(160).collect();
            let file = path.to_owned();
            return Difference::Changed { stage, file, line, published: short(before), found: short(now) };
        }
        line += 1;
    }
}
