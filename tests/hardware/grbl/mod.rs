//! Motors: the GRBL driver against the fake controller, and that one against dialogues with a real
//! one.

mod bench;
mod faults;
mod gate;
mod others;
mod resuming;
mod terminal;
mod transcripts;

use bench::{Bench, near};
use spinebench::hardware::clock::Clock;
use spinebench::hardware::grbl::{Mode, MotionFault, MotionSettings, MoveRefusal, codes};
use spinebench::simulators::{ControllerFault, ControllerOptions};

#[test]
fn opening_looks_and_touches_nothing() {
    let bench = Bench::new(ControllerOptions::default());
    let before_mm = bench.position_mm();
    let controller = bench.open();
    assert_eq!(bench.sent_lines(), ["$I", "$$", "$#"]);
    assert_eq!(bench.position_mm(), before_mm);
    assert_eq!((controller.state().mode, controller.homed()), (Mode::Alarm(Some(11)), false));
    let info = controller.info();
    assert_eq!((info.firmware.as_str(), info.blocks), ("grblHAL", 100));
    assert_eq!((info.max_speed_mm_min, info.acceleration_mm_s2), ([600.0; 4], [50.0; 4]));
    assert_eq!(info.travel_mm, [60.0; 4]);
}

#[test]
fn opening_wakes_a_controller_with_half_a_line_and_an_old_error() {
    let bench = Bench::new(ControllerOptions::default());
    bench.inject(ControllerFault::StickyError(20));
    bench.inject(ControllerFault::Reboot);
    bench.open();
}

#[test]
fn a_controller_that_is_homed_already_moves_at_once() {
    let bench = Bench::new(ControllerOptions::default());
    bench.home_beforehand();
    let mut controller = bench.open();
    assert_eq!((controller.state().mode, controller.homed()), (Mode::Idle, true));
    bench.go(&mut controller, [3.0; 4], 600.0).unwrap();
    bench.run(&mut controller, 3.0).unwrap();
    assert!(near(bench.position_mm(), [3.0; 4], 1e-3));
}

#[test]
fn homing_ends_where_the_axes_stand() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.open();
    let now_s = bench.now_s();
    assert_eq!(
        controller.move_to([1.0; 4], 600.0, now_s),
        Err(MotionFault::Refused(MoveRefusal::NotHomed))
    );
    bench.home(&mut controller).unwrap();
    assert!((5.0..7.0).contains(&(bench.now_s() - now_s)), "{}", bench.now_s() - now_s);
    assert_eq!((controller.homed(), controller.state().mode), (true, Mode::Idle));
    assert_eq!(controller.state().position_mm, [0.0; 4]);
    assert!(near(bench.position_mm(), [0.0; 4], 1e-9));
    let queries = |from: usize| bench.sent()[from..].iter().filter(|&&byte| byte == b'?').count();
    let homed = bench.sent().len();
    bench.run(&mut controller, 1.0).unwrap();
    assert!((15..=21).contains(&queries(homed)), "{}", queries(homed));
}

#[test]
fn no_query_leaves_while_homing() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.open();
    controller.start_homing(bench.now_s());
    bench.run(&mut controller, 0.5).unwrap();
    let begun = bench.sent().len();
    bench.run(&mut controller, 4.0).unwrap();
    assert!(controller.is_homing() && bench.sent().len() == begun);
}

#[test]
fn moves_arrive() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.go(&mut controller, [10.0, 5.0, 8.0, 6.0], 600.0).unwrap();
    bench
        .run_while(&mut controller, 1.0, |controller| controller.state().mode != Mode::Run)
        .unwrap();
    assert!(controller.state().feed_mm_min > 0.0);
    bench.run(&mut controller, 3.0).unwrap();
    assert_eq!(controller.state().position_mm, [10.0, 5.0, 8.0, 6.0]);
    assert!(near(bench.position_mm(), [10.0, 5.0, 8.0, 6.0], 1e-3));
    let lines = bench.sent_lines();
    assert_eq!(
        lines[lines.len() - 2..],
        ["G21 G90 G94 G54", "G1 X10.000 Y5.000 Z8.000 A6.000 F600.0"]
    );
    assert!(!bench.sent().contains(&b'\r'));
}

