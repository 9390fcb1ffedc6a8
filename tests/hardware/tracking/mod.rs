//! Motion capture: the client against the synthetic tracker over real UDP, and against recordings
//! of a real one.

mod bench;
mod capture;
mod crowd;
mod faults;
mod fuzz;
mod opening;
mod real;

use bench::{Bench, apart, at_rest, pose, steady};
use nalgebra::Point3;
use spinebench::hardware::clock::Clock;
use spinebench::hardware::tracking::{RigidPose, TrackingFault, Transport, align};
use spinebench::simulators::{SimulatedTracker, TrackerOptions};

/// Single precision on the wire, at some metres from Motive's origin.
const WIRE_M: f64 = 5e-7;
const WIRE_RAD: f64 = 1e-6;

#[test]
fn every_version_tracks_in_unicast() {
    for version in SimulatedTracker::VERSIONS {
        let bench = Bench::new(TrackerOptions { version, ..Default::default() }, steady);
        let mut tracking = bench.open().unwrap();
        let (m, rad, fresh) = bench.judge(&mut tracking, 2.0);
        assert!(
            m < WIRE_M && rad < WIRE_RAD && fresh > 0.98,
            "{version}: {m} m, {rad} rad, {fresh}"
        );
        let status = tracking.status();
        assert!(
            status.valid >= 199
                && status.lost + status.malformed + status.foreign + status.occluded == 0
        );
        assert!((status.rate_hz.unwrap() - 100.0).abs() < 1e-6, "{status:?}");
        assert!(status.latency_jitter_s < 0.005, "{status:?}");
    }
}

#[test]
fn every_version_tracks_in_multicast() {
    for version in SimulatedTracker::VERSIONS {
        let transport = Transport::Multicast;
        let bench = Bench::new(TrackerOptions { version, transport, ..Default::default() }, steady);
        let mut tracking = match bench.open() {
            Ok(tracking) => tracking,
            Err(fault @ TrackingFault::Socket { .. }) => return println!("skipped: {fault}"),
            Err(fault) => panic!("{fault}"),
        };
        let (m, rad, fresh) = bench.judge(&mut tracking, 2.0);
        if tracking.status().received == 0 {
            return println!("skipped: the system does not deliver multicast on loopback");
        }
        assert!(
            m < WIRE_M && rad < WIRE_RAD && fresh > 0.98,
            "{version}: {m} m, {rad} rad, {fresh}"
        );
    }
}

#[test]
fn moving_the_base_moves_nothing() {
    fn carried(time_s: f64) -> (RigidPose, RigidPose) {
        let base =
            pose([0.3 * time_s.sin(), 1.0, 0.2 * time_s], [0.5 * time_s, 0.1, -0.3 * time_s]);
        (at_rest(0.0).0, base)
    }
    let mount = |settings: &mut spinebench::hardware::tracking::TrackingSettings| {
        settings.alignment = pose([0.01, -0.02, 0.005], [0.0, 0.1, 1.5]);
        settings.tip_offset = pose([0.0, 0.0, 0.012], [0.0, 0.0, 0.7]);
    };
    let bench = Bench::with(TrackerOptions::default(), carried, mount);
    let mut tracking = bench.open().unwrap();
    let mut worst = (0.0_f64, 0.0_f64);
    // Steps of one frame, so that the frames are where the bodies really were.
    bench.watch(&mut tracking, 3.0, 0.01, |tracking, _| {
        if let Some(tip) = tracking.latest().filter(|_| tracking.status().valid > 2) {
            let (m, rad) = apart(&tip.pose(), &at_rest(0.0).0);
            worst = (worst.0.max(m), worst.1.max(rad));
        }
    });
    assert!(tracking.status().valid > 290);
    assert!(worst.0 < 1e-4 && worst.1 < 1e-4, "{worst:?}");
}

