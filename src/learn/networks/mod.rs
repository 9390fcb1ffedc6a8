//! Networks (paper IV-A), used step by step in closed loop. `kinds/` has the formulas of one hidden
//! unit, Elman's, which is the paper's, and others; `batch.rs` back-propagates them through time,
//! `session.rs` trains, and `member.rs` takes a step.

mod adam;
mod batch;
mod config;
mod full_batch;
mod history;
mod kinds;
mod member;
mod mini_batches;
mod network;
mod samples;
mod session;
mod tiles;
mod train;
mod weights;
mod windows;

pub use config::{Loss, NetworkConfig, Optimiser};
pub use kinds::NetworkKind;
pub use network::{Network, NetworkState};
pub use train::{Epoch, Stopped, Trained};
