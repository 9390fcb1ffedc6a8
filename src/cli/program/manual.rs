//! Parts of the manual that are made of the program itself.

use crate::cli::Arguments;
use clap::{Command, CommandFactory};
use spinebench::effects::{CATALOGUE, Card, Parameter};
use std::fmt::Write as _;

/// Width of the help in the manual, whatever the terminal's.
const HELP_WIDTH: usize = 100;

/// The long help of every command, a section each.
pub(crate) fn help() -> String {
    let mut program = Arguments::command().term_width(HELP_WIDTH);
    program.build();
    let mut text = String::new();
    add_help(&program, "spinebench", &mut text);
    text
}

fn add_help(command: &Command, name: &str, text: &mut String) {
    let help = command.clone().bin_name(name).render_long_help().to_string();
    let help: Vec<&str> = help.lines().map(str::trim_end).collect();
    let _ = write!(text, "## `{name}`\n\n```text\n{}\n```\n\n", help.join("\n").trim_end());
    let shown = command
        .get_subcommands()
        .filter(|inner| !inner.is_hide_set() && inner.get_name() != "help");
    for inner in shown {
        add_help(inner, &format!("{name} {}", inner.get_name()), text);
    }
}

/// The catalogue of effects, a section each, with the pictures in `plots`/effects.
pub(crate) fn effects(plots: &str) -> String {
    CATALOGUE.iter().map(|card| section(card, plots)).collect()
}

fn section(card: &Card, plots: &str) -> String {
    let name = card.name;
    let row = |parameter: &Parameter| {
        let unit = if parameter.unit == "1" { "ratio" } else { parameter.unit };
        format!("| `{}` | {unit} | {} |\n", parameter.name, parameter.null)
    };
    let rows: String = card.parameters.iter().map(row).collect();
    let others: Vec<String> =
        card.confused_with.iter().map(|other| format!("[`{other}`](#{other})")).collect();
    let others = if others.is_empty() { "none".to_owned() } else { others.join(", ") };
    format!(
        "## `{name}`\n\nMissing: {}.\n\n![{name}: the nominal robot and the robot with the \
         effect]({plots}/effects/{name}.svg)\n\nEquation: {}\n\n| parameter | unit | no effect at \
         |\n| --- | --- | --- |\n{rows}\nSource: {}. Confused with: {others}.\n\n",
        card.missing,
        card.equation,
        card.source.trim_end_matches('.')
    )
}
