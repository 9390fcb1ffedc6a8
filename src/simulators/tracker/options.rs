//! What the synthetic tracker is like, and what can go wrong with it.

use std::net::Ipv4Addr;

use natnet::Version;

use crate::base::Seed;
use crate::hardware::tracking::Transport;

/// Settings of the synthetic server.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackerOptions {
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// Standard deviation of the position noise of each body per axis, metres.
    pub noise_m: f64,
    /// Protocol: 3.0, 3.1, 4.0 or 4.1; unicast clients may ask for another one of these.
    pub version: Version,
    /// How frames are sent.
    pub transport: Transport,
    /// Group for multicast.
    pub multicast_group: Ipv4Addr,
    /// Port for commands; 0 lets the system choose.
    pub command_port: u16,
    /// Port that frames come from, and of the group; 0 lets the system choose.
    pub data_port: u16,
    /// Name and streaming id of the body at the base.
    pub base: (String, i32),
    /// Name and streaming id of the body at the tip.
    pub tip: (String, i32),
    /// Name and streaming id of bodies that only lie about.
    pub others: Vec<(String, i32)>,
    /// Probability that a frame is lost.
    pub loss: f64,
    /// Server's clock minus the time given to [`step`](super::FakeTracker::step), s.
    pub clock_offset_s: f64,
    /// Number of the first frame.
    pub first_frame: i32,
    /// Seed of noise, losses and malformed bytes.
    pub seed: Seed,
}

impl Default for TrackerOptions {
    fn default() -> Self {
        TrackerOptions {
            rate_hz: 100.0,
            noise_m: 0.0,
            version: Version::V4_1,
            transport: Transport::Unicast,
            multicast_group: Ipv4Addr::new(239, 255, 42, 99),
            command_port: 0,
            data_port: 0,
            base: ("base".into(), 1),
            tip: ("tip".into(), 2),
            others: vec![("table".into(), 7)],
            loss: 0.0,
            clock_offset_s: 1000.0,
            first_frame: 100_000,
            seed: Seed(0),
        }
    }
}

/// One of the two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackedBody {
    /// The one at the base.
    Base,
    /// The one at the tip.
    Tip,
}

/// What can go wrong with the stream, from [`inject`](super::FakeTracker::inject) until
/// [`clear_faults`](super::FakeTracker::calm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackerFault {
    /// Frames are lost with this probability.
    Loss(f64),
    /// Of each two frames the later one comes first.
    OutOfOrder,
    /// Each frame comes twice.
    Duplicate,
    /// A body is in the frames, but not seen.
    Occluded(TrackedBody),
    /// The server says nothing at all.
    Silent,
    /// Numbers and stamps go on, the poses stay as they are.
    Frozen,
    /// Numbers and poses go on, the stamps stay as they are.
    FrozenClock,
    /// The tip's position is not a number.
    NanPose,
    /// The tip is seen so far away from where it is, metres along Motive's x.
    Jump(f64),
    /// Each body is taken for the other.
    SwappedBodies,
    /// A second server on this computer sends other poses to the same clients.
    SecondServer,
    /// The server starts again, once: frame numbers from 1, clock from 0, no clients.
    Restart,
    /// Frames are cut off or have wrong bytes.
    Malformed,
    /// Frames come so much later than they were taken, s.
    Late(f64),
    /// Requests for the list of bodies are not answered.
    Undescribed,
    /// The tip's body is no longer in the frames, nor in the list of bodies.
    BodyGone,
}
