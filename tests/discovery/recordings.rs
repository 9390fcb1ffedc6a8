//! What recordings may be like: without noise, of another simulator, with markers on the base, or
//! of no use.

use spinebench::base::Rows;
use spinebench::data::findings::Verdict;
use spinebench::data::recording::Pose;
use spinebench::data::{Actuation, Recording};
use spinebench::discovery::{Discovery, DiscoveryError, Options, discover};
use spinebench::effects::{BodyPoint, Model};
use spinebench::tasks::{SimulationOptions, simulate_recording};

use super::hidden::{NOISE_M, chain, found, names, nominal, part, recorded, told, trials, twin};

/// A recording that was simulated, without noise: it is as wrong as the simulator's steps, the same
/// in every trial.
#[test]
#[ignore = "make campaign"]
fn a_recording_without_noise_is_one_like_others() {
    let commands = trials(&twin("nothing"), 0, 6);
    let with_steps = |effects: &str, motion_tolerance_m: f64| {
        let mut model = Model { effects: crate::support::rods::effects(effects), ..nominal() };
        model.robot.resolution.motion_tolerance_m = motion_tolerance_m;
        let recording = simulate_recording(&model, &commands, &SimulationOptions::default());
        found(&Recording { tip_quaternion: None, ..recording }, &Options::default())
    };
    let simulated =
        |effects: &str| with_steps(effects, nominal().robot.resolution.motion_tolerance_m);
    let nothing = simulated("[]");
    assert_eq!(nothing.findings.verdict, Verdict::Consistent, "{}", nothing.findings.summary);
    let load = simulated("- tip_load: {mass_kg: 0.01}");
    assert_eq!(
        (load.findings.verdict, names(&load)),
        (Verdict::Named, vec!["tip_load"]),
        "{}",
        load.findings.summary
    );
    // Its steps are 0.14 mm off, where the load moves the tip by 6.9 mm.
    assert!((told(&load, "mass_kg").0 - 0.01).abs() < 3e-4);
    // The answer's own steps are 0.015 mm off (docs/method/search.md).
    let exact = with_steps("- tip_load: {mass_kg: 0.01}", 1e-6);
    assert!((told(&exact, "mass_kg").0 - 0.01).abs() < 0.015 / 6.9 * 0.01);
    assert!(
        load.findings.gap.after_m < 0.03 * load.findings.gap.before_m,
        "{:?}",
        load.findings.gap
    );
}

/// Trials that were cut out of a longer log begin wherever the robot was: their first tips are no
/// repeats, and not the model's.
#[test]
#[ignore = "make campaign"]
fn trials_that_do_not_start_at_home_are_noticed_and_answered_all_the_same() {
    let cut = |whole: &Recording| {
        let later: Vec<usize> =
            whole.trials().into_iter().flat_map(|(_, rows)| rows.skip(10)).collect();
        let mut cut = part(whole, &later);
        for (_, rows) in cut.trials() {
            let begins_s = cut.time_s[rows.start];
            cut.time_s[rows].iter_mut().for_each(|time_s| *time_s -= begins_s);
        }
        cut
    };
    let whole = recorded("[]", 6, 9, 0.0);
    let nothing = found(&cut(&whole), &Options::default());
    // 6 g; by how the trials begin, a force or a heavier rod.
    let load = discover(
        &nominal(),
        &cut(&chain("r12.csv")),
        Some(&chain("baseline.csv")),
        &Options::default(),
    )
    .unwrap();
    assert_eq!(nothing.findings.verdict, Verdict::Consistent, "{}", nothing.findings.summary);
    assert_eq!(
        (load.findings.verdict, names(&load)),
        (Verdict::Named, vec!["tip_load"]),
        "{}",
        load.findings.summary
    );
    assert!((told(&load, "mass_kg").0 - 0.006).abs() < 3e-4);
    for found in [&nothing, &load] {
        let floor = found.findings.noise_floor_m / (3.0_f64.sqrt() * NOISE_M);
        assert!((0.8..1.2).contains(&floor), "{floor}");
        let said = &found.findings.limitations;
        let said = |words: &str| said.iter().filter(|said| said.contains(words)).count();
        assert_eq!(["not every trial starts settled", "Tracking was lost"].map(said), [1, 0]);
    }
    let whole = found(&whole, &Options::default());
    assert!(
        whole
            .findings
            .limitations
            .iter()
            .all(|said| !said.contains("not every trial starts settled"))
    );
}

