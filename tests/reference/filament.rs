//! Filament: `filament_*` and `filament2018`.

use super::stub;
use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::coat::filament::standard::{
    Anisotropy, Coat, EnvironmentQuery, Sheen, Surface, SurfaceData,
};
use overcoat_shading::coat::filament::{Quality, cloth, dielectric_f0, f0_clear_coat_to_surface, standard};
use overcoat_shading::coat::filament_2018::{self, Attenuation};

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "filament_direct", uniform: SWITCHES, run: standard_direct, skipped: &[] },
    Adapter { table: "filament_ibl", uniform: SWITCHES, run: standard_ibl, skipped: &[] },
    Adapter { table: "filament_cloth", uniform: CLOTH_SWITCHES, run: cloth_direct, skipped: &[] },
    Adapter { table: "filament_cloth_ibl", uniform: CLOTH_SWITCHES, run: cloth_ibl, skipped: &[] },
    Adapter { table: "filament2018", uniform: &["in_modifyF0"], run: document, skipped: &[] },
];

/// Columns that all rows of a vector must share.
const SWITCHES: &[&str] = &[
    "in_mobile",
    "in_clearCoat_on",
    "in_coatNormal_on",
    "in_iorChange_on",
    "in_coatRoughness_on",
    "in_anisotropy_on",
    "in_sheen_on",
];
/// As [`SWITCHES`], of cloth.
const CLOTH_SWITCHES: &[&str] = &["in_mobile", "in_subsurfaceColor_on"];

fn standard_direct(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => standard_direct_on(l, batch))
}
fn standard_ibl(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => standard_ibl_on(l, batch))
}
fn cloth_direct(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => cloth_direct_on(l, batch))
}
fn cloth_ibl(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => cloth_ibl_on(l, batch))
}

fn document(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => document_on(l, batch))
}

fn quality(batch: &Batch<'_>) -> Quality {
    if batch.is_on("mobile") { Quality::Mobile } else { Quality::Desktop }
}

#[inline(always)]
fn load<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> L::F {
    l.load(&batch.get(name))
}

#[inline(always)]
fn load3<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> V3<L> {
    Vec3::from_array(batch.get3(name)).map(|c| l.load(&c))
}

/// Sets columns from lane numbers.
struct Columns(Found);

impl Columns {
    fn one<L: Lanes>(&mut self, _: L, name: &str, value: L::F) {
        self.0.set(name, value.to_array());
    }
    fn three<L: Lanes>(&mut self, _: L, name: &str, value: V3<L>) {
        self.0.set3(name, value.map(Float::to_array).to_array());
    }
}

#[inline(always)]
fn stub_query<L: Lanes>(l: L, query: EnvironmentQuery<L>) -> V3<L> {
    stub::environment(l, query.direction, query.perceptual_roughness)
}

#[inline(always)]
fn standard_surface<L: Lanes>(l: L, batch: &Batch<'_>) -> Surface<L> {
    let on = |name: &str| batch.is_on(&format!("{name}_on"));
    let coat_normal = load3(l, batch, "Nc");
    let data = SurfaceData {
        base_color: load3(l, batch, "baseColor"),
        metallic: load(l, batch, "metallic"),
        perceptual_roughness: load(l, batch, "roughness"),
        dielectric_f0: Vec3::uniform(dielectric_f0(l, load(l, batch, "reflectance"))),
        coat: on("clearCoat").then(|| Coat {
            mask: load(l, batch, "clearCoat"),
            perceptual_roughness: load(l, batch, "clearCoatRoughness"),
            normal: on("coatNormal").then_some(coat_normal),
            ior_change: on("iorChange"),
            roughens_base: on("coatRoughness"),
            own_sine: false,
        }),
        anisotropy: on("anisotropy").then(|| Anisotropy {
            strength: load(l, batch, "anisotropy"),
            direction: load3(l, batch, "T"),
            geometric_normal: coat_normal,
        }),
        sheen: on("sheen").then(|| Sheen {
            color: load3(l, batch, "sheenColor"),
            roughness: load(l, batch, "sheenRoughness"),
        }),
    };
    let parameters =
        standard::parameters(l, quality(batch), &data, load3(l, batch, "N"), load3(l, batch, "V"));
    standard::surface(l, &parameters, load3(l, batch, "dfg"), load(l, batch, "sheenDFGz"))
}

