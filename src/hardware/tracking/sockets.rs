//! The client's UDP sockets. No call blocks.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};

use socket2::{Domain, Protocol, Socket, Type};

use super::fault::TrackingFault;
use super::settings::TrackingSettings;

/// Size of the receive buffer: holds the longest UDP datagram.
const BUFFER_BYTES: usize = 65_536;

/// Requested size of the system's receive queue: several seconds of frames.
const QUEUE_BYTES: usize = 1 << 20;

/// A socket for commands, which also receives unicast frames, and one for multicast frames.
pub(crate) struct TrackerSockets {
    command: UdpSocket,
    group: Option<UdpSocket>,
    server: SocketAddrV4,
    buffer: Box<[u8]>,
}

impl TrackerSockets {
    /// Opens the command socket, on a port that the system chooses.
    pub(crate) fn open(settings: &TrackingSettings) -> Result<TrackerSockets, TrackingFault> {
        let local = SocketAddrV4::new(settings.interface, 0);
        let command = socket(local, false).map_err(|source| TrackingFault::Socket {
            doing: format!("open a UDP socket at {local}"),
            source,
        })?;
        let server = SocketAddrV4::new(settings.server, settings.command_port);
        Ok(TrackerSockets {
            command,
            group: None,
            server,
            buffer: vec![0; BUFFER_BYTES].into_boxed_slice(),
        })
    }

    /// Joins the multicast group of the frames.
    pub(crate) fn join(&mut self, settings: &TrackingSettings) -> Result<(), TrackingFault> {
        let group = SocketAddrV4::new(settings.multicast_group, settings.data_port);
        let joined = joined(group, settings.interface).map_err(|source| TrackingFault::Socket {
            doing: format!("join the multicast group {group} on interface {}", settings.interface),
            source,
        })?;
        self.group = Some(joined);
        Ok(())
    }

    /// Address that commands are sent to.
    pub(crate) fn server(&self) -> SocketAddrV4 {
        self.server
    }

    /// Sends a command.
    pub(crate) fn send(&self, datagram: &[u8]) -> io::Result<()> {
        self.command.send_to(datagram, self.server).map(|_| ())
    }

    /// The next waiting datagram and its sender.
    pub(crate) fn receive(&mut self) -> io::Result<Option<(&[u8], SocketAddr)>> {
        let mut received = waiting(&self.command, &mut self.buffer)?;
        if let (None, Some(group)) = (received, &self.group) {
            received = waiting(group, &mut self.buffer)?;
        }
        Ok(received.map(|(length, from)| (&self.buffer[..length], from)))
    }
}

const PASSING: [ErrorKind; 4] = [
    ErrorKind::WouldBlock,
    ErrorKind::Interrupted,
    ErrorKind::ConnectionReset,
    ErrorKind::ConnectionRefused,
];

fn waiting(socket: &UdpSocket, buffer: &mut [u8]) -> io::Result<Option<(usize, SocketAddr)>> {
    match socket.recv_from(buffer) {
        Ok((length, from)) => Ok(Some((length, from))),
        // Some systems report a closed port of the server here; a missing answer is detected
        // elsewhere.
        Err(error) if PASSING.contains(&error.kind()) => Ok(None),
        Err(error) => Err(error),
    }
}

fn socket(local: SocketAddrV4, shared: bool) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_reuse_address(shared)?;
    socket.set_nonblocking(true)?;
    // A smaller queue than requested is acceptable.
    let _ = socket.set_recv_buffer_size(QUEUE_BYTES);
    socket.bind(&SocketAddr::V4(local).into())?;
    Ok(socket.into())
}

/// Other programs on this computer may join the same group.
fn joined(group: SocketAddrV4, interface: Ipv4Addr) -> io::Result<UdpSocket> {
    // Bound to the group's address, Unix delivers only this group; Windows does not accept that
    // address.
    let address = if cfg!(windows) { Ipv4Addr::UNSPECIFIED } else { *group.ip() };
    let socket = socket(SocketAddrV4::new(address, group.port()), true)?;
    socket.join_multicast_v4(group.ip(), &interface)?;
    Ok(socket)
}
