//! Work-precision diagram: processor time over the error of the tip, one panel for each robot, one
//! style for each simulator.

use super::labels::{PEERS, ROBOTS};
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, legend};
use crate::report::order::distinct;
use crate::report::style::{DASHED, GREY, HAIR, LEFT_MARGIN, LINE, MARKER, NARROW, TALL};
use crate::report::{Artifact, Figure, Published, ReportError, text};
use crate::rows::experiment::PeerRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "peers",
    about: "Processor time against tip error, compared with other simulators",
    render,
};

const CAPTION: &str = "Processor time per simulated second against the root mean square error of the \
    tip, both on logarithmic axes, for this program and other simulators on three robots; lower left \
    is better. Each line is one setting at several time steps, each mark one run; broken line: real \
    time.";

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let rows: Vec<&PeerRow> = published.peers.iter().filter(|row| drawable(row)).collect();
    FIGURE.needs("work_precision.csv with a finished run", rows.is_empty())?;
    let tables = vec![text("peers.md", super::table::markdown(&published.peers))];
    FIGURE.files(tables, CAPTION, |width| draw(&rows, width))
}

/// Whether a row can be drawn on logarithmic axes.
fn drawable(row: &PeerRow) -> bool {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    positive(row.rms_error_m) && positive(row.cpu_s_per_s)
}

fn draw(rows: &[&PeerRow], width: f64) -> Canvas {
    let robots = distinct(rows.iter().map(|row| row.robot.as_str()));
    let mut canvas = Canvas::new(width, TALL);
    let key = |peer| (LegendEntry::Plain(PEERS.look(peer)), PEERS.label(peer));
    let mut keys: Vec<_> =
        PEERS.sorted(rows.iter().map(|row| row.peer.as_str())).into_iter().map(key).collect();
    keys.push((LegendEntry::Line(GREY, DASHED), "real time"));
    let top = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys) + 32.0;
    let y = Axis::decades(
        "processor time (ms per s)",
        rows.iter().map(|row| 1e3 * row.cpu_s_per_s).chain([1e3]),
    );
    let per_line = if width < NARROW { 1 } else { robots.len().max(1) };
    let high = if width < NARROW { 150.0 } else { 250.0 };
    let wide = (width - LEFT_MARGIN - 14.0) / per_line as f64;
    for (index, robot) in robots.iter().enumerate() {
        let (line, column) = (index / per_line, index % per_line);
        let of_robot: Vec<&PeerRow> =
            rows.iter().copied().filter(|row| row.robot == *robot).collect();
        let x = Axis::decades(
            "rms error of the tip (mm)",
            of_robot.iter().map(|row| 1e3 * row.rms_error_m),
        );
        let panel = canvas.panel(Panel {
            corner: [LEFT_MARGIN + wide * column as f64, top + (high + 62.0) * line as f64],
            size: [wide - if per_line > 1 { 44.0 } else { 0.0 }, high],
            x,
            y: if column == 0 { y.clone() } else { y.bare() },
            title: format!("({}) {}", char::from(b'a' + (index % 26) as u8), ROBOTS.label(robot)),
        });
        // Real time: 10³ ms of the processor for a second.
        panel.line(&mut canvas, &[[panel.x.low, 3.0], [panel.x.high, 3.0]], GREY, DASHED, HAIR);
        curves(&mut canvas, &panel, &of_robot);
    }
    canvas.height = (top + (high + 62.0) * robots.len().div_ceil(per_line) as f64 - 14.0).round();
    canvas
}

/// One line through the time steps of each setting; ours last, on top.
fn curves(canvas: &mut Canvas, panel: &Panel, rows: &[&PeerRow]) {
    for peer in PEERS.sorted(rows.iter().map(|row| row.peer.as_str())).into_iter().rev() {
        let of_peer: Vec<&PeerRow> = rows.iter().copied().filter(|row| row.peer == peer).collect();
        let kind = |row: &PeerRow| format!("{} {}", row.setting, row.segments_or_nodes);
        let kinds: Vec<String> = of_peer.iter().map(|row| kind(row)).collect();
        for one in distinct(kinds.iter().map(String::as_str)) {
            let mut line: Vec<&&PeerRow> = of_peer.iter().filter(|row| kind(row) == one).collect();
            line.sort_by(|a, b| a.dt_s.total_cmp(&b.dt_s));
            let points: Vec<[f64; 2]> = line
                .iter()
                .map(|row| [(1e3 * row.rms_error_m).log10(), (1e3 * row.cpu_s_per_s).log10()])
                .collect();
            panel.marked(canvas, &points, PEERS.look(peer), [0.7 * LINE, 0.85 * MARKER]);
        }
    }
}
