//! Environment prefilter and lookups per instruction set: `cargo bench -p overcoat-benches --bench environment`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use overcoat::jobs::Jobs;
use overcoat::scene::EquirectImage;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, SimdLevel};
use overcoat_core::math::vec3::Vec3;
use overcoat_stages::light::{EnvironmentLight, PrefilteredEnvironment};
use std::hint::black_box;
use std::sync::Arc;

/// A picture of 1024 x 512 with gradients and a few bright windows.
fn picture() -> Arc<EquirectImage> {
    let pixels = (0..512 * 1024)
        .map(|k| {
            let (x, y) = (k % 1024, k / 1024);
            let window = x / 37 % 9 == 0 && (100..180).contains(&y);
            let base = (512 - y) as f32 / 512.0;
            if window { [12.0, 11.0, 10.0] } else { [base, base * 0.9, 0.2] }
        })
        .collect();
    Arc::new(EquirectImage::new(1024, 512, pixels).expect("sizes agree"))
}

/// Lookups for 4096 fragments of a curved surface.
#[inline(always)]
fn lookups<L: Lanes>(l: L, light: &EnvironmentLight<'_>, roughness: f32, diffuse: bool) -> f32 {
    let mut sum = l.zero();
    for block in 0..4096 / LANES {
        let x = l.lane_indices().to_float() * 0.01 + (block % 16) as f32 * 0.1 - 0.8;
        let z = l.splat(block as f32 / 128.0 - 1.0);
        let direction = Vec3::new(x, l.splat(0.4), z);
        let rgb = if diffuse {
            light.irradiance_over_pi(l, direction)
        } else {
            light.radiance(l, direction, l.splat(roughness))
        };
        sum = sum + rgb.x + rgb.y + rgb.z;
    }
    sum.to_array()[0]
}

fn benches(c: &mut Criterion) {
    let picture = picture();
    let mut group = c.benchmark_group("prefilter 1024x512");
    group.sample_size(10);
    for level in SimdLevel::available().filter(|l| *l != SimdLevel::Scalar) {
        for threads in [1, 2] {
            let jobs = Jobs::new(threads);
            group.bench_function(format!("{level}, {threads} threads"), |b| {
                b.iter(|| PrefilteredEnvironment::new(black_box(&picture), &jobs, level));
            });
        }
    }
    group.finish();

    let bytes = PrefilteredEnvironment::studio().to_bytes();
    c.bench_function("unpack the studio", |b| {
        b.iter(|| PrefilteredEnvironment::from_bytes(black_box(&bytes)));
    });

    let environment = PrefilteredEnvironment::new(&picture, &Jobs::new(0), SimdLevel::best());
    let light = EnvironmentLight::new(&environment, 30.0, 1.0);
    let mut group = c.benchmark_group("lookup");
    group.throughput(Throughput::Elements(4096));
    for level in SimdLevel::available().filter(|l| *l != SimdLevel::Scalar) {
        for (name, roughness, diffuse) in
            [("rough", 0.4, false), ("sharp", 0.03, false), ("diffuse", 0.0, true)]
        {
            group.bench_function(format!("{name}, {level}"), |b| {
                b.iter(|| overcoat_core::dispatch!(level, l => lookups(l, black_box(&light), roughness, diffuse)));
            });
        }
    }
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