/// The columns that describe the surface.
#[inline(always)]
fn store_standard<L: Lanes>(l: L, found: &mut Columns, surface: &Surface<L>) {
    let it = &surface.parameters;
    let zero = l.zero();
    found.three(l, "diffuseColor", it.diffuse_color);
    found.three(l, "f0", it.f0);
    found.one(l, "perceptualRoughness", it.perceptual_roughness);
    found.one(l, "roughness", it.roughness);
    found.one(l, "ccPerceptualRoughness", it.coat.map_or(zero, |c| c.perceptual_roughness));
    found.one(l, "ccRoughness", it.coat.map_or(zero, |c| c.roughness));
    found.three(l, "energyCompensation", surface.energy_compensation);
    found.one(l, "sheenScaling", if it.sheen.is_some() { surface.sheen_scaling } else { zero });
    found.one(l, "NoV", it.n_dot_v);
}

#[inline(always)]
fn standard_direct_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Columns(Found::default());
    let surface = standard_surface(l, batch);
    store_standard(l, &mut found, &surface);
    let light = load3(l, batch, "L");
    let lobes = standard::lobes(l, &surface, light);
    let zero = l.zero();
    found.one(l, "NoL", lobes.n_dot_l);
    found.one(l, "NoH", lobes.n_dot_h);
    found.one(l, "LoH", lobes.l_dot_h);
    found.one(l, "D", lobes.d);
    found.one(l, "V", lobes.v);
    found.three(l, "F", lobes.f);
    found.three(l, "Fr", lobes.specular);
    found.three(l, "Fd", lobes.diffuse);
    found.one(l, "sheenD", lobes.sheen.map_or(zero, |s| s.d));
    found.one(l, "sheenV", lobes.sheen.map_or(zero, |s| s.v));
    let coat = lobes.coat;
    found.one(l, "ccNoH", coat.map_or(zero, |c| c.n_dot_h));
    let separate = batch.is_on("coatNormal_on");
    found.one(l, "ccNoL", coat.filter(|_| separate).map_or(zero, |c| c.n_dot_l));
    found.one(l, "ccD", coat.map_or(zero, |c| c.d));
    found.one(l, "ccV", coat.map_or(zero, |c| c.v));
    found.one(l, "Fcc", coat.map_or(zero, |c| c.f));
    found.one(l, "ccLobe", coat.map_or(zero, |c| c.value));
    found.one(l, "attenuation", coat.map_or(l.splat(1.0), |c| c.f.one_minus()));
    let color = load3(l, batch, "lightColor");
    let attenuation = load(l, batch, "lightAttenuation");
    found.three(l, "color", standard::direct(l, &surface, light, color * attenuation));
    found.0
}

