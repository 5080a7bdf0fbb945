//! Which system calls a process can make: seccomp.
//!
//! Three filters, of whose verdicts the kernel takes the strictest: a list of what is allowed, everything else an error;
//! a list of what ends the process; and `clone3`, which is said not to exist.

use super::SandboxError;
use seccompiler::SeccompCmpOp::{Eq, MaskedEq};
use seccompiler::{
    BackendError, BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule, apply_filter,
};
use std::collections::BTreeMap;
use std::fmt::Display;

/// Calls and the arguments with which they match; with any, where the list is empty.
type Calls = BTreeMap<i64, Vec<SeccompRule>>;

/// Restricts this thread and all that it starts.
pub(super) fn restrict() -> Result<(), SandboxError> {
    let refused = |code: i32| SeccompAction::Errno(code.unsigned_abs());
    let system = |error: BackendError| SandboxError::System(error.to_string());
    // The list of what is allowed comes last: installing a filter is not on it.
    install(deadly().map_err(system)?, SeccompAction::Allow, SeccompAction::KillProcess)?;
    // Its flags are in memory, where a filter cannot see them. C libraries use clone if it is not there.
    let clone3 = Calls::from([(libc::SYS_clone3, Vec::new())]);
    install(clone3, SeccompAction::Allow, refused(libc::ENOSYS))?;
    install(allowed().map_err(system)?, refused(libc::EPERM), SeccompAction::Allow)
}

/// Restricts this thread and what it becomes: any program may run in it, without network and without power over other processes
/// or over files' names, owners and rights. `alone`: no other process can be started.
///
/// Everything refused is an error for the program (`EPERM`), since one that was written without this in mind tries a lot and goes on.
pub(super) fn restrict_program(alone: bool) -> Result<(), SandboxError> {
    let refused = |code: i32| SeccompAction::Errno(code.unsigned_abs());
    let system = |error: BackendError| SandboxError::System(error.to_string());
    // Their arguments are in memory, where a filter cannot see them. C libraries use the older calls if these are not there.
    let unseen = Calls::from([(libc::SYS_clone3, Vec::new()), (libc::SYS_openat2, Vec::new())]);
    install(unseen, SeccompAction::Allow, refused(libc::ENOSYS))?;
    install(denied(alone).map_err(system)?, SeccompAction::Allow, refused(libc::EPERM))
}

