//! What a new user meets in the first hour: wrong units, swapped arguments, folders that take
//! nothing, words that help.

use crate::support::hour::Desk;

const HEADER: &str = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m";

/// Twelve rows in which tendon 1 is pulled.
fn commands() -> String {
    let row = |k: u32| format!("0,{:.1},{},0,0,0", 0.2 * f64::from(k), 0.0005 * f64::from(k));
    std::iter::once(HEADER.to_owned()).chain((0..12).map(row)).collect::<Vec<_>>().join("\n") + "\n"
}

fn nominal() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/models/nominal.yaml")).unwrap()
}

fn desk() -> Desk {
    let desk = Desk::new();
    desk.put("m.yaml", &nominal());
    desk.put("plant.yaml", "simulated: {model: m.yaml}\n");
    desk.put("c.csv", &commands());
    desk.ok("simulate --model m.yaml --commands c.csv --out rec.csv");
    desk
}

#[test]
fn wrong_units_are_refused_with_the_unit_that_was_meant() {
    let desk = desk();
    let cases = [
        (
            "2.33e9",
            "4.0",
            "robot.backbone.youngs_modulus_pa: found 4 (if that is in GPa, write 4e9 Pa)",
        ),
        (
            "radius_m: 0.020",
            "radius_m: 15",
            "robot.tendons.radius_m: found 15 (if that is in mm, write 0.015 m)",
        ),
        (
            "mass_kg: 0.004",
            "mass_kg: 3",
            "robot.disks.mass_kg: found 3 (if that is in g, write 0.003 kg)",
        ),
        (
            "radius_m: 0.002,",
            "radius_m: 1.5,",
            "robot.backbone.radius_m: found 1.5 (if that is in mm, write 0.0015 m)",
        ),
        (
            "length_m: 0.22",
            "length_m: 300",
            "robot.backbone.length_m: found 300 (if that is in mm, write 0.3 m)",
        ),
    ];
    for (right, wrong, expected) in cases {
        assert!(nominal().contains(right), "{right}");
        desk.put("wrong.yaml", &nominal().replacen(right, wrong, 1));
        for command in [
            "simulate --model wrong.yaml --commands c.csv --out out.csv",
            "discover --model wrong.yaml --measured rec.csv --out out",
            "calibrate --model wrong.yaml --measured rec.csv --out out.yaml",
        ] {
            let said = desk.refused(command);
            assert!(said.contains(expected) && said.starts_with("error: wrong.yaml:"), "{said}");
        }
    }
    desk.put(
        "wrong.yaml",
        &(nominal() + "  - tip_load: {mass_kg: 20}\n").replace("effects: []", "effects:"),
    );
    let said = desk.refused("simulate --model wrong.yaml --commands c.csv --out out.csv");
    assert!(
        said.contains("effects[0].tip_load.mass_kg: found 20 (if that is in g, write 0.02 kg)"),
        "{said}"
    );
}

#[test]
fn commands_in_millimetres_are_refused() {
    let desk = desk();
    let row = |k: u32| format!("0,{:.1},{k},0,0,0", 0.2 * f64::from(k));
    let rows = std::iter::once(HEADER.to_owned()).chain((0..12).map(row));
    desk.put("mm.csv", &(rows.collect::<Vec<_>>().join("\n") + "\n"));
    for command in [
        "simulate --model m.yaml --commands mm.csv --out out.csv",
        "simulate --static --model m.yaml --commands mm.csv --out out.csv",
        "collect --plant plant.yaml --commands mm.csv --out out.csv",
    ] {
        let said = desk.refused(command);
        let place = "mm.csv, line 3, column `tendon_1_m`: found 1, expected metres, a possible \
                     displacement for a robot of 0.22 m (are these millimetres?)";
        assert!(said.contains(place), "{command}: {said}");
    }
}

