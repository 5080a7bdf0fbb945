//! Pictures of a material and of its translation as it was written and read again, and FLIP between them.

use crate::ball;
use crate::failure::Failure;
use overcoat_core::color::srgb::{SRGB8_TO_LINEAR, srgb_to_linear};
use overcoat_core::frame::{DisplayImage, DisplayOptions, Frame};
use overcoat_core::limits::Limits;
use overcoat_description::{Description, Machine};
use overcoat_golden::metrics::flip::{DEFAULT_PIXELS_PER_DEGREE, LinearImage, flip};
use overcoat_load::{Loaded, MaterialFile};
use overcoat_render::Renderer;
use overcoat_scene::{Flakes, Material, MaterialId, Scene, ShadingModel, Texture};
use serde::Serialize;

/// Largest FLIP on a sphere of a translation that is written without `--force`: the sphere is nothing but the material.
const SPHERE_BOUND: f64 = 0.3;

/// Largest FLIP on the file, most of which other materials may be.
const FILE_BOUND: f64 = 0.12;

/// Feature without which a target is refused, however much alike the pictures are: a coat is what paint is.
const COAT: &str = "clear coat";

/// Side of the pictures in pixels.
const SIDE: u64 = 256;

/// FLIP between pictures of the material and of what was written: mean over the pixels that the object covers.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Flip {
    /// On a sphere of radius 1 metre; the largest where several materials were translated.
    pub(super) sphere: f64,
    /// On the glTF file itself, where there is one and it can be drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) file: Option<f64>,
    /// Largest values of both that are written without `--force`.
    pub(super) bounds: [f64; 2],
}

impl Flip {
    pub(super) fn new(sphere: f64, file: Option<f64>) -> Self {
        Self { sphere, file, bounds: [SPHERE_BOUND, FILE_BOUND] }
    }

    /// The lines of a report.
    pub(super) fn told(&self) -> String {
        format!("{:<21} {:>8.4}\n", "FLIP on a sphere", self.sphere) + &self.of_the_file()
    }

    /// The line about the file, if there is one.
    pub(super) fn of_the_file(&self) -> String {
        self.file.map_or_else(String::new, |file| format!("{:<21} {file:>8.4}\n", "FLIP on the file"))
    }

    /// Refuses what looks too different.
    ///
    /// # Errors
    /// [`Failure`] with the number, the bound, and what the goal has no place for.
    pub(super) fn check(&self, what: &str, lacks: &[&str], force: bool) -> Result<(), Failure> {
        let [of_sphere, of_file] = self.bounds;
        let is_above = |value: f64, bound: f64| value > bound || value.is_nan();
        let (value, place, bound) = match self.file {
            Some(file) if is_above(file, of_file) => (file, "on the file", of_file),
            _ => (self.sphere, "on a sphere", of_sphere),
        };
        if force {
            return Ok(());
        }
        if lacks.contains(&COAT) {
            let what = format!("{what}, which has no {COAT}: nothing is written; --force writes it without");
            return Err(Failure::differ(what));
        }
        if !is_above(value, bound) {
            return Ok(());
        }
        let lacks = match lacks {
            [] => String::new(),
            names => format!(", which has no place for {}", names.join(", ")),
        };
        Err(Failure::differ(format!(
            "{what}{lacks}: FLIP {value:.3} {place} is above {bound}, and nothing is written; --force writes it"
        )))
    }
}

/// A scene with a sphere of a material file, shaded by a model.
pub(super) fn sphere_of_file(
    file: &MaterialFile,
    model: ShadingModel,
    limits: &Limits,
) -> Result<Scene, Failure> {
    let mut scene = ball::scene().map_err(|e| Failure::scene(&e))?;
    file.assign(&mut scene, None, limits).map_err(|e| Failure::assign(&e))?;
    shade(&mut scene, |_| model)?;
    Ok(scene)
}

/// A scene with a sphere of a material that reads these textures.
pub(super) fn sphere_of(
    material: &Material,
    textures: &[Texture],
    model: ShadingModel,
) -> Result<Scene, Failure> {
    let mut scene = ball::scene().map_err(|e| Failure::scene(&e))?;
    for texture in textures {
        scene.add_texture(texture.clone()).map_err(|e| Failure::scene(&e))?;
    }
    let material = material.clone().with(|m| m.model = Some(model));
    scene.replace_material(MaterialId::from_index(0), material).map_err(|e| Failure::scene(&e))?;
    Ok(scene)
}

