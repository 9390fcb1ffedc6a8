//! Options of the simulated tracker, and its faults.

use std::net::Ipv4Addr;

use natnet::Version;

use crate::base::Seed;
use crate::hardware::tracking::Transport;

/// Options of the simulated server.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackerOptions {
    /// Frame rate, Hz.
    pub rate_hz: f64,
    /// Standard deviation of the position noise of each body per axis, metres.
    pub noise_m: f64,
    /// Version: 3.0, 3.1, 4.0 or 4.1; unicast clients may request another one of these.
    pub version: Version,
    /// Transport of the frames.
    pub transport: Transport,
    /// Multicast group.
    pub multicast_group: Ipv4Addr,
    /// Port for commands; 0 lets the system choose.
    pub command_port: u16,
    /// Source port of the frames, and port of the group; 0 lets the system choose.
    pub data_port: u16,
    /// Name and streaming id of the body at the base.
    pub base: (String, i32),
    /// Name and streaming id of the body at the tip.
    pub tip: (String, i32),
    /// Names and streaming ids of bodies that are not part of the robot.
    pub others: Vec<(String, i32)>,
    /// Probability that a frame is lost.
    pub loss: f64,
    /// Server's clock minus the time given to [`step`](super::SimulatedTracker::step), s.
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

/// One of the robot's two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackedBody {
    /// The body at the base.
    Base,
    /// The body at the tip.
    Tip,
}

/// A fault of the stream, from [`inject`](super::SimulatedTracker::inject) until
/// [`clear_faults`](super::SimulatedTracker::clear_faults).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackerFault {
    /// Frames are lost with this probability.
    Loss(f64),
    /// Every two frames are sent in reverse order.
    OutOfOrder,
    /// Each frame is sent twice.
    Duplicate,
    /// A body is listed in the frames, but not tracked.
    Occluded(TrackedBody),
    /// The server sends nothing at all.
    Silent,
    /// Numbers and stamps advance, the poses are frozen.
    Frozen,
    /// The tip's pose is frozen, with noise of this standard deviation per axis, metres; the base
    /// goes on.
    FrozenTip(f64),
    /// A second server at the same address and port sends other poses, with these offsets of its
    /// count, frames, and of its clock, s; `alone` once the first one is silent.
    SameAddress {
        /// Frame numbers of the second server minus those of the first one.
        frames: i32,
        /// Its clock minus that of the first one, s.
        clock_s: f64,
        /// Whether the first server is silent.
        alone: bool,
    },
    /// Frames are delayed by random times up to this one, s, and sent as they become due.
    Jitter(f64),
    /// Frames are lost for a while, again and again.
    Gaps {
        /// From the beginning of one gap to that of the next, s.
        every_s: f64,
        /// Length of each, s.
        lasting_s: f64,
    },
    /// Frame numbers descend.
    Descending,
    /// The tip's quaternion is zero.
    ZeroQuaternion,
    /// Numbers and poses advance, the stamps are frozen.
    FrozenClock,
    /// The tip's position is not a number.
    NanPose,
    /// The tip is displaced by this much, metres along Motive's x.
    Jump(f64),
    /// The two bodies are interchanged.
    SwappedBodies,
    /// A second server on this computer sends other poses to the same clients.
    SecondServer,
    /// The server restarts once: frame numbers from 1, clock from 0, no clients.
    Restart,
    /// Frames are truncated or have wrong bytes.
    Malformed,
    /// Frames are sent this much later than they were captured, s.
    Late(f64),
    /// Requests for the list of bodies are not answered.
    Undescribed,
    /// The tip's body is missing in the frames and in the list of bodies.
    BodyGone,
}
