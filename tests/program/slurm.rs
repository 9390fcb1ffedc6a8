//! Runs on a real Slurm: two emulated nodes on loopback, one of which loses power. Where Slurm
//! cannot be installed the test says so and is skipped.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::support::runs::{assert_same, published};
use spinebench::runner::Store;

const SMOKE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/smoke.yaml");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/program/cluster.sh");
/// Repetitions: so many that workers are busy for some seconds.
const SEEDS: &str = "8";
/// Longer than anything here takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// A cluster that is ended when it is dropped.
struct Cluster {
    folder: PathBuf,
    environment: Vec<(String, String)>,
}

impl Cluster {
    fn script(arguments: &[&str]) -> Output {
        // Arrays of ten tasks at most, so that a task starts several workers.
        Command::new("bash")
            .arg(SCRIPT)
            .args(arguments)
            .env("MAX_ARRAY_SIZE", "11")
            .output()
            .unwrap()
    }

    /// A cluster of two nodes, or why there can be none.
    fn start(folder: &Path) -> Result<Cluster, String> {
        let installed = Cluster::script(&["install"]);
        if installed.status.code() == Some(77) {
            return Err(String::from_utf8_lossy(&installed.stdout).trim().to_owned());
        }
        let failed = |what: &str, output: &Output| {
            panic!("{what}: {}", String::from_utf8_lossy(&output.stderr))
        };
        if !installed.status.success() {
            failed("install", &installed);
        }
        let name = folder.to_str().unwrap();
        let started = Cluster::script(&["start", name, "2"]);
        if !started.status.success() {
            failed("start", &started);
        }
        let lines = std::fs::read_to_string(folder.join("env")).unwrap();
        let variable = |line: &str| {
            line.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()))
        };
        Ok(Cluster {
            folder: folder.to_owned(),
            environment: lines.lines().filter_map(variable).collect(),
        })
    }

    fn tell(&self, action: &str, node: &str) {
        let output = Cluster::script(&[action, self.folder.to_str().unwrap(), node]);
        assert!(
            output.status.success(),
            "{action} {node}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.envs(self.environment.iter().map(|(name, value)| (name, value)));
        command
    }

    fn squeue(&self, format: &str) -> String {
        let output = self
            .command("squeue")
            .args(["--noheader", "--array", "--format", format])
            .output()
            .unwrap();
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    fn spinebench(&self, folder: &Path, arguments: &[&str]) -> Command {
        let mut command = self.command(env!("CARGO_BIN_EXE_spinebench"));
        command.current_dir(folder).args(arguments).env("SPINEBENCH_CACHE", ".spinebench/cache");
        command
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let _ = Cluster::script(&["stop", self.folder.to_str().unwrap()]);
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Waits until `holds`, which must come true.
fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < PATIENCE, "{what} did not come");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// The end of a child, killed when it takes too long.
fn end(mut child: Child) -> Output {
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > PATIENCE {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    child.wait_with_output().unwrap()
}

fn entries(folder: &Path) -> usize {
    Store::at(folder.join(".spinebench/cache")).entries().map_or(0, |entries| entries.len())
}

#[test]
fn runs_on_a_real_cluster_are_those_of_this_machine() {
    let folder = tempfile::tempdir().unwrap();
    let cluster = match Cluster::start(&folder.path().join("cluster")) {
        Ok(cluster) => cluster,
        Err(why) => {
            // Past the harness, which shows nothing of tests that pass.
            let _ = writeln!(std::io::stderr(), "skipped: {why}");
            return;
        }
    };
    let room = |name: &str| {
        let room = folder.path().join(name);
        std::fs::create_dir(&room).unwrap();
        room
    };
    let here = room("here");
    let output = cluster.spinebench(&here, &["run", SMOKE, "--seeds", SEEDS]).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    let (expected, stages) = (published(&here), entries(&here));
    assert!(stages > 300, "{stages} stages");
    a_node_loses_power(&cluster, &room("power"), &expected, stages);
    the_limit_is_near(&cluster, &room("limit"), &expected);
    leaving_and_coming_back(&cluster, &room("leave"), &expected);
    calling_off(&cluster, &room("off"));
    failures_are_rows(&cluster, &room("bad"), &room("bad_here"));
    what_the_cluster_refuses_is_told(&cluster, &room("refused"));
}

fn a_node_loses_power(
    cluster: &Cluster,
    folder: &Path,
    expected: &BTreeMap<PathBuf, Vec<u8>>,
    stages: usize,
) {
    let arguments = ["run", SMOKE, "--seeds", SEEDS, "--executor", "slurm", "--jobs", "3"];
    let child = cluster.spinebench(folder, &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let on_n2 = || cluster.squeue("%T %N").lines().any(|line| line.trim() == "RUNNING n2");
    until("a task on the node", || entries(folder) > stages / 10 && on_n2());
    let running = cluster.squeue("%T").lines().filter(|line| *line == "RUNNING").count();
    assert!(running <= 3, "{running} tasks at a time");
    cluster.tell("kill-node", "n2");
    let before = entries(folder);
    assert!(before < stages, "the node died after everything was done");
    let output = end(child);
    let words = said(&output);
    assert!(output.status.success(), "{words}");
    assert!(words.contains("submitted 3 workers in 3 array tasks for "), "{words}");
    let line = words.lines().find(|line| line.contains("stages computed")).unwrap();
    let computed: usize = line.split(' ').find_map(|word| word.parse().ok()).unwrap();
    assert!(computed < stages / 4, "{computed} of {stages} stages were left to this machine");
    assert_same(&published(folder), expected, "not as on this machine");
    cluster.tell("start-node", "n2");
    // Two workers never computed the same entry; what sharing cost them is shown.
    let shared = words.lines().find(|line| line.contains(" worker runs of ")).unwrap();
    assert!(shared.contains(" 0 stages computed twice (0.0 s)"), "{shared}");
    let _ = writeln!(std::io::stderr(), "a node lost power: {shared}");
}

/// The signal that comes before a task's limit: it ends what it has begun, goes back into the queue
/// and goes on later.
fn the_limit_is_near(cluster: &Cluster, folder: &Path, expected: &BTreeMap<PathBuf, Vec<u8>>) {
    let arguments =
        ["run", SMOKE, "--seeds", SEEDS, "--executor", "slurm", "--jobs", "2", "--time-min", "30"];
    let child = cluster.spinebench(folder, &arguments).stderr(Stdio::piped()).spawn().unwrap();
    // One that is about to end does not come back, and one that has just begun does not listen yet:
    // all are told, often.
    let mut told = BTreeSet::new();
    until("a task back in the queue", || {
        if entries(folder) > 3 {
            told.extend(tell_of_the_limit(cluster));
        }
        told.iter().any(|task| is_back(cluster, task))
    });
    let output = end(child);
    assert!(output.status.success(), "{}", said(&output));
    assert!(!said(&output).contains("submitting these stages again"), "{}", said(&output));
    assert_same(&published(folder), expected, "not as on this machine");
}

/// Tells the tasks at work that their limit is near; which they are.
fn tell_of_the_limit(cluster: &Cluster) -> Vec<String> {
    let tasks = cluster.squeue("%F_%K %T");
    let running =
        tasks.lines().filter_map(|line| line.trim().strip_suffix(" RUNNING").map(str::to_owned));
    let tell = |task: &String| {
        let output = cluster.command("scancel").args(["--signal=USR2", task]).output().unwrap();
        // One that has ended since cannot be told.
        output.status.success()
    };
    running.filter(tell).collect()
}

fn is_back(cluster: &Cluster, task: &str) -> bool {
    let output =
        cluster.command("scontrol").args(["--oneliner", "show", "job", task]).output().unwrap();
    String::from_utf8_lossy(&output.stdout).contains("Restarts=1")
}

fn leaving_and_coming_back(
    cluster: &Cluster,
    folder: &Path,
    expected: &BTreeMap<PathBuf, Vec<u8>>,
) {
    let arguments = [
        "run",
        SMOKE,
        "--seeds",
        SEEDS,
        "--executor",
        "slurm",
        "--jobs",
        "12",
        "--partition",
        "slow",
    ];
    // A worker of the campaign before may still be on its way out.
    until("an empty queue", || cluster.squeue("%j").is_empty());
    let output =
        cluster.spinebench(folder, &[&arguments[..], &["--detach"]].concat()).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    assert!(
        said(&output).contains("submitted 12 workers in 6 array tasks")
            && said(&output).contains("the jobs continue"),
        "{}",
        said(&output)
    );
    assert!(published(folder).is_empty(), "nothing is published before everything is there");
    let partitions = cluster.squeue("%P");
    assert!(
        !partitions.is_empty() && partitions.lines().all(|line| line.trim() == "slow"),
        "{partitions}"
    );
    let standing = cluster.spinebench(folder, &["status"]).output().unwrap();
    let standing = String::from_utf8(standing.stdout).unwrap();
    assert!(standing.contains("  smoke: ") && standing.contains(" stages; "), "{standing}");

    // Watched by one, then by another after the first was interrupted.
    let watching = cluster.spinebench(folder, &arguments).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_secs(1));
    let second = cluster.spinebench(folder, &arguments).output().unwrap();
    let pid = watching.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let first = end(watching);
    let words = said(&second);
    assert!(
        second.status.code() == Some(1) && words.contains("is watched by another process"),
        "{words}"
    );
    assert!(first.status.success() && said(&first).contains("watching it"), "{}", said(&first));

    let output =
        end(cluster.spinebench(folder, &arguments).stderr(Stdio::piped()).spawn().unwrap());
    assert!(output.status.success(), "{}", said(&output));
    assert_same(&published(folder), expected, "not as on this machine");
}

fn calling_off(cluster: &Cluster, folder: &Path) {
    let arguments = [
        "run",
        SMOKE,
        "--seeds",
        SEEDS,
        "--executor",
        "slurm",
        "--jobs",
        "6",
        "--set",
        "slurm.task_s=1",
    ];
    let child = cluster.spinebench(folder, &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let standing = || {
        let output = cluster.spinebench(folder, &["status"]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    until("the campaign", || !cluster.squeue("%j").is_empty());
    let unknown = cluster.spinebench(folder, &["cancel", "nobody"]).output().unwrap();
    assert_eq!(unknown.status.code(), Some(2), "{}", said(&unknown));
    let id = standing().split(' ').next().unwrap().to_owned();
    let cancelled = cluster.spinebench(folder, &["cancel", &id]).output().unwrap();
    assert!(cancelled.status.success(), "{}", said(&cancelled));
    let output = end(child);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("slurm.task_s has no effect"), "{}", said(&output));
    assert!(said(&output).contains(&format!("campaign {id} was cancelled")), "{}", said(&output));
    until("an empty queue", || cluster.squeue("%j").is_empty());
    assert!(standing().contains(", cancelled; no jobs"), "{}", standing());
}

/// A robot that is a recording of something else: its stages fail, on the cluster as here, and are
/// tried once.
fn failures_are_rows(cluster: &Cluster, folder: &Path, here: &Path) {
    let recording = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m,tip_x_m,tip_y_m,tip_z_m\n\
                     0,0,0,0,0,0,0,0,0.2\n0,0.2,0.1,0,0,0,0,0,0.2\n";
    for room in [folder, here] {
        std::fs::write(room.join("other.csv"), recording).unwrap();
    }
    let robot = "plant={replay: {recording: other.csv}}";
    let reach = "runs.reach=[{policies: [a, pi_real], modes: [open, closed], gp_points: [20], \
                 real_points: [200]}]";
    let sets = [
        robot,
        reach,
        "modes.closed_load.effects=[]",
        "runs.track=null",
        "claims=[]",
        "figures=[]",
    ];
    let arguments = ["run", SMOKE, "--seeds", "1"]
        .into_iter()
        .chain(sets.into_iter().flat_map(|set| ["--set", set]));
    let arguments: Vec<&str> = arguments.collect();
    let local = cluster.spinebench(here, &arguments).output().unwrap();
    let child = cluster.spinebench(folder, &[&arguments[..], &["--executor", "slurm"]].concat());
    let output = end({ child }.stderr(Stdio::piped()).spawn().unwrap());
    assert_eq!(
        (local.status.code(), output.status.code()),
        (Some(1), Some(1)),
        "{}\n{}",
        said(&local),
        said(&output)
    );
    assert!(
        published(folder) == published(here) && !published(here).is_empty(),
        "{}",
        said(&output)
    );
    let trials = std::fs::read_to_string(folder.join("results/smoke/trials.csv")).unwrap();
    assert!(trials.lines().skip(1).any(|line| !line.ends_with(",ok")), "{trials}");
}

fn what_the_cluster_refuses_is_told(cluster: &Cluster, folder: &Path) {
    let arguments = ["run", SMOKE, "--seeds", "1", "--executor", "slurm", "--partition", "nowhere"];
    let output = cluster.spinebench(folder, &arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        said(&output).contains("sbatch: ") && said(&output).contains("artition"),
        "{}",
        said(&output)
    );
    let output = cluster
        .spinebench(folder, &["run", SMOKE, "--executor", "slurm", "--cpus", "0"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).starts_with("error: --cpus: found 0"), "{}", said(&output));
    assert!(!folder.join("results").exists());
}