/// Markers along the body and none on the tip: each is compared where the model places it.
#[test]
fn points_along_the_body_are_answered_without_a_tip() {
    let mut model = nominal();
    for (name, s_m) in [("low", 0.1), ("high", 0.19)] {
        model
            .tracking
            .points
            .insert(name.to_owned(), BodyPoint { s_m, offset_m: [0.0, 0.005, 0.0] });
    }
    let truth = Model {
        effects: crate::support::rods::effects("- tip_load: {mass_kg: 0.01}"),
        ..model.clone()
    };
    let options = SimulationOptions { noise_m: NOISE_M, ..Default::default() };
    let recording = simulate_recording(&truth, &trials(&twin("nothing"), 0, 4), &options);
    let points_only = Recording { tip_m: None, tip_quaternion: None, ..recording };
    let found = discover(&model, &points_only, None, &Options::default()).unwrap();
    assert_eq!(
        (found.findings.verdict, names(&found)),
        (Verdict::Named, vec!["tip_load"]),
        "{}",
        found.findings.summary
    );
    assert!((told(&found, "mass_kg").0 - 0.01).abs() < 5e-4, "{:?}", told(&found, "mass_kg"));
    assert!(
        found.findings.summary.contains("rms error of all tracked places"),
        "{}",
        found.findings.summary
    );
    let of = |name: &str| found.residuals.iter().filter(|row| row.point == name).count();
    assert_eq!([of("low"), of("high"), of("")], [200, 200, 0]);
    assert!(found.findings.disagreement.iter().any(|group| group.place == "tracked place: high"));
}

/// One long log: its parts are fitted and held out, each played with the seconds before it.
#[test]
fn a_log_of_one_trial_is_divided() {
    let mut model = nominal();
    let mut commands = trials(&twin("nothing"), 0, 3);
    for row in 0..commands.len() {
        (commands.trial[row], commands.time_s[row]) = (0, 0.2 * row as f64);
    }
    model.effects = crate::support::rods::effects("- tip_load: {mass_kg: 0.01}");
    let mut log = simulate_recording(
        &model,
        &commands,
        &SimulationOptions { noise_m: NOISE_M, ..Default::default() },
    );
    log.tip_quaternion = None;
    let found = found(&log, &Options::default());
    assert_eq!(
        (found.findings.verdict, names(&found)),
        (Verdict::Named, vec!["tip_load"]),
        "{}",
        found.findings.summary
    );
    assert!((told(&found, "mass_kg").0 - 0.01).abs() < 5e-4);
    let said = found.findings.limitations.join(" ");
    assert!(said.contains("divided into 8 stretches of time"), "{said}");
    assert_eq!(found.findings.gap.held_out_trials.len(), 2);
}

/// Poses at rest in any order of time, parted by pattern.
#[test]
fn poses_at_rest_are_answered_without_their_times() {
    let mut model = nominal();
    let mut commands = trials(&twin("nothing"), 0, 3);
    commands.pattern = Some((0..commands.len()).map(|row| format!("part_{}", row / 25)).collect());
    for row in 0..commands.len() {
        (commands.trial[row], commands.time_s[row]) = (0, 7.0 * row as f64);
    }
    model.effects = crate::support::rods::effects("- bending_stiffness: {scale: 0.8}");
    let options = SimulationOptions { at_rest: true, noise_m: NOISE_M, ..Default::default() };
    let mut poses = simulate_recording(&model, &commands, &options);
    poses.tip_quaternion = None;
    let found = found(&poses, &Options { at_rest: true, ..Options::default() });
    assert_eq!(names(&found), ["bending_stiffness"], "{}", found.findings.summary);
    assert!((told(&found, "scale").0 - 0.8).abs() < 0.01);
    let said = found.findings.limitations.join(" ");
    assert!(said.contains("pose at rest") && said.contains("runs of one pattern"), "{said}");
}

