//! Sockets of the server: clients, answers, and destinations of frames.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};

use natnet::command::ConnectOptions;
use natnet::{ConnectionInfo, FrameOfData, ModelDef, ServerInfo, Version};
use socket2::SockRef;

use super::options::TrackerOptions;
use crate::hardware::tracking::Transport;

/// Ticks per second of the cameras' clock.
pub(crate) const CLOCK_HZ: u64 = 10_000_000;

/// Time without a message after which a client is forgotten, s.
const CLIENT_GONE_S: f64 = 5.0;

/// Most clients, and most requests answered in one step: the port is open to everybody on this
/// computer.
const MAX_CLIENTS: usize = 8;
const MAX_REQUESTS: usize = 256;

/// Longest request that is read, bytes.
const REQUEST_BYTES: usize = 2048;

/// A unicast client.
struct NatNetClient {
    address: SocketAddr,
    version: Version,
    heard_s: f64,
}

/// The server at 127.0.0.1.
pub(crate) struct NatNetServer {
    command: UdpSocket,
    data: UdpSocket,
    stranger: UdpSocket,
    transport: Transport,
    group: SocketAddrV4,
    version: Version,
    clients: Vec<NatNetClient>,
}

impl NatNetServer {
    pub(crate) fn open(options: &TrackerOptions) -> io::Result<NatNetServer> {
        let data = socket(options.data_port)?;
        let group = SocketAddrV4::new(options.multicast_group, data.local_addr()?.port());
        Ok(NatNetServer {
            command: socket(options.command_port)?,
            data,
            stranger: socket(0)?,
            transport: options.transport,
            group,
            version: options.version,
            clients: Vec::new(),
        })
    }

    /// Ports for commands and for frames.
    pub(crate) fn ports(&self) -> io::Result<(u16, u16)> {
        Ok((self.command.local_addr()?.port(), self.group.port()))
    }

    pub(crate) fn forget_clients(&mut self) {
        self.clients.clear();
    }

    /// Reads the requests, and answers them unless `silent`.
    pub(crate) fn answer(&mut self, now_s: f64, model: Option<&ModelDef>, silent: bool) {
        let mut request = [0; REQUEST_BYTES];
        for _ in 0..MAX_REQUESTS {
            let Ok((length, from)) = self.command.recv_from(&mut request) else { break };
            if silent {
                continue;
            }
            if let Some(reply) = self.reply(&request[..length], from, now_s, model) {
                let _ = self.command.send_to(&reply, from);
            }
        }
        self.clients.retain(|client| now_s - client.heard_s <= CLIENT_GONE_S);
    }

    fn reply(
        &mut self,
        request: &[u8],
        from: SocketAddr,
        now_s: f64,
        model: Option<&ModelDef>,
    ) -> Option<Vec<u8>> {
        let id = natnet::MessageHeader::parse(request).ok()?.message_id;
        let payload = &request[natnet::HEADER_LEN..];
        match id {
            natnet::NAT_CONNECT => {
                self.add_client(payload, from, now_s);
                self.info()
            }
            natnet::NAT_DISCOVERY => self.info(),
            natnet::NAT_REQUEST_MODELDEF => model?.to_datagram(self.version_of(from)).ok(),
            natnet::NAT_ECHOREQUEST => Some(echo(payload, now_s)),
            natnet::NAT_KEEPALIVE => {
                self.clients
                    .iter_mut()
                    .filter(|client| client.address == from)
                    .for_each(|client| client.heard_s = now_s);
                None
            }
            natnet::NAT_DISCONNECT => {
                self.clients.retain(|client| client.address != from);
                None
            }
            _ => Some(message(natnet::NAT_UNRECOGNIZED_REQUEST, &[])),
        }
    }

    /// Adds a unicast client, with the version that it requests.
    fn add_client(&mut self, payload: &[u8], address: SocketAddr, heard_s: f64) {
        let requested =
            ConnectOptions::parse(payload).and_then(|options| options.bitstream_version);
        let version =
            requested.filter(|version| version.validate().is_ok()).unwrap_or(self.version);
        self.clients.retain(|client| client.address != address);
        if self.clients.len() < MAX_CLIENTS {
            self.clients.push(NatNetClient { address, version, heard_s });
        }
    }

    fn version_of(&self, address: SocketAddr) -> Version {
        let client = self.clients.iter().find(|client| client.address == address);
        match (self.transport, client) {
            (Transport::Unicast, Some(client)) => client.version,
            _ => self.version,
        }
    }

    fn info(&self) -> Option<Vec<u8>> {
        let info = ServerInfo {
            application_name: "Simulated tracker".into(),
            server_version: Version::new(1, 0, 0, 0),
            protocol_version: self.version,
            high_res_clock_frequency: CLOCK_HZ,
            connection: ConnectionInfo {
                data_port: self.group.port(),
                multicast: self.transport == Transport::Multicast,
                multicast_group: self.group.ip().octets(),
            },
        };
        info.to_datagram().ok()
    }

    /// Sends a frame to all clients. `corrupt` may change its bytes; a second server sends from
    /// another port.
    pub(crate) fn send(
        &self,
        frame: &FrameOfData,
        stranger: bool,
        corrupt: &mut dyn FnMut(&mut Vec<u8>),
    ) {
        let socket = if stranger { &self.stranger } else { &self.data };
        let mut send = |version: Version, address: SocketAddr| {
            if let Ok(mut datagram) = frame.to_datagram(version) {
                corrupt(&mut datagram);
                let _ = socket.send_to(&datagram, address);
            }
        };
        match self.transport {
            Transport::Multicast => send(self.version, self.group.into()),
            Transport::Unicast => {
                self.clients.iter().for_each(|client| send(client.version, client.address))
            }
        }
    }
}

fn socket(port: u16) -> io::Result<UdpSocket> {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, port))?;
    socket.set_nonblocking(true)?;
    socket.set_multicast_loop_v4(true)?;
    // Frames stay on this computer.
    socket.set_multicast_ttl_v4(0)?;
    SockRef::from(&socket).set_multicast_if_v4(&Ipv4Addr::LOCALHOST)?;
    Ok(socket)
}

fn message(id: u16, payload: &[u8]) -> Vec<u8> {
    let length = u16::try_from(payload.len()).unwrap_or(u16::MAX);
    [&id.to_le_bytes(), &length.to_le_bytes(), payload].concat()
}

/// The client's time as received, and the server's time.
fn echo(payload: &[u8], now_s: f64) -> Vec<u8> {
    let ticks = (now_s * CLOCK_HZ as f64) as u64;
    message(
        natnet::NAT_ECHORESPONSE,
        &[&payload[..payload.len().min(8)], &ticks.to_le_bytes()].concat(),
    )
}
