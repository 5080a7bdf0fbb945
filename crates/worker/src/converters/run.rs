//! A run of a converter, seen from the process that draws: it starts a launcher, reads what comes, and ends all that is left.

use super::launch::{self, Launch};
use super::{Converted, Converter, Original};
use crate::codes;
use crate::failure::Failure;
use overcoat_core::limits::Limits;
use overcoat_load::Warning;
use std::io::Write;
use std::path::{Path, PathBuf};

/// First bytes of GLB.
const GLB: &[u8] = b"glTF";

/// Warnings that are told of one file, at most.
const MOST_WARNINGS: usize = 16;

fn failed(message: impl std::fmt::Display) -> Failure {
    Failure::failed(message).with_code(codes::CONVERTER)
}

/// Runs a converter on a file.
pub(super) fn run(
    converter: &Converter,
    original: Original<'_>,
    pixels: u32,
    limits: &Limits,
) -> Result<Converted, Failure> {
    let program = program_of(converter)?;
    let needs_folder = converter.scratch || matches!(original, Original::Bytes(_));
    let folder = if needs_folder { Some(private_folder()?) } else { None };
    let own = folder.as_ref().map(|folder| folder.path());
    // Its output is one folder below, so that it cannot put another file in the place of the one that it reads.
    let scratch = match own.filter(|_| converter.scratch) {
        Some(own) => {
            let scratch = own.join("scratch");
            std::fs::create_dir(&scratch).map_err(|e| failed(format!("no private folder: {e}")))?;
            Some(scratch)
        }
        None => None,
    };
    let input = match (original, own) {
        (Original::File(path), _) => path.canonicalize().map_err(failed)?,
        (Original::Bytes(bytes), Some(own)) => lay_out(bytes, own, converter)?,
        (Original::Bytes(_), None) => return Err(failed("no private folder")),
    };
    let output = scratch.as_ref().map(|scratch| scratch.join("out.glb"));
    let output_bytes = converter.output_bytes.min(limits.input_bytes);
    let launch = Launch {
        program,
        arguments: arguments(converter, pixels, scratch.as_deref(), output.as_deref())?,
        read: converter.read.clone(),
        scratch,
        processes: converter.processes,
        unsandboxed: converter.unsandboxed,
        cpu_seconds: converter.cpu_seconds,
        memory: converter.memory,
        output_bytes,
    };
    let to_file = converter.uses("{output}");
    let ended = system::run(&launch, &input, converter, if to_file { 0 } else { output_bytes })?;
    let glb = match (to_file, &output) {
        (true, Some(output)) => {
            ended.check(converter)?;
            system::read_made(output, output_bytes)?
        }
        _ => ended.checked_output(converter)?,
    };
    if !glb.starts_with(GLB) {
        let what = if glb.is_empty() { "nothing" } else { "something else" };
        return Err(failed(format!("it was to write GLB and has written {what}{}", ended.last_words())));
    }
    Ok(Converted { glb, warnings: ended.warnings() })
}

fn private_folder() -> Result<tempfile::TempDir, Failure> {
    let made = tempfile::Builder::new().prefix("overcoat-converter-").tempdir();
    made.map_err(|e| failed(format!("no private folder: {e}")))
}

/// Writes bytes into the private folder, under a name that is not the client's.
fn lay_out(bytes: &[u8], folder: &Path, converter: &Converter) -> Result<PathBuf, Failure> {
    let extension = converter.extensions.first().map_or("bin", String::as_str);
    let path = folder.join(format!("model.{extension}"));
    let written = std::fs::File::create_new(&path).and_then(|mut file| file.write_all(bytes));
    written.map_err(|e| failed(format!("the file cannot be laid out: {e}")))?;
    Ok(path)
}

/// The arguments with all but the file in them.
fn arguments(
    converter: &Converter,
    pixels: u32,
    scratch: Option<&Path>,
    output: Option<&Path>,
) -> Result<Vec<String>, Failure> {
    let text = |path: Option<&Path>| match path.map(|path| path.to_str()) {
        Some(None) => Err(failed("the folder of temporary files has a name that is no text")),
        Some(Some(text)) => Ok(text.to_owned()),
        None => Ok(String::new()),
    };
    let (scratch, output, pixels) = (text(scratch)?, text(output)?, pixels.to_string());
    let known = [("{pixels}", &pixels), ("{scratch}", &scratch), ("{output}", &output)];
    let filled = |argument: &String| {
        known.iter().fold(argument.clone(), |argument, (name, value)| argument.replace(name, value))
    };
    Ok(converter.command.iter().skip(1).map(filled).collect())
}

