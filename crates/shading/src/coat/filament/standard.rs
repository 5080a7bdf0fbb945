//! Filament's standard lit model with clear coat, anisotropy and sheen.
//!
//! Conventions and radiometry as in the [parent](super).
//!
//! **Physics.** A GGX lobe over Lambert, scaled for the light that scatters between microfacets; optionally a cloth lobe
//! on it; on top one dielectric layer of F0 0.04. Under the coat the base's F0 is that of the new interface, and the
//! base is at least as rough as the coat. The coat dims diffuse and specular by one factor, 1 - clearCoat F; F is of
//! the half vector for lights and of the view for the environment. It neither absorbs nor refracts, and its reflection
//! of the environment is F alone, without the table. Lambert and the specular lobe do not know of each other under
//! lights. Measured (`tests/models/filament.rs`): of light from all directions, white plastic of roughness 0.5 sends back
//! 1.04 of what falls in seen from the front, 1.17 at N.V = 0.1 and 1.21 at 0.01; the same under a coat of roughness 0.3
//! 1.00, 1.23 and 1.16; a white metal 0.99 to 1.01, coated 1.00, 1.09, 1.01. A white environment shows white within 0.02.
//! `sheenScaling` falls below 0 where the albedo of the cloth lobe exceeds 1 (smooth cloth at grazing angles): the base
//! then counts negative, as in the original. For fixed table values the lobes are reciprocal; energy compensation and
//! `sheenScaling`, read for the view alone, are not.
//!
//! Lanes with a coat mask of exactly 0 keep the bits of a material without coat (but -0 may become 0).

pub use crate::coat::EnvironmentQuery;
pub use crate::coat::layers::Sheen;

use super::{
    Half, LEAST_ANISOTROPIC, Quality, bent_mirror, clamp_n_dot_v, d_ggx, dominant_direction,
    f0_clear_coat_to_surface, fresnel, sine_squared, visibility,
};
use crate::brdf::microfacet::{
    distribution_ggx_anisotropic, schlick, visibility_kelemen, visibility_smith_anisotropic,
};
use crate::brdf::sheen::{LEAST_SINE_SQUARED, distribution_charlie, visibility_neubelt};
use crate::brdf::table::Table;
use crate::coat::glsl::{mix, mix_number};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use std::f32::consts::FRAC_1_PI;

/// F0 of the coat.
const COAT_F0: f32 = 0.04;

/// Least y of the DFG table; the table is above 0.27 for real roughness.
const LEAST_DFG: f32 = 1e-3;

/// The clear coat of a material.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// `clearCoat`, 0 none to 1 full.
    pub mask: L::F,
    /// `clearCoatRoughness`, perceptual, 0 to 1.
    pub perceptual_roughness: L::F,
    /// Unit normal of the coat where the material has a normal map or a coat normal; `None` lights the coat with the
    /// base's normal.
    pub normal: Option<V3<L>>,
    /// `clearCoatIorChange`: F0 of the base becomes that of its interface with the coat. On by default.
    pub ior_change: bool,
    /// True if the base is at least as rough as the coat, as it is where a material writes `clearCoatRoughness`.
    pub roughens_base: bool,
    /// True where mobile takes the sine between normal and half vector of the coat too. The original takes the base's, which lights up
    /// coats over a base that is tilted as it never is there (flakes).
    pub own_sine: bool,
}

/// Brushed or combed surfaces.
#[derive(Clone, Copy)]
pub struct Anisotropy<L: Lanes> {
    /// -1 to 1: above 0 the highlight is stretched along the direction, below across it.
    pub strength: L::F,
    /// `anisotropyDirection` in the space of the normal, of any length but 0, not along the geometric normal.
    pub direction: V3<L>,
    /// Unit normal of the triangle or its interpolation, before normal maps.
    pub geometric_normal: V3<L>,
}

/// `MaterialInputs` for sixteen fragments. Options are for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub base_color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// `roughness`, perceptual, 0 to 1.
    pub perceptual_roughness: L::F,
    /// F0 of the dielectric part; from `reflectance` by [`super::dielectric_f0`].
    pub dielectric_f0: V3<L>,
    /// `None` where no lane has a coat; the same bits as a mask of 0, and faster.
    pub coat: Option<Coat<L>>,
    /// `None` for isotropic surfaces.
    pub anisotropy: Option<Anisotropy<L>>,
    /// `None` without cloth.
    pub sheen: Option<Sheen<L>>,
}

