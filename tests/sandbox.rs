//! `--sandbox` holds: a process in it cannot do what a program that was taken over would do, and its pictures are the
//! same. Each attempt is a process of its own, once with the sandbox and once without, which shows that the attempt is
//! real.
#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output};

/// The signal of a call that ends the process.
const SIGSYS: i32 = 31;

fn overcoat(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overcoat")).args(args).current_dir(folder).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// True if this kernel has what the sandbox is made of; if not, says so, and the program must have refused to run.
fn there_is_a_sandbox() -> bool {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("x"), "x").unwrap();
    let tried = overcoat(folder.path(), &["--sandbox", "attempt", "read", "x", "--input", "."]);
    if tried.status.success() {
        return true;
    }
    let message = stderr(&tried);
    assert!(message.contains("there is no sandbox here: this kernel has no landlock"), "{message}");
    assert_eq!(tried.status.code(), Some(1), "a run without the sandbox that was asked for");
    eprintln!("SKIPPED, NOTHING WAS TESTED: {message}");
    false
}

/// A folder with a model's folder, a picture's folder, and something beside them.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    for name in ["in", "in/below", "out", "other"] {
        fs::create_dir(place.path().join(name)).unwrap();
    }
    for name in ["in/a", "in/below/b", "out/c", "other/secret", "secret"] {
        fs::write(place.path().join(name), "content").unwrap();
    }
    place
}

#[test]
fn what_a_program_that_was_taken_over_would_try_fails() {
    if !there_is_a_sandbox() {
        return;
    }
    let refused = [
        ("read", "other/secret"),
        ("read", "secret"),
        ("read", "in/../secret"),
        ("read", "/etc/passwd"),
        ("read", "/proc/self/environ"),
        ("read", "/proc/self/mem"),
        ("read", "/dev/zero"),
        ("list", "other"),
        ("list", "/"),
        ("thread", "/etc/passwd"),
        ("thread", "secret"),
        ("write", "in/new"),
        ("write", "other/new"),
        ("write", "/tmp/overcoat-was-here"),
        ("truncate", "in/a"),
        ("truncate", "out/c"),
        ("remove", "in/a"),
        ("remove", "other/secret"),
        ("link", "other/secret"),
    ];
    for (what, path) in refused {
        let place = place();
        let tried =
            overcoat(place.path(), &["--sandbox", "attempt", what, path, "--input", "in", "--output", "out"]);
        let message = stderr(&tried);
        assert_eq!(tried.status.code(), Some(1), "{what} {path}: {message}");
        assert!(message.contains("refused: "), "{what} {path}: {message}");
        assert_eq!(fs::read_to_string(place.path().join("in/a")).unwrap(), "content", "{what} {path}");
        assert!(!Path::new("/tmp/overcoat-was-here").exists());
    }
    let deadly = [
        ("connect", "."),
        ("listen", "."),
        ("send", "."),
        ("local", "."),
        ("execute", "/bin/true"),
        ("spawn", "/bin/true"),
    ];
    for (what, path) in deadly {
        let place = place();
        let tried = overcoat(place.path(), &["--sandbox", "attempt", what, path]);
        assert_eq!(tried.status.signal(), Some(SIGSYS), "{what}: {} {}", tried.status, stderr(&tried));
    }
}

#[test]
fn the_attempts_are_real_and_the_work_is_allowed() {
    if !there_is_a_sandbox() {
        return;
    }
    // Without the sandbox all of them succeed (as far as the user may), so the refusals above are the sandbox's.
    for (what, path) in [
        ("read", "/etc/passwd"),
        ("thread", "/etc/passwd"),
        ("write", "other/new"),
        ("truncate", "in/a"),
        ("link", "other/secret"),
        ("remove", "other/secret"),
        ("listen", "."),
        ("local", "."),
        ("spawn", "/bin/true"),
        ("execute", "/bin/true"),
    ] {
        let place = place();
        let tried = overcoat(place.path(), &["attempt", what, path]);
        assert!(tried.status.success(), "{what} {path}: {}", stderr(&tried));
    }
    // With it, what the work needs.
    for (what, path) in [
        ("read", "in/a"),
        ("read", "in/below/b"),
        ("thread", "in/below/b"),
        ("list", "in"),
        ("write", "out/new"),
        ("remove", "out/c"),
    ] {
        let place = place();
        let tried =
            overcoat(place.path(), &["--sandbox", "attempt", what, path, "--input", "in", "--output", "out"]);
        assert!(tried.status.success(), "{what} {path}: {}", stderr(&tried));
    }
}

/// A textured triangle with a material library, an environment, a material and a scene file.
fn models(folder: &Path) {
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    };
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 2, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0, 0, 0, 255]).unwrap();
    let mut sky = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    sky.extend([128, 64, 32, 129].repeat(8));
    write(
        "models/x.obj",
        b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n",
    );
    write("models/m.mtl", b"newmtl a\nmap_Kd textures/t.png\n");
    write("models/textures/t.png", &png);
    write("materials/y.toml", b"base_color_texture = \"t.png\"\ncoat = 1\n");
    write("materials/t.png", &png);
    write("skies/sky.hdr", &sky);
    write(
        "scenes/s.json",
        br#"{"model":"../models/x.obj","env":"../skies/sky.hdr","material":"../materials/y.toml","size":[48,32]}"#,
    );
    fs::create_dir(folder.join("pictures")).unwrap();
}

