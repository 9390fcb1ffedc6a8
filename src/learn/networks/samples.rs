//! The samples of a training.

use super::Network;
use super::history::InputHistory;
use super::windows::Split;
use crate::base::Rows;
use crate::learn::LearnError;

/// Samples, divided into those that train and those that validate.
pub(super) struct TrainingSamples {
    pub(super) split: Split,
    /// Standardised inputs with their history, and outputs, row-major.
    pub(super) inputs: Vec<f32>,
    pub(super) targets: Vec<f32>,
    /// Validation rows in their own units, one table per run.
    held_out: Vec<(Rows, Rows)>,
}

impl TrainingSamples {
    pub(super) fn new(
        network: &Network,
        inputs: &Rows,
        outputs: &Rows,
        sequences: &[usize],
        split: Split,
    ) -> Self {
        let pick = |rows: &Rows, run: &std::ops::Range<usize>| {
            rows.select(&run.clone().collect::<Vec<_>>())
        };
        let targets = outputs.values().iter().enumerate();
        TrainingSamples {
            inputs: with_history(network, inputs, sequences),
            targets: targets
                .map(|(i, v)| network.outputs.apply(i % outputs.width(), *v) as f32)
                .collect(),
            held_out: split
                .validate
                .iter()
                .map(|run| (pick(inputs, run), pick(outputs, run)))
                .collect(),
            split,
        }
    }

    /// Mean absolute error on the validation rows, in the outputs' unit.
    pub(super) fn validation_mae(&self, network: &Network) -> Result<f64, LearnError> {
        let (mut sum, mut count) = (0.0, 0);
        for (inputs, outputs) in &self.held_out {
            let answers = network.predict_rows(inputs, &[])?;
            sum += answers
                .values()
                .iter()
                .zip(outputs.values())
                .map(|(a, b)| (a - b).abs())
                .sum::<f64>();
            count += outputs.values().len();
        }
        Ok(sum / f64::from(u32::try_from(count).unwrap_or(u32::MAX)))
    }
}

/// The inputs of each row with their history.
fn with_history(network: &Network, inputs: &Rows, sequences: &[usize]) -> Vec<f32> {
    let mut history = InputHistory::new(inputs.width(), network.history);
    let mut starts = sequences.iter().copied().peekable();
    let mut table = Vec::with_capacity(inputs.values().len() * network.history);
    for (index, row) in inputs.iter().enumerate() {
        if starts.next_if_eq(&index).is_some() {
            history.reset();
        }
        table.extend_from_slice(
            history.push(row.iter().enumerate().map(|(i, v)| network.inputs.apply(i, *v) as f32)),
        );
    }
    table
}
