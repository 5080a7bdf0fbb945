//! The Khronos glTF Sample Renderer: the functions of the shading pass on the rows of `gltf_khronos_*`.

use super::stub;
use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::coat::gltf::{
    self, Anisotropy, Coat, CoatF0, Environment, Iridescence, Lookups, Sheen, Surface, SurfaceData, Terms,
};
use std::f32::consts::PI;

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "gltf_khronos_direct", uniform: UNIFORM, run: direct, skipped: &[] },
    Adapter { table: "gltf_khronos_ibl", uniform: UNIFORM, run: ibl, skipped: &[] },
];

/// Columns that all rows of a vector must share.
const UNIFORM: &[&str] =
    &["in_clearcoat_on", "in_specular_on", "in_sheen_on", "in_iridescence_on", "in_anisotropy_on"];

fn direct(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => direct_on(l, batch))
}
fn ibl(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => ibl_on(l, batch))
}

#[inline(always)]
fn load<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> L::F {
    l.load(&batch.get(name))
}

#[inline(always)]
fn load3<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> V3<L> {
    Vec3::from_array(batch.get3(name)).map(|c| l.load(&c))
}

fn store3<L: Lanes>(v: V3<L>) -> [[f32; LANES]; 3] {
    v.map(Float::to_array).to_array()
}

#[inline(always)]
fn surface<L: Lanes>(l: L, batch: &Batch<'_>, found: &mut Found) -> Surface<L> {
    let specular = batch.is_on("specular_on");
    let data = SurfaceData {
        base_color: load3(l, batch, "baseColor"),
        metallic: load(l, batch, "metallic"),
        roughness: load(l, batch, "roughness"),
        ior: load(l, batch, "ior"),
        specular_factor: if specular { load(l, batch, "specularFactor") } else { l.splat(1.0) },
        specular_color: if specular { load3(l, batch, "specularColor") } else { Vec3::splat(l, [1.0; 3]) },
        coat: batch.is_on("clearcoat_on").then(|| Coat {
            factor: load(l, batch, "clearcoat"),
            roughness: load(l, batch, "clearcoatRoughness"),
            normal: load3(l, batch, "Nc"),
        }),
        sheen: batch.is_on("sheen_on").then(|| Sheen {
            color: load3(l, batch, "sheenColor"),
            roughness: load(l, batch, "sheenRoughness"),
        }),
        iridescence: batch.is_on("iridescence_on").then(|| Iridescence {
            factor: load(l, batch, "iridescence"),
            ior: load(l, batch, "iridescenceIor"),
            thickness: load(l, batch, "iridescenceThickness"),
        }),
        anisotropy: batch.is_on("anisotropy_on").then(|| Anisotropy {
            strength: load(l, batch, "anisoStrength"),
            direction: ["anisoRot_x", "anisoRot_y"].map(|name| load(l, batch, name)),
            tangent: load3(l, batch, "T"),
            bitangent: load3(l, batch, "B"),
            geometric_normal: load3(l, batch, "Nc"),
        }),
    };
    let lookups = Lookups {
        ggx: ["ggxLut_x", "ggxLut_y"].map(|name| load(l, batch, name)),
        charlie: load(l, batch, "charlieLut_z"),
        sheen_albedo: load(l, batch, "sheenE_V"),
    };
    let (normal, view) = (load3(l, batch, "N"), load3(l, batch, "V"));
    let surface = gltf::surface_with_lookups(l, CoatF0::BaseIor, &data, normal, view, &lookups);
    let zero = Vec3::zero(l);
    found.set3("f0Dielectric", store3::<L>(surface.f0_dielectric));
    found.set3("f90Dielectric", store3::<L>(Vec3::uniform(surface.specular_weight)));
    found.set("specularWeight", surface.specular_weight.to_array());
    found.set("alphaRoughness", surface.alpha_roughness.to_array());
    let (tangent, bitangent) = match &surface.anisotropy {
        Some(anisotropy) => (anisotropy.tangent, anisotropy.bitangent),
        None => (zero, zero),
    };
    found.set3("anisotropicT", store3::<L>(tangent));
    found.set3("anisotropicB", store3::<L>(bitangent));
    let (dielectric, metallic) = match &surface.film {
        Some(film) => (film.dielectric, film.metallic),
        None => (zero, zero),
    };
    found.set3("iridescenceFresnelDielectric", store3::<L>(dielectric));
    found.set3("iridescenceFresnelMetallic", store3::<L>(metallic));
    let weight = match &surface.coat {
        Some(coat) => coat.weight,
        None => l.zero(),
    };
    found.set3("clearcoatWeight", store3::<L>(Vec3::uniform(weight)));
    surface
}

/// The columns that lights and environment share.
fn store_terms<L: Lanes>(l: L, found: &mut Found, kind: &str, surface: &Surface<L>, terms: &Terms<L>) {
    found.set3(&format!("{kind}_diffuse"), store3::<L>(terms.diffuse));
    found.set3(&format!("{kind}_specular"), store3::<L>(terms.specular));
    found.set3("metalBrdf", store3::<L>(terms.metal));
    found.set3("dielectricBrdf", store3::<L>(terms.dielectric));
    found.set3("sheen", store3::<L>(terms.sheen));
    found.set("albedoSheenScaling", terms.sheen_scaling.to_array());
    found.set3("baseColorBeforeCoat", store3::<L>(gltf::beneath_coat(l, surface, terms)));
}

#[inline(always)]
fn direct_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = surface(l, batch, &mut found);
    let (light, color) = (load3(l, batch, "L"), load3(l, batch, "lightColor"));
    let direct = gltf::direct_terms(l, &surface, light, color, load(l, batch, "sheenE_L"));
    store_terms(l, &mut found, "l", &surface, &direct.terms);
    found.set3("metalFresnel", store3::<L>(direct.metal_fresnel));
    found.set3("dielectricFresnel", store3::<L>(direct.dielectric_fresnel));
    found.set3("clearcoatBrdf", store3::<L>(direct.terms.coat));
    found.set3("color", store3::<L>(gltf::color(l, &surface, &direct.terms)));
    found
}

#[inline(always)]
fn ibl_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = surface(l, batch, &mut found);
    let all = gltf::environment_queries(l, &surface);
    let mut radiance = [Vec3::zero(l); 3];
    for (radiance, query) in radiance.iter_mut().zip(all.queries).take(all.count) {
        *radiance = stub::environment(l, query.direction, query.perceptual_roughness);
    }
    let irradiance = |normal| stub::environment(l, normal, l.splat(1.0)) * PI;
    let environment = Environment {
        irradiance: irradiance(surface.normal),
        radiance: radiance[0],
        coat_radiance: radiance[1],
        sheen_radiance: radiance[all.sheen],
    };
    let indirect = gltf::indirect_terms(l, &surface, &environment);
    store_terms(l, &mut found, "f", &surface, &indirect.terms);
    found.set3("metalFresnelIbl", store3::<L>(indirect.metal_fresnel));
    found.set3("dielectricFresnelIbl", store3::<L>(indirect.dielectric_fresnel));
    let coat = if surface.coat.is_some() { indirect.terms.coat } else { Vec3::zero(l) };
    found.set3("clearcoatRadiance", store3::<L>(coat));
    found.set3("color", store3::<L>(gltf::color(l, &surface, &indirect.terms)));
    found
}
