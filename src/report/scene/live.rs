//! The page of the live view: sliders for the drives and the effects, and the robot that answers.

use maud::{PreEscaped, html};
use serde::Serialize;

use super::key::live_key;
use super::player::{STYLE, VIEW_SCRIPT, document, json, scripts};
use crate::data::scene::SceneRobot;

/// What the page needs to know of a model.
#[derive(Clone, Debug, Serialize)]
pub struct LiveView {
    /// The model, for the heading.
    pub name: String,
    /// Its robot.
    pub robot: SceneRobot,
    /// Tendons or drives.
    pub controls: Vec<LiveControl>,
    /// The catalogue's effects that this robot can have.
    pub effects: Vec<LiveEffect>,
}

/// A slider that displaces a tendon or a drive.
#[derive(Clone, Debug, Serialize)]
pub struct LiveControl {
    /// Its name.
    pub name: String,
    /// Unit of its displacement, `m` or `rad`.
    pub unit: &'static str,
    /// Largest displacement to either side.
    pub travel: f64,
    /// Index of the tendon on the other side of the backbone.
    pub opposite: Option<usize>,
}

/// An effect that can be switched on.
#[derive(Clone, Debug, Serialize)]
pub struct LiveEffect {
    /// Name in models.
    pub name: String,
    /// What a model without it lacks.
    pub missing: String,
    /// Whether the model has it.
    pub on: bool,
    /// Its parameters.
    pub parameters: Vec<LiveParameter>,
}

/// A slider for a parameter of an effect.
#[derive(Clone, Debug, Serialize)]
pub struct LiveParameter {
    /// Name in models.
    pub name: String,
    /// Its unit; `1` for a ratio.
    pub unit: String,
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Step of the slider.
    pub step: f64,
    /// Value at first.
    pub value: f64,
}

/// The page; its socket is `socket` beside it.
pub fn live_page(view: &LiveView) -> String {
    let content = html! {
        style { (PreEscaped(STYLE)) (PreEscaped(include_str!("assets/live.css"))) }
        script type="application/json" #live-data { (PreEscaped(json(view))) }
        h1 { (view.name) }
        div .live {
            div .live-robot {
                canvas #live-canvas tabindex="0" role="img" aria-label="Robot in three dimensions. Drag or arrow keys turn the view, plus and minus zoom." {}
                (live_key())
                p .scene-hint { "Drag or use the arrow keys to turn the view; + and − or the wheel zoom; 0 resets the view." }
            }
            div .live-panel {
                section aria-label="State" {
                    p #live-error role="alert" {}
                    table {
                        tbody {
                            tr { th scope="row" { "Tip" } td #live-tip { "–" } }
                            tr { th scope="row" { "Tensions" } td #live-tensions { "–" } }
                            tr { th scope="row" { "Solver" } td #live-status { "connecting" } }
                            tr { th scope="row" { "Time" } td #live-time { "–" } }
                        }
                    }
                    p #live-state .scene-hidden aria-live="polite" {}
                }
                section aria-label="Commands" {
                    h2 { "Displacements" }
                    p .scene-hint { "Positive pulls." }
                    div #live-controls {}
                    p .live-buttons {
                        label { input #live-opposite type="checkbox" checked; " The opposite tendon pays out" }
                        label { input #live-static type="checkbox"; " Static: show the equilibrium" }
                        button #live-home type="button" { "All to 0" }
                        button #live-restart type="button" { "Restart" }
                        button #live-view type="button" { "Reset view" }
                    }
                }
                section aria-label="Effects" {
                    h2 { "Effects" }
                    div #live-effects {}
                }
            }
        }
        script { (PreEscaped(scripts(&[VIEW_SCRIPT, include_str!("assets/live.js")]))) }
    };
    document(&view.name, &content)
}
