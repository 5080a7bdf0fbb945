//! Model files made in memory, for scenes that show what loaders make of them.

pub mod document;
pub mod draco;
pub mod ktx2;
pub mod package;
// The builder of the loader's own tests.
#[allow(dead_code)]
#[path = "../../gltf/model.rs"]
pub mod model;
// The encoders of the decoder's own tests.
#[allow(dead_code)]
#[path = "../../../crates/load/src/gltf/meshopt/encoder.rs"]
pub mod encoder;
pub mod meshopt;

use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{AnimationChoice, Context, Format, LoadOptions, MemoryResolver, load_bytes_with};
use overcoat::scene::Scene;
use std::error::Error;

/// Loads a file of the named format, with files beside it. What a file of these asks for must be understood: a warning
/// is a mistake here.
pub fn load(
    bytes: &[u8],
    format: Format,
    beside: &MemoryResolver,
    options: &LoadOptions,
) -> Result<Scene, Box<dyn Error>> {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: beside, limits: &limits, jobs: &jobs };
    let loaded = load_bytes_with(bytes, Some(format), options, &context)?;
    match loaded.warnings.first() {
        None => Ok(loaded.scene),
        Some(warning) => Err(warning.message.clone().into()),
    }
}

/// The only animation of a file, at a time in seconds.
pub fn at_time(time: f64) -> LoadOptions {
    let animation = AnimationChoice { name: "0".to_owned(), time, repeat: false };
    LoadOptions::default().with_animation(animation)
}

/// A PNG picture.
pub fn png(image: &overcoat::scene::Image) -> Result<Vec<u8>, Box<dyn Error>> {
    encoded(image, image::ImageFormat::Png)
}

/// A picture in a file format that is without loss.
pub fn encoded(
    picture: &overcoat::scene::Image,
    format: image::ImageFormat,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let texels = picture.texels().as_flattened().to_vec();
    let buffer = image::RgbaImage::from_raw(picture.width(), picture.height(), texels).ok_or("no picture")?;
    let mut bytes = std::io::Cursor::new(Vec::new());
    buffer.write_to(&mut bytes, format)?;
    Ok(bytes.into_inner())
}
