//! Four lead screws with motors: a queue of straight moves with limited acceleration.

use std::collections::VecDeque;

/// Time step of the motion, seconds.
const STEP_S: f64 = 1e-3;
/// Remaining distance below which a move has ended, mm.
const END_TOLERANCE_MM: f64 = 5e-4;
/// Junction deviation, which sets the speed at corners, mm (`$11`).
const JUNCTION_MM: f64 = 0.01;
/// Motion that is computed ahead and that a hold no longer changes, s: grblHAL's ten segments of 10
/// ms.
const COMPUTED_AHEAD_S: f64 = 0.1;
/// A hold that ends a last move within this time of its end discards the move, s: half of the
/// segments.
const DISCARDED_S: f64 = 0.05;

/// Speed and acceleration limits of a move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionLimits {
    /// Along the path, mm/min.
    pub(crate) feed_mm_min: f64,
    /// Of each axis, mm/min.
    pub(crate) max_speed_mm_min: [f64; 4],
    /// Of each axis, mm/s².
    pub(crate) acceleration_mm_s2: [f64; 4],
}

/// A straight move.
#[derive(Clone, Debug)]
struct PlannedMove {
    target_mm: [f64; 4],
    direction: [f64; 4],
    remaining_mm: f64,
    speed_mm_s: f64,
    acceleration_mm_s2: f64,
    /// Largest speed at its start, from the corner before it.
    corner_mm_s: f64,
    /// Largest speed at its end.
    exit_mm_s: f64,
}

/// Motors and screws.
#[derive(Clone, Debug, Default)]
pub(crate) struct SimulatedAxes {
    /// Positions that the controller counts, mm.
    pub(crate) counted_mm: [f64; 4],
    /// True positions of the screws, mm from home.
    pub(crate) screws_mm: [f64; 4],
    /// Axes that neither turn nor count.
    pub(crate) dead: [bool; 4],
    /// Axes that count but do not turn.
    pub(crate) slipping: [bool; 4],
    /// Decelerating to a standstill, or standing.
    holding: bool,
    /// Remaining time of the motion that was computed before the hold, s.
    ahead_s: f64,
    /// What a hold has left of a move that is no longer in the queue: it runs with the next move.
    remainder: Option<PlannedMove>,
    planned_mm: [f64; 4],
    blocks: VecDeque<PlannedMove>,
    speed_mm_s: f64,
    rest_s: f64,
}

impl SimulatedAxes {
    /// Moves in the queue, including the running one.
    pub(crate) fn queued(&self) -> usize {
        self.blocks.len()
    }

    /// Speed along the path, mm/min.
    pub(crate) fn speed_mm_min(&self) -> f64 {
        self.speed_mm_s * 60.0
    }

    /// Positions that the controller counted `earlier_s` ago, mm, if it has moved as it does now
    /// since then.
    pub(crate) fn counted_before_mm(&self, earlier_s: f64) -> [f64; 4] {
        let direction = self.blocks.front().map_or([0.0; 4], |block| block.direction);
        std::array::from_fn(|axis| {
            self.counted_mm[axis] - direction[axis] * self.speed_mm_s * earlier_s
        })
    }

    /// End of the last move, mm.
    pub(crate) fn planned_mm(&self) -> [f64; 4] {
        self.planned_mm
    }

    /// Axes whose screws are at `screws_mm`, mm from home.
    pub(crate) fn at(screws_mm: [f64; 4]) -> SimulatedAxes {
        SimulatedAxes { screws_mm, ..SimulatedAxes::default() }
    }

    /// Decelerates to a standstill. A feed hold first executes the motion that is computed already,
    /// as grblHAL does; a cancelled jog does not.
    pub(crate) fn hold(&mut self, after_computed_motion: bool) {
        if !self.holding {
            self.ahead_s = if after_computed_motion { COMPUTED_AHEAD_S } else { 0.0 };
        }
        self.holding = true;
    }

    /// True from a hold until the axes stand.
    pub(crate) fn is_stopping(&self) -> bool {
        self.holding && !self.blocks.is_empty() && (self.speed_mm_s > 0.0 || self.ahead_s > 0.0)
    }

    /// Goes on after a hold.
    pub(crate) fn resume(&mut self) {
        self.holding = false;
    }

    /// Discards all moves; the axes stop at once.
    pub(crate) fn stop(&mut self) {
        self.blocks.clear();
        self.remainder = None;
        self.holding = false;
        self.halt();
        self.planned_mm = self.counted_mm;
    }

