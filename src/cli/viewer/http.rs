//! What a browser asks, and what it is answered.

use std::io::{self, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// Upper bound on the head of a request, bytes.
const MAX_HEAD: usize = 16 << 10;
/// Upper bound on its lines.
const MAX_HEADERS: usize = 64;
/// How long the head of a request may take.
const PATIENCE: Duration = Duration::from_secs(5);

/// The head of a request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct BrowserRequest {
    pub(super) method: String,
    pub(super) path: String,
    pub(super) host: String,
    pub(super) origin: Option<String>,
    /// The key of a request for a socket.
    pub(super) socket_key: Option<String>,
}

impl BrowserRequest {
    /// Reads the head of a request; `None` for what is none.
    pub(super) fn read(stream: &mut TcpStream) -> io::Result<Option<BrowserRequest>> {
        stream.set_read_timeout(Some(PATIENCE))?;
        let mut head = Vec::new();
        let mut part = [0; 2048];
        while head.len() < MAX_HEAD {
            let count = stream.read(&mut part)?;
            if count == 0 {
                break;
            }
            head.extend_from_slice(&part[..count]);
            match BrowserRequest::parsed(&head) {
                Ok(Some(request)) => return Ok(Some(request)),
                Ok(None) => {}
                Err(_) => break,
            }
        }
        Ok(None)
    }

    /// The request that `head` holds; `None` while it is not complete.
    fn parsed(head: &[u8]) -> Result<Option<BrowserRequest>, httparse::Error> {
        let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        if parsed.parse(head)?.is_partial() {
            return Ok(None);
        }
        let value = |name: &str| {
            let header = parsed.headers.iter().find(|one| one.name.eq_ignore_ascii_case(name));
            header.map(|one| String::from_utf8_lossy(one.value).trim().to_owned())
        };
        let upgrades = value("upgrade").is_some_and(|to| to.eq_ignore_ascii_case("websocket"));
        Ok(Some(BrowserRequest {
            method: parsed.method.unwrap_or_default().to_owned(),
            path: parsed.path.unwrap_or_default().to_owned(),
            host: value("host").unwrap_or_default(),
            origin: value("origin"),
            socket_key: value("sec-websocket-key").filter(|_| upgrades),
        }))
    }

    /// Whether a page of this server asks: its host is this server by a name that only this
    /// computer has, and so is the origin of the page, if there is one.
    pub(super) fn is_from(&self, server: SocketAddr) -> bool {
        let names = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", server.port()));
        let is_ours =
            |origin: &String| names.iter().any(|name| *origin == format!("http://{name}"));
        names.contains(&self.host) && self.origin.as_ref().is_none_or(is_ours)
    }
}

/// Answers with a page.
pub(super) fn answer_page(stream: &mut TcpStream, page: &str) -> io::Result<()> {
    let policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                  img-src data:; connect-src 'self'";
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\n\
         Content-Security-Policy: {policy}\r\nReferrer-Policy: no-referrer\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        page.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(page.as_bytes())
}

/// Refuses a request.
pub(super) fn refuse_request(stream: &mut TcpStream, status: &str) -> io::Result<()> {
    let length = status.len() + 1;
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: text/plain; charset=utf-8\r\n\
         Content-Length: {length}\r\nConnection: close\r\n\r\n{status}\n"
    )
}

/// Accepts a request for a socket.
pub(super) fn accept_socket(stream: &mut TcpStream, key: &str) -> io::Result<()> {
    let accepted = tungstenite::handshake::derive_accept_key(key.as_bytes());
    write!(
        stream,
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accepted}\r\n\r\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pages_of_this_server_may_ask() {
        let server: SocketAddr = "127.0.0.1:8123".parse().unwrap();
        let asks = |host: &str, origin: Option<&str>| {
            let (host, origin) = (host.to_owned(), origin.map(str::to_owned));
            BrowserRequest { host, origin, ..BrowserRequest::default() }.is_from(server)
        };
        assert!(asks("127.0.0.1:8123", None));
        assert!(asks("localhost:8123", Some("http://localhost:8123")));
        assert!(!asks("robot.example:8123", None));
        assert!(!asks("127.0.0.1:8124", None));
        assert!(!asks("127.0.0.1:8123", Some("http://robot.example")));
        assert!(!asks("127.0.0.1:8123", Some("null")));
    }

    #[test]
    fn heads_arrive_in_parts() {
        let head = b"GET /x/ HTTP/1.1\r\nHost: localhost:1\r\nUpgrade: WebSocket\r\nSec-WebSocket-Key: k\r\n\r\n";
        assert_eq!(BrowserRequest::parsed(&head[..20]), Ok(None));
        let request = BrowserRequest::parsed(head).unwrap().unwrap();
        assert_eq!((request.path.as_str(), request.socket_key.as_deref()), ("/x/", Some("k")));
        assert!(BrowserRequest::parsed(b"\x16\x03\x01 not http\r\n\r\n").is_err());
    }
}
