//! `spinebench page`.

use crate::cli::program::{manual, schema};
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::{TableDescription, write_atomic};
use spinebench::report::page::{captioned_picture, gallery, recounted, splice};
use spinebench::rows::table_descriptions;
use std::path::{Path, PathBuf};

/// Update the generated parts of Markdown pages, each between the comments `begin:NAME` and
/// `end:NAME`. NAME is a file relative to the page: a `.md` is copied in, a picture is shown with
/// its caption; or `columns:ROW`, the columns of rows of the type ROW; `figures`, all published
/// pictures in `plots/`; `effects`, the catalogue of effects; `help`, the help of all commands;
/// `keys:KIND`, the keys of a kind of file that `spinebench schema` knows.
///
/// In a sentence, the number after the comment `count:FILE.csv; COLUMN=VALUE; …` becomes the number
/// of rows of the table that meet the conditions.
#[derive(Args)]
pub(crate) struct PageCommand {
    /// Pages to update in place.
    #[arg(value_name = "PAGE.md", required = true)]
    pages: Vec<PathBuf>,
    /// Change nothing; exit with status 1 if a page is not up to date.
    #[arg(long)]
    check: bool,
}

impl PageCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let mut stale = Vec::new();
        for page in &self.pages {
            let refuse =
                |words: String| CommandError::BadInput(format!("{}: {words}", page.display()));
            let before =
                std::fs::read_to_string(page).map_err(|error| refuse(error.to_string()))?;
            let now = updated(page, &before).map_err(refuse)?;
            if now == before {
                continue;
            }
            if self.check {
                stale.push(page.display().to_string());
            } else {
                write_atomic(page, now.as_bytes()).map_err(CommandError::failed)?;
            }
        }
        if stale.is_empty() {
            return Ok(());
        }
        let words = format!("not up to date: {}; `spinebench page` updates them", stale.join(", "));
        Err(CommandError::Failed(words))
    }
}

/// The page with its generated parts as they are now.
fn updated(page: &Path, before: &str) -> Result<String, String> {
    let folder = page.parent().unwrap_or(Path::new("")).to_owned();
    let mut text = before.to_owned();
    for name in named(before) {
        let content = content(&folder, &name)?;
        text = splice(&text, &name, &content).map_err(|error| error.to_string())?;
    }
    recounted(&text, &folder)
}

/// The names in the page's markers.
fn named(text: &str) -> Vec<String> {
    let name = |line: &str| {
        Some(line.trim().strip_prefix("<!-- begin:")?.strip_suffix(" -->")?.to_owned())
    };
    text.lines().filter_map(name).collect()
}

/// The Markdown between the markers of a name.
fn content(folder: &Path, name: &str) -> Result<String, String> {
    match name.split_once(':') {
        Some(("columns", row)) => {
            let table = table_descriptions().find(|table| table.name == row);
            return table
                .map(TableDescription::markdown)
                .ok_or_else(|| format!("found no table of `{row}`"));
        }
        Some(("keys", kind)) => return schema::keys_markdown(kind),
        _ => {}
    }
    match name {
        "figures" => {
            let (plots, relative) = plots(folder)?;
            gallery(&plots, &relative).map_err(|error| format!("{}: {error}", plots.display()))
        }
        "effects" => Ok(manual::effects(&plots(folder)?.1)),
        "help" => Ok(manual::help()),
        file => file_content(folder, file),
    }
}

fn file_content(folder: &Path, file: &str) -> Result<String, String> {
    let path = folder.join(file);
    if path.extension().is_some_and(|end| end == "md") {
        return std::fs::read_to_string(&path).map_err(|error| format!("{file}: {error}"));
    }
    if !path.is_file() {
        return Err(format!("found no `{file}`, expected a published figure"));
    }
    let stem = path.file_stem().map_or(file.into(), |stem| stem.to_string_lossy());
    let caption = std::fs::read_to_string(path.with_extension("md")).ok();
    Ok(captioned_picture(file, &stem, caption.as_deref()))
}

/// The nearest folder `plots` at or above the page's, and how the page names it.
fn plots(folder: &Path) -> Result<(PathBuf, String), String> {
    let above = |steps: usize| "../".repeat(steps) + "plots";
    let found = (0..8).map(above).find(|relative| folder.join(relative).is_dir());
    let relative = found.ok_or("found no folder `plots` at or above the page's")?;
    Ok((folder.join(&relative), relative))
}
