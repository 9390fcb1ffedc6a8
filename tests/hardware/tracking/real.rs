//! Recordings of Motive 2.1: one rigid body, NatNet 3.0, 120 Hz.

use std::cell::RefCell;
use std::net::UdpSocket;

use natnet::{Decoder, Message, ModelDef, ServerInfo, Version};
use spinebench::hardware::clock::Clock;
use spinebench::hardware::tracking::{
    BodyName, FrameStream, Received, TrackerClient, TrackingSettings, Transport, UpAxis,
};

use super::bench::{apart, fresh};
use super::capture::{self, CAPTURE, Datagram, PACKETS};

const V3_0: Version = Version::new(3, 0, 0, 0);

fn settings() -> TrackingSettings {
    let tip_body = BodyName::Name("RaceQuad".into());
    let server = [192, 168, 0, 106].into();
    let transport = Transport::Multicast;
    TrackingSettings {
        server,
        transport,
        base_body: None,
        tip_body,
        rate_hz: 120.0,
        up_axis: UpAxis::Z,
        ..Default::default()
    }
}

#[test]
fn every_packet_decodes() {
    let folder = capture::folder();
    let decoder = Decoder::new(V3_0).unwrap();
    for name in PACKETS {
        let packet = std::fs::read(folder.join(name)).unwrap();
        let decoded = decoder.parse(&packet).unwrap();
        match decoded.message() {
            Message::FrameOfData(frame) => {
                // Where a marker is occluded, the others still give the body.
                let occluded = frame.labeled_markers.iter().any(|marker| marker.params & 1 != 0);
                assert!(
                    frame.rigid_bodies[0].tracking_valid() && occluded == name.contains("occluded"),
                    "{name}"
                );
                assert_eq!(decoded.to_datagram().unwrap(), packet);
            }
            Message::ModelDef(model) => {
                assert_eq!(model.rigid_bodies().collect::<Vec<_>>(), [("RaceQuad", 2)])
            }
            Message::ServerInfo(info) => assert_eq!(info.protocol_version, V3_0),
            Message::Other { .. } => {
                assert!(
                    !name.contains("frame") && !name.contains("def_") || name.contains("request")
                )
            }
            _ => panic!("{name}"),
        }
    }
}

fn recording() -> Vec<Datagram> {
    capture::datagrams(&std::fs::read(capture::folder().join(CAPTURE)).unwrap())
}

fn parts(recording: &[Datagram]) -> (ServerInfo, ModelDef) {
    let of = |id: u16| {
        recording.iter().find(|datagram| datagram.payload[..2] == id.to_le_bytes()).unwrap()
    };
    let info = ServerInfo::parse(&of(natnet::NAT_SERVERINFO).payload).unwrap();
    (info, ModelDef::parse(&of(natnet::NAT_MODELDEF).payload, V3_0).unwrap())
}

#[test]
fn a_recording_is_followed() {
    let recording = recording();
    let (info, model) = parts(&recording);
    let mut stream = FrameStream::new(&settings(), &info, Some(&model)).unwrap();
    let (mut poses, mut frames) = (Vec::new(), 0);
    for datagram in &recording {
        if stream.process(&datagram.payload, datagram.from, datagram.time_s) == Received::Frame {
            frames += 1;
            poses.extend(stream.latest().copied());
        }
    }
    let status = stream.status();
    assert_eq!(
        (frames, status.received, status.valid, status.lost),
        (518, 518, 518, 0),
        "{status:?}"
    );
    assert_eq!(
        (status.malformed, status.duplicates, status.out_of_order, status.restarts),
        (0, 0, 0, 0)
    );
    assert!((status.rate_hz.unwrap() - 120.0).abs() < 0.1, "{status:?}");
    assert!(
        status.latency_jitter_s < 0.002 && status.camera_latency_s.is_some_and(|s| s < 0.02),
        "{status:?}"
    );
    for pair in poses.windows(2) {
        let (m, rad) = apart(&pair[0].pose(), &pair[1].pose());
        assert!(m < 0.02 && rad < 0.1, "{m} m, {rad} rad");
    }
    // Every hundredth of a second of it can be asked for, at the end of what is kept.
    let last_s = poses.last().unwrap().time_s;
    let asked =
        (0..300).filter(|k| stream.pose_at(last_s - 0.01 * f64::from(*k)).is_some()).count();
    assert_eq!(asked, 300);
}

/// A server that repeats the recording when somebody waits: its answers to their questions, its
/// frames one by one.
struct Replay {
    socket: UdpSocket,
    recording: Vec<Datagram>,
    next: RefCell<(f64, usize, Option<std::net::SocketAddr>)>,
}

// Only one thread ever waits.
struct OneThread(std::sync::Mutex<Replay>);

impl Clock for OneThread {
    fn now_s(&self) -> f64 {
        self.0.lock().unwrap().next.borrow().0
    }

    fn sleep_until(&self, time_s: f64) {
        let replay = self.0.lock().unwrap();
        let mut next = replay.next.borrow_mut();
        next.0 = time_s;
        let mut request = [0; 2048];
        while let Ok((_, from)) = replay.socket.recv_from(&mut request) {
            next.2 = Some(from);
            let wanted = match u16::from_le_bytes([request[0], request[1]]) {
                natnet::NAT_CONNECT => natnet::NAT_SERVERINFO,
                natnet::NAT_REQUEST_MODELDEF => natnet::NAT_MODELDEF,
                _ => continue,
            };
            let answer = replay
                .recording
                .iter()
                .find(|datagram| datagram.payload[..2] == wanted.to_le_bytes())
                .unwrap();
            replay.socket.send_to(&answer.payload, from).unwrap();
        }
        let start_s = replay.recording[0].time_s;
        while let (Some(datagram), Some(client)) = (replay.recording.get(next.1), next.2) {
            if datagram.time_s - start_s > time_s - 1.0 {
                break;
            }
            if datagram.payload[..2] == natnet::NAT_FRAMEOFDATA.to_le_bytes() {
                replay.socket.send_to(&datagram.payload, client).unwrap();
            }
            next.1 += 1;
        }
    }
}

#[test]
fn a_recording_comes_through_the_sockets() {
    let mut recording = recording();
    // The one byte by which the server says that it streams in multicast.
    const MULTICAST: usize = 4 + 274;
    let introductions = recording.iter_mut().filter(|datagram| datagram.payload[..2] == [1, 0]);
    introductions.for_each(|datagram| datagram.payload[MULTICAST] = 0);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_nonblocking(true).unwrap();
    let port = socket.local_addr().unwrap().port();
    let settings = TrackingSettings {
        server: [127, 0, 0, 1].into(),
        command_port: port,
        transport: Transport::Unicast,
        ..settings()
    };
    let clock = OneThread(std::sync::Mutex::new(Replay {
        socket,
        recording,
        next: RefCell::new((0.0, 0, None)),
    }));
    let mut tracking = TrackerClient::open(settings, &clock).unwrap();
    assert_eq!(tracking.server(), "Motive 2.1.0.0, NatNet 3.0.0.0");
    let mut count = 0;
    for k in 1..2300 {
        let now_s = f64::from(k) * 0.004;
        clock.sleep_until(now_s);
        tracking.poll(now_s);
        count += u32::from(fresh(&tracking, now_s));
    }
    let status = tracking.status();
    assert_eq!(
        (status.valid, status.lost, status.malformed, status.foreign),
        (518, 0, 0, 0),
        "{status:?}"
    );
    assert!(count > 1050, "{count}");
}