#[test]
fn poses_at_rest_are_marked_and_read_as_such() {
    let desk = desk();
    desk.ok("simulate --static --model m.yaml --commands c.csv --out rest.csv");
    let rest = std::fs::read_to_string(desk.path("rest.csv")).unwrap();
    assert!(rest.lines().next().unwrap().contains(",at_rest,"), "{rest}");
    // Repeated times: poses at rest may have any.
    let times = rest.lines().map(|line| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if cells[1] != "time_s" {
            cells[1] = "0.0";
        }
        cells.join(",") + "\n"
    });
    desk.put("rest.csv", &times.collect::<String>());
    let note = "all rows are marked as poses at rest (`at_rest`): read as with --static";
    let said = desk.ok("calibrate --model m.yaml --measured rest.csv --out m2.yaml");
    assert!(said.contains(note), "{said}");
    assert!(!desk.ok("calibrate --model m.yaml --measured rec.csv --out m2.yaml").contains(note));
    desk.put("c1.csv", &commands().replace("\n0,", "\n1,"));
    desk.ok("simulate --model m.yaml --commands c1.csv --out moves.csv");
    let said = desk.refused("discover --model m.yaml --measured moves.csv rest.csv --out out");
    assert!(
        said.contains("rest.csv, line 1, column `at_rest`: found poses at rest and rows in motion"),
        "{said}"
    );
    let played = desk.ok("simulate --model m.yaml --commands moves.csv --out again.csv");
    assert!(played.contains("wrote"));
    let again = std::fs::read_to_string(desk.path("again.csv")).unwrap();
    assert!(!again.lines().next().unwrap().contains("at_rest"), "{again}");
}

#[test]
fn rows_that_all_fail_are_an_error_that_names_the_suspect() {
    let desk = desk();
    // A backbone of gel: possible, but not with these disks.
    desk.put("gel.yaml", &nominal().replacen("2.33e9", "6e3", 1));
    let output = desk.run("simulate --static --model gel.yaml --commands c.csv --out out.csv");
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("none of 12 rows could be solved"), "{said}");
    assert!(
        said.contains("gel.yaml: robot.backbone.youngs_modulus_pa: found 6000, an unusual value"),
        "{said}"
    );
}

#[test]
fn an_output_that_cannot_be_written_is_told_before_the_work() {
    let desk = desk();
    desk.put("file", "");
    for command in [
        "simulate --model m.yaml --commands c.csv --out file/out.csv",
        "simulate --model m.yaml --commands c.csv --out out.xlsx",
        "collect --plant plant.yaml --commands c.csv --out file/out.csv",
        "collect --plant plant.yaml --commands c.csv --out out.ods",
        "calibrate --model m.yaml --measured rec.csv --out file/out.yaml",
        "calibrate --model m.yaml --measured rec.csv --out out.csv",
        "calibrate --model m.yaml --measured rec.csv --out out.yaml --report file/out",
        "discover --model m.yaml --measured rec.csv --out file/out",
    ] {
        let said = desk.refused(command);
        assert!(said.contains("file/out") || said.contains("ending"), "{command}: {said}");
    }
    // A probe leaves nothing behind, also where the command fails later.
    let said = desk.refused("discover --model m.yaml --measured rec.csv --out out/of/reach");
    assert!(said.contains("rec.csv"), "{said}");
}

#[test]
fn swapped_arguments_and_missing_files_are_told_in_one_short_line() {
    let desk = desk();
    for (command, expected) in [
        ("discover --model rec.csv --measured rec.csv --out out", "found a recording (CSV)"),
        (
            "discover --model m.yaml --measured m.yaml --out out",
            "m.yaml, line 1: found a YAML file",
        ),
        ("discover --model m.yml --measured rec.csv --out out", "did you mean `m.yaml`?"),
        ("discover --model m.yaml --measured reco.csv --out out", "found no such file in /"),
        ("calibrate --model m.yaml --measured data/rec.csv --out out.yaml", "found no folder data"),
    ] {
        let said = desk.refused(command);
        assert!(said.contains(expected) && said.len() < 300, "{command}: {said}");
    }
    desk.put("sheet.csv", "PK\u{3}\u{4}rest");
    let said = desk.refused("discover --model m.yaml --measured sheet.csv --out out");
    assert!(said.contains("found a spreadsheet"), "{said}");
}

#[test]
fn commands_end_with_one_line_of_what_was_written_unless_quiet() {
    let desk = desk();
    let said = desk.ok("simulate --model m.yaml --commands c.csv --out o.csv");
    assert_eq!(said, "wrote o.csv: 1 trial, 12 rows\n");
    let said = desk.ok("collect --plant plant.yaml --commands c.csv --out o.csv");
    assert_eq!(said, "wrote o.csv: 1 trial, 12 rows\n");
    let said = desk.ok("calibrate --model m.yaml --measured rec.csv --out m2.yaml");
    assert!(said.starts_with("wrote m2.yaml\n"), "{said}");
    for quiet in ["--quiet simulate", "simulate --quiet"] {
        assert_eq!(desk.ok(&format!("{quiet} --model m.yaml --commands c.csv --out o.csv")), "");
    }
}

