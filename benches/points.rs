//! Clouds of one and of ten million points: reading a binary PLY file, and the first picture of it at 512 x 512, for which
//! sizes and normals are found; then the next picture of the same cloud.
//!
//! `cargo bench -p overcoat-benches --bench points`; ten million points take about 1 GB.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, Format, NoResolver, load_bytes};
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{Framing, Scene};
use std::hint::black_box;

/// A ball with bumps, its points at random: positions and 8-bit colours.
fn ply(count: u32) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    )
    .into_bytes();
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    for _ in 0..count {
        let p = loop {
            let p = [next(), next(), next()];
            let square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            if square > 0.01 && square < 1.0 {
                break p.map(|v| v / square.sqrt());
            }
        };
        let bump = 1.0 + 0.1 * p[0] * p[1] * p[2];
        bytes.extend(p.iter().flat_map(|v| (v * bump).to_le_bytes()));
        bytes.extend(p.map(|v| (v * 100.0 + 128.0) as u8));
    }
    bytes
}

fn load(bytes: &[u8], jobs: &Jobs) -> Scene {
    let context = Context { resolver: &NoResolver, limits: &Limits::default(), jobs };
    load_bytes(bytes, Some(Format::Ply), &context).expect("it is a cloud").scene
}

fn points(criterion: &mut Criterion) {
    let options = RenderOptions::draft(512, 512);
    for millions in [1, 10] {
        let bytes = ply(millions * 1_000_000);
        let mut renderer = Renderer::new(0);
        let mut group = criterion.benchmark_group(format!("points/{millions} million"));
        group.sample_size(10).throughput(Throughput::Elements(u64::from(millions) * 1_000_000));
        group.bench_function("load", |bencher| bencher.iter(|| load(black_box(&bytes), renderer.jobs())));
        let scene = load(&bytes, renderer.jobs());
        let view = Framing::default().camera(&scene);
        group.bench_function("next picture", |bencher| {
            bencher.iter(|| {
                let frame = renderer.render(&scene, &view, &options).expect("within limits").frame;
                renderer.recycle(frame);
            });
        });
        drop(scene);
        group.bench_function("first picture", |bencher| {
            bencher.iter_batched(
                || load(&bytes, &Jobs::new(0)),
                |scene| {
                    let frame = renderer.render(&scene, &view, &options).expect("within limits").frame;
                    renderer.recycle(frame);
                },
                BatchSize::PerIteration,
            );
        });
    }
}

criterion_group!(benches, points);
criterion_main!(benches);
