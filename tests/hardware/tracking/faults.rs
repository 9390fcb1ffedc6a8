//! What goes wrong in a running stream, one thing at a time.

use spinebench::hardware::clock::Clock;
use spinebench::hardware::tracking::{TrackerClient, Transport};
use spinebench::simulators::{TrackedBody, TrackerFault, TrackerOptions};

use super::bench::{Bench, at_rest, fresh, steady};
use super::{WIRE_M, WIRE_RAD};

fn tracked() -> (Bench, TrackerClient) {
    let bench = Bench::new(TrackerOptions::default(), steady);
    let mut tracking = bench.open().unwrap();
    bench.run(&mut tracking, 0.5);
    assert!(fresh(&tracking, bench.now_s()));
    (bench, tracking)
}

/// After the fault the samples are right again.
fn recovers(bench: &Bench, tracking: &mut TrackerClient, within_s: f64) {
    bench.clear_faults();
    bench.run(tracking, within_s);
    let (m, rad, fresh) = bench.judge(tracking, 0.5);
    assert!(
        m < WIRE_M && rad < WIRE_RAD && fresh > 0.99,
        "{m} m, {rad} rad, {fresh}, {:?}",
        tracking.status()
    );
}

#[test]
fn losses_are_counted_and_bridged() {
    for (loss, expected) in [(0.01, 10.0), (0.2, 200.0)] {
        let bench = Bench::new(TrackerOptions { loss, ..Default::default() }, steady);
        let mut tracking = bench.open().unwrap();
        let (mut asked, mut answered) = (0, 0);
        bench.watch(&mut tracking, 10.0, 0.002, |tracking, now_s| {
            asked += 1;
            answered += i32::from(tracking.pose_at(now_s - 0.05).is_some());
        });
        let status = tracking.status();
        assert!((status.lost as f64 - expected).abs() < 4.0 * f64::sqrt(expected), "{status:?}");
        assert!(
            status.lost + status.received >= 999 && (status.rate_hz.unwrap() - 100.0).abs() < 1e-6
        );
        assert!(
            f64::from(answered) > f64::from(asked) * (1.0 - 2.0 * loss * loss) - 60.0,
            "{answered} of {asked}"
        );
        let (m, rad, _) = bench.judge(&mut tracking, 1.0);
        assert!(m < WIRE_M && rad < WIRE_RAD, "{m} {rad}");
    }
}

#[test]
fn old_and_double_frames_are_dropped() {
    let (bench, mut tracking) = tracked();
    bench.inject(TrackerFault::OutOfOrder);
    bench.inject(TrackerFault::Duplicate);
    let mut last_s = 0.0;
    bench.watch(&mut tracking, 2.0, 0.002, |tracking, _| {
        let time_s = tracking.latest().unwrap().time_s;
        assert!(time_s >= last_s);
        last_s = time_s;
    });
    let status = tracking.status();
    assert!(
        status.out_of_order >= 190 && status.duplicates >= 95 && status.restarts == 0,
        "{status:?}"
    );
    recovers(&bench, &mut tracking, 0.1);
}

#[test]
fn what_is_not_seen_is_not_valid() {
    let faults = [
        TrackerFault::Occluded(TrackedBody::Tip),
        TrackerFault::Occluded(TrackedBody::Base),
        TrackerFault::NanPose,
        TrackerFault::BodyGone,
    ];
    for fault in faults {
        let (bench, mut tracking) = tracked();
        let (before, valid) = (*tracking.latest().unwrap(), tracking.status().valid);
        bench.inject(fault);
        bench.run(&mut tracking, 0.3);
        let status = tracking.status();
        assert!(status.occluded >= 29 && status.valid == valid, "{fault:?}: {status:?}");
        assert!((tracking.latest().unwrap().time_s - before.time_s).abs() < 1e-6);
        assert!(!fresh(&tracking, bench.now_s()) && tracking.age_s(bench.now_s()) > 0.28);
        assert!(tracking.pose_at(bench.now_s() - 0.05).is_none());
        assert_eq!(status.fault.is_some(), fault == TrackerFault::BodyGone, "{status:?}");
        recovers(&bench, &mut tracking, 0.6);
    }
}

#[test]
fn a_second_server_is_not_listened_to() {
    for transport in [Transport::Unicast, Transport::Multicast] {
        let bench = Bench::new(TrackerOptions { transport, ..Default::default() }, steady);
        let Ok(mut tracking) = bench.open() else { return println!("skipped: no multicast") };
        bench.inject(TrackerFault::SecondServer);
        let (m, _, fresh) = bench.judge(&mut tracking, 2.0);
        let status = tracking.status();
        if status.received == 0 {
            return println!("skipped: no multicast on loopback");
        }
        assert!(m < WIRE_M && fresh > 0.98 && status.foreign >= 195, "{m} {fresh} {status:?}");
        assert!(status.foreign_source.is_some_and(|source| source.ip().is_loopback()));
        assert_eq!((status.out_of_order, status.restarts), (0, 0));
    }
}

