//! The process between: this program, started once more, that sets bounds, gives up rights and becomes the converter.
//!
//! A process that has threads cannot be restricted, and what restricts one before it becomes another program is not safe to call
//! in a process that has them. So the drawing process starts this one, of which nothing but the bounds is left.

use overcoat_sandbox::ProgramGrants;
use serde::{Deserialize, Serialize};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// First argument of the program that makes it a launcher.
pub const COMMAND: &str = "launch-converter";

/// Exit code of a launcher that has not become another program.
pub const NOT_STARTED: u8 = 125;

/// Beginning of the line with which a launcher says why.
pub const MARK: &str = "overcoat-launcher: ";

/// Folders of programs and libraries of the system.
const PROGRAMS: [&str; 8] = ["/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/nix/store", "/gnu/store"];

/// Files and folders of the system that programs read at their start.
const SETTINGS: [&str; 12] = [
    "/etc/ld.so.cache",
    "/etc/ld.so.conf",
    "/etc/ld.so.conf.d",
    "/etc/ld.so.preload",
    "/etc/alternatives",
    "/etc/fonts",
    "/etc/localtime",
    "/proc/self",
    "/proc/cpuinfo",
    "/proc/meminfo",
    "/sys/devices/system/cpu",
    "/dev/urandom",
];

/// Bounds and rights of a converter. It comes from the drawing process, as JSON.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Launch {
    /// The program.
    pub program: PathBuf,
    /// Its arguments, in which `{input}` stands for the file.
    pub arguments: Vec<String>,
    /// Files and folders beside those of the system, to read and to run.
    pub read: Vec<PathBuf>,
    /// Private folder, to write.
    pub scratch: Option<PathBuf>,
    /// It may start other processes.
    pub processes: bool,
    /// It goes on where there is no sandbox.
    pub unsandboxed: bool,
    /// Seconds of processor time.
    pub cpu_seconds: u64,
    /// Bytes of memory.
    pub memory: u64,
    /// Bytes of a file that is written.
    pub output_bytes: u64,
}

/// Becomes the converter that the arguments after [`COMMAND`] describe. Returns an exit code where that fails.
#[must_use]
pub fn launch(arguments: &[OsString]) -> u8 {
    let Err(reason) = become_converter(arguments);
    eprintln!("{MARK}{}", reason.replace('\n', " "));
    NOT_STARTED
}

fn become_converter(arguments: &[OsString]) -> Result<std::convert::Infallible, String> {
    let [launch, input] = arguments else { return Err("it is started by overcoat alone".to_owned()) };
    let launch = launch.to_str().ok_or_else(|| "its first argument is no text".to_owned())?;
    let launch: Launch = serde_json::from_str(launch).map_err(|e| e.to_string())?;
    #[cfg(unix)]
    return become_it(&launch, input);
    #[cfg(not(unix))]
    {
        let _ = (launch, input);
        Err("converters are run on Unix systems only".to_owned())
    }
}

#[cfg(unix)]
fn become_it(launch: &Launch, input: &OsStr) -> Result<std::convert::Infallible, String> {
    use std::os::unix::process::CommandExt;
    bound(launch)?;
    match overcoat_sandbox::enter_for_program(&grants(launch, input)) {
        Ok(()) => {}
        // The drawing process tells it with the picture.
        Err(e) if launch.unsandboxed => eprintln!("warning: a converter has run without a sandbox: {e}"),
        Err(e) => return Err(e.to_string()),
    }
    let mut command = std::process::Command::new(&launch.program);
    command.args(launch.arguments.iter().map(|argument| with_input(argument, input)));
    // Secrets of the operator are in the environment.
    command.env_clear();
    let home = launch.scratch.clone().unwrap_or_else(|| PathBuf::from("/nonexistent"));
    command.env("PATH", "/usr/local/bin:/usr/bin:/bin").env("LANG", "C.UTF-8").env("LC_ALL", "C.UTF-8");
    command.env("HOME", &home).env("TMPDIR", &home);
    let error = command.exec();
    Err(format!("{}: {error}", launch.program.display()))
}

/// An argument with the file in it.
#[cfg(unix)]
fn with_input(argument: &str, input: &OsStr) -> OsString {
    let mut parts = argument.split("{input}");
    let mut out = OsString::from(parts.next().unwrap_or_default());
    for part in parts {
        out.push(input);
        out.push(part);
    }
    out
}

/// Rights of the converter to files.
#[cfg(unix)]
fn grants(launch: &Launch, input: &OsStr) -> ProgramGrants {
    let mut grants = ProgramGrants {
        run_folders: PROGRAMS.map(PathBuf::from).to_vec(),
        run_files: vec![launch.program.clone()],
        read_files: vec![PathBuf::from(input)],
        write_files: vec![PathBuf::from("/dev/null")],
        scratch_folders: launch.scratch.iter().cloned().collect(),
        may_start_processes: launch.processes,
        ..ProgramGrants::default()
    };
    for path in SETTINGS.map(PathBuf::from) {
        if path.is_dir() { grants.read_folders.push(path) } else { grants.read_files.push(path) }
    }
    for path in &launch.read {
        if path.is_dir() {
            grants.run_folders.push(path.clone())
        } else {
            grants.run_files.push(path.clone())
        }
    }
    grants
}

/// Bounds that a process cannot pass.
#[cfg(unix)]
fn bound(launch: &Launch) -> Result<(), String> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let set = |resource: Resource, bound: u64, hard: u64| {
        // Whoever started the program may have been stricter.
        let least = |given: Option<u64>, own: u64| Some(given.map_or(own, |given| given.min(own)));
        let Rlimit { current, maximum } = getrlimit(resource);
        let bounds = Rlimit {
            current: least(current.min(maximum).or(current).or(maximum), bound),
            maximum: least(maximum, hard),
        };
        setrlimit(resource, bounds).map_err(|e| format!("bounds cannot be set: {e}"))
    };
    set(Resource::Core, 0, 0)?;
    set(Resource::Nofile, 256, 256)?;
    // At the first bound the process is told, by a signal that ends it; at the second it is killed.
    set(Resource::Cpu, launch.cpu_seconds, launch.cpu_seconds.saturating_add(1))?;
    let file = if launch.scratch.is_some() { launch.output_bytes } else { 0 };
    set(Resource::Fsize, file, file)?;
    crate::memory_bound::bound_memory(launch.memory).map_err(|e| format!("memory cannot be bounded: {e}"))?;
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Signal, set_parent_process_death_signal};
        set_parent_process_death_signal(Some(Signal::KILL))
            .map_err(|e| format!("the end of the parent cannot be followed: {e}"))?;
    }
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_an_argument_and_no_text_of_a_shell() {
        let put = |argument: &str| with_input(argument, OsStr::new("/a b/;x"));
        assert_eq!(put("{input}"), "/a b/;x");
        assert_eq!(put("in={input},{input}"), "in=/a b/;x,/a b/;x");
        assert_eq!(put("--plain"), "--plain");
    }
}
