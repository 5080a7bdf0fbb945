//! Unity URP: the functions of the shading pass on the rows of its tables.

use super::stub;
use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::coat::urp::{self, BrdfData, Coat, Reflectance, Surface, SurfaceData, UrpVersion};

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "urp_brdf", uniform: UNIFORM, run: brdf, skipped: &[] },
    Adapter { table: "urp_direct", uniform: UNIFORM, run: direct, skipped: &[] },
    Adapter { table: "urp_gi", uniform: UNIFORM, run: gi, skipped: &[] },
    Adapter { table: "urp17_brdf", uniform: UNIFORM_17, run: brdf_17, skipped: &[] },
    Adapter { table: "urp17_direct", uniform: UNIFORM_17, run: direct_17, skipped: &[] },
    Adapter { table: "urp17_gi", uniform: UNIFORM_17, run: gi_17, skipped: &[] },
];

/// Columns that all rows of a vector must share.
const UNIFORM: &[&str] = &["in_mobile", "in_specularWorkflow"];
/// As [`UNIFORM`], of the tables of the newest version.
const UNIFORM_17: &[&str] = &["in_realIsHalf", "in_specularWorkflow"];

fn brdf(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => brdf_on(l, version_13(batch), batch))
}
fn brdf_17(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => brdf_on(l, version_17(batch), batch))
}
fn direct(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => direct_on(l, version_13(batch), batch))
}
fn direct_17(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => direct_on(l, version_17(batch), batch))
}
fn gi(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => gi_on(l, version_13(batch), batch))
}
fn gi_17(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => gi_on(l, version_17(batch), batch))
}

fn version_13(batch: &Batch<'_>) -> UrpVersion {
    if batch.is_on("mobile") { UrpVersion::Mobile } else { UrpVersion::Desktop }
}

fn version_17(batch: &Batch<'_>) -> UrpVersion {
    if batch.is_on("realIsHalf") { UrpVersion::NewestHalf } else { UrpVersion::Newest }
}

#[inline(always)]
fn load3<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> V3<L> {
    Vec3::from_array(batch.get3(name)).map(|c| l.load(&c))
}

fn store3<L: Lanes>(v: V3<L>) -> [[f32; 16]; 3] {
    v.map(Float::to_array).to_array()
}

#[inline(always)]
fn material<L: Lanes>(l: L, batch: &Batch<'_>) -> SurfaceData<L> {
    let reflectance = if batch.is_on("specularWorkflow") {
        Reflectance::Specular { color: load3(l, batch, "specular") }
    } else {
        Reflectance::Metallic {
            metallic: l.load(&batch.get("metallic")),
            dielectric_f0: Vec3::splat(l, [urp::DIELECTRIC_F0; 3]),
        }
    };
    SurfaceData {
        albedo: load3(l, batch, "albedo"),
        reflectance,
        smoothness: l.load(&batch.get("smoothness")),
        coat: Some(Coat {
            mask: l.load(&batch.get("clearCoatMask")),
            smoothness: l.load(&batch.get("clearCoatSmoothness")),
            normal: None,
        }),
    }
}

#[inline(always)]
fn surface<L: Lanes>(l: L, version: UrpVersion, batch: &Batch<'_>) -> Surface<L> {
    urp::surface(l, version, &material(l, batch), load3(l, batch, "N"), load3(l, batch, "V"))
}

fn store_roughness<L: Lanes>(found: &mut Found, name: &str, data: &BrdfData<L>) {
    let mut set = |field: &str, value: L::F| found.set(&format!("{name}_{field}"), value.to_array());
    set("perceptualRoughness", data.perceptual_roughness);
    set("roughness", data.roughness);
    set("roughness2", data.roughness2);
    set("grazingTerm", data.grazing_term);
    set("normalizationTerm", data.normalization_term);
    set("roughness2MinusOne", data.roughness2_minus_one);
    found.set3(&format!("{name}_specular"), store3::<L>(data.specular));
}

fn store_colors<L: Lanes>(found: &mut Found, name: &str, data: &BrdfData<L>) {
    found.set3(&format!("{name}_albedo"), store3::<L>(data.albedo));
    found.set3(&format!("{name}_diffuse"), store3::<L>(data.diffuse));
    found.set(&format!("{name}_reflectivity"), data.reflectivity.to_array());
}

#[inline(always)]
fn brdf_on<L: Lanes>(l: L, version: UrpVersion, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let material = material(l, batch);
    let before =
        urp::initialize_brdf_data(l, version, material.albedo, material.reflectance, material.smoothness);
    store_roughness(&mut found, "base0", &before);
    store_colors(&mut found, "base0", &before);
    // The layers as the shading pass has them; directions do not enter.
    let up = Vec3::splat(l, [0.0, 0.0, 1.0]);
    let surface = urp::surface(l, version, &material, up, up);
    store_roughness(&mut found, "base", &surface.base);
    if let Some(coat) = &surface.coat {
        store_roughness(&mut found, "coat", &coat.data);
        store_colors(&mut found, "coat", &coat.data);
    }
    found
}

#[inline(always)]
fn direct_on<L: Lanes>(l: L, version: UrpVersion, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = surface(l, version, batch);
    let [normal, light, view] = ["N", "L", "V"].map(|name| load3(l, batch, name));
    let mut term = |name: &str, data: &BrdfData<L>| {
        let value = urp::direct_brdf_specular(l, version, data, normal, light, view);
        found.set(name, value.to_array());
    };
    term("base_DirectBRDFSpecular", &surface.base);
    if let Some(coat) = &surface.coat {
        term("coat_DirectBRDFSpecular", &coat.data);
    }
    let color = load3(l, batch, "lightColor");
    let lit = urp::direct(l, &surface, light, color * l.load(&batch.get("attenuation")));
    found.set3("lit", store3::<L>(lit));
    found
}

#[inline(always)]
fn stub_query<L: Lanes>(l: L, query: urp::EnvironmentQuery<L>) -> V3<L> {
    stub::environment(l, query.direction, query.perceptual_roughness)
}

#[inline(always)]
fn gi_on<L: Lanes>(l: L, version: UrpVersion, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = surface(l, version, batch);
    found.set3("envBase", store3::<L>(stub_query(l, surface.base_query())));
    if let Some(query) = surface.coat_query() {
        found.set3("envCoat", store3::<L>(stub_query(l, query)));
    }
    let baked_gi = load3(l, batch, "bakedGI");
    let occlusion = l.load(&batch.get("occlusion"));
    let gi = urp::indirect(l, &surface, baked_gi, |query| stub_query(l, query), occlusion);
    found.set3("gi", store3::<L>(gi));
    found
}
