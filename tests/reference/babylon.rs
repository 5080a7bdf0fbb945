//! Babylon.js: the functions of the shading pass on the rows of `babylon_*`.

use super::stub;
use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::coat::babylon::{
    self, AaRoughness, AmbientOcclusion, Anisotropy, Coat, CoatSurface, DiffuseModel, Environment, Lookups,
    Options, Surface, SurfaceData, Tint,
};

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "babylon_direct", uniform: DIRECT, run: direct, skipped: &[] },
    Adapter { table: "babylon_ibl", uniform: IBL, run: ibl, skipped: &[] },
];

/// Columns that all rows of a vector must share. Whether the coat's index is 1.5 is not among them.
const DIRECT: &[&str] = &[
    "in_clearCoat_on",
    "in_remapF0_on",
    "in_tint_on",
    "in_coatNormal_on",
    "in_bump_on",
    "in_specularAA_on",
    "in_legacyEnergy_on",
    "in_energyConservation_on",
    "in_heightCorrelated_on",
    "in_diffuseModel",
    "in_anisotropy_on",
    "in_anisotropyLegacy_on",
    "in_softLight_on",
];
/// As [`DIRECT`], of the environment.
const IBL: &[&str] = &[
    "in_clearCoat_on",
    "in_remapF0_on",
    "in_tint_on",
    "in_coatNormal_on",
    "in_bump_on",
    "in_specularAA_on",
    "in_legacyEnergy_on",
    "in_energyConservation_on",
    "in_heightCorrelated_on",
    "in_diffuseModel",
    "in_anisotropy_on",
    "in_anisotropyLegacy_on",
    "in_environmentBrdf_on",
    "in_mixIrradiance_on",
    "in_irradianceInVertex_on",
    "in_linearSpecular_on",
    "in_radianceOcclusion_on",
    "in_horizonOcclusion_on",
    "in_ao_on",
    "in_aoGray_on",
];

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

/// The switches of a row. Those that a table does not have are off.
fn options(batch: &Batch<'_>) -> Options {
    Options {
        legacy_energy: batch.is_on("legacyEnergy_on"),
        energy_conservation: batch.is_on("energyConservation_on"),
        height_correlated: batch.is_on("heightCorrelated_on"),
        diffuse: match batch.get("diffuseModel")[0] as u8 {
            0 => DiffuseModel::Eon,
            1 => DiffuseModel::Burley,
            2 => DiffuseModel::Lambert,
            _ => DiffuseModel::Legacy,
        },
        legacy_anisotropy: batch.is_on("anisotropyLegacy_on"),
        soft_lights: batch.is_on("softLight_on"),
        mixes_irradiance: batch.is_on("mixIrradiance_on"),
        irradiance_in_vertex: batch.is_on("irradianceInVertex_on"),
        linear_specular: batch.is_on("linearSpecular_on"),
        radiance_occlusion: batch.is_on("radianceOcclusion_on"),
        horizon_occlusion: batch.is_on("horizonOcclusion_on"),
    }
}

#[inline(always)]
fn store_aa<L: Lanes>(found: &mut Found, prefix: &str, aa: &AaRoughness<L>) {
    let name = |rest: &str| if prefix.is_empty() { format!("aa{rest}") } else { format!("{prefix}Aa{rest}") };
    found.set(&name("Roughness"), aa.perceptual.to_array());
    found.set(&name("AlphaG"), aa.alpha.to_array());
}

#[inline(always)]
fn store_coat<L: Lanes>(l: L, found: &mut Found, coat: Option<&CoatSurface<L>>) {
    let (zero, one) = (l.zero(), l.splat(1.0));
    let none = AaRoughness { perceptual: zero, alpha: zero };
    store_aa(found, "cc", coat.map_or(&none, |c| &c.aa));
    found.set("ccNdotV", coat.map_or(zero, |c| c.n_dot_v).to_array());
    found.set("ccAlphaG", coat.map_or(zero, |c| c.alpha_g).to_array());
    found.set("conservationFactor", coat.map_or(one, |c| c.conservation_factor).to_array());
    found.set3("ccEnergyFactor", store3::<L>(coat.map_or(Vec3::uniform(one), |c| c.energy_factor)));
    let tint = coat.and_then(|c| c.tint.as_ref());
    found.set3("extinction", store3::<L>(tint.map_or(Vec3::uniform(zero), |t| t.extinction)));
    found.set("ccNdotVRefract", tint.map_or(zero, |t| t.n_dot_v_refract).to_array());
    found.set3("absorptionView", store3::<L>(tint.map_or(Vec3::uniform(one), |t| t.absorption)));
}

