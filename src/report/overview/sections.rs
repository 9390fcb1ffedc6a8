//! The figures of the paper, and what goes past the paper.

use maud::{Markup, html};
use std::path::Path;

use super::charts::{AxisColumn, Chart, ChartKind, PageData};
use super::tables::{EmbeddedTable, published_columns};
use super::{OverviewFacts, PagePart, repair};
use crate::data::DataError;
use crate::report::scene::player;
use crate::report::style::training_label;

/// A chart of columns of one table, or nothing where the table is not there.
pub(super) fn chart_of(
    results: &Path,
    data: &mut PageData,
    file: &str,
    keep: impl Fn(&dyn Fn(&str) -> String) -> bool,
    chart: Chart,
    caption: &str,
) -> Result<Markup, DataError> {
    let Some(columns) = published_columns(results, file)? else { return Ok(Markup::default()) };
    let mut wanted: Vec<&str> = chart.category.iter().map(String::as_str).collect();
    wanted.extend([chart.x.column]);
    wanted.extend(chart.y.iter().map(|axis| axis.column));
    wanted.extend(chart.interval.into_iter().flatten());
    wanted.extend(chart.series);
    wanted.extend(chart.paper);
    wanted.extend(chart.facets.iter().map(|(column, _)| *column));
    wanted.extend(chart.columns.iter().map(|(column, _)| *column));
    wanted.extend(chart.x_columns.iter().copied());
    let table = data.add(EmbeddedTable::new(file, &columns, &wanted, keep));
    Ok(data.chart(Chart { table, ..chart }, caption))
}

/// Figs 5, 6 and 8.
///
/// # Errors
/// [`DataError`] for a table that cannot be read.
pub(super) fn figures(
    results: &Path,
    facts: &OverviewFacts,
    data: &mut PageData,
) -> Result<Vec<PagePart>, DataError> {
    let fig5 = fig5(results, data)?;
    let fig6 = fig6(results, data)?;
    let fig8 = fig8(results, data)?;
    let robots = path_player(facts);
    Ok(vec![
        PagePart::new("fig5", "Fig. 5: simulated and “real” tips", fig5),
        PagePart::new("fig6", "Fig. 6: error against the amount of real data", fig6),
        PagePart::new("fig8", "Fig. 8: a path in closed loop", html! { (robots) (fig8) }),
    ])
}

/// The robot on the path, with what it is.
fn path_player(facts: &OverviewFacts) -> Markup {
    let robots = player("The robot on the path under each controller", &facts.path.scenes);
    html! {
        @if !robots.0.is_empty() {
            p .note {
                "The robot under the commands of repetition " (facts.path.seed + 1) ", "
                (training_label(&facts.path.training)) ", simulated again without noise. A controller \
                 stops where it has passed the last point of the path."
            }
            (robots)
        }
    }
}

fn fig5(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let mut charts = Markup::default();
    let chart = Chart {
        kind: ChartKind::Points,
        title: "Tips, seen from the side".into(),
        x: AxisColumn {
            zero: false,
            ..AxisColumn::millimetres("real_z_m", "z, along the straight robot (mm)")
        },
        y: Some(AxisColumn { zero: false, ..AxisColumn::millimetres("real_x_m", "x, up (mm)") }),
        columns: vec![("real_x_m", "simulated “real” robot"), ("sim_x_m", "simulation")],
        x_columns: vec!["real_z_m", "sim_z_m"],
        ..Chart::default()
    };
    let caption = "The tips of 1,000 commands in the first repetition.";
    let first = |cell: &dyn Fn(&str) -> String| cell("seed") == "0";
    charts.0 += &chart_of(results, data, "fig5/gap.csv", first, chart, caption)?.0;
    let errors = Chart {
        title: "Difference by axis".into(),
        x: AxisColumn::millimetres("rms_m", "rms difference (mm)"),
        category: vec!["axis".into()],
        ..Chart::default()
    };
    let caption =
        "Root mean square difference between simulated and “real” tip over all repetitions.";
    charts.0 += &chart_of(results, data, "fig5/summary.csv", |_| true, errors, caption)?.0;
    Ok(charts)
}

