//! Velvet: Ashikhmin and Premoze's lobe over a Lambert base, with or without an anisotropic GGX lobe of the fibres'
//! backing.
//!
//! The lobe is that of "Distribution-based BRDFs" (2007), [`crate::brdf::velvet`]; the anisotropic lobe is GGX with
//! Kulla and Conty's alpha (1 +- k) and height-correlated Smith visibility, as in Filament. The authors do not say how
//! velvet lies on a base nor how it is lit by an environment; this is done here with the means of the coupled model of
//! Kelemen and Szirmay-Kalos (2001) and is named below.
//!
//! **Use and radiometry** as of [`crate::coat::filament`]: [`surface`] once, [`direct`] for every light, [`indirect`]
//! for the environment. Lambert is colour / pi, the colour of a light is its irradiance at normal incidence, the result
//! is radiance; the environment is radiance and its irradiance comes divided by pi.
//!
//! **Layers.** E(u) is the directional albedo of the velvet lobe, c the largest channel of its colour, a(u) = 1 - c E(u)
//! what it leaves. The Lambert part becomes colour / pi a(N.L) a(N.V) / mean(a): reciprocal, and exactly what the lobe
//! leaves when lit from all sides. The GGX lobe is scaled by a(N.L) a(N.V), which loses a little but never gains, and
//! dims the Lambert part by 1 minus its albedo, for lights the larger one of N.L and N.V. Light lost between the
//! microfacets of GGX is not given back.
//!
//! **Environment.** The lobe has its least value about the mirror direction and gathers light from nearly the whole
//! hemisphere, the more from the viewer's side the lower the view. It is replaced by its albedo times the radiance that
//! the environment has in the mean direction of that light, filtered as broadly as it can be (perceptual roughness 1):
//! exact for uniform light, right in the mean for light that changes linearly with direction.
//!
//! **Physics.** White velvet on white reflects 1 under a white environment, and never more than 1 of any light beyond
//! the tables' error of 0.005 (`tests/models/velvet.rs`). The model is reciprocal as long as N.V is above 1e-4.

use super::EnvironmentQuery;
use super::filament::{
    Half, LEAST_ANISOTROPIC, Quality, bent_mirror, clamp_n_dot_v, dominant_direction, f90_of, fresnel,
};
use crate::brdf::microfacet::{distribution_ggx_anisotropic, visibility_smith_anisotropic};
use crate::brdf::table::Table;
use crate::brdf::velvet::{
    LEAST_ROUGHNESS, VelvetAlbedo, anisotropic_roughness, distribution_velvet_real_time, velvet_lobe,
};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Least alpha of the GGX lobe (Filament's on desktop).
const LEAST_ALPHA: f32 = 0.002_025;
/// Its perceptual roughness.
const LEAST_PERCEPTUAL_ROUGHNESS: f32 = 0.045;

/// The GGX lobe beneath the velvet.
#[derive(Clone, Copy)]
pub struct Specular<L: Lanes> {
    /// F0, linear, 0 to 1. Reflectance at grazing angles is 1 from an F0 of 0.02 upwards.
    pub f0: V3<L>,
    /// 0 to 1.
    pub perceptual_roughness: L::F,
    /// k of alpha (1 + k) and alpha (1 - k), -1 to 1: above 0 the highlight is stretched along the direction.
    pub anisotropy: L::F,
    /// Direction of the grooves in the space of the normal, of any length but 0, not along the normal.
    pub direction: V3<L>,
}

/// Material of sixteen fragments. Options are for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Colour of the Lambert base, linear, 0 to 1.
    pub base_color: V3<L>,
    /// Colour of the velvet lobe, linear, 0 to 1; black for none.
    pub velvet_color: V3<L>,
    /// Roughness of the velvet lobe, the s of its distribution, 0.05 to 1 (less counts as 0.05). Small: a narrow rim;
    /// large: an even sheen. Where an artist's perceptual roughness is given, its square.
    pub velvet_roughness: L::F,
    /// The GGX lobe, if any.
    pub specular: Option<Specular<L>>,
}

