//! Learning beside other packages: ratios of times with their intervals, and times over the number
//! of samples.

mod goals;
mod labels;
mod ratios;
mod table;

use crate::report::drawing::{
    Axis, Canvas, Dot, DotChart, DotPanel, DotRow, LegendEntry, MIN_PANEL, Panel, Text, TextAlign,
    legend,
};
use crate::report::style::{GREY, LINE, MARKER, NARROW, SMALL, TALL};
use crate::report::{Artifact, Figure, Published, ReportError, text};
use labels::{PACKAGES, title};
use ratios::{OURS, TaskRows};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "peers_learning",
    about: "Comparison with other learning packages: times over ours, and over samples",
    render,
};

/// Tasks of the lower panels, over the number of samples.
const CURVES: [TaskCurves; 3] = [
    TaskCurves { task: "fit", title: "(b) fit (s)", units_per_s: 1.0 },
    TaskCurves { task: "predict_one", title: "(c) 1 prediction (µs)", units_per_s: 1e6 },
    TaskCurves { task: "predict_many", title: "(d) 10,000 predictions (s)", units_per_s: 1.0 },
];

/// A lower panel: its task, title and unit of time.
struct TaskCurves {
    task: &'static str,
    title: &'static str,
    units_per_s: f64,
}

/// Room for the numbers of a lower panel.
const LEFT_MARGIN: f64 = 46.0;
/// Height of a lower panel.
const CURVES_HEIGHT: f64 = 150.0;

const CAPTION: &str = "Comparison with other learning packages on one thread: (a) processor time \
                       of each package over that of this program, geometric mean of the rounds \
                       with its 95 % interval, on a logarithmic axis; right of 1 this program is \
                       faster. (b) to (d) processor time against the number of samples, both on \
                       logarithmic axes.";

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let tasks = TaskRows::all(&published.learning_peers);
    FIGURE.needs(
        "learning.csv with a time of ours",
        !tasks.iter().any(|task| task.cpu_s(OURS).is_some()),
    )?;
    let peers = PACKAGES.sorted(published.learning_peers.iter().map(|row| row.peer.as_str()));
    let tables = vec![text("learning.md", table::markdown(&tasks, &peers))];
    FIGURE.files(tables, CAPTION, |width| draw(&tasks, &peers, width))
}

/// Whether the task is one that somebody wants done, not one that explains times.
fn wanted(task: &TaskRows) -> bool {
    !task.task.starts_with("product") && task.task != "evaluation"
}

fn draw(tasks: &[TaskRows], peers: &[&str], width: f64) -> Canvas {
    let shown: Vec<TaskRows> = tasks.iter().copied().filter(wanted).collect();
    let keys: Vec<(LegendEntry, &str)> = peers
        .iter()
        .map(|peer| (LegendEntry::Plain(PACKAGES.look(peer)), PACKAGES.label(peer)))
        .collect();
    let mut canvas = Canvas::new(width, TALL);
    let below = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys);
    let top = ratios_chart(&shown, peers).draw(&mut canvas, below + 32.0) + 32.0;
    let sizes = tasks
        .iter()
        .filter(|task| CURVES.iter().any(|curves| curves.task == task.task))
        .map(|task| task.size as f64);
    let x = Axis::decades("samples N", sizes);
    let per_line = if width < NARROW { 1 } else { CURVES.len() };
    let pitch = (width - 10.0) / per_line as f64;
    for (index, curves) in CURVES.iter().enumerate() {
        let (line, column) = (index / per_line, index % per_line);
        let corner =
            [LEFT_MARGIN + pitch * column as f64, top + (CURVES_HEIGHT + 62.0) * line as f64];
        curves.draw(&mut canvas, tasks, peers, corner, pitch - LEFT_MARGIN - 8.0, &x);
    }
    let lines = CURVES.len().div_ceil(per_line) as f64;
    canvas.height = (top + (CURVES_HEIGHT + 62.0) * lines - 14.0).round();
    canvas
}

/// Ratios with intervals, a row for each task, the packages one below the other.
fn ratios_chart(tasks: &[TaskRows], peers: &[&str]) -> DotChart {
    let others: Vec<&str> = peers.iter().copied().filter(|peer| *peer != OURS).collect();
    let seen = |task: &TaskRows| -> Vec<(&str, ratios::Averaged)> {
        others.iter().filter_map(|peer| Some((*peer, task.ratio(peer)?))).collect()
    };
    let all = tasks.iter().flat_map(seen);
    let values =
        all.flat_map(|(_, ratio)| ratio.interval.into_iter().flatten().chain([ratio.mean]));
    let dots = tasks.iter().enumerate().flat_map(|(row, task)| {
        seen(task).into_iter().enumerate().map(move |(lane, (peer, ratio))| {
            let look = PACKAGES.look(peer);
            Dot {
                thin: ratio.interval.map(|ends| ends.map(f64::log10)),
                ..Dot::new(row, lane, ratio.mean.log10(), look.marker, look.colour)
            }
        })
    });
    DotChart {
        rows: tasks.iter().map(|task| DotRow::Named(title(task), seen(task).len())).collect(),
        lane_height: 9.5,
        min_panel: MIN_PANEL,
        aside: 0.0,
        panels: vec![DotPanel {
            title: "(a) times over ours".to_owned(),
            x: Axis::decades("time over ours", values.chain([1.0])),
            dots: dots.collect(),
            joined: false,
            goals: Vec::new(),
        }],
    }
}

impl TaskCurves {
    /// Draws the times over the number of samples.
    fn draw(
        &self,
        canvas: &mut Canvas,
        tasks: &[TaskRows],
        peers: &[&str],
        corner: [f64; 2],
        wide: f64,
        x: &Axis,
    ) {
        let of_task: Vec<&TaskRows> = tasks.iter().filter(|task| task.task == self.task).collect();
        let line = |peer: &str| -> Vec<[f64; 2]> {
            let point = |task: &&TaskRows| {
                Some([task.size as f64, self.units_per_s * task.cpu_s(peer)?.mean])
            };
            of_task.iter().filter_map(point).collect()
        };
        let times = peers.iter().flat_map(|peer| line(peer)).map(|[_, time]| time);
        let size = [wide, CURVES_HEIGHT];
        let y = Axis::decades("", times);
        let panel =
            canvas.panel(Panel { corner, size, x: x.clone(), y, title: self.title.to_owned() });
        for peer in peers.iter().rev() {
            let points: Vec<[f64; 2]> =
                line(peer).into_iter().map(|point| point.map(f64::log10)).collect();
            panel.marked(canvas, &points, PACKAGES.look(peer), [0.8 * LINE, 0.85 * MARKER]);
        }
        if of_task.is_empty() {
            let middle = [corner[0] + size[0] / 2.0, corner[1] + size[1] / 2.0];
            canvas.text(Text::new("not measured", middle, SMALL, TextAlign::Centre).colour(GREY));
        }
    }
}
