//! The comparison with other simulators as tables: the fastest setting within each error.

use std::fmt::Write;

use super::labels::{PEERS, ROBOTS};
use crate::report::order::distinct;
use crate::rows::experiment::PeerRow;

/// Error limits of the columns, mm.
const WANTED_MM: [f64; 4] = [10.0, 1.0, 0.1, 0.01];

/// Tables in Markdown: for each robot and simulator the fastest setting within each error, and the
/// static solves.
pub(crate) fn markdown(rows: &[PeerRow]) -> String {
    let mut text = String::new();
    dynamic_runs(&mut text, rows);
    static_solves(&mut text, rows);
    text
}

fn dynamic_runs(text: &mut String, rows: &[PeerRow]) {
    let heads: Vec<String> = WANTED_MM.iter().map(|mm| format!("≤ {mm} mm")).collect();
    let _ = writeln!(text, "| Robot | Simulator | {} | smallest error |", heads.join(" | "));
    let _ = writeln!(text, "| --- | --- |{} ---: |", " ---: |".repeat(heads.len()));
    for robot in distinct(
        rows.iter().filter(|row| row.real_time_factor.is_finite()).map(|row| row.robot.as_str()),
    ) {
        let of_robot: Vec<&PeerRow> = rows
            .iter()
            .filter(|row| row.robot == robot && row.real_time_factor.is_finite())
            .collect();
        for (place, peer) in
            PEERS.sorted(of_robot.iter().map(|row| row.peer.as_str())).into_iter().enumerate()
        {
            let of_peer: Vec<&PeerRow> =
                of_robot.iter().copied().filter(|row| row.peer == peer).collect();
            let cells: Vec<String> =
                WANTED_MM.iter().map(|mm| fastest(&of_peer, 1e-3 * mm)).collect();
            let best = of_peer
                .iter()
                .map(|row| row.rms_error_m)
                .filter(|error| error.is_finite())
                .fold(f64::INFINITY, f64::min);
            let robot = if place == 0 { ROBOTS.label(robot) } else { "" };
            let _ = writeln!(
                text,
                "| {robot} | {} | {} | {} mm |",
                PEERS.label(peer),
                cells.join(" | "),
                short(1e3 * best)
            );
        }
    }
    let _ = writeln!(
        text,
        "\nSimulated time over processor time of the fastest setting with an rms tip error within \
         that of the column (nodes or segments, time step); –: no tested setting."
    );
}

/// Speed and setting of the fastest row within an error.
fn fastest(rows: &[&PeerRow], error_m: f64) -> String {
    let within = rows.iter().filter(|row| row.rms_error_m <= error_m);
    within.max_by(|a, b| a.real_time_factor.total_cmp(&b.real_time_factor)).map_or(
        "–".to_owned(),
        |row| {
            let [speed, nodes, step] =
                [row.real_time_factor, row.segments_or_nodes, 1e3 * row.dt_s].map(short);
            format!("**{speed}** ({nodes}, {step} ms)")
        },
    )
}

fn static_solves(text: &mut String, rows: &[PeerRow]) {
    let solves: Vec<&PeerRow> =
        rows.iter().filter(|row| !row.dt_s.is_finite() && row.cpu_s_per_s.is_finite()).collect();
    if solves.is_empty() {
        return;
    }
    let _ = writeln!(text, "\n| Static solve | from | nodes | time | tip off by |");
    let _ = writeln!(text, "| --- | --- | ---: | ---: | ---: |");
    for row in solves {
        let [nodes, time, error] =
            [row.segments_or_nodes, 1e6 * row.cpu_s_per_s, 1e6 * row.static_error_m].map(short);
        let _ = writeln!(
            text,
            "| {} | {} | {nodes} | {time} µs | {error} µm |",
            PEERS.label(&row.peer),
            row.setting
        );
    }
}

/// Three significant digits, without an exponent.
fn short(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return "–".to_owned();
    }
    let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}
