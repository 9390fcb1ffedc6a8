//! The player: scenes side by side on one clock and with one camera, in a page without network.

use maud::{Markup, PreEscaped, html};

use super::key::key;
use super::still::still;
use crate::data::scene::Scene;
use crate::report::drawing::svg;
use crate::report::html::document_with_head;

/// Geometry and drawing, which the live view shares.
pub(super) const VIEW_SCRIPT: &str = include_str!("assets/view.js");
/// Style of canvases, controls and keys.
pub(super) const STYLE: &str = include_str!("assets/player.css");
const PLAYER_SCRIPT: &str = include_str!("assets/player.js");

/// Speeds, times that of the robot; the middle one is the first.
const SPEEDS: [f64; 7] = [0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0];

/// A player of `scenes`, with all that it needs. Without scripts the page shows a still picture of
/// each scene's last frame. Scenes without frames are left out; without any there is no player.
pub fn player(title: &str, scenes: &[Scene]) -> Markup {
    let scenes: Vec<Scene> = scenes
        .iter()
        .filter(|scene| !scene.frames.is_empty())
        .cloned()
        .map(Scene::rounded)
        .collect();
    if scenes.is_empty() {
        return Markup::default();
    }
    html! {
        div .scene-player role="group" aria-label=(title) {
            style { (PreEscaped(STYLE)) }
            script type="application/json" .scene-data { (PreEscaped(json(&scenes))) }
            div .scene-panels {
                @for scene in &scenes {
                    div .scene-panel {
                        h4 { (scene.name) }
                        canvas tabindex="0" role="img" aria-label={ (scene.name) ": robot in three dimensions. Drag or arrow keys turn the view, plus and minus zoom, space plays." } {}
                        (PreEscaped(picture(scene)))
                        output {}
                    }
                }
            }
            div .scene-controls {
                button type="button" .scene-play { "Play" }
                input .scene-time type="range" aria-label="Time";
                span .scene-clock {}
                label { "Speed " select .scene-speed {
                    @for speed in SPEEDS { option value=(speed) selected[speed == 1.0] { (speed) "×" } }
                } }
                button type="button" .scene-reset { "Reset view" }
            }
            (key(&scenes))
            p .scene-state .scene-hidden aria-live="polite" {}
            script { (PreEscaped(scripts(&[VIEW_SCRIPT, PLAYER_SCRIPT]))) }
        }
    }
}

/// A page with one player.
pub fn player_page(title: &str, note: &str, scenes: &[Scene]) -> String {
    let content = html! {
        h1 { (title) }
        p { (note) }
        (player(title, scenes))
        p .scene-hint { "Drag or use the arrow keys to turn the view; + and − or the wheel zoom; space plays; 0 resets the view." }
    };
    document(title, &content)
}

/// A page of the viewer.
pub(super) fn document(title: &str, content: &Markup) -> String {
    let head = html! {
        // A browser asks a server for no icon.
        link rel="icon" href="data:,";
        style { (PreEscaped(include_str!("assets/page.css"))) }
    };
    document_with_head(title, &head, content)
}

/// JSON that stands inside a script element.
pub(super) fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default().replace('<', "\\u003c")
}

/// Scripts as one, each of whose names stays its own: a page may hold several players.
pub(super) fn scripts(parts: &[&str]) -> String {
    format!("(() => {{\n{}}})();", parts.concat())
}

/// The last frame for readers without scripts; nothing where it cannot be drawn.
fn picture(scene: &Scene) -> String {
    let drawn = svg(&still(scene)).unwrap_or_default();
    let svg = String::from_utf8_lossy(&drawn).into_owned();
    svg.replacen("<svg ", "<svg role=\"img\" aria-label=\"last frame\" ", 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::scene::SceneFrame;

    #[test]
    fn a_player_is_self_contained_and_escapes_names() {
        let nasty = "</script><script>alert(1)</script>".to_owned();
        let frames = vec![SceneFrame { tip_m: Some([0.1, 0.0, 0.2]), ..SceneFrame::default() }];
        let scene = Scene { name: nasty.clone(), frames, ..Scene::default() };
        let page = player(&nasty, &[scene]).into_string();
        assert!(!page.contains("alert(1)</script>"), "{page}");
        assert_eq!(page.matches("</script>").count(), 2);
        assert!(!page.contains("src=") && !page.contains("href="));
        assert!(player("nothing", &[Scene::default()]).into_string().is_empty());
    }
}
