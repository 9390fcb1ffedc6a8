//! `simulate`, `collect`, `calibrate` and `effects` through the program itself.

use spinebench::base::{Plant, Seed, TendonCommand};
use spinebench::data::Recording;
use spinebench::data::recording::Extra;
use spinebench::effects::{CATALOGUE, Model};
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::rod::TipWrench;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const NOMINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/models/nominal.yaml");
const LENGTHS: &str = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m";
const TENSIONS: &str = "trial,time_s,tendon_1_n,tendon_2_n,tendon_3_n,tendon_4_n";

/// A folder with files in it, and the program run there.
struct Bench(tempfile::TempDir);

impl Bench {
    fn new() -> Bench {
        Bench(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn run(&self, arguments: &str) -> Output {
        let program = Path::new(env!("CARGO_BIN_EXE_spinebench"));
        let words = arguments.split(' ').map(|word| if word == "NOMINAL" { NOMINAL } else { word });
        Command::new(program).args(words).current_dir(self.0.path()).output().unwrap()
    }

    /// Runs what must succeed.
    fn ok(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
        said + &String::from_utf8(output.stdout).unwrap()
    }

    /// Runs what must be refused with exit status 2, in one line, leaving no file `out*`.
    fn refused(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        assert!(said.starts_with("error: ") && said.trim_end().lines().count() == 1, "{said}");
        for entry in std::fs::read_dir(self.0.path()).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            assert!(!name.starts_with("out") && !name.starts_with('.'), "{arguments} left {name}");
        }
        said
    }

    fn simulated(&self, flags: &str, commands: &str) -> Recording {
        self.put("in.csv", commands);
        self.ok(&format!("simulate --model NOMINAL --commands in.csv --out out.csv{flags}"));
        Recording::read(&self.path("out.csv")).unwrap()
    }
}

fn nominal() -> Model {
    let text = include_str!("../../models/nominal.yaml");
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text))
        .unwrap()
}

fn plant() -> Simulated {
    let options = SimulatedOptions { travel_m: f64::INFINITY, ..SimulatedOptions::default() };
    Simulated::new(&nominal(), &[], options)
}

fn pulls(all: [f64; 4]) -> Vec<TendonCommand> {
    all.map(TendonCommand::Pull).to_vec()
}

fn tips(recording: &Recording) -> &[[f64; 3]] {
    recording.tip_m.as_deref().unwrap()
}

fn statuses(recording: &Recording) -> Vec<String> {
    let found = recording.extra.iter().find(|(name, _)| name == "solver_status").unwrap();
    let Extra::Text(cells) = &found.1 else { panic!("{found:?}") };
    cells.clone()
}

fn apart_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    spinebench::base::distance_m(&a, &b)
}

#[test]
fn static_lengths_are_the_equilibria_of_the_rod_with_all_digits() {
    let bench = Bench::new();
    let out = bench.simulated(
        " --static",
        &format!("{LENGTHS}\n0,0,0,0,0,0\n0,0.2,0.01,0,-0.01,0\n0,0.4,0.01,0.01,-0.01,-0.01\n1,0,0.005,0,-0.004,0\n"),
    );
    let mut plant = plant();
    let commands =
        [[0.0; 4], [0.01, 0.0, -0.01, 0.0], [0.01, 0.01, -0.01, -0.01], [0.005, 0.0, -0.004, 0.0]];
    for (row, command) in commands.into_iter().enumerate() {
        plant.reset(Seed(0)).unwrap();
        let seen = plant.settle(&pulls(command)).unwrap();
        assert!(apart_m(seen.tip_m, tips(&out)[row]) < 1e-8, "row {row}");
        let quaternion = out.tip_quaternion.as_ref().unwrap()[row];
        assert!((quaternion.iter().map(|q| q * q).sum::<f64>() - 1.0).abs() < 1e-9);
    }
    // Pulling tendon 1 bends up, and gravity lets the robot hang at home.
    assert!(
        tips(&out)[1][0] > tips(&out)[0][0] + 0.02 && tips(&out)[0][0] < -0.005,
        "{:?}",
        tips(&out)
    );
    assert_eq!(statuses(&out), ["converged"; 4]);
    let header = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    for column in [
        "tip_qw",
        "tension_1_n",
        "tension_4_n",
        "solver_residual_m",
        "space_error_m",
        "solver_status",
    ] {
        assert!(header.lines().next().unwrap().split(',').any(|name| name == column), "{header}");
    }
    assert!(
        header.lines().nth(2).unwrap().split(',').any(|cell| cell.len() >= 17),
        "all digits: {header}"
    );
}

#[test]
fn static_rows_carry_their_own_loads() {
    let bench = Bench::new();
    let columns =
        "tip_force_x_n,tip_force_y_n,tip_force_z_n,tip_moment_x_nm,tip_moment_y_nm,tip_moment_z_nm";
    let out = bench.simulated(
        " --static",
        &format!(
            "{LENGTHS},{columns}\n0,0,0,0,0,0,0.1,0,0,0,0,0\n0,1,0,0,0,0,0,0,0,0,0.01,0\n0,2,0,0,0,0,0,0,0,0,0,0\n\
             0,3,0.01,0,-0.01,0,0,-0.2,0.1,0,0,0.005\n"
        ),
    );
    let rows: [([f64; 4], [f64; 3], [f64; 3]); 4] = [
        ([0.0; 4], [0.1, 0.0, 0.0], [0.0; 3]),
        ([0.0; 4], [0.0; 3], [0.0, 0.01, 0.0]),
        ([0.0; 4], [0.0; 3], [0.0; 3]),
        ([0.01, 0.0, -0.01, 0.0], [0.0, -0.2, 0.1], [0.0, 0.0, 0.005]),
    ];
    for (row, (command, force, moment)) in rows.into_iter().enumerate() {
        let mut plant = plant();
        plant.set_extra_tip_load(TipWrench { force_n: force.into(), moment_nm: moment.into() });
        let seen = plant.settle(&pulls(command)).unwrap();
        assert!(
            apart_m(seen.tip_m, tips(&out)[row]) < 1e-8,
            "row {row}: {:?} {:?}",
            seen.tip_m,
            tips(&out)[row]
        );
    }
    let home = tips(&out)[2];
    assert!(tips(&out)[0][0] > home[0] + 1e-3, "a force along x lifts");
    assert!(tips(&out)[1][0] > home[0] + 1e-3, "a moment about y turns z towards x");
}

