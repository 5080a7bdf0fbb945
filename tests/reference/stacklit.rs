//! Unity HDRP StackLit: `stacklit_*` and `stacklit17_convert`.

use super::helpers::{FGD, load, load3, store3};
use super::stub;
use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::fresnel::ior_to_fresnel0;
use overcoat_shading::brdf::occlusion::VisibilityCone;
use overcoat_shading::coat::stacklit::{
    self, Adding, Anisotropy, BsdfData, COAT_LOBE, Cbsdf, Coat, DataOcclusion, DiffusionProfile, Frame,
    HazyGloss, Iridescence, Layers, Light, Lighting, Occlusion, Options, PreLight, Reflectance, Scattering,
    ScreenSpaceOcclusion, SecondLobe, SpecularOcclusion, SurfaceData, Transmission, Version,
};

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "stacklit_adding", uniform: UNIFORM_ADDING, run: adding, skipped: &[] },
    Adapter { table: "stacklit_direct", uniform: UNIFORM_DIRECT, run: direct, skipped: &[] },
    Adapter { table: "stacklit_ibl", uniform: UNIFORM_IBL, run: ibl, skipped: &[] },
    Adapter { table: "stacklit_sss_hazy", uniform: UNIFORM_PROFILE, run: scattering, skipped: &[] },
    Adapter { table: "stacklit17_convert", uniform: UNIFORM_PROFILE_17, run: scattering_17, skipped: &[] },
];

const UNIFORM_ADDING: &[&str] = &["in_cfg_coatNormalMap", "in_materialFeatures"];
const UNIFORM_DIRECT: &[&str] = &[
    "in_cfg_coatNormalMap",
    "in_cfg_recomputePerLight",
    "in_cfg_refractedAnglesForBase",
    "in_cfg_honorLightMinRoughness",
    "in_materialFeatures",
];
const UNIFORM_IBL: &[&str] = &[
    "in_cfg_coatNormalMap",
    "in_cfg_recomputePerLight",
    "in_cfg_refractedAnglesForBase",
    "in_cfg_honorLightMinRoughness",
    "in_cfg_specOccMethod",
    "in_materialFeatures",
];
/// A profile is one for all lanes: every row of these tables has its own.
const UNIFORM_PROFILE: &[&str] = &["in_materialFeatures", "row"];
const UNIFORM_PROFILE_17: &[&str] = &["in_materialFeatures", "in_useProfileIor", "row"];

fn adding(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => adding_on(l, batch))
}
fn direct(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => direct_on(l, batch))
}
fn ibl(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => ibl_on(l, batch))
}
fn scattering(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => scattering_on(l, batch, Version::V13))
}
fn scattering_17(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => scattering_on(l, batch, Version::Newest))
}

/// Bits of `materialFeatures`.
const ANISOTROPY: u32 = 4;
const COAT: u32 = 8;
const IRIDESCENCE: u32 = 16;
const SUBSURFACE: u32 = 32;
const TRANSMISSION: u32 = 64;
const COAT_NORMAL_MAP: u32 = 128;
const SPECULAR_COLOR: u32 = 256;
const HAZY_GLOSS: u32 = 512;

/// The original's switches: what the tables' programs were compiled with.
fn options(batch: &Batch<'_>, version: Version, occlusion_method: u32) -> Options {
    let cone = VisibilityCone::CosineWithBentCorrection;
    let specular_occlusion = match occlusion_method {
        0 => None,
        1 => Some((ScreenSpaceOcclusion::FromAmbientOcclusion, DataOcclusion::FromAmbientOcclusion)),
        method => {
            let data = DataOcclusion::ConeCone { cone, tilt_bent_normal: method == 3 };
            Some((ScreenSpaceOcclusion::FromAmbientOcclusion, data))
        }
    };
    Options {
        version,
        recompute_per_light: batch.is_on("cfg_recomputePerLight"),
        refracted_angles_for_base: batch.is_on("cfg_refractedAnglesForBase"),
        honor_light_min_roughness: batch.is_on("cfg_honorLightMinRoughness"),
        specular_occlusion: specular_occlusion
            .map(|(screen_space, data)| SpecularOcclusion { screen_space, data }),
        energy_conserving_specular: false,
        subsurface_scattering: true,
        // The rows with a mask of 0 went through the layers.
        zero_mask_is_uncoated: false,
        ..Options::default()
    }
}

