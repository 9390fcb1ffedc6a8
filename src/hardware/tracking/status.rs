//! What a tracker counts while it runs.

use std::net::SocketAddr;

/// Counts since the connection was made, and measures of the stream.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackingStatus {
    /// Frames of our server that decoded, old ones and duplicates included.
    pub received: u64,
    /// Frames that did not come, by their numbers.
    pub lost: u64,
    /// Frames that came after a later one; dropped.
    pub out_of_order: u64,
    /// Frames that came twice; dropped.
    pub duplicates: u64,
    /// Frames with a higher number whose stamp had not gone on; dropped.
    pub stuck_clock: u64,
    /// Datagrams of our server that do not decode.
    pub malformed: u64,
    /// Datagrams of anybody else; dropped.
    pub foreign: u64,
    /// Who sent the last of those.
    pub foreign_source: Option<SocketAddr>,
    /// New frames without a valid pose of both bodies.
    pub occluded: u64,
    /// New frames with a valid pose of both bodies.
    pub valid: u64,
    /// Times that the server began to count its frames again.
    pub restarts: u64,
    /// Times that the list of bodies was read again.
    pub models: u64,
    /// Why the server's frames are of no use at present: bodies that it no longer has, a version that it changed to.
    pub fault: Option<String>,
    /// Frames per second by the server's clock, over the last second or so.
    pub rate_hz: Option<f64>,
    /// Mean delay of the frames beyond the least one, s.
    pub latency_jitter_s: f64,
    /// From mid-exposure to transmission of the last frame by the server's clock, s, where it tells.
    pub camera_latency_s: Option<f64>,
    /// What is the matter with the frames that have come since the last valid one.
    pub unseen: Option<&'static str>,
    /// For how long all numbers of the tip's body have been the same to the last bit, s: real cameras are never so still.
    pub unchanged_s: f64,
    /// Times that they were others than before.
    pub changes: u64,
    /// Times that the system refused to send or receive.
    pub socket_errors: u64,
    /// The last of its reasons.
    pub socket_error: Option<String>,
}

impl TrackingStatus {
    pub(super) fn count_foreign(&mut self, from: SocketAddr) {
        self.foreign += 1;
        self.foreign_source = Some(from);
    }

    pub(super) fn count_socket_error(&mut self, error: &std::io::Error) {
        self.socket_errors += 1;
        self.socket_error = Some(error.to_string());
    }
}
