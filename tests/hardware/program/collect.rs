//! Commands before they are played, and a recording as a robot.

use super::bench::Bench;
use spinebench::data::Recording;

const HEADER: &str = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m";

#[test]
fn a_dry_run_says_what_would_happen() {
    let bench = Bench::new();
    // Nothing that it opens is there.
    bench.put(
        "plant.yaml",
        &format!("hardware: {{name: robot, model: {}/models/nominal.yaml}}\n", super::bench::ROOT),
    );
    bench.put(
        "in.csv",
        &format!(
            "{HEADER},known_load_kg\n0,0,0,0,0,0,0.01\n0,0.2,0.002,0,-0.002,0,0.01\n0,0.4,0.009,0,-0.009,0,0.01\n\
             0,0.6,0.009,0,-0.009,0,0.01\n1,0,0,0,0,0,0\n1,0.2,0,0,0,0,0\n"
        ),
    );
    let ended = bench.run("collect --plant plant.yaml --commands in.csv --dry-run");
    ended.is(0, &["trials: 2, commands: 4, ticks of 0.2 s: 6"]);
    ended.is(
        0,
        &[
            "largest step: 7.000 mm (line 4)",
            "displacements: -9.000 to 9.000 mm",
            "trial 0: 10.0 g, trial 1: 0.0 g",
        ],
    );
    assert_eq!(std::fs::read_dir(bench.path("")).unwrap().count(), 2, "something was written");

    for (name, row, words) in [
        ("far.csv", "0,0.2,0.031,0,0,0", "line 3: tendon 1: displacement (m) of 0.031"),
        ("fast.csv", "0,0.2,0,0.0125,0,-0.0125", "line 3: tendon 2: step (m) of 0.0125"),
        (
            "slack.csv",
            "0,0.2,-0.0101,0,-0.0101,0",
            "line 3: tendon 1: sum with its antagonist (m) of -0.0202",
        ),
    ] {
        bench.put(name, &format!("{HEADER}\n0,0,0,0,0,0\n{row}\n0,0.4,0,0,0,0\n"));
        // With and without: nothing is opened for commands that will be refused.
        for more in ["--dry-run", "--out out.csv"] {
            let ended = bench.run(&format!("collect --plant plant.yaml --commands {name} {more}"));
            ended.is(2, &[&format!("error: {name}, "), words]);
        }
    }
    bench.put("curved.yaml", "constant_curvature: {}\n");
    bench
        .run("collect --plant curved.yaml --commands in.csv --dry-run")
        .is(2, &["found a constant_curvature plant"]);
    bench.run("collect --plant plant.yaml --commands in.csv").is(2, &["--out"]);
}

#[test]
fn a_recording_stands_for_the_robot_that_made_it() {
    let bench = Bench::new();
    bench.put("curved.yaml", "constant_curvature: {noise_m: 0.0005}\n");
    bench.put("replay.yaml", "replay: {recording: rec.csv}\n");
    bench.put_commands("in.csv", 2, 12);
    bench.run("collect --plant curved.yaml --commands in.csv --out rec.csv").is(0, &[]);
    bench.run("collect --plant replay.yaml --commands in.csv --out again.csv").is(0, &[]);
    let [recorded, again] =
        ["rec.csv", "again.csv"].map(|name| Recording::read(&bench.path(name)).unwrap());
    assert_eq!((recorded.tip_m, recorded.commands), (again.tip_m, again.commands));
    // Another command, and a row more than there is.
    bench.put("other.csv", &other_command(&bench.text("in.csv")));
    let refused = bench.run("collect --plant replay.yaml --commands other.csv --out other-out.csv");
    refused.is(
        1,
        &[
            "trial 0: not in the recording: tendon 1 at 0.0001 m; line 4 has",
            "0 of 2 trials are kept",
        ],
    );
    bench.put_commands("long.csv", 1, 13);
    let refused = bench.run("collect --plant replay.yaml --commands long.csv --out long-out.csv");
    refused.is(1, &["a step after the last row of the trial (line 13)"]);
    assert!(!bench.path("other-out.csv").exists() && !bench.path("long-out.csv").exists());
}

#[test]
fn a_recording_is_named_from_the_plant_file_and_has_the_steps_of_the_commands() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("robots")).unwrap();
    bench.put("curved.yaml", "constant_curvature: {}\n");
    bench.put("robots/replay.yaml", "replay: {recording: rec.csv}\n");
    bench.put_commands("in.csv", 1, 12);
    bench.run("collect --plant curved.yaml --commands in.csv --out robots/rec.csv").is(0, &[]);
    bench.run("collect --plant robots/replay.yaml --commands in.csv --out again.csv").is(0, &[]);

    // Twice as fast.
    let recorded = bench.text("robots/rec.csv");
    bench.put("quick.csv", &halved_times(&bench.text("in.csv")));
    let refused =
        bench.run("collect --plant robots/replay.yaml --commands quick.csv --out quick-out.csv");
    refused.is(
        1,
        &["robots/rec.csv, all rows, column `time_s`: found steps of 0.200000 s, expected 0.1 s, \
           as the commands have"],
    );
    // DrivenModel by tensions.
    bench.put(
        "robots/rec.csv",
        &recorded
            .replace("1_m,", "1_n,")
            .replace("2_m,", "2_n,")
            .replace("3_m,", "3_n,")
            .replace("4_m,", "4_n,"),
    );
    let refused =
        bench.run("collect --plant robots/replay.yaml --commands in.csv --out tensions-out.csv");
    refused.is(
        1,
        &["found the tensions of 4 tendons, expected the displacements of 4 tendons (tendon_1_m"],
    );
    assert!(!bench.path("quick-out.csv").exists() && !bench.path("tensions-out.csv").exists());
}

/// Commands twice as fast.
fn halved_times(text: &str) -> String {
    let (header, rows) = text.split_once('\n').unwrap();
    let halved = rows.lines().map(|row| {
        let cells: Vec<&str> = row.splitn(3, ',').collect();
        format!("{},{:.1},{}\n", cells[0], 0.5 * cells[1].parse::<f64>().unwrap(), cells[2])
    });
    format!("{header}\n{}", halved.collect::<String>())
}

/// The third command of the first trial is another one.
fn other_command(text: &str) -> String {
    let line = |(number, line): (usize, &str)| {
        if number != 3 {
            return format!("{line}\n");
        }
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[2] = "0.0001";
        cells.join(",") + "\n"
    };
    text.lines().enumerate().map(line).collect()
}
