//! The commands of Slurm: submit workers, list jobs, cancel.

use super::campaign_folder::CampaignFolder;
use crate::specs::SlurmOptions;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Usual reasons to wait.
const USUAL_REASONS: [&str; 7] =
    ["", "None", "Resources", "Priority", "Dependency", "BeginTime", "JobArrayTaskLimit"];
/// Seconds before the limit at which workers are told to end.
const NOTICE_S: u32 = 90;

/// Most array tasks: a controller starts some fifty a second, the step of a task all its workers at
/// once.
const MAX_TASKS: usize = 100;
/// Exit status of a worker that was told to end while stages were left: `EX_TEMPFAIL` of sysexits.
pub const STAGES_LEFT_STATUS: u8 = 75;

/// Workers that an array task starts, unless the options say.
pub fn workers_per_task(workers: usize) -> usize {
    workers.div_ceil(MAX_TASKS)
}

/// An array of tasks that each start the same number of workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WorkerArray {
    tasks: usize,
    /// Workers that a task starts.
    workers_per_task: usize,
}

impl WorkerArray {
    /// An array of at least `workers` workers.
    pub(super) fn of(workers: usize, options: &SlurmOptions) -> WorkerArray {
        WorkerArray::within(
            workers,
            options.workers_per_task.map(|count| count as usize),
            largest_array(),
        )
    }

    fn within(workers: usize, per_task: Option<usize>, max_tasks: usize) -> WorkerArray {
        let per_task = per_task
            .unwrap_or_else(|| workers_per_task(workers))
            .max(workers.div_ceil(max_tasks))
            .max(1);
        WorkerArray { tasks: workers.div_ceil(per_task), workers_per_task: per_task }
    }

    /// Its size, in words.
    pub(super) fn describe(self) -> String {
        format!("{} workers in {} array tasks", self.tasks * self.workers_per_task, self.tasks)
    }
}

/// Submits an array of workers.
///
/// # Errors
/// What `sbatch` says, or that there is none.
pub(super) fn submit(
    folder: &CampaignFolder,
    array: WorkerArray,
    options: &SlurmOptions,
) -> Result<(), String> {
    let program =
        std::env::current_exe().map_err(|error| format!("the file of this program: {error}"))?;
    if !program.is_file() {
        let file = program.display();
        return Err(format!(
            "{file}: found a program file that was replaced after the start, expected the same \
             build; run the command again"
        ));
    }
    let mut command = Command::new("sbatch");
    command
        .args(arguments(folder, array, options))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| absent("sbatch", &error))?;
    if let Some(mut input) = child.stdin.take() {
        // A refusal says more than the pipe that it closes.
        let _ = input.write_all(script(&program, folder, array, options).as_bytes());
    }
    let output = child.wait_with_output().map_err(|error| absent("sbatch", &error))?;
    succeeded("sbatch", &output).map(drop)
}

fn arguments(folder: &CampaignFolder, array: WorkerArray, options: &SlurmOptions) -> Vec<String> {
    let mut arguments = vec![
        "--parsable".to_owned(),
        "--requeue".to_owned(),
        "--open-mode=append".to_owned(),
        format!("--job-name={}", folder.job_name()),
        format!("--array=0-{}", array.tasks - 1),
        format!("--ntasks={}", array.workers_per_task),
        format!("--cpus-per-task={}", options.cpus),
        format!("--signal=USR2@{NOTICE_S}"),
        format!("--output={}", folder.logs().join("%A_%a.log").display()),
    ];
    let mut optional = |name: &str, value: Option<String>| {
        arguments.extend(value.map(|value| format!("--{name}={value}")))
    };
    optional("partition", options.partition.clone());
    optional("account", options.account.clone());
    optional("time", options.time_min.map(|minutes| minutes.to_string()));
    optional(
        "mem-per-cpu",
        options.memory_mb.map(|megabytes| format!("{}M", megabytes.div_ceil(options.cpus))),
    );
    arguments.extend(options.arguments.iter().cloned());
    arguments
}

/// The script of a task: one step that starts its workers. The notice before the limit goes to the
/// workers; one that comes before they listen does not end them. A task whose workers ended early
/// goes back into the queue.
fn script(
    program: &Path,
    folder: &CampaignFolder,
    array: WorkerArray,
    options: &SlurmOptions,
) -> String {
    let (program, folder) = (quoted(program), quoted(folder.path()));
    let (workers, cpus) = (array.tasks * array.workers_per_task, options.cpus);
    format!(
        "#!/bin/bash\nsrun --kill-on-bad-exit=0 --wait=0 --cpus-per-task={cpus} bash -c 'trap \"\" \
         USR2; exec \"$@\"' worker \\\n  {program} work {folder} --workers \
         {workers}\nstatus=$?\nif [ $status = {STAGES_LEFT_STATUS} ]; then\n  scontrol requeue \
         \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\" && sleep 60\nfi\nexit $status\n"
    )
}

