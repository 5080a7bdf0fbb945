//! The pieces that Unity's models share: `helpers_ggx`, `helpers_occlusion`, `helpers_ibl`, `helpers_fgd`.

use super::stub;
use super::table::{Adapter, Batch, Found, Table as Csv};
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::fgd::pre_integrated_fgd;
use overcoat_shading::brdf::occlusion::{self, BentNormalTilt, BentOcclusion, VisibilityCone};
use overcoat_shading::brdf::table::{Table, TexelGrid};
use overcoat_shading::brdf::{diffuse, ggx, integrate, reflection};
use std::path::Path;
use std::sync::LazyLock;

pub const ADAPTERS: &[Adapter] = &[
    Adapter { table: "helpers_ggx", uniform: &[], run: ggx, skipped: &[] },
    Adapter { table: "helpers_occlusion", uniform: &[], run: occlusion, skipped: &[] },
    Adapter { table: "helpers_ibl", uniform: &[], run: ibl, skipped: &[] },
    Adapter { table: "helpers_fgd", uniform: &[], run: fgd, skipped: &[] },
];

fn ggx(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => ggx_on(l, batch))
}
fn occlusion(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => occlusion_on(l, batch))
}
fn ibl(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => ibl_on(l, batch))
}
fn fgd(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => fgd_on(l, batch))
}

/// The FGD table that the originals of all HDRP tables read.
pub static FGD: LazyLock<Table<3>> = LazyLock::new(|| {
    let path =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/reference/unity/fgd_lut.csv");
    let csv = Csv::read(&path).expect("the texels");
    let column = |name: &str| csv.column(name).expect("a column of the texels");
    let (ix, iy) = (column("ix"), column("iy"));
    let [x, y, z] = ["out_x", "out_y", "out_z"].map(column);
    let mut texels = vec![[f32::NAN; 3]; 64 * 64];
    for row in 0..csv.rows {
        texels[iy[row] as usize * 64 + ix[row] as usize] = [x[row] as f32, y[row] as f32, z[row] as f32];
    }
    assert!(texels.iter().flatten().all(|t| t.is_finite()), "a texel is missing");
    Table::new(64, 64, TexelGrid::Corners, &texels).expect("64 by 64 texels")
});

/// A column.
#[inline(always)]
pub fn load<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> L::F {
    l.load(&batch.get(name))
}

/// Three columns.
#[inline(always)]
pub fn load3<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> V3<L> {
    Vec3::from_array(batch.get3(name)).map(|c| l.load(&c))
}

/// Three columns back.
pub fn store3<L: Lanes>(v: V3<L>) -> [[f32; LANES]; 3] {
    v.to_arrays()
}

#[inline(always)]
fn ggx_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let get = |name: &str| load(l, batch, name);
    let (nh, nl, nv, lv) = (get("NdotH"), get("NdotL"), get("NdotV"), get("LdotV"));
    let a = get("roughness");
    let half = Vec3::new(get("TdotH"), get("BdotH"), nh);
    let light = Vec3::new(get("TdotL"), get("BdotL"), nl);
    let view = Vec3::new(get("TdotV"), get("BdotV"), nv);
    let ab = [get("roughnessT"), get("roughnessB")];
    let lambda = ggx::part_lambda(l, nv, a);
    let lambda_ab = ggx::anisotropic_part_lambda(l, view, ab);
    let mut found = Found::default();
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("D_GGXNoPI", ggx::distribution_no_pi(l, nh, a));
    set("D_GGX", ggx::distribution(l, nh, a));
    set("PartLambdaV", lambda);
    set("V_SmithJointGGX", ggx::smith_visibility(l, nl, nv, a, lambda));
    set("DV_SmithJointGGX", ggx::smith_distribution_visibility(l, nh, nl, nv, a, lambda));
    set("G_MaskingSmithGGX", ggx::smith_masking(l, nv, a));
    set("D_GGXAniso", ggx::anisotropic_distribution(l, half, ab));
    set("AnisoPartLambdaV", lambda_ab);
    set("V_SmithJointGGXAniso", ggx::anisotropic_smith_visibility(l, light, nv, ab, lambda_ab));
    let dv = ggx::anisotropic_distribution_visibility(l, half, light, nv, ab, lambda_ab);
    set("DV_SmithJointGGXAniso", dv);
    // The table passes its roughness as the perceptual one.
    set("DisneyDiffuseNoPI", diffuse::disney_no_pi(l, nv, nl, lv, a));
    set("DisneyDiffuse", diffuse::disney(l, nv, nl, lv, a));
    found
}

