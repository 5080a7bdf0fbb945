//! The lanes against a plain definition in double precision, and what must hold of any filter.

use super::*;
use overcoat_core::math::lanes::{LANES, SimdLevel};
use overcoat_scene::{AlphaUse, ColorSpace, Filter, Image, MipFilter, Sampler, Wrap};
use std::sync::Arc;

/// Numbers in [0, 1), the same in every run.
struct Noise(u32);

impl Noise {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 8
    }
    fn next(&mut self) -> f32 {
        self.bits() as f32 / 16_777_216.0
    }
    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }
}

fn image(width: u32, height: u32, texel: impl FnMut(u32) -> [u8; 4]) -> Arc<Image> {
    Arc::new(Image::new(width, height, (0..width * height).map(texel).collect()).unwrap())
}

fn noise_texture(width: u32, height: u32, color_space: ColorSpace, sampler: Sampler) -> Texture {
    let mut noise = Noise(width * 31 + height);
    let image = image(width, height, |_| (noise.bits() ^ noise.bits() << 8).to_le_bytes());
    Texture::new(image, color_space, AlphaUse::Data, sampler)
}

/// Sixteen places to read.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Places {
    uv: [[f32; LANES]; 2],
    dx: [[f32; LANES]; 2],
    dy: [[f32; LANES]; 2],
}

impl Places {
    fn same(uv: [f32; 2], dx: [f32; 2], dy: [f32; 2]) -> Self {
        Self { uv: uv.map(|c| [c; LANES]), dx: dx.map(|c| [c; LANES]), dy: dy.map(|c| [c; LANES]) }
    }
    fn random(noise: &mut Noise, texels_per_pixel: f32, texture: &Texture) -> Self {
        let size = [texture.image().width() as f32, texture.image().height() as f32];
        let mut derivative = |coherent: bool| {
            let scale = texels_per_pixel * noise.within(0.3, 3.0);
            let base = [noise.within(-scale, scale), noise.within(-scale, scale)];
            std::array::from_fn(|axis| {
                std::array::from_fn(|_| {
                    let wobble = if coherent { noise.within(0.9, 1.1) } else { noise.within(-8.0, 8.0) };
                    base[axis] * wobble / size[axis]
                })
            })
        };
        let coherent = texels_per_pixel < 4.0;
        let (dx, dy) = (derivative(coherent), derivative(coherent));
        Self { uv: std::array::from_fn(|_| std::array::from_fn(|_| noise.within(-2.0, 3.0))), dx, dy }
    }
    fn lane(&self, k: usize) -> [[f64; 2]; 3] {
        [self.uv, self.dx, self.dy].map(|v| [f64::from(v[0][k]), f64::from(v[1][k])])
    }
    #[inline(always)]
    fn read<L: Lanes>(&self, l: L, texture: &Texture, anisotropy: u32, active: u16) -> [[f32; LANES]; 4] {
        let load = |v: &[[f32; LANES]; 2]| [l.load(&v[0]), l.load(&v[1])];
        let footprint = Footprint { dx: load(&self.dx), dy: load(&self.dy) };
        let active = l.mask(active);
        sample(l, texture, load(&self.uv), &footprint, anisotropy, active).map(Float::to_array)
    }
    fn read_at(
        &self,
        level: SimdLevel,
        texture: &Texture,
        anisotropy: u32,
        active: u16,
    ) -> [[f32; LANES]; 4] {
        overcoat_core::dispatch!(level, l => self.read(l, texture, anisotropy, active))
    }
    /// RGBA of one lane at the best level.
    fn texel(&self, texture: &Texture, anisotropy: u32) -> [f32; 4] {
        let planes = self.read_at(SimdLevel::best(), texture, anisotropy, u16::MAX);
        std::array::from_fn(|n| planes[n][0])
    }
}

/// The definition, one fragment at a time.
mod definition {
    use super::*;
    use overcoat_core::color::srgb::SRGB8_TO_LINEAR;
    use overcoat_core::math::double;