#[test]
fn resampling_is_exact_for_steady_motion() {
    let bench = Bench::new(TrackerOptions::default(), steady);
    let mut tracking = bench.open().unwrap();
    // An opening between two frames, so that none of the times asked for is that of a frame.
    bench.watch(&mut tracking, 0.0437, 0.0437, |_, _| {});
    let mut asked = 0;
    bench.watch(&mut tracking, 4.0, 0.2, |tracking, now_s| {
        let time_s = now_s - 0.0234;
        let tip = tracking.pose_at(time_s).unwrap();
        // Polled at 5 Hz, the least delay seen is up to a frame period: the clock may be off by
        // that, not the motion.
        let tip_time_s = time_s - clock_error_s(tracking, now_s);
        let (m, rad) = apart(&tip.pose(), &steady(tip_time_s).0);
        assert!(m < WIRE_M && rad < WIRE_RAD, "{m} m, {rad} rad at {time_s} s");
        assert!(tip.quaternion[0] >= 0.0 && tip.time_s == time_s);
        asked += 1;
    });
    assert_eq!(asked, 20);
}

/// By how much the newest sample's local time is later than the truth, from where the tip was then.
fn clock_error_s(tracking: &spinebench::hardware::tracking::TrackerClient, now_s: f64) -> f64 {
    let tip = tracking.latest().unwrap();
    let error_s = tip.time_s - (tip.position_m[0] - 0.01) / 0.05;
    assert!((-1e-5..0.0101).contains(&error_s), "{error_s} at {now_s}");
    error_s
}

#[test]
fn no_pose_is_made_up() {
    let bench = Bench::new(TrackerOptions::default(), steady);
    let mut tracking = bench.open().unwrap();
    assert!(tracking.pose_at(0.0).is_none() && tracking.age_s(0.0).is_infinite());
    bench.run(&mut tracking, 0.5);
    let now_s = bench.now_s();
    assert!(tracking.pose_at(now_s - 60.0).is_none(), "before the first");
    assert!(tracking.pose_at(now_s + 0.0201).is_none(), "after the last");
    assert!(tracking.pose_at(f64::NAN).is_none());
    let latest = *tracking.latest().unwrap();
    assert_eq!(tracking.pose_at(latest.time_s + 0.005), Some(latest));
}

#[test]
fn alignment_is_recovered() {
    let truth = pose([0.05, -0.12, 0.3], [0.7, -1.9, 0.4]);
    let robot: Vec<[f64; 3]> = (0..12)
        .map(|k| (f64::from(k) * 0.7, 0.01 * f64::from(k)))
        .map(|(angle, height)| [0.08 * angle.cos(), 0.08 * angle.sin(), 0.15 + height])
        .collect();
    let see = |point: &[f64; 3]| (truth.motion() * Point3::from(*point)).coords.into();
    let seen: Vec<[f64; 3]> = robot.iter().map(see).collect();
    let found = align(&robot, &seen).unwrap();
    let (m, rad) = apart(&found.pose, &truth);
    assert!(m < 1e-14 && rad < 1e-13 && found.worst_m < 1e-14, "{found:?}, {m} m, {rad} rad");

    // Points in a plane, such as the tips of one ring, determine it too, and not its mirror image.
    let flat: Vec<[f64; 3]> = robot.iter().map(|point| [point[0], point[1], 0.2]).collect();
    let seen: Vec<[f64; 3]> = flat.iter().map(see).collect();
    let (m, rad) = apart(&align(&flat, &seen).unwrap().pose, &truth);
    assert!(m < 1e-14 && rad < 1e-13, "{m} m, {rad} rad");

    // A millimetre at one point shows in the residual.
    let mut off = seen.clone();
    off[3][1] += 1e-3;
    let found = align(&flat, &off).unwrap();
    assert!(found.worst_m > 5e-4 && found.residual_m < found.worst_m);
}

#[test]
fn alignment_refuses_what_does_not_determine_it() {
    let line: Vec<[f64; 3]> =
        (0..9).map(|k| [0.01 * f64::from(k), 0.02 * f64::from(k), 0.2]).collect();
    let refused =
        |robot: &[[f64; 3]], seen: &[[f64; 3]]| align(robot, seen).unwrap_err().to_string();
    assert!(refused(&line, &line).contains("on a line"));
    assert!(refused(&[[0.1; 3]; 5], &[[0.1; 3]; 5]).contains("on a line"));
    assert!(refused(&line[..2], &line[..2]).contains("at least 3"));
    assert!(refused(&line[..4], &line[..3]).contains("4 points"));
    assert!(refused(&[[f64::NAN; 3]; 5], &line[..5]).contains("not a number"));
}