#[inline(never)]
fn frame<L: Lanes>(l: L, batch: &Batch<'_>, has_geometric_normal: bool) -> Frame<L> {
    let normal = load3(l, batch, "N");
    let tangent = load3(l, batch, "T");
    Frame {
        normal,
        geometric_normal: if has_geometric_normal { load3(l, batch, "geomN") } else { normal },
        tangent,
        bitangent: normal.cross(tangent),
        view: load3(l, batch, "V"),
    }
}

#[inline(never)]
fn material<L: Lanes>(l: L, batch: &Batch<'_>, version: Version) -> SurfaceData<L> {
    let features = batch.get("materialFeatures")[0] as u32;
    let number = |name: &str| load(l, batch, name);
    let color = |name: &str| load3(l, batch, name);
    let uniform = |name: &str| batch.get(name)[0];
    let uniform3 = |name: &str| batch.get3(name).map(|c| c[0]);
    let has = |feature: u32| features & feature != 0;
    let one = l.splat(1.0);
    let scattering = has(SUBSURFACE | TRANSMISSION).then(|| Scattering {
        profile: DiffusionProfile {
            transmission_tint: uniform3("profileTint"),
            fresnel0: uniform("profileFresnel0"),
            shape: uniform3("profileShape"),
            thickness_remap_min: uniform("profileThicknessRemapMin"),
            thickness_remap_scale: uniform("profileThicknessRemapScale"),
            thin: uniform("profileThin") == 1.0,
            post_scatter: uniform("profilePostScatter") == 1.0,
        },
        use_profile_ior: version == Version::V13 || uniform("useProfileIor") == 1.0,
        subsurface_mask: has(SUBSURFACE).then(|| number("subsurfaceMask")),
        transmission: has(TRANSMISSION).then(|| Transmission {
            thickness: number("thickness"),
            mask: if version == Version::V13 { Vec3::uniform(one) } else { color("transmissionMask") },
        }),
    });
    SurfaceData {
        base_color: color("baseColor"),
        metallic: number("metallic"),
        reflectance: if has(SPECULAR_COLOR) {
            Reflectance::Specular { color: color("specularColor") }
        } else {
            Reflectance::Metallic {
                dielectric_f0: Vec3::uniform(ior_to_fresnel0(l, number("dielectricIor"), one)),
            }
        },
        smoothness: number("perceptualSmoothnessA"),
        second_lobe: Some(SecondLobe { smoothness: number("perceptualSmoothnessB"), mix: number("lobeMix") }),
        anisotropy: has(ANISOTROPY)
            .then(|| Anisotropy { a: number("anisotropyA"), b: number("anisotropyB") }),
        haze: has(HAZY_GLOSS).then(|| HazyGloss {
            haziness: number("haziness"),
            extent: number("hazeExtent"),
            max_dielectric_f0: number("hazyGlossMaxDielectricF0"),
        }),
        iridescence: has(IRIDESCENCE).then(|| Iridescence {
            mask: number("iridescenceMask"),
            thickness: number("iridescenceThickness"),
            coat_fixup_tir: number("iridescenceCoatFixupTIR"),
            coat_fixup_tir_clamp: number("iridescenceCoatFixupTIRClamp"),
        }),
        coat: has(COAT).then(|| Coat {
            mask: number("coatMask"),
            smoothness: number("coatPerceptualSmoothness"),
            ior: number("coatIor"),
            thickness: number("coatThickness"),
            extinction: color("coatExtinction"),
            normal: has(COAT_NORMAL_MAP).then(|| color("coatN")),
        }),
        scattering,
        occlusion: Occlusion::none(l, load3(l, batch, "N")),
    }
}