/// System calls that no converter of files needs.
fn denied(alone: bool) -> Result<Calls, BackendError> {
    let mut calls = deadly()?;
    // A program is what the process becomes; memory files and socket pairs lead nowhere.
    for harmless in [libc::SYS_execve, libc::SYS_memfd_create, libc::SYS_socketpair, libc::SYS_personality] {
        calls.remove(&harmless);
    }
    let more = [
        // Metadata of files, which landlock leaves alone.
        libc::SYS_fchmod,
        libc::SYS_fchmodat,
        libc::SYS_fchown,
        libc::SYS_fchownat,
        libc::SYS_utimensat,
        libc::SYS_setxattr,
        libc::SYS_lsetxattr,
        libc::SYS_fsetxattr,
        libc::SYS_removexattr,
        libc::SYS_lremovexattr,
        libc::SYS_fremovexattr,
        // Older kernels' landlock does not see it.
        libc::SYS_truncate,
        // A way out of the group of processes that is ended as a whole.
        libc::SYS_setsid,
        libc::SYS_setpgid,
        // Memory and messages that stay when the process has ended.
        libc::SYS_shmget,
        libc::SYS_semget,
        libc::SYS_msgget,
        libc::SYS_mq_open,
        // Bounds of other processes.
        libc::SYS_setpriority,
        libc::SYS_sched_setscheduler,
        libc::SYS_sched_setattr,
        libc::SYS_setgroups,
        libc::SYS_setresgid,
        libc::SYS_setregid,
        // Newer calls that do what others above do: fchmodat2, the setxattrat family, file_setattr, mount setters.
        452,
        463,
        466,
        469,
        libc::SYS_mount_setattr,
        libc::SYS_fsconfig,
        libc::SYS_fsmount,
        libc::SYS_sethostname,
        libc::SYS_settimeofday,
        libc::SYS_clock_settime,
        libc::SYS_adjtimex,
        libc::SYS_syslog,
        libc::SYS_quotactl,
        libc::SYS_acct,
    ];
    calls.extend(more.map(|call| (call, Vec::new())));
    #[cfg(target_arch = "x86_64")]
    {
        let older = [
            libc::SYS_chmod,
            libc::SYS_chown,
            libc::SYS_lchown,
            libc::SYS_utime,
            libc::SYS_utimes,
            libc::SYS_futimesat,
        ];
        calls.extend(older.map(|call| (call, Vec::new())));
    }
    // A file that may be read cannot be cut by opening it, whatever the kernel's landlock sees of that.
    let cuts =
        |number| argument(number, MaskedEq((libc::O_ACCMODE | libc::O_TRUNC) as u64), libc::O_TRUNC.into());
    calls.insert(libc::SYS_openat, vec![cuts(2)?]);
    #[cfg(target_arch = "x86_64")]
    calls.insert(libc::SYS_open, vec![cuts(1)?]);
    // Aborting is a signal to itself; the number of the process stays when it becomes another program.
    calls.insert(libc::SYS_tgkill, vec![argument(0, SeccompCmpOp::Ne, i64::from(std::process::id()))?]);
    // Bounds are read, not set: the pointer to new ones is null.
    let some = SeccompCondition::new(2, SeccompCmpArgLen::Qword, SeccompCmpOp::Ne, 0)?;
    calls.insert(libc::SYS_prlimit64, vec![SeccompRule::new(vec![some])?]);
    calls.insert(libc::SYS_setrlimit, Vec::new());
    // Terminals: putting characters into their input.
    calls.insert(libc::SYS_ioctl, any_of(1, &[libc::TIOCSTI as i64, 0x541c])?);
    if !alone {
        #[cfg(target_arch = "x86_64")]
        [libc::SYS_fork, libc::SYS_vfork].iter().for_each(|call| drop(calls.remove(call)));
        let spaces = [
            libc::CLONE_NEWNS,
            libc::CLONE_NEWCGROUP,
            libc::CLONE_NEWUTS,
            libc::CLONE_NEWIPC,
            libc::CLONE_NEWUSER,
            libc::CLONE_NEWPID,
            libc::CLONE_NEWNET,
        ];
        let of_space = |flag: i32| argument(0, MaskedEq(u64::from(flag as u32)), i64::from(flag));
        calls.insert(libc::SYS_clone, spaces.into_iter().map(of_space).collect::<Result<_, _>>()?);
    }
    Ok(calls)
}

fn install(calls: Calls, otherwise: SeccompAction, matching: SeccompAction) -> Result<(), SandboxError> {
    let system = |error: &dyn Display| SandboxError::System(error.to_string());
    let architecture = std::env::consts::ARCH.try_into().map_err(|e: BackendError| system(&e))?;
    let filter =
        SeccompFilter::new(calls, otherwise, matching, architecture).map_err(|e: BackendError| system(&e))?;
    let program: BpfProgram = filter.try_into().map_err(|e: BackendError| system(&e))?;
    apply_filter(&program).map_err(|e| system(&e))
}

/// An argument, by its number from 0, that compares so with a value.
fn argument(number: u8, op: SeccompCmpOp, value: i64) -> Result<SeccompRule, BackendError> {
    // Constants of the C library are signed where the kernel reads bits.
    let value = u64::from(value as u32);
    SeccompRule::new(vec![SeccompCondition::new(number, SeccompCmpArgLen::Dword, op, value)?])
}

