//! The client: a frame stream, its sockets, and the keep-alive of the connection.

use natnet::{ServerInfo, command};

use super::fault::TrackingFault;
use super::handshake;
use super::pose::TipPose;
use super::settings::{TrackingSettings, Transport};
use super::sockets::TrackerSockets;
use super::status::TrackingStatus;
use super::stream::{FrameStream, Received};
use crate::base::Point3;
use crate::hardware::clock::Clock;

/// Interval of keep-alive messages to a unicast server, s.
const KEEPALIVE_S: f64 = 1.0;

/// Time without a frame after which the handshake is repeated, s.
const SILENCE_S: f64 = 1.0;

/// Shortest interval between two requests, s.
const MIN_REQUEST_INTERVAL_S: f64 = 0.5;

/// Most datagrams read in one poll, so that a flood cannot block the caller.
const MAX_PER_POLL: usize = 4096;

/// A connection to a motion capture server.
pub struct TrackerClient {
    settings: TrackingSettings,
    sockets: TrackerSockets,
    stream: FrameStream,
    server: ServerInfo,
    keepalive_s: f64,
    next_request_s: f64,
    last_frame_s: f64,
}

impl TrackerClient {
    /// Connects to the server and finds the robot's bodies. Waits for answers on `clock`, at most
    /// `connect_s` for each.
    ///
    /// # Errors
    /// [`TrackingFault`] says what was found, what was expected and how to continue.
    pub fn open(
        settings: TrackingSettings,
        clock: &dyn Clock,
    ) -> Result<TrackerClient, TrackingFault> {
        settings.check()?;
        let mut sockets = TrackerSockets::open(&settings)?;
        let server = handshake::connect(&mut sockets, &settings, clock)?;
        let version = handshake::version(&settings, &server)?;
        handshake::transport(&settings, &server)?;
        if settings.transport == Transport::Multicast {
            sockets.join(&settings)?;
        }
        let model = match handshake::model(&mut sockets, &settings, version, clock) {
            // Bodies given by their streaming ids need no model.
            Err(TrackingFault::NoModel { .. }) if settings.names_no_body() => None,
            other => Some(other?),
        };
        let stream = FrameStream::new(&settings, &server, model.as_ref())?;
        let now_s = clock.now_s();
        Ok(TrackerClient {
            settings,
            sockets,
            stream,
            server,
            keepalive_s: now_s,
            next_request_s: now_s,
            last_frame_s: now_s,
        })
    }

    /// Processes everything that has arrived by local time `now_s`, and sends what is due. Never
    /// blocks and never fails: [`TrackerClient::status`] counts what goes wrong.
    pub fn poll(&mut self, now_s: f64) {
        for _ in 0..MAX_PER_POLL {
            match self.sockets.receive() {
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
        // After reading, so that a request is not sent for what has just arrived.
        self.maintain_connection(now_s);
    }

    fn handle(&mut self, received: Received, now_s: f64) {
        match received {
            Received::Frame => self.last_frame_s = now_s,
            Received::Model(model) => self.stream.set_model(&model),
            // Only as an answer: while frames arrive, nothing has to be negotiated.
            Received::Server(server) if self.is_silent(now_s) => {
                self.stream.reconnect(&server, now_s);
                self.server = server;
            }
            Received::Server(_) | Received::Nothing => {}
        }
    }

    fn is_silent(&self, now_s: f64) -> bool {
        now_s - self.last_frame_s >= SILENCE_S
    }

    /// Keeps a unicast server sending, and requests what is missing.
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
        if let Err(error) = self.sockets.send(datagram) {
            self.stream.status_mut().count_socket_error(&error);
        }
    }

    /// The tip at a local time, s: interpolated between the valid samples before and after if they
    /// are at most 2.5 frame periods apart, else the sample before if it is at most one period old,
    /// else none.
    pub fn pose_at(&self, time_s: f64) -> Option<TipPose> {
        self.stream.pose_at(time_s)
    }

    /// Mean tip position of the valid samples since a local time, metres; none without one.
    pub fn mean_since(&self, since_s: f64) -> Option<Point3> {
        self.stream.mean_since(since_s)
    }

    /// The newest valid sample.
    pub fn latest(&self) -> Option<&TipPose> {
        self.stream.latest()
    }

    /// Age of the newest valid sample at `now_s`, s; infinite before the first one. The delay of
    /// late frames counts as age, relative to the smallest delay of the last ten seconds.
    pub fn age_s(&self, now_s: f64) -> f64 {
        self.latest().map_or(f64::INFINITY, |tip| now_s - tip.time_s)
    }

    /// Counts and measures so far.
    pub fn status(&self) -> &TrackingStatus {
        self.stream.status()
    }

    /// The server's name and version, and the version of its protocol.
    pub fn server(&self) -> String {
        format!("{}, NatNet {}", handshake::application(&self.server), self.server.protocol_version)
    }
}

impl Drop for TrackerClient {
    /// Tells a unicast server not to wait for keep-alives.
    fn drop(&mut self) {
        if self.settings.transport == Transport::Unicast {
            self.send(&command::disconnect_datagram());
        }
    }
}