/// A known load is a mass at the tip, trial by trial, and may change from row to row; at rest it is
/// its weight.
#[test]
fn known_loads_hang_on_the_tip() {
    let bench = Bench::new();
    let out = bench.simulated(
        " --static",
        &format!("{LENGTHS},known_load_kg\n0,0,0,0,0,0,0\n0,1,0,0,0,0,0.02\n1,0,0,0,0,0,0.02\n1,1,0,0,0,0,0\n"),
    );
    let [without, with] = [tips(&out)[0], tips(&out)[1]];
    assert!(with[0] < without[0] - 0.005, "{with:?} {without:?}");
    assert!(
        apart_m(with, tips(&out)[2]) < 1e-7 && apart_m(without, tips(&out)[3]) < 1e-7,
        "{:?}",
        tips(&out)
    );
    bench.put(
        "loaded.yaml",
        &std::fs::read_to_string(NOMINAL)
            .unwrap()
            .replace("effects: []", "effects: [{tip_load: {mass_kg: 0.02}}]"),
    );
    bench.put("plain.csv", &format!("{LENGTHS}\n0,0,0,0,0,0\n"));
    bench.ok("simulate --model loaded.yaml --commands plain.csv --out loaded.csv");
    let loaded = Recording::read(&bench.path("loaded.csv")).unwrap();
    assert!(apart_m(with, tips(&loaded)[0]) < 1e-7);
}

#[test]
fn a_moving_row_shows_the_robot_before_its_command_and_long_holds_come_to_rest() {
    let bench = Bench::new();
    let out = bench.simulated("", &format!("{LENGTHS}\n3,0,0.01,0,-0.01,0\n3,0.001,0.01,0,-0.01,0\n3,0.002,0,0,0,0\n3,0.3,0.01,0,-0.01,0\n3,100.3,0,0,0,0\n7,0,0.02,0,-0.02,0\n"));
    let mut plant = plant();
    let home = plant.reset(Seed(0)).unwrap().tip_m;
    let bent = plant.settle(&pulls([0.01, 0.0, -0.01, 0.0])).unwrap().tip_m;
    let seen = tips(&out);
    assert!(apart_m(seen[0], home) < 1e-9, "the first command acts from time 0 on");
    assert!(
        apart_m(seen[1], home) > 1e-3 && apart_m(seen[2], seen[1]) > 1e-3,
        "steps of 1 ms: {seen:?}"
    );
    assert!(
        apart_m(seen[4], bent) < 1e-6,
        "100 s are enough to come to rest: {:e} m",
        apart_m(seen[4], bent)
    );
    assert!(apart_m(seen[5], home) < 1e-9, "a trial of one row starts at home");
    assert_eq!(statuses(&out), ["converged"; 6]);
    assert!(out.valid.is_none());
}

#[test]
fn tensions_drive_too_and_are_reported() {
    let bench = Bench::new();
    let tensions = LENGTHS.replace("_m,", "_n,").replace("tendon_4_m", "tendon_4_n");
    let out = bench.simulated(
        " --static",
        &format!("{tensions}\n0,0,0,0,0,0\n0,1,5,0,0,0\n0,2,0,5,0,0\n0,3,0,-1,0,0\n0,4,0,0,5,0\n"),
    );
    let mut plant = plant();
    plant.reset_slack(Seed(0));
    let bent = plant.apply_tensions(&[5.0, 0.0, 0.0, 0.0], true).unwrap().tip_m;
    assert!(apart_m(tips(&out)[1], bent) < 1e-8 && bent[0] > tips(&out)[0][0] + 0.02);
    // A tendon cannot push: that row has a name, and takes no other with it.
    assert_eq!(statuses(&out), ["converged", "converged", "converged", "bad_command", "converged"]);
    assert_eq!(out.valid.as_deref(), Some(&[true, true, true, false, true][..]));
    let text = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    assert!(!text.to_lowercase().contains("nan"), "{text}");
    let moving = bench.simulated("", &format!("{tensions}\n0,0,5,0,0,0\n0,20,0,0,0,0\n"));
    assert!(apart_m(tips(&moving)[1], bent) < 1e-6, "20 s at 5 N come to rest");
}

