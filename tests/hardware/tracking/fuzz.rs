//! Any bytes from anywhere: nothing panics, nothing is believed.

use std::net::SocketAddr;

use natnet::{ModelDef, PlannedBody, ServerInfo, SyntheticServer, Version};
use proptest::prelude::*;
use spinebench::hardware::tracking::{FrameStream, Received, StreamVersion, TrackingSettings};
use spinebench::simulators::SimulatedTracker;

use super::capture;

const SERVER: &str = "127.0.0.1:1510";

fn server(version: Version) -> ServerInfo {
    ServerInfo {
        application_name: "fuzz".into(),
        server_version: version,
        protocol_version: version,
        high_res_clock_frequency: 0,
        connection: natnet::ConnectionInfo {
            data_port: 1511,
            multicast: false,
            multicast_group: [239, 255, 42, 99],
        },
    }
}

fn model() -> ModelDef {
    let body = |name: &str, id| {
        let (name, tail) = (name.to_owned(), vec![0; 4]);
        natnet::DataSet::RigidBody(natnet::RigidBodyDef {
            name,
            id,
            parent_id: -1,
            offset: [0.0; 3],
            tail,
        })
    };
    ModelDef { datasets: vec![body("base", 1), body("tip", 2)] }
}

fn stream(version: Version) -> FrameStream {
    FrameStream::new(&TrackingSettings::default(), &server(version), Some(&model())).unwrap()
}

/// A frame, the list of bodies and the server's introduction.
fn good(version: Version) -> Vec<Vec<u8>> {
    let bodies = [1, 2].map(|id| PlannedBody::tracked(id, [0.1, 0.2, 0.3], [0.0, 0.0, 0.0, 1.0]));
    let synthetic = SyntheticServer::new(version, 1000);
    let frame = synthetic.datagram(5, 1.0, &bodies).unwrap();
    vec![frame, model().to_datagram(version).unwrap(), server(version).to_datagram().unwrap()]
}

/// What the stream believes is a pose.
fn is_sane(stream: &FrameStream) {
    if let Some(tip) = stream.latest() {
        let length2: f64 = tip.quaternion.iter().map(|value| value * value).sum();
        assert!(tip.time_s.is_finite() && tip.position_m.iter().all(|value| value.abs() < 1e4));
        assert!((length2 - 1.0).abs() < 1e-9 && tip.quaternion[0] >= 0.0);
    }
}

fn version() -> impl Strategy<Value = Version> {
    prop::sample::select(SimulatedTracker::VERSIONS.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn any_bytes(version in version(), id in 0_u16..16, bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let mut stream = stream(version);
        let from: SocketAddr = SERVER.parse().unwrap();
        stream.process(&bytes, from, 0.0);
        stream.process(&[&id.to_le_bytes()[..], &bytes].concat(), from, 0.1);
        is_sane(&stream);
    }

    #[test]
    fn broken_messages(
        version in version(),
        which in 0_usize..3,
        cut in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..8), 0..6),
        truncate in any::<bool>(),
    ) {
        let mut datagram = good(version)[which].clone();
        for (at, bit) in flips {
            let at = at.index(datagram.len());
            datagram[at] ^= 1 << bit;
        }
        if truncate {
            datagram.truncate(cut.index(datagram.len()));
        }
        let mut stream = stream(version);
        for k in 0..3 {
            stream.process(&datagram, SERVER.parse().unwrap(), f64::from(k));
        }
        is_sane(&stream);
        if truncate {
            // A list of bodies that ends after its count may be whole; frames and introductions
            // never are.
            prop_assert!(stream.status().valid == 0);
        }
    }

    #[test]
    fn frames_in_any_order(numbers in prop::collection::vec((any::<i32>(), prop::num::f64::ANY, -1e6..1e6), 1..40)) {
        let mut stream = stream(Version::V4_1);
        let bodies = [1, 2].map(|id| PlannedBody::tracked(id, [0.1, 0.2, 0.3], [0.0, 0.0, 0.0, 1.0]));
        for (k, (number, stamp_s, near_s)) in numbers.into_iter().enumerate() {
            let stamp_s = if k % 2 == 0 { stamp_s } else { near_s };
            let frame = SyntheticServer::new(Version::V4_1, 1000).datagram(number, stamp_s, &bodies).unwrap();
            stream.process(&frame, SERVER.parse().unwrap(), k as f64);
            is_sane(&stream);
            let asked = [k as f64, stamp_s].into_iter().filter_map(|time_s| stream.pose_at(time_s));
            prop_assert!(asked.map(|tip| tip.position_m[0]).all(f64::is_finite));
            prop_assert!(stream.status().latency_jitter_s.is_finite());
        }
    }
}

#[test]
fn real_packets_with_any_one_bit_wrong() {
    let folder = capture::folder();
    let settings = TrackingSettings {
        base_body: None,
        tip_body: spinebench::hardware::tracking::BodyName::Id(2),
        ..Default::default()
    };
    assert_eq!(settings.version, StreamVersion::Auto);
    for name in capture::PACKETS {
        let packet = std::fs::read(folder.join(name)).unwrap();
        for bit in 0..packet.len() * 8 {
            let mut broken = packet.clone();
            broken[bit / 8] ^= 1 << (bit % 8);
            let mut stream =
                FrameStream::new(&settings, &server(Version::new(3, 0, 0, 0)), Some(&model()))
                    .unwrap();
            stream.process(&broken, SERVER.parse().unwrap(), 0.0);
            is_sane(&stream);
        }
        for length in 0..packet.len() {
            let mut stream =
                FrameStream::new(&settings, &server(Version::new(3, 0, 0, 0)), Some(&model()))
                    .unwrap();
            let heard = stream.process(&packet[..length], SERVER.parse().unwrap(), 0.0);
            assert!(!matches!(heard, Received::Frame), "{name} cut to {length} bytes");
        }
    }
}
