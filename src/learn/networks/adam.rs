//! Adam: Kingma & Ba 2015, algorithm 1.

use crate::learn::simd::Real;
use crate::math::vectorised;

/// First and second moments of the gradient and the number of steps taken.
pub(super) struct Adam<T> {
    first_moment: Vec<T>,
    second_moment: Vec<T>,
    steps: i32,
}

impl<T: Real> Adam<T> {
    pub(super) fn new(len: usize) -> Self {
        Adam {
            first_moment: vec![T::default(); len],
            second_moment: vec![T::default(); len],
            steps: 0,
        }
    }

    /// One step down the gradient.
    pub(super) fn step(&mut self, weights: &mut [T], gradient: &[T], rate: f64) {
        // The settings that the article proposes.
        const BETA_1: f64 = 0.9;
        const BETA_2: f64 = 0.999;
        self.steps += 1;
        // Bias correction: moments that begin at zero are too small at first.
        let corrected = rate / (1.0 - BETA_1.powi(self.steps));
        let (rate, unbias) = (T::of(corrected), T::of(1.0 / (1.0 - BETA_2.powi(self.steps))));
        let (b1, c1, b2, c2) =
            (T::of(BETA_1), T::of(1.0 - BETA_1), T::of(BETA_2), T::of(1.0 - BETA_2));
        let epsilon = T::of(1e-8);
        vectorised!({
            let moments = self.first_moment.iter_mut().zip(&mut self.second_moment);
            for ((w, &g), (m, v)) in weights.iter_mut().zip(gradient).zip(moments) {
                *m = b1.fma(*m, c1 * g);
                *v = b2.fma(*v, c2 * g * g);
                *w = *w - rate * (*m / ((*v * unbias).root() + epsilon));
            }
        });
    }
}
