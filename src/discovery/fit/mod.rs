//! One set of candidate effects fitted to the samples: physics, nuisance parameters and noise
//! together.

pub(crate) mod ar1_noise;
pub(crate) mod baseline;
pub(crate) mod candidate;
pub(crate) mod gauss_newton;
pub(crate) mod jackknife;
pub(crate) mod nuisance;
pub(crate) mod nuisance_priors;
pub(crate) mod obstacle_hint;
pub(crate) mod profile_intervals;
pub(crate) mod sensitivities;
pub(crate) mod simulate;
pub(crate) mod step_out;