#[test]
fn a_restart_is_noticed() {
    for transport in [Transport::Unicast, Transport::Multicast] {
        let bench = Bench::new(TrackerOptions { transport, ..Default::default() }, steady);
        let Ok(mut tracking) = bench.open() else { return println!("skipped: no multicast") };
        bench.run(&mut tracking, 0.5);
        if tracking.status().received == 0 {
            return println!("skipped: no multicast on loopback");
        }
        bench.inject(TrackerFault::Restart);
        bench.run(&mut tracking, 0.8);
        assert!(!fresh(&tracking, bench.now_s()), "frames of an unknown count are not samples");
        recovers(&bench, &mut tracking, 1.2);
        assert_eq!(tracking.status().restarts, 1);
        // Twenty seconds later all is as it was.
        bench.run(&mut tracking, 20.0);
        assert_eq!(
            (tracking.status().restarts, tracking.status().lost),
            (1, 0),
            "{:?}",
            tracking.status()
        );
    }
}

#[test]
fn silence_makes_samples_old_and_is_survived() {
    let (bench, mut tracking) = tracked();
    bench.inject(TrackerFault::Silent);
    // Long enough that the server forgets its clients.
    bench.run(&mut tracking, 8.0);
    assert!(!fresh(&tracking, bench.now_s()) && tracking.age_s(bench.now_s()) > 7.9);
    recovers(&bench, &mut tracking, 1.2);
    assert_eq!((tracking.status().restarts, tracking.status().occluded), (0, 0));
}

#[test]
fn late_frames_are_old() {
    let (bench, mut tracking) = tracked();
    bench.inject(TrackerFault::Late(0.2));
    bench.run(&mut tracking, 1.0);
    let age_s = tracking.age_s(bench.now_s());
    assert!((0.19..0.22).contains(&age_s), "{age_s}");
    assert!(tracking.status().latency_jitter_s > 0.15);
    let (m, _, _) = bench.judge(&mut tracking, 0.2);
    assert!(m < WIRE_M, "{m}");
}

#[test]
fn a_standing_clock_gives_no_samples() {
    let (bench, mut tracking) = tracked();
    bench.inject(TrackerFault::FrozenClock);
    bench.run(&mut tracking, 3.0);
    assert!(!fresh(&tracking, bench.now_s()) && tracking.status().stuck_clock >= 290);
    recovers(&bench, &mut tracking, 0.1);
    assert_eq!(tracking.status().restarts, 0);
}

#[test]
fn a_picture_that_stands_still_is_reported() {
    let (bench, mut tracking) = tracked();
    assert!(tracking.status().unchanged_s < 1e-9);
    bench.inject(TrackerFault::Frozen);
    bench.run(&mut tracking, 1.0);
    assert!(fresh(&tracking, bench.now_s()) && (tracking.status().unchanged_s - 1.0).abs() < 0.03);
    recovers(&bench, &mut tracking, 0.1);
    assert!(tracking.status().unchanged_s < 1e-9);
}

#[test]
fn jumps_and_swaps_are_seen_as_they_come() {
    let bench = Bench::new(TrackerOptions::default(), at_rest);
    let mut tracking = bench.open().unwrap();
    bench.inject(TrackerFault::Jump(0.05));
    let (m, rad, fresh) = bench.judge(&mut tracking, 0.2);
    assert!((m - 0.05).abs() < WIRE_M && rad < WIRE_RAD && fresh > 0.7, "{m}");
    bench.clear_faults();
    bench.inject(TrackerFault::SwappedBodies);
    let (m, _, _) = bench.judge(&mut tracking, 0.2);
    assert!(m > 0.05, "the base seen from the tip is elsewhere: {m}");
}

#[test]
fn cut_frames_are_counted() {
    let (bench, mut tracking) = tracked();
    bench.inject(TrackerFault::Malformed);
    bench.run(&mut tracking, 3.0);
    let status = tracking.status();
    assert!(status.malformed >= 290 && status.valid < 60, "{status:?}");
    assert!(!fresh(&tracking, bench.now_s()));
    recovers(&bench, &mut tracking, 0.1);
}

#[test]
fn noise_is_what_was_set() {
    let bench = Bench::new(TrackerOptions { noise_m: 1e-4, ..Default::default() }, at_rest);
    let mut tracking = bench.open().unwrap();
    let truth = at_rest(0.0).0.position_m;
    let mut squares = Vec::new();
    bench.watch(&mut tracking, 5.0, 0.01, |tracking, _| {
        squares.extend(tracking.latest().map(|tip| (tip.position_m[0] - truth[0]).powi(2)));
    });
    // Both bodies have it.
    let deviation_m = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((deviation_m / (1e-4 * f64::sqrt(2.0)) - 1.0).abs() < 0.15, "{deviation_m}");
}
