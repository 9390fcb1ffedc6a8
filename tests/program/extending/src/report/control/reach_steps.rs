//! Control steps until a goal-reaching trial ends, by policy.

use crate::report::drawing::{Axis, Canvas, Panel};
use crate::report::style::{LEFT_MARGIN, MARKER, policies_in_order, policy_label, policy_look};
use crate::report::{Artifact, Figure, Published, ReportError};
use crate::rows::experiment::TrialRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "reach_steps",
    about: "Control steps until a goal-reaching trial ends, by policy",
    render,
};

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs("trials.csv", published.trials.is_empty())?;
    let caption =
        "Control steps until a goal-reaching trial ends, a mark for each trial, by policy.";
    FIGURE.files(Vec::new(), caption, |width| draw(&published.trials, width))
}

/// The picture at a width in hundredths of an inch: that of a page, or of one column.
fn draw(trials: &[TrialRow], width: f64) -> Canvas {
    let policies = policies_in_order(trials.iter().map(|row| row.cell.policy.as_str()));
    let names: Vec<String> =
        policies.iter().map(|policy| policy_label(policy).to_owned()).collect();
    let mut canvas = Canvas::new(width, 260.0);
    let panel = Panel {
        corner: [LEFT_MARGIN, 30.0],
        size: [width - LEFT_MARGIN - 14.0, 180.0],
        x: Axis::categories("policy", &names),
        y: Axis::covering(
            "control steps",
            trials.iter().map(|row| row.steps as f64).chain([0.0]),
            5,
        ),
        title: "Steps until a trial ends".to_owned(),
    };
    panel.draw(&mut canvas);
    for (place, policy) in policies.iter().enumerate() {
        let look = policy_look(policy);
        for row in trials.iter().filter(|row| row.cell.policy == *policy) {
            canvas.marker(
                panel.at(place as f64, row.steps as f64),
                look.marker,
                MARKER,
                look.colour,
                false,
            );
        }
    }
    canvas
}