#[inline(always)]
fn standard_ibl_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Columns(Found::default());
    let surface = standard_surface(l, batch);
    store_standard(l, &mut found, &surface);
    let (zero, one) = (l.zero(), l.splat(1.0));
    let base = surface.base_query(l);
    let radiance = stub_query(l, base);
    found.three(l, "E", surface.specular_dfg());
    found.three(l, "reflDir", base.direction);
    found.three(l, "radiance", radiance);
    let irradiance = stub::environment(l, load3(l, batch, "N"), one);
    let sheen_radiance = surface.sheen_query().map_or(Vec3::uniform(zero), |query| stub_query(l, query));
    // The original looks nothing up for a coat of mask 0.
    let coated = !load(l, batch, "clearCoat").eq(zero);
    let coat_radiance = surface
        .coat_query()
        .map_or(Vec3::uniform(zero), |query| Vec3::select(coated, stub_query(l, query), Vec3::uniform(zero)));
    let below = standard::base_indirect(l, &surface, irradiance, radiance, sheen_radiance);
    found.three(l, "FdBeforeCoat", below.diffuse);
    found.three(l, "FrBeforeCoat", below.specular);
    found.one(l, "ccNoV", surface.parameters.coat.map_or(zero, |c| coated.select(c.n_dot_v, zero)));
    found.one(l, "Fc", surface.coat_fresnel(l).unwrap_or(zero));
    found.one(l, "attenuation", surface.coat_fresnel(l).map_or(one, Float::one_minus));
    found.three(l, "ccRadiance", coat_radiance);
    let all = standard::coat_indirect(l, &surface, below, coat_radiance);
    found.three(l, "Fd", all.diffuse);
    found.three(l, "Fr", all.specular);
    let color = standard::indirect(l, &surface, irradiance, |query| stub_query(l, query), one);
    found.three(l, "color", color);
    found.0
}

#[inline(always)]
fn cloth_surface<L: Lanes>(l: L, batch: &Batch<'_>, found: &mut Columns) -> cloth::Surface<L> {
    let data = cloth::SurfaceData {
        base_color: load3(l, batch, "baseColor"),
        sheen_color: load3(l, batch, "sheenColor"),
        perceptual_roughness: load(l, batch, "roughness"),
        subsurface_color: batch.is_on("subsurfaceColor_on").then(|| load3(l, batch, "subsurfaceColor")),
    };
    let (normal, view) = (load3(l, batch, "N"), load3(l, batch, "V"));
    let dfg = load3(l, batch, "dfg");
    let surface = cloth::surface(l, quality(batch), &data, normal, view, |_, _| dfg.z);
    let (zero, one) = (l.zero(), l.splat(1.0));
    found.three(l, "diffuseColor", data.base_color);
    found.three(l, "f0", data.sheen_color);
    found.one(l, "perceptualRoughness", surface.perceptual_roughness);
    found.one(l, "roughness", surface.roughness);
    found.one(l, "NoV", surface.n_dot_v);
    // Columns that the model does not have.
    found.three(l, "energyCompensation", Vec3::uniform(one));
    for column in ["ccPerceptualRoughness", "ccRoughness", "sheenScaling"] {
        found.one(l, column, zero);
    }
    found.one(l, "attenuation", one);
    surface
}

#[inline(always)]
fn cloth_direct_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Columns(Found::default());
    let surface = cloth_surface(l, batch, &mut found);
    let light = load3(l, batch, "L");
    let lobes = cloth::lobes(l, &surface, light);
    found.one(l, "NoL", lobes.n_dot_l);
    found.one(l, "NoH", lobes.n_dot_h);
    found.one(l, "LoH", lobes.l_dot_h);
    found.one(l, "D", lobes.d);
    found.one(l, "V", lobes.v);
    found.three(l, "F", load3(l, batch, "sheenColor"));
    found.three(l, "Fr", lobes.specular);
    found.three(l, "Fd", lobes.diffuse);
    for column in ["sheenD", "sheenV", "ccNoH", "ccNoL", "ccD", "ccV", "Fcc", "ccLobe"] {
        found.one(l, column, l.zero());
    }
    let color = load3(l, batch, "lightColor");
    let attenuation = load(l, batch, "lightAttenuation");
    found.three(l, "color", cloth::direct(l, &surface, light, color * attenuation));
    found.0
}

