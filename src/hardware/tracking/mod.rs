//! Motion capture: the tip of the robot in its base frame, from an OptiTrack NatNet stream.
//!
//! [`Tracking`] speaks to Motive over UDP and never waits after [`Tracking::open`]. A datagram passes through [`Stream`]:
//! is it from our server, does it decode, is it newer than the last one, are both bodies seen. What is left becomes a
//! [`TipPose`] at a local time.

mod align;
mod bodies;
mod client;
pub(crate) mod clock_sync;
mod fault;
mod frames;
mod handshake;
pub(crate) mod peer_filter;
mod pose;
pub(crate) mod sequence_numbers;
mod settings;
pub(crate) mod sockets;
mod status;
mod stream;

pub use align::{Alignment, align, realign};
pub use client::Tracking;
pub use fault::TrackingFault;
pub use pose::{Mounting, Pose, TipPose};
pub use settings::{BodyName, StreamVersion, TrackingSettings, Transport, UpAxis};
pub use status::TrackingStatus;
pub use stream::{Heard, Stream};
