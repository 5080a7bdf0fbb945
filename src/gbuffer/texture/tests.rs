//! The lanes against a plain definition in double precision, and what must hold of any filter.

use super::*;
use crate::math::lanes::{LANES, SimdLevel};
use crate::scene::{AlphaUse, Filter, Image, Sampler, Wrap};
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
    fn read<L: Lanes>(&self, l: L, texture: &Texture, anisotropy: u32, active: u16) -> [[f32; LANES]; 5] {
        let load = |v: &[[f32; LANES]; 2]| [l.load(&v[0]), l.load(&v[1])];
        let footprint = Footprint { dx: load(&self.dx), dy: load(&self.dy) };
        let active = l.mask(active);
        let [r, g, b, a] = sample(l, texture, load(&self.uv), &footprint, anisotropy, active);
        let alpha = sample_alpha(l, texture, load(&self.uv), &footprint, anisotropy, active);
        [r, g, b, a, alpha].map(Float::to_array)
    }
    fn read_at(
        &self,
        level: SimdLevel,
        texture: &Texture,
        anisotropy: u32,
        active: u16,
    ) -> [[f32; LANES]; 5] {
        crate::dispatch!(level, l => self.read(l, texture, anisotropy, active))
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
    use crate::color::srgb::SRGB8_TO_LINEAR;
    use crate::math::double;

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
