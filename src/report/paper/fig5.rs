//! Fig. 5: tips that the model computes and tips that the “real” robot shows, under the same commands:
//! three projections, and how the difference is distributed along each axis.

use crate::base::Point3;
use crate::math::summary::{mean, quantile, root_mean_square};
use crate::report::drawing::{
    Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend, range, signed, thousands,
};
use crate::report::order::distinct;
use crate::report::style::{BLUE, DASHED, GREY, INK, LEFT_MARGIN, NARROW, SMALL, TALL, VERMILION};
use crate::report::{Artifact, Figure, Published, ReportError, csv};
use crate::rows::experiment::{GapRow, GapSummaryRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "fig5",
    about: "Fig. 5: workspace of the model and of the simulated “real” robot, and their difference",
    render,
};

const AXES: [&str; 3] = ["x", "y", "z"];
/// Horizontal and vertical axis of each projection.
const PROJECTIONS: [(usize, usize); 3] = [(2, 0), (2, 1), (1, 0)];
/// Dots of each kind in a projection: more would only cover each other.
const MAX_DOTS: usize = 900;
const BINS: usize = 40;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let gaps = &published.gaps;
    FIGURE.needs("gap.csv", gaps.is_empty())?;
    let summary = summary(gaps);
    FIGURE.files(vec![csv("summary.csv", &summary)?], &caption(gaps), |width| draw(gaps, width))
}

fn simulated(row: &GapRow) -> Point3 {
    [row.gap.sim_x_m, row.gap.sim_y_m, row.gap.sim_z_m]
}

fn real(row: &GapRow) -> Point3 {
    [row.gap.real_x_m, row.gap.real_y_m, row.gap.real_z_m]
}

/// Differences along one axis, simulated minus measured as the paper's e = p_sim − p_exp; metres.
fn differences_m(gaps: &[GapRow], axis: usize) -> Vec<f64> {
    gaps.iter()
        .map(|row| simulated(row)[axis] - real(row)[axis])
        .filter(|gap| gap.is_finite())
        .collect()
}

fn summary(gaps: &[GapRow]) -> Vec<GapSummaryRow> {
    let seeds = distinct(gaps.iter().map(|row| row.seed));
    let row = |axis: &str, gaps_m: Vec<f64>| {
        let sizes: Vec<f64> = gaps_m.iter().map(|gap| gap.abs()).collect();
        GapSummaryRow {
            axis: axis.to_owned(),
            mean_m: mean(&gaps_m),
            rms_m: root_mean_square(&gaps_m),
            p95_m: quantile(&sizes, 0.95),
            max_m: quantile(&sizes, 1.0),
            samples: gaps_m.len() as u64,
            seeds: seeds.len() as u64,
        }
    };
    let distances = gaps.iter().map(|row| crate::base::distance_m(&simulated(row), &real(row)));
    let distances: Vec<f64> = distances.filter(|distance| distance.is_finite()).collect();
    let axes = AXES.iter().enumerate().map(|(axis, name)| row(name, differences_m(gaps, axis)));
    axes.chain([row("distance", distances)]).collect()
}

fn caption(gaps: &[GapRow]) -> String {
    let seeds = distinct(gaps.iter().map(|row| row.seed)).len();
    let stride = gaps.len().div_ceil(MAX_DOTS).max(1);
    let dots = if stride == 1 { String::new() } else { format!(" (one in {stride} is drawn)") };
    format!(
        "Tips of the model and tips of the simulated “real” robot under the same {} commands in \
         {seeds} repetitions{dots}: (a) to (c) three projections in mm; (d) to (f) share of \
         samples against the difference along each axis, model minus “real”. Broken lines are \
         means; samples beyond an axis are counted in its outer bins.",
        thousands(gaps.len() as u64)
    )
}

fn draw(gaps: &[GapRow], width: f64) -> Canvas {
    let stride = gaps.len().div_ceil(MAX_DOTS).max(1);
    let shown: Vec<&GapRow> = gaps.iter().step_by(stride).collect();
    let spans = spans_mm(gaps);
    let span = |axis: usize| spans[axis][1] - spans[axis][0];
    let is_narrow = width < NARROW;
    // One scale for all three projections, so that shapes are true and can be compared.
    let free_width = width - 3.0 * LEFT_MARGIN - 12.0;
    let scale = if is_narrow {
        ((width - LEFT_MARGIN - 14.0) / span(1)).min(180.0 / span(0))
    } else {
        (free_width / PROJECTIONS.iter().map(|(across, _)| span(*across)).sum::<f64>())
            .min(260.0 / span(0))
    };
    let axes: Vec<Axis> = (0..3)
        .map(|axis| {
            let ticks = (scale * span(axis) / 42.0).round().max(2.0) as usize;
            Axis::exact(&format!("{} (mm)", AXES[axis]), spans[axis][0], spans[axis][1], ticks)
        })
        .collect();
    let mut canvas = Canvas::new(width, TALL);
    let keys = [
        (LegendEntry::Dot(BLUE), "model"),
        (LegendEntry::Dot(VERMILION), "simulated “real” robot"),
    ];
    let mut top = legend(&mut canvas, [10.0, 16.0], width, &keys) + 28.0;
    let high = scale * span(0);
    let mut left = LEFT_MARGIN;
    for (index, (across, up)) in PROJECTIONS.into_iter().enumerate() {
        if is_narrow && index == 2 {
            (left, top) = (LEFT_MARGIN, top + high + 62.0);
        }
        let panel = canvas.panel(Panel {
            corner: [left, top + high - scale * span(up)],
            size: [scale * span(across), scale * span(up)],
            x: axes[across].clone(),
            y: axes[up].clone(),
            title: format!("({}) {}–{}", ["a", "b", "c"][index], AXES[across], AXES[up]),
        });
        for (points, colour) in [(simulated as fn(&GapRow) -> Point3, BLUE), (real, VERMILION)] {
            for point in shown
                .iter()
                .map(|row| points(row))
                .filter(|point| point.iter().all(|part| part.is_finite()))
            {
                canvas.disc(panel.at(1e3 * point[across], 1e3 * point[up]), 1.15, colour, 0.5);
            }
        }
        left += panel.size[0] + LEFT_MARGIN;
    }
    canvas.height = histograms(&mut canvas, gaps, top + high + 70.0).round();
    canvas
}

