//! Which system calls a confined submission may do: filters of seccomp.

use nix::libc;
use rustix::process::getpid;
use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule, apply_filter,
};
use std::collections::BTreeMap;
use std::os::fd::RawFd;

/// Filters of system calls: those of a program that computes, and the execution of what
/// `descriptor` holds. Of several filters, the strictest answer holds; of two refusals, that
/// of the later filter.
pub(super) fn filters(descriptor: RawFd) -> Result<[BpfProgram; 3], String> {
    let own = u64::from(getpid().as_raw_pid().unsigned_abs());
    let errno = |number: i32| SeccompAction::Errno(number.unsigned_abs());
    let (allow, kill) = (SeccompAction::Allow, SeccompAction::KillProcess);
    let of = |rules: Result<Rules, seccompiler::BackendError>, otherwise, matched| {
        let arch = std::env::consts::ARCH.try_into()?;
        SeccompFilter::new(rules?, otherwise, matched, arch).and_then(BpfProgram::try_from)
    };
    // A call that is not known here fails as on an older kernel, for which libraries are
    // prepared: `clone3` falls back to `clone`.
    let filters = || {
        Ok([
            of(attacks(), allow.clone(), kill)?,
            of(computing(own, descriptor), errno(libc::ENOSYS), allow.clone())?,
            of(refused(own), allow, errno(libc::EPERM))?,
        ])
    };
    filters().map_err(|error: seccompiler::BackendError| format!("seccomp: {error}"))
}

/// Applies filters to the thread and those that it starts.
pub(super) fn restrict_calls(filters: &[BpfProgram]) -> Result<(), String> {
    filters.iter().try_for_each(|filter| {
        apply_filter(filter).map_err(|error| {
            format!("found a kernel that refuses a filter of system calls ({error})")
        })
    })
}

/// Rules by the number of a system call; a call without a rule matches whatever its arguments.
type Rules = BTreeMap<i64, Vec<SeccompRule>>;

fn argument(
    index: u8,
    operator: SeccompCmpOp,
    value: u64,
) -> Result<SeccompCondition, seccompiler::BackendError> {
    SeccompCondition::new(index, SeccompCmpArgLen::Dword, operator, value)
}

/// One rule for each value that an argument may equal.
fn one_of(index: u8, values: &[u64]) -> Result<Vec<SeccompRule>, seccompiler::BackendError> {
    let rule = |value: &u64| SeccompRule::new(vec![argument(index, SeccompCmpOp::Eq, *value)?]);
    values.iter().map(rule).collect()
}

/// What only an attack does: another process, a socket, the memory of another process.
fn attacks() -> Result<Rules, seccompiler::BackendError> {
    let calls = [
        libc::SYS_socket,
        libc::SYS_ptrace,
        libc::SYS_process_vm_readv,
        libc::SYS_process_vm_writev,
    ];
    let mut rules: Rules = calls.into_iter().map(|call| (call, Vec::new())).collect();
    #[cfg(target_arch = "x86_64")]
    rules.extend([(libc::SYS_fork, Vec::new()), (libc::SYS_vfork, Vec::new())]);
    let thread = libc::CLONE_THREAD.unsigned_abs().into();
    let process = SeccompRule::new(vec![argument(0, SeccompCmpOp::MaskedEq(thread), 0)?])?;
    rules.insert(libc::SYS_clone, vec![process]);
    Ok(rules)
}