#[inline(always)]
fn surface<L: Lanes>(l: L, batch: &Batch<'_>, has_table: bool, found: &mut Found) -> Surface<L> {
    let get = |name: &str| load(l, batch, name);
    let get3 = |name: &str| load3(l, batch, name);
    let has_slopes = batch.is_on("specularAA_on");
    let tint = batch.is_on("tint_on").then(|| Tint {
        color: get3("tintColor"),
        at_distance: get("tintAtDistance"),
        thickness: get("tintThickness"),
    });
    let geometric_normal = get3("Ng");
    let normal_mapped = batch.is_on("bump_on");
    let data = SurfaceData {
        base_color: get3("baseColor"),
        metallic: get("metallic"),
        roughness: get("roughness"),
        ior: get("ior"),
        specular_weight: get("specularWeight"),
        specular_color: get3("specularColor"),
        diffuse_roughness: get("diffuseRoughness"),
        normal_slope: has_slopes.then(|| get("aaSlope")),
        geometric_normal,
        normal_mapped,
        coat: batch.is_on("clearCoat_on").then(|| Coat {
            intensity: get("clearCoat"),
            roughness: get("clearCoatRoughness"),
            ior: get("clearCoatIor"),
            normal: if batch.is_on("coatNormal_on") { get3("Nc") } else { geometric_normal },
            normal_slope: has_slopes.then(|| get("ccAaSlope")),
            remaps_f0: batch.is_on("remapF0_on"),
            tint,
        }),
        anisotropy: batch.is_on("anisotropy_on").then(|| Anisotropy {
            intensity: get("anisotropy"),
            direction: [get("anisoDir_x"), get("anisoDir_y")],
            tangent: get3("T"),
            bitangent: get3("B"),
        }),
    };
    let normal = if normal_mapped { get3("N") } else { geometric_normal };
    let lookups = Lookups { base: [get("brdf_x"), get("brdf_y")], coat: [get("ccBrdf_x"), get("ccBrdf_y")] };
    let lookups = if has_table { Some(&lookups) } else { None };
    let surface = babylon::surface_with_lookups(l, &options(batch), &data, normal, get3("V"), lookups);

    let zero = l.zero();
    found.set3("surfaceAlbedo", store3::<L>(surface.surface_albedo));
    found.set("reflectanceF0", surface.reflectance_f0.to_array());
    found.set3("F0", store3::<L>(surface.f0));
    found.set3("F90", store3::<L>(Vec3::uniform(surface.f90)));
    found.set("perceptualRoughness", surface.roughness.to_array());
    found.set("alphaG", surface.alpha_g.to_array());
    store_aa(found, "", &surface.aa);
    found.set("NdotV", surface.n_dot_v.to_array());
    found.set3("F0Coated", store3::<L>(surface.f0_coated));
    found.set3("energyFactor", store3::<L>(surface.energy_factor));
    found.set3("baseEnergyFactor", store3::<L>(Vec3::uniform(surface.base_energy_factor)));
    let frame = match &surface.anisotropy {
        Some(anisotropy) => [anisotropy.tangent, anisotropy.bitangent, anisotropy.normal],
        None => [Vec3::uniform(zero); 3],
    };
    for (name, vector) in ["anisotropicT", "anisotropicB", "anisotropicN"].into_iter().zip(frame) {
        found.set3(name, store3::<L>(vector));
    }
    store_coat(l, found, surface.coat.as_ref());
    surface
}

#[inline(always)]
fn direct_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = surface(l, batch, true, &mut found);
    let (light, color) = (load3(l, batch, "L"), load3(l, batch, "lightColor"));
    // Light from afar, at distance 1.
    let extent = load(l, batch, "lightRadius");
    let terms = babylon::direct_terms(l, &surface, light, color, extent);
    let (zero, one) = (l.zero(), l.splat(1.0));
    found.set("NdotL", terms.n_dot_l.to_array());
    found.set("NdotH", terms.n_dot_h.to_array());
    found.set("VdotH", terms.v_dot_h.to_array());
    found.set("LdotV", terms.l_dot_v.to_array());
    found.set("lightRoughness", terms.light_roughness.to_array());
    found.set("specRoughness", terms.specular_roughness.to_array());
    found.set3("diffuseLight", store3::<L>(terms.diffuse_light));
    found.set3("diffuseBeforeCoat", store3::<L>(terms.diffuse_before_coat));
    found.set("D", terms.distribution.to_array());
    found.set("Vis", terms.visibility.to_array());
    found.set3("fresnel", store3::<L>(terms.fresnel));
    found.set3("specularBeforeCoat", store3::<L>(terms.specular_before_coat));
    found.set3("diffuseLit", store3::<L>(terms.diffuse));
    found.set3("specularLit", store3::<L>(terms.specular));
    found.set3("finalDiffuse", store3::<L>(terms.final_diffuse));
    found.set3("finalSpecular", store3::<L>(terms.final_specular));
    found.set3("finalClearCoat", store3::<L>(terms.final_coat));
    let [along, across] = terms.alphas.unwrap_or([zero; 2]);
    found.set("alphaT", along.to_array());
    found.set("alphaB", across.to_array());
    let coat = terms.coat.as_ref();
    found.set("ccLightRoughness", coat.map_or(zero, |c| c.light_roughness).to_array());
    found.set("ccSpecRoughness", coat.map_or(zero, |c| c.specular_roughness).to_array());
    found.set("ccNdotL", coat.map_or(zero, |c| c.n_dot_l).to_array());
    found.set("ccNdotH", coat.map_or(zero, |c| c.n_dot_h).to_array());
    found.set("ccFresnel", coat.map_or(zero, |c| c.fresnel).to_array());
    found.set("ccD", coat.map_or(zero, |c| c.distribution).to_array());
    found.set("ccVis", coat.map_or(zero, |c| c.visibility).to_array());
    found.set3("ccLobe", store3::<L>(coat.map_or(Vec3::uniform(zero), |c| c.lobe)));
    found.set("ccAttenuation", coat.map_or(one, |c| c.attenuation).to_array());
    found.set("ccNdotLRefract", coat.map_or(zero, |c| c.n_dot_l_refract).to_array());
    found.set3("absorption", store3::<L>(coat.map_or(Vec3::uniform(one), |c| c.absorption)));
    found.set3("color", store3::<L>(babylon::direct(l, &surface, light, color, extent)));
    found
}

