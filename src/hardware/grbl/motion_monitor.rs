//! Monitors motion: axes must be where their commands put them, and must move while moves are
//! pending.

use std::collections::VecDeque;

use super::fault::MotionFault;
use super::settings::MotionSettings;

/// Largest difference between reported and commanded positions, mm.
const POSITION_TOLERANCE_MM: f64 = 0.02;
/// Largest distance of moving axes from the straight lines between their commands, mm. A single
/// report may exceed it (docs/reference/hardware.md, "Resuming").
const MAX_OFF_LINE_MM: f64 = 0.1;
/// The start of the oldest move that may still be running, and the targets of at most three:
/// grblHAL reports a move as done once its last 100 ms are computed, and two more may be queued
/// then.
const MAX_TARGETS: usize = 4;
/// Equal reports after which axes count as standing, regardless of their interval.
const MIN_EQUAL_REPORTS: u32 = 3;

/// The last commanded positions; the axes are between them.
#[derive(Clone, Debug, Default)]
pub(crate) struct CommandedPath {
    targets_mm: VecDeque<[f64; 4]>,
    /// Position in the previous report.
    last_mm: [f64; 4],
    /// The previous report was off the lines: a single one may have read its axes one after the
    /// other while they moved.
    off_line: bool,
}

impl CommandedPath {
    /// False while the position of the axes is unknown.
    pub(crate) fn is_known(&self) -> bool {
        !self.targets_mm.is_empty()
    }

    /// Discards the commanded positions.
    pub(crate) fn discard(&mut self) {
        self.targets_mm.clear();
    }

    /// Sets the present position as the start.
    pub(crate) fn start(&mut self, position_mm: [f64; 4]) {
        self.targets_mm = VecDeque::from([position_mm]);
        (self.last_mm, self.off_line) = (position_mm, false);
    }

    /// Adds the target of a move.
    pub(crate) fn push(&mut self, target_mm: [f64; 4]) {
        self.targets_mm.push_back(target_mm);
        if self.targets_mm.len() > MAX_TARGETS {
            self.targets_mm.pop_front();
        }
    }

    /// Compares a report with the commands; `standing` when all moves are done.
    pub(crate) fn check(
        &mut self,
        position_mm: [f64; 4],
        standing: bool,
    ) -> Result<(), MotionFault> {
        let Some(&target_mm) = self.targets_mm.back() else { return Ok(()) };
        for axis in 0..4 {
            self.check_axis(axis, position_mm[axis], standing).map_err(|fault| match fault {
                MotionFault::NotMoving { axis, .. } => self.not_moving(axis, &position_mm),
                other => other,
            })?;
        }
        let off_line = if standing { Ok(()) } else { self.check_line(&position_mm) };
        // Two reports in a row: a single one may have read its axes while they moved.
        if std::mem::replace(&mut self.off_line, off_line.is_err()) {
            off_line?;
        }
        self.last_mm = position_mm;
        if standing {
            // All moves are done, so that earlier targets permit nothing any more.
            self.targets_mm = VecDeque::from([target_mm]);
        }
        Ok(())
    }

    /// The axis with the longest remaining distance, and its target, mm; none when all axes have
    /// arrived.
    pub(crate) fn farthest_axis(&self, position_mm: &[f64; 4]) -> Option<(usize, f64)> {
        let target_mm = self.targets_mm.back()?;
        let remaining_mm = |axis: usize| (target_mm[axis] - position_mm[axis]).abs();
        let axis = (0..4).max_by(|&a, &b| remaining_mm(a).total_cmp(&remaining_mm(b)))?;
        (remaining_mm(axis) > POSITION_TOLERANCE_MM).then_some((axis, target_mm[axis]))
    }

    /// True for a position on the way to the last target.
    pub(crate) fn is_between(&self, position_mm: &[f64; 4]) -> bool {
        let on_its_way = |axis: usize| self.check_axis(axis, position_mm[axis], false).is_ok();
        (0..4).all(on_its_way) && self.check_line(position_mm).is_ok()
    }

