//! `spinebench effects`.

use crate::cli::program::shared::print_all;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::effects::{CATALOGUE, Card, card};
use spinebench::report;
use spinebench::runner::effect_pictures;
use spinebench::specs::read_model;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Print the catalogue: each effect with its parameters and units, equation, source, and the
/// effects it is confused with. With `--plots`, draw the response of a robot with each effect.
#[derive(Args)]
pub(crate) struct EffectsCommand {
    /// Print only this effect.
    name: Option<String>,
    /// Folder for the figures, one for each effect: the robot without and with the effect under the
    /// same commands. Prints nothing.
    #[arg(long, value_name = "DIR", conflicts_with = "name")]
    plots: Option<PathBuf>,
    /// Model of the robot in the figures.
    #[arg(long, value_name = "MODEL", default_value = "models/nominal.yaml", requires = "plots")]
    model: PathBuf,
}

impl EffectsCommand {
    pub(crate) fn execute(self) -> CommandResult {
        if let Some(folder) = &self.plots {
            return draw(folder, &self.model);
        }
        let mut text = String::new();
        match &self.name {
            None => CATALOGUE.iter().for_each(|card| describe(card, &mut text)),
            Some(name) => {
                let card = card(name).ok_or_else(|| {
                    let all: Vec<&str> = CATALOGUE.iter().map(|card| card.name).collect();
                    CommandError::BadInput(format!(
                        "NAME: found `{name}`, expected one of {}",
                        all.join(", ")
                    ))
                })?;
                describe(card, &mut text);
            }
        }
        print_all(text.as_bytes());
        Ok(())
    }
}

/// Draws the picture of every effect on the robot of a model file.
fn draw(folder: &Path, model: &Path) -> CommandResult {
    let model = read_model(model).map_err(CommandError::bad_input)?;
    for picture in effect_pictures(&model).map_err(CommandError::Failed)? {
        let files = picture.files().map_err(CommandError::failed)?;
        report::write(&files, folder, folder).map_err(CommandError::failed)?;
    }
    Ok(())
}

fn describe(card: &Card, text: &mut String) {
    let _ = writeln!(
        text,
        "{}\n  missing:       {}\n  equation:      {}",
        card.name, card.missing, card.equation
    );
    for parameter in card.parameters {
        let unit = if parameter.unit == "1" { "ratio" } else { parameter.unit };
        let _ = writeln!(
            text,
            "  parameter:     {} ({unit}; no effect at {})",
            parameter.name, parameter.null
        );
    }
    let _ = writeln!(
        text,
        "  source:        {}\n  confused with: {}\n",
        card.source,
        card.confused_with.join(", ")
    );
}
