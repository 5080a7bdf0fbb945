//! A finished picture.

use crate::sentence;
use js_sys::{Float32Array, Uint8ClampedArray, Uint32Array};
use overcoat::Frame;
use overcoat::frame::{Aov, DisplayImage, DisplayOptions};
use overcoat::load::Warning;
use overcoat::render::Rendered;
use overcoat::scene::CameraMatrices;
use serde_json::json;
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// A picture, linear and for a screen. Each plane is copied out once, when it is asked for.
#[wasm_bindgen]
pub struct Picture {
    frame: Frame,
    camera: CameraMatrices,
    image: DisplayImage,
    warnings: Vec<String>,
}

impl Picture {
    pub(crate) fn new(
        Rendered { frame, camera, .. }: Rendered,
        display: &DisplayOptions,
        warnings: Vec<Warning>,
    ) -> Self {
        let image = DisplayImage::new(&frame, &display.metered(&frame));
        let warnings = warnings.into_iter().map(|warning| warning.message).collect();
        Self { frame, camera, image, warnings }
    }
}

#[wasm_bindgen]
impl Picture {
    /// Width in pixels.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn width(&self) -> u32 {
        self.image.width
    }

    /// Height in pixels.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn height(&self) -> u32 {
        self.image.height
    }

    /// The camera that it was taken with, in the coordinates of the file: a JSON object with `kind`, the matrix `K` and the poses
    /// `world_to_camera` (OpenCV) and `camera_to_world` (OpenGL) by rows, `near`, and `far`, null without a limit.
    #[must_use]
    pub fn camera(&self) -> String {
        let CameraMatrices { width, height, k, world_to_camera, camera_to_world, near, far, .. } =
            self.camera;
        // Digits of single precision, no more.
        let decimal = |v: f32| v.to_string().parse::<f64>().ok().filter(|v| v.is_finite());
        json!({
            "kind": if self.camera.perspective { "perspective" } else { "orthographic" },
            "width": width,
            "height": height,
            "K": k,
            "world_to_camera": world_to_camera,
            "camera_to_world": camera_to_world,
            "near": decimal(near),
            "far": decimal(far),
        })
        .to_string()
    }

    /// The hash of the linear frame, as the command prints it.
    #[must_use]
    pub fn hash(&self) -> String {
        self.frame.frame_hash()
    }

    /// Features that the model asks for and the picture does not show.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// RGBA, 8 bits, sRGB, straight alpha, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> Uint8ClampedArray {
        Uint8ClampedArray::from(self.image.as_bytes())
    }

    /// RGBA, linear Rec. 709, premultiplied, row by row from the top.
    #[must_use]
    pub fn linear(&self) -> Float32Array {
        Float32Array::from(self.frame.pixels.as_flattened())
    }

    /// A plane of the G-buffer that was asked for when the picture was drawn: its numbers, pixel by pixel, a `Float32Array`, or of
    /// identities a `Uint32Array`.
    ///
    /// # Errors
    /// If it was not asked for.
    pub fn plane(&self, name: &str) -> Result<JsValue, JsValue> {
        let plane = Aov::from_name(name).and_then(|aov| self.frame.plane(aov));
        let plane = plane.ok_or_else(|| sentence(format!("aovs: '{name}' was not drawn")))?;
        Ok(match plane.aov.is_identity() {
            true => Uint32Array::from(plane.ids.as_slice()).into(),
            false => Float32Array::from(plane.data.as_slice()).into(),
        })
    }
}
