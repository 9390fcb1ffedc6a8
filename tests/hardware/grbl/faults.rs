//! Every fault that can be injected ends in the fault of the driver that names it, and is left by
//! reset and homing.

use spinebench::hardware::clock::Clock;
use spinebench::hardware::grbl::{Controller, Mode, MotionFault, MotionSettings, MoveRefusal};
use spinebench::simulators::{ControllerFault, ControllerOptions, robot_settings};

use super::bench::{Bench, near};

const TARGET_MM: [f64; 4] = [12.0, 9.0, 7.0, 14.0];

/// What the driver finds when `fault` comes while it stands; then it moves nothing, and recovers.
fn standing(fault: ControllerFault) -> MotionFault {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.inject(fault);
    let found = bench.run(&mut controller, 4.0).unwrap_err();
    recovers(&bench, &mut controller, &found);
    found
}

/// The same in the middle of a move.
fn moving(fault: ControllerFault) -> MotionFault {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.go(&mut controller, [50.0; 4], 600.0).unwrap();
    bench.run(&mut controller, 1.0).unwrap();
    assert_eq!(controller.state().mode, Mode::Run);
    bench.inject(fault);
    let found = bench.run(&mut controller, 4.0).unwrap_err();
    recovers(&bench, &mut controller, &found);
    found
}

/// The same just before a move.
fn on_the_next_move(fault: ControllerFault) -> MotionFault {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.inject(fault);
    bench.go(&mut controller, TARGET_MM, 600.0).unwrap();
    let found = bench.run(&mut controller, 6.0).unwrap_err();
    recovers(&bench, &mut controller, &found);
    found
}

/// The same before homing.
fn homing(fault: ControllerFault) -> MotionFault {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.open();
    bench.inject(fault);
    let found = bench.home(&mut controller).unwrap_err();
    recovers(&bench, &mut controller, &found);
    found
}

/// The same in the middle of homing.
fn in_the_middle_of_homing(fault: ControllerFault) -> MotionFault {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.open();
    controller.start_homing(bench.now_s());
    bench.run(&mut controller, 2.0).unwrap();
    bench.inject(fault);
    let found = bench.run(&mut controller, 70.0).unwrap_err();
    recovers(&bench, &mut controller, &found);
    found
}

/// No move leaves before reset and homing; holding does. Once repaired it works again.
fn recovers(bench: &Bench, controller: &mut Controller, found: &MotionFault) {
    assert!(!found.to_string().is_empty() && !found.is_refusal());
    assert_eq!(controller.poll(bench.now_s()).as_ref(), Err(found), "the first fault stays");
    assert!(!controller.homed() && !controller.is_homing());
    let before = bench.sent_lines().len();
    assert_eq!(controller.move_to(TARGET_MM, 600.0, bench.now_s()).as_ref(), Err(found));
    controller.start_homing(bench.now_s());
    assert_eq!(bench.sent_lines().len(), before);
    controller.hold(bench.now_s());
    controller.resume(bench.now_s());
    bench.clear_faults();
    controller.reset(bench.now_s());
    let sent = bench.sent();
    if matches!(found, MotionFault::Unplugged { .. }) {
        assert!(matches!(bench.run(controller, 3.0), Err(MotionFault::Unplugged { .. })));
        return;
    }
    assert_eq!(sent[sent.len() - 2..], [b'!', 0x18], "no resume");
    bench.run(controller, 2.0).unwrap();
    assert_eq!(
        controller.move_to(TARGET_MM, 600.0, bench.now_s()),
        Err(MotionFault::Refused(MoveRefusal::NotHomed))
    );
    bench.home(controller).unwrap();
    bench.go(controller, TARGET_MM, 600.0).unwrap();
    bench.run(controller, 5.0).unwrap();
    assert!(near(controller.state().position_mm, TARGET_MM, 0.002));
    assert!(near(bench.position_mm(), TARGET_MM, 0.01));
}

#[test]
fn no_answers() {
    for found in [
        standing(ControllerFault::Silent),
        moving(ControllerFault::Silent),
        on_the_next_move(ControllerFault::Silent),
    ] {
        assert!(matches!(found, MotionFault::Silent { .. }), "{found}");
    }
    let found = in_the_middle_of_homing(ControllerFault::Silent);
    assert!(matches!(found, MotionFault::HomingTimeout { waited_s } if waited_s > 30.0), "{found}");
}

