//! From datagrams to samples: the client without its sockets.

use std::collections::VecDeque;
use std::net::{SocketAddr, SocketAddrV4};

use natnet::{Decoder, FrameOfData, Message, MessageHeader, ModelDef, ParsePolicy, ServerInfo};

use super::bodies::TrackedBodies;
use super::clock_sync::ClockSync;
use super::fault::TrackingFault;
use super::handshake;
use super::mounting::Mounting;
use super::peer_filter::PeerFilter;
use super::pose::{RigidPose, TipPose};
use super::recent_losses::RecentLosses;
use super::sequence_numbers::{FrameOrder, FrameSequence, FrameStamp};
use super::settings::TrackingSettings;
use super::status::TrackingStatus;
use super::tip_buffer::TipBuffer;
use crate::base::Point3;

/// Number of frames over which the rate is measured.
const RATE_FRAMES: usize = 128;

/// Bit of a frame's parameters: the list of bodies has changed.
const MODEL_CHANGED: u16 = 0x02;

/// Largest valid time stamp, s: three centuries, since the server's start or since 1970.
const MAX_STAMP_S: f64 = 1e10;

/// Time without a sample, s, after which unusable frames are reported as its reason.
const UNSEEN_S: f64 = 0.04;

/// Largest plausible camera latency, s.
const MAX_CAMERA_LATENCY_S: f64 = 10.0;

/// Kind of a processed datagram.
#[derive(Clone, Debug, PartialEq)]
pub enum Received {
    /// Nothing of use: foreign, malformed, or of another kind.
    Nothing,
    /// A frame of our server; added to the samples unless it was old.
    Frame,
    /// The identity of our server.
    Server(ServerInfo),
    /// The list of bodies of our server.
    Model(ModelDef),
}

/// The frame stream of one server: takes datagrams, returns poses.
pub struct FrameStream {
    settings: TrackingSettings,
    decoder: Decoder,
    clock_hz: u64,
    peer_filter: PeerFilter,
    bodies: Option<TrackedBodies>,
    mounting: Mounting,
    sequence: FrameSequence,
    clock_sync: ClockSync,
    samples: TipBuffer,
    recent_stamps: VecDeque<FrameStamp>,
    losses: RecentLosses,
    /// The tip's body when it was last tracked, and the stamp since when it has not changed.
    unchanged: Option<(RigidPose, f64)>,
    wants_model: bool,
    status: TrackingStatus,
}

impl FrameStream {
    /// A stream of a server that has announced its identity and its bodies; the bodies are not
    /// needed if both are given by their streaming ids.
    ///
    /// # Errors
    /// [`TrackingFault`] for an unsupported version, or bodies that are missing or not unique.
    pub fn new(
        settings: &TrackingSettings,
        server: &ServerInfo,
        model: Option<&ModelDef>,
    ) -> Result<FrameStream, TrackingFault> {
        let command = SocketAddrV4::new(settings.server, settings.command_port);
        Ok(FrameStream {
            decoder: decoder(settings, server)?,
            clock_hz: server.high_res_clock_frequency,
            peer_filter: PeerFilter::new(command, server.connection.data_port),
            bodies: Some(TrackedBodies::find(settings, model)?),
            mounting: Mounting::of(settings),
            sequence: FrameSequence::new(settings.rate_hz),
            clock_sync: ClockSync::default(),
            samples: TipBuffer::new(1.0 / settings.rate_hz),
            recent_stamps: VecDeque::with_capacity(RATE_FRAMES),
            losses: RecentLosses::default(),
            unchanged: None,
            wants_model: false,
            status: TrackingStatus::default(),
            settings: settings.clone(),
        })
    }

