//! Share of lost frames in the recent past.

use std::collections::VecDeque;

/// Frames over which losses are counted: 2.56 s at 100 Hz.
const FRAMES: usize = 256;
/// Frames of one gap that count as lost: longer gaps are judged by the age of the last pose.
const MAX_OF_GAP: u64 = 10;

/// The last frames, received or lost.
#[derive(Clone, Debug, Default)]
pub(super) struct RecentLosses {
    received: VecDeque<bool>,
}

impl RecentLosses {
    /// Adds a frame that was received after `lost` missing ones.
    pub(super) fn add(&mut self, lost: u64) {
        for _ in 0..lost.min(MAX_OF_GAP) {
            self.received.push_back(false);
        }
        self.received.push_back(true);
        while self.received.len() > FRAMES {
            self.received.pop_front();
        }
    }

    /// A frame that counts as lost has arrived after a later one.
    pub(super) fn arrived_late(&mut self) {
        // The newest gap is the likeliest place of a late frame.
        if let Some(lost) = self.received.iter_mut().rev().find(|received| !**received) {
            *lost = true;
        }
    }

    /// Share of lost frames; none before there are enough of them.
    pub(super) fn share(&self) -> Option<f64> {
        let lost = self.received.iter().filter(|received| !**received).count();
        (self.received.len() == FRAMES).then(|| lost as f64 / FRAMES as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_gap_is_no_steady_loss() {
        let mut losses = RecentLosses::default();
        (0..FRAMES - 1).for_each(|_| losses.add(0));
        assert_eq!(losses.share(), None);
        losses.add(5000);
        assert!(losses.share().is_some_and(|share| share < 0.05));
        (0..FRAMES).for_each(|_| losses.add(1));
        assert_eq!(losses.share(), Some(0.5));
        (0..FRAMES / 4).for_each(|_| losses.arrived_late());
        assert_eq!(losses.share(), Some(0.25));
    }
}
