//! The rounds: every task by ours and every package, one after the other.

use std::path::Path;

use spinebench::rows::learning_peers::LearningPeerRow;

use super::ours::Ours;
use super::package::{PACKAGES, Package};
use super::samples::Samples;
use super::task::{Outcome, Task, all};

/// Everything that the rounds found.
pub struct Found {
    pub rows: Vec<LearningPeerRow>,
    /// Packages and versions.
    pub versions: Vec<(String, String)>,
    /// Packages that did not run, and why.
    pub skipped: Vec<(String, String)>,
}

/// Who takes turns.
enum Competitor<'a> {
    Ours(Ours<'a>),
    Package(Box<Package>),
}

impl Competitor<'_> {
    fn name(&self) -> &'static str {
        match self {
            Competitor::Ours(_) => "spinebench",
            Competitor::Package(package) => package.name,
        }
    }

    /// The outcome of a task; `None` for one that is not its own.
    fn run(&mut self, task: Task, round: u64) -> Option<Result<Outcome, String>> {
        match self {
            Competitor::Ours(ours) => Some(ours.run(task, round)),
            Competitor::Package(package) => package.does(task).then(|| package.run(task, round)),
        }
    }
}

/// Runs them. Whoever begins changes from round to round.
pub fn run(samples: &Samples, scratch: &Path, rounds: u64) -> Found {
    let mut found = Found { rows: Vec::new(), versions: Vec::new(), skipped: Vec::new() };
    let mut competitors = vec![Competitor::Ours(Ours::new(samples))];
    for (name, script) in PACKAGES {
        match Package::start(name, script, scratch) {
            Ok(package) => {
                found.versions.extend(package.versions.iter().cloned());
                competitors.push(Competitor::Package(Box::new(package)));
            }
            Err(reason) => {
                println!("{name}: skipped: {reason}");
                found.skipped.push((name.to_owned(), reason));
            }
        }
    }
    for round in 1..=rounds {
        for task in all(samples.network.trained()) {
            for competitor in &mut competitors {
                if let Some(outcome) = competitor.run(task, round) {
                    let row = Outcome::row(outcome, task, competitor.name(), round);
                    print(&row);
                    found.rows.push(row);
                }
            }
        }
        competitors.rotate_left(1);
    }
    found
}

/// Prints a row, as soon as it is known.
fn print(row: &LearningPeerRow) {
    println!(
        "{:2} {:18} {:5} {:12} {:12.6} ms {:10.3} nats {:5} {:9.4} mm  {}",
        row.round,
        row.task,
        row.size,
        row.peer,
        1e3 * row.cpu_s,
        row.likelihood,
        row.evaluations,
        1e3 * row.error_m,
        row.status
    );
}