/// The coat as it is lit.
#[derive(Clone, Copy)]
pub struct CoatParameters<L: Lanes> {
    /// 0 none to 1 full.
    pub mask: L::F,
    /// After clamping.
    pub perceptual_roughness: L::F,
    /// Alpha.
    pub roughness: L::F,
    /// N.V at the coat, at least 1e-4.
    pub n_dot_v: L::F,
    normal: V3<L>,
    separate_normal: bool,
    own_sine: bool,
}

/// The frame of an anisotropic lobe.
#[derive(Clone, Copy)]
pub struct AnisotropyParameters<L: Lanes> {
    strength: L::F,
    tangent: V3<L>,
    bitangent: V3<L>,
    /// Alpha along tangent and bitangent.
    pub roughness: [L::F; 2],
}

impl<L: Lanes> AnisotropyParameters<L> {
    /// A vector in the frame, given its cosine with the normal.
    #[inline(always)]
    fn in_frame(&self, v: V3<L>, n_dot: L::F) -> V3<L> {
        Vec3::new(self.tangent.dot(v), self.bitangent.dot(v), n_dot)
    }
}

/// The cloth as it is lit.
#[derive(Clone, Copy)]
pub struct SheenParameters<L: Lanes> {
    color: V3<L>,
    /// After clamping.
    pub perceptual_roughness: L::F,
    /// Alpha.
    pub roughness: L::F,
}

/// Filament's `PixelParams`, as far as it does not depend on the DFG table.
#[derive(Clone, Copy)]
pub struct Parameters<L: Lanes> {
    quality: Quality,
    normal: V3<L>,
    view: V3<L>,
    /// Colour of the Lambert part.
    pub diffuse_color: V3<L>,
    /// F0, under the coat if there is one.
    pub f0: V3<L>,
    /// Perceptual roughness of the base, under the coat if there is one; after clamping.
    pub perceptual_roughness: L::F,
    /// Its square, alpha.
    pub roughness: L::F,
    /// At least 1e-4.
    pub n_dot_v: L::F,
    /// The coat, if any lane has one.
    pub coat: Option<CoatParameters<L>>,
    /// The frame, if anisotropic.
    pub anisotropy: Option<AnisotropyParameters<L>>,
    /// The cloth, if any.
    pub sheen: Option<SheenParameters<L>>,
}

impl<L: Lanes> Parameters<L> {
    /// Coordinates of the base in the DFG table: N.V and perceptual roughness.
    #[inline(always)]
    pub fn dfg_coordinates(&self) -> [L::F; 2] {
        [self.n_dot_v, self.perceptual_roughness]
    }
}

/// `getPixelParams` up to the table.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye.
#[inline(always)]
pub fn parameters<L: Lanes>(
    l: L,
    quality: Quality,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
) -> Parameters<L> {
    let least = quality.least_perceptual_roughness();
    let one_minus_metallic = data.metallic.one_minus();
    let diffuse_color = data.base_color * one_minus_metallic;
    let mut f0 = data.base_color * data.metallic + data.dielectric_f0 * one_minus_metallic;
    let n_dot_v = clamp_n_dot_v(l, normal, view);

    let mut p = data.perceptual_roughness;
    let coat = match &data.coat {
        Some(coat) => {
            let coat_p = coat.perceptual_roughness.clamp_to(least, 1.0);
            if coat.ior_change {
                let under_coat = vec3!(f0 in f0 => f0_clear_coat_to_surface(l, quality, f0));
                f0 = mix(l, f0, under_coat, coat.mask);
            }
            if coat.roughens_base {
                p = mix_number(l, p, p.max(coat_p), coat.mask);
            }
            let (coat_normal, coat_n_dot_v) = match coat.normal {
                Some(coat_normal) => (coat_normal, clamp_n_dot_v(l, coat_normal, view)),
                None => (normal, n_dot_v),
            };
            Some(CoatParameters {
                mask: coat.mask,
                perceptual_roughness: coat_p,
                roughness: coat_p * coat_p,
                n_dot_v: coat_n_dot_v,
                normal: coat_normal,
                separate_normal: coat.normal.is_some(),
                own_sine: coat.own_sine,
            })
        }
        None => None,
    };
    let perceptual_roughness = p.clamp_to(least, 1.0);
    let roughness = perceptual_roughness * perceptual_roughness;

    let anisotropy = match &data.anisotropy {
        Some(anisotropy) => {
            let k = anisotropy.strength;
            let tangent = anisotropy.direction.normalize();
            let bitangent = anisotropy.geometric_normal.cross(tangent).normalize();
            let floor = quality.least_roughness();
            let along = (roughness * (k + 1.0)).at_least(floor);
            let across = (roughness * k.one_minus()).at_least(floor);
            Some(AnisotropyParameters { strength: k, tangent, bitangent, roughness: [along, across] })
        }
        None => None,
    };
    let sheen = match &data.sheen {
        Some(sheen) => {
            let p = sheen.roughness.clamp_to(least, 1.0);
            Some(SheenParameters { color: sheen.color, perceptual_roughness: p, roughness: p * p })
        }
        None => None,
    };
    Parameters {
        quality,
        normal,
        view,
        diffuse_color,
        f0,
        perceptual_roughness,
        roughness,
        n_dot_v,
        coat,
        anisotropy,
        sheen,
    }
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// Layers.
    pub parameters: Parameters<L>,
    dfg: V3<L>,
    sheen_dfg: L::F,
    /// Scale of the base's specular lobe for light that scatters more than once between microfacets.
    pub energy_compensation: V3<L>,
    /// Transmittance of the cloth for light of the base; 1 without cloth.
    pub sheen_scaling: L::F,
}

