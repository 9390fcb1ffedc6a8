//! Fig. 8: (a) the target path in the workspace, (b) the paths that the policies track, (c) their
//! error over time.

use super::summarise::track_summary;
use crate::base::Point3;
use crate::math::summary::{interval_95, mean};
use crate::report::drawing::{
    Axis, Canvas, CanvasPoint, LegendEntry, Panel, Text, TextAlign, View, legend,
};
use crate::report::order::trainings;
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{
    CLOUD, DASHED, GREY, HAIR, INK, LEFT_MARGIN, Marker, NARROW, SMALL, SOLID, TALL, TEXT,
    policies_in_order, policy_label, policy_look, policy_markdown, training_short,
};
use crate::report::{Artifact, Figure, Published, ReportError, captioned, csv, text};
use crate::rows::experiment::{TrackRow, TrackSummaryRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "fig8",
    about: "Fig. 8: target path, tracked paths and tracking error over time",
    render,
};

/// Points of the workspace drawn behind the path.
const MAX_CLOUD_DOTS: usize = 2000;
const STRIP_HEIGHT: f64 = 58.0;
/// Largest error over the median one, from which the axis is logarithmic, and what it begins at.
const FLAT: f64 = 15.0;
const SMALLEST_MM: f64 = 0.1;

/// One policy's run.
struct Run<'a> {
    policy: &'a str,
    rows: Vec<&'a TrackRow>,
}

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let tracks = &published.tracks;
    FIGURE.needs("tracks.csv", tracks.is_empty())?;
    let summary = track_summary(tracks);
    let mut files = vec![csv("summary.csv", &summary)?, text("fig8.md", markdown(&summary))];
    for (index, training) in
        trainings(tracks.iter().map(|row| row.training.as_str())).into_iter().enumerate()
    {
        let stem =
            if index == 0 { FIGURE.name.to_owned() } else { format!("{}_{training}", FIGURE.name) };
        let drawing = |width| draw(published, &summary, training, width);
        files.extend(captioned(FIGURE.name, &stem, &caption(published, training), drawing)?);
    }
    Ok(files)
}

/// The runs of the first repetition, in the paper's order.
fn runs<'a>(tracks: &'a [TrackRow], training: &str) -> Vec<Run<'a>> {
    let trained = tracks.iter().filter(|row| row.training == training);
    let Some(seed) = trained.clone().map(|row| row.seed).min() else { return Vec::new() };
    let policies = policies_in_order(trained.clone().map(|row| row.policy.as_str()));
    let run = |policy| {
        let mut rows: Vec<&TrackRow> = trained
            .clone()
            .filter(|row| {
                row.seed == seed && row.policy == policy && row.sample.error_m.is_finite()
            })
            .collect();
        rows.sort_by_key(|row| row.sample.step);
        Run { policy, rows }
    };
    policies.into_iter().map(run).filter(|run| !run.rows.is_empty()).collect()
}

fn target(row: &TrackRow) -> Point3 {
    [row.sample.target_x_m, row.sample.target_y_m, row.sample.target_z_m]
}

fn tip(row: &TrackRow) -> Point3 {
    [row.sample.tip_x_m, row.sample.tip_y_m, row.sample.tip_z_m]
}