/// The calls of a program that computes in threads, and reads files and pipes.
fn computing(own: u64, descriptor: RawFd) -> Result<Rules, seccompiler::BackendError> {
    let plain = CALLS.iter().chain(CALLS_OF_ARCHITECTURE);
    let mut rules: Rules = plain.map(|call| (*call, Vec::new())).collect();
    let equal = |index, value| argument(index, SeccompCmpOp::Eq, value);
    // A thread in the same namespaces.
    let namespaces = libc::CLONE_NEWNS
        | libc::CLONE_NEWCGROUP
        | libc::CLONE_NEWUTS
        | libc::CLONE_NEWIPC
        | libc::CLONE_NEWUSER
        | libc::CLONE_NEWPID
        | libc::CLONE_NEWNET;
    let mask = u64::from((libc::CLONE_THREAD | namespaces).unsigned_abs());
    let thread = u64::from(libc::CLONE_THREAD.unsigned_abs());
    let clone = SeccompRule::new(vec![argument(0, SeccompCmpOp::MaskedEq(mask), thread)?])?;
    rules.insert(libc::SYS_clone, vec![clone]);
    let first = u64::from(descriptor.unsigned_abs());
    let flags = u64::from(libc::AT_EMPTY_PATH.unsigned_abs());
    let execute = SeccompRule::new(vec![equal(0, first)?, equal(4, flags)?])?;
    rules.insert(libc::SYS_execveat, vec![execute]);
    // Limits can be read; the third argument would be new ones.
    let no_limits = |process| {
        let none = SeccompCondition::new(2, SeccompCmpArgLen::Qword, SeccompCmpOp::Eq, 0)?;
        SeccompRule::new(vec![equal(0, process)?, none])
    };
    rules.insert(libc::SYS_prlimit64, vec![no_limits(0)?, no_limits(own)?]);
    // Whether a descriptor is a terminal, and what waits in a pipe. The type of the constants
    // of libc depends on the C library.
    let asked = [
        0x5401, // TCGETS
        0x5413, // TIOCGWINSZ
        0x541B, // FIONREAD
        0x5421, // FIONBIO
        0x5450, // FIONCLEX
        0x5451, // FIOCLEX
    ];
    rules.insert(libc::SYS_ioctl, one_of(1, &asked)?);
    Ok(rules)
}

/// What a program may try without harm, and is told that it may not.
fn refused(own: u64) -> Result<Rules, seccompiler::BackendError> {
    let plain = REFUSED.iter().chain(REFUSED_OF_ARCHITECTURE);
    let mut rules: Rules = plain.map(|call| (*call, Vec::new())).collect();
    let signals = [
        libc::SYS_kill,
        libc::SYS_tkill,
        libc::SYS_tgkill,
        libc::SYS_rt_sigqueueinfo,
        libc::SYS_rt_tgsigqueueinfo,
    ];
    for call in signals {
        let others = SeccompRule::new(vec![argument(0, SeccompCmpOp::Ne, own)?])?;
        rules.insert(call, vec![others]);
    }
    // Signals to other processes through the owner of a pipe, and locks, by which processes of one
    // policy could tell each other what they have seen.
    let kinds = [
        libc::F_SETOWN,
        15, // F_SETOWN_EX
        10, // F_SETSIG
        libc::F_SETLEASE,
        libc::F_NOTIFY,
        libc::F_GETLK,
        libc::F_SETLK,
        libc::F_SETLKW,
        libc::F_OFD_GETLK,
        libc::F_OFD_SETLK,
        libc::F_OFD_SETLKW,
    ];
    rules.insert(libc::SYS_fcntl, one_of(1, &kinds.map(|kind| kind.unsigned_abs().into()))?);
    // Without the signal at the end of the harness it would outlive it.
    let options = [libc::PR_SET_PDEATHSIG, libc::PR_SET_MM, libc::PR_SET_PTRACER];
    let options = options.map(|option| option.unsigned_abs().into());
    rules.insert(libc::SYS_prctl, one_of(0, &options)?);
    Ok(rules)
}

