//! Resumes held moves: after the hold is complete, until the controller confirms, and to the end of
//! each move.
//!
//! A grblHAL executes 100 ms of computed motion before it decelerates (`Hold:1`), ignores `~` until
//! it stands (`Hold:0`), and may drop the rest of a short move: it is idle before the target, and
//! executes the rest only with the next move of at least one step. The same target again is no move
//! to it. While it is held it reads no lines: a move that it was sent just before is answered after
//! the hold.

use super::controller::Controller;
use super::fault::MotionFault;
use super::gcode;
use super::gcode::RESUME;
use super::pending::LinePurpose;
use super::state::{AXIS_NAMES, Mode};

/// Longest time from the wish to resume until the controller confirms it, s.
const RESUME_LIMIT_S: f64 = 1.5;
/// Times that a target is sent again before its axis counts as blocked.
const MAX_COMPLETIONS: u32 = 2;
/// Steps per millimetre of axes, `$100` to `$103`.
const STEPS_PER_MM: u16 = 100;
/// Largest displacement of a target that is sent again, mm: less than the tolerance of positions.
const MAX_DISPLACEMENT_MM: f64 = 0.015;

/// State of a hold and of the moves after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resumption {
    /// When the last hold byte was sent, s.
    pub(super) hold_sent_s: f64,
    /// Since when held moves are to be resumed, s.
    requested_s: Option<f64>,
    /// When `~` was last sent since then, and how often.
    sent_s: Option<f64>,
    sent: u32,
    /// A hold may have ended the present move short of its target.
    may_end_short: bool,
    completions: u32,
}

impl Default for Resumption {
    fn default() -> Self {
        Resumption {
            hold_sent_s: f64::NEG_INFINITY,
            requested_s: None,
            sent_s: None,
            sent: 0,
            may_end_short: false,
            completions: 0,
        }
    }
}

impl Resumption {
    /// A hold byte was sent at `now_s`.
    pub(super) fn hold(&mut self, now_s: f64) {
        *self = Resumption { hold_sent_s: now_s, may_end_short: true, ..Resumption::default() };
    }

    /// The last move has arrived.
    pub(super) fn arrived(&mut self) {
        (self.may_end_short, self.completions) = (false, 0);
    }
}

impl Controller {
    /// Resumes held moves as soon as the hold is complete, unless there is a fault.
    pub fn resume(&mut self, now_s: f64) {
        if self.fault.is_none() && self.holding {
            self.resumption.requested_s.get_or_insert(now_s);
            self.continue_resume(now_s);
        }
    }

    /// True from [`Controller::resume`] until the controller confirms.
    pub fn is_resuming(&self) -> bool {
        self.resumption.requested_s.is_some()
    }

    /// Sends `~` once the hold is complete, again while the controller still stands, and waits for
    /// its confirmation.
    pub(super) fn continue_resume(&mut self, now_s: f64) {
        let Some(requested_s) = self.resumption.requested_s else { return };
        if self.fault.is_some() {
            return;
        }
        // Only a report that was requested after the last byte tells of its effect.
        let answered_query_s = self.answered_query_s;
        let since_s = self.resumption.sent_s.unwrap_or(self.resumption.hold_sent_s);
        match self.state.mode {
            Mode::Hold { complete: true } if answered_query_s > since_s => {
                self.resumption.sent_s = Some(now_s);
                self.resumption.sent += 1;
                self.send_byte(RESUME);
            }
            Mode::Idle | Mode::Run if answered_query_s > since_s => {
                self.resumption.requested_s = None;
                self.holding = false;
                self.resumed_s = now_s;
                // The controller reads a line that it was sent before the hold only now.
                self.pending.iter_mut().for_each(|pending| pending.resume(now_s));
                self.stall_detector.restart(now_s);
            }
            mode if now_s - requested_s > RESUME_LIMIT_S => {
                let sent = self.resumption.sent;
                self.record_fault(MotionFault::NotResumed {
                    mode,
                    waited_s: now_s - requested_s,
                    sent,
                });
            }
            _ => {}
        }
    }

    /// Sends the target again if a hold has ended the last move short of it; true if it did.
    /// `position_mm` is that of standing axes.
    pub(super) fn complete_short_move(&mut self, position_mm: &[f64; 4], now_s: f64) -> bool {
        let Some((axis, _)) = self.commanded_path.farthest_axis(position_mm) else {
            self.resumption.arrived();
            return false;
        };
        let Some((target_mm, feed_mm_min)) = self.last_move else { return false };
        let due = self.resumption.may_end_short && self.resumption.completions < MAX_COMPLETIONS;
        // Off the path it did not fall short, so sending it again would hide a fault.
        if !due
            || self.holding
            || !self.setup_acknowledged
            || !self.commanded_path.is_between(position_mm)
        {
            return false;
        }
        let displaced_mm = self.displaced_mm(target_mm, axis);
        let Ok(the_move) = gcode::compose(displaced_mm, feed_mm_min, &self.settings) else {
            return false;
        };
        self.resumption.completions += 1;
        self.state.message = format!(
            "{} stopped at {:.3} mm in a hold; target {:.3} mm sent again",
            AXIS_NAMES[axis], position_mm[axis], target_mm[axis]
        );
        self.commanded_path.push(the_move.target_mm);
        self.send(the_move.line, LinePurpose::Move, now_s);
        true
    }

    /// `target_mm` with `axis` displaced by one step, away from the nearer end of its travel.
    fn displaced_mm(&self, mut target_mm: [f64; 4], axis: usize) -> [f64; 4] {
        let setting = self.info.settings.get(&(STEPS_PER_MM + axis as u16));
        let steps_per_mm: f64 = setting.and_then(|value| value.parse().ok()).unwrap_or(0.0);
        let step_mm = if steps_per_mm > 0.0 {
            (1e3 / steps_per_mm).ceil() * 1e-3
        } else {
            MAX_DISPLACEMENT_MM
        };
        let (low_mm, high_mm) = self.settings.limits_mm(axis);
        // A target at the end of its travel can only be displaced inwards.
        let inwards = if target_mm[axis] > 0.5 * (low_mm + high_mm) { -1.0 } else { 1.0 };
        // A second attempt must differ from the first one.
        let attempt = f64::from(self.resumption.completions + 1);
        target_mm[axis] += inwards * (attempt * step_mm).min(MAX_DISPLACEMENT_MM);
        target_mm
    }
}
