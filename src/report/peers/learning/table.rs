//! The comparison as tables: ratios, what the fits reached, shares of the processor's peak, figures
//! to reach.

use std::fmt::Write;

use super::labels::{PACKAGES, title};
use super::ratios::{Averaged, OURS, TaskRows};
use super::{goals, wanted};
use crate::report::drawing::signed;

/// Tables in Markdown.
pub(super) fn markdown(tasks: &[TaskRows], peers: &[&str]) -> String {
    let mut text = String::new();
    ratios(&mut text, tasks, peers);
    reached(&mut text, tasks, peers);
    peak(&mut text, tasks, peers);
    let _ = write!(text, "\n{}", goals::markdown(tasks));
    text
}

fn head(text: &mut String, first: &str, cells: impl Iterator<Item = String>) {
    let cells: Vec<String> = cells.collect();
    let _ = writeln!(
        text,
        "| {first} | {} |\n| --- |{}",
        cells.join(" | "),
        " ---: |".repeat(cells.len())
    );
}

fn ratios(text: &mut String, tasks: &[TaskRows], peers: &[&str]) {
    let others: Vec<&str> = peers.iter().copied().filter(|peer| *peer != OURS).collect();
    let names = others.iter().map(|peer| PACKAGES.label(peer).to_owned());
    head(text, "Task", ["spinebench".to_owned()].into_iter().chain(names));
    for task in tasks.iter().filter(|task| wanted(task)) {
        let ours = task.cpu_s(OURS).map_or("–".to_owned(), |ours| time(ours.mean));
        let cells: Vec<String> = others
            .iter()
            .map(|peer| task.ratio(peer).map_or("–".to_owned(), with_interval))
            .collect();
        let _ = writeln!(text, "| {} | {ours} | {} |", title(task), cells.join(" | "));
    }
    let _ = writeln!(
        text,
        "\nOurs: processor time of one thread. Packages: their time over ours, geometric mean over \
         the rounds and its 95 % interval; three outputs everywhere, predictions with variance."
    );
}

/// Likelihoods, evaluations and errors of the fits; epochs and errors of the networks.
fn reached(text: &mut String, tasks: &[TaskRows], peers: &[&str]) {
    let _ = writeln!(text);
    head(text, "Reached", peers.iter().map(|peer| PACKAGES.label(peer).to_owned()));
    for task in tasks.iter().filter(|task| task.task == "fit") {
        let cell = |peer: &&str| {
            let likelihood = task.mean(peer, |row| row.likelihood)?;
            let evaluations = task.mean(peer, |row| row.evaluations)?;
            let error_mm = 1e3 * task.mean(peer, |row| row.error_m)?;
            Some(format!("{} ({evaluations:.0}; {error_mm:.4} mm)", signed(likelihood, 3)))
        };
        let cells: Vec<String> =
            peers.iter().map(|peer| cell(peer).unwrap_or_else(|| "–".to_owned())).collect();
        let _ = writeln!(text, "| {} | {} |", title(task), cells.join(" | "));
    }
    for task in tasks.iter().filter(|task| task.task == "until_error") {
        let cell = |peer: &&str| {
            let epochs = task.mean(peer, |row| row.evaluations)?;
            let error_mm = 1e3 * task.mean(peer, |row| row.error_m)?;
            Some(format!("{epochs:.1} epochs ({error_mm:.3} mm)"))
        };
        let cells: Vec<String> =
            peers.iter().map(|peer| cell(peer).unwrap_or_else(|| "–".to_owned())).collect();
        let _ = writeln!(text, "| {} | {} |", title(task), cells.join(" | "));
    }
    let _ = writeln!(
        text,
        "\nFits: sum of the three log marginal likelihoods (evaluations; root mean square error on \
         the other exploration, without noise). Networks: mean over the rounds, each with its own \
         initial weights."
    );
}

fn peak(text: &mut String, tasks: &[TaskRows], peers: &[&str]) {
    let rate =
        |task: &TaskRows, peer: &str| Some(1e-9 * task.operations()? / task.cpu_s(peer)?.mean);
    let best = |precision: &str| {
        let products = tasks.iter().filter(|task| task.task == precision);
        products
            .flat_map(|task| peers.iter().filter_map(|peer| rate(task, peer)))
            .fold(f64::NAN, f64::max)
    };
    let (double, single) = (best("product_f64"), best("product_f32"));
    let _ = writeln!(text);
    head(
        text,
        "GFLOP/s (share of the peak)",
        peers.iter().map(|peer| PACKAGES.label(peer).to_owned()),
    );
    for task in tasks.iter().filter(|task| task.operations().is_some()) {
        let top = if matches!(task.task, "epoch" | "product_f32") { single } else { double };
        let cell = |peer: &&str| {
            rate(task, peer).map(|rate| format!("{} ({:.0} %)", number(rate), 100.0 * rate / top))
        };
        let cells: Vec<String> =
            peers.iter().map(|peer| cell(peer).unwrap_or_else(|| "–".to_owned())).collect();
        let _ = writeln!(text, "| {} | {} |", title(task), cells.join(" | "));
    }
    let _ = writeln!(
        text,
        "\nThe peak is the fastest product of two matrices of its precision in this table. \
         Counted: N³ for a likelihood with gradient, N² for a prediction of one output, six \
         operations for a weight and a row of a window of an epoch; other work is not counted."
    );
}

/// A geometric mean with its interval.
pub(super) fn with_interval(value: Averaged) -> String {
    let interval = value.interval.map(|[low, high]| format!(" ({}–{})", number(low), number(high)));
    format!("**{}**{}", number(value.mean), interval.unwrap_or_default())
}

/// Three significant digits.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() || value <= 0.0 {
        return "–".to_owned();
    }
    let digits = (2 - value.log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.digits$}")
}

/// A time in the unit that it is read in.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{} µs", number(1e6 * s)),
        s if s < 1.0 => format!("{} ms", number(1e3 * s)),
        s => format!("{} s", number(s)),
    }
}
