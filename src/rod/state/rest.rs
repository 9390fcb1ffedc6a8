//! Commands and loads of the last static solve.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::contact::ContactMemory;
use crate::rod::equations::tendon_friction::TendonSliding;
use crate::rod::params::hysteresis_law::HistoryState;
use crate::rod::params::loads::TipWrench;

/// Commands and loads of a static solve.
#[derive(Clone, Debug)]
pub(crate) struct SettledConditions {
    pub(crate) constraints: Vec<TendonConstraint>,
    pub(crate) tip_load: TipWrench,
    /// Histories before relaxation.
    pub(crate) histories: Vec<Vec<HistoryState>>,
    /// Sliding of the tendons before the drives moved.
    pub(crate) sliding: Vec<TendonSliding>,
    /// What the friction of contacts remembered before.
    pub(crate) contact_memory: ContactMemory,
    /// Duration of the rest, s.
    pub(crate) rested_s: f64,
}