/// The model's first half, compiled once for each instruction set and not for each table.
#[inline(never)]
fn surface<L: Lanes>(l: L, options: &Options, data: &SurfaceData<L>, frame: &Frame<L>) -> PreLight<L> {
    l.run(
        #[inline(always)]
        || stacklit::surface(l, options, data, frame, &FGD),
    )
}

fn store_bsdf<L: Lanes>(l: L, found: &mut Found, bsdf: &BsdfData<L>) {
    found.set3("diffuseColor", store3::<L>(bsdf.diffuse_color));
    found.set3("fresnel0", store3::<L>(bsdf.fresnel0));
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("lobeMix", bsdf.lobe_mix);
    for (name, lobe) in ["A", "B"].into_iter().zip(&bsdf.lobes) {
        set(&format!("perceptualRoughness{name}"), lobe.perceptual_roughness);
        set(&format!("roughness{name}T"), lobe.roughness[0]);
        set(&format!("roughness{name}B"), lobe.roughness[1]);
        set(&format!("anisotropy{name}"), lobe.anisotropy);
    }
    let zero = l.zero();
    let coat = match &bsdf.coat {
        Some(coat) => [coat.mask, coat.ior, coat.thickness, coat.roughness],
        None => [zero; 4],
    };
    for (name, value) in ["coatMask", "coatIor", "coatThickness", "coatRoughness"].into_iter().zip(coat) {
        set(name, value);
    }
}

fn store_layers<L: Lanes>(found: &mut Found, layers: &Layers<L>) {
    found.set3("vLayerEnergyCoeffTOP", store3::<L>(Vec3::uniform(layers.top)));
    found.set3("vLayerEnergyCoeffBOTTOM", store3::<L>(layers.bottom));
    found.set3("diffuseEnergy", store3::<L>(layers.diffuse_energy));
    found.set3("fresnelIrid", store3::<L>(layers.iridescent));
    for (name, lobe) in ["A", "B"].into_iter().zip(&layers.lobes) {
        found.set(&format!("layeredRoughnessT_{name}"), lobe.roughness[0].to_array());
        found.set(&format!("layeredRoughnessB_{name}"), lobe.roughness[1].to_array());
    }
    found.set("layeredCoatRoughness", layers.coat_roughness.to_array());
}

/// Stores the columns that the tables of adding and of the environment share.
fn store_prelight<L: Lanes>(l: L, found: &mut Found, pre: &PreLight<L>) {
    store_layers(found, &pre.layers);
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("NdotV_base", pre.n_dot_v[0]);
    set("baseLayerNdotV", pre.base_layer_n_dot_v);
    set("bottomAngleFGD", pre.layers.bottom_cosine);
    set("diffuseFGD", l.splat(1.0));
    set("coatIeta", pre.bsdf.coat.as_ref().map_or(l.zero(), |coat| coat.ieta));
    for (k, name) in ["COAT", "A", "B"].into_iter().enumerate() {
        set(&format!("iblPerceptualRoughness{name}"), pre.lobes[k].perceptual_roughness);
    }
    for (name, lobe) in ["A", "B"].into_iter().zip(&pre.layers.lobes) {
        set(&format!("iblAnisotropy{name}"), lobe.anisotropy);
    }
}

#[inline(never)]
fn adding_of<L: Lanes>(l: L, pre: &PreLight<L>) -> Option<Adding<L>> {
    l.run(
        #[inline(always)]
        || pre.adding(l),
    )
}

