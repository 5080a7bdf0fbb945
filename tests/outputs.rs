//! Where pictures go that is no plain file: links, pipes, devices, standard output by its name.
#![cfg(all(feature = "cli", target_os = "linux"))]

use std::fs::{self, File};
use std::os::unix::fs::{MetadataExt, symlink};
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
    // Where it is a file, whoever started the program has it open, and may have written to it.
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
