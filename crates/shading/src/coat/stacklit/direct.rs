//! Lights without extent (`EvaluateBSDF` and `ShadeSurface_Infinitesimal`).

use super::adding::{Call, Layers, layers_once};
use super::prelight::{COAT_LOBE, PreLight, bare_iridescence, lobe_lambda};
use super::statistics::MIN_N_DOT_V;
use crate::brdf::diffuse::{LAMBERT, TRANSMISSION_WRAP_LIGHT, wrapped_cosine};
use crate::brdf::fresnel::schlick_color;
use crate::brdf::ggx::{
    anisotropic_distribution_visibility, bsdf_angles, part_lambda, smith_distribution_visibility,
};
use crate::brdf::reflection::coat_refract;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Upper limit of D V. No highlight comes near it: it is reached where the guards of the quotient take over (light
/// behind the surface, or exactly opposite to the view), and keeps the products with colours finite.
const GREATEST_DV: f32 = 1e30;

/// A light as it reaches the fragments.
#[derive(Clone, Copy)]
pub struct Light<L: Lanes> {
    /// Unit vector to the light.
    pub direction: V3<L>,
    /// Irradiance at normal incidence, with shadow, linear.
    pub color: V3<L>,
    /// Least roughness (alpha) that stands for the light's extent; read with
    /// [`super::Options::honor_light_min_roughness`].
    pub min_roughness: L::F,
    /// Factors for diffuse and specular light.
    pub dimmers: [f32; 2],
}

impl<L: Lanes> Light<L> {
    /// A point-like light.
    #[inline(always)]
    pub fn new(l: L, direction: V3<L>, color: V3<L>) -> Self {
        Self { direction, color, min_roughness: l.zero(), dimmers: [1.0; 2] }
    }
}

/// Light that leaves towards the viewer, in two parts.
#[derive(Clone, Copy)]
pub struct Lighting<L: Lanes> {
    /// Per unit of diffuse colour until [`super::compose`] multiplies it.
    pub diffuse: V3<L>,
    /// All of it.
    pub specular: V3<L>,
}

/// StackLit's `CBSDF`: reflected and transmitted shares per unit of irradiance, cosines included.
#[derive(Clone, Copy)]
pub struct Cbsdf<L: Lanes> {
    /// Diffuse reflection per unit of diffuse colour.
    pub diffuse_reflected: V3<L>,
    /// Specular reflection.
    pub specular_reflected: V3<L>,
    /// Diffuse transmission per unit of diffuse colour and transmittance.
    pub diffuse_transmitted: V3<L>,
}

/// The stack as one light finds it. With [`super::Options::recompute_per_light`] off, that of the view but for the
/// light's least roughness.
#[inline(always)]
pub fn layers_for_light<L: Lanes>(l: L, pre: &PreLight<L>, l_dot_h: L::F, min_roughness: L::F) -> Layers<L> {
    let options = &pre.options;
    let mut found = pre.layers;
    match (&pre.bsdf.coat, options.recompute_per_light) {
        (Some(coat), true) => {
            let call = Call {
                cosine: l_dot_h,
                path: None,
                uncoated_cosine: l_dot_h,
                min_roughness,
                per_light: true,
            };
            return layers_once(l, options, &pre.bsdf, coat, &call);
        }
        (None, true) => found.iridescent = bare_iridescence(l, &pre.bsdf, l_dot_h),
        (_, false) => {
            if options.honor_light_min_roughness {
                for lobe in &mut found.lobes {
                    lobe.roughness = each!(a in lobe.roughness => a.max(min_roughness));
                }
                if pre.bsdf.coat.is_some() {
                    found.coat_roughness = found.coat_roughness.max(min_roughness);
                }
            }
        }
    }
    found
}

/// `IsNonZeroBSDF`: lanes in which the light can show.
#[inline(always)]
pub fn is_non_zero<L: Lanes>(l: L, pre: &PreLight<L>, direction: V3<L>) -> L::M {
    if pre.bsdf.transmittance.is_some() {
        return l.mask(u16::MAX);
    }
    larger_cosine(l, pre, direction).gt(l.zero())
}

/// The larger of the cosines of a light with base and coat.
#[inline(always)]
fn larger_cosine<L: Lanes>(_: L, pre: &PreLight<L>, direction: V3<L>) -> L::F {
    pre.frame.normal.dot(direction).max(pre.coat_normal.dot(direction))
}

/// View and light as the base finds them, which the coat may have refracted.
struct BaseAngles<L: Lanes> {
    view: V3<L>,
    direction: V3<L>,
    half: V3<L>,
    n_dot_h: L::F,
    n_dot_l: L::F,
    n_dot_v: L::F,
}

/// D V times energy compensation of the base, both lobes mixed.
#[inline(always)]
fn base_lobes<L: Lanes>(l: L, pre: &PreLight<L>, layers: &Layers<L>, seen: &BaseAngles<L>) -> V3<L> {
    let (options, bsdf, frame) = (&pre.options, &pre.bsdf, &pre.frame);
    let along = if bsdf.anisotropic {
        let [t, b] = [frame.tangent, frame.bitangent];
        [
            Vec3::new(t.dot(seen.half), b.dot(seen.half), seen.n_dot_h),
            Vec3::new(t.dot(seen.direction), b.dot(seen.direction), seen.n_dot_l),
        ]
    } else {
        [Vec3::zero(l); 2]
    };
    let per_light_lambda = options.recompute_per_light && bsdf.coat.is_some();
    let mut base = Vec3::zero(l);
    for x in 0..bsdf.lobe_count {
        let lobe = &pre.lobes[1 + x];
        let layered = &layers.lobes[x];
        let lambda = if per_light_lambda {
            lobe_lambda(l, bsdf, frame, seen.view, seen.n_dot_v, layered)
        } else {
            lobe.part_lambda_v
        };
        let dv = if bsdf.anisotropic {
            anisotropic_distribution_visibility(
                l,
                along[0],
                along[1],
                seen.n_dot_v,
                layered.roughness,
                lambda,
            )
        } else {
            smith_distribution_visibility(
                l,
                seen.n_dot_h,
                seen.n_dot_l,
                seen.n_dot_v,
                layered.roughness[0],
                lambda,
            )
        };
        let dv = dv.at_most(GREATEST_DV);
        let term = lobe.energy_compensation * dv;
        // Not base + mix (term - base), which rounding makes negative where one lobe is a spike.
        base = if x == 0 { term } else { base * bsdf.lobe_mix.one_minus() + term * bsdf.lobe_mix };
    }
    base
}

/// D V of the coat.
#[inline(always)]
fn coat_lobe<L: Lanes>(
    l: L,
    pre: &PreLight<L>,
    layers: &Layers<L>,
    n_dot_l: L::F,
    inverse_length: L::F,
) -> L::F {
    let n_dot_v = pre.n_dot_v[1];
    let clamped = n_dot_v.at_least(MIN_N_DOT_V);
    let n_dot_h = ((n_dot_l + n_dot_v) * inverse_length).saturate();
    let lambda = if pre.options.recompute_per_light {
        part_lambda(l, clamped, layers.coat_roughness)
    } else {
        pre.lobes[COAT_LOBE].part_lambda_v
    };
    smith_distribution_visibility(l, n_dot_h, n_dot_l, clamped, layers.coat_roughness, lambda)
        .at_most(GREATEST_DV)
}

/// `EvaluateBSDF` of a light direction.
#[inline(always)]
pub fn evaluate_bsdf<L: Lanes>(l: L, pre: &PreLight<L>, light: &Light<L>) -> Cbsdf<L> {
    let (options, bsdf, frame) = (&pre.options, &pre.bsdf, &pre.frame);
    let (zero, one) = (l.zero(), l.splat(1.0));
    let [n_dot_v, _] = pre.n_dot_v;
    let n_dot_l_given = frame.normal.dot(light.direction);
    let n_dot_l_coat = pre.coat_normal.dot(light.direction);
    let angles = bsdf_angles(l, light.direction, frame.view, n_dot_l_given, n_dot_v);
    let l_dot_h = angles.l_dot_h;
    let half = (light.direction + frame.view) * angles.inverse_length;
    let layers = layers_for_light(l, pre, l_dot_h, light.min_roughness);

    let (mut view, mut direction) = (frame.view, light.direction);
    let (mut n_dot_l, mut n_dot_v_base) = (n_dot_l_given, n_dot_v.at_least(MIN_N_DOT_V));
    if let (Some(coat), true) = (&bsdf.coat, options.refracted_angles_for_base) {
        let refracted = coat_refract(l, frame.view, half, coat.ieta);
        let mirrored = (-refracted).reflect(half);
        view = Vec3::select(coat.uncoated, frame.view, refracted);
        direction = Vec3::select(coat.uncoated, light.direction, mirrored);
        n_dot_l = frame.normal.dot(direction);
        n_dot_v_base = frame.normal.dot(view).at_least(MIN_N_DOT_V);
    }

    let seen = BaseAngles { view, direction, half, n_dot_h: angles.n_dot_h, n_dot_l, n_dot_v: n_dot_v_base };
    let base = base_lobes(l, pre, &layers, &seen);

    let mut fresnel = schlick_color(l, bsdf.fresnel0, one, l_dot_h);
    if let Some(film) = &bsdf.iridescence {
        fresnel = fresnel.lerp(layers.iridescent, film.mask);
    }
    let lit = n_dot_l.at_least(0.0);
    let mut diffuse = Vec3::splat(l, [LAMBERT; 3]);
    let specular = match &bsdf.coat {
        Some(coat) => {
            if options.recompute_per_light {
                fresnel = Vec3::select(coat.uncoated, fresnel, layers.bottom);
            }
            fresnel = fresnel.lerp(layers.bottom, coat.mask);
            diffuse = layers.diffuse_energy * LAMBERT;
            let dv = coat_lobe(l, pre, &layers, n_dot_l_coat, angles.inverse_length);
            let top = n_dot_l_coat.at_least(0.0) * layers.top;
            let compensation = pre.lobes[COAT_LOBE].energy_compensation;
            fresnel * lit * base + compensation * top * dv
        }
        None => fresnel * lit * base,
    };

    let larger = n_dot_l_given.max(n_dot_l_coat);
    let behind = larger.lt(zero).select(n_dot_l_given, larger);
    let transmitted = wrapped_cosine(l, -behind, TRANSMISSION_WRAP_LIGHT);
    let reflected = n_dot_l.saturate();
    Cbsdf {
        diffuse_reflected: diffuse * reflected,
        specular_reflected: specular,
        diffuse_transmitted: diffuse * transmitted,
    }
}

/// One light: its reflection towards the viewer. Zero in lanes that it cannot reach.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, pre: &PreLight<L>, light: &Light<L>) -> Lighting<L> {
    let zero = l.zero();
    let shows = is_non_zero(l, pre, light.direction) & light.color.max_component().gt(zero);
    if !shows.any() {
        return Lighting { diffuse: Vec3::zero(l), specular: Vec3::zero(l) };
    }
    let found = evaluate_bsdf(l, pre, light);
    let [diffuse_dimmer, specular_dimmer] = light.dimmers;
    let diffuse = match &pre.bsdf.transmittance {
        Some(t) => found.diffuse_reflected + found.diffuse_transmitted * *t,
        None => found.diffuse_reflected,
    };
    Lighting {
        diffuse: Vec3::select(shows, diffuse * light.color * diffuse_dimmer, Vec3::zero(l)),
        specular: Vec3::select(
            shows,
            found.specular_reflected * light.color * specular_dimmer,
            Vec3::zero(l),
        ),
    }
}
