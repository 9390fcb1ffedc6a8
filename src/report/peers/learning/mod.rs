//! Learning beside other packages: ratios of times with their intervals, and times over the number
//! of samples.

mod goals;
mod labels;
mod ratios;
mod table;

use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::style::{DASHED, GREY, HAIR, LINE, MARKER, PAGE_WIDTH, SMALL};
use crate::report::{Artifact, Figure, Published, ReportError, text};
use labels::{PACKAGES, title};
use ratios::{OURS, TaskRows};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "peers_learning",
    about: "Learning beside other packages: times over ours, and over samples",
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

/// Room for the names of tasks.
const NAMES_WIDTH: f64 = 186.0;
const LEFT_MARGIN: f64 = 46.0;
/// Height of a task, and of the lower panels.
const TASK_HEIGHT: f64 = 25.0;
const CURVES_HEIGHT: f64 = 150.0;
/// From one lower panel to the next.
const CURVES_PITCH: f64 = (PAGE_WIDTH - 14.0) / CURVES.len() as f64;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let tasks = TaskRows::all(&published.learning_peers);
    FIGURE.needs(
        "learning.csv with a time of ours",
        !tasks.iter().any(|task| task.cpu_s(OURS).is_some()),
    )?;
    let peers = PACKAGES.sorted(published.learning_peers.iter().map(|row| row.peer.as_str()));
    FIGURE.files(vec![text("learning.md", table::markdown(&tasks, &peers))], &draw(&tasks, &peers))
}

/// Whether the task is one that somebody wants done, not one that explains times.
fn wanted(task: &TaskRows) -> bool {
    !task.task.starts_with("product") && task.task != "evaluation"
}

fn draw(tasks: &[TaskRows], peers: &[&str]) -> Canvas {
    let shown: Vec<TaskRows> = tasks.iter().copied().filter(wanted).collect();
    let high = TASK_HEIGHT * shown.len().max(1) as f64;
    let keys: Vec<(LegendEntry, &str)> = peers
        .iter()
        .map(|peer| (LegendEntry::Plain(PACKAGES.look(peer)), PACKAGES.label(peer)))
        .collect();
    let mut canvas = Canvas::new(PAGE_WIDTH, high + CURVES_HEIGHT + 190.0);
    let below = legend(&mut canvas, [LEFT_MARGIN, 18.0], PAGE_WIDTH - 12.0, &keys);
    ratio_panel(&mut canvas, &shown, peers, [NAMES_WIDTH, below + 34.0], high);
    let top = below + 34.0 + high + 76.0;
    let sizes = tasks
        .iter()
        .filter(|task| CURVES.iter().any(|curves| curves.task == task.task))
        .map(|task| task.size as f64);
    let x = Axis::decades("samples N", sizes);
    for (index, curves) in CURVES.iter().enumerate() {
        let corner = [LEFT_MARGIN + CURVES_PITCH * index as f64, top];
        curves.draw(&mut canvas, tasks, peers, corner, &x);
    }
    canvas
}

/// Ratios with intervals, a line of marks for each task, the packages one below the other.
fn ratio_panel(
    canvas: &mut Canvas,
    tasks: &[TaskRows],
    peers: &[&str],
    corner: [f64; 2],
    high: f64,
) {
    let others: Vec<&str> = peers.iter().copied().filter(|peer| *peer != OURS).collect();
    let ratios =
        |task: &TaskRows| others.iter().filter_map(|peer| task.ratio(peer)).collect::<Vec<_>>();
    let names: Vec<String> = tasks.iter().rev().map(title).collect();
    let values = tasks
        .iter()
        .flat_map(ratios)
        .flat_map(|ratio| ratio.interval.into_iter().flatten().chain([ratio.mean]));
    let panel = canvas.panel(Panel {
        corner,
        size: [PAGE_WIDTH - 18.0 - corner[0], high],
        x: Axis::decades(
            "processor time of the package over ours (geometric mean of the rounds, 95 % interval)",
            values.chain([1.0]),
        ),
        y: Axis::categories("", &names),
        title: "(a) times over ours".to_owned(),
    });
    panel.line(canvas, &[[0.0, panel.y.low], [0.0, panel.y.high]], GREY, DASHED, HAIR);
    for (place, task) in tasks.iter().rev().enumerate() {
        let seen: Vec<&&str> = others.iter().filter(|peer| task.ratio(peer).is_some()).collect();
        for (lane, peer) in seen.iter().enumerate() {
            let Some(ratio) = task.ratio(peer) else { continue };
            // Lanes are spread evenly within the task.
            let y = place as f64 + 0.68 * (0.5 - (lane as f64 + 0.5) / seen.len() as f64);
            let colour = PACKAGES.look(peer).colour;
            if let Some(ends) = ratio.interval {
                let [low, high] = ends.map(|end| panel.at(end.log10(), y));
                canvas.line(&[low, high], 1.1, colour, &[]);
                for [x, y] in [low, high] {
                    canvas.line(&[[x, y - 2.0], [x, y + 2.0]], 1.1, colour, &[]);
                }
            }
            canvas.marker(
                panel.at(ratio.mean.log10(), y),
                PACKAGES.look(peer).marker,
                0.85 * MARKER,
                colour,
                false,
            );
        }
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
        let size = [CURVES_PITCH - LEFT_MARGIN - 8.0, CURVES_HEIGHT];
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
