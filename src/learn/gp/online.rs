//! A fitted process that takes further samples one by one.
//!
//! What a process knows is the prior for what is measured later: a Gaussian process with its
//! posterior mean and covariance, conditioned on the added samples, is the process of all samples
//! with the same hyper-parameters. A sample adds a row to the Cholesky factor of the added ones and
//! costs `O((N + n)²)` for N fitted and n added samples; one that leaves costs `O(n²)`. That holds
//! for inducing points and mean functions as for an exact process.

use serde::{Deserialize, Serialize};

use super::Gp;
use super::covariance::TrainingPoints;
use super::posterior::{FittedPrior, PosteriorFeatures};
use super::sparse::CovarianceAt;
use crate::base::Rows;
use crate::learn::LearnError;
use crate::learn::simd::dot;

/// Rule for the removed sample when there are too many.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Leaving {
    /// The oldest.
    #[default]
    Oldest,
    /// The one that is most strongly correlated with the new one, over all outputs, because the new
    /// one contains the same information.
    MostAlike,
}

/// A fitted process and the samples that were added to it. Standardisation, hyper-parameters and
/// fitted samples stay.
#[derive(Clone)]
pub struct OnlineGp {
    gp: Gp,
    capacity: usize,
    leaving: Leaving,
    /// Added samples, standardised, oldest first.
    inputs: Vec<Vec<f64>>,
    outputs: Vec<AddedSamples>,
}

/// What the added samples are to one output, in the order of the inputs.
#[derive(Clone)]
struct AddedSamples {
    prior: FittedPrior,
    features: Vec<PosteriorFeatures>,
    /// Rows of the Cholesky factor of their covariance, each as long as its number.
    factor: Vec<Vec<f64>>,
    /// Measured less predicted value of each.
    residuals: Vec<f64>,
    alpha: Vec<f64>,
}

impl AddedSamples {
    /// Covariances of the standardised query `x` with the added samples.
    fn covariances(&self, features: &PosteriorFeatures, x: &[f64]) -> Vec<f64> {
        let mut k = vec![0.0; self.residuals.len()];
        if k.is_empty() {
            return k;
        }
        self.prior.covariances(x, &mut k);
        let scale = self.prior.scale();
        for (k, added) in k.iter_mut().zip(&self.features) {
            // Posterior covariance of the fitted process: it is the prior of the added samples.
            *k = scale * *k - dot(&added.projection, &features.projection)
                + dot(&added.image, &features.image);
        }
        k
    }

    /// `L⁻¹ b`.
    fn solve_half(&self, b: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = Vec::with_capacity(b.len());
        for (row, b) in self.factor.iter().zip(b) {
            let i = out.len();
            out.push((b - dot(&row[..i], &out)) / row[i]);
        }
        out
    }

    /// Weights of the added samples, `(L Lᵀ)⁻¹` applied to the residuals.
    fn update_weights(&mut self) {
        let mut alpha = self.solve_half(&self.residuals);
        for i in (0..alpha.len()).rev() {
            alpha[i] /= self.factor[i][i];
            let (weight, row) = (alpha[i], &self.factor[i]);
            alpha[..i].iter_mut().zip(row).for_each(|(alpha, l)| *alpha -= weight * l);
        }
        self.alpha = alpha;
    }

    /// Takes sample `index` out: the rows below it become the factor of what they were without its
    /// column.
    fn remove(&mut self, index: usize) {
        self.factor.remove(index);
        self.features.remove(index);
        self.residuals.remove(index);
        // A rank-one update of the trailing rows by the removed column (Golub & Van Loan, section
        // 6.5.4).
        let mut column: Vec<f64> =
            self.factor[index..].iter_mut().map(|row| row.remove(index)).collect();
        for k in 0..column.len() {
            let at = index + k;
            let (diagonal, value) = (self.factor[at][at], column[k]);
            let length = diagonal.hypot(value);
            let (cosine, sine) = (diagonal / length, value / length);
            self.factor[at][at] = length;
            for (row, value) in self.factor[at + 1..].iter_mut().zip(&mut column[k + 1..]) {
                let entry = row[at];
                row[at] = cosine * entry + sine * *value;
                *value = cosine * *value - sine * entry;
            }
        }
    }
}

