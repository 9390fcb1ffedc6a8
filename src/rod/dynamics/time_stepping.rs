//! Time stepping: a diagonally implicit Runge–Kutta scheme with error control.

use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::{Drive, Rod};
use crate::rod::state::rod_state::RodState;

/// Tolerance of a stage as a share of the step's allowed error …
const STAGE_SHARE: f64 = 1e-2;
/// … and for constant steps, metres.
const STAGE_TOLERANCE_M: f64 = 1e-8;
/// Shortest step as a share of the longest. A step of this length is accepted whatever its error …
const MIN_STEP_SHARE: f64 = 1.0 / 1024.0;
/// … and the number of halvings of a failing constant step.
const MAX_HALVINGS: i32 = 6;
/// Safety factor on the step length that the error would allow.
const SAFETY: f64 = 0.9;
/// A step is repeated when its allowed length is below this share of its length …
const MIN_ACCEPTED_RATIO: f64 = 0.7;
/// … and the length is kept up to this growth factor, since LU factors belong to one length.
const MAX_KEPT_RATIO: f64 = 1.3;
const MAX_GROWTH: f64 = 2.0;

impl Rod {
    /// Moves the rod for `duration_s` with `drives` held.
    pub fn advance(&mut self, drives: &[Drive], duration_s: f64) -> SolveStatus {
        self.advance_with(&|_| drives.to_vec(), duration_s)
    }

    /// Moves the rod for `duration_s`. `drives` gives the drives at a time from now, seconds. Jumps
    /// of drive speed should lie at the beginning or the end. Durations below a thousandth of the
    /// longest step are added up until they make a step.
    pub fn advance_with(
        &mut self,
        drives: &dyn Fn(f64) -> Vec<Drive>,
        duration_s: f64,
    ) -> SolveStatus {
        let resolution = self.system.params.resolution;
        let owed_s = std::mem::take(&mut self.step_size.owed_s);
        // The solver's error of position, which a step corrects, is one of velocity that is larger
        // by 1/h.
        if owed_s + duration_s < MIN_STEP_SHARE * resolution.time_step_s {
            self.step_size.owed_s = owed_s + duration_s;
            let is_command = self.constraints(&drives(duration_s)).is_some();
            return if is_command { SolveStatus::Converged } else { SolveStatus::BadCommand };
        }
        self.choose_motion_grid();
        let mut elapsed_s = -owed_s;
        let mut remaining_s = owed_s + duration_s;
        while remaining_s > 1e-9 * duration_s {
            let target_s = self.step_size.next_s.min(resolution.time_step_s);
            // Rounding must not add a step.
            let count = (remaining_s / target_s - 1e-9).ceil().max(1.0);
            // The last two steps share what remains, so that none is tiny.
            let h = if count <= 2.0 { remaining_s / count } else { target_s };
            let (mut status, step_s) = self.step(&|t| drives(f64::max(0.0, elapsed_s + t)), h);
            if status == SolveStatus::Converged {
                status = self.verify_motion();
            }
            if status != SolveStatus::Converged {
                return status;
            }
            elapsed_s += step_s;
            remaining_s -= step_s;
        }
        SolveStatus::Converged
    }

    /// One time step of at most `h` seconds, shortened on failure or excessive error; returns its
    /// length as well.
    fn step(&mut self, drives: &dyn Fn(f64) -> Vec<Drive>, mut h: f64) -> (SolveStatus, f64) {
        let resolution = self.system.params.resolution;
        let share = if resolution.motion_tolerance_m.is_finite() {
            MIN_STEP_SHARE
        } else {
            0.5_f64.powi(MAX_HALVINGS)
        };
        let mut min_step_s = share * resolution.time_step_s;
        // Rounding must not forbid a step of the shortest length.
        let mut min_retry_s = 0.999 * min_step_s.min(h);
        let mut before = std::mem::take(&mut self.before);
        before.copy_from(&self.state);
        let status = loop {
            let status = self.try_step(drives, h, &before);
            // A failed solve shortens the step as an infinite error would.
            let mut ratio =
                if status == SolveStatus::Converged { self.step_ratio(&before, h) } else { 0.0 };
            // Stability is asked only of a step that is accurate, since it may cost a derivative.
            if ratio >= MIN_ACCEPTED_RATIO {
                let growth_step_ratio = self.growth_step_ratio(drives, h);
                if growth_step_ratio < MIN_ACCEPTED_RATIO {
                    min_step_s *= growth_step_ratio;
                    min_retry_s = 0.999 * min_step_s.min(h);
                }
                ratio = ratio.min(growth_step_ratio);
            }
            // At most halve: an error estimate beside a jump is far too large.
            let retry_s = h * ratio.clamp(0.5, MIN_ACCEPTED_RATIO);
            if status == SolveStatus::BadCommand
                || ratio >= MIN_ACCEPTED_RATIO
                || retry_s < min_retry_s
            {
                if status == SolveStatus::Converged {
                    // Keep the length near its optimum, since new LU factors cost more than the
                    // gain.
                    let factor = if (1.0..MAX_KEPT_RATIO).contains(&ratio) {
                        1.0
                    } else {
                        ratio.clamp(0.3, MAX_GROWTH)
                    };
                    self.step_size.next_s = (h * factor).max(min_step_s);
                    self.finish_step(h);
                } else {
                    self.state.copy_from(&before);
                }
                break status;
            }
            self.state.copy_from(&before);
            h = retry_s;
            self.step_size.next_s = h;
        };
        self.before = before;
        (status, h)
    }

