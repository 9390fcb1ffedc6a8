//! Fig. 6: error against real data used. (a) π_real against the real points of its network; (b)
//! policy A against the real points of its Gaussian process. Open and closed loop, bands of one
//! standard deviation.

use crate::report::drawing::{
    Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend, text_width,
};
use crate::report::order::{distinct, trainings};
use crate::report::style::{
    BLUE, INK, LEFT_MARGIN, Look, MARKER, Marker, SOLID, TALL, TEXT, VERMILION, capitalised,
    training_short,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv};
use crate::rows::experiment::ReachSummaryRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "fig6",
    about: "Fig. 6: error against the number of real points, π_real and policy A",
    render,
};

const LOOKS: [(&str, &str, Look); 2] = [
    (
        "open",
        "open loop",
        Look { colour: VERMILION, marker: Marker::Square, dash: crate::report::style::DASHED },
    ),
    ("closed", "closed loop", Look { colour: BLUE, marker: Marker::Circle, dash: SOLID }),
];

/// One line of panels.
struct PolicyPanel {
    policy: &'static str,
    title: &'static str,
    size: fn(&ReachSummaryRow) -> u64,
}

const PARTS: [PolicyPanel; 2] = [
    PolicyPanel {
        policy: "pi_real", title: "(a) πᵣₑₐₗ", size: |row| row.cell.real_points
    },
    PolicyPanel { policy: "a", title: "(b) policy A", size: |row| row.cell.gp_points },
];

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let swept = published
        .trials
        .iter()
        .filter(|row| PARTS.iter().any(|part| part.policy == row.cell.policy));
    let swept: Vec<_> = swept
        .filter(|row| LOOKS.iter().any(|(mode, _, _)| *mode == row.cell.mode))
        .cloned()
        .collect();
    FIGURE.needs("trials.csv of pi_real or a", swept.is_empty())?;
    let summary = published.reach_summary(&swept);
    FIGURE.files(vec![csv("summary.csv", &summary)?], &caption(&summary), |width| {
        draw(published, &summary, width)
    })
}

fn caption(summary: &[ReachSummaryRow]) -> String {
    let seeds = summary.iter().map(|row| row.seeds).max().unwrap_or(0);
    let trials = summary.iter().map(|row| row.trials).max().unwrap_or(0);
    format!(
        "Goal-reaching error in mm against the number of real points (logarithmic axis): (a) πᵣₑₐₗ, \
         points that its network is trained on; (b) policy A, points that its Gaussian process is \
         fitted to. Marks are means over {trials} trials in {seeds} repetitions, bars their 95 % \
         intervals, bands one standard deviation over targets; hollow: the paper’s Table I."
    )
}

fn draw(published: &Published, summary: &[ReachSummaryRow], width: f64) -> Canvas {
    let columns = trainings(summary.iter().map(|row| row.training.as_str()));
    let parts: Vec<&PolicyPanel> = PARTS
        .iter()
        .filter(|part| summary.iter().any(|row| row.cell.policy == part.policy))
        .collect();
    let gap = 18.0;
    let wide =
        (width - LEFT_MARGIN - 14.0 - gap * (columns.len() - 1) as f64) / columns.len() as f64;
    let (high, pitch) = (150.0, 212.0);
    let mut canvas = Canvas::new(width, TALL);
    let mut keys: Vec<(LegendEntry, &str)> =
        LOOKS.iter().map(|(_, name, look)| (LegendEntry::Series(*look), *name)).collect();
    if published.context.is_paper_robot {
        keys.push((LegendEntry::Marker(Marker::Square, INK, true), "paper, open"));
        keys.push((LegendEntry::Marker(Marker::Circle, INK, true), "paper, closed"));
    }
    let top = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys) + 48.0;
    for (column, training) in columns.iter().enumerate() {
        let middle = LEFT_MARGIN + column as f64 * (wide + gap) + wide / 2.0;
        let label = published.training_label(training);
        let heading = if text_width(&label, TEXT, true) < wide {
            label
        } else {
            training_short(training).to_owned()
        };
        let at = [middle, top - 26.0];
        canvas.text(Text::new(capitalised(&heading), at, TEXT, TextAlign::Centre).bold());
    }
    for (line, part) in parts.iter().enumerate() {
        let y = errors(summary.iter().filter(|row| row.cell.policy == part.policy));
        for (column, training) in columns.iter().enumerate() {
            let rows: Vec<&ReachSummaryRow> = summary
                .iter()
                .filter(|row| row.cell.policy == part.policy && row.training == *training)
                .collect();
            let mut sizes = distinct(rows.iter().map(|row| (part.size)(row)));
            sizes.sort_unstable();
            let panel = canvas.panel(Panel {
                corner: [LEFT_MARGIN + column as f64 * (wide + gap), top + pitch * line as f64],
                size: [wide, high],
                x: Axis::sizes("real points", &sizes),
                y: if column == 0 { y.clone() } else { y.bare() },
                title: part.title.to_owned(),
            });
            lines(&mut canvas, &panel, &rows, part);
        }
    }
    canvas.height = (top + pitch * parts.len() as f64 - 14.0).round();
    canvas
}

/// The axis of errors, millimetres, with room for bands, intervals and the paper's points.
fn errors<'a>(rows: impl Iterator<Item = &'a ReachSummaryRow>) -> Axis {
    let ends = rows.flat_map(|row| {
        let spread = if row.sd_m.is_finite() { row.sd_m } else { 0.0 };
        [row.mean_m + spread, row.high_95_m, row.paper_mean_m].map(|value| 1e3 * value)
    });
    Axis::from_zero("error (mm)", ends, 5)
}

/// Open and closed loop in one panel. Bands go below all lines.
fn lines(canvas: &mut Canvas, panel: &Panel, rows: &[&ReachSummaryRow], part: &PolicyPanel) {
    let place = |row: &ReachSummaryRow| ((part.size)(row) as f64).log10();
    let of_mode = |mode: &str| {
        let mut rows: Vec<&ReachSummaryRow> =
            rows.iter().copied().filter(|row| row.cell.mode == mode && row.trials > 0).collect();
        rows.sort_by_key(|row| (part.size)(row));
        rows
    };
    let points = |rows: &[&ReachSummaryRow]| -> Vec<[f64; 3]> {
        rows.iter().map(|row| [place(row), 1e3 * row.mean_m, 1e3 * row.sd_m]).collect()
    };
    for (mode, _, look) in LOOKS {
        panel.band(canvas, &points(&of_mode(mode)), look);
    }
    for (index, (mode, _, look)) in LOOKS.into_iter().enumerate() {
        let rows = of_mode(mode);
        for row in rows.iter().filter(|row| row.low_95_m.is_finite()) {
            let ends = [1e3 * row.low_95_m, 1e3 * row.high_95_m]
                .map(|end| end.clamp(panel.y.low, panel.y.high));
            panel.interval(canvas, place(row), ends, look.colour);
        }
        panel.series(canvas, &points(&rows), look);
        for row in rows.iter().filter(|row| row.paper_mean_m.is_finite()) {
            // A little beside, so that neither covers the other.
            let aside = 0.025 * (panel.x.high - panel.x.low);
            let beside = place(row) + if index == 0 { -aside } else { aside };
            canvas.marker(
                panel.at(beside, 1e3 * row.paper_mean_m),
                look.marker,
                MARKER + 0.4,
                INK,
                true,
            );
        }
    }
}
