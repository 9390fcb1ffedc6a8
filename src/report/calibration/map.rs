//! Where the calibrated model errs: an arrow from each measured position to the simulated one, from
//! the side, from above and along the robot.

use super::CalibrationReport;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, legend};
use crate::report::style::{BLUE, GREY, SOLID, TALL, VERMILION};

/// Arrows: more would cover each other.
const MAX_ARROWS: usize = 220;
/// Horizontal and vertical axis of each view.
const VIEWS: [(usize, usize); 3] = [(2, 0), (2, 1), (0, 1)];
const AXES: [&str; 3] = ["x (mm)", "y (mm)", "z (mm)"];

/// A position and its error, millimetres.
struct Arrow {
    from: [f64; 3],
    to: [f64; 3],
}

/// The picture at a width in hundredths of an inch; none without positions.
pub(super) fn draw(report: &CalibrationReport, width: f64) -> Option<Canvas> {
    let solved: Vec<_> = report.sightings.iter().filter(|row| row.error_x_m.is_finite()).collect();
    let count = solved.len().min(MAX_ARROWS);
    let arrow = |k: usize| {
        let row = solved[k * solved.len() / count];
        let from = [row.x_m, row.y_m, row.z_m].map(|x| 1e3 * x);
        let error = [row.error_x_m, row.error_y_m, row.error_z_m];
        Arrow { from, to: std::array::from_fn(|axis| from[axis] + 1e3 * error[axis]) }
    };
    let arrows: Vec<Arrow> = (0..count).map(arrow).collect();
    if arrows.is_empty() {
        return None;
    }
    let in_row = if width > 500.0 { 3 } else { 1 };
    let room = (width - 20.0) / in_row as f64 - 62.0;
    let rows = VIEWS.len().div_ceil(in_row);
    let mut canvas = Canvas::new(width, TALL);
    let keys = [
        (LegendEntry::Dot(GREY), "measured"),
        (LegendEntry::Dot(BLUE), "simulated with the fitted model"),
        (LegendEntry::Line(VERMILION, SOLID), "error"),
    ];
    let top = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys) + 12.0;
    canvas.height = (top + rows as f64 * (room + 60.0)).ceil();
    for (index, &(across, up)) in VIEWS.iter().enumerate() {
        let spans = [across, up].map(|axis| span(&arrows, axis));
        let half = 0.52 * spans.iter().map(|[low, high]| high - low).fold(1.0, f64::max);
        let axis = |which: usize, name: usize| {
            let middle = 0.5 * (spans[which][0] + spans[which][1]);
            Axis::exact(AXES[name], middle - half, middle + half, 4)
        };
        let panel = canvas.panel(Panel {
            corner: [
                52.0 + (index % in_row) as f64 * (room + 62.0),
                top + (index / in_row) as f64 * (room + 60.0),
            ],
            size: [room, room],
            x: axis(0, across),
            y: axis(1, up),
            title: String::new(),
        });
        for arrow in &arrows {
            let [from, to] = [arrow.from, arrow.to].map(|at| panel.at(at[across], at[up]));
            canvas.line(&[from, to], 0.9, VERMILION, &[]);
            canvas.disc(from, 1.5, GREY, 0.9);
            canvas.disc(to, 1.1, BLUE, 1.0);
        }
    }
    Some(canvas)
}

/// Range of both ends of the arrows along an axis.
fn span(arrows: &[Arrow], axis: usize) -> [f64; 2] {
    let ends = || arrows.iter().flat_map(move |arrow| [arrow.from[axis], arrow.to[axis]]);
    [ends().fold(f64::INFINITY, f64::min), ends().fold(f64::NEG_INFINITY, f64::max)]
}
