//! Outputs that are no plain files: links, pipes, devices, standard output by its name; and the remains of unfinished
//! ones.
#![cfg(target_os = "linux")]

#[path = "streams/mod.rs"]
mod streams;

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};

const MODEL: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn render(folder: &Path, output: &str, stdout: Stdio) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overcoat"))
        .args(["render", "x.obj", "--size", "16", "-o", output, "--output-format", "png"])
        .current_dir(folder)
        .stdout(stdout)
        .output()
        .unwrap()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("x.obj"), MODEL).unwrap();
    folder
}

fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG") && bytes.ends_with(b"IEND\xae\x42\x60\x82")
}

#[test]
fn standard_output_by_its_name() {
    let folder = folder();
    let piped = render(folder.path(), "/dev/stdout", Stdio::piped());
    assert!(is_png(&piped.stdout), "{}", String::from_utf8_lossy(&piped.stderr));
    // If standard output is a file, whoever started the program has it open, and may have written to it.
    let path = folder.path().join("p.png");
    let mut file = File::create(&path).unwrap();
    std::io::Write::write_all(&mut file, b"before").unwrap();
    let inode = file.metadata().unwrap().ino();
    assert!(render(folder.path(), "/dev/stdout", file.into()).status.success());
    let bytes = fs::read(&path).unwrap();
    assert!(bytes.starts_with(b"before") && is_png(&bytes[6..]));
    assert_eq!(fs::metadata(&path).unwrap().ino(), inode, "another file under the name of standard output");
}

#[test]
fn links_pipes_and_devices() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    // A link is followed, and stays one.
    fs::create_dir(at("elsewhere")).unwrap();
    fs::write(at("elsewhere/p.png"), "old").unwrap();
    symlink("elsewhere/p.png", at("link.png")).unwrap();
    assert!(render(folder.path(), "link.png", Stdio::null()).status.success());
    assert!(is_png(&fs::read(at("elsewhere/p.png")).unwrap()));
    assert!(fs::symlink_metadata(at("link.png")).unwrap().is_symlink());
    // A pipe gets the bytes and stays a pipe.
    if Command::new("mkfifo").arg(at("pipe.png")).status().is_ok_and(|status| status.success()) {
        let reader = Command::new("cat").arg(at("pipe.png")).stdout(Stdio::piped()).spawn().unwrap();
        assert!(render(folder.path(), "pipe.png", Stdio::null()).status.success());
        assert!(is_png(&reader.wait_with_output().unwrap().stdout));
        assert!(!fs::metadata(at("pipe.png")).unwrap().is_file());
    }
    // A device that is full is an error, and stays a device.
    let full = render(folder.path(), "/dev/full", Stdio::null());
    assert_eq!(full.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&full.stderr).contains("/dev/full: cannot be written"));
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
    // Nothing else is left.
    let mut names: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.retain(|name| name != "pipe.png");
    names.sort();
    assert_eq!(names, ["elsewhere", "link.png", "x.obj"]);
}

/// Output of a shell script in which the program is `$0`.
fn shell(folder: &Path, script: &str) -> Output {
    Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_overcoat")])
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn names(folder: &Path) -> Vec<OsString> {
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    names
}

#[test]
fn a_link_to_nothing_is_followed_as_one_to_a_file_is() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("elsewhere")).unwrap();
    symlink("elsewhere/p.png", at("link.png")).unwrap();
    symlink("no-such-folder/p.png", at("lost.png")).unwrap();
    for sandbox in ["", "--sandbox"] {
        let done = shell(folder.path(), &format!("\"$0\" {sandbox} render x.obj --size 16 -o link.png"));
        if sandbox.is_empty() || !text(&done.stderr).contains("there is no sandbox here") {
            assert!(done.status.success(), "{}", text(&done.stderr));
            assert!(is_png(&fs::read(at("elsewhere/p.png")).unwrap()));
            fs::remove_file(at("elsewhere/p.png")).unwrap();
        }
        assert!(fs::symlink_metadata(at("link.png")).unwrap().is_symlink());
    }
    assert_eq!(render(folder.path(), "lost.png", Stdio::null()).status.code(), Some(1));
    assert_eq!(names(folder.path()), ["elsewhere", "link.png", "lost.png", "x.obj"]);
}