/// The program of a converter: by its absolute path; by its name beside this program, on the absolute folders of `PATH`, or where
/// packages have programs that are not for people. Never from the current folder.
fn program_of(converter: &Converter) -> Result<PathBuf, Failure> {
    let name = converter.command.first().map_or("", String::as_str);
    if name.contains('/') {
        return Ok(PathBuf::from(name));
    }
    let beside = std::env::current_exe().ok().and_then(|own| Some(own.parent()?.to_owned()));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let on_path = std::env::split_paths(&path).filter(|folder| folder.is_absolute());
    let others = ["/usr/local/libexec/overcoat", "/usr/libexec/overcoat"].map(PathBuf::from);
    let mut folders = beside.into_iter().chain(on_path).chain(others);
    let found = folders.find_map(|folder| Some(folder.join(name)).filter(|program| program.is_file()));
    // The launcher's rights are to what it is, and not to a link.
    let found = found.map(|program| program.canonicalize().unwrap_or(program));
    found.ok_or_else(|| failed(format!("its program '{name}' is not there")))
}

#[cfg(unix)]
mod system {
    use super::*;
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
    use std::io::Read;
    use std::os::unix::fs::OpenOptionsExt;
    use std::os::unix::process::{CommandExt, ExitStatusExt};
    use std::process::{Child, Command, ExitStatus, Stdio};
    use std::time::{Duration, Instant};

    /// Bytes of messages that are kept: the first, and as many of the last.
    const MESSAGES: usize = 8 << 10;

    /// Time between looks at a folder that is written to.
    const LOOK: Duration = Duration::from_millis(50);

