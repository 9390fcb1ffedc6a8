//! Seasons: tracks and program are frozen, and a secret that draws the sealed robots is bound by
//! its hash before the season and disclosed after it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::robot::RobotSeed;
use super::track::{self, ReadTrack};
use super::{LeagueError, NAME, is_name};
use crate::runner::Digest;
use crate::specs::{Document, files_behind, to_yaml};

/// The seed of the development robots where there is no season.
pub const PUBLIC_SEED: u64 = 1;

/// Stands for the season of a score where there is none.
pub const DEVELOPMENT: &str = "development";

/// What follows the name of a season whose sealed robots play.
const SEALED: &str = "_sealed";

/// Whether a score may have this season, whose robots were sealed or not.
pub(super) fn is_season(name: &str, is_sealed: bool) -> bool {
    check_name(name).is_ok() || name == DEVELOPMENT && !is_sealed
}

/// A season as scores, tables and questions name it.
pub fn label(season: &str, is_sealed: bool) -> String {
    season.to_owned() + if is_sealed { SEALED } else { "" }
}

/// A season as its file gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Season {
    /// Its name.
    pub season: String,
    /// Version of the program that scores.
    pub program: String,
    /// Digest of the tracks, the specs that they extend, models and engines.
    pub tracks: String,
    /// Seed of the development robots.
    pub public_seed: u64,
    /// Hash of the secret that draws the sealed robots, BLAKE3 over name and secret, in
    /// hexadecimal; none before it is sealed.
    #[serde(default)]
    pub sealed: Option<String>,
    /// The secret in hexadecimal, once the season has ended.
    #[serde(default)]
    pub secret: Option<String>,
}

impl Season {
    /// A season of the tracks in a folder, to be scored by this program.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for a name that cannot be one, and tracks that cannot be read.
    pub fn new(name: &str, tracks: &Path) -> Result<Season, LeagueError> {
        check_name(name).map_err(LeagueError::input)?;
        Ok(Season {
            season: name.to_owned(),
            program: crate::VERSION.to_owned(),
            tracks: digest(tracks)?.to_string(),
            public_seed: public_seed(name),
            sealed: None,
            secret: None,
        })
    }

    /// Reads the file of a season.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for the first wrong key.
    pub fn read(file: &Path) -> Result<Season, LeagueError> {
        let document = Document::read(file, &[], &[]).map_err(LeagueError::input)?;
        let season: Season = document.parse().map_err(LeagueError::input)?;
        let wrong = |words: String| LeagueError::input(format!("{}: {words}", file.display()));
        check_name(&season.season).map_err(wrong)?;
        let (found, expected) = (season.public_seed, public_seed(&season.season));
        if found != expected {
            return Err(wrong(format!(
                "public_seed: found {found}, expected {expected}, which follows from the name"
            )));
        }
        Ok(season)
    }

    /// The text of its file.
    ///
    /// # Errors
    /// [`LeagueError::Failed`] where YAML cannot represent it.
    pub fn text(&self) -> Result<String, LeagueError> {
        to_yaml(self).map_err(LeagueError::failed)
    }

    /// The hash of a secret of this season.
    pub fn hash(&self, secret: &[u8; 32]) -> String {
        Digest::of(&[self.season.as_bytes(), secret].concat()).to_string()
    }

    /// The secret in a text, if it is that of this season.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for another secret.
    pub fn checked(&self, text: &str) -> Result<[u8; 32], LeagueError> {
        let expected = "64 hexadecimal digits, as `spinebench league seal` wrote";
        let secret = Digest::parse(text.trim())
            .ok_or_else(|| LeagueError::input(format!("secret: expected {expected}")))?;
        let Some(sealed) = &self.sealed else {
            return Err(LeagueError::input(format!(
                "season {}: found no `sealed`, expected a season that was sealed",
                self.season
            )));
        };
        let hash = self.hash(secret.bytes());
        if hash != *sealed {
            return Err(LeagueError::input(format!(
                "secret: found one with the hash {hash}, expected {sealed}, which was published"
            )));
        }
        Ok(*secret.bytes())
    }

