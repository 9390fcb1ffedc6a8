//! Counts and measures of the tracking.

use std::net::SocketAddr;

use super::sequence_numbers::FrameStamp;

/// Counts since the connection was made, and measures of the stream.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackingStatus {
    /// Decoded frames of our server, including old and duplicate ones.
    pub received: u64,
    /// Missing frames, by their numbers.
    pub lost: u64,
    /// Frames that arrived after a later one; dropped.
    pub out_of_order: u64,
    /// Frames that arrived twice; dropped.
    pub duplicates: u64,
    /// Frames with a higher number but an old time stamp; dropped.
    pub stuck_clock: u64,
    /// Undecodable datagrams of our server.
    pub malformed: u64,
    /// Datagrams of other senders; dropped.
    pub foreign: u64,
    /// Sender of the last of those.
    pub foreign_source: Option<SocketAddr>,
    /// Frames from our server's address and port with another count or another clock: a second
    /// server streams there.
    pub second_source: u64,
    /// The last of those: when it came, s, and how it differs.
    pub second_source_last: Option<(f64, String)>,
    /// Share of lost frames among the last 256; none before there are as many.
    pub recent_loss: Option<f64>,
    /// New frames without a valid pose of both bodies.
    pub occluded: u64,
    /// New frames with a valid pose of both bodies.
    pub valid: u64,
    /// Restarts of the server's frame count.
    pub restarts: u64,
    /// Times that the list of bodies was read again.
    pub models: u64,
    /// Why the server's frames cannot be used now: missing bodies, or a changed version.
    pub fault: Option<String>,
    /// Frames per second by the server's clock, over the last 128 frames.
    pub rate_hz: Option<f64>,
    /// Mean delay of the frames beyond the smallest one, s.
    pub latency_jitter_s: f64,
    /// Time from mid-exposure to transmission of the last frame by the server's clock, s, if the
    /// server reports it.
    pub camera_latency_s: Option<f64>,
    /// What is wrong with the frames since the last valid one.
    pub unseen: Option<&'static str>,
    /// How long all values of the tip's body have been identical to the last bit, s: real cameras
    /// are never that still.
    pub unchanged_s: f64,
    /// Number of changes of those values.
    pub changes: u64,
    /// Errors of the sockets.
    pub socket_errors: u64,
    /// The last of them.
    pub socket_error: Option<String>,
}

impl TrackingStatus {
    pub(super) fn count_foreign(&mut self, from: SocketAddr) {
        self.foreign += 1;
        self.foreign_source = Some(from);
    }

    pub(super) fn count_second_source(
        &mut self,
        from: SocketAddr,
        stamp: FrameStamp,
        last: Option<&FrameStamp>,
        now_s: f64,
    ) {
        self.second_source += 1;
        let after =
            last.map(|last| format!(" after {} stamped {:.2} s", last.number, last.stamp_s));
        let found = format!(
            "frame {} stamped {:.2} s{}",
            stamp.number,
            stamp.stamp_s,
            after.unwrap_or_default()
        );
        self.second_source_last = Some((now_s, format!("{found}, both from {from}")));
    }

    pub(super) fn count_socket_error(&mut self, error: &std::io::Error) {
        self.socket_errors += 1;
        self.socket_error = Some(error.to_string());
    }
}
