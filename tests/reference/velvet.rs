//! Velvet and anisotropic GGX: `velvet_aniso`.

use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::microfacet::{distribution_ggx_anisotropic, visibility_smith_anisotropic};
use overcoat_shading::brdf::sheen::{self, distribution_charlie, visibility_neubelt};
use overcoat_shading::brdf::velvet::{
    anisotropic_roughness, distribution_velvet, distribution_velvet_real_time, velvet_lobe,
};

pub const ADAPTERS: &[Adapter] = &[Adapter { table: "velvet_aniso", uniform: &[], run: lobes, skipped: &[] }];

/// Least alpha of the clamped columns: Filament's on desktop.
const LEAST_ALPHA: f32 = 0.002_025;

fn lobes(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => lobes_on(l, batch))
}

#[inline(always)]
fn load3<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> V3<L> {
    Vec3::from_array(batch.get3(name)).map(|c| l.load(&c))
}

#[inline(always)]
fn lobes_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    let load = |name: &str| l.load(&batch.get(name));
    let (normal, tangent) = (load3(l, batch, "N"), load3(l, batch, "T"));
    let (view, light) = (load3(l, batch, "V"), load3(l, batch, "L"));
    let bitangent = normal.cross(tangent);
    let half = (view + light).divide_by_length();
    let in_frame = |v: V3<L>| Vec3::from_array([tangent, bitangent, normal]).map(|axis| axis.dot(v));
    let (half, view, light) = (in_frame(half), in_frame(view), in_frame(light));
    for (name, value) in ["ToH", "BoH", "NoH"].into_iter().zip(half.to_array()) {
        set(name, value);
    }
    let (n_dot_h, n_dot_v, n_dot_l) = (half.z, view.z, light.z);
    set("NoV", n_dot_v);
    set("NoL", n_dot_l);

    let (alpha, anisotropy) = (load("alpha"), load("anisotropy"));
    let alphas = anisotropic_roughness(l, alpha, anisotropy, 0.0);
    let clamped = anisotropic_roughness(l, alpha, anisotropy, LEAST_ALPHA);
    set("alphaT", alphas[0]);
    set("alphaB", alphas[1]);
    for (suffix, alphas) in [("", alphas), ("_clamped", clamped)] {
        set(&format!("D_aniso{suffix}"), distribution_ggx_anisotropic(l, half, alphas, 0.0));
        set(&format!("V_aniso{suffix}"), visibility_smith_anisotropic(l, light, view, alphas, 0.0));
    }

    let sigma = load("sigma");
    let velvet = distribution_velvet(l, n_dot_h, sigma);
    let real_time = distribution_velvet_real_time(l, n_dot_h, sigma);
    set("D_velvet", velvet);
    set("D_velvet_clampedSin", real_time);
    set("f_velvet", velvet_lobe(l, velvet, n_dot_l, n_dot_v, 0.0));
    set("f_velvet_clampedSin", velvet_lobe(l, real_time, n_dot_l, n_dot_v, 0.0));
    set("D_charlie", distribution_charlie(l, n_dot_h, sigma, 0.0));
    set("D_charlie_clampedSin", distribution_charlie(l, n_dot_h, sigma, sheen::LEAST_SINE_SQUARED));
    set("V_neubelt", visibility_neubelt(l, n_dot_l, n_dot_v, 0.0));
    found
}
