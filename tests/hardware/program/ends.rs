//! However a session ends, the robot stands where it was told to be, and the next one goes on.

use super::bench::{Bench, Entry, ServedSimulator, target_mm, until};
use super::in_process::SLOWED;
use spinebench::data::Recording;

const COLLECT: &str = "collect --plant served.yaml --commands in.csv --out out.csv";
const TRIALS: usize = 3;
const ROWS: usize = 16;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0.0002");
    bench.put_commands("in.csv", TRIALS, ROWS);
    bench
}

/// Waits until one trial has been kept and the second one is under way.
fn in_the_second_trial(bench: &Bench, served: &ServedSimulator) {
    until(|| bench.path("out.part.csv").exists().then_some(()));
    let before = served.moves();
    // The way home takes a few moves, and then come those of the trial.
    until(|| (served.moves() > before + 8).then_some(()));
}

/// The screws stand within the last tick that was sent.
fn stands_within_the_last_tick(log: &[Entry]) {
    let targets: Vec<[f64; 4]> = log.iter().filter_map(|entry| target_mm(&entry.what)).collect();
    let [from, to] = [targets[targets.len() - 2], targets[targets.len() - 1]];
    let screws_mm = log[log.len() - 1].screws_mm;
    for axis in 0..4 {
        let (low, high) = (from[axis].min(to[axis]) - 0.01, from[axis].max(to[axis]) + 0.01);
        assert!(
            (low..=high).contains(&screws_mm[axis]),
            "axis {axis}: {screws_mm:?}, sent from {from:?} to {to:?}"
        );
    }
}

/// A hold was heard, then a reset, and no move after it; the log.
fn was_held(served: &ServedSimulator) -> Vec<Entry> {
    // The last bytes of a program may still be on their way.
    until(|| served.log().iter().any(|entry| entry.what == "heard ^X").then_some(()));
    let log = served.stands();
    let last = |what: &str| log.iter().rposition(|entry| entry.what == what);
    let held = last("heard !").expect("no hold was heard");
    assert!(last("heard ^X").expect("no reset was heard") > held);
    assert!(
        log[held..].iter().all(|entry| target_mm(&entry.what).is_none()),
        "a move after the hold"
    );
    log
}

/// The same command finishes the recording, and keeps what there was.
fn goes_on(bench: &Bench) {
    let kept = Recording::read(&bench.path("out.part.csv")).unwrap();
    bench.run(COLLECT).is(0, &["resuming after 1 of 3 trials"]);
    let whole = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!((whole.len(), whole.trials().len()), (TRIALS * ROWS, TRIALS));
    assert_eq!(whole.tip_m.unwrap()[..ROWS], kept.tip_m.unwrap());
    assert!(!bench.path("out.part.csv").exists());
}

fn interrupted_by(signal: &str) {
    let bench = bench();
    let served = bench.serve("plant.yaml", "served.yaml");
    let collect = bench.start(COLLECT);
    in_the_second_trial(&bench, &served);
    collect.signal(signal);
    collect
        .end()
        .is(1, &["trial 1: robot stopped: the program was interrupted", "1 of 3 trials are kept"]);
    stands_within_the_last_tick(&was_held(&served));
    assert!(!bench.is_latched(), "an interrupt is no fault");
    goes_on(&bench);
}

#[test]
fn an_interrupt_holds_the_robot() {
    interrupted_by("INT");
}

#[test]
fn a_termination_holds_the_robot() {
    interrupted_by("TERM");
}

/// A program that is paused, as a suspended computer pauses it, measures rows at other times than
/// they say: the trial is not kept. The robot has done nothing wrong.
#[test]
fn a_pause_ends_the_trial() {
    let bench = bench();
    // More than a busy computer is late by, and less than the pause.
    let plant = bench.text("plant.yaml").replace("max_late_ticks: 50", "max_late_ticks: 4");
    bench.put("plant.yaml", &plant);
    let served = bench.serve("plant.yaml", "served.yaml");
    let collect = bench.start(COLLECT);
    in_the_second_trial(&bench, &served);
    collect.signal("STOP");
    std::thread::sleep(std::time::Duration::from_secs(2));
    collect.signal("CONT");
    let words = ["trial 1: tick late: ", "expected at most 800 ms", "1 of 3 trials are kept"];
    collect.end().is(1, &words);
    stands_within_the_last_tick(&served.stands());
    assert!(!bench.is_latched() && !bench.is_distrusted(), "a pause is no fault of the robot");
    goes_on(&bench);
}

