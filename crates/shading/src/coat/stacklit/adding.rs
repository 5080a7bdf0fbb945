//! The adding operator (`ComputeAdding`): coat, medium and base combined into reflectances and roughnesses.
//!
//! The original runs a loop over the three layers that adds each to the stack above (reflectances by the series of
//! reflections between them, variances weighted by energy). For this stack the loop has a closed form, which is what
//! is computed: with R of the coat's face (colourless), B of the medium and F of the base,
//!
//! ```text
//! top    = R
//! bottom = ((1 - R) B)^2 F / (1 - R B^2 F)       what the base adds to the reflected light
//! T      = (1 - F) (1 - R) B / (1 - R B^2 F)     what reaches the Lambert part, and what leaves from it
//! ```
//!
//! [`Adding::state_after`] gives the loop's state after each layer; `tests/models/stacklit.rs` holds the loop.

use super::convert::{BsdfData, CoatData, lights_roughness};
use super::options::Options;
use super::statistics::{
    BaseInterface, CoatInterface, GeometricPath, MIN_N_DOT_V, base_interface, coat_interface, medium,
};
use crate::brdf::roughness::{
    anisotropic_roughness, linear_variance_to_roughness, modified_anisotropy, roughness_to_linear_variance,
};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// The mean of a colour, as energies of lobes are weighed.
#[inline(always)]
fn mean<L: Lanes>(_: L, v: V3<L>) -> L::F {
    (v.x + v.y + v.z) * (1.0 / 3.0)
}

/// For whom the layers are combined.
#[derive(Clone, Copy)]
pub struct Call<L: Lanes> {
    /// Cosine with which light enters: of the view, or L.H.
    pub cosine: L::F,
    /// Path about the geometric normal, and the base's normal: for the view, where the coat has a normal of its own.
    pub path: Option<(GeometricPath<L>, V3<L>)>,
    /// The cosine that lanes without a coat take for their film.
    pub uncoated_cosine: L::F,
    /// The light's least roughness, 0 for the view.
    pub min_roughness: L::F,
    /// True if the call is for a light.
    pub per_light: bool,
}

/// A base lobe as seen through the coat.
#[derive(Clone, Copy)]
pub struct LayeredLobe<L: Lanes> {
    /// Perceptual roughness for the environment.
    pub perceptual_roughness: L::F,
    /// Anisotropy for the environment; may leave -1 to 1.
    pub anisotropy: L::F,
    /// Roughness (alpha) along tangent and bitangent for lights.
    pub roughness: [L::F; 2],
}

/// The stack as one surface, for the rest of the model.
#[derive(Clone, Copy)]
pub struct Layers<L: Lanes> {
    /// Reflectance of the coat (`vLayerEnergyCoeff[TOP]`).
    pub top: L::F,
    /// Reflectance that the base adds (`vLayerEnergyCoeff[BOTTOM]`).
    pub bottom: V3<L>,
    /// Share of light that the Lambert part receives, and sends.
    pub diffuse_energy: V3<L>,
    /// Reflectance of the base under a full film (`fresnelIridforCalculatingFhyperTIR`), 0 where there is none.
    pub iridescent: V3<L>,
    /// Cosine at the base (`bottomAngleFGD`).
    pub bottom_cosine: L::F,
    /// Lobes A and B.
    pub lobes: [LayeredLobe<L>; 2],
    /// Roughness (alpha) of the coat for lights.
    pub coat_roughness: L::F,
}

/// All that the operator finds on its way.
#[derive(Clone, Copy)]
pub struct Adding<L: Lanes> {
    /// Layer 0.
    pub coat: CoatInterface<L>,
    /// Cosine in the medium, layer 1.
    pub medium_cosine: L::F,
    /// Transmittance of the medium.
    pub medium: V3<L>,
    /// Layer 2.
    pub base: BaseInterface<L>,
    /// Reflectance from below of all that lies on the base.
    reflectance_from_below: V3<L>,
    /// 1 / (1 - reflections between base and coat).
    series: V3<L>,
    /// Variance of light reflected from below, 0 where nothing is.
    variance_from_below: L::F,
    /// Mean weight of the reflections between base and coat.
    mean_rr: L::F,
    /// Light that has left the base for good.
    transmitted_out: V3<L>,
    /// Resulting layers.
    pub layers: Layers<L>,
}

