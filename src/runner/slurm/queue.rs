//! The cluster's commands: submitting, asking what is in the queue, cancelling.

use super::folder::Folder;
use crate::specs::SlurmOptions;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Reasons to wait that nobody needs to hear of.
const USUAL: [&str; 7] = ["", "None", "Resources", "Priority", "Dependency", "BeginTime", "JobArrayTaskLimit"];
/// Seconds before a task's limit at which it is told to end what it has begun.
const NOTICE_S: u32 = 90;

/// A job array that is to be submitted.
pub(super) struct Array<'a> {
    /// Name that all jobs of the campaign have.
    pub(super) name: &'a str,
    /// Number of its attempt, from 1.
    pub(super) attempt: usize,
    /// Number of its wave, from 0.
    pub(super) wave: usize,
    /// Number of the wave's task that is the array's first.
    pub(super) first: usize,
    /// Tasks.
    pub(super) tasks: usize,
    /// Tasks that may run at a time; 0: any number.
    pub(super) at_a_time: usize,
    /// Jobs that must have ended before.
    pub(super) after: &'a [String],
}

/// Submits an array; its job's number.
///
/// # Errors
/// What `sbatch` says, or that there is none.
pub(super) fn submit(folder: &Folder, array: &Array, options: &SlurmOptions) -> Result<String, String> {
    let program = std::env::current_exe().map_err(|error| format!("this program's own file: {error}"))?;
    if !program.is_file() {
        let found = program.display();
        return Err(format!(
            "{found}: found it replaced since it began, expected the same build; run the command again"
        ));
    }
    let mut command = Command::new("sbatch");
    command.args(arguments(folder, array, options)).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| absent("sbatch", &error))?;
    if let Some(mut input) = child.stdin.take() {
        // A refusal says more than the pipe that it closes.
        let _ = input.write_all(script(&program, folder, array).as_bytes());
    }
    let output = child.wait_with_output().map_err(|error| absent("sbatch", &error))?;
    let said = succeeded("sbatch", &output)?;
    let job = said.trim().split(';').next().unwrap_or_default();
    if job.is_empty() || !job.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(format!("sbatch: found `{}`, expected the number of a job", said.trim()));
    }
    Ok(job.to_owned())
}

fn arguments(folder: &Folder, array: &Array, options: &SlurmOptions) -> Vec<String> {
    let mut range = format!("0-{}", array.tasks.saturating_sub(1));
    if array.at_a_time > 0 {
        let _ = write!(range, "%{}", array.at_a_time);
    }
    let mut arguments = vec![
        "--parsable".to_owned(),
        "--requeue".to_owned(),
        "--open-mode=append".to_owned(),
        format!("--job-name={}", array.name),
        format!("--array={range}"),
        format!("--cpus-per-task={}", options.cpus),
        format!("--signal=B:USR2@{NOTICE_S}"),
        format!("--output={}", folder.logs().join("%A_%a.log").display()),
    ];
    if !array.after.is_empty() {
        arguments.push(format!("--dependency=afterany:{}", array.after.join(":")));
    }
    let mut optional =
        |name: &str, value: Option<String>| arguments.extend(value.map(|value| format!("--{name}={value}")));
    optional("partition", options.partition.clone());
    optional("account", options.account.clone());
    optional("time", options.time_min.map(|minutes| minutes.to_string()));
    optional("mem", options.memory_mb.map(|megabytes| format!("{megabytes}M")));
    arguments.extend(options.arguments.iter().cloned());
    arguments
}

/// The program takes the shell's place, so that the notice before the limit reaches it; one that comes before it listens
/// does not end it.
fn script(program: &Path, folder: &Folder, array: &Array) -> String {
    let (program, folder) = (quoted(program), quoted(folder.path()));
    let (attempt, wave, first) = (array.attempt, array.wave, array.first);
    format!(
        "#!/bin/bash\ntrap '' USR2\nexec {program} work {folder} --attempt {attempt} --wave {wave} --first {first}\n"
    )
}

/// A path as one word of the shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', r"'\''"))
}

