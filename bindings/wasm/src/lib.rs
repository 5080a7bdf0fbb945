//! overcoat for JavaScript: what `js/engine.js` calls. Bytes and JSON in, typed arrays and JSON out; every decision about
//! pictures is the library's.
//!
//! Nothing of this package is a promise of its own: the interface is that of the npm package, see `README.md`.

mod arrays;
#[cfg(feature = "compare")]
mod compare;
mod files;
mod limits;
mod model;
mod picture;
mod world;
mod world_materials;

use js_sys::Uint8Array;
use overcoat::description::DescriptionError;
use overcoat::frame::{Aov, DisplayImage};
use overcoat::output::{OutputFormat, OutputOptions, encode_image};
use overcoat::world::WorldError;
use std::fmt::Display;
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// An error of the library as JavaScript has them: one sentence.
fn sentence(error: impl Display) -> JsValue {
    js_sys::Error::new(&error.to_string()).into()
}

/// The same about what was asked for, and not about a file: `js/engine.js` knows it by its name.
fn about_options(error: impl Display) -> JsValue {
    let error = js_sys::Error::new(&error.to_string());
    error.set_name("OptionsError");
    error.into()
}

/// The error of a description, or of a file that it names.
fn of_description(error: DescriptionError) -> JsValue {
    match error {
        DescriptionError::Invalid(_) | DescriptionError::OutOfRange(_) => about_options(error),
        _ => sentence(error),
    }
}

/// The error of a world: a fault of the request, unless a file cannot be brought to a pose.
fn of_world(error: WorldError) -> JsValue {
    match error {
        WorldError::Load(_) => sentence(error),
        _ => about_options(error),
    }
}

/// Planes of the G-buffer by their names.
fn planes(names: &[String]) -> Result<Vec<Aov>, JsValue> {
    let plane = |name: &String| {
        Aov::from_name(name).ok_or_else(|| {
            let known: Vec<&str> = Aov::ALL.iter().map(|plane| plane.name()).collect();
            about_options(format!("aovs: there is no '{name}'; known are {}", known.join(", ")))
        })
    };
    names.iter().map(plane).collect()
}

/// Makes panics errors of JavaScript, which say what has happened; a trap would not. `js/engine.js` knows them by how they
/// begin, and throws the instance away.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|info| wasm_bindgen::throw_str(&format!("panic: {info}"))));
}

/// The version of the library.
#[wasm_bindgen]
#[must_use]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// The instruction set of this module: `simd128` or `scalar`.
#[wasm_bindgen]
#[must_use]
pub fn lanes() -> String {
    overcoat::SimdLevel::best().name().to_owned()
}

/// A picture file of pixels: RGBA, 8 bits, sRGB, straight alpha, row by row from the top. `format` is an extension; quality
/// (1 to 100) is that of JPEG.
///
/// # Errors
/// If there are more or fewer pixels than `width * height`, or the format is unknown or has no 8 bits.
#[wasm_bindgen]
pub fn encode(
    width: u32,
    height: u32,
    pixels: &[u8],
    format: &str,
    quality: u8,
) -> Result<Uint8Array, JsValue> {
    let (pixels, rest) = pixels.as_chunks::<4>();
    if !rest.is_empty() || pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(sentence("a picture has width * height pixels of four bytes"));
    }
    let format = OutputFormat::from_extension(format).filter(|format| !format.is_linear());
    let format = format.ok_or_else(|| sentence("a picture is encoded as png, webp or jpg"))?;
    let image = DisplayImage { width, height, pixels: pixels.to_vec() };
    let mut options = OutputOptions::default();
    options.jpeg_quality = quality;
    let bytes = encode_image(&image, format, &options).map_err(sentence)?;
    Ok(Uint8Array::from(bytes.as_slice()))
}