#[test]
fn set_reaches_the_items_of_lists_and_null_drops_what_was_inherited() {
    let desk = Desk::new();
    let experiments = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments");
    desk.put("own.yaml", &format!("extends: {experiments}/smoke.yaml\nname: own\nseeds: 1\n"));
    let all = desk.ok("plan own.yaml");
    let fewer = desk.ok("plan own.yaml --set runs.reach[0].modes=[closed]");
    assert_ne!(all, fewer);
    let said = desk.refused("plan own.yaml --set runs.reach[7].modes=[closed]");
    assert!(
        said.starts_with(
            "error: --set runs.reach[7].modes=[closed]: runs.reach[7].modes: found a list of 1"
        ),
        "{said}"
    );
    // Mode and training of the paper are inherited; both go, and what still names them is told.
    desk.put(
        "own.yaml",
        &format!(
            "extends: {experiments}/smoke.yaml\nname: own\nseeds: 1\ntraining: {{paper: null}}\n"
        ),
    );
    let one = desk.ok("plan own.yaml");
    assert_ne!(all, one);
    // A kind of training that is named beside inherited ones runs beside them, and that is said.
    assert!(!one.contains("note:"), "{one}");
    let said = desk.ok("plan own.yaml --set training.converged={}");
    assert!(!said.contains("note:"), "{said}");
    desk.put(
        "both.yaml",
        &format!("extends: {experiments}/smoke.yaml\nname: both\ntraining: {{converged: {{}}}}\n"),
    );
    let said = desk.ok("plan both.yaml");
    let expected = "note: both.yaml:3:1: training: runs the inherited `paper` too; `training: \
                    {paper: null}` drops it";
    assert!(said.contains(expected), "{said}");
    let said = desk.refused("plan own.yaml --set modes.open=null");
    assert!(said.contains("found `open`, expected one of"), "{said}");
}

/// A robot with these angles and ends of its tendons.
fn arm(angles: &str, more: &str) -> String {
    format!(
        "robot:\n  backbone: {{length_m: 0.30, radius_m: 0.002, youngs_modulus_pa: 2.5e9, \
         poisson_ratio: 0.39, density_kg_m3: 1200}}\n  tendons: {{radius_m: 0.02, angles_deg: \
         {angles}, pretension_m: 0.0005{more}}}\n"
    )
}

#[test]
fn robots_of_three_six_and_nine_tendons_run_the_papers_experiments() {
    let nine = "[0, 120, 240, 40, 160, 280, 80, 200, 320]";
    let ends = ", ends_m: [0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3, 0.3, 0.3]";
    let robots =
        [("[0, 120, 240]", "", 3), ("[0, 60, 120, 180, 240, 300]", "", 6), (nine, ends, 9)];
    let experiments = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments");
    for (angles, more, tendons) in robots {
        let desk = Desk::new();
        desk.put("arm.yaml", &arm(angles, more));
        let sizes = "explore: {points: 60}\nruns:\n  gap: {rows: 20}\n  reach:\n    - {policies: \
                     [a, b, c, pi_real], modes: [closed], gp_points: [20], real_points: [50]}\n  \
                     track: {policies: [c], mode: closed, gp_points: 20, real_points: null}\n";
        let robot = "model: {simulated: {model: arm.yaml}}\nplant: {simulated: {model: arm.yaml, \
                     noise_m: 0.0005}}\n";
        let spec =
            format!("extends: {experiments}/smoke.yaml\nname: arm\nseeds: 1\n{robot}{sizes}");
        desk.put("own.yaml", &spec);
        desk.ok("run own.yaml --strict");
        let rows =
            |file: &str| std::fs::read_to_string(desk.path("results/arm").join(file)).unwrap();
        let trials = rows("trials.csv");
        assert!(
            trials.lines().count() > 8 && trials.lines().skip(1).all(|line| line.ends_with(",ok")),
            "{trials}"
        );
        let gap = rows("gap.csv");
        let (header, row) = (gap.lines().next().unwrap(), gap.lines().nth(5).unwrap());
        assert_eq!(header.contains("further_tendons_m"), tendons > 4, "{header}");
        let cells: Vec<&str> = row.split(',').collect();
        match tendons {
            3 => assert_eq!(cells[5], "", "{row}"),
            _ => assert_eq!(cells[6].split(' ').count(), tendons - 4, "{row}"),
        }
    }
}

