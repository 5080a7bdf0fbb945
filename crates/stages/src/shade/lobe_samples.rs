//! Directions for rays: a fixed set of points of low discrepancy, turned from pixel to pixel, and the lobes that they are
//! mapped onto.

use overcoat_core::each;
use overcoat_core::math::double;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Rays below which the turns repeat after four and two blocks, as powers of two, and the pixels along a side of a block: the more
/// rays, the fewer pixels it takes until they are many.
const REPEATS: [(u32, u32, u32); 2] = [(32, 2, 2), (128, 1, 1)];

/// Points of the unit square, the first coordinate as an angle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LobeSamples {
    /// Cosine and sine of the angle, and the second coordinate.
    points: Vec<[f32; 3]>,
    /// Offsets of the points in each pixel of a square: a rotation by its cosine and sine, and a shift.
    turns: Vec<[f32; 3]>,
    /// Blocks along a side of that square.
    side: u32,
    /// Pixels along a side of a block.
    block: u32,
}

impl LobeSamples {
    /// `count` points of Roberts' R2 sequence (2018, "The unreasonable effectiveness of quasirandom sequences"), of which the
    /// first few do for narrow lobes, and turns of another part of it in the order of Bayer's matrix (1973), so that neighbours
    /// differ most.
    #[must_use]
    pub fn new(count: u32) -> Self {
        let at = |number: u32| {
            let along = |step: f64| {
                let place = f64::from(number) * step + 0.5;
                place - place.floor()
            };
            let (turn, other) = (along(0.754_877_666_246_692_8), along(0.569_840_290_998_053_2));
            let (sin, cos) = double::sin_cos(turn * std::f64::consts::TAU);
            [cos as f32, sin as f32, other as f32]
        };
        let (bits, block) =
            REPEATS.iter().find(|(rays, ..)| count < *rays).map_or((0, 1), |&(_, bits, block)| (bits, block));
        let side = 1 << bits;
        let turn = |pixel: u32| {
            let (x, y) = (pixel % side, pixel / side);
            let mut order = 0;
            for bit in 0..bits {
                let (column, row) = (x >> bit & 1, y >> bit & 1);
                order |= ((column ^ row) << 1 | row) << (2 * (bits - 1 - bit));
            }
            at(order * count)
        };
        Self {
            points: (0..count).map(at).collect(),
            turns: (0..side * side).map(turn).collect(),
            side,
            block,
        }
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Blocks along a side of the square after which the turns repeat: 4, 2 or 1.
    #[must_use]
    pub fn period(&self) -> u32 {
        self.side
    }

    /// Pixels along a side of the blocks whose surfaces send the rays of wide lobes together where they are alike: 2 or 1.
    #[must_use]
    pub fn block(&self) -> u32 {
        self.block
    }

    /// The turns of sixteen pixels, those of another set for each `lobe`: of lobes in the mask by the block that they lie in.
    #[inline(always)]
    pub(super) fn turns<L: Lanes>(
        &self,
        l: L,
        pixels: &[[u32; 2]; LANES],
        lobe: u32,
        of_blocks: u16,
    ) -> [L::F; 3] {
        let (mut planes, side) = ([[0.0; LANES]; 3], self.side);
        for (lane, pixel) in pixels.iter().enumerate() {
            let size = if of_blocks >> lane & 1 == 1 { self.block } else { 1 };
            let [x, y] = pixel.map(|v| v / size);
            let number = (x + 3 * lobe) % side + (y + 5 * lobe) % side * side;
            let turn = self.turns[number as usize];
            for k in 0..3 {
                planes[k][lane] = turn[k];
            }
        }
        each!(k => l.load(&planes[k]))
    }

    /// One point as sixteen pixels have it: cosine and sine of its angle, and the second coordinate.
    #[inline(always)]
    pub(super) fn point<L: Lanes>(&self, l: L, number: usize, turns: &[L::F; 3]) -> [L::F; 3] {
        let [cos, sin, other] = self.points[number];
        let [turn_cos, turn_sin, shift] = *turns;
        let shifted = shift + other;
        let one = l.splat(1.0);
        let wrapped = shifted.ge(one).select(shifted - one, shifted);
        [turn_cos * cos - turn_sin * sin, turn_sin * cos + turn_cos * sin, wrapped]
    }
}

/// A direction about a normal by the cosine, from a point.
#[inline(always)]
pub(super) fn cosine_direction<L: Lanes>(
    _: L,
    [tangent, bitangent, normal]: &[V3<L>; 3],
    [cos, sin, other]: [L::F; 3],
) -> V3<L> {
    let (radius, height) = (other.sqrt(), other.one_minus().at_least(0.0).sqrt());
    *tangent * (radius * cos) + *bitangent * (radius * sin) + *normal * height
}

/// A direction into which GGX reflects the view, from a point, and its weight: Smith's shadowing once the masking is in the
/// choice. Visible normals as Dupuy and Benyoub 2023 choose them ("Sampling visible GGX normals with spherical caps").
#[inline(always)]
pub(super) fn ggx_direction<L: Lanes>(
    l: L,
    [tangent, bitangent, normal]: &[V3<L>; 3],
    view: V3<L>,
    alpha: L::F,
    [cos, sin, other]: [L::F; 3],
) -> (V3<L>, L::F) {
    let v = Vec3::new(tangent.dot(view), bitangent.dot(view), normal.dot(view).at_least(1e-4));
    let stretched = Vec3::new(v.x * alpha, v.y * alpha, v.z).normalize();
    let z = other.one_minus() * (stretched.z + 1.0) - stretched.z;
    let radius = z.squared().one_minus().at_least(0.0).sqrt();
    let cap = Vec3::new(radius * cos, radius * sin, z) + stretched;
    let half = Vec3::new(cap.x * alpha, cap.y * alpha, cap.z.at_least(1e-6)).normalize();
    let towards = (-v).reflect(half);
    let own = lambda_plus_one(alpha, v.z);
    let below = towards.z.le(l.zero());
    let weight = below.select(l.zero(), own / (own + lambda_plus_one(alpha, towards.z) - 1.0));
    (*tangent * towards.x + *bitangent * towards.y + *normal * towards.z, weight)
}

/// Smith's Lambda of GGX and 1, of a direction with this cosine.
#[inline(always)]
fn lambda_plus_one<F: Float>(alpha: F, cosine: F) -> F {
    let square = cosine.squared().at_least(1e-8);
    let tangent_2 = square.one_minus().at_least(0.0) / square;
    ((tangent_2 * alpha.squared() + 1.0).sqrt() + 1.0) * 0.5
}