#[inline(always)]
fn occlusion_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let get = |name: &str| load(l, batch, name);
    let [n, v, bent, geometric] = ["N", "V", "bent", "geom"].map(|name| load3(l, batch, name));
    let (ao, p) = (get("ao"), get("perceptualRoughness"));
    let a = p * p;
    let n_dot_v = n.dot(v).at_least(1e-4);
    let open = BentOcclusion { normal: n, bent_normal: bent, ao };
    let mut found = Found::default();
    let bounced = occlusion::gtao_multi_bounce(l, ao, load3(l, batch, "albedo"));
    found.set3("GTAOMultiBounce", store3::<L>(bounced));
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("SOFromAO", occlusion::specular_occlusion_from_ao(l, n_dot_v, ao, a));
    set("BentAO_ConeCone_core", occlusion::specular_occlusion_cone_cone(l, v, &open, a));
    set("BentAO_SG_core", occlusion::specular_occlusion_gaussian(l, v, &open, a));
    set("HorizonOcclusion", occlusion::horizon_occlusion(l, v, n, geometric, get("horizonFade")));
    let between = get("cosB");
    let area = occlusion::spherical_cap_intersection(l, get("cosC1"), get("cosC2"), between);
    set("SphericalCapIntersectionSolidArea", area);
    set("FastACos_cosB", occlusion::fast_acos(l, between));
    let tilt = BentNormalTilt {
        geometric_normal: geometric,
        threshold: get("fixupThreshold"),
        strength: get("fixupStrength"),
    };
    for (name, cone, tilt) in [
        ("uniform", VisibilityCone::Uniform, None),
        ("cos", VisibilityCone::Cosine, None),
        ("cosBent", VisibilityCone::CosineWithBentCorrection, None),
        ("cosBent_fixBoth", VisibilityCone::CosineWithBentCorrection, Some(tilt)),
        ("cos_fixRough", VisibilityCone::Cosine, None),
        ("cos_fixTilt", VisibilityCone::Cosine, Some(tilt)),
    ] {
        let value = occlusion::specular_occlusion_cone_cone_tilted(l, v, &open, p, cone, tilt);
        set(&format!("ConeCone_{name}"), value);
    }
    found
}

#[inline(always)]
fn ibl_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let get = |name: &str| load(l, batch, name);
    let [n, v, t, h] = ["N", "V", "T", "H"].map(|name| load3(l, batch, name));
    let p = get("perceptualRoughness");
    let mut found = Found::default();
    let r = (-v).reflect(n);
    found.set3("reflectR", store3::<L>(r));
    let dominant = reflection::specular_dominant_direction(l, n, r, p, get("NdotV"));
    found.set3("SpecularDominantDir", store3::<L>(dominant));
    let b = n.cross(t);
    let k = get("anisotropy");
    let (bent, roughness) = reflection::anisotropic_normal_and_roughness(l, b, t, n, v, k, p);
    found.set3("anisoN", store3::<L>(bent));
    found.set("anisoPerceptualRoughness", roughness.to_array());
    found.set3("CoatRefract", store3::<L>(reflection::coat_refract(l, v, h, get("ieta"))));
    found.set3("EnvStub", store3::<L>(stub::environment(l, r, p)));
    found
}

#[inline(always)]
fn fgd_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let mut found = Found::default();
    let f0 = load3(l, batch, "f0");
    let (n_dot_v, p) = (load(l, batch, "NdotV"), load(l, batch, "perceptualRoughness"));
    let fgd = pre_integrated_fgd(l, &FGD, n_dot_v, p, f0);
    found.set3("LUT_specularFGD", store3::<L>(fgd.specular));
    found.set("LUT_diffuseFGD", fgd.diffuse.to_array());
    found.set("LUT_reflectivity", fgd.reflectivity.to_array());

    let mut integral = [[0.0; LANES]; 3];
    let cosines = batch.get("NdotV");
    for (lane, p) in batch.get("perceptualRoughness").into_iter().enumerate().take(batch.rows.len()) {
        for value in integrate::unity_fgd(f64::from(p), &[f64::from(cosines[lane])]) {
            for (channel, value) in integral.iter_mut().zip(value) {
                channel[lane] = value as f32;
            }
        }
    }
    found.set3("direct", integral);
    found
}