    /// The axes stop at once; the moves stay in the queue.
    pub(crate) fn halt(&mut self) {
        self.speed_mm_s = 0.0;
        self.rest_s = 0.0;
    }

    /// Sets the positions that the controller counts.
    pub(crate) fn count_from(&mut self, position_mm: [f64; 4]) {
        self.counted_mm = position_mm;
        self.stop();
    }

    /// Adds a move to `target_mm`; none if the distance is negligible.
    pub(crate) fn push(&mut self, target_mm: [f64; 4], limits: &MotionLimits) {
        let way: [f64; 4] = std::array::from_fn(|axis| target_mm[axis] - self.planned_mm[axis]);
        let length_mm = way.iter().map(|part| part * part).sum::<f64>().sqrt();
        if length_mm < END_TOLERANCE_MM {
            return;
        }
        self.blocks.extend(self.remainder.take());
        let direction = way.map(|part| part / length_mm);
        let along = |per_axis: [f64; 4]| {
            let shares = per_axis.into_iter().zip(direction).filter(|(_, part)| part.abs() > 1e-9);
            shares.map(|(limit, part)| limit / part.abs()).fold(f64::INFINITY, f64::min)
        };
        let speed_mm_s = limits.feed_mm_min.min(along(limits.max_speed_mm_min)) / 60.0;
        let acceleration_mm_s2 = along(limits.acceleration_mm_s2);
        let corner_mm_s = self.blocks.back().map_or(0.0, |before| {
            corner_mm_s(&before.direction, &direction, acceleration_mm_s2)
                .min(speed_mm_s)
                .min(before.speed_mm_s)
        });
        self.planned_mm = target_mm;
        self.blocks.push_back(PlannedMove {
            target_mm,
            direction,
            remaining_mm: length_mm,
            speed_mm_s,
            acceleration_mm_s2,
            corner_mm_s,
            exit_mm_s: 0.0,
        });
        self.limit_exit_speeds();
    }

    /// Limits the exit speed of every move so that the following ones can stop in time.
    fn limit_exit_speeds(&mut self) {
        let mut next_mm_s = 0.0;
        for block in self.blocks.iter_mut().rev() {
            block.exit_mm_s = next_mm_s;
            // v² = v_exit² + 2 a s.
            let stoppable_mm_s = (next_mm_s * next_mm_s
                + 2.0 * block.acceleration_mm_s2 * block.remaining_mm)
                .sqrt();
            next_mm_s = block.corner_mm_s.min(stoppable_mm_s);
        }
    }

    /// Advances the motion by `duration_s`.
    pub(crate) fn advance(&mut self, duration_s: f64) {
        self.rest_s += duration_s;
        while self.rest_s >= STEP_S && !self.blocks.is_empty() {
            self.rest_s -= STEP_S;
            self.step();
        }
        if self.blocks.is_empty() {
            self.halt();
        }
    }

    fn step(&mut self) {
        let Some(block) = self.blocks.front_mut() else { return };
        let change_mm_s = block.acceleration_mm_s2 * STEP_S;
        let stops = self.holding && self.ahead_s <= 0.0;
        self.ahead_s = (self.ahead_s - STEP_S).max(0.0);
        self.speed_mm_s = if stops {
            (self.speed_mm_s - change_mm_s).max(0.0)
        } else {
            let stoppable_mm_s = (block.exit_mm_s.powi(2)
                + 2.0 * block.acceleration_mm_s2 * block.remaining_mm)
                .sqrt();
            (self.speed_mm_s + change_mm_s).min(block.speed_mm_s).min(stoppable_mm_s)
        };
        let mut way_mm = (self.speed_mm_s * STEP_S).min(block.remaining_mm);
        let ends = block.remaining_mm - way_mm < END_TOLERANCE_MM && !stops;
        if ends {
            way_mm = block.remaining_mm;
        }
        block.remaining_mm -= way_mm;
        let (direction, target_mm) = (block.direction, block.target_mm);
        self.turn(std::array::from_fn(|axis| direction[axis] * way_mm));
        if ends {
            self.blocks.pop_front();
            self.settle(target_mm);
        }
        if stops && self.speed_mm_s == 0.0 {
            self.discard_remainder();
        }
    }

    /// Late in its last move, a grblHAL that is held removes the move from its queue (`Bf` is then
    /// that of an empty one, and a resume ends in `Idle`), although its segments remain. They are
    /// executed with the next move that has at least one step.
    fn discard_remainder(&mut self) {
        let last = self.blocks.len() == 1;
        if last
            && self.blocks[0].remaining_mm > 0.0
            && self.blocks[0].remaining_mm <= DISCARDED_S * self.blocks[0].speed_mm_s
        {
            self.remainder =
                self.blocks.pop_front().map(|block| PlannedMove { exit_mm_s: 0.0, ..block });
            self.halt();
        }
    }