    fn texel(texture: &Texture, level: usize, x: i64, y: i64) -> [f64; 4] {
        let level = texture.levels().nth(level).unwrap();
        let wrap = |i: i64, n: u32, wrap| {
            let n = i64::from(n);
            match wrap {
                Wrap::Repeat => i.rem_euclid(n),
                Wrap::MirroredRepeat => {
                    let i = i.rem_euclid(2 * n);
                    if i < n { i } else { 2 * n - 1 - i }
                }
                Wrap::ClampToEdge => i.clamp(0, n - 1),
            }
        };
        let x = wrap(x, level.width, texture.sampler().wrap_u);
        let y = wrap(y, level.height, texture.sampler().wrap_v);
        let texel = level.texels[(y * i64::from(level.width) + x) as usize];
        std::array::from_fn(|n| match texture.color_space() {
            ColorSpace::Srgb if n < 3 => f64::from(SRGB8_TO_LINEAR[usize::from(texel[n])]),
            _ => f64::from(texel[n]) / 255.0,
        })
    }

    fn mix(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
        std::array::from_fn(|n| a[n] * (1.0 - t) + b[n] * t)
    }

    fn within(texture: &Texture, level: usize, [u, v]: [f64; 2], filter: Filter) -> [f64; 4] {
        let layout = texture.layout()[level];
        let (x, y) = (u * f64::from(layout.width), v * f64::from(layout.height));
        let at = |x: f64, y: f64| texel(texture, level, x as i64, y as i64);
        match filter {
            Filter::Nearest => at(x.floor(), y.floor()),
            Filter::Linear => {
                let (x, y) = (x - 0.5, y - 0.5);
                let (i, j) = (x.floor(), y.floor());
                let upper = mix(at(i, j), at(i + 1.0, j), x - i);
                let lower = mix(at(i, j + 1.0), at(i + 1.0, j + 1.0), x - i);
                mix(upper, lower, y - j)
            }
        }
    }

    fn mips(texture: &Texture, uv: [f64; 2], lambda: f64) -> [f64; 4] {
        let sampler = texture.sampler();
        let last = texture.level_count() - 1;
        let filter = if lambda <= 0.0 { sampler.magnification } else { sampler.minification };
        let clamped = lambda.clamp(0.0, last as f64);
        match sampler.mip {
            MipFilter::None => within(texture, 0, uv, filter),
            MipFilter::Nearest => {
                within(texture, ((clamped + 0.5).ceil() - 1.0).max(0.0) as usize, uv, filter)
            }
            MipFilter::Linear => {
                let level = clamped.floor() as usize;
                let fine = within(texture, level, uv, filter);
                mix(fine, within(texture, (level + 1).min(last), uv, filter), clamped - clamped.floor())
            }
        }
    }

    /// Logarithm of a positive number by repeated squaring.
    pub fn log2(mut x: f64) -> f64 {
        let mut result = 0.0;
        while x >= 2.0 {
            x *= 0.5;
            result += 1.0;
        }
        while x < 1.0 {
            x *= 2.0;
            result -= 1.0;
        }
        let mut bit = 0.5;
        for _ in 0..40 {
            x *= x;
            if x >= 2.0 {
                x *= 0.5;
                result += bit;
            }
            bit *= 0.5;
        }
        result
    }

    /// The filtered texel, the level of detail and the number of probes.
    pub fn sample(texture: &Texture, [uv, dx, dy]: [[f64; 2]; 3], anisotropy: u32) -> ([f64; 4], f64, f64) {
        let size = [f64::from(texture.image().width()), f64::from(texture.image().height())];
        let [a, b] = [dx[0] * size[0], dx[1] * size[1]];
        let [c, d] = [dy[0] * size[0], dy[1] * size[1]];
        if anisotropy == 1 || texture.sampler().minification == Filter::Nearest {
            let lambda = log2((a * a + b * b).max(c * c + d * d).sqrt());
            return (mips(texture, uv, lambda), lambda, 1.0);
        }
        // Singular values by the closed form of sums and differences.
        let length = |x: f64, y: f64| (x * x + y * y).sqrt();
        let (sum, difference) = (length(a + d, b - c), length(a - d, b + c));
        let (major, minor) = ((sum + difference) / 2.0, (sum - difference).abs() / 2.0);
        let eta = if major <= 1.0 { 1.0 } else { (major / minor - 0.25).clamp(1.0, f64::from(anisotropy)) };
        let (count, lambda) = (eta.ceil(), log2(major / eta));
        // The direction that the footprint is longest in.
        let angle = 0.5 * double::atan2(2.0 * (a * b + c * d), a * a + c * c - b * b - d * d);
        let axis = [double::cos(angle) * major / size[0], double::sin(angle) * major / size[1]];
        let mut total = [0.0; 4];
        for k in 1..=count as u32 {
            let t = f64::from(k) / (count + 1.0) - 0.5;
            let texel = mips(texture, [uv[0] + t * axis[0], uv[1] + t * axis[1]], lambda);
            total = std::array::from_fn(|n| total[n] + texel[n] / count);
        }
        (total, lambda, count)
    }
}

