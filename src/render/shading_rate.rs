//! Which surfaces are shaded more than once a pixel.
//!
//! Asked for a rate above one, a picture has it where one shading a pixel shows: highlights that are sharper than what normals
//! turn within a pixel, textures that are not averaged when they shrink, alpha masks and normal maps under a shine. The rest,
//! most of most pictures, is shaded once. Decided triangle by triangle of material, screen and vertices alone.

use super::options::RenderOptions;
use super::pass::FrameContext;
use super::tile_triangles::TileTriangles;
use crate::gbuffer::{Draw, SourceTriangle, TriangleSource};
use crate::raster::SUBPIXELS;
use crate::scene::{AlphaMode, Filter, Material, MipFilter, Texture, Workflow};

/// When triangles of one material are shaded more than once a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Finer {
    /// Never.
    Never,
    /// Always.
    Always,
    /// Where normals turn by more than this a pixel: the square of the length of their change.
    WhereNormalsTurn(f32),
}

/// Normals that turn by this share of the width of a highlight (its alpha) a pixel move it by so much that it shows.
const SHARE_OF_LOBE: f32 = 0.25;

/// The least alpha that counts: sharper reflections are smooth again as far as the environment is.
const LEAST_ALPHA: f32 = 0.04;

/// From this perceptual roughness on, normal maps have no highlights that are narrower than their texels' turns.
const MATT: f32 = 0.6;

impl Finer {
    /// Of a material of the scene.
    fn of(material: &Material, textures: &[Texture]) -> Self {
        let unfiltered = |texture: &Texture| {
            let sampler = texture.sampler();
            sampler.minification == Filter::Nearest || sampler.mip == MipFilter::None
        };
        let mut read = material.textures().map(|place| &textures[place.texture.index()]);
        if matches!(material.alpha_mode, AlphaMode::Mask { .. }) || read.any(unfiltered) {
            return Self::Always;
        }
        if material.unlit {
            return Self::Never;
        }
        let (roughness, textured) = match &material.workflow {
            Workflow::MetallicRoughness { roughness, texture, .. } => (*roughness, texture.is_some()),
            Workflow::SpecularGlossiness { glossiness, texture, .. } => {
                (1.0 - *glossiness, texture.is_some())
            }
        };
        // A texture only makes metallic surfaces smoother and glossy ones rougher.
        let base = if textured { 0.0 } else { roughness };
        let least = if material.coat > 0.0 && material.coat_roughness < base {
            material.coat_roughness
        } else {
            base
        };
        if material.has_normal_maps() && least < MATT {
            return Self::Always;
        }
        let alpha = least * least;
        let turn = SHARE_OF_LOBE * if alpha > LEAST_ALPHA { alpha } else { LEAST_ALPHA };
        Self::WhereNormalsTurn(turn * turn)
    }

    /// Those of all materials of a scene, in their order, in place of what was there: none at a rate of one.
    pub(super) fn list(
        materials: &[Material],
        textures: &[Texture],
        options: &RenderOptions,
        out: &mut Vec<Self>,
    ) {
        out.clear();
        if options.shading_rate > 1 {
            let of = |material| {
                if options.shade_everywhere { Self::Always } else { Self::of(material, textures) }
            };
            out.extend(materials.iter().map(of));
        }
    }
}

/// Whether the fragments of a triangle or point are shaded more than once a pixel. The rate is above one.
#[inline(never)]
pub(super) fn is_finer(frame: &FrameContext<'_>, triangles: &TileTriangles<'_>, identity: u32) -> bool {
    let (chunk, index) = triangles.identities[identity as usize];
    let chunk = &frame.chunks[chunk as usize];
    let draw = &frame.shade.draws[chunk.draw as usize];
    let finer = frame.finer[draw.material as usize];
    if finer == Finer::Never || (chunk.points && finer != Finer::Always) {
        // Points have one normal each.
        return false;
    }
    // Where triangles are merged, one answers for the pixel.
    if frame.merge.is_some() && !chunk.points && chunk.triangles[index as usize].small_samples != 0 {
        return false;
    }
    match finer {
        Finer::Never => false,
        Finer::Always => true,
        // True as well where the change is no number.
        Finer::WhereNormalsTurn(most) => !(normal_change(draw, &triangles.triangle(identity)) <= most),
    }
}

/// The square of how far the unit normal of a triangle moves from pixel to pixel, along the axis along which it is more: of its
/// plane on the screen, perspective left out.
fn normal_change(draw: &Draw<'_>, source: &SourceTriangle<'_>) -> f32 {
    let SourceTriangle { screen, clip, .. } = source;
    let [a, b, c] = screen.vertices();
    let unit = |vertex: u32| {
        let v = draw.mesh.shading_normals().get(vertex as usize).copied().unwrap_or_default();
        let square = dot(v, v);
        if square > 0.0 { v.map(|x| x / square.sqrt()) } else { v }
    };
    let own = [a, b, c].map(unit);
    let between = |at: &[f32; 2]| {
        std::array::from_fn(|k| {
            own[0][k] + at[0] * (own[1][k] - own[0][k]) + at[1] * (own[2][k] - own[0][k])
        })
    };
    let mut normals = match clip {
        Some(corners) => corners.each_ref().map(between),
        None => own,
    };
    if screen.is_swapped() {
        normals.swap(1, 2);
    }
    // In pixels.
    let side = |to: i32, from: i32| (to - from) as f32 * (1.0 / SUBPIXELS as f32);
    let [x1, x2] = [1, 2].map(|k| side(screen.x[k], screen.x[0]));
    let [y1, y2] = [1, 2].map(|k| side(screen.y[k], screen.y[0]));
    let area = x1 * y2 - x2 * y1;
    let turn = |u: f32, v: f32| {
        let change: [f32; 3] = std::array::from_fn(|k| {
            ((normals[1][k] - normals[0][k]) * u + (normals[2][k] - normals[0][k]) * v) / area
        });
        dot(change, change)
    };
    let (across, down) = (turn(y2, -y1), turn(-x2, x1));
    if across > down { across } else { down }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}