/// Adds the texels of the DFG table: `dfg` at [`Parameters::dfg_coordinates`], `sheen_dfg` the z at N.V and the
/// roughness of the cloth (of no effect without).
#[inline(always)]
pub fn surface<L: Lanes>(l: L, parameters: &Parameters<L>, dfg: V3<L>, sheen_dfg: L::F) -> Surface<L> {
    let gain = dfg.y.at_least(LEAST_DFG).recip() - 1.0;
    let energy_compensation = parameters.f0 * gain + 1.0;
    let sheen_scaling = match &parameters.sheen {
        Some(sheen) => (sheen.color.max_component() * sheen_dfg).one_minus(),
        None => l.splat(1.0),
    };
    Surface { parameters: *parameters, dfg, sheen_dfg, energy_compensation, sheen_scaling }
}

/// [`parameters`] and [`surface`] with a DFG table: first parameter N.V, second perceptual roughness.
#[inline(always)]
pub fn surface_with_table<L: Lanes>(
    l: L,
    quality: Quality,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    table: &Table<3>,
) -> Surface<L> {
    let parameters = parameters(l, quality, data, normal, view);
    let [u, v] = parameters.dfg_coordinates();
    let dfg = table.fetch(l, u, v);
    let sheen_dfg = match &parameters.sheen {
        Some(sheen) => table.fetch(l, u, sheen.perceptual_roughness)[2],
        None => l.zero(),
    };
    surface(l, &parameters, Vec3::from_array(dfg), sheen_dfg)
}

/// Distribution and visibility of the cloth for one light.
#[derive(Clone, Copy)]
pub struct SheenLobe<L: Lanes> {
    /// Charlie, 1/sr.
    pub d: L::F,
    /// Neubelt.
    pub v: L::F,
}

/// The coat's lobe for one light.
#[derive(Clone, Copy)]
pub struct CoatLobe<L: Lanes> {
    /// N.H at the coat.
    pub n_dot_h: L::F,
    /// N.L at the coat, saturated.
    pub n_dot_l: L::F,
    /// GGX, 1/sr.
    pub d: L::F,
    /// Kelemen.
    pub v: L::F,
    /// Fresnel reflectance times mask.
    pub f: L::F,
    /// D V F, 1/sr.
    pub value: L::F,
}

/// The lobes for one light, in 1/sr and without N.L.
#[derive(Clone, Copy)]
pub struct Lobes<L: Lanes> {
    /// N.L, saturated.
    pub n_dot_l: L::F,
    /// N.H, saturated.
    pub n_dot_h: L::F,
    /// L.H, saturated.
    pub l_dot_h: L::F,
    /// Distribution of the base.
    pub d: L::F,
    /// Visibility of the base.
    pub v: L::F,
    /// Fresnel reflectance of the base.
    pub f: V3<L>,
    /// D V F.
    pub specular: V3<L>,
    /// Lambert.
    pub diffuse: V3<L>,
    /// The cloth, if any.
    pub sheen: Option<SheenLobe<L>>,
    /// The coat, if any.
    pub coat: Option<CoatLobe<L>>,
}

