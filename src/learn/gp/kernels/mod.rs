//! Covariance functions. A kernel is its formula (one file) and its line in `kernels!`. Gram matrices, gradients and
//! the contract tests apply to all kernels.
//!
//! Every kernel here is stationary: `k(x, y) = σ_s² c(s)` with the scaled squared distance
//! `s = Σ_d (x_d − y_d)² / l_d²` and `c(0) = 1`.

mod formula;

pub use formula::{At, Formula, Kernel, Lengths, ShapeParameter};

macro_rules! kernels {
    ($($module:ident::$kernel:ident),* $(,)?) => {
        $(mod $module; pub use $module::$kernel;)*

        /// The registry.
        pub const KERNELS: &[&dyn Kernel] = &[$(&$kernel),*];
    };
}

kernels! {
    se_ard::SeArd,
    se_iso::SeIso,
    matern32_ard::Matern32Ard,
    matern52_ard::Matern52Ard,
    rational_quadratic::RationalQuadratic,
}

/// The kernel registered under `name`; the suffix `_ard` may be omitted.
pub fn find(name: &str) -> Option<&'static dyn Kernel> {
    let named = |kernel: &&dyn Kernel| kernel.name() == name || kernel.name().strip_suffix("_ard") == Some(name);
    KERNELS.iter().copied().find(named)
}