#[test]
fn the_gate_refuses_and_goes_on() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    let before = bench.sent();
    for (target_mm, feed_mm_min) in [
        ([f64::NAN, 0.0, 0.0, 0.0], 600.0),
        ([0.0, f64::INFINITY, 0.0, 0.0], 600.0),
        ([0.0, 0.0, 60.001, 0.0], 600.0),
        ([0.0, 0.0, 0.0, -0.001], 600.0),
        ([1.0; 4], f64::NAN),
        ([1.0; 4], 0.0),
        ([1.0; 4], -5.0),
        ([1.0; 4], 3000.1),
    ] {
        let refused = controller.move_to(target_mm, feed_mm_min, bench.now_s()).unwrap_err();
        assert!(matches!(refused, MotionFault::Refused(_)) && refused.is_refusal(), "{refused}");
    }
    assert_eq!(bench.sent(), before);
    bench.go(&mut controller, [60.0, -0.0004, 60.0004, 0.0], 3000.0).unwrap();
    assert_eq!(bench.sent_lines().last().unwrap(), "G1 X60.000 Y0.000 Z60.000 A0.000 F3000.0");
    bench.run(&mut controller, 15.0).unwrap();
}

#[test]
fn a_third_move_has_to_wait() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.go(&mut controller, [10.0; 4], 60.0).unwrap();
    assert_eq!(
        controller.move_to([11.0; 4], 60.0, bench.now_s()),
        Err(MotionFault::Busy),
        "not acknowledged"
    );
    bench.go(&mut controller, [11.0; 4], 60.0).unwrap();
    bench.run(&mut controller, 1.0).unwrap();
    assert_eq!(controller.state().queued, 2);
    assert_eq!(controller.move_to([12.0; 4], 60.0, bench.now_s()), Err(MotionFault::Busy));
    assert_eq!(controller.fault(), None);
}

#[test]
fn a_stream_never_has_more_than_two_moves_waiting() {
    for (delay_s, reply_timeout_s) in [([0.01, 0.06], 0.3), ([0.01, 0.5], 0.8)] {
        let bench =
            Bench::new(ControllerOptions { delay_s, seed: 5, ..ControllerOptions::default() });
        let mut controller =
            bench.ready_with(&MotionSettings { reply_timeout_s, ..MotionSettings::default() });
        let target_mm = |k: u32| {
            [0.0, 1.0, 2.0, 3.0].map(|phase| 30.0 + 20.0 * (f64::from(k) * 0.05 + phase).sin())
        };
        bench.go(&mut controller, target_mm(0), 600.0).unwrap();
        bench.run(&mut controller, 10.0).unwrap();
        let began_s = bench.now_s();
        for k in 1..=500 {
            let until_s = bench.now_s() + 0.2;
            bench.go(&mut controller, target_mm(k), 600.0).unwrap();
            assert!(controller.state().unacknowledged <= 1 && controller.state().queued <= 2);
            bench.run_while(&mut controller, 0.2, |_| bench.now_s() < until_s).unwrap();
        }
        println!("{delay_s:?} s: {:.1} s for 500 moves", bench.now_s() - began_s);
        bench.run(&mut controller, 5.0).unwrap();
        assert_eq!((bench.most_queued(), controller.state().moves), (2, 501));
        assert!(near(bench.position_mm(), target_mm(500), 0.01));
        assert!(!bench.sent().contains(&b'\r'));
    }
}

#[test]
fn a_hold_stops_and_goes_on() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.go(&mut controller, [30.0; 4], 600.0).unwrap();
    bench.run(&mut controller, 1.0).unwrap();
    controller.hold(bench.now_s());
    let refused = controller.move_to([31.0; 4], 600.0, bench.now_s());
    assert!(matches!(refused, Err(MotionFault::Refused(MoveRefusal::NotReady(_)))), "{refused:?}");
    bench.run(&mut controller, 1.0).unwrap();
    assert_eq!(controller.state().mode, Mode::Hold { complete: true });
    let held_mm = bench.position_mm();
    bench.run(&mut controller, 1.0).unwrap();
    assert_eq!(bench.position_mm(), held_mm);
    controller.resume(bench.now_s());
    bench.run(&mut controller, 8.0).unwrap();
    assert!(near(bench.position_mm(), [30.0; 4], 0.01) && controller.homed());
}