    /// Takes the last stage as the new state.
    fn finish_step(&mut self, h: f64) {
        self.step_size.steps += 1;
        self.state.rates.copy_from(&self.stages[self.stages.len() - 1]);
        self.commit_histories(h);
        self.log.iter_mut().for_each(|log| log.accept(h));
    }

    /// Allowed step length as a share of the last one, from its error.
    fn step_ratio(&self, start: &RodState, h: f64) -> f64 {
        let tolerance_m = self.system.params.resolution.motion_tolerance_m;
        if tolerance_m.is_infinite() {
            return f64::INFINITY;
        }
        // The estimate falls with the third power of the step.
        SAFETY * (tolerance_m / self.step_error_m(start, h).max(1e-12)).cbrt()
    }

    /// Estimate of the error that the step of `h` seconds just taken added to the position of the
    /// rod, metres.
    ///
    /// The smaller of two estimates, neither of which is ever much too small: the deviation from
    /// the trapezoidal rule, which is h³/12 times the third derivative for smooth motion; and the
    /// velocity difference between the first and the last stage, which is insensitive to a jump of
    /// drive speed at the start of the step. The weights make the tip error of the paper's robot
    /// under random commands about equal to the tolerance (`docs/method/rod.md`).
    fn step_error_m(&self, start: &RodState, h: f64) -> f64 {
        const TRAPEZOID_WEIGHT: f64 = 0.1;
        const SPREAD_WEIGHT: f64 = 0.02;
        let (first, last) = (&self.stages[0].node_v, &self.stages[self.stages.len() - 1].node_v);
        let (mut missed, mut spread) = (0.0_f64, 0.0_f64);
        for (g, p) in self.state.shape.node_p.iter().enumerate() {
            let moved = p - start.shape.node_p[g];
            // Trapezoidal rule: p₁ − p₀ − h (v₀ + v₁)/2.
            let defect = moved - (start.rates.node_v[g] + last[g]) * (0.5 * h);
            missed = missed.max(defect.norm_squared());
            spread = spread.max((last[g] - first[g]).norm_squared());
        }
        // A jump of drive speed spoils the trapezoid, not the spread; smooth motion the reverse.
        f64::min(TRAPEZOID_WEIGHT * missed.sqrt(), SPREAD_WEIGHT * h * spread.sqrt())
    }

    fn try_step(
        &mut self,
        drives: &dyn Fn(f64) -> Vec<Drive>,
        h: f64,
        start: &RodState,
    ) -> SolveStatus {
        let loads = self.full_loads();
        let allowed_m = self.system.params.resolution.motion_tolerance_m;
        let tolerance_m =
            if allowed_m.is_finite() { STAGE_SHARE * allowed_m } else { STAGE_TOLERANCE_M };
        self.settled_under = None;
        self.log.iter_mut().for_each(|log| log.stages.clear());
        for i in 0..self.tableau.rows.len() {
            let Some(constraints) = self.constraints(&drives(self.step_size.stage_times[i] * h))
            else {
                return SolveStatus::BadCommand;
            };
            // Each stage ends at its own time and hence under its own commands.
            self.seed_tensions(&constraints);
            self.motion.prepare(start, &self.system.masses, &self.tableau.rows[i], &self.stages, h);
            let status = self.solve(&constraints, &loads, false, tolerance_m);
            if status != SolveStatus::Converged {
                return status;
            }
            // Later stages need the rates of this one.
            self.stages[i].read(&self.motion, &self.system.masses, &self.state.shape);
            self.log_stage();
        }
        SolveStatus::Converged
    }
}