#[test]
fn motion_that_freezes() {
    let found = moving(ControllerFault::Frozen);
    assert!(matches!(found, MotionFault::NoAxisMoves { .. }), "{found}");
    let found = on_the_next_move(ControllerFault::Frozen);
    assert!(matches!(found, MotionFault::NoAxisMoves { .. }), "{found}");
    let found = in_the_middle_of_homing(ControllerFault::Frozen);
    assert!(matches!(found, MotionFault::HomingTimeout { .. }), "{found}");
    // As slow as it may be told to be is not frozen.
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.go(&mut controller, [0.05, 0.0, 0.0, 0.0], 0.6).unwrap();
    bench.run(&mut controller, 6.0).unwrap();
    assert_eq!(controller.state().position_mm[0], 0.05);
    // Nor is a hold, however long, and what goes on after it.
    bench.go(&mut controller, [20.0; 4], 600.0).unwrap();
    bench.run(&mut controller, 0.5).unwrap();
    controller.hold(bench.now_s());
    bench.run(&mut controller, 3.0).unwrap();
    controller.resume(bench.now_s());
    bench.run(&mut controller, 6.0).unwrap();
    assert!(near(controller.state().position_mm, [20.0; 4], 0.002));
}

#[test]
fn slow_answers() {
    let found = standing(ControllerFault::SlowReplies(1.0));
    assert!(matches!(found, MotionFault::Silent { .. }), "{found}");
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.inject(ControllerFault::SlowReplies(0.2));
    bench.go(&mut controller, TARGET_MM, 600.0).unwrap();
    bench.run(&mut controller, 5.0).unwrap();
}

#[test]
fn unreadable_answers() {
    let found = standing(ControllerFault::Garbage);
    assert!(matches!(found, MotionFault::Garbled { count: 3, .. }), "{found}");
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    for _ in 0..5 {
        bench.inject(ControllerFault::GarbledLine);
        bench.run(&mut controller, 5.5).unwrap();
    }
    assert_eq!(controller.state().garbled, 5);
    for noise in [&b"hello\n"[..], b"<Idle|MPos:1,2,3>\n", b"ok?\n", &[b'x'; 300]] {
        let bench = Bench::new(ControllerOptions::default());
        let mut controller = bench.ready();
        (0..3).for_each(|_| bench.make_noise(noise));
        let found = bench.run(&mut controller, 1.0).unwrap_err();
        assert!(matches!(found, MotionFault::Garbled { .. }), "{found}");
    }
}

#[test]
fn lost_and_doubled_acknowledgements() {
    let found = on_the_next_move(ControllerFault::LostOk);
    assert!(
        matches!(&found, MotionFault::Silent { to, .. } if to.starts_with("G1 X12.000")),
        "{found}"
    );
    assert_eq!(on_the_next_move(ControllerFault::DoubledOk), MotionFault::StrayOk);
    let found = homing(ControllerFault::LostOk);
    assert!(matches!(found, MotionFault::HomingTimeout { .. }), "{found}");
}

#[test]
fn axes_that_do_not_follow() {
    let found = on_the_next_move(ControllerFault::DeadAxis(2));
    assert!(matches!(found, MotionFault::NotMoving { axis: 2, target_mm: 7.0, .. }), "{found}");
    let found = standing(ControllerFault::WrongPosition(1, 3.0));
    assert!(matches!(found, MotionFault::Moved { axis: 1, .. }), "{found}");
    let found = standing(ControllerFault::WrongPosition(3, -3.0));
    assert!(matches!(found, MotionFault::OutsideTravel { axis: 3, .. }), "{found}");
    let found = moving(ControllerFault::WrongPosition(0, -11.0));
    assert!(matches!(found, MotionFault::OutsideTravel { axis: 0, .. }), "{found}");
    let found = standing(ControllerFault::WorkOffset(0, 1.0));
    assert!(matches!(found, MotionFault::WorkOffset { .. }), "{found}");
}

