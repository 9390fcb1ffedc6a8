//! Scaling of campaigns: efficiency and time over the number of nodes, simulated from recorded
//! stage times.

use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, legend, thousands};
use crate::report::style::{DASHED, GREY, HAIR, LEFT_MARGIN, LINE, LOOKS, MARKER, NARROW, TALL};
use crate::report::{Artifact, Figure, Published, ReportError, text};
use crate::rows::experiment::ScalingRow;
use std::fmt::Write as _;

/// Registry entry.
pub(super) const FIGURE: Figure =
    Figure { name: "scaling", about: "Efficiency and time over the number of nodes", render };

/// Drawn systems and their names in the figure.
const SYSTEMS: [(&str, &str); 2] =
    [("ideal cluster", "stages alone, best order"), ("workers", "workers: launches, locks, store")];

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let drawn =
        |row: &&ScalingRow| SYSTEMS.iter().any(|(name, _)| *name == row.system) && row.wall_s > 0.0;
    let rows: Vec<&ScalingRow> = published.scaling.iter().filter(drawn).collect();
    FIGURE.needs("scaling.csv with a replayed cluster", rows.is_empty())?;
    let tables = vec![text("scaling.md", markdown(&published.scaling))];
    FIGURE.files(tables, &caption(&rows), |width| draw(&rows, width))
}

fn caption(rows: &[&ScalingRow]) -> String {
    let stages = rows.iter().map(|row| row.stages).max().unwrap_or(0);
    format!(
        "A campaign of {} stages, whose times were recorded on one processor, replayed on \
         clusters: (a) total time in h and (b) share of the nodes’ time spent in stages, against \
         the number of nodes (logarithmic axis). Broken line: 90 %.",
        thousands(stages)
    )
}

fn draw(rows: &[&ScalingRow], width: f64) -> Canvas {
    let mut canvas = Canvas::new(width, TALL);
    let keys: Vec<(LegendEntry, &str)> = SYSTEMS
        .iter()
        .enumerate()
        .map(|(index, (_, words))| (LegendEntry::Plain(LOOKS[index]), *words))
        .collect();
    let top = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys) + 32.0;
    let max_workers = rows.iter().map(|row| row.workers as f64).fold(1.0, f64::max);
    let nodes = Axis::decades("nodes of one processor", [1.0, max_workers].into_iter());
    let time = Axis::decades("time (h)", rows.iter().map(|row| row.wall_s / 3600.0));
    let share = Axis::exact("time in stages (%)", 0.0, 100.0, 5);
    let (per_line, high) = if width < NARROW { (1, 140.0) } else { (2, 230.0) };
    let wide = width / per_line as f64 - LEFT_MARGIN - 16.0;
    for (index, (title, y)) in
        [("(a) Time", time), ("(b) Efficiency", share)].into_iter().enumerate()
    {
        let (line, column) = (index / per_line, index % per_line);
        let panel = canvas.panel(Panel {
            corner: [
                LEFT_MARGIN + (wide + LEFT_MARGIN + 8.0) * column as f64,
                top + (high + 62.0) * line as f64,
            ],
            size: [wide, high],
            x: nodes.clone(),
            y,
            title: title.to_owned(),
        });
        if index == 1 {
            panel.line(
                &mut canvas,
                &[[panel.x.low, 90.0], [panel.x.high, 90.0]],
                GREY,
                DASHED,
                HAIR,
            );
        }
        for (look, (system, _)) in LOOKS.iter().zip(SYSTEMS) {
            let value = |row: &ScalingRow| {
                if index == 0 { (row.wall_s / 3600.0).log10() } else { 100.0 * row.efficiency }
            };
            let of_system = rows.iter().filter(|row| row.system == system);
            let points: Vec<[f64; 2]> =
                of_system.map(|row| [(row.workers as f64).log10(), value(row)]).collect();
            panel.marked(&mut canvas, &points, *look, [LINE, MARKER]);
        }
    }
    canvas.height = (top + (high + 62.0) * (2 / per_line) as f64 - 14.0).round();
    canvas
}

fn markdown(rows: &[ScalingRow]) -> String {
    let mut page = String::from(
        "| system | workers | time | efficiency | through the store | largest loss | locks lost, \
         polls |\n| --- | ---: | ---: | ---: | ---: | --- | ---: |\n",
    );
    for row in rows {
        let time = if row.wall_s < 600.0 {
            format!("{:.1} s", row.wall_s)
        } else {
            format!("{:.2} h", row.wall_s / 3600.0)
        };
        let share = if row.efficiency.is_finite() {
            format!("{:.1} %", 100.0 * row.efficiency)
        } else {
            "–".to_owned()
        };
        let store = if row.store_gb.is_finite() {
            let operations = match row.store_operations {
                0 => String::new(),
                operations => format!(", {operations} operations"),
            };
            format!("{:.1} GB, {:.1} MB/s{operations}", row.store_gb, row.store_mb_s)
        } else {
            "–".to_owned()
        };
        let bound = if row.bound.is_empty() { "–" } else { &row.bound };
        let idle = if row.store_operations > 0 {
            format!("{}, {}", row.locks_lost, row.polls)
        } else {
            "–".to_owned()
        };
        let _ = writeln!(
            page,
            "| {} | {} | {time} | {share} | {store} | {bound} | {idle} |",
            row.system, row.workers
        );
    }
    page
}