    /// Processes one datagram, received from `from` at local time `now_s`. Any bytes are accepted.
    pub fn process(&mut self, datagram: &[u8], from: SocketAddr, now_s: f64) -> Received {
        // The sender is checked by kind before anything is decoded.
        let id = MessageHeader::parse(datagram).map_or(u16::MAX, |header| header.message_id);
        let ours = match id {
            natnet::NAT_FRAMEOFDATA => self.peer_filter.accepts_frames(from),
            natnet::NAT_SERVERINFO | natnet::NAT_MODELDEF => self.peer_filter.accepts_answers(from),
            _ => self.peer_filter.is_same_host(from),
        };
        if !ours {
            self.status.count_foreign(from);
            return Received::Nothing;
        }
        let Ok(decoded) = self.decoder.parse(datagram) else {
            self.status.malformed += 1;
            self.status.unseen = Some("unreadable frames");
            return Received::Nothing;
        };
        match decoded.into_message() {
            Message::FrameOfData(frame) => self.take_frame(&frame, from, now_s),
            Message::ServerInfo(info) => Received::Server(info),
            Message::ModelDef(model) => Received::Model(model),
            _ => Received::Nothing,
        }
    }

    fn take_frame(&mut self, frame: &FrameOfData, from: SocketAddr, now_s: f64) -> Received {
        let stamp = FrameStamp { number: frame.frame_number, stamp_s: frame.timing.timestamp };
        if !stamp.stamp_s.is_finite() || stamp.stamp_s.abs() > MAX_STAMP_S {
            self.status.malformed += 1;
            self.status.unseen = Some("invalid time stamps");
            return Received::Nothing;
        }
        self.peer_filter.set_frames_port(from);
        self.status.received += 1;
        let present_s = self.clock_sync.present_stamp_s(now_s);
        let order = self.sequence.classify(stamp, now_s, present_s);
        let (rejected_count, why) = match order {
            // Not of our server: silence of ours must be noticed.
            FrameOrder::Foreign => {
                self.status.count_second_source(from, stamp, self.recent_stamps.back(), now_s);
                return Received::Nothing;
            }
            FrameOrder::New { lost } => {
                self.status.lost += lost;
                self.losses.add(lost);
                self.status.recent_loss = self.losses.share();
                self.take_new(frame, stamp, now_s);
                return Received::Frame;
            }
            FrameOrder::Restart => {
                self.restart();
                self.take_new(frame, stamp, now_s);
                return Received::Frame;
            }
            FrameOrder::Duplicate => {
                (&mut self.status.duplicates, "frames with the number of the previous one")
            }
            FrameOrder::Old => {
                (&mut self.status.out_of_order, "frames with lower numbers than the previous one")
            }
            FrameOrder::StuckClock => {
                (&mut self.status.stuck_clock, "frames whose time stamps do not increase")
            }
        };
        *rejected_count += 1;
        if order == FrameOrder::Old {
            self.losses.arrived_late();
        }
        // While other frames are valid, these do no harm.
        if self.samples.latest().is_none_or(|tip| now_s - tip.time_s > UNSEEN_S) {
            self.status.unseen = Some(why);
        }
        Received::Frame
    }

    /// Discards everything that depends on the server's frame numbers and clock.
    fn restart(&mut self) {
        self.status.restarts += 1;
        self.clock_sync = ClockSync::default();
        self.samples.clear();
        self.recent_stamps.clear();
        self.losses = RecentLosses::default();
        self.unchanged = None;
        self.wants_model = true;
    }

    fn take_new(&mut self, frame: &FrameOfData, stamp: FrameStamp, now_s: f64) {
        let offset_s = self.clock_sync.update(stamp.stamp_s, now_s);
        // Before the sample is added: its local time needs the newest offset.
        self.samples.set_offset(offset_s);
        self.status.latency_jitter_s = self.clock_sync.jitter_s();
        self.measure(frame, stamp);
        self.wants_model |= frame.params & MODEL_CHANGED != 0;
        self.wants_model |= self.bodies.is_none_or(|bodies| !bodies.are_in(frame));
        let Some((base, tip)) = self.bodies.and_then(|bodies| bodies.poses(frame)) else {
            self.status.occluded += 1;
            self.status.unseen = self.bodies.map(|bodies| bodies.unseen(frame));
            return;
        };
        self.status.valid += 1;
        self.status.unseen = None;
        self.samples.push(stamp.stamp_s, self.mounting.tip(&base, &tip));
        let unchanged_since_s =
            self.unchanged.filter(|unchanged| unchanged.0 == tip).map(|unchanged| unchanged.1);
        self.status.changes += u64::from(unchanged_since_s.is_none());
        let since_s = unchanged_since_s.unwrap_or(stamp.stamp_s);
        self.unchanged = Some((tip, since_s));
        self.status.unchanged_s = stamp.stamp_s - since_s;
    }