/// Four axes that stand are not one axis that stands.
#[test]
fn motors_that_are_off_are_called_that() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    (0..4).for_each(|axis| bench.inject(ControllerFault::DeadAxis(axis)));
    bench.go(&mut controller, [7.0; 4], 600.0).unwrap();
    let words = bench.run(&mut controller, 3.0).unwrap_err().to_string();
    assert!(
        words.starts_with("no axis moves: ") && words.contains("the motors are off"),
        "{words}"
    );
}

/// grblHAL holds before it reports a target outside the travel, which another program has sent.
#[test]
fn a_hold_before_an_alarm_is_called_by_the_alarm() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.make_noise(b"<Hold:1|MPos:0.000,0.000,0.000,0.000|Bf:100,1023|FS:0,0>\r\n");
    bench.run(&mut controller, 0.06).unwrap();
    bench.make_noise(b"ALARM:2\r\n");
    let found = bench.run(&mut controller, 0.2).unwrap_err();
    assert_eq!(found, MotionFault::Alarm { code: 2 });
}

/// Without its number in the status reports (`$10=511`), an alarm has the number that was pushed.
#[test]
fn an_alarm_has_the_number_that_was_pushed() {
    let mut settings = robot_settings();
    settings.insert(10, "511".to_owned());
    let bench = Bench::new(ControllerOptions { settings, ..ControllerOptions::default() });
    bench.home_beforehand();
    bench.inject(ControllerFault::SpuriousAlarm(3));
    let mut controller = bench.open();
    assert_eq!(controller.alarm(), Some(3));
    bench.run(&mut controller, 1.0).unwrap();
    assert_eq!(controller.alarm(), Some(3), "after reports without a number");
}

/// An alarm from before the controller was connected: nobody has heard its number.
#[test]
fn an_alarm_from_before_is_asked_for() {
    for (plain, number) in [(false, 3), (true, 0)] {
        let mut settings = robot_settings();
        settings.insert(10, "511".to_owned());
        let options = ControllerOptions { settings, plain, ..ControllerOptions::default() };
        let bench = Bench::new(options);
        bench.home_beforehand();
        bench.inject(ControllerFault::SpuriousAlarm(3));
        bench.sleep_until(bench.now_s() + 1.0);
        bench.forget_received();
        let controller = bench.open();
        assert_eq!(controller.alarm(), Some(number), "plain: {plain}");
    }
}

/// As a report was measured that grblHAL's simulator composed while the axes moved.
#[test]
fn one_report_of_axes_read_at_different_moments_stops_nothing() {
    for begun_s in [0.3, 1.0, 2.2] {
        let bench = Bench::new(ControllerOptions::default());
        let mut controller = bench.ready();
        bench.go(&mut controller, [20.0; 4], 600.0).unwrap();
        bench.run(&mut controller, begun_s).unwrap();
        bench.inject(ControllerFault::TornReport(0.03));
        let apart_mm = |position_mm: [f64; 4]| position_mm[0] - position_mm[3];
        bench
            .run_while(&mut controller, 1.0, |controller| {
                apart_mm(controller.state().position_mm) < 0.1
            })
            .unwrap();
        assert!(apart_mm(controller.state().position_mm) > 0.1);
        bench.run(&mut controller, 6.0).unwrap();
        assert!(near(controller.state().position_mm, [20.0; 4], 0.002));
    }
}

#[test]
fn an_axis_that_dies_in_a_stream_is_noticed_before_it_stands() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.inject(ControllerFault::DeadAxis(1));
    let mut target_mm = [0.0; 4];
    let found = (0..100).find_map(|_| {
        target_mm = target_mm.map(|value| value + 0.5);
        bench
            .go(&mut controller, target_mm, 300.0)
            .and_then(|()| bench.run(&mut controller, 0.2))
            .err()
    });
    assert!(matches!(found, Some(MotionFault::NotMoving { axis: 1, .. })), "{found:?}");
    assert!(target_mm[0] < 5.0, "{target_mm:?}");
}

#[test]
fn an_axis_that_slips_is_not_noticed_here() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.inject(ControllerFault::SlippingAxis(0));
    bench.go(&mut controller, TARGET_MM, 600.0).unwrap();
    bench.run(&mut controller, 5.0).unwrap();
    assert!(
        near(controller.state().position_mm, TARGET_MM, 0.002)
            && bench.position_mm()[0].abs() < 0.01
    );
}