#[test]
fn standard_output_that_nobody_reads_is_an_error() {
    let folder = folder();
    let lost = shell(folder.path(), "\"$0\" render x.obj --size 16 -o - >&-");
    assert_eq!(lost.status.code(), Some(1));
    assert!(text(&lost.stderr).contains("standard output is closed"), "{}", text(&lost.stderr));
    // Users discard a picture explicitly.
    assert!(shell(folder.path(), "\"$0\" render x.obj --size 16 -o - > /dev/null").status.success());
    // A reader that has stopped knows. (More than a pipe holds.)
    let stopped = shell(
        folder.path(),
        "{ \"$0\" render x.obj --size 1000 -o - --background env; echo $? > code; } | true",
    );
    assert_eq!(
        (text(&stopped.stderr), fs::read_to_string(folder.path().join("code")).unwrap()),
        (String::new(), "1\n".to_owned())
    );
}

#[test]
fn names_that_are_no_text_stay_what_they_are() {
    let folder = folder();
    fs::create_dir(folder.path().join("out")).unwrap();
    let name = |bytes: &'static [u8]| OsStr::from_bytes(bytes);
    let model = name(b"m\xe9.obj");
    fs::rename(folder.path().join("x.obj"), folder.path().join(model)).unwrap();
    fs::write(folder.path().join(name(b"\xe8.toml")), "metallic = 1\n").unwrap();
    let commands: [&[&OsStr]; 4] = [
        &[name(b"turntable"), model, name(b"-o"), name(b"out/t\xe9-#.png"), name(b"--frames"), name(b"2")],
        &[name(b"render"), model, name(b"-o"), name(b"out/r\xe9.png"), name(b"--aov"), name(b"depth")],
        &[
            name(b"render"),
            model,
            name(b"-o"),
            name(b"out/\xe9m.png"),
            name(b"--material"),
            name(b"\xe8.toml"),
        ],
        &[name(b"sheet"), model, name(b"-o"), name(b"out/s\xe9.png")],
    ];
    for args in commands {
        let done = Command::new(env!("CARGO_BIN_EXE_overcoat"))
            .args(args)
            .args(["--size", "16"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(done.status.success(), "{args:?}: {}", text(&done.stderr));
    }
    let expected: [&[u8]; 6] =
        [b"r\xe9.depth.png", b"r\xe9.png", b"s\xe9.png", b"t\xe9-0.png", b"t\xe9-1.png", b"\xe9m.png"];
    assert_eq!(names(&folder.path().join("out")), expected.map(OsStr::from_bytes));
    // The environment is looked for under its own name.
    let missing = Command::new(env!("CARGO_BIN_EXE_overcoat"))
        .args([name(b"render"), model, name(b"-o"), name(b"p.png"), name(b"--env"), name(b"\xe9.hdr")])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(text(&missing.stderr).contains("\u{fffd}.hdr: cannot be read"), "{}", text(&missing.stderr));
}

#[test]
fn a_file_size_limit_ends_with_a_line_and_without_a_file() {
    let folder = folder();
    for output in ["p.png", "f-#.png --frames 3"] {
        let command = if output.contains('#') { "turntable" } else { "render" };
        let done = shell(
            folder.path(),
            &format!("ulimit -f 1; \"$0\" {command} x.obj --size 200 -o {output} --background env"),
        );
        assert_eq!(done.status.code(), Some(1), "{:?} {}", done.status, text(&done.stderr));
        let message = text(&done.stderr);
        assert!(
            message.contains("cannot be written: File too large") && message.lines().count() == 1,
            "{message}"
        );
        assert_eq!(names(folder.path()), ["x.obj"]);
    }
}

/// Frames are there as they are made, each of them whole; if one fails, none is left.
#[test]
fn numbered_frames_are_written_as_they_are_made() {
    let folder = folder();
    fs::create_dir(folder.path().join("out")).unwrap();
    // The third frame waits for a reader: the first two are there by then.
    let pipe = folder.path().join("out/f-2.png");
    if !Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()) {
        return;
    }
    let args = ["turntable", "x.obj", "--size", "16", "-o", "out/f-#.png", "--frames", "4"];
    let start = || {
        Command::new(env!("CARGO_BIN_EXE_overcoat")).args(args).current_dir(folder.path()).spawn().unwrap()
    };
    let mut running = start();
    // Opening waits for the writer.
    let mut reader = File::open(&pipe).unwrap();
    for frame in ["out/f-0.png", "out/f-1.png"] {
        assert!(is_png(&fs::read(folder.path().join(frame)).unwrap()));
    }
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut reader, &mut bytes).unwrap();
    assert!(is_png(&bytes) && running.wait().unwrap().success());
    assert!(is_png(&fs::read(folder.path().join("out/f-3.png")).unwrap()));
    // Killed while the third is written: whole frames, and nothing else.
    for frame in ["out/f-0.png", "out/f-1.png", "out/f-3.png"] {
        fs::remove_file(folder.path().join(frame)).unwrap();
    }
    let mut running = start();
    let reader = File::open(&pipe).unwrap();
    running.kill().unwrap();
    running.wait().unwrap();
    drop(reader);
    assert!(names(&folder.path().join("out")).iter().all(|name| !name.as_bytes().ends_with(b".tmp")));
    // A frame that cannot be written: those before it go.
    for name in names(&folder.path().join("out")) {
        fs::remove_file(folder.path().join("out").join(name)).unwrap();
    }
    symlink("/dev/full", &pipe).unwrap();
    let done =
        Command::new(env!("CARGO_BIN_EXE_overcoat")).args(args).current_dir(folder.path()).output().unwrap();
    assert_eq!(done.status.code(), Some(1), "{}", text(&done.stderr));
    assert_eq!(names(&folder.path().join("out")), ["f-2.png"]);
}