#[test]
fn a_trial_that_fails_marks_its_rows_and_spares_the_others() {
    let bench = Bench::new();
    let out = bench.simulated(
        "",
        &format!(
            "{LENGTHS}\n0,0,0,0,0,0\n0,0.2,0.4,0,0,0\n0,0.4,0,0,0,0\n0,0.6,0,0,0,0\n1,0,0.01,0,-0.01,0\n1,0.2,0,0,0,0\n"
        ),
    );
    assert_eq!(out.valid.as_deref(), Some(&[true, true, false, false, true, true][..]));
    let statuses = statuses(&out);
    assert!(
        statuses[2] != "converged" && statuses[2] == statuses[3] && !statuses[2].contains(' '),
        "{statuses:?}"
    );
    assert!([0, 1, 4, 5].iter().all(|&row| statuses[row] == "converged"), "{statuses:?}");
    let said = bench.ok("simulate --model NOMINAL --commands in.csv --out out.csv");
    assert!(said.contains("2 of 6 rows could not be solved"), "{said}");
}

#[test]
fn parquet_is_as_good_as_csv_and_unknown_columns_are_carried() {
    let bench = Bench::new();
    let commands = format!(
        "{LENGTHS},camera,note\n0,0,0,0,0,0,7,\"a, \
         b\"\n0,0.2,0.01,0,-0.01,0,8,\n0,0.5,0,0,0,0,9,c\n"
    );
    let csv = bench.simulated("", &commands);
    bench.ok("simulate --model NOMINAL --commands in.csv --out out.parquet");
    let parquet = Recording::read(&bench.path("out.parquet")).unwrap();
    assert_eq!(parquet.tip_m, csv.tip_m);
    bench.ok("simulate --model NOMINAL --commands out.parquet --out again.csv");
    let again = Recording::read(&bench.path("again.csv")).unwrap();
    assert_eq!(again.tip_m, csv.tip_m);
    assert_eq!(
        std::fs::read(bench.path("again.csv")).unwrap(),
        std::fs::read(bench.path("out.csv")).unwrap()
    );
    let note = csv.extra.iter().find(|(name, _)| name == "note").unwrap();
    assert_eq!(note.1, Extra::Text(vec!["a, b".into(), String::new(), "c".into()]));
    assert!(csv.extra.iter().any(|(name, _)| name == "camera"));
}

/// A helix of several turns hangs at rest; on the requested grid its rest would be 3 mm away.
#[test]
fn a_rod_at_rest_stays_where_it_is_on_any_grid() {
    let bench = Bench::new();
    let helix = "robot:\n  backbone: {length_m: 0.6, radius_m: 0.002, youngs_modulus_pa: 1e7, \
                 poisson_ratio: 0.5, density_kg_m3: 1200, pieces: [{end_m: 0.6, \
                 rest_curvature_rad_m: [14, 0, 7]}]}\n  tendons: {radius_m: 0.002, angles_deg: \
                 [0]}\n  gravity_m_s2: [0, 0, 9.81]\n  damping_time_s: 0.02\n";
    bench.put("helix.yaml", helix);
    bench.put("in.csv", "trial,time_s,tendon_1_n\n0,0,0\n0,0.5,0\n");
    bench.ok("simulate --model helix.yaml --commands in.csv --out out.csv");
    let out = Recording::read(&bench.path("out.csv")).unwrap();
    let apart_m = apart_m(tips(&out)[0], tips(&out)[1]);
    assert!(apart_m < 1e-6 && statuses(&out) == ["converged", "converged"], "{apart_m}");
}

/// Editors of some systems begin a file with a byte-order mark, or write UTF-16.
#[test]
fn files_with_a_byte_order_mark_are_read() {
    let bench = Bench::new();
    let plain = std::fs::read(NOMINAL).unwrap();
    let commands = format!("{LENGTHS}\n0,0,0,0,0,0\n0,0.2,0.002,0,-0.002,0\n");
    let marked = [b"\xEF\xBB\xBF".as_slice(), &plain].concat();
    let wide: Vec<u8> = format!("\u{feff}{}", String::from_utf8_lossy(&plain))
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    bench.put("commands.csv", &commands);
    bench.put("marked.csv", &format!("\u{feff}{commands}"));
    std::fs::write(bench.path("marked.yaml"), marked).unwrap();
    std::fs::write(bench.path("wide.yaml"), wide).unwrap();
    bench.ok("simulate --model NOMINAL --commands commands.csv --out out.csv --static");
    for model in ["marked.yaml", "wide.yaml"] {
        bench
            .ok(&format!("simulate --model {model} --commands marked.csv --out same.csv --static"));
        assert_eq!(
            std::fs::read(bench.path("same.csv")).unwrap(),
            std::fs::read(bench.path("out.csv")).unwrap()
        );
    }
    bench.put("plant.yaml", "\u{feff}simulated: {model: marked.yaml}\n");
    bench.ok("collect --plant plant.yaml --commands marked.csv --out rec.csv");
}

