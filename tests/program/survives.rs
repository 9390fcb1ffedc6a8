//! Runs that are killed, share a store, find it damaged or full: nothing is lost, nothing
//! half-computed is believed, and the results are the same bytes.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::support::runs::{assert_same, published};
use rand::RngExt;
use spinebench::base::Seed;
use spinebench::runner::Store;

const SMOKE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/smoke.yaml");
/// A smoke reproduction of one seed: all of Table I's and Fig. 8's stages.
const RUN: [&str; 6] = ["run", SMOKE, "--seeds", "1", "--threads", "2"];

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command.current_dir(folder).args(arguments).env("SPINEBENCH_CACHE", ".spinebench/cache");
    command
}

fn spinebench(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

/// Runs to the end; stages computed and read, and all that was said.
fn run(folder: &Path, more: &[&str]) -> (usize, usize, String) {
    let output = spinebench(folder, &[&RUN, more].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    let line = said.lines().find(|line| line.contains("stages computed")).unwrap();
    let numbers: Vec<usize> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    (numbers[0], numbers[1], said)
}

/// What an undisturbed run publishes, how many stages it computes and how long it takes.
fn undisturbed(folder: &Path) -> (BTreeMap<PathBuf, Vec<u8>>, usize, Duration) {
    let began = Instant::now();
    let (computed, cached, _) = run(folder, &[]);
    assert_eq!(cached, 0);
    let found = published(folder);
    assert!(found.len() > 10, "{:?}", found.keys());
    (found, computed, began.elapsed())
}

fn begin(folder: &Path) -> Child {
    command(folder, &RUN).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn store(folder: &Path) -> Store {
    Store::at(folder.join(".spinebench/cache"))
}

/// Two hundred times a run is killed at a random moment and begun again. After up to twenty kills
/// it is left to get through, however slow the machine is meanwhile: its bytes are those of an
/// undisturbed run, and the store is emptied.
#[test]
fn kills_change_no_byte_and_lose_only_what_was_in_flight() {
    // `make campaign` asks for 200.
    let wanted: usize =
        std::env::var("KILLS").map_or(20, |kills| kills.parse().expect("a number of kills"));
    let folder = tempfile::tempdir().unwrap();
    let calm = tempfile::tempdir().unwrap();
    let (expected, stages, whole) = undisturbed(calm.path());
    let mut random = Seed(21).rng();
    let (mut kills, mut kills_of_this, mut finished) = (0, 0, 0);
    let mut patience = random.random_range(1..=20);
    while kills < wanted {
        let mut child = begin(folder.path());
        if kills_of_this < patience {
            // Late and early moments alike, those of publishing included.
            let wait = whole.mul_f64(random.random_range(0.0..0.5_f64));
            let began = Instant::now();
            while began.elapsed() < wait && child.try_wait().unwrap().is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
            if child.try_wait().unwrap().is_none() {
                child.kill().unwrap();
                (kills, kills_of_this) = (kills + 1, kills_of_this + 1);
            }
        }
        let status = child.wait().unwrap();
        let store = store(folder.path());
        let entries = store.entries().unwrap();
        for entry in &entries {
            assert_eq!(store.damage(entry), None, "after kill {kills}");
        }
        if status.success() {
            assert_same(
                &published(folder.path()),
                &expected,
                &format!("after {kills_of_this} kills"),
            );
            finished += 1;
            kills_of_this = 0;
            patience = random.random_range(1..=20);
            std::fs::remove_dir_all(folder.path()).unwrap();
            std::fs::create_dir(folder.path()).unwrap();
        }
    }
    let before = store(folder.path()).entries().unwrap().len();
    let (computed, _, _) = run(folder.path(), &[]);
    assert_same(&published(folder.path()), &expected, "at last");
    assert_eq!(
        before + computed,
        stages,
        "what was stored is not computed again, and nothing is missing"
    );
    assert!(finished >= (wanted / 22).max(1), "{finished} runs got through");

    let pruned = spinebench(folder.path(), &["cache", "prune"]);
    let said = String::from_utf8(pruned.stdout).unwrap();
    assert!(said.starts_with("removed 0 entries and "), "{said}");
    assert!(store(folder.path()).leftovers().unwrap().is_empty());
}

#[test]
fn fifty_damages_are_all_detected_and_mended() {
    let folder = tempfile::tempdir().unwrap();
    let (expected, _, _) = undisturbed(folder.path());
    let store = store(folder.path());
    let entries = store.entries().unwrap();
    let mut random = Seed(22).rng();
    for round in 0..50 {
        let entry = &entries[random.random_range(0..entries.len())];
        let path = store.path(&entry.stage, &entry.key);
        let good = std::fs::read(&path).unwrap();
        let mut bad = good.clone();
        match random.random_range(0..3) {
            0 => bad[random.random_range(0..good.len())] ^= 1 << random.random_range(0..8),
            1 => bad.truncate(random.random_range(0..good.len())),
            _ => bad.extend_from_slice(b"more"),
        }
        std::fs::write(&path, &bad).unwrap();
        let verified = spinebench(folder.path(), &["cache", "verify"]);
        let said = String::from_utf8(verified.stdout).unwrap();
        assert_eq!(verified.status.code(), Some(1), "round {round}: {said}");
        assert!(said.contains(&format!("{} {}: ", entry.stage, entry.key.short())), "{said}");
        assert!(said.ends_with(" 1 damaged\n"), "{said}");
        if round % 5 == 0 {
            // A run mends it if it asks for it, and gives the same bytes in any case.
            let (computed, _, said) = run(folder.path(), &[]);
            assert!(computed <= 1 && said.matches("is damaged").count() == computed, "{said}");
            assert_same(&published(folder.path()), &expected, "mended");
        }
        std::fs::write(&path, &good).unwrap();
    }
    let verified = spinebench(folder.path(), &["cache", "verify"]);
    assert_eq!(verified.status.code(), Some(0), "{}", String::from_utf8_lossy(&verified.stdout));
}

#[test]
fn processes_that_share_a_store_share_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let calm = tempfile::tempdir().unwrap();
    let (expected, stages, _) = undisturbed(calm.path());
    let outs = ["one", "two", "three"];
    let children: Vec<Child> = outs
        .iter()
        .map(|out| {
            let arguments = [&RUN[..], &["--out", out]].concat();
            command(folder.path(), &arguments)
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap()
        })
        .collect();
    let mut computed = 0;
    for child in children {
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        let line = said.lines().find(|line| line.contains("stages computed")).unwrap();
        computed += line.split(' ').find_map(|word| word.parse::<usize>().ok()).unwrap();
    }
    assert_eq!(computed, stages, "every stage is computed by one of them");
    for out in outs {
        assert_same(&published(&folder.path().join(out)), &expected, out);
    }
}

/// A folder in a file system of one or two megabytes, if this process may mount one.
fn small_disk(folder: &Path, size: &str) -> Option<Mounted> {
    std::fs::create_dir_all(folder).unwrap();
    let mut mount = Command::new("mount");
    mount.args(["-t", "tmpfs", "-o", size, "tmpfs"]).arg(folder).stderr(Stdio::null());
    mount.status().is_ok_and(|status| status.success()).then(|| Mounted(folder.to_owned()))
}

struct Mounted(PathBuf);

impl Drop for Mounted {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_is_told_and_leaves_everything_good() {
    let folder = tempfile::tempdir().unwrap();
    let calm = tempfile::tempdir().unwrap();
    let (expected, _, _) = undisturbed(calm.path());
    let Some(_disk) = small_disk(&folder.path().join("small"), "size=256k") else {
        // Past the harness, which shows nothing of tests that pass.
        let _ = writeln!(
            std::io::stderr(),
            "skipped: mounting a small disk needs rights that this process does not have"
        );
        return;
    };
    // The store is full: the run goes on without it.
    let (_, _, said) = run(folder.path(), &["--cache", "small/cache"]);
    assert_eq!(
        said.matches("results cannot be kept in small/cache: No space left").count(),
        1,
        "{said}"
    );
    assert_same(&published(folder.path()), &expected, "without a store");
    let kept = Store::at(folder.path().join("small/cache"));
    let entries = kept.entries().unwrap();
    assert!(
        !entries.is_empty() && entries.iter().all(|entry| kept.damage(entry).is_none()),
        "{}",
        entries.len()
    );
    assert!(kept.leftovers().unwrap().is_empty());

    // The results find no room: none of them is new.
    std::fs::remove_dir_all(folder.path().join("small/cache")).unwrap();
    let out = folder.path().join("small");
    std::fs::create_dir_all(out.join("results/smoke")).unwrap();
    std::fs::write(out.join("results/smoke/trials.csv"), "old").unwrap();
    let output = spinebench(folder.path(), &[&RUN[..], &["--out", "small"]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("No space left on device"), "{said}");
    assert_eq!(std::fs::read(out.join("results/smoke/trials.csv")).unwrap(), b"old");
    assert_eq!(published(&out).len(), 1, "nothing half-written: {:?}", published(&out).keys());
}

#[test]
fn folders_that_take_nothing_are_told_before_or_after_the_work() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let output = spinebench(folder.path(), &[&RUN[..], &["--out", "file"]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.starts_with("error: file: found "), "{said}");
    let (_, _, said) = run(folder.path(), &["--cache", "file"]);
    assert_eq!(said.matches("results cannot be kept in file").count(), 1, "{said}");
}

/// A limit on memory ends the process; what it had stored is good and the next run goes on from
/// there.
#[test]
fn a_limit_on_memory_leaves_a_good_store() {
    let folder = tempfile::tempdir().unwrap();
    let calm = tempfile::tempdir().unwrap();
    let (expected, _, _) = undisturbed(calm.path());
    let mut ended = 0;
    // Beside the program itself, which must be mapped before it can say anything.
    let program_kb = std::fs::metadata(env!("CARGO_BIN_EXE_spinebench")).unwrap().len() / 1024;
    for kilobytes in [10_000, 60_000, 190_000].map(|more| program_kb + more) {
        let script = format!("ulimit -v {kilobytes}; exec \"$@\"");
        let mut command = Command::new("bash");
        command.args(["-c", &script, "bash", env!("CARGO_BIN_EXE_spinebench")]).args(RUN);
        let output = command
            .current_dir(folder.path())
            .env("SPINEBENCH_CACHE", ".spinebench/cache")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        if !output.status.success() {
            ended += 1;
            assert!(said.contains("memory") || said.contains("thread"), "{said}");
        }
        let store = store(folder.path());
        assert!(store.entries().unwrap().iter().all(|entry| store.damage(entry).is_none()));
    }
    assert!(ended > 0, "the limits were not felt");
    run(folder.path(), &[]);
    assert_same(&published(folder.path()), &expected, "at last");
}