#[test]
fn a_reset_of_standing_axes_keeps_the_position() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.go(&mut controller, [30.0; 4], 600.0).unwrap();
    bench.run(&mut controller, 1.0).unwrap();
    controller.hold(bench.now_s());
    bench.run(&mut controller, 1.0).unwrap();
    let held_mm = bench.position_mm();
    controller.reset(bench.now_s());
    bench.run(&mut controller, 1.0).unwrap();
    assert_eq!((controller.state().mode, controller.homed()), (Mode::Idle, true));
    assert!(near(controller.state().position_mm, held_mm, 0.002));
    bench.go(&mut controller, [2.0; 4], 600.0).unwrap();
    let lines = bench.sent_lines();
    assert_eq!(lines[lines.len() - 2], "G21 G90 G94 G54", "set up again");
    bench.run(&mut controller, 4.0).unwrap();
    assert!(near(bench.position_mm(), [2.0; 4], 0.01));
}

#[test]
fn a_position_in_doubt_is_found_by_homing() {
    let bench = Bench::new(ControllerOptions::default());
    bench.home_beforehand();
    let mut controller = bench.open();
    assert!(controller.homed());
    controller.require_homing();
    bench.run(&mut controller, 4.0).unwrap();
    assert!(!controller.homed() && controller.homing_required(), "whatever it says");
    assert_eq!(
        controller.move_to([1.0; 4], 600.0, bench.now_s()),
        Err(MotionFault::Refused(MoveRefusal::NotHomed))
    );
    bench.home(&mut controller).unwrap();
    assert!(controller.homed() && !controller.homing_required());
}

#[test]
fn a_reset_of_moving_axes_loses_the_position() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.go(&mut controller, [30.0; 4], 600.0).unwrap();
    bench.run(&mut controller, 1.0).unwrap();
    controller.reset(bench.now_s());
    assert!(!controller.homed());
    bench.run(&mut controller, 1.0).unwrap();
    assert_eq!((controller.state().mode, controller.homed()), (Mode::Alarm(Some(11)), false));
    bench.home(&mut controller).unwrap();
    assert!(near(bench.position_mm(), [0.0; 4], 1e-9) && controller.homed());
}

#[test]
fn homing_can_be_broken_off_and_begun_again() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.open();
    controller.start_homing(bench.now_s());
    bench.run(&mut controller, 2.0).unwrap();
    controller.reset(bench.now_s());
    controller.start_homing(bench.now_s());
    bench.run_while(&mut controller, 20.0, |controller| controller.is_homing()).unwrap();
    assert!(controller.homed() && near(bench.position_mm(), [0.0; 4], 1e-9));
}

#[test]
fn every_number_has_its_words() {
    let numbered = |code: &u16| !matches!(code, 59 | 68 | 69);
    for code in (1..=79).filter(numbered) {
        assert!(codes::knows_error(code), "error {code}");
    }
    for code in 1..=20 {
        assert!(codes::knows_alarm(code), "alarm {code}");
    }
    for meaning in
        (0..=u16::from(u8::MAX)).flat_map(|code| [codes::error(code), codes::alarm(code)])
    {
        assert!(meaning.what.ends_with('.') && meaning.remedy.ends_with('.'), "{meaning}");
    }
    let fault = MotionFault::Alarm { code: 9 }.to_string();
    assert!(
        fault.contains("alarm 9") && fault.contains("no switch") && fault.contains("home"),
        "{fault}"
    );
}

#[test]
fn settings_are_checked() {
    MotionSettings::default().check().unwrap();
    let bad = |change: fn(&mut MotionSettings), key: &str| {
        let mut settings = MotionSettings::default();
        change(&mut settings);
        assert_eq!(settings.check().unwrap_err().key, key);
    };
    bad(|settings| settings.port.clear(), "port");
    bad(|settings| settings.baud = 0, "baud");
    bad(|settings| settings.reply_timeout_s = 0.0, "reply_timeout_s");
    bad(|settings| settings.homing_timeout_s = f64::NAN, "homing_timeout_s");
    bad(|settings| settings.travel_m = -0.06, "travel_m");
    bad(|settings| settings.max_speed_mm_min = f64::INFINITY, "max_speed_mm_min");
    bad(|settings| settings.homing_directions = 16, "homing_directions");
    let read: MotionSettings =
        serde_yaml::from_str("{travel_m: 0.05, port: /dev/ttyUSB0}").unwrap();
    assert_eq!((read.travel_m, read.limits_mm(0)), (0.05, (0.0, 50.0)));
    assert!(serde_yaml::from_str::<MotionSettings>("{travel_mm: 50}").is_err());
}