/// Two segments with three tendons each, poses at rest: which one is softer.
#[test]
fn the_segment_that_is_softer_is_named() {
    let text = "
robot:
  backbone: {length_m: 0.24, radius_m: 0.0008, youngs_modulus_pa: 60e9, poisson_ratio: 0.3, density_kg_m3: 6500}
  disks: {count: 12, mass_kg: 0.003}
  tendons: {radius_m: 0.012, angles_deg: [0, 120, 240, 0, 120, 240], ends_m: [0.12, 0.12, 0.12, 0.24, 0.24, 0.24], \
pretension_m: 0.001, compliance_m_per_n: 0.0003}
  gravity_m_s2: [0, 0, 9.81]
";
    let model: Model = serde_yaml::from_str(text).unwrap();
    let mut commands = Recording::new(Actuation::Lengths, 6);
    for row in 0..75_u32 {
        let bend = |k: usize| {
            let phase = 0.7 * f64::from(row) * (1.0 + 0.37 * (k / 3) as f64);
            let angle = 2.0944 * k as f64;
            0.004 * (phase.sin() * angle.cos() + (1.3 * phase).cos() * angle.sin())
        };
        commands.trial.push(u64::from(row / 25));
        commands.time_s.push(f64::from(row));
        commands.commands.push(&[0, 1, 2, 3, 4, 5].map(bend));
    }
    let mut robot = model.clone();
    robot.effects = crate::support::rods::effects("- bending_stiffness: {scale: 0.5, segment: 2}");
    let options = SimulationOptions { at_rest: true, noise_m: NOISE_M, ..Default::default() };
    let mut poses = simulate_recording(&robot, &commands, &options);
    poses.tip_quaternion = None;
    let options = Options { at_rest: true, ..Options::default() };
    let found = discover(&model, &poses, None, &options).unwrap();
    assert_eq!(names(&found), ["bending_stiffness"], "{}", found.findings.summary);
    let softer = &found.findings.effects[0];
    assert_eq!(softer.parameters["segment"], 2, "{softer:?}");
    assert!((told(&found, "scale").0 - 0.5).abs() < 0.05 && softer.interval_95.len() == 1);
}

#[test]
#[ignore = "make campaign"]
fn the_same_data_give_the_same_answer() {
    let measured = recorded("- delay: {time_s: 0.1}", 3, 6, 0.0);
    let (a, b) = (found(&measured, &Options::default()), found(&measured, &Options::default()));
    assert_eq!(a.findings, b.findings);
    assert_eq!(a.model, b.model);
}

/// Another simulator, a chain of rigid bodies: what the baseline has in common with the recording
/// is no discovery.
#[test]
fn recordings_of_another_simulator_are_understood() {
    let baseline = twin("baseline");
    let with = |name: &str| {
        discover(&nominal(), &twin(name), Some(&baseline), &Options::default()).unwrap()
    };
    let nothing = with("nothing");
    assert_eq!(nothing.findings.verdict, Verdict::Consistent, "{}", nothing.findings.summary);
    let load = with("tip_load_10g");
    assert_eq!(
        (load.findings.verdict, names(&load)),
        (Verdict::Named, vec!["tip_load"]),
        "{}",
        load.findings.summary
    );
    // Two simulators of one robot agree on what a load does to a tenth.
    assert!((told(&load, "mass_kg").0 - 0.01).abs() < 1e-3);
    for found in [&nothing, &load] {
        assert_eq!(doubts(found), 0);
        calibration_is_told_as_it_is(found);
    }
}

/// How often an answer says that the model does not fit its baseline.
fn doubts(found: &Discovery) -> usize {
    found
        .findings
        .limitations
        .iter()
        .filter(|told| told.contains("error on the baseline is still"))
        .count()
}

/// Whether the baseline has changed the model is told as it is.
fn calibration_is_told_as_it_is(found: &Discovery) {
    let told = |words: &str| found.findings.limitations.iter().any(|told| told.contains(words));
    assert_eq!(
        found.calibrated,
        told("bending stiffness times"),
        "{:?}",
        found.findings.limitations
    );
    assert_ne!(found.calibrated, told("does not increase the likelihood of the baseline"));
    let before = &nominal().robot;
    assert_eq!(
        found.calibrated,
        found.model.robot.backbone != before.backbone
            || found.model.robot.sections != before.sections
    );
}

/// A number that the baseline tells of, and that the answer puts another one in the place of.
#[test]
#[ignore = "make campaign"]
fn damping_of_another_simulator_is_named() {
    let damping =
        discover(&nominal(), &chain("r10.csv"), Some(&chain("baseline.csv")), &Options::default())
            .unwrap();
    assert_eq!((damping.findings.verdict, names(&damping)), (Verdict::Named, vec!["damping"]));
    assert!((told(&damping, "time_s").0 - 0.6).abs() < 0.06);
}

/// With a baseline that was itself recorded against a wall, the answer is worth little, and says
/// so.
#[test]
#[ignore = "make campaign"]
fn a_baseline_that_the_model_does_not_fit_is_doubted() {
    let other =
        discover(&nominal(), &chain("baseline.csv"), Some(&chain("r15.csv")), &Options::default())
            .unwrap();
    assert_eq!(doubts(&other), 1, "{:?}", other.findings.limitations);
    calibration_is_told_as_it_is(&other);
}