#[test]
fn alarms() {
    for (found, code) in [
        (homing(ControllerFault::SwitchStuckOpen(3)), 9),
        (homing(ControllerFault::DeadAxis(0)), 9),
        (homing(ControllerFault::SwitchStuckClosed(0)), 8),
        (standing(ControllerFault::SwitchStuckClosed(1)), 1),
        (standing(ControllerFault::HardLimit(1)), 1),
        (moving(ControllerFault::HardLimit(2)), 1),
        (standing(ControllerFault::SpuriousAlarm(17)), 17),
        (moving(ControllerFault::SpuriousAlarm(5)), 5),
    ] {
        assert_eq!(found, MotionFault::Alarm { code }, "{found}");
    }
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.inject(ControllerFault::HardLimit(1));
    bench.run(&mut controller, 1.0).unwrap_err();
    bench.run(&mut controller, 1.0).unwrap_err();
    (0..20).for_each(|_| {
        bench.sleep_until(bench.now_s() + 0.05);
        controller.poll(bench.now_s()).unwrap_err();
    });
    assert_eq!(controller.state().pins.limits, [false, true, false, false]);
}

#[test]
fn errors_that_repeat() {
    let found = on_the_next_move(ControllerFault::StickyError(22));
    assert!(
        matches!(&found, MotionFault::Error { code: 22, line } if line.starts_with("G1 ")),
        "{found}"
    );
}

#[test]
fn restarts() {
    for found in [
        standing(ControllerFault::Reboot),
        moving(ControllerFault::Reboot),
        in_the_middle_of_homing(ControllerFault::Reboot),
    ] {
        assert!(matches!(found, MotionFault::Rebooted { .. }), "{found}");
    }
}

#[test]
fn pulled_cables() {
    for found in [
        standing(ControllerFault::Unplugged),
        moving(ControllerFault::Unplugged),
        in_the_middle_of_homing(ControllerFault::Unplugged),
    ] {
        assert!(matches!(found, MotionFault::Unplugged { .. }), "{found}");
    }
}

#[test]
fn wrong_settings() {
    for (number, value) in [
        (1, "25"),
        (10, "2"),
        (13, "1"),
        (20, "0"),
        (21, "0"),
        (22, "9"),
        (23, "7"),
        (44, "7"),
        (112, "nan"),
        (121, "0"),
        (133, "59.9"),
        (376, "1"),
    ] {
        let bench = Bench::new(ControllerOptions::default());
        bench.inject(ControllerFault::WrongSettings(number, value.to_owned()));
        let found = bench.open_with(&MotionSettings::default()).map(|_| ()).unwrap_err();
        let MotionFault::WrongSettings(wrong) = &found else { panic!("{found}") };
        assert!(wrong.len() == 1 && wrong[0].number == number, "{found}");
        let text = found.to_string();
        assert!(
            text.contains(&format!("${number} ("))
                && text.contains(value)
                && text.contains("expected"),
            "{text}"
        );
    }
    let bench = Bench::new(ControllerOptions::default());
    bench.inject(ControllerFault::WrongSettings(1, "25".to_owned()));
    bench
        .open_with(&MotionSettings { hold_when_idle: false, ..MotionSettings::default() })
        .unwrap();
}

#[test]
fn nobody_to_open() {
    let open = |fault| {
        let bench = Bench::new(ControllerOptions::default());
        bench.inject(fault);
        bench.open_with(&MotionSettings::default()).map(|_| ()).unwrap_err()
    };
    let found = open(ControllerFault::Silent);
    assert!(matches!(found, MotionFault::Silent { .. }), "{found}");
    let found = open(ControllerFault::Unplugged);
    assert!(matches!(found, MotionFault::Unplugged { .. }), "{found}");
    let found = open(ControllerFault::Garbage);
    assert!(matches!(found, MotionFault::Garbled { .. }), "{found}");
    let found = open(ControllerFault::WorkOffset(2, 0.5));
    assert!(matches!(found, MotionFault::WorkOffset { .. }), "{found}");
}
