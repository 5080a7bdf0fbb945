//! Colour encoding, mip levels and texture filtering.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use overcoat::color::srgb;
use overcoat::scene::{AlphaUse, ColorSpace, Image, Sampler, Texture};
use overcoat_core::math::lanes::{Float, LANES, Lanes, SimdLevel};
use overcoat_stages::gbuffer::texture::{Footprint, MAX_TOGETHER, sample_together};
use std::hint::black_box;
use std::sync::Arc;

/// Numbers in [0, 1), the same in every run.
fn noise() -> impl FnMut() -> f32 {
    let mut state = 1_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    }
}

fn encode(c: &mut Criterion) {
    let mut group = c.benchmark_group("srgb-encode-512x512");
    let mut next = noise();
    let pixels: Vec<[f32; 4]> = (0..512 * 512).map(|_| std::array::from_fn(|_| next())).collect();
    let mut out = vec![[0; 4]; pixels.len()];
    group.throughput(Throughput::Elements(pixels.len() as u64));
    for level in SimdLevel::available().filter(|&level| level != SimdLevel::Scalar) {
        group.bench_function(level.name(), |b| {
            b.iter(|| srgb::encode_srgb8(level, black_box(&pixels), &mut out))
        });
    }
    group.bench_function("one by one", |b| {
        b.iter(|| {
            for (from, to) in black_box(&pixels).iter().zip(&mut out) {
                *to = from.map(srgb::linear_to_srgb8);
            }
        });
    });
}

fn picture(side: u32) -> Arc<Image> {
    let mut next = noise();
    let texels = (0..side * side).map(|_| std::array::from_fn(|_| (next() * 255.0) as u8)).collect();
    Arc::new(Image::new(side, side, texels).expect("the size fits"))
}

fn mips(c: &mut Criterion) {
    let mut group = c.benchmark_group("mip-chain");
    group.sample_size(10);
    for (name, side, color_space, alpha) in [
        ("2048 sRGB", 2048, ColorSpace::Srgb, AlphaUse::Data),
        ("2048 linear", 2048, ColorSpace::Linear, AlphaUse::Data),
        ("2048 sRGB coverage", 2048, ColorSpace::Srgb, AlphaUse::Coverage),
        ("2048 sRGB mask", 2048, ColorSpace::Srgb, AlphaUse::mask(0.5)),
        ("2047 sRGB", 2047, ColorSpace::Srgb, AlphaUse::Data),
    ] {
        let image = picture(side);
        group.throughput(Throughput::Elements(u64::from(side * side)));
        group.bench_function(name, |b| {
            b.iter(|| Texture::new(black_box(&image).clone(), color_space, alpha, Sampler::default()));
        });
    }
}

/// Reads of neighbouring fragments, sixteen at a time, walking over the textures.
#[inline(always)]
fn walk<L: Lanes>(l: L, textures: &[&Texture], across: f32, down: f32, anisotropy: u32) -> f32 {
    let texel = 1.0 / textures[0].image().width() as f32;
    let (across, down) = (across * texel, down * texel);
    let footprint = Footprint { dx: [l.splat(across), l.zero()], dy: [l.zero(), l.splat(down)] };
    let x: [f32; LANES] = std::array::from_fn(|k| (k % 4) as f32);
    let y: [f32; LANES] = std::array::from_fn(|k| (k / 4) as f32);
    let (x, y) = (l.load(&x) * across, l.load(&y) * down);
    let mut sum = l.zero();
    let mut out = [[l.zero(); 4]; MAX_TOGETHER];
    for k in 0..BATCHES {
        let (column, row) = ((k % 64) as f32 * 4.0, (k / 64) as f32 * 4.0);
        let uv = [x + column * across, y + (row * down + 0.3)];
        let out = &mut out[..textures.len()];
        sample_together(l, textures, &uv, &footprint, anisotropy, l.mask(u16::MAX), out);
        for [r, g, b, a] in out {
            sum = sum + *r + *g + *b + *a;
        }
    }
    sum.to_array()[0]
}

/// Batches of sixteen fragments of one measurement.
const BATCHES: u32 = 4096;

fn filter(c: &mut Criterion) {
    use ColorSpace::{Linear, Srgb};
    for (name, color_spaces, across, down) in [
        ("magnified sRGB", &[Srgb][..], 0.3, 0.3),
        ("trilinear sRGB", &[Srgb], 1.5, 1.5),
        ("trilinear linear", &[Linear], 1.5, 1.5),
        ("trilinear sRGB and two linear", &[Srgb, Linear, Linear], 1.5, 1.5),
        ("anisotropic 8x sRGB", &[Srgb], 1.5, 12.0),
        ("anisotropic 8x linear", &[Linear], 1.5, 12.0),
        ("anisotropic 8x sRGB and two linear", &[Srgb, Linear, Linear], 1.5, 12.0),
    ] {
        let mut group = c.benchmark_group(name);
        let texture =
            |&color_space| Texture::new(picture(1024), color_space, AlphaUse::Data, Sampler::default());
        let textures: Vec<Texture> = color_spaces.iter().map(texture).collect();
        let textures: Vec<&Texture> = textures.iter().collect();
        group.throughput(Throughput::Elements(u64::from(BATCHES) * LANES as u64));
        for level in SimdLevel::available().filter(|&level| level != SimdLevel::Scalar) {
            group.bench_function(level.name(), |b| {
                b.iter(
                    || overcoat_core::dispatch!(level, l => walk(l, &textures, black_box(across), down, 8)),
                );
            });
        }
    }
}

criterion_group!(benches, encode, mips, filter);
criterion_main!(benches);
