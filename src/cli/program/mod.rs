//! What the commands share, and those about the program itself.

pub(super) mod completions;
pub(super) mod interrupted;
pub(super) mod manual;
pub(super) mod outputs;
pub(super) mod schema;
pub(super) mod shared;