/// System calls that the program needs once it has been started.
fn allowed() -> Result<Calls, BackendError> {
    let mut calls = Calls::new();
    let plain = [
        // Memory that is there already. Mapping and protecting it is below.
        libc::SYS_brk,
        libc::SYS_munmap,
        libc::SYS_mremap,
        libc::SYS_madvise,
        // Threads, but for starting them.
        libc::SYS_futex,
        libc::SYS_set_robust_list,
        libc::SYS_rseq,
        libc::SYS_set_tid_address,
        libc::SYS_sched_yield,
        libc::SYS_sched_getaffinity,
        libc::SYS_membarrier,
        libc::SYS_gettid,
        libc::SYS_getpid,
        libc::SYS_exit,
        libc::SYS_exit_group,
        libc::SYS_restart_syscall,
        // Signals that are received: a full stack is told from other faults.
        libc::SYS_rt_sigaction,
        libc::SYS_rt_sigprocmask,
        libc::SYS_rt_sigreturn,
        libc::SYS_sigaltstack,
        // Time and random numbers (hash tables have keys).
        libc::SYS_clock_gettime,
        libc::SYS_clock_getres,
        libc::SYS_clock_nanosleep,
        libc::SYS_nanosleep,
        libc::SYS_gettimeofday,
        libc::SYS_getrandom,
        libc::SYS_getrusage,
        libc::SYS_sysinfo,
        // Descriptors that are open. Landlock says which may be opened.
        libc::SYS_read,
        libc::SYS_readv,
        libc::SYS_pread64,
        libc::SYS_write,
        libc::SYS_writev,
        libc::SYS_pwrite64,
        libc::SYS_lseek,
        libc::SYS_close,
        libc::SYS_fstat,
        libc::SYS_fchmod,
        libc::SYS_ftruncate,
        libc::SYS_flock,
        libc::SYS_ppoll,
        // Names of files; what they lead to is up to landlock.
        libc::SYS_newfstatat,
        libc::SYS_statx,
        libc::SYS_faccessat,
        libc::SYS_faccessat2,
        libc::SYS_readlinkat,
        libc::SYS_getcwd,
        libc::SYS_getdents64,
        libc::SYS_mkdirat,
        // A file without a name gets one.
        libc::SYS_linkat,
        libc::SYS_renameat,
        libc::SYS_renameat2,
        libc::SYS_unlinkat,
        // Only ever restrict further.
        libc::SYS_landlock_create_ruleset,
        libc::SYS_landlock_add_rule,
        libc::SYS_landlock_restrict_self,
    ];
    calls.extend(plain.map(|call| (call, Vec::new())));
    // The other filter's error counts: of two errors the kernel returns that of the filter that came last.
    calls.insert(libc::SYS_clone3, Vec::new());
    #[cfg(target_arch = "x86_64")]
    calls.extend(
        // Older names of calls above, which C libraries still use on this processor.
        [
            libc::SYS_stat,
            libc::SYS_lstat,
            libc::SYS_access,
            libc::SYS_readlink,
            libc::SYS_mkdir,
            libc::SYS_rename,
            libc::SYS_unlink,
            libc::SYS_poll,
            libc::SYS_time,
        ]
        .map(|call| (call, Vec::new())),
    );
    // Files are made new and renamed, never cut: before Linux 6.2 landlock does not look at that.
    let whole = |number| argument(number, MaskedEq(libc::O_TRUNC as u64), 0);
    calls.insert(libc::SYS_openat, vec![whole(2)?]);
    #[cfg(target_arch = "x86_64")]
    calls.insert(libc::SYS_open, vec![whole(1)?]);
    // Memory that is written to is never executed.
    let not_executable = argument(2, MaskedEq(libc::PROT_EXEC as u64), 0)?;
    calls.insert(libc::SYS_mmap, vec![not_executable.clone()]);
    calls.insert(libc::SYS_mprotect, vec![not_executable]);
    calls.insert(
        libc::SYS_clone,
        vec![argument(0, MaskedEq(THREAD_OR_SPACE), i64::from(libc::CLONE_THREAD))?],
    );
    // Aborting the process: a signal to itself.
    calls.insert(libc::SYS_tgkill, vec![argument(0, Eq, i64::from(std::process::id()))?]);
    let prctl = [libc::PR_SET_NAME, libc::PR_SET_NO_NEW_PRIVS, libc::PR_GET_NO_NEW_PRIVS];
    calls.insert(libc::SYS_prctl, any_of(0, &prctl.map(i64::from))?);
    let fcntl = [libc::F_GETFD, libc::F_SETFD, libc::F_GETFL, libc::F_DUPFD_CLOEXEC];
    calls.insert(libc::SYS_fcntl, any_of(1, &fcntl.map(i64::from))?);
    // Is this a terminal, and how wide.
    calls.insert(libc::SYS_ioctl, any_of(1, &[libc::TCGETS as i64, libc::TIOCGWINSZ as i64])?);
    // Reading limits (of the stack), not setting them: the pointer to new ones is null. Its upper half is in another
    // argument word, so both are compared.
    let none = SeccompCondition::new(2, SeccompCmpArgLen::Qword, Eq, 0)?;
    calls.insert(libc::SYS_prlimit64, vec![SeccompRule::new(vec![none])?]);
    Ok(calls)
}

