//! The physical material of three.js (`MeshPhysicalMaterial`), release 187, formula by formula.
//!
//! Source: `lights_physical_fragment`, `lights_physical_pars_fragment`, `iridescence_fragment`,
//! `envmap_physical_pars_fragment`, `aomap_fragment` and `meshphysical.glsl` of 0.187.0. The functions carry the names
//! of the originals and perform their operations in the same order. Releases 119 to 131, which are a different
//! model, are in [`super::three_legacy`].
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct()`] for every light and [`indirect()`] for the
//! environment; the sum is the reflected radiance. What the material emits passes the coat:
//! [`Surface::coat_transmittance`].
//!
//! **Radiometry.** The result is radiance for lights in irradiance at normal incidence: the Lambert term is
//! `color / pi`. The environment is radiance, its irradiance has pi in it.
//!
//! **Physics.** GGX over Lambert, energy-compensated (Turquin 2019 under lights, Fdez-Aguera 2019 under an
//! environment); sheen (Charlie) above it; a coat of F0 0.04 above all. The coat dims the layers beneath by its
//! Fresnel reflectance at the angle of view, once, also for direct light and for emission; it neither absorbs nor
//! refracts nor changes the base. All Fresnel terms use Schlick's approximation with a spherical Gaussian in place of
//! the power. Left out: retroreflection, diffuse roughness, transmission, dispersion. Measured in
//! `tests/models/properties.rs` over views, roughness and metalness: under a white environment a white surface shows
//! at most 1, with a coat 1.007; of the light of lights from everywhere it reflects at most 1.03, with a coat 1.004.
//! Nothing is reciprocal: compensation and coat look at the view only.
//!
//! **Beyond the original:** cosines and vectors that the original leaves undefined (light and view opposite, view
//! along the bitangent) have a direction here. Every result is finite for inputs in range and unit vectors. A thin
//! film can be brighter than 1 in a channel, and its F0 negative: the original's, whose frame buffer cuts it off.

mod direct;
mod indirect;
pub(super) mod lobes;
pub(super) use lobes::specular_occlusion;

pub use super::EnvironmentQuery;
use super::glsl::mix;
pub use super::layers::{Coat, Iridescence, Sheen};
pub use direct::{direct, direct_terms};
pub use indirect::{Indirect, ambient_occlusion, environment_queries, indirect, indirect_terms};

use crate::brdf::microfacet::schlick_weight;
use crate::brdf::table::Table;
use crate::brdf::thin_film::{SchlickWeight, ThinFilm, eval_iridescence};
use lobes::EPSILON;
use overcoat_core::each;
use overcoat_core::math::exp;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Colour that the model expects of a light per unit of irradiance at normal incidence: the irradiance itself.
pub const LIGHT_COLOR_PER_IRRADIANCE: f32 = 1.0;

/// F0 of the coat (`clearcoatF0`).
pub const COAT_F0: f32 = 0.04;

/// Least perceptual roughness of base and coat.
pub const LEAST_ROUGHNESS: f32 = 0.045;

/// The anisotropy of a material.
#[derive(Clone, Copy)]
pub struct Anisotropy<L: Lanes> {
    /// Strength (0 to 1) times the direction in the frame of tangent and bitangent (`anisotropyV`).
    pub vector: [L::F; 2],
    /// Unit tangent.
    pub tangent: V3<L>,
    /// Unit bitangent.
    pub bitangent: V3<L>,
}

/// Sixteen fragments' material. A feature that is `None` costs nothing and is one for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metalness: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Perceptual roughness to be added for the variation of the geometric normal within a pixel
    /// (`geometryRoughness`), 0 or more.
    pub geometry_roughness: L::F,
    /// Refractive index of the dielectric, 1 to 2.333; 1.5 by default.
    pub ior: L::F,
    /// `specularIntensity`, 0 to 1; 1 by default.
    pub specular_intensity: L::F,
    /// `specularColor`, linear; white by default.
    pub specular_color: V3<L>,
    /// Clear coat.
    pub coat: Option<Coat<L>>,
    /// Sheen.
    pub sheen: Option<Sheen<L>>,
    /// Thin film.
    pub iridescence: Option<Iridescence<L>>,
    /// Anisotropic highlights.
    pub anisotropy: Option<Anisotropy<L>>,
}

/// A coat as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    /// 0 none to 1 full.
    pub factor: L::F,
    /// Perceptual, in the range of the model.
    pub roughness: L::F,
    /// Unit normal.
    pub normal: V3<L>,
    /// N.V, saturated.
    pub n_dot_v: L::F,
    /// Fresnel reflectance for the view.
    pub fresnel: L::F,
    /// 1 - factor * fresnel: the transmittance for light from beneath.
    pub transmittance: L::F,
    /// Scale and bias of the lookup.
    pub dfg: [L::F; 2],
}

/// Sheen as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct SheenSurface<L: Lanes> {
    /// Linear.
    pub color: V3<L>,
    /// Largest channel of the colour.
    pub largest: L::F,
    /// Perceptual, in the range of the model.
    pub roughness: L::F,
    /// Directional albedo for the view.
    pub albedo: L::F,
}

/// A thin film as [`surface`] prepares it; all 0 where the factor is.
#[derive(Clone, Copy)]
pub struct FilmSurface<L: Lanes> {
    /// 0 none to 1 full; 0 for a thickness of 0.
    pub factor: L::F,
    /// Reflectance for the view.
    pub fresnel: V3<L>,
    /// F0 of the dielectric that Schlick's approximation would need for that.
    pub f0_dielectric: V3<L>,
    /// As above, of the metal.
    pub f0_metallic: V3<L>,
}

/// Anisotropy as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct AnisotropySurface<L: Lanes> {
    /// 0 to 1.
    pub strength: L::F,
    /// Roughness (alpha) along the tangent; along the bitangent it is the base's.
    pub alpha_t: L::F,
    /// Direction of the grooves.
    pub tangent: V3<L>,
    /// Across the grooves.
    pub bitangent: V3<L>,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// Unit normal of the base.
    pub normal: V3<L>,
    /// Unit vector to the eye.
    pub view: V3<L>,
    /// N.V of the base, saturated.
    pub n_dot_v: L::F,
    /// Base colour (`diffuseColor`).
    pub diffuse_color: V3<L>,
    /// The Lambert part's colour (`diffuseContribution`).
    pub diffuse_contribution: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metalness: L::F,
    /// F0 of the dielectric (`specularColor`).
    pub specular_color: V3<L>,
    /// F0 of the mixture (`specularColorBlended`).
    pub specular_color_blended: V3<L>,
    /// Reflectance at grazing angles.
    pub specular_f90: L::F,
    /// Perceptual, in the range of the model.
    pub roughness: L::F,
    /// Scale and bias of the lookup.
    pub dfg: [L::F; 2],
    /// Factor on direct highlights for light lost between microfacets.
    pub multi_scattering_compensation: V3<L>,
    /// The coat, if any lane has one.
    pub coat: Option<CoatSurface<L>>,
    /// Sheen, if any lane has it.
    pub sheen: Option<SheenSurface<L>>,
    /// Thin film, if any lane has one.
    pub film: Option<FilmSurface<L>>,
    /// Anisotropy, if any lane has it.
    pub anisotropy: Option<AnisotropySurface<L>>,
}

impl<L: Lanes> Surface<L> {
    /// Transmittance of the coat towards the eye, for light from beneath such as the material's emission.
    #[inline(always)]
    pub fn coat_transmittance(&self, l: L) -> L::F {
        match &self.coat {
            Some(coat) => coat.transmittance,
            None => l.splat(1.0),
        }
    }
}

/// Reflected light by lobe, before the layers are put together: three.js' accumulators, for direct or indirect light.
#[derive(Clone, Copy)]
pub struct Terms<L: Lanes> {
    /// Lambert.
    pub diffuse: V3<L>,
    /// Base.
    pub specular: V3<L>,
    /// Sheen.
    pub sheen: V3<L>,
    /// Coat, for a factor of 1.
    pub coat: V3<L>,
}

/// Reflected light of all layers.
#[inline(always)]
pub fn outgoing_light<L: Lanes>(_: L, surface: &Surface<L>, terms: &Terms<L>) -> V3<L> {
    let mut out = terms.diffuse + terms.specular;
    if surface.sheen.is_some() {
        out += terms.sheen;
    }
    if let Some(coat) = &surface.coat {
        out = out * coat.transmittance + terms.coat * coat.factor;
    }
    out
}

/// `F_Schlick` with its weight: f0 (1 - w) + f90 w.
#[inline(always)]
pub(super) fn f_schlick<L: Lanes>(_: L, f0: V3<L>, f90: L::F, weight: L::F) -> V3<L> {
    let (rest, grazing) = (weight.one_minus(), f90 * weight);
    f0 * rest + grazing
}

/// The weight for a cosine of 0 to 1.
#[inline(always)]
pub(super) fn fresnel_weight<L: Lanes>(l: L, cosine: L::F) -> L::F {
    SchlickWeight::SphericalGaussian.at(l, cosine)
}

/// `IBLSheenBRDF`: fit of the directional albedo of the sheen lobe, 0 to 1.
#[inline(always)]
pub fn sheen_albedo<L: Lanes>(l: L, cosine: L::F, roughness: L::F) -> L::F {
    let r = roughness;
    let r2 = r * r;
    let q = (r + 0.1).recip();
    let a = r * 1.0678 - 1.9362 + r2 * 0.4573 - q * 0.8469;
    let b = r * 0.5538 - 0.6014 - r2 * 0.4670 - q * 0.1255;
    exp(l, a * cosine + b).saturate()
}

/// Perceptual roughness in the range of the model.
#[inline(always)]
fn material_roughness<L: Lanes>(_: L, roughness: L::F, geometry_roughness: L::F) -> L::F {
    (roughness.at_least(LEAST_ROUGHNESS) + geometry_roughness).at_most(1.0)
}

/// N.V, saturated.
#[inline(always)]
fn cosine<L: Lanes>(_: L, normal: V3<L>, direction: V3<L>) -> L::F {
    normal.dot(direction).saturate()
}

/// Prepares sixteen fragments: the material and all that depends on the view only.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye. `dfg` holds scale and bias over
/// (perceptual roughness, N.V), texels at the centres of cells.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    dfg: &Table<2>,
) -> Surface<L> {
    let roughness = material_roughness(l, data.roughness, data.geometry_roughness);
    let base = dfg.fetch(l, roughness, cosine(l, normal, view));
    let coat = match &data.coat {
        Some(coat) => {
            let roughness = material_roughness(l, coat.roughness, data.geometry_roughness);
            dfg.fetch(l, roughness, cosine(l, coat.normal, view))
        }
        None => base,
    };
    surface_with_dfg(l, data, normal, view, base, coat)
}

/// [`surface`] with scale and bias as fetched for the base and for the coat (of no effect where there is none).
#[inline(always)]
pub fn surface_with_dfg<L: Lanes>(
    l: L,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    dfg: [L::F; 2],
    coat_dfg: [L::F; 2],
) -> Surface<L> {
    let one = l.splat(1.0);
    let n_dot_v = cosine(l, normal, view);
    let roughness = material_roughness(l, data.roughness, data.geometry_roughness);
    let metalness = data.metalness;

    let f0 = ((data.ior - 1.0) / (data.ior + 1.0)).squared();
    let specular_color = (data.specular_color * f0).at_most(1.0) * data.specular_intensity;
    let specular_f90 = data.specular_intensity * metalness.one_minus() + metalness;
    let specular_color_blended = mix(l, specular_color, data.color, metalness);
    let scattered_once = (dfg[0] + dfg[1]).at_least(EPSILON);
    let lost = one / scattered_once - 1.0;

    let film = match &data.iridescence {
        Some(iridescence) => {
            Some(film_surface(l, iridescence, n_dot_v, specular_color, data.color, metalness))
        }
        None => None,
    };
    let anisotropy = match &data.anisotropy {
        Some(anisotropy) => Some(anisotropy_surface(l, anisotropy, roughness)),
        None => None,
    };
    let sheen = match &data.sheen {
        Some(sheen) => {
            let roughness = sheen.roughness.clamp_to(1e-4, 1.0);
            Some(SheenSurface {
                color: sheen.color,
                largest: sheen.color.max_component(),
                roughness,
                albedo: sheen_albedo(l, n_dot_v, roughness),
            })
        }
        None => None,
    };
    let coat = match &data.coat {
        Some(coat) => {
            let n_dot_v = cosine(l, coat.normal, view);
            let weight = fresnel_weight(l, n_dot_v);
            let fresnel = weight.one_minus() * COAT_F0 + weight;
            let factor = coat.factor.saturate();
            Some(CoatSurface {
                factor,
                roughness: material_roughness(l, coat.roughness, data.geometry_roughness),
                normal: coat.normal,
                n_dot_v,
                fresnel,
                transmittance: (factor * fresnel).one_minus(),
                dfg: coat_dfg,
            })
        }
        None => None,
    };
    Surface {
        normal,
        view,
        n_dot_v,
        diffuse_color: data.color,
        diffuse_contribution: data.color * metalness.one_minus(),
        metalness,
        specular_color,
        specular_color_blended,
        specular_f90,
        roughness,
        dfg,
        multi_scattering_compensation: specular_color_blended * lost + 1.0,
        coat,
        sheen,
        film,
        anisotropy,
    }
}

/// The film's reflectance for the view, and the F0 that stand for it under an environment.
#[inline(always)]
fn film_surface<L: Lanes>(
    l: L,
    iridescence: &Iridescence<L>,
    n_dot_v: L::F,
    dielectric_f0: V3<L>,
    metal_f0: V3<L>,
    metalness: L::F,
) -> FilmSurface<L> {
    let film = ThinFilm { ior: iridescence.ior, thickness: iridescence.thickness };
    let fresnel =
        eval_iridescence(l, SchlickWeight::SphericalGaussian, &film, n_dot_v, &[dielectric_f0, metal_f0]);
    // `Schlick_to_F0`, with the power.
    let weight = schlick_weight(l, n_dot_v).clamp_to(0.0, 0.9999);
    let f0: [V3<L>; 2] = each!(f in fresnel => (f - weight) / weight.one_minus());
    let factor = iridescence.thickness.eq(l.zero()).select(l.zero(), iridescence.factor.saturate());
    let present = factor.gt(l.zero());
    let none = Vec3::zero(l);
    FilmSurface {
        factor,
        fresnel: Vec3::select(present, mix(l, fresnel[0], fresnel[1], metalness), none),
        f0_dielectric: Vec3::select(present, f0[0], none),
        f0_metallic: Vec3::select(present, f0[1], none),
    }
}

/// Strength and directions from the vector; a vector of length 0 points along the tangent.
#[inline(always)]
fn anisotropy_surface<L: Lanes>(l: L, anisotropy: &Anisotropy<L>, roughness: L::F) -> AnisotropySurface<L> {
    let [x, y] = anisotropy.vector;
    let length = (x * x + y * y).sqrt();
    let none = length.eq(l.zero());
    let divisor = none.select(l.splat(1.0), length);
    let x = none.select(l.splat(1.0), x / divisor);
    let y = y / divisor;
    let strength = length.saturate();
    let alpha = roughness * roughness;
    let strength2 = strength * strength;
    let (t, b) = (anisotropy.tangent, anisotropy.bitangent);
    AnisotropySurface {
        strength,
        alpha_t: (alpha * strength2.one_minus() + strength2).max(alpha),
        tangent: t * x + b * y,
        bitangent: b * x - t * y,
    }
}
