//! Holds and what comes after them, as grblHAL was measured to do: 100 ms of motion before it slows
//! down, no `~` before it stands, short moves that end short, lost queries.

use spinebench::hardware::clock::Clock;
use spinebench::hardware::grbl::{Controller, Mode, MotionFault, MotionSettings};
use spinebench::simulators::{ControllerFault, ControllerOptions, robot_settings};

use super::bench::{Bench, near};

/// A controller as fast as a robot's.
fn fast() -> Bench {
    let mut settings = robot_settings();
    for axis in 0..4 {
        settings.insert(110 + axis, "3000".to_owned());
        settings.insert(120 + axis, "500".to_owned());
    }
    Bench::new(ControllerOptions { settings, ..ControllerOptions::default() })
}

fn count(bench: &Bench, byte: u8) -> usize {
    bench.sent().iter().filter(|&&sent| sent == byte).count()
}

/// Holds for `held_s`, resumes, and runs until the moves are done.
fn hold_and_resume(
    bench: &Bench,
    controller: &mut Controller,
    held_s: f64,
) -> Result<(), MotionFault> {
    controller.hold(bench.now_s());
    bench.run(controller, held_s)?;
    controller.resume(bench.now_s());
    bench.run(controller, 1.0)
}

#[test]
fn a_resume_waits_until_the_axes_stand() {
    for held_s in [0.0, 0.02, 0.05, 0.1, 0.2, 0.5] {
        let bench = fast();
        let mut controller = bench.ready();
        bench.go(&mut controller, [30.0; 4], 1125.0).unwrap();
        bench.run(&mut controller, 0.5).unwrap();
        controller.hold(bench.now_s());
        bench.run(&mut controller, held_s).unwrap();
        controller.resume(bench.now_s());
        assert!(controller.is_resuming());
        assert!(held_s > 0.1 || count(&bench, b'~') == 0, "{held_s}: it decelerates");
        assert!(
            controller.move_to([31.0; 4], 600.0, bench.now_s()).is_err(),
            "not before it moves"
        );
        bench.run(&mut controller, 0.6).unwrap();
        assert!(!controller.is_resuming() && controller.state().mode == Mode::Run, "{held_s}");
        bench.run(&mut controller, 4.0).unwrap();
        assert!(near(bench.position_mm(), [30.0; 4], 0.01), "{held_s}: {:?}", bench.position_mm());
        assert_eq!(count(&bench, b'~'), 1, "{held_s}: one is enough for a controller that stands");
    }
}

#[test]
fn a_move_that_a_hold_ends_short_is_sent_again() {
    let mut completed = 0;
    for k in 0..50 {
        let bench = fast();
        let mut controller = bench.ready();
        bench.go(&mut controller, [30.0; 4], 3000.0).unwrap();
        bench.run(&mut controller, 4.0).unwrap();
        let before = bench.sent_lines().len();
        bench.go(&mut controller, [33.0, 30.0, 27.0, 31.0], 1125.0).unwrap();
        bench.run(&mut controller, 0.005 * f64::from(k)).unwrap();
        hold_and_resume(&bench, &mut controller, 0.06).unwrap();
        assert!(
            near(bench.position_mm(), [33.0, 30.0, 27.0, 31.0], 0.02),
            "{k}: {:?}",
            bench.position_mm()
        );
        completed += usize::from(bench.sent_lines().len() == before + 2);
        // And goes on from there.
        bench.go(&mut controller, [30.0; 4], 1125.0).unwrap();
        bench.run(&mut controller, 1.0).unwrap();
        assert!(near(bench.position_mm(), [30.0; 4], 0.003), "{k}: {:?}", bench.position_mm());
    }
    println!("{completed} of 50 moves were completed");
    assert!((3..25).contains(&completed), "{completed}");
}