/// Flags of `clone` that tell a thread of this process from everything else.
const THREAD_OR_SPACE: u64 = (libc::CLONE_THREAD
    | libc::CLONE_NEWNS
    | libc::CLONE_NEWCGROUP
    | libc::CLONE_NEWUTS
    | libc::CLONE_NEWIPC
    | libc::CLONE_NEWUSER
    | libc::CLONE_NEWPID
    | libc::CLONE_NEWNET) as u32 as u64;

fn any_of(number: u8, values: &[i64]) -> Result<Vec<SeccompRule>, BackendError> {
    values.iter().map(|&value| argument(number, Eq, value)).collect()
}

/// System calls that only a program that was taken over would make.
fn deadly() -> Result<Calls, BackendError> {
    let mut calls = Calls::new();
    let plain = [
        // Network.
        libc::SYS_socket,
        libc::SYS_socketpair,
        libc::SYS_connect,
        libc::SYS_bind,
        libc::SYS_listen,
        libc::SYS_accept,
        libc::SYS_accept4,
        libc::SYS_sendto,
        libc::SYS_sendmsg,
        libc::SYS_sendmmsg,
        libc::SYS_recvfrom,
        libc::SYS_recvmsg,
        libc::SYS_recvmmsg,
        // Other programs and processes.
        libc::SYS_execve,
        libc::SYS_execveat,
        libc::SYS_kill,
        // By this one musl aborts; but it names a thread of any process, and a filter cannot know whose.
        libc::SYS_tkill,
        libc::SYS_rt_sigqueueinfo,
        libc::SYS_rt_tgsigqueueinfo,
        libc::SYS_pidfd_open,
        libc::SYS_pidfd_getfd,
        libc::SYS_pidfd_send_signal,
        libc::SYS_ptrace,
        libc::SYS_process_vm_readv,
        libc::SYS_process_vm_writev,
        // Calls that filters do not see, and ways round them.
        libc::SYS_io_uring_setup,
        libc::SYS_io_uring_enter,
        libc::SYS_io_uring_register,
        libc::SYS_personality,
        libc::SYS_memfd_create,
        libc::SYS_userfaultfd,
        libc::SYS_open_by_handle_at,
        // The kernel and its name spaces.
        libc::SYS_bpf,
        libc::SYS_perf_event_open,
        libc::SYS_unshare,
        libc::SYS_setns,
        libc::SYS_mount,
        libc::SYS_umount2,
        libc::SYS_move_mount,
        libc::SYS_open_tree,
        libc::SYS_fsopen,
        libc::SYS_pivot_root,
        libc::SYS_chroot,
        libc::SYS_init_module,
        libc::SYS_finit_module,
        libc::SYS_delete_module,
        libc::SYS_kexec_load,
        libc::SYS_reboot,
        libc::SYS_swapon,
        libc::SYS_add_key,
        libc::SYS_request_key,
        libc::SYS_keyctl,
        libc::SYS_mknodat,
        libc::SYS_setuid,
        libc::SYS_setgid,
        libc::SYS_setreuid,
        libc::SYS_setresuid,
        libc::SYS_capset,
    ];
    calls.extend(plain.map(|call| (call, Vec::new())));
    #[cfg(target_arch = "x86_64")]
    calls.extend(
        [libc::SYS_fork, libc::SYS_vfork, libc::SYS_mknod, libc::SYS_ioperm, libc::SYS_iopl]
            .map(|call| (call, Vec::new())),
    );
    // A new process, in its many forms.
    calls.insert(libc::SYS_clone, vec![argument(0, MaskedEq(libc::CLONE_THREAD as u64), 0)?]);
    Ok(calls)
}
