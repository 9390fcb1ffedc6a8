//! A population of robots: the error of each policy over robots, and the share of robots on which
//! each claim holds.

use super::population_table::{attribution_rows, markdown, population_rows};
use crate::report::cells::modes_in_order;
use crate::report::drawing::{
    Axis, Canvas, Dot, DotChart, DotPanel, DotRow, LegendEntry, MIN_PANEL, Text, TextAlign, legend,
};
use crate::report::order::last_training;
use crate::report::style::{
    INK, Marker, TALL, TEXT, capitalised, claim_words, mode_title, policies_in_order, policy_label,
    policy_look, training_label,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::population::{PopulationRow, RobotClaimRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "population",
    about: "Population of robots: error of each policy, and share of robots on which each claim \
            holds",
    render,
};

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let Published { trials, robots, robot_claims: claims, robot_errors, .. } = published;
    FIGURE.needs(
        "robots.csv and trials.csv",
        robots.is_empty() || trials.is_empty() && robot_errors.is_empty(),
    )?;
    if trials.is_empty() {
        // The tables of these robots are published in place of their trials.
        return FIGURE
            .files(Vec::new(), &caption(robot_errors), |width| draw(robot_errors, claims, width));
    }
    let rows = population_rows(trials);
    let effects = attribution_rows(trials, robots);
    let mut files = vec![
        csv("population.csv", &rows)?,
        text("population.md", markdown(&rows, claims, &effects)),
    ];
    // Of few robots no effect can be told.
    if !effects.is_empty() {
        files.push(csv("attribution.csv", &effects)?);
    }
    FIGURE.files(files, &caption(&rows), |width| draw(&rows, claims, width))
}

fn caption(rows: &[PopulationRow]) -> String {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let robots = rows.iter().map(|row| row.robots).max().unwrap_or(0);
    format!(
        "Goal-reaching error of each policy over {robots} simulated robots with different missing \
         effects, in mm on a logarithmic axis, by mode; {}. Mark: median over robots, also \
         in numbers; thick: half of all robots; thin: 90 %; hollow: the worst robot. Below: the share of robots \
         on which each claim of the paper holds, with Wilson’s 95 % interval.",
        training_label(training)
    )
}

/// Panels of the last kind of training: networks are at their best there.
fn draw(rows: &[PopulationRow], claims: &[RobotClaimRow], width: f64) -> Canvas {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let rows: Vec<&PopulationRow> = rows.iter().filter(|row| row.training == training).collect();
    let claims: Vec<&RobotClaimRow> =
        claims.iter().filter(|row| row.training == training).collect();
    let modes = modes_in_order(rows.iter().map(|row| row.cell.mode.as_str()));
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    let x = Axis::log(
        "error (mm)",
        // Room for the number right of the worst robot.
        rows.iter().flat_map(|row| [1e3 * row.p05_m, 2.0 * 1e3 * row.largest_m]),
        110.0,
    );
    let panel = |mode: &&str| {
        let of_mode = rows.iter().filter(|row| row.cell.mode == **mode);
        let dots = of_mode.flat_map(|row| {
            let place = policies.iter().position(|name| *name == row.cell.policy).unwrap_or(0);
            spread(place, row)
        });
        let title = capitalised(&mode_title(mode));
        DotPanel { title, x: x.clone(), dots: dots.collect(), joined: false, goals: Vec::new() }
    };
    let chart = DotChart {
        rows: policies.iter().map(|name| DotRow::Named(policy_label(name).to_owned(), 1)).collect(),
        lane_height: 15.0,
        min_panel: 90.0,
        aside: 0.0,
        panels: modes.iter().map(panel).collect(),
    };
    let mut canvas = Canvas::new(width, TALL);
    let keys = [
        (LegendEntry::Marker(Marker::Circle, INK, false), "median robot"),
        (LegendEntry::Marker(Marker::Diamond, INK, true), "worst robot"),
    ];
    legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys);
    let mut below = chart.draw(&mut canvas, 46.0);
    if !claims.is_empty() {
        below = shares(&mut canvas, &claims, below + 22.0);
    }
    canvas.height = below.round();
    canvas
}

/// The errors of one policy over robots: the median in numbers above the marks.
fn spread(row: usize, errors: &PopulationRow) -> Vec<Dot> {
    let look = policy_look(&errors.cell.policy);
    let at = |error_m: f64| (1e3 * error_m).log10();
    if !(errors.p05_m > 0.0 && errors.largest_m.is_finite()) {
        return Vec::new();
    }
    let dot = |value, marker| Dot::new(row, 0, value, marker, look.colour);
    vec![
        Dot {
            thin: Some([at(errors.p05_m), at(errors.p95_m)]),
            thick: Some([at(errors.p25_m), at(errors.p75_m)]),
            ..dot(at(errors.median_m), look.marker)
        },
        Dot {
            hollow: true,
            words: format!("{:.1}", 1e3 * errors.median_m),
            ..dot(at(errors.largest_m), Marker::Diamond)
        },
    ]
}

/// The share of robots on which each claim holds, below `top`; returns where it ends.
fn shares(canvas: &mut Canvas, claims: &[&RobotClaimRow], top: f64) -> f64 {
    let dot = |(row, claim): (usize, &&RobotClaimRow)| Dot {
        thin: Some([100.0 * claim.low_95, 100.0 * claim.high_95]),
        ..Dot::new(row, 0, 100.0 * claim.share, Marker::Circle, INK)
    };
    let name = |claim: &&RobotClaimRow| {
        let words =
            format!("{}: {} of {}", claim_words(&claim.statement), claim.held, claim.robots);
        DotRow::Named(words, 1)
    };
    let chart = DotChart {
        rows: claims.iter().map(name).collect(),
        lane_height: 14.0,
        min_panel: MIN_PANEL,
        aside: 0.0,
        panels: vec![DotPanel {
            title: String::new(),
            x: Axis::exact("robots on which it holds (%)", 0.0, 100.0, 4),
            dots: claims.iter().enumerate().map(dot).collect(),
            joined: false,
            goals: Vec::new(),
        }],
    };
    canvas.text(Text::new("Claims of the paper", [10.0, top], TEXT, TextAlign::Left).bold());
    chart.draw(canvas, top + 10.0)
}
