//! Connections that are refused, and what the lab reads then.

use std::net::UdpSocket;

use natnet::Version;
use spinebench::hardware::tracking::{
    BodyName, StreamVersion, TrackingFault, TrackingSettings, Transport,
};
use spinebench::simulators::{TrackerFault, TrackerOptions};

use super::bench::{Bench, at_rest};

fn refused(options: TrackerOptions, change: impl Fn(&mut TrackingSettings)) -> String {
    let bench = Bench::with(options, at_rest, change);
    bench.open().err().unwrap().to_string()
}

#[test]
fn no_server() {
    let bench = Bench::new(TrackerOptions::default(), at_rest);
    bench.inject(TrackerFault::Silent);
    let fault = bench.open().err().unwrap();
    assert!(matches!(fault, TrackingFault::NoServer { .. }), "{fault}");
    assert!(
        fault.to_string().contains("within 2 s") && fault.to_string().contains("start Motive"),
        "{fault}"
    );

    // A port that nobody listens on.
    let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let text = refused(TrackerOptions::default(), |settings| settings.command_port = free);
    assert!(text.contains(&format!("127.0.0.1:{free}")), "{text}");
}

#[test]
fn wrong_bodies() {
    let missing = refused(TrackerOptions::default(), |settings| {
        settings.tip_body = BodyName::Name("Tip".into())
    });
    assert!(
        missing.contains("no rigid body 'Tip'") && missing.contains("'tip' (id 2)"),
        "{missing}"
    );
    let missing =
        refused(TrackerOptions::default(), |settings| settings.base_body = Some(BodyName::Id(9)));
    assert!(missing.contains("streaming id 9") && missing.contains("base_body"), "{missing}");
    let shared =
        refused(TrackerOptions::default(), |settings| settings.base_body = Some(BodyName::Id(2)));
    assert!(shared.contains("the same rigid body, streaming id 2"), "{shared}");
    let others = vec![("tip".into(), 8)];
    let double = refused(TrackerOptions { others, ..Default::default() }, |_| {});
    assert!(double.contains("2 rigid bodies 'tip'"), "{double}");
    let others = vec![("table".into(), 2)];
    let double = refused(TrackerOptions { others, ..Default::default() }, |_| {});
    assert!(double.contains("2 rigid bodies streaming id 2"), "{double}");
}

#[test]
fn wrong_transport_or_version() {
    let text =
        refused(TrackerOptions::default(), |settings| settings.transport = Transport::Multicast);
    assert!(text.contains("streams by Unicast") && text.contains("expected Multicast"), "{text}");
    let options = TrackerOptions { transport: Transport::Multicast, ..Default::default() };
    let text = refused(options.clone(), |settings| settings.data_port = 1);
    assert!(text.contains("239.255.42.99:1;"), "{text}");
    let text = refused(options, |settings| settings.version = StreamVersion::V3_0);
    assert!(text.contains("streams NatNet 4.1.0.0, expected 3.0"), "{text}");
}

#[test]
fn bodies_set_by_their_ids_need_no_description() {
    let ids = |settings: &mut TrackingSettings| {
        (settings.base_body, settings.tip_body) = (Some(BodyName::Id(1)), BodyName::Id(2));
    };
    let bench = Bench::with(TrackerOptions::default(), at_rest, ids);
    bench.inject(TrackerFault::Undescribed);
    let mut tracking = bench.open().unwrap();
    let (m, _, fresh) = bench.judge(&mut tracking, 1.0);
    assert!(m < super::WIRE_M && fresh > 0.98, "{m} {fresh}");

    let bench = Bench::new(TrackerOptions::default(), at_rest);
    bench.inject(TrackerFault::Undescribed);
    let fault = bench.open().err().unwrap();
    assert!(matches!(fault, TrackingFault::NoModel { .. }), "{fault}");
}

#[test]
fn a_unicast_server_is_asked_for_the_version() {
    let options = TrackerOptions { version: Version::V4_1, ..Default::default() };
    let bench = Bench::with(options, at_rest, |settings| settings.version = StreamVersion::V3_0);
    let mut tracking = bench.open().unwrap();
    let (_, _, fresh) = bench.judge(&mut tracking, 1.0);
    assert!(fresh > 0.98 && tracking.status().malformed == 0);
    assert_eq!(tracking.server(), "Simulated tracker 1.0.0.0, NatNet 4.1.0.0");
}

#[test]
fn settings_are_read_and_checked() {
    let text = "server: 192.168.1.10\ntransport: multicast\nbase_body: 3\ntip_body: \
                wrist\nversion: '3.1'\nup_axis: Z\nalignment: {position_m: [0, 0.1, 0]}\n";
    let settings: TrackingSettings = serde_yaml::from_str(text).unwrap();
    assert_eq!((settings.base_body.clone(), settings.rate_hz), (Some(BodyName::Id(3)), 100.0));
    assert_eq!((settings.version, settings.alignment.quaternion[0]), (StreamVersion::V3_1, 1.0));
    settings.check().unwrap();
    let again: TrackingSettings =
        serde_yaml::from_str(&serde_yaml::to_string(&settings).unwrap()).unwrap();
    assert_eq!(again, settings);
    assert!(serde_yaml::from_str::<TrackingSettings>("servers: 1.2.3.4").is_err());

    let bad = |key: &str, change: &dyn Fn(&mut TrackingSettings)| {
        let mut settings = TrackingSettings::default();
        change(&mut settings);
        assert_eq!(settings.check().unwrap_err().key, key);
    };
    bad("rate_hz", &|settings| settings.rate_hz = f64::NAN);
    bad("command_port", &|settings| settings.command_port = 0);
    bad("multicast_group", &|settings| settings.multicast_group = [10, 0, 0, 1].into());
    bad("alignment", &|settings| settings.alignment.quaternion = [0.0; 4]);
    bad("tip_offset", &|settings| settings.tip_offset.position_m[1] = f64::INFINITY);
    bad("tip_body", &|settings| settings.tip_body = BodyName::Name("base".into()));
}