/// Chooses the model of each material of a scene.
pub(super) fn shade(scene: &mut Scene, model: impl Fn(usize) -> ShadingModel) -> Result<(), Failure> {
    for (k, material) in scene.materials().to_vec().into_iter().enumerate() {
        let material = material.with(|m| m.model = Some(model(k)));
        scene.replace_material(MaterialId::from_index(k as u32), material).map_err(|e| Failure::scene(&e))?;
    }
    Ok(())
}

/// Part of their size that flakes have on a sphere: its pixels are as wide as flakes may be, and the mean of many is compared.
const FLAKES: f32 = 0.05;

/// Makes flakes so small that none is seen by itself.
fn shrink_flakes(scene: &mut Scene) -> Result<(), Failure> {
    for (k, material) in scene.materials().to_vec().into_iter().enumerate() {
        if material.lobes.flakes.share > 0.0 {
            let small = (material.lobes.flakes.size * FLAKES).max(Flakes::LEAST_SIZE);
            let material = material.with(|m| m.lobes.flakes.size = small);
            let id = MaterialId::from_index(k as u32);
            scene.replace_material(id, material).map_err(|e| Failure::scene(&e))?;
        }
    }
    Ok(())
}

/// FLIP between two spheres.
pub(super) fn between_spheres(
    scenes: [Scene; 2],
    renderer: &mut Renderer,
    limits: &Limits,
) -> Result<f64, Failure> {
    let description = ball::description([SIDE; 2]);
    let [mut a, mut b] = scenes;
    for scene in [&mut a, &mut b] {
        shrink_flakes(scene)?;
    }
    let [a, b] = [a, b].map(Loaded::from);
    let pictures = [a, b].map(|loaded| picture(loaded, &description, renderer, limits));
    let [a, b] = pictures;
    Ok(difference(&a?, &b?).unwrap_or(0.0))
}

/// FLIP between two scenes of a file; `None` if nothing is seen of it.
pub(super) fn between_files(
    scenes: [Loaded; 2],
    renderer: &mut Renderer,
    limits: &Limits,
) -> Result<Option<f64>, Failure> {
    let description = Description { size: Some([SIDE; 2]), ..Description::default() };
    let [a, b] = scenes.map(|loaded| picture(loaded, &description, renderer, limits));
    Ok(difference(&a?, &b?))
}

/// Pictures of two frames of a sphere, and FLIP between them.
pub(super) fn between_frames(frames: &[Frame; 2]) -> ([DisplayImage; 2], f64) {
    let [a, b] = frames.each_ref().map(|frame| DisplayImage::new(frame, &DisplayOptions::default()));
    let off = difference(&a, &b).unwrap_or(0.0);
    ([a, b], off)
}

fn picture(
    loaded: Loaded,
    description: &Description,
    renderer: &mut Renderer,
    limits: &Limits,
) -> Result<DisplayImage, Failure> {
    let picture = description.picture_of(loaded, Machine::default(), limits, renderer.jobs())?;
    let rendered = renderer
        .render(&picture.scene, &picture.camera, &picture.options)
        .map_err(|e| Failure::render(&e))?;
    Ok(DisplayImage::new(&rendered.frame, &picture.display.metered(&rendered.frame)))
}

/// Mean of FLIP over the pixels that are covered in either, before middle grey.
fn difference(a: &DisplayImage, b: &DisplayImage) -> Option<f64> {
    let map = flip(&linear(a), &linear(b), DEFAULT_PIXELS_PER_DEGREE);
    let (mut sum, mut count) = (0.0, 0_u32);
    for (value, (a, b)) in map.iter().zip(a.pixels.iter().zip(&b.pixels)) {
        if a[3] > 0 || b[3] > 0 {
            sum += f64::from(*value);
            count += 1;
        }
    }
    (count > 0).then(|| sum / f64::from(count))
}

/// The picture laid over grey.
fn linear(image: &DisplayImage) -> LinearImage {
    let grey = srgb_to_linear(128.0 / 255.0);
    let pixels = image
        .pixels
        .iter()
        .map(|&[r, g, b, alpha]| {
            let alpha = f32::from(alpha) / 255.0;
            [r, g, b].map(|code| SRGB8_TO_LINEAR[usize::from(code)] * alpha + grey * (1.0 - alpha))
        })
        .collect();
    LinearImage { width: image.width as usize, height: image.height as usize, pixels }
}