#[test]
fn bad_models_are_refused_by_file_line_and_key() {
    let bench = Bench::new();
    bench.put("in.csv", &format!("{LENGTHS}\n0,0,0,0,0,0\n"));
    let good = std::fs::read_to_string(NOMINAL).unwrap();
    let cases = [
        ("radius_m: 0.002", "radius_m: -0.002", "radius_m"),
        ("radius_m: 0.002", "radius_mm: 2", "radius_mm"),
        ("youngs_modulus_pa: 2.33e9", "youngs_modulus_pa: stiff", "youngs_modulus_pa"),
        ("youngs_modulus_pa: 2.33e9", "youngs_modulus_pa: .nan", "youngs_modulus_pa"),
        ("poisson_ratio: 0.3897", "poisson_ratio: 0.7", "poisson_ratio"),
        ("count: 11", "count: 30", "length_m"),
        ("count: 11", "count: -1", "count"),
        ("count: 12", "count: 1000000000000", "count"),
        ("angles_deg: [0, 90, 180, 270]", "angles_deg: []", "angles_deg"),
        ("effects: []", "effects: [{tip_load: {mass_kg: -1}}]", "mass_kg"),
        ("effects: []", "effects: [{tip_lode: {mass_kg: 1}}]", "tip_lode"),
        ("effects: []", "effects: [{actuator_gain: {tendon: 5, scale: 1.1}}]", "tendon"),
        ("damping_time_s: 0.03", "damping_time_s: 0.03\n  resolution: {cell_m: 1e-12}", "cell_m"),
        (
            "damping_time_s: 0.03",
            "damping_time_s: 0.03\n  resolution: {bending_modes: 1000000}",
            "bending_modes",
        ),
    ];
    for (from, to, key) in cases {
        let text = good.replace(from, to);
        assert_ne!(text, good, "{from}");
        bench.put("model.yaml", &text);
        let said = bench.refused("simulate --model model.yaml --commands in.csv --out out.csv");
        let place =
            text.lines().position(|line| line.contains(to.lines().last().unwrap().trim())).unwrap()
                + 1;
        assert!(
            said.contains("model.yaml") && said.contains(&place.to_string()) && said.contains(key),
            "{to}: {said}"
        );
    }
    bench.refused("simulate --model none.yaml --commands in.csv --out out.csv");
}

#[test]
fn bad_commands_and_places_are_refused() {
    let bench = Bench::new();
    let three = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m\n0,0,0,0,0\n";
    let cases = [
        (three.to_owned(), "line 1, column `tendon_4_m`"),
        (format!("{LENGTHS},tendon_5_m\n0,0,0,0,0,0,0\n"), "line 1, column `tendon_5_m`"),
        (format!("{LENGTHS},tendon_1000000000000_m\n0,0,0,0,0,0,0\n"), "column `tendon_5_m`"),
        (format!("{LENGTHS}\n0,0,0,x,0,0\n"), "line 2, column `tendon_2_m`"),
        (format!("{LENGTHS}\n0,0,0,0,0,0\n0,0,0,0,0,0\n"), "line 3, column `time_s`"),
        (format!("{LENGTHS}\n0,0.1,0,0,0,0\n"), "line 2, column `time_s`"),
        (format!("{LENGTHS}\n0,0,0,0,0,inf\n"), "line 2, column `tendon_4_m`"),
        (format!("{LENGTHS}\n"), "in.csv"),
        (String::new(), "in.csv"),
    ];
    for (commands, place) in cases {
        bench.put("in.csv", &commands);
        let said = bench.refused("simulate --model NOMINAL --commands in.csv --out out.csv");
        assert!(said.contains("in.csv") && said.contains(place), "{said}");
    }
    bench.put("in.csv", &format!("{LENGTHS}\n0,0,0,0,0,0\n"));
    bench.put("file", "");
    for out in ["file/out.csv", "/proc/none/out.csv"] {
        let said =
            bench.refused(&format!("simulate --model NOMINAL --commands in.csv --out {out}"));
        assert!(said.contains(out), "{said}");
    }
    bench.refused("calibrate --model NOMINAL --measured in.csv --out out.yaml");
    let measured = |rows: &str| {
        bench.put("in.csv", &format!("{LENGTHS},tip_x_m,tip_y_m,tip_z_m\n{rows}"));
        bench.refused("calibrate --model NOMINAL --measured in.csv --out out.yaml")
    };
    let far = measured("0,0,0,0,0,0,0,0,0.2\n0,0.2,3,0,-3,0,0,0,0.2\n");
    assert!(
        ["in.csv", "line 3", "tendon_1_m", "millimetres"].iter().all(|word| far.contains(word)),
        "{far}"
    );
    let long = measured("0,0,0,0,0,0,0,0,0.2\n0,1e8,0,0,0,0,0,0,0.2\n");
    assert!(
        ["in.csv", "line 3", "time_s", "milliseconds"].iter().all(|word| long.contains(word)),
        "{long}"
    );
}

#[test]
fn collect_measures_with_noise_by_seed_and_heeds_the_travel() {
    let bench = Bench::new();
    bench.put("plant.yaml", &format!("simulated: {{model: {NOMINAL}, noise_m: 0.0005}}\n"));
    let rows: String = (0..60).map(|k| format!("0,{},0,0,0,0\n", 0.2 * f64::from(k))).collect();
    bench.put("in.csv", &format!("{LENGTHS}\n{rows}"));
    let collect = |out: &str, more: &str| {
        bench.ok(&format!("collect --plant plant.yaml --commands in.csv --out {out}{more}"));
        Recording::read(&bench.path(out)).unwrap()
    };
    let (one, same, other) =
        (collect("a.csv", ""), collect("b.csv", ""), collect("c.csv", " --seed 2"));
    assert_eq!(one, same);
    assert_ne!(one.tip_m, other.tip_m);
    assert!(one.tip_quaternion.is_none() && one.extra.is_empty(), "a tracker sees the tip");
    for axis in 0..3 {
        let values: Vec<f64> = tips(&one).iter().map(|tip| tip[axis]).collect();
        let spread = spinebench::math::summary::standard_deviation(&values);
        assert!((3.5e-4..6.5e-4).contains(&spread), "axis {axis}: {spread} m");
    }
    bench.put("in.csv", &format!("{LENGTHS}\n0,0,0.061,0,-0.061,0\n0,0.2,0,0,0,0\n"));
    let refused = collect("d.csv", "");
    assert_eq!(refused.valid.as_deref(), Some(&[true, false][..]), "travel is 60 mm");
}