#[test]
fn tendons_on_one_side_are_refused_with_their_place_before_anything_runs() {
    let desk = Desk::new();
    let experiments = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments");
    desk.put("arm.yaml", &arm("[0, 60, 90]", ""));
    let robot = "model: {simulated: {model: arm.yaml}}\nplant: {simulated: {model: arm.yaml}}\n";
    desk.put("own.yaml", &format!("extends: {experiments}/smoke.yaml\nname: arm\n{robot}"));
    let said = desk.refused("run own.yaml --out out");
    assert!(said.starts_with("error: arm.yaml:3:"), "{said}");
    assert!(
        said.contains(
            "tendons.angles_deg: found segment 1 with tendons on one side only (0°, 60°, 90°)"
        ),
        "{said}"
    );
    // A robot with another number of tendons cannot replay the model's commands.
    desk.put("arm.yaml", &arm("[0, 120, 240]", ""));
    desk.put(
        "own.yaml",
        &format!(
            "extends: {experiments}/smoke.yaml\nname: arm\nmodel: {{simulated: {{model: \
                  arm.yaml}}}}\n"
        ),
    );
    let said = desk.refused("run own.yaml --out out");
    assert!(said.contains("plant: found 4 tendons, expected 3, the number of the model"), "{said}");
}

#[test]
fn a_look_leaves_published_results_alone_and_says_where_it_went() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("results")).unwrap();
    desk.put("results/PUBLISHED", "published\n");
    desk.put("results/claims.md", "published\n");
    let smoke = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/smoke.yaml");
    let run = format!("run {smoke} --seeds 1");
    let said = desk.ok(&run);
    assert!(
        said.contains("results/ and plots/ here are published; this run writes to out/"),
        "{said}"
    );
    assert!(
        said.contains("out/results/smoke/table1.md") && said.contains("out/plots/smoke/table1.png"),
        "{said}"
    );
    assert_eq!(std::fs::read_to_string(desk.path("results/claims.md")).unwrap(), "published\n");
    assert_eq!(std::fs::read_dir(desk.path("results")).unwrap().count(), 2);
    assert!(!desk.path("plots").exists() && desk.path("out/results/claims.md").is_file());
    desk.ok("gather out/results/smoke");
    assert!(!desk.path("plots").exists());
    // Other settings under the same name are told before they replace what is there.
    assert!(!desk.ok(&run).contains("other settings"));
    let other = desk.ok(&format!("{run} --set gp.starts=3"));
    let replaced =
        "note: out/results/smoke/ contains results of other settings (`gp`); they are replaced";
    assert!(other.contains(replaced), "{other}");
    // Who names the folder is obeyed.
    desk.ok(&(run + " --out ."));
    assert!(
        desk.path("results/smoke/table1.md").is_file()
            && desk.path("plots/smoke/table1.png").is_file()
    );
}

#[test]
fn a_run_that_is_interrupted_says_that_the_same_command_goes_on() {
    let desk = Desk::new();
    let smoke = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/smoke.yaml");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command
        .args(["run", smoke, "--log", "json"])
        .current_dir(desk.path("."))
        .env("SPINEBENCH_CACHE", ".spinebench/cache");
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stderr.take().unwrap()));
    // The last results may not be stored yet, the first are.
    let finished =
        lines.by_ref().map(Result::unwrap).filter(|line| line.contains("\"finished\"")).nth(11);
    assert!(finished.is_some());
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.contains("the same command resumes")), "{rest:?}");
    let said = desk.ok(&format!("run {smoke}"));
    let line = said.lines().find(|line| line.contains("stages computed")).unwrap();
    assert!(!line.contains(" 0 read"), "{line}");
}

#[test]
fn discover_tells_its_steps() {
    let desk = desk();
    let root = env!("CARGO_MANIFEST_DIR");
    let command = format!(
        "discover --log json --model {root}/models/nominal.yaml --measured \
         {root}/tests/reference/twin/nothing.csv --baseline \
         {root}/tests/reference/twin/baseline.csv --out out"
    );
    let said = desk.ok(&command);
    for step in [
        "checking the recording",
        "trying the effects one by one",
        "fitting the answer with full accuracy",
    ] {
        assert!(said.contains(&format!("\"text\":\"{step}\"")), "{step}: {said}");
    }
    assert!(said.contains("\"event\":\"step\""), "{said}");
}

#[test]
fn the_version_names_the_revision_as_python_writes_it() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_spinebench"))
        .arg("--version")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(said.trim(), format!("spinebench {}", spinebench::VERSION));
    let pattern = r"^\d+\.\d+\.\d+(\+[0-9a-f]{8}(\.modified)?)?$";
    assert!(regex::Regex::new(pattern).unwrap().is_match(spinebench::VERSION), "{said}");
}