#[test]
fn a_killed_program_leaves_a_robot_that_ends_its_tick() {
    let bench = bench();
    let served = bench.serve("plant.yaml", "served.yaml");
    let collect = bench.start(COLLECT);
    in_the_second_trial(&bench, &served);
    collect.signal("KILL");
    assert_eq!(collect.end().status, None);
    stands_within_the_last_tick(&served.stands());
    assert!(!bench.is_latched());
    goes_on(&bench);
}

#[test]
fn a_panic_holds_the_robot() {
    let bench = bench();
    let mut served = bench.serve("plant.yaml", "served.yaml");
    let failing = bench.start_test("program::in_process::panics_in_motion", "served.yaml");
    until(|| served.log().iter().any(|entry| entry.what.contains("X40.000")).then_some(()));
    served.stands();
    // Slow enough for the last move to last until a busy computer comes to hold it.
    served.wish("set 110 10");
    bench.put(SLOWED, "");
    failing.end().is(101, &["whoever decides has failed"]);
    stands_within_the_last_tick(&was_held(&served));
}

#[test]
fn a_pulled_cable_stops_until_somebody_has_looked() {
    let bench = bench();
    let mut served = bench.serve("plant.yaml", "served.yaml");
    let collect = bench.start(COLLECT);
    in_the_second_trial(&bench, &served);
    served.wish("unplug");
    collect
        .end()
        .is(1, &["trial 1: robot stopped: serial line to the controller lost", "spinebench arm"]);
    stands_within_the_last_tick(&served.stands());
    assert!(bench.is_latched());
    drop(served);
    // Plugged in again.
    let _served = bench.serve("plant.yaml", "served.yaml");
    bench.run(COLLECT).is(1, &["robot `robot` is stopped", "serial line to the controller lost"]);
    bench.run("arm --plant served.yaml").is(0, &["armed: `robot` was stopped"]);
    bench.run("arm --plant served.yaml").is(0, &["`robot` was not stopped"]);
    goes_on(&bench);
    let log = bench.text("spinebench/robot.log");
    assert!(log.contains("stopped: ") && log.contains("armed by the operator"), "{log}");
}

/// A motor loses steps, and its controller does not know: home is elsewhere, and the trial is not
/// kept.
#[test]
fn a_trial_in_which_steps_are_lost_is_not_kept() {
    let bench = bench();
    let mut served = bench.serve("plant.yaml", "served.yaml");
    let collect = bench.start(COLLECT);
    in_the_second_trial(&bench, &served);
    served.wish("miss X 2");
    collect.end().is(
        1,
        &[
            "trial 1: robot stopped: the rest position of the tip at home differs by ",
            "1 of 3 trials are kept",
        ],
    );
    assert!(bench.is_latched() && bench.is_distrusted());
    bench.run("arm --plant served.yaml").is(0, &["armed: `robot`", "homed before its next motion"]);
    goes_on(&bench);
    assert_eq!(served.homings(), 2);
}

/// Steps may have been lost although the controller says that it is homed: another program homes
/// the robot, however often it is armed.
#[test]
fn after_a_stop_the_position_is_found_anew() {
    let bench = bench();
    let mut served = bench.serve("plant.yaml", "served.yaml");
    let collect = bench.start(COLLECT);
    in_the_second_trial(&bench, &served);
    assert_eq!((served.homings(), bench.is_distrusted()), (1, false));
    // The motors and the controller are as they were: only the tip is elsewhere, and moves meanwhile.
    served.wish("jump 0.15");
    collect
        .end()
        .is(1, &["trial 1: robot stopped: the measured tip jumped by 1", "spinebench arm"]);
    assert!(bench.is_latched() && bench.is_distrusted());
    served.stands();
    served.wish("repair");
    served.wish("tell homed");
    bench.run("arm --plant served.yaml").is(0, &["armed: `robot`", "homed before its next motion"]);
    assert!(!bench.is_latched() && bench.is_distrusted(), "arming finds no position");
    // What else it says depends on how busy the computer is.
    let found = |words: &str| {
        assert!(bench.run("doctor --plant served.yaml").said.contains(words), "no `{words}`")
    };
    found("axes: not homed");
    assert!(bench.is_distrusted() && served.homings() == 1, "nothing was moved");
    goes_on(&bench);
    assert_eq!((served.homings(), bench.is_distrusted()), (2, false));
    // Now it is known.
    found("axes: homed");
    bench.run("collect --plant served.yaml --commands in.csv --out again.csv").is(0, &[]);
    assert_eq!(served.homings(), 2);
}

#[test]
fn a_closed_loop_runs_over_the_terminal() {
    let bench = bench();
    let served = bench.serve("plant.yaml", "served.yaml");
    bench
        .start_test("program::in_process::reaches_a_target", "served.yaml")
        .end()
        .is(0, &["1 passed"]);
    assert!(served.moves() >= 20, "{}", served.moves());
}
