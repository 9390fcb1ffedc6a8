//! The fault campaign: what goes wrong with a robot at rest, in motion and while it homes, what
//! must happen, and within how many milliseconds.

use std::fmt::Write;
use std::sync::Arc;

use crate::support::rehearsal::{STEP_S, open, options};
use spinebench::base::{Plant, PlantError, Seed};
use spinebench::hardware::interrupt::Interrupt;
use spinebench::plants::Hardware;
use spinebench::simulators::{ControllerFault, Intervention, Simulator, TrackedBody, TrackerFault};

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
    /// The same, whenever the controller comes to mention it, which some things it does once a
    /// second.
    Eventually(&'static str),
    /// Nothing that the robot has to be held for.
    Nothing,
}

/// What breaks something.
type Breaks = Box<dyn Fn(&mut Simulator, &Interrupt) + Send + Sync>;

/// A fault, whether it ends by itself, and what must come of it in each phase.
struct Fault {
    name: &'static str,
    inject: Breaks,
    /// When it ends, after it has come, s; never if not finite.
    lasts_s: f64,
    expected: [Expected; 3],
}

use Expected::{Eventually, Held, Nothing, Stopped};

const CONTROLLER: Expected = Stopped("controller");
const ALL_STOP: [Expected; 3] = [CONTROLLER; 3];
const LOST: [Expected; 3] = [Stopped("tracking"), Stopped("tracking"), Stopped("tracking")];

/// Faults of the controller, its cable and its machine, that last.
fn of_the_controller() -> Vec<(&'static str, ControllerFault, [Expected; 3])> {
    use ControllerFault::*;
    let in_motion = [Nothing, CONTROLLER, CONTROLLER];
    let unless_homing = [CONTROLLER, CONTROLLER, Nothing];
    vec![
        ("controller says nothing", Silent, ALL_STOP),
        ("motion freezes, reports go on", Frozen, in_motion),
        ("cable pulled", Unplugged, ALL_STOP),
        ("power of the controller lost for a moment", Reboot, ALL_STOP),
        ("answers unreadable", Garbage, ALL_STOP),
        ("one answer unreadable", GarbledLine, [Nothing; 3]),
        ("answers a second late", SlowReplies(1.0), ALL_STOP),
        ("bytes that are no lines", Babble, ALL_STOP),
        ("a query lost", LostQuery, [Nothing; 3]),
        ("an ok lost", LostOk, in_motion),
        ("an ok twice", DoubledOk, in_motion),
        ("hard limit X", HardLimit(0), unless_homing),
        ("hard limit A", HardLimit(3), unless_homing),
        ("alarm without a cause", SpuriousAlarm(3), ALL_STOP),
        ("unknown alarm", SpuriousAlarm(77), ALL_STOP),
        ("line refused, error 2", StickyError(2), in_motion),
        ("axis X does not turn", DeadAxis(0), in_motion),
        ("axis A does not turn", DeadAxis(3), in_motion),
        ("switch X never closes", SwitchStuckOpen(0), [Nothing, Nothing, CONTROLLER]),
        ("switch A always closed", SwitchStuckClosed(3), ALL_STOP),
        ("position jumps by 2 mm", WrongPosition(1, 2.0), unless_homing),
        ("somebody presses hold", HoldButton, unless_homing),
        ("somebody halves all speeds", FeedOverride(50), ALL_STOP),
        ("reports without machine positions", WorkPositions, ALL_STOP),
        (
            "work offset of 5 mm",
            WorkOffset(2, 5.0),
            [Eventually("controller"), CONTROLLER, CONTROLLER],
        ),
    ]
}

