//! The physically based material of Babylon.js (`PBRMaterial`) with clear coat, release 9.35, formula by formula.
//!
//! Source: `pbr.fragment`, the includes `pbrBlock*` and `pbr*Functions`, and the classes that set their uniforms, of
//! \@babylonjs/core 9.35.0. The functions carry the names of the originals where there is one. Its other material
//! (`OpenPBRMaterial`) is a different model and not here.
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct()`] for every light and [`indirect()`] for the
//! environment; the sum is the reflected radiance. Emission is added as it is: the coat does not dim it.
//!
//! **Radiometry.** The result is radiance for lights in irradiance at normal incidence: the Lambert term is
//! `color / pi`. The environment is radiance; its irradiance is given over pi (what a white Lambert surface would show).
//!
//! **Physics.** GGX over a diffuse lobe ([`DiffuseModel`]: EON by default, which is Lambert without diffuse
//! roughness), the highlight scaled for light that scatters between microfacets. On top a dielectric of any index with
//! a medium that absorbs ([`Tint`], Beer-Lambert along the refracted paths). The coat dims the layers beneath by its
//! Fresnel reflectance, once: for lights at the half vector, for the environment at the view. F0 of the base under the
//! coat is that of the new interface if [`Coat::remaps_f0`].
//!
//! **Quirks** of the original, all kept:
//! * Diffuse light is dimmed by the constant 1 - F0 only, not by what the highlight takes ([`Options::legacy_energy`], the
//!   default); otherwise by the Fresnel reflectance at N.H (not V.H).
//! * The coat's highlight under lights is scaled by the energy factor of the *base's* F0 with the coat's albedo: that of
//!   a coated metal is coloured. The coat's reflection of the environment is not scaled.
//! * F0 under a coat of exactly 1.5 follows a fit that is 0 for all F0 up to 0.069: seen from the front, plastic has no
//!   highlight of its own.
//! * Alpha is the squared roughness + 0.0005. Rough reflections fade into the irradiance, with weight alpha.
//! * Kelemen's visibility on the coat, so that its highlight has no masking at grazing angles.
//! * Horizon occlusion of the coat depends on whether the *base* has a normal map. Ambient occlusion never reaches the
//!   coat.
//! * N.L ends at 1e-7 and not at 0: behind the terminator something of that order is left, more of very smooth surfaces.
//!   The coat's absorption has no terminator at all.
//!
//! Left out: sheen, thin film, subsurface and refraction, which the tables that the model is held against do not have;
//! filtering in real time; the squared falloff of lights, which is the light's matter.
//! Measured in `tests/models/properties.rs` over views, roughness and metalness: under a white environment a white surface
//! shows at most 1.87 (smooth plastic at the silhouette, whose diffuse light is not dimmed), under a coat 1.06, without
//! [`Options::legacy_energy`] 1 and 1.001; of the light of lights from everywhere it reflects at most 1.06 and 1.12, or
//! 1.002 and 1.05.
//! Nothing is reciprocal: energy factors look at the view only.
//!
//! **Beyond the original:** light and view opposite each other have a half vector here (the normal); Kelemen's visibility
//! and the division by an albedo end. A degenerate tangent frame has a direction. F0 of a dielectric ends at 1. Lights at
//! a place are treated as those from afar in the diffuse lobe (the original passes L.V = 0 there, which matters to rough
//! EON only). Every result is finite for inputs in range and unit vectors, and none is negative.

mod coat;
mod diffuse;
mod direct;
mod indirect;

pub use super::EnvironmentQuery;
pub use coat::{CoatSurface, TintSurface};
pub use direct::{CoatLobe, Direct, direct, direct_terms};
pub use indirect::{
    AmbientOcclusion, Environment, Indirect, color, environment_queries, indirect, indirect_terms,
    irradiance_direction, lod,
};

use super::glsl::{mix, mix_number, normalize_or};
use crate::brdf::table::Table;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::pow;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Colour that the model expects of a light per unit of irradiance at normal incidence: the irradiance itself.
pub const LIGHT_COLOR_PER_IRRADIANCE: f32 = 1.0;

/// `light.radius` by default, in units of length.
pub const LIGHT_RADIUS: f32 = 1e-5;

/// `Epsilon`.
const EPSILON: f32 = 1e-7;

/// `MINIMUMVARIANCE`: added to every alpha.
const MINIMUM_VARIANCE: f32 = 0.0005;

/// Least albedo that energy factors divide by; the table is above 0.3 for real roughness.
const LEAST_ALBEDO: f32 = 1e-3;

/// The diffuse lobe of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DiffuseModel {
    /// Energy-preserving Oren-Nayar (Portsmouth, Kutz and Hill 2024).
    #[default]
    Eon,
    /// Burley's, with the diffuse roughness.
    Burley,
    /// Lambert's.
    Lambert,
    /// Burley's with the roughness of the highlight: files of older releases.
    Legacy,
}

/// Switches of the shader. They hold for all lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Options {
    /// `LEGACY_SPECULAR_ENERGY_CONSERVATION`: diffuse light is dimmed by a constant.
    pub legacy_energy: bool,
    /// `MS_BRDF_ENERGY_CONSERVATION`: highlights are scaled for light that scatters between microfacets.
    pub energy_conservation: bool,
    /// `BRDF_V_HEIGHT_CORRELATED`: Smith's visibility with correlated heights. Without it the original also turns
    /// `energy_conservation` off, and reads another table ([`surface`]).
    pub height_correlated: bool,
    /// The diffuse lobe.
    pub diffuse: DiffuseModel,
    /// `ANISOTROPIC_LEGACY`: roughness along both axes as in files of releases before 6.4.
    pub legacy_anisotropy: bool,
    /// True if the extent of a light adds to the roughness: every falloff but "standard".
    pub soft_lights: bool,
    /// `MIX_IBL_RADIANCE_WITH_IRRADIANCE`: rough reflections fade into the irradiance.
    pub mixes_irradiance: bool,
    /// `USESPHERICALINVERTEX`: irradiance is that of the geometric normal.
    pub irradiance_in_vertex: bool,
    /// `LINEARSPECULARREFLECTION`: the environment's levels are linear in the perceptual roughness.
    pub linear_specular: bool,
    /// `RADIANCEOCCLUSION`: ambient occlusion dims reflections too.
    pub radiance_occlusion: bool,
    /// `HORIZONOCCLUSION`: reflections that a normal map sends below the geometric horizon are dimmed.
    pub horizon_occlusion: bool,
}

impl Default for Options {
    /// The engine's, which are the glTF loader's too.
    fn default() -> Self {
        Self {
            legacy_energy: true,
            energy_conservation: true,
            height_correlated: true,
            diffuse: DiffuseModel::Eon,
            legacy_anisotropy: false,
            soft_lights: true,
            mixes_irradiance: true,
            irradiance_in_vertex: true,
            linear_specular: false,
            radiance_occlusion: true,
            horizon_occlusion: true,
        }
    }
}

/// Absorption by the coat's medium (`clearCoat.isTintEnabled`).
#[derive(Clone, Copy)]
pub struct Tint<L: Lanes> {
    /// `tintColor`, linear, 0 to 1: transmittance after `at_distance`.
    pub color: V3<L>,
    /// `tintColorAtDistance`, above 0; 1 by default. Held at 1e-5 or more.
    pub at_distance: L::F,
    /// `tintThickness`, 0 or more, in the unit of the distance; 1 by default. Held at 1e-5 or more.
    pub thickness: L::F,
}

/// The clear coat of a material.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// `intensity`, 0 none to 1 full.
    pub intensity: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// `indexOfRefraction`, 1 to 3; 1.5 by default, and always from KHR_materials_clearcoat.
    pub ior: L::F,
    /// Unit normal of the coat: that of its own map, else the geometric one (never that of the base's map).
    pub normal: V3<L>,
    /// The larger of |dN/dx| and |dN/dy| of that normal over a pixel, 0 or more; `None` is `SPECULARAA` off.
    pub normal_slope: Option<L::F>,
    /// `remapF0OnInterfaceChange`: F0 of the base becomes that of its interface with the coat. On by default, off from
    /// glTF files.
    pub remaps_f0: bool,
    /// The medium; `None` is clear.
    pub tint: Option<Tint<L>>,
}

/// The anisotropy of a material.
#[derive(Clone, Copy)]
pub struct Anisotropy<L: Lanes> {
    /// `intensity`, 0 to 1; -1 to 1 with [`Options::legacy_anisotropy`].
    pub intensity: L::F,
    /// Direction of the larger roughness in the frame of tangent and bitangent: cosine and sine of the rotation.
    pub direction: [L::F; 2],
    /// Tangent.
    pub tangent: V3<L>,
    /// Bitangent.
    pub bitangent: V3<L>,
}

/// Sixteen fragments' material. A feature that is `None` costs nothing and is one for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// `albedoColor`, linear, 0 to 1.
    pub base_color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// `indexOfRefraction` of the dielectric, 1 to 3; 1.5 by default.
    pub ior: L::F,
    /// `metallicF0Factor`, 0 to 1; 1 by default. Also the reflectance at grazing angles, metals included, with
    /// [`Options::legacy_energy`].
    pub specular_weight: L::F,
    /// `metallicReflectanceColor`, linear, 0 or more; white by default. Times weight and F0 of the index it counts up to 1.
    pub specular_color: V3<L>,
    /// `baseDiffuseRoughness`, 0 to 1; 0 by default.
    pub diffuse_roughness: L::F,
    /// The larger of |dN/dx| and |dN/dy| of the base's normal over a pixel, 0 or more; `None` is `SPECULARAA` off, the
    /// engine's default (the glTF loader turns it on).
    pub normal_slope: Option<L::F>,
    /// Unit normal of the geometry, without a normal map.
    pub geometric_normal: V3<L>,
    /// True if the base has a normal map (`BUMP`), without which there is no horizon occlusion.
    pub normal_mapped: bool,
    /// Clear coat.
    pub coat: Option<Coat<L>>,
    /// Anisotropic highlights.
    pub anisotropy: Option<Anisotropy<L>>,
}

/// Texels of the albedo table for sixteen fragments: GGX weighted with (1 - V.H)^5, and without weight.
#[derive(Clone, Copy)]
pub struct Lookups<L: Lanes> {
    /// For N.V and roughness of the base.
    pub base: [L::F; 2],
    /// For N.V and roughness of the coat; of no effect where there is none.
    pub coat: [L::F; 2],
}

/// Roughness that the variation of a normal within a pixel adds (`getAARoughnessFactors`).
#[derive(Clone, Copy)]
pub struct AaRoughness<L: Lanes> {
    /// Least perceptual roughness of highlights, 0 to 1.
    pub perceptual: L::F,
    /// Added to the alpha of reflections, 0 or more.
    pub alpha: L::F,
}

/// Anisotropy as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct AnisotropySurface<L: Lanes> {
    /// As given.
    pub intensity: L::F,
    /// Direction of the larger roughness.
    pub tangent: V3<L>,
    /// Across it and the normal.
    pub bitangent: V3<L>,
    /// The normal that the environment is mirrored at.
    pub normal: V3<L>,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// Switches.
    pub options: Options,
    /// Unit normal of the base.
    pub normal: V3<L>,
    /// Unit normal of the geometry.
    pub geometric_normal: V3<L>,
    /// True if the base has a normal map.
    pub normal_mapped: bool,
    /// Unit vector to the eye.
    pub view: V3<L>,
    /// N.V of the base, with its sign.
    pub n_dot_v_unclamped: L::F,
    /// |N.V| + 1e-7.
    pub n_dot_v: L::F,
    /// Colour of the diffuse lobe.
    pub surface_albedo: V3<L>,
    /// F0 without a coat.
    pub f0: V3<L>,
    /// F0 under the coat.
    pub f0_coated: V3<L>,
    /// Reflectance at grazing angles.
    pub f90: L::F,
    /// `reflectanceF0`: stands for F0 where diffuse light is dimmed.
    pub reflectance_f0: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Roughness of the diffuse lobe, 0 to 1.
    pub diffuse_roughness: L::F,
    /// For the variation of the normal within a pixel.
    pub aa: AaRoughness<L>,
    /// Alpha of the reflection of the environment, above 0; above 1 for the roughest.
    pub alpha_g: L::F,
    /// Environment BRDF of the base (see [`Lookups`]); `None` without a table.
    pub brdf: Option<[L::F; 2]>,
    /// Factor on highlights for light that scatters between microfacets.
    pub energy_factor: V3<L>,
    /// The same for `reflectance_f0`.
    pub base_energy_factor: L::F,
    /// The coat, if any lane has one.
    pub coat: Option<CoatSurface<L>>,
    /// Anisotropy, if any lane has it.
    pub anisotropy: Option<AnisotropySurface<L>>,
}

/// `convertRoughnessToAverageSlope`: alpha of a perceptual roughness.
#[inline(always)]
fn average_slope<L: Lanes>(_: L, roughness: L::F) -> L::F {
    roughness * roughness + MINIMUM_VARIANCE
}

/// `absEps`.
#[inline(always)]
fn abs_eps<L: Lanes>(_: L, x: L::F) -> L::F {
    x.abs() + EPSILON
}

/// `getAARoughnessFactors`.
#[inline(always)]
fn aa_roughness<L: Lanes>(l: L, slope: Option<L::F>) -> AaRoughness<L> {
    match slope {
        Some(slope) => {
            let slope2 = slope * slope;
            AaRoughness { perceptual: pow(l, slope2.saturate(), l.splat(0.333)), alpha: slope2.sqrt() * 0.75 }
        }
        None => AaRoughness { perceptual: l.zero(), alpha: l.zero() },
    }
}

/// `getEnergyConservationFactor`: 1 + f0 (1 / albedo - 1), albedo that of the lobe for F0 = 1.
#[inline(always)]
fn energy_factor<L: Lanes>(_: L, f0: L::F, albedo: L::F) -> L::F {
    f0 * (albedo.at_least(LEAST_ALBEDO).recip() - 1.0) + 1.0
}

/// Albedos of GGX for a layer, weighted with (1 - V.H)^5 and without weight.
#[inline(always)]
fn fetch<L: Lanes>(l: L, table: &Table<3>, normal: V3<L>, view: V3<L>, roughness: L::F) -> [L::F; 2] {
    table.fetch_first(l, abs_eps(l, normal.dot(view)).sqrt(), roughness)
}

/// Prepares sixteen fragments: the material and all that depends on the view only.
///
/// `normal` (of the base) and `view` are unit vectors in one space; `view` points to the eye. `albedos` are those of GGX
/// over (sqrt(N.V), perceptual roughness), weighted with (1 - V.H)^5 and without weight:
/// [`crate::brdf::tables::ggx_albedo`]. The engine ships these integrals at (N.V, perceptual roughness) with eight bits
/// a channel, 0.0036 from them in the mean square. `None` where it has no environment BRDF texture. Without
/// [`Options::height_correlated`] they must be scale and bias instead, which it does not ship.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    options: &Options,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    albedos: Option<&Table<3>>,
) -> Surface<L> {
    let lookups = match albedos {
        Some(table) => {
            let base = fetch(l, table, normal, view, data.roughness);
            let coat = match &data.coat {
                Some(coat) => fetch(l, table, coat.normal, view, coat.roughness),
                None => base,
            };
            Some(Lookups { base, coat })
        }
        None => None,
    };
    surface_with_lookups(l, options, data, normal, view, lookups.as_ref())
}

/// [`surface`] with the texels of the table.
#[inline(always)]
pub fn surface_with_lookups<L: Lanes>(
    l: L,
    options: &Options,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    lookups: Option<&Lookups<L>>,
) -> Surface<L> {
    let one = l.splat(1.0);
    // As the original does; sharp highlights need the last bit.
    let view = view.divide_by_length();
    let n_dot_v_unclamped = normal.dot(view);
    let n_dot_v = abs_eps(l, n_dot_v_unclamped);
    let metallic = data.metallic;
    let roughness = data.roughness.one_minus().saturate().one_minus();

    let weighted_f0 = ((data.ior - 1.0) / (data.ior + 1.0)).squared() * data.specular_weight;
    let dielectric_f0 = (data.specular_color * weighted_f0).at_most(1.0);
    let f0 = mix(l, dielectric_f0, data.base_color, metallic);
    let (f90, reflectance_f0, surface_albedo) = if options.legacy_energy {
        let albedo = data.base_color * dielectric_f0.one_minus() * metallic.one_minus();
        (data.specular_weight, f0.max_component(), albedo)
    } else {
        let grazing = data.specular_weight * ((data.ior - 1.0) * 2.0).saturate();
        let largest = dielectric_f0.max_component();
        (mix_number(l, grazing, one, metallic), mix_number(l, largest, one, metallic), data.base_color)
    };
    let aa = aa_roughness(l, data.normal_slope);
    let f0_coated = match &data.coat {
        Some(coat) if coat.remaps_f0 => mix(l, f0, coat::f0_under_coat(l, f0, coat.ior), coat.intensity),
        _ => f0,
    };
    let compensation = if options.energy_conservation { lookups } else { None };
    let (energy, base_energy) = match compensation {
        Some(found) => (
            vec3!(f0 in f0_coated => energy_factor(l, f0, found.base[1])),
            energy_factor(l, reflectance_f0, found.base[1]),
        ),
        None => (Vec3::uniform(one), one),
    };
    let (base_brdf, coat_brdf) = match lookups {
        Some(found) => (Some(found.base), Some(found.coat)),
        None => (None, None),
    };
    let coat = match &data.coat {
        Some(coat) => Some(coat::coat_surface(l, options, coat, view, f0_coated, coat_brdf)),
        None => None,
    };
    let anisotropy = match &data.anisotropy {
        Some(anisotropy) => Some(anisotropy_surface(l, options, anisotropy, normal, view, roughness)),
        None => None,
    };
    Surface {
        options: *options,
        normal,
        geometric_normal: data.geometric_normal,
        normal_mapped: data.normal_mapped,
        view,
        n_dot_v_unclamped,
        n_dot_v,
        surface_albedo,
        f0,
        f0_coated,
        f90,
        reflectance_f0,
        roughness,
        diffuse_roughness: data.diffuse_roughness,
        aa,
        alpha_g: average_slope(l, roughness) + aa.alpha,
        brdf: base_brdf,
        energy_factor: energy,
        base_energy_factor: base_energy,
        coat,
        anisotropy,
    }
}

/// `anisotropicBlock`: the frame, and the normal bent towards the plane of view and grooves.
#[inline(always)]
fn anisotropy_surface<L: Lanes>(
    l: L,
    options: &Options,
    anisotropy: &Anisotropy<L>,
    normal: V3<L>,
    view: V3<L>,
    roughness: L::F,
) -> AnisotropySurface<L> {
    let k = anisotropy.intensity;
    let [x, y] = anisotropy.direction;
    let (along, across) = (anisotropy.tangent.divide_by_length(), anisotropy.bitangent.divide_by_length());
    let tangent = (along * x + across * y).divide_by_length();
    let unit_normal = normal.divide_by_length();
    let bitangent = unit_normal.cross(tangent).divide_by_length();
    let bent = if options.legacy_anisotropy {
        let grooves = Vec3::select(k.ge(l.zero()), bitangent, tangent);
        let unit = grooves.divide_by_length();
        let bent = unit.cross(view).cross(grooves);
        mix(l, normal, bent, k.abs())
    } else {
        let across = bitangent.cross(view).cross(bitangent);
        let bent = normalize_or(l, across, normal);
        let towards = (k * roughness.one_minus()).one_minus();
        let towards2 = towards * towards;
        mix(l, bent, normal, towards2 * towards2)
    };
    AnisotropySurface { intensity: k, tangent, bitangent, normal: normalize_or(l, bent, normal) }
}