#[inline(always)]
fn adding_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let options = options(batch, Version::V13, 0);
    let data = material(l, batch, Version::V13);
    let pre = surface(l, &options, &data, &frame(l, batch, true));
    store_bsdf(l, &mut found, &pre.bsdf);
    store_prelight(l, &mut found, &pre);
    let Some(adding) = adding_of(l, &pre) else { return found };
    for layer in 0..3 {
        let statistics = adding.statistics(l, layer);
        let state = adding.state_after(l, layer);
        let colors = ["R12_", "T12_", "R21_", "T21_"].into_iter().zip(statistics.energies);
        for (name, color) in colors.chain(["R0i_", "T0i_", "Ri0_", "Ti0_"].into_iter().zip(state.energies)) {
            found.set3(&format!("L{layer}_{name}"), store3::<L>(color));
        }
        let numbers = ["cti", "ctt"].into_iter().zip(statistics.cosines);
        let numbers =
            numbers.chain(["s_r12", "s_t12", "s_r21", "s_t21"].into_iter().zip(statistics.variances));
        let numbers = numbers.chain(["j12", "j21"].into_iter().zip(statistics.jacobians));
        let numbers = numbers.chain(["s_r0i", "s_t0i", "s_ti0"].into_iter().zip(state.variances));
        for (name, number) in numbers.chain([("m_rr", state.mean_rr)]) {
            found.set(&format!("L{layer}_{name}"), number.to_array());
        }
    }
    found
}

fn store_mask<L: Lanes>(found: &mut Found, name: &str, mask: L::M) {
    let bits = mask.bits();
    found.set(name, std::array::from_fn::<f32, LANES, _>(|k| f32::from(bits >> k & 1)));
}

#[inline(never)]
fn evaluate_bsdf<L: Lanes>(l: L, pre: &PreLight<L>, light: &Light<L>) -> Cbsdf<L> {
    l.run(
        #[inline(always)]
        || stacklit::evaluate_bsdf(l, pre, light),
    )
}

#[inline(never)]
fn lit<L: Lanes>(l: L, pre: &PreLight<L>, light: &Light<L>) -> (L::M, Lighting<L>) {
    l.run(
        #[inline(always)]
        || (stacklit::is_non_zero(l, pre, light.direction), stacklit::direct(l, pre, light)),
    )
}

#[inline(never)]
fn final_light<L: Lanes>(
    l: L,
    pre: &PreLight<L>,
    lit: &Lighting<L>,
    baked: &V3<L>,
) -> (V3<L>, V3<L>, Lighting<L>) {
    l.run(
        #[inline(always)]
        || {
            let behind = *baked * 0.5;
            let baked = stacklit::baked_diffuse(l, pre, *baked, behind);
            let environment = stacklit::environment(
                l,
                pre,
                #[inline(always)]
                |query| stub::environment(l, query.direction, query.perceptual_roughness),
            );
            let total = stacklit::compose(l, pre, lit, environment, baked, Vec3::zero(l));
            (baked, environment, total)
        },
    )
}

/// The functions for lights, and what a light changes.
fn store_light<L: Lanes>(l: L, found: &mut Found, pre: &PreLight<L>, light: &Light<L>) -> Lighting<L> {
    let bsdf = evaluate_bsdf(l, pre, light);
    found.set3("diffR", store3::<L>(bsdf.diffuse_reflected));
    found.set3("specR", store3::<L>(bsdf.specular_reflected));
    found.set3("diffT", store3::<L>(bsdf.diffuse_transmitted));
    let (shows, lit) = lit(l, pre, light);
    store_mask::<L>(found, "isNonZero", shows);
    found.set3("litDiffuse", store3::<L>(lit.diffuse));
    found.set3("litSpecular", store3::<L>(lit.specular));
    lit
}

#[inline(always)]
fn direct_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let options = options(batch, Version::V13, 0);
    let data = material(l, batch, Version::V13);
    let pre = surface(l, &options, &data, &frame(l, batch, true));
    let mut light = Light::new(l, load3(l, batch, "L"), load3(l, batch, "lightColor"));
    light.min_roughness = load(l, batch, "lightMinRoughness");
    store_light(l, &mut found, &pre, &light);
    // The table has the layers of the view, before the light raises or recomputes anything.
    store_layers(&mut found, &pre.layers);
    store_compensation(&mut found, &pre);
    found
}

