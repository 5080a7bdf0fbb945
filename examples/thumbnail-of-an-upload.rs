//! A thumbnail of bytes that nobody has looked at: what a server does with an upload.
//!
//! ```sh
//! cargo run --release --example thumbnail-of-an-upload < model.glb > thumbnail.png
//! ```
//!
//! Bounds on what a file may ask for are counts, so that the same upload ends in the same way everywhere. Memory and time of the
//! process are the system's: `overcoat thumbnail` and `overcoat-service` bound those too, in a process without rights.

use overcoat::frame::DisplayOptions;
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, NoResolver, load_bytes};
use overcoat::output::encode_png;
use overcoat::scene::Framing;
use overcoat::{RenderOptions, Renderer};
use std::error::Error;
use std::io::{Read, Write};

/// A PNG file of `side` x `side` pixels on white, and warnings about what it lacks.
fn thumbnail(upload: &[u8], side: u32) -> Result<(Vec<u8>, Vec<String>), Box<dyn Error>> {
    let limits =
        Limits::default().with_decoded_bytes(256 << 20).with_triangles(4 << 20).with_shading(4 << 10);
    let jobs = Jobs::new(1);
    // A model from memory reaches no other file, whatever it says.
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    let loaded = load_bytes(upload, None, &context)?;
    let mut warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    let camera = Framing::automatic(&loaded.scene).camera(&loaded.scene);
    let options = RenderOptions::new(side, side).with_limits(limits);
    let mut display = DisplayOptions::default();
    display.background = Some([255; 3]);
    let drawn = Renderer::new(1).render_image(&loaded.scene, &camera, &options, &display)?;
    warnings.extend(drawn.stats.reduced_light.map(|light| light.to_string()));
    Ok((encode_png(&drawn.image)?, warnings))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut upload = Vec::new();
    // One byte more than is allowed shows that it is too long.
    let most = Limits::default().input_bytes;
    std::io::stdin().lock().take(most + 1).read_to_end(&mut upload)?;
    if upload.len() as u64 > most {
        return Err("the upload is too long".into());
    }
    let (png, warnings) = thumbnail(&upload, 256)?;
    warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    std::io::stdout().write_all(&png)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uploads_become_pictures_or_one_line() {
        let model = include_bytes!("../assets/models/rounded-cube.glb");
        let (png, warnings) = thumbnail(model, 32).unwrap();
        assert!(png.starts_with(b"\x89PNG") && warnings.is_empty(), "{warnings:?}");
        for broken in [&b""[..], b"no model", &model[..200]] {
            let message = thumbnail(broken, 32).unwrap_err().to_string();
            assert!(!message.is_empty() && !message.contains('\n'), "{message}");
        }
    }
}