/// Calls that are allowed, apart from what [`refused`] takes from some of them.
#[rustfmt::skip]
const CALLS: &[i64] = &[
    libc::SYS_read, libc::SYS_write, libc::SYS_readv, libc::SYS_writev, libc::SYS_pread64,
    libc::SYS_pwrite64, libc::SYS_preadv, libc::SYS_pwritev, libc::SYS_preadv2,
    libc::SYS_pwritev2, libc::SYS_close, libc::SYS_close_range, libc::SYS_lseek,
    libc::SYS_fstat, libc::SYS_newfstatat, libc::SYS_statx, libc::SYS_faccessat,
    libc::SYS_faccessat2, libc::SYS_readlinkat, libc::SYS_openat, libc::SYS_openat2,
    libc::SYS_getdents64, libc::SYS_getcwd, libc::SYS_chdir, libc::SYS_fchdir, libc::SYS_statfs,
    libc::SYS_fstatfs, libc::SYS_dup, libc::SYS_dup3, libc::SYS_pipe2, libc::SYS_fcntl,
    libc::SYS_fadvise64, libc::SYS_ppoll, libc::SYS_pselect6, libc::SYS_epoll_create1,
    libc::SYS_epoll_ctl, libc::SYS_epoll_pwait, libc::SYS_epoll_pwait2, libc::SYS_eventfd2,
    libc::SYS_mmap, libc::SYS_munmap, libc::SYS_mprotect, libc::SYS_mremap, libc::SYS_madvise,
    libc::SYS_brk, libc::SYS_msync, libc::SYS_mlock, libc::SYS_mlock2, libc::SYS_munlock,
    libc::SYS_mlockall, libc::SYS_munlockall, libc::SYS_mincore, libc::SYS_membarrier,
    libc::SYS_get_mempolicy, libc::SYS_pkey_alloc, libc::SYS_pkey_free, libc::SYS_pkey_mprotect,
    libc::SYS_futex, libc::SYS_futex_waitv, libc::SYS_set_robust_list,
    libc::SYS_get_robust_list, libc::SYS_rseq, libc::SYS_set_tid_address,
    libc::SYS_restart_syscall, libc::SYS_exit, libc::SYS_exit_group, libc::SYS_wait4,
    libc::SYS_waitid, libc::SYS_getpid, libc::SYS_getppid, libc::SYS_gettid, libc::SYS_getuid,
    libc::SYS_geteuid, libc::SYS_getgid, libc::SYS_getegid, libc::SYS_getgroups,
    libc::SYS_getresuid, libc::SYS_getresgid, libc::SYS_getpgid, libc::SYS_getsid,
    libc::SYS_capget, libc::SYS_uname, libc::SYS_sysinfo, libc::SYS_times, libc::SYS_getrusage,
    libc::SYS_getrlimit, libc::SYS_umask, libc::SYS_getcpu, libc::SYS_rt_sigaction,
    libc::SYS_rt_sigprocmask, libc::SYS_rt_sigreturn, libc::SYS_rt_sigpending,
    libc::SYS_rt_sigtimedwait, libc::SYS_rt_sigsuspend, libc::SYS_sigaltstack, libc::SYS_kill,
    libc::SYS_tkill, libc::SYS_tgkill, libc::SYS_rt_sigqueueinfo, libc::SYS_rt_tgsigqueueinfo,
    libc::SYS_sched_yield, libc::SYS_sched_getaffinity, libc::SYS_sched_getparam,
    libc::SYS_sched_getscheduler, libc::SYS_sched_get_priority_max,
    libc::SYS_sched_get_priority_min, libc::SYS_sched_rr_get_interval, libc::SYS_getpriority,
    libc::SYS_nanosleep, libc::SYS_clock_nanosleep, libc::SYS_clock_gettime,
    libc::SYS_clock_getres, libc::SYS_gettimeofday, libc::SYS_getitimer, libc::SYS_setitimer,
    libc::SYS_timer_create, libc::SYS_timer_settime, libc::SYS_timer_gettime,
    libc::SYS_timer_getoverrun, libc::SYS_timer_delete, libc::SYS_timerfd_create,
    libc::SYS_timerfd_settime, libc::SYS_timerfd_gettime, libc::SYS_getrandom, libc::SYS_prctl,
    libc::SYS_seccomp,
];

/// The same under names that newer architectures do not have.
#[cfg(target_arch = "x86_64")]
#[rustfmt::skip]
const CALLS_OF_ARCHITECTURE: &[i64] = &[
    libc::SYS_open, libc::SYS_stat, libc::SYS_lstat, libc::SYS_access, libc::SYS_readlink,
    libc::SYS_getdents, libc::SYS_poll, libc::SYS_select, libc::SYS_epoll_create,
    libc::SYS_epoll_wait, libc::SYS_dup2, libc::SYS_pipe, libc::SYS_eventfd, libc::SYS_alarm,
    libc::SYS_pause, libc::SYS_getpgrp, libc::SYS_time, libc::SYS_arch_prctl,
];

#[cfg(target_arch = "aarch64")]
const CALLS_OF_ARCHITECTURE: &[i64] = &[];

