//! Commands at a robot on the bench or a rehearsed one.

pub(super) mod align;
pub(super) mod arm;
pub(super) mod collect;
pub(super) mod doctor;
pub(super) mod rehearse;
pub(super) mod session;
pub(super) mod weigh;
