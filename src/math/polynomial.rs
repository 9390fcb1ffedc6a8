//! Legendre polynomials.

/// Fills `out[k]` with the Legendre polynomial of degree k at `x` in [−1, 1] (Bonnet's recursion).
pub fn legendre(x: f64, out: &mut [f64]) {
    for k in 0..out.len() {
        out[k] = match k {
            0 => 1.0,
            1 => x,
            _ => {
                let m = k as f64;
                ((2.0 * m - 1.0) * x * out[k - 1] - (m - 1.0) * out[k - 2]) / m
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_closed_forms() {
        let (mut p, x) = ([0.0; 4], 0.3);
        legendre(x, &mut p);
        assert!((p[2] - 0.5 * (3.0 * x * x - 1.0)).abs() < 1e-15);
        assert!((p[3] - 0.5 * (5.0 * x * x * x - 3.0 * x)).abs() < 1e-15);
    }
}
