//! What confines a submission on Linux: Landlock for files, limits of resources, filters of system
//! calls.

use super::ConfineCommand;
use super::calls::{filters, restrict_calls};
use landlock::{
    ABI, Access, AccessFs, AccessNet, LandlockStatus, Ruleset, RulesetAttr, RulesetCreatedAttr,
    RulesetStatus, Scope, path_beneath_rules,
};
use nix::fcntl::{AtFlags, FcntlArg, FdFlag, fcntl};
use rustix::process::{
    Resource, Rlimit, Signal, getppid, getrlimit, set_parent_process_death_signal, setrlimit,
};
use rustix::thread::{CapabilitySet, CapabilitySets, set_capabilities, set_no_new_privs};
use std::ffi::{CString, OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::os::fd::{AsRawFd, RawFd};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Newest version of Landlock that is asked for; an older kernel gives what it has.
const NEWEST: ABI = ABI::V10;
/// Descriptors that the program can have open.
const OPEN_FILES: u64 = 64;
/// Threads that it can have beyond those of the whole computer now.
const THREADS: u64 = 256;
/// The program is executed from a descriptor of at least this number. It can never have one
/// of that number again, so that the filter tells this execution from every later one.
const PROGRAM_DESCRIPTOR: RawFd = 100;
/// What a dynamically linked program reads before its first line.
const RUNTIME: [&str; 7] =
    ["/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache", "/dev/null", "/dev/urandom"];
/// Its environment, beside `PATH`. Threads of numeric libraries would make sums depend on
/// the computer.
const ENVIRONMENT: [&str; 8] = [
    "LANG=C.UTF-8",
    "PYTHONHASHSEED=0",
    "PYTHONDONTWRITEBYTECODE=1",
    "OPENBLAS_NUM_THREADS=1",
    "OMP_NUM_THREADS=1",
    "MKL_NUM_THREADS=1",
    "HOME=/nonexistent",
    "TZ=UTC",
];

pub(super) fn confine(command: &ConfineCommand) -> Result<(), String> {
    let parent = getppid();
    let program = found(&command.program[0])?;
    let arguments: Vec<CString> = std::iter::once(Ok(text(program.as_os_str())?))
        .chain(command.program[1..].iter().map(|argument| text(argument)))
        .collect::<Result<_, _>>()?;
    let environment = environment()?;
    let mut read: Vec<PathBuf> =
        command.read.iter().map(|path| readable(path)).collect::<Result<_, _>>()?;

    keep_no_descriptors()?;
    let descriptor = executed_from(&program)?;
    let failed = |what: &str, error: rustix::io::Errno| format!("found no {what} ({error})");
    set_parent_process_death_signal(Some(Signal::KILL))
        .map_err(|error| failed("signal at the end of the harness", error))?;
    if getppid() != parent {
        return Err("found no harness, expected one that waits for the program".to_owned());
    }
    std::env::set_current_dir(&read[0])
        .map_err(|error| format!("{}: found no folder ({error})", read[0].display()))?;
    set_no_new_privs(true).map_err(|error| failed("no_new_privs", error))?;
    // Of root, and in containers: with no_new_privs, the program does not get them back.
    let none = CapabilitySet::empty();
    set_capabilities(None, CapabilitySets { effective: none, permitted: none, inheritable: none })
        .map_err(|error| failed("process without capabilities", error))?;
    read.push(program.clone());
    restrict_files(&read)?;
    // Made before memory is short: this program may be larger than the limit.
    let filters = filters(descriptor)?;
    limit_resources(command.memory_mib << 20, command.cpu_s)?;
    restrict_calls(&filters)?;

    let empty = CString::default();
    let Err(error) =
        nix::unistd::execveat(descriptor, &empty, &arguments, &environment, AtFlags::AT_EMPTY_PATH);
    Err(format!("{}: found no program that can be executed ({error})", program.display()))
}

pub(super) fn guards() -> Result<String, String> {
    let abi = restrict_files(&[])?;
    restrict_calls(&filters(PROGRAM_DESCRIPTOR)?)?;
    Ok(format!("landlock abi {abi}, seccomp, rlimits"))
}

fn text(words: &OsStr) -> Result<CString, String> {
    CString::new(words.as_bytes())
        .map_err(|_| format!("{}: found a byte 0, expected an argument", words.display()))
}

/// The program as an absolute path, not resolved: Python finds its virtual environment by it.
fn found(program: &OsString) -> Result<PathBuf, String> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = if program.as_bytes().contains(&b'/') {
        vec![PathBuf::new()]
    } else {
        std::env::split_paths(&path).collect()
    };
    let can_be_executed = |file: &PathBuf| {
        file.metadata().is_ok_and(|data| data.is_file() && data.permissions().mode() & 0o111 != 0)
    };
    let file = folders.iter().map(|folder| folder.join(program)).find(can_be_executed);
    let file = file.ok_or_else(|| {
        format!("{}: found no such program, expected one to execute", program.display())
    })?;
    std::path::absolute(&file).map_err(|error| format!("{}: {error}", file.display()))
}

