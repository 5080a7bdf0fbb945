//! three.js: the functions of the shading pass on the rows of `threejs_*`.

use super::stub;
use super::table::{Adapter, Batch, Found, Table as Rows};
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::table::{Table, TexelGrid};
use overcoat_shading::coat::three::{
    self, Anisotropy, Coat, Indirect, Iridescence, Sheen, Surface, SurfaceData, Terms,
};
use overcoat_shading::coat::three_legacy::{self as legacy, LightUnits, ThreeVersion};
use std::f32::consts::PI;
use std::path::Path;

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "threejs_legacy_direct", uniform: LEGACY, run: r119_direct, skipped: &[] },
    Adapter { table: "threejs_legacy_indirect", uniform: LEGACY, run: r119_indirect, skipped: &[] },
    Adapter { table: "threejs_r131_direct", uniform: LEGACY, run: r131_direct, skipped: &[] },
    Adapter { table: "threejs_r131_indirect", uniform: LEGACY, run: r131_indirect, skipped: &[] },
    Adapter { table: "threejs_current_direct", uniform: CURRENT, run: current_direct, skipped: &[] },
    Adapter { table: "threejs_current_indirect", uniform: CURRENT, run: current_indirect, skipped: &[] },
];

/// Columns that all rows of a vector must share.
const LEGACY: &[&str] = &["in_clearcoat_on", "in_sheen_on", "in_physicallyCorrectLights"];
/// As [`LEGACY`], of the current release.
const CURRENT: &[&str] = &["in_clearcoat_on", "in_sheen_on", "in_iridescence_on", "in_anisotropy_on"];

fn r119_direct(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => legacy_direct_on(l, ThreeVersion::R119, batch))
}
fn r131_direct(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => legacy_direct_on(l, ThreeVersion::R131, batch))
}
fn r119_indirect(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => legacy_indirect_on(l, ThreeVersion::R119, batch))
}
fn r131_indirect(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => legacy_indirect_on(l, ThreeVersion::R131, batch))
}
fn current_direct(batch: &Batch<'_>) -> Found {
    let table = dfg_table();
    overcoat_core::dispatch_baseline!(l => current_direct_on(l, &table, batch))
}
fn current_indirect(batch: &Batch<'_>) -> Found {
    let table = dfg_table();
    overcoat_core::dispatch_baseline!(l => current_indirect_on(l, &table, batch))
}

/// The look-up table that the release ships.
fn dfg_table() -> Table<2> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .join("tests/reference/web/threejs_dfg_lut.csv");
    let rows = Rows::read(&path).expect("the copy");
    let [x, y, scale, bias] = ["ix", "iy", "scale", "bias"].map(|name| rows.column(name).expect("a column"));
    let mut texels = vec![[0.0; 2]; 256];
    for k in 0..rows.rows {
        texels[y[k] as usize * 16 + x[k] as usize] = [scale[k] as f32, bias[k] as f32];
    }
    Table::new(16, 16, TexelGrid::Centers, &texels).expect("16 x 16 texels")
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

/// Irradiance of the environment at a normal, as the originals were fed with it.
#[inline(always)]
fn stub_irradiance<L: Lanes>(l: L, normal: V3<L>) -> V3<L> {
    stub::environment(l, normal, l.splat(1.0)) * PI
}

#[inline(always)]
fn legacy_surface<L: Lanes>(
    l: L,
    version: ThreeVersion,
    batch: &Batch<'_>,
    found: &mut Found,
) -> legacy::Surface<L> {
    let tinted = version == ThreeVersion::R131;
    let coat = batch.is_on("clearcoat_on").then(|| Coat {
        factor: load(l, batch, "clearcoat"),
        roughness: load(l, batch, "clearcoatRoughness"),
        normal: load3(l, batch, "Ncc"),
    });
    let data = legacy::SurfaceData {
        color: load3(l, batch, "diffuse"),
        metalness: load(l, batch, "metalness"),
        roughness: load(l, batch, "roughness"),
        geometry_roughness: l.zero(),
        reflectivity: load(l, batch, "reflectivity"),
        specular_intensity: if tinted { load(l, batch, "specularIntensity") } else { l.splat(1.0) },
        specular_tint: if tinted { load3(l, batch, "specularTint") } else { Vec3::splat(l, [1.0; 3]) },
        coat,
        sheen: batch.is_on("sheen_on").then(|| load3(l, batch, "sheenColor")),
    };
    let surface = legacy::surface(l, version, &data, load3(l, batch, "N"), load3(l, batch, "V"));
    found.set3("m_diffuseColor", store3::<L>(surface.diffuse_color));
    found.set3("m_specularColor", store3::<L>(surface.specular_color));
    found.set3("m_specularColorF90", store3::<L>(Vec3::uniform(surface.specular_f90)));
    found.set("m_specularRoughness", surface.roughness.to_array());
    let (factor, roughness) = match &surface.coat {
        Some(coat) => (coat.factor, coat.roughness),
        None => (l.zero(), l.zero()),
    };
    found.set("m_clearcoat", factor.to_array());
    found.set("m_clearcoatRoughness", roughness.to_array());
    surface
}

