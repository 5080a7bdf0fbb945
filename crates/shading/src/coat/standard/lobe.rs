//! Lobes of GGX as sums of the round lobes that the prefiltered environment holds.

use super::{AnisotropySurface, EnvironmentQuery};
use crate::brdf::microfacet::schlick_weight;
use crate::coat::glsl::normalize_or;
use overcoat_core::math::lanes::{Float, Lanes, Mask, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};

/// Round lobes that stand for one of a surface that is equally rough in all directions.
pub(super) const ROUND: usize = 3;

/// Lobes along the grain of a brushed surface.
pub(super) const BRUSHED: usize = 12;

/// Below this perceptual roughness a lobe is one lookup: it is narrower than a texel of the environment.
const SMOOTH: f32 = 0.07;

/// Shares of the round lobes.
const SHARES: [f32; ROUND] = [0.558_012, 0.220_857, 0.221_130];

/// For each round lobe two polynomials of N.V (u) and perceptual roughness (p) over 1, u, p, u^2, u p, p^2, u^3, u^2 p, u
/// p^2, p^3: how far its direction is bent from the mirrored view R to the normal N, R + p^2 bend (N - R), and its
/// perceptual roughness over that of the surface.
///
/// Least squares over 72 pairs of N.V and roughness: the squared difference between the sum of the lobes and GGX with
/// its height-correlated shadowing and cosine, over the hemisphere.
const FIT: [[[f32; 10]; 2]; ROUND] = [
    [
        [
            1.086_201, -2.236_771, 1.347_179, 3.503_644, -1.487_033, 3.048_679, -1.484_060, -0.102_952,
            1.077_264, -3.677_249,
        ],
        [
            0.521_297, 0.802_206, -0.163_160, -0.532_201, -0.516_421, 1.846_730, 0.165_079, 1.117_337,
            -1.817_166, 0.055_201,
        ],
    ],
    [
        [
            -0.013_629, -3.133_732, 3.378_883, 3.886_205, -0.971_029, -0.295_459, -0.925_672, -4.171_682,
            4.750_581, -3.233_504,
        ],
        [
            0.295_681, 1.022_584, 0.039_260, -0.744_758, -1.330_028, 0.648_446, 0.305_008, 1.352_911,
            -0.562_958, 0.149_040,
        ],
    ],
    [
        [
            -0.820_305, -4.206_577, 5.936_900, 1.775_465, -3.196_863, -7.081_233, 1.111_040, -4.026_563,
            10.941_892, 2.147_933,
        ],
        [
            0.253_013, 1.213_879, 0.700_282, 0.176_928, -3.053_948, -1.390_367, -0.382_595, 1.306_662,
            1.633_379, 1.501_025,
        ],
    ],
];

/// A lookup, its share of the lobe, and the cosine of view and half vector there.
#[derive(Clone, Copy)]
pub(super) struct Sample<L: Lanes> {
    pub(super) query: EnvironmentQuery<L>,
    pub(super) share: L::F,
    pub(super) v_dot_h: L::F,
}

/// A lookup.
#[inline(always)]
fn query<L: Lanes>(_: L, direction: V3<L>, perceptual_roughness: L::F) -> EnvironmentQuery<L> {
    EnvironmentQuery { direction, perceptual_roughness }
}

/// A polynomial of [`FIT`].
#[inline(always)]
fn polynomial<L: Lanes>(_: L, c: &[f32; 10], u: L::F, p: L::F) -> L::F {
    let linear = u * c[1] + p * c[2] + c[0];
    let square = (u * c[3] + p * c[4]) * u + p * p * c[5];
    let cube = (u * c[6] + p * c[7]) * (u * u) + (u * c[8] + p * c[9]) * (p * p);
    linear + square + cube
}