    /// All axes arrive together: an axis that stands while the others move puts the position off
    /// the line.
    fn check_line(&self, position_mm: &[f64; 4]) -> Result<(), MotionFault> {
        let targets: Vec<&[f64; 4]> = self.targets_mm.iter().collect();
        // Any of the moves that may still run can be the present one.
        let nearest = targets.windows(2).map(|ends| nearest_mm(ends[0], ends[1], position_mm));
        let distance_mm = |place: &[f64; 4]| {
            place.iter().zip(position_mm).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let Some(place) = nearest.min_by(|a, b| distance_mm(a).total_cmp(&distance_mm(b))) else {
            return Ok(());
        };
        if distance_mm(&place) <= MAX_OFF_LINE_MM {
            return Ok(());
        }
        let behind_mm = |axis: usize| {
            let stands = (position_mm[axis] - self.last_mm[axis]).abs() <= POSITION_TOLERANCE_MM;
            // An axis that stands is named before one that lags.
            let weight = if stands { 1e3 } else { 1.0 };
            weight * (place[axis] - position_mm[axis]).abs()
        };
        let axis = (0..4).max_by(|&a, &b| behind_mm(a).total_cmp(&behind_mm(b))).unwrap_or(0);
        let target_mm = self.targets_mm.back().map_or(place[axis], |target_mm| target_mm[axis]);
        Err(MotionFault::NotMoving { axis, reached_mm: position_mm[axis], target_mm })
    }

    /// The fault of an axis that does not move towards its target; all axes are named if none does.
    pub(crate) fn not_moving(&self, axis: usize, position_mm: &[f64; 4]) -> MotionFault {
        let (Some(start_mm), Some(&target_mm)) = (self.targets_mm.front(), self.targets_mm.back())
        else {
            let (reached_mm, target_mm) = (position_mm[axis], position_mm[axis]);
            return MotionFault::NotMoving { axis, reached_mm, target_mm };
        };
        let apart = |a: f64, b: f64| (a - b).abs() > POSITION_TOLERANCE_MM;
        let due: Vec<usize> = (0..4).filter(|&k| apart(start_mm[k], target_mm[k])).collect();
        let stands = |&k: &usize| {
            apart(position_mm[k], target_mm[k]) && !apart(position_mm[k], self.last_mm[k])
        };
        if due.len() > 1 && due.iter().all(stands) {
            return MotionFault::NoAxisMoves { reached_mm: *position_mm, target_mm };
        }
        MotionFault::NotMoving { axis, reached_mm: position_mm[axis], target_mm: target_mm[axis] }
    }

    fn check_axis(&self, axis: usize, position_mm: f64, standing: bool) -> Result<(), MotionFault> {
        let mut commands = self.targets_mm.iter().map(|target_mm| target_mm[axis]);
        let low_mm = commands.clone().fold(f64::INFINITY, f64::min);
        let high_mm = commands.clone().fold(f64::NEG_INFINITY, f64::max);
        let target_mm = commands.next_back().unwrap_or(position_mm);
        let on_its_way = (low_mm - POSITION_TOLERANCE_MM..=high_mm + POSITION_TOLERANCE_MM)
            .contains(&position_mm);
        let arrived = (position_mm - target_mm).abs() <= POSITION_TOLERANCE_MM;
        let stays = (position_mm - self.last_mm[axis]).abs() <= POSITION_TOLERANCE_MM;
        // A standing axis must be at its target, a moving one between its commands.
        if arrived || (on_its_way && !standing) {
            return Ok(());
        }
        // Short of the target it stalled; elsewhere something else has moved it.
        if on_its_way || stays {
            return Err(MotionFault::NotMoving { axis, reached_mm: position_mm, target_mm });
        }
        Err(MotionFault::Moved { axis, position_mm, low_mm, high_mm })
    }
}

/// Detects a stall: neither the axes nor the queue advance although moves are pending. A controller
/// whose motion freezes may go on reporting that it moves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StallDetector {
    since_s: f64,
    reports: u32,
    position_mm: [f64; 4],
    queued: usize,
}

impl StallDetector {
    /// Restarts the measurement at `now_s`.
    pub(crate) fn restart(&mut self, now_s: f64) {
        (self.since_s, self.reports) = (now_s, 0);
    }

    /// Takes the next report, of a controller that should be moving when `due`; returns how long it
    /// has not moved, s.
    pub(crate) fn add_report(
        &mut self,
        due: bool,
        position_mm: [f64; 4],
        queued: usize,
        now_s: f64,
    ) -> f64 {
        // A shorter queue is progress, too: moves may be shorter than the resolution.
        let has_advanced = position_mm != self.position_mm || queued < self.queued;
        (self.position_mm, self.queued) = (position_mm, queued);
        if has_advanced || !due {
            self.restart(now_s);
        }
        self.reports += 1;
        if self.reports > MIN_EQUAL_REPORTS { now_s - self.since_s } else { 0.0 }
    }
}

/// The point between `from` and `to` that is nearest to `position`, mm.
fn nearest_mm(from: &[f64; 4], to: &[f64; 4], position: &[f64; 4]) -> [f64; 4] {
    let way: [f64; 4] = std::array::from_fn(|axis| to[axis] - from[axis]);
    let length2: f64 = way.iter().map(|x| x * x).sum();
    let along: f64 = (0..4).map(|axis| way[axis] * (position[axis] - from[axis])).sum();
    let share = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    std::array::from_fn(|axis| from[axis] + share * way[axis])
}

/// Refuses a position beyond the ends of a screw.
pub(crate) fn within_travel(
    position_mm: &[f64; 4],
    settings: &MotionSettings,
) -> Result<(), MotionFault> {
    for (axis, &position_mm) in position_mm.iter().enumerate() {
        let (low_mm, high_mm) = settings.limits_mm(axis);
        if !(low_mm - POSITION_TOLERANCE_MM..=high_mm + POSITION_TOLERANCE_MM)
            .contains(&position_mm)
        {
            return Err(MotionFault::OutsideTravel { axis, position_mm, low_mm, high_mm });
        }
    }
    Ok(())
}