fn units(batch: &Batch<'_>) -> LightUnits {
    if batch.is_on("physicallyCorrectLights") { LightUnits::Physical } else { LightUnits::Legacy }
}

#[inline(always)]
fn legacy_direct_on<L: Lanes>(l: L, version: ThreeVersion, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = legacy_surface(l, version, batch, &mut found);
    let light = load3(l, batch, "L");
    let color = load3(l, batch, "lightColor");
    let (cosine, albedo) = match &surface.coat {
        Some(coat) => {
            let cosine = coat.normal.dot(light).saturate();
            (cosine, legacy::clearcoat_dhr_approx(l, coat.roughness, cosine))
        }
        None => (l.zero(), l.zero()),
    };
    found.set("ccDotNL", cosine.to_array());
    found.set("clearcoatDHRApprox", albedo.to_array());
    let (base, coat) = legacy::specular_brdfs(l, &surface, light);
    found.set3("ccBRDF", store3::<L>(Vec3::uniform(coat)));
    found.set3("baseSpecBRDF", store3::<L>(base));
    let terms = legacy::direct_terms(l, units(batch), &surface, light, color);
    found.set3("directDiffuse", store3::<L>(terms.diffuse));
    found.set3("directSpecular", store3::<L>(terms.specular));
    let outgoing = terms.diffuse + terms.specular;
    found.set3("outgoing", store3::<L>(outgoing));
    found
}

#[inline(always)]
fn legacy_indirect_on<L: Lanes>(l: L, version: ThreeVersion, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = legacy_surface(l, version, batch, &mut found);
    let zero = l.zero();
    let (cosine, albedo, brdf) = match &surface.coat {
        Some(coat) => (
            coat.n_dot_v,
            legacy::clearcoat_dhr_approx(l, coat.roughness, coat.n_dot_v),
            legacy::coat_environment_brdf(l, coat),
        ),
        None => (zero, zero, zero),
    };
    found.set("ccDotNV", cosine.to_array());
    found.set("clearcoatDHRApprox", albedo.to_array());
    found.set3("ccEnvBRDF", store3::<L>(Vec3::uniform(brdf)));
    let (single, multi) = legacy::multiscattering_environment(l, &surface);
    found.set3("singleScatter", store3::<L>(single));
    found.set3("multiScatter", store3::<L>(multi));
    let dfg = legacy::integrate_specular_brdf(l, surface.n_dot_v, surface.roughness);
    found.set("dfg_x", dfg[0].to_array());
    found.set("dfg_y", dfg[1].to_array());

    let mut radiance = [Vec3::uniform(zero); 2];
    let (queries, count) = legacy::environment_queries(l, &surface);
    for (radiance, query) in radiance.iter_mut().zip(queries).take(count) {
        *radiance = stub::environment(l, query.direction, query.perceptual_roughness);
    }
    let ambient = load3(l, batch, "irradiance");
    let irradiance = stub_irradiance(l, surface.normal);
    found.set3("iblIrradiance", store3::<L>(irradiance));
    found.set3("radiance", store3::<L>(radiance[0]));
    found.set3("clearcoatRadiance", store3::<L>(radiance[1]));
    let light = legacy::Indirect { ambient, irradiance, radiance: radiance[0], coat_radiance: radiance[1] };
    let terms = legacy::indirect_terms(l, &surface, &light);
    found.set3("indirectDiffuse", store3::<L>(terms.diffuse));
    found.set3("indirectSpecular", store3::<L>(terms.specular));
    let outgoing = terms.diffuse + terms.specular;
    found.set3("outgoing", store3::<L>(outgoing));
    found
}

