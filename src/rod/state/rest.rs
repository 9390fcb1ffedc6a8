//! What the last static solve was asked for.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::params::hysteresis_law::HistoryState;
use crate::rod::params::loads::TipWrench;

/// What a static solve was asked for.
#[derive(Clone, Debug)]
pub(crate) struct SettledConditions {
    pub(crate) holds: Vec<TendonConstraint>,
    pub(crate) tip_load: TipWrench,
    /// Histories before they came to rest as well.
    pub(crate) histories: Vec<Vec<HistoryState>>,
}
