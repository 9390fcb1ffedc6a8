//! `doctor` on correct and on wrong hardware.

use super::bench::{Bench, ROOT};

#[test]
fn correct_hardware_passes() {
    let bench = Bench::new();
    let plant = format!("{ROOT}/experiments/plants/rehearsal.yaml");
    let ended = bench.run(&format!("doctor --plant {plant} --move"));
    ended.is(
        0,
        &[
            "ok     controller: grblHAL",
            "ok     tip: ",
            "ok     tendons 2 and 4: pulled 6 mm",
            "ok     command latency",
        ],
    );
    assert!(!ended.said.contains("WRONG"), "{}", ended.said);
    bench.run(&format!("doctor --plant {plant}")).is(0, &["not homed", "nothing was moved"]);
}

#[test]
fn every_wrong_setting_is_reported() {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0.0002");
    let mut served = bench.serve("plant.yaml", "served.yaml");
    let plant = bench.text("served.yaml");
    let changed = |name: &str, from: &str, to: &str| {
        assert!(plant.contains(from), "{plant}");
        bench.put(name, &plant.replace(from, to));
    };
    // A frame that is turned.
    changed("turned.yaml", "up_axis: Y", "up_axis: Z");
    bench
        .run("doctor --plant turned.yaml")
        .is(1, &["WRONG  tip: ", "from the model's home", "failed checks: 1"]);
    // A body of another name, a server that is not there, a port that is not there.
    changed("unnamed.yaml", "tip_body: tip", "tip_body: hand");
    bench.run("doctor --plant unnamed.yaml").is(1, &["error: ", "'hand'"]);
    changed("elsewhere.yaml", "server: 127.0.0.1", "server: 127.0.0.9");
    let elsewhere = bench.text("elsewhere.yaml").replace("connect_s: 20.0", "connect_s: 1.0");
    bench.put("elsewhere.yaml", &elsewhere);
    bench.run("doctor --plant elsewhere.yaml").is(1, &["error: ", "127.0.0.9"]);
    changed("portless.yaml", "port: /dev/", "port: /dev/no-such-");
    bench
        .run("doctor --plant portless.yaml")
        .is(1, &["error: /dev/no-such-", "cannot open the port"]);
    // Settings of the controller, in the order in which they are found.
    served.wish("set 110 300");
    bench.run("doctor --plant served.yaml").is(
        1,
        &["error: setting $110 (maximum speed of an axis, mm/min) of the controller: found 300, \
           expected at least 1125"],
    );
    served.wish("set 110 3000");
    // As grblHAL comes from the factory.
    served.wish("set 120 10");
    bench.run("doctor --plant served.yaml").is(
        1,
        &["error: setting $120 (maximum acceleration of an axis, mm/s²) of the controller: found \
           10, expected at least 469"],
    );
    served.wish("set 120 500");
    served.wish("set 110 300");
    served.wish("set 21 0");
    served.wish("set 22 0");
    served.wish("set 44 4");
    bench.run("doctor --plant served.yaml").is(
        1,
        &[
            "error: 4 settings are wrong:",
            "setting $21 (hard limits) of the controller: found 0, expected a bit mask that \
             includes 1",
            "send $22=13  $21=1  $110=1125  $44=15 with a terminal program",
        ],
    );
    // Both devices are named when both are wrong.
    bench.put("both.yaml", &elsewhere);
    bench
        .run("doctor --plant both.yaml")
        .is(1, &["error: 4 settings are wrong", "; and ", "127.0.0.9"]);
    assert_eq!(served.moves(), 0);
}

/// A body that the cameras do not see is named.
#[test]
fn a_hidden_body_is_named() {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0.0002");
    let mut served = bench.serve("plant.yaml", "served.yaml");
    for (body, words) in [
        ("base", "WRONG  tip: not tracked (the base is not tracked), expected both bodies in view"),
        ("tip", "WRONG  tip: not tracked (the tip is not tracked), expected both bodies in view"),
    ] {
        served.wish(&format!("hide {body}"));
        bench.run("doctor --plant served.yaml").is(1, &[words]);
        served.wish("repair");
    }
}

/// A controller that alarms while nothing moves: `doctor` names the alarm, `collect` resets and
/// homes.
#[test]
fn an_alarm_at_rest_is_named_and_cleared_by_homing() {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0.0002");
    bench.put_commands("commands.csv", 1, 5);
    let mut served = bench.serve("plant.yaml", "served.yaml");
    for code in [1, 2, 77] {
        served.wish(&format!("alarm {code}"));
        let named = format!("WRONG  controller: alarm {code}: ");
        bench
            .run("doctor --plant served.yaml")
            .is(1, &[&named, "resets and homes it", "failed checks: 1"]);
        let collect =
            format!("collect --plant served.yaml --commands commands.csv --out rec_{code}.csv");
        bench.run(&collect).is(0, &[]);
        assert!(!bench.is_latched());
    }
    let after = bench.run("doctor --plant served.yaml");
    after.is(0, &["ok     controller: "]);
    assert!(!after.said.contains("alarm"), "{}", after.said);
}