/// The least and the largest perceptual roughness that lookups for a surface of this one have, over all views: about, by the
/// fit at 17 of them.
#[must_use]
pub fn roughness_of_lookups(roughness: f32) -> [f32; 2] {
    if roughness < SMOOTH {
        return [roughness; 2];
    }
    let (p, [mut least, mut most]) = (Scalar.splat(roughness), [roughness; 2]);
    for (k, view) in (0..ROUND).flat_map(|k| (0..=16).map(move |view| (k, view))) {
        let scale = polynomial(Scalar, &FIT[k][1], Scalar.splat(view as f32 / 16.0), p);
        let [found, ..] = (p * scale.clamp_to(0.05, 1.2)).at_most(1.0).to_array();
        least = if found < least { found } else { least };
        most = if found > most { found } else { most };
    }
    [least, most]
}

/// An interface as its lookups see it.
#[derive(Clone, Copy)]
pub(super) struct Lobe<L: Lanes> {
    view: V3<L>,
    normal: V3<L>,
    /// The view, mirrored.
    mirrored: V3<L>,
    n_dot_v: L::F,
    /// Perceptual roughness.
    roughness: L::F,
    /// Fragments for which a single lookup is enough.
    pub(super) one: L::M,
}

impl<L: Lanes> Lobe<L> {
    /// `single`: all fragments ask once, whatever their roughness.
    #[inline(always)]
    pub(super) fn new(
        l: L,
        view: V3<L>,
        normal: V3<L>,
        n_dot_v: L::F,
        roughness: L::F,
        single: bool,
    ) -> Self {
        let least = l.splat(if single { f32::INFINITY } else { SMOOTH });
        let mirrored = (-view).reflect(normal);
        Self { view, normal, mirrored, n_dot_v, roughness, one: roughness.lt(least) }
    }

    /// Cosine of view and half vector for a unit vector to the light.
    #[inline(always)]
    fn v_dot_h(&self, light: V3<L>) -> L::F {
        (self.view.dot(light) * 0.5 + 0.5).saturate().sqrt()
    }

    /// Round lobe k. The first is also the one of fragments that ask once.
    #[inline(always)]
    pub(super) fn round(&self, l: L, k: usize) -> Sample<L> {
        let (u, p) = (self.n_dot_v, self.roughness);
        let bend = polynomial(l, &FIT[k][0], u, p) * (p * p);
        let bend = self.one.select(l.zero(), bend);
        let scale = polynomial(l, &FIT[k][1], u, p).clamp_to(0.05, 1.2);
        let roughness = self.one.select(p, (p * scale).at_most(1.0));
        let direction = normalize_or(l, self.mirrored + (self.normal - self.mirrored) * bend, self.normal);
        let v_dot_h = self.v_dot_h(direction);
        Sample { query: query(l, direction, roughness), share: l.splat(SHARES[k]), v_dot_h }
    }

    /// Lobe k of a brushed surface: half vectors along the direction of the larger roughness, at equal shares of the
    /// slopes' distribution there, each nearly as wide as the surface is rough across it and no narrower than the gaps.
    /// At most views nearer to the lobe than sixteen of its visible normals.
    #[inline(always)]
    pub(super) fn brushed(&self, l: L, anisotropy: &AnisotropySurface<L>, k: usize) -> Sample<L> {
        let [along, across] = anisotropy.alpha;
        let (slope, gap) = SLOPES[k];
        // The rest of the spread once each lobe has its own.
        let spread = (along * along - across * across).at_least(0.0).sqrt();
        let half = (self.normal + anisotropy.tangent * (spread * slope)).normalize();
        let v_dot_h = self.view.dot(half);
        let light = half * (v_dot_h * 2.0) - self.view;
        let n_dot_l = light.dot(self.normal);
        // Its visible share, D G2 (V.H) / N.V over the half vectors (Heitz 2014).
        let masked = n_dot_l * stretched_length(l, anisotropy, self.view, self.n_dot_v);
        let shadowed = masked + self.n_dot_v * stretched_length(l, anisotropy, light, n_dot_l);
        let share = n_dot_l * v_dot_h / (half.dot(self.normal) * shadowed.at_least(1e-6));
        let seen = n_dot_l.gt(l.zero()).select(share, l.zero()).at_least(0.0);
        let alpha = (across * 0.8).max(spread * gap).at_most(1.0);
        let roughness = alpha.sqrt();
        // The mean of the round lobes' bends.
        let bent = light + (self.normal - light) * (alpha * roughness);
        let light = normalize_or(l, bent, self.normal);
        Sample { query: query(l, light, roughness), share: seen, v_dot_h: v_dot_h.saturate() }
    }
}