/// The statistics of a layer as the loop has them.
#[derive(Clone, Copy)]
pub struct Statistics<L: Lanes> {
    /// Cosines of incidence and of transmission.
    pub cosines: [L::F; 2],
    /// R12, T12, R21, T21.
    pub energies: [V3<L>; 4],
    /// s_r12, s_t12, s_r21, s_t21.
    pub variances: [L::F; 4],
    /// j12, j21.
    pub jacobians: [L::F; 2],
}

/// The state of the loop after a layer.
#[derive(Clone, Copy)]
pub struct State<L: Lanes> {
    /// R0i, T0i, Ri0, Ti0.
    pub energies: [V3<L>; 4],
    /// Mean weight of the reflections between this layer and those above.
    pub mean_rr: L::F,
    /// s_r0i, s_t0i, s_ti0.
    pub variances: [L::F; 3],
}

/// Roughness (alpha) at a light's least roughness, where lights have one.
#[inline(always)]
fn raised<L: Lanes>(options: &Options, roughness: L::F, min_roughness: L::F) -> L::F {
    if options.honor_light_min_roughness { roughness.max(min_roughness) } else { roughness }
}

/// `ComputeAdding`.
#[inline(always)]
pub fn compute_adding<L: Lanes>(
    l: L,
    options: &Options,
    bsdf: &BsdfData<L>,
    coat: &CoatData<L>,
    call: &Call<L>,
) -> Adding<L> {
    let zero = l.zero();
    let coat_alpha = raised::<L>(options, coat.roughness, call.min_roughness);
    let entering = match &call.path {
        Some((path, _)) => path.cosine,
        None => call.cosine,
    };
    let face = coat_interface(l, coat, call.cosine, entering, coat_alpha);
    let medium_cosine = face.transmitted_cosine.at_least(MIN_N_DOT_V);
    let absorbed = medium(l, coat, medium_cosine);
    let base =
        base_interface(l, bsdf, coat, medium_cosine, call.path.as_ref(), call.uncoated_cosine, coat_alpha);

    let reflectance = face.reflectance;
    let passing = reflectance.one_minus();
    // T0i = Ti0 and Ri0 of all above the base.
    let above = absorbed * passing;
    let from_below = absorbed * reflectance * absorbed;
    let rest = (from_below * base.reflectance).one_minus();
    let series = vec3!(rest in rest => rest.gt(zero).select(rest.recip(), zero));
    let bottom = above * base.reflectance * above * series;
    let transmitted_out = base.reflectance.one_minus() * above * series;
    let mean_rr = mean(l, from_below * base.reflectance * series);
    let variance_from_below = mean(l, from_below).gt(zero).select(face.reflected_variance, zero);

    let mut lobes = [LayeredLobe { perceptual_roughness: zero, anisotropy: zero, roughness: [zero; 2] }; 2];
    for x in 0..bsdf.lobe_count {
        let lobe = &bsdf.lobes[x];
        let p = lobe.perceptual_roughness;
        let alpha = raised::<L>(options, p * p, call.min_roughness);
        let own = roughness_to_linear_variance(l, alpha);
        let at_base = face.variance_in + own + mean_rr * (own + variance_from_below);
        let variance = face.variance_out + face.jacobian * at_base;
        let layered_p = linear_variance_to_roughness(l, variance).sqrt();
        let layered_p = coat.uncoated.select(p, layered_p);
        let anisotropy = if bsdf.anisotropic {
            let modified = modified_anisotropy(l, lobe.anisotropy, alpha.sqrt(), layered_p);
            coat.uncoated.select(lobe.anisotropy, modified)
        } else {
            lobe.anisotropy
        };
        let roughness = if options.recompute_per_light && !call.per_light {
            [zero; 2]
        } else {
            let layered = anisotropic_roughness(l, layered_p * layered_p, anisotropy);
            each!(k => lights_roughness(l, options, coat.uncoated.select(lobe.roughness[k], layered[k])))
        };
        lobes[x] = LayeredLobe { perceptual_roughness: layered_p, anisotropy, roughness };
    }
    Adding {
        coat: face,
        medium_cosine,
        medium: absorbed,
        base,
        reflectance_from_below: from_below,
        series,
        variance_from_below,
        mean_rr,
        transmitted_out,
        layers: Layers {
            top: reflectance,
            bottom,
            diffuse_energy: Vec3::splat(l, [1.0; 3]).lerp(transmitted_out, coat.mask),
            iridescent: base.iridescent,
            bottom_cosine: base.cosine,
            lobes,
            coat_roughness: if call.per_light {
                coat_alpha
            } else {
                lights_roughness(l, options, coat.roughness)
            },
        },
    }
}