    /// Turns the screws by `way_mm`.
    pub(crate) fn turn(&mut self, way_mm: [f64; 4]) {
        for axis in 0..4 {
            if !self.dead[axis] {
                self.counted_mm[axis] += way_mm[axis];
            }
            if !self.dead[axis] && !self.slipping[axis] {
                self.screws_mm[axis] += way_mm[axis];
            }
        }
    }

    /// Prevents rounding errors from accumulating over moves.
    fn settle(&mut self, target_mm: [f64; 4]) {
        for axis in 0..4 {
            if (self.counted_mm[axis] - target_mm[axis]).abs() < 1e-6 {
                self.counted_mm[axis] = target_mm[axis];
            }
        }
    }
}

/// Largest speed at a corner, by GRBL's junction deviation.
fn corner_mm_s(before: &[f64; 4], after: &[f64; 4], acceleration_mm_s2: f64) -> f64 {
    let cosine = -before.iter().zip(after).map(|(one, other)| one * other).sum::<f64>();
    // Back the way it came: a stop. Straight on: no limit.
    if cosine > 0.999_999 {
        return 0.0;
    }
    let half_sine = (0.5 * (1.0 - cosine)).max(0.0).sqrt();
    if half_sine > 0.999_999 {
        return f64::INFINITY;
    }
    // v² = a δ sin(θ/2) / (1 − sin(θ/2)), θ the angle between the two moves.
    (acceleration_mm_s2 * JUNCTION_MM * half_sine / (1.0 - half_sine)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: MotionLimits = MotionLimits {
        feed_mm_min: 600.0,
        max_speed_mm_min: [600.0; 4],
        acceleration_mm_s2: [50.0; 4],
    };

    #[test]
    fn a_move_takes_the_time_of_its_trapezium() {
        let mut axes = SimulatedAxes::default();
        axes.push([10.0, 0.0, 0.0, 0.0], &PACE);
        axes.advance(1.19);
        assert!(axes.queued() == 1);
        axes.advance(0.03);
        assert_eq!((axes.queued(), axes.counted_mm[0]), (0, 10.0));
    }

    #[test]
    fn straight_moves_run_into_each_other_and_a_hold_stops_between() {
        let mut axes = SimulatedAxes::default();
        (1..=5).for_each(|k| axes.push([2.0 * f64::from(k), 0.0, 0.0, 0.0], &PACE));
        axes.advance(0.5);
        assert!((axes.speed_mm_min() - 600.0).abs() < 1.0, "{}", axes.speed_mm_min());
        axes.hold(true);
        axes.advance(0.09);
        assert!(axes.is_stopping() && axes.speed_mm_min() > 599.0, "computed ahead");
        axes.advance(0.22);
        assert!(axes.speed_mm_min() == 0.0 && axes.queued() > 0 && !axes.is_stopping());
        axes.resume();
        axes.advance(2.0);
        assert_eq!(axes.counted_mm[0], 10.0);
    }

    /// As measured with grblHAL's simulator: F1125, 500 mm/s², a move of 3 mm held after 50 ms.
    #[test]
    fn a_short_move_that_is_held_late_ends_short_and_its_rest_runs_with_the_next_move() {
        let fast = MotionLimits {
            feed_mm_min: 1125.0,
            max_speed_mm_min: [3000.0; 4],
            acceleration_mm_s2: [500.0; 4],
        };
        let mut axes = SimulatedAxes::default();
        axes.push([3.0, 0.0, 0.0, 0.0], &fast);
        axes.advance(0.05);
        axes.hold(true);
        axes.advance(0.3);
        let held_mm = axes.counted_mm[0];
        assert!((2.0..2.95).contains(&held_mm) && axes.queued() == 0, "{held_mm}");
        axes.resume();
        axes.advance(0.5);
        assert_eq!(axes.counted_mm[0], held_mm);
        axes.push([3.0, 0.0, 0.0, 0.0], &fast);
        axes.advance(0.5);
        assert_eq!(axes.counted_mm[0], held_mm, "the target of the last move is no move");
        axes.push([3.0, 0.0025, 0.0, 0.0], &fast);
        axes.advance(0.5);
        assert!(
            (axes.counted_mm[0] - 3.0).abs() < 1e-9 && (axes.counted_mm[1] - 0.0025).abs() < 1e-9
        );
    }
}