/// |(at V.t, ab V.b, V.n)|, by which Smith's shadowing goes.
#[inline(always)]
fn stretched_length<L: Lanes>(_: L, anisotropy: &AnisotropySurface<L>, v: V3<L>, cosine: L::F) -> L::F {
    let [along, across] = anisotropy.alpha;
    let (x, y) = (anisotropy.tangent.dot(v), anisotropy.bitangent.dot(v));
    Vec3::new(along * x, across * y, cosine).length()
}

/// Slopes of GGX along one axis in units of alpha, in the middle of twelve equal shares (u / sqrt(1 - u^2) for u = (2 k + 1)
/// / 12 - 1), and 0.45 of what each share covers, 0.5 at most.
const SLOPES: [(f32, f32); BRUSHED] = [
    (-2.293_659, 0.500),
    (-1.133_893, 0.259),
    (-0.718_185, 0.140),
    (-0.458_349, 0.100),
    (-0.258_199, 0.083),
    (-0.083_624, 0.076),
    (0.083_624, 0.076),
    (0.258_199, 0.083),
    (0.458_349, 0.100),
    (0.718_185, 0.140),
    (1.133_893, 0.259),
    (2.293_659, 0.500),
];

/// The mean radiance over a lobe, without weight and weighted with Schlick's (1 - V.H)^5.
#[derive(Clone, Copy)]
pub(super) struct Mean<L: Lanes> {
    pub(super) all: V3<L>,
    pub(super) grazing: V3<L>,
}

impl<L: Lanes> Mean<L> {
    /// This at 0, the other at 1.
    #[inline(always)]
    pub(super) fn lerp(&self, _: L, other: &Self, t: L::F) -> Self {
        Self { all: self.all.lerp(other.all, t), grazing: self.grazing.lerp(other.grazing, t) }
    }
}

/// Sums of lookups.
#[derive(Clone, Copy)]
pub(super) struct Sums<L: Lanes> {
    all: V3<L>,
    grazing: V3<L>,
    share: L::F,
    grazing_share: L::F,
    first: V3<L>,
}

impl<L: Lanes> Sums<L> {
    #[inline(always)]
    pub(super) fn new(l: L) -> Self {
        let (zero, none) = (l.zero(), Vec3::zero(l));
        Self { all: none, grazing: none, share: zero, grazing_share: zero, first: none }
    }

    /// Adds the radiance of sample k.
    #[inline(always)]
    pub(super) fn add(&mut self, l: L, k: usize, sample: &Sample<L>, radiance: V3<L>) {
        let grazing = sample.share * schlick_weight(l, sample.v_dot_h);
        self.all += radiance * sample.share;
        self.grazing += radiance * grazing;
        self.share = self.share + sample.share;
        self.grazing_share = self.grazing_share + grazing;
        if k == 0 {
            self.first = radiance;
        }
    }

    /// The means; where one lookup is all, that.
    #[inline(always)]
    pub(super) fn mean(&self, _: L, one: L::M) -> Mean<L> {
        let all = self.all * self.share.at_least(1e-20).recip();
        let grazing = self.grazing * self.grazing_share.at_least(1e-20).recip();
        Mean { all: Vec3::select(one, self.first, all), grazing: Vec3::select(one, self.first, grazing) }
    }
}
