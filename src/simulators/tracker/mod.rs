//! A simulated motion capture server: NatNet over real UDP on this computer, without threads, with
//! injectable faults.

mod options;
mod server;

use std::collections::VecDeque;
use std::io;
use std::net::Ipv4Addr;

use natnet::{DataSet, FrameOfData, ModelDef, PlannedBody, RigidBodyDef, SyntheticServer, Version};
use rand::RngExt;
use rand_distr::{Distribution, Normal};

pub use options::{TrackedBody, TrackerFault, TrackerOptions};
use server::{CLOCK_HZ, NatNetServer};

use crate::base::{Generator, Seed};
use crate::hardware::tracking::{BodyName, RigidPose, TrackingSettings};

/// Frames that are overdue by more than this are not sent, s.
const OVERDUE_S: f64 = 2.0;

/// Position error of a second server's tip, metres: plausible, so that only the source tells.
const SECOND_SERVER_M: f64 = 0.03;

/// Offset of the second server's frame numbers.
const SECOND_SERVER_FRAMES: i32 = 500_000;

/// Bit of a frame's parameters: the list of bodies has changed.
const MODEL_CHANGED: u16 = 0x02;

/// A server at 127.0.0.1 that advances in [`SimulatedTracker::step`].
pub struct SimulatedTracker {
    options: TrackerOptions,
    server: NatNetServer,
    faults: Vec<TrackerFault>,
    rng: Generator,
    /// Number of the next frame, and its due time by the caller's clock once known.
    number: i32,
    next_s: Option<f64>,
    /// The server's clock minus the caller's, s.
    offset_s: f64,
    clock_from_zero: bool,
    model_changed: bool,
    /// Poses of base and tip at the end of the last step.
    before: Option<(f64, RigidPose, RigidPose)>,
    frozen: Option<Vec<PlannedBody>>,
    frozen_tip: Option<RigidPose>,
    frozen_stamp_s: Option<f64>,
    held: Option<FrameOfData>,
    late: VecDeque<(f64, FrameOfData)>,
}

impl SimulatedTracker {
    /// Supported versions: NatNet 3.0, 3.1, 4.0 and 4.1.
    pub const VERSIONS: [Version; 4] = [
        Version::new(3, 0, 0, 0),
        Version::new(3, 1, 0, 0),
        Version::new(4, 0, 0, 0),
        Version::V4_1,
    ];

    /// Opens the server's sockets.
    ///
    /// # Errors
    /// When the system refuses one of them.
    pub fn new(options: TrackerOptions) -> io::Result<SimulatedTracker> {
        Ok(SimulatedTracker {
            server: NatNetServer::open(&options)?,
            faults: Vec::new(),
            rng: options.seed.child("tracker").rng(),
            number: options.first_frame,
            next_s: None,
            offset_s: options.clock_offset_s,
            clock_from_zero: false,
            model_changed: false,
            before: None,
            frozen: None,
            frozen_tip: None,
            frozen_stamp_s: None,
            held: None,
            late: VecDeque::new(),
            options,
        })
    }

    /// Settings for a client of this server, except for the mounting.
    ///
    /// # Errors
    /// When the system does not provide the ports.
    pub fn settings(&self) -> io::Result<TrackingSettings> {
        let (command_port, data_port) = self.server.ports()?;
        Ok(TrackingSettings {
            server: Ipv4Addr::LOCALHOST,
            command_port,
            data_port,
            transport: self.options.transport,
            multicast_group: self.options.multicast_group,
            interface: Ipv4Addr::LOCALHOST,
            base_body: Some(BodyName::Name(self.options.base.0.clone())),
            tip_body: BodyName::Name(self.options.tip.0.clone()),
            rate_hz: self.options.rate_hz,
            ..TrackingSettings::default()
        })
    }

    /// Injects a fault, or replaces the one of its kind.
    pub fn inject(&mut self, fault: TrackerFault) {
        if fault == TrackerFault::Restart {
            self.server.forget_clients();
            self.late.clear();
            (self.number, self.next_s, self.held) = (1, None, None);
            self.clock_from_zero = true;
            return;
        }
        self.model_changed |= fault == TrackerFault::BodyGone;
        self.faults.retain(|other| std::mem::discriminant(other) != std::mem::discriminant(&fault));
        self.faults.push(fault);
    }

    /// Draws noise and losses from `seed` from now on.
    pub fn reseed(&mut self, seed: Seed) {
        self.rng = seed.child("tracker").rng();
    }

