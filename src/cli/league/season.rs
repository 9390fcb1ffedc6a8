//! `spinebench league new-season`, `seal` and `open`.

use super::common::read;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::write_atomic;
use spinebench::league::season::Season;
use std::path::{Path, PathBuf};

/// Freeze the tracks and this program for a season, and write its file.
#[derive(Args)]
pub(crate) struct NewSeasonCommand {
    /// Name of the season.
    name: String,
    /// File to write.
    #[arg(long, value_name = "SEASON.yaml")]
    out: PathBuf,
    /// Folder of the tracks.
    #[arg(long, value_name = "DIR", default_value = "experiments/league")]
    tracks: PathBuf,
}

impl NewSeasonCommand {
    pub(crate) fn execute(&self) -> CommandResult {
        if self.out.exists() {
            refuse!(
                "--out: found {}, expected a new file: a season stays as it is",
                self.out.display()
            );
        }
        let season = Season::new(&self.name, &self.tracks)?;
        write(&self.out, &season)?;
        println!(
            "season `{}`: tracks {}, program {}",
            season.season,
            &season.tracks[..12],
            season.program
        );
        Ok(())
    }
}

/// Draw the secret of a season, keep it in a file of its own, and write its hash into the season.
#[derive(Args)]
pub(crate) struct SealCommand {
    /// File of the season.
    season: PathBuf,
    /// File to write the secret in, outside any repository.
    #[arg(long, value_name = "FILE")]
    secret: PathBuf,
}

impl SealCommand {
    pub(crate) fn execute(&self) -> CommandResult {
        let mut season = Season::read(&self.season)?;
        if let Some(sealed) = &season.sealed {
            refuse!(
                "{}: found `sealed` {sealed}, expected a season that is not sealed yet",
                self.season.display()
            );
        }
        let secret = std::path::absolute(&self.secret).map_err(CommandError::bad_input)?;
        if let Some(repository) = secret.ancestors().find(|folder| folder.join(".git").exists()) {
            refuse!(
                "--secret: found a file in the repository {}, expected one outside any repository",
                repository.display()
            );
        }
        if secret.exists() {
            refuse!("--secret: found {}, expected a new file", secret.display());
        }
        let mut bytes = [0; 32];
        getrandom::fill(&mut bytes).map_err(CommandError::failed)?;
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        season.sealed = Some(season.hash(&bytes));
        write_secret(&secret, &(digits + "\n"))
            .map_err(|error| CommandError::Failed(format!("{}: {error}", secret.display())))?;
        write(&self.season, &season).inspect_err(|_| {
            // A secret without a season would be in the way of the next try.
            let _ = std::fs::remove_file(&secret);
        })?;
        println!("sealed: {}", season.sealed.unwrap_or_default());
        Ok(())
    }
}

/// Disclose the secret of a season that has ended: write it into the season.
#[derive(Args)]
pub(crate) struct OpenCommand {
    /// File of the season.
    season: PathBuf,
    /// File of the secret.
    #[arg(long, value_name = "FILE")]
    secret: PathBuf,
}

impl OpenCommand {
    pub(crate) fn execute(&self) -> CommandResult {
        let mut season = Season::read(&self.season)?;
        let text = read(&self.secret)?;
        season.checked(&text)?;
        season.secret = Some(text.trim().to_owned());
        write(&self.season, &season)?;
        println!(
            "season `{}` is open: everybody can score its sealed robots (--sealed)",
            season.season
        );
        Ok(())
    }
}

fn write(file: &Path, season: &Season) -> CommandResult {
    write_atomic(file, season.text()?.as_bytes())
        .map_err(|error| CommandError::Failed(format!("{}: {error}", file.display())))
}

/// Writes a file that its owner alone can read.
fn write_secret(file: &Path, text: &str) -> std::io::Result<()> {
    use std::io::Write as _;
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(file)?.write_all(text.as_bytes())
}
