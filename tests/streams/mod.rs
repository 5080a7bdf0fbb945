//! Inputs that are no plain files: models, environments, materials and scene files from pipes, and in gzip or
//! Zstandard.

use super::{is_png, names, shell, text};
use flate2::Compression;
use flate2::read::GzEncoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use std::fs;
use std::io::Read;
use std::path::Path;

const MODEL: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    GzEncoder::new(bytes, Compression::fast()).read_to_end(&mut out).unwrap();
    out
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    compress_to_vec(bytes, CompressionLevel::Fastest)
}

/// A model with its materials, an environment, a material and a scene file: each as it is, and packed.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut sky = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    sky.extend([128, 64, 32, 129].repeat(8));
    let scene = br#"{"model": "x.obj", "env": "sky.hdr", "material": "y.toml", "size": [16, 16]}"#;
    for (name, bytes) in [
        ("x.obj", MODEL.as_bytes()),
        ("m.mtl", b"newmtl a\nKd 1 0 0\n"),
        ("sky.hdr", &sky),
        ("y.toml", b"base_color = [0, 1, 0]\n"),
        ("s.json", scene),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
        fs::write(folder.path().join(format!("{name}.gz")), gzip(bytes)).unwrap();
        fs::write(folder.path().join(format!("{name}.zst")), zstd(bytes)).unwrap();
    }
    folder
}

/// The picture of a script's command, and what it says.
fn picture(folder: &Path, command: &str) -> (Vec<u8>, String) {
    let done = shell(folder, &format!("{command} -o p.png --size 16"));
    assert!(done.status.success(), "{command}: {}", text(&done.stderr));
    let bytes = fs::read(folder.join("p.png")).unwrap();
    assert!(is_png(&bytes));
    fs::remove_file(folder.join("p.png")).unwrap();
    (bytes, text(&done.stderr))
}

#[test]
fn what_is_packed_gives_the_same_picture() {
    let folder = folder();
    let at = folder.path();
    let plain = picture(at, "\"$0\" render x.obj");
    for end in ["gz", "zst"] {
        assert_eq!(picture(at, &format!("\"$0\" render x.obj.{end}")), plain);
    }
    let whole = picture(at, "\"$0\" render --scene s.json");
    assert_ne!(whole, plain);
    for (env, material) in [("sky.hdr.gz", "y.toml"), ("sky.hdr.zst", "y.toml"), ("sky.hdr", "./y.toml.gz")] {
        let command = format!("\"$0\" render x.obj.gz --env {env} --material {material}");
        assert_eq!(picture(at, &command), whole, "{command}");
    }
    assert_eq!(picture(at, "\"$0\" render --scene s.json.gz"), whole);
    // All commands read models in one way.
    for command in
        ["sheet x.obj.gz", "turntable x.obj.gz --frames 2", "compare-models x.obj.zst --models gltf"]
    {
        picture(at, &format!("\"$0\" {command}"));
    }
    let info = shell(at, "\"$0\" info x.obj.gz --json");
    assert!(text(&info.stdout).contains("\"obj\""), "{}", text(&info.stdout));
    // Bytes behind the data are warned of; missing ones too.
    let packed = fs::read(at.join("x.obj.gz")).unwrap();
    fs::write(at.join("tail.gz"), [packed.as_slice(), b"junk"].concat()).unwrap();
    let (same, message) = picture(at, "\"$0\" render tail.gz");
    assert!(same == plain.0 && message == "warning: 4 bytes after the gzip data are left out\n", "{message}");
    fs::write(at.join("cut.gz"), &packed[..packed.len() - 6]).unwrap();
    assert!(picture(at, "\"$0\" render cut.gz").1.contains("damaged or cut short"));
}

#[test]
fn a_bomb_is_a_limit() {
    let folder = folder();
    let zeros = vec![b'\n'; 1 << 20];
    for (name, bytes) in [("bomb.gz", gzip(&zeros)), ("bomb.obj.zst", zstd(&zeros))] {
        fs::write(folder.path().join(name), bytes).unwrap();
        let done = shell(folder.path(), &format!("\"$0\" render {name} -o p.png --limit input_bytes=100k"));
        assert_eq!(done.status.code(), Some(3), "{}", text(&done.stderr));
        assert!(text(&done.stderr).contains("(input_bytes)"), "{}", text(&done.stderr));
    }
}

#[test]
fn pipes_are_read_and_have_no_folder() {
    let folder = folder();
    let at = folder.path();
    // Without its materials, which are beside it.
    let plain = picture(at, "\"$0\" render - < x.obj");
    assert!(plain.1.contains("may not refer to other files"), "{}", plain.1);
    for command in [
        "cat x.obj | \"$0\" render /dev/stdin",
        "cat x.obj.gz | \"$0\" render /dev/stdin",
        "\"$0\" render /dev/stdin < x.obj",
        "cat x.obj | { exec 7<&0; \"$0\" render /dev/fd/7; }",
        "\"$0\" render /dev/fd/7 7< x.obj",
    ] {
        let command = command.replace("; }", " -o p.png --size 16; } #");
        assert_eq!(picture(at, &command), plain, "{command}");
    }
    // The environment, the material, the scene file.
    let whole = picture(at, "\"$0\" render x.obj --env sky.hdr --material y.toml");
    for command in [
        "cat sky.hdr | \"$0\" render x.obj --env - --material y.toml",
        "cat y.toml | { exec 7<&0; \"$0\" render x.obj --env sky.hdr --material /dev/fd/7 -o p.png --size 16; } #",
        "cat s.json | \"$0\" render --scene -",
        "cat s.json.gz | { exec 7<&0; \"$0\" render --scene /dev/fd/7 -o p.png --size 16; } #",
    ] {
        assert_eq!(picture(at, command), whole, "{command}");
        let confined = command.replace("\"$0\"", "\"$0\" --sandbox");
        if !text(&shell(at, "\"$0\" --sandbox materials").stderr).contains("no sandbox here") {
            assert_eq!(picture(at, &confined), whole, "{confined}");
        }
    }
    // Folders and devices stay what nobody can draw.
    for (path, part) in
        [("/dev/zero", "not a regular file"), ("/dev/null", "not a regular file"), (".", "a folder")]
    {
        let done = shell(at, &format!("\"$0\" render {path} -o p.png"));
        assert_eq!(done.status.code(), Some(1));
        assert!(text(&done.stderr).contains(part), "{}", text(&done.stderr));
    }
    // One byte more than is allowed.
    let done = shell(at, "yes v 0 0 0 | \"$0\" render /dev/stdin -o p.png --limit input_bytes=1M");
    assert_eq!(done.status.code(), Some(3), "{}", text(&done.stderr));
    assert!(names(at).iter().all(|name| !name.to_string_lossy().contains(".tmp")));
}