    /// Why a converter was stopped.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Stopped {
        Time,
        Output,
    }

    /// A converter that has ended.
    pub(super) struct Ended {
        status: ExitStatus,
        stopped: Option<Stopped>,
        output: Vec<u8>,
        messages: Vec<u8>,
    }

    /// A child that is ended with all its processes, whatever happens.
    struct Group(Child);

    impl Group {
        fn pid(&self) -> Option<Pid> {
            Pid::from_raw(i32::try_from(self.0.id()).ok()?)
        }

        /// True once it has ended. It is not waited for: until then nobody else has its number.
        fn has_ended(&self) -> bool {
            let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
            self.pid().is_none_or(|pid| !matches!(waitid(WaitId::Pid(pid), options), Ok(None)))
        }

        fn kill(&self) {
            if let Some(pid) = self.pid() {
                let _ = kill_process_group(pid, Signal::KILL);
            }
        }

        fn end(&mut self) -> std::io::Result<ExitStatus> {
            self.kill();
            self.0.wait()
        }
    }

    impl Drop for Group {
        fn drop(&mut self) {
            let _ = self.end();
        }
    }

    /// Runs a launcher to its end. `most`: bytes of its output.
    pub(super) fn run(
        launch: &Launch,
        input: &Path,
        converter: &Converter,
        most: u64,
    ) -> Result<Ended, Failure> {
        let own = std::env::current_exe().map_err(|e| failed(format!("this program's own file: {e}")))?;
        let spec = serde_json::to_string(launch).map_err(failed)?;
        let mut command = Command::new(own);
        command.arg(launch::COMMAND).arg(spec).arg(input).current_dir("/").env_clear().process_group(0);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut group = Group(command.spawn().map_err(|e| failed(format!("it cannot be started: {e}")))?);
        let deadline = Instant::now() + Duration::from_secs(converter.wall_seconds);
        let (mut output, mut messages) = (Vec::new(), Vec::new());
        let mut stopped = None;
        while stopped.is_none() {
            let left = deadline.saturating_duration_since(Instant::now());
            let looks = launch.scratch.is_some() || launch.processes;
            let step = if looks { left.min(LOOK) } else { left };
            if left.is_zero() {
                stopped = Some(Stopped::Time);
            } else if !receive(&mut group.0, step, (&mut output, most), &mut messages)? {
                break;
            }
            if launch.processes && group.has_ended() {
                // Processes that it has left behind may keep its streams open.
                group.kill();
            }
            let is_full = |folder: &PathBuf| size_of(folder, 0) > launch.output_bytes;
            if output.len() as u64 > most && most > 0 || launch.scratch.as_ref().is_some_and(is_full) {
                stopped = Some(Stopped::Output);
            }
        }
        // Its streams are closed; the process itself may go on.
        while stopped.is_none() && !group.has_ended() {
            if Instant::now() >= deadline {
                stopped = Some(Stopped::Time);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let status = group.end().map_err(|e| failed(format!("its end is not known: {e}")))?;
        Ok(Ended { status, stopped, output, messages })
    }

    /// Waits for a stream of the child and reads it. False once both are at their end.
    fn receive(
        child: &mut Child,
        step: Duration,
        (output, most): (&mut Vec<u8>, u64),
        messages: &mut Vec<u8>,
    ) -> Result<bool, Failure> {
        let lost = |e: std::io::Error| failed(format!("its streams are lost: {e}"));
        let (mut has_output, mut has_messages) = (false, false);
        {
            let mut streams = Vec::new();
            streams.extend(child.stdout.as_ref().map(|s| PollFd::new(s, PollFlags::IN)));
            streams.extend(child.stderr.as_ref().map(|s| PollFd::new(s, PollFlags::IN)));
            if streams.is_empty() {
                return Ok(false);
            }
            let time = Timespec { tv_sec: step.as_secs() as i64, tv_nsec: i64::from(step.subsec_nanos()) };
            match poll(&mut streams, Some(&time)) {
                Ok(_) => {}
                Err(rustix::io::Errno::INTR) => return Ok(true),
                Err(e) => return Err(lost(e.into())),
            }
            let mut ready = streams.iter().map(|stream| !stream.revents().is_empty());
            if child.stdout.is_some() {
                has_output = ready.next().unwrap_or(false);
            }
            if child.stderr.is_some() {
                has_messages = ready.next().unwrap_or(false);
            }
        }
        let mut part = [0; 1 << 16];
        if let (true, Some(stream)) = (has_output, child.stdout.as_mut()) {
            match stream.read(&mut part).map_err(lost)? {
                0 => child.stdout = None,
                n => {
                    // Output beside the file that was asked for is chatter.
                    let kept = if most == 0 { &[] } else { part.get(..n).unwrap_or_default() };
                    Limits::check_memory(|| "what a converter writes".to_owned(), kept.len() as u64)
                        .map_err(|e| Failure::limit(&e))?;
                    output.extend_from_slice(kept);
                }
            }
        }
        if let (true, Some(stream)) = (has_messages, child.stderr.as_mut()) {
            match stream.read(&mut part).map_err(lost)? {
                0 => child.stderr = None,
                n => {
                    messages.extend_from_slice(part.get(..n).unwrap_or_default());
                    if messages.len() > 3 * MESSAGES {
                        messages.drain(MESSAGES..messages.len() - MESSAGES);
                    }
                }
            }
        }
        Ok(child.stdout.is_some() || child.stderr.is_some())
    }

    /// Bytes of all files in a folder; folders that lie too deep count as far too many.
    fn size_of(folder: &Path, depth: usize) -> u64 {
        if depth > 16 {
            return u64::MAX;
        }
        let Ok(entries) = std::fs::read_dir(folder) else { return 0 };
        let size = |entry: std::fs::DirEntry| match entry.metadata() {
            Ok(metadata) if metadata.is_dir() => size_of(&entry.path(), depth + 1).saturating_add(4096),
            Ok(metadata) => metadata.len(),
            Err(_) => 0,
        };
        entries.filter_map(Result::ok).map(size).fold(0, u64::saturating_add)
    }

    /// A file that a converter was to make. No link is followed, and nothing but a file is read.
    pub(super) fn read_made(path: &Path, most: u64) -> Result<Vec<u8>, Failure> {
        let unreadable = |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::NotFound => failed("it was to write GLB into {output} and has not"),
            _ => failed(format!("what it was to write cannot be read: {e}")),
        };
        let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
        let mut options = std::fs::OpenOptions::new();
        let file = options.read(true).custom_flags(flags.bits() as i32).open(path).map_err(unreadable)?;
        if !file.metadata().map_err(unreadable)?.is_file() {
            return Err(failed("what it has written is no file"));
        }
        let mut bytes = Vec::new();
        file.take(most + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        if bytes.len() as u64 > most {
            return Err(Failure::beyond(format!("it has written more than {most} bytes")));
        }
        Ok(bytes)
    }

    impl Ended {
        /// An error unless it has ended as it should.
        pub(super) fn check(&self, converter: &Converter) -> Result<(), Failure> {
            let bound = |what: String| Err(Failure::beyond(what));
            match (self.stopped, self.status.signal()) {
                (Some(Stopped::Time), _) => bound(format!(
                    "it took longer than {} s and was stopped (wall_seconds)",
                    converter.wall_seconds
                )),
                (Some(Stopped::Output), _) => bound(format!(
                    "it wrote more than {} bytes and was stopped (output_bytes, --limit input_bytes)",
                    converter.output_bytes
                )),
                (None, Some(signal)) if signal == Signal::XCPU.as_raw() => bound(format!(
                    "it took more than {} s of processor time and was stopped (cpu_seconds)",
                    converter.cpu_seconds
                )),
                (None, Some(signal)) if signal == Signal::XFSZ.as_raw() => {
                    bound(format!("it wrote more than {} bytes and was stopped", converter.output_bytes))
                }
                (None, Some(signal)) => {
                    Err(failed(format!("it was ended by signal {signal}{}", self.last_words())))
                }
                (None, None) => self.check_code(converter),
            }
        }

        fn check_code(&self, converter: &Converter) -> Result<(), Failure> {
            let told = self.text();
            match self.status.code() {
                Some(0) => Ok(()),
                Some(code) => match told.lines().find_map(|line| line.strip_prefix(launch::MARK)) {
                    Some(reason) if code == i32::from(launch::NOT_STARTED) => {
                        let remedy = match reason.contains("sandbox") && !converter.unsandboxed {
                            true => "; --allow-unsandboxed-converters runs it without",
                            false => "",
                        };
                        Err(failed(format!("it is not run: {reason}{remedy}")))
                    }
                    _ => Err(failed(format!("it has failed with code {code}{}", self.last_words()))),
                },
                None => Err(failed("it has failed")),
            }
        }

        /// Its output, if it has ended as it should.
        pub(super) fn checked_output(&self, converter: &Converter) -> Result<Vec<u8>, Failure> {
            self.check(converter)?;
            Ok(self.output.clone())
        }

        fn text(&self) -> String {
            String::from_utf8_lossy(&self.messages).into_owned()
        }

        /// The last line that it has said, as the end of a message.
        pub(super) fn last_words(&self) -> String {
            let text = self.text();
            let last = text.lines().rev().map(str::trim).find(|line| !line.is_empty());
            last.map_or_else(String::new, |line| format!(": {}", line.chars().take(300).collect::<String>()))
        }

        /// Remarks that it makes for who reads the picture.
        pub(super) fn warnings(&self) -> Vec<Warning> {
            let text = self.text();
            let told = text.lines().filter_map(|line| line.strip_prefix("warning:"));
            let told = told.map(|line| line.trim().chars().take(300).collect::<String>());
            told.take(MOST_WARNINGS).map(Warning::new).collect()
        }
    }
}

#[cfg(not(unix))]
mod system {
    use super::*;

    /// A converter that has ended: there is none.
    pub(super) enum Ended {}

    pub(super) fn run(_: &Launch, _: &Path, _: &Converter, _: u64) -> Result<Ended, Failure> {
        Err(failed("converters are run on Unix systems only"))
    }

    pub(super) fn read_made(_: &Path, _: u64) -> Result<Vec<u8>, Failure> {
        Err(failed("converters are run on Unix systems only"))
    }

    impl Ended {
        pub(super) fn check(&self, _: &Converter) -> Result<(), Failure> {
            match *self {}
        }

        pub(super) fn checked_output(&self, _: &Converter) -> Result<Vec<u8>, Failure> {
            match *self {}
        }

        pub(super) fn last_words(&self) -> String {
            match *self {}
        }

        pub(super) fn warnings(&self) -> Vec<Warning> {
            match *self {}
        }
    }
}
