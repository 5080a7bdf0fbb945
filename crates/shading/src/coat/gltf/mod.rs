//! The material of the Khronos glTF Sample Renderer, formula by formula: metallic-roughness with
//! KHR_materials_specular, _ior, _clearcoat, _sheen, _anisotropy and _iridescence.
//!
//! Source: `pbr.frag`, `brdf.glsl`, `punctual.glsl`, `ibl.glsl`, `iridescence.glsl` and `material_info.glsl` of
//! \@khronosgroup/gltf-viewer 1.1.0. The functions carry the names of the originals and perform their operations in the
//! same order.
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct()`] for every light and [`indirect()`] for the
//! environment; the sum is the reflected radiance. What the material emits passes the coat:
//! [`Surface::coat_transmittance`].
//!
//! **Radiometry.** The result is radiance for lights in irradiance at normal incidence (lux): the Lambert term is
//! `color / pi`. The environment is radiance, its irradiance has pi in it.
//!
//! **Physics.** The appendix of glTF 2.0: a dielectric (Lambert under GGX, mixed by Schlick's Fresnel reflectance of the
//! half vector) and a metal, mixed; sheen (Charlie) above, whose albedo is taken from what is beneath; a coat above
//! all, mixed in by its Fresnel reflectance for the *view*, which therefore also weighs its highlight: the coat's lobe
//! has no Fresnel term of its own. Under an environment the base's multiple scattering is compensated (Fdez-Aguera
//! 2019), under lights it is not. The coat neither absorbs nor refracts nor changes the base.
//! Measured in `tests/models/properties.rs` over views, roughness and metalness: under a white environment a white surface
//! shows at most 1, with or without coat, and with white sheen 1.47 (the table of the sheen's lobe samples one roughness
//! and evaluates another); of the light of lights from everywhere it reflects at most 1.03, with a coat 1, with sheen
//! 1.01. Base and sheen are reciprocal, the coat is not: it looks at the view only.
//!
//! **Deviations.** The Sample Renderer takes the coat's F0 from the *base's* index of refraction, the extension's text
//! says 0.04; both are a value ([`CoatF0`]). Distributions of roughness 0, which the original divides by zero, give no
//! highlight, and end at 10^12. Directions that it leaves undefined (light and view opposite, view along the
//! bitangent) have one here. The cube for sheen that the original is given has a level for each roughness; the maps here
//! have six between 0.18 and 1 (`light/charlie.rs`), and smoother cloth sees what 0.18 sees. Every result is finite for inputs in range and unit vectors. A thin film can be brighter
//! than 1 in a channel and then takes more from beneath than there is: as in the original.

mod direct;
mod indirect;
mod sampled;

pub use super::EnvironmentQuery;
pub use super::layers::{Coat, Iridescence, Sheen};
pub use direct::{Direct, direct, direct_terms};
pub use indirect::{
    Environment, EnvironmentQueries, Indirect, environment_queries, ibl_ggx_fresnel, indirect, indirect_terms,
};
pub use sampled::{Scattering, indirect_sampled, mean_schlick_weight};

use super::glsl::mix;
use crate::brdf::microfacet::schlick;
use crate::brdf::table::Table;
use crate::brdf::thin_film::{SchlickWeight, ThinFilm, eval_iridescence};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::V3;

/// Colour that the model expects of a light per unit of irradiance at normal incidence: the irradiance itself.
pub const LIGHT_COLOR_PER_IRRADIANCE: f32 = 1.0;

/// Source of the coat's F0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CoatF0 {
    /// The base's index of refraction: the Sample Renderer. Differs from [`CoatF0::Fixed`] where KHR_materials_ior is
    /// not 1.5.
    BaseIor,
    /// 0.04, an index of 1.5: the text of KHR_materials_clearcoat.
    Fixed,
}

/// The anisotropy of a material.
#[derive(Clone, Copy)]
pub struct Anisotropy<L: Lanes> {
    /// 0 to 1.
    pub strength: L::F,
    /// Direction of the larger roughness in the frame of tangent and bitangent: cosine and sine of the rotation.
    pub direction: [L::F; 2],
    /// Unit tangent.
    pub tangent: V3<L>,
    /// Unit bitangent.
    pub bitangent: V3<L>,
    /// Unit normal of the geometry, without a normal map: it completes the frame.
    pub geometric_normal: V3<L>,
}

/// Sixteen fragments' material. A feature that is `None` costs nothing and is one for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub base_color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Refractive index of the dielectric; 1.5 by default. 0 makes its F0 1.
    pub ior: L::F,
    /// `specularFactor`, 0 to 1; 1 by default.
    pub specular_factor: L::F,
    /// `specularColorFactor`, linear; white by default. Times the F0 it counts up to 1.
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

/// The pre-integrated tables of the model, texels over (N.V, perceptual roughness).
#[derive(Clone, Copy)]
pub struct Tables<'a> {
    /// Scale and bias of GGX, and the sheen lobe's albedo under the environment.
    pub brdf: &'a Table<3>,
    /// Directional albedo of the sheen, at most 1 of which counts.
    pub sheen_albedo: &'a Table<1>,
}

/// Texels of the tables for sixteen fragments.
#[derive(Clone, Copy)]
pub struct Lookups<L: Lanes> {
    /// Scale and bias of GGX for (N.V, roughness).
    pub ggx: [L::F; 2],
    /// Albedo of the sheen under the environment for (N.V, sheen roughness); of no effect without sheen.
    pub charlie: L::F,
    /// Directional albedo of the sheen for (N.V, sheen roughness); of no effect without sheen.
    pub sheen_albedo: L::F,
}

/// A coat as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Unit normal.
    pub normal: V3<L>,
    /// N.V, saturated.
    pub n_dot_v: L::F,
    /// Factor times Fresnel reflectance for the view: share of the coat in the blend with the layers beneath.
    pub weight: L::F,
}

/// Sheen as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct SheenSurface<L: Lanes> {
    /// Linear.
    pub color: V3<L>,
    /// Largest channel of the colour.
    pub largest: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Transmittance of the sheen for the view: 1 - its directional albedo, scaled by its colour.
    pub scaling: L::F,
    /// Albedo of the lobe under the environment.
    pub charlie: L::F,
    /// The visibility for the view's side.
    visibility: direct::SheenVisibility<L>,
}

/// A thin film as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct FilmSurface<L: Lanes> {
    /// 0 none to 1 full; 0 for a thickness of 0.
    pub factor: L::F,
    /// Reflectance on the dielectric for the view.
    pub dielectric: V3<L>,
    /// Reflectance on the metal for the view.
    pub metallic: V3<L>,
}

/// Anisotropy as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct AnisotropySurface<L: Lanes> {
    /// 0 to 1.
    pub strength: L::F,
    /// Direction of the larger roughness.
    pub tangent: V3<L>,
    /// Across it and the geometric normal.
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
    /// Base colour.
    pub base_color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// F0 of the dielectric, before the factor.
    pub f0_dielectric: V3<L>,
    /// The factor, and the dielectric's reflectance at grazing angles.
    pub specular_weight: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Its square.
    pub alpha_roughness: L::F,
    /// Scale and bias of the lookup.
    pub ggx: [L::F; 2],
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
            Some(coat) => coat.weight.one_minus(),
            None => l.splat(1.0),
        }
    }
}

/// Reflected light by lobe, for direct or indirect light.
#[derive(Clone, Copy)]
pub struct Terms<L: Lanes> {
    /// The Lambert lobe, without Fresnel terms.
    pub diffuse: V3<L>,
    /// The base's highlight or reflection, without Fresnel terms.
    pub specular: V3<L>,
    /// The metal.
    pub metal: V3<L>,
    /// The dielectric.
    pub dielectric: V3<L>,
    /// The sheen.
    pub sheen: V3<L>,
    /// Transmittance of the sheen for light from beneath.
    pub sheen_scaling: L::F,
    /// The coat, without Fresnel term and factor.
    pub coat: V3<L>,
}

/// Reflected light of base and sheen, beneath the coat.
#[inline(always)]
pub fn beneath_coat<L: Lanes>(l: L, surface: &Surface<L>, terms: &Terms<L>) -> V3<L> {
    let base = mix(l, terms.dielectric, terms.metal, surface.metallic);
    match surface.sheen {
        Some(_) => terms.sheen + base * terms.sheen_scaling,
        None => base,
    }
}

/// Reflected light of all layers.
#[inline(always)]
pub fn color<L: Lanes>(l: L, surface: &Surface<L>, terms: &Terms<L>) -> V3<L> {
    let base = beneath_coat(l, surface, terms);
    match &surface.coat {
        Some(coat) => mix(l, base, terms.coat, coat.weight),
        None => base,
    }
}

/// Lambert and highlight (or reflection) as dielectric and as metal, by their Fresnel reflectances; the thin film
/// has its own.
#[inline(always)]
fn dielectric_and_metal<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    [diffuse, specular]: [V3<L>; 2],
    [dielectric_fresnel, metal_fresnel]: [V3<L>; 2],
) -> [V3<L>; 2] {
    let dielectric = diffuse * dielectric_fresnel.one_minus() + specular * dielectric_fresnel;
    let metal = metal_fresnel * specular;
    let Some(film) = &surface.film else { return [dielectric, metal] };
    // `rgb_mix`.
    let beneath = film.dielectric.max_component().one_minus();
    let filmed = diffuse * beneath + film.dielectric * specular;
    let filmed_metal = specular * film.metallic;
    [mix(l, dielectric, filmed, film.factor), mix(l, metal, filmed_metal, film.factor)]
}

/// N.X, saturated.
#[inline(always)]
fn cosine<L: Lanes>(_: L, normal: V3<L>, direction: V3<L>) -> L::F {
    normal.dot(direction).saturate()
}

/// Prepares sixteen fragments: the material and all that depends on the view only.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    coat_f0: CoatF0,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    tables: Tables<'_>,
) -> Surface<L> {
    let n_dot_v = cosine(l, normal, view);
    let [scale, bias] = tables.brdf.fetch_first(l, n_dot_v, data.roughness);
    let (charlie, sheen_albedo) = match &data.sheen {
        Some(sheen) => {
            let [_, _, charlie] = tables.brdf.fetch(l, n_dot_v, sheen.roughness);
            let [albedo] = tables.sheen_albedo.fetch(l, n_dot_v, sheen.roughness);
            (charlie, albedo.saturate())
        }
        None => (l.zero(), l.zero()),
    };
    let lookups = Lookups { ggx: [scale, bias], charlie, sheen_albedo };
    surface_with_lookups(l, coat_f0, data, normal, view, &lookups)
}

/// The film's reflectance for the view on a dielectric and a metal of these F0.
#[inline(always)]
fn film_surface<L: Lanes>(l: L, film: &Iridescence<L>, n_dot_v: L::F, bases: [V3<L>; 2]) -> FilmSurface<L> {
    let factor = film.thickness.eq(l.zero()).select(l.zero(), film.factor.saturate());
    let film = ThinFilm { ior: film.ior, thickness: film.thickness };
    let [dielectric, metallic] = eval_iridescence(l, SchlickWeight::Power, &film, n_dot_v, &bases);
    FilmSurface { factor, dielectric, metallic }
}

/// [`surface`] with the texels of the tables.
#[inline(always)]
pub fn surface_with_lookups<L: Lanes>(
    l: L,
    coat_f0: CoatF0,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    lookups: &Lookups<L>,
) -> Surface<L> {
    // As the original does; sharp highlights need the last bit.
    let view = view.divide_by_length();
    let n_dot_v = cosine(l, normal, view);
    let roughness = data.roughness.saturate();
    let f0 = ((data.ior - 1.0) / (data.ior + 1.0)).squared();
    let f0_dielectric = (data.specular_color * f0).at_most(1.0);
    let film = match &data.iridescence {
        Some(film) => Some(film_surface(l, film, n_dot_v, [f0_dielectric, data.base_color])),
        None => None,
    };
    let sheen = match &data.sheen {
        Some(sheen) => {
            let largest = sheen.color.max_component();
            Some(SheenSurface {
                color: sheen.color,
                largest,
                roughness: sheen.roughness,
                scaling: (largest * lookups.sheen_albedo).one_minus(),
                charlie: lookups.charlie,
                visibility: direct::SheenVisibility::new(l, n_dot_v, sheen.roughness),
            })
        }
        None => None,
    };
    let anisotropy = match &data.anisotropy {
        Some(anisotropy) => {
            let [x, y] = anisotropy.direction;
            let tangent = anisotropy.tangent * x + anisotropy.bitangent * y;
            Some(AnisotropySurface {
                strength: anisotropy.strength.saturate(),
                tangent,
                bitangent: anisotropy.geometric_normal.cross(tangent),
            })
        }
        None => None,
    };
    let coat = match &data.coat {
        Some(coat) => {
            let n_dot_v = cosine(l, coat.normal, view);
            let f0 = match coat_f0 {
                CoatF0::BaseIor => f0,
                CoatF0::Fixed => l.splat(0.04),
            };
            Some(CoatSurface {
                roughness: coat.roughness.saturate(),
                normal: coat.normal,
                n_dot_v,
                weight: coat.factor.saturate() * schlick(l, f0, l.splat(1.0), n_dot_v),
            })
        }
        None => None,
    };
    Surface {
        normal,
        view,
        n_dot_v,
        base_color: data.base_color,
        metallic: data.metallic.saturate(),
        f0_dielectric,
        specular_weight: data.specular_factor,
        roughness,
        alpha_roughness: roughness * roughness,
        ggx: lookups.ggx,
        coat,
        sheen,
        film,
        anisotropy,
    }
}
