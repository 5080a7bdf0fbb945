//! One-sided surfaces that are seen from behind, and so left out: found by a picture in which they have two sides.

use crate::failure::Failure;
use crate::model_source::ModelSource;
use crate::picture_task::PictureTask;
use overcoat_core::frame::Aov;
use overcoat_description::{CameraDescription, DescriptionOption};
use overcoat_render::{Ground, RenderOptions, Renderer};
use overcoat_scene::{Camera, Material, MaterialId, Scene};
use std::collections::BTreeMap;
use std::ffi::OsStr;

/// Share of the object from which on surfaces that are left out are worth a word.
pub(super) const NOTICED: f64 = 0.01;

/// Part by which a surface has to be nearer than another to be before it.
const NEARER: f32 = 1e-4;

/// Longest side of the pictures that views are tried with.
const SIDE: u32 = 64;

/// Share of the pixels of the object, if all surfaces had two sides, that show something else as they have not. `None` if no
/// pixel shows it.
///
/// # Errors
/// [`Failure`] if a limit is passed.
pub(super) fn share(
    options: &RenderOptions,
    renderer: &mut Renderer,
    scene: &mut Scene,
    camera: &Camera,
) -> Result<Option<f64>, Failure> {
    let one_sided = one_sided(scene);
    if one_sided.is_empty() {
        return Ok(Some(0.0));
    }
    let mut options = options.clone();
    options.aovs = vec![Aov::Depth];
    // Depth needs no light.
    (options.visibility.maps, options.visibility.rays, options.ground) = (0, 0, Ground::None);
    let as_it_is = depths(&options, renderer, scene, camera)?;
    let replaced = set_sides(scene, &one_sided, true);
    let both = replaced.and_then(|()| depths(&options, renderer, scene, camera));
    set_sides(scene, &one_sided, false)?;
    let both = both?;
    let all = both.iter().filter(|depth| **depth > 0.0).count();
    let hidden = as_it_is
        .iter()
        .zip(&both)
        .filter(|&(&one, &two)| two > 0.0 && (one == 0.0 || two < one * (1.0 - NEARER)));
    Ok((all > 0).then(|| hidden.count() as f64 / all as f64))
}

/// Name of the first view, of those that have one, from which next to no surface is seen from behind.
///
/// # Errors
/// [`Failure`] if a limit is passed, or no camera sees the model.
pub(super) fn better_view(
    task: &PictureTask,
    source: &ModelSource,
    renderer: &mut Renderer,
    scene: &mut Scene,
) -> Result<Option<&'static str>, Failure> {
    let Some(option) = DescriptionOption::all().find(|option| option.key() == "view") else {
        return Ok(None);
    };
    for name in option.names() {
        let own = &task.description.camera;
        let mut description = task.description.clone();
        description.camera = CameraDescription {
            fov_y_degrees: own.fov_y_degrees,
            orthographic_height: own.orthographic_height,
            ..CameraDescription::default()
        };
        if option.set(&mut description, OsStr::new(name)).is_err() {
            continue;
        }
        let mut options = task.options.clone();
        let longest = options.width.max(options.height).max(1);
        let scaled = |side: u32| (side * SIDE.min(longest) / longest).max(1);
        (options.width, options.height) = (scaled(options.width), scaled(options.height));
        let camera = description.camera(scene, &options).map_err(|error| error.at(&source.path))?;
        if share(&options, renderer, scene, &camera)?.is_some_and(|share| share < NOTICED) {
            return Ok(Some(name));
        }
    }
    Ok(None)
}

/// Materials with one side, by their numbers.
fn one_sided(scene: &Scene) -> BTreeMap<usize, (MaterialId, Material)> {
    let used = scene.instances().iter().map(|instance| instance.material);
    let materials = used.filter_map(|id| Some((id, scene.materials().get(id.index())?)));
    let one_sided = materials.filter(|(_, material)| !material.double_sided);
    one_sided.map(|(id, material)| (id.index(), (id, material.clone()))).collect()
}

/// Gives materials two sides, or what they had.
fn set_sides(
    scene: &mut Scene,
    of: &BTreeMap<usize, (MaterialId, Material)>,
    two_sided: bool,
) -> Result<(), Failure> {
    for (id, material) in of.values() {
        let mut material = material.clone();
        material.double_sided = two_sided;
        scene.replace_material(*id, material).map_err(|e| Failure::scene(&e))?;
    }
    Ok(())
}

/// Distance of the surface in each pixel, 0 where none is.
fn depths(
    options: &RenderOptions,
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &Camera,
) -> Result<Vec<f32>, Failure> {
    let rendered = renderer.render(scene, camera, options).map_err(|e| Failure::render(&e))?;
    let plane = rendered.frame.plane(Aov::Depth).map(|plane| plane.data.clone());
    renderer.recycle(rendered.frame);
    Ok(plane.unwrap_or_default())
}
