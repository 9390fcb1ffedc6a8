//! Learning beside other packages: ratios of times with their intervals, and times over the number of samples.

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
const CURVES: [(&str, &str, f64); 3] = [
    ("fit", "(b) fit (s)", 1.0),
    ("predict_one", "(c) 1 prediction (µs)", 1e6),
    ("predict_many", "(d) 10,000 predictions (s)", 1.0),
];
/// Room for the names of tasks.
const NAMES: f64 = 186.0;
const LEFT: f64 = 46.0;
/// Height of a task, and of the lower panels.
const TASK_HIGH: f64 = 25.0;
const CURVES_HIGH: f64 = 150.0;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let tasks = TaskRows::all(&published.learning_peers);
    FIGURE.needs("learning.csv with a time of ours", !tasks.iter().any(|task| task.cpu_s(OURS).is_some()))?;
    let peers = PACKAGES.sorted(published.learning_peers.iter().map(|row| row.peer.as_str()));
    FIGURE.files(vec![text("learning.md", table::markdown(&tasks, &peers))], &draw(&tasks, &peers))
}

/// Whether the task is one that somebody wants done, not one that explains times.
fn wanted(task: &TaskRows) -> bool {
    !task.task.starts_with("product") && task.task != "evaluation"
}

fn draw(tasks: &[TaskRows], peers: &[&str]) -> Canvas {
    let shown: Vec<TaskRows> = tasks.iter().copied().filter(wanted).collect();
    let high = TASK_HIGH * shown.len().max(1) as f64;
    let keys: Vec<(LegendEntry, &str)> =
        peers.iter().map(|peer| (LegendEntry::Plain(PACKAGES.look(peer)), PACKAGES.label(peer))).collect();
    let mut canvas = Canvas::new(PAGE_WIDTH, high + CURVES_HIGH + 190.0);
    let below = legend(&mut canvas, [LEFT, 18.0], PAGE_WIDTH - 12.0, &keys);
    ratio_panel(&mut canvas, &shown, peers, [NAMES, below + 34.0], high);
    let top = below + 34.0 + high + 76.0;
    let sizes =
        tasks.iter().filter(|task| CURVES.iter().any(|(name, ..)| *name == task.task)).map(|task| task.size as f64);
    let x = Axis::decades("samples N", sizes);
    let wide = (PAGE_WIDTH - 14.0) / CURVES.len() as f64;
    for (index, curve) in CURVES.iter().enumerate() {
        let corner = [LEFT + wide * index as f64, top];
        curve_panel(&mut canvas, tasks, peers, *curve, (corner, [wide - LEFT - 8.0, CURVES_HIGH], x.clone()));
    }
    canvas
}

/// Ratios with intervals, a line of marks for each task, the packages one below the other.
fn ratio_panel(canvas: &mut Canvas, tasks: &[TaskRows], peers: &[&str], corner: [f64; 2], high: f64) {
    let others: Vec<&str> = peers.iter().copied().filter(|peer| *peer != OURS).collect();
    let ratios = |task: &TaskRows| others.iter().filter_map(|peer| task.ratio(peer)).collect::<Vec<_>>();
    let names: Vec<String> = tasks.iter().rev().map(title).collect();
    let values =
        tasks.iter().flat_map(ratios).flat_map(|ratio| ratio.interval.into_iter().flatten().chain([ratio.mean]));
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
            canvas.marker(panel.at(ratio.mean.log10(), y), PACKAGES.look(peer).marker, 0.85 * MARKER, colour, false);
        }
    }
}

/// Times over the number of samples.
fn curve_panel(
    canvas: &mut Canvas,
    tasks: &[TaskRows],
    peers: &[&str],
    (kind, words, unit): (&str, &str, f64),
    (corner, size, x): ([f64; 2], [f64; 2], Axis),
) {
    let own: Vec<&TaskRows> = tasks.iter().filter(|task| task.task == kind).collect();
    let line = |peer: &str| -> Vec<[f64; 2]> {
        let point = |task: &&TaskRows| Some([task.size as f64, unit * task.cpu_s(peer)?.mean]);
        own.iter().filter_map(point).collect()
    };
    let times = peers.iter().flat_map(|peer| line(peer)).map(|[_, time]| time);
    let panel = canvas.panel(Panel { corner, size, x, y: Axis::decades("", times), title: words.to_owned() });
    for peer in peers.iter().rev() {
        let points: Vec<[f64; 2]> = line(peer).into_iter().map(|point| point.map(f64::log10)).collect();
        panel.marked(canvas, &points, PACKAGES.look(peer), [0.8 * LINE, 0.85 * MARKER]);
    }
    if own.is_empty() {
        let middle = [corner[0] + size[0] / 2.0, corner[1] + size[1] / 2.0];
        canvas.text(Text::new("not measured", middle, SMALL, TextAlign::Centre).colour(GREY));
    }
}
