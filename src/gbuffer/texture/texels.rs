//! Reading texels: wrapping, addresses, unpacking, and the filter within one level.

use crate::color::srgb::SRGB8_TO_LINEAR;
use crate::math::lanes::{Float, Int, LANES, Lanes, Mask};
use crate::scene::{Filter, LevelLayout, Texture, Wrap};

/// What is read of a texel, as N channels.
pub(super) trait Format<const N: usize> {
    /// The channels of `texels[index]`, in whatever unit the texture has them cheapest.
    fn read<L: Lanes>(l: L, texels: &[[u8; 4]], index: L::I) -> [L::F; N];
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

/// `texels[index]` of every lane, each as the bits of a little-endian integer.
#[inline(always)]
fn gather<L: Lanes>(l: L, texels: &[[u8; 4]], index: L::I) -> L::I {
    let index = index.to_array();
    let mut out = [0; LANES];
    for k in 0..LANES {
        out[k] = texels.get(index[k] as usize).map_or(0, |&texel| i32::from_le_bytes(texel));
    }
    l.load_i(&out)
}

impl Format<4> for Rgba {
    #[inline(always)]
    fn read<L: Lanes>(l: L, texels: &[[u8; 4]], index: L::I) -> [L::F; 4] {
        let packed = gather(l, texels, index);
        [
            (packed & 0xff).to_float(),
            (packed.shr_logical(8) & 0xff).to_float(),
            (packed.shr_logical(16) & 0xff).to_float(),
            packed.shr_logical(24).to_float(),
        ]
    }
    #[inline(always)]
    fn finish<F: Float>(channels: [F; 4]) -> [F; 4] {
        channels.map(|c| c * CODE)
    }
}

impl Format<4> for SrgbRgba {
    #[inline(always)]
    fn read<L: Lanes>(l: L, texels: &[[u8; 4]], index: L::I) -> [L::F; 4] {
        let index = index.to_array();
        let mut out = [[0.0; LANES]; 3];
        let mut alpha = [0; LANES];
        for k in 0..LANES {
            let [r, g, b, a] = texels.get(index[k] as usize).copied().unwrap_or_default();
            out[0][k] = SRGB8_TO_LINEAR[usize::from(r)];
            out[1][k] = SRGB8_TO_LINEAR[usize::from(g)];
            out[2][k] = SRGB8_TO_LINEAR[usize::from(b)];
            alpha[k] = i32::from(a);
        }
        [l.load(&out[0]), l.load(&out[1]), l.load(&out[2]), l.load_i(&alpha).to_float()]
    }
    #[inline(always)]
    fn finish<F: Float>([r, g, b, a]: [F; 4]) -> [F; 4] {
        [r, g, b, a * CODE]
    }
}

impl Format<1> for Alpha {
    #[inline(always)]
    fn read<L: Lanes>(l: L, texels: &[[u8; 4]], index: L::I) -> [L::F; 1] {
        [gather(l, texels, index).shr_logical(24).to_float()]
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
    let first = level.to_array()[active.bits().trailing_zeros() as usize % LANES];
    let layout = texture.layout();
    if (level.eq(l.splat_i(first)) | !active).all() {
        let LevelLayout { width, height, offset } = layout[first as usize];
        let texels = if first == 0 { texture.image().texels() } else { texture.reduced() };
        let levels = Levels {
            texels,
            width: l.splat_i(width as i32),
            height: l.splat_i(height as i32),
            offset: l.splat_i(offset as i32),
        };
        return sample_within::<L, T, N>(l, texture, &levels, uv, filter);
    }
    let of = level.to_array();
    let mut planes = [[0; LANES]; 3];
    for k in 0..LANES {
        let LevelLayout { width, height, offset } = layout[of[k] as usize];
        planes[0][k] = width as i32;
        planes[1][k] = height as i32;
        planes[2][k] = offset as i32;
    }
    let [width, height, offset] = planes.map(|plane| l.load_i(&plane));
    let levels = Levels { texels: texture.reduced(), width, height, offset };
    let texel = sample_within::<L, T, N>(l, texture, &levels, uv, filter);
    // Level 0 lies in an array of its own.
    let at_0 = level.eq(l.splat_i(0));
    if !(at_0 & active).any() {
        return texel;
    }
    let LevelLayout { width, height, .. } = layout[0];
    let levels = Levels {
        texels: texture.image().texels(),
        width: l.splat_i(width as i32),
        height: l.splat_i(height as i32),
        offset: l.splat_i(0),
    };
    let fine = sample_within::<L, T, N>(l, texture, &levels, uv, filter);
    std::array::from_fn(|n| at_0.select(fine[n], texel[n]))
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
    let row = |y: L::I| y * levels.width + levels.offset;
    match filter {
        Filter::Nearest => {
            let x = u.to_int().min(levels.width + -1);
            let y = v.to_int().min(levels.height + -1);
            T::read(l, levels.texels, row(y) + x)
        }
        Filter::Linear => {
            let ([x0, x1], s) = neighbours(u, levels.width, sampler.wrap_u);
            let ([y0, y1], t) = neighbours(v, levels.height, sampler.wrap_v);
            let (row_0, row_1) = (row(y0), row(y1));
            let upper = pair::<L, T, N>(l, levels.texels, row_0 + x0, row_0 + x1, s);
            let lower = pair::<L, T, N>(l, levels.texels, row_1 + x0, row_1 + x1, s);
            std::array::from_fn(|n| upper[n].lerp(lower[n], t))
        }
    }
}

#[inline(always)]
fn pair<L: Lanes, T: Format<N>, const N: usize>(
    l: L,
    texels: &[[u8; 4]],
    left: L::I,
    right: L::I,
    s: L::F,
) -> [L::F; N] {
    let (left, right) = (T::read(l, texels, left), T::read(l, texels, right));
    std::array::from_fn(|n| left[n].lerp(right[n], s))
}

/// A coordinate folded into one copy of the texture, 0 to 1 inclusive. NaN and infinity become 0 or 1.
#[inline(always)]
fn wrap_coordinate<F: Float>(u: F, wrap: Wrap) -> F {
    match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::MirroredRepeat => {
            // 0 to 2, then back from 1.
            let twice = u - (u * 0.5).floor() * 2.0;
            (twice - 1.0).abs().one_minus()
        }
        Wrap::ClampToEdge => u,
    }
    .saturate()
}

/// The two texels between whose centres a position (in texels, 0 to `size`) lies, and how far it is from the first
/// to the second.
#[inline(always)]
fn neighbours<F: Float>(position: F, size: F::I, wrap: Wrap) -> ([F::I; 2], F) {
    let x = position - 0.5;
    let floor = x.floor();
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
