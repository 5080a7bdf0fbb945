//! From a file to pixels in ten lines.
//!
//! ```sh
//! cargo run --release --example file-to-pixels -- model.glb
//! ```

use overcoat::frame::{DisplayImage, DisplayOptions};
use overcoat::scene::Framing;
use overcoat::{RenderOptions, Renderer};
use std::error::Error;

/// 8-bit sRGB pixels with straight alpha of the model in a file.
fn picture(path: &str, width: u32, height: u32) -> Result<DisplayImage, Box<dyn Error>> {
    let loaded = overcoat::load::model(path)?;
    loaded.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    let aspect = width as f32 / height as f32;
    let camera = Framing::automatic(&loaded.scene).with_aspect(aspect).camera(&loaded.scene);
    let options = RenderOptions::new(width, height);
    let mut renderer = Renderer::builder().build()?;
    let rendered = renderer.render_image(&loaded.scene, &camera, &options, &DisplayOptions::default())?;
    Ok(rendered.image)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "assets/models/rounded-cube.glb".to_owned());
    let image = picture(&path, 64, 32)?;
    // A character for each pixel: those that nothing covers stay free, bright ones are full.
    for row in image.rows() {
        let shade = |&[r, g, b, a]: &[u8; 4]| match (a, r.max(g).max(b)) {
            (0..128, _) => ' ',
            (_, 0..64) => '.',
            (_, 64..128) => '+',
            (_, 128..192) => 'x',
            _ => '#',
        };
        println!("{}", row.iter().map(shade).collect::<String>());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_is_in_the_middle_of_the_picture() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models/rounded-cube.glb");
        let image = picture(path, 48, 32).unwrap();
        assert_eq!((image.pixel(24, 16).unwrap()[3], image.pixel(0, 0)), (255, Some([0; 4])));
        assert_eq!(image.as_bytes().len(), 48 * 32 * 4);
    }
}
