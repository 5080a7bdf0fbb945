//! One default: whoever asks for nothing but a size gets the same picture of the same file at every door. Its hash is in
//! `tests/default-picture.txt`; here the library's two ways, scene files and the program are held against it, and in their own tests
//! the service (`service/tests/serve/pictures.rs`), Python, C and JavaScript (`bindings/`).

use overcoat::description::{Description, Machine};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::load_file;
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{Camera, Framing, Scene};
use std::path::Path;
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
const SIZE: (u32, u32) = (96, 64);

/// Model, size and hash of the frame.
fn expected() -> String {
    let text = std::fs::read_to_string(Path::new(ROOT).join("tests/default-picture.txt")).unwrap();
    let [model, size, hash] = text.split_whitespace().collect::<Vec<_>>().try_into().unwrap();
    assert_eq!((model, size), ("assets/models/rounded-cube.glb", "96x64"));
    hash.to_owned()
}

fn model() -> std::path::PathBuf {
    Path::new(ROOT).join("assets/models/rounded-cube.glb")
}

fn hash(scene: &Scene, camera: &Camera, options: &RenderOptions) -> String {
    Renderer::new(2).render(scene, camera, options).unwrap().frame.frame_hash()
}

#[test]
fn the_library() {
    let scene = load_file(&model(), &Limits::default(), &Jobs::new(1)).unwrap().scene;
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let camera = Framing::automatic(&scene).with_aspect(aspect).camera(&scene);
    assert_eq!(hash(&scene, &camera, &RenderOptions::new(SIZE.0, SIZE.1)), expected());
}

#[test]
fn descriptions_and_scene_files() {
    let mut described = Description::default();
    (described.model, described.size) = (Some(model()), Some([SIZE.0.into(), SIZE.1.into()]));
    let text = format!("size = [{}, {}]", SIZE.0, SIZE.1);
    let mut read = Description::from_toml(&text).unwrap();
    read.model = Some(model());
    for description in [described, read] {
        let picture = description.picture(Machine::default(), &Limits::default(), &Jobs::new(1)).unwrap();
        assert_eq!(hash(&picture.scene, &picture.camera, &picture.options), expected());
    }
}

#[test]
fn the_program() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_overcoat"))
        .args(["render", "--size", "96x64", "--json", "-o"])
        .args([&folder.path().join("car.png"), &model()])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["frame_hash"], expected());
}