#[inline(always)]
fn current_surface<L: Lanes>(l: L, dfg: &Table<2>, batch: &Batch<'_>, found: &mut Found) -> Surface<L> {
    let data = SurfaceData {
        color: load3(l, batch, "diffuse"),
        metalness: load(l, batch, "metalness"),
        roughness: load(l, batch, "roughness"),
        geometry_roughness: l.zero(),
        ior: load(l, batch, "ior"),
        specular_intensity: load(l, batch, "specularIntensity"),
        specular_color: load3(l, batch, "specularColor"),
        coat: batch.is_on("clearcoat_on").then(|| Coat {
            factor: load(l, batch, "clearcoat"),
            roughness: load(l, batch, "clearcoatRoughness"),
            normal: load3(l, batch, "Ncc"),
        }),
        sheen: batch.is_on("sheen_on").then(|| Sheen {
            color: load3(l, batch, "sheenColor"),
            roughness: load(l, batch, "sheenRoughness"),
        }),
        iridescence: batch.is_on("iridescence_on").then(|| Iridescence {
            factor: load(l, batch, "iridescence"),
            ior: load(l, batch, "iridescenceIOR"),
            thickness: load(l, batch, "iridescenceThickness"),
        }),
        anisotropy: batch.is_on("anisotropy_on").then(|| Anisotropy {
            vector: ["anisotropyVec_x", "anisotropyVec_y"].map(|name| load(l, batch, name)),
            tangent: load3(l, batch, "T"),
            bitangent: load3(l, batch, "B"),
        }),
    };
    let surface = three::surface(l, &data, load3(l, batch, "N"), load3(l, batch, "V"), dfg);
    let zero = l.zero();
    found.set3("m_diffuseColor", store3::<L>(surface.diffuse_color));
    found.set3("m_diffuseContribution", store3::<L>(surface.diffuse_contribution));
    found.set3("m_specularColor", store3::<L>(surface.specular_color));
    found.set3("m_specularColorBlended", store3::<L>(surface.specular_color_blended));
    found.set("m_specularF90", surface.specular_f90.to_array());
    found.set("m_roughness", surface.roughness.to_array());
    let (alpha_t, tangent) = match &surface.anisotropy {
        Some(anisotropy) => (anisotropy.alpha_t, anisotropy.tangent),
        None => (zero, Vec3::uniform(zero)),
    };
    found.set("m_alphaT", alpha_t.to_array());
    found.set3("m_anisotropyT", store3::<L>(tangent));
    let films = match &surface.film {
        Some(film) => [film.fresnel, film.f0_dielectric, film.f0_metallic],
        None => [Vec3::uniform(zero); 3],
    };
    for (name, value) in
        ["iridescenceFresnel", "iridescenceF0Dielectric", "iridescenceF0Metallic"].into_iter().zip(films)
    {
        found.set3(name, store3::<L>(value));
    }
    found.set("dfg_x", surface.dfg[0].to_array());
    found.set("dfg_y", surface.dfg[1].to_array());
    found.set3("multiScatteringCompensation", store3::<L>(surface.multi_scattering_compensation));
    let coat = match &surface.coat {
        Some(c) => [c.factor, c.roughness, c.n_dot_v, c.fresnel, c.dfg[0], c.dfg[1]],
        None => [zero; 6],
    };
    found.set("m_clearcoat", coat[0].to_array());
    found.set("m_clearcoatRoughness", coat[1].to_array());
    found.set("dotNVcc", coat[2].to_array());
    found.set3("Fcc", store3::<L>(Vec3::uniform(coat[3])));
    found.set("ccDfg_x", coat[4].to_array());
    found.set("ccDfg_y", coat[5].to_array());
    surface
}

#[inline(always)]
fn store_terms<L: Lanes>(l: L, found: &mut Found, kind: &str, surface: &Surface<L>, terms: &Terms<L>) {
    let lower = kind.to_lowercase();
    found.set3(&format!("{lower}Diffuse"), store3::<L>(terms.diffuse));
    found.set3(&format!("{lower}Specular"), store3::<L>(terms.specular));
    found.set3(&format!("sheenSpecular{kind}"), store3::<L>(terms.sheen));
    found.set3(&format!("clearcoatSpecular{kind}"), store3::<L>(terms.coat));
    found.set3("outgoing", store3::<L>(three::outgoing_light(l, surface, terms)));
}

#[inline(always)]
fn current_direct_on<L: Lanes>(l: L, dfg: &Table<2>, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = current_surface(l, dfg, batch, &mut found);
    let light = load3(l, batch, "L");
    let color = load3(l, batch, "lightColor");
    store_terms(l, &mut found, "Direct", &surface, &three::direct_terms(l, &surface, light, color));
    found
}

#[inline(always)]
fn current_indirect_on<L: Lanes>(l: L, dfg: &Table<2>, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = current_surface(l, dfg, batch, &mut found);
    let mut radiance = [Vec3::zero(l); 2];
    let (queries, count) = three::environment_queries(l, &surface);
    for (radiance, query) in radiance.iter_mut().zip(queries).take(count) {
        *radiance = stub::environment(l, query.direction, query.perceptual_roughness);
    }
    let ambient = load3(l, batch, "irradiance");
    let irradiance = stub_irradiance(l, surface.normal);
    found.set3("iblIrradiance", store3::<L>(irradiance));
    found.set3("radiance", store3::<L>(radiance[0]));
    found.set3("clearcoatRadiance", store3::<L>(radiance[1]));
    let light = Indirect { ambient, irradiance, radiance: radiance[0], coat_radiance: radiance[1] };
    store_terms(l, &mut found, "Indirect", &surface, &three::indirect_terms(l, &surface, &light));
    found
}
