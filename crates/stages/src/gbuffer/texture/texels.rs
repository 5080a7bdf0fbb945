//! Reading texels: wrapping, addresses, unpacking, and the filter within one level.

use overcoat_core::color::srgb::SRGB8_LANES;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask};
use overcoat_scene::{BAND_SHIFT, ColorSpace, Filter, LevelLayout, Sampler, Texture, Wrap};
use prefetch_index::prefetch_index;

/// The largest code counts as 1.
const CODE: f32 = 1.0 / 255.0;

/// The colour of sixteen texels, each the bits of a little-endian integer, in whatever unit the colour space has it
/// cheapest.
trait Decode {
    fn decode<L: Lanes>(l: L, packed: L::I) -> [L::F; 3];
}

/// [`ColorSpace::Linear`]: as it is.
struct Linear;
/// [`ColorSpace::Srgb`]: made linear.
struct Srgb;

impl Decode for Linear {
    #[inline(always)]
    fn decode<L: Lanes>(_: L, packed: L::I) -> [L::F; 3] {
        [
            (packed & 0xff).to_float(),
            (packed.shr_logical(8) & 0xff).to_float(),
            (packed.shr_logical(16) & 0xff).to_float(),
        ]
    }
}

impl Decode for Srgb {
    #[inline(always)]
    fn decode<L: Lanes>(l: L, packed: L::I) -> [L::F; 3] {
        l.look_up_bytes(&SRGB8_LANES, packed)
    }
}

/// Alpha, which is linear in every colour space.
#[inline(always)]
fn alpha<I: Int>(packed: I) -> I::F {
    packed.shr_logical(24).to_float()
}

/// Brings filtered channels of a colour space to 0..1.
#[inline(always)]
pub(super) fn finish<F: Float>(color_space: ColorSpace, [r, g, b, a]: [F; 4]) -> [F; 4] {
    match color_space {
        ColorSpace::Srgb => [r, g, b, a * CODE],
        ColorSpace::Linear => [r * CODE, g * CODE, b * CODE, a * CODE],
    }
}

/// Size and place of the level of each lane.
pub(super) struct LevelLanes<'a, L: Lanes> {
    /// Level 0, which lies in an array of its own.
    is_0: bool,
    width: L::I,
    height: L::I,
    offset: L::I,
    /// For levels of which only some rows are there: offsets by band of rows, each of which takes the place of
    /// `offset`, and the number of the level's first band.
    bands: Option<(&'a [[u8; 4]], L::I)>,
}

impl<'a, L: Lanes> LevelLanes<'a, L> {
    /// One level, which must exist, for all lanes.
    #[inline(always)]
    pub fn uniform(l: L, texture: &'a Texture, level: i32) -> Self {
        let LevelLayout { width, height, offset } = texture.layout()[level as usize];
        Self {
            is_0: level == 0,
            width: l.splat_i(width as i32),
            height: l.splat_i(height as i32),
            offset: l.splat_i(offset as i32),
            bands: texture
                .bands()
                .map(|bands| (bands.places(), l.splat_i(bands.first(level as usize) as i32))),
        }
    }

    /// Any levels but 0; lanes at level 0 read something of no meaning, unless only some rows are there.
    #[inline(always)]
    pub fn reduced(l: L, texture: &'a Texture, levels: &[i32; LANES]) -> Self {
        let mut planes = [[0; LANES]; 3];
        for k in 0..LANES {
            let LevelLayout { width, height, offset } = texture.layout()[levels[k] as usize];
            planes[0][k] = width as i32;
            planes[1][k] = height as i32;
            planes[2][k] = offset as i32;
        }
        Self {
            is_0: false,
            width: l.load_i(&planes[0]),
            height: l.load_i(&planes[1]),
            offset: l.load_i(&planes[2]),
            bands: texture.bands().map(|bands| {
                let firsts = each!(level in *levels => bands.first(level as usize) as i32);
                (bands.places(), l.load_i(&firsts))
            }),
        }
    }

    /// Upper and lower row that a filter reads at the wrapped coordinate `v`, and the weight of the lower one, which
    /// has no meaning if the nearest is read.
    #[inline(always)]
    fn rows(&self, v: L::F, sampler: &Sampler, filter: Filter) -> ([L::I; 2], L::F) {
        let v = v * self.height.to_float();
        match filter {
            Filter::Nearest => {
                let y = v.to_int().min(self.height + -1);
                ([y; 2], v)
            }
            Filter::Linear => neighbours(v, self.height, sampler.wrap_v),
        }
    }

