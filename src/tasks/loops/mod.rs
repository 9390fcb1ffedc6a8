//! Control loops: goal reaching, path tracking, trials of fixed duration.

pub(super) mod pace;
pub(super) mod reach;
pub(super) mod response;
pub(super) mod track;
pub(super) mod watched;
pub(super) mod work;
