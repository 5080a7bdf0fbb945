//! StackLit repaired: a coat over a base by the adding method, measured on a random walk through the layers.
//!
//! Source: no engine's. The idea is that of Unity's StackLit: Belcour, "Efficient Rendering of Layered Materials using an Atomic
//! Decomposition with Statistical Operators" (2018), which follows albedo, mean and variance of lobes through interfaces. What
//! is repaired:
//! - *Diffuse light is a kind of its own* with a closed sum over its bounces, counted once, as de Dinechin and Belcour, "Rendering
//!   Layered Materials with Diffuse Interfaces" (2022), have it. StackLit scales Lambert by what passes for the view times the
//!   bounces of the specular lobe: neither the way in nor what the face sends back to a base that absorbs is counted.
//! - *Total reflection*: what a rough base mirrors beyond the cone of escape stays inside. StackLit takes Fresnel's term at
//!   the mean direction, and is too bright over rough metal.
//! - *The base is evaluated inside the coat*, with directions that are refracted one by one, and not outside with a lobe
//!   that has been widened to what refraction makes of it: over a smooth coat that is exact up to the second bounce.
//! - *Anisotropy*: variances are added along each axis (Weier and Belcour, "Rendering Layered Materials with Anisotropic
//!   Interfaces", 2020).
//! - *All bounces between facets* of an interface, from its albedo (Turquin 2019).
//!
//! `src/guide/stacklit_d.md` has the derivation and the table of errors. Numbers that no derivation gives, a dozen, are
//! fitted to the referee (`overcoat_lab::truth`) and named where they stand.
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct()`] for every light and [`indirect()`] for the environment;
//! the sum is the reflected radiance.
//!
//! **Radiometry.** The BRDF contains its 1/pi: a light's colour is the irradiance that it delivers at normal incidence. The
//! irradiance of the environment is given over pi, its radiance as it is.
//!
//! **Physics.** The coat is a dielectric of its own index with Fresnel's equations, GGX of its own roughness and anisotropy,
//! over a medium that absorbs (Beer and Lambert along refracted paths). The base is GGX with Schlick's term over Lambert, without
//! refraction between the two, and of its own normal. A mask between 0 and 1 is that share of the surface with a coat and the
//! rest without. Under white light from everywhere nothing shows more than 1; a coat of index 1 over a base that it does
//! not dim is the base. The Lambertian part is reciprocal. The specular one is but for the albedos that all bounces between
//! facets scale with, which look at the view.
//!
//! **Quirks.** Below a coat a dielectric base reflects by its index relative to the coat's, and not at all where the two are
//! equal; the index is the one that has F0 in air. F0 of a metal is its reflectance in place, under the coat.
//!
//! **Left out:** sheen, thin films, the second lobe, subsurface scattering, the coat's colour (its medium has an extinction).
//! Scattering in the medium. Every result is finite and not negative for inputs in range and unit vectors.

mod darkening;
mod direct;
mod face;
mod indirect;
mod trapped;

pub use super::EnvironmentQuery;
pub(in crate::coat) use darkening::Darkening;
pub use direct::direct;
pub use indirect::indirect;

use crate::brdf::microfacet::schlick_weight;
use crate::brdf::table::Table;
use crate::coat::glsl::normalize_or;
use face::{Crossing, Face};
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use trapped::{Bounces, MEAN_SCHLICK_WEIGHT, Trapped, albedos};

/// Least cosine of light and view, so that nothing is divided by 0.
const LEAST_COSINE: f32 = 1e-4;

/// Least perceptual roughness under lights without extent, which a smoother surface would not show at all.
const LEAST_ROUGHNESS: f32 = 0.045;

/// F90 of an interface between nearly equal indices, by the root r of its F0: `a r / (1 + b r)`. Schlick's term has the mean of Fresnel's
/// then, which rises at grazing angles alone.
const GRAZING: [f32; 2] = [12.9, 5.0];

/// Stretched roughness.
#[derive(Clone, Copy)]
pub struct Anisotropy<L: Lanes> {
    /// Anisotropy of the base, 0 to 1, as glTF defines it.
    pub base: L::F,
    /// Anisotropy of the coat, 0 to 1, as OpenPBR defines it.
    pub coat: L::F,
    /// Unit vector along the larger roughness of both.
    pub tangent: V3<L>,
}

/// A coat.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// 0 none to 1 full.
    pub mask: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Index of refraction, 1 to 3; held there.
    pub ior: L::F,
    /// Optical thickness of the medium at normal incidence, 0 or more. `None` where it absorbs nothing in any lane.
    pub depth: Option<V3<L>>,
    /// Unit normal.
    pub normal: V3<L>,
}

/// Sixteen fragments' material. A feature that is `None` costs nothing and is one for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// F0 of the dielectric with its weight, linear, 0 to 1.
    pub dielectric_f0: V3<L>,
    /// Reflectance of the dielectric at grazing angles, 0 to 1: the weight.
    pub dielectric_f90: L::F,
    /// Clear coat.
    pub coat: Option<Coat<L>>,
    /// Anisotropic highlights.
    pub anisotropy: Option<Anisotropy<L>>,
    /// Perceptual roughness of the base as light that the coat sends back to it meets it, 0 to 1, where that is another than of what
    /// is seen: all flakes are met by what one flake reflects. The base lies as the coat does then.
    pub trapped_roughness: Option<L::F>,
}

/// The base as the material has it.
#[derive(Clone, Copy)]
struct Base<L: Lanes> {
    normal: V3<L>,
    /// Alpha along tangent and bitangent.
    alpha: [L::F; 2],
    /// Perceptual roughness of the mean alpha.
    roughness: L::F,
    /// The same as light that the coat sends back meets it.
    trapped_roughness: L::F,
    /// F0 of the specular lobe, metal and dielectric together.
    f0: V3<L>,
    f90: L::F,
    /// F0 and F90 of the dielectric alone, which dims the Lambertian lobe.
    dielectric: (V3<L>, L::F),
    /// Albedo of the Lambertian lobe.
    albedo: V3<L>,
}

/// The base as it is seen from a direction, through a coat or not.
#[derive(Clone, Copy)]
struct Seen<L: Lanes> {
    /// Unit vector to the eye, refracted by the coat if there is one.
    view: V3<L>,
    n_dot_v: L::F,
    /// Light of all bounces between facets over that of the first.
    bounces: V3<L>,
    /// Directional albedo of the specular lobe.
    albedo: V3<L>,
    /// Transmittance of the specular lobe towards the Lambertian one, 0 to 1.
    left: V3<L>,
}

/// A coat over the base, as it is seen.
#[derive(Clone, Copy)]
struct Coated<L: Lanes> {
    mask: L::F,
    normal: V3<L>,
    alpha: [L::F; 2],
    face: Face<L>,
    view: Crossing<L>,
    /// Transmittance for the view, medium included.
    passes: V3<L>,
    /// Transmittance of the medium alone.
    medium: V3<L>,
    depth: Option<V3<L>>,
    /// The base as it reflects below the coat.
    below: Base<L>,
    base: Seen<L>,
    /// Factor of the tangential part of the view inside.
    bend: L::F,
    /// Share of the face's variance that the view's crossing adds.
    spread: L::F,
    trapped: Trapped<L>,
    /// Share of the view's mirrored light that the interface keeps inside.
    beyond: L::F,
    /// Light of bounces between base and face that stay in the lobe, over that of the first.
    around: V3<L>,
    /// Share of the lobe that the face reflects back to the base.
    back: L::F,
}

/// Tangent frame of the base's anisotropic lobe.
#[derive(Clone, Copy)]
struct Axes<L: Lanes> {
    tangent: V3<L>,
    bitangent: V3<L>,
}

impl<L: Lanes> Axes<L> {
    /// A vector along the axes, with its cosine to the normal.
    #[inline(always)]
    fn local(&self, _: L, w: V3<L>, cosine: L::F) -> V3<L> {
        Vec3::new(self.tangent.dot(w), self.bitangent.dot(w), cosine)
    }
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    view: V3<L>,
    base: Base<L>,
    axes: Option<Axes<L>>,
    coat: Option<Coated<L>>,
    /// The base without a coat, where any lane shows it.
    bare: Option<Seen<L>>,
}

impl<L: Lanes> Surface<L> {
    /// Transmittance of the coat towards the eye, for light from beneath such as the material's emission.
    #[inline(always)]
    pub fn coat_transmittance(&self, l: L) -> V3<L> {
        let one = Vec3::splat(l, [1.0; 3]);
        match &self.coat {
            Some(coat) => one.lerp(coat.passes, coat.mask),
            None => one,
        }
    }

    /// Coated and bare in their shares. `bare` is read only where a lane shows it.
    #[inline(always)]
    fn mixed(&self, _: L, coated: V3<L>, bare: V3<L>) -> V3<L> {
        match (&self.coat, &self.bare) {
            (Some(_), None) => coated,
            (Some(coat), Some(_)) => bare * coat.mask.one_minus() + coated * coat.mask,
            (None, _) => bare,
        }
    }
}

impl<L: Lanes> Base<L> {
    #[inline(always)]
    fn new(l: L, data: &SurfaceData<L>, normal: V3<L>) -> Self {
        let metallic = data.metallic.saturate();
        let (roughness, across) = (data.roughness.saturate(), data.roughness.saturate().squared());
        let (alpha, roughness) = match &data.anisotropy {
            Some(anisotropy) => {
                let strength = anisotropy.base.saturate().squared();
                let across = across.at_least(LEAST_ROUGHNESS * LEAST_ROUGHNESS);
                let along = across * strength.one_minus() + strength;
                ([along, across], (along * across).sqrt().sqrt())
            }
            None => ([across; 2], roughness),
        };
        Self {
            normal,
            alpha,
            roughness,
            trapped_roughness: data.trapped_roughness.unwrap_or(roughness),
            f0: data.dielectric_f0.lerp(data.color, metallic),
            f90: data.dielectric_f90.lerp(l.splat(1.0), metallic),
            dielectric: (data.dielectric_f0, data.dielectric_f90),
            albedo: data.color * metallic.one_minus(),
        }
    }

    /// The base below a coat of that index: the dielectric reflects by its index relative to the coat's, and not at all where the
    /// two are equal. A metal stays as it is.
    #[inline(always)]
    fn below(&self, l: L, metal: V3<L>, metallic: L::F, coat_ior: L::F) -> Self {
        let ((f0, f90), ior) = (self.dielectric, coat_ior.clamp_to(1.0, 3.0));
        let weight = f90.at_least(1e-4).recip();
        // The root of F0 is the relative step of the index, over air and over the coat.
        let step = vec3!(f in f0 => {
            let root = (f * weight).at_least(0.0).sqrt().at_most(0.9);
            let index = (root + 1.0) / root.one_minus();
            (index - ior) / (index + ior)
        });
        let f0 = vec3!(s in step => s * s * f90);
        let largest = step.x.abs().max(step.y.abs()).max(step.z.abs());
        let grazing = (largest * GRAZING[0] / (largest * GRAZING[1] + 1.0)).at_most(1.0);
        let f90 = f90 * grazing;
        Self {
            f0: f0.lerp(metal, metallic),
            f90: f90.lerp(l.splat(1.0), metallic),
            dielectric: (f0, f90),
            ..*self
        }
    }

    /// Transmittance of the dielectric's reflection at a cosine, where a face above returns the share `back` of it:
    /// `(1 - F) / (1 - F back)`.
    #[inline(always)]
    fn left(&self, l: L, cosine: L::F, back: L::F) -> V3<L> {
        let (f0, f90) = self.dielectric;
        let weight = schlick_weight(l, cosine);
        vec3!(f in f0 => {
            let f = f + (f90 - f) * weight;
            f.one_minus() / (f * back).one_minus().at_least(1e-3)
        })
    }

    /// `view` is a unit vector where the base is, `back` as for [`Base::left`].
    #[inline(always)]
    fn seen(&self, l: L, table: &Table<3>, view: V3<L>, back: L::F) -> Seen<L> {
        let n_dot_v = self.normal.dot(view).clamp_to(LEAST_COSINE, 1.0);
        let [all, grazing] = albedos(l, table, n_dot_v, self.roughness);
        let f90 = self.f90;
        let bounces = vec3!(f in self.f0 => {
            let mean = f + (f90 - f) * MEAN_SCHLICK_WEIGHT;
            (mean * all.one_minus()).one_minus().at_least(0.01).recip()
        });
        let once = vec3!(f in self.f0 => f * all + (f90 - f) * grazing);
        let albedo = (once * bounces).at_most(1.0);
        // Rough facets reflect more at some angles than a smooth surface: that is not left either.
        let left = self.left(l, n_dot_v, back);
        let rest = vec3!(a in albedo => a.one_minus() / (a * back).one_minus().at_least(1e-3));
        Seen { view, n_dot_v, bounces, albedo, left: left.min(rest) }
    }
}

impl<L: Lanes> Coated<L> {
    /// Variances of slopes of the base's lobe along each axis, where that share of the face's is added.
    #[inline(always)]
    fn variances(&self, _: L, base: &Base<L>, share: L::F) -> [L::F; 2] {
        let ([x, y], [face_x, face_y]) = (base.alpha, self.alpha);
        [x.squared() + face_x.squared() * share, y.squared() + face_y.squared() * share]
    }
}

/// Alphas of OpenPBR's anisotropy.
#[inline(always)]
fn coat_alphas<L: Lanes>(l: L, roughness: L::F, anisotropy: L::F) -> [L::F; 2] {
    let ratio = anisotropy.saturate().one_minus();
    let along = roughness * roughness * (l.splat(2.0) / (ratio * ratio + 1.0)).sqrt();
    [along, ratio * along]
}

/// Prepares sixteen fragments: the material and all that depends on the view only.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye. `table` is
/// [`crate::brdf::tables::ggx_albedo`].
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    table: &Table<3>,
) -> Surface<L> {
    let base = Base::new(l, data, normal);
    let axes = match &data.anisotropy {
        Some(anisotropy) => {
            let flat = anisotropy.tangent - normal * anisotropy.tangent.dot(normal);
            let tangent = normalize_or(l, flat, anisotropy.tangent);
            Some(Axes { tangent, bitangent: normal.cross(tangent) })
        }
        None => None,
    };
    let coat = match &data.coat {
        Some(coat) => {
            let below = base.below(l, data.color, data.metallic.saturate(), coat.ior);
            Some(coated(l, coat, &below, data.anisotropy.as_ref(), view, table))
        }
        None => None,
    };
    let full = match &coat {
        Some(coat) => coat.mask.ge(l.splat(1.0)).all(),
        None => false,
    };
    let bare = if full { None } else { Some(base.seen(l, table, view, l.zero())) };
    Surface { view, base, axes, coat, bare }
}

/// The coat over a base.
#[inline(always)]
fn coated<L: Lanes>(
    l: L,
    coat: &Coat<L>,
    base: &Base<L>,
    anisotropy: Option<&Anisotropy<L>>,
    view: V3<L>,
    table: &Table<3>,
) -> Coated<L> {
    let roughness = coat.roughness.saturate();
    let alpha = match anisotropy {
        Some(anisotropy) => coat_alphas(l, roughness, anisotropy.coat),
        None => [roughness * roughness; 2],
    };
    let mean_alpha = (alpha[0] * alpha[1]).sqrt();
    let face = Face::new(l, coat.ior, mean_alpha.sqrt(), mean_alpha);
    let at = face.crossing(l, table, coat.normal.dot(view));
    let medium = match &coat.depth {
        Some(depth) => medium(l, *depth, at.inner),
        None => Vec3::splat(l, [1.0; 3]),
    };
    let bounces = Bounces {
        face: &face,
        depth: coat.depth,
        base_alpha: base.trapped_roughness.squared(),
        f0: base.f0,
        dielectric: base.dielectric,
        albedo: base.albedo,
    };
    let trapped = Trapped::new(l, &bounces);
    let beyond = trapped.share_beyond(l, at.inner);
    let back = at.reflected * beyond.one_minus();
    let (inside, bend) = face.bend(l, view, coat.normal, &at);
    let spread = face.spread(l, at.outer, coat.normal.dot(inside).at_least(LEAST_COSINE));
    let seen = base.seen(l, table, inside, at.reflected);
    let around = vec3!(a in seen.albedo => (a * back).one_minus().at_least(1e-3).recip());
    Coated {
        mask: coat.mask.saturate(),
        normal: coat.normal,
        alpha,
        face,
        view: at,
        passes: medium * at.passes(),
        medium,
        depth: coat.depth,
        below: *base,
        base: seen,
        bend,
        spread,
        trapped,
        beyond,
        around,
        back,
    }
}

/// Transmittance of a medium of this optical thickness at an inner cosine.
#[inline(always)]
fn medium<L: Lanes>(l: L, depth: V3<L>, cosine: L::F) -> V3<L> {
    vec3!(t in depth => math::exp_transmittance(l, -t / cosine))
}
