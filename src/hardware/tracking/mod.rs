//! Motion capture: the tip of the robot in its base frame, from an OptiTrack NatNet stream.
//!
//! [`TrackerClient`] talks to Motive over UDP and never blocks after [`TrackerClient::open`].
//! [`FrameStream`] checks each datagram: sent by our server, decodable, newer than the last one,
//! both bodies tracked. The result is a [`TipPose`] at a local time.

mod align;
mod bodies;
mod client;
mod clock_sync;
mod fault;
mod handshake;
mod mounting;
mod peer_filter;
mod pose;
mod recent_losses;
mod sequence_numbers;
mod settings;
mod sockets;
mod status;
mod stream;
mod tip_buffer;

pub use align::{Alignment, align, realign};
pub use client::TrackerClient;
pub use fault::TrackingFault;
pub use mounting::Mounting;
pub use pose::{RigidPose, TipPose};
pub use settings::{BodyName, StreamVersion, TrackingSettings, Transport, UpAxis};
pub use status::TrackingStatus;
pub use stream::{FrameStream, Received};
