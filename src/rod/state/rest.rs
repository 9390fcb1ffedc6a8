//! What the last static solve was asked for.

use crate::rod::equations::boundary_conditions::Hold;
use crate::rod::params::hysteresis_law::MemoryState;
use crate::rod::params::loads::TipLoad;

/// What a static solve was asked for.
#[derive(Clone, Debug)]
pub(crate) struct Rest {
    pub(crate) holds: Vec<Hold>,
    pub(crate) tip_load: TipLoad,
    /// Histories before they came to rest as well.
    pub(crate) memory: Vec<Vec<MemoryState>>,
}
