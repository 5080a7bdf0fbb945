//! Helpers that layered models share: Fresnel, roughness, thin films, hazy gloss (`helpers_fresnel`, `_roughness`,
//! `_iridescence`, `_haze`).

use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::{fresnel, iridescence, roughness};
use overcoat_shading::coat::stacklit::haze::{Haze, HazyLobes, haze_mapping};

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "helpers_fresnel", uniform: &[], run: fresnel, skipped: &[] },
    Adapter { table: "helpers_roughness", uniform: &[], run: roughness, skipped: &[] },
    Adapter { table: "helpers_iridescence", uniform: &[], run: iridescence, skipped: &[] },
    Adapter { table: "helpers_haze", uniform: &[], run: haze, skipped: &[] },
];

fn fresnel(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => fresnel_on(l, batch))
}
fn roughness(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => roughness_on(l, batch))
}
fn iridescence(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => iridescence_on(l, batch))
}
fn haze(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => haze_on(l, batch))
}

#[inline(always)]
fn load<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> L::F {
    l.load(&batch.get(name))
}

#[inline(always)]
fn load3<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> V3<L> {
    Vec3::from_array(batch.get3(name)).map(|c| l.load(&c))
}

fn store3<L: Lanes>(v: V3<L>) -> [[f32; 16]; 3] {
    v.map(Float::to_array).to_array()
}

#[inline(always)]
fn fresnel_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let [cosine, n1, n2, f90, reflectivity] =
        ["cosTheta", "n1", "n2", "f90", "reflectivity"].map(|name| load(l, batch, name));
    let f0 = load3(l, batch, "f0");
    let one = l.splat(1.0);
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("FresnelUnpolarized", fresnel::fresnel_unpolarized(l, cosine, n1, n2));
    set("F_Schlick_s_f90", fresnel::schlick(l, f0.x, f90, cosine));
    set("F_Schlick_s", fresnel::schlick(l, f0.x, one, cosine));
    set("F_Transm_Schlick_f90", fresnel::schlick_transmission(l, f0.x, f90, cosine));
    set("F_FresnelDielectric_n2", fresnel::fresnel_dielectric(l, n2, cosine));
    set("IorToFresnel0_n2", fresnel::ior_to_fresnel0(l, n2, one));
    set("IorToFresnel0_n2_n1", fresnel::ior_to_fresnel0(l, n2, n1));
    set("Pow4_oneMinusCos", fresnel::pow4(l, cosine.one_minus()));
    let mut set3 = |name: &str, value: V3<L>| found.set3(name, store3::<L>(value));
    set3("F_Schlick_v_f90", fresnel::schlick_color(l, f0, f90, cosine));
    set3("F_Schlick_v", fresnel::schlick_color(l, f0, one, cosine));
    set3("Fresnel0ToIor", f0.map(|f| fresnel::fresnel0_to_ior(l, f)));
    set3("ConvertF0ClearCoat15", f0.map(|f| fresnel::f0_under_coat(l, f)));
    set3("ConvertF0ClearCoat15Fast", f0.map(|f| fresnel::f0_under_coat_fast(l, f)));
    set3("ConvertF0NewTopIor_n1", fresnel::f0_under_ior(l, f0, n1));
    set3("GetEnergyCompensationFactor", fresnel::energy_compensation_factor(l, reflectivity, f0));
    found
}

#[inline(always)]
fn roughness_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let [a, v, k, a2] = ["a", "v", "anisotropy", "a2"].map(|name| load(l, batch, name));
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("PerceptualRoughnessToRoughness", a.squared());
    set("RoughnessToPerceptualRoughness", a.sqrt());
    set("RoughnessToVariance", roughness::roughness_to_variance(l, a));
    set("VarianceToRoughness", roughness::variance_to_roughness(l, v));
    set("RoughnessToLinearVariance", roughness::roughness_to_linear_variance(l, a));
    set("PerceptualRoughnessToLinearVariance", roughness::roughness_to_linear_variance(l, a.squared()));
    set("LinearVarianceToRoughness", roughness::linear_variance_to_roughness(l, v));
    set("LinearVarianceToPerceptualRoughness", roughness::linear_variance_to_roughness(l, v).sqrt());
    set("ClampRoughnessForAnalyticalLights", roughness::clamp_roughness_for_analytical_lights(l, a));
    let [t, b] = roughness::anisotropic_roughness(l, a.squared(), k);
    set("roughnessT", t);
    set("roughnessB", b);
    set("ConvertRoughnessToAnisotropy_a_a2", roughness::anisotropy_of_roughness(l, a, a2));
    let isotropic = roughness::roughness_of_anisotropic(l, a, k * 0.9);
    set("ConvertRoughnessTAndAnisotropyToRoughness_a_09aniso", isotropic);
    set("GetModifiedAnisotropy", roughness::modified_anisotropy(l, k, a, a2));
    set("PerceptualRoughnessToMipmapLevel", roughness::mip_of_perceptual_roughness(l, a));
    set("PerceptualRoughnessBeckmannToGGX", roughness::perceptual_roughness_beckmann_to_ggx(l, a));
    found
}

#[inline(always)]
fn iridescence_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let [top, cosine, thickness, over, path, shift] =
        ["eta1", "cosTheta1", "thickness", "iorOverBaseLayer", "opd", "shift"]
            .map(|name| load(l, batch, name));
    let f0 = load3(l, batch, "f0");
    let mut set3 = |name: &str, value: V3<L>| found.set3(name, store3::<L>(value));
    set3("EvalIridescence", iridescence::eval_iridescence(l, top, cosine, thickness, f0));
    let under = iridescence::f0_under_film(l, thickness, f0, over);
    set3("EvalIridescence_iorOver", iridescence::eval_iridescence(l, top, cosine, thickness, under));
    set3("EvalSensitivity", iridescence::sensitivity(l, path, shift));
    found
}

#[inline(always)]
fn haze_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let haze = Haze {
        haziness: load(l, batch, "haziness"),
        extent: load(l, batch, "hazeExtent"),
        extent_anisotropy: load(l, batch, "hazeExtentAnisotropy"),
        max_f0: load3(l, batch, "maxF0"),
    };
    let fresnel0 = load3(l, batch, "f0");
    // Lobe B of the table where nothing is reflected: zeros.
    let before = HazyLobes {
        fresnel0,
        lobe_mix: l.zero(),
        anisotropy_b: l.zero(),
        perceptual_roughness_b: l.zero(),
        roughness_b: [l.zero(); 2],
    };
    let core = ["roughnessAT", "roughnessAB"].map(|name| load(l, batch, name));
    let lobes = haze_mapping(l, fresnel0, core, &haze, &before);
    found.set3("fresnel0", store3::<L>(lobes.fresnel0));
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("lobeMix", lobes.lobe_mix);
    set("anisotropyB", lobes.anisotropy_b);
    set("perceptualRoughnessB", lobes.perceptual_roughness_b);
    set("roughnessBT", lobes.roughness_b[0]);
    set("roughnessBB", lobes.roughness_b[1]);
    found
}
