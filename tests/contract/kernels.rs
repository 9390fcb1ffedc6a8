//! What every registered kernel must do: one contract, run over the whole registry.

use spinebench::learn::gp::kernels::{KERNELS, Kernel, find};

/// Twelve points in three dimensions, two of them equal.
fn points() -> Vec<[f64; 3]> {
    let mut points: Vec<[f64; 3]> = (0..11)
        .map(f64::from)
        .map(|i| [(1.7 * i).sin(), (0.9 * i + 1.0).cos(), (i * i * 0.37).sin()])
        .collect();
    points.push(points[3]);
    points
}

fn squared_distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let lengths = [0.7, 1.3, 2.1];
    (0..3).map(|d| ((a[d] - b[d]) / lengths[d]).powi(2)).sum()
}

fn shapes(kernel: &dyn Kernel) -> Vec<f64> {
    kernel.shapes().iter().map(|shape| shape.start).collect()
}

fn correlation(kernel: &dyn Kernel, shape: &[f64], s: f64) -> f64 {
    let mut row = [s];
    kernel.correlations(shape, &mut row);
    row[0]
}

#[test]
fn names_are_unique_and_found() {
    assert!(KERNELS.len() >= 5);
    for (place, kernel) in KERNELS.iter().enumerate() {
        let same = KERNELS.iter().position(|other| other.name() == kernel.name());
        assert_eq!(same, Some(place), "{} is registered twice", kernel.name());
        assert_eq!(find(kernel.name()).map(Kernel::name), Some(kernel.name()));
    }
    assert!(find("no_such_kernel").is_none());
}

#[test]
fn a_correlation_is_one_at_zero_and_falls() {
    for kernel in KERNELS {
        let shape = shapes(*kernel);
        assert!((correlation(*kernel, &shape, 0.0) - 1.0).abs() < 1e-15, "{}", kernel.name());
        let mut previous = 1.0;
        for i in 1..200 {
            let next = correlation(*kernel, &shape, f64::from(i) * 0.1);
            assert!(next < previous && next > 0.0, "{} at {i}", kernel.name());
            previous = next;
        }
    }
}

#[test]
fn gram_matrices_are_symmetric_and_positive_definite() {
    for kernel in KERNELS {
        let (shape, points) = (shapes(*kernel), points());
        let n = points.len();
        let at = |i: usize, j: usize| {
            correlation(*kernel, &shape, squared_distance(&points[i], &points[j]))
        };
        let mut l: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| at(i, j)).collect()).collect();
        let transposed: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| at(j, i)).collect()).collect();
        assert_eq!(l, transposed, "{} is not symmetric", kernel.name());
        // Cholesky by definition; the point that occurs twice leaves a zero, which the noise lifts.
        for j in 0..n {
            l[j][j] += 1e-9;
            for i in j..n {
                let dot: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                let value = l[i][j] - dot;
                assert!(
                    i != j || value > 0.0,
                    "{} is not positive definite (pivot {j}: {value})",
                    kernel.name()
                );
                l[i][j] = if i == j { value.sqrt() } else { value / l[j][j] };
            }
        }
    }
}

#[test]
fn slopes_are_finite_differences() {
    for kernel in KERNELS {
        let shape = shapes(*kernel);
        for i in 0..60 {
            let s = 0.02 + f64::from(i) * 0.21;
            let (mut at, mut slope) = ([s], [0.0]);
            kernel.slopes(&shape, &mut at, &mut slope);
            assert_eq!(at[0], correlation(*kernel, &shape, s), "{}", kernel.name());
            let e = 1e-5 * s;
            let expected = (correlation(*kernel, &shape, s + e)
                - correlation(*kernel, &shape, s - e))
                / (2.0 * e);
            assert!(
                (slope[0] - expected).abs() < 1e-8,
                "{} at {s}: {} {expected}",
                kernel.name(),
                slope[0]
            );
        }
        let (mut at, mut slope) = ([0.0], [f64::NAN]);
        kernel.slopes(&shape, &mut at, &mut slope);
        assert!(slope[0].is_finite(), "{}: the slope at zero is not finite", kernel.name());
    }
}

#[test]
fn shape_slopes_are_finite_differences() {
    let mut seen = 0;
    for kernel in KERNELS {
        for index in 0..kernel.shapes().len() {
            for s in [0.0, 0.3, 2.0, 9.0] {
                let mut row = [s];
                kernel.shape_slopes(&shapes(*kernel), index, &mut row);
                let moved = |by: f64| {
                    let mut shape = shapes(*kernel);
                    shape[index] *= by.exp();
                    correlation(*kernel, &shape, s)
                };
                let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                assert!((row[0] - expected).abs() < 1e-8, "{} shape {index} at {s}", kernel.name());
                seen += 1;
            }
        }
    }
    assert!(seen > 0, "no kernel has a shape");
}

#[test]
fn values_are_the_published_formulas() {
    let check = |name: &str, s: f64, expected: f64| {
        let kernel = find(name).unwrap();
        let found = correlation(kernel, &shapes(kernel), s);
        assert!((found - expected).abs() < 1e-14, "{name}: {found} {expected}");
    };
    check("se_ard", 2.0, (-1.0_f64).exp());
    check("se_iso", 0.5, (-0.25_f64).exp());
    check("matern32_ard", 3.0, 4.0 * (-3.0_f64).exp());
    check("matern52_ard", 5.0, (1.0 + 5.0 + 25.0 / 3.0) * (-5.0_f64).exp());
    check("rational_quadratic", 4.0, 0.25); // (1 + 4/4)^-2
}