/// Evaluates the lobes for the unit vector to a light.
#[inline(always)]
pub fn lobes<L: Lanes>(l: L, surface: &Surface<L>, light: V3<L>) -> Lobes<L> {
    let it = &surface.parameters;
    let half = Half::new(l, it.view, light);
    let n_dot_l = it.normal.dot(light).saturate();
    let n_dot_h = it.normal.dot(half.vector).saturate();
    let sine_squared = sine_squared(l, it.quality, it.normal, half.vector, n_dot_h);

    let (d, v) = match &it.anisotropy {
        Some(a) => {
            let d = distribution_ggx_anisotropic(
                l,
                a.in_frame(half.vector, n_dot_h),
                a.roughness,
                LEAST_ANISOTROPIC,
            );
            let v = visibility_smith_anisotropic(
                l,
                a.in_frame(light, n_dot_l),
                a.in_frame(it.view, it.n_dot_v),
                a.roughness,
                it.quality.least_smith_anisotropic(),
            );
            (d, v)
        }
        None => (
            d_ggx(l, it.roughness, n_dot_h, sine_squared),
            visibility(l, it.quality, it.roughness, it.n_dot_v, n_dot_l),
        ),
    };
    let d = half.defined.select(d, l.zero());
    let f = fresnel(l, it.quality, it.f0, half.l_dot_h);
    let specular = f * (d * v);
    let diffuse = it.diffuse_color * FRAC_1_PI;

    let sheen = match &it.sheen {
        Some(sheen) => {
            let d = distribution_charlie(l, n_dot_h, sheen.roughness, LEAST_SINE_SQUARED);
            let v = visibility_neubelt(l, n_dot_l, it.n_dot_v, it.quality.least_neubelt());
            Some(SheenLobe { d: half.defined.select(d, l.zero()), v })
        }
        None => None,
    };
    let coat = match &it.coat {
        Some(coat) => {
            let (n_dot_h, n_dot_l) = if coat.separate_normal {
                (coat.normal.dot(half.vector).saturate(), coat.normal.dot(light).saturate())
            } else {
                (n_dot_h, n_dot_l)
            };
            let sine_squared = match it.quality {
                // The sine of the base's normal, in the original too.
                Quality::Mobile if !coat.own_sine => sine_squared,
                quality => super::sine_squared(l, quality, coat.normal, half.vector, n_dot_h),
            };
            let d = half.defined.select(d_ggx(l, coat.roughness, n_dot_h, sine_squared), l.zero());
            let v = visibility_kelemen(l, half.l_dot_h, it.quality.least_kelemen());
            let f = schlick(l, l.splat(COAT_F0), l.splat(1.0), half.l_dot_h) * coat.mask;
            Some(CoatLobe { n_dot_h, n_dot_l, d, v, f, value: d * v * f })
        }
        None => None,
    };
    Lobes { n_dot_l, n_dot_h, l_dot_h: half.l_dot_h, d, v, f, specular, diffuse, sheen, coat }
}

/// One light, `surfaceShading`: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence, with
/// distance, cone, shadow and occlusion applied.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>) -> V3<L> {
    let lobes = lobes(l, surface, direction);
    let it = &surface.parameters;
    let mut value = lobes.diffuse + lobes.specular * surface.energy_compensation;
    if let (Some(sheen), Some(lobe)) = (&it.sheen, &lobes.sheen) {
        let dv = lobe.d * lobe.v;
        value = value * surface.sheen_scaling + sheen.color * dv;
    }
    let mut weight = lobes.n_dot_l;
    if let (Some(coat), Some(lobe)) = (&it.coat, &lobes.coat) {
        let transmittance = lobe.f.one_minus();
        if coat.separate_normal {
            // Each layer has its own cosine with the light. Lanes without a coat keep the order of operations they
            // would have alone, and with it the bits.
            let coated = !coat.mask.eq(l.zero());
            let one = l.splat(1.0);
            let below = coated.select(transmittance * lobes.n_dot_l, one);
            let above = lobe.value * lobe.n_dot_l;
            weight = coated.select(one, weight);
            value = value * below + above;
        } else {
            value = value * transmittance + lobe.value;
        }
    }
    value * color * weight
}

impl<L: Lanes> Surface<L> {
    /// The mirror direction of the view at a normal.
    #[inline(always)]
    fn mirrored(&self, normal: V3<L>) -> V3<L> {
        (-self.parameters.view).reflect(normal)
    }

