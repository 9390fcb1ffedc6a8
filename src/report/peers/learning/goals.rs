//! What was to be reached, and whether it is.

use std::fmt::Write;

use super::labels::{PACKAGES, title};
use super::ratios::{Averaged, OURS, TaskRows};
use super::table::{time, with_interval};

/// A figure to reach.
enum Goal {
    /// So many times the time of ours by this package.
    Over(&'static str, f64),
    /// So many times the time of ours by the fastest package.
    OverBest(f64),
    /// At most this time, s.
    Within(f64),
}

const GOALS: [(&str, u64, Goal); 7] = [
    ("fit", 1000, Goal::Over("scikit_learn", 20.0)),
    ("fit", 1000, Goal::Over("scipy", 5.0)),
    ("fit", 100, Goal::Over("scipy", 5.0)),
    ("predict_one", 100, Goal::Within(5e-6)),
    ("predict_many", 1000, Goal::OverBest(2.0)),
    ("epoch", 7000, Goal::Over("pytorch", 12.0)),
    ("until_error", 7000, Goal::Over("pytorch", 20.0)),
];

/// The figures as a table; a figure is reached, or not, where its whole interval is on one side.
pub(super) fn markdown(tasks: &[TaskRows]) -> String {
    let mut text =
        String::from("| Comparison | Required | Measured | |\n| --- | ---: | ---: | --- |\n");
    for (kind, size, goal) in GOALS {
        let Some(task) = tasks.iter().find(|task| task.task == kind && task.size == size) else {
            continue;
        };
        let [what, wanted, measured, word] = goal.cells(task);
        let _ = writeln!(text, "| {}: {what} | {wanted} | {measured} | {word} |", title(task));
    }
    text
}

impl Goal {
    /// What is compared, the wanted and the found figure, whether it is reached.
    fn cells(&self, task: &TaskRows) -> [String; 4] {
        let (package, measured, wanted) = match *self {
            Goal::Over(peer, wanted) => (PACKAGES.label(peer), task.ratio(peer), wanted),
            Goal::OverBest(wanted) => ("the fastest other", task.ratio_of_best(), wanted),
            Goal::Within(limit_s) => {
                let (measured, limit) = (task.cpu_s(OURS), format!("≤ {} µs", 1e6 * limit_s));
                let verdict =
                    goal_verdict(measured.map(Averaged::inverse), 1.0 / limit_s).to_owned();
                let measured = measured.map_or("–".to_owned(), |measured| time(measured.mean));
                return ["ours".to_owned(), limit, measured, verdict];
            }
        };
        let verdict = goal_verdict(measured, wanted).to_owned();
        let measured = measured.map_or("–".to_owned(), with_interval);
        [format!("{package} over ours"), format!("≥ {wanted}"), measured, verdict]
    }
}

/// Whether a number is at least the wanted one.
fn goal_verdict(measured: Option<Averaged>, wanted: f64) -> &'static str {
    let Some(measured) = measured else { return "not measured" };
    let [low, high] = measured.interval.unwrap_or([measured.mean; 2]);
    match (low >= wanted, high < wanted) {
        (true, _) => "reached",
        (_, true) => "**not reached**",
        _ => "undecided",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_reached_when_its_whole_interval_is() {
        let measured =
            |low, high| Some(Averaged { mean: 0.5 * (low + high), interval: Some([low, high]) });
        assert_eq!(goal_verdict(measured(5.0, 6.0), 5.0), "reached");
        assert_eq!(goal_verdict(measured(4.0, 6.0), 5.0), "undecided");
        assert_eq!(goal_verdict(measured(4.0, 4.9), 5.0), "**not reached**");
        assert_eq!(goal_verdict(None, 5.0), "not measured");
    }
}
