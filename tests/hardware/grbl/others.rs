//! Controllers that follow GRBL 1.1 and are not the one whose dialogues there are.

use spinebench::hardware::clock::Clock;
use spinebench::hardware::grbl::parser::{Reply, parse};
use spinebench::hardware::grbl::{Mode, MotionFault, MotionSettings};
use spinebench::simulators::{ControllerFault, ControllerOptions, robot_settings};

use super::bench::{Bench, near};

/// GRBL itself with a fourth axis: settings that only grblHAL has are missing, others say what they
/// are for.
fn plain(report: &str) -> ControllerOptions {
    let mut settings = robot_settings();
    settings.retain(|number, _| *number <= 32 || (100..=133).contains(number));
    settings.insert(10, report.to_owned());
    settings.insert(22, "1".to_owned());
    settings.insert(13, "0 (report inches, bool)".to_owned());
    ControllerOptions { settings, plain: true, ..ControllerOptions::default() }
}

#[test]
fn another_controller_homes_moves_and_holds() {
    // With and without the state of its queue in the reports.
    for report in ["3", "1"] {
        let bench = Bench::new(plain(report));
        let mut controller = bench.open();
        assert_eq!(
            (controller.info().version.as_str(), controller.homed()),
            ("1.1h.20190830:another", false)
        );
        bench.home(&mut controller).unwrap();
        assert!(controller.homed());
        bench.run(&mut controller, 0.5).unwrap();
        for k in 1..=20 {
            bench.go(&mut controller, [f64::from(k); 4], 600.0).unwrap();
            assert!(bench.most_queued() <= 2);
        }
        bench.run(&mut controller, 2.0).unwrap();
        assert!(near(bench.position_mm(), [20.0; 4], 0.01), "{:?}", bench.position_mm());

        bench.go(&mut controller, [50.0; 4], 600.0).unwrap();
        bench.run(&mut controller, 1.0).unwrap();
        controller.hold(bench.now_s());
        bench.run_while(&mut controller, 2.0, |controller| !controller.stands()).unwrap();
        assert_eq!(controller.state().mode, Mode::Hold { complete: true });
        let held_mm = bench.position_mm();
        controller.reset(bench.now_s());
        bench.run(&mut controller, 1.0).unwrap();
        assert!(controller.homed() && near(controller.state().position_mm, held_mm, 0.002));
    }
}

#[test]
fn another_controller_is_found_out_as_well() {
    for (fault, words) in [
        (ControllerFault::WrongSettings(22, "0".into()), "setting $22"),
        (ControllerFault::WrongSettings(10, "2".into()), "setting $10"),
        (ControllerFault::WrongSettings(13, "1".into()), "setting $13"),
        (ControllerFault::WorkOffset(3, 0.5), "work offset"),
    ] {
        let bench = Bench::new(plain("3"));
        bench.inject(fault);
        let found =
            bench.open_with(&MotionSettings::default()).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(words), "{found}");
    }
    let bench = Bench::new(plain("3"));
    let mut controller = bench.ready();
    bench.inject(ControllerFault::Frozen);
    bench.go(&mut controller, [9.0; 4], 600.0).unwrap();
    let found = bench.run(&mut controller, 2.0).unwrap_err();
    assert!(matches!(found, MotionFault::NoAxisMoves { .. }), "{found}");
}

/// What cannot be read is what the error names, not a silence.
#[test]
fn a_controller_with_another_number_of_axes_is_shown_in_its_own_words() {
    let bench = Bench::new(ControllerOptions::default());
    bench.inject(ControllerFault::ThreeAxes);
    let found = bench.open_with(&MotionSettings::default()).map(|_| ()).unwrap_err();
    assert!(
        matches!(&found, MotionFault::Garbled { line, .. } if line.contains("MPos:")),
        "{found}"
    );
}

#[test]
fn lines_with_spaces_are_lines() {
    assert_eq!(parse("ok "), Some(Reply::Ok));
    assert_eq!(parse("error: 9"), Some(Reply::Error(9)));
    assert_eq!(parse("ALARM: 1"), Some(Reply::Alarm(1)));
    let Some(Reply::Status(status)) = parse("<Hold|MPos:1,2,3,4>") else { panic!() };
    assert!(status.bare_hold && status.mode == Mode::Hold { complete: false });
    let Some(Reply::Status(status)) = parse("<Hold:1|MPos:1,2,3,4>") else { panic!() };
    assert!(!status.bare_hold);
}
