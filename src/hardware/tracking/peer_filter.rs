//! Filter of datagrams by sender: only the server of the handshake counts.

use std::net::{SocketAddr, SocketAddrV4};

/// Addresses of the server. The port of its frames is learnt from the first frame; a port that the
/// server announced takes precedence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PeerFilter {
    command: SocketAddrV4,
    data_port: u16,
    frames_port: Option<u16>,
}

impl PeerFilter {
    /// A filter for the server that answered at `command` and announced `data_port`.
    pub(crate) fn new(command: SocketAddrV4, data_port: u16) -> PeerFilter {
        PeerFilter { command, data_port, frames_port: None }
    }

    /// True for answers of our server.
    pub(crate) fn accepts_answers(&self, from: SocketAddr) -> bool {
        from == SocketAddr::V4(self.command)
    }

    /// True for frames of our server, or of one that may be our server.
    pub(crate) fn accepts_frames(&self, from: SocketAddr) -> bool {
        let SocketAddr::V4(from) = from else { return false };
        let port = from.port();
        let is_learnt = self.frames_port.is_none_or(|learnt_port| learnt_port == port);
        let is_announced = self.is_named_port(port)
            && !self.frames_port.is_some_and(|learnt_port| self.is_named_port(learnt_port));
        from.ip() == self.command.ip() && (is_learnt || is_announced)
    }

    /// Accepts frames from this port only, after a valid frame came from it.
    pub(crate) fn set_frames_port(&mut self, from: SocketAddr) {
        self.frames_port = Some(from.port());
    }

    /// Takes the `data_port` of a new handshake. A port that was never announced is discarded.
    pub(crate) fn reconnect(&mut self, data_port: u16) {
        self.data_port = data_port;
        self.frames_port = self.frames_port.filter(|learnt_port| self.is_named_port(*learnt_port));
    }

    /// True for anything from the server's address.
    pub(crate) fn is_same_host(&self, from: SocketAddr) -> bool {
        from.ip() == *self.command.ip()
    }

    fn is_named_port(&self, port: u16) -> bool {
        port == self.data_port || port == self.command.port()
    }
}
