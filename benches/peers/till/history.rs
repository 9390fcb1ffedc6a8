//! Time: BDF-α on strains, velocities and the slopes of the strains (Till et al. 2019, section 3).

use nalgebra::Vector3;

/// What is differentiated in time: v, u, q, ω and the derivatives of v and u along the rod.
pub(super) type Remembered = [Vector3<f64>; 6];

/// Coefficients of y' = c₀ y + (c₁ + c₀ d₁) y₁ + c₂ y₂ + d₁ h₁, where h₁ is the history of the step
/// before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bdf {
    pub(super) c0: f64,
    last: f64,
    before: f64,
    kept: f64,
}

impl Bdf {
    pub(super) fn new(dt_s: f64, alpha: f64) -> Bdf {
        let c0 = (1.5 + alpha) / (dt_s * (1.0 + alpha));
        let kept = alpha / (1.0 + alpha);
        Bdf {
            c0,
            last: -2.0 / dt_s + kept * c0,
            before: (0.5 + alpha) / (dt_s * (1.0 + alpha)),
            kept,
        }
    }

    /// Nothing moves.
    pub(super) fn rest() -> Bdf {
        Bdf { c0: 0.0, last: 0.0, before: 0.0, kept: 0.0 }
    }
}

/// The past of every place along the rod.
pub(super) struct Record {
    pub(super) now: Vec<Remembered>,
    before: Vec<Remembered>,
    /// The part of each time derivative that is known before the step.
    pub(super) past: Vec<Remembered>,
}

impl Record {
    pub(super) fn new(count: usize) -> Record {
        let zero = vec![[Vector3::zeros(); 6]; count];
        Record { now: zero.clone(), before: zero.clone(), past: zero }
    }

    pub(super) fn clear_history(&mut self) {
        self.past.iter_mut().for_each(|past| *past = [Vector3::zeros(); 6]);
    }

    /// From rest: all derivatives are zero.
    pub(super) fn start(&mut self, bdf: &Bdf) {
        self.before.clone_from(&self.now);
        for (past, now) in self.past.iter_mut().zip(&self.now) {
            *past = now.map(|value| -value * bdf.c0);
        }
    }

    pub(super) fn advance(&mut self, bdf: &Bdf) {
        for ((past, now), before) in self.past.iter_mut().zip(&self.now).zip(&self.before) {
            for c in 0..6 {
                past[c] = now[c] * bdf.last + before[c] * bdf.before + past[c] * bdf.kept;
            }
        }
        std::mem::swap(&mut self.before, &mut self.now);
    }
}

/// Values in the middle of a cell from those at its ends and their derivatives along the rod, by a
/// cubic.
pub(super) fn middle(
    from: &Remembered,
    to: &Remembered,
    from_slope: &[Vector3<f64>; 4],
    to_slope: &[Vector3<f64>; 4],
    h: f64,
) -> Remembered {
    let value = |c: usize| (from[c] + to[c]) * 0.5 + (from_slope[c] - to_slope[c]) * (h / 8.0);
    let slope = |c: usize| (to[c] - from[c]) * (1.5 / h) - (from_slope[c] + to_slope[c]) * 0.25;
    [value(0), value(1), value(2), value(3), slope(0), slope(1)]
}
