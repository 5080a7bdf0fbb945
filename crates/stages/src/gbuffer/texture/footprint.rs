//! From the footprint of a pixel to a level of detail and the probes of anisotropic filtering.
//!
//! The footprint is the ellipse that the derivatives map the pixel's circle to. Its axes are found exactly (singular
//! values of the 2 x 2 matrix), where EXT_texture_filter_anisotropic and Vulkan approximate them by the lengths of
//! the two derivatives: the result does not depend on how the view is rolled about its axis. Number of probes and
//! level follow Vulkan: with `eta = major / minor` limited to the largest anisotropy, `N = ceil(eta)` and
//! `lambda = log2(major / eta)`, which is continuous. One deviation: 1/4 is taken off `eta` first, so that surfaces seen nearly
//! face on cost one probe and not two; they get blurred by as much.

use super::Footprint;
use overcoat_core::math::lanes::{Float, Int, Lanes, Mask};
use overcoat_scene::{Filter, MipFilter, Texture};

/// Derivatives are limited to this many texels, so that fourth powers stay finite. A whole texture is smaller.
const MAX_TEXELS: f32 = 1_073_741_824.0;

/// Largest number of probes.
const MAX_PROBES: u32 = 16;

/// Filter of each lane: level of detail, and the probes along the footprint.
#[derive(Clone, Copy)]
pub(super) struct Probes<L: Lanes> {
    /// Level of detail: 0 and less is magnification.
    pub lambda: L::F,
    /// Number of probes, a whole number from 1.
    pub count: L::F,
    /// Largest of the counts of active lanes.
    pub most: u32,
    /// Major axis of the footprint, its whole length, in texture coordinates.
    pub major: [L::F; 2],
}

/// A derivative in texels, limited.
#[inline(always)]
fn texels<L: Lanes>(d: &[L::F; 2], size: [f32; 2]) -> [L::F; 2] {
    [(d[0] * size[0]).clamp_to(-MAX_TEXELS, MAX_TEXELS), (d[1] * size[1]).clamp_to(-MAX_TEXELS, MAX_TEXELS)]
}

impl<L: Lanes> Probes<L> {
    /// One probe in the middle.
    #[inline(always)]
    pub fn one(l: L, lambda: L::F) -> Self {
        Self { lambda, count: l.splat(1.0), most: 1, major: [l.zero(); 2] }
    }

    #[inline(always)]
    pub fn new(l: L, texture: &Texture, footprint: &Footprint<L>, max_anisotropy: u32, active: L::M) -> Self {
        let sampler = texture.sampler();
        let max_probes = match sampler.minification {
            Filter::Nearest => 1,
            Filter::Linear => max_anisotropy.clamp(1, MAX_PROBES),
        };
        if max_probes == 1 && sampler.mip == MipFilter::None && sampler.magnification == sampler.minification
        {
            return Self::one(l, l.zero());
        }
        let size = [texture.width() as f32, texture.height() as f32];
        let [ux, vx] = texels::<L>(&footprint.dx, size);
        let [uy, vy] = texels::<L>(&footprint.dy, size);
        let (length_x, length_y) = (ux * ux + vx * vx, uy * uy + vy * vy);
        let longer = length_x.max(length_y);
        let isotropic = log2(longer) * 0.5;
        // The sum of both bounds the major axis from above.
        if max_probes == 1 || (length_x + length_y).le(l.splat(1.0)).all() {
            return Self::one(l, isotropic);
        }
        // Squared major axis: the larger eigenvalue of J * transpose(J).
        let (u, v, mixed) = (ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy);
        let difference = (u - v) * 0.5;
        let radius = (difference * difference + mixed * mixed).sqrt();
        let major = (u + v) * 0.5 + radius;
        // major / minor = major^2 / (major * minor), and the determinant is the product of the axes. 0 gives the limit.
        let area = (ux * vy - uy * vx).abs();
        let minified = l.splat(1.0).lt(major);
        let eta = (major / area).at_most(max_probes as f32 + 0.25) - 0.25;
        let eta = minified.select(eta.at_least(1.0), l.splat(1.0));
        let whole = eta.to_int().to_float();
        let count = whole + whole.lt(eta).select(l.splat(1.0), l.zero());
        let most = largest(count, active);
        let lambda = log2(major / (eta * eta)) * 0.5;
        if most == 1 {
            return Self::one(l, lambda);
        }
        // An eigenvector, from the row of the matrix that does not cancel.
        let wide = l.zero().le(difference);
        let long = radius + difference.abs();
        let direction = [wide.select(long, mixed), wide.select(mixed, long)];
        let length = (direction[0] * direction[0] + direction[1] * direction[1]).sqrt();
        // A circle has no direction; it has one probe in the middle.
        let scale = l.zero().lt(length).select(major.sqrt() / length, l.zero());
        let major = [direction[0] * scale * (1.0 / size[0]), direction[1] * scale * (1.0 / size[1])];
        Self { lambda, count, most, major }
    }
}

/// The largest of the active lanes of small whole numbers, at least 1.
#[inline(always)]
fn largest<F: Float>(count: F, active: F::M) -> u32 {
    let mut most = 1;
    while (count.splat_like(most as f32).lt(count) & active).any() {
        most += 1;
    }
    most
}

/// Logarithm to base 2 with an error below 6e-5, which is 1/60 of the smallest step of a hardware's level of
/// detail. Exact for powers of two, continuous, increasing. 0 gives about -127; for finite x >= 0.
#[inline(always)]
pub(super) fn log2<F: Float>(x: F) -> F {
    let bits = x.bits();
    let exponent = (bits.shr(23) + -127).to_float();
    let t = ((bits & 0x007f_ffff) | 0x3f80_0000).float_from_bits() - 1.0;
    // log2(1 + t) = t + t (1 - t) q(t)
    let q = t * -0.046_806_24 + 0.153_441_65;
    let q = q * t + -0.270_675_88;
    let q = q * t + 0.442_479_1;
    exponent + (t + t * t.one_minus() * q)
}
