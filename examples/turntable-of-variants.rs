//! A turntable of each material variant of a model (of the model as it is, if it has none), as animated pictures.
//!
//! ```sh
//! cargo run --release --example turntable-of-variants -- shoe.glb pictures
//! ```

use overcoat::frame::DisplayOptions;
use overcoat::load::{AnimatedModel, LoadOptions};
use overcoat::output::{MovieFormat, MovieFrame, encode_movie};
use overcoat::scene::Scene;
use overcoat::viewport::Orbit;
use overcoat::{Limits, RenderOptions, Renderer};
use std::error::Error;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

const SIDE: u32 = 192;
const FRAMES: u16 = 24;
const MILLISECONDS: u16 = 100;

/// An animated WebP of a turn around a scene.
fn turn(scene: &Scene, renderer: &mut Renderer) -> Result<Vec<u8>, Box<dyn Error>> {
    let options = RenderOptions::new(SIDE, SIDE);
    let mut orbit = Orbit::around(scene, 1.0);
    let mut frames = Vec::new();
    for _ in 0..FRAMES {
        let rendered = renderer.render_image(scene, &orbit.camera(), &options, &DisplayOptions::default())?;
        frames.push(MovieFrame::new(&rendered.image, MovieFormat::WebP, true)?);
        renderer.recycle_image(rendered.image);
        orbit.turn(TAU / f64::from(FRAMES), 0.0);
    }
    Ok(encode_movie(&frames, &[MILLISECONDS; FRAMES as usize])?)
}

/// Writes a picture for each variant. Returns their paths.
fn write(model: &Path, folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let (limits, mut renderer) = (Limits::default(), Renderer::builder().build()?);
    let options = LoadOptions::default();
    let names: Vec<Option<String>> = {
        let read = AnimatedModel::open(model, &options, &limits, renderer.jobs())?;
        let names: Vec<_> = read.variants().map(|name| Some(name.to_owned())).collect();
        if names.is_empty() { vec![None] } else { names }
    };
    std::fs::create_dir_all(folder)?;
    let mut written = Vec::new();
    for (number, variant) in names.into_iter().enumerate() {
        let loaded = overcoat::load::load_file_with(
            model,
            &options.clone().with_variant(variant),
            &limits,
            renderer.jobs(),
        )?;
        loaded.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
        // Names of variants are the file's; those of pictures are numbers.
        let path = folder.join(format!("{number}.webp"));
        std::fs::write(&path, turn(&loaded.scene, &mut renderer)?)?;
        written.push(path);
    }
    Ok(written)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, folder] = &arguments[..] else { return Err("turntable-of-variants MODEL FOLDER".into()) };
    for path in write(Path::new(model), Path::new(folder))? {
        println!("{}", path.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle that is red in one variant and green in the other.
    const MODEL: &str = r#"{
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "extensionsUsed": ["KHR_materials_variants", "KHR_materials_unlit"],
        "extensions": { "KHR_materials_variants": { "variants": [{ "name": "red" }, { "name": "green" }] } },
        "materials": [
            { "doubleSided": true, "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1] }, "extensions": { "KHR_materials_unlit": {} } },
            { "doubleSided": true, "pbrMetallicRoughness": { "baseColorFactor": [0, 1, 0, 1] }, "extensions": { "KHR_materials_unlit": {} } }
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0, "extensions": { "KHR_materials_variants": {
            "mappings": [{ "material": 0, "variants": [0] }, { "material": 1, "variants": [1] }] } } }] }],
        "buffers": [{ "byteLength": 36,
            "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }]
    }"#;

    #[test]
    fn each_variant_has_its_turntable() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("model.gltf");
        std::fs::write(&model, MODEL).unwrap();
        let written = write(&model, &folder.path().join("pictures")).unwrap();
        assert_eq!(written.len(), 2);
        let [red, green] = [&written[0], &written[1]].map(|path| std::fs::read(path).unwrap());
        assert!(red.starts_with(b"RIFF") && green.starts_with(b"RIFF") && red != green);
    }
}
