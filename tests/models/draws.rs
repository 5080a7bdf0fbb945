//! Random inputs for the tests of the models: a fixed sequence, sixteen at a time, with the edges of every range in it.

use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};

/// Vectors of sixteen random numbers, of any instruction set: the numbers do not depend on it.
pub struct Draws {
    state: u64,
}

impl Draws {
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// SplitMix64.
    fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Numbers that [`Draws::unit`] loads. Compiled once, since the models inline it dozens of times.
    #[inline(never)]
    fn numbers(&mut self) -> [f32; LANES] {
        // Tables instead of branches, which nobody could predict.
        const SCALE: [f32; 8] = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        const OFFSET: [f32; 8] = [0.0, 1.0, 1e-20, 0.999_999_94, 0.0, 0.0, 0.0, 0.0];
        let mut numbers = [0.0; LANES];
        for x in &mut numbers {
            let bits = self.bits();
            let kind = (bits & 7) as usize;
            *x = (bits >> 40) as f32 * (1.0 / 16_777_215.0) * SCALE[kind] + OFFSET[kind];
        }
        numbers
    }

    /// 0 to 1: evenly in half of the lanes, elsewhere 0, 1, a tiny number, or one next to 1.
    #[inline(always)]
    pub fn unit<L: Lanes>(&mut self, l: L) -> L::F {
        l.load(&self.numbers())
    }

    /// Three of [`Draws::unit`].
    #[inline(always)]
    pub fn color<L: Lanes>(&mut self, l: L) -> V3<L> {
        Vec3::new(self.unit(l), self.unit(l), self.unit(l))
    }

    /// Unit vectors in the hemisphere of +Z or close beneath it, on its pole and its rim too.
    #[inline(always)]
    pub fn direction<L: Lanes>(&mut self, l: L) -> V3<L> {
        let z = self.unit(l) * 1.05 - 0.05;
        let (x, y) = (self.unit(l) * 2.0 - 1.0, self.unit(l) * 2.0 - 1.0);
        let planar = (x * x + y * y).at_least(1e-6).sqrt();
        let radius = (z * z).one_minus().at_least(0.0).sqrt() / planar;
        Vec3::new(x * radius, y * radius, z).normalize()
    }

    /// +Z once in two, or any of [`Draws::direction`].
    #[inline(always)]
    pub fn normal<L: Lanes>(&mut self, l: L) -> V3<L> {
        let direction = self.direction(l);
        if self.coin() { direction } else { Vec3::splat(l, [0.0, 0.0, 1.0]) }
    }

    /// True once in two.
    pub fn coin(&mut self) -> bool {
        self.bits() & 1 == 1
    }
}

/// True if all lanes of all components are numbers from `least` to the largest finite one.
#[inline(always)]
pub fn all_from<L: Lanes>(l: L, v: V3<L>, least: f32) -> bool {
    let (least, infinity) = (l.splat(least), l.splat(f32::INFINITY));
    v.to_array().into_iter().all(|c| (c.ge(least) & c.lt(infinity)).all())
}

/// A vector of one lane.
pub fn lane<L: Lanes>(v: V3<L>, k: usize) -> [f32; 3] {
    v.lane(k)
}

/// Directions that stand for equal parts of the hemisphere about +Z: as many vectors of sixteen.
pub fn hemisphere(rings: u32) -> Vec<V3<Scalar>> {
    let mut directions = Vec::new();
    for ring in 0..rings {
        let z: [f32; LANES] = [(ring as f32 + 0.5) / rings as f32; LANES];
        let angle = |k: usize| (k as f32 + 0.5) * (std::f32::consts::TAU / LANES as f32);
        let radius = (1.0 - z[0] * z[0]).sqrt();
        let x = std::array::from_fn(|k| radius * overcoat_core::math::scalar::cos(angle(k)));
        let y = std::array::from_fn(|k| radius * overcoat_core::math::scalar::sin(angle(k)));
        directions.push(Vec3::from_array([x, y, z]).map(|c| Scalar.load(&c)));
    }
    directions
}

/// The share of the light of a white hemisphere that leaves: the mean of what `reflected` gives for lights of colour
/// 1, times 2 pi. The largest of the channels.
pub fn reflectance(rings: u32, mut reflected: impl FnMut(V3<Scalar>) -> V3<Scalar>) -> f64 {
    let mut sum = [0.0_f64; 3];
    for direction in hemisphere(rings) {
        let light = reflected(direction);
        for (sum, c) in sum.iter_mut().zip(light.to_arrays()) {
            *sum += c.iter().map(|&x| f64::from(x)).sum::<f64>();
        }
    }
    let scale = std::f64::consts::TAU / f64::from(rings * LANES as u32);
    sum.into_iter().fold(0.0, |a: f64, b| a.max(b * scale))
}

/// A unit vector in the plane of X and Z.
pub fn tilted(cosine: f32) -> V3<Scalar> {
    Vec3::splat(Scalar, [(1.0 - cosine * cosine).sqrt(), 0.0, cosine])
}

/// Number of sets of random inputs that a test takes of each model: ten million where the compiler optimises.
pub const SETS: usize = if cfg!(debug_assertions) { 100_000 } else { 10_000_000 };

const COSINES: [f32; 6] = [1.0, 0.8, 0.5, 0.25, 0.1, 0.02];
const ROUGHNESSES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Largest value over views, roughness and metalness.
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

/// Asserts measured extremes, (what, found, expected), to half a percent: more is a change of the model, less too.
pub fn measured(extremes: &[(&str, f64, f64)]) {
    for (what, found, expected) in extremes {
        println!("{what}: {found:.4}, expected {expected}");
    }
    for (what, found, expected) in extremes {
        assert!((found - expected).abs() <= 0.005 * expected, "{what}: {found:.4}, not {expected}");
    }
}
