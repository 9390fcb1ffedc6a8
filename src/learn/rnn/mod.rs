//! Elman networks (paper IV-A): trained by back-propagation through time, used step by step in closed loop.

mod adam;
mod bptt;
mod config;
mod network;
mod tiles;
mod train;
mod weights;
mod windows;

pub use config::{ElmanConfig, Loss};
pub use network::{Elman, ElmanState};
pub use train::{Epoch, Stopped, Trained};
