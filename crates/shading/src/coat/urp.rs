//! Unity URP's Complex Lit with clear coat (`_CLEARCOAT`), formula by formula.
//!
//! Source: universal/ShaderLibrary `BRDF`, `Lighting` and `GlobalIllumination` of package 13.0.0
//! ([`UrpVersion::Desktop`], [`UrpVersion::Mobile`]) and of Unity 6 ([`UrpVersion::Newest`]). The functions
//! carry the names of the originals and perform their operations in the same order.
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct`] for every light and [`indirect`] for
//! the environment; the sum is the reflected radiance.
//!
//! **Radiometry.** URP leaves pi out of its BRDF: the Lambert term is `albedo`, not `albedo / pi`. A light
//! that delivers the irradiance E at normal incidence therefore has the colour [`LIGHT_COLOR_PER_IRRADIANCE`]
//! E = E / pi, and `baked_gi` is the irradiance of the environment divided by pi (the colour that a white
//! Lambert surface would show). The environment itself is radiance.
//!
//! **Physics.** A GGX-like base lobe over Lambert under one smooth dielectric layer of F0 0.04. The coat dims the
//! layers beneath by its Fresnel reflectance on the way out only (Schlick with exponent 4, of the view angle, also for
//! direct light); it neither absorbs nor refracts. Left out: light lost between microfacets, interreflection between
//! the layers, the Fresnel increase of the base's direct highlights towards grazing angles. Measured in
//! `tests/energy.rs`: of the light of one direction, a white metal of smoothness 0, 0.5 and 0.8 reflects 0.2 to 0.33,
//! 1.0 to 1.1 and 1.74 to 1.81 of what falls in (twice as much as a mirror in the limit); under a white environment a
//! surface shows at most 1 from the front, 2 at the silhouette and 1.067 in the mean over all views. Only the base
//! alone is reciprocal.
//!
//! **Beyond the original** (what the original can express changes by rounding at most):
//! * Lanes with a coat mask of exactly 0 keep the bits of a material without coat. (The original takes the
//!   base roughness through [`roughness_to_variance`] and back, which returns it up to rounding.) What a
//!   fragment looks like can therefore not depend on whether its neighbours in the vector have a coat.
//! * A coat normal apart from the base normal, see [`Coat::normal`].
//! * Any dielectric F0 in the metallic workflow, see [`Reflectance::Metallic`].
//!
//! Every result is finite for finite inputs in range and unit vectors; cosines are saturated, a NaN among
//! them counts as 0.

pub use super::EnvironmentQuery;

use crate::brdf::fresnel::{f0_under_coat, f0_under_coat_fast, pow4};
use crate::brdf::ggx::minimalist_cook_torrance;
use crate::brdf::roughness::{roughness_to_variance, variance_to_roughness};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Colour that URP expects of a light per unit of irradiance at normal incidence: 1 / pi.
pub const LIGHT_COLOR_PER_IRRADIANCE: f32 = std::f32::consts::FRAC_1_PI;

/// F0 of dielectrics and of the coat (`kDielectricSpec.rgb`).
pub const DIELECTRIC_F0: f32 = 0.04;

/// 1 - F0 (`kDielectricSpec.a`).
const ONE_MINUS_DIELECTRIC_F0: f32 = 0.96;

/// 2^-14, the smallest normal half-precision number.
const HALF_MIN: f32 = 6.103_515_6e-5;

/// 2^-7.
const HALF_MIN_SQRT: f32 = 0.007_812_5;

/// Ratio of the refractive indices of air and coat, 1 / 1.5.
const CLEAR_COAT_IETA: f32 = 1.0 / 1.5;

/// Which text of URP. Arithmetic is 32-bit in all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UrpVersion {
    /// 13.0 on desktop: the base gets rougher under the coat, F0 by the cubic fit.
    Desktop,
    /// 13.0 on mobile (`SHADER_API_MOBILE`): the base keeps its roughness, F0 by the quadratic fit,
    /// highlights end at 100.
    Mobile,
    /// Unity 6, the same on every platform: the base gets rougher, F0 by the quadratic fit; the specular
    /// workflow darkens diffuse by the largest channel.
    Newest,
    /// Unity 6 where `real` is half precision (`REAL_IS_HALF`): as [`UrpVersion::Newest`] with highlights
    /// that end at 1000.
    NewestHalf,
}

impl UrpVersion {
    /// True if the coat makes the base rougher.
    fn roughens_base(self) -> bool {
        self != Self::Mobile
    }

    /// Upper limit of the specular term, if the version has one.
    fn specular_limit(self) -> Option<f32> {
        match self {
            Self::Mobile => Some(100.0),
            Self::NewestHalf => Some(1000.0),
            Self::Desktop | Self::Newest => None,
        }
    }
}

/// Workflow in which a material states its F0, one for all lanes.
#[derive(Clone, Copy)]
pub enum Reflectance<L: Lanes> {
    /// The metallic workflow.
    Metallic {
        /// 0 dielectric to 1 metal.
        metallic: L::F,
        /// F0 of the dielectric part; [`DIELECTRIC_F0`] in URP. An extension for KHR_materials_ior and
        /// KHR_materials_specular: it stands for `kDielectricSpec.rgb`, and 1 less its largest channel for
        /// `kDielectricSpec.a`, so that 0.04 gives the bits of the original. The coat keeps 0.04, and the
        /// reflectance at grazing angles is not scaled.
        dielectric_f0: V3<L>,
    },
    /// The specular workflow (`_SPECULAR_SETUP`).
    Specular {
        /// F0, linear, 0 to 1.
        color: V3<L>,
    },
}

/// The clear coat of a material.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// 0 none to 1 full.
    pub mask: L::F,
    /// 1 - perceptual roughness of the coat, 0 to 1.
    pub smoothness: L::F,
    /// Unit normal of the coat where it differs from the base's (KHR_materials_clearcoat); URP has one
    /// normal. The coat's highlight, reflection and Fresnel terms use it, the base keeps its own. `None` and
    /// a normal with the base's bits give the same bits.
    pub normal: Option<V3<L>>,
}

/// URP's `SurfaceData`, for sixteen fragments.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub albedo: V3<L>,
    /// F0 by one of the workflows.
    pub reflectance: Reflectance<L>,
    /// 1 - perceptual roughness of the base, 0 to 1.
    pub smoothness: L::F,
    /// `None` where no lane has a coat; the same bits as a mask of 0, and faster.
    pub coat: Option<Coat<L>>,
}

/// URP's `BRDFData`: one layer, ready for any number of lights.
#[derive(Clone, Copy)]
pub struct BrdfData<L: Lanes> {
    /// Base colour as given.
    pub albedo: V3<L>,
    /// Colour of the Lambert part, with pi folded out.
    pub diffuse: V3<L>,
    /// F0.
    pub specular: V3<L>,
    /// Share of light that does not reach the Lambert part.
    pub reflectivity: L::F,
    /// 1 - smoothness.
    pub perceptual_roughness: L::F,
    /// Square of the former (GGX alpha), at least 2^-7.
    pub roughness: L::F,
    /// Square of the former, at least 2^-14.
    pub roughness2: L::F,
    /// Reflectance at grazing angles.
    pub grazing_term: L::F,
    /// 4 roughness + 2.
    pub normalization_term: L::F,
    /// roughness2 - 1.
    pub roughness2_minus_one: L::F,
}

impl<L: Lanes> BrdfData<L> {
    /// `InitializeBRDFDataDirect`.
    #[inline(always)]
    fn new(
        l: L,
        albedo: V3<L>,
        diffuse: V3<L>,
        specular: V3<L>,
        reflectivity: L::F,
        smoothness: L::F,
    ) -> Self {
        let zero = l.zero();
        let mut data = Self {
            albedo,
            diffuse,
            specular,
            reflectivity,
            perceptual_roughness: zero,
            roughness: zero,
            roughness2: zero,
            grazing_term: (smoothness + reflectivity).saturate(),
            normalization_term: zero,
            roughness2_minus_one: zero,
        };
        data.set_perceptual_roughness(smoothness.one_minus());
        data
    }

    /// Sets the roughness and all that derives from it; the grazing term does not.
    #[inline(always)]
    fn set_perceptual_roughness(&mut self, p: L::F) {
        self.perceptual_roughness = p;
        self.roughness = (p * p).at_least(HALF_MIN_SQRT);
        self.roughness2 = (self.roughness * self.roughness).at_least(HALF_MIN);
        self.normalization_term = self.roughness * 4.0 + 2.0;
        self.roughness2_minus_one = self.roughness2 - 1.0;
    }
}

/// `InitializeBRDFData`: the base as it would be without a coat.
#[inline(always)]
pub fn initialize_brdf_data<L: Lanes>(
    l: L,
    version: UrpVersion,
    albedo: V3<L>,
    reflectance: Reflectance<L>,
    smoothness: L::F,
) -> BrdfData<L> {
    match reflectance {
        Reflectance::Metallic { metallic, dielectric_f0 } => {
            let a = dielectric_f0.max_component().one_minus();
            let one_minus_reflectivity = a - metallic * a;
            let diffuse = albedo * one_minus_reflectivity;
            let specular = dielectric_f0.lerp(albedo, metallic);
            BrdfData::new(l, albedo, diffuse, specular, one_minus_reflectivity.one_minus(), smoothness)
        }
        Reflectance::Specular { color } => {
            let reflectivity = color.max_component();
            let diffuse = match version {
                UrpVersion::Desktop | UrpVersion::Mobile => albedo * color.one_minus(),
                UrpVersion::Newest | UrpVersion::NewestHalf => albedo * reflectivity.one_minus(),
            };
            BrdfData::new(l, albedo, diffuse, color, reflectivity, smoothness)
        }
    }
}

/// `InitializeBRDFDataClearCoat`: the coat's data, and the base as it is under the coat.
#[inline(always)]
pub fn initialize_brdf_data_clear_coat<L: Lanes>(
    l: L,
    version: UrpVersion,
    mask: L::F,
    coat_smoothness: L::F,
    base: &mut BrdfData<L>,
) -> BrdfData<L> {
    let f0 = l.splat(DIELECTRIC_F0);
    let diffuse = l.splat(ONE_MINUS_DIELECTRIC_F0);
    let coat = BrdfData::new(
        l,
        Vec3::splat(l, [1.0; 3]),
        Vec3::uniform(diffuse),
        Vec3::uniform(f0),
        f0,
        coat_smoothness,
    );

    if version.roughens_base() {
        let ieta = l.splat(1.0).lerp(l.splat(CLEAR_COAT_IETA), mask);
        let p = base.perceptual_roughness;
        let sigma = roughness_to_variance(l, p * p);
        let rougher = variance_to_roughness(l, sigma * ieta.squared()).sqrt();
        // Without a coat the way there and back would only add rounding.
        base.set_perceptual_roughness(mask.eq(l.zero()).select(p, rougher));
    }
    let under_coat = vec3!(f0 in base.specular => match version {
        UrpVersion::Desktop => f0_under_coat(l, f0),
        UrpVersion::Mobile | UrpVersion::Newest | UrpVersion::NewestHalf => f0_under_coat_fast(l, f0),
    });
    base.specular = base.specular.lerp(under_coat, mask);
    coat
}

/// Half vector of light and view, and its cosine with the light: shared by base and coat.
#[inline(always)]
fn half_vector<L: Lanes>(_: L, light: V3<L>, view: V3<L>) -> (V3<L>, L::F) {
    let half = (light + view).normalize();
    (half, light.dot(half).saturate())
}

/// The specular term of one layer for a half vector.
#[inline(always)]
fn specular_term<L: Lanes>(
    l: L,
    version: UrpVersion,
    data: &BrdfData<L>,
    normal: V3<L>,
    half: V3<L>,
    l_dot_h: L::F,
) -> L::F {
    let n_dot_h = normal.dot(half).saturate();
    let term = minimalist_cook_torrance(
        l,
        n_dot_h,
        l_dot_h,
        data.roughness2,
        data.roughness2_minus_one,
        data.normalization_term,
    );
    match version.specular_limit() {
        Some(limit) => (term - HALF_MIN).clamp_to(0.0, limit),
        None => term,
    }
}

/// `DirectBRDFSpecular`: the specular term of one layer, to be multiplied by F0. Unit vectors; light and view
/// point away from the surface.
#[inline(always)]
pub fn direct_brdf_specular<L: Lanes>(
    l: L,
    version: UrpVersion,
    data: &BrdfData<L>,
    normal: V3<L>,
    light: V3<L>,
    view: V3<L>,
) -> L::F {
    let (half, l_dot_h) = half_vector(l, light, view);
    specular_term(l, version, data, normal, half, l_dot_h)
}

/// A coat over a base, as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    /// The coat's own layer.
    pub data: BrdfData<L>,
    /// 0 none to 1 full.
    pub mask: L::F,
    /// Unit normal of the coat.
    pub normal: V3<L>,
    /// True if the normal was given apart from the base's.
    separate_normal: bool,
    /// (1 - N.V)^4 at the coat.
    fresnel: L::F,
    /// 1 - mask * Fresnel reflectance: the transmittance for light from beneath.
    transmittance: L::F,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    version: UrpVersion,
    /// The base, under the coat if there is one.
    pub base: BrdfData<L>,
    /// The coat, if any lane has one.
    pub coat: Option<CoatSurface<L>>,
    normal: V3<L>,
    view: V3<L>,
    /// (1 - N.V)^4 at the base.
    fresnel: L::F,
}

/// (1 - sat(N.V))^4.
#[inline(always)]
fn fresnel_term<L: Lanes>(l: L, normal: V3<L>, view: V3<L>) -> L::F {
    pow4(l, normal.dot(view).saturate().one_minus())
}

/// Prepares sixteen fragments: layers and all that depends on the view only.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    version: UrpVersion,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
) -> Surface<L> {
    let mut base = initialize_brdf_data(l, version, data.albedo, data.reflectance, data.smoothness);
    let fresnel = fresnel_term(l, normal, view);
    let coat = match &data.coat {
        Some(coat) => {
            let layer = initialize_brdf_data_clear_coat(l, version, coat.mask, coat.smoothness, &mut base);
            let (coat_normal, fresnel) = match coat.normal {
                Some(coat_normal) => (coat_normal, fresnel_term(l, coat_normal, view)),
                None => (normal, fresnel),
            };
            let reflectance = fresnel * ONE_MINUS_DIELECTRIC_F0 + DIELECTRIC_F0;
            Some(CoatSurface {
                data: layer,
                mask: coat.mask,
                normal: coat_normal,
                separate_normal: coat.normal.is_some(),
                fresnel,
                transmittance: (coat.mask * reflectance).one_minus(),
            })
        }
        None => None,
    };
    Surface { version, base, coat, normal, view, fresnel }
}

/// One light, `LightingPhysicallyBased`: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` the irradiance at normal incidence over pi,
/// with distance, cone and shadow applied.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>) -> V3<L> {
    let (half, l_dot_h) = half_vector(l, direction, surface.view);
    let mut cosine = surface.normal.dot(direction).saturate();
    let base = &surface.base;
    let term = specular_term(l, surface.version, base, surface.normal, half, l_dot_h);
    let mut brdf = base.diffuse + base.specular * term;
    if let Some(coat) = &surface.coat {
        let term = specular_term(l, surface.version, &coat.data, coat.normal, half, l_dot_h);
        let mut transmittance = coat.transmittance;
        let mut reflection = term * DIELECTRIC_F0 * coat.mask;
        if coat.separate_normal {
            // Each layer has its own cosine with the light. The larger one is factored out, which leaves
            // weights of exactly 1 where both agree.
            let coat_cosine = coat.normal.dot(direction).saturate();
            let larger = cosine.max(coat_cosine);
            let one = l.splat(1.0);
            let ratio = cosine.min(coat_cosine) / l.zero().lt(larger).select(larger, one);
            // A lane without a coat keeps the base's cosine to the bit.
            let coated = !coat.mask.eq(l.zero());
            transmittance = transmittance * (cosine.lt(coat_cosine) & coated).select(ratio, one);
            reflection = reflection * coat_cosine.lt(cosine).select(ratio, one);
            cosine = coated.select(larger, cosine);
        }
        brdf = brdf * transmittance + reflection;
    }
    let radiance = color * cosine;
    brdf * radiance
}

