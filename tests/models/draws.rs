//! Random inputs for the tests of the models: a fixed sequence, sixteen at a time, with the edges of every range in it.

use overcoat::math::lanes::{Float, Int, LANES, Lanes, Mask, Scalar};
use overcoat::math::vec3::{self, V3};

/// Vectors of sixteen random numbers.
pub struct Draws<L: Lanes> {
    l: L,
    state: L::I,
}

impl<L: Lanes> Draws<L> {
    #[inline(always)]
    pub fn new(l: L, seed: i32) -> Self {
        Self { l, state: (l.lane_indices() + seed) * 0x6c07_8965 + 1 }
    }

    /// 32 bits a lane, the upper ones the better.
    #[inline(always)]
    fn bits(&mut self) -> L::I {
        self.state = self.state * 1_664_525 + 1_013_904_223;
        // Lanes of one generator are shifted copies of each other: the product tells them apart.
        (self.state ^ self.state.shr_logical(15)) * 0x2c1b_3c6d
    }

    /// 0 to 1, evenly.
    #[inline(always)]
    pub fn even(&mut self) -> L::F {
        self.bits().shr_logical(8).to_float() * (1.0 / 16_777_215.0)
    }

    /// 0 to 1: evenly in half of the lanes, elsewhere 0, 1, a tiny number, or one next to 1.
    #[inline(always)]
    pub fn unit(&mut self) -> L::F {
        let l = self.l;
        let (even, which) = (self.even(), self.bits().shr_logical(29));
        let is = |k: i32| which.eq(l.splat_i(k));
        let x = is(0).select(l.zero(), even);
        let x = is(1).select(l.splat(1.0), x);
        let x = is(2).select(l.splat(1e-20), x);
        is(3).select(l.splat(0.999_999_94), x)
    }

    /// Three of [`Draws::unit`].
    #[inline(always)]
    pub fn color(&mut self) -> V3<L> {
        [self.unit(), self.unit(), self.unit()]
    }

    /// A unit vector in the hemisphere of +Z or close beneath it, on its pole and its rim too.
    #[inline(always)]
    pub fn direction(&mut self) -> V3<L> {
        let l = self.l;
        let z = self.unit() * 1.05 - 0.05;
        let (x, y) = (self.unit() * 2.0 - 1.0, self.unit() * 2.0 - 1.0);
        let planar = (x * x + y * y).at_least(1e-6).sqrt();
        let radius = (z * z).one_minus().at_least(0.0).sqrt() / planar;
        vec3::normalize(l, [x * radius, y * radius, z])
    }

    /// True once in two.
    #[inline(always)]
    pub fn coin(&mut self) -> bool {
        self.bits().to_array()[0] < 0
    }
}

/// Lanes that are not finite numbers.
#[inline(always)]
pub fn not_finite<L: Lanes>(l: L, v: V3<L>) -> L::M {
    let wrong = |x: L::F| !x.abs().le(l.splat(f32::MAX));
    wrong(v[0]) | wrong(v[1]) | wrong(v[2])
}

/// A vector of one lane.
pub fn lane<L: Lanes>(v: V3<L>, k: usize) -> [f32; 3] {
    v.map(|c| c.to_array()[k])
}

/// Directions that stand for equal parts of the hemisphere about +Z: as many vectors of sixteen.
pub fn hemisphere(rings: u32) -> Vec<V3<Scalar>> {
    let mut directions = Vec::new();
    for ring in 0..rings {
        let z: [f32; LANES] = [(ring as f32 + 0.5) / rings as f32; LANES];
        let angle = |k: usize| (k as f32 + 0.5) * (std::f32::consts::TAU / LANES as f32);
        let radius = (1.0 - z[0] * z[0]).sqrt();
        let x = std::array::from_fn(|k| radius * overcoat::math::scalar::cos(angle(k)));
        let y = std::array::from_fn(|k| radius * overcoat::math::scalar::sin(angle(k)));
        directions.push([x, y, z].map(|c| Scalar.load(&c)));
    }
    directions
}

/// The share of the light of a white hemisphere that leaves: the mean of what `reflected` gives for lights of colour
/// 1, times 2 pi. The largest of the channels.
pub fn reflectance(rings: u32, mut reflected: impl FnMut(V3<Scalar>) -> V3<Scalar>) -> f64 {
    let mut sum = [0.0_f64; 3];
    for direction in hemisphere(rings) {
        let light = reflected(direction);
        for (sum, c) in sum.iter_mut().zip(light) {
            *sum += c.to_array().iter().map(|&x| f64::from(x)).sum::<f64>();
        }
    }
    let scale = std::f64::consts::TAU / f64::from(rings * LANES as u32);
    sum.into_iter().fold(0.0, |a: f64, b| a.max(b * scale))
}

/// A unit vector in the plane of X and Z.
pub fn tilted(cosine: f32) -> V3<Scalar> {
    vec3::splat(Scalar, [(1.0 - cosine * cosine).sqrt(), 0.0, cosine])
}

/// How many sets of random inputs a test takes: ten million where the build is optimised for it.
pub const SETS: usize = if cfg!(debug_assertions) { 200_000 } else { 10_000_000 };

const COSINES: [f32; 6] = [1.0, 0.8, 0.5, 0.25, 0.1, 0.02];
const ROUGHNESSES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// What is found at most, over views, roughness and metalness.
pub fn most(mut of: impl FnMut(f32, f32, f32) -> f64) -> f64 {
    let mut most = 0.0_f64;
    for cosine in COSINES {
        for roughness in ROUGHNESSES {
            for metalness in [0.0, 1.0] {
                most = most.max(of(cosine, roughness, metalness));
            }
        }
    }
    most
}

/// Asserts a measured extreme to half a percent: more is a change of the model, less too.
pub fn measured(what: &str, found: f64, expected: f64) {
    println!("{what}: {found:.4}");
    assert!((found - expected).abs() <= 0.005, "{what}: {found:.4}, not {expected}");
}
