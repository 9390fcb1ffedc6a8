//! A linear response of second order to steps.

/// Ranges of the two numbers of a response.
const TIMES_S: (f64, f64) = (5e-4, 3.0);
const DAMPINGS: (f64, f64) = (0.05, 20.0);

/// A linear response of second order, 1/(1 + 2ζT s + T² s²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StepResponse {
    /// T, seconds.
    pub(super) time_s: f64,
    /// ζ.
    pub(super) damping: f64,
}

/// What becomes of a deviation from rest and of its rate after a time.
pub(super) struct Propagated {
    /// Deviation from deviation and from rate.
    pub(super) deviation: [f64; 2],
    /// Rate from deviation and from rate.
    pub(super) rate: [f64; 2],
}

impl StepResponse {
    /// −dH/ds at 0.
    pub(super) fn mean_delay_s(self) -> f64 {
        2.0 * self.damping * self.time_s
    }

    pub(super) fn scaled(self, time: f64, damping: f64) -> StepResponse {
        StepResponse {
            time_s: (self.time_s * time).clamp(TIMES_S.0, TIMES_S.1),
            damping: (self.damping * damping).clamp(DAMPINGS.0, DAMPINGS.1),
        }
    }

    /// The free motion after `time_s`: cosine- and sine-like parts, both with their decay.
    pub(super) fn after(self, time_s: f64) -> Propagated {
        let (rate, decay) = (1.0 / self.time_s, self.damping / self.time_s);
        // The poles are (−ζ ± √(ζ² − 1))/T: equal, complex or real.
        let discriminant = self.damping * self.damping - 1.0;
        let (cosine, sine) = if discriminant.abs() < 1e-9 {
            let envelope = (-decay * time_s).exp();
            (envelope, envelope * time_s)
        } else if discriminant < 0.0 {
            let frequency = rate * (-discriminant).sqrt();
            let (sine, cosine) = (frequency * time_s).sin_cos();
            let envelope = (-decay * time_s).exp();
            (envelope * cosine, envelope * sine / frequency)
        } else {
            let split_rate = rate * discriminant.sqrt();
            let [slow, fast] =
                [split_rate - decay, -split_rate - decay].map(|pole| (pole * time_s).exp());
            (0.5 * (slow + fast), 0.5 * (slow - fast) / split_rate)
        };
        Propagated {
            deviation: [cosine + decay * sine, sine],
            rate: [-rate * rate * sine, cosine - decay * sine],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against steps of an explicit integration.
    #[test]
    fn a_response_moves_as_its_equation_says() {
        for damping in [0.2, 1.0, 3.0] {
            let response = StepResponse { time_s: 0.1, damping };
            let (mut deviation, mut rate) = (1.0, 4.0);
            let step_s = 1e-5;
            for _ in 0..20_000 {
                let acceleration = -deviation / 0.01 - 2.0 * damping * rate / 0.1;
                rate += step_s * acceleration;
                deviation += step_s * rate;
            }
            let after = response.after(0.2);
            let of = |[a, b]: [f64; 2]| a + 4.0 * b;
            assert!((of(after.deviation) - deviation).abs() < 1e-3, "{damping}: {deviation}");
            assert!((of(after.rate) - rate).abs() < 1e-2, "{damping}: {rate}");
        }
    }
}