impl<L: Lanes> Surface<L> {
    /// Environment lookup of the base.
    #[inline(always)]
    pub fn base_query(&self) -> EnvironmentQuery<L> {
        EnvironmentQuery {
            direction: (-self.view).reflect(self.normal),
            perceptual_roughness: self.base.perceptual_roughness,
        }
    }

    /// Environment lookup of the coat, if there is one.
    #[inline(always)]
    pub fn coat_query(&self) -> Option<EnvironmentQuery<L>> {
        match &self.coat {
            Some(coat) => Some(EnvironmentQuery {
                direction: (-self.view).reflect(coat.normal),
                perceptual_roughness: coat.data.perceptual_roughness,
            }),
            None => None,
        }
    }
}

/// `EnvironmentBRDFSpecular`: the reflectance of a layer for prefiltered radiance. `fresnel` is (1 - N.V)^4.
#[inline(always)]
fn environment_brdf_specular<L: Lanes>(_: L, data: &BrdfData<L>, fresnel: L::F) -> V3<L> {
    let surface_reduction = (data.roughness2 + 1.0).recip();
    let color = data.specular.lerp(Vec3::uniform(data.grazing_term), fresnel);
    color * surface_reduction
}

/// The environment, `GlobalIllumination`, with the radiance found for [`Surface::base_query`] and
/// [`Surface::coat_query`] (of no effect where there is no coat).
///
/// `baked_gi` is the irradiance at the base normal over pi, `occlusion` 0 (hidden) to 1.
#[inline(always)]
pub fn global_illumination<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    baked_gi: V3<L>,
    base_radiance: V3<L>,
    coat_radiance: V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let base = &surface.base;
    let reflectance = environment_brdf_specular(l, base, surface.fresnel);
    let mut color = baked_gi * base.diffuse + base_radiance * reflectance;
    if let Some(coat) = &surface.coat {
        let reflectance = environment_brdf_specular(l, &coat.data, coat.fresnel);
        color = color * coat.transmittance + coat_radiance * reflectance * coat.mask;
    }
    color * occlusion
}

