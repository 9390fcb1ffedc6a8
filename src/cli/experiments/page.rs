//! `spinebench page`.

use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::{TableDescription, write_atomic};
use spinebench::report::page::recounted;
use spinebench::report::page::{picture, splice};
use spinebench::rows::table_descriptions;
use std::path::{Path, PathBuf};

/// Insert published tables and figures into a Markdown page, between the lines `<!-- begin:FILE
/// -->` and `<!-- end:FILE -->`. FILE is relative to the page: a `.md` is copied in, any other file
/// is shown as a picture; `columns:ROW` is the table of the columns that rows of the type ROW have.
/// In a sentence, the number after `<!-- count:FILE.csv; COLUMN=VALUE; … -->` becomes the number of
/// rows of the table that meet the conditions, and the text after `<!-- cell:COLUMN of FILE.csv;
/// COLUMN=VALUE; … -->` the cell of the only such row.
#[derive(Args)]
pub(crate) struct PageCommand {
    /// Page to update in place.
    #[arg(value_name = "PAGE.md")]
    page: PathBuf,
}

impl PageCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let name = self.page.display();
        let refuse = |words: String| CommandError::BadInput(format!("{name}: {words}"));
        let mut text =
            std::fs::read_to_string(&self.page).map_err(|error| refuse(error.to_string()))?;
        let folder = self.page.parent().unwrap_or(Path::new("")).to_owned();
        for file in named(&text) {
            let content = content(&folder, &file).map_err(&refuse)?;
            text = splice(&text, &file, &content).map_err(|error| refuse(error.to_string()))?;
        }
        text = recounted(&text, &folder).map_err(&refuse)?;
        write_atomic(&self.page, text.as_bytes()).map_err(CommandError::failed)
    }
}

/// The files that the page's markers name.
fn named(text: &str) -> Vec<String> {
    let name = |line: &str| {
        Some(line.trim().strip_prefix("<!-- begin:")?.strip_suffix(" -->")?.to_owned())
    };
    text.lines().filter_map(name).collect()
}

/// The Markdown that shows a file on the page.
fn content(folder: &Path, file: &str) -> Result<String, String> {
    if let Some(row) = file.strip_prefix("columns:") {
        let table = table_descriptions().find(|table| table.name == row);
        return table
            .map(TableDescription::markdown)
            .ok_or_else(|| format!("found no table of `{row}`"));
    }
    let path = folder.join(file);
    if Path::new(file).extension().is_some_and(|extension| extension == "md") {
        return std::fs::read_to_string(&path).map_err(|error| format!("{file}: {error}"));
    }
    if !path.is_file() {
        return Err(format!("found no `{file}`, expected a published figure"));
    }
    let stem = path
        .file_stem()
        .map_or_else(|| file.to_owned(), |stem| stem.to_string_lossy().into_owned());
    Ok(picture(file, &stem))
}
