//! Equilibria: found, refined, and judged for discretisation error and stability.

pub(crate) mod continuation;
pub(crate) mod dynamic_relaxation;
pub(crate) mod equilibrium;
pub(crate) mod error_estimate;
pub(crate) mod interpenetration;
pub(crate) mod judgement;
pub(crate) mod reconstruction;
pub(crate) mod refinement;
pub(crate) mod stable_branch;
pub(crate) mod static_solve;
