//! Scaling of campaigns: efficiency and time over the number of nodes, simulated from recorded
//! stage times.

use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::style::{DASHED, GREY, HAIR, LINE, LOOKS, MARKER, PAGE_WIDTH, SMALL};
use crate::report::{Artifact, Figure, Published, ReportError, text};
use crate::rows::experiment::ScalingRow;
use std::fmt::Write as _;

/// Registry entry.
pub(super) const FIGURE: Figure =
    Figure { name: "scaling", about: "Efficiency and time over the number of nodes", render };

/// Drawn systems and their names in the figure.
const SYSTEMS: [(&str, &str); 2] =
    [("ideal cluster", "stages alone, best order"), ("workers", "workers: launches, locks, store")];
const PANEL_HEIGHT: f64 = 230.0;
const LEFT_MARGIN: f64 = 58.0;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let drawn =
        |row: &&ScalingRow| SYSTEMS.iter().any(|(name, _)| *name == row.system) && row.wall_s > 0.0;
    let rows: Vec<&ScalingRow> = published.scaling.iter().filter(drawn).collect();
    FIGURE.needs("scaling.csv with a replayed cluster", rows.is_empty())?;
    FIGURE.files(vec![text("scaling.md", markdown(&published.scaling))], &draw(&rows))
}

fn draw(rows: &[&ScalingRow]) -> Canvas {
    let mut canvas = Canvas::new(PAGE_WIDTH, 348.0);
    let keys: Vec<(LegendEntry, &str)> = SYSTEMS
        .iter()
        .enumerate()
        .map(|(index, (_, words))| (LegendEntry::Plain(LOOKS[index]), *words))
        .collect();
    let below = legend(&mut canvas, [LEFT_MARGIN, 18.0], PAGE_WIDTH - 12.0, &keys);
    let max_workers = rows.iter().map(|row| row.workers as f64).fold(1.0, f64::max);
    let nodes = Axis::decades("nodes of one processor", [1.0, max_workers].into_iter());
    let time =
        Axis::decades("time from begin to end (h)", rows.iter().map(|row| row.wall_s / 3600.0));
    let share = Axis::exact("share of the nodes’ time in stages (%)", 0.0, 100.0, 5);
    let wide = (PAGE_WIDTH - LEFT_MARGIN - 14.0) / 2.0;
    for (index, (title, y)) in
        [("(a) time", time), ("(b) efficiency", share)].into_iter().enumerate()
    {
        let panel = canvas.panel(Panel {
            corner: [LEFT_MARGIN + (wide + 14.0) * index as f64, below + 34.0],
            size: [wide - 44.0, PANEL_HEIGHT],
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
    let stages = rows.iter().map(|row| row.stages).max().unwrap_or(0);
    let note = format!("{stages} stages, their times recorded on one processor; dashed: 90 %");
    canvas.text(
        Text::new(
            &note,
            [PAGE_WIDTH - 14.0, below + 34.0 + PANEL_HEIGHT + 44.0],
            SMALL,
            TextAlign::Right,
        )
        .colour(GREY),
    );
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