#[test]
fn weights_hung_on_tendons_calibrate_the_shipped_plant() {
    let bench = Bench::new();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/calibration");
    bench.ok(&format!(
        "collect --plant {folder}/plant.yaml --commands {folder}/weights.csv --out rec.csv"
    ));
    bench.put("guess.yaml", &std::fs::read_to_string(NOMINAL).unwrap().replace("2.33e9", "2.0e9"));
    let said = bench.ok("calibrate --model guess.yaml --measured rec.csv --out fitted.yaml");
    let numbers: Vec<f64> = said
        .lines()
        .find(|line| line.starts_with("youngs"))
        .unwrap()
        .split([' ', ','])
        .filter_map(|word| word.parse().ok())
        .collect();
    let [value, _, low, high] = numbers[..] else { panic!("{said}") };
    assert!(
        low < value && value < high && low < 2.33e9 && 2.33e9 < high && high - low < 0.03e9,
        "{said}"
    );
    let fitted = spinebench::specs::read_model(&bench.path("fitted.yaml")).unwrap();
    assert_eq!(fitted.robot.backbone.poisson_ratio, 0.3897);
    assert!((fitted.robot.backbone.youngs_modulus_pa / value - 1.0).abs() < 1e-5);
    let poisson = bench
        .run("calibrate --model guess.yaml --measured rec.csv --fit poisson_ratio --out out.yaml");
    assert!(
        poisson.status.code() == Some(2) && !bench.path("out.yaml").exists(),
        "the ratio is held"
    );
}

#[test]
fn the_catalogue_tells_what_each_effect_is() {
    let bench = Bench::new();
    let all = bench.ok("effects");
    for card in CATALOGUE {
        let one = bench.ok(&format!("effects {}", card.name));
        assert!(all.contains(&one), "{one}");
        let parts = [card.missing, card.equation, card.source];
        assert!(parts.iter().all(|part| !part.is_empty() && one.contains(part)), "{one}");
        assert!(card.parameters.iter().all(|parameter| one.contains(parameter.name)), "{one}");
        assert!(
            !card.confused_with.is_empty()
                && card.confused_with.iter().all(|name| one.contains(name)),
            "{one}"
        );
    }
    assert!(bench.run("effects tip_lode").status.code() == Some(2));
}

const TRACKED: &str =
    "tracking: {points: {end: {s_m: 0.22}, mid: {s_m: 0.1, offset_m: [0.02, 0, 0]}}}\n";

/// The model's points are written beside the tip; `collect` measures them, with noise of their own.
#[test]
fn tracked_points_are_simulated_and_collected() {
    let bench = Bench::new();
    let nominal = std::fs::read_to_string(NOMINAL).unwrap();
    bench.put("tracked.yaml", &format!("{nominal}{TRACKED}"));
    let rows = "0,0,0,0,0,0,still\n0,0.2,0.01,0,-0.01,0,bend\n0,0.4,0.01,0,-0.01,0,bend\n";
    bench.put("in.csv", &format!("{LENGTHS},pattern\n{rows}"));
    bench.ok("simulate --model tracked.yaml --commands in.csv --out sim.csv");
    let out = Recording::read(&bench.path("sim.csv")).unwrap();
    let [end, mid] = ["end", "mid"].map(|name| out.point(name).unwrap());
    assert_eq!(Some(&end.position_m), out.tip_m.as_ref());
    assert_eq!(end.quaternion, out.tip_quaternion);
    assert!(
        mid.position_m[2][2] < 0.11 && mid.position_m[2][0] > mid.position_m[0][0] + 0.005,
        "{mid:?}"
    );
    assert_eq!(out.pattern.as_ref().unwrap(), &["still", "bend", "bend"]);
    bench.ok("simulate --model NOMINAL --commands in.csv --out plain.csv");
    let plain = Recording::read(&bench.path("plain.csv")).unwrap();
    assert_eq!(
        (&plain.tip_m, plain.points.is_empty()),
        (&out.tip_m, true),
        "points change nothing else"
    );

    bench.put("plant.yaml", "simulated: {model: tracked.yaml, noise_m: 0.001}\n");
    bench.ok("collect --plant plant.yaml --commands in.csv --out rec.csv");
    let recorded = Recording::read(&bench.path("rec.csv")).unwrap();
    let apart = apart_m(recorded.point("mid").unwrap().position_m[2], mid.position_m[2]);
    assert!(apart > 1e-5 && apart < 6e-3, "{apart}");
    assert_eq!(recorded.point("mid").unwrap().quaternion, None);
    bench.put(
        "untracked.yaml",
        "simulated: {model: NOMINAL, noise_m: 0.001}\n".replace("NOMINAL", NOMINAL).as_str(),
    );
    bench.ok("collect --plant untracked.yaml --commands in.csv --out tip.csv");
    assert_eq!(
        Recording::read(&bench.path("tip.csv")).unwrap().tip_m,
        recorded.tip_m,
        "noise of its own"
    );
    bench.put("replay.yaml", "replay: {recording: rec.csv}\n");
    bench.ok("collect --plant replay.yaml --commands in.csv --out again.csv");
    assert_eq!(Recording::read(&bench.path("again.csv")).unwrap().points, recorded.points);

    let said = bench.refused("simulate --model NOMINAL --commands rec.csv --out no.csv");
    assert!(
        said.contains(
            "rec.csv, line 1, column `point_end_x_m`: found the point `end`, expected no \
                       tracked point"
        ),
        "{said}"
    );
    bench.put("bad.yaml", &format!("{nominal}tracking: {{tip: {{s_m: -1}}}}\n"));
    let said = bench.refused("simulate --model bad.yaml --commands in.csv --out no.csv");
    assert!(
        said.contains("tracking.tip.s_m: found -1, expected a place on the backbone"),
        "{said}"
    );
    bench.put("bad.yaml", &format!("{nominal}tracking: {{points: {{end: {{s_m: 0.3}}}}}}\n"));
    let said = bench.refused("simulate --model bad.yaml --commands in.csv --out no.csv");
    assert!(
        said.contains("tracking.points.end.s_m: found 0.3, expected a place on the backbone"),
        "{said}"
    );
}

