//! Annotations of a picture, as data sets have them: what it shows of each instance, object or material, by numbers and boxes.
//!
//! The numbers are those of BOP's `scene_gt_info.json` (<https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md>),
//! but that all pixels are those of the picture: what lies outside of it is not counted.

use super::projected_box::ProjectedBox;
use super::{RenderError, RenderOptions, Renderer};
use overcoat_core::frame::{Aov, AovPlane};
use overcoat_scene::{Camera, Scene};
use overcoat_stages::geometry::View;
use std::collections::BTreeMap;

/// Visible and hidden parts of one instance, object or material in a picture.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Annotation {
    /// Number in the plane of identities, at least 1.
    pub id: u32,
    /// Name of the object or material in its file, of an instance that of its object; empty if there is none.
    pub name: String,
    /// Pixels of the plane that show it.
    pub visible_pixels: u64,
    /// Pixels that would show it if nothing else were there; `None` if counting them would take too much.
    pub pixels: Option<u64>,
    /// Box around the pixels that show it: left, top, width and height. `None` if there is no such pixel.
    pub visible_box: Option<[u32; 4]>,
    /// Box around its geometry on the screen, whatever hides it, in pixels from the upper left corner, also beyond the picture: left,
    /// top, width and height. Lines and points count without their width, splats by the box around their cloud. `None` if nothing of
    /// it lies between the near and the far limit.
    pub full_box: Option<[f64; 4]>,
}

impl Annotation {
    /// Part of its pixels that are visible, 0 to 1; 0 if there are none, `None` if they were not counted.
    #[must_use]
    pub fn visible_fraction(&self) -> Option<f64> {
        let fraction = |pixels| if pixels == 0 { 0.0 } else { self.visible_pixels as f64 / pixels as f64 };
        self.pixels.map(fraction)
    }
}

/// Pixels of all passes that draw something alone: 2048 of 512 x 512. A file chooses how many things overlap.
const MOST_PIXELS_ALONE: u64 = 1 << 29;

/// Numbers whose boxes are compared, each with each.
const MOST_COMPARED: usize = 4096;

/// Draws and clouds of splats that have one number in a plane.
#[derive(Default)]
struct Group {
    draws: Vec<usize>,
    splats: Vec<usize>,
}

impl Renderer {
    /// Annotates everything in a picture that its plane of identities has numbers for, whether it is visible or not, by these
    /// numbers.
    ///
    /// Pixels of what may be hidden are counted by drawing it alone: a pass of one sample a pixel without light or shading, for
    /// each whose box on the screen meets that of another, up to 2^29 pixels of all passes together. All pixels of the rest are
    /// visible.
    ///
    /// # Errors
    /// As [`Renderer::render`]; [`RenderError::Option`] if the plane is none of identities or has another size.
    pub fn annotate(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        plane: &AovPlane,
    ) -> Result<Vec<Annotation>, RenderError> {
        self.annotate_within(scene, camera, options, plane, MOST_PIXELS_ALONE)
    }

    /// [`Renderer::annotate`] with so many pixels of all passes that draw something alone.
    fn annotate_within(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        plane: &AovPlane,
        most_pixels: u64,
    ) -> Result<Vec<Annotation>, RenderError> {
        let pixels = u64::from(options.width) * u64::from(options.height);
        if !plane.aov.is_identity() || plane.ids.len() as u64 != pixels {
            let value = format!("{} of {} pixels", plane.aov.name(), plane.len());
            let allowed = "a plane of identities of the picture";
            return Err(RenderError::Option { option: "plane", value, allowed });
        }
        let view = View::new(camera, options.width, options.height)?;
        let groups = groups(scene, plane.aov);
        let mut found: Vec<Annotation> = groups
            .iter()
            .map(|(&id, group)| Annotation {
                id,
                name: name_of(scene, plane.aov, id, group),
                visible_pixels: 0,
                pixels: None,
                visible_box: None,
                full_box: box_of(scene, &view, group),
            })
            .collect();
        count_visible(plane, options.width, &mut found);
        let boxes: Vec<_> = found.iter().map(|annotation| annotation.full_box).collect();
        let mut passes = most_pixels / pixels.max(1);
        for (k, group) in groups.values().enumerate() {
            let is_apart = groups.len() <= MOST_COMPARED
                && boxes.iter().enumerate().all(|(other, of)| k == other || !meet(boxes[k], *of));
            if is_apart {
                found[k].pixels = Some(found[k].visible_pixels);
            } else if passes > 0 {
                passes -= 1;
                found[k].pixels =
                    match self.pixels_alone(scene, camera, options, (plane.aov, found[k].id), group) {
                        Err(RenderError::Limit(_)) => None,
                        counted => Some(counted?),
                    };
            }
        }
        Ok(found)
    }

    /// Pixels that show a group if nothing else is there.
    fn pixels_alone(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        (aov, id): (Aov, u32),
        group: &Group,
    ) -> Result<u64, RenderError> {
        let alone = scene.with_only(
            |place| group.draws.binary_search(&place).is_ok(),
            |place| group.splats.binary_search(&place).is_ok(),
        );
        // Numbers of instances are those of another scene.
        let (aov, id) = if aov == Aov::InstanceId { (aov, 1) } else { (aov, id) };
        let planes = self.render_planes(&alone, camera, &options.clone().with_aovs(vec![aov]))?;
        let ids = planes.iter().flat_map(|plane| &plane.ids);
        Ok(ids.filter(|&&found| found == id).count() as u64)
    }
}