/// Mean over repetitions of each policy's figures, with intervals where there are enough.
fn markdown(summary: &[TrackSummaryRow]) -> String {
    let line = |group: &[TrackSummaryRow]| {
        let of = |value: fn(&TrackSummaryRow) -> f64| group.iter().map(value).collect::<Vec<f64>>();
        let with = |values: Vec<f64>, digits: usize| match interval_95(&values) {
            Some([low, high]) => {
                format!("{:.digits$} [{low:.digits$}, {high:.digits$}]", mean(&values))
            }
            None => format!("{:.digits$}", mean(&values)),
        };
        let error = format!(
            "{:.5}({:.5})",
            mean(&of(|row| row.mean_error_m)),
            mean(&of(|row| row.sd_error_m))
        );
        vec![
            training_short(&group[0].training).to_owned(),
            policy_markdown(&group[0].policy).to_owned(),
            error,
            with(of(|row| row.start_error_m), 5),
            with(of(|row| 1e3 * row.oscillation_m), 2),
            with(of(|row| row.completion_time_s), 1),
        ]
    };
    let groups =
        summary.chunk_by(|one, next| one.training == next.training && one.policy == next.policy);
    let header = "Networks | Controller | Error, mean(SD) (m) | At the start (m) | Oscillation \
                  (mm) | Completion (s)";
    format!(
        "{}\nIn brackets after a number: 95 % interval of the mean over repetitions (Student’s t). \
         Oscillation: median peak-to-peak of the error about its moving mean, windows of {:.0} \
         s.\n",
        MarkdownTable::new(header, groups.map(line)).markdown(),
        super::summarise::OSCILLATION_WINDOW_S
    )
}

fn caption(published: &Published, training: &str) -> String {
    let axis =
        if is_logarithmic(&runs(&published.tracks, training)) { ", logarithmic axis," } else { "" };
    format!(
        "Path tracking, first repetition, {}: (a) the target path; (b) the path of the tip under \
         each policy, the target in grey; (c) distance from the moving target in mm{axis} against \
         time in s. Dashed: mean over the run; vertical line: end of the run; oscillation: median \
         peak-to-peak of the error about its moving mean.",
        published.training_label(training)
    )
}

fn draw(published: &Published, summary: &[TrackSummaryRow], training: &str, width: f64) -> Canvas {
    let runs = runs(&published.tracks, training);
    let mut canvas = Canvas::new(width, TALL);
    let is_narrow = width < NARROW;
    let size = if is_narrow { [width - 60.0, 190.0] } else { [318.0, 274.0] };
    target_path(&mut canvas, published, &runs, size);
    let corner = if is_narrow { [12.0, size[1] + 128.0] } else { [346.0, 20.0] };
    let pictures_end = tracked(&mut canvas, &runs, corner);
    let below = pictures_end.max(size[1] + 120.0);
    canvas.height = series(&mut canvas, &runs, summary, below + 18.0).round();
    canvas
}

/// Whether most of the time errors are small beside the largest one, so that a linear axis would
/// show a flat line.
fn is_logarithmic(runs: &[Run]) -> bool {
    let mut errors_m: Vec<f64> =
        runs.iter().flat_map(|run| run.rows.iter().map(|row| row.sample.error_m)).collect();
    errors_m.sort_by(f64::total_cmp);
    let median_m = errors_m.get(errors_m.len() / 2).copied().unwrap_or(f64::NAN);
    errors_m.last().is_some_and(|largest_m| *largest_m > FLAT * median_m)
}

/// Targets as the first run meets them, and the points that they connect.
fn path(published: &Published, runs: &[Run]) -> (Vec<Point3>, Vec<Point3>) {
    let mut targets: Vec<Point3> = Vec::new();
    for row in runs.first().iter().flat_map(|run| &run.rows) {
        if targets.last() != Some(&target(row)) {
            targets.push(target(row));
        }
    }
    let seed = runs.first().map(|run| run.rows[0].seed);
    let waypoints = published.waypoints.iter().filter(|row| Some(row.seed) == seed);
    (targets, waypoints.map(|row| [row.x_m, row.y_m, row.z_m]).collect())
}

