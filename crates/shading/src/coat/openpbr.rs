//! OpenPBR's coat over a metal or a glossy dielectric.
//!
//! Source: the OpenPBR surface specification, version 1.1.1 (<https://academysoftwarefoundation.github.io/OpenPBR/>),
//! sections *Coat*, *Specular*, *Metal* and *Model*. It describes a stack of slabs and leaves the evaluation to the
//! renderer; marked **choice** is what this one takes of the approximations that the text offers. No program of the
//! authors stands behind it.
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct`] for every light and [`indirect`] for the
//! environment; the sum is the reflected radiance.
//!
//! **Radiometry.** The BRDF contains its 1/pi: a light's colour is the irradiance that it delivers at normal incidence.
//! The irradiance of the environment is given over pi, its radiance as it is.
//!
//! **Physics.** The coat is a GGX interface of its own index, roughness and anisotropy. What lies beneath
//! * is seen through the coat: dimmed by the coat's directional albedo of the view (**choice**: albedo scaling) and by
//!   its medium along the refracted paths in and out, `coat_color` to the power (1/mu_i + 1/mu_o) / 2 (**choice**: the
//!   paths of a smooth interface);
//! * has another F0: the ratio of the indices of base and coat takes the place of the base's index;
//! * is rougher, as light crosses the rough coat twice;
//! * is darker and more saturated, as light is reflected back to it from inside the coat: K of it in the mean, between a
//!   smooth and a Lambertian base by the roughness (**choice**: that of the base without coat); `coat_darkening` blends
//!   this.
//!
//! The dielectric base is GGX with the exact Fresnel term over Lambert (no diffuse roughness), balanced by albedo
//! scaling; the metal is GGX with the F82 tint. Both lobes are scaled for the light that leaves after more than one bounce
//! between the facets, by 1 / (1 - F (1 - E)) (**choice**: Turquin 2019, with the mean F of Fdez-Aguera 2019; the
//! specification asks for it and leaves the way open). The coat's lobe is not: of a dielectric it would be 2 percent. Left out
//! of OpenPBR: transmission, subsurface, fuzz, thin film and emission.
//!
//! The F82 term of a dark `specular_color` falls below 0 near its angle, in the text as here: a metal's `direct` can be
//! negative by up to 0.09 of the highlight. Whoever adds lights up ends at 0.
//!
//! **Energy** (measured in `tests/models/openpbr.rs`): under white light from everywhere nothing shows more than 1; of
//! separate lights a white surface returns at most 1.021, because the albedos that scale the layers are Schlick's and
//! the lobes have the exact Fresnel term. A white metal keeps its light at every roughness. Nothing is reciprocal: albedos look at
//! the view only.
//!
//! The specification's fit of the mean Fresnel reflectance is 0.0017 at index 1: an index-matched coat darkens a little.
//!
//! **Environment** (not in the specification; in the spirit of the direct form): split sum. Each lobe takes
//! prefiltered radiance in its mirror direction times its albedo from [`super::super::brdf::tables::ggx_albedo`], the
//! Lambert part irradiance. Base and Lambert part pass the coat with the same albedo scaling and darkening. Light that the
//! base mirrors has crossed the medium at the angle of the view twice; diffuse light comes in at the mean cosine of a
//! Lambert surface, 2/3. Anisotropic lobes bend the normal across the grain as Filament does.
//!
//! Lanes with a coat weight of exactly 0 keep the bits of a material without coat.

pub use super::EnvironmentQuery;

use crate::brdf::fresnel::fresnel_dielectric;
use crate::brdf::microfacet::{distribution_ggx_anisotropic, schlick_color, visibility_smith_anisotropic};
use crate::brdf::table::Table;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::math::{ln, pow};
use overcoat_core::vec3;
use std::f32::consts::FRAC_1_PI;

/// Least alpha along either axis: a mirror keeps a highlight of about a hundredth of a degree. The specification has no
/// floor and divides by 0 for roughness 0 or anisotropy 1.
const LEAST_ALPHA: f32 = 1e-4;

/// Least denominator of the visibility term, so that its product with the distribution stays finite; reached below
/// cosines of about 1e-3.
const LEAST_SMITH: f32 = 1e-6;

/// Least square of the anisotropic distribution's denominator; an orthonormal frame stays above the square of the two
/// alphas, 1e-16.
const LEAST_DISTRIBUTION: f32 = 1e-17;

/// Least cosine inside the coat, for index 1 at grazing angles.
const LEAST_MU: f32 = 1e-3;

/// 1 / (u (1 - u)^6) at u = 1/7, the cosine of the 82 degrees at which the tint applies: 7^7 / 6^6.
const F82_SCALE: f32 = 823_543.0 / 46_656.0;

/// (1 - 1/7)^5.
const F82_SCHLICK: f32 = 7776.0 / 16_807.0;

/// Mean of (1 - u)^5 over the hemisphere.
const MEAN_SCHLICK_WEIGHT: f32 = 1.0 / 21.0;

/// Mean of u (1 - u)^6 over the hemisphere.
const MEAN_DIP: f32 = 1.0 / 126.0;

/// Mean cosine of light that falls on a Lambert surface from everywhere.
const MEAN_COSINE: f32 = 2.0 / 3.0;

/// The coat of a material.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// `coat_weight`, 0 none to 1 full.
    pub weight: L::F,
    /// `coat_color`, linear: the share of light that passes the medium twice at normal incidence, 0 to 1.
    pub color: V3<L>,
    /// `coat_roughness`, 0 to 1.
    pub roughness: L::F,
    /// `coat_roughness_anisotropy`, 0 to 1: the highlight is stretched along the tangent.
    pub anisotropy: L::F,
    /// `coat_ior`, 1 to 3; held there.
    pub ior: L::F,
    /// `coat_darkening`, 0 none to 1 physical.
    pub darkening: L::F,
    /// Unit normal of the coat where it differs from the base's (`geometry_coat_normal`); `None` and a normal with the
    /// base's bits give the same bits.
    pub normal: Option<V3<L>>,
}

/// OpenPBR's parameters for sixteen fragments.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// `base_weight`, 0 to 1.
    pub base_weight: L::F,
    /// `base_color`, linear, 0 to 1.
    pub base_color: V3<L>,
    /// `base_metalness`, 0 dielectric to 1 metal.
    pub metalness: L::F,
    /// `specular_weight`, 0 to 1.
    pub specular_weight: L::F,
    /// `specular_color`, linear, 0 to 1: tint of a dielectric's reflection, or of a metal's at 82 degrees.
    pub specular_color: V3<L>,
    /// `specular_roughness`, 0 to 1; the square root of alpha.
    pub roughness: L::F,
    /// `specular_roughness_anisotropy`, 0 to 1: the highlight is stretched along the tangent.
    pub anisotropy: L::F,
    /// `specular_ior`, 1 to 3.
    pub ior: L::F,
    /// `None` where no lane has a coat; the same bits as a weight of 0, and faster.
    pub coat: Option<Coat<L>>,
    /// True if a coat of higher index than the base has the ratio of indices inverted, which avoids a ring of total
    /// reflection that a real coat does not show (the specification recommends it). One for all lanes.
    pub invert_ratio: bool,
    /// True if light that meets more than one facet is lost. One for all lanes.
    pub single_scattering: bool,
    /// Perceptual roughness of the base as light that the coat sends back to it meets it, 0 to 1, where that is another than of what
    /// is seen: all flakes are met by what one flake reflects. The base lies as the coat does then.
    pub trapped_roughness: Option<L::F>,
}

/// Directional albedos of lobes for the view.
#[derive(Clone, Copy)]
pub enum AlbedoSource<'a, L: Lanes> {
    /// From a table over (sqrt(N.V), roughness) with texels at the corners: x the albedo of GGX weighted with (1 -
    /// V.H)^5, y without weight, z weighted with V.H (1 - V.H)^6.
    Table(&'a Table<3>),
    /// Numbers of the caller for coat and dielectric base, without the tint of the latter. The environment's lobes then
    /// have these albedos too, and a metal that of its Fresnel term at the view.
    Given {
        /// Albedo of the coat.
        coat: L::F,
        /// Albedo of the dielectric base.
        specular: L::F,
    },
}

/// Right-handed orthonormal axes of a layer.
#[derive(Clone, Copy)]
struct Frame<L: Lanes> {
    tangent: V3<L>,
    bitangent: V3<L>,
    normal: V3<L>,
}

impl<L: Lanes> Frame<L> {
    #[inline(always)]
    fn new(_: L, normal: V3<L>, tangent: V3<L>) -> Self {
        Self { tangent, bitangent: normal.cross(tangent), normal }
    }

    /// A vector in the frame; its cosine with the normal saturated.
    #[inline(always)]
    fn local(&self, v: V3<L>) -> V3<L> {
        Vec3::new(self.tangent.dot(v), self.bitangent.dot(v), self.normal.dot(v).saturate())
    }
}

/// A rough interface: its axes, its alphas and the view from it.
#[derive(Clone, Copy)]
pub struct Interface<L: Lanes> {
    frame: Frame<L>,
    /// Alpha along tangent and bitangent.
    pub alpha: [L::F; 2],
    /// Roughness, the square root of the isotropic alpha.
    pub roughness: L::F,
    anisotropy: L::F,
    /// The view in the frame.
    view: V3<L>,
}

/// alpha_t = r^2 sqrt(2 / (1 + (1 - k)^2)), alpha_b = (1 - k) alpha_t. At least [`LEAST_ALPHA`].
#[inline(always)]
fn alphas<L: Lanes>(l: L, roughness: L::F, anisotropy: L::F) -> [L::F; 2] {
    let ratio = anisotropy.one_minus();
    let along = roughness * roughness * (l.splat(2.0) / (ratio * ratio + 1.0)).sqrt();
    [along.at_least(LEAST_ALPHA), (ratio * along).at_least(LEAST_ALPHA)]
}

impl<L: Lanes> Interface<L> {
    #[inline(always)]
    fn new(l: L, frame: Frame<L>, roughness: L::F, anisotropy: L::F, view: V3<L>) -> Self {
        let alpha = alphas(l, roughness, anisotropy);
        Self { frame, alpha, roughness, anisotropy, view: frame.local(view) }
    }

    /// N.V, saturated.
    #[inline(always)]
    pub fn n_dot_v(&self) -> L::F {
        self.view.z
    }

    /// N.H for unit vectors to the light and to the eye, saturated.
    #[inline(always)]
    pub fn n_dot_h(&self, light: V3<L>, view: V3<L>) -> L::F {
        self.frame.normal.dot((light + view).normalize()).saturate()
    }

    /// Distribution (1/sr) and visibility for a light direction and half vector.
    #[inline(always)]
    fn distribution_and_visibility(&self, l: L, light: V3<L>, half: V3<L>) -> (L::F, L::F) {
        let half = self.frame.local(half);
        let d = distribution_ggx_anisotropic(l, half, self.alpha, LEAST_DISTRIBUTION);
        (d, visibility_smith_anisotropic(l, light, self.view, self.alpha, LEAST_SMITH))
    }

    /// Environment lookup of the lobe. The normal is bent across the grain, by |k| saturate(5 r), as Filament's
    /// `getReflectedVector` does.
    #[inline(always)]
    fn query(&self, view: V3<L>) -> EnvironmentQuery<L> {
        let (grain, normal) = (self.frame.bitangent, self.frame.normal);
        let grain_normal = grain.cross(view).cross(grain);
        let bend = self.anisotropy * (self.roughness * 5.0).saturate();
        let bent = normal.lerp(grain_normal, bend).normalize();
        EnvironmentQuery { direction: (-view).reflect(bent), perceptual_roughness: self.roughness }
    }
}

/// The coat as [`surface`] prepares it, and its effect on the base.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    /// The interface to air.
    pub interface: Interface<L>,
    weight: L::F,
    ior: L::F,
    color: V3<L>,
    /// Directional albedo for the view.
    pub albedo: L::F,
    /// Mean Fresnel reflectance for light from outside, from everywhere.
    pub mean_reflectance: L::F,
    /// Share of diffuse light from inside that the coat reflects back.
    pub inner_diffuse: L::F,
    /// Share of light from a smooth base that the coat reflects back.
    pub inner_specular: L::F,
    /// Effective roughness of the base, 0 to 1: blends `inner_specular` (0) and `inner_diffuse` (1).
    pub base_roughness: L::F,
    /// Share of light from the base that the coat reflects back.
    pub inner: L::F,
    /// Albedo of the base.
    pub base_albedo: V3<L>,
    /// Factor on the base's light after all interreflections with the coat, before blending.
    pub delta: V3<L>,
    /// The same after blending with weight and `coat_darkening`.
    pub darkening: V3<L>,
    /// Cosine of the view inside the coat.
    pub mu_view: L::F,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// The base's interface, as rough as it is seen.
    pub base: Interface<L>,
    /// The coat, if any lane has one.
    pub coat: Option<CoatSurface<L>>,
    view: V3<L>,
    metalness: L::F,
    specular_weight: L::F,
    specular_color: V3<L>,
    /// Base colour times weight: the albedo of the Lambert part and F0 of the metal.
    pub base_color: V3<L>,
    /// Index of the dielectric base relative to the layer above.
    pub eta: L::F,
    /// F0 of that.
    pub f0: L::F,
    /// The index after the specular weight.
    pub eta_modified: L::F,
    /// Albedo of the dielectric specular lobe for the view, without tint.
    pub specular_albedo: L::F,
    /// Albedo of the metal for the view.
    pub metal_albedo: V3<L>,
    /// All bounces between facets over the first, of the dielectric and of the metal; 1 where albedos are given and for single scattering.
    pub bounces: (L::F, V3<L>),
}

/// `a (1 - t) + b t`.
#[inline(always)]
fn mix<L: Lanes>(_: L, a: L::F, b: L::F, t: L::F) -> L::F {
    a.lerp(b, t)
}

/// F0 of a relative index, ((1 - eta) / (1 + eta))^2.
#[inline(always)]
fn f0_of_ior<L: Lanes>(_: L, eta: L::F) -> L::F {
    (eta.one_minus() / (eta + 1.0)).squared()
}

/// The index whose F0 is that of `eta` times the specular weight, on the same side of 1.
#[inline(always)]
fn modified_eta<L: Lanes>(l: L, eta: L::F, f0: L::F, specular_weight: L::F) -> L::F {
    // A weight above 1 cannot make F0 more than 1; 1 / 0 is infinite and not less than any weight.
    let xi = specular_weight.min(f0.recip());
    let root = (xi * f0).at_least(0.0).sqrt().at_most(0.999);
    let epsilon = eta.lt(l.splat(1.0)).select(-root, root);
    (epsilon + 1.0) / epsilon.one_minus()
}

/// The F82 tint of a metal at the cosine u: Schlick's reflectance less u (1 - u)^6 times what brings it to
/// `specular_color` times Schlick's at u = 1/7. Kutz, Hasan and Edmondson, "Novel aspects of the Adobe Standard
/// Material" (2023). Negative for dark tints near u = 1/7.
#[inline(always)]
fn fresnel_f82<L: Lanes>(l: L, f0: V3<L>, tint: V3<L>, u: L::F) -> V3<L> {
    let schlick = schlick_color(l, f0, l.splat(1.0), u);
    let x = u.one_minus();
    let dip = u * (x * x * x).squared();
    let full = f82_dip(l, f0, tint);
    schlick - full * dip
}

/// The factor of u (1 - u)^6 in [`fresnel_f82`].
#[inline(always)]
fn f82_dip<L: Lanes>(_: L, f0: V3<L>, tint: V3<L>) -> V3<L> {
    tint.one_minus() * (f0 + f0.one_minus() * F82_SCHLICK) * F82_SCALE
}

/// The albedos of a lobe from the table: without weight, weighted with (1 - u)^5, and with u (1 - u)^6.
#[inline(always)]
fn lookup<L: Lanes>(l: L, table: &Table<3>, interface: &Interface<L>) -> [L::F; 3] {
    let [grazing, all, dip] = table.fetch(l, interface.view.z.sqrt(), interface.roughness);
    [all, grazing, dip]
}

/// Albedo of a dielectric lobe from its parts without weight and weighted with (1 - u)^5.
///
/// The exact Fresnel term differs from Schlick's most where the indices agree: it vanishes there, while Schlick's still
/// reaches 1 at grazing angles. F90 = min(1, 20 sqrt(F0)) follows it (about F0 = 0.0025, index 1.1).
#[inline(always)]
fn dielectric_albedo<L: Lanes>(_: L, all: L::F, grazing: L::F, f0: L::F) -> L::F {
    let f90 = (f0.sqrt() * 20.0).at_most(1.0);
    (f0 * (all - grazing) + f90 * grazing).saturate()
}

/// All bounces between facets over the first, 1 / (1 - F (1 - E)), for the mean Fresnel reflectance F and the albedo E of
/// facets that absorb nothing (Turquin 2019, with the mean of Fdez-Aguera 2019).
#[inline(always)]
fn all_bounces<L: Lanes>(_: L, mean: L::F, all: L::F) -> L::F {
    (mean.saturate() * all.one_minus()).one_minus().at_least(0.01).recip()
}

/// Prepares sixteen fragments: layers, albedos and all that depends on the view only.
///
/// `normal`, `tangent` and `view` are unit vectors in one space, tangent and normal at right angles; `view` points to
/// the eye.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    data: &SurfaceData<L>,
    normal: V3<L>,
    tangent: V3<L>,
    view: V3<L>,
    albedos: AlbedoSource<'_, L>,
) -> Surface<L> {
    let frame = Frame::new(l, normal, tangent);
    let base_color = data.base_color * data.base_weight;
    let mut eta = data.ior;
    let mut roughness = data.roughness;
    if let Some(coat) = &data.coat {
        let coat_ior = coat.ior.clamp_to(1.0, 3.0);
        let mut ratio = data.ior / coat_ior;
        if data.invert_ratio {
            ratio = coat_ior.gt(data.ior).select(coat_ior / data.ior, ratio);
        }
        eta = mix(l, eta, ratio, coat.weight);
        let r4 = roughness.squared().squared() + coat.roughness.squared().squared() * 2.0;
        roughness = mix(l, roughness, r4.at_most(1.0).sqrt().sqrt(), coat.weight);
    }
    let f0 = f0_of_ior(l, eta);
    let eta_modified = modified_eta(l, eta, f0, data.specular_weight);
    let base = Interface::new(l, frame, roughness, data.anisotropy, view);
    let (specular_albedo, metal_albedo, bounces) = match albedos {
        AlbedoSource::Table(table) => {
            let [all, grazing, dip] = lookup(l, table, &base);
            let kept = if data.single_scattering { l.splat(1.0) } else { all };
            let full = f82_dip(l, base_color, data.specular_color);
            let schlick = base_color * (all - grazing) + grazing;
            let mean = base_color + base_color.one_minus() * MEAN_SCHLICK_WEIGHT - full * MEAN_DIP;
            let of_metal = vec3!(f in mean => all_bounces(l, f, kept));
            let metal = (schlick - full * dip).at_least(0.0) * of_metal * data.specular_weight;
            let f0 = f0_of_ior(l, eta_modified);
            let of_dielectric = all_bounces(l, f0 + f0.one_minus() * MEAN_SCHLICK_WEIGHT, kept);
            let specular = (dielectric_albedo(l, all, grazing, f0) * of_dielectric).saturate();
            (specular, metal, (of_dielectric, of_metal))
        }
        AlbedoSource::Given { specular, .. } => {
            let metal = fresnel_f82(l, base_color, data.specular_color, base.view.z);
            (specular, metal * data.specular_weight, (l.splat(1.0), Vec3::splat(l, [1.0; 3])))
        }
    };
    let mut surface = Surface {
        base,
        coat: None,
        view,
        metalness: data.metalness,
        specular_weight: data.specular_weight,
        specular_color: data.specular_color,
        base_color,
        eta,
        f0,
        eta_modified,
        specular_albedo,
        metal_albedo,
        bounces,
    };
    surface.coat = match &data.coat {
        Some(coat) => Some(coat_surface(l, &surface, data, coat, albedos)),
        None => None,
    };
    surface
}

/// The coat over a base whose fields are already those under the coat.
#[inline(always)]
fn coat_surface<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    data: &SurfaceData<L>,
    coat: &Coat<L>,
    albedos: AlbedoSource<'_, L>,
) -> CoatSurface<L> {
    let base = &surface.base;
    let frame = match coat.normal {
        Some(normal) => {
            // The tangent at right angles to this normal; the same bits where it already is.
            let tangent = base.frame.tangent;
            let along = tangent.dot(normal);
            let turned = (tangent - normal * along).normalize();
            let same = along.abs().lt(l.splat(1e-6));
            Frame::new(l, normal, Vec3::select(same, tangent, turned))
        }
        None => base.frame,
    };
    let interface = Interface::new(l, frame, coat.roughness, coat.anisotropy, surface.view);
    let ior = coat.ior.clamp_to(1.0, 3.0);
    let ior2 = ior * ior;
    let albedo = match albedos {
        AlbedoSource::Table(table) => {
            let [all, grazing, _] = lookup(l, table, &interface);
            dielectric_albedo(l, all, grazing, f0_of_ior(l, ior))
        }
        AlbedoSource::Given { coat, .. } => coat,
    };
    // Fit of the specification, 1 to 3.
    let mean_reflectance = ln(l, (ior * 10893.0 - 1438.2) / (ior2 * -774.4 + ior * 10212.0 + 1.0));
    let inner_diffuse = (mean_reflectance.one_minus() / ior2).one_minus();
    let inner_specular = fresnel_dielectric(l, ior, interface.view.z);
    let x = (data.specular_weight * surface.f0).saturate();
    let roughness = data.trapped_roughness.unwrap_or(data.roughness);
    let base_roughness = mix(l, mix(l, l.splat(1.0), roughness, x), roughness, data.metalness);
    let inner = mix(l, inner_specular, inner_diffuse, base_roughness);
    let metal_weight = data.specular_weight.at_most(1.0);
    let dielectric = surface.base_color.lerp(data.specular_color, x);
    let base_albedo = dielectric.lerp(surface.base_color * metal_weight, data.metalness);
    // Below a coat that reflects everything a white base keeps its light: 0 / 0 without the limit.
    let held = inner.at_most(0.999_999);
    let delta = Vec3::uniform(held.one_minus()) / (base_albedo * held).one_minus();
    let strength = coat.weight * coat.darkening;
    let darkening = Vec3::splat(l, [1.0; 3]).lerp(delta, strength);
    CoatSurface {
        mu_view: mu(l, interface.view.z, ior),
        interface,
        weight: coat.weight,
        ior,
        color: coat.color,
        albedo,
        mean_reflectance,
        inner_diffuse,
        inner_specular,
        base_roughness,
        inner,
        base_albedo,
        delta,
        darkening,
    }
}

/// Cosine inside a coat of the given index.
#[inline(always)]
fn mu<L: Lanes>(_: L, cosine: L::F, ior: L::F) -> L::F {
    ((cosine * cosine).one_minus() / (ior * ior)).one_minus().at_least(LEAST_MU * LEAST_MU).sqrt()
}

impl<L: Lanes> CoatSurface<L> {
    /// Transmittance of the medium for light that enters at the inner cosine `mu_light` and leaves towards the view.
    #[inline(always)]
    pub fn absorption(&self, l: L, mu_light: L::F) -> V3<L> {
        let exponent = (mu_light.recip() + self.mu_view.recip()) * 0.5;
        vec3!(color in self.color => pow(l, color.at_least(0.0), exponent))
    }

    /// Transmittance of the coat for light of the base that enters at the inner cosine `mu_light`, darkening included.
    #[inline(always)]
    fn transmittance(&self, l: L, mu_light: L::F) -> V3<L> {
        let absorption = self.absorption(l, mu_light);
        let through = absorption * self.albedo.one_minus();
        Vec3::splat(l, [1.0; 3]).lerp(through, self.weight) * self.darkening
    }
}

/// The lobes for one light direction. BRDF values, 1/sr, without cosine.
#[derive(Clone, Copy)]
pub struct Lobes<L: Lanes> {
    /// N.L at the base.
    pub n_dot_l: L::F,
    /// V.H.
    pub v_dot_h: L::F,
    /// Distribution and visibility of the base.
    pub base_dv: [L::F; 2],
    /// Fresnel reflectance of the dielectric base, without tint.
    pub dielectric_fresnel: L::F,
    /// Fresnel reflectance of the metal times its weight.
    pub metal_fresnel: V3<L>,
    /// The dielectric's reflection.
    pub specular: V3<L>,
    /// The Lambert part, before it is dimmed by the reflection.
    pub diffuse: V3<L>,
    /// The metal's reflection.
    pub metal: V3<L>,
    /// All of the base.
    pub base: V3<L>,
    /// The coat's lobe; 0 without a coat.
    pub coat: CoatLobe<L>,
}

/// The coat for one light direction.
#[derive(Clone, Copy)]
pub struct CoatLobe<L: Lanes> {
    /// N.L at the coat.
    pub n_dot_l: L::F,
    /// Cosine of the light inside the coat.
    pub mu_light: L::F,
    /// Distribution and visibility.
    pub dv: [L::F; 2],
    /// Fresnel reflectance.
    pub fresnel: L::F,
    /// The lobe without the coat's weight, 1/sr.
    pub value: L::F,
    /// Transmittance for light of the base, darkening included.
    pub transmittance: V3<L>,
}

/// The lobes towards a light. `light` is the unit vector to it.
#[inline(always)]
pub fn lobes<L: Lanes>(l: L, surface: &Surface<L>, light: V3<L>) -> Lobes<L> {
    // Light from straight behind has no half vector (and no cosine that counts); any will do but 0, with which the
    // distribution overflows.
    let sum = light + surface.view;
    let opposite = sum.dot(sum).lt(l.splat(1e-12));
    let half = Vec3::select(opposite, surface.base.frame.normal, sum.normalize());
    let v_dot_h = surface.view.dot(half).saturate();
    let local = surface.base.frame.local(light);
    let (d, v) = surface.base.distribution_and_visibility(l, local, half);
    let dielectric_fresnel = fresnel_dielectric(l, surface.eta_modified, v_dot_h);
    let metal_fresnel =
        fresnel_f82(l, surface.base_color, surface.specular_color, v_dot_h) * surface.specular_weight;
    let dv = d * v;
    let specular = surface.specular_color * (dv * dielectric_fresnel * surface.bounces.0);
    let diffuse = surface.base_color * FRAC_1_PI;
    let metal = metal_fresnel * dv * surface.bounces.1;
    let unreflected = surface.specular_albedo.one_minus();
    let base = (specular + diffuse * unreflected).lerp(metal, surface.metalness);
    let zero = l.zero();
    let coat = match &surface.coat {
        Some(coat) => {
            let local = coat.interface.frame.local(light);
            let (d, v) = coat.interface.distribution_and_visibility(l, local, half);
            let fresnel = fresnel_dielectric(l, coat.ior, v_dot_h);
            let mu_light = mu(l, local.z, coat.ior);
            let transmittance = coat.transmittance(l, mu_light);
            CoatLobe {
                n_dot_l: local.z,
                mu_light,
                dv: [d, v],
                fresnel,
                value: d * v * fresnel,
                transmittance,
            }
        }
        None => CoatLobe {
            n_dot_l: zero,
            mu_light: zero,
            dv: [zero; 2],
            fresnel: zero,
            value: zero,
            transmittance: Vec3::splat(l, [1.0; 3]),
        },
    };
    Lobes {
        n_dot_l: local.z,
        v_dot_h,
        base_dv: [d, v],
        dielectric_fresnel,
        metal_fresnel,
        specular,
        diffuse,
        metal,
        base,
        coat,
    }
}

impl<L: Lanes> Lobes<L> {
    /// The BRDF of a surface whose layers share their normal, 1/sr.
    #[inline(always)]
    pub fn total(&self, l: L, surface: &Surface<L>) -> V3<L> {
        let reflection = match &surface.coat {
            Some(coat) => coat.weight * self.coat.value,
            None => l.zero(),
        };
        self.base * self.coat.transmittance + reflection
    }
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence, with distance, cone and
/// shadow applied.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>) -> V3<L> {
    let lobes = lobes(l, surface, direction);
    let mut reflected = lobes.base * lobes.n_dot_l;
    if let Some(coat) = &surface.coat {
        let reflection = coat.weight * lobes.coat.value * lobes.coat.n_dot_l;
        reflected = reflected * lobes.coat.transmittance + reflection;
    }
    reflected * color
}

/// The environment: the radiance that the fragments reflect.
///
/// `irradiance` is the environment's at the base normal, over pi; `environment` gives prefiltered radiance and is asked
/// once, or twice with a coat; `occlusion` is 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let mut radiance = [Vec3::zero(l); 2];
    // A loop, so that the look-up is compiled once.
    for (k, radiance) in radiance.iter_mut().enumerate() {
        let query = match (k, &surface.coat) {
            (0, _) => Some(surface.base.query(surface.view)),
            (_, Some(coat)) => Some(coat.interface.query(surface.view)),
            (_, None) => None,
        };
        if let Some(query) = query {
            *radiance = environment(query);
        }
    }
    let [below, above] = radiance;
    let dielectric = surface.metalness.one_minus();
    let unreflected = dielectric * surface.specular_albedo.one_minus();
    let tinted = surface.specular_color * surface.specular_albedo;
    let mut specular = tinted.lerp(surface.metal_albedo, surface.metalness) * below;
    let mut diffuse = surface.base_color * unreflected * irradiance;
    if let Some(coat) = &surface.coat {
        let mirrored = coat.transmittance(l, coat.mu_view);
        let scattered = coat.transmittance(l, mu(l, l.splat(MEAN_COSINE), coat.ior));
        let reflection = coat.weight * coat.albedo;
        specular = specular * mirrored + above * reflection;
        diffuse *= scattered;
    }
    (specular + diffuse) * occlusion
}
