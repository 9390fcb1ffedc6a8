//! Periodic kernel of one period for all its inputs: MacKay 1998; Rasmussen & Williams 2006, eq.
//! 4.31.

use std::f64::consts::PI;

use super::component::{Component, Hyperparameter, PairRow};

/// `k(x, y) = exp(−2 Σ_d sin²(π (x_d − y_d)/p) / l²)`.
pub struct Periodic;

impl Periodic {
    /// Writes Σ_d sin²(π Δ_d / p) for every training point.
    fn squares(period: f64, row: &PairRow, out: &mut [f64]) {
        out.fill(0.0);
        for (values, centre) in row.each() {
            out.iter_mut()
                .zip(values)
                .for_each(|(out, x)| *out += (PI * (x - centre) / period).sin().powi(2));
        }
    }
}

impl Component for Periodic {
    fn name(&self) -> &'static str {
        "periodic"
    }

    fn hyperparameters(&self, _inputs: usize) -> Vec<Hyperparameter> {
        let length = Hyperparameter::length("length".to_owned());
        let period = Hyperparameter::plain("period", 2.0, (0.1, 100.0), (0.5, 8.0));
        vec![Hyperparameter { bounds: (0.05, 1e3), ..length }, period]
    }

    fn values(&self, parameters: &[f64], row: &PairRow, out: &mut [f64]) {
        Self::squares(parameters[1], row, out);
        out.iter_mut().for_each(|s| *s = (-2.0 * *s / parameters[0].powi(2)).exp());
    }

    fn rates(&self, parameters: &[f64], row: &PairRow, out: &mut [Vec<f64>]) {
        let (inverse, period) = (parameters[0].powi(-2), parameters[1]);
        let [of_length, of_period] = out else { return };
        Self::squares(period, row, of_length);
        of_period.fill(0.0);
        for (values, centre) in row.each() {
            for (rate, x) in of_period.iter_mut().zip(values) {
                let angle = PI * (x - centre) / period;
                // d/d ln p of −2 sin²(a)/l² with a = πΔ/p, by 2 sin a cos a = sin 2a.
                *rate += 2.0 * angle * (2.0 * angle).sin() * inverse;
            }
        }
        for (length, period) in of_length.iter_mut().zip(of_period) {
            let value = (-2.0 * *length * inverse).exp();
            *length *= 4.0 * inverse * value;
            *period *= value;
        }
    }
}
