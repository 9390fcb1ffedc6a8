//! Servers that track much besides the robot.

use std::net::SocketAddr;

use natnet::{
    Asset, ConnectionInfo, FrameOfData, LabeledMarker, MarkerSet, ModelDef, PlannedBody,
    RawSection, RigidBody, ServerInfo, Skeleton, SyntheticServer, Version,
};
use spinebench::base::distance_m;
use spinebench::hardware::tracking::{BodyName, FrameStream, Received, TrackingSettings};
use spinebench::simulators::SimulatedTracker;

const CLOCK_HZ: u64 = 10_000_000;

fn server(version: Version) -> ServerInfo {
    ServerInfo {
        application_name: "Another".into(),
        server_version: Version::new(2, 0, 0, 0),
        protocol_version: version,
        high_res_clock_frequency: CLOCK_HZ,
        connection: ConnectionInfo {
            data_port: 1511,
            multicast: false,
            multicast_group: [239, 255, 42, 99],
        },
    }
}

/// Bones and parts of assets have the numbers of the robot's bodies: each kind counts for itself.
fn bone(id: i32) -> RigidBody {
    RigidBody {
        id,
        position: [9.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        mean_marker_error: 0.0,
        params: 1,
    }
}

fn crowd(version: Version, mut frame: FrameOfData) -> FrameOfData {
    let marker =
        |id| LabeledMarker { id, position: [0.5; 3], size: 0.014, params: 0, residual: 1e-4 };
    frame.marker_sets = vec![
        MarkerSet { name: "tip".into(), markers: vec![[0.1, 0.2, 0.3]; 5] },
        MarkerSet { name: "all".into(), markers: Vec::new() },
    ];
    frame.other_markers = vec![[1.0, 2.0, 3.0]; 40];
    frame.labeled_markers = (0..25).map(marker).collect();
    let skeletons = [Skeleton { id: 1, rigid_bodies: vec![bone(1), bone(2)] }];
    frame.skeletons = RawSection::from_skeletons(&skeletons).unwrap();
    if version == Version::V4_1 {
        let assets =
            [Asset { id: 2, rigid_bodies: vec![bone(1), bone(2)], markers: vec![marker(2)] }];
        frame.assets = RawSection::from_assets(&assets).unwrap();
    }
    frame
}

#[test]
fn markers_skeletons_and_assets_are_not_the_robots_bodies() {
    let from: SocketAddr = "127.0.0.1:1511".parse().unwrap();
    let settings = TrackingSettings {
        base_body: None,
        tip_body: BodyName::Id(2),
        ..TrackingSettings::default()
    };
    for version in SimulatedTracker::VERSIONS {
        let mut stream = FrameStream::new(&settings, &server(version), None::<&ModelDef>).unwrap();
        for k in 0..20 {
            let time_s = 0.01 * f64::from(k);
            let bodies = [
                PlannedBody::tracked(40, [4.0; 3], [0.0, 0.0, 0.0, 1.0]),
                PlannedBody::tracked(2, [0.25, 0.5, 0.125 * k as f32], [0.0, 0.0, 0.0, 1.0]),
                PlannedBody::tracked(1, [3.0; 3], [0.0, 0.0, 0.0, 1.0]),
            ];
            let frame = SyntheticServer::new(version, CLOCK_HZ).frame(k + 1, time_s, &bodies);
            let datagram = crowd(version, frame).to_datagram(version).unwrap();
            assert_eq!(stream.process(&datagram, from, time_s), Received::Frame, "{version}");
            let tip = stream.latest().unwrap().position_m;
            let expected = [0.5, -0.25, 0.125 * f64::from(k)];
            assert!(distance_m(&tip, &expected) < 1e-12, "{version}: {tip:?}");
        }
        assert_eq!((stream.status().valid, stream.status().malformed), (20, 0), "{version}");
    }
}

/// A server whose frames are of no use says why by them.
#[test]
fn frames_of_no_use_are_named() {
    let from: SocketAddr = "127.0.0.1:1511".parse().unwrap();
    let settings = TrackingSettings {
        base_body: None,
        tip_body: BodyName::Id(2),
        ..TrackingSettings::default()
    };
    let unseen = |frames: &dyn Fn(i32) -> (i32, f64, PlannedBody)| {
        let mut stream = FrameStream::new(&settings, &server(Version::V4_1), None).unwrap();
        for k in 1..30 {
            let (number, stamp_s, body) = frames(k);
            let frame =
                SyntheticServer::new(Version::V4_1, CLOCK_HZ).frame(number, stamp_s, &[body]);
            stream.process(&frame.to_datagram(Version::V4_1).unwrap(), from, 0.01 * f64::from(k));
        }
        stream.status().unseen
    };
    let tip = |id| PlannedBody::tracked(id, [0.1; 3], [0.0, 0.0, 0.0, 1.0]);
    let stamp_s = |k| 0.01 * f64::from(k);
    assert_eq!(unseen(&|k| (k, stamp_s(k), tip(2))), None);
    assert_eq!(unseen(&|k| (k, 0.0, tip(2))), Some("frames whose time stamps do not increase"));
    assert_eq!(
        unseen(&|k| (7, stamp_s(k), tip(2))),
        Some("frames with the number of the previous one")
    );
    assert_eq!(unseen(&|k| (k, 1e13 + stamp_s(k), tip(2))), Some("invalid time stamps"));
    assert_eq!(unseen(&|k| (k, stamp_s(k), tip(3))), Some("frames without the tip's body"));
    let lost = PlannedBody { tracking_valid: false, ..tip(2) };
    assert_eq!(unseen(&|k| (k, stamp_s(k), lost)), Some("the tip is not tracked"));
}