impl OnlineGp {
    /// A process that knows what `gp` knows and holds at most `capacity` further samples.
    ///
    /// # Errors
    /// [`LearnError::Setting`] for no samples.
    pub fn new(gp: &Gp, capacity: usize, leaving: Leaving) -> Result<OnlineGp, LearnError> {
        LearnError::unless_setting(capacity > 0, "points", capacity, "at least 1 point")?;
        let nothing = TrainingPoints::of(&Rows::new(gp.inputs()));
        let empty = |theta: &Vec<f64>| AddedSamples {
            prior: FittedPrior::new(&gp.covariance, theta, &nothing),
            features: Vec::new(),
            factor: Vec::new(),
            residuals: Vec::new(),
            alpha: Vec::new(),
        };
        let outputs = gp.theta.iter().map(empty).collect();
        Ok(OnlineGp { gp: gp.clone(), capacity, leaving, inputs: Vec::new(), outputs })
    }

    /// Forgets what was added.
    pub fn restart(&mut self) {
        while !self.inputs.is_empty() {
            // From the end: the last row leaves without an update of the others.
            self.remove(self.inputs.len() - 1);
        }
    }

    /// The process as it was fitted.
    pub fn fitted(&self) -> &Gp {
        &self.gp
    }

    /// Number of added samples.
    pub fn added(&self) -> usize {
        self.inputs.len()
    }

    /// Adds a sample in the units of inputs and outputs; where there are as many as may be, another
    /// leaves.
    ///
    /// # Errors
    /// [`LearnError`] for another width or numbers that are not finite; nothing is added then.
    pub fn add(&mut self, input: &[f64], output: &[f64]) -> Result<(), LearnError> {
        self.gp.check_width(input.len())?;
        LearnError::unless_shape("columns of a sample's outputs", output.len(), self.gp.outputs())?;
        LearnError::unless_finite("inputs", self.added(), input)?;
        LearnError::unless_finite("outputs", self.added(), output)?;
        let x = self.gp.standardised(input);
        if self.added() == self.capacity {
            let leaving_index = match self.leaving {
                Leaving::Oldest => 0,
                Leaving::MostAlike => self.most_correlated(&x),
            };
            self.remove(leaving_index);
        }
        self.inputs.push(x.clone());
        let points = self.points();
        for (c, samples) in self.outputs.iter_mut().enumerate() {
            let posterior = &self.gp.posteriors[c];
            let features = posterior.features(&x);
            let covariances = samples.covariances(&features, &x);
            // The new row of the Cholesky factor: L⁻¹ times the covariances, and the root of what
            // they leave of the variance.
            let mut row = samples.solve_half(&covariances);
            let PosteriorFeatures { projection, image } = &features;
            let variance =
                posterior.prior.variance(&x) - dot(projection, projection) + dot(image, image);
            // Rounding may leave less than nothing of a variance that is known.
            let variance = variance.max(0.0) + noise(&self.gp, c, &points);
            // A sample that coincides with another leaves no remainder; the factor must stay
            // positive.
            row.push((variance - dot(&row, &row)).max(f64::MIN_POSITIVE).sqrt());
            // Residuals refer to the fitted process, so that old samples need no new prediction.
            let predicted = posterior.mean(&x, &mut vec![0.0; posterior.points()]);
            samples.residuals.push(self.gp.output_standardiser.apply(c, output[c]) - predicted);
            samples.factor.push(row);
            samples.features.push(features);
            samples.prior = FittedPrior::new(&self.gp.covariance, &self.gp.theta[c], &points);
            samples.update_weights();
        }
        Ok(())
    }

    /// Posterior mean of every output at one point, in the outputs' units.
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a query of another width.
    pub fn mean(&self, input: &[f64]) -> Result<Vec<f64>, LearnError> {
        if self.inputs.is_empty() {
            return self.gp.mean(input);
        }
        Ok(self.predict(input)?.0)
    }

