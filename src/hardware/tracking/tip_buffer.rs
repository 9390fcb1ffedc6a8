//! Buffer of the latest samples, with interpolation in time.

use std::collections::VecDeque;

use super::pose::{RigidPose, TipPose};
use crate::base::Point3;

/// Capacity: five seconds at 100 Hz.
const MAX_POSES: usize = 512;

/// Largest gap that is interpolated, in frame periods: one lost frame, with some tolerance.
const MAX_INTERPOLATED_PERIODS: f64 = 2.5;

/// Tolerance of times relative to the frame period.
const PERIOD_TOLERANCE: f64 = 1e-6;

/// Valid samples in the order of their stamps.
#[derive(Clone, Debug)]
pub(super) struct TipBuffer {
    period_s: f64,
    offset_s: f64,
    samples: VecDeque<TipPose>,
}

impl TipBuffer {
    /// An empty buffer for a tracker with this frame period, s.
    pub(super) fn new(period_s: f64) -> TipBuffer {
        TipBuffer { period_s, offset_s: 0.0, samples: VecDeque::with_capacity(MAX_POSES) }
    }

    /// Sets local time minus the server's time, s; all samples shift together.
    pub(super) fn set_offset(&mut self, offset_s: f64) {
        // A falling offset shifts all samples, so that intervals between them stay true.
        if offset_s != self.offset_s {
            self.offset_s = offset_s;
            self.samples.iter_mut().for_each(|sample| sample.time_s = sample.stamp_s + offset_s);
        }
    }

    /// Adds a sample that is newer than all others.
    pub(super) fn push(&mut self, stamp_s: f64, tip: RigidPose) {
        if self.samples.len() == MAX_POSES {
            self.samples.pop_front();
        }
        self.samples.push_back(TipPose::new(stamp_s, stamp_s + self.offset_s, tip));
    }

    /// Removes all samples.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
    }

    /// The newest sample.
    pub(super) fn latest(&self) -> Option<&TipPose> {
        self.samples.back()
    }

    /// Mean tip position of the samples since a local time, metres; none without one.
    pub(super) fn mean_since(&self, since_s: f64) -> Option<Point3> {
        let recent = self.samples.iter().rev().take_while(|sample| sample.time_s >= since_s);
        let (count, sum_m) =
            recent.fold((0, [0.0; 3]), |(count, sum_m): (usize, Point3), sample| {
                (count + 1, std::array::from_fn(|axis| sum_m[axis] + sample.position_m[axis]))
            });
        (count > 0).then(|| sum_m.map(|sum_m| sum_m / count as f64))
    }

    /// The pose at a local time: interpolated between its neighbours if they are close together,
    /// else the sample before if it is at most one period old, else none.
    pub(super) fn at(&self, time_s: f64) -> Option<TipPose> {
        let after = self.samples.partition_point(|sample| sample.time_s <= time_s);
        let before = *self.samples.get(after.checked_sub(1)?)?;
        let next = self.samples.get(after);
        if let Some(next) = next.filter(|next| {
            next.time_s - before.time_s
                <= (MAX_INTERPOLATED_PERIODS + PERIOD_TOLERANCE) * self.period_s
        }) {
            let fraction = (time_s - before.time_s) / (next.time_s - before.time_s);
            let pose = before.pose().towards(&next.pose(), fraction);
            return Some(TipPose::new(time_s - self.offset_s, time_s, pose));
        }
        (time_s - before.time_s <= (1.0 + PERIOD_TOLERANCE) * self.period_s).then_some(before)
    }
}
