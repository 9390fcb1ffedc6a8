use super::*;
use crate::base::Rows;
use crate::learn::Standardiser;
use crate::learn::gp::expression::KernelExpression;
use crate::learn::gp::likelihood::Likelihood;
use crate::learn::gp::{Gp, GpConfig};
use crate::math::optimise::both_gradients;

const KINDS: [Approximation; 2] = [Approximation::Sgpr, Approximation::Fitc];
const MEANS: [MeanFunction; 3] = [MeanFunction::Zero, MeanFunction::Constant, MeanFunction::Linear];

/// Rows over three inputs and two outputs with some noise.
fn table(n: usize) -> (Rows, Rows) {
    let (mut inputs, mut outputs) = (Rows::new(3), Rows::new(2));
    for i in (0..n).map(|i| i as f64) {
        let x = [(1.7 * i).sin(), (0.9 * i).cos(), (0.31 * i * i).sin()];
        inputs.push(&x);
        let noise = 0.2 * (77.0 * i).sin();
        outputs.push(&[x[0] + (2.0 * x[1]).sin() + noise, x[2] * x[0] - 0.5 * noise]);
    }
    (inputs, outputs)
}

fn samples(n: usize) -> (TrainingPoints, Vec<f64>) {
    let (inputs, outputs) = table(n);
    let all: Vec<usize> = (0..n).collect();
    let y = outputs.iter().map(|row| row[0] + 0.3).collect();
    (TrainingPoints::standardised(&inputs, &Standardiser::fit(&inputs, &all)), y)
}

fn covariance(text: &str) -> (Covariance, Vec<f64>) {
    let covariance = Covariance::new(&KernelExpression::parse(text).unwrap(), 3).unwrap();
    let mut theta: Vec<f64> = (0..covariance.len()).map(|k| 0.3 * (k as f64).sin()).collect();
    theta[covariance.len() - 1] = -2.0;
    (covariance, theta)
}

const EXPRESSIONS: [&str; 7] = [
    "se_ard",
    "se_iso",
    "rational_quadratic",
    "matern12",
    "se_ard[1-2] + linear[3] + white",
    "matern32 * periodic[1] + polynomial[2, 3] * white",
    "arc_cosine + constant * matern52",
];

