//! A bound on the loads below which no rod buckles; it settles most cases without a matrix.

use crate::rod::state::rod::Rod;

/// A bound below this share of the elastic stiffness proves stability; the margin covers shear and
/// stretch.
const SAFE_SHARE: f64 = 0.8;

impl Rod {
    /// Whether the loads of an equilibrium are too small for buckling.
    pub(crate) fn is_stable_by_bound(&self) -> bool {
        self.system.params.moment_laws.is_empty() && self.is_below_buckling()
    }

    /// Whether the loads of the last evaluation, inertia included, are too small for buckling
    /// whatever the history-dependent moments, which resist bending. A force N(s) contributes at
    /// most |N| |δθ|² + |∫N| |δθ| |δθ′| to the second variation of the energy, a moment M at most
    /// |M| |δθ| |δθ′|. With |δθ(s)|² ≤ s ∫|δθ′|² both are bounded by integrals that are compared
    /// with the least rotational stiffness.
    pub(crate) fn is_below_buckling(&self) -> bool {
        let params = &self.system.params;
        if params.point_loads.iter().any(|load| load.follows || load.moment_nm.norm_squared() > 0.0)
        {
            return false;
        }
        // Contact may soften what the bound assumes: its force turns with the surface.
        if !self.solver.workspace.touches.is_empty() {
            return false;
        }
        let (mut force_integral, mut squared_force_integral, mut distal_force_integral) =
            (0.0, 0.0, 0.0);
        for (node, force) in
            self.system.grid.nodes.iter().zip(&self.solver.workspace.loads.force).rev()
        {
            let (s, weight, n) = (node.position_m, node.weight_m, force.norm());
            // Up to a Gauss point: half of its own part, the other half afterwards.
            distal_force_integral += 0.5 * weight * n;
            force_integral += weight * n * s;
            squared_force_integral += weight * s * distal_force_integral * distal_force_integral;
            distal_force_integral += 0.5 * weight * n;
        }
        let length = params.length_m();
        let bound = force_integral
            + squared_force_integral.sqrt()
            + self.tip_load.moment_nm.norm() * length * std::f64::consts::FRAC_1_SQRT_2;
        bound * self.grid_level.max_turning_compliance < SAFE_SHARE
    }

    /// Whether a load turns with the rod, so that no energy decides about stability.
    pub(crate) fn has_follower_loads(&self) -> bool {
        self.system.params.point_loads.iter().any(|load| load.follows)
    }
}
