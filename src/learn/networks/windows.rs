//! Split of the rows into training and validation, and the windows in them.

use super::config::NetworkConfig;
use crate::learn::LearnError;

/// Contiguous runs of rows, none across the start of a sequence.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Split {
    pub(super) train: Vec<std::ops::Range<usize>>,
    pub(super) validate: Vec<std::ops::Range<usize>>,
}

/// Checks that start rows increase and exist.
pub(super) fn check_sequences(sequences: &[usize], rows: usize) -> Result<(), LearnError> {
    let mut previous = None;
    for (place, &start) in sequences.iter().enumerate() {
        if start >= rows || previous.is_some_and(|p| start <= p) {
            return Err(LearnError::Sequences { place, found: start, rows });
        }
        previous = Some(start);
    }
    Ok(())
}

impl Split {
    /// Cuts `rows` rows into `split_blocks` blocks in time order, each block's first `train_share`
    /// to training and its rest to validation, and both at the starts of sequences.
    pub(super) fn new(
        rows: usize,
        sequences: &[usize],
        config: &NetworkConfig,
    ) -> Result<Self, LearnError> {
        check_sequences(sequences, rows)?;
        let mut split = Split::default();
        for block in 0..config.split_blocks {
            let (from, to) =
                (block * rows / config.split_blocks, (block + 1) * rows / config.split_blocks);
            let middle = from + ((to - from) as f64 * config.train_share).round() as usize;
            split.train.extend(cut(from..middle, sequences));
            split.validate.extend(cut(middle..to, sequences));
        }
        let windows: usize =
            split.train.iter().map(|run| (run.len() + 1).saturating_sub(config.window)).sum();
        let validation_rows: usize = split.validate.iter().map(ExactSizeIterator::len).sum();
        if windows == 0 || validation_rows == 0 {
            let why = "a window of training rows within one sequence and a row to validate on";
            let needed = ((config.window as f64 / config.train_share).ceil() as usize + 1)
                * config.split_blocks;
            return Err(LearnError::TooFewRows { found: rows, needed, why });
        }
        Ok(split)
    }

    /// Numbers of the training rows.
    pub(super) fn training_rows(&self) -> Vec<usize> {
        self.train.iter().cloned().flatten().collect()
    }

    /// First rows of the windows of one epoch: every `stride`-th from `offset` on in each run.
    pub(super) fn windows(&self, window: usize, stride: usize, offset: usize) -> Vec<u32> {
        let starts = |run: &std::ops::Range<usize>| {
            let count = (run.len() + 1).saturating_sub(window);
            // A short run must not lose its only windows to an offset.
            let offset = if count == 0 { 0 } else { offset % stride.min(count) };
            (run.start + offset..run.start + count).step_by(stride)
        };
        self.train.iter().flat_map(starts).map(|start| start as u32).collect()
    }
}

/// A run of rows cut at the starts of sequences.
fn cut(run: std::ops::Range<usize>, sequences: &[usize]) -> Vec<std::ops::Range<usize>> {
    let inside = sequences.iter().copied().filter(|&s| s > run.start && s < run.end);
    let mut edges = vec![run.start];
    edges.extend(inside);
    edges.push(run.end);
    edges.windows(2).map(|pair| pair[0]..pair[1]).filter(|run| !run.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_cross_neither_split_nor_sequence() {
        let config = NetworkConfig { window: 3, split_blocks: 2, ..NetworkConfig::default() };
        let split = Split::new(20, &[0, 5], &config).unwrap();
        assert_eq!(split.train, [0..5, 5..7, 10..17]);
        assert_eq!(split.validate, [7..10, 17..20]);
        assert_eq!(split.windows(3, 1, 0), [0, 1, 2, 10, 11, 12, 13, 14]);
        assert_eq!(split.windows(3, 3, 1), [1, 11, 14]);
        assert_eq!(split.training_rows().len(), 14);
    }

    #[test]
    fn bad_sequences_are_named() {
        let config = NetworkConfig::default();
        assert_eq!(
            Split::new(50, &[0, 30, 30], &config),
            Err(LearnError::Sequences { place: 2, found: 30, rows: 50 })
        );
        assert!(matches!(
            Split::new(10, &[], &config),
            Err(LearnError::TooFewRows { found: 10, .. })
        ));
    }
}