const DRIVEN: &str = "drives: {pan: {tendons: [1, 3], gains: [0.02, -0.02]}, tilt: {tendons: [2, \
                      4], gains: [1, -1]}}\n";

/// Servos and screws in place of tendons: the same robot, the same tip; what is written carries the
/// drives.
#[test]
fn drives_move_tendons() {
    let bench = Bench::new();
    let nominal = std::fs::read_to_string(NOMINAL).unwrap();
    bench.put("driven.yaml", &format!("{nominal}{DRIVEN}"));
    bench.put(
        "in.csv",
        "trial,time_s,drive_pan_rad,drive_tilt_m\n0,0,0,0\n0,0.2,0.5,0.004\n0,0.4,-0.1,0.004\n",
    );
    bench.put(
        "tendons.csv",
        &format!("{LENGTHS}\n0,0,0,0,0,0\n0,0.2,0.01,0.004,-0.01,-0.004\n0,0.4,-0.002,0.004,0.002,-0.004\n"),
    );
    bench.ok("simulate --model driven.yaml --commands in.csv --out a.csv");
    bench.ok("simulate --model driven.yaml --commands tendons.csv --out b.csv");
    let [a, b] = ["a.csv", "b.csv"].map(|name| Recording::read(&bench.path(name)).unwrap());
    assert_eq!(a.tip_m, b.tip_m);
    assert_eq!((a.drives.len(), a.drives[0].displacement.as_slice()), (2, &[0.0, 0.5, -0.1][..]));
    bench.put("plant.yaml", "simulated: {model: driven.yaml}\n");
    bench.ok("collect --plant plant.yaml --commands in.csv --out rec.csv");
    assert_eq!(Recording::read(&bench.path("rec.csv")).unwrap().tip_m, a.tip_m);
    bench.put("replay.yaml", &format!("replay:\n  recording: rec.csv\n  {DRIVEN}"));
    bench.ok("collect --plant replay.yaml --commands in.csv --out again.csv");
    let again = Recording::read(&bench.path("again.csv")).unwrap();
    assert_eq!((&again.tip_m, &again.drives), (&a.tip_m, &a.drives));
    let said = bench.refused("simulate --model NOMINAL --commands in.csv --out no.csv");
    assert!(
        said.contains(
            "in.csv, line 1, column `drive_pan_rad`: found the drive `pan`, expected displacements \
             of tendons"
        ),
        "{said}"
    );
    for (drives, words) in [
        ("{pan: {tendons: [1, 3]}}", "drives.pan.gains: found no such key"),
        (
            "{pan: {tendons: [1, 3], gains: [0.02]}}",
            "drives.pan.gains: found [0.02], expected one number per tendon",
        ),
        (
            "{pan: {tendons: [1, 5], gains: [1, 1]}}",
            "drives.pan.tendons: found [1, 5], expected numbers of tendons",
        ),
    ] {
        bench.put("bad.yaml", &format!("{nominal}drives: {drives}\n"));
        let said = bench.refused("simulate --model bad.yaml --commands in.csv --out no.csv");
        assert!(said.contains("bad.yaml:") && said.contains(words), "{said}");
    }
}

/// A trial that starts anywhere is at rest under its first command; one that goes on is where the
/// one before ended.
#[test]
fn trials_start_where_the_model_or_the_option_says() {
    let bench = Bench::new();
    let rows = "0,0,0.01,0,-0.01,0\n0,0.2,0.01,0,-0.01,0\n0,0.4,0.008,0,-0.008,0\n1,0,0,0.01,0,-0.01\n1,0.2,0,0.01,0,-0.01\n";
    bench.put("in.csv", &format!("{LENGTHS}\n{rows}"));
    let simulated = |flags: &str| {
        let said =
            bench.ok(&format!("simulate --model NOMINAL --commands in.csv --out sim.csv{flags}"));
        (Recording::read(&bench.path("sim.csv")).unwrap(), said)
    };
    let (home, said) = simulated("");
    assert!(!said.contains("note:"), "the default needs no words: {said}");
    let (still, _) = simulated(" --static");
    let (away, said) = simulated(" --starts anywhere");
    assert!(
        said.contains("Each trial starts at rest under its first command (starts: anywhere)."),
        "{said}"
    );
    let (on, said) = simulated(" --starts continue");
    assert!(said.contains("(starts: continue)"), "{said}");
    for row in [0, 3] {
        assert!(apart_m(tips(&away)[row], tips(&still)[row]) < 1e-6, "row {row}");
        assert!(apart_m(tips(&away)[row], tips(&home)[row]) > 5e-3, "row {row}");
    }
    assert!(apart_m(tips(&away)[1], tips(&away)[0]) < 1e-6, "it stays at rest");
    assert_eq!(tips(&on)[..3], tips(&home)[..3], "the first trial starts at home");
    assert!(
        apart_m(tips(&on)[3], tips(&still)[2]) < 1e-6,
        "at rest under the last command of the trial before"
    );
    let nominal = std::fs::read_to_string(NOMINAL).unwrap();
    bench.put("away.yaml", &format!("{nominal}tracking: {{starts: anywhere}}\n"));
    bench.ok("simulate --model away.yaml --commands in.csv --out model.csv");
    assert_eq!(Recording::read(&bench.path("model.csv")).unwrap(), away, "the model says the same");
    bench.put("on.yaml", &format!("{nominal}tracking: {{starts: continue}}\n"));
    let said = bench.refused("discover --model on.yaml --measured sim.csv --out found");
    assert!(
        said.contains("tracked rows: found 5, expected at least 30"),
        "what continues is played, too: {said}"
    );
}