    /// Clears all faults.
    pub fn clear_faults(&mut self) {
        self.model_changed |= self.has(TrackerFault::BodyGone);
        self.faults.clear();
        (self.held, self.frozen, self.frozen_tip, self.frozen_stamp_s) = (None, None, None, None);
    }

    /// Answers requests and sends the frames that are due by `now_s`. The bodies are at `tip` and
    /// `base` in Motive's frame at `now_s`, and have moved there uniformly since the last call.
    pub fn step(&mut self, now_s: f64, tip: &RigidPose, base: &RigidPose) {
        let silent = self.has(TrackerFault::Silent);
        let model = (!self.has(TrackerFault::Undescribed)).then(|| self.model());
        self.server.answer(now_s, model.as_ref(), silent);
        let (before_s, base_before, tip_before) =
            self.before.replace((now_s, *base, *tip)).unwrap_or((now_s, *base, *tip));
        if std::mem::take(&mut self.clock_from_zero) {
            self.offset_s = -now_s;
        }
        let mut due_s = self.next_s.unwrap_or(now_s);
        while due_s <= now_s {
            let share = if now_s > before_s {
                ((due_s - before_s) / (now_s - before_s)).clamp(0.0, 1.0)
            } else {
                1.0
            };
            if !silent && now_s - due_s <= OVERDUE_S {
                self.capture_frame(
                    due_s,
                    base_before.towards(base, share),
                    tip_before.towards(tip, share),
                );
            }
            self.number = self.number.wrapping_add(1);
            due_s += 1.0 / self.options.rate_hz;
        }
        self.next_s = Some(due_s);
        while self.late.front().is_some_and(|(time_s, _)| *time_s <= now_s) {
            if let Some((_, frame)) = self.late.pop_front() {
                self.send(&frame);
            }
        }
    }

    fn has(&self, fault: TrackerFault) -> bool {
        self.faults.contains(&fault)
    }

    fn amount(&self, which: impl Fn(&TrackerFault) -> Option<f64>) -> Option<f64> {
        self.faults.iter().find_map(which)
    }

    /// The list of bodies.
    fn model(&self) -> ModelDef {
        let gone = self.has(TrackerFault::BodyGone);
        let tip = (!gone).then_some(&self.options.tip);
        let bodies = [&self.options.base].into_iter().chain(tip).chain(&self.options.others);
        let datasets = bodies.map(|(name, id)| {
            DataSet::RigidBody(RigidBodyDef {
                name: name.clone(),
                id: *id,
                parent_id: -1,
                offset: [0.0; 3],
                // No markers.
                tail: vec![0; 4],
            })
        });
        ModelDef { datasets: datasets.collect() }
    }

    /// Captures a frame at `time_s` and sends it, subject to the injected faults.
    fn capture_frame(&mut self, time_s: f64, base: RigidPose, tip: RigidPose) {
        let mut stamp_s = time_s + self.offset_s;
        if self.has(TrackerFault::FrozenClock) {
            stamp_s = *self.frozen_stamp_s.get_or_insert(stamp_s);
        }
        let mut bodies = self.bodies(base, tip);
        if self.has(TrackerFault::Frozen) {
            bodies = self.frozen.get_or_insert(bodies).clone();
        }
        let number = if self.has(TrackerFault::Descending) {
            self.number.wrapping_neg()
        } else {
            self.number
        };
        let mut frame =
            SyntheticServer::new(self.options.version, CLOCK_HZ).frame(number, stamp_s, &bodies);
        if std::mem::take(&mut self.model_changed) {
            frame.params |= MODEL_CHANGED;
        }
        let loss =
            self.amount(
                |fault| if let TrackerFault::Loss(share) = fault { Some(*share) } else { None },
            );
        let in_gap = self.faults.iter().any(|fault| {
            matches!(fault, TrackerFault::Gaps { every_s, lasting_s } if time_s.rem_euclid(*every_s) < *lasting_s)
        });
        if self.rng.random::<f64>() < loss.unwrap_or(self.options.loss) || in_gap {
            return;
        }
        if !self.has(TrackerFault::OutOfOrder) {
            self.deliver(time_s, frame);
        } else if let Some(earlier) = self.held.take() {
            self.deliver(time_s, frame);
            self.deliver(time_s, earlier);
        } else {
            self.held = Some(frame);
        }
    }