    /// Posterior mean and variance (of the noise-free function) of every output at one point.
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a query of another width.
    pub fn predict(&self, input: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LearnError> {
        let (mut means, mut variances) = self.gp.predict(input)?;
        let x = self.gp.standardised(input);
        for (c, samples) in self.outputs.iter().enumerate() {
            let k = samples.covariances(&self.gp.posteriors[c].features(&x), &x);
            let half = samples.solve_half(&k);
            let scale = self.gp.output_standardiser.scale(c);
            means[c] += scale * dot(&k, &samples.alpha);
            variances[c] = (variances[c] - scale * scale * dot(&half, &half)).max(0.0);
        }
        Ok((means, variances))
    }

    fn points(&self) -> TrainingPoints {
        let mut rows = Rows::new(self.gp.inputs());
        self.inputs.iter().for_each(|row| rows.push(row));
        TrainingPoints::of(&rows)
    }

    fn remove(&mut self, index: usize) {
        self.inputs.remove(index);
        let points = self.points();
        for (samples, theta) in self.outputs.iter_mut().zip(&self.gp.theta) {
            samples.remove(index);
            samples.prior = FittedPrior::new(&self.gp.covariance, theta, &points);
            samples.update_weights();
        }
    }

    /// The added sample that is most strongly correlated with the new one.
    fn most_correlated(&self, x: &[f64]) -> usize {
        let mut correlations = vec![0.0; self.added()];
        for (posterior, samples) in self.gp.posteriors.iter().zip(&self.outputs) {
            let k = samples.covariances(&posterior.features(x), x);
            for ((correlation, k), features) in
                correlations.iter_mut().zip(k).zip(&samples.features)
            {
                let PosteriorFeatures { projection, image } = features;
                let variance =
                    posterior.prior.variance(x) - dot(projection, projection) + dot(image, image);
                // Squares: a sample that is strongly anticorrelated tells as much.
                *correlation += k * k / variance.max(1e-12);
            }
        }
        (1..correlations.len())
            .fold(0, |best, i| if correlations[i] > correlations[best] { i } else { best })
    }
}

/// Noise variance of output `c` at the last of `points`, with what the kernel has of it.
fn noise(gp: &Gp, c: usize, points: &TrainingPoints) -> f64 {
    let theta = &gp.theta[c];
    let (mut variance, mut white_noise) = ([0.0], [0.0]);
    let last = points.select(&[points.n - 1]);
    CovarianceAt::new(&gp.covariance, theta).diagonal(&last, &mut variance, &mut white_noise);
    gp.covariance.noise_variance(theta) + white_noise[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::gp::posterior::Posterior;
    use crate::learn::gp::{Approximation, GpConfig, KernelExpression, MeanFunction};

    fn table(n: usize) -> (Rows, Rows) {
        let (mut inputs, mut outputs) = (Rows::new(3), Rows::new(2));
        for i in (0..n).map(|i| i as f64) {
            let x = [(1.7 * i).sin(), (0.9 * i).cos(), (0.31 * i * i).sin()];
            inputs.push(&x.map(|x| 0.03 * x + 0.1));
            outputs.push(&[
                0.01 * (x[0] + (2.0 * x[1]).sin() + 0.1 * (77.0 * i).sin()),
                0.02 * x[2] * x[0] + 0.001 * (55.0 * i).sin() + 3.0,
            ]);
        }
        (inputs, outputs)
    }

    fn fitted(rows: &[usize], kernel: &str, mean: MeanFunction, kind: Approximation) -> Gp {
        let (inputs, outputs) = table(90);
        let kernel = KernelExpression::parse(kernel).unwrap();
        let config = GpConfig {
            kernel,
            mean,
            approximation: kind,
            inducing_points: 90,
            starts: 1,
            ..GpConfig::default()
        };
        Gp::fit(&inputs.select(rows), &outputs.select(rows), &config).unwrap()
    }

    /// The process on `rows` with the hyper-parameters and standardisation of `gp`.
    fn refitted(gp: &Gp, rows: &[usize]) -> Gp {
        let (inputs, outputs) = table(90);
        let mut all = gp.clone();
        (all.inputs, all.outputs) = (inputs.select(rows), outputs.select(rows));
        let points = TrainingPoints::standardised(&all.inputs, &gp.input_standardiser);
        for (c, theta) in gp.theta.iter().enumerate() {
            let y: Vec<f64> =
                all.outputs.iter().map(|row| gp.output_standardiser.apply(c, row[c])).collect();
            all.posteriors[c] =
                Posterior::exact(&gp.covariance, gp.config.mean, &points, &y, theta).unwrap();
        }
        all
    }

    fn assert_same(online: &OnlineGp, gp: &Gp, tolerance: f64, what: &str) {
        for row in table(90).0.iter().skip(80) {
            let ((mean, variance), (wanted, wanted_variance)) =
                (online.predict(row).unwrap(), gp.predict(row).unwrap());
            assert_eq!(online.mean(row).unwrap(), mean);
            for c in 0..2 {
                let scale = gp.output_standardiser.scale(c);
                assert!(
                    (mean[c] - wanted[c]).abs() < tolerance * scale,
                    "{what}: {} {}",
                    mean[c],
                    wanted[c]
                );
                let apart = (variance[c] - wanted_variance[c]).abs();
                assert!(
                    apart < tolerance * scale * scale,
                    "{what}: {} {}",
                    variance[c],
                    wanted_variance[c]
                );
            }
        }
    }

    #[test]
    fn added_samples_give_what_a_process_of_all_of_them_gives() {
        let (inputs, outputs) = table(90);
        let first: Vec<usize> = (0..40).collect();
        for kernel in ["se_ard", "matern32 + linear[1] + white"] {
            for mean in [MeanFunction::Zero, MeanFunction::Linear] {
                for kind in [Approximation::Exact, Approximation::Sgpr] {
                    let gp = fitted(&first, kernel, mean, kind);
                    let what = format!("{kernel} {mean:?} {kind:?}");
                    let mut online = OnlineGp::new(&gp, 30, Leaving::Oldest).unwrap();
                    assert_same(&online, &gp, 1e-12, &what);
                    (40..60).for_each(|i| online.add(inputs.row(i), outputs.row(i)).unwrap());
                    assert_eq!(online.added(), 20);
                    // With every sample as an inducing point the sparse process is the exact one,
                    // to its jitter.
                    let tolerance = if kind == Approximation::Exact { 1e-9 } else { 1e-5 };
                    assert_same(
                        &online,
                        &refitted(&gp, &(0..60).collect::<Vec<usize>>()),
                        tolerance,
                        &what,
                    );
                    online.restart();
                    assert_same(&online, &gp, 1e-12, &what);
                }
            }
        }
    }

    #[test]
    fn the_oldest_leave_and_the_rest_is_as_if_they_had_never_come() {
        let (inputs, outputs) = table(90);
        let first: Vec<usize> = (0..30).collect();
        let gp = fitted(&first, "se_ard", MeanFunction::Zero, Approximation::Exact);
        let mut online = OnlineGp::new(&gp, 12, Leaving::Oldest).unwrap();
        (30..75).for_each(|i| online.add(inputs.row(i), outputs.row(i)).unwrap());
        assert_eq!(online.added(), 12);
        let rows: Vec<usize> = first.iter().copied().chain(63..75).collect();
        assert_same(&online, &refitted(&gp, &rows), 1e-8, "oldest");
    }

    #[test]
    fn of_samples_that_are_alike_the_earlier_one_leaves() {
        let (inputs, outputs) = table(90);
        let first: Vec<usize> = (0..30).collect();
        let gp = fitted(&first, "se_ard", MeanFunction::Zero, Approximation::Exact);
        let mut online = OnlineGp::new(&gp, 5, Leaving::MostAlike).unwrap();
        (30..35).for_each(|i| online.add(inputs.row(i), outputs.row(i)).unwrap());
        online.add(inputs.row(32), outputs.row(32)).unwrap();
        let rows: Vec<usize> = first.iter().copied().chain([30, 31, 33, 34, 32]).collect();
        assert_same(&online, &refitted(&gp, &rows), 1e-8, "alike");
    }

    #[test]
    fn samples_that_are_none_are_refused_and_change_nothing() {
        let (inputs, outputs) = table(90);
        let gp = fitted(
            &(0..30).collect::<Vec<usize>>(),
            "se_ard",
            MeanFunction::Zero,
            Approximation::Exact,
        );
        assert!(OnlineGp::new(&gp, 0, Leaving::Oldest).is_err());
        let mut online = OnlineGp::new(&gp, 5, Leaving::Oldest).unwrap();
        assert!(online.add(&inputs.row(31)[..2], outputs.row(31)).is_err());
        assert!(online.add(inputs.row(31), &outputs.row(31)[..1]).is_err());
        assert!(online.add(inputs.row(31), &[f64::NAN, 0.0]).is_err());
        assert_eq!(online.added(), 0);
        assert_same(&online, &gp, 1e-12, "unchanged");
    }
}
