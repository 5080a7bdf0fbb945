//! StackLit's adding (HDRP 13.0.0, `ComputeAdding` and `GetPreLightData` of `StackLit`) as its loop, and as copies have it.

use super::ball::{Color, L, Number, Setting, color, number, view};
use overcoat::scene::{Material, ShadingModel, Workflow};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::Vec3;
use overcoat_shading::brdf::fgd::pre_integrated_specular;
use overcoat_shading::brdf::tables::unity_fgd;
use overcoat_shading::coat::stacklit::{
    Adding, Coat, Frame, Light, Options, PreLight, SurfaceData, Version, baked_diffuse, compose, direct,
    environment, surface,
};

pub const MODEL: ShadingModel = ShadingModel::StackLit;

const COPPER: [f32; 3] = [0.93, 0.6, 0.38];
const ROUGHNESS: f32 = 0.3;
const COAT_ROUGHNESS: f32 = 0.15;

/// Reading of the notes: the right one, or one of the mistakes.
#[derive(Clone, Copy, PartialEq)]
pub enum Notes {
    Right,
    /// `(R0i + R12 * Ti0) / denom` for the first of the products.
    Sums,
    /// BOTTOM as what has been reflected so far, and not as what the base adds to it.
    Accumulated,
    /// FGD of the base's own F0 times BOTTOM.
    TimesFgd,
}

/// Lacquered copper.
pub fn material() -> Material {
    let [r, g, b] = COPPER;
    Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: ROUGHNESS, texture: None };
        m.coat = 1.0;
        m.coat_roughness = COAT_ROUGHNESS;
    })
}

pub fn shade(normal: Color, setting: &Setting, notes: Notes) -> Color {
    let coat = Coat {
        mask: number(1.0),
        smoothness: number(1.0 - COAT_ROUGHNESS),
        ior: number(1.5),
        thickness: number(0.0),
        extinction: color([0.0; 3]),
        normal: None,
    };
    let metal = SurfaceData::plain(L, color(COPPER), number(1.0), number(1.0 - ROUGHNESS), normal);
    let data = SurfaceData { coat: Some(coat), ..metal };
    let options = Options { version: Version::V13, specular_occlusion: None, ..Options::default() };
    let across = color([0.0; 3]);
    let frame = Frame { normal, geometric_normal: normal, tangent: across, bitangent: across, view: view() };
    let mut pre = surface(L, &options, &data, &frame, unity_fgd());
    let adding = pre.adding(L).unwrap();

    let [coat, base] = by_the_loop(&adding, notes == Notes::Sums);
    pre.layers.bottom = match notes {
        Notes::Accumulated => coat + base,
        _ => base,
    };
    let own = pre.bsdf.fresnel0;
    pre.lobes[1].specular_fgd = match notes {
        Notes::TimesFgd => fgd(&pre, own) * pre.layers.bottom,
        _ => fgd(&pre, pre.layers.bottom),
    };
    lit(&pre, setting)
}

/// Reflectance under light from everywhere of a lobe with this F0.
fn fgd(pre: &PreLight<Scalar>, f0: Color) -> Color {
    let p = pre.layers.lobes[0].perceptual_roughness;
    pre_integrated_specular(L, unity_fgd(), pre.base_layer_n_dot_v, p, f0).0
}

/// Light that coat and base add to the reflection, by the loop over the layers.
fn by_the_loop(adding: &Adding<Scalar>, sums: bool) -> [Color; 2] {
    let one = color([1.0; 3]);
    let none = color([0.0; 3]);
    let [mut r0i, mut t0i, mut ri0, mut ti0] = [none, one, none, one];
    let mut added = [none; 3];
    for (layer, added) in added.iter_mut().enumerate() {
        let [r12, t12, r21, t21] = adding.statistics(L, layer).energies;
        let inverse = over(one - ri0 * r12);
        *added = if sums { (r0i + r12 * ti0) * inverse } else { t0i * r12 * ti0 * inverse };
        r0i += *added;
        (t0i, ri0, ti0) = (t0i * t12 * inverse, r21 + t21 * ri0 * t12 * inverse, t21 * ti0 * inverse);
    }
    [added[0], added[2]]
}

/// 1 / x, and 0 where the original's guard (`mean(denom) <= 0`) has 0.
fn over(x: Color) -> Color {
    x.map(|x: Number| {
        let x = x.to_array();
        let inverse: [f32; LANES] = std::array::from_fn(|k| if x[k] > 0.0 { 1.0 / x[k] } else { 0.0 });
        L.load(&inverse)
    })
}

fn lit(pre: &PreLight<Scalar>, setting: &Setting) -> Color {
    let sky = color([setting.sky; 3]);
    let lamp = Light::new(L, setting.direction(), color([setting.lamp; 3]));
    let lights = direct(L, pre, &lamp);
    let mirrored = environment(L, pre, |_| sky);
    let baked = baked_diffuse(L, pre, sky, sky);
    let out = compose(L, pre, &lights, mirrored, baked, Vec3::zero(L));
    out.diffuse + out.specular
}
