//! Errors on what the fit has not seen, beside those of simpler models.

pub(super) mod baselines;
pub(super) mod constant_curvature;
pub(super) mod residuals;
pub(super) mod validation;