/// Calls that are told "not permitted"; those with files matter for metadata, which Landlock
/// does not cover. `seccomp` is here because this filter is the last.
#[rustfmt::skip]
const REFUSED: &[i64] = &[
    libc::SYS_execve, libc::SYS_socketpair, libc::SYS_memfd_create, libc::SYS_memfd_secret,
    libc::SYS_shmget, libc::SYS_shmat, libc::SYS_shmctl, libc::SYS_shmdt, libc::SYS_semget,
    libc::SYS_semop, libc::SYS_semtimedop, libc::SYS_semctl, libc::SYS_msgget, libc::SYS_msgsnd,
    libc::SYS_msgrcv, libc::SYS_msgctl, libc::SYS_mq_open, libc::SYS_mq_unlink,
    libc::SYS_io_uring_setup, libc::SYS_io_uring_enter, libc::SYS_io_uring_register,
    libc::SYS_io_setup, libc::SYS_bpf, libc::SYS_perf_event_open, libc::SYS_userfaultfd,
    libc::SYS_seccomp, libc::SYS_pidfd_open, libc::SYS_pidfd_send_signal, libc::SYS_pidfd_getfd,
    libc::SYS_kcmp, libc::SYS_process_madvise, libc::SYS_process_mrelease,
    libc::SYS_migrate_pages, libc::SYS_move_pages, libc::SYS_mount, libc::SYS_umount2,
    libc::SYS_pivot_root, libc::SYS_chroot, libc::SYS_move_mount, libc::SYS_open_tree,
    libc::SYS_fsopen, libc::SYS_fsconfig, libc::SYS_fsmount, libc::SYS_fspick,
    libc::SYS_mount_setattr, libc::SYS_unshare, libc::SYS_setns, libc::SYS_keyctl,
    libc::SYS_add_key, libc::SYS_request_key, libc::SYS_open_by_handle_at,
    libc::SYS_name_to_handle_at, libc::SYS_inotify_init1, libc::SYS_fanotify_init,
    libc::SYS_flock, libc::SYS_personality, libc::SYS_reboot, libc::SYS_init_module,
    libc::SYS_finit_module, libc::SYS_delete_module, libc::SYS_kexec_load, libc::SYS_quotactl,
    libc::SYS_swapon, libc::SYS_swapoff, libc::SYS_acct, libc::SYS_syslog,
    libc::SYS_settimeofday, libc::SYS_clock_settime, libc::SYS_adjtimex,
    libc::SYS_clock_adjtime, libc::SYS_sethostname, libc::SYS_setdomainname, libc::SYS_vhangup,
    libc::SYS_setrlimit, libc::SYS_setpriority, libc::SYS_ioprio_set,
    libc::SYS_sched_setaffinity, libc::SYS_sched_setparam, libc::SYS_sched_setscheduler,
    libc::SYS_sched_setattr, libc::SYS_setpgid, libc::SYS_setsid, libc::SYS_setuid,
    libc::SYS_setgid, libc::SYS_setreuid, libc::SYS_setregid, libc::SYS_setresuid,
    libc::SYS_setresgid, libc::SYS_setgroups, libc::SYS_setfsuid, libc::SYS_setfsgid,
    libc::SYS_capset, libc::SYS_fchmod, libc::SYS_fchmodat, libc::SYS_fchown,
    libc::SYS_fchownat, libc::SYS_utimensat, libc::SYS_truncate, libc::SYS_ftruncate,
    libc::SYS_fallocate, libc::SYS_mkdirat, libc::SYS_mknodat, libc::SYS_unlinkat,
    libc::SYS_renameat, libc::SYS_renameat2, libc::SYS_linkat, libc::SYS_symlinkat,
    libc::SYS_setxattr, libc::SYS_lsetxattr, libc::SYS_fsetxattr, libc::SYS_removexattr,
    libc::SYS_lremovexattr, libc::SYS_fremovexattr,
];

/// The same under names that newer architectures do not have.
#[cfg(target_arch = "x86_64")]
#[rustfmt::skip]
const REFUSED_OF_ARCHITECTURE: &[i64] = &[
    libc::SYS_chmod, libc::SYS_chown, libc::SYS_lchown, libc::SYS_utime, libc::SYS_utimes,
    libc::SYS_futimesat, libc::SYS_mkdir, libc::SYS_rmdir, libc::SYS_mknod, libc::SYS_creat,
    libc::SYS_unlink, libc::SYS_rename, libc::SYS_link, libc::SYS_symlink,
    libc::SYS_inotify_init, libc::SYS_iopl, libc::SYS_ioperm, libc::SYS_modify_ldt,
    libc::SYS_uselib,
];

#[cfg(target_arch = "aarch64")]
const REFUSED_OF_ARCHITECTURE: &[i64] = &[];
