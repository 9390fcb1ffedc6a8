//! Handshake: requests at the start of a connection, and checks of the answers.

use std::net::SocketAddr;

use natnet::command::{self, CommandError, ConnectOptions, Request};
use natnet::{ModelDef, ParsePolicy, ServerInfo, Version};

use super::fault::TrackingFault;
use super::settings::{TrackingSettings, Transport};
use super::sockets::TrackerSockets;
use crate::hardware::clock::Clock;

/// Time after which a request is repeated, s: datagrams get lost.
const REPEAT_S: f64 = 0.25;

/// Interval at which the sockets are read, s.
const READ_INTERVAL_S: f64 = 0.002;

/// Most datagrams read between two looks at the clock.
const MAX_AT_ONCE: usize = 256;

/// The connect request. In unicast it also requests the frames, in the fixed version if there is
/// one.
pub(super) fn connect_request(settings: &TrackingSettings) -> Result<Request, CommandError> {
    match (settings.transport, settings.version.fixed()) {
        (Transport::Unicast, Some(version)) => {
            command::connect_request_with(ConnectOptions::requesting(version))
        }
        _ => command::connect_request(),
    }
}

/// Requests the server's identity.
pub(super) fn connect(
    sockets: &mut TrackerSockets,
    settings: &TrackingSettings,
    clock: &dyn Clock,
) -> Result<ServerInfo, TrackingFault> {
    let read =
        |datagram: &[u8]| ServerInfo::parse_with_policy(datagram, ParsePolicy::Compatible).ok();
    request_until_answered(sockets, settings, clock, connect_request(settings), read)?.map_err(
        |unreadable| TrackingFault::NoServer {
            server: sockets.server(),
            waited_s: settings.connect_s,
            unreadable,
        },
    )
}

/// Requests the list of bodies.
pub(super) fn model(
    sockets: &mut TrackerSockets,
    settings: &TrackingSettings,
    version: Version,
    clock: &dyn Clock,
) -> Result<ModelDef, TrackingFault> {
    let read = |datagram: &[u8]| {
        ModelDef::parse_with_policy(datagram, version, ParsePolicy::Compatible).ok()
    };
    request_until_answered(sockets, settings, clock, command::request_modeldef(), read)?.map_err(
        |unreadable| TrackingFault::NoModel {
            server: sockets.server(),
            waited_s: settings.connect_s,
            unreadable,
        },
    )
}

/// Repeats a request until a valid answer arrives or the time is over; then returns the number of
/// unreadable datagrams.
fn request_until_answered<T>(
    sockets: &mut TrackerSockets,
    settings: &TrackingSettings,
    clock: &dyn Clock,
    request: Result<Request, CommandError>,
    read: impl Fn(&[u8]) -> Option<T>,
) -> Result<Result<T, u64>, TrackingFault> {
    let fault = |source| TrackingFault::Socket {
        doing: format!("communicate with {}", settings.server),
        source,
    };
    let request = request.map_err(|error| fault(std::io::Error::other(error)))?;
    let start_s = clock.now_s();
    let (mut request_s, mut unreadable) = (start_s, 0);
    while clock.now_s() - start_s <= settings.connect_s {
        if clock.now_s() >= request_s {
            sockets.send(request.as_bytes()).map_err(fault)?;
            request_s += REPEAT_S;
        }
        clock.sleep_until(clock.now_s() + READ_INTERVAL_S);
        let server = SocketAddr::V4(sockets.server());
        for _ in 0..MAX_AT_ONCE {
            let Some((datagram, from)) = sockets.receive().map_err(fault)? else { break };
            // Answers of another server on the network do not count.
            if let Some(answer) = read(datagram).filter(|_| from == server) {
                return Ok(Ok(answer));
            }
            // Unicast frames may arrive before the answer.
            unreadable += u64::from(natnet::FrameOfData::parse(datagram, Version::V4_1).is_err());
        }
    }
    Ok(Err(unreadable))
}

/// The version of the frames that the server will send.
pub(super) fn version(
    settings: &TrackingSettings,
    server: &ServerInfo,
) -> Result<Version, TrackingFault> {
    let offered = server.protocol_version;
    let Some(fixed) = settings.version.fixed() else {
        return if offered.validate().is_ok() {
            Ok(offered)
        } else {
            Err(unreadable_version(server, offered))
        };
    };
    let same = (fixed.major, fixed.minor) == (offered.major, offered.minor);
    // A multicast stream serves all its clients in one version.
    let can_switch = settings.transport == Transport::Unicast && offered.major >= 3;
    if same || can_switch {
        return Ok(fixed);
    }
    let expected = format!(
        "{}.{} as set in `version`; set it to auto, or use unicast",
        fixed.major, fixed.minor
    );
    Err(TrackingFault::Version {
        application: application(server),
        found: offered.to_string(),
        expected,
    })
}

/// The error for an unsupported version.
pub(super) fn unreadable_version(server: &ServerInfo, found: Version) -> TrackingFault {
    let expected =
        "3.0, 3.1, 4.0 or 4.1; a newer server may stream 4.1 if `version` requests it in unicast"
            .into();
    TrackingFault::Version { application: application(server), found: found.to_string(), expected }
}

/// Refuses a server that sends its frames to another address than the configured one.
pub(super) fn transport(
    settings: &TrackingSettings,
    server: &ServerInfo,
) -> Result<(), TrackingFault> {
    let connection = &server.connection;
    let found = if connection.multicast { Transport::Multicast } else { Transport::Unicast };
    let found_at = std::net::SocketAddrV4::new(server.multicast_group(), connection.data_port);
    let expected_at = std::net::SocketAddrV4::new(settings.multicast_group, settings.data_port);
    if found == settings.transport && (found == Transport::Unicast || found_at == expected_at) {
        return Ok(());
    }
    Err(TrackingFault::Transport { found, found_at, expected: settings.transport, expected_at })
}

/// Name and version of the server.
pub(super) fn application(server: &ServerInfo) -> String {
    format!("{} {}", server.application_name, server.server_version)
}