fn store_compensation<L: Lanes>(found: &mut Found, pre: &PreLight<L>) {
    for (k, name) in ["COAT", "A", "B"].into_iter().enumerate() {
        let present = k != COAT_LOBE || pre.bsdf.coat.is_some();
        let factor = if present { store3::<L>(pre.lobes[k].energy_compensation) } else { [[0.0; 16]; 3] };
        found.set3(&format!("energyComp{name}"), factor);
    }
}

/// Baked light, environment and composition.
fn store_final<L: Lanes>(l: L, batch: &Batch<'_>, found: &mut Found, pre: &PreLight<L>, lit: &Lighting<L>) {
    let (baked, environment, total) = final_light(l, pre, lit, &load3(l, batch, "bakedDiffuse"));
    found.set3("env", store3::<L>(environment));
    found.set3("bakedDiffuse", store3::<L>(baked));
    found.set3("finalDiffuse", store3::<L>(total.diffuse));
    found.set3("finalSpecular", store3::<L>(total.specular));
}

#[inline(always)]
fn occlusion<L: Lanes>(l: L, batch: &Batch<'_>) -> Occlusion<L> {
    let mut occlusion = Occlusion::none(l, load3(l, batch, "N"));
    occlusion.ambient = load(l, batch, "ambientOcclusion");
    occlusion.screen_space = load(l, batch, "ssAO");
    occlusion.direct_strength = load(l, batch, "directAOParam");
    occlusion
}

#[inline(always)]
fn ibl_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let options = options(batch, Version::V13, batch.get("cfg_specOccMethod")[0] as u32);
    let mut data = material(l, batch, Version::V13);
    data.occlusion = occlusion(l, batch);
    data.occlusion.bent_normal = load3(l, batch, "bentN");
    data.occlusion.tilt_threshold = load(l, batch, "soFixupVisibilityRatioThreshold");
    data.occlusion.tilt_strength = load(l, batch, "soFixupStrengthFactor");
    let pre = surface(l, &options, &data, &frame(l, batch, true));
    store_prelight(l, &mut found, &pre);
    store_compensation(&mut found, &pre);
    for (k, name) in ["COAT", "A", "B"].into_iter().enumerate() {
        let lobe = &pre.lobes[k];
        let present = k != COAT_LOBE || pre.bsdf.coat.is_some();
        let mut set3 = |field: &str, value: V3<L>| {
            let value = if present { store3::<L>(value) } else { [[0.0; 16]; 3] };
            found.set3(&format!("{field}{name}"), value);
        };
        set3("specularFGD", lobe.specular_fgd);
        set3("hemiSpecOcc", lobe.specular_occlusion);
        set3("iblR", lobe.reflection);
        found.set(&format!("partLambdaV{name}"), lobe.part_lambda_v.to_array());
    }
    let light = Light::new(l, load3(l, batch, "L"), load3(l, batch, "lightColor"));
    let lit = store_light(l, &mut found, &pre, &light);
    store_final(l, batch, &mut found, &pre, &lit);
    found
}

#[inline(always)]
fn scattering_on<L: Lanes>(l: L, batch: &Batch<'_>, version: Version) -> Found {
    let mut found = Found::default();
    let options = options(batch, version, 0);
    let mut data = material(l, batch, version);
    data.occlusion = occlusion(l, batch);
    let pre = surface(l, &options, &data, &frame(l, batch, false));
    store_bsdf(l, &mut found, &pre.bsdf);
    let zero = Vec3::zero(l);
    found.set3("transmittance", store3::<L>(pre.bsdf.transmittance.unwrap_or(zero)));
    found.set3("modifiedDiffuseColorForSSS", store3::<L>(pre.bsdf.modified_diffuse_color));
    let light = Light::new(l, load3(l, batch, "L"), load3(l, batch, "lightColor"));
    let lit = store_light(l, &mut found, &pre, &light);
    store_final(l, batch, &mut found, &pre, &lit);
    found
}