/// (a): the path and its points inside the workspace, `size` large.
fn target_path(canvas: &mut Canvas, published: &Published, runs: &[Run], size: [f64; 2]) {
    let (targets, waypoints) = path(published, runs);
    let seed = runs.first().map(|run| run.rows[0].seed);
    let workspace_m = published.workspace.iter().filter(|row| Some(row.seed) == seed);
    let workspace_m: Vec<Point3> = workspace_m.map(|row| [row.x_m, row.y_m, row.z_m]).collect();
    let stride = workspace_m.len().div_ceil(MAX_CLOUD_DOTS).max(1);
    let cloud: Vec<Point3> = workspace_m.into_iter().step_by(stride).collect();
    let tips = runs.iter().flat_map(|run| run.rows.iter().map(|row| tip(row)));
    let corner = [12.0, 52.0];
    let everything = cloud.iter().chain(&targets).chain(&waypoints).copied().chain(tips);
    let view = View::of(everything, corner, size, 8.0);
    canvas.text(
        Text::new("(a) target path in the workspace", [corner[0], 20.0], TEXT, TextAlign::Left)
            .bold(),
    );
    for point in &cloud {
        canvas.disc(view.at(*point), 1.2, CLOUD, 0.9);
    }
    let places: Vec<CanvasPoint> = targets.iter().map(|point| view.at(*point)).collect();
    canvas.line(&places, 1.5, INK, SOLID);
    let marked = if waypoints.is_empty() { &targets[..0] } else { &waypoints };
    for point in marked {
        canvas.marker(view.at(*point), Marker::Circle, 2.6, crate::report::style::VERMILION, false);
    }
    let points = format!("{} points", marked.len());
    let mut keys = vec![(LegendEntry::Line(INK, SOLID), "target path")];
    if !marked.is_empty() {
        keys.push((
            LegendEntry::Marker(Marker::Circle, crate::report::style::VERMILION, false),
            points.as_str(),
        ));
    }
    if !cloud.is_empty() {
        keys.push((LegendEntry::Dot(CLOUD), "workspace"));
    }
    legend(canvas, [corner[0], 38.0], 330.0, &keys);
    view.triad(canvas, [corner[0] + 40.0, corner[1] + size[1] + 38.0], 26.0);
    view.scale_bar(canvas, [corner[0] + size[0] - 90.0, corner[1] + size[1] + 50.0], 0.05);
}

/// (b): one small picture a policy, seen as in (a) and closer. Returns where they end.
fn tracked(canvas: &mut Canvas, runs: &[Run], [left, top]: CanvasPoint) -> f64 {
    canvas.text(Text::new("(b) tracked paths", [left, top], TEXT, TextAlign::Left).bold());
    let tracked_points =
        runs.iter().flat_map(|run| run.rows.iter().flat_map(|row| [target(row), tip(row)]));
    let wide = (canvas.width - left - 12.0) / 2.0;
    let size = [wide - 6.0, 0.85 * wide];
    let close = View::of(tracked_points, [0.0, 0.0], size, 6.0);
    for (index, run) in runs.iter().enumerate() {
        let corner =
            [left + wide * (index % 2) as f64, top + 32.0 + (size[1] + 16.0) * (index / 2) as f64];
        let view = close.moved(corner, size);
        let places = |points: fn(&TrackRow) -> Point3| {
            run.rows.iter().map(|row| view.at(points(row))).collect::<Vec<_>>()
        };
        let look = policy_look(run.policy);
        canvas.line(&places(target), 2.6, CLOUD, SOLID);
        canvas.line(&places(tip), 1.0, look.colour, SOLID);
        canvas.marker(places(tip)[0], look.marker, 3.2, look.colour, false);
        let name = policy_label(run.policy);
        canvas.text(
            Text::new(name, [corner[0] + 2.0, corner[1] + 10.0], TEXT, TextAlign::Left)
                .colour(look.colour)
                .bold(),
        );
    }
    let keys = [
        (LegendEntry::Line(CLOUD, SOLID), "target"),
        (LegendEntry::Line(INK, SOLID), "tip (marker: start)"),
    ];
    legend(canvas, [left, top + 18.0], canvas.width, &keys);
    let bottom = top + 32.0 + (size[1] + 16.0) * runs.len().div_ceil(2) as f64;
    let bar = [canvas.width - 100.0, bottom + 12.0];
    close.moved([left, top], size).scale_bar(canvas, bar, 0.05);
    bottom + 18.0
}

