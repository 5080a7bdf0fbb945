//! `--cache`: pictures are the same with it, what is damaged in it is not used, and where it cannot be they are drawn all the same.

use super::{folder, names, overcoat, stderr};
use std::fs;

/// A small environment without compression: a slope, and a lamp.
fn sky() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n".to_vec();
    for k in 0..64 * 32_u32 {
        let (x, y) = (k % 64, k / 64);
        let lamp = (20..26).contains(&x) && (6..10).contains(&y);
        bytes.extend([(200 - 5 * y) as u8, 128, (60 + x) as u8, if lamp { 132 } else { 128 }]);
    }
    bytes
}

#[test]
fn pictures_are_the_same_with_and_without_kept_environments() {
    let work = folder();
    fs::write(work.path().join("sky.hdr"), sky()).unwrap();
    let kept = work.path().join("kept/here");
    let draw = |extra: &[&str]| {
        let args =
            ["render", "quad.glb", "-o", "x.png", "--size", "40", "--env", "sky.hdr", "--background", "env"];
        let output = overcoat(work.path(), &[&args, extra].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        (fs::read(work.path().join("x.png")).unwrap(), stderr(&output))
    };
    let (plain, _) = draw(&[]);
    let (first, said) = draw(&["--cache", "kept/here"]);
    assert_eq!((names(&kept).len(), said.as_str()), (1, ""));
    assert!(first == plain);
    let file = kept.join(&names(&kept)[0]);
    let bytes = fs::read(&file).unwrap();
    let (second, said) = draw(&["--cache", "kept/here"]);
    assert!(second == plain && said.is_empty());

    // Black, if it were believed.
    let mut dark = bytes[..72 + 16].to_vec();
    dark.extend(std::iter::repeat_n(0x7f, 10_000));
    fs::write(&file, &dark).unwrap();
    let (damaged, _) = draw(&["--cache", "kept/here"]);
    assert!(damaged == plain);
    assert!(fs::read(&file).unwrap() == bytes, "what was damaged is replaced");

    // A cache folder that cannot be made.
    fs::write(work.path().join("file"), "x").unwrap();
    let (without, said) = draw(&["--cache", "file"]);
    assert!(without == plain && said.contains("environments are not kept in file"), "{said}");
    assert_eq!(draw(&["--cache", "file", "--quiet"]).1, "");
}

#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn a_sandboxed_program_adds_nothing() {
    let work = folder();
    fs::write(work.path().join("sky.hdr"), sky()).unwrap();
    fs::create_dir(work.path().join("kept")).unwrap();
    fs::create_dir(work.path().join("out")).unwrap();
    let draw = |output: &str, extra: &[&str]| {
        let args =
            ["render", "quad.glb", "-o", output, "--size", "40", "--env", "sky.hdr", "--cache", "kept"];
        overcoat(work.path(), &[&args, extra].concat())
    };
    let output = draw("out/x.png", &["--sandbox"]);
    if stderr(&output).contains("sandbox cannot be set up") {
        return;
    }
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("the environment is not kept"), "{}", stderr(&output));
    assert_eq!(names(&work.path().join("kept")), [""; 0]);
    assert!(draw("out/y.png", &[]).status.success());
    assert_eq!(names(&work.path().join("kept")).len(), 1);
    // It may read.
    let output = draw("out/z.png", &["--sandbox"]);
    assert_eq!((output.status.success(), stderr(&output).as_str()), (true, ""));
}