/// [`compute_adding`] without its by-products, as one function for each instruction set: the view asks for it, and so
/// does every light if the material wants it.
#[inline(never)]
pub(super) fn layers_once<L: Lanes>(
    l: L,
    options: &Options,
    bsdf: &BsdfData<L>,
    coat: &CoatData<L>,
    call: &Call<L>,
) -> Layers<L> {
    l.run(
        #[inline(always)]
        || compute_adding(l, options, bsdf, coat, call).layers,
    )
}

impl<L: Lanes> Adding<L> {
    /// Statistics of layer 0 (coat), 1 (medium) or 2 (base).
    #[inline(always)]
    pub fn statistics(&self, l: L, layer: usize) -> Statistics<L> {
        let (zero, one) = (l.zero(), l.splat(1.0));
        match layer {
            0 => {
                let r = Vec3::uniform(self.coat.reflectance);
                let t = r.one_minus();
                let s = &self.coat;
                Statistics {
                    cosines: [s.cosine, s.transmitted_cosine],
                    energies: [r, t, r, t],
                    variances: [s.reflected_variance, s.variance_in, s.reflected_variance, s.variance_out],
                    jacobians: [s.jacobian, s.jacobian.recip()],
                }
            }
            1 => Statistics {
                cosines: [self.medium_cosine; 2],
                energies: [Vec3::zero(l), self.medium, Vec3::zero(l), self.medium],
                variances: [zero; 4],
                jacobians: [one; 2],
            },
            _ => {
                let r = self.base.reflectance;
                let t = r.one_minus();
                Statistics {
                    cosines: [self.medium_cosine; 2],
                    energies: [r, t, r, t],
                    variances: [zero; 4],
                    jacobians: [one; 2],
                }
            }
        }
    }

    /// The loop's state after layer 0, 1 or 2.
    #[inline(always)]
    pub fn state_after(&self, l: L, layer: usize) -> State<L> {
        let (zero, r) = (l.zero(), Vec3::uniform(self.coat.reflectance));
        let passing = r.one_minus();
        let reflects = self.coat.reflectance.gt(zero);
        let top_variance = reflects.select(self.coat.reflected_variance, zero);
        let (s_in, s_out) = (self.coat.variance_in, self.coat.variance_out);
        if layer == 0 {
            return State {
                energies: [r, passing, r, passing],
                mean_rr: zero,
                variances: [top_variance, s_in, s_out],
            };
        }
        let above = passing * self.medium;
        if layer == 1 {
            return State {
                energies: [r, above, self.reflectance_from_below, above],
                mean_rr: zero,
                variances: [top_variance, s_in, s_out],
            };
        }
        let bottom = self.layers.bottom;
        let total = r + bottom;
        let base = self.base.reflectance;
        let out = base.one_minus();
        let series = out * self.series;
        let from_below = base + series * self.reflectance_from_below * out;
        let between = self.variance_from_below * self.mean_rr;
        let lobe = s_out + self.coat.jacobian * (s_in + between);
        let energy = mean(l, total);
        let weighed = mean(l, r) * top_variance + mean(l, bottom) * lobe;
        State {
            energies: [total, above * series, from_below, self.transmitted_out],
            mean_rr: self.mean_rr,
            variances: [
                energy.gt(zero).select(weighed / energy, zero),
                s_in + between,
                s_out + between / self.coat.jacobian,
            ],
        }
    }
}
