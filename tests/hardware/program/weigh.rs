//! Calibration with weights, from the session to the model.

use super::bench::{Bench, ROOT, until};
use spinebench::data::Recording;
use spinebench::specs::{model_text, read_model};
use std::path::Path;

#[test]
fn weights_find_the_stiffness_of_the_robot() {
    let bench = Bench::new();
    let nominal = read_model(&Path::new(ROOT).join("models/nominal.yaml")).unwrap();
    let mut hidden = nominal.clone();
    hidden.robot.backbone.youngs_modulus_pa *= 0.8;
    bench.put("hidden.yaml", &model_text(&hidden).unwrap());
    bench.put(
        "plant.yaml",
        &format!(
            "hardware: {{name: robot, model: {ROOT}/models/nominal.yaml, rehearsal: {{model: \
             hidden.yaml, noise_m: 0.0005}}}}\n"
        ),
    );
    let ended = bench.run("weigh --plant plant.yaml --weights 0,0.02,0.05 --out out.csv");
    ended.is(0, &["trial 1: hang 20.0 g on the tip", "trial 2: hang 50.0 g", "calibrate --static"]);
    let recording = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!((recording.len(), recording.trials().len()), (3 * 17, 3));
    assert_eq!(recording.known_load_kg.as_ref().unwrap()[17..19], [0.02, 0.02]);
    let model = format!("{ROOT}/models/nominal.yaml");
    bench
        .run(&format!("calibrate --static --model {model} --measured out.csv --out fitted.yaml"))
        .is(0, &["95 % interval"]);
    let found_pa = read_model(&bench.path("fitted.yaml")).unwrap().robot.backbone.youngs_modulus_pa;
    let expected_pa = hidden.robot.backbone.youngs_modulus_pa;
    assert!(
        (found_pa / expected_pa - 1.0).abs() < 0.02,
        "{found_pa:.4e} Pa, expected {expected_pa:.4e} Pa"
    );
}

#[test]
fn poses_may_be_given_and_are_checked() {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0");
    let header = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n";
    bench.put("poses.csv", &format!("{header}0,0,0.01,0,-0.01,0\n0,1,0,0.01,0,-0.01\n"));
    bench
        .run("weigh --plant plant.yaml --weights 0.01 --poses poses.csv --out out.csv")
        .is(0, &["2 poses"]);
    let recording = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!(recording.len(), 3, "home comes first");
    let tips = recording.tip_m.unwrap();
    assert!(tips[1][0] > tips[0][0] + 0.02 && tips[2][1] > tips[0][1] + 0.02, "{tips:?}");

    bench.put("far.csv", &format!("{header}0,0,0.01,0,-0.01,0\n0,1,0,0.031,0,-0.01\n"));
    let refused = bench.run("weigh --plant plant.yaml --poses far.csv --out far-out.csv");
    refused.is(2, &["error: far.csv, line 3: tendon 2: displacement (m) of 0.031"]);
    bench
        .run("weigh --plant plant.yaml --weights 0,-1 --out far-out.csv")
        .is(2, &["found `-1`, expected 0 to 10 kg"]);
    bench
        .run("weigh --plant plant.yaml --reach-m 0.2 --out far-out.csv")
        .is(2, &["--reach-m: found 0.2"]);
    assert!(!bench.path("far-out.csv").exists());
}

/// Nobody is there to hang a weight: what has been recorded is kept, and the session goes on once
/// somebody is. Hands between the robot and the cameras do not stop it.
#[test]
fn a_session_waits_for_hands() {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0");
    let mut served = bench.serve("plant.yaml", "served.yaml");
    bench.put(
        "poses.csv",
        "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n0,0,0.01,0,-0.01,0\n",
    );
    // Those of a real robot: hidden for so long, it would be stopped if it were not parked.
    let quick = bench
        .text("served.yaml")
        .replace("hold_stop_s: 10.0", "hold_stop_s: 0.4")
        .replace("timeout_s: 10.0\n", "timeout_s: 5.0\n");
    bench.put("served.yaml", &quick.replace("tracking_hold_s: 5.0", "tracking_hold_s: 0.6"));
    let weigh = "weigh --plant served.yaml --weights 0,0.05,0.02 --poses poses.csv --rest-steps 3 \
                 --out out.csv";
    bench
        .run(weigh)
        .is(1, &["stdin closed while waiting for the operator: trial 1: hang 50.0 g on the tip"]);
    assert!(bench.path("out.part.csv").exists() && !bench.path("out.csv").exists());
    served.wish("hang 0.05");
    let mut session = bench.start_with_hands(weigh);
    session.press_enter();
    until(|| {
        (Recording::read(&bench.path("out.part.csv")).unwrap().trials().len() == 2).then_some(())
    });
    // The robot goes home after the second trial and is parked.
    served.stands();
    until(|| (bench.text("spinebench/robot.log").matches("parked").count() == 2).then_some(()));
    served.wish("hide tip");
    served.wish("hang 0.02");
    std::thread::sleep(std::time::Duration::from_secs(2));
    served.wish("repair");
    session.press_enter();
    session.end().is(
        0,
        &["resuming after 1 of 3 trials", "trial 2: hang 20.0 g on the tip, then press Enter"],
    );
    assert!(!bench.is_latched());
    let tips = Recording::read(&bench.path("out.csv")).unwrap().tip_m.unwrap();
    assert!(
        tips[2][0] < tips[0][0] - 0.005 && tips[4][0] > tips[2][0] + 0.002,
        "weights pull the tip down: {tips:?}"
    );
}
