//! The league from outside: submissions are scored twice with the same bytes, a policy that peeks
//! learns nothing, a faulty one loses its trials alone, and another process serves a robot.
//!
//! Without Python or a kernel that can confine a policy the tests are skipped, and say so; with
//! `SPINEBENCH_PEERS=required`, as in `.ci/run`, Python has to be there.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

const POLICIES: &str = include_str!("../data/league/policy.py");

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Whether the tests can run here.
fn is_possible() -> bool {
    let succeeds = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output();
        output.is_ok_and(|output| output.status.success())
    };
    let has_python = succeeds("python3", &["-c", "import json"]);
    let required = std::env::var("SPINEBENCH_PEERS").is_ok_and(|value| value == "required");
    assert!(has_python || !required, "without python3");
    let confine = ["league", "confine", "--read", "/usr", "--", "/bin/true"];
    let is_possible = has_python && succeeds(env!("CARGO_BIN_EXE_spinebench"), &confine);
    if !is_possible {
        eprintln!("skipped: without python3, or a kernel that can confine a policy");
    }
    is_possible
}

/// A folder with a track of one small robot, and a place for submissions.
struct League(tempfile::TempDir);

impl League {
    fn new() -> League {
        let league = League(tempfile::tempdir().unwrap());
        let root = root();
        let tracks = league.path("tracks");
        std::fs::create_dir_all(&tracks).unwrap();
        let track = format!(
            "about: A small track.\ntask: {{reach: {{modes: [closed]}}}}\nrobots: robots.yaml\nrobots_each: 1\n\
             hidden: {{least_effects: 1, most_effects: 1, effects: [tip_load]}}\nnoise_m: 0.0005\nsamples: 10\nanswer_s: 2.0\n\
             floor: [integral]\nexperiment:\n  extends: {}\n  training: {{paper: null}}\n  targets: {{pool: 20, drawn: 2, \
             sweep: {{rows: 5, columns: 5}}}}\n  reach: {{max_steps: 15}}\n",
            root.join("experiments/paper.yaml").display()
        );
        std::fs::write(tracks.join("small.yaml"), track).unwrap();
        let robots = format!(
            "rod: {{family: paper, model: {}, load_kg: 0.02}}\n",
            root.join("models/nominal.yaml").display()
        );
        std::fs::write(tracks.join("robots.yaml"), robots).unwrap();
        std::fs::write(league.path("secret.txt"), "the truth").unwrap();
        league
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A submission with a policy in YAML.
    fn submit(&self, name: &str, policy: &str) -> PathBuf {
        let folder = self.path(name);
        std::fs::create_dir_all(&folder).unwrap();
        let text = format!(
            "name: {name}\nauthors: [test]\ntrack: small\npolicy: {policy}\ntrained_on: nothing\nreal_samples: 0\nlicence: MIT\n"
        );
        std::fs::write(folder.join("submission.yaml"), text).unwrap();
        std::fs::write(folder.join("policy.py"), POLICIES).unwrap();
        folder
    }

    /// A submission `mine` of answers to a track, with `further` keys.
    fn answering(&self, track: &str, further: &str) -> PathBuf {
        let folder = self.path("mine");
        std::fs::create_dir_all(folder.join("answers")).unwrap();
        let text = format!(
            "name: mine\nauthors: [test]\ntrack: {track}\n{further}answers: answers\ntrained_on: nothing\nreal_samples: 0\nlicence: MIT\n"
        );
        std::fs::write(folder.join("submission.yaml"), text).unwrap();
        folder
    }

    fn python(&self, name: &str, class: &str) -> PathBuf {
        self.submit(name, &format!("{{python: {{file: policy.py, class: {class}}}}}"))
    }

    fn league(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
        command.arg("league").args(arguments);
        command
            .env("SPINEBENCH_CACHE", self.path("cache"))
            .env("SPINEBENCH_TEST_SECRET", "the truth");
        command.current_dir(self.0.path()).output().unwrap()
    }

    /// A command that must end with 2 and these words.
    fn refused(&self, arguments: &[&str], words: &str) {
        let output = self.league(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", said(&output));
        assert!(said(&output).contains(words), "{arguments:?}: {words}: {}", said(&output));
    }

    /// `league score`, which must succeed; its score.
    fn score(&self, folder: &Path) -> Value {
        let output = self.league(&["score", folder.to_str().unwrap(), "--tracks", "tracks"]);
        assert!(output.status.success(), "{}", said(&output));
        serde_json::from_slice(&std::fs::read(folder.join("score/score.json")).unwrap()).unwrap()
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The statuses of the failed trials.
fn failures(score: &Value) -> String {
    score["robots"][0]["cells"][0]["failures"].to_string()
}

#[test]
fn a_strangers_policy_and_a_network_are_scored_twice_with_the_same_bytes() {
    if !is_possible() {
        return;
    }
    let league = League::new();
    let network = league
        .submit("network", "{onnx: {file: net.onnx, position_scale_m: 0.2, pull_scale_m: 0.02}}");
    std::fs::copy(root().join("tests/data/onnx/torch_policy.onnx"), network.join("net.onnx"))
        .unwrap();
    for folder in [league.python("honest", "Honest"), network] {
        let score = league.score(&folder);
        assert_eq!(failures(&score), "{}", "{score}");
        let first = std::fs::read(folder.join("score/score.json")).unwrap();
        league.score(&folder);
        assert_eq!(first, std::fs::read(folder.join("score/score.json")).unwrap());
        let [error, floor] =
            [&score["robots"][0]["cells"][0]["error"], &score["robots"][0]["cells"][0]["floor"]]
                .map(|value| value.as_f64().unwrap());
        assert!(floor > 0.0 && floor < error && error < 1.0, "{score}");
    }
    let table = league.league(&["table", ".", "--out", "board"]);
    assert!(table.status.success(), "{}", said(&table));
    let board = std::fs::read_to_string(league.path("board/board.csv")).unwrap();
    assert_eq!(board.lines().count(), 3, "{board}");
    assert!(std::fs::read_to_string(league.path("board/board.html")).unwrap().contains("honest"));
}

#[test]
fn a_policy_that_peeks_learns_nothing() {
    if !is_possible() {
        return;
    }
    let league = League::new();
    let folder = league.python("peeking", "Peeking");
    // The digest of the submission does not cover it.
    std::fs::create_dir_all(folder.join("score")).unwrap();
    std::fs::write(folder.join("score/beside.txt"), "what an earlier trial has seen").unwrap();
    let score = league.score(&folder);
    assert_eq!(failures(&score), "{}", "{score}");
    assert!(!folder.join("written.txt").exists());
    // The same file without confinement does learn: the test can fail.
    let free = Command::new("python3")
        .arg("policy.py")
        .current_dir(&folder)
        .env("SPINEBENCH_TEST_SECRET", "the truth")
        .output()
        .unwrap();
    let learnt = String::from_utf8_lossy(&free.stdout).into_owned();
    assert!(learnt.matches(',').count() > 6, "{learnt} {}", said(&free));
}

#[test]
fn a_faulty_policy_loses_its_trials_alone() {
    if !is_possible() {
        return;
    }
    let league = League::new();
    for (class, words) in [
        ("NotFinite", "not finite"),
        ("WrongNumber", "wrong number of tendons: found 3, expected 4"),
        ("Late", "late: no answer within 2 s"),
        ("Crashing", "exit status 7"),
        ("Forking", "forbidden system call"),
        ("Hungry", "out of memory"),
    ] {
        let score = league.score(&league.python(&class.to_lowercase(), class));
        let cell = &score["robots"][0]["cells"][0];
        assert_eq!(cell["trials"], 2, "{class}: {score}");
        assert!(
            failures(&score).contains(words) && failures(&score).ends_with(":1}"),
            "{class}: {}",
            failures(&score)
        );
    }
}

#[test]
fn check_reports_all_faults_at_once() {
    let league = League::new();
    let folder = league.submit("of course", "{python: {file: none.py, class: None}}");
    let text = std::fs::read_to_string(folder.join("submission.yaml")).unwrap();
    std::fs::write(
        folder.join("submission.yaml"),
        text.replace("licence: MIT", "licence: ''\nrobots: [snake]"),
    )
    .unwrap();
    let output = league.league(&["check", folder.to_str().unwrap(), "--tracks", "tracks"]);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    for words in
        ["name: found `of course`", "licence: found nothing", "none.py", "robots: found `snake`"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn check_refuses_what_a_score_could_not_stand_for() {
    if !is_possible() {
        return;
    }
    let league = League::new();
    std::fs::write(league.path("beside.py"), POLICIES).unwrap();
    let answers = "{python: {file: policy.py, class: ShortSample, samples: 5}}";
    for (name, policy, words) in [
        (
            "beside",
            "{python: {file: ../beside.py, class: Honest}}",
            "expected a place in the folder",
        ),
        ("dots", "{python: {file: ../dots/policy.py, class: Honest}}", "expected a place in"),
        ("short", answers, "sample: wrong number of tendons: found 3, expected 4"),
        ("class", "{python: {file: policy.py, class: None}}", "found Honest, ShortSample"),
    ] {
        let folder = league.submit(name, policy);
        let output = league.league(&["check", folder.to_str().unwrap(), "--tracks", "tracks"]);
        assert_eq!(output.status.code(), Some(2), "{name}");
        assert!(said(&output).contains(words), "{name}: {}", said(&output));
    }
    let robots = std::fs::read_to_string(league.path("tracks/robots.yaml")).unwrap();
    let engine = ", engine: {name: other, command: [python3, -c, 'import nothing']}}";
    std::fs::write(league.path("tracks/robots.yaml"), robots.replace('}', engine)).unwrap();
    let folder = league.python("honest", "Honest");
    let output = league.league(&["check", folder.to_str().unwrap(), "--tracks", "tracks"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("this machine: engine `other`"), "{}", said(&output));
}

#[test]
fn a_policy_sees_the_tip_of_its_last_sample() {
    if !is_possible() {
        return;
    }
    let league = League::new();
    let policy = "{python: {file: policy.py, class: LastSample, samples: 2}}";
    let score = league.score(&league.submit("last", policy));
    assert_eq!(failures(&score), "{}");
    assert_eq!(score["robot_samples"], 2);
}

#[test]
fn anybody_verifies_a_season_by_the_same_bytes_once_its_secret_is_disclosed() {
    let league = League::new();
    let done = |arguments: &[&str]| {
        let output = league.league(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", said(&output));
    };
    done(&["new-season", "one", "--out", "one.yaml", "--tracks", "tracks"]);
    done(&["seal", "one.yaml", "--secret", "key"]);
    let sealed = std::fs::read_to_string(league.path("one.yaml")).unwrap();
    let key = std::fs::read_to_string(league.path("key")).unwrap();
    assert!(!sealed.contains(key.trim()), "{sealed}");
    league.submit("integral", "{builtin: integral}");
    let score = |out: &str, robots: &[&str]| {
        let arguments =
            [&["score", "integral", "--tracks", "tracks", "--out", out], robots].concat();
        (league.league(&arguments), std::fs::read_to_string(league.path(out).join("score.json")))
    };
    let (scored, first) = score("first", &["--season", "one.yaml", "--secret", "key"]);
    assert!(scored.status.success(), "{}", said(&scored));
    let first = first.unwrap();
    assert!(first.contains("\"sealed\": true") && !first.contains(key.trim()), "{first}");
    let (_, public) = score("public", &["--season", "one.yaml"]);
    let robots =
        |score: &str| serde_json::from_str::<Value>(score).unwrap()["digests"]["robots"].clone();
    assert_ne!(robots(&first), robots(&public.unwrap()));
    let (early, none) = score("early", &["--season", "one.yaml", "--sealed"]);
    assert!(early.status.code() == Some(2) && none.is_err(), "{}", said(&early));
    std::fs::write(league.path("wrong"), "0".repeat(64)).unwrap();
    let wrong = league.league(&["open", "one.yaml", "--secret", "wrong"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(said(&wrong).contains("which was published"), "{}", said(&wrong));
    done(&["open", "one.yaml", "--secret", "key"]);
    assert!(std::fs::read_to_string(league.path("one.yaml")).unwrap().contains(key.trim()));
    let (scored, second) = score("second", &["--season", "one.yaml", "--sealed"]);
    assert!(scored.status.success(), "{}", said(&scored));
    assert_eq!(first, second.unwrap());
    // Other tracks are another season.
    let track = std::fs::read_to_string(league.path("tracks/small.yaml")).unwrap();
    std::fs::write(
        league.path("tracks/small.yaml"),
        track.replace("noise_m: 0.0005", "noise_m: 0.0"),
    )
    .unwrap();
    let other = league.league(&[
        "robots", "small", "--out", "robots", "--tracks", "tracks", "--season", "one.yaml",
    ]);
    assert_eq!(other.status.code(), Some(2));
    assert!(said(&other).contains("tracks: found"), "{}", said(&other));
}

#[test]
fn a_robot_that_is_lost_is_no_failure_of_the_policy() {
    if !is_possible() {
        return;
    }
    let league = League::new();
    let server = "import json, sys\n\
        for line in sys.stdin:\n    \
            if 'hello' not in line: sys.exit(3)\n    \
            print(json.dumps({'robot': {'protocol': 1, 'tendons': 4}}), flush=True)\n";
    std::fs::write(league.path("tracks/server.py"), server).unwrap();
    let robots = std::fs::read_to_string(league.path("tracks/robots.yaml")).unwrap();
    let engine = ", engine: {name: other, command: [python3, server.py]}}";
    std::fs::write(league.path("tracks/robots.yaml"), robots.replace('}', engine)).unwrap();
    let folder = league.submit("integral", "{builtin: integral}");
    let output = league.league(&["score", folder.to_str().unwrap(), "--tracks", "tracks"]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("robot server: ended: exit status 3"), "{}", said(&output));
    assert!(!folder.join("score/score.json").exists());
}

#[test]
fn tracks_robots_and_scores_that_cannot_be_are_refused() {
    let league = League::new();
    let folder = league.submit("integral", "{builtin: integral}");
    let score = league.score(&folder);
    let read = |file: &str| std::fs::read_to_string(league.path(file)).unwrap();
    let refused_with = |file: &str, from: &str, to: &str, command: &[&str], words: &str| {
        let text = read(file);
        assert!(text.contains(from), "{from}: {text}");
        std::fs::write(league.path(file), text.replacen(from, to, 1)).unwrap();
        league.refused(command, words);
        std::fs::write(league.path(file), text).unwrap();
    };
    let check = ["check", "integral", "--tracks", "tracks"];
    std::fs::write(league.path("base.yaml"), "licence: none\n").unwrap();
    for (file, from, to, words) in [
        ("tracks/small.yaml", "noise_m: 0.0005", "noise_m: .nan", "small.yaml: noise_m: found NaN"),
        ("tracks/small.yaml", "answer_s: 2.0", "answer_s: -1", "small.yaml: answer_s: found -1"),
        (
            "tracks/small.yaml",
            "robots_each: 1",
            "robots_each: 0",
            "small.yaml: robots_each: found 0",
        ),
        ("tracks/small.yaml", "modes: [closed]", "modes: []", "small.yaml: modes: found"),
        ("tracks/small.yaml", "floor: [integral]", "floor: [x]", "small.yaml: floor: found x"),
        ("tracks/robots.yaml", "rod: ", "../rod: ", "robots.yaml: ../rod: found `../rod`"),
        (
            "tracks/robots.yaml",
            "load_kg",
            "effects: [creep], load_kg",
            "rod.effects: found none of",
        ),
        ("integral/submission.yaml", "name: integral", "name: a/b", "name: found `a/b`"),
        ("integral/submission.yaml", "name: ", "extends: ../base.yaml\nname: ", "extends: found"),
    ] {
        refused_with(file, from, to, &check, words);
    }
    let cell = score["robots"][0]["cells"][0]["error"].to_string();
    for (from, to, words) in [
        ("\"season\": \"development\"", "\"season\": \"/../../evil\"", "season: found"),
        (&format!("\"error\": {cell}"), "\"error\": -1.0", "expected none below 0"),
        ("\"trials\": 2", "\"trials\": 0", "expected 1 to"),
    ] {
        refused_with("integral/score/score.json", from, to, &["table", "integral"], words);
    }
    let inside = ["score", "integral", "--tracks", "tracks", "--out", "integral/mine"];
    league.refused(&inside, "--out: found");
    assert!(!league.path("integral/mine").exists());
}

#[test]
fn a_season_is_bound_to_its_name_and_its_secret() {
    let league = League::new();
    let done = |arguments: &[&str]| {
        let output = league.league(&[arguments, &["--tracks", "tracks"]].concat());
        assert!(output.status.success(), "{arguments:?}: {}", said(&output));
    };
    for (file, key) in [("one.yaml", "key"), ("again.yaml", "key_2")] {
        done(&["new-season", "one", "--out", file]);
        let sealed = league.league(&["seal", file, "--secret", key]);
        assert!(sealed.status.success(), "{}", said(&sealed));
    }
    league.submit("integral", "{builtin: integral}");
    league.submit("jacobian", "{builtin: online_jacobian}");
    let sealed = ["--season", "one.yaml", "--secret", "key", "--out", "scores/integral"];
    done(&[["score", "integral"].as_slice(), &sealed].concat());
    let again = ["--season", "again.yaml", "--secret", "key_2", "--out", "scores/jacobian"];
    done(&[["score", "jacobian"].as_slice(), &again].concat());
    league.refused(&["table", "scores"], "digests.secret: found");

    let season = std::fs::read_to_string(league.path("one.yaml")).unwrap();
    let refused = |from: &str, to: &str, words: &str| {
        assert!(season.contains(from), "{season}");
        std::fs::write(league.path("forged.yaml"), season.replace(from, to)).unwrap();
        let forged = ["score", "integral", "--tracks", "tracks", "--season", "forged.yaml"];
        league.refused(&forged, words);
    };
    refused("public_seed: ", "public_seed: 1", "public_seed: found 1");
    refused("season: one", "season: development", "season: found `development`");
    for name in ["a/b", "development", "x_sealed", ""] {
        let new = ["new-season", name, "--out", "x.yaml", "--tracks", "tracks"];
        league.refused(&new, "season: found");
    }
}

#[test]
fn a_wrong_name_is_a_missed_detection_a_wrong_isolation_or_a_false_alarm() {
    let league = League::new();
    let names = league.answering("which", "").join("answers");
    let track = "about: A small track.\ntask: {name: {trials: 1, rows: 3, step_s: 0.2, step_share: 0.1, pull_share: 1.0}}\n\
        robots: robots.yaml\nrobots_each: 6\nhidden: {least_effects: 0, most_effects: 1, effects: [tip_load]}\nnoise_m: 0.0005\n";
    std::fs::write(league.path("tracks/which.yaml"), track).unwrap();
    // What went wrong with each robot, where all get one answer.
    let faults = |answer: &str| -> Vec<String> {
        let rows = (1..=6).map(|number| format!("rod_{number},{answer}\n")).collect::<String>();
        std::fs::write(names.join("names.csv"), "robot,effects\n".to_owned() + &rows).unwrap();
        let score = league.score(&league.path("mine"));
        let cells = score["robots"].as_array().unwrap().iter().map(|robot| &robot["cells"][0]);
        let fault = |cell: &Value| {
            let failures = cell["failures"].to_string();
            assert_eq!(cell["error"].as_f64(), Some(f64::from(u8::from(failures != "{}"))));
            failures
        };
        cells.map(fault).collect()
    };
    let nothing = faults("");
    assert!(nothing.iter().any(|fault| fault == "{}"), "{nothing:?}");
    assert!(nothing.iter().any(|fault| fault != "{}"), "{nothing:?}");
    for (rows, words) in [
        ("rod_1,creep\nrod_1,\n", "found 2 rows of `rod_1`, expected one"),
        ("rod_1,creep creep\n", "names.csv:2: effects: found `creep`"),
        ("rod_1,none\n", "names.csv:2: effects: found `none`"),
    ] {
        std::fs::write(names.join("names.csv"), format!("robot,effects\n{rows}")).unwrap();
        league.refused(&["check", "mine", "--tracks", "tracks"], words);
    }
    for (answer, where_nothing_is_right, elsewhere) in [
        ("", "{}", r#"{"missed detection":1}"#),
        ("tip_load", r#"{"false alarm":1}"#, "{}"),
        ("creep", r#"{"false alarm":1}"#, r#"{"wrong isolation":1}"#),
    ] {
        let expected = nothing
            .iter()
            .map(|fault| if fault == "{}" { where_nothing_is_right } else { elsewhere });
        assert_eq!(faults(answer), expected.collect::<Vec<_>>(), "{answer}");
    }
}

#[test]
fn what_simulate_writes_is_an_answer() {
    let league = League::new();
    let track = "about: A small track.\ntask: {identify: {trials: 1, asked: 1, rows: 3, step_s: 0.2, step_share: 0.1, pull_share: 1.0}}\n\
        robots: robots.yaml\nrobots_each: 1\nhidden: {least_effects: 1, most_effects: 1, effects: [tip_load]}\nnoise_m: 0.0005\n";
    std::fs::write(league.path("tracks/unseen.yaml"), track).unwrap();
    let robots = league.league(&["robots", "unseen", "--out", "questions", "--tracks", "tracks"]);
    assert!(robots.status.success(), "{}", said(&robots));
    let folder = league.answering("unseen", "");
    let asked = |file: &str| league.path(&format!("questions/rod_1/{file}"));
    let mut simulate = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    simulate
        .arg("simulate")
        .arg("--model")
        .arg(asked("model.yaml"))
        .arg("--commands")
        .arg(asked("asked.csv"));
    simulate.arg("--out").arg(folder.join("answers/rod_1.csv"));
    let simulated = simulate.output().unwrap();
    assert!(simulated.status.success(), "{}", said(&simulated));
    let score = league.score(&league.path("mine"));
    assert!(score["robots"][0]["cells"][0]["error"].as_f64().unwrap() > 0.0, "{score}");
    // Answers to the questions of another season would be scored on other robots.
    league.answering("unseen", "questions: one\n");
    league.refused(&["check", "mine", "--tracks", "tracks"], "questions: found `one`");
}

#[test]
fn a_real_robot_plays_where_its_recording_is() {
    let league = League::new();
    let rows = league.path("rows");
    std::fs::create_dir_all(&rows).unwrap();
    let model = std::fs::read_to_string(root().join("models/nominal.yaml")).unwrap();
    std::fs::write(rows.join("arm_start.yaml"), &model).unwrap();
    let recording = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m,tip_x_m,tip_y_m,tip_z_m,valid,pattern\n\
        0,0,0,0,0,0,0,0,0.22,1,one\n0,1,0.002,0,-0.002,0,0.01,0,0.21,1,one\n\
        0,2,0.002,0.002,-0.002,-0.002,0.01,0.01,0.21,1,pair_1\n0,3,0.003,0.003,-0.003,-0.003,,,,0,pair_1\n\
        0,4,0.004,0.004,-0.004,-0.004,0.02,0.02,0.2,1,pair_2\n";
    std::fs::write(rows.join("arm.csv"), recording).unwrap();
    let digest = |text: &str| spinebench::runner::Digest::of(text.as_bytes());
    let track = format!(
        "about: A small track.\ntask: {{identify: {{trials: 1, asked: 1, rows: 3, step_s: 0.2, step_share: 0.1, pull_share: 1.0}}}}\n\
         robots: robots.yaml\nrobots_each: 1\nhidden: {{least_effects: 1, most_effects: 1, effects: [tip_load]}}\nnoise_m: 0.0005\n\
         measured:\n  arm:\n    recording: {{file: arm.csv, digest: {}}}\n    model: {{file: arm_start.yaml, digest: {}}}\n    \
         asked: [pair_*]\n",
        digest(recording),
        digest(&model)
    );
    std::fs::write(league.path("tracks/unseen.yaml"), track).unwrap();
    let measured = ["--tracks", "tracks", "--measured", "rows"];
    let robots =
        league.league(&[["robots", "unseen", "--out", "questions"].as_slice(), &measured].concat());
    assert!(robots.status.success(), "{}", said(&robots));
    let [given, asked] = ["given", "asked"].map(|name| {
        std::fs::read_to_string(league.path(&format!("questions/arm/{name}.csv"))).unwrap()
    });
    assert!(given.lines().count() == 3 && given.contains("at_rest"), "{given}");
    // The row without a tip is not asked.
    assert!(asked.lines().count() == 3 && !asked.contains("tip"), "{asked}");

    let folder = league.answering("unseen", "robots: [arm]\n");
    // 2.2 mm beside tips of a robot of 220 mm.
    let answer =
        "trial,time_s,tip_x_m,tip_y_m,tip_z_m\n0,2,0.0122,0.01,0.21\n0,4,0.02,0.0222,0.2\n";
    std::fs::write(folder.join("answers/arm.csv"), answer).unwrap();
    let score = league.league(&[["score", "mine"].as_slice(), &measured].concat());
    assert!(score.status.success(), "{}", said(&score));
    let score: Value =
        serde_json::from_slice(&std::fs::read(folder.join("score/score.json")).unwrap()).unwrap();
    let robot = &score["robots"][0];
    assert_eq!(
        [&robot["robot"], &robot["family"], &robot["engine"]],
        ["arm", "arm", "measured"],
        "{score}"
    );
    assert!((robot["cells"][0]["error"].as_f64().unwrap() - 0.01).abs() < 1e-9, "{score}");

    let refused = |arguments: &[&str], words: &[&str]| {
        let output = league.league(&[["check", "mine"].as_slice(), arguments].concat());
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(words.iter().all(|words| said.contains(words)), "{words:?}: {said}");
    };
    refused(&measured[..2], &["robots: found `arm`", "needs --measured DIR"]);
    let other = recording.replace("0.01,0.01,0.21", "0.01,0.01,0.20");
    std::fs::write(rows.join("arm.csv"), &other).unwrap();
    let [found, expected] = [&other[..], recording].map(|text| digest(text).to_string());
    let key = "unseen.yaml: measured.arm.recording.digest: found";
    refused(&measured, &[key, &found, "arm.csv", &expected]);
    std::fs::remove_file(rows.join("arm.csv")).unwrap();
    refused(&measured, &["measured.arm.recording.file: found no", "arm.csv", "expected"]);
}

#[test]
fn another_process_serves_a_robot_over_a_pipe_and_over_a_port() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let commands: String = (0..6)
        .map(|row| {
            format!("0,{:.1},{p},0,-{p},0\n", 0.2 * f64::from(row), p = 0.002 * f64::from(row))
        })
        .collect();
    std::fs::write(
        folder.path().join("in.csv"),
        format!("trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n{commands}"),
    )
    .unwrap();
    let collect = |plant: &str, out: &str| {
        let text = format!(
            "external:\n  model: {}\n  {plant}\n",
            root().join("models/nominal.yaml").display()
        );
        std::fs::write(folder.path().join("plant.yaml"), text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
        command.args(["collect", "--plant", "plant.yaml", "--commands", "in.csv", "--out", out]);
        command.current_dir(folder.path()).output().unwrap()
    };
    let robot = root().join("benches/league/example_robot.py").display().to_string();
    let pipe = collect(&format!("command: [python3, {robot}]"), "pipe.csv");
    assert!(pipe.status.success(), "{}", said(&pipe));
    let rows = std::fs::read_to_string(folder.path().join("pipe.csv")).unwrap();
    // The arm of that file: 8 mm on a lever of 10 mm bend 200 mm by 0.8 rad.
    assert!(rows.lines().count() == 7 && rows.contains("0.0758233"), "{rows}");
    let serve = "import socketserver, subprocess, sys\n\
                 class One(socketserver.StreamRequestHandler):\n\
                 \tdef handle(self):\n\
                 \t\tsubprocess.run([sys.executable, sys.argv[1]], stdin=self.request, stdout=self.request)\n\
                 server = socketserver.TCPServer(('127.0.0.1', 0), One)\n\
                 print(server.server_address[1], flush=True)\n\
                 server.handle_request()\n";
    let mut server =
        Command::new("python3").args(["-c", serve, &robot]).stdout(Stdio::piped()).spawn().unwrap();
    let mut port = String::new();
    std::io::BufRead::read_line(
        &mut std::io::BufReader::new(server.stdout.as_mut().unwrap()),
        &mut port,
    )
    .unwrap();
    let socket = collect(&format!("address: '127.0.0.1:{}'", port.trim()), "socket.csv");
    assert!(socket.status.success(), "{}", said(&socket));
    assert_eq!(rows, std::fs::read_to_string(folder.path().join("socket.csv")).unwrap());
    server.wait().unwrap();
    let far = collect("address: '8.8.8.8:80'", "far.csv");
    assert_eq!(far.status.code(), Some(2));
    assert!(said(&far).contains("an address of this machine"), "{}", said(&far));
}