/// One material, light and view, worked out by the original functions (the specification's examples).
mod examples {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    fn example() -> SurfaceData<Scalar> {
        let l = Scalar;
        let mut data = SurfaceData::plain(
            l,
            Vec3::splat(l, [0.8, 0.1, 0.1]),
            l.splat(0.9),
            l.splat(0.6),
            Vec3::splat(l, [0.0, 0.0, 1.0]),
        );
        data.second_lobe = Some(SecondLobe { smoothness: l.splat(0.3), mix: l.splat(0.3) });
        data.anisotropy = Some(Anisotropy { a: l.splat(0.5), b: l.splat(0.2) });
        data.coat = Some(Coat {
            mask: l.splat(0.8),
            smoothness: l.splat(0.9),
            ior: l.splat(1.5),
            thickness: l.splat(0.5),
            extinction: Vec3::splat(l, [0.1, 0.4, 0.8]),
            normal: None,
        });
        data
    }

    fn shade(options: &Options, data: &SurfaceData<Scalar>) -> (PreLight<Scalar>, Cbsdf<Scalar>, V3<Scalar>) {
        let l = Scalar;
        let up = Vec3::splat(l, [0.0, 0.0, 1.0]);
        let frame = Frame {
            normal: up,
            geometric_normal: up,
            tangent: Vec3::splat(l, [1.0, 0.0, 0.0]),
            bitangent: Vec3::splat(l, [0.0, 1.0, 0.0]),
            view: Vec3::splat(l, [0.5, 0.0, 0.75_f32.sqrt()]),
        };
        let sin_40_degrees = 0.642_787_6_f32;
        let z = (1.0 - sin_40_degrees * sin_40_degrees - 0.04).sqrt();
        let pre = surface(l, options, data, &frame);
        let light = Light::new(l, Vec3::splat(l, [-sin_40_degrees, 0.2, z]), Vec3::splat(l, [1.0; 3]));
        let lighting = lit(l, &pre, &light).1;
        let (_, environment, _) = final_light(l, &pre, &lighting, &Vec3::splat(l, [0.5; 3]));
        let bsdf = evaluate_bsdf(l, &pre, &light);
        (pre, bsdf, environment)
    }

    fn near(what: &str, found: <Scalar as Lanes>::F, expected: f32) {
        let found = found.to_array()[0];
        assert!((found - expected).abs() <= 2e-5 * expected.abs() + 1e-7, "{what}: {found} not {expected}");
    }

    fn near3(what: &str, found: V3<Scalar>, expected: [f32; 3]) {
        for (found, expected) in found.to_array().into_iter().zip(expected) {
            near(what, found, expected);
        }
    }

    fn original() -> Options {
        Options { specular_occlusion: None, zero_mask_is_uncoated: false, ..Options::default() }
    }

    #[test]
    fn layers_of_the_example() {
        let (pre, _, environment) = shade(&original(), &example());
        near3("f0", pre.bsdf.fresnel0, [0.635_656_2, 0.021_745_26, 0.021_745_26]);
        near("top", pre.layers.top, 0.029_050_63);
        near3("bottom", pre.layers.bottom, [0.559_541_7, 0.014_559_5, 0.010_333_78]);
        near3("diffuse energy", pre.layers.diffuse_energy, [0.475_815_1, 0.840_497_4, 0.739_566_9]);
        near("base N.V", pre.base_layer_n_dot_v, 0.934_049_8);
        let roughness = pre.layers.lobes.iter().flat_map(|lobe| lobe.roughness);
        for (found, expected) in roughness.zip([0.316_324_7, 0.127_825_4, 0.698_753, 0.483_477_7]) {
            near("layered roughness", found, expected);
        }
        near("coat roughness", pre.layers.coat_roughness, 0.01);
        near("p A", pre.lobes[1].perceptual_roughness, 0.365_498_1);
        near("p B", pre.lobes[2].perceptual_roughness, 0.768_840_3);
        near3("fgd coat", pre.lobes[0].specular_fgd, [0.023_281_36; 3]);
        near3("fgd A", pre.lobes[1].specular_fgd, [0.374_183, 0.010_525_75, 0.008_325_601]);
        near3("fgd B", pre.lobes[2].specular_fgd, [0.103_712_5, 0.002_946_454, 0.002_336_814]);
        near3("energy A", pre.lobes[1].energy_compensation, [1.047_914, 1.001_639, 1.001_639]);
        near3("energy B", pre.lobes[2].energy_compensation, [1.421_435, 1.014_417, 1.014_417]);
        near3("environment", environment, [0.192_820_9, 0.015_573_28, 0.022_274_61]);
    }

