//! The server of `spinebench view`: one page and its socket, for this computer alone.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::http::{BrowserRequest, accept_socket, answer_page, refuse_request};

/// What the server shows.
pub(super) trait ServedPage: Send + Sync + 'static {
    /// The page.
    fn page(&self) -> &str;
    /// Talks with a page over an open socket until either side ends it.
    fn talk(&self, _stream: TcpStream) {}
}

/// Pages that are served at a time.
const MAX_VISITORS: usize = 16;

/// A server that listens.
pub(super) struct ViewServer {
    listener: TcpListener,
    token: String,
}

impl ViewServer {
    /// Listens on a port of this computer; 0 takes a free one.
    pub(super) fn open(port: u16) -> io::Result<ViewServer> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let mut token = [0; 16];
        getrandom::fill(&mut token).map_err(io::Error::other)?;
        let token = token.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(ViewServer { listener, token })
    }

    /// Address of the page: only who knows its token is served.
    pub(super) fn url(&self) -> io::Result<String> {
        Ok(format!("http://{}/{}/", self.listener.local_addr()?, self.token))
    }

    /// Serves until the process ends.
    pub(super) fn serve(self, page: Arc<dyn ServedPage>) -> io::Result<()> {
        let (address, token) = (self.listener.local_addr()?, Arc::new(self.token));
        let visitors = Arc::new(AtomicUsize::new(0));
        for stream in self.listener.incoming() {
            let Ok(stream) = stream else { continue };
            if visitors.fetch_add(1, Ordering::SeqCst) >= MAX_VISITORS {
                visitors.fetch_sub(1, Ordering::SeqCst);
                continue;
            }
            let (page, token, visitors) = (page.clone(), token.clone(), visitors.clone());
            std::thread::spawn(move || {
                // A browser that goes away is no error.
                let _ = answer(stream, address, &token, page.as_ref());
                visitors.fetch_sub(1, Ordering::SeqCst);
            });
        }
        Ok(())
    }
}

fn answer(
    mut stream: TcpStream,
    address: SocketAddr,
    token: &str,
    served: &dyn ServedPage,
) -> io::Result<()> {
    let Some(request) = BrowserRequest::read(&mut stream)? else {
        return refuse_request(&mut stream, "400 Bad Request");
    };
    let inside = request.path.strip_prefix('/').and_then(|path| path.strip_prefix(token));
    let is_page = request.method == "GET" && request.is_from(address);
    match (inside, &request.socket_key) {
        _ if !is_page => refuse_request(&mut stream, "403 Forbidden"),
        (Some("/"), None) => answer_page(&mut stream, served.page()),
        // A browser says where the page is from; what says nothing is none.
        (Some("/socket"), Some(key)) if request.origin.is_some() => {
            accept_socket(&mut stream, key)?;
            stream.set_nodelay(true)?;
            served.talk(stream);
            Ok(())
        }
        (Some("/socket"), _) => refuse_request(&mut stream, "403 Forbidden"),
        _ => refuse_request(&mut stream, "404 Not Found"),
    }
}
