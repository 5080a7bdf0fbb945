//! Reading texels: wrapping, addresses, unpacking, and the filter within one level.

use crate::color::srgb::SRGB8_TO_LINEAR;
use crate::math::lanes::{Float, Int, LANES, Lanes, Mask};
use crate::scene::{Filter, LevelLayout, Texture, Wrap};

/// What is read of a texel, as N channels.
pub(super) trait Format<const N: usize> {
    /// The channels of sixteen texels, each the bits of a little-endian integer, in whatever unit the texture has them
    /// cheapest.
    fn decode<L: Lanes>(l: L, packed: L::I) -> [L::F; N];
    /// Brings filtered channels to 0..1.
    fn finish<F: Float>(channels: [F; N]) -> [F; N];
}

/// Red, green, blue and alpha as they are.
pub(super) struct Rgba;
/// Colours decoded from sRGB, and alpha.
pub(super) struct SrgbRgba;
/// Alpha alone.
pub(super) struct Alpha;

/// The largest code counts as 1.
const CODE: f32 = 1.0 / 255.0;

impl Format<4> for Rgba {
    #[inline(always)]
    fn decode<L: Lanes>(_: L, packed: L::I) -> [L::F; 4] {
        [
            (packed & 0xff).to_float(),
            (packed.shr_logical(8) & 0xff).to_float(),
            (packed.shr_logical(16) & 0xff).to_float(),
            packed.shr_logical(24).to_float(),
        ]
    }
    #[inline(always)]
    fn finish<F: Float>(channels: [F; 4]) -> [F; 4] {
        [channels[0] * CODE, channels[1] * CODE, channels[2] * CODE, channels[3] * CODE]
    }
}

impl Format<4> for SrgbRgba {
    #[inline(always)]
    fn decode<L: Lanes>(l: L, packed: L::I) -> [L::F; 4] {
        let [r, g, b] = l.look_up_bytes(&SRGB8_TO_LINEAR, packed);
        [r, g, b, packed.shr_logical(24).to_float()]
    }
    #[inline(always)]
    fn finish<F: Float>([r, g, b, a]: [F; 4]) -> [F; 4] {
        [r, g, b, a * CODE]
    }
}

impl Format<1> for Alpha {
    #[inline(always)]
    fn decode<L: Lanes>(_: L, packed: L::I) -> [L::F; 1] {
        [packed.shr_logical(24).to_float()]
    }
    #[inline(always)]
    fn finish<F: Float>([a]: [F; 1]) -> [F; 1] {
        [a * CODE]
    }
}

/// Size and place of the level of each lane.
struct Levels<'a, L: Lanes> {
    texels: &'a [[u8; 4]],
    width: L::I,
    height: L::I,
    offset: L::I,
}

impl<'a, L: Lanes> Levels<'a, L> {
    /// One level for all lanes.
    #[inline(always)]
    fn uniform(l: L, texture: &'a Texture, level: i32) -> Self {
        let LevelLayout { width, height, offset } = texture.layout()[level as usize];
        Self {
            texels: if level == 0 { texture.image().texels() } else { texture.reduced() },
            width: l.splat_i(width as i32),
            height: l.splat_i(height as i32),
            offset: l.splat_i(offset as i32),
        }
    }

    /// Any levels but 0; lanes at level 0 read something of no meaning.
    #[inline(always)]
    fn reduced(l: L, texture: &'a Texture, levels: &[i32; LANES]) -> Self {
        let mut planes = [[0; LANES]; 3];
        for k in 0..LANES {
            let LevelLayout { width, height, offset } = texture.layout()[levels[k] as usize];
            planes[0][k] = width as i32;
            planes[1][k] = height as i32;
            planes[2][k] = offset as i32;
        }
        Self {
            texels: texture.reduced(),
            width: l.load_i(&planes[0]),
            height: l.load_i(&planes[1]),
            offset: l.load_i(&planes[2]),
        }
    }
}

impl<L: Lanes> Levels<'_, L> {
    /// The texel at an index, as the bits of a little-endian integer. An index outside reads something of no meaning.
    #[inline(always)]
    fn texel(&self, l: L, index: L::I) -> L::I {
        l.gather_bytes(self.texels, index)
    }
}