/// A held controller reads no lines, but it answers queries: nothing is wrong.
#[test]
fn a_move_sent_just_before_a_hold_is_answered_after_it() {
    let bench = fast();
    let mut controller = bench.ready();
    bench.go(&mut controller, [3.0; 4], 1125.0).unwrap();
    bench.run(&mut controller, 0.15).unwrap();
    bench.go(&mut controller, [6.0; 4], 1125.0).unwrap();
    controller.hold(bench.now_s());
    let began_s = bench.now_s();
    while bench.now_s() < began_s + 1.0 {
        bench.run(&mut controller, 0.01).unwrap();
        let waiting_s = controller.waiting_s(bench.now_s());
        assert!(waiting_s <= MotionSettings::default().late_s, "{waiting_s} s");
    }
    assert_eq!(controller.state().unacknowledged, 1, "the move is answered while it is held");
    controller.resume(bench.now_s());
    bench.run(&mut controller, 2.0).unwrap();
    assert!(near(bench.position_mm(), [6.0; 4], 0.02), "{:?}", bench.position_mm());
}

/// A line that stays without an answer after a hold is noticed.
#[test]
fn an_answer_that_does_not_come_after_a_hold_is_missed() {
    let bench = fast();
    let mut controller = bench.ready();
    bench.go(&mut controller, [3.0; 4], 1125.0).unwrap();
    bench.inject(ControllerFault::LostOk);
    controller.hold(bench.now_s());
    bench.run(&mut controller, 0.5).unwrap();
    controller.resume(bench.now_s());
    let found = bench.run(&mut controller, 3.0).unwrap_err();
    assert!(matches!(found, MotionFault::Silent { .. }), "{found}");
}

/// An axis that is blocked is not told to move for ever.
#[test]
fn an_axis_that_stays_short_is_found() {
    let bench = fast();
    let mut controller = bench.ready();
    bench.go(&mut controller, [3.0; 4], 1125.0).unwrap();
    bench.run(&mut controller, 0.05).unwrap();
    bench.inject(ControllerFault::DeadAxis(1));
    let found = hold_and_resume(&bench, &mut controller, 0.1).unwrap_err();
    assert!(matches!(found, MotionFault::NotMoving { axis: 1, .. }), "{found}");
}

#[test]
fn a_controller_that_does_not_resume_is_given_up() {
    let bench = fast();
    let mut controller = bench.ready();
    bench.go(&mut controller, [30.0; 4], 1125.0).unwrap();
    bench.run(&mut controller, 0.3).unwrap();
    bench.inject(ControllerFault::IgnoredResume);
    controller.hold(bench.now_s());
    bench.run(&mut controller, 0.05).unwrap();
    controller.resume(bench.now_s());
    let found = bench.run(&mut controller, 5.0).unwrap_err();
    let MotionFault::NotResumed { mode, waited_s, sent } = found else { panic!("{found}") };
    assert_eq!(mode, Mode::Hold { complete: true });
    assert!((1.4..1.7).contains(&waited_s) && sent > 3, "{waited_s} s, {sent}");
}

#[test]
fn a_lost_query_is_asked_again() {
    let bench = Bench::new(ControllerOptions { lost_queries: 0.0, ..ControllerOptions::default() });
    let mut controller = bench.ready();
    let mut longest_s = 0.0_f64;
    for k in 1..=40 {
        bench.inject(ControllerFault::LostQuery);
        bench.go(&mut controller, [f64::from(k); 4], 600.0).unwrap();
        let until_s = bench.now_s() + 0.3;
        while bench.now_s() < until_s {
            bench.run(&mut controller, 0.01).unwrap();
            longest_s = longest_s.max(controller.waiting_s(bench.now_s()));
        }
    }
    assert!((0.08..=MotionSettings::default().late_s).contains(&longest_s), "{longest_s} s");
    // Opening asks again as well.
    let bench = Bench::new(ControllerOptions::default());
    bench.inject(ControllerFault::LostQuery);
    bench.open();
}

#[test]
fn bytes_that_are_no_lines_are_called_that() {
    let bench = Bench::new(ControllerOptions::default());
    let mut controller = bench.ready();
    bench.inject(ControllerFault::Babble);
    let found = bench.run(&mut controller, 4.0).unwrap_err();
    let words = found.to_string();
    assert!(matches!(found, MotionFault::Noise { .. } | MotionFault::Garbled { .. }), "{found}");
    assert!(words.contains("baud rate") && !words.contains("power"), "{words}");
    let bench = Bench::new(ControllerOptions::default());
    bench.inject(ControllerFault::Babble);
    let words = bench.open_with(&MotionSettings::default()).map(|_| ()).unwrap_err().to_string();
    assert!(words.contains("baud rate") && !words.contains("power"), "{words}");
}
