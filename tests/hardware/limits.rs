//! Whatever decides, nothing outside the limits reaches the screws, and an hour of work needs no
//! help.

use crate::support::rehearsal::{STEP_S, open, options};
use rand::RngExt;
use spinebench::base::{Plant, PlantError, Seed, TendonCommand};
use spinebench::hardware::safety::SafetyLimits;

/// A number that a broken policy may give: mostly near the last one, sometimes anything.
fn wild(random: &mut impl RngExt, near_m: f64, reach_m: f64) -> f64 {
    match random.random_range(0..20) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => f64::NEG_INFINITY,
        3 => f64::from_bits(random.random()),
        4 => random.random_range(-0.1..0.1),
        _ => near_m + random.random_range(-reach_m..reach_m),
    }
}

#[test]
fn a_million_commands_are_admitted_only_within_the_limits() {
    let limits = SafetyLimits::default();
    let mut random = Seed(11).rng();
    let mut last_m = [0.0_f64; 4];
    let mut admitted = 0;
    for _ in 0..1_000_000 {
        let pulls_m: [f64; 4] =
            std::array::from_fn(|tendon| wild(&mut random, last_m[tendon], 0.004));
        if limits.check_command(&pulls_m, &last_m, STEP_S, 1).is_err() {
            continue;
        }
        admitted += 1;
        for tendon in 0..4 {
            assert!(
                pulls_m[tendon].abs() <= 0.03 + 1e-9
                    && (pulls_m[tendon] - last_m[tendon]).abs() <= 0.003 + 1e-9
            );
        }
        for pair in 0..2 {
            let (sum, before) =
                (pulls_m[pair] + pulls_m[pair + 2], last_m[pair] + last_m[pair + 2]);
            assert!(
                sum <= before.max(0.03) + 1e-9 && sum >= before.min(-0.02) - 1e-9,
                "{pulls_m:?} after {last_m:?}"
            );
        }
        last_m = pulls_m;
    }
    assert!(admitted > 10_000, "{admitted}");
}

#[test]
fn a_wild_policy_moves_no_screw_out_of_bounds() {
    let mut plant = open(&options(), 3);
    let mut random = Seed(12).rng();
    let mut last_m = plant.reset(Seed(0)).unwrap().pulls_m;
    let (mut moved, mut refused) = (0, 0);
    for _ in 0..3000 {
        let pulls_m: Vec<f64> =
            last_m.iter().map(|&near_m| wild(&mut random, near_m, 0.0025)).collect();
        match plant.step(&pulls_m) {
            Ok(seen) => (moved, last_m) = (moved + 1, seen.pulls_m),
            Err(PlantError::Refused(_) | PlantError::Solver(_)) => refused += 1,
            Err(other) => panic!("{other}"),
        }
        let screws_mm = plant
            .rehearsal()
            .unwrap()
            .with_simulator(|simulator| simulator.controller.position_mm());
        assert!(screws_mm.iter().all(|mm| (-0.01..=60.01).contains(mm)), "{screws_mm:?}");
        let commanded_m = plant.with_rig(|rig| rig.commanded_m());
        assert_eq!(commanded_m.to_vec(), last_m, "a refused command has left something behind");
    }
    assert!(moved > 300 && refused > 300, "{moved} moved, {refused} refused");
}

/// Tendons that follow waive nothing of what the others keep to, and nothing moves before that is
/// judged.
#[test]
fn a_tendon_that_follows_waives_no_limit_of_the_others() {
    let mut plant = open(&options(), 5);
    plant.reset(Seed(0)).unwrap();
    let follow = TendonCommand::Follow;
    for asked_m in [0.05, -0.031, f64::NAN, f64::INFINITY] {
        let before_mm = plant
            .rehearsal()
            .unwrap()
            .with_simulator(|simulator| simulator.controller.position_mm());
        let commands = [TendonCommand::Pull(asked_m), TendonCommand::Pull(0.001), follow, follow];
        let Err(PlantError::Refused(words)) = plant.drive(&commands) else {
            panic!("{asked_m} was not refused")
        };
        assert!(words.contains("tendon 1"), "{words}");
        assert_eq!(
            plant
                .rehearsal()
                .unwrap()
                .with_simulator(|simulator| simulator.controller.position_mm()),
            before_mm
        );
    }
    let seen = plant
        .drive(&[TendonCommand::Pull(0.002), TendonCommand::Pull(0.001), follow, follow])
        .unwrap();
    assert!(seen.valid);
}

/// The sum of antagonists is known only once the model has moved the tendons that follow: it must
/// not stay there.
#[test]
fn a_command_refused_for_its_antagonists_leaves_the_model_where_it_was() {
    let follow = TendonCommand::Follow;
    let after = |refused: Option<[TendonCommand; 4]>| {
        let mut plant = open(&options(), 5);
        plant.reset(Seed(0)).unwrap();
        if let Some(commands) = refused {
            let Err(PlantError::Refused(words)) = plant.drive(&commands) else {
                panic!("not refused")
            };
            assert!(words.contains("antagonist"), "{words}");
        }
        plant
            .drive(&[TendonCommand::Pull(0.002), TendonCommand::Pull(0.001), follow, follow])
            .unwrap()
            .pulls_m
    };
    let both = TendonCommand::Pull(0.018);
    assert_eq!(after(Some([both, follow, both, follow])), after(None));
}

#[test]
fn ten_minutes_with_lost_frames_miss_nothing() {
    lost_frames_miss_nothing(600.0);
}

#[test]
#[ignore = "long; `make campaign` runs it"]
fn campaign_an_hour_with_lost_frames_misses_nothing() {
    lost_frames_miss_nothing(3600.0);
}

fn lost_frames_miss_nothing(duration_s: f64) {
    let mut options = options();
    options.rehearsal.as_mut().unwrap().loss = 0.01;
    options.rehearsal.as_mut().unwrap().noise_m = 0.0005;
    let mut plant = open(&options, 4);
    let begun_s = plant.now_s();
    let mut invalid = 0;
    while plant.now_s() - begun_s < duration_s {
        plant.reset(Seed(0)).unwrap();
        for k in 0..250 {
            let angle = 0.05 * f64::from(k);
            let (x, y) = (0.012 * angle.sin(), 0.012 * (1.0 - angle.cos()));
            invalid += usize::from(!plant.step(&[x, y, -x, -y]).unwrap().valid);
        }
    }
    let status = plant.with_rig(|rig| rig.tracking().status().clone());
    println!(
        "{} ticks, {} frames, {} lost",
        plant.timing().jitter.count(),
        status.received,
        status.lost
    );
    assert!(status.lost as f64 > 0.005 * status.received as f64, "{status:?}");
    assert_eq!((invalid, plant.timing().missed, plant.timing().held), (0, 0, 0));
    assert_eq!(plant.events().len(), 2, "{:?}", plant.events());
}