/// One level per lane, filtered within. `level` must exist.
#[inline(always)]
pub(super) fn sample_level<L: Lanes, T: Format<N>, const N: usize>(
    l: L,
    texture: &Texture,
    level: L::I,
    uv: [L::F; 2],
    filter: Filter,
    active: L::M,
) -> [L::F; N] {
    // Neighbouring fragments nearly always lie on one level.
    let of_lane = level.to_array();
    let first = of_lane[active.bits().trailing_zeros() as usize % LANES];
    let at_first = level.eq(l.splat_i(first)) | !active;
    let uniform = at_first.all();
    let at_0 = level.eq(l.splat_i(0));
    let mut result = [l.zero(); N];
    for part in 0..2 {
        let levels = match (uniform, part) {
            (true, 0) => Levels::uniform(l, texture, first),
            (false, 0) => Levels::reduced(l, texture, &of_lane),
            // Level 0 lies in an array of its own.
            (false, 1) if (at_0 & active).any() => Levels::uniform(l, texture, 0),
            _ => break,
        };
        let texel = sample_within::<L, T, N>(l, texture, &levels, uv, filter);
        for n in 0..N {
            result[n] = if part == 0 { texel[n] } else { at_0.select(texel[n], result[n]) };
        }
    }
    result
}

#[inline(always)]
fn sample_within<L: Lanes, T: Format<N>, const N: usize>(
    l: L,
    texture: &Texture,
    levels: &Levels<'_, L>,
    uv: [L::F; 2],
    filter: Filter,
) -> [L::F; N] {
    let sampler = texture.sampler();
    let u = wrap_coordinate(uv[0], sampler.wrap_u) * levels.width.to_float();
    let v = wrap_coordinate(uv[1], sampler.wrap_v) * levels.height.to_float();
    match filter {
        Filter::Nearest => {
            let x = u.to_int().min(levels.width + -1);
            let y = v.to_int().min(levels.height + -1);
            T::decode(l, levels.texel(l, y * levels.width + levels.offset + x))
        }
        Filter::Linear => {
            let ([x0, x1], s) = neighbours(u, levels.width, sampler.wrap_u);
            let ([y0, y1], t) = neighbours(v, levels.height, sampler.wrap_v);
            let row_0 = y0 * levels.width + levels.offset;
            let inside = x1.eq(x0 + 1) & y1.eq(y0 + 1);
            let [upper_left, upper_right, lower_left, lower_right] = if inside.all() {
                let [a, b] = l.gather_pairs_bytes(levels.texels, row_0 + x0);
                let [c, d] = l.gather_pairs_bytes(levels.texels, row_0 + x0 + levels.width);
                [a, b, c, d]
            } else {
                let row_1 = y1 * levels.width + levels.offset;
                [
                    levels.texel(l, row_0 + x0),
                    levels.texel(l, row_0 + x1),
                    levels.texel(l, row_1 + x0),
                    levels.texel(l, row_1 + x1),
                ]
            };
            let mut result = T::decode(l, upper_left);
            let right = T::decode(l, upper_right);
            let lower_left = T::decode(l, lower_left);
            let lower_right = T::decode(l, lower_right);
            for n in 0..N {
                let upper = result[n].lerp(right[n], s);
                let lower = lower_left[n].lerp(lower_right[n], s);
                result[n] = upper.lerp(lower, t);
            }
            result
        }
    }
}

/// Coordinates of this magnitude and more are even integers in single precision, so all read the same texel.
const EVEN: f32 = 16_777_216.0;

/// A coordinate folded into one copy of the texture, 0 to 1 inclusive. NaN and infinity become 0 or 1.
#[inline(always)]
fn wrap_coordinate<F: Float>(u: F, wrap: Wrap) -> F {
    match wrap {
        Wrap::Repeat => {
            let u = u.clamp_to(-EVEN, EVEN);
            u - floor(u)
        }
        Wrap::MirroredRepeat => {
            let u = u.clamp_to(-EVEN, EVEN);
            // 0 to 2, then back from 1.
            let twice = u - floor(u * 0.5) * 2.0;
            (twice - 1.0).abs().one_minus()
        }
        Wrap::ClampToEdge => u.saturate(),
    }
}

/// Largest integer not above, for numbers that fit an integer. Without rounding instructions (SSE2) the general
/// function is sixteen calls.
#[inline(always)]
fn floor<F: Float>(x: F) -> F {
    let truncated = x.to_int().to_float();
    truncated - x.lt(truncated).select(x.splat_like(1.0), x.splat_like(0.0))
}

/// The two texels between whose centres a position (in texels, 0 to `size`) lies, and how far it is from the first
/// to the second.
#[inline(always)]
fn neighbours<F: Float>(position: F, size: F::I, wrap: Wrap) -> ([F::I; 2], F) {
    let x = position - 0.5;
    let floor = floor(x);
    let (first, fraction) = (floor.to_int(), x - floor);
    let (second, last) = (first + 1, size + -1);
    let between = match wrap {
        Wrap::Repeat => [
            first.non_negative().select_i(first, last),
            second.lt(size).select_i(second, first.splat_like(0)),
        ],
        // Beyond the edge a mirrored texture begins with the same texel.
        Wrap::MirroredRepeat | Wrap::ClampToEdge => [first.max(first.splat_like(0)), second.min(last)],
    };
    (between, fraction)
}
