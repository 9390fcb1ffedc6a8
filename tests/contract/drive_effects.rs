//! Effects on the drives of a simulated robot: they act at their time, and remember what the drive
//! did while it followed.

use spinebench::base::{Plant, Seed, TendonCommand, distance_m};
use spinebench::effects::{EffectSpec, Model};
use spinebench::plants::{Simulated, SimulatedOptions};

fn plant(effect: &str) -> Simulated {
    let parse = serde_yaml::Deserializer::from_str;
    let text = include_str!("../../models/nominal.yaml");
    let model: Model = serde_yaml::with::singleton_map_recursive::deserialize(parse(text)).unwrap();
    let effects: Vec<EffectSpec> =
        serde_yaml::with::singleton_map_recursive::deserialize(parse(effect)).unwrap();
    Simulated::new(&model, &effects, SimulatedOptions::default())
}

const BENT: [f64; 4] = [0.01, 0.0, -0.01, 0.0];

/// One step of 5 s is as good as 25 of 0.2 s, and at its end a delay of 0.1 s is long over.
#[test]
fn a_delay_does_not_depend_on_how_long_commands_are_held() {
    let (mut late, mut prompt, mut ticks) =
        (plant("- delay: {time_s: 0.1}"), plant("[]"), plant("- delay: {time_s: 0.1}"));
    for each in [&mut late, &mut prompt, &mut ticks] {
        each.reset(Seed(0)).unwrap();
    }
    for _ in 0..25 {
        ticks.step(&BENT).unwrap();
    }
    late.set_step_s(5.0);
    prompt.set_step_s(5.0);
    let (long, at_once, short) =
        (late.step(&BENT).unwrap(), prompt.step(&BENT).unwrap(), ticks.step(&BENT).unwrap());
    assert!(distance_m(&long.tip_m, &at_once.tip_m) < 1e-6, "{long:?} {at_once:?}");
    assert!(distance_m(&long.tip_m, &short.tip_m) < 1e-6, "{long:?} {short:?}");
    // Within a tick the command acts from its delay on: as when it is held back for half of it.
    let (mut late, mut by_hand) = (plant("- delay: {time_s: 0.1}"), plant("[]"));
    late.reset(Seed(0)).unwrap();
    by_hand.reset(Seed(0)).unwrap();
    by_hand.set_step_s(0.1);
    by_hand.step(&[0.0; 4]).unwrap();
    let expected = by_hand.step(&BENT).unwrap();
    // Time steps fall elsewhere, so to the accuracy that they are chosen for.
    assert!(distance_m(&late.step(&BENT).unwrap().tip_m, &expected.tip_m) < 1e-4);
}

#[test]
fn at_rest_a_delay_is_over() {
    let (mut late, mut prompt) = (plant("- delay: {time_s: 10}"), plant("[]"));
    late.reset(Seed(0)).unwrap();
    prompt.reset(Seed(0)).unwrap();
    let commands = BENT.map(TendonCommand::Pull);
    assert_eq!(late.settle(&commands).unwrap().tip_m, prompt.settle(&commands).unwrap().tip_m);
    // And the next command is late by its delay, from there.
    let held = late.step(&[0.0; 4]).unwrap();
    assert!(distance_m(&held.tip_m, &prompt.step(&BENT).unwrap().tip_m) < 1e-7, "{held:?}");
}

/// A drive that followed the shape for a while and is then told to stay where it stands does not
/// jump back to zero.
#[test]
fn a_drive_that_followed_goes_on_from_where_it_stands() {
    // A stiff spine, so that the opposite tendon has to be let out.
    let mut robot = plant("[{delay: {time_s: 0.2}}, {spine_compressibility: {scale: 0.01}}]");
    robot.reset(Seed(0)).unwrap();
    let half = [
        TendonCommand::Pull(0.012),
        TendonCommand::Pull(0.0),
        TendonCommand::Follow,
        TendonCommand::Follow,
    ];
    let mut seen = robot.drive(&half).unwrap();
    for _ in 0..20 {
        seen = robot.drive(&half).unwrap();
    }
    assert!(seen.pulls_m[2] < -0.005, "{seen:?}");
    let after = robot.step(&seen.pulls_m).unwrap();
    assert!(distance_m(&seen.tip_m, &after.tip_m) < 5e-5, "{seen:?} {after:?}");
    assert!(after.tensions_n.unwrap()[2] < 0.1);
}