/// Faults of the tracker that last.
fn of_the_tracker() -> Vec<(&'static str, TrackerFault, [Expected; 3])> {
    use TrackerFault::*;
    vec![
        ("tracker says nothing", Silent, LOST),
        ("tip hidden", Occluded(TrackedBody::Tip), LOST),
        ("base hidden", Occluded(TrackedBody::Base), LOST),
        ("tip's body removed in Motive", BodyGone, LOST),
        ("poses that are no numbers", NanPose, LOST),
        ("frames that cannot be read", Malformed, LOST),
        ("frames 300 ms late", Late(0.3), LOST),
        ("19 of 20 frames lost", Loss(0.95), LOST),
        ("one pose for ever", Frozen, [Nothing, Stopped("tracking"), Nothing]),
        (
            "tip frozen, with noise of 0.02 mm",
            FrozenTip(2e-5),
            [Nothing, Eventually("tracking"), Nothing],
        ),
        (
            "tip frozen, with noise of 0.5 mm",
            FrozenTip(5e-4),
            [Nothing, Eventually("tracking"), Nothing],
        ),
        ("frame numbers descend", Descending, LOST),
        ("quaternion of zeros", ZeroQuaternion, LOST),
        ("tip jumps by 150 mm", Jump(0.15), [Stopped("tip"); 3]),
        ("tip jumps by 60 mm", Jump(0.06), [Stopped("tip"), Stopped("tip"), Nothing]),
        ("bodies swapped", SwappedBodies, [Stopped("tip"); 3]),
        ("a second server with other poses", SecondServer, [Nothing; 3]),
        (
            "a second server at the same port",
            SameAddress { frames: 77_777, clock_s: 500.0, alone: false },
            LOST,
        ),
        (
            "the same, with a lower count",
            SameAddress { frames: -77_777, clock_s: -500.0, alone: false },
            LOST,
        ),
        ("the same, 0.4 s ahead", SameAddress { frames: 40, clock_s: 0.4, alone: false }, LOST),
        ("the same, 0.4 s behind", SameAddress { frames: -40, clock_s: -0.4, alone: false }, LOST),
        (
            "another server in its place",
            SameAddress { frames: 77_777, clock_s: 500.0, alone: true },
            LOST,
        ),
        ("10 % of the frames lost", Loss(0.1), [Nothing; 3]),
        ("frames up to 25 ms late", Jitter(0.025), [Nothing; 3]),
        ("frames out of order", OutOfOrder, [Nothing; 3]),
        ("frames twice", Duplicate, [Nothing; 3]),
        ("1 % of the frames lost", Loss(0.01), [Nothing; 3]),
    ]
}

/// Faults of the tracker that end, and how long they last, s.
fn passing() -> Vec<(&'static str, TrackerFault, f64, [Expected; 3])> {
    let held = [Held("tracking"), Held("tracking"), Nothing];
    vec![
        ("tracker says nothing for 70 ms", TrackerFault::Silent, 0.07, held),
        ("tracker says nothing for 120 ms", TrackerFault::Silent, 0.12, held),
        ("tracker says nothing for 190 ms", TrackerFault::Silent, 0.19, held),
        ("tip hidden for 120 ms", TrackerFault::Occluded(TrackedBody::Tip), 0.12, held),
    ]
}