fn samplers() -> impl Iterator<Item = Sampler> {
    let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    let filters = [Filter::Nearest, Filter::Linear];
    let mips = [MipFilter::None, MipFilter::Nearest, MipFilter::Linear];
    (0..36).map(move |k| Sampler {
        wrap_u: wraps[k % 3],
        wrap_v: wraps[(k + k / 3) % 3],
        magnification: filters[k / 3 % 2],
        minification: filters[k / 6 % 2],
        mip: mips[k / 12],
    })
}

const SIZES: [(u32, u32); 6] = [(16, 16), (1, 1), (1, 7), (33, 5), (64, 1), (30, 100)];

#[test]
fn lanes_follow_the_definition() {
    let mut noise = Noise(7);
    let (mut compared, mut anisotropic) = (0, 0);
    for sampler in samplers() {
        for (width, height) in SIZES {
            for color_space in [ColorSpace::Srgb, ColorSpace::Linear] {
                let texture = noise_texture(width, height, color_space, sampler);
                for texels_per_pixel in [0.1, 0.9, 3.0, 40.0] {
                    let places = Places::random(&mut noise, texels_per_pixel, &texture);
                    for anisotropy in [1, 16] {
                        let found = places.read_at(SimdLevel::best(), &texture, anisotropy, u16::MAX);
                        for k in 0..LANES {
                            let place = places.lane(k);
                            // Where a rounding decides between two texels or levels, either is right.
                            let (expected, lambda, count) = definition::sample(&texture, place, anisotropy);
                            let jitter = |d: f64| {
                                let moved = place.map(|v| v.map(|c| c + d * (1.0 + c.abs())));
                                let (e, l, n) = definition::sample(&texture, moved, anisotropy);
                                let far = (0..4).any(|c| (e[c] - expected[c]).abs() > 2e-3);
                                far || (l - lambda).abs() > 1e-3 || n != count
                            };
                            let on_the_edge = sampler.mip == MipFilter::Nearest
                                && (lambda - 0.5 - (lambda - 0.5).round()).abs() < 1e-3
                                || lambda.abs() < 1e-3;
                            if on_the_edge || jitter(2e-6) || jitter(-2e-6) {
                                continue;
                            }
                            compared += 1;
                            anisotropic += usize::from(count > 1.0);
                            for c in 0..4 {
                                let difference = (f64::from(found[c][k]) - expected[c]).abs();
                                assert!(
                                    difference < 1e-3,
                                    "{sampler:?} {width}x{height} {color_space:?} anisotropy {anisotropy}: \
                                     channel {c} is {} and not {} at {place:?}, lambda {lambda}, count {count}",
                                    found[c][k],
                                    expected[c],
                                );
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 45_000 && anisotropic > 5_000, "{compared} {anisotropic}");
}

#[test]
fn every_level_gives_the_bits_of_the_scalar_reference() {
    let mut noise = Noise(3);
    for (k, sampler) in samplers().enumerate() {
        let (width, height) = SIZES[k % SIZES.len()];
        let color_space = if k % 2 == 0 { ColorSpace::Srgb } else { ColorSpace::Linear };
        let texture = noise_texture(width, height, color_space, sampler);
        for texels_per_pixel in [0.2, 2.0, 30.0] {
            let places = Places::random(&mut noise, texels_per_pixel, &texture);
            for (anisotropy, active) in [(1, u16::MAX), (8, u16::MAX), (16, 0x8421)] {
                let read = |level| {
                    let planes = places.read_at(level, &texture, anisotropy, active);
                    let mut bits = planes.map(|plane| plane.map(f32::to_bits));
                    for plane in &mut bits {
                        for k in 0..LANES {
                            plane[k] *= u32::from(active >> k & 1);
                        }
                    }
                    bits
                };
                let expected = read(SimdLevel::Scalar);
                for level in SimdLevel::available() {
                    assert!(read(level) == expected, "{level} {sampler:?} {places:?}");
                }
            }
        }
    }
}

#[test]
fn textures_read_together_have_the_bits_of_each_alone() {
    let mut noise = Noise(11);
    for sampler in samplers() {
        let color_spaces = [ColorSpace::Srgb, ColorSpace::Linear, ColorSpace::Srgb, ColorSpace::Linear];
        let textures = color_spaces.map(|color_space| {
            let image = image(40, 24, |_| (noise.bits() ^ noise.bits() << 8).to_le_bytes());
            Texture::new(image, color_space, AlphaUse::Data, sampler)
        });
        let textures: [&Texture; MAX_TOGETHER] = textures.each_ref();
        assert!(textures.iter().all(|texture| texture.is_read_like(textures[0])));
        for texels_per_pixel in [0.4, 1.0, 3.0, 20.0] {
            let places = Places::random(&mut noise, texels_per_pixel, textures[0]);
            for level in SimdLevel::available() {
                overcoat_core::dispatch!(level, l => {
                    let load = |v: &[[f32; LANES]; 2]| [l.load(&v[0]), l.load(&v[1])];
                    let footprint = Footprint { dx: load(&places.dx), dy: load(&places.dy) };
                    let (uv, active) = (load(&places.uv), l.mask(0x7fff));
                    // One plan for all: nothing may stay of the one before.
                    let (mut plan, mut fetched) = (SamplePlan::none(l), Fetched::none(l));
                    for (len, anisotropy) in [(1, 8), (3, 1), (4, 8)] {
                        let mut together = [[l.splat(7.0); 4]; MAX_TOGETHER];
                        let out = &mut together[..len];
                        plan.make(l, textures[0], &uv, &footprint, anisotropy, active);
                        plan.prefetch(&textures[..len]);
                        plan.sample(l, &textures[..len], &mut fetched, out);
                        for (texture, found) in textures.iter().zip(out) {
                            let alone = sample(l, texture, uv, &footprint, anisotropy, active);
                            for n in 0..4 {
                                let bits = |v: [f32; LANES]| v.map(f32::to_bits);
                                let (found, alone) = (bits(found[n].to_array()), bits(alone[n].to_array()));
                                assert_eq!(found[..15], alone[..15], "{level} {sampler:?} {len} {anisotropy}");
                            }
                        }
                    }
                });
            }
        }
    }
}

/// Alpha of opaque textures is not read: it must have the bits that reading gives, which the first channel has here.
#[test]
fn opaque_textures_have_the_bits_of_others() {
    let mut noise = Noise(13);
    for sampler in samplers() {
        for color_space in [ColorSpace::Srgb, ColorSpace::Linear] {
            let colors: Vec<[u8; 4]> = (0..40 * 24).map(|_| noise.bits().to_le_bytes()).collect();
            let with_alpha = |alpha: u8| {
                let image = image(40, 24, |k| [255, colors[k as usize][1], colors[k as usize][2], alpha]);
                Texture::new(image, color_space, AlphaUse::Data, sampler)
            };
            let (opaque, other) = (with_alpha(255), with_alpha(254));
            assert!(opaque.is_opaque() && !other.is_opaque());
            for texels_per_pixel in [0.4, 1.0, 3.0, 20.0] {
                let places = Places::random(&mut noise, texels_per_pixel, &opaque);
                for (level, anisotropy) in SimdLevel::available().flat_map(|level| [(level, 1), (level, 8)]) {
                    let read = |texture| {
                        places
                            .read_at(level, texture, anisotropy, u16::MAX)
                            .map(|channel| channel.map(f32::to_bits))
                    };
                    let (found, of_other) = (read(&opaque), read(&other));
                    assert_eq!(found[..3], of_other[..3], "{level} {sampler:?} {anisotropy}");
                    if color_space == ColorSpace::Linear {
                        assert_eq!(found[3], found[0], "{level} {sampler:?} {anisotropy}");
                    }
                }
            }
        }
    }
}

#[test]
fn lanes_do_not_depend_on_their_neighbours() {
    let mut noise = Noise(11);
    for (width, height) in SIZES {
        let texture = noise_texture(width, height, ColorSpace::Srgb, Sampler::default());
        let places = Places::random(&mut noise, 8.0, &texture);
        let together = places.read_at(SimdLevel::best(), &texture, 8, u16::MAX);
        for k in 0..LANES {
            let [uv, dx, dy] = [places.uv, places.dx, places.dy].map(|v| v.map(|plane| plane[k]));
            let alone = Places::same(uv, dx, dy).texel(&texture, 8);
            assert_eq!(alone, std::array::from_fn(|n| together[n][k]), "lane {k}");
        }
    }
}

#[test]
fn a_constant_texture_is_constant_under_every_filter() {
    let mut noise = Noise(5);
    for sampler in samplers() {
        for (width, height) in SIZES {
            for color_space in [ColorSpace::Srgb, ColorSpace::Linear] {
                let texel = [200, 1, 255, 77];
                let texture =
                    Texture::new(image(width, height, |_| texel), color_space, AlphaUse::Data, sampler);
                let color = |code: u8| match color_space {
                    ColorSpace::Srgb => overcoat_core::color::srgb::SRGB8_TO_LINEAR[usize::from(code)],
                    ColorSpace::Linear => f32::from(code) * (1.0 / 255.0),
                };
                let expected = [color(200), color(1), 1.0, 77.0 * (1.0 / 255.0)];
                for texels_per_pixel in [0.1, 5.0] {
                    let places = Places::random(&mut noise, texels_per_pixel, &texture);
                    for anisotropy in [1, 16] {
                        let planes = places.read_at(SimdLevel::best(), &texture, anisotropy, u16::MAX);
                        for k in 0..LANES {
                            for n in 0..4 {
                                // Exact for one probe; a mean over N probes rounds 2 N times.
                                let tolerance = if anisotropy == 1 { 0.0 } else { 1e-6 * expected[n] };
                                assert!((planes[n][k] - expected[n]).abs() <= tolerance, "{sampler:?}");
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Black and white texels in turn.
fn checkerboard(side: u32, color_space: ColorSpace) -> Texture {
    let texel = |k: u32| if (k % side + k / side).is_multiple_of(2) { [255; 4] } else { [0, 0, 0, 255] };
    Texture::new(image(side, side, texel), color_space, AlphaUse::Data, Sampler::default())
}

#[test]
fn a_distant_checkerboard_is_half_as_bright_in_linear_light() {
    let texture = checkerboard(64, ColorSpace::Srgb);
    for anisotropy in [1, 16] {
        let [r, g, b, a] = Places::same([0.37, 0.91], [0.2, 0.0], [0.0, 0.2]).texel(&texture, anisotropy);
        // 188 is the nearest code; averaging codes would give 128, which is 0.216.
        assert!((r - 0.5).abs() < 3e-3, "{r}");
        assert_eq!((r, r, 1.0), (g, b, a));
    }
}

/// A texture of 4 x 1 grey levels and the value read at u.
fn row_at(u: f32, wrap: Wrap, filter: Filter) -> f32 {
    let sampler = Sampler {
        wrap_u: wrap,
        wrap_v: wrap,
        magnification: filter,
        minification: filter,
        mip: MipFilter::None,
    };
    let image = image(4, 1, |k| [[10, 20, 30, 40][k as usize]; 4]);
    let texture = Texture::new(image, ColorSpace::Linear, AlphaUse::Data, sampler);
    Places::same([u, 0.5], [0.01, 0.0], [0.0, 0.01]).texel(&texture, 1)[0] * 255.0
}

#[test]
fn wrap_modes_continue_the_texture_beyond_its_edges() {
    use Filter::{Linear, Nearest};
    use Wrap::{ClampToEdge, MirroredRepeat, Repeat};
    for (wrap, filter, u, expected) in [
        // Half a texel before the first centre, at the edge: the mean of both sides.
        (Repeat, Linear, 0.0, 25.0),
        (Repeat, Linear, 1.0, 25.0),
        (Repeat, Linear, -3.0, 25.0),
        (MirroredRepeat, Linear, 0.0, 10.0),
        (MirroredRepeat, Linear, 1.0, 40.0),
        (ClampToEdge, Linear, 0.0, 10.0),
        (ClampToEdge, Linear, 1.0, 40.0),
        // Centres, outside.
        (Repeat, Linear, 1.125, 10.0),
        (Repeat, Linear, -0.125, 40.0),
        (MirroredRepeat, Linear, 1.125, 40.0),
        (MirroredRepeat, Linear, 1.875, 10.0),
        (MirroredRepeat, Linear, 2.125, 10.0),
        (MirroredRepeat, Linear, -0.375, 20.0),
        (ClampToEdge, Linear, 7.0, 40.0),
        (ClampToEdge, Linear, -7.0, 10.0),
        (Repeat, Linear, 0.25, 15.0),
        (Repeat, Nearest, 0.26, 20.0),
        (Repeat, Nearest, 0.24, 10.0),
        (Repeat, Nearest, 1.0, 10.0),
        (Repeat, Nearest, -1e-9, 40.0),
        (MirroredRepeat, Nearest, 1.01, 40.0),
        (MirroredRepeat, Nearest, -0.01, 10.0),
        (ClampToEdge, Nearest, 1.0, 40.0),
    ] {
        let found = row_at(u, wrap, filter);
        assert!((found - expected).abs() < 1e-4, "{wrap:?} {filter:?} at {u}: {found}, not {expected}");
    }
}

#[test]
fn coordinates_without_bound_read_some_texel() {
    for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
        for filter in [Filter::Nearest, Filter::Linear] {
            for u in [1e9, -1e9, 3e38, -3e38, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 16_777_215.0] {
                let found = row_at(u, wrap, filter);
                assert!((10.0..=40.001).contains(&found), "{wrap:?} {filter:?} {u}: {found}");
            }
        }
    }
    // Likewise footprints.
    let texture = noise_texture(30, 100, ColorSpace::Srgb, Sampler::default());
    for d in [0.0, 1e-30, 1e-44, 1e9, 3e38, f32::INFINITY, f32::NAN] {
        for dy in [[0.0, d], [d, d], [0.0, 0.0], [-d, d]] {
            for anisotropy in [1, 16] {
                let texel = Places::same([0.3, 0.3], [d, 0.0], dy).texel(&texture, anisotropy);
                assert!(texel.iter().all(|c| (0.0..=1.000_001).contains(c)), "{d} {dy:?}: {texel:?}");
            }
        }
    }
}

#[test]
fn the_level_follows_the_larger_derivative() {
    let sampler = Sampler::default();
    let texture = noise_texture(64, 64, ColorSpace::Linear, sampler);
    let mut lambdas = Vec::new();
    for texels in [0.5_f32, 1.0, 2.0, 3.0, 4.0, 64.0, 1000.0] {
        let footprint = [texels / 64.0, 0.0];
        for (dx, dy) in [(footprint, [0.0, 0.001]), ([0.0, 0.001], footprint)] {
            overcoat_core::dispatch!(SimdLevel::best(), l => {
                let splat = |v: [f32; 2]| [l.splat(v[0]), l.splat(v[1])];
                let footprint = Footprint { dx: splat(dx), dy: splat(dy) };
                lambdas.push(Probes::new(l, &texture, &footprint, 1, l.mask(1)).lambda.to_array()[0]);
            });
        }
    }
    let expected = [-1.0, 0.0, 1.0, definition::log2(3.0) as f32, 2.0, 6.0, definition::log2(1000.0) as f32];
    for (found, expected) in lambdas.chunks(2).zip(expected) {
        assert_eq!(found[0], found[1]);
        assert!((found[0] - expected).abs() < 6e-5, "{} {expected}", found[0]);
    }
}

#[test]
fn the_logarithm_is_increasing_and_exact_for_powers_of_two() {
    let log2 =
        |x: f32| overcoat_core::dispatch!(SimdLevel::best(), l => footprint::log2(l.splat(x)).to_array()[0]);
    for k in -126..=127 {
        assert_eq!(log2(f32::from_bits(((k + 127) as u32) << 23)), k as f32);
    }
    let mut last = -1.0;
    for k in 0..=4096 {
        let x = 1.0 + k as f32 / 4096.0;
        let found = log2(x);
        assert!(found >= last && (f64::from(found) - definition::log2(f64::from(x))).abs() < 6e-5, "{x}");
        last = found;
    }
    assert!(log2(0.0) < -100.0);
}

/// Bars along u, as a floor seen at a grazing angle shows them: 16 texels a pixel along v, less than one along u.
#[test]
fn anisotropic_filtering_keeps_what_the_narrow_side_resolves() {
    let sampler = Sampler::default();
    let bars = image(64, 64, |k| if k % 64 / 4 % 2 == 0 { [255; 4] } else { [0; 4] });
    let texture = Texture::new(bars, ColorSpace::Linear, AlphaUse::Data, sampler);
    let contrast = |anisotropy| {
        let at = |u: f32| {
            Places::same([u, 0.4], [1.0 / 64.0, 0.0], [0.0, 16.0 / 64.0]).texel(&texture, anisotropy)[0]
        };
        // The middle of a white and of a black bar.
        at(2.0 / 64.0) - at(6.0 / 64.0)
    };
    let by_anisotropy = [1, 2, 4, 8, 16].map(contrast);
    assert!(by_anisotropy[0] < 0.05, "trilinear blurs it to grey: {by_anisotropy:?}");
    assert!(by_anisotropy[4] > 0.95, "sixteen probes see the bars: {by_anisotropy:?}");
    assert!(by_anisotropy.is_sorted(), "{by_anisotropy:?}");
}

#[test]
fn the_filter_does_not_depend_on_the_roll_of_the_view() {
    let texture = noise_texture(64, 64, ColorSpace::Linear, Sampler::default());
    // The same ellipse by two conjugate diameters that are turned against each other.
    let (long, short) = ([6.0 / 64.0, 3.0 / 64.0], [-0.5 / 64.0, 1.0 / 64.0]);
    let turned = |c: f32, s: f32| {
        let dx = [c * long[0] + s * short[0], c * long[1] + s * short[1]];
        let dy = [c * short[0] - s * long[0], c * short[1] - s * long[1]];
        Places::same([0.4, 0.7], dx, dy).texel(&texture, 16)
    };
    let expected = turned(1.0, 0.0);
    for (c, s) in [(0.8, 0.6), (0.6, -0.8), (0.0, 1.0), (-0.28, 0.96)] {
        let found = turned(c, s);
        for n in 0..4 {
            assert!((found[n] - expected[n]).abs() < 2e-3, "{found:?} {expected:?}");
        }
    }
}

#[test]
fn surfaces_seen_face_on_cost_one_probe() {
    let texture = noise_texture(64, 64, ColorSpace::Linear, Sampler::default());
    let probes = |dx: [f32; 2], dy: [f32; 2], most| {
        overcoat_core::dispatch!(SimdLevel::best(), l => {
            let splat = |v: [f32; 2]| [l.splat(v[0] / 64.0), l.splat(v[1] / 64.0)];
            let footprint = Footprint { dx: splat(dx), dy: splat(dy) };
            let probes = Probes::new(l, &texture, &footprint, most, l.mask(u16::MAX));
            (probes.most, probes.lambda.to_array()[0])
        })
    };
    assert_eq!(probes([2.0, 0.0], [0.0, 2.0], 16).0, 1);
    assert_eq!(probes([1.5, 1.5], [-1.5, 1.4], 16).0, 1);
    assert_eq!(probes([2.0, 0.0], [0.0, 2.4], 16).0, 1);
    assert_eq!(probes([2.0, 0.0], [0.0, 4.0], 16).0, 2);
    // Magnified, however long and thin.
    assert_eq!(probes([0.9, 0.0], [0.0, 0.001], 16).0, 1);
    assert_eq!(probes([32.0, 0.0], [0.0, 2.0], 8).0, 8);
    // Where the limit cuts, the level covers the rest: 32 / 8 texels.
    assert!((probes([32.0, 0.0], [0.0, 2.0], 8).1 - 2.0).abs() < 1e-4);
    // A degenerate footprint is as long as the limit allows.
    assert_eq!(probes([32.0, 0.0], [0.0, 0.0], 16).0, 16);
}
