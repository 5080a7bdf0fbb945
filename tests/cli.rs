//! Runs the program as a user does: exit codes, messages, what is written and what is not.

#[path = "cli/bench.rs"]
mod bench;
#[path = "cli/cache.rs"]
mod cache;
#[path = "cli/conformance.rs"]
mod conformance;
#[path = "cli/converters.rs"]
mod converters;
#[path = "cli/diagnose.rs"]
mod diagnose;
#[path = "cli/diff.rs"]
mod diff;
#[path = "cli/error_format.rs"]
mod error_format;
#[path = "cli/guide.rs"]
mod guide;
#[path = "cli/info.rs"]
mod info;
#[path = "cli/install.rs"]
mod install;
#[path = "cli/json.rs"]
mod json;
#[path = "cli/lab.rs"]
mod lab;
#[path = "cli/materials.rs"]
mod materials;
#[path = "cli/measured.rs"]
mod measured;
#[path = "cli/mistakes.rs"]
mod mistakes;
#[path = "cli/nothing_to_see.rs"]
mod nothing_to_see;
#[path = "cli/outputs.rs"]
mod outputs;
#[path = "cli/scene_file.rs"]
mod scene_file;
#[path = "cli/sheet.rs"]
mod sheet;
#[path = "cli/thumbnail.rs"]
mod thumbnail;
#[path = "cli/translate.rs"]
mod translate;
#[path = "cli/views.rs"]
mod views;

use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// Runs the program in a folder.
fn overcoat(folder: &Path, args: &[&str]) -> Output {
    overcoat_with_input(folder, args, b"")
}

/// Runs the program in a folder with something on standard input.
fn overcoat_with_input(folder: &Path, args: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_overcoat"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that does not read its input closes the pipe; that is its right.
    let _ = child.stdin.take().unwrap().write_all(input);
    child.wait_with_output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A folder with a valid model, `quad.glb`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("quad.glb"), glb(&quad(), &quad_buffer())).unwrap();
    folder
}

/// Names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

const QUAD: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];

/// Positions, then indices.
fn quad_buffer() -> Vec<u8> {
    let mut bytes: Vec<u8> = QUAD.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// A red quad of two triangles that faces +Z, with one camera.
fn quad() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}],
        "cameras": [{"name": "eye", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {
            "baseColorFactor": [0.8, 0.0, 0.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12}
        ],
        "buffers": [{"byteLength": 60}]
    })
}

/// A binary glTF file.
fn glb(json: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = buffer.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut out = b"glTF".to_vec();
    let word = |out: &mut Vec<u8>, v: usize| out.extend((v as u32).to_le_bytes());
    word(&mut out, 2);
    word(&mut out, 12 + 8 + text.len() + 8 + binary.len());
    word(&mut out, text.len());
    out.extend(b"JSON");
    out.extend(text);
    word(&mut out, binary.len());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

/// A PNG file that claims a size and has hardly any data.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[0x78, 0x9c]).unwrap();
    bytes
}

/// Size and RGBA pixels of a PNG file.
fn read_png(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::ALPHA);
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

/// Red, green and blue of the pixel in the middle of a 16 x 16 picture.
fn middle(folder: &Path, name: &str) -> [u8; 3] {
    let (_, _, pixels) = read_png(&fs::read(folder.join(name)).unwrap());
    let at = 4 * (8 * 16 + 8);
    [pixels[at], pixels[at + 1], pixels[at + 2]]
}

#[test]
fn a_model_becomes_a_picture() {
    let folder = folder();
    let output = overcoat(folder.path(), &["render", "quad.glb", "-o", "quad.png", "--size", "64x48"]);
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
    assert!(output.stdout.is_empty());
    let (width, height, pixels) = read_png(&fs::read(folder.path().join("quad.png")).unwrap());
    assert_eq!((width, height), (64, 48));
    let center = &pixels[4 * (24 * 64 + 32)..][..4];
    assert!(center[0] > 60 && center[0] / 2 > center[1] && center[3] == 255, "{center:?}");
    assert_eq!(&pixels[..4], &[0; 4], "the corner is not transparent");
    assert_eq!(names(folder.path()), ["quad.glb", "quad.png"]);
}

#[test]
fn pipes_carry_models_in_and_pictures_out() {
    let folder = folder();
    let model = fs::read(folder.path().join("quad.glb")).unwrap();
    let to_file = overcoat(folder.path(), &["render", "quad.glb", "-o", "out.png", "--size", "32"]);
    assert_eq!(to_file.status.code(), Some(0));
    let file = fs::read(folder.path().join("out.png")).unwrap();
    for format in [None, Some("glb")] {
        let mut args = vec!["render", "-", "-o", "-", "--size", "32"];
        args.extend(format.iter().flat_map(|f| ["--format", f]));
        let piped = overcoat_with_input(folder.path(), &args, &model);
        assert_eq!(piped.status.code(), Some(0), "{}", stderr(&piped));
        assert!(piped.stdout == file, "the pipe's picture differs from the file's");
    }
    let exr =
        overcoat(folder.path(), &["render", "quad.glb", "-o", "-", "--output-format", "exr", "--size", "8"]);
    assert_eq!(&exr.stdout[..4], &[0x76, 0x2f, 0x31, 0x01]);

    let empty = overcoat_with_input(folder.path(), &["render", "-", "-o", "-"], b"");
    assert_eq!(empty.status.code(), Some(1));
    assert!(stderr(&empty).contains("standard input") && empty.stdout.is_empty(), "{}", stderr(&empty));
    // A model read from a pipe has no folder to read more from.
    let mut outside = quad();
    outside["buffers"][0]["uri"] = json!("quad.bin");
    let text = outside.to_string();
    let refused = overcoat_with_input(folder.path(), &["render", "-", "-o", "-"], text.as_bytes());
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("quad.bin"), "{}", stderr(&refused));
    // Two things do not fit into one pipe.
    let both = overcoat(folder.path(), &["render", "quad.glb", "-o", "-", "--json"]);
    assert_eq!(both.status.code(), Some(2));
}

#[test]
fn help_has_examples_and_version_is_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let help = overcoat(folder.path(), &["--help"]);
    assert_eq!(help.status.code(), Some(0));
    assert!(String::from_utf8(help.stdout).unwrap().contains("overcoat car.glb"));
    for command in ["render", "info", "sheet", "bench"] {
        let help = overcoat(folder.path(), &[command, "--help"]);
        assert_eq!(help.status.code(), Some(0));
        assert!(String::from_utf8(help.stdout).unwrap().contains("Example"), "{command}");
    }
    let version = overcoat(folder.path(), &["--version"]);
    assert_eq!(
        String::from_utf8(version.stdout).unwrap(),
        format!("overcoat {}\n", env!("CARGO_PKG_VERSION"))
    );
}
