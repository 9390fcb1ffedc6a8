//! Networks (paper IV-A): trained by back-propagation through time, used step by step in closed loop. The paper's is
//! Elman's; `kinds/` has the others.

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
