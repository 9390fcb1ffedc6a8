//! `spinebench effects`.

use crate::cli::program::shared::print_all;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::effects::{CATALOGUE, Card, card};
use std::fmt::Write as _;

/// Print the catalogue: each effect with its parameters and units, equation, source, and the
/// effects it is confused with.
#[derive(Args)]
pub(crate) struct EffectsCommand {
    /// Print only this effect.
    name: Option<String>,
}

impl EffectsCommand {
    pub(crate) fn execute(self) -> CommandResult {
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
            "  parameter:     {} ({unit}; nothing changes at {})",
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
