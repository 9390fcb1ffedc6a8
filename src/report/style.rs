//! The house style: one set of colours, markers, dashes and sizes for every figure.
//!
//! Colours are those of Okabe & Ito (2008), told apart with every common colour vision; each series also has a marker
//! and a dash of its own, so that a grey print can be read. Lengths are in hundredths of an inch: a figure of
//! [`PAGE_WIDTH`] fills the two columns of a paper, and text of [`TEXT`] is 8 pt there.

/// A colour, red, green and blue.
pub type Colour = [u8; 3];

/// Okabe & Ito's blue.
pub const BLUE: Colour = [0, 114, 178];
/// Okabe & Ito's vermilion.
pub const VERMILION: Colour = [213, 94, 0];
/// Okabe & Ito's bluish green.
pub const GREEN: Colour = [0, 158, 115];
/// Okabe & Ito's reddish purple.
pub const PURPLE: Colour = [204, 121, 167];
/// Okabe & Ito's orange.
pub const ORANGE: Colour = [230, 159, 0];
/// Okabe & Ito's sky blue.
pub const SKY: Colour = [86, 180, 233];
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
/// Size of labels and legends (8 pt).
pub const TEXT: f64 = 11.1;
/// Size of tick labels (7 pt).
pub const SMALL: f64 = 9.8;
/// Width of a data line.
pub const LINE: f64 = 1.5;
/// Width of axes, ticks and thin intervals.
pub const HAIR: f64 = 0.8;
/// Radius of a marker.
pub const MARKER: f64 = 3.4;
/// Opacity of a band of one standard deviation.
pub const BAND: f64 = 0.18;

/// The shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A filled circle.
    Circle,
    /// A filled square.
    Square,
    /// A filled diamond.
    Diamond,
    /// A filled triangle, point up.
    Triangle,
}

/// How a line is broken: lengths of stroke and gap in turn; empty for an unbroken line.
pub type Dash = &'static [f64];

/// An unbroken line.
pub const SOLID: Dash = &[];
/// Long strokes.
pub const DASHED: Dash = &[6.0, 3.0];
/// Dots.
pub const DOTTED: Dash = &[1.6, 2.4];
/// A stroke and a dot.
pub const DASH_DOT: Dash = &[6.0, 2.4, 1.6, 2.4];

/// How a series looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Colour of line, marker and band.
    pub colour: Colour,
    /// Marker.
    pub marker: Marker,
    /// Dash of the line.
    pub dash: Dash,
}

/// Looks in the order in which series take them.
pub const LOOKS: [Look; 6] = [
    Look { colour: BLUE, marker: Marker::Circle, dash: SOLID },
    Look { colour: VERMILION, marker: Marker::Square, dash: DASHED },
    Look { colour: GREEN, marker: Marker::Diamond, dash: DASH_DOT },
    Look { colour: PURPLE, marker: Marker::Triangle, dash: DOTTED },
    Look { colour: ORANGE, marker: Marker::Circle, dash: DASHED },
    Look { colour: SKY, marker: Marker::Square, dash: SOLID },
];

/// Policies of the paper in its order, as rows name them.
pub const POLICIES: [&str; 4] = ["a", "b", "c", "pi_real"];

/// How a policy looks in every figure.
pub fn policy_look(policy: &str) -> Look {
    let place = POLICIES.iter().position(|known| *known == policy);
    LOOKS[place.unwrap_or(POLICIES.len()).min(LOOKS.len() - 1)]
}

/// The name of a policy as the paper prints it.
pub fn policy_label(policy: &str) -> String {
    match policy {
        "a" | "b" | "c" => policy.to_uppercase(),
        "pi_real" => "πᵣₑₐₗ".to_owned(),
        other => other.to_owned(),
    }
}

/// The same in Markdown.
pub fn policy_markdown(policy: &str) -> String {
    if policy == "pi_real" { "π<sub>real</sub>".to_owned() } else { policy_label(policy) }
}

/// A way of training in two words.
pub fn training_short(training: &str) -> &str {
    if training == "paper" { "paper’s errors" } else { training }
}

/// What a way of training means, as a heading.
pub fn heading(training: &str) -> String {
    let words = training_label(training);
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// What a way of training means, in words.
pub fn training_label(training: &str) -> String {
    match training {
        "paper" => "networks stopped at the paper’s errors".to_owned(),
        "converged" => "networks trained to convergence".to_owned(),
        other => format!("training: {other}"),
    }
}
