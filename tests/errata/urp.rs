//! Roughening of the base under a coat by URP (Unity 6, universal/ShaderLibrary `Lighting`,
//! `InitializeBRDFDataClearCoat`), and by copies that have lost brackets.

use super::ball::{Color, L, Setting, color, number, view};
use overcoat::scene::{Material, ShadingModel, Workflow};
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_shading::coat::urp::{
    self, Coat, LIGHT_COLOR_PER_IRRADIANCE, Reflectance, SurfaceData, UrpVersion, direct, indirect,
};

pub const MODEL: ShadingModel = ShadingModel::Urp17;

const STEEL: [f32; 3] = [0.5, 0.58, 0.66];
const ROUGHNESS: f32 = 0.4;
const COAT_ROUGHNESS: f32 = 0.1;

/// Reading of the notes: the right one, or the mistake.
#[derive(Clone, Copy, PartialEq)]
pub enum Notes {
    /// `sqrt(sqrt(2 / (sigma * ieta^2 + 2)))`
    Right,
    /// `sqrt(sqrt(2 / sigma * ieta^2 + 2))`
    Brackets,
}

/// Lacquered steel.
pub fn material() -> Material {
    let [r, g, b] = STEEL;
    Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: ROUGHNESS, texture: None };
        m.coat = 1.0;
        m.coat_roughness = COAT_ROUGHNESS;
    })
}

/// The perceptual roughness of the base under a full coat.
pub fn roughened(p: f32, notes: Notes) -> f32 {
    let sigma = 2.0 / (p * p * p * p) - 2.0;
    let ieta2 = 1.0 / 2.25;
    let alpha2 = match notes {
        Notes::Right => 2.0 / (sigma * ieta2 + 2.0),
        Notes::Brackets => 2.0 / sigma * ieta2 + 2.0,
    };
    alpha2.sqrt().sqrt()
}

pub fn shade(normal: Color, setting: &Setting, notes: Notes) -> Color {
    let data = SurfaceData {
        albedo: color(STEEL),
        reflectance: Reflectance::Metallic { metallic: number(1.0), dielectric_f0: color([0.04; 3]) },
        smoothness: number(1.0 - ROUGHNESS),
        coat: Some(Coat { mask: number(1.0), smoothness: number(1.0 - COAT_ROUGHNESS), normal: None }),
    };
    let mut surface = urp::surface(L, UrpVersion::Newest, &data, normal, view());
    // `InitializeBRDFDataDirect`'s, of another roughness.
    let base = &mut surface.base;
    base.perceptual_roughness = number(roughened(ROUGHNESS, notes));
    base.roughness = base.perceptual_roughness.squared();
    base.roughness2 = base.roughness.squared();
    base.normalization_term = base.roughness * 4.0 + 2.0;
    base.roughness2_minus_one = base.roughness2 - 1.0;
    let lamp = color([setting.lamp * LIGHT_COLOR_PER_IRRADIANCE; 3]);
    let sky = color([setting.sky; 3]);
    direct(L, &surface, setting.direction(), lamp) + indirect(L, &surface, sky, |_| sky, L.splat(1.0))
}
