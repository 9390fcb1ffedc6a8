//! Everything about the policies that the paper leaves open, in one place for the specs.

use serde::{Deserialize, Serialize};

use super::{AOptions, COptions, DirectOptions, LimitOptions, NetworkOptions};
use crate::base::BadOption;

/// Settings of all policies; each default and its alternatives are argued in `docs/decisions.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PolicyOptions {
    /// What the drive can do; the same for every policy.
    pub limits: LimitOptions,
    /// How the networks are asked; the same for every policy.
    pub network: NetworkOptions,
    /// Algorithm 2.
    pub a: AOptions,
    /// Policies that are an inverse network and nothing else: B and π_real.
    pub direct: DirectOptions,
    /// The hybrid.
    pub c: COptions,
}

impl PolicyOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        self.limits.check()?;
        self.network.check()?;
        self.a.check()?;
        self.direct.check()?;
        self.c.check()
    }
}