    fn measure(&mut self, frame: &FrameOfData, stamp: FrameStamp) {
        if self.recent_stamps.len() == RATE_FRAMES {
            self.recent_stamps.pop_front();
        }
        self.recent_stamps.push_back(stamp);
        let first = self.recent_stamps.front().unwrap_or(&stamp);
        let (frames, time_s) =
            (stamp.number.wrapping_sub(first.number), stamp.stamp_s - first.stamp_s);
        self.status.rate_hz = (time_s > 0.0).then(|| f64::from(frames) / time_s);
        let (exposed, sent) = (frame.timing.camera_mid_exposure, frame.timing.transmit);
        let latency_s = sent.saturating_sub(exposed) as f64 / self.clock_hz.max(1) as f64;
        // Servers that do not report it send zeros.
        let reported = exposed > 0 && sent >= exposed && latency_s < MAX_CAMERA_LATENCY_S;
        self.status.camera_latency_s = reported.then_some(latency_s);
    }

    /// Takes the answer to a new handshake: the server may have restarted with other ports,
    /// versions and bodies.
    pub(super) fn reconnect(&mut self, server: &ServerInfo, now_s: f64) {
        match decoder(&self.settings, server) {
            Ok(decoder) => self.decoder = decoder,
            Err(fault) => {
                self.status.fault = Some(fault.to_string());
                return;
            }
        }
        self.clock_hz = server.high_res_clock_frequency;
        self.peer_filter.reconnect(server.connection.data_port);
        // Frames that have been refused as another source's do not become ours because ours are
        // silent.
        let refused = self
            .status
            .second_source_last
            .as_ref()
            .is_some_and(|(then_s, _)| now_s - then_s < UNSEEN_S);
        if !refused {
            self.sequence.expect_restart();
        }
        self.wants_model = true;
    }

    /// Takes the server's present list of bodies.
    pub(super) fn set_model(&mut self, model: &ModelDef) {
        self.wants_model = false;
        self.status.models += 1;
        let bodies = TrackedBodies::find(&self.settings, Some(model));
        self.status.fault = bodies.as_ref().err().map(ToString::to_string);
        self.bodies = bodies.ok();
    }

    /// True if the list of bodies has to be requested.
    pub(super) fn wants_model(&self) -> bool {
        self.wants_model
    }

    /// The tip at a local time, s: interpolated between the valid samples before and after if they
    /// are at most 2.5 frame periods apart, else the sample before if it is at most one period old,
    /// else none.
    pub fn pose_at(&self, time_s: f64) -> Option<TipPose> {
        self.samples.at(time_s)
    }

    /// Mean tip position of the valid samples since a local time, metres.
    pub fn mean_since(&self, since_s: f64) -> Option<Point3> {
        self.samples.mean_since(since_s)
    }

    /// The newest valid sample.
    pub fn latest(&self) -> Option<&TipPose> {
        self.samples.latest()
    }

    /// Counts so far.
    pub fn status(&self) -> &TrackingStatus {
        &self.status
    }

    pub(super) fn status_mut(&mut self) -> &mut TrackingStatus {
        &mut self.status
    }
}

/// Unread sections may be of a newer Motive than the decoder knows.
fn decoder(settings: &TrackingSettings, server: &ServerInfo) -> Result<Decoder, TrackingFault> {
    let version = handshake::version(settings, server)?;
    match Decoder::new(version) {
        Ok(decoder) => Ok(decoder.with_policy(ParsePolicy::Compatible)),
        Err(_) => Err(handshake::unreadable_version(server, version)),
    }
}