fn environment() -> Result<Vec<CString>, String> {
    let mut path = OsString::from("PATH=");
    path.push(std::env::var_os("PATH").unwrap_or_else(|| "/usr/bin:/bin".into()));
    let fixed = ENVIRONMENT.iter().map(OsStr::new);
    std::iter::once(path.as_os_str()).chain(fixed).map(text).collect()
}

fn readable(path: &Path) -> Result<PathBuf, String> {
    let absolute = std::path::absolute(path).and_then(|path| path.metadata().map(|_| path));
    absolute.map_err(|error| format!("--read: found {} ({error})", path.display()))
}

/// Lets no descriptor but 0, 1 and 2 reach the program.
fn keep_no_descriptors() -> Result<(), String> {
    let unknown = |error| format!("/proc/self/fd: found no list of descriptors ({error})");
    let entries = std::fs::read_dir("/proc/self/fd").map_err(unknown)?;
    let numbers: Vec<RawFd> = entries
        .map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().parse().ok()))
        .filter_map(Result::transpose)
        .collect::<Result<_, _>>()
        .map_err(unknown)?;
    for number in numbers.into_iter().filter(|number| *number > 2) {
        match fcntl(number, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)) {
            // The one of the list itself is closed by now.
            Ok(_) | Err(nix::errno::Errno::EBADF) => {}
            Err(error) => {
                return Err(format!("descriptor {number}: cannot close it ({error})"));
            }
        }
    }
    Ok(())
}

/// A descriptor of the program that closes when it is executed.
fn executed_from(program: &Path) -> Result<RawFd, String> {
    let told = |error: &dyn std::fmt::Display| format!("{}: {error}", program.display());
    let mut file = File::open(program).map_err(|error| told(&error))?;
    let mut start = [0; 2];
    let read = file.read(&mut start).map_err(|error| told(&error))?;
    if read == 2 && &start == b"#!" {
        // Its interpreter would be a second execution.
        return Err(told(&"found a script, expected a program; name its interpreter before it"));
    }
    fcntl(file.as_raw_fd(), FcntlArg::F_DUPFD_CLOEXEC(PROGRAM_DESCRIPTOR))
        .map_err(|error| told(&error))
}

fn limit_resources(memory: u64, cpu_s: u64) -> Result<(), String> {
    // "0.10 0.12 0.09 2/345 6789": of 345 threads, 2 run.
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let threads = load.split(['/', ' ']).nth(4).and_then(|count| count.parse().ok());
    let limits = [
        (Resource::Core, 0, 0),
        (Resource::Fsize, 0, 0),
        (Resource::Msgqueue, 0, 0),
        // A thread counts for the user, so the limit is beside what others of the user run.
        // Linux does not apply it to root.
        (Resource::Nproc, threads.unwrap_or(4096) + THREADS, 0),
        // SIGXCPU tells the end of the time from other ends; SIGKILL follows.
        (Resource::Cpu, cpu_s, 1),
        (Resource::Nofile, OPEN_FILES, 0),
        (Resource::As, memory, 0),
    ];
    for (resource, limit, grace) in limits {
        let ceiling = getrlimit(resource).maximum.unwrap_or(u64::MAX);
        let (current, maximum) = (limit.min(ceiling), (limit + grace).min(ceiling));
        setrlimit(resource, Rlimit { current: Some(current), maximum: Some(maximum) })
            .map_err(|error| format!("{resource:?}: cannot limit it to {limit} ({error})"))?;
    }
    Ok(())
}

/// Lets the thread read and execute what is beneath `read` and [`RUNTIME`], write to
/// `/dev/null`, and nothing else. Returns the version of Landlock that the kernel has.
fn restrict_files(read: &[PathBuf]) -> Result<i32, String> {
    let restricted = || {
        let runtime = RUNTIME.iter().map(Path::new);
        let seen = runtime.chain(read.iter().map(PathBuf::as_path));
        Ruleset::default()
            .handle_access(AccessFs::from_all(NEWEST))?
            .handle_access(AccessNet::from_all(NEWEST))?
            .scope(Scope::from_all(NEWEST))?
            .create()?
            .add_rules(path_beneath_rules(seen, AccessFs::from_read(NEWEST)))?
            .add_rules(path_beneath_rules(["/dev/null"], AccessFs::WriteFile))?
            .restrict_self()
    };
    let status = restricted().map_err(|error| format!("Landlock: {error}"))?;
    match (status.ruleset, status.landlock) {
        (RulesetStatus::NotEnforced, _)
        | (_, LandlockStatus::NotEnabled | LandlockStatus::NotImplemented) => {
            Err("found a kernel that does not enforce Landlock, expected Linux 5.13 or later \
                 with `landlock` in /sys/kernel/security/lsm"
                .to_owned())
        }
        (_, LandlockStatus::Available { effective_abi, kernel_abi }) => {
            Ok(kernel_abi.unwrap_or(effective_abi as i32))
        }
    }
}
