//! Commands that run, plan, verify and publish experiments.

pub(super) mod cache;
pub(super) mod cluster;
pub(super) mod compare;
pub(super) mod gather;
pub(super) mod pack;
pub(super) mod page;
pub(super) mod plan;
pub(super) mod plot;
pub(super) mod report;
pub(super) mod run;
pub(super) mod verify;
mod verify_claim;
