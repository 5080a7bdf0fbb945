//! Filament's document of 2018, whose code dims the base's specular part twice, and its later editions. The crate has both, as
//! two settings of a model.

use super::ball::{Color, L, Setting, color, number, view};
use overcoat::scene::{Material, ShadingModel, Workflow};
use overcoat_core::math::vec3::Vec3;
use overcoat_shading::brdf::tables::filament_dfg;
use overcoat_shading::coat::filament_2018::{Attenuation, Coat, SurfaceData, direct, indirect, surface};

pub const MODEL: ShadingModel = ShadingModel::Filament2018;

const GOLD: [f32; 3] = [0.95, 0.66, 0.25];
const ROUGHNESS: f32 = 0.35;
const COAT_ROUGHNESS: f32 = 0.1;

/// Lacquered gold.
pub fn material(once: bool) -> Material {
    let [r, g, b] = GOLD;
    let mut material = Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: ROUGHNESS, texture: None };
        m.coat = 1.0;
        m.coat_roughness = COAT_ROUGHNESS;
    });
    material.options.filament_2018.single_attenuation = once;
    material
}

/// Schlick's reflectance of the coat at the cosine of l.h or n.v.
pub fn coat_reflectance(cosine: f64) -> f64 {
    let x = 1.0 - cosine;
    0.04 + 0.96 * x * x * x * x * x
}

pub fn shade(normal: Color, setting: &Setting, squared: bool) -> Color {
    let data = SurfaceData {
        base_color: color(GOLD),
        metallic: number(1.0),
        perceptual_roughness: number(ROUGHNESS),
        dielectric_f0: color([0.04; 3]),
        coat: Some(Coat {
            mask: number(1.0),
            perceptual_roughness: number(COAT_ROUGHNESS),
            modify_f0: true,
            attenuation: if squared { Attenuation::Code } else { Attenuation::Later },
        }),
    };
    let layers = surface(L, &data, normal, view());
    let dfg = Vec3::from_array(filament_dfg().fetch(L, layers.n_dot_v, layers.perceptual_roughness));
    let sky = color([setting.sky; 3]);
    direct(L, &layers, setting.direction(), color([setting.lamp; 3]))
        + indirect(L, &layers, dfg, sky, |_| sky, number(1.0))
}
