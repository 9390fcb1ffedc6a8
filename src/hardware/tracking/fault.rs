//! What can go wrong when a connection to the motion capture is made.

use std::io;
use std::net::SocketAddrV4;

use super::settings::{BodyName, Transport};
use crate::base::BadOption;

/// Why there is no tracking, and how to go on.
#[derive(Debug, thiserror::Error)]
pub enum TrackingFault {
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] BadOption),
    /// The system refused a socket.
    #[error("tracking: could not {doing} ({source}); check `interface` and that no other program holds the port")]
    Socket {
        /// What was being done.
        doing: String,
        /// The system's reason.
        source: io::Error,
    },
    /// Nobody answered the handshake.
    #[error(
        "tracking: no NatNet server answered at {server} within {waited_s} s ({unreadable} datagrams came that are no \
         answer); start Motive, turn its streaming on, check `server`, `command_port` and firewalls"
    )]
    NoServer {
        /// Where the server should be.
        server: SocketAddrV4,
        /// How long was waited, s.
        waited_s: f64,
        /// Datagrams that came but were not the answer.
        unreadable: u64,
    },
    /// The server did not say which bodies it tracks.
    #[error(
        "tracking: {server} did not describe its bodies within {waited_s} s ({unreadable} datagrams came that are no \
         answer); if its NatNet version is right, restart its streaming"
    )]
    NoModel {
        /// The server.
        server: SocketAddrV4,
        /// How long was waited, s.
        waited_s: f64,
        /// Datagrams that came but were not the answer.
        unreadable: u64,
    },
    /// The stream's layout is not one that can be read.
    #[error("tracking: the server {application} streams NatNet {found}, expected {expected}")]
    Version {
        /// The server's name and version.
        application: String,
        /// The stream's version.
        found: String,
        /// What was expected and how to get it.
        expected: String,
    },
    /// The server sends frames in another way than this client listens.
    #[error(
        "tracking: the server streams by {found:?} to {found_at}, expected {expected:?} to {expected_at}; set \
         `transport`, `multicast_group` and `data_port` as in Motive's streaming settings"
    )]
    Transport {
        /// The server's way.
        found: Transport,
        /// Its group and port.
        found_at: SocketAddrV4,
        /// The way that was set.
        expected: Transport,
        /// The group and port that were set.
        expected_at: SocketAddrV4,
    },
    /// The server tracks no such body.
    #[error(
        "tracking: the server has no rigid body {body} (the robot's {role}); it has {there_are}. Create it in Motive or \
         set `{role}_body`; capitals matter"
    )]
    BodyMissing {
        /// `base` or `tip`.
        role: &'static str,
        /// The body that was set.
        body: BodyName,
        /// The bodies of the server.
        there_are: String,
    },
    /// More than one body answers to the name or id.
    #[error(
        "tracking: the server has {count} rigid bodies {body} (the robot's {role}); it has {there_are}. Rename one of \
         them in Motive, or give them different streaming ids"
    )]
    BodyDouble {
        /// `base` or `tip`.
        role: &'static str,
        /// The body that was set.
        body: BodyName,
        /// How many there are.
        count: usize,
        /// The bodies of the server.
        there_are: String,
    },
    /// Base and tip are one body, once by name and once by id.
    #[error("tracking: base and tip are the same rigid body, streaming id {id}; set `base_body` and `tip_body` apart")]
    BodyShared {
        /// Its streaming id.
        id: i32,
    },
    /// Points that do not determine a pose.
    #[error("tracking: no alignment from these points: {0}")]
    Alignment(String),
}
