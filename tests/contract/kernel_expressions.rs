//! Kernel expressions: values of a peer, fits of what only a sum or a product describes, and
//! refusals.

use spinebench::base::Rows;
use spinebench::learn::LearnError;
use spinebench::learn::gp::{Gp, GpConfig, KernelExpression, kernels};

/// The rows of a CSV file below the project's folder, without its header.
fn read_cells(name: &str) -> Vec<Vec<String>> {
    let path = format!("{}/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn samples() -> (Rows, Rows) {
    let (mut x, mut y) = (Rows::new(3), Rows::new(1));
    for i in (0..6).map(f64::from) {
        let row = [(1.7 * i).sin(), (0.9 * i + 1.0).cos(), (i * i * 0.37).sin()];
        y.push(&[row[0] + (2.0 * row[1]).sin()]);
        x.push(&row);
    }
    (x, y)
}

/// The hyper-parameters of the reference, by name.
fn parameters(expression: &KernelExpression) -> Vec<f64> {
    let (mut products, lengths) = (0, [0.7, 1.3, 2.1]);
    let value = |name: &String| match name.split(' ').collect::<Vec<_>>()[..] {
        ["signal", ..] => {
            products += 1;
            if products == 1 { 1.0 } else { 1.5 }
        }
        ["length" | "scale", input, "of", ..] => lengths[input.parse::<usize>().unwrap() - 1],
        ["length", ..] => 0.7,
        ["period", ..] => 1.3,
        ["alpha", ..] => 2.0,
        _ => panic!("{name}"),
    };
    expression.hyperparameter_names(3).unwrap().iter().map(value).collect()
}

#[test]
fn values_are_those_of_a_peer() {
    let (x, _) = samples();
    let cells = read_cells("tests/reference/kernels/gram.csv");
    for [text, row, column, value] in cells.iter().map(|row| [0, 1, 2, 3].map(|k| row[k].as_str()))
    {
        let expression = KernelExpression::parse(text).unwrap();
        let gram = expression.gram(&x, &parameters(&expression)).unwrap();
        let (row, column, value): (usize, usize, f64) =
            (row.parse().unwrap(), column.parse().unwrap(), value.parse().unwrap());
        for found in [gram.row(row)[column], gram.row(column)[row]] {
            // arccos loses half of the digits where a point meets itself.
            let tolerance = if text == "arc_cosine" { 1e-7 } else { 1e-12 };
            assert!(
                (found - value).abs() < tolerance,
                "{text} at {row}, {column}: {found} {value}"
            );
        }
    }
    // A kernel that is added may have values of its own beside these.
    let known = |name: &&str| cells.iter().any(|row| row[0].split('[').next() == Some(name));
    assert!(
        kernels::names().filter(known).count() >= 13,
        "every shipped kernel has values of a peer"
    );
}

#[test]
fn likelihoods_are_those_of_a_peer() {
    let (x, y) = samples();
    for row in read_cells("tests/reference/kernels/likelihood.csv") {
        let expression = KernelExpression::parse(&row[0]).unwrap();
        let mut theta: Vec<f64> = parameters(&expression).iter().map(|p| p.ln()).collect();
        theta.push(0.1_f64.ln());
        let config = GpConfig { kernel: expression, ..GpConfig::default() };
        let gp = Gp::condition(&x, &y, &config, vec![theta], 0).unwrap();
        let (found, expected) = (gp.log_marginal_likelihood()[0], row[1].parse::<f64>().unwrap());
        assert!((found - expected).abs() < 1e-9, "{}: {found} {expected}", row[0]);
    }
}

/// A trend under a wave, seen on one side only.
fn trend(from: f64, count: usize) -> (Rows, Rows) {
    let (mut x, mut y) = (Rows::new(2), Rows::new(1));
    for i in 0..count {
        let t = from + 0.1 * i as f64;
        x.push(&[t, (7.3 * t).sin()]);
        y.push(&[0.8 * t + 0.5 * (2.0 * std::f64::consts::PI * t / 1.5).sin()]);
    }
    (x, y)
}

fn error_beyond(kernel: &str) -> f64 {
    let ((x, y), (far, truth)) = (trend(0.0, 60), trend(7.0, 20));
    let config =
        GpConfig { kernel: KernelExpression::parse(kernel).unwrap(), ..GpConfig::default() };
    let gp = Gp::fit(&x, &y, &config).unwrap();
    let predicted = gp.predict_rows(&far).unwrap();
    let one = gp.predict(far.row(3)).unwrap();
    assert!(
        (predicted.mean.row(3)[0] - one.0[0]).abs() < 1e-9
            && (predicted.variance.row(3)[0] - one.1[0]).abs() < 1e-9
    );
    let square = |(found, truth): (&[f64], &[f64])| (found[0] - truth[0]).powi(2);
    (predicted.mean.iter().zip(truth.iter()).map(square).sum::<f64>() / 20.0).sqrt()
}

#[test]
fn a_sum_carries_on_what_one_kernel_forgets() {
    let (alone, together) = (error_beyond("se_ard"), error_beyond("linear[1] + periodic[1]"));
    assert!(together < 0.02 && alone > 20.0 * together, "{alone} {together}");
}

#[test]
fn a_fit_is_written_and_read_back_to_the_bit() {
    let (x, y) = trend(0.0, 40);
    let kernel = KernelExpression::parse("se[2]*(linear+constant) + white").unwrap();
    let gp = Gp::fit(&x, &y, &GpConfig { kernel, starts: 2, ..GpConfig::default() }).unwrap();
    let text = serde_json::to_string(&gp).unwrap();
    assert!(text.contains("se_ard[2] * (linear + constant) + white"), "{text}");
    let back: Gp = serde_json::from_str(&text).unwrap();
    assert_eq!(gp.predict(x.row(5)).unwrap(), back.predict(x.row(5)).unwrap());
    assert_eq!(gp.hyperparameter_names().len(), gp.theta()[0].len());
    assert!(gp.cross_validation_mae()[0].is_finite());
}

#[test]
fn inputs_that_are_not_there_are_refused() {
    let (x, y) = trend(0.0, 10);
    for kernel in ["linear[3]", "se_ard + linear[place]"] {
        let config =
            GpConfig { kernel: KernelExpression::parse(kernel).unwrap(), ..GpConfig::default() };
        let refused = Gp::fit(&x, &y, &config).unwrap_err();
        assert!(matches!(refused, LearnError::Setting { key: "kernel", .. }), "{refused}");
    }
}