    #[test]
    fn lights_of_the_example() {
        let cases = [
            (
                false,
                false,
                [0.290_720_6, 0.007_890_372, 0.006_334_092],
                [0.111_998_5, 0.197_838_3, 0.174_081],
            ),
            (
                true,
                false,
                [0.282_735_8, 0.007_185_524, 0.005_209_793],
                [0.111_874_4, 0.196_886_8, 0.172_680_9],
            ),
            (
                false,
                true,
                [0.282_844_6, 0.007_680_519, 0.006_168_461],
                [0.129_243_7, 0.228_300_8, 0.200_885_5],
            ),
            (
                true,
                true,
                [0.266_184_9, 0.006_782_685, 0.004_926_577],
                [0.129_100_5, 0.227_202_8, 0.199_269_9],
            ),
        ];
        for (recompute_per_light, refracted_angles_for_base, specular, diffuse) in cases {
            let options = Options { recompute_per_light, refracted_angles_for_base, ..original() };
            let (_, bsdf, _) = shade(&options, &example());
            near3("specular", bsdf.specular_reflected, specular);
            near3("diffuse", bsdf.diffuse_reflected, diffuse);
        }
    }

    #[test]
    fn example_without_coat() {
        let mut bare = example();
        bare.coat = None;
        let mut masked = example();
        if let Some(coat) = &mut masked.coat {
            coat.mask = Scalar.zero();
        }
        for data in [bare, masked] {
            let (_, bsdf, environment) = shade(&original(), &data);
            near3("specular", bsdf.specular_reflected, [0.289_706_9, 0.034_661_56, 0.034_661_56]);
            near3("diffuse", bsdf.diffuse_reflected, [0.235_382_4; 3]);
            near3("environment", environment, [0.239_190_8, 0.036_952_95, 0.058_113_68]);
        }
    }

    #[test]
    fn examples_of_haze_and_iridescence() {
        let l = Scalar;
        let mut hazy = example();
        hazy.coat = None;
        hazy.anisotropy = None;
        let mut film = hazy;
        hazy.haze = Some(HazyGloss {
            haziness: l.splat(0.5),
            extent: l.splat(3.0),
            max_dielectric_f0: l.splat(0.25),
        });
        let (pre, bsdf, _) = shade(&original(), &hazy);
        near3("f0", pre.bsdf.fresnel0, [0.861_847_1, 0.111_897_3, 0.111_897_3]);
        near("lobe mix", pre.bsdf.lobe_mix, 0.170_606_7);
        near("p B", pre.bsdf.lobes[1].perceptual_roughness, 0.8);
        near3("specular", bsdf.specular_reflected, [0.798_378_1, 0.098_951_85, 0.098_951_85]);

        film.metallic = l.zero();
        film.iridescence = Some(Iridescence {
            mask: l.splat(1.0),
            thickness: l.splat(0.4),
            coat_fixup_tir: l.zero(),
            coat_fixup_tir_clamp: l.zero(),
        });
        let (pre, bsdf, _) = shade(&original(), &film);
        near3("film", pre.layers.iridescent, [0.168_930_2, 0.142_012_8, 0.017_227_36]);
        near3("specular", bsdf.specular_reflected, [0.136_591_9, 0.114_827_3, 0.013_929_52]);
    }
}