#[test]
fn pictures_are_the_same_bytes() {
    if !there_is_a_sandbox() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    models(folder);
    let commands: [&[&str]; 10] = [
        &["render", "models/x.obj", "-o", "pictures/p.png", "--size", "40"],
        &["render", "models/x.obj", "-o", "pictures/p.exr", "--size", "40", "--threads", "3"],
        &["render", "models/x.obj", "-o", "pictures/p.png", "--size", "40", "--aov", "depth"],
        &["render", "models/x.obj", "-o", "p.png", "--size", "40", "--env", "skies/sky.hdr"],
        &["render", "models/x.obj", "-o", "p.png", "--size", "40", "--material", "materials/y.toml"],
        &["render", "--scene", "scenes/s.json", "-o", "pictures/p.png"],
        &["sheet", "models/x.obj", "models/x.obj", "-o", "pictures/p.png", "--size", "40"],
        &["compare-models", "models/x.obj", "-o", "p.png", "--size", "16", "--models", "gltf,urp17"],
        &["diff", "models/x.obj", "models/x.obj", "-o", "p.png", "--size", "16"],
        &["materials", "-o", "pictures/p.png", "--size", "16"],
    ];
    for args in commands {
        let output = folder.join(args[args.iter().position(|a| *a == "-o").unwrap() + 1]);
        let free = overcoat(folder, args);
        assert!(free.status.success(), "{args:?}: {}", stderr(&free));
        let expected = fs::read(&output).unwrap();
        fs::remove_file(&output).unwrap();
        let confined = overcoat(folder, &[&["--sandbox"], args].concat());
        assert!(confined.status.success(), "{args:?}: {} {}", confined.status, stderr(&confined));
        assert_eq!(stderr(&confined), stderr(&free), "{args:?}");
        assert!(fs::read(&output).unwrap() == expected, "{args:?}: another picture");
        // Replacing a file is allowed where making one is.
        assert!(overcoat(folder, &[&["--sandbox"], args].concat()).status.success(), "{args:?}");
        let left: Vec<_> =
            fs::read_dir(folder.join("pictures")).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert!(left.iter().all(|name| !name.to_string_lossy().contains(".tmp")), "{left:?}");
    }
    for args in [&["info", "models/x.obj"][..], &["golden", "check", "models/textures", "materials"]] {
        let (free, confined) = (overcoat(folder, args), overcoat(folder, &[&["--sandbox"], args].concat()));
        assert!(
            free.stdout == confined.stdout && free.status == confined.status,
            "{args:?}: {}",
            stderr(&confined)
        );
    }
    // Standard output and the report, whose memory is read from a file that is out of reach.
    let piped = overcoat(folder, &["--sandbox", "render", "models/x.obj", "-o", "-", "--size", "40"]);
    assert!(piped.stdout.starts_with(b"\x89PNG"), "{}", stderr(&piped));
    let args = ["render", "models/x.obj", "-o", "p.png", "--size", "40", "--json", "--sandbox"];
    let report: serde_json::Value = serde_json::from_slice(&overcoat(folder, &args).stdout).unwrap();
    assert!(report["peak_rss_bytes"].as_u64().is_some_and(|bytes| bytes > 1 << 20), "{report}");
}

#[test]
fn a_scene_file_opens_nothing_but_what_it_names() {
    if !there_is_a_sandbox() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    models(place.path());
    // The model's texture is beside the model's folder: the resolver refuses, and so would landlock.
    fs::write(place.path().join("models/m.mtl"), "newmtl a\nmap_Kd ../materials/t.png\n").unwrap();
    fs::write(place.path().join("scenes/s.json"), r#"{"model":"../models/x.obj","env":"none"}"#).unwrap();
    let done = overcoat(place.path(), &["--sandbox", "render", "--scene", "scenes/s.json", "-o", "p.png"]);
    assert!(done.status.success(), "{}", stderr(&done));
    assert!(stderr(&done).contains("leads out of the model's folder"), "{}", stderr(&done));
    // Files that do not exist are still said to be missing, not forbidden.
    let missing = overcoat(place.path(), &["--sandbox", "render", "models/no.obj", "-o", "p.png"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(stderr(&missing).contains("No such file"), "{}", stderr(&missing));
}

/// A folder of files is made in a folder that is there and in one that is not.
#[test]
fn conformance_packs_are_made_in_it() {
    if !there_is_a_sandbox() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    fs::create_dir(place.path().join("there")).unwrap();
    for name in ["there", "new"] {
        let few = ["--size", "32", "--samples", "32", "--scenes", "furnace", "--models", "standard"];
        let done = overcoat(place.path(), &[&["--sandbox", "conformance", name], &few[..]].concat());
        assert!(done.status.success(), "{name}: {}", stderr(&done));
        assert!(place.path().join(name).join("VERSION").is_file());
    }
}
