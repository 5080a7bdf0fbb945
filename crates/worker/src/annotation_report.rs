//! Annotations of each instance, object or material of a picture, as `--json` tells them.

use crate::failure::Failure;
use crate::report::Stages;
use overcoat_core::frame::Frame;
use overcoat_load::Warning;
use overcoat_render::{Annotation, RenderOptions, Renderer};
use overcoat_scene::{Camera, Scene};
use serde::Serialize;
use std::collections::BTreeMap;

/// One number of a plane of identities. Keys but the first two are those of BOP's `scene_gt_info.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnnotationReport {
    id: u32,
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    /// Left, top, width and height in pixels, whatever hides it, also beyond the picture.
    bbox_obj: Option<[f64; 4]>,
    /// Box around the pixels that show it, likewise.
    bbox_visib: Option<[u32; 4]>,
    /// Pixels of the picture that would show it alone; null if they were not counted.
    px_count_all: Option<u64>,
    px_count_visib: u64,
    visib_fract: Option<f64>,
}

impl From<Annotation> for AnnotationReport {
    fn from(of: Annotation) -> Self {
        let visib_fract = of.visible_fraction();
        Self {
            id: of.id,
            name: of.name,
            bbox_obj: of.full_box,
            bbox_visib: of.visible_box,
            px_count_all: of.pixels,
            px_count_visib: of.visible_pixels,
            visib_fract,
        }
    }
}

/// Annotations of all planes of identities of a picture, by the names of the planes; a stage, if there are any. `warnings` learn
/// how many have no pixels of their own, as counting them would take too much.
///
/// # Errors
/// [`Failure`] if the picture was stopped.
pub fn annotations(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    frame: &Frame,
    (stages, warnings): (&mut Stages, &mut Vec<Warning>),
) -> Result<BTreeMap<&'static str, Vec<AnnotationReport>>, Failure> {
    let planes = frame.aovs.iter().filter(|plane| plane.aov.is_identity());
    let annotated = planes.map(|plane| {
        let annotate = || renderer.annotate(scene, camera, options, plane);
        let found = stages.time("annotations", annotate).map_err(|e| Failure::render(&e))?;
        let uncounted = found.iter().filter(|annotation| annotation.pixels.is_none()).count();
        if uncounted > 0 {
            let (plane, all) = (plane.aov.name(), found.len());
            warnings.push(Warning::new(format!(
                "px_count_all and visib_fract of {uncounted} of {all} in {plane} are left out: too many overlap"
            )));
        }
        Ok((plane.aov.name(), found.into_iter().map(AnnotationReport::from).collect()))
    });
    annotated.collect()
}
