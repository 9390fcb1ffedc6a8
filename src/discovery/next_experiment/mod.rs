//! What to record next if the data cannot tell the remaining candidates apart.

pub(crate) mod protocols;
pub(crate) mod t_optimality;