#[inline(always)]
fn ibl_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let surface = surface(l, batch, batch.is_on("environmentBrdf_on"), &mut found);
    let (zero, one) = (l.zero(), l.splat(1.0));
    let (queries, count) = babylon::environment_queries(l, &surface);
    let linear = surface.options.linear_specular;
    let (width, scale) = (load(l, batch, "cubeWidth"), load(l, batch, "lodScale"));
    let coat = surface.coat.as_ref();
    let alphas = if linear {
        [surface.roughness, coat.map_or(zero, |c| c.roughness)]
    } else {
        [surface.alpha_g, coat.map_or(zero, |c| c.alpha_g)]
    };
    let names = [
        ["lod", "reflectionDir", "lookupRoughness", "radiance"],
        ["ccLod", "ccReflectionDir", "ccLookupRoughness", "ccRadiance"],
    ];
    let mut radiance = [Vec3::uniform(zero); 2];
    for k in 0..2 {
        let [lod, direction, roughness, seen] = names[k];
        let asked = k < count;
        let query = queries[k];
        if asked {
            radiance[k] = stub::environment(l, query.direction, query.perceptual_roughness);
        }
        let level = if asked { babylon::lod(l, linear, alphas[k], width, scale) } else { zero };
        found.set(lod, level.to_array());
        found.set3(direction, store3::<L>(if asked { query.direction } else { Vec3::uniform(zero) }));
        found.set(roughness, if asked { query.perceptual_roughness } else { zero }.to_array());
        found.set3(seen, store3::<L>(radiance[k]));
    }
    let direction = babylon::irradiance_direction(l, &surface);
    let irradiance = stub::environment(l, direction, one);
    found.set3("irradianceDir", store3::<L>(direction));
    found.set3("irradiance", store3::<L>(irradiance));
    let occlusion = if !batch.is_on("ao_on") {
        AmbientOcclusion::gray(l, one)
    } else if batch.is_on("aoGray_on") {
        AmbientOcclusion::gray(l, load(l, batch, "ao_x"))
    } else {
        AmbientOcclusion::colored(l, load3(l, batch, "ao"))
    };
    found.set3("ambientOcclusion", store3::<L>(occlusion.color));
    let environment = Environment { irradiance, radiance: radiance[0], coat_radiance: radiance[1] };
    let terms = babylon::indirect_terms(l, &surface, &environment, &occlusion);
    found.set3("environmentRadiance", store3::<L>(terms.environment_radiance));
    found.set3("baseReflectance", store3::<L>(Vec3::uniform(terms.base_reflectance)));
    found.set3("specularReflectance", store3::<L>(terms.specular_reflectance));
    found.set("radianceOcclusion", terms.radiance_occlusion.to_array());
    found.set("horizonOcclusion", terms.horizon_occlusion.to_array());
    found.set("ccHorizonOcclusion", terms.coat_horizon_occlusion.to_array());
    found.set3("ccReflectance", store3::<L>(Vec3::uniform(terms.coat_reflectance)));
    found.set3("finalIrradiance", store3::<L>(terms.final_irradiance));
    found.set3("finalRadiance", store3::<L>(terms.final_radiance));
    found.set3("finalClearCoatRadiance", store3::<L>(terms.final_coat_radiance));
    found.set3("color", store3::<L>(babylon::color(l, &terms)));
    found
}
