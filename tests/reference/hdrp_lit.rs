//! Unity HDRP Lit: `hdrp_lit_coat`.

use super::helpers::{FGD, load, load3, store3};
use super::stub;
use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::Vec3;
use overcoat_shading::coat::hdrp_lit::{
    self as lit, Anisotropy, EnvironmentQuery, Iridescence, Occlusion, Reflectance, Surface, SurfaceData,
};

pub const ADAPTERS: &[Adapter] =
    &[Adapter { table: "hdrp_lit_coat", uniform: &["in_materialFeatures"], run: coat, skipped: &[] }];

fn coat(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => coat_on(l, batch))
}

/// Bits of `materialFeatures`.
const SPECULAR_COLOR: u32 = 2;
const ANISOTROPY: u32 = 16;
const IRIDESCENCE: u32 = 32;
const CLEAR_COAT: u32 = 64;

#[inline(always)]
fn material<L: Lanes>(l: L, batch: &Batch<'_>) -> SurfaceData<L> {
    let features = batch.get("materialFeatures")[0] as u32;
    let has = |bit: u32| features & bit != 0;
    let reflectance = if has(SPECULAR_COLOR) {
        Reflectance::Specular { color: load3(l, batch, "specularColor") }
    } else {
        Reflectance::Metallic {
            metallic: load(l, batch, "metallic"),
            dielectric_f0: Vec3::uniform(l.splat(lit::DIELECTRIC_F0)),
        }
    };
    SurfaceData {
        base_color: load3(l, batch, "baseColor"),
        reflectance,
        perceptual_smoothness: load(l, batch, "perceptualSmoothness"),
        anisotropy: has(ANISOTROPY)
            .then(|| Anisotropy { strength: load(l, batch, "anisotropy"), tangent: load3(l, batch, "T") }),
        iridescence: has(IRIDESCENCE).then(|| Iridescence {
            mask: load(l, batch, "iridescenceMask"),
            thickness: load(l, batch, "iridescenceThickness"),
        }),
        coat_mask: has(CLEAR_COAT).then(|| load(l, batch, "coatMask")),
        transmittance: None,
    }
}

/// The columns of the conversion and of what depends on the view.
fn store_surface<L: Lanes>(l: L, found: &mut Found, data: &SurfaceData<L>, surface: &Surface<L>) {
    let Surface { bsdf, pre, .. } = surface;
    found.set3("diffuseColor", store3::<L>(bsdf.diffuse_color));
    found.set3("convFresnel0", store3::<L>(lit::convert_surface_data(l, data).fresnel0));
    found.set3("fresnel0", store3::<L>(bsdf.fresnel0));
    found.set3("iblR", store3::<L>(pre.ibl_r));
    found.set3("specularFGD", store3::<L>(pre.specular_fgd));
    for (name, value) in [
        ("perceptualRoughness", bsdf.perceptual_roughness),
        ("roughnessT", bsdf.roughness[0]),
        ("roughnessB", bsdf.roughness[1]),
        ("NdotV", pre.n_dot_v),
        ("partLambdaV", pre.part_lambda_v),
        ("energyCompensation", pre.energy_compensation),
        ("iblPerceptualRoughness", pre.ibl_perceptual_roughness),
        ("diffuseFGD", pre.diffuse_fgd),
    ] {
        found.set(name, value.to_array());
    }
    // Columns of the coat are 0 in the table for a material without one.
    let none = [0.0; LANES];
    found.set("coatRoughness", bsdf.coat.map_or(none, |c| c.roughness.to_array()));
    found.set("coatPartLambdaV", pre.coat.map_or(none, |c| c.part_lambda_v.to_array()));
    found.set3("coatIblR", pre.coat.map_or([none; 3], |c| store3::<L>(c.ibl_r)));
    found.set("coatIblF", pre.coat.map_or(none, |c| c.ibl_f.to_array()));
}

#[inline(always)]
fn coat_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let data = material(l, batch);
    let surface = lit::surface(l, &FGD, &data, load3(l, batch, "N"), load3(l, batch, "V"));
    store_surface(l, &mut found, &data, &surface);

    let (light, min_roughness) = (load3(l, batch, "L"), load(l, batch, "lightMinRoughness"));
    let bsdf = lit::evaluate_bsdf(l, &surface, light, min_roughness);
    found.set3("diffR", store3::<L>(Vec3::uniform(bsdf.diffuse_reflected)));
    found.set3("specR", store3::<L>(bsdf.specular_reflected));
    found.set3("diffT", store3::<L>(Vec3::uniform(bsdf.diffuse_transmitted)));
    let direct = lit::direct(l, &surface, light, load3(l, batch, "lightColor"), min_roughness);
    found.set3("litDiffuse", store3::<L>(direct.diffuse));
    found.set3("litSpecular", store3::<L>(direct.specular));

    let env = lit::environment(
        l,
        &surface,
        #[inline(always)]
        |query: EnvironmentQuery<L>| stub::environment(l, query.direction, query.perceptual_roughness),
    );
    found.set3("env", store3::<L>(env));
    let baked_gi = load3(l, batch, "bakedDiffuse");
    found.set3("bakedDiffuse", store3::<L>(lit::baked_diffuse(l, &surface, baked_gi)));
    let occlusion = Occlusion {
        ambient: load(l, batch, "ambientOcclusion"),
        specular: load(l, batch, "specularOcclusion"),
        screen_space: load(l, batch, "ssAO"),
        direct_strength: load(l, batch, "directAOParam"),
        specular_blend: l.splat(1.0),
    };
    let output = lit::compose(l, &surface, &direct, env, baked_gi, Vec3::zero(l), &occlusion);
    found.set3("finalDiffuse", store3::<L>(output.diffuse));
    found.set3("finalSpecular", store3::<L>(output.specular));
    found
}
