//! `overcoat-embedded IN OUT [SIDE]`: a square PNG of a glTF or STL file.
//!
//! Calls for a device that has a few megabytes to spare: one thread, no command line library, limits that fit.

use overcoat::Renderer;
use overcoat::frame::DisplayOptions;
use overcoat::load::{LoadOptions, TextureLoading, load_file_with};
use overcoat::output::{encode_png, write_atomically};
use overcoat::scene::Framing;
use overcoat::{Limits, RenderOptions};
use std::path::Path;
use std::process::ExitCode;

/// Limits for untrusted models on a small device.
fn limits() -> Limits {
    let mut limits = Limits::default();
    (limits.input_bytes, limits.decoded_bytes) = (64 << 20, 64 << 20);
    (limits.triangles, limits.vertices) = (1 << 20, 1 << 20);
    (limits.texture_pixels, limits.total_texture_pixels) = (1 << 24, 1 << 25);
    limits
}

/// Draws the model in a file. The error is one line.
fn thumbnail(input: &Path, output: &Path, side: u32) -> Result<(), String> {
    let mut renderer = Renderer::new(1);
    let loading = LoadOptions::default().with_textures(TextureLoading::ByNeed);
    let loaded = load_file_with(input, &loading, &limits(), renderer.jobs()).map_err(|e| e.to_string())?;
    let scene = &loaded.scene;
    let camera = Framing::automatic(scene).camera(scene);
    let options = RenderOptions::draft(side, side).with_limits(limits());
    let display = DisplayOptions::default();
    let drawn = renderer.render_image(scene, &camera, &options, &display).map_err(|e| e.to_string())?;
    for warning in loaded.warnings.iter().map(ToString::to_string).chain(scene.texture_losses()) {
        eprintln!("warning: {warning}");
    }
    if let Some(unseen) = drawn.stats.unseen(scene, &camera, &options) {
        return Err(format!("nothing to see: {unseen}"));
    }
    let bytes = encode_png(&drawn.image).map_err(|e| e.to_string())?;
    write_atomically(output, &bytes).map_err(|e| e.to_string())
}

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let (input, output, side) = match arguments.as_slice() {
        [input, output] => (input, output, Some(256)),
        [input, output, side] => (input, output, side.to_str().and_then(|side| side.parse().ok())),
        _ => (&Default::default(), &Default::default(), None),
    };
    let Some(side) = side else {
        eprintln!(
            "usage: overcoat-embedded IN OUT [SIDE]   a PNG of a .glb, .gltf or .stl file, 256 pixels wide"
        );
        return ExitCode::from(2);
    };
    match thumbnail(Path::new(input), Path::new(output), side) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("overcoat-embedded: {}: {error}", Path::new(input).display());
            ExitCode::FAILURE
        }
    }
}
