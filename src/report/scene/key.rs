//! What the colours and lines of a drawn robot mean.

use maud::{Markup, PreEscaped, html};

use crate::data::scene::Scene;

/// Symbols in a box of 36 by 18, in the colour of their line.
const TAUT: &str = r#"<path d="M2 9h32" stroke-width="3"/>"#;
const SLACK: &str =
    r#"<path d="M2 9q8-12 16 0t16 0" stroke-width="2.4" fill="none" stroke-dasharray="6 4"/>"#;
const TARGET: &str = r#"<path d="M18 1v16M8 9h20" stroke-width="2.4"/><circle cx="18" cy="9" r="5" stroke-width="2.4" fill="none"/>"#;
const WAY: &str =
    r#"<path d="M2 13Q16-5 34 11" stroke-width="2" fill="none" stroke-dasharray="6 4"/>"#;
const TRAIL: &str = r#"<path d="M2 13Q16-5 34 11" stroke-width="2.6" fill="none"/>"#;
const MEASURED: &str = r#"<path d="M18 1l8 8-8 8-8-8z" fill="currentColor" stroke-width="0"/>"#;

/// The entries that these scenes need.
pub(super) fn key(scenes: &[Scene]) -> Markup {
    let frames = || scenes.iter().flat_map(|scene| &scene.frames);
    let tensions = || frames().flat_map(|frame| &frame.tensions_n);
    let moves = scenes.iter().any(|scene| {
        let mut targets = scene.frames.iter().filter_map(|frame| frame.target_m);
        let first = targets.next();
        targets.any(|target| Some(target) != first)
    });
    let tendons = scenes.iter().any(|scene| !scene.robot.tendons.is_empty());
    let entries = [
        (tendons, "taut", TAUT, "tendon, taut"),
        (tensions().any(|tension| *tension <= 0.0), "slack", SLACK, "tendon, slack"),
        (frames().any(|frame| frame.target_m.is_some()), "target", TARGET, "target"),
        (moves, "target", WAY, "path of the target"),
        (frames().any(|frame| frame.tip_m.is_some()), "trail", TRAIL, "path of the tip"),
        (frames().any(|frame| !frame.measured_m.is_empty()), "measured", MEASURED, "measured"),
    ];
    entries_list(entries.into_iter().filter(|entry| entry.0))
}

/// The entries of the live view.
pub(super) fn live_key() -> Markup {
    let entries = [
        (true, "taut", TAUT, "tendon, taut"),
        (true, "slack", SLACK, "tendon, slack"),
        (true, "trail", TRAIL, "path of the tip"),
    ];
    entries_list(entries.into_iter())
}

fn entries_list<'a>(entries: impl Iterator<Item = (bool, &'a str, &'a str, &'a str)>) -> Markup {
    html! {
        ul .scene-key {
            @for (_, class, symbol, label) in entries {
                li {
                    svg .{ "key-" (class) } viewBox="0 0 36 18" stroke="currentColor" aria-hidden="true" { (PreEscaped(symbol)) }
                    (label)
                }
            }
        }
    }
}
