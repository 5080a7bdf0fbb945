//! Clay: what a model is made of whose file says nothing of it.

use overcoat_scene::{Material, Workflow};

/// Its colour, linear: sRGB #b8b0a8, a warm light grey.
///
/// A white page, a grey one and a black one are each another tone and another tint, so that the outline is seen before all of
/// them; in the light of the studio its shades span most of what lies between.
const COLOR: [f32; 4] = [0.479, 0.434, 0.392, 1.0];

/// Its perceptual roughness: a sheen that tells which way surfaces lean, and no mirror.
const ROUGHNESS: f32 = 0.6;

/// The material of surfaces in files that have none at all.
pub(super) fn clay() -> Material {
    Material::default().with(|m| {
        m.base_color = COLOR;
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: ROUGHNESS, texture: None };
    })
}

/// Clay in white, where vertices have colours, which multiply the base colour.
pub(super) fn white_clay() -> Material {
    clay().with(|m| m.base_color = [1.0; 4])
}
