//! The fault campaign: what goes wrong with a robot at rest, in motion and while it homes, what must happen, and within
//! how many milliseconds.

mod hardware_support;

use std::fmt::Write;

use hardware_support::{STEP_S, open, options};
use spinebench::base::{Plant, PlantError, Seed};
use spinebench::hardware::bench::{ControllerFault, Plan, TrackerFault, World};
use spinebench::hardware::interrupt::Interrupt;
use spinebench::plants::Hardware;

/// When the fault comes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Rest,
    Motion,
    Homing,
}

/// What must come of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Expected {
    /// Stopped for the cause of this kind.
    Stopped(&'static str),
    /// Held for the cause of this kind and active again once the fault is gone.
    Held(&'static str),
    /// The same, whenever the controller comes to mention it, which some things it does once a second.
    Eventually(&'static str),
    /// Nothing that the robot has to be held for.
    Nothing,
}

/// A fault, whether it ends by itself, and what must come of it in each phase.
struct Fault {
    name: &'static str,
    inject: fn(&mut World, &Interrupt),
    /// When it ends, after it has come, s; never if not finite.
    lasts_s: f64,
    expected: [Expected; 3],
}

use Expected::{Eventually, Held, Nothing, Stopped};

const CONTROLLER: Expected = Stopped("controller");
const ALL_STOP: [Expected; 3] = [CONTROLLER; 3];
const LOST: [Expected; 3] = [Stopped("tracking"), Stopped("tracking"), Stopped("tracking")];

fn faults() -> Vec<Fault> {
    let controller =
        |name, inject: fn(&mut World, &Interrupt), expected| Fault { name, inject, lasts_s: f64::INFINITY, expected };
    let tracker = controller;
    let passing = |name, inject: fn(&mut World, &Interrupt), expected| Fault { name, inject, lasts_s: 0.12, expected };
    vec![
        controller("controller says nothing", |w, _| w.controller.inject(ControllerFault::Silent), ALL_STOP),
        controller("cable pulled", |w, _| w.controller.inject(ControllerFault::Unplugged), ALL_STOP),
        controller(
            "power of the controller lost for a moment",
            |w, _| w.controller.inject(ControllerFault::Reboot),
            ALL_STOP,
        ),
        controller("answers unreadable", |w, _| w.controller.inject(ControllerFault::Garbage), ALL_STOP),
        controller("one answer unreadable", |w, _| w.controller.inject(ControllerFault::GarbledLine), [Nothing; 3]),
        controller("answers a second late", |w, _| w.controller.inject(ControllerFault::SlowReplies(1.0)), ALL_STOP),
        controller(
            "an ok lost",
            |w, _| w.controller.inject(ControllerFault::LostOk),
            [Nothing, CONTROLLER, CONTROLLER],
        ),
        controller(
            "an ok twice",
            |w, _| w.controller.inject(ControllerFault::DoubledOk),
            [Nothing, CONTROLLER, CONTROLLER],
        ),
        controller(
            "hard limit X",
            |w, _| w.controller.inject(ControllerFault::HardLimit(0)),
            [CONTROLLER, CONTROLLER, Nothing],
        ),
        controller(
            "hard limit A",
            |w, _| w.controller.inject(ControllerFault::HardLimit(3)),
            [CONTROLLER, CONTROLLER, Nothing],
        ),
        controller("alarm without a cause", |w, _| w.controller.inject(ControllerFault::SpuriousAlarm(3)), ALL_STOP),
        controller("unknown alarm", |w, _| w.controller.inject(ControllerFault::SpuriousAlarm(77)), ALL_STOP),
        controller(
            "line refused, error 2",
            |w, _| w.controller.inject(ControllerFault::StickyError(2)),
            [Nothing, CONTROLLER, CONTROLLER],
        ),
        controller(
            "axis X does not turn",
            |w, _| w.controller.inject(ControllerFault::DeadAxis(0)),
            [Nothing, CONTROLLER, CONTROLLER],
        ),
        controller(
            "axis A does not turn",
            |w, _| w.controller.inject(ControllerFault::DeadAxis(3)),
            [Nothing, CONTROLLER, CONTROLLER],
        ),
        controller(
            "switch X never closes",
            |w, _| w.controller.inject(ControllerFault::SwitchStuckOpen(0)),
            [Nothing, Nothing, CONTROLLER],
        ),
        controller(
            "switch A always closed",
            |w, _| w.controller.inject(ControllerFault::SwitchStuckClosed(3)),
            [CONTROLLER, CONTROLLER, CONTROLLER],
        ),
        controller(
            "position jumps by 2 mm",
            |w, _| w.controller.inject(ControllerFault::WrongPosition(1, 2.0)),
            [CONTROLLER, CONTROLLER, Nothing],
        ),
        controller(
            "work offset of 5 mm",
            |w, _| w.controller.inject(ControllerFault::WorkOffset(2, 5.0)),
            [Eventually("controller"), CONTROLLER, CONTROLLER],
        ),
        tracker("tracker says nothing", |w, _| w.tracker.inject(TrackerFault::Silent), LOST),
        passing(
            "tracker says nothing for 120 ms",
            |w, _| w.tracker.inject(TrackerFault::Silent),
            [Held("tracking"), Held("tracking"), Nothing],
        ),
        tracker(
            "tip hidden",
            |w, _| w.tracker.inject(TrackerFault::Occluded(spinebench::hardware::bench::FakeBody::Tip)),
            LOST,
        ),
        tracker(
            "base hidden",
            |w, _| w.tracker.inject(TrackerFault::Occluded(spinebench::hardware::bench::FakeBody::Base)),
            LOST,
        ),
        passing(
            "tip hidden for 120 ms",
            |w, _| w.tracker.inject(TrackerFault::Occluded(spinebench::hardware::bench::FakeBody::Tip)),
            [Held("tracking"), Held("tracking"), Nothing],
        ),
        tracker("tip's body removed in Motive", |w, _| w.tracker.inject(TrackerFault::BodyGone), LOST),
        tracker("poses that are no numbers", |w, _| w.tracker.inject(TrackerFault::NanPose), LOST),
        tracker("frames that cannot be read", |w, _| w.tracker.inject(TrackerFault::Malformed), LOST),
        tracker("frames 300 ms late", |w, _| w.tracker.inject(TrackerFault::Late(0.3)), LOST),
        tracker("19 of 20 frames lost", |w, _| w.tracker.inject(TrackerFault::Loss(0.95)), LOST),
        tracker("tip jumps by 150 mm", |w, _| w.tracker.inject(TrackerFault::Jump(0.15)), [Stopped("tip"); 3]),
        tracker("bodies swapped", |w, _| w.tracker.inject(TrackerFault::SwappedBodies), [Stopped("tip"); 3]),
        tracker("a second server with other poses", |w, _| w.tracker.inject(TrackerFault::SecondServer), [Nothing; 3]),
        tracker("frames out of order", |w, _| w.tracker.inject(TrackerFault::OutOfOrder), [Nothing; 3]),
        tracker("frames twice", |w, _| w.tracker.inject(TrackerFault::Duplicate), [Nothing; 3]),
        tracker("1 % of the frames lost", |w, _| w.tracker.inject(TrackerFault::Loss(0.01)), [Nothing; 3]),
        controller("Ctrl-C or SIGTERM", |_, interrupt| interrupt.raise(), [Stopped("interrupted"); 3]),
    ]
}

/// What came of a fault.
#[derive(Debug)]
struct Outcome {
    /// First state other than active, with the kind of its cause and how long after the fault, ms.
    first: Option<(&'static str, String, f64)>,
    /// The same of a stop.
    stopped: Option<(String, f64)>,
    /// From the fault to the last motion of a screw, ms.
    moved_ms: f64,
    error: Option<PlantError>,
}

/// When the fault comes, after the phase has begun, s.
const AFTER_S: f64 = 1.05;

fn play(fault: &Fault, phase: Phase) -> Outcome {
    let mut plant = open(&options(), 7);
    let begun = match phase {
        Phase::Homing => Ok(()),
        _ => plant.reset(Seed(0)).map(|_| ()),
    };
    begun.unwrap();
    let inject_s = plan(&plant, fault);
    let error = match phase {
        Phase::Homing => plant.reset(Seed(0)).map(|_| ()).and_then(|()| wander(&mut plant, 3, 0.0)).err(),
        Phase::Rest => wander(&mut plant, 12, 0.0).err(),
        Phase::Motion => wander(&mut plant, 12, 0.0025).err(),
    };
    let events = plant.events();
    let after = || events.iter().filter(|event| event.time_s >= inject_s);
    let first = after().find(|event| ["held", "stopped"].contains(&event.state));
    let stop = after().find(|event| event.state == "stopped");
    let ms = |time_s: f64| 1e3 * (time_s - inject_s);
    let moved_s = plant.stage().unwrap().with(|world| world.moved_s());
    Outcome {
        first: first.map(|event| (event.state, event.kind.to_owned(), ms(event.time_s))),
        stopped: stop.map(|event| (event.kind.to_owned(), ms(event.time_s))),
        moved_ms: ms(moved_s),
        error,
    }
}

/// Plans the fault and its end; when it comes, s.
fn plan(plant: &Hardware, fault: &Fault) -> f64 {
    let stage = plant.stage().unwrap();
    let (interrupt, inject, inject_s) = (stage.interrupt(), fault.inject, plant.now_s() + AFTER_S);
    stage.with(|world| {
        let breaks: Plan = Box::new(move |world| inject(world, &interrupt));
        world.at(inject_s, breaks);
        if fault.lasts_s.is_finite() {
            world.at(inject_s + fault.lasts_s, Box::new(|world| world.tracker.calm()));
        }
    });
    inject_s
}

/// Steps of the same command, or of one that changes by `step_m` a tick.
fn wander(plant: &mut Hardware, ticks: usize, step_m: f64) -> Result<(), PlantError> {
    for k in 1..=ticks {
        let pull_m = step_m * k as f64;
        plant.step(&[pull_m, -0.5 * pull_m, -pull_m, 0.5 * pull_m])?;
    }
    Ok(())
}

/// A fault may take a tick to show, and then the robot is held within one tick and stopped within two; the limits are
/// those of a robot that is told to move.
const HELD_MS: f64 = 2e3 * STEP_S;
const STOPPED_MS: f64 = 3e3 * STEP_S;

fn judge(outcome: &Outcome, expected: Expected, phase: Phase) -> bool {
    let prompt = |ms: f64, most_ms: f64| phase == Phase::Homing || ms <= most_ms;
    match expected {
        Stopped(kind) => {
            let stopped = outcome.stopped.as_ref().is_some_and(|(found, ms)| *found == kind && prompt(*ms, STOPPED_MS));
            stopped && outcome.error.is_some() && prompt(outcome.moved_ms, HELD_MS)
        }
        Eventually(kind) => {
            outcome.error.is_some() && outcome.stopped.as_ref().is_some_and(|(found, _)| *found == kind)
        }
        Held(kind) => {
            let first = outcome.first.as_ref();
            let held =
                first.is_some_and(|(state, found, ms)| *state == "held" && found == kind && prompt(*ms, HELD_MS));
            held && outcome.error.is_none()
        }
        Nothing => outcome.error.is_none() && outcome.stopped.is_none(),
    }
}

#[test]
fn every_fault_ends_in_a_robot_that_stands() {
    let mut table = String::from(
        "fault                                     | phase  | first                  |    ms | stopped      |    ms | last motion, ms\n",
    );
    let mut wrong = Vec::new();
    for fault in faults() {
        for (phase, expected) in [Phase::Rest, Phase::Motion, Phase::Homing].into_iter().zip(fault.expected) {
            let outcome = play(&fault, phase);
            let (first, first_ms) =
                outcome.first.as_ref().map_or(("–".to_owned(), String::new()), |(state, kind, ms)| {
                    (format!("{state} [{kind}]"), format!("{ms:.0}"))
                });
            let (stop, stop_ms) = outcome
                .stopped
                .as_ref()
                .map_or(("–".to_owned(), String::new()), |(kind, ms)| (kind.clone(), format!("{ms:.0}")));
            let good = judge(&outcome, expected, phase);
            let mark = if good { "" } else { "  WRONG" };
            writeln!(
                table,
                "{:42}| {phase:6?} | {first:22} | {first_ms:>5} | {stop:12} | {stop_ms:>5} | {:.0}{mark}",
                fault.name, outcome.moved_ms
            )
            .unwrap();
            if !good {
                wrong.push(format!("{} in {phase:?}: expected {expected:?}, found {outcome:?}", fault.name));
            }
        }
    }
    println!("{table}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