    /// Index of a row's first texel in the packed texels.
    #[inline(always)]
    fn start(&self, l: L, row: L::I) -> L::I {
        let place = match self.bands {
            None => self.offset,
            Some((places, first)) => l.gather_bytes(places, row.shr(BAND_SHIFT) + first),
        };
        row * self.width + place
    }
}

/// Places of the texels that a filter combines, and the position of each lane between them: the same in all textures
/// that are read alike.
#[derive(Clone, Copy)]
pub(super) struct Corners<L: Lanes> {
    /// In level 0.
    is_0: bool,
    /// The right ones follow the left ones in every lane.
    are_pairs: bool,
    /// Upper left, lower left; upper right and lower right, unless they are pairs.
    index: [L::I; 4],
    /// Filter weights of the texels.
    pub weights: Weights<L>,
}

/// Filter weights: one texel alone, or four of them bilinearly.
#[derive(Clone, Copy)]
pub(super) struct Weights<L: Lanes> {
    /// One texel a lane and not four.
    is_one: bool,
    /// Bilinear weights of the right texels and of the lower ones, 0 to 1.
    fractions: [L::F; 2],
}

impl<L: Lanes> Corners<L> {
    /// The first texel.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        Self { is_0: true, are_pairs: false, index: [l.splat_i(0); 4], weights: Weights::one(l) }
    }

    /// Texels of coordinates that [`wrap`] gave.
    #[inline(always)]
    pub fn new(
        l: L,
        sampler: &Sampler,
        levels: &LevelLanes<'_, L>,
        wrapped: [L::F; 2],
        filter: Filter,
    ) -> Self {
        let LevelLanes { is_0, width, .. } = *levels;
        let u = wrapped[0] * width.to_float();
        let ([y0, y1], t) = levels.rows(wrapped[1], sampler, filter);
        match filter {
            Filter::Nearest => {
                let x = u.to_int().min(width + -1);
                let index = levels.start(l, y0) + x;
                Self { is_0, are_pairs: false, index: [index; 4], weights: Weights::one(l) }
            }
            Filter::Linear => {
                let ([x0, x1], s) = neighbours(u, width, sampler.wrap_u);
                let (upper, lower) = (levels.start(l, y0), levels.start(l, y1));
                Self {
                    is_0,
                    are_pairs: x1.eq(x0 + 1).all(),
                    index: [upper + x0, lower + x0, upper + x1, lower + x1],
                    weights: Weights { is_one: false, fractions: [s, t] },
                }
            }
        }
    }

    /// The texels in each texture: upper left, upper right, lower left and lower right; or the one.
    ///
    /// Three textures at once, as materials often have them (base colour, normal, occlusion with roughness and metallic): a
    /// textured frame takes 0.95 of the time.
    #[inline(always)]
    pub fn fetch(&self, l: L, textures: &[&Texture], out: &mut [[L::I; 4]]) {
        let mut out = &mut out[..textures.len()];
        let mut textures = textures;
        if self.are_pairs {
            while let (Some(&three), Some(texels)) = (textures.first_chunk::<3>(), out.first_chunk_mut::<3>())
            {
                *texels = self.fetch_pairs(l, three);
                (textures, out) = (&textures[3..], &mut out[3..]);
            }
        }
        for (texture, texels) in textures.iter().zip(out) {
            *texels = if self.are_pairs {
                self.fetch_pairs(l, [texture])[0]
            } else {
                self.fetch_one_by_one(l, texture)
            };
        }
    }

    /// The same where texels are pairs.
    #[inline(always)]
    fn fetch_pairs<const N: usize>(&self, l: L, textures: [&Texture; N]) -> [[L::I; 4]; N] {
        let tables = each!(texture in textures => self.texels(texture));
        let upper = l.gather_pairs_bytes(tables, self.index[0]);
        let lower = l.gather_pairs_bytes(tables, self.index[1]);
        each!(n => [upper[n][0], upper[n][1], lower[n][0], lower[n][1]])
    }

    /// The same where texels are no pairs. A function of its own: inlined, its indices were taken out of their vectors even
    /// where they are not used.
    #[inline(never)]
    fn fetch_one_by_one(&self, l: L, texture: &Texture) -> [L::I; 4] {
        l.run(
            #[inline(always)]
            || {
                let texels = self.texels(texture);
                let [upper_left, lower_left, upper_right, lower_right] = self.index;
                let a = l.gather_bytes(texels, upper_left);
                if self.weights.is_one {
                    return [a; 4];
                }
                let b = l.gather_bytes(texels, upper_right);
                let c = l.gather_bytes(texels, lower_left);
                let d = l.gather_bytes(texels, lower_right);
                [a, b, c, d]
            },
        )
    }

    /// Prefetches the left texels of the upper rows, or of both `rows`, in textures: the right ones are beside them.
    /// Changes no result.
    ///
    /// Every lane's, although neighbours often share a cache line: with every other one, fetching took half as long again.
    #[inline(always)]
    pub fn prefetch(&self, textures: &[&Texture], rows: usize) {
        for index in &self.index[..rows] {
            let index = index.to_array();
            for texture in textures {
                let texels = self.texels(texture);
                for k in index {
                    prefetch_index(texels, k as u32 as usize);
                }
            }
        }
    }

    #[inline(always)]
    fn texels<'a>(&self, texture: &'a Texture) -> &'a [[u8; 4]] {
        if self.is_0 { texture.first_texels() } else { texture.reduced() }
    }
}

