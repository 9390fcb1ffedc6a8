//! Whose datagrams count: those of the server that we shook hands with.

use std::net::{SocketAddr, SocketAddrV4};

/// Where our server sends from. Its address is known; the port of its frames is learnt from the first one, and a port
/// that the server named takes precedence over one that it did not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PeerFilter {
    command: SocketAddrV4,
    data_port: u16,
    frames_port: Option<u16>,
}

impl PeerFilter {
    /// The server that answered at `command` and named `data_port`.
    pub(crate) fn new(command: SocketAddrV4, data_port: u16) -> PeerFilter {
        PeerFilter { command, data_port, frames_port: None }
    }

    /// True for answers of our server.
    pub(crate) fn accepts_answers(&self, from: SocketAddr) -> bool {
        from == SocketAddr::V4(self.command)
    }

    /// True for frames of our server, or of one that may be it.
    pub(crate) fn accepts_frames(&self, from: SocketAddr) -> bool {
        let SocketAddr::V4(from) = from else { return false };
        let port = from.port();
        let same = self.frames_port.is_none_or(|known| known == port);
        let better = self.is_named_port(port) && !self.frames_port.is_some_and(|known| self.is_named_port(known));
        from.ip() == self.command.ip() && (same || better)
    }

    /// A good frame came from here: from now on only these count.
    pub(crate) fn set_frames_port(&mut self, from: SocketAddr) {
        self.frames_port = Some(from.port());
    }

    /// The server was met again and names `data_port`. A port that it never named need not be its port any more.
    pub(crate) fn reconnect(&mut self, data_port: u16) {
        self.data_port = data_port;
        self.frames_port = self.frames_port.filter(|known| self.is_named_port(*known));
    }

    /// True for anything from the server's address.
    pub(crate) fn is_same_host(&self, from: SocketAddr) -> bool {
        from.ip() == *self.command.ip()
    }

    fn is_named_port(&self, port: u16) -> bool {
        port == self.data_port || port == self.command.port()
    }
}
