//! Reasons that a picture shows nothing of a scene.

use super::{RenderOptions, RenderStats};
use overcoat_scene::{Bounds, Camera, Instance, Scene};
use overcoat_stages::geometry::View;
use std::fmt;

/// Reason that a picture shows nothing of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unseen {
    /// There is nothing to draw.
    Empty,
    /// Triangles are no more than lines or points, and lines no more than points: as they are, or where a transform has
    /// squeezed them.
    WithoutArea,
    /// Alpha is 0, or below the cutoff, wherever something would be seen.
    Transparent,
    /// Everything is behind the camera, or before its near distance.
    BehindCamera,
    /// Everything is beside the picture.
    BesidePicture,
    /// Everything together is smaller than a pixel.
    SmallerThanPixel,
    /// Everything is one-sided and seen from behind.
    FromBehind,
    /// Everything lies between the samples of the pixels.
    BetweenSamples,
}

impl fmt::Display for Unseen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "the model has no triangles, lines or points",
            Self::WithoutArea => "the model's triangles have no area, its lines no length",
            Self::Transparent => "the model is transparent all over (alpha 0, or below the cutoff)",
            Self::BehindCamera => "all of the model is behind the camera",
            Self::BesidePicture => "all of the model is beside the picture",
            Self::SmallerThanPixel => "all of the model is smaller than a pixel",
            Self::FromBehind => "all of the model is one-sided and seen from behind",
            Self::BetweenSamples => "all that is in the picture is too thin for its pixels",
        })
    }
}

impl RenderStats {
    /// Reason that a picture shows nothing of the scene, if it does not: [`RenderStats::covered`] is 0. Scene, camera
    /// and options are those that it was taken with.
    #[must_use]
    pub fn unseen(&self, scene: &Scene, camera: &Camera, options: &RenderOptions) -> Option<Unseen> {
        (self.covered == 0).then(|| reason(self, scene, camera, options))
    }
}

fn reason(stats: &RenderStats, scene: &Scene, camera: &Camera, options: &RenderOptions) -> Unseen {
    if scene.triangle_count() == 0 && scene.splat_count() == 0 {
        return Unseen::Empty;
    }
    if stats.fragments > 0 || stats.splats_drawn > 0 {
        return Unseen::Transparent;
    }
    if scene.instances().is_empty() {
        return Unseen::BesidePicture;
    }
    let material = |instance: &Instance| &scene.materials()[instance.material.index()];
    let solid: Vec<&Instance> = scene.instances().iter().filter(|i| scene.is_solid(i)).collect();
    if solid.is_empty() {
        return Unseen::WithoutArea;
    }
    let seen: Vec<&Instance> = solid.into_iter().filter(|i| !scene.is_invisible(material(i))).collect();
    if seen.is_empty() {
        return Unseen::Transparent;
    }
    let Ok(view) = View::new(camera, options.width, options.height) else { return Unseen::BetweenSamples };
    let mut places = seen.iter().map(|instance| {
        let bounds = scene.meshes()[instance.mesh.index()].bounds();
        place(&view, bounds, instance)
    });
    let mut all = places.next().unwrap_or(Place::Behind);
    for other in places {
        all = all.with(other);
    }
    match all {
        Place::Behind => Unseen::BehindCamera,
        Place::Beside => Unseen::BesidePicture,
        Place::Box(Bounds { min, max }) if max[0] - min[0] < 1.0 && max[1] - min[1] < 1.0 => {
            Unseen::SmallerThanPixel
        }
        _ if stats.triangles_rasterized == 0 && seen.iter().all(|i| !material(i).double_sided) => {
            Unseen::FromBehind
        }
        _ => Unseen::BetweenSamples,
    }
}

/// Position of a box relative to the screen.
enum Place {
    Behind,
    Beside,
    /// In pixels.
    Box(Bounds),
    /// Behind and before the camera.
    Around,
}

impl Place {
    fn with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Around, _) | (_, Self::Around) => Self::Around,
            (Self::Box(a), Self::Box(b)) => Self::Box(a.union(&b)),
            (Self::Box(a), _) | (_, Self::Box(a)) => Self::Box(a),
            (Self::Beside, _) | (_, Self::Beside) => Self::Beside,
            (Self::Behind, Self::Behind) => Self::Behind,
        }
    }
}

/// Position of an instance's box relative to the screen.
fn place(view: &View, bounds: &Bounds, instance: &Instance) -> Place {
    let half = [f64::from(view.width) * 0.5, f64::from(view.height) * 0.5];
    let corners: [[f64; 3]; 8] = std::array::from_fn(|corner| {
        let p: [f64; 3] =
            std::array::from_fn(|k| if corner >> k & 1 == 1 { bounds.max[k] } else { bounds.min[k] });
        view.project(instance.transform.point(p))
    });
    let near = f64::from(view.near);
    if corners.iter().all(|c| c[2] < near) {
        return Place::Behind;
    }
    let border = |c: &[f64; 3], k: usize| half[k] * if view.perspective { c[2] } else { 1.0 };
    let beyond = |k: usize, sign: f64| corners.iter().all(|c| c[k] * sign > border(c, k));
    if (0..2).any(|k| beyond(k, 1.0) || beyond(k, -1.0)) {
        return Place::Beside;
    }
    if corners.iter().any(|c| c[2] < near) {
        return Place::Around;
    }
    let on_screen = |c: &[f64; 3]| {
        let w = if view.perspective { c[2] } else { 1.0 };
        [c[0] / w, c[1] / w, 0.0]
    };
    let boxes = corners.iter().map(|c| Bounds { min: on_screen(c), max: on_screen(c) });
    Place::Box(boxes.fold(Bounds::EMPTY, |all, one| all.union(&one)))
}