impl<L: Lanes> Weights<L> {
    #[inline(always)]
    pub fn one(l: L) -> Self {
        Self { is_one: true, fractions: [l.zero(); 2] }
    }

    /// Applies the filter to texels that [`Corners::fetch`] found in a texture, in the unit of [`finish`].
    #[inline(always)]
    pub fn filter(self, l: L, texture: &Texture, texels: [L::I; 4]) -> [L::F; 4] {
        let [r, g, b] = match texture.color_space() {
            ColorSpace::Srgb => self.blend::<Srgb>(l, texels),
            ColorSpace::Linear => self.blend::<Linear>(l, texels),
        };
        // Of texels that have it all, every mean is the same.
        let alpha = if texture.reads_opaque() { l.splat(255.0) } else { self.blend_alpha(texels) };
        [r, g, b, alpha]
    }

    #[inline(always)]
    fn blend<T: Decode>(self, l: L, [a, b, c, d]: [L::I; 4]) -> [L::F; 3] {
        let [s, t] = self.fractions;
        let mut result = T::decode(l, a);
        if self.is_one {
            return result;
        }
        let upper_right = T::decode(l, b);
        let lower_left = T::decode(l, c);
        let lower_right = T::decode(l, d);
        for n in 0..3 {
            let upper = result[n].lerp(upper_right[n], s);
            let lower = lower_left[n].lerp(lower_right[n], s);
            result[n] = upper.lerp(lower, t);
        }
        result
    }

    #[inline(always)]
    fn blend_alpha(self, [a, b, c, d]: [L::I; 4]) -> L::F {
        if self.is_one {
            return alpha(a);
        }
        let [s, t] = self.fractions;
        alpha(a).lerp(alpha(b), s).lerp(alpha(c).lerp(alpha(d), s), t)
    }
}

/// Coordinates of this magnitude and more are even integers in single precision, so all read the same texel.
const EVEN: f32 = 16_777_216.0;

/// Coordinates folded into one copy of a texture that is read by a sampler.
#[inline(always)]
pub(super) fn wrap<F: Float>(sampler: &Sampler, [u, v]: [F; 2]) -> [F; 2] {
    [wrap_coordinate(u, sampler.wrap_u), wrap_coordinate(v, sampler.wrap_v)]
}

/// A coordinate folded into one copy of the texture, 0 to 1 inclusive. NaN and infinity become 0 or 1.
#[inline(always)]
fn wrap_coordinate<F: Float>(u: F, wrap: Wrap) -> F {
    match wrap {
        Wrap::Repeat => {
            let u = u.clamp_to(-EVEN, EVEN);
            u - u.floor()
        }
        Wrap::MirroredRepeat => {
            let u = u.clamp_to(-EVEN, EVEN);
            // 0 to 2, then back from 1.
            let twice = u - (u * 0.5).floor() * 2.0;
            (twice - 1.0).abs().one_minus()
        }
        Wrap::ClampToEdge => u.saturate(),
    }
}

/// Indices of the two texels between whose centres a position (in texels, 0 to `size`) lies, and the weight of the
/// second.
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
