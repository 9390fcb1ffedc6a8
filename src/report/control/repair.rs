//! A changed robot and its repair: the error of goal reaching before, after, and mended in several
//! ways, by change and policy, in open and in closed loop.

use super::repair_table::{VARIANTS, markdown, summary_rows};
use crate::math::summary::mean;
use crate::report::cells::modes_in_order;
use crate::report::drawing::{
    Axis, Canvas, Dot, DotChart, DotPanel, DotRow, LegendEntry, MIN_PANEL, legend,
};
use crate::report::order::{distinct, last_training};
use crate::report::style::{
    INK, LOOKS, Marker, TALL, capitalised, mode_title, policies_in_order, policy_label,
    training_label,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::repairs::{RepairRow, RepairSummaryRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "repair",
    about: "A robot that changed: error before, after, repaired, and with new data, by change",
    render,
};

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs("repair_trials.csv", published.repair_trials.is_empty())?;
    let rows = summary_rows(&published.repair_trials, &published.repairs);
    FIGURE.files(
        vec![csv("repair_summary.csv", &rows)?, text("repair.md", markdown(&rows, published))],
        &caption(&rows),
        |width| draw(&rows, &published.repairs, width),
    )
}

fn caption(rows: &[RepairSummaryRow]) -> String {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let changes = distinct(rows.iter().map(|row| row.change.as_str())).len();
    let trials = rows.iter().map(|row| row.trials).max().unwrap_or(0);
    let seeds = rows.iter().map(|row| row.seeds).max().unwrap_or(0);
    format!(
        "Goal-reaching error of each policy before and after {changes} changes of the robot, and \
         after each way to repair the controller, in mm; {}. Marks are means over {trials} trials \
         in {seeds} repetitions. The hollow mark is the mean distance from a target to the nearest \
         equilibrium position of the tip of the changed robot: the lower bound for every \
         controller.",
        training_label(training)
    )
}

/// The variants as a legend names them.
fn variant_words(variant: &str) -> &'static str {
    match variant {
        "before" => "before the change",
        "changed" => "after it",
        "repaired" => "networks repaired",
        "moved_points" => "error model moved",
        "new_points" => "new points",
        "new_real" => "new data",
        _ => "other",
    }
}

/// The panels of the last kind of training: networks are at their best there.
fn draw(rows: &[RepairSummaryRow], repairs: &[RepairRow], width: f64) -> Canvas {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let rows: Vec<&RepairSummaryRow> = rows.iter().filter(|row| row.training == training).collect();
    let modes = modes_in_order(rows.iter().map(|row| row.cell.mode.as_str()));
    let changes = distinct(rows.iter().map(|row| row.change.as_str()));
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    let nearest = changes.iter().map(|change| nearest_mm(repairs, change));
    let means_mm = rows.iter().map(|row| 1e3 * row.mean_m).chain(nearest);
    let x = Axis::from_zero("error (mm)", means_mm, 4);
    let mut chart_rows = Vec::new();
    for change in &changes {
        chart_rows.push(DotRow::Heading(capitalised(&change.replace('_', " "))));
        chart_rows
            .extend(policies.iter().map(|name| DotRow::Named(policy_label(name).to_owned(), 1)));
    }
    let row_of = |change: &str, policy: &str| {
        let [change, policy] = [(&changes, change), (&policies, policy)]
            .map(|(names, name)| names.iter().position(|other| *other == name).unwrap_or(0));
        change * (policies.len() + 1) + 1 + policy
    };
    let panel = |mode: &&str| {
        let of_mode = rows.iter().filter(|row| row.cell.mode == **mode && row.mean_m.is_finite());
        let dots = of_mode.flat_map(|row| {
            let look = LOOKS[VARIANTS.rank(&row.variant).min(LOOKS.len() - 1)];
            let place = row_of(&row.change, &row.cell.policy);
            let nearest_mm = nearest_mm(repairs, &row.change);
            let nearest =
                Dot { hollow: true, ..Dot::new(place, 0, nearest_mm, Marker::Circle, INK) };
            let is_first = VARIANTS.rank(&row.variant) == 0 && nearest_mm.is_finite();
            let dot = Dot::new(place, 0, 1e3 * row.mean_m, look.marker, look.colour);
            is_first.then_some(nearest).into_iter().chain([dot])
        });
        let title = capitalised(&mode_title(mode));
        DotPanel { title, x: x.clone(), dots: dots.collect(), joined: false, goals: Vec::new() }
    };
    let chart = DotChart {
        rows: chart_rows,
        lane_height: 9.5,
        min_panel: MIN_PANEL,
        aside: 0.0,
        panels: modes.iter().map(panel).collect(),
    };
    let mut canvas = Canvas::new(width, TALL);
    let variants = VARIANTS.sorted(rows.iter().map(|row| row.variant.as_str()));
    let mut keys: Vec<(LegendEntry, &str)> = variants
        .into_iter()
        .map(|variant| {
            let look = LOOKS[VARIANTS.rank(variant).min(LOOKS.len() - 1)];
            (LegendEntry::Marker(look.marker, look.colour, false), variant_words(variant))
        })
        .collect();
    keys.push((LegendEntry::Marker(Marker::Circle, INK, true), "nearest possible"));
    let base = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys);
    canvas.height = chart.draw(&mut canvas, base + 30.0).round();
    canvas
}

/// How near a changed robot can come to the targets, mean over repetitions, millimetres.
fn nearest_mm(repairs: &[RepairRow], change: &str) -> f64 {
    let of_change =
        repairs.iter().filter(|row| row.change == change).map(|row| 1e3 * row.nearest_m);
    mean(&of_change.filter(|nearest_mm| nearest_mm.is_finite()).collect::<Vec<f64>>())
}
