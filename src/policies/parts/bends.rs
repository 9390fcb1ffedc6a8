//! Commands in the few numbers that bend a robot, for controllers without a model: towards x and
//! towards y in each segment, with tendons on opposite sides pulled and given by the same amount.

use nalgebra::DMatrix;

use super::actuator_limits::{LimitOptions, largest_change_m};
use crate::base::{Displacements, TendonLayout};

/// The displacements for a bend: two numbers for each segment from base to tip. A tendon passes the
/// segments before its own, and their bends take it along.
fn pulls_m(layout: &TendonLayout, bend_m: &[f64]) -> Displacements {
    let mut pulls_m = vec![0.0; layout.segments.iter().map(Vec::len).sum()];
    for (segment, tendons) in layout.segments.iter().enumerate() {
        for placed in tendons {
            let (sin, cos) = placed.angle_deg.to_radians().sin_cos();
            let passed = bend_m.chunks_exact(2).take(segment + 1);
            if let Some(pull_m) = pulls_m.get_mut(placed.tendon) {
                *pull_m = passed.map(|bend_m| cos * bend_m[0] + sin * bend_m[1]).sum();
            }
        }
    }
    pulls_m
}

/// Displacement of each tendon (row) for each component of a bend (column).
pub(crate) fn pulls_per_bend(layout: &TendonLayout) -> DMatrix<f64> {
    let bends = 2 * layout.segments.len();
    let columns: Vec<Displacements> = (0..bends)
        .map(|component| {
            let mut bend_m = vec![0.0; bends];
            bend_m[component] = 1.0;
            pulls_m(layout, &bend_m)
        })
        .collect();
    let tendons = layout.segments.iter().map(Vec::len).sum();
    DMatrix::from_fn(tendons, bends, |tendon, component| columns[component][tendon])
}

/// Where the tendons lie, and what the drive can do.
pub(crate) struct BendDirections {
    layout: TendonLayout,
    limits: LimitOptions,
}

impl BendDirections {
    pub(crate) fn new(layout: TendonLayout, limits: LimitOptions) -> BendDirections {
        BendDirections { layout, limits }
    }

    /// Number of components: x and y of each segment from base to tip.
    pub(crate) fn len(&self) -> usize {
        2 * self.layout.segments.len()
    }

    /// The displacements for a bend.
    pub(crate) fn pulls_m(&self, bend_m: &[f64]) -> Displacements {
        pulls_m(&self.layout, bend_m)
    }

    /// Moves a bend by `change_m`, or as far in that direction as the drive moves in a tick, and
    /// within its travel. What the drive does not do is not part of the bend, so that an integral
    /// cannot wind up.
    pub(crate) fn advance(&self, bend_m: &mut [f64], change_m: &[f64]) {
        let before_m = self.pulls_m(bend_m);
        let wanted_m: Vec<f64> =
            bend_m.iter().zip(change_m).map(|(bend, change)| bend + change).collect();
        let largest_m = largest_change_m(&before_m, &self.pulls_m(&wanted_m));
        let share = self.limits.max_step_m.map_or(1.0, |step_m| (step_m / largest_m).min(1.0));
        let travel_m = self.limits.travel_m;
        for (bend_m, change_m) in bend_m.iter_mut().zip(change_m) {
            *bend_m = (*bend_m + share * change_m).clamp(-travel_m, travel_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_tendons_move_against_each_other_within_a_step() {
        let bends = BendDirections::new(
            TendonLayout::ring(4),
            LimitOptions { travel_m: 0.005, max_step_m: Some(0.003) },
        );
        let mut bend_m = vec![0.0, 0.0];
        bends.advance(&mut bend_m, &[0.012, -0.006]);
        for (found, expected) in bends.pulls_m(&bend_m).iter().zip([0.003, -0.0015, -0.003, 0.0015])
        {
            assert!((found - expected).abs() < 1e-12, "{bend_m:?}");
        }
        bends.advance(&mut bend_m, &[0.012, -0.006]);
        bends.advance(&mut bend_m, &[0.012, -0.006]);
        assert!((bend_m[0] - 0.005).abs() < 1e-12, "travel binds: {bend_m:?}");
    }
}
