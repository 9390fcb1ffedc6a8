//! Do the intervals of the Gaussian process hold what they promise? The covered share of unseen
//! points against the promised one, by axis.

use crate::math::summary::mean;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::order::{ascending, distinct};
use crate::report::style::{DASHED, GREY, HAIR, LEFT_MARGIN, LOOKS, Look, PAGE_WIDTH, SMALL, TALL};
use crate::report::{Artifact, Figure, Published, ReportError};
use crate::rows::experiment::GpCoverageRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "gp_coverage",
    about: "Intervals of the Gaussian process: share of unseen points that they cover against the \
            promised one",
    render,
};

const PANEL_GAP: f64 = 18.0;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs("gp_coverage.csv", published.gp_coverages.is_empty())?;
    FIGURE.files(Vec::new(), &draw(&published.gp_coverages))
}

fn draw(rows: &[GpCoverageRow]) -> Canvas {
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
    let wide =
        (PAGE_WIDTH - LEFT_MARGIN - 12.0 - PANEL_GAP * (axes.len() - 1) as f64) / axes.len() as f64;
    let mut canvas = Canvas::new(PAGE_WIDTH, TALL);
    let below = legend(&mut canvas, [LEFT_MARGIN, 16.0], PAGE_WIDTH - 8.0, &keys);
    let note = "means over repetitions; below the broken line: intervals too narrow";
    canvas.text(Text::new(note, [LEFT_MARGIN, below + 17.0], SMALL, TextAlign::Left).colour(GREY));
    let top = below + 44.0;
    let y = Axis::exact("covered (%)", 0.0, 100.0, 5);
    for (column, axis) in axes.iter().enumerate() {
        let panel = canvas.panel(Panel {
            corner: [LEFT_MARGIN + column as f64 * (wide + PANEL_GAP), top],
            size: [wide, wide],
            x: Axis::exact("promised (%)", 0.0, 100.0, 5),
            y: if column == 0 { y.clone() } else { y.bare() },
            title: format!("gap along {axis}"),
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
    canvas.height = (top + wide + 46.0).round();
    canvas
}