/// A switch that somebody holds closed is named with its axis; once it opens, the next motion
/// resets, unlocks and homes.
#[test]
fn a_closed_switch_is_named() {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0.0002");
    bench.put_commands("commands.csv", 1, 5);
    let mut served = bench.serve("plant.yaml", "served.yaml");
    bench.run("collect --plant served.yaml --commands commands.csv --out first.csv").is(0, &[]);
    served.wish("press Y");
    let doctor = bench.run("doctor --plant served.yaml");
    doctor.is(
        1,
        &["alarm 1: A limit switch was hit", "limit switch closed: Y; ", "failed checks: 2"],
    );
    bench.run("collect --plant served.yaml --commands commands.csv --out rec.csv").is(0, &[]);
    assert!(served.homings() == 2 && !bench.is_latched());
    assert!(!bench.run("doctor --plant served.yaml").said.contains("switch"));
}

/// Motion is compared in size and in direction.
#[test]
fn a_robot_that_moves_otherwise_than_its_model_fails_the_test_motion() {
    let bench = Bench::new();
    let nominal = std::fs::read_to_string(format!("{ROOT}/models/nominal.yaml")).unwrap();
    bench.put("stiff.yaml", &nominal.replace("2.33e9", "2.33e10"));
    bench.put("turned.yaml", &nominal.replace("[0, 90, 180, 270]", "[45, 135, 225, 315]"));
    for (model, words) in [
        ("stiff.yaml", "expected a ratio of 0.62 to 1.6: check the model's dimensions"),
        ("turned.yaml", "expected at most 30 degrees: check the order of the tendons"),
    ] {
        let models = format!("model: {ROOT}/models/nominal.yaml, rehearsal: {{model: {model}}}");
        bench.put("plant.yaml", &format!("hardware: {{name: robot, {models}}}\n"));
        let doctor = bench.run("doctor --plant plant.yaml --move");
        doctor.is(1, &["WRONG  tendons 1 and 3: pulled 6 mm", words]);
    }
}

/// An alarm whose cause a person has to remove: nothing is sent, and nothing is stored that `arm`
/// would have to clear.
#[test]
fn an_alarm_with_a_cause_is_left_to_a_person() {
    let bench = Bench::new();
    bench.put_rehearsal("plant.yaml", "noise_m: 0.0002");
    bench.put_commands("commands.csv", 1, 5);
    let mut served = bench.serve("plant.yaml", "served.yaml");
    served.wish("alarm 10");
    bench
        .run("doctor --plant served.yaml")
        .is(1, &["alarm 10: The emergency stop is pressed. Release it"]);
    bench
        .run("collect --plant served.yaml --commands commands.csv --out rec.csv")
        .is(1, &["alarm 10: The emergency stop is pressed."]);
    assert!(!bench.is_latched());
    assert_eq!(served.moves(), 0);
}

/// An answer time after which the robot is stopped already.
#[test]
fn an_answer_time_without_effect_is_refused() {
    let bench = Bench::new();
    bench.put(
        "plant.yaml",
        &format!(
            "hardware:\n  name: robot\n  model: {ROOT}/models/nominal.yaml\n  motion:\n    \
             reply_timeout_s: 2\n    late_s: 0.8\n"
        ),
    );
    let words = [
        "plant.yaml:5",
        "hardware.motion.reply_timeout_s",
        "found 2 s",
        "motion.late_s + safety.hold_stop_s",
    ];
    bench.run("doctor --plant plant.yaml").is(2, &words);
}

#[test]
fn hardware_commands_refuse_other_plants() {
    let bench = Bench::new();
    bench.put("plant.yaml", "constant_curvature: {}\n");
    for command in
        ["doctor", "arm", "weigh --out out.csv", "align --move", "rehearse --out out.yaml"]
    {
        bench
            .run(&format!("{command} --plant plant.yaml"))
            .is(2, &["error: plant.yaml: expected `hardware`"]);
    }
    bench.put(
        "bench.yaml",
        &format!("hardware: {{name: robot, model: {ROOT}/models/nominal.yaml}}\n"),
    );
    bench.run("rehearse --plant bench.yaml --out out.yaml").is(2, &["found no `rehearsal`"]);
    assert!(!bench.path("out.yaml").exists() && !bench.path("out.csv").exists());
}