/// (c): error against time, one strip a policy, all to one scale. Returns where they end.
fn series(canvas: &mut Canvas, runs: &[Run], summary: &[TrackSummaryRow], top: f64) -> f64 {
    let title = Text::new("(c) error against time", [12.0, top], TEXT, TextAlign::Left);
    canvas.text(title.bold());
    let keys = [
        (LegendEntry::Line(GREY, DASHED), "mean over the run"),
        (LegendEntry::Line(INK, SOLID), "end of the run"),
    ];
    let top = legend(canvas, [12.0, top + 18.0], canvas.width, &keys) + 12.0;
    let rows = || runs.iter().flat_map(|run| &run.rows);
    let x = Axis::covering("time (s)", rows().map(|row| row.sample.time_s).chain([0.0]), 8);
    let errors_mm = rows().map(|row| 1e3 * row.sample.error_m);
    let is_logarithmic = is_logarithmic(runs);
    let y = if is_logarithmic {
        // Below a tenth of a millimetre, noise of the tracker.
        Axis::decades("", errors_mm.map(|error_mm| error_mm.max(SMALLEST_MM)))
    } else {
        Axis::covering("", errors_mm.chain([0.0]), 2)
    };
    for (index, run) in runs.iter().enumerate() {
        let last = index + 1 == runs.len();
        let panel = canvas.panel(Panel {
            corner: [LEFT_MARGIN, top + (STRIP_HEIGHT + 12.0) * index as f64],
            size: [canvas.width - LEFT_MARGIN - 100.0, STRIP_HEIGHT],
            x: if last { x.clone() } else { x.bare() },
            y: y.clone(),
            title: String::new(),
        });
        strip(canvas, &panel, run, summary, is_logarithmic);
    }
    let bottom = top + (STRIP_HEIGHT + 12.0) * runs.len() as f64;
    let middle = [LEFT_MARGIN - 38.0, 0.5 * (top + bottom)];
    canvas.text(Text::new("error (mm)", middle, TEXT, TextAlign::Centre).upwards());
    bottom + 32.0
}

fn strip(
    canvas: &mut Canvas,
    panel: &Panel,
    run: &Run,
    summary: &[TrackSummaryRow],
    is_logarithmic: bool,
) {
    let height = |error_mm: f64| {
        if is_logarithmic { error_mm.max(SMALLEST_MM).log10() } else { error_mm }
    };
    let look = policy_look(run.policy);
    let first = run.rows[0];
    let is_run = |row: &&TrackSummaryRow| {
        row.policy == first.policy && row.training == first.training && row.seed == first.seed
    };
    let points: Vec<[f64; 2]> =
        run.rows.iter().map(|row| [row.sample.time_s, height(1e3 * row.sample.error_m)]).collect();
    panel.line(canvas, &points, look.colour, SOLID, 1.1);
    let right = panel.corner[0] + panel.size[0] + 10.0;
    let line = |number: f64| panel.corner[1] + 12.0 + 14.0 * number;
    let name = Text::new(policy_label(run.policy), [right, line(0.0)], TEXT, TextAlign::Left);
    canvas.text(name.colour(look.colour).bold());
    let Some(row) = summary.iter().find(is_run) else { return };
    let mean_mm = 1e3 * row.mean_error_m;
    let mean_line = [panel.x.low, panel.x.high].map(|x| [x, height(mean_mm)]);
    panel.line(canvas, &mean_line, GREY, DASHED, HAIR);
    let end = row.completion_time_s;
    panel.line(canvas, &[[end, panel.y.low], [end, panel.y.high]], INK, SOLID, HAIR);
    let end_words = if row.status.is_ok() { format!("{end:.0} s") } else { row.status.to_string() };
    let labels = [
        format!("mean {mean_mm:.1} mm"),
        format!("oscill. {:.1} mm", 1e3 * row.oscillation_m),
        end_words,
    ];
    for (number, label) in labels.into_iter().enumerate() {
        canvas.text(Text::new(label, [right, line(number as f64 + 1.0)], SMALL, TextAlign::Left));
    }
}
