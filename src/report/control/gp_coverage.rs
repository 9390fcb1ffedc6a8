//! Do the intervals of the Gaussian process hold what they promise? The covered share of unseen
//! points against the promised one, by axis.

use crate::math::summary::mean;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, legend};
use crate::report::order::{ascending, distinct};
use crate::report::style::{DASHED, GREY, HAIR, LEFT_MARGIN, LOOKS, Look, NARROW, TALL};
use crate::report::{Artifact, Figure, Published, ReportError};
use crate::rows::experiment::GpCoverageRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "gp_coverage",
    about: "Intervals of the Gaussian process: coverage on unseen points against nominal coverage",
    render,
};

const PANEL_GAP: f64 = 18.0;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs("gp_coverage.csv", published.gp_coverages.is_empty())?;
    let rows = &published.gp_coverages;
    FIGURE.files(Vec::new(), &caption(rows), |width| draw(rows, width))
}

fn caption(rows: &[GpCoverageRow]) -> String {
    let seeds = distinct(rows.iter().map(|row| row.seed)).len();
    format!(
        "Coverage of intervals of the Gaussian process on unseen points against their nominal \
         coverage, both in %, along each axis of the tip, by number of real points. Marks are \
         means over {seeds} repetitions; below the broken line the intervals are too narrow."
    )
}

fn draw(rows: &[GpCoverageRow], width: f64) -> Canvas {
    let mut sizes = distinct(rows.iter().map(|row| row.coverage.points));
    sizes.sort_unstable();
    let looks: Vec<Look> = (0..sizes.len()).map(|index| LOOKS[index % LOOKS.len()]).collect();
    let names: Vec<String> = sizes.iter().map(|points| format!("{points} points")).collect();
    let keys: Vec<(LegendEntry, &str)> = looks
        .iter()
        .map(|look| LegendEntry::Plain(*look))
        .zip(names.iter().map(String::as_str))
        .collect();
    let axes = distinct(rows.iter().map(|row| row.coverage.axis.as_str()));
    let per_line = if width < NARROW { 2 } else { axes.len().max(1) };
    let wide = (width - LEFT_MARGIN - 14.0 - PANEL_GAP * (per_line - 1) as f64) / per_line as f64;
    let mut canvas = Canvas::new(width, TALL);
    let top = legend(&mut canvas, [LEFT_MARGIN, 16.0], width - 8.0, &keys) + 30.0;
    let y = Axis::exact("covered (%)", 0.0, 100.0, 5);
    for (place, axis) in axes.iter().enumerate() {
        let (line, column) = (place / per_line, place % per_line);
        let left = LEFT_MARGIN + column as f64 * (wide + PANEL_GAP);
        let panel = canvas.panel(Panel {
            corner: [left, top + (wide + 62.0) * line as f64],
            size: [wide, wide],
            x: Axis::exact("promised (%)", 0.0, 100.0, 5),
            y: if column == 0 { y.clone() } else { y.bare() },
            title: format!("Gap along {axis}"),
        });
        panel.line(&mut canvas, &[[0.0, 0.0], [100.0, 100.0]], GREY, DASHED, HAIR);
        for (points, look) in sizes.iter().zip(&looks) {
            let of_curve =
                |row: &&GpCoverageRow| row.coverage.axis == *axis && row.coverage.points == *points;
            let shares = ascending(rows.iter().filter(of_curve).map(|row| row.coverage.promised));
            let point = |promised: &f64| {
                let same_share =
                    rows.iter().filter(of_curve).filter(|row| row.coverage.promised == *promised);
                let covered = mean(&same_share.map(|row| row.coverage.covered).collect::<Vec<_>>());
                [100.0 * promised, 100.0 * covered, f64::NAN]
            };
            let line: Vec<[f64; 3]> =
                shares.iter().map(point).filter(|point| point[1].is_finite()).collect();
            panel.series(&mut canvas, &line, *look);
        }
    }
    let lines = axes.len().div_ceil(per_line) as f64;
    canvas.height = (top + (wide + 62.0) * lines - 16.0).round();
    canvas
}
