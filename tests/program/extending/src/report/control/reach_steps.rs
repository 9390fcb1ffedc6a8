//! Control steps until a goal-reaching trial ends, by policy.

use crate::report::drawing::{Axis, Canvas, Panel};
use crate::report::style::{MARKER, PAGE_WIDTH, policies_in_order, policy_label, policy_look};
use crate::report::{Artifact, Figure, Published, ReportError, pictures};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "reach_steps",
    about: "Control steps until a goal-reaching trial ends, by policy",
    render,
};

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let trials = &published.trials;
    if trials.is_empty() {
        return Err(ReportError::NoRows { figure: FIGURE.name, needs: "trials.csv" });
    }
    let policies = policies_in_order(trials.iter().map(|row| row.cell.policy.as_str()));
    let names: Vec<String> =
        policies.iter().map(|policy| policy_label(policy).to_owned()).collect();
    let mut canvas = Canvas::new(PAGE_WIDTH, 260.0);
    let panel = Panel {
        corner: [58.0, 30.0],
        size: [640.0, 180.0],
        x: Axis::categories("policy", &names),
        y: Axis::covering(
            "control steps",
            trials.iter().map(|row| row.steps as f64).chain([0.0]),
            5,
        ),
        title: "steps until a trial ends".to_owned(),
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
    Ok(pictures(FIGURE.name, FIGURE.name, &canvas)?.to_vec())
}
