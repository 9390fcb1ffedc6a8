//! Faults while connecting to the motion capture system.

use std::io;
use std::net::SocketAddrV4;

use super::settings::{BodyName, Transport};
use crate::base::BadOption;

/// Why there is no tracking, and how to continue.
#[derive(Debug, thiserror::Error)]
pub enum TrackingFault {
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] BadOption),
    /// The system refused a socket.
    #[error(
        "tracking: could not {doing} ({source}); check `interface` and that no other program uses \
         the port"
    )]
    Socket {
        /// The operation that failed.
        doing: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// No server answered the handshake.
    #[error(
        "tracking: no answer of a NatNet server at {server} within {waited_s} s ({unreadable} \
         other datagrams received); start Motive, enable streaming, check `server`, `command_port` \
         and firewalls"
    )]
    NoServer {
        /// Address of the server.
        server: SocketAddrV4,
        /// Time waited, s.
        waited_s: f64,
        /// Datagrams that were not the answer.
        unreadable: u64,
    },
    /// The server did not describe its bodies.
    #[error(
        "tracking: {server} did not describe its bodies within {waited_s} s ({unreadable} other \
         datagrams received); check its NatNet version, restart its streaming"
    )]
    NoModel {
        /// Address of the server.
        server: SocketAddrV4,
        /// Time waited, s.
        waited_s: f64,
        /// Datagrams that were not the answer.
        unreadable: u64,
    },
    /// The stream's version is not supported.
    #[error("tracking: the server {application} streams NatNet {found}, expected {expected}")]
    Version {
        /// Name and version of the server.
        application: String,
        /// Version of the stream.
        found: String,
        /// The expected version and how to get it.
        expected: String,
    },
    /// The server's transport differs from the configured one.
    #[error(
        "tracking: the server streams by {found:?} to {found_at}, expected {expected:?} to \
         {expected_at}; set `transport`, `multicast_group` and `data_port` as in Motive's \
         streaming settings"
    )]
    Transport {
        /// Transport of the server.
        found: Transport,
        /// Its group and port.
        found_at: SocketAddrV4,
        /// Configured transport.
        expected: Transport,
        /// Configured group and port.
        expected_at: SocketAddrV4,
    },
    /// The server does not track the configured body.
    #[error(
        "tracking: the server has no rigid body {body} (the robot's {role}); it has {there_are}. \
         Create it in Motive or set `{role}_body`; names are case-sensitive"
    )]
    BodyMissing {
        /// `base` or `tip`.
        role: &'static str,
        /// The configured body.
        body: BodyName,
        /// The bodies of the server.
        there_are: String,
    },
    /// Several bodies have the configured name or id.
    #[error(
        "tracking: the server has {count} rigid bodies {body} (the robot's {role}); it has \
         {there_are}. Rename one of them in Motive, or give them different streaming ids"
    )]
    BodyDouble {
        /// `base` or `tip`.
        role: &'static str,
        /// The configured body.
        body: BodyName,
        /// Their number.
        count: usize,
        /// The bodies of the server.
        there_are: String,
    },
    /// Base and tip are the same body, once by name and once by id.
    #[error(
        "tracking: base and tip are the same rigid body, streaming id {id}; `base_body` and \
         `tip_body` must differ"
    )]
    BodyShared {
        /// Its streaming id.
        id: i32,
    },
    /// The points do not determine a pose.
    #[error("tracking: cannot compute the alignment: {0}")]
    Alignment(String),
}