/// Tasks in the queue by state and, in brackets, reason: those of all jobs with a name.
///
/// # Errors
/// What `squeue` says: the cluster does not answer.
pub(super) fn queued(name: &str) -> Result<BTreeMap<String, usize>, String> {
    let arguments = ["--noheader", "--array", "--format=%T %r", "--name", name];
    let output = Command::new("squeue").args(arguments).output().map_err(|error| absent("squeue", &error))?;
    Ok(counted(&succeeded("squeue", &output)?))
}

fn counted(said: &str) -> BTreeMap<String, usize> {
    let mut states = BTreeMap::new();
    for line in said.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (state, reason) = line.split_once(' ').unwrap_or((line, ""));
        let state = state.to_lowercase();
        let telling = state == "pending" && !USUAL.contains(&reason);
        *states.entry(if telling { format!("{state} ({reason})") } else { state }).or_default() += 1;
    }
    states
}

/// Tasks by state, in words.
pub(super) fn words(states: &BTreeMap<String, usize>) -> String {
    states.iter().map(|(state, count)| format!("{count} {state}")).collect::<Vec<_>>().join(", ")
}

/// Largest number of tasks that one array may have.
pub(super) fn largest_array() -> usize {
    let output = Command::new("scontrol").args(["show", "config"]).output();
    let said = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    let size = said.lines().find_map(|line| line.strip_prefix("MaxArraySize")?.split('=').nth(1)?.trim().parse().ok());
    // The documented default, where the cluster does not tell.
    size.unwrap_or(1001_usize).saturating_sub(1).max(1)
}

/// Cancels all jobs with a name.
///
/// # Errors
/// What `scancel` says.
pub(super) fn cancel(name: &str) -> Result<(), String> {
    let output = Command::new("scancel").args(["--name", name]).output().map_err(|error| absent("scancel", &error))?;
    succeeded("scancel", &output).map(drop)
}

/// Puts the task that this process is back into the queue, which ends it. It is named as a task: the number of its job may
/// be that of the whole array.
///
/// # Errors
/// What `scontrol` says, or that this is no task.
pub(super) fn requeue_self() -> Result<(), String> {
    let variable = |name: &str| std::env::var(name).map_err(|_| format!("no {name}: this is no task of Slurm's"));
    let task = format!("{}_{}", variable("SLURM_ARRAY_JOB_ID")?, variable("SLURM_ARRAY_TASK_ID")?);
    let output =
        Command::new("scontrol").args(["requeue", &task]).output().map_err(|error| absent("scontrol", &error))?;
    succeeded("scontrol", &output).map(drop)
}

fn absent(command: &str, error: &std::io::Error) -> String {
    format!("{command}: found {error}, expected the commands of Slurm on the path")
}

fn succeeded(command: &str, output: &Output) -> Result<String, String> {
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(format!("{command}: {}", said.trim().lines().next().unwrap_or("failed and said nothing")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_dependencies_become_arguments() {
        let folder = Folder::at(Path::new("/shared/store/slurm/abc"));
        let after = ["7".to_owned(), "8".to_owned()];
        let array = Array { name: "n", attempt: 1, wave: 2, first: 1000, tasks: 5, at_a_time: 3, after: &after };
        let options = SlurmOptions {
            partition: Some("long".into()),
            time_min: Some(30),
            memory_mb: Some(500),
            ..SlurmOptions::default()
        };
        let said = arguments(&folder, &array, &options).join(" ");
        for part in ["--array=0-4%3", "--dependency=afterany:7:8", "--partition=long", "--time=30", "--mem=500M"] {
            assert!(said.contains(part), "{said}");
        }
        let script = script(Path::new("/opt/it's/spinebench"), &folder, &array);
        let work = r"exec '/opt/it'\''s/spinebench' work '/shared/store/slurm/abc' --attempt 1 --wave 2 --first 1000";
        assert_eq!(script.lines().skip(1).collect::<Vec<_>>(), ["trap '' USR2", work]);
    }

    #[test]
    fn the_queue_is_counted_by_state_and_telling_reasons() {
        let said = "RUNNING None\nPENDING Resources\nPENDING JobHeldAdmin\nPENDING Dependency\nCOMPLETING None\n";
        let expected = [("completing", 1), ("pending", 2), ("pending (JobHeldAdmin)", 1), ("running", 1)];
        let expected: BTreeMap<String, usize> = expected.map(|(state, count)| (state.to_owned(), count)).into();
        assert_eq!(counted(said), expected);
        assert!(counted("").is_empty());
    }
}