/// With a memory in the robot, poses at rest depend on the way, and `continue` carries it from
/// trial to trial.
#[test]
fn memory_goes_on_with_the_trials() {
    let bench = Bench::new();
    let nominal = std::fs::read_to_string(NOMINAL).unwrap();
    let effects = "effects: [{backlash: {width_m: 0.002}}]";
    bench.put("memory.yaml", &nominal.replace("effects: []", effects));
    let (bend, back) = ("0.015,0,-0.015,0", "0.002,0,-0.002,0");
    bench.put("one.csv", &format!("{LENGTHS}\n0,0,{bend}\n0,0,{back}\n"));
    bench.put("two.csv", &format!("{LENGTHS}\n0,5,{bend}\n1,4,{back}\n"));
    bench.ok("simulate --static --model memory.yaml --commands one.csv --out one_out.csv");
    bench.ok("simulate --static --model memory.yaml --commands two.csv --out apart.csv");
    bench.ok(
        "simulate --static --starts continue --model memory.yaml --commands two.csv --out on.csv",
    );
    let read = |name: &str| tips(&Recording::read_poses(&bench.path(name)).unwrap())[1];
    assert!(apart_m(read("one_out.csv"), read("on.csv")) < 1e-9);
    assert!(apart_m(read("one_out.csv"), read("apart.csv")) > 1e-4);
}

/// Each trial under its own gravity, as a model under it.
#[test]
fn gravity_changes_from_trial_to_trial() {
    let bench = Bench::new();
    let columns = "gravity_x_m_s2,gravity_y_m_s2,gravity_z_m_s2";
    let rows = "0,0,0,0,0,0,-9.81,0,0\n0,0.2,0.01,0,-0.01,0,-9.81,0,0\n1,0,0,0,0,0,0,0,9.81\n1,0.2,0.01,0,-0.01,0,0,0,9.81\n";
    bench.put("in.csv", &format!("{LENGTHS},{columns}\n{rows}"));
    bench.put("plain.csv", &format!("{LENGTHS}\n0,0,0,0,0,0\n0,0.2,0.01,0,-0.01,0\n"));
    let nominal = std::fs::read_to_string(NOMINAL).unwrap();
    bench.put(
        "hung.yaml",
        &nominal.replace("gravity_m_s2: [-9.81, 0, 0]", "gravity_m_s2: [0, 0, 9.81]"),
    );
    bench.ok("simulate --model NOMINAL --commands in.csv --out both.csv");
    bench.ok("simulate --model NOMINAL --commands plain.csv --out lying.csv");
    bench.ok("simulate --model hung.yaml --commands plain.csv --out hung.csv");
    let [both, lying, hung] = ["both.csv", "lying.csv", "hung.csv"]
        .map(|name| Recording::read(&bench.path(name)).unwrap());
    assert_eq!(tips(&both), [tips(&lying), tips(&hung)].concat());
    assert!(apart_m(tips(&lying)[0], tips(&hung)[0]) > 5e-3);
    assert!(both.gravity_m_s2.is_some(), "carried");
    let said =
        bench.refused("simulate --starts continue --model NOMINAL --commands in.csv --out no.csv");
    assert!(
        said.contains("in.csv, row 3: found another gravity than in the first trial"),
        "{said}"
    );
}

/// A string that bends within a hundredth of its length: the error names the key, and with the
/// value that it asks for there is a tip.
#[test]
fn a_grid_that_is_too_coarse_is_told_with_its_key() {
    let bench = Bench::new();
    let model = |resolution: &str| {
        format!(
            "robot:\n  backbone: {{length_m: 0.7144, radius_m: 0.000675, youngs_modulus_pa: 2.0e6, \
             poisson_ratio: 0.49, density_kg_m3: 1200}}\n  tendons: {{radius_m: 0.0151, \
             angles_deg: [0, 90, 180, 270]}}\n  gravity_m_s2: [-9.81, 0, 0]\n{resolution}"
        )
    };
    bench.put("string.yaml", &model(""));
    bench.put("tolerant.yaml", &model("  resolution: {static_tolerance_m: 1.0e-5}\n"));
    bench
        .put("rest.csv", "trial,time_s,tendon_1_n,tendon_2_n,tendon_3_n,tendon_4_n\n0,0,0,0,0,0\n");
    let refused =
        bench.run("simulate --static --model string.yaml --commands rest.csv --out out.csv");
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(
        said.contains("string.yaml: robot.resolution.static_tolerance_m: found 0.000001, which"),
        "{said}"
    );
    bench.ok("simulate --static --model tolerant.yaml --commands rest.csv --out out.csv");
    let tip_m = Recording::read(&bench.path("out.csv")).unwrap().tip_m.unwrap()[0];
    assert!((tip_m[0] + 0.712).abs() < 0.002, "{tip_m:?}");
}

