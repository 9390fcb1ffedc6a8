//! What is timed.

use spinebench::rows::learning_peers::LearningPeerRow;

/// Samples of the fits.
pub const SIZES: [usize; 3] = [100, 400, 1000];
/// Rows and columns of the matrices whose product measures the processor's peak.
const PRODUCT: usize = 2048;

/// A piece of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    /// Its name in the table and in requests to the packages.
    pub name: &'static str,
    /// Samples, rows trained on, or rows of a matrix.
    pub size: usize,
}

/// What came of a task.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Processor time of one repetition, s.
    pub cpu_s: f64,
    /// Sum of the outputs' log marginal likelihoods, nats.
    pub likelihood: f64,
    /// Evaluations of the likelihood, or epochs.
    pub evaluations: f64,
    /// Error on rows that were not trained on, metres.
    pub error_m: f64,
}

impl Outcome {
    /// An outcome of which only the time counts.
    pub fn of(cpu_s: f64) -> Outcome {
        Outcome { cpu_s, likelihood: f64::NAN, evaluations: f64::NAN, error_m: f64::NAN }
    }

    /// The row of this outcome or failure.
    pub fn row(
        found: Result<Outcome, String>,
        task: Task,
        peer: &str,
        round: u64,
    ) -> LearningPeerRow {
        let (outcome, status) = match found {
            Ok(outcome) => (outcome, "ok".to_owned()),
            Err(reason) => (Outcome::of(f64::NAN), reason),
        };
        LearningPeerRow {
            task: task.name.to_owned(),
            size: task.size as u64,
            peer: peer.to_owned(),
            round,
            cpu_s: outcome.cpu_s,
            likelihood: outcome.likelihood,
            evaluations: outcome.evaluations,
            error_m: outcome.error_m,
            status,
        }
    }
}

/// All of it, in the order in which it is done: predictions follow the fit that they use.
pub fn all(trained_rows: usize) -> Vec<Task> {
    let task = |name, size| Task { name, size };
    let mut tasks = vec![task("product_f64", PRODUCT), task("product_f32", PRODUCT)];
    for name in ["fit", "predict_one", "predict_many"] {
        tasks.extend(SIZES.iter().map(|&size| task(name, size)));
    }
    tasks.push(task("evaluation", SIZES[SIZES.len() - 1]));
    tasks.extend(["epoch", "until_error"].map(|name| task(name, trained_rows)));
    tasks
}