/// The GGX lobe as it is lit.
#[derive(Clone, Copy)]
struct SpecularSurface<'a, L: Lanes> {
    f0: V3<L>,
    perceptual_roughness: L::F,
    anisotropy: L::F,
    tangent: V3<L>,
    bitangent: V3<L>,
    alpha: [L::F; 2],
    dfg: &'a Table<3>,
    /// [`Self::albedo_at`] N.V.
    albedo: V3<L>,
}

impl<L: Lanes> SpecularSurface<'_, L> {
    #[inline(always)]
    fn in_frame(&self, v: V3<L>, n_dot: L::F) -> V3<L> {
        Vec3::new(self.tangent.dot(v), self.bitangent.dot(v), n_dot)
    }

    /// Share of uniform light that the lobe reflects towards a direction at this cosine.
    #[inline(always)]
    fn albedo_at(&self, l: L, cosine: L::F) -> V3<L> {
        let [x, y, _] = self.dfg.fetch(l, cosine, self.perceptual_roughness);
        let f90 = f90_of(l, Quality::Desktop, self.f0);
        (Vec3::uniform(f90) - self.f0) * x + self.f0 * y
    }
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<'a, L: Lanes> {
    table: &'a VelvetAlbedo,
    normal: V3<L>,
    view: V3<L>,
    n_dot_v: L::F,
    base_color: V3<L>,
    velvet_color: V3<L>,
    velvet_roughness: L::F,
    /// Largest channel of the velvet's colour.
    strength: L::F,
    /// Albedo of the velvet lobe of colour 1 for the view.
    velvet_albedo: L::F,
    /// Mean direction of the light that it reflects.
    velvet_direction: V3<L>,
    /// Scale of the Lambert part for the view: a(N.V) / mean(a).
    diffuse_scale: L::F,
    specular: Option<SpecularSurface<'a, L>>,
}