/// Names of all numbers that a plane of identities may show of a scene, empty where the file has none: of an instance that of its
/// object. Empty for other planes.
#[must_use]
pub fn names_of_ids(scene: &Scene, aov: Aov) -> BTreeMap<u32, String> {
    if !aov.is_identity() {
        return BTreeMap::new();
    }
    let groups = groups(scene, aov);
    groups.iter().map(|(&id, group)| (id, name_of(scene, aov, id, group))).collect()
}

/// Draws and clouds of a scene by their numbers in a plane.
fn groups(scene: &Scene, aov: Aov) -> BTreeMap<u32, Group> {
    let mut groups: BTreeMap<u32, Group> = BTreeMap::new();
    for (place, instance) in scene.instances().iter().enumerate() {
        let number = match aov {
            Aov::MaterialId => instance.material.index(),
            Aov::ObjectId => instance.object as usize,
            _ => place,
        };
        // Scenes have no more.
        let id = u32::try_from(number).unwrap_or(u32::MAX).saturating_add(1);
        groups.entry(id).or_default().draws.push(place);
    }
    if aov == Aov::ObjectId {
        for (place, instance) in scene.splat_instances().iter().enumerate() {
            groups.entry(instance.object.saturating_add(1)).or_default().splats.push(place);
        }
    }
    groups
}

/// Name of a group, empty if it has none.
fn name_of(scene: &Scene, aov: Aov, id: u32, group: &Group) -> String {
    let number = id.saturating_sub(1);
    let of_object = |object: u32| scene.object_name(object).unwrap_or_default().to_owned();
    match aov {
        Aov::MaterialId => scene.materials().get(number as usize).map(|m| m.name.clone()).unwrap_or_default(),
        Aov::ObjectId => of_object(number),
        _ => {
            let instance = group.draws.first().and_then(|&place| scene.instances().get(place));
            instance.map(|instance| of_object(instance.object)).unwrap_or_default()
        }
    }
}

/// Box on the screen around a group.
fn box_of(scene: &Scene, view: &View, group: &Group) -> Option<[f64; 4]> {
    let mut found = ProjectedBox::default();
    for &place in &group.draws {
        let instance = &scene.instances()[place];
        found.add_mesh(view, &scene.meshes()[instance.mesh.index()], &instance.transform);
    }
    for &place in &group.splats {
        let instance = &scene.splat_instances()[place];
        found.add_bounds(view, scene.splats()[instance.cloud.index()].bounds(), &instance.transform);
    }
    found.finish(view)
}

/// Counts pixels of each annotation and finds the boxes around them. The annotations are sorted by their numbers.
fn count_visible(plane: &AovPlane, width: u32, found: &mut [Annotation]) {
    let mut ends: Vec<[u32; 4]> = vec![[u32::MAX, u32::MAX, 0, 0]; found.len()];
    // Neighbours often are of one number.
    let mut last = (0, None);
    for (y, row) in (0..).zip(plane.ids.chunks(width.max(1) as usize)) {
        for (x, &id) in (0..).zip(row) {
            if id != last.0 {
                last = (id, found.binary_search_by_key(&id, |annotation| annotation.id).ok());
            }
            let Some(k) = last.1 else { continue };
            found[k].visible_pixels += 1;
            let [left, top, right, bottom] = ends[k];
            ends[k] = [left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)];
        }
    }
    for (annotation, [left, top, right, bottom]) in found.iter_mut().zip(ends) {
        annotation.visible_box = (left < right).then(|| [left, top, right - left, bottom - top]);
    }
}

/// Width of the widest lines and points in pixels: boxes do not count it.
const MARGIN: f64 = 64.0;

/// True if things with these boxes may have a pixel in common.
fn meet(a: Option<[f64; 4]>, b: Option<[f64; 4]>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return false };
    (0..2).all(|k| a[k] - MARGIN < b[k] + b[k + 2] && b[k] - MARGIN < a[k] + a[k + 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::{Framing, Instance, Material, Transform, primitives};

    /// Overlapping things are counted as long as passes remain, all others always.
    #[test]
    fn passes_are_bounded() {
        let mut scene = Scene::new();
        let ball = scene.add_mesh(primitives::sphere(0.4, 12).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        for (k, x) in [0.0, 0.3, 3.0].into_iter().enumerate() {
            let place = Transform::translation([x, 0.0, 0.0]).unwrap();
            scene.add_instance(Instance::new(ball, material, place).with_object(k as u32)).unwrap();
        }
        let camera = Framing::default().with_direction([0.0, 0.0, 1.0]).camera(&scene);
        let options = RenderOptions::draft(256, 256).with_aovs(vec![Aov::ObjectId]);
        let mut renderer = Renderer::new(1);
        let planes = renderer.render_planes(&scene, &camera, &options).unwrap();
        for (passes, expected) in [(0, [false, false, true]), (1, [true, false, true]), (2, [true; 3])] {
            let found =
                renderer.annotate_within(&scene, &camera, &options, &planes[0], passes * 256 * 256).unwrap();
            assert_eq!(
                found.iter().map(|a| a.pixels.is_some()).collect::<Vec<_>>(),
                expected,
                "{passes}: {found:?}"
            );
        }
    }
}