    /// Refuses another program or other tracks than those of the season in `file`.
    ///
    /// # Errors
    /// [`LeagueError::Input`] names what differs.
    pub fn check_frozen(&self, file: &Path, tracks: &Path) -> Result<(), LeagueError> {
        let here = [
            ("program", &self.program, crate::VERSION.to_owned(), "this program".to_owned()),
            ("tracks", &self.tracks, digest(tracks)?.to_string(), tracks.display().to_string()),
        ];
        for (key, found, expected, of) in here {
            if *found != expected {
                return Err(LeagueError::input(format!(
                    "{}: {key}: found {found}, expected {expected}, that of {of}",
                    file.display()
                )));
            }
        }
        Ok(())
    }

    /// What draws the robots: the sealed ones with their secret, the development robots without.
    pub fn seed(&self, secret: Option<[u8; 32]>) -> RobotSeed {
        secret.map_or(RobotSeed::Public(self.public_seed), RobotSeed::Sealed)
    }
}

/// Refuses a name that cannot be that of a season.
fn check_name(name: &str) -> Result<(), String> {
    if is_name(name) && name != DEVELOPMENT && !name.ends_with(SEALED) {
        return Ok(());
    }
    Err(format!(
        "season: found `{name}`, expected {NAME}, other than `{DEVELOPMENT}` and `…{SEALED}`"
    ))
}

/// The seed of the development robots of a season: 32 bits of the hash of its name.
fn public_seed(name: &str) -> u64 {
    let first: [u8; 4] = std::array::from_fn(|index| Digest::of(name.as_bytes()).bytes()[index]);
    u32::from_le_bytes(first).into()
}

/// Digest of all that tracks depend on: their files, the specs they extend, the models, the engines.
///
/// # Errors
/// [`LeagueError::Input`] for a file that cannot be read.
pub fn digest(tracks: &Path) -> Result<Digest, LeagueError> {
    let mut files: Vec<PathBuf> = Vec::new();
    for name in track::names(tracks)? {
        let read = ReadTrack::read(tracks, &name)?;
        files.extend([read.file.clone(), tracks.join(&read.track.robots)]);
        files.extend(read.extended().iter().flat_map(|file| files_behind(file)));
        for kind in read.kinds.values() {
            files.extend(files_behind(&read.robots_folder.join(&kind.model)));
            let engine = kind.engine.iter();
            let named = engine.flat_map(|engine| {
                engine.command.iter().map(PathBuf::from).chain(engine.files.clone())
            });
            files.extend(
                named.map(|file| read.robots_folder.join(file)).filter(|file| file.is_file()),
            );
        }
    }
    files.sort();
    files.dedup();
    let mut bytes = Vec::new();
    for file in files {
        let content = std::fs::read(&file)
            .map_err(|error| LeagueError::input(format!("{}: {error}", file.display())))?;
        bytes.extend(file.file_name().unwrap_or_default().to_string_lossy().bytes());
        bytes.extend(Digest::of(&content).bytes());
    }
    Ok(Digest::of(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_secret_of_the_season_opens_it() {
        let mut season = Season {
            season: "test".into(),
            program: String::new(),
            tracks: String::new(),
            public_seed: 2,
            sealed: None,
            secret: None,
        };
        let secret = Digest::of(b"a secret");
        assert!(season.checked(&secret.to_string()).unwrap_err().to_string().contains("sealed"));
        season.sealed = Some(season.hash(secret.bytes()));
        assert_eq!(season.checked(&format!("{secret}\n")), Ok(*secret.bytes()));
        assert!(season.checked(&Digest::of(b"another").to_string()).is_err());
        assert!(season.checked("no digits").is_err());
        assert_ne!(
            season.hash(secret.bytes()),
            Season { season: "other".into(), ..season.clone() }.hash(secret.bytes())
        );
    }
}
