//! A step of displacements that takes the tip towards a target within the drives' travel.
//!
//! A robot of several segments has more tendons than its tip has coordinates. Among the
//! displacements p that bring the tip to a target, those are sought that bend every segment evenly:
//! min |J d − e|² + λ²|d|² + μ²|U (p + d)|² for the step d, with |p + d| ≤ travel and |d| ≤ trust,
//! where e is the way to the target and U takes from displacements what no bend of the segments
//! makes of them. λ and μ are shares of the size of J, so that robots of any size step alike.

use nalgebra::{DMatrix, DVector};

use crate::base::TendonLayout;
use crate::policies::parts::bends::pulls_per_bend;

/// λ and μ as shares of the root mean square row of J.
const DAMPING_SHARE: f64 = 0.02;
const EVENNESS_SHARE: f64 = 0.05;
/// Sweeps of the minimisation over all displacements.
const MAX_SWEEPS: usize = 2000;
/// Change of a displacement in a sweep below which it has converged, as a share of the trust.
const SWEEP_TOLERANCE: f64 = 1e-5;

/// U: what remains of displacements without those that bend the segments of `layout` evenly.
pub(crate) fn unevenness(layout: &TendonLayout) -> DMatrix<f64> {
    let even = pulls_per_bend(layout);
    let tendons = even.nrows();
    let factors = even.svd(true, false);
    let size = factors.singular_values.max();
    let directions = factors.u.unwrap_or_else(|| DMatrix::zeros(tendons, 0));
    // Two tendons in a plane bend a segment one way only: the other component has no direction.
    let independent = factors.singular_values.iter().enumerate();
    let independent = independent.filter(|(_, value)| **value > 1e-9 * size);
    independent.fold(DMatrix::identity(tendons, tendons), |rest, (index, _)| {
        rest - directions.column(index) * directions.column(index).transpose()
    })
}

/// A quadratic model of the search at the displacements where it stands.
pub(crate) struct BoundedStep<'a> {
    hessian: DMatrix<f64>,
    descent: DVector<f64>,
    unevenness: &'a DMatrix<f64>,
    evenness: f64,
    pulls_m: &'a [f64],
    travel_m: f64,
}

impl BoundedStep<'_> {
    /// The model at `pulls_m` with the derivative J (3 rows) there, for the way `error_m` to the
    /// target.
    pub(crate) fn new<'a>(
        jacobian: &DMatrix<f64>,
        error_m: &[f64; 3],
        unevenness: &'a DMatrix<f64>,
        pulls_m: &'a [f64],
        travel_m: f64,
    ) -> BoundedStep<'a> {
        let size_squared = jacobian.norm_squared() / 3.0;
        let (damping, evenness) =
            (DAMPING_SHARE.powi(2) * size_squared, EVENNESS_SHARE.powi(2) * size_squared);
        let count = pulls_m.len();
        let hessian = jacobian.transpose() * jacobian
            + damping * DMatrix::identity(count, count)
            + evenness * unevenness;
        let descent = jacobian.transpose() * DVector::from_row_slice(error_m)
            - evenness * (unevenness * DVector::from_row_slice(pulls_m));
        BoundedStep { hessian, descent, unevenness, evenness, pulls_m, travel_m }
    }

    /// What the search minimises, at displacements from which the tip is `error_m` away.
    pub(crate) fn cost(&self, pulls_m: &[f64], error_m: &[f64; 3]) -> f64 {
        let uneven_m = self.unevenness * DVector::from_row_slice(pulls_m);
        DVector::from_row_slice(error_m).norm_squared() + self.evenness * uneven_m.norm_squared()
    }

    /// The displacements after a step of at most `trust_m` for each tendon: coordinate descent on
    /// the strictly convex problem with bounds.
    pub(crate) fn next_m(&self, trust_m: f64) -> Vec<f64> {
        let mut step_m: DVector<f64> = DVector::zeros(self.pulls_m.len());
        let mut slope = self.descent.clone();
        for _ in 0..MAX_SWEEPS {
            let mut largest_m = 0.0_f64;
            for (tendon, pull_m) in self.pulls_m.iter().enumerate() {
                let least_m = (-self.travel_m - pull_m).max(-trust_m).min(0.0);
                let most_m = (self.travel_m - pull_m).min(trust_m).max(0.0);
                let free_m = step_m[tendon] + slope[tendon] / self.hessian[(tendon, tendon)];
                let change_m: f64 = free_m.clamp(least_m, most_m) - step_m[tendon];
                slope.axpy(-change_m, &self.hessian.column(tendon), 1.0);
                step_m[tendon] += change_m;
                largest_m = largest_m.max(change_m.abs());
            }
            if largest_m <= SWEEP_TOLERANCE * trust_m {
                break;
            }
        }
        self.pulls_m.iter().zip(step_m.iter()).map(|(pull_m, step_m)| pull_m + step_m).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::PlacedTendon;

    fn two_segments() -> TendonLayout {
        let ring = |first: usize| {
            let place =
                |tendon| PlacedTendon { tendon: first + tendon, angle_deg: 120.0 * tendon as f64 };
            (0..3).map(place).collect()
        };
        TendonLayout { segments: vec![ring(0), ring(3)] }
    }

    #[test]
    fn a_bend_of_the_segments_is_even_and_pulling_all_tendons_is_not() {
        let unevenness = unevenness(&two_segments());
        let bend =
            pulls_per_bend(&two_segments()) * DVector::from_row_slice(&[1.0, -2.0, 0.5, 3.0]);
        assert!((&unevenness * bend).norm() < 1e-12);
        let together = DVector::from_element(6, 1.0);
        assert!((&unevenness * &together - &together).norm() < 1e-12);
    }

    #[test]
    fn a_step_stays_within_travel_and_trust_and_is_even_where_it_can_be() {
        let unevenness = unevenness(&two_segments());
        // The tip moves with the bend of both segments.
        let even = pulls_per_bend(&two_segments());
        let gains = DMatrix::from_row_slice(
            3,
            4,
            &[
                9.0, 0.0, 4.0, 0.0, //
                0.0, 9.0, 0.0, 4.0, //
                0.0, 0.0, 0.0, 0.0,
            ],
        );
        let jacobian = gains * even.transpose();
        let home_m = [0.0; 6];
        let near = BoundedStep::new(&jacobian, &[0.01, 0.0, 0.0], &unevenness, &home_m, 0.006);
        let next_m = near.next_m(0.006);
        let reached = &jacobian * DVector::from_row_slice(&next_m);
        assert!((reached[0] - 0.01).abs() < 1e-4 && reached[1].abs() < 1e-6, "{reached}");
        // Even but for what the sweeps leave when they stop.
        let uneven_m = (&unevenness * DVector::from_row_slice(&next_m)).norm();
        assert!(uneven_m < 0.02 * DVector::from_row_slice(&next_m).norm(), "{next_m:?}");
        let far = BoundedStep::new(&jacobian, &[1.0, 0.3, 0.0], &unevenness, &home_m, 0.006);
        assert!(far.next_m(0.002).iter().all(|pull_m| pull_m.abs() <= 0.002));
        assert!(far.next_m(0.1).iter().all(|pull_m| pull_m.abs() <= 0.006));
    }
}