fn fig6(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let panels = [
        (
            "pi_real",
            "real_points",
            "real points of π_real’s network",
            "(a) π_real: error against real points",
        ),
        (
            "a",
            "gp_points",
            "points of the Gaussian process",
            "(b) A: error against points of the Gaussian process",
        ),
    ];
    let mut charts = Markup::default();
    for (policy, column, label, title) in panels {
        let chart = Chart {
            kind: ChartKind::Lines,
            title: title.into(),
            x: AxisColumn::plain(column, label).log(),
            y: Some(AxisColumn::millimetres("mean_m", "mean error (mm)")),
            interval: Some(["low_95_m", "high_95_m"]),
            series: Some("mode"),
            facets: vec![("training", "paper".into())],
            paper: Some("paper_mean_m"),
            ..Chart::default()
        };
        let of_policy = |cell: &dyn Fn(&str) -> String| cell("policy") == policy;
        let caption = "Mean over ten repetitions with its 95 % interval. Diamonds: the paper.";
        charts.0 += &chart_of(results, data, "fig6/summary.csv", of_policy, chart, caption)?.0;
    }
    Ok(charts)
}

fn fig8(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let first = |cell: &dyn Fn(&str) -> String| cell("seed") == "0";
    let facets = || vec![("training", "paper".to_owned())];
    let path = Chart {
        kind: ChartKind::Points,
        title: "Path of the tip".into(),
        x: AxisColumn { zero: false, ..AxisColumn::millimetres("tip_y_m", "y, to the side (mm)") },
        y: Some(AxisColumn { zero: false, ..AxisColumn::millimetres("tip_x_m", "x, up (mm)") }),
        joined: true,
        series: Some("policy"),
        facets: facets(),
        ..Chart::default()
    };
    let error = Chart {
        kind: ChartKind::Lines,
        title: "Error over time".into(),
        x: AxisColumn::plain("time_s", "time (s)"),
        y: Some(AxisColumn::millimetres("error_m", "distance to the path point (mm)")),
        series: Some("policy"),
        facets: facets(),
        ..Chart::default()
    };
    let path = chart_of(
        results,
        data,
        "fig8/tracks.csv",
        first,
        path,
        "First repetition, seen from the base.",
    )?;
    let error = chart_of(results, data, "fig8/tracks.csv", first, error, "First repetition.")?;
    let means = Chart {
        title: "Mean error by repetition".into(),
        x: AxisColumn::millimetres("mean_error_m", "mean error on the path (mm)"),
        kind: ChartKind::Strips,
        category: vec!["policy".into()],
        series: Some("policy"),
        facets: facets(),
        ..Chart::default()
    };
    let means =
        chart_of(results, data, "fig8/summary.csv", |_| true, means, "One dot per repetition.")?;
    Ok(html! { (path) (error) (means) })
}

/// Controllers, repair, populations, sweeps, discovery and real robots.
///
/// # Errors
/// [`DataError`] for a table that cannot be read.
pub(super) fn further(results: &Path, data: &mut PageData) -> Result<Vec<PagePart>, DataError> {
    let controllers = controllers(results, data)?;
    let repair = repair::section(results, data)?;
    let population = population(results, data)?;
    let sweeps = sweeps(results, data)?;
    let discovery = discovery(results, data)?;
    let real = real(results, data)?;
    Ok(vec![
        PagePart::new("controllers", "Further controllers", controllers),
        PagePart::new("repair", "Repair: a robot that changes", repair),
        PagePart::new("population", "A population of robots", population),
        PagePart::new("sweeps", "Sweeps", sweeps),
        PagePart::new("discovery", "Discovery of missing physics", discovery),
        PagePart::new("real", "Real robots", real),
    ])
}

fn controllers(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let chart = Chart {
        title: "Error at the end of a trial".into(),
        x: AxisColumn::millimetres("error_end_m", "mean error of the true tip (mm)"),
        interval: Some(["low_95_m", "high_95_m"]),
        category: vec!["policy".into()],
        series: Some("policy"),
        facets: vec![("training", "converged".into()), ("mode", "closed".into())],
        ..Chart::default()
    };
    let caption = "Mean over ten repetitions with its 95 % interval; A to π_real are the paper’s controllers. \
                   True tip: without tracking noise.";
    chart_of(results, data, "controllers/controllers.csv", |_| true, chart, caption)
}

