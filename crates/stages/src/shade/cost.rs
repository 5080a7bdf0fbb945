//! Cost of shading a fragment, in units of about a nanosecond: one core of a Zen 5 processor with AVX2.
//!
//! Limits count work by this table and those of the models ([`Model::cost`](super::model::Model::cost)) and not by a clock, so that a file ends in the same way on every machine. The figures
//! were measured as the processor time of whole frames (one square of 512 x 512 pixels, 1 sample, the studio, no lights or
//! 33 points), divided by their fragments: rasterizing, reading attributes and writing the pixel are part of them. They are
//! upper bounds where a material decides: one with any of its lobes costs as if it had all of them, and a texture is counted as
//! if every footprint were as long as [`ShadeContext::anisotropy`] allows.

use super::variation::normal_filter;
use super::{ShadeContext, models, paint};
use overcoat_scene::{AlphaMode, AreaLightMethod, Lobes, Material, ShadingModel};

/// A material without light or textures.
const UNLIT: u64 = 21;

/// One texture, read with one probe; and each probe more.
const TEXTURE: u64 = 14;
const PROBE: u64 = 7;

/// Transmission through a surface, beside its reflection; and that of each light.
const TRANSMISSION: u64 = 205;
const LIGHT_THROUGH: u64 = 3;

/// A rectangle or tube through linearly transformed cosines, and by facets.
const AREA_LIGHT: u64 = 60;
const AREA_LIGHT_BY_FACETS: u64 = 1200;

/// One depth map looked up by a fragment.
const MAP: u64 = 3;

/// Shadow of a light without extent, and of a part of one with extent.
const SHADOW: u64 = 20;
const SHADOW_OF_PART: u64 = 35;

/// A node or leaf that a ray visits, with its share of what sending the ray takes: of a hierarchy that fits into caches, and of
/// one of more than [`CACHED`] bytes.
const VISIT: u64 = 30;
const FAR_VISIT: u64 = 80;
const CACHED: usize = 1 << 24;

/// Rays of a fragment's neighbours, whose light is added to that of its own.
const POOL: u64 = 1500;

/// A hit of a ray, as a multiple of a fragment: few of sixteen have one material, and all are sorted.
const HIT: u64 = 2;

/// Maps that a hit is lit by: a part of them, see [`TracedLight`](super::TracedLight).
const MAPS_OF_HIT: u32 = 32;

/// Roughness that grows where normals vary within a pixel.
const NORMAL_FILTER: u64 = 9;

/// Flakes, orange peel, scratches and swirl marks of a fragment, found; the surfaces that they add are counted as such.
const PAINT: u64 = 60;

/// Sorting and summing a fragment of a blended surface.
const BLENDING: u64 = 90;

/// Alpha masks: one sample of one pixel of a surface that may be there, without its texture.
const MASK: u64 = 7;

/// Cost of fragments of one material, in units of about a nanosecond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadingCost {
    /// Each, in the light of the environment and of all rectangles and tubes.
    pub fragment: u64,
    /// Rays of an opaque fragment, once for all of its parts, without what tracing them takes.
    pub receiving: u64,
    /// A hit of a ray on such a surface.
    pub hit: u64,
    /// Each once more for every light without extent that reaches it.
    pub light: u64,
    /// A fragment that is blended, beside the rest.
    pub blending: u64,
    /// One sample of one pixel whose alpha is held against a cutoff.
    pub mask: u64,
}

impl ShadingCost {
    /// Cost of a material of the scene.
    #[must_use]
    pub fn of(material: &Material, context: &ShadeContext<'_>) -> Self {
        let probes = u64::from(context.anisotropy.clamp(1, 16)) - 1;
        let texture = TEXTURE + PROBE * probes;
        let masked = matches!(material.alpha_mode, AlphaMode::Mask { .. });
        let alpha_texture = if material.base_color_texture.is_some() { texture } else { 0 };
        let mask = if masked { MASK + alpha_texture } else { 0 };
        let textures = texture * material.textures().count() as u64;
        if material.unlit {
            return Self {
                fragment: UNLIT + textures,
                receiving: 0,
                hit: UNLIT + textures,
                light: 0,
                blending: BLENDING,
                mask,
            };
        }
        let model = material.shading(context.model);
        let [plain, layers, light, light_on_layers] = models::cost(model);
        let layered = material.coat > 0.0 || material.lobes != Lobes::default();
        let by_facets =
            model == ShadingModel::GltfSampled || context.area_light_method == AreaLightMethod::Facets;
        let area = if by_facets { AREA_LIGHT_BY_FACETS } else { AREA_LIGHT };
        let (shadow, parts) = match &context.lamps {
            Some(lamps) => (SHADOW, SHADOW_OF_PART * lamps.parts.len() as u64),
            None => (0, 0),
        };
        let (through, light_through) =
            if material.transmits() { (TRANSMISSION, LIGHT_THROUGH) } else { (0, 0) };
        let filter = if normal_filter(context, material).is_some() { NORMAL_FILTER } else { 0 };
        // Its flakes and what scratches and swirl marks leave of its coat are surfaces of their own.
        let surfaces = paint::surfaces(material);
        let painted = if paint::is_painted(material) { PAINT } else { 0 };
        let fragment = surfaces
            * (if layered { layers } else { plain } + area * context.area_lights.len() as u64)
            + painted
            + textures
            + filter
            + through
            + parts
            + MAP * u64::from(context.maps);
        let light = surfaces * if layered { light_on_layers } else { light } + light_through + shadow;
        // The surface is found once more for its rays. What they hit may be reached by all lights.
        let receiving = if context.maps > 0 && context.lobe_rays > 0 { fragment + POOL } else { 0 };
        let left_out = MAP * u64::from(context.maps.saturating_sub(MAPS_OF_HIT));
        let hit = HIT * ((fragment - left_out) + light * context.lights.len() as u64);
        Self { fragment, receiving, hit, light, blending: BLENDING, mask }
    }

    /// Cost of nodes and leaves that rays visit in a hierarchy of so many bytes.
    #[must_use]
    pub fn of_visits(visited: u64, bytes: usize) -> u64 {
        visited.saturating_mul(if bytes > CACHED { FAR_VISIT } else { VISIT })
    }
}
