//! Colour encoding, mip levels and texture filtering.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use overcoat::color::srgb;
use overcoat::math::lanes::SimdLevel;
use std::hint::black_box;

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

criterion_group!(benches, encode);
criterion_main!(benches);