/// A path as one word of the shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', r"'\''"))
}

/// Jobs with this name by state, with the reason for waiting in brackets where a person should know
/// it.
///
/// # Errors
/// What `squeue` says.
pub(super) fn jobs(name: &str) -> Result<BTreeMap<String, usize>, String> {
    let arguments = ["--noheader", "--array", "--format=%T %r", "--name", name];
    let output = Command::new("squeue")
        .args(arguments)
        .output()
        .map_err(|error| absent("squeue", &error))?;
    Ok(counted(&succeeded("squeue", &output)?))
}

fn counted(listing: &str) -> BTreeMap<String, usize> {
    let mut states = BTreeMap::new();
    for line in listing.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (state, reason) = line.split_once(' ').unwrap_or((line, ""));
        let state = state.to_lowercase();
        let unusual = state == "pending" && !USUAL_REASONS.contains(&reason);
        *states.entry(if unusual { format!("{state} ({reason})") } else { state }).or_default() +=
            1;
    }
    states
}

/// Jobs by state, in words.
pub(super) fn describe(states: &BTreeMap<String, usize>) -> String {
    states.iter().map(|(state, count)| format!("{count} {state}")).collect::<Vec<_>>().join(", ")
}

/// Largest number of tasks that one array may have.
fn largest_array() -> usize {
    let output = Command::new("scontrol").args(["show", "config"]).output();
    let config = output
        .map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
        .unwrap_or_default();
    let size = config
        .lines()
        .find_map(|line| line.strip_prefix("MaxArraySize")?.split('=').nth(1)?.trim().parse().ok());
    // The documented default, where the cluster does not tell.
    size.unwrap_or(1001_usize).saturating_sub(1).max(1)
}

/// Cancels the jobs with a name, or those of them that wait.
///
/// # Errors
/// What `scancel` says.
pub(super) fn cancel(name: &str, waiting: bool) -> Result<(), String> {
    let mut command = Command::new("scancel");
    command.args(["--name", name]).args(waiting.then_some("--state=PENDING"));
    succeeded("scancel", &command.output().map_err(|error| absent("scancel", &error))?).map(drop)
}

fn absent(command: &str, error: &std::io::Error) -> String {
    format!("{command}: found {error}, expected the commands of Slurm on the path")
}

fn succeeded(command: &str, output: &Output) -> Result<String, String> {
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let message = String::from_utf8_lossy(&output.stderr);
    Err(format!(
        "{command}: {}",
        message.trim().lines().next().unwrap_or("failed without a message")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_array_starts_several_workers_a_task() {
        let within = |workers, each, largest| {
            let array = WorkerArray::within(workers, each, largest);
            (array.tasks, array.workers_per_task)
        };
        assert_eq!([within(1, None, 1000), within(100, None, 1000)], [(1, 1), (100, 1)]);
        assert_eq!([within(1000, None, 1000), within(150, None, 1000)], [(100, 10), (75, 2)]);
        assert_eq!([within(12, None, 10), within(12, Some(1), 1000)], [(6, 2), (12, 1)]);
        assert_eq!(
            within(12, Some(1), 10),
            (6, 2),
            "the cluster's largest array limits the option"
        );
    }

    #[test]
    fn options_become_arguments_and_paths_are_quoted() {
        let folder = CampaignFolder::at(Path::new("/shared/store/slurm/abc"));
        let options = SlurmOptions {
            partition: Some("long".into()),
            time_min: Some(30),
            memory_mb: Some(500),
            cpus: 2,
            ..SlurmOptions::default()
        };
        let array = WorkerArray { tasks: 5, workers_per_task: 3 };
        let said = arguments(&folder, array, &options).join(" ");
        for part in
            ["--array=0-4", "--ntasks=3", "--partition=long", "--time=30", "--mem-per-cpu=250M"]
        {
            assert!(said.contains(part), "{said}");
        }
        let script = script(Path::new("/opt/it's/spinebench"), &folder, array, &options);
        let work = r"  '/opt/it'\''s/spinebench' work '/shared/store/slurm/abc' --workers 15";
        assert_eq!(script.lines().nth(2), Some(work), "{script}");
    }

    #[test]
    fn the_queue_is_counted_by_state_and_telling_reasons() {
        let said = "RUNNING None\nPENDING Resources\nPENDING JobHeldAdmin\nPENDING \
                    BeginTime\nCOMPLETING None\n";
        let expected =
            [("completing", 1), ("pending", 2), ("pending (JobHeldAdmin)", 1), ("running", 1)];
        let expected: BTreeMap<String, usize> =
            expected.map(|(state, count)| (state.to_owned(), count)).into();
        assert_eq!(counted(said), expected);
        assert!(counted("").is_empty());
    }
}
