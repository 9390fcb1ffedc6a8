//! Networks and Gaussian processes.

pub(crate) mod gaussian_process;
pub(crate) mod generated_network;
pub(crate) mod gp_coverage;
pub(crate) mod gp_leave_one_out;
pub(crate) mod imitating_network;
pub(crate) mod networks;