const LOADS: &str =
    "tip_force_x_n,tip_force_y_n,tip_force_z_n,tip_moment_x_nm,tip_moment_y_nm,tip_moment_z_nm";
const WIRE: &str = "robot:\n  backbone: {length_m: 0.30, radius_m: 0.002, youngs_modulus_pa: \
                    2.5e9, poisson_ratio: 0.39, density_kg_m3: 1200}\n  tendons: {radius_m: 0.01, \
                    angles_deg: [0, 90, 180, 270], pretension_m: 0}\n  gravity_m_s2: [0, 0, 0]\n";

fn column(recording: &Recording, name: &str) -> Vec<String> {
    let found = recording
        .extra
        .iter()
        .find(|(own, _)| own == name)
        .unwrap_or_else(|| panic!("no column {name}"));
    match &found.1 {
        Extra::Text(cells) => cells.clone(),
        Extra::Numbers(numbers) => numbers.iter().map(f64::to_string).collect(),
        other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn a_rest_says_on_which_branch_it_is() {
    let bench = Bench::new();
    bench.put("wire.yaml", WIRE);
    let rows =
        ["0,0,0,0,0,0,0,0,-0.5,0,0,0", "0,1,0,0,0,0,0,0,-1.3,0,0,0", "0,2,0,0,0,0,0,0,-1.31,0,0,0"];
    bench.put("in.csv", &format!("{TENSIONS},{LOADS}\n{}\n", rows.join("\n")));
    bench.ok("simulate --static --model wire.yaml --commands in.csv --out out.csv");
    let out = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!(statuses(&out), ["converged"; 3]);
    assert_eq!(column(&out, "branch"), ["same", "bifurcation", "same"]);
    assert!(tips(&out)[1][0] > 0.1 && tips(&out)[2][0] > tips(&out)[1][0], "{:?}", tips(&out));
}

#[test]
fn a_fluttering_rest_is_told_and_a_motion_starts_there() {
    let bench = Bench::new();
    let load = "  damping_time_s: 0\n  loads:\n  - point: {position_m: 0.3, force_n: [0, 0, -7.5], \
                frame: body}\n";
    bench.put("beck.yaml", &format!("{WIRE}{load}"));
    bench.put("in.csv", &format!("{TENSIONS}\n0,0,0,0,0,0\n0,0.5,0,0,0,0\n"));
    let refused = bench.run("simulate --static --model beck.yaml --commands in.csv --out rest.csv");
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        refused.status.code() == Some(1) && said.contains("robot.loads: every equilibrium"),
        "{said}"
    );
    bench.ok("simulate --model beck.yaml --commands in.csv --out out.csv");
    let out = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!(statuses(&out), ["flutters", "converged"]);
    assert!(tips(&out)[0][0].abs() < 1e-9 && tips(&out)[1][0].abs() > 1e-3, "{:?}", tips(&out));
}

#[test]
fn contact_is_written_with_its_force_and_place() {
    let bench = Bench::new();
    bench.put(
        "wall.yaml",
        &format!("{WIRE}obstacles: [{{plane: {{normal: [1, 0, 0], distance_m: -0.032}}}}]\n"),
    );
    let rows = "0,0,0,0,0,0,-0.05,0,0,0,0,0\n0,1,0,0,0,0,-0.3,0,0,0,0,0\n";
    bench.put("in.csv", &format!("{TENSIONS},{LOADS}\n{rows}"));
    for flags in [" --static", ""] {
        bench.ok(&format!("simulate --model wall.yaml --commands in.csv --out out.csv{flags}"));
        let out = Recording::read(&bench.path("out.csv")).unwrap();
        // Without contact the place is empty.
        let number = |cell: &String| cell.parse().unwrap_or(f64::NAN);
        let numbers = |name: &str| column(&out, name).iter().map(number).collect::<Vec<f64>>();
        assert_eq!(numbers("contact_force_x_n")[0], 0.0);
        if flags.is_empty() {
            continue;
        }
        // The surface is 2 mm from the axis: the tip is held at −30 mm.
        assert!(
            (numbers("contact_force_x_n")[1] - 0.1942).abs() < 1e-3
                && numbers("contact_s_m")[1] == 0.3
        );
        assert!((tips(&out)[1][0] + 0.030).abs() < 5e-5, "{:?}", tips(&out));
    }
}

#[test]
fn calibrate_finds_the_place_of_a_wall() {
    let bench = Bench::new();
    let nominal = std::fs::read_to_string(NOMINAL).unwrap();
    let wall = |x_m: f64| {
        format!("{nominal}obstacles: [{{plane: {{normal: [-1, 0, 0], distance_m: {x_m}}}}}]\n")
    };
    bench.put("truth.yaml", &wall(-0.03));
    bench.put("guess.yaml", &wall(-0.035));
    let rows: String =
        (0..20).map(|k| format!("0,{k},{0},0,-{0},0\n", 0.001 * f64::from(k))).collect();
    bench.put("in.csv", &format!("{LENGTHS}\n{rows}"));
    bench.ok("simulate --static --model truth.yaml --commands in.csv --out rec.csv");
    bench.ok("calibrate --static --model guess.yaml --measured rec.csv --fit \
              obstacles[0].plane.distance_m --out fitted.yaml");
    let fitted = spinebench::specs::read_model(&bench.path("fitted.yaml")).unwrap();
    let found_m = fitted.obstacles[0].plane.unwrap().distance_m;
    assert!((found_m + 0.03).abs() < 1e-4, "{found_m}");
}
