//! The house style: one set of colours, markers, dashes and sizes for every figure.
//!
//! Colours are those of Okabe & Ito (2008), told apart with every common colour vision; each series
//! also has a marker and a dash of its own, so that a grey print can be read. Lengths are in
//! hundredths of an inch: a figure of [`PAGE_WIDTH`] fills the two columns of a paper, and text of
//! [`TEXT`] is 8 pt there.
/// Height of a canvas while it is drawn on; the final one is set afterwards.
pub(crate) const TALL: f64 = 1e6;

use crate::base::series::PALETTE;
pub use crate::base::series::{Colour, DASH_DOT, DASHED, DOTTED, Dash, Look, Marker, SOLID};
use crate::policies;

/// Okabe & Ito's blue.
pub const BLUE: Colour = PALETTE[0];
/// Okabe & Ito's vermilion.
pub const VERMILION: Colour = PALETTE[1];
/// Okabe & Ito's bluish green.
pub const GREEN: Colour = PALETTE[2];
/// Okabe & Ito's orange.
pub const ORANGE: Colour = PALETTE[4];
/// Okabe & Ito's sky blue.
pub const SKY: Colour = PALETTE[5];
/// Text and axes.
pub const INK: Colour = [38, 38, 38];
/// What stands back: target paths, reference lines.
pub const GREY: Colour = [120, 120, 120];
/// Grid lines.
pub const GRID: Colour = [226, 226, 226];
/// The workspace behind a path.
pub const CLOUD: Colour = [205, 205, 205];
/// Paper.
pub const WHITE: Colour = [255, 255, 255];

/// Width of a figure over two columns, hundredths of an inch.
pub const PAGE_WIDTH: f64 = 720.0;
/// Width of a figure over one column: 85 mm, hundredths of an inch.
pub const COLUMN_WIDTH: f64 = 334.6;
/// A drawing below this width puts its panels one below the other.
pub(crate) const NARROW: f64 = 500.0;
/// Room for the numbers and the label of the y axis left of a panel, hundredths of an inch.
pub(crate) const LEFT_MARGIN: f64 = 56.0;
/// Size of labels and legends (8 pt).
pub const TEXT: f64 = 11.1;
/// Size of tick labels (7 pt).
pub const SMALL: f64 = 9.8;
/// Half the height of a capital or digit of the embedded font, in ems: with its baseline this far
/// below a line, a text is centred on it.
pub(crate) const HALF_CAP: f64 = 0.36;
/// Width of a data line.
pub const LINE: f64 = 1.5;
/// Width of axes, ticks and thin intervals.
pub const HAIR: f64 = 0.8;
/// Radius of a marker.
pub const MARKER: f64 = 3.4;
/// Opacity of a band of one standard deviation.
pub const BAND: f64 = 0.18;

/// Looks in the order in which series take them.
pub const LOOKS: [Look; 6] = [
    Look::assigned(0),
    Look::assigned(1),
    Look::assigned(2),
    Look::assigned(3),
    Look::assigned(4),
    Look::assigned(5),
];

/// Position of a policy in tables and figures; policies that are not in the registry follow the
/// last.
pub fn policy_rank(policy: &str) -> usize {
    policies::REGISTRY
        .iter()
        .position(|entry| entry.name == policy)
        .unwrap_or(policies::REGISTRY.len())
}

/// The policies among these, each once, in the order of the registry; others follow by name.
pub fn policies_in_order<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut policies: Vec<&str> = names.collect();
    policies.sort_by_key(|policy| (policy_rank(policy), *policy));
    policies.dedup();
    policies
}

/// How a policy looks in every figure: as its registry entry states, else by its position.
pub fn policy_look(policy: &str) -> Look {
    let stated = policies::find(policy).and_then(|entry| entry.look);
    stated.unwrap_or_else(|| Look::assigned(policy_rank(policy)))
}

/// The name of a policy in figures.
pub fn policy_label(policy: &str) -> &str {
    policies::find(policy).map_or(policy, |entry| entry.label.plain)
}

/// The name of a policy in Markdown.
pub fn policy_markdown(policy: &str) -> &str {
    policies::find(policy).map_or(policy, |entry| entry.label.markdown)
}

/// The name of a policy in LaTeX.
pub fn policy_latex(policy: &str) -> String {
    policies::find(policy)
        .map_or_else(|| super::page::markup::latex(policy), |entry| entry.label.latex.to_owned())
}

/// The training whose networks stop at the errors that the paper reports.
pub(crate) const PAPER_TRAINING: &str = "paper";

/// In the place of a way of training: none takes part.
pub(crate) const ANY_TRAINING: &str = "any";

/// A way of training in two words.
pub fn training_short(training: &str) -> &str {
    if training == PAPER_TRAINING { "paper’s errors" } else { training }
}

/// What a way of training means, as a heading.
pub fn heading(training: &str) -> String {
    capitalised(&training_label(training))
}

/// Words with a capital at the beginning.
pub(crate) fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// What a way of training means, in words.
pub fn training_label(training: &str) -> String {
    match training {
        PAPER_TRAINING => "networks stopped at the paper’s errors".to_owned(),
        "converged" => "networks trained to convergence".to_owned(),
        other => format!("training: {other}"),
    }
}

/// A mode of trials as a heading.
pub(crate) fn mode_title(mode: &str) -> String {
    match mode {
        "open" => "open loop".to_owned(),
        "closed" => "closed loop".to_owned(),
        "closed_load" => "closed loop with a load".to_owned(),
        other => other.replace('_', " "),
    }
}

/// The statement of a claim as a sentence.
pub(crate) fn claim_words(statement: &str) -> String {
    let words = statement.replace("pi_real", policy_label("pi_real"));
    // A Greek letter stays small.
    if words.starts_with(|letter: char| letter.is_ascii()) { capitalised(&words) } else { words }
}
