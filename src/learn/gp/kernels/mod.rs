//! Covariance functions. A kernel is its formula (one file) and its line in [`KERNELS`]. Gram matrices, gradients and
//! the contract tests apply to all kernels.
//!
//! Every kernel here is stationary: `k(x, y) = σ_s² c(s)` with the scaled squared distance
//! `s = Σ_d (x_d − y_d)² / l_d²` and `c(0) = 1`.

mod formula;
mod matern32_ard;
mod matern52_ard;
mod rational_quadratic;
mod se_ard;
mod se_iso;

pub use formula::{At, Formula, Kernel, Lengths, ShapeParameter};
pub use matern32_ard::Matern32Ard;
pub use matern52_ard::Matern52Ard;
pub use rational_quadratic::RationalQuadratic;
pub use se_ard::SeArd;
pub use se_iso::SeIso;

/// The registry.
pub const KERNELS: &[&dyn Kernel] = &[&SeArd, &SeIso, &Matern32Ard, &Matern52Ard, &RationalQuadratic];

/// The kernel registered under `name`; the suffix `_ard` may be omitted.
pub fn find(name: &str) -> Option<&'static dyn Kernel> {
    let named = |kernel: &&dyn Kernel| kernel.name() == name || kernel.name().strip_suffix("_ard") == Some(name);
    KERNELS.iter().copied().find(named)
}
