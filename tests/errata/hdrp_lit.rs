//! The block of HDRP Lit that puts the coat over the base (13.0.0, `EvaluateBSDF` of `Lit`), right and as copies have it.

use super::ball::{Color, L, Number, Setting, color, number, view};
use overcoat::scene::{Material, ShadingModel, Workflow};
use overcoat_core::math::lanes::{Float, Scalar};
use overcoat_core::math::vec3::Vec3;
use overcoat_shading::brdf::fresnel::schlick;
use overcoat_shading::brdf::ggx::{bsdf_angles, part_lambda, smith_distribution_visibility};
use overcoat_shading::brdf::tables::unity_fgd;
use overcoat_shading::coat::hdrp_lit::{
    self as lit, CosineWeightedBsdf, DirectLighting, Occlusion, Reflectance, Surface, SurfaceData,
};

pub const MODEL: ShadingModel = ShadingModel::HdrpLit;

const RED: [f32; 3] = [0.5, 0.05, 0.04];
const ROUGHNESS: f32 = 0.5;

/// Least roughness (alpha) with which lamps are shown.
const LEAST: f32 = 1.0 / 1024.0;

/// Reading of the notes: the right one, or one of the mistakes.
#[derive(Clone, Copy, PartialEq)]
pub enum Notes {
    Right,
    /// `coatF = Schlick + coatMask`.
    PlusMask,
    /// `specTerm += (1 - coatF)^2`.
    PlusThrough,
    /// `CLEAR_COAT_ROUGHNESS` as a perceptual roughness.
    AlphaSquared,
    /// `CLEAR_COAT_PERCEPTUAL_ROUGHNESS` as alpha.
    PerceptualAsAlpha,
}

/// Red plastic under a coat.
pub fn material() -> Material {
    let [r, g, b] = RED;
    Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: ROUGHNESS, texture: None };
        m.coat = 1.0;
    })
}

pub fn shade(normal: Color, setting: &Setting, notes: Notes) -> Color {
    let data = SurfaceData {
        base_color: color(RED),
        reflectance: Reflectance::Metallic { metallic: number(0.0), dielectric_f0: color([0.04; 3]) },
        perceptual_smoothness: number(1.0 - ROUGHNESS),
        anisotropy: None,
        iridescence: None,
        coat_mask: Some(number(1.0)),
        transmittance: None,
    };
    let surface = lit::surface(L, unity_fgd(), &data, normal, view());
    let sky = color([setting.sky; 3]);
    let bsdf = bsdf(&surface, normal, setting.direction(), notes);
    let lamp = color([setting.lamp; 3]);
    let lamps =
        DirectLighting { diffuse: lamp * bsdf.diffuse_reflected, specular: lamp * bsdf.specular_reflected };
    let mirrored = lit::environment(L, &surface, |_| sky);
    let occlusion = Occlusion::of_material(L, &surface, data.perceptual_smoothness, number(1.0));
    let out = lit::compose(L, &surface, &lamps, mirrored, sky, Vec3::zero(L), &occlusion);
    out.diffuse + out.specular
}

/// The base as it lies under the coat, and the coat over it.
fn bsdf(surface: &Surface<Scalar>, normal: Color, light: Color, notes: Notes) -> CosineWeightedBsdf<Scalar> {
    let mut base = *surface;
    base.bsdf.coat = None;
    let base = lit::evaluate_bsdf(L, &base, light, number(LEAST));

    let (one, mask) = (number(1.0), surface.bsdf.coat.unwrap().mask);
    let n_dot_l = normal.dot(light);
    let angles = bsdf_angles(L, light, view(), n_dot_l, surface.pre.n_dot_v);
    let schlick = schlick(L, number(0.04), one, angles.l_dot_h);
    let coat_f = if notes == Notes::PlusMask { schlick + mask } else { schlick * mask };
    let alpha = number(match notes {
        Notes::AlphaSquared => 0.01 * 0.01,
        Notes::PerceptualAsAlpha => 0.1,
        _ => 0.01,
    });
    let n_dot_v = surface.pre.clamped_n_dot_v;
    let lambda = part_lambda(L, n_dot_v, alpha);
    let raised = alpha.max(number(LEAST));
    let highlight = smith_distribution_visibility(L, angles.n_dot_h, n_dot_l.abs(), n_dot_v, raised, lambda);
    let cosine: Number = n_dot_l.saturate();
    let through = coat_f.one_minus().squared();
    let beneath = match notes {
        // Beside the cosine, which the base's has already.
        Notes::PlusThrough => base.specular_reflected + color([1.0; 3]) * (through * cosine),
        _ => base.specular_reflected * through,
    };
    CosineWeightedBsdf {
        diffuse_reflected: base.diffuse_reflected * one.lerp(coat_f.one_minus(), mask),
        specular_reflected: beneath + color([1.0; 3]) * (coat_f * highlight * cosine),
        diffuse_transmitted: base.diffuse_transmitted,
    }
}