fn population(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let shares = Chart {
        title: "Share of robots on which a claim holds".into(),
        x: AxisColumn { scale: 100.0, zero: true, ..AxisColumn::plain("share", "robots (%)") },
        interval: Some(["low_95", "high_95"]),
        category: vec!["statement".into()],
        facets: vec![("training", "paper".into())],
        ..Chart::default()
    };
    let comparisons = |cell: &dyn Fn(&str) -> String| !cell("claim").starts_with("table1_");
    let caption = "A hundred simulated robots with different gaps; 95 % interval of the share \
                   (Wilson).";
    let shares =
        chart_of(results, data, "population/robot_claims.csv", comparisons, shares, caption)?;
    let errors = Chart {
        title: "Errors over the robots".into(),
        x: AxisColumn::millimetres("median_m", "median error over robots (mm)"),
        interval: Some(["p05_m", "p95_m"]),
        category: vec!["policy".into()],
        series: Some("policy"),
        facets: vec![("training", "paper".into()), ("mode", "closed".into())],
        ..Chart::default()
    };
    let caption = "Median over robots; the line goes from the 5th to the 95th percentile.";
    let errors = chart_of(results, data, "population/population.csv", |_| true, errors, caption)?;
    Ok(html! { (shares) (errors) })
}

fn sweeps(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let mut names: Vec<String> = std::fs::read_dir(results)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with("sweep_"))
        .collect();
    names.sort();
    let mut charts = Markup::default();
    for name in names {
        let file = format!("{name}/sweep.csv");
        let Some(columns) = published_columns(results, &file)? else { continue };
        let fields: Vec<String> = columns
            .iter()
            .map(|(column, _)| column.clone())
            .filter(|column| column.contains('.'))
            .collect();
        let first = |column: &str| {
            let cells = columns.iter().find(|(name, _)| name == column);
            cells.and_then(|(_, cells)| cells.first().cloned()).unwrap_or_default()
        };
        let chart = Chart {
            title: name.trim_start_matches("sweep_").replace('_', " "),
            x: AxisColumn::millimetres("mean_m", "mean error (mm)"),
            interval: Some(["low_95_m", "high_95_m"]),
            category: fields.clone(),
            series: Some("policy"),
            facets: vec![
                ("task", first("task")),
                ("training", first("training")),
                ("mode", first("mode")),
            ],
            ..Chart::default()
        };
        let caption = format!("Swept: {}. 95 % intervals over repetitions.", fields.join(", "));
        let shown = chart_of(results, data, &file, |_| true, chart, &caption)?;
        charts.0 += &html! { details id=(name) { summary { (name.trim_start_matches("sweep_").replace('_', " ")) } (shown) } }.into_string();
    }
    Ok(charts)
}

fn discovery(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let chart = Chart {
        title: "Share of cases".into(),
        x: AxisColumn { scale: 100.0, zero: true, ..AxisColumn::plain("value", "share (%)") },
        interval: Some(["low_95", "high_95"]),
        category: vec!["measure".into()],
        facets: vec![("part", "all".into())],
        ..Chart::default()
    };
    let shares = |cell: &dyn Fn(&str) -> String| cell("kind") == "share";
    let caption = "Recordings of simulated robots whose effects are unknown to the search: one \
                   effect, a pair, or none. In the group: several effects explain the data equally well, and \
                   the true one is among those named. Outside the span: an effect that no combination of \
                   the catalogue imitates; inside: one that some combination imitates.";
    let own =
        chart_of(results, data, "discovery_full/summary.csv", shares, chart.clone(), caption)?;
    let caption = "The same on recordings of another simulator, a MuJoCo chain.";
    let twin = Chart { title: "Recordings of another simulator".into(), ..chart };
    let twin = chart_of(results, data, "discovery_twin/summary.csv", shares, twin, caption)?;
    Ok(html! { (own) (twin) })
}

fn real(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let chart = Chart {
        title: "Error of models on positions not used in any fit".into(),
        x: AxisColumn::plain("rod_mm", "rms error (mm)").log(),
        category: vec!["robot".into()],
        columns: vec![
            ("rod_mm", "rod, calibrated"),
            ("as_given_mm", "rod as given"),
            ("constant_curvature_mm", "constant curvature"),
            ("linear_mm", "linear regression"),
            ("quadratic_mm", "quadratic regression"),
            ("gaussian_process_mm", "Gaussian process"),
            ("noise_mm", "noise, upper bound"),
        ],
        ..Chart::default()
    };
    let caption = "Four robots built and measured by other groups.";
    chart_of(results, data, "real/summary.csv", |_| true, chart, caption)
}