/// A wall at 45 mm along −y, met by balls of 1 mm along the body.
#[test]
fn a_wall_of_another_simulator_is_named() {
    let wall =
        discover(&nominal(), &chain("r15.csv"), Some(&chain("baseline.csv")), &Options::default())
            .unwrap();
    assert_eq!(
        (wall.findings.verdict, names(&wall)),
        (Verdict::Named, vec!["contact"]),
        "{}",
        wall.findings.summary
    );
    // The place of a wall along the robot means nothing, so that no interval is told.
    let found = |parameter: &str| wall.findings.effects[0].parameters[parameter].as_f64().unwrap();
    assert!((found("distance_m") - 0.046).abs() < 2e-3);
    assert!((found("azimuth_rad") + std::f64::consts::FRAC_PI_2).abs() < 0.05);
}

/// Spheres of 20 to 30 mm beside the body, touched in a third of the rows.
#[test]
#[ignore = "make campaign"]
fn spheres_of_another_simulator_are_named() {
    for name in ["sphere_recording", "sphere_recording_2", "sphere_recording_3"] {
        let file = format!("{}/tests/reference/stability/{name}.csv", env!("CARGO_MANIFEST_DIR"));
        let measured = Recording::read(std::path::Path::new(&file)).unwrap();
        let sphere =
            discover(&nominal(), &measured, Some(&chain("baseline.csv")), &Options::default())
                .unwrap();
        let told = (sphere.findings.verdict, names(&sphere));
        assert_eq!(told, (Verdict::Named, vec!["contact"]), "{name}: {}", sphere.findings.summary);
    }
}

#[test]
#[ignore = "make campaign"]
fn friction_of_another_simulator_is_named() {
    let friction =
        discover(&nominal(), &twin("friction"), Some(&twin("baseline")), &Options::default())
            .unwrap();
    assert_eq!((friction.findings.verdict, names(&friction)), (Verdict::Named, vec!["friction"]));
    assert!((told(&friction, "moment_nm").0 - 0.02).abs() < 2e-3);
}

#[test]
fn a_model_that_cannot_be_played_at_its_own_resolution_says_so() {
    let mut model = nominal();
    let measured = recorded("", 4, 3, 0.0);
    let told = |model: &Model| {
        let found = discover(model, &measured, None, &Options::default()).unwrap();
        found.findings.limitations.iter().any(|told| told.contains("own resolution"))
    };
    assert!(!told(&model));
    // Finer than numbers of sixteen digits can be.
    model.robot.resolution.static_tolerance_m = 1e-20;
    assert!(told(&model));
}

/// Markers on the base say that it stands straight: a turned frame is not called a tilted base.
#[test]
#[ignore = "make campaign"]
fn base_markers_tell_a_turned_frame_from_a_tilted_base() {
    let mut measured = recorded("- base_tilt: {tilt_x_rad: 0.02, tilt_y_rad: 0.0}", 4, 9, 0.0);
    assert_eq!(names(&found(&measured, &Options::default())), ["base_tilt"]);
    let straight = Pose { position_m: [0.0; 3], quaternion: [1.0, 0.0, 0.0, 0.0] };
    measured.base = Some(vec![straight; measured.len()]);
    assert!(!names(&found(&measured, &Options::default())).contains(&"base_tilt"));
}

#[test]
fn data_that_allow_no_answer_are_refused() {
    let refuse = |measured: &Recording| {
        discover(&nominal(), measured, None, &Options::default()).unwrap_err()
    };
    let whole = twin("nothing");
    assert!(matches!(
        refuse(&trials(&whole, 0, 1)),
        DiscoveryError::TooFew { what: "tracked trials", .. }
    ));
    let mut frozen = trials(&whole, 0, 3);
    frozen.tip_m.as_mut().unwrap().fill([0.0, 0.0, 0.2]);
    assert!(matches!(
        refuse(&frozen),
        DiscoveryError::Constant { column: "tip_x_m,tip_y_m,tip_z_m", .. }
    ));
    let mut lost = trials(&whole, 0, 3);
    lost.valid = Some((0..lost.len()).map(|row| row % 10 == 0).collect());
    assert!(matches!(refuse(&lost), DiscoveryError::TooFew { what: "tracked rows", .. }));
    let mut still = trials(&whole, 0, 3);
    let home = vec![0.0; 4];
    let mut commands = Rows::new(4);
    (0..still.len()).for_each(|_| commands.push(&home));
    still.commands = commands;
    assert!(matches!(refuse(&still), DiscoveryError::Constant { column: "tendon_1_m…", .. }));
}
