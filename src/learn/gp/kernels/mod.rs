//! Covariance functions. A kernel is its formula (one file) and its line in a registry. Gram
//! matrices, gradients and the contract tests apply to all kernels.
//!
//! Those in `kernels!` are stationary: `k(x, y) = σ_s² c(s)` with the scaled squared distance `s =
//! Σ_d (x_d − y_d)² / l_d²` and `c(0) = 1`. Those in `factors!` are not, or see no distance;
//! expressions combine both.

mod component;
mod dot_product;
mod formula;

pub use component::{Component, Hyperparameter, PairRow};
pub use dot_product::{DotFormula, DotValue};
pub use formula::{At, Formula, Kernel, Lengths, ShapeParameter};

pub(super) use component::Stationary;

macro_rules! kernels {
    ($($module:ident::$kernel:ident),* $(,)?) => {
        $(mod $module; pub use $module::$kernel;)*

        /// The registry of stationary kernels.
        pub const KERNELS: &[&dyn Kernel] = &[$(&$kernel),*];

        /// The same as factors of an expression.
        pub(super) const STATIONARY: &[&dyn Component] = &[$(&Stationary(&$kernel)),*];
    };
}

macro_rules! factors {
    ($($module:ident::$factor:ident),* $(,)?) => {
        $(mod $module; pub use $module::$factor;)*

        /// The registry of the other kernels.
        pub const FACTORS: &[&dyn Component] = &[$(&$factor),*];
    };
}

kernels! {
    se_ard::SeArd,
    se_iso::SeIso,
    matern32_ard::Matern32Ard,
    matern52_ard::Matern52Ard,
    rational_quadratic::RationalQuadratic,
    matern12_ard::Matern12Ard,
}

factors! {
    linear::Linear,
    polynomial::Polynomial,
    cubic::Cubic,
    periodic::Periodic,
    arc_cosine::ArcCosine,
    constant::Constant,
    white::White,
}

/// The stationary kernel registered under `name`; the suffix `_ard` may be omitted.
pub fn find(name: &str) -> Option<&'static dyn Kernel> {
    let named = |kernel: &&dyn Kernel| {
        kernel.name() == name || kernel.name().strip_suffix("_ard") == Some(name)
    };
    KERNELS.iter().copied().find(named)
}

/// The names of all kernels.
pub fn names() -> impl Iterator<Item = &'static str> {
    KERNELS.iter().map(|kernel| kernel.name()).chain(FACTORS.iter().map(|factor| factor.name()))
}