/// [`global_illumination`] with the environment as a function of the queries; it is asked once, or twice with
/// a coat.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    baked_gi: V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let base_radiance = environment(surface.base_query());
    let coat_radiance = match surface.coat_query() {
        Some(query) => environment(query),
        None => base_radiance,
    };
    global_illumination(l, surface, baked_gi, base_radiance, coat_radiance, occlusion)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    /// A red, nearly metallic base under a coat, lit from the upper left: known answers of the original
    /// functions.
    fn example(version: UrpVersion) -> Surface<Scalar> {
        let l = Scalar;
        let data = SurfaceData {
            albedo: Vec3::splat(l, [0.8, 0.1, 0.1]),
            reflectance: Reflectance::Metallic {
                metallic: l.splat(0.9),
                dielectric_f0: Vec3::splat(l, [DIELECTRIC_F0; 3]),
            },
            smoothness: l.splat(0.5),
            coat: Some(Coat { mask: l.splat(0.8), smoothness: l.splat(0.9), normal: None }),
        };
        let view = Vec3::splat(l, [0.5, 0.0, 0.75_f32.sqrt()]);
        surface(l, version, &data, Vec3::splat(l, [0.0, 0.0, 1.0]), view)
    }

    #[test]
    fn known_answers() {
        let l = Scalar;
        let sin_40_degrees = 0.642_787_6_f32;
        let z = (1.0 - sin_40_degrees * sin_40_degrees - 0.04).sqrt();
        let light = Vec3::splat(l, [-sin_40_degrees, 0.2, z]);
        let cases = [
            (
                UrpVersion::Desktop,
                [0.637_898_6, 0.029_560_74],
                0.576_286,
                2.942_649,
                [1.401_602, 0.072_445_48],
            ),
            (UrpVersion::Mobile, [0.633_741_2, 0.023_749], 0.5, 4.48, [2.090_071, 0.086_333_42]),
            (UrpVersion::Newest, [0.633_741_2, 0.023_749], 0.576_286, 2.942_649, [1.392_847, 0.060_206_84]),
        ];
        for (version, f0, p, highlight, lit) in cases {
            let near = |found: <Scalar as Lanes>::F, expected: f32| {
                let found = found.to_array()[0];
                assert!((found - expected).abs() <= 2e-6 * expected, "{version:?}: {found} not {expected}");
            };
            let surface = example(version);
            near(surface.base.specular.x, f0[0]);
            near(surface.base.specular.y, f0[1]);
            near(surface.base.perceptual_roughness, p);
            let term = direct_brdf_specular(l, version, &surface.base, surface.normal, light, surface.view);
            near(term, highlight);
            let found = direct(l, &surface, light, Vec3::splat(l, [1.0; 3]));
            near(found.x, lit[0]);
            near(found.y, lit[1]);
        }
    }
}
