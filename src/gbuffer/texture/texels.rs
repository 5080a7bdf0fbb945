//! Reading texels: wrapping, addresses, unpacking, and the filter within one level.

use crate::color::srgb::SRGB8_TO_LINEAR;
use crate::math::lanes::{Float, Int, LANES, Lanes, Mask};
use crate::scene::{Filter, LevelLayout, Texture, Wrap};

/// What is read of a texel, as N channels.
pub(super) trait Format<const N: usize> {
    /// The channels of sixteen texels, in whatever unit the texture has them cheapest.
    fn decode<L: Lanes>(l: L, texels: &[[u8; 4]; LANES]) -> [L::F; N];
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

/// Each texel as the bits of a little-endian integer.
#[inline(always)]
fn pack<L: Lanes>(l: L, texels: &[[u8; 4]; LANES]) -> L::I {
    let mut out = [0; LANES];
    for k in 0..LANES {
        out[k] = i32::from_le_bytes(texels[k]);
    }
    l.load_i(&out)
}

impl Format<4> for Rgba {
    #[inline(always)]
    fn decode<L: Lanes>(l: L, texels: &[[u8; 4]; LANES]) -> [L::F; 4] {
        let packed = pack(l, texels);
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
    fn decode<L: Lanes>(l: L, texels: &[[u8; 4]; LANES]) -> [L::F; 4] {
        let mut color = [[0.0; LANES]; 3];
        for k in 0..LANES {
            for c in 0..3 {
                color[c][k] = SRGB8_TO_LINEAR[usize::from(texels[k][c])];
            }
        }
        let alpha = pack(l, texels).shr_logical(24).to_float();
        [l.load(&color[0]), l.load(&color[1]), l.load(&color[2]), alpha]
    }
    #[inline(always)]
    fn finish<F: Float>([r, g, b, a]: [F; 4]) -> [F; 4] {
        [r, g, b, a * CODE]
    }
}

impl Format<1> for Alpha {
    #[inline(always)]
    fn decode<L: Lanes>(l: L, texels: &[[u8; 4]; LANES]) -> [L::F; 1] {
        [pack(l, texels).shr_logical(24).to_float()]
    }
    #[inline(always)]
    fn finish<F: Float>([a]: [F; 1]) -> [F; 1] {
        [a * CODE]
    }
}

/// `texels[index]` of every lane; an index outside reads 0.
#[inline(always)]
fn gather<I: Int>(texels: &[[u8; 4]], index: I) -> [[u8; 4]; LANES] {
    let index = index.to_array();
    let mut out = [[0; 4]; LANES];
    for k in 0..LANES {
        out[k] = texels.get(index[k] as usize).copied().unwrap_or_default();
    }
    out
}

/// The texels at an index, to the right of it, a row below, and to the right of that: one address for four.
#[inline(always)]
fn gather_quads<I: Int>(texels: &[[u8; 4]], index: I, row: usize) -> [[[u8; 4]; LANES]; 4] {
    let index = index.to_array();
    let mut out = [[[0; 4]; LANES]; 4];
    for k in 0..LANES {
        let first = index[k] as usize;
        let upper = texels.get(first..).and_then(|rest| rest.first_chunk());
        let lower = texels.get(first + row..).and_then(|rest| rest.first_chunk());
        if let (Some(&[a, b]), Some(&[c, d])) = (upper, lower) {
            out[0][k] = a;
            out[1][k] = b;
            out[2][k] = c;
            out[3][k] = d;
        }
    }
    out
}

/// Size and place of the level of each lane.
struct Levels<'a, L: Lanes> {
    texels: &'a [[u8; 4]],
    /// The width, if it is the same for all lanes.
    row: Option<usize>,
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
            row: Some(width as usize),
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
            row: None,
            width: l.load_i(&planes[0]),
            height: l.load_i(&planes[1]),
            offset: l.load_i(&planes[2]),
        }
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
            T::decode(l, &gather(levels.texels, y * levels.width + levels.offset + x))
        }
        Filter::Linear => {
            let ([x0, x1], s) = neighbours(u, levels.width, sampler.wrap_u);
            let ([y0, y1], t) = neighbours(v, levels.height, sampler.wrap_v);
            let row_0 = y0 * levels.width + levels.offset;
            let inside = x1.eq(x0 + 1) & y1.eq(y0 + 1);
            let quads = match levels.row {
                Some(row) if inside.all() => gather_quads(levels.texels, row_0 + x0, row),
                _ => {
                    let row_1 = y1 * levels.width + levels.offset;
                    let at = |index| gather(levels.texels, index);
                    [at(row_0 + x0), at(row_0 + x1), at(row_1 + x0), at(row_1 + x1)]
                }
            };
            let mut result = T::decode(l, &quads[0]);
            let right = T::decode(l, &quads[1]);
            let lower_left = T::decode(l, &quads[2]);
            let lower_right = T::decode(l, &quads[3]);
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
