//! Other people's models. Switched on by `OVERCOAT_CORPUS`, a folder with `EXPECT.tsv` (what should become of each
//! file) and `hostile/` (files that must do no harm).
#![cfg(unix)]

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Longest time that a hostile file may take.
const PATIENCE: Duration = Duration::from_secs(10);
/// Address space that it may take, in KiB.
const MEMORY_KIB: u64 = 2 << 20;

/// Files of which nothing can be seen whatever the renderer does, and why.
const INVISIBLE: [(&str, &str); 1] = [("obj/degenerate_mesh.obj", "its only triangle has no area")];

fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("OVERCOAT_CORPUS").map(PathBuf::from);
    if folder.is_none() {
        println!("OVERCOAT_CORPUS is not set: skipped");
    }
    folder
}

/// Outcome of a run of the program.
struct Outcome {
    /// `None`: by a signal.
    code: Option<i32>,
    timed_out: bool,
    stderr: String,
}

/// Runs the program with bounded time and memory.
fn run(args: &[&Path], scratch: &Path, number: usize) -> Outcome {
    let log = scratch.join(format!("{number}.log"));
    let mut child = Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY_KIB}; exec \"$0\" \"$@\"")])
        .arg(env!("CARGO_BIN_EXE_overcoat"))
        .args(args)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&log).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let mut timed_out = false;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > PATIENCE && !timed_out {
            timed_out = true;
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let stderr = String::from_utf8_lossy(&fs::read(&log).unwrap()).into_owned();
    Outcome { code: status.code(), timed_out, stderr }
}

/// Runs a check over all items on two threads and panics with all complaints.
fn check_all<T: Sync>(items: &[T], check: impl Fn(usize, &T) -> Result<(), String> + Sync) {
    let next = AtomicUsize::new(0);
    let complaints = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(k) else { break };
                    if let Err(complaint) = check(k, item) {
                        complaints.lock().unwrap().push(complaint);
                    }
                }
            });
        }
    });
    let complaints = complaints.into_inner().unwrap();
    assert!(complaints.is_empty(), "{} of {}:\n{}", complaints.len(), items.len(), complaints.join("\n"));
}

/// Pixels of a PNG file with some coverage.
fn covered_pixels(path: &Path) -> usize {
    let mut decoder = png::Decoder::new(std::io::BufReader::new(File::open(path).unwrap()));
    decoder.set_transformations(png::Transformations::ALPHA);
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    pixels[..info.buffer_size()].chunks(4).filter(|p| p[3] > 0).count()
}

#[test]
fn every_model_becomes_what_is_expected() {
    let Some(corpus) = corpus() else { return };
    let table = fs::read_to_string(corpus.join("EXPECT.tsv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .filter(|line| !line.starts_with('#') && !line.is_empty())
        .map(|line| line.split('\t').collect())
        .collect();
    assert!(rows.len() > 50, "only {} rows", rows.len());
    let scratch = tempfile::tempdir().unwrap();
    let out = |k: usize| scratch.path().join(format!("{k}.png"));
    check_all(&rows, |k, row| {
        let (file, expected) = (row[0], row[1]);
        let picture = out(k);
        let outcome = run(
            &[
                "render".as_ref(),
                &corpus.join(file),
                "-o".as_ref(),
                &picture,
                "--size".as_ref(),
                "128".as_ref(),
            ],
            scratch.path(),
            k,
        );
        let Outcome { code, timed_out, stderr } = &outcome;
        let complain =
            |what: &str| Err(format!("{file} ({expected}): {what}; exit {code:?}: {}", stderr.trim()));
        if *timed_out {
            return complain("takes too long");
        }
        match expected {
            // Which is a failure that says so, and no picture.
            "picture" if INVISIBLE.iter().any(|(name, _)| *name == file) => {
                let said = *code == Some(1) && stderr.contains("nothing to see") && !picture.exists();
                if said { Ok(()) } else { complain("no message") }
            }
            "picture" if *code != Some(0) => complain("no picture"),
            "picture" if covered_pixels(&picture) == 0 => complain("blank"),
            "picture" => Ok(()),
            // A message says why nothing is seen.
            // Points and lines are something to see.
            "warning" | "empty" if *code == Some(0) && covered_pixels(&picture) > 0 => Ok(()),
            "warning" | "empty" if stderr.trim().is_empty() => complain("no message"),
            "warning" | "empty" if *code == Some(0) && covered_pixels(&picture) == 0 => complain("blank"),
            "warning" | "empty" | "check" if matches!(code, Some(0 | 1 | 3)) => Ok(()),
            _ => complain("neither a picture nor a clear error"),
        }
    });
}

#[test]
fn hostile_files_do_no_harm() {
    let Some(corpus) = corpus() else { return };
    let mut files = Vec::new();
    let mut folders = vec![corpus.join("hostile")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    assert!(files.len() > 100, "only {} files", files.len());
    let scratch = tempfile::tempdir().unwrap();
    let model =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("assets/models/rounded-cube.glb");
    check_all(&files, |k, file| {
        let out = scratch.path().join(format!("{k}.png"));
        let is_environment = file.extension().is_some_and(|e| e == "hdr" || e == "exr");
        let input: [&Path; 3] = if is_environment {
            [&model, "--env".as_ref(), file]
        } else {
            [file, "--env".as_ref(), "none".as_ref()]
        };
        let mut args: Vec<&Path> = vec!["render".as_ref()];
        args.extend(input);
        args.extend(["-o".as_ref(), out.as_path(), "--size".as_ref(), "64".as_ref()]);
        let Outcome { code, timed_out, stderr } = run(&args, scratch.path(), k);
        let complain = |what: &str| {
            let start: String = stderr.chars().take(300).collect();
            Err(format!("{}: {what}; exit {code:?}: {}", file.display(), start.trim()))
        };
        let last = stderr.lines().last().unwrap_or("");
        match code {
            _ if timed_out => complain("takes too long"),
            Some(0) if out.exists() => Ok(()),
            Some(1 | 3) if out.exists() => complain("failed and left a picture"),
            Some(1 | 3) if last.starts_with("overcoat: ") => Ok(()),
            _ => complain("neither a picture nor a clear error"),
        }
    });
}