fn faults() -> Vec<Fault> {
    let forever = f64::INFINITY;
    let mut all = Vec::new();
    for (name, fault, expected) in of_the_controller() {
        let inject: Breaks =
            Box::new(move |simulator, _| simulator.controller.inject(fault.clone()));
        all.push(Fault { name, inject, lasts_s: forever, expected });
    }
    let lasting = of_the_tracker()
        .into_iter()
        .map(|(name, fault, expected)| (name, fault, forever, expected));
    for (name, fault, lasts_s, expected) in lasting.chain(passing()) {
        let inject: Breaks = Box::new(move |simulator, _| simulator.tracker.inject(fault));
        all.push(Fault { name, inject, lasts_s, expected });
    }
    let inject: Breaks = Box::new(|_, interrupt| interrupt.raise());
    all.push(Fault {
        name: "Ctrl-C or SIGTERM",
        inject,
        lasts_s: forever,
        expected: [Stopped("interrupted"); 3],
    });
    all
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

fn play(fault: &Arc<Fault>, phase: Phase) -> Outcome {
    let mut plant = open(&options(), 7);
    let begun = match phase {
        Phase::Homing => Ok(()),
        _ => plant.reset(Seed(0)).map(|_| ()),
    };
    begun.unwrap();
    let inject_s = plan(&plant, fault);
    let error = match phase {
        Phase::Homing => {
            plant.reset(Seed(0)).map(|_| ()).and_then(|()| wander(&mut plant, 3, 0.0)).err()
        }
        // Some things a controller mentions once in a second or two.
        Phase::Rest => wander(&mut plant, 20, 0.0).err(),
        Phase::Motion => wander(&mut plant, 12, 0.0025).err(),
    };
    let events = plant.events();
    let after = || events.iter().filter(|event| event.time_s >= inject_s);
    let first = after().find(|event| ["held", "stopped"].contains(&event.state));
    let stop = after().find(|event| event.state == "stopped");
    let ms = |time_s: f64| 1e3 * (time_s - inject_s);
    let moved_s = plant.rehearsal().unwrap().with_simulator(|simulator| simulator.moved_s());
    Outcome {
        first: first.map(|event| (event.state, event.kind.to_owned(), ms(event.time_s))),
        stopped: stop.map(|event| (event.kind.to_owned(), ms(event.time_s))),
        moved_ms: ms(moved_s),
        error,
    }
}

/// Plans the fault and its end; when it comes, s.
fn plan(plant: &Hardware, fault: &Arc<Fault>) -> f64 {
    let rehearsal = plant.rehearsal().unwrap();
    let (interrupt, breaking, inject_s) =
        (rehearsal.interrupt(), Arc::clone(fault), plant.now_s() + AFTER_S);
    rehearsal.with_simulator(|simulator| {
        let breaks: Intervention =
            Box::new(move |simulator| (breaking.inject)(simulator, &interrupt));
        simulator.schedule(inject_s, breaks);
        if fault.lasts_s.is_finite() {
            simulator.schedule(
                inject_s + fault.lasts_s,
                Box::new(|simulator| simulator.tracker.clear_faults()),
            );
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

/// A fault may take a tick to show, and then the robot is held within one tick and stopped within
/// two; the limits are those of a robot that is told to move.
const HELD_MS: f64 = 2e3 * STEP_S;
const STOPPED_MS: f64 = 3e3 * STEP_S;

fn judge(outcome: &Outcome, expected: Expected, phase: Phase) -> bool {
    let prompt = |ms: f64, most_ms: f64| phase == Phase::Homing || ms <= most_ms;
    match expected {
        Stopped(kind) => {
            let stopped = outcome
                .stopped
                .as_ref()
                .is_some_and(|(found, ms)| *found == kind && prompt(*ms, STOPPED_MS));
            stopped && outcome.error.is_some() && prompt(outcome.moved_ms, HELD_MS)
        }
        Eventually(kind) => {
            outcome.error.is_some()
                && outcome.stopped.as_ref().is_some_and(|(found, _)| *found == kind)
        }
        Held(kind) => {
            let first = outcome.first.as_ref();
            let held = first.is_some_and(|(state, found, ms)| {
                *state == "held" && found == kind && prompt(*ms, HELD_MS)
            });
            held && outcome.error.is_none()
        }
        Nothing => outcome.error.is_none() && outcome.first.is_none(),
    }
}

/// Plans that the tip is hidden `times` times, for `hidden_s` of every `period_s`.
fn blink(plant: &Hardware, times: u32, period_s: f64, hidden_s: f64) {
    let begun_s = plant.now_s();
    plant.rehearsal().unwrap().with_simulator(|simulator| {
        for k in 1..=times {
            let hide_s = begun_s + period_s * f64::from(k);
            simulator.schedule(
                hide_s,
                Box::new(|simulator| {
                    simulator.tracker.inject(TrackerFault::Occluded(TrackedBody::Tip))
                }),
            );
            simulator.schedule(
                hide_s + hidden_s,
                Box::new(|simulator| simulator.tracker.clear_faults()),
            );
        }
    });
}

#[test]
fn a_robot_that_is_held_again_and_again_is_stopped() {
    let mut plant = open(&options(), 8);
    plant.reset(Seed(0)).unwrap();
    blink(&plant, 9, 0.5, 0.1);
    let Err(PlantError::Stopped(words)) = wander(&mut plant, 40, 0.0005) else {
        panic!("{:?}", plant.events())
    };
    assert!(words.contains("held 6 times within 10 s, expected at most 5"), "{words}");
    let holds = plant.events().iter().filter(|event| event.state == "held").count();
    assert_eq!(holds, 5, "{:?}", plant.events());
    // As often as that, but not within ten seconds.
    let mut plant = open(&options(), 8);
    plant.reset(Seed(0)).unwrap();
    blink(&plant, 9, 2.5, 0.1);
    wander(&mut plant, 130, 0.0002).unwrap();
    assert_eq!(
        plant.events().iter().filter(|event| event.state == "held").count(),
        9,
        "{:?}",
        plant.events()
    );
}

/// Axes that slow down for longer than a reset would wait are waited for.
#[test]
fn a_stop_keeps_the_position() {
    let mut plant = open(&options(), 9);
    plant.reset(Seed(0)).unwrap();
    plant.rehearsal().unwrap().with_simulator(|simulator| {
        (120..124).for_each(|k| {
            simulator.controller.inject(ControllerFault::WrongSettings(k, "40".to_owned()))
        });
    });
    let interrupt = plant.rehearsal().unwrap().interrupt();
    // Half way between two moves: which of the two comes first at the same moment is chance.
    let raise_s = plant.now_s() + AFTER_S + 0.05;
    plant.rehearsal().unwrap().with_simulator(|simulator| {
        simulator.schedule(raise_s, Box::new(move |_| interrupt.raise()))
    });
    let stopped = wander(&mut plant, 12, 0.0025).unwrap_err();
    assert!(matches!(stopped, PlantError::Stopped(_)), "{stopped:?}");
    plant.run_diagnostics(2.0);
    let moved_ms = 1e3
        * (plant.rehearsal().unwrap().with_simulator(|simulator| simulator.moved_s()) - raise_s);
    assert!(moved_ms > 200.0, "{moved_ms} ms: too short to tell");
    let homed = plant.rehearsal().unwrap().with_simulator(|simulator| simulator.controller.homed());
    assert!(
        homed && plant.with_rig(|rig| !rig.controller().homing_required()),
        "{:?}",
        plant.events()
    );
}

#[test]
fn every_fault_ends_in_a_robot_that_stands() {
    let mut table = String::from(
        "fault                                     | phase  | first                  |    ms | \
         stopped      |    ms | last motion, ms\n",
    );
    let mut wrong = Vec::new();
    for fault in faults().into_iter().map(Arc::new) {
        for (phase, expected) in
            [Phase::Rest, Phase::Motion, Phase::Homing].into_iter().zip(fault.expected)
        {
            let outcome = play(&fault, phase);
            let (first, first_ms) = outcome
                .first
                .as_ref()
                .map_or(("–".to_owned(), String::new()), |(state, kind, ms)| {
                    (format!("{state} [{kind}]"), format!("{ms:.0}"))
                });
            let (stop, stop_ms) =
                outcome.stopped.as_ref().map_or(("–".to_owned(), String::new()), |(kind, ms)| {
                    (kind.clone(), format!("{ms:.0}"))
                });
            let good = judge(&outcome, expected, phase);
            let mark = if good { "" } else { "  WRONG" };
            writeln!(
                table,
                "{:42}| {phase:6?} | {first:22} | {first_ms:>5} | {stop:12} | {stop_ms:>5} | \
                 {:.0}{mark}",
                fault.name, outcome.moved_ms
            )
            .unwrap();
            if !good {
                wrong.push(format!(
                    "{} in {phase:?}: expected {expected:?}, found {outcome:?}",
                    fault.name
                ));
            }
        }
    }
    println!("{table}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