#[test]
fn gradients_are_finite_differences_for_every_kind_kernel_and_mean() {
    let (points, y) = samples(50);
    let inducing: Vec<usize> = (0..50).step_by(4).collect();
    for text in EXPRESSIONS {
        let (covariance, theta) = covariance(text);
        for kind in KINDS {
            for mean in MEANS {
                let mut likelihood =
                    SparseLikelihood::new(kind, mean, covariance.clone(), &points, &y, &inducing);
                assert!(likelihood.value(&theta).is_finite());
                for (k, [found, expected]) in
                    both_gradients(&mut likelihood, &theta).into_iter().enumerate()
                {
                    let apart = (found - expected).abs() / (1.0 + expected.abs());
                    assert!(apart < 1e-5, "{text} {kind:?} {mean:?} {k}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn with_every_sample_as_inducing_point_the_likelihood_is_the_exact_one() {
    let (points, y) = samples(40);
    let all: Vec<usize> = (0..40).collect();
    for text in EXPRESSIONS {
        let (covariance, theta) = covariance(text);
        for mean in MEANS {
            let exact = Likelihood::new(covariance.clone(), mean, &points, &y).value(&theta);
            for kind in KINDS {
                let mut sparse =
                    SparseLikelihood::new(kind, mean, covariance.clone(), &points, &y, &all);
                let found = sparse.value(&theta);
                assert!(
                    (found - exact).abs() < 1e-6 * exact.abs(),
                    "{text} {kind:?} {mean:?}: {found} {exact}"
                );
            }
        }
    }
}

#[test]
fn the_bound_is_below_the_likelihood_and_rises_with_inducing_points() {
    let (points, y) = samples(80);
    let (covariance, theta) = covariance("se_ard");
    let exact = -Likelihood::new(covariance.clone(), MeanFunction::Zero, &points, &y).value(&theta);
    let bound = |count: usize| {
        let chosen = greedy_conditional_variance(&covariance, &theta, &points, count);
        let (kind, mean) = (Approximation::Sgpr, MeanFunction::Zero);
        -SparseLikelihood::new(kind, mean, covariance.clone(), &points, &y, &chosen).value(&theta)
    };
    let bounds: Vec<f64> = [5, 10, 20, 40, 80].map(bound).to_vec();
    assert!(bounds.windows(2).all(|pair| pair[0] < pair[1] + 1e-6), "{bounds:?}");
    assert!(bounds[4] <= exact + 1e-6 && bounds[4] > exact - 1e-3, "{bounds:?} {exact}");
    assert!(bounds[0] < exact - 10.0, "{bounds:?} {exact}");
}

#[test]
fn inducing_points_end_at_the_rank_of_the_kernel_and_are_distinct() {
    let (points, _) = samples(60);
    let (linear, theta) = covariance("linear + constant");
    assert_eq!(greedy_conditional_variance(&linear, &theta, &points, 30).len(), 4);
    let twice = points.select(&(0..60).chain(0..60).collect::<Vec<usize>>());
    let (smooth, theta) = covariance("matern12");
    let mut chosen = greedy_conditional_variance(&smooth, &theta, &twice, 100);
    assert_eq!(chosen.len(), 60);
    chosen.iter_mut().for_each(|index| *index %= 60);
    chosen.sort_unstable();
    chosen.dedup();
    assert_eq!(chosen.len(), 60);
}

fn config(
    approximation: Approximation,
    mean: MeanFunction,
    kernel: &str,
    inducing_points: usize,
) -> GpConfig {
    let kernel = KernelExpression::parse(kernel).unwrap();
    GpConfig {
        kernel,
        approximation,
        mean,
        inducing_points,
        starts: 2,
        folds: 7,
        ..GpConfig::default()
    }
}

#[test]
fn predictions_with_every_sample_as_inducing_point_are_the_exact_ones() {
    let (inputs, outputs) = table(45);
    let queries = table(63).0.select(&(45..63).collect::<Vec<usize>>());
    for text in EXPRESSIONS {
        let theta = vec![covariance(text).1; 2];
        for mean in MEANS {
            let of = |kind: Approximation| {
                let config = config(kind, mean, text, 45);
                let gp = Gp::condition(&inputs, &outputs, &config, theta.clone(), 0).unwrap();
                let found = gp.predict_rows(&queries).unwrap();
                assert_eq!(gp.predict(queries.row(3)).unwrap().0, found.mean.row(3));
                assert!(gp.predict(queries.row(3)).unwrap().1[1] - found.variance.row(3)[1] < 1e-9);
                assert_eq!(gp.mean(queries.row(5)).unwrap(), found.mean.row(5));
                [found.mean.values(), found.variance.values(), &gp.cross_validation_mae()].concat()
            };
            let exact = of(Approximation::Exact);
            for kind in KINDS {
                let apart =
                    exact.iter().zip(of(kind)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-6, "{text} {kind:?} {mean:?}: {apart}");
            }
        }
    }
}

#[test]
fn held_out_samples_are_predicted_as_if_they_had_not_been_there() {
    let (points, y) = samples(48);
    let (covariance, theta) = covariance("se_ard + white");
    let inducing: Vec<usize> = (0..8).collect();
    let fold: Vec<usize> = (20..31).collect();
    let others: Vec<usize> = (0..48).filter(|i| !fold.contains(i)).collect();
    let (few, few_y) = (points.select(&others), others.iter().map(|&i| y[i]).collect::<Vec<f64>>());
    for kind in KINDS {
        for mean in MEANS {
            let mut all =
                SparseLikelihood::new(kind, mean, covariance.clone(), &points, &y, &inducing);
            let mut without =
                SparseLikelihood::new(kind, mean, covariance.clone(), &few, &few_y, &inducing);
            assert!(all.value(&theta).is_finite() && without.value(&theta).is_finite());
            let errors = all.held_out_errors(&fold);
            for (error, &i) in errors.iter().zip(&fold) {
                let features =
                    (0..all.width()).map(|j| all.features[j * 48 + i] * without.weights[j]);
                let expected = y[i] - features.sum::<f64>();
                assert!((error - expected).abs() < 1e-9, "{kind:?} {mean:?}: {error} {expected}");
            }
        }
    }
}

#[test]
fn a_fit_with_few_inducing_points_is_near_the_exact_one_and_comes_back_from_its_stored_form() {
    let (inputs, outputs) = table(300);
    let queries = table(340).0.select(&(300..340).collect::<Vec<usize>>());
    let exact =
        Gp::fit(&inputs, &outputs, &config(Approximation::Exact, MeanFunction::Zero, "se_ard", 2))
            .unwrap();
    let wanted = exact.predict_rows(&queries).unwrap();
    for kind in KINDS {
        let gp =
            Gp::fit(&inputs, &outputs, &config(kind, MeanFunction::Zero, "se_ard", 60)).unwrap();
        assert_eq!(gp.points(), 300);
        let found = gp.predict_rows(&queries).unwrap();
        let apart =
            wanted.mean.values().iter().zip(found.mean.values()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 0.05, "{kind:?}");
        let text = serde_json::to_string(&gp).unwrap();
        let back: Gp = serde_json::from_str(&text).unwrap();
        assert_eq!(back.predict_rows(&queries).unwrap(), found);
        assert_eq!(serde_json::to_string(&back).unwrap(), text);
        let (bound, of_exact) = (gp.log_marginal_likelihood(), exact.log_marginal_likelihood());
        if kind == Approximation::Sgpr {
            assert!(
                bound.iter().zip(&of_exact).all(|(a, b)| *a < b + 1e-3 && *a > b - 5.0),
                "{bound:?} {of_exact:?}"
            );
        }
    }
}