    fn bodies(&mut self, base: RigidPose, tip: RigidPose) -> Vec<PlannedBody> {
        let noise_m = self.options.noise_m;
        let (mut base, mut tip) = (self.noisy(base, noise_m), self.noisy(tip, noise_m));
        if let Some(m) = self
            .amount(|fault| if let TrackerFault::FrozenTip(m) = fault { Some(*m) } else { None })
        {
            let frozen = *self.frozen_tip.get_or_insert(tip);
            (tip, base) = (self.noisy(frozen, m), self.noisy(base, m));
        }
        tip.position_m[0] += self
            .amount(|fault| if let TrackerFault::Jump(m) = fault { Some(*m) } else { None })
            .unwrap_or(0.0);
        if self.has(TrackerFault::NanPose) {
            tip.position_m = [f64::NAN; 3];
        }
        if self.has(TrackerFault::ZeroQuaternion) {
            tip.quaternion = [0.0; 4];
        }
        if self.has(TrackerFault::SwappedBodies) {
            std::mem::swap(&mut base, &mut tip);
        }
        let planned_body = |body, id, pose: &RigidPose| PlannedBody {
            tracking_valid: !self.has(TrackerFault::Occluded(body)),
            ..planned(id, pose)
        };
        let mut bodies = vec![planned_body(TrackedBody::Base, self.options.base.1, &base)];
        if !self.has(TrackerFault::BodyGone) {
            bodies.push(planned_body(TrackedBody::Tip, self.options.tip.1, &tip));
        }
        bodies
            .extend(self.options.others.iter().map(|(_, id)| planned(*id, &RigidPose::default())));
        bodies
    }

    fn noisy(&mut self, mut pose: RigidPose, noise_m: f64) -> RigidPose {
        if noise_m > 0.0
            && let Ok(normal) = Normal::new(0.0, noise_m)
        {
            pose.position_m.iter_mut().for_each(|value| *value += normal.sample(&mut self.rng));
        }
        pose
    }

    fn deliver(&mut self, time_s: f64, frame: FrameOfData) {
        if let Some(max_delay_s) =
            self.amount(|fault| if let TrackerFault::Jitter(s) = fault { Some(*s) } else { None })
        {
            let due_s = time_s + max_delay_s * self.rng.random::<f64>();
            let place = self.late.partition_point(|(earlier_s, _)| *earlier_s <= due_s);
            self.late.insert(place, (due_s, frame));
            return;
        }
        let late_s =
            self.amount(|fault| if let TrackerFault::Late(s) = fault { Some(*s) } else { None });
        if let Some(late_s) = late_s {
            self.late.push_back((time_s + late_s, frame));
            return;
        }
        self.send(&frame);
        if self.has(TrackerFault::Duplicate) {
            self.send(&frame);
        }
    }

    fn send(&mut self, frame: &FrameOfData) {
        if self.send_from_same_address(frame) {
            return;
        }
        let malformed = self.has(TrackerFault::Malformed);
        let rng = &mut self.rng;
        self.server.send(frame, false, &mut |datagram| {
            if malformed {
                datagram.truncate(rng.random_range(0..datagram.len()));
            }
        });
        if self.has(TrackerFault::SecondServer) {
            let mut other = frame.clone();
            other.frame_number = other.frame_number.wrapping_add(SECOND_SERVER_FRAMES);
            self.displace_tip(&mut other);
            self.server.send(&other, true, &mut |_| {});
        }
    }

    /// Sends the frame of a second server at the same address and port, if there is one; true if it
    /// is alone.
    fn send_from_same_address(&mut self, frame: &FrameOfData) -> bool {
        let second = self.faults.iter().find_map(|fault| match *fault {
            TrackerFault::SameAddress { frames, clock_s, alone } => Some((frames, clock_s, alone)),
            _ => None,
        });
        let Some((frames, clock_s, alone)) = second else { return false };
        let mut other = frame.clone();
        other.frame_number = other.frame_number.wrapping_add(frames);
        other.timing.timestamp += clock_s;
        self.displace_tip(&mut other);
        self.server.send(&other, false, &mut |_| {});
        alone
    }

    fn displace_tip(&self, frame: &mut FrameOfData) {
        let tips = frame.rigid_bodies.iter_mut().filter(|body| body.id == self.options.tip.1);
        tips.for_each(|body| body.position[0] += SECOND_SERVER_M as f32);
    }
}

fn planned(id: i32, pose: &RigidPose) -> PlannedBody {
    let [w, x, y, z] = pose.quaternion.map(|value| value as f32);
    PlannedBody::tracked(id, pose.position_m.map(|value| value as f32), [x, y, z, w])
}
