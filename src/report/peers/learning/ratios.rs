//! Times of packages over ours, round by round: what disturbs a round disturbs both.

use crate::math::summary::{interval_95, mean};
use crate::rows::learning_peers::LearningPeerRow;

/// Our own name in the table.
pub(super) const OURS: &str = "spinebench";

/// A geometric mean over rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Averaged {
    pub(super) mean: f64,
    /// 95 % interval by Student's t of the logarithms; `None` for one round.
    pub(super) interval: Option<[f64; 2]>,
}

impl Averaged {
    fn of(values: &[f64]) -> Option<Averaged> {
        let logarithms: Vec<f64> = values.iter().map(|value| value.ln()).collect();
        let centre = mean(&logarithms).exp();
        let interval = interval_95(&logarithms).map(|ends| ends.map(f64::exp));
        centre.is_finite().then_some(Averaged { mean: centre, interval })
    }

    /// One over it.
    pub(super) fn inverse(self) -> Averaged {
        Averaged {
            mean: 1.0 / self.mean,
            interval: self.interval.map(|[low, high]| [1.0 / high, 1.0 / low]),
        }
    }
}

/// One task at one size.
#[derive(Clone, Copy, Debug)]
pub(super) struct TaskRows<'a> {
    rows: &'a [LearningPeerRow],
    pub(super) task: &'a str,
    pub(super) size: u64,
}

impl<'a> TaskRows<'a> {
    /// The tasks and sizes of `rows`, in the order of their first appearance.
    pub(super) fn all(rows: &'a [LearningPeerRow]) -> Vec<TaskRows<'a>> {
        let mut tasks: Vec<TaskRows<'a>> = Vec::new();
        for row in rows {
            if !tasks.iter().any(|task| task.task == row.task && task.size == row.size) {
                tasks.push(TaskRows { rows, task: &row.task, size: row.size });
            }
        }
        tasks
    }

    /// The rows of a package that did not fail.
    pub(super) fn of(self, peer: &str) -> impl Iterator<Item = &'a LearningPeerRow> {
        self.rows.iter().filter(move |row| {
            row.task == self.task
                && row.size == self.size
                && row.peer == peer
                && row.cpu_s > 0.0
                && row.cpu_s.is_finite()
        })
    }

    /// Processor time of a package, s.
    pub(super) fn cpu_s(self, peer: &str) -> Option<Averaged> {
        Averaged::of(&self.of(peer).map(|row| row.cpu_s).collect::<Vec<_>>())
    }

    /// Processor time of a package over ours.
    pub(super) fn ratio(self, peer: &str) -> Option<Averaged> {
        self.ratio_of(|round| self.in_round(peer, round))
    }

    /// Processor time of the fastest other package of each round over ours.
    pub(super) fn ratio_of_best(self) -> Option<Averaged> {
        let others = |round| {
            let other_rows =
                self.rows.iter().filter(move |row| row.peer != OURS && row.round == round);
            other_rows
                .filter(|row| row.task == self.task && row.size == self.size && row.cpu_s > 0.0)
                .map(|row| row.cpu_s)
        };
        self.ratio_of(|round| others(round).min_by(f64::total_cmp))
    }

    fn in_round(self, peer: &str, round: u64) -> Option<f64> {
        self.of(peer).find(|row| row.round == round).map(|row| row.cpu_s)
    }

    fn ratio_of(self, time_s: impl Fn(u64) -> Option<f64>) -> Option<Averaged> {
        let ratios: Vec<f64> =
            self.of(OURS).filter_map(|ours| Some(time_s(ours.round)? / ours.cpu_s)).collect();
        Averaged::of(&ratios)
    }

    /// Mean of another column of a package.
    pub(super) fn mean(self, peer: &str, column: impl Fn(&LearningPeerRow) -> f64) -> Option<f64> {
        let values: Vec<f64> = self.of(peer).map(column).collect();
        Some(mean(&values)).filter(|value| value.is_finite())
    }

    /// Floating-point operations of the task, where they are counted; the same for every package.
    pub(super) fn operations(self) -> Option<f64> {
        let n = self.size as f64;
        match self.task {
            "product_f64" | "product_f32" => Some(2.0 * n.powi(3)),
            // A third for the factor, two thirds for the inverse.
            "evaluation" => Some(n.powi(3)),
            // A triangle times a vector for each of three outputs and 10,000 queries.
            "predict_many" => Some(3.0 * 1e4 * n * n),
            // Forward, and twice as much backward: 30 units with 7 inputs, 30 states and a
            // constant, and 3 outputs; a window of ten from every row that has nine after it.
            "epoch" => Some(6.0 * (30.0 * 38.0 + 3.0 * 31.0) * 10.0 * (n - 9.0)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(peer: &str, round: u64, cpu_s: f64) -> LearningPeerRow {
        LearningPeerRow {
            task: "fit".to_owned(),
            size: 100,
            peer: peer.to_owned(),
            round,
            cpu_s,
            likelihood: f64::NAN,
            evaluations: f64::NAN,
            error_m: f64::NAN,
            status: crate::base::Outcome::Ok,
        }
    }

    #[test]
    fn ratios_pair_the_times_of_a_round_and_leave_failures_out() {
        let times =
            [("spinebench", [1.0, 2.0, 4.0]), ("a", [2.0, 8.0, 8.0]), ("b", [3.0, f64::NAN, 4.0])];
        let rows: Vec<LearningPeerRow> = times
            .iter()
            .flat_map(|(peer, cpu_s)| {
                cpu_s.iter().zip(1..).map(|(&cpu_s, round)| row(peer, round, cpu_s))
            })
            .collect();
        let task = TaskRows::all(&rows)[0];
        let a = task.ratio("a").unwrap();
        assert!((a.mean - 16f64.cbrt()).abs() < 1e-12, "{a:?}");
        let [low, high] = a.interval.unwrap();
        assert!(low < a.mean && a.mean < high && (low * high - a.mean * a.mean).abs() < 1e-9);
        assert!((task.ratio("b").unwrap().mean - 3f64.sqrt()).abs() < 1e-12);
        // 2, 4 and 1 times ours.
        assert!((task.ratio_of_best().unwrap().mean - 2.0).abs() < 1e-12);
        assert_eq!(task.ratio("c"), None);
        assert_eq!(TaskRows { size: 7, ..task }.ratio_of_best(), None);
    }
}
