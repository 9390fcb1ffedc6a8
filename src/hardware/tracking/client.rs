//! The client: a stream, its sockets, and what keeps the connection alive.

use natnet::{ServerInfo, command};

use super::fault::TrackingFault;
use super::handshake;
use super::pose::TipPose;
use super::settings::{TrackingSettings, Transport};
use super::sockets::TrackerSockets;
use super::status::TrackingStatus;
use super::stream::{FrameStream, Received};
use crate::hardware::clock::Clock;

/// A unicast server is told so often, s, that this client is there.
const KEEPALIVE_S: f64 = 1.0;

/// After so long without a frame, s, the server is asked again who it is.
const SILENCE_S: f64 = 1.0;

/// Shortest time between two questions, s.
const MIN_REQUEST_INTERVAL_S: f64 = 0.5;

/// Datagrams read in one poll: a flood may not hold the caller up.
const MAX_PER_POLL: usize = 4096;

/// The connection to a motion capture server.
pub struct TrackerClient {
    settings: TrackingSettings,
    link: TrackerSockets,
    stream: FrameStream,
    server: ServerInfo,
    keepalive_s: f64,
    next_request_s: f64,
    last_frame_s: f64,
}

impl TrackerClient {
    /// Connects to the server that the settings describe, and looks the robot's bodies up. Waits for answers on
    /// `clock`, `connect_s` for each at most.
    ///
    /// # Errors
    /// [`TrackingFault`] says what was found, what was expected and how to go on.
    pub fn open(settings: TrackingSettings, clock: &dyn Clock) -> Result<TrackerClient, TrackingFault> {
        settings.check()?;
        let mut link = TrackerSockets::open(&settings)?;
        let server = handshake::connect(&mut link, &settings, clock)?;
        let version = handshake::version(&settings, &server)?;
        handshake::transport(&settings, &server)?;
        if settings.transport == Transport::Multicast {
            link.join(&settings)?;
        }
        let model = match handshake::model(&mut link, &settings, version, clock) {
            // Bodies that are set by their streaming ids need nobody to look them up.
            Err(TrackingFault::NoModel { .. }) if settings.names_no_body() => None,
            other => Some(other?),
        };
        let stream = FrameStream::new(&settings, &server, model.as_ref())?;
        let now_s = clock.now_s();
        Ok(TrackerClient {
            settings,
            link,
            stream,
            server,
            keepalive_s: now_s,
            next_request_s: now_s,
            last_frame_s: now_s,
        })
    }

    /// Takes in everything that has arrived by local time `now_s`, and says to the server what has to be said. Never
    /// waits and never fails: what goes wrong is counted in [`TrackerClient::status`].
    pub fn poll(&mut self, now_s: f64) {
        for _ in 0..MAX_PER_POLL {
            match self.link.receive() {
                Ok(Some((datagram, from))) => {
                    let received = self.stream.process(datagram, from, now_s);
                    self.handle(received, now_s);
                }
                Ok(None) => break,
                Err(error) => {
                    self.stream.status_mut().count_socket_error(&error);
                    break;
                }
            }
        }
        self.maintain_connection(now_s);
    }

    fn handle(&mut self, received: Received, now_s: f64) {
        match received {
            Received::Frame => self.last_frame_s = now_s,
            Received::Model(model) => self.stream.set_model(&model),
            // Only as an answer: while frames come, nothing has to be agreed anew.
            Received::Server(server) if self.is_silent(now_s) => {
                self.stream.reconnect(&server);
                self.server = server;
            }
            Received::Server(_) | Received::Nothing => {}
        }
    }

    fn is_silent(&self, now_s: f64) -> bool {
        now_s - self.last_frame_s >= SILENCE_S
    }

    /// Keeps a unicast server sending, and asks for what is not known.
    fn maintain_connection(&mut self, now_s: f64) {
        if self.settings.transport == Transport::Unicast && now_s >= self.keepalive_s {
            self.keepalive_s = now_s + KEEPALIVE_S;
            self.send(&command::keepalive_datagram());
        }
        if now_s < self.next_request_s {
            return;
        }
        let request = if self.is_silent(now_s) {
            handshake::connect_request(&self.settings)
        } else if self.stream.wants_model() {
            command::request_modeldef()
        } else {
            return;
        };
        self.next_request_s = now_s + MIN_REQUEST_INTERVAL_S;
        if let Ok(request) = request {
            self.send(request.as_bytes());
        }
    }

    fn send(&mut self, datagram: &[u8]) {
        if let Err(error) = self.link.send(datagram) {
            self.stream.status_mut().count_socket_error(&error);
        }
    }

    /// The tip at a local time, s: between the valid samples before and after if they are at most 2.5 frame periods
    /// apart, else the one before if it is at most one period old, else none.
    pub fn pose_at(&self, time_s: f64) -> Option<TipPose> {
        self.stream.pose_at(time_s)
    }

    /// The newest valid sample.
    pub fn latest(&self) -> Option<&TipPose> {
        self.stream.latest()
    }

    /// How old the newest valid sample is at `now_s`, s; infinite before the first one. Frames that come late are old
    /// when they come, against the least delay of the last ten seconds.
    pub fn age_s(&self, now_s: f64) -> f64 {
        self.latest().map_or(f64::INFINITY, |tip| now_s - tip.time_s)
    }

    /// What has been counted and measured so far.
    pub fn status(&self) -> &TrackingStatus {
        self.stream.status()
    }

    /// The server's name and version, and the version of its protocol.
    pub fn server(&self) -> String {
        format!("{}, NatNet {}", handshake::application(&self.server), self.server.protocol_version)
    }
}

impl Drop for TrackerClient {
    /// A unicast server need not wait for keep-alives that do not come.
    fn drop(&mut self) {
        if self.settings.transport == Transport::Unicast {
            self.send(&command::disconnect_datagram());
        }
    }
}