#[inline(always)]
fn cloth_ibl_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Columns(Found::default());
    let surface = cloth_surface(l, batch, &mut found);
    let (zero, one) = (l.zero(), l.splat(1.0));
    let query = surface.query(l);
    let radiance = stub_query(l, query);
    let irradiance = stub::environment(l, load3(l, batch, "N"), one);
    let parts = cloth::indirect_parts(l, &surface, irradiance, radiance);
    found.three(l, "E", surface.specular_dfg());
    found.three(l, "reflDir", query.direction);
    found.three(l, "radiance", radiance);
    for suffix in ["BeforeCoat", ""] {
        found.three(l, &format!("Fd{suffix}"), parts.diffuse);
        found.three(l, &format!("Fr{suffix}"), parts.specular);
    }
    found.one(l, "ccNoV", zero);
    found.one(l, "Fc", zero);
    found.three(l, "ccRadiance", Vec3::uniform(zero));
    let color = cloth::indirect(l, &surface, irradiance, |query| stub_query(l, query), one);
    found.three(l, "color", color);
    found.0
}

/// The document's surface in one of its editions.
#[inline(always)]
fn document_surface<L: Lanes>(
    l: L,
    batch: &Batch<'_>,
    attenuation: Attenuation,
) -> filament_2018::Surface<L> {
    let data = filament_2018::SurfaceData {
        base_color: load3(l, batch, "baseColor"),
        metallic: load(l, batch, "metallic"),
        perceptual_roughness: load(l, batch, "perceptualRoughness"),
        dielectric_f0: Vec3::uniform(dielectric_f0(l, load(l, batch, "reflectance"))),
        coat: Some(filament_2018::Coat {
            mask: load(l, batch, "clearCoat"),
            perceptual_roughness: load(l, batch, "clearCoatPerceptualRoughness"),
            modify_f0: batch.is_on("modifyF0"),
            attenuation,
        }),
    };
    filament_2018::surface(l, &data, load3(l, batch, "N"), load3(l, batch, "V"))
}

#[inline(always)]
fn document_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Columns(Found::default());
    let light = load3(l, batch, "L");
    let color = load3(l, batch, "lightColor");
    for (form, attenuation) in [("FormA", Attenuation::Code), ("FormB", Attenuation::Later)] {
        let surface = document_surface(l, batch, attenuation);
        let lobes = filament_2018::lobes(l, &surface, light);
        let brdf = filament_2018::brdf(l, &surface, &lobes);
        found.three(l, &format!("brdf{form}"), color * brdf);
        let lit = filament_2018::direct(l, &surface, light, color);
        found.three(l, &format!("lit{form}"), lit);
        if attenuation == Attenuation::Later {
            continue;
        }
        let f0 = surface.f0;
        found.three(l, "f0", f0);
        found.three(l, "f0ThreeSteps", f0.map(|f0| filament_2018::f0_under_coat_by_index(l, f0)));
        found.three(l, "f0Combined", f0.map(|f0| filament_2018::f0_under_coat_combined(l, f0)));
        let fit = |quality| f0.map(|f0| f0_clear_coat_to_surface(l, quality, f0));
        found.three(l, "f0PolyDesktop", fit(Quality::Desktop));
        found.three(l, "f0PolyMobile", fit(Quality::Mobile));
        found.three(l, "f0Used", surface.f0_used);
        found.one(l, "roughness", surface.roughness);
        found.one(l, "NoV", surface.n_dot_v);
        found.one(l, "NoL", lobes.n_dot_l);
        found.one(l, "NoH", lobes.n_dot_h);
        found.one(l, "LoH", lobes.l_dot_h);
        found.one(l, "D", lobes.d);
        found.one(l, "V", lobes.v);
        found.three(l, "F", lobes.f);
        found.three(l, "Fd", lobes.diffuse);
        found.three(l, "Fr", lobes.specular);
        if let (Some(coat), Some(lobe)) = (surface.coat, lobes.coat) {
            found.one(l, "ccRoughness", coat.roughness);
            found.one(l, "Dc", lobe.d);
            found.one(l, "Vc", lobe.v);
            found.one(l, "Fc", lobe.f);
            found.one(l, "Frc", lobe.value);
        }
    }
    found.0
}