    /// Environment lookup of the base: `getReflectedVector`, for an anisotropic lobe at a normal bent towards the
    /// plane of view and grooves, then towards the normal for rough surfaces.
    #[inline(always)]
    pub fn base_query(&self, l: L) -> EnvironmentQuery<L> {
        let it = &self.parameters;
        let mirrored = match &it.anisotropy {
            Some(a) => bent_mirror(
                l,
                it.normal,
                it.view,
                [a.tangent, a.bitangent],
                a.strength,
                it.perceptual_roughness,
            ),
            None => self.mirrored(it.normal),
        };
        EnvironmentQuery {
            direction: dominant_direction(l, it.normal, mirrored, it.roughness),
            perceptual_roughness: it.perceptual_roughness,
        }
    }

    /// Environment lookup of the cloth, if there is any.
    #[inline(always)]
    pub fn sheen_query(&self) -> Option<EnvironmentQuery<L>> {
        match &self.parameters.sheen {
            Some(sheen) => Some(EnvironmentQuery {
                direction: self.mirrored(self.parameters.normal),
                perceptual_roughness: sheen.perceptual_roughness,
            }),
            None => None,
        }
    }

    /// Environment lookup of the coat, if there is one.
    #[inline(always)]
    pub fn coat_query(&self) -> Option<EnvironmentQuery<L>> {
        match &self.parameters.coat {
            Some(coat) => Some(EnvironmentQuery {
                direction: self.mirrored(coat.normal),
                perceptual_roughness: coat.perceptual_roughness,
            }),
            None => None,
        }
    }

    /// `specularDFG`: the share of uniform light that the base's specular lobe reflects, before compensation.
    #[inline(always)]
    pub fn specular_dfg(&self) -> V3<L> {
        let f0 = self.parameters.f0;
        f0.one_minus() * self.dfg.x + f0 * self.dfg.y
    }

    /// Fresnel reflectance of the coat for the view, times mask; `None` without coat.
    #[inline(always)]
    pub fn coat_fresnel(&self, l: L) -> Option<L::F> {
        match &self.parameters.coat {
            Some(coat) => Some(schlick(l, l.splat(COAT_F0), l.splat(1.0), coat.n_dot_v) * coat.mask),
            None => None,
        }
    }
}

/// Reflected light of the environment in its two parts.
#[derive(Clone, Copy)]
pub struct Indirect<L: Lanes> {
    /// From beneath: Lambert.
    pub diffuse: V3<L>,
    /// Specular lobe, cloth, coat.
    pub specular: V3<L>,
}

/// Base and cloth under the environment, before the coat: `evaluateIBL` down to `evaluateSheenIBL`.
#[inline(always)]
pub fn base_indirect<L: Lanes>(
    _: L,
    surface: &Surface<L>,
    irradiance: V3<L>,
    base_radiance: V3<L>,
    sheen_radiance: V3<L>,
) -> Indirect<L> {
    let it = &surface.parameters;
    let e = surface.specular_dfg();
    let mut diffuse = it.diffuse_color * irradiance * e.one_minus();
    let mut specular = e * base_radiance * surface.energy_compensation;
    if let Some(sheen) = &it.sheen {
        diffuse *= surface.sheen_scaling;
        specular = specular * surface.sheen_scaling + sheen.color * surface.sheen_dfg * sheen_radiance;
    }
    Indirect { diffuse, specular }
}

/// The coat on top of [`base_indirect`]: `evaluateClearCoatIBL`.
#[inline(always)]
pub fn coat_indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    below: Indirect<L>,
    coat_radiance: V3<L>,
) -> Indirect<L> {
    let Some(f) = surface.coat_fresnel(l) else { return below };
    let transmittance = f.one_minus();
    Indirect {
        diffuse: below.diffuse * transmittance,
        specular: below.specular * transmittance + coat_radiance * f,
    }
}

/// The environment: the radiance that the fragments reflect.
///
/// `irradiance` is the environment's at the base normal, over pi; `environment` gives prefiltered radiance and is asked
/// once, and once more each for cloth and coat; `occlusion` is 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let mut radiance = [Vec3::zero(l); 3];
    // A loop, so that the look-up is compiled once.
    for (k, radiance) in radiance.iter_mut().enumerate() {
        let query = match k {
            0 => Some(surface.base_query(l)),
            1 => surface.sheen_query(),
            _ => surface.coat_query(),
        };
        if let Some(query) = query {
            *radiance = environment(query);
        }
    }
    let below = base_indirect(l, surface, irradiance, radiance[0], radiance[1]);
    let all = coat_indirect(l, surface, below, radiance[2]);
    (all.diffuse + all.specular) * occlusion
}
