//! Networks and Gaussian processes.

pub(in crate::runner) mod gaussian_process;
pub(in crate::runner) mod generated_network;
pub(in crate::runner) mod gp_coverage;
pub(in crate::runner) mod gp_leave_one_out;
pub(in crate::runner) mod imitating_network;
pub(in crate::runner) mod networks;