/// What each axis shows, millimetres; x and y alike, so that the projections stand side by side.
fn spans_mm(gaps: &[GapRow]) -> [[f64; 2]; 3] {
    let tips_mm = |axis: usize| {
        gaps.iter().flat_map(move |row| [1e3 * simulated(row)[axis], 1e3 * real(row)[axis]])
    };
    let wide = |(low, high): (f64, f64)| [low - 0.04 * (high - low), high + 0.04 * (high - low)];
    let across = wide(range(tips_mm(0).chain(tips_mm(1))));
    [across, across, wide(range(tips_mm(2)))]
}

/// Share of the samples by difference, one panel an axis, all to one scale. Returns where they end.
fn histograms(canvas: &mut Canvas, gaps: &[GapRow], top: f64) -> f64 {
    let gaps_mm: Vec<Vec<f64>> = (0..3)
        .map(|axis| differences_m(gaps, axis).iter().map(|gap| 1e3 * gap).collect())
        .collect();
    // Single outliers do not stretch the scale: the outer bins take them.
    let (low, high) =
        range(gaps_mm.iter().flat_map(|gaps| [quantile(gaps, 0.001), quantile(gaps, 0.999)]));
    let largest = low.abs().max(high.abs());
    let x = Axis::covering("", [-largest, largest].into_iter(), 4);
    let width = (x.high - x.low) / BINS as f64;
    let shares: Vec<Vec<f64>> = gaps_mm.iter().map(|gaps| shares(gaps, x.low, width)).collect();
    let y = Axis::covering("samples (%)", shares.iter().flatten().copied().chain([0.0]), 4);
    let per_line = if canvas.width < NARROW { 1 } else { 3 };
    let gap = 24.0;
    let wide = (canvas.width - LEFT_MARGIN - 12.0 - gap * (per_line - 1) as f64) / per_line as f64;
    let (high, pitch) = if per_line == 1 { (70.0, 124.0) } else { (110.0, 160.0) };
    let first_line = top;
    for axis in 0..3 {
        let (line, column) = (axis / per_line, axis % per_line);
        let top = first_line + pitch * line as f64;
        let panel = canvas.panel(Panel {
            corner: [LEFT_MARGIN + (wide + gap) * column as f64, top],
            size: [wide, high],
            x: Axis { label: format!("model − “real”, {} (mm)", AXES[axis]), ..x.clone() },
            y: if column == 0 { y.clone() } else { y.bare() },
            title: format!("({}) along {}", ["d", "e", "f"][axis], AXES[axis]),
        });
        for (bin, share) in shares[axis].iter().enumerate().filter(|(_, share)| **share > 0.0) {
            let from = x.low + bin as f64 * width;
            let corners = [panel.at(from, 0.0), panel.at(from + width, *share)];
            canvas.rectangle(
                [corners[0][0] + 0.3, corners[0][1]],
                [corners[1][0] - 0.3, corners[1][1]],
                GREY,
                0.75,
            );
        }
        panel.line(canvas, &[[0.0, y.low], [0.0, y.high]], INK, &[], 0.8);
        let centre = mean(&gaps_mm[axis]);
        panel.line(canvas, &[[centre, y.low], [centre, y.high]], VERMILION, DASHED, 1.3);
        let rms = root_mean_square(&gaps_mm[axis]);
        let labels = [format!("mean {} mm", signed(centre, 1)), format!("rms {rms:.1} mm")];
        // On the side where the mean is not.
        let (edge, align) = if centre > 0.0 {
            (2.0, TextAlign::Left)
        } else {
            (panel.size[0] - 2.0, TextAlign::Right)
        };
        for (line, label) in labels.into_iter().enumerate() {
            let at = [panel.corner[0] + edge, top + 10.0 + 13.0 * line as f64];
            canvas.text(Text::new(label, at, SMALL, align));
        }
    }
    first_line + pitch * (3 / per_line) as f64 - 4.0
}

/// Percentage of the values in each bin; the first and last bins take what lies beyond.
fn shares(values: &[f64], low: f64, width: f64) -> Vec<f64> {
    let mut counts = vec![0.0; BINS];
    for value in values {
        let bin = ((value - low) / width).floor().clamp(0.0, (BINS - 1) as f64) as usize;
        counts[bin] += 100.0 / values.len() as f64;
    }
    counts
}
