//! OpenPBR: `openpbr_coat`.

use super::table::{Adapter, Batch, Found};
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::coat::openpbr::{self, AlbedoSource, Coat, SurfaceData};

pub const ADAPTERS: &[Adapter] =
    &[Adapter { table: "openpbr_coat", uniform: &["in_tirFix"], run: coat, skipped: &[] }];

fn coat(batch: &Batch<'_>) -> Found {
    overcoat_core::dispatch_baseline!(l => coat_on(l, batch))
}

#[inline(always)]
fn load<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> L::F {
    l.load(&batch.get(name))
}

#[inline(always)]
fn load3<L: Lanes>(l: L, batch: &Batch<'_>, name: &str) -> V3<L> {
    Vec3::from_array(batch.get3(name)).map(|c| l.load(&c))
}

#[inline(always)]
fn coat_on<L: Lanes>(l: L, batch: &Batch<'_>) -> Found {
    let data = SurfaceData {
        base_weight: load(l, batch, "baseWeight"),
        base_color: load3(l, batch, "baseColor"),
        metalness: load(l, batch, "metalness"),
        specular_weight: load(l, batch, "specularWeight"),
        specular_color: load3(l, batch, "specularColor"),
        roughness: load(l, batch, "specularRoughness"),
        anisotropy: load(l, batch, "specularAnisotropy"),
        ior: load(l, batch, "specularIor"),
        coat: Some(Coat {
            weight: load(l, batch, "coatWeight"),
            color: load3(l, batch, "coatColor"),
            roughness: load(l, batch, "coatRoughness"),
            anisotropy: load(l, batch, "coatAnisotropy"),
            ior: load(l, batch, "coatIor"),
            darkening: load(l, batch, "coatDarkening"),
            normal: None,
        }),
        invert_ratio: batch.is_on("tirFix"),
        single_scattering: false,
        trapped_roughness: None,
    };
    let [normal, tangent, view, light] = ["N", "T", "V", "L"].map(|name| load3(l, batch, name));
    let albedos = AlbedoSource::Given { coat: load(l, batch, "Ecoat"), specular: load(l, batch, "Espec") };
    let surface = openpbr::surface(l, &data, normal, tangent, view, albedos);
    let lobes = openpbr::lobes(l, &surface, light);
    let mut found = Found::default();
    let mut set = |name: &str, value: L::F| found.set(name, value.to_array());
    set("etaS", surface.eta);
    set("Fs", surface.f0);
    set("etaSmod", surface.eta_modified);
    set("roughenedRoughness", surface.base.roughness);
    set("alphaT", surface.base.alpha[0]);
    set("alphaB", surface.base.alpha[1]);
    set("NoL", lobes.n_dot_l);
    set("NoV", surface.base.n_dot_v());
    set("NoH", surface.base.n_dot_h(light, view));
    set("VoH", lobes.v_dot_h);
    set("D", lobes.base_dv[0]);
    set("V", lobes.base_dv[1]);
    set("Fspec", lobes.dielectric_fresnel);
    if let Some(coat) = &surface.coat {
        set("coatAlphaT", coat.interface.alpha[0]);
        set("coatAlphaB", coat.interface.alpha[1]);
        set("EF", coat.mean_reflectance);
        set("Kr", coat.inner_diffuse);
        set("Ks", coat.inner_specular);
        set("rB", coat.base_roughness);
        set("K", coat.inner);
        set("muTi", lobes.coat.mu_light);
        set("muTo", coat.mu_view);
        set("Dc", lobes.coat.dv[0]);
        set("Vc", lobes.coat.dv[1]);
        set("Fc", lobes.coat.fresnel);
        set("fCoat", lobes.coat.value);
    }
    let mut set3 = |name: &str, value: V3<L>| found.set3(name, value.map(Float::to_array).to_array());
    if let Some(coat) = &surface.coat {
        set3("Eb", coat.base_albedo);
        set3("Delta", coat.delta);
        set3("darkening", coat.darkening);
        set3("absorption", coat.absorption(l, lobes.coat.mu_light));
    }
    set3("Fcond", lobes.metal_fresnel);
    set3("fSpec", lobes.specular);
    set3("fDiffuse", lobes.diffuse);
    set3("fCond", lobes.metal);
    set3("fBase", lobes.base);
    set3("fCoated", lobes.total(l, &surface));
    let color = load3(l, batch, "lightColor");
    set3("lit", openpbr::direct(l, &surface, light, color));
    found
}