#[test]
fn a_file_in_a_folder_where_nothing_may_be_made_is_written_over() {
    let folder = folder();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("p.png"), "old").unwrap();
    fs::set_permissions(&out, fs::Permissions::from_mode(0o555)).unwrap();
    let done = render(folder.path(), "out/p.png", Stdio::null());
    fs::set_permissions(&out, fs::Permissions::from_mode(0o755)).unwrap();
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(is_png(&fs::read(out.join("p.png")).unwrap()));
    assert_eq!(names(&out), ["p.png"]);
}

/// A file that is mounted by itself cannot be replaced. Where the system allows no mounts, nothing is tested.
#[test]
fn a_file_that_is_mounted_by_itself_is_written_over() {
    let folder = folder();
    fs::write(folder.path().join("p.png"), "old".repeat(10_000)).unwrap();
    fs::write(folder.path().join("mounted"), "mounted".repeat(10_000)).unwrap();
    for sandbox in ["", "--sandbox"] {
        let script = format!(
            "unshare -rm sh -c 'mount --bind mounted p.png || exit 77; \"$0\" {sandbox} render x.obj --size 16 -o p.png' \"$0\""
        );
        let done = shell(folder.path(), &script);
        let message = text(&done.stderr);
        if done.status.code() == Some(77)
            || message.contains("unshare")
            || message.contains("no sandbox here")
        {
            eprintln!("SKIPPED, NOTHING WAS TESTED: {message}");
            continue;
        }
        assert!(done.status.success(), "{sandbox}: {message}");
        assert!(is_png(&fs::read(folder.path().join("mounted")).unwrap()));
        assert!(fs::read(folder.path().join("p.png")).unwrap().starts_with(b"oldold"));
    }
    assert_eq!(names(folder.path()), ["mounted", "p.png", "x.obj"]);
}

/// Lack of memory ends with one line and a documented exit code, whatever the system gives.
#[test]
fn memory_that_cannot_be_had_ends_with_a_line_and_a_code() {
    let folder = folder();
    // With less than itself the system does not start a program.
    let program = fs::metadata(env!("CARGO_BIN_EXE_overcoat")).unwrap().len() / 1024;
    for (k, kilobytes) in (program + 2_000..400_000).step_by(20_000).enumerate() {
        let size = if k % 2 == 0 { 16 } else { 2000 };
        let script = format!(
            "export RUST_BACKTRACE=0; ulimit -v {kilobytes}; \"$0\" render x.obj --size {size} -o p.png --threads 4"
        );
        let done = shell(folder.path(), &script);
        let message = text(&done.stderr);
        match done.status.code() {
            Some(0) => {}
            // 127: the system itself could not start the program.
            Some(3 | 1) => {
                // Memory that is reserved beforehand fails with our line; other allocations with those of the standard
                // library.
                let lines: Vec<&str> =
                    message.lines().filter(|line| !line.starts_with("warning: ")).collect();
                let of_library = ["memory allocation of ", "note: ", "skipping backtrace"];
                let is_ours = lines.len() == 1 && lines[0].starts_with("overcoat: ");
                let is_theirs = !lines.is_empty()
                    && lines.iter().all(|line| of_library.iter().any(|l| line.starts_with(l)));
                assert!(is_ours || is_theirs, "{kilobytes}: {message}");
            }
            Some(127) => {}
            code => panic!("{kilobytes}: {code:?} {message}"),
        }
        assert!(names(folder.path()).iter().all(|name| !name.as_bytes().ends_with(b".tmp")));
    }
}