/// Prepares sixteen fragments. `normal` and `view` are unit vectors in one space; `view` points to the eye. `table` is
/// [`VelvetAlbedo::shared`], `dfg` the table of GGX in the form of [`crate::coat::filament`].
#[inline(always)]
pub fn surface<'a, L: Lanes>(
    l: L,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    table: &'a VelvetAlbedo,
    dfg: &'a Table<3>,
) -> Surface<'a, L> {
    let n_dot_v = clamp_n_dot_v(l, normal, view);
    let roughness = data.velvet_roughness.clamp_to(LEAST_ROUGHNESS, 1.0);
    let strength = data.velvet_color.max_component();
    let velvet_albedo = table.albedo(l, n_dot_v, roughness);
    let ([sideways, upwards], mean) = table.view(l, n_dot_v, roughness);
    // Seen along the normal there is no sideways, and none is needed.
    let tangent = (view - normal * normal.dot(view)).normalize();
    let velvet_direction = normal * upwards + tangent * sideways;
    let diffuse_scale = (strength * velvet_albedo).one_minus() / (strength * mean).one_minus();

    let specular = match &data.specular {
        Some(it) => {
            let p = it.perceptual_roughness.clamp_to(LEAST_PERCEPTUAL_ROUGHNESS, 1.0);
            let tangent = it.direction.normalize();
            let mut specular = SpecularSurface {
                f0: it.f0,
                perceptual_roughness: p,
                anisotropy: it.anisotropy,
                tangent,
                bitangent: normal.cross(tangent).normalize(),
                alpha: anisotropic_roughness(l, p * p, it.anisotropy, LEAST_ALPHA),
                dfg,
                albedo: it.f0,
            };
            specular.albedo = specular.albedo_at(l, n_dot_v);
            Some(specular)
        }
        None => None,
    };
    Surface {
        table,
        normal,
        view,
        n_dot_v,
        base_color: data.base_color,
        velvet_color: data.velvet_color,
        velvet_roughness: roughness,
        strength,
        velvet_albedo,
        velvet_direction,
        diffuse_scale,
        specular,
    }
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence, with
/// distance, cone and shadow applied.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<'_, L>, direction: V3<L>, color: V3<L>) -> V3<L> {
    let half = Half::new(l, surface.view, direction);
    let n_dot_l = surface.normal.dot(direction).saturate();
    let n_dot_h = surface.normal.dot(half.vector).saturate();
    let d = distribution_velvet_real_time(l, n_dot_h, surface.velvet_roughness);
    let d = half.defined.select(d, l.zero());
    let velvet = velvet_lobe(l, d, n_dot_l, surface.n_dot_v, 0.0);
    // Transmittance of the velvet for light on its way in.
    let albedo = surface.table.albedo(l, n_dot_l, surface.velvet_roughness);
    let entering = (surface.strength * albedo).one_minus();
    let mut below = surface.base_color * (entering * surface.diffuse_scale * FRAC_1_PI);
    if let Some(it) = &surface.specular {
        let half_in_frame = it.in_frame(half.vector, n_dot_h);
        let d = distribution_ggx_anisotropic(l, half_in_frame, it.alpha, LEAST_ANISOTROPIC);
        let v = visibility_smith_anisotropic(
            l,
            it.in_frame(direction, n_dot_l),
            it.in_frame(surface.view, surface.n_dot_v),
            it.alpha,
            Quality::Desktop.least_smith_anisotropic(),
        );
        let dv = half.defined.select(d * v, l.zero());
        let f = fresnel(l, Quality::Desktop, it.f0, half.l_dot_h);
        let leaving = (surface.strength * surface.velvet_albedo).one_minus();
        let scale = dv * entering * leaving;
        let albedo = it.albedo_at(l, n_dot_l);
        below = below * albedo.max(it.albedo).one_minus() + f * scale;
    }
    (surface.velvet_color * velvet + below) * color * n_dot_l
}

/// The environment: the radiance that the fragments reflect.
///
/// `irradiance` is the environment's at the normal, over pi; `environment` gives prefiltered radiance for a direction
/// that is not of unit length, and is asked once, or twice with a GGX lobe; `occlusion` is 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<'_, L>,
    irradiance: V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let velvet_query =
        EnvironmentQuery { direction: surface.velvet_direction, perceptual_roughness: l.splat(1.0) };
    let mut radiance = [Vec3::zero(l); 2];
    // A loop, so that the look-up is compiled once.
    for (k, radiance) in radiance.iter_mut().enumerate() {
        let query = match (k, &surface.specular) {
            (0, _) => Some(velvet_query),
            (_, Some(it)) => Some(specular_query(l, surface, it)),
            _ => None,
        };
        if let Some(query) = query {
            *radiance = environment(query);
        }
    }
    let [velvet_radiance, base_radiance] = radiance;
    let leaving = (surface.strength * surface.velvet_albedo).one_minus();
    let mut below = surface.base_color * irradiance;
    if let Some(it) = &surface.specular {
        // Light of the mirror direction enters at the angle at which it leaves.
        below = below * it.albedo.one_minus() + base_radiance * it.albedo * leaving;
    }
    let velvet = surface.velvet_color * surface.velvet_albedo * velvet_radiance;
    (velvet + below * leaving) * occlusion
}

/// Environment lookup of the GGX lobe.
#[inline(always)]
fn specular_query<L: Lanes>(
    l: L,
    surface: &Surface<'_, L>,
    it: &SpecularSurface<'_, L>,
) -> EnvironmentQuery<L> {
    let frame = [it.tangent, it.bitangent];
    let p = it.perceptual_roughness;
    let mirrored = bent_mirror(l, surface.normal, surface.view, frame, it.anisotropy, p);
    EnvironmentQuery {
        direction: dominant_direction(l, surface.normal, mirrored, p * p),
        perceptual_roughness: p,
    }
}
