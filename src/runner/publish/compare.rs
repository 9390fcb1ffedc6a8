//! Results against published ones: to the byte, or where another processor computed them, to a
//! stated tolerance.

use super::results::Files;
use crate::data::packed::csv_of;
use std::path::{Path, PathBuf};

/// How alike results must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standard {
    /// To the byte, pictures included.
    Bytes,
    /// Numbers in tables to this share of the larger one (or a nanometre); other words exactly; no
    /// pictures.
    Numbers(f64),
}

/// Numbers that are this close together are the same under any tolerance.
const NEGLIGIBLE_DIFFERENCE: f64 = 1e-9;

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
const STAGES_OF_TABLES: [(&str, &str); 9] = [
    ("spec.yaml", "spec"),
    ("gap.csv", "collect_real"),
    ("gp.csv", "gp_fit"),
    ("networks.csv", "train"),
    ("waypoints.csv", "waypoints"),
    ("trials.csv", "reach"),
    ("tracks.csv", "track"),
    ("discovery.csv", "discover"),
    ("intervals.csv", "discover"),
];

/// Compares files with those of the same names below `published`; the first difference is the one
/// whose stage comes first.
///
/// # Errors
/// The first [`Difference`].
pub fn compare(files: &Files, published: &Path, standard: Standard) -> Result<(), Difference> {
    let mut paths: Vec<&PathBuf> = files.keys().collect();
    paths.sort_by_key(|path| (rank(path).0, (*path).clone()));
    for path in paths {
        let stage = rank(path).1;
        let Ok(bytes) = csv_of(&published.join(path)) else {
            return Err(Difference::Missing { stage, file: path.clone() });
        };
        if bytes != files[path] && !(standard != Standard::Bytes && is_picture(path)) {
            match difference(&bytes, &files[path], standard) {
                None => {}
                Some((line, published, found)) => {
                    return Err(Difference::Changed {
                        stage,
                        file: path.clone(),
                        line,
                        published,
                        found,
                    });
                }
            }
        }
    }
    Ok(())
}

fn rank(path: &Path) -> (usize, &'static str) {
    let name = path.file_name().unwrap_or_default();
    let place = STAGES_OF_TABLES.iter().position(|(file, _)| name == *file);
    place.map_or((STAGES_OF_TABLES.len(), "report"), |place| (place, STAGES_OF_TABLES[place].1))
}

fn is_picture(path: &Path) -> bool {
    path.extension().is_some_and(|end| end == "png" || end == "svg")
}

/// The first line that differs, as published and as found.
fn difference(
    published: &[u8],
    found: &[u8],
    standard: Standard,
) -> Option<(usize, String, String)> {
    let (published, found) = (String::from_utf8_lossy(published), String::from_utf8_lossy(found));
    let (mut old, mut new) = (published.lines(), found.lines());
    let short = |text: Option<&str>| text.unwrap_or("(end of file)").chars().take(160).collect();
    for line in 1.. {
        let (before, now) = (old.next(), new.next());
        let same = match (before, now, standard) {
            // Other bytes and the same lines: the ends of lines differ.
            (None, None, Standard::Bytes) => false,
            (None, None, Standard::Numbers(_)) => return None,
            (Some(before), Some(now), Standard::Numbers(share)) => alike(before, now, share),
            _ => before == now,
        };
        if !same {
            return Some((line, short(before), short(now)));
        }
    }
    None
}

/// Whether two numbers differ by no more than this share of the larger one, or a nanometre.
pub(super) fn is_close(one: f64, other: f64, share: f64) -> bool {
    (one - other).abs() <= NEGLIGIBLE_DIFFERENCE.max(share * one.abs().max(other.abs()))
}

/// Whether two lines have the same words, and numbers that are this close.
fn alike(one: &str, other: &str, share: f64) -> bool {
    let words = |line: &str| -> Vec<String> {
        line.split([',', ' ', '|', '(', ')', '[', ']', ':']).map(str::to_owned).collect()
    };
    let close = |one: &String, other: &String| match (one.parse::<f64>(), other.parse::<f64>()) {
        (Ok(one), Ok(other)) => is_close(one, other, share),
        _ => one == other,
    };
    let (one, other) = (words(one), words(other));
    one.len() == other.len()
        && one.iter().zip(&other).all(|(one, other)| one == other || close(one, other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tolerance_is_about_numbers_and_bytes_are_about_everything() {
        let folder = tempfile::tempdir().unwrap();
        let table = Path::new("results/one/trials.csv");
        std::fs::create_dir_all(folder.path().join("results/one")).unwrap();
        std::fs::write(folder.path().join(table), "a,b,c\nx,1.000000,\ny,2.5,-3e-12\n").unwrap();
        let told = |text: &str, standard: Standard| {
            compare(
                &Files::from([(table.to_owned(), text.as_bytes().to_vec())]),
                folder.path(),
                standard,
            )
        };
        let numbers = Standard::Numbers(1e-6);
        assert_eq!(told("a,b,c\nx,1.000000,\ny,2.5,-3e-12\n", Standard::Bytes), Ok(()));
        assert!(told("a,b,c\nx,1.0000001,\ny,2.5,-3e-12\n", Standard::Bytes).is_err());
        assert_eq!(told("a,b,c\nx,1.0000001,\ny,2.5,0\n", numbers), Ok(()));
        let wrong = [
            "a,b,c\nx,1.00001,\ny,2.5,0\n",
            "a,b,c\nz,1,\ny,2.5,0\n",
            "a,b,c\nx,1,0\ny,2.5,0\n",
            "a,b,c\nx,1,\n",
        ];
        for text in wrong {
            let Err(Difference::Changed { stage, .. }) = told(text, numbers) else {
                panic!("{text}")
            };
            assert_eq!(stage, "reach");
        }
        let files = Files::from([(PathBuf::from("results/one/gp.csv"), b"1\n".to_vec())]);
        assert!(matches!(
            compare(&files, folder.path(), numbers),
            Err(Difference::Missing { stage: "gp_fit", .. })
        ));
    }
}
