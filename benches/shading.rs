//! Speed of shading and of the functions under it, per instruction set: time per element is nanoseconds per
//! fragment or per function value, on one core.
//!
//! `cargo bench -p overcoat-benches --bench shading -- urp/desktop` runs one group.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use overcoat_core::math::lanes::{Float, LANES, Lanes, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::coat::urp::{self, Coat, Reflectance, SurfaceData, UrpVersion};
use std::hint::black_box;
use std::time::Duration;

/// Vectors in a pass; all of their data stay in the first-level cache.
const VECTORS: usize = 16;

/// Numbers of one fragment.
const PLANES: usize = 12;

type Planes = [[f32; LANES]; PLANES];

/// Fragments with all their numbers in 0 to 1.
fn fragments() -> Vec<Planes> {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    (0..VECTORS).map(|_| std::array::from_fn(|_| std::array::from_fn(|_| next()))).collect()
}

/// One coated surface under one light and a constant environment.
#[inline(always)]
fn shade<L: Lanes>(l: L, version: UrpVersion, planes: &Planes, coated: bool) -> V3<L> {
    let data = SurfaceData {
        albedo: Vec3::new(l.load(&planes[0]), l.load(&planes[1]), l.load(&planes[2])),
        reflectance: Reflectance::Metallic {
            metallic: l.load(&planes[3]),
            dielectric_f0: Vec3::splat(l, [urp::DIELECTRIC_F0; 3]),
        },
        smoothness: l.load(&planes[4]),
        coat: if coated {
            Some(Coat { mask: l.load(&planes[5]), smoothness: l.load(&planes[6]), normal: None })
        } else {
            None
        },
    };
    let normal = Vec3::new(l.load(&planes[7]), l.load(&planes[8]), l.load(&planes[9])).normalize();
    let view = Vec3::new(l.load(&planes[10]), l.load(&planes[11]), l.load(&planes[9])).normalize();
    let surface = urp::surface(l, version, &data, normal, view);
    let light = Vec3::splat(l, [0.6, 0.0, 0.8]);
    let one = l.splat(1.0);
    let direct = urp::direct(l, &surface, light, Vec3::uniform(one));
    let indirect = urp::indirect(
        l,
        &surface,
        Vec3::uniform(one),
        #[inline(always)]
        |_| Vec3::uniform(one),
        one,
    );
    direct + indirect
}

#[inline(always)]
fn pass<L: Lanes>(l: L, version: UrpVersion, fragments: &[Planes], coated: bool) -> [f32; LANES] {
    let mut sum = l.zero();
    for planes in fragments {
        let Vec3 { x: r, y: g, z: b } = shade(l, version, planes, coated);
        sum = sum + (r + g + b);
    }
    sum.to_array()
}

fn bench_urp(c: &mut Criterion) {
    let fragments = fragments();
    let cases = [
        ("urp/desktop", UrpVersion::Desktop, true),
        ("urp/mobile", UrpVersion::Mobile, true),
        ("urp/desktop without coat", UrpVersion::Desktop, false),
    ];
    for (name, version, coated) in cases {
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements((VECTORS * LANES) as u64));
        for level in SimdLevel::available() {
            group.bench_function(BenchmarkId::from_parameter(level), |b| {
                b.iter(|| {
                    let fragments = black_box(&fragments);
                    overcoat_core::dispatch!(level, l => pass(l, version, fragments, coated))
                });
            });
        }
        group.finish();
    }
}

macro_rules! function {
    ($c:expr, $inputs:expr, $name:literal, |$l:ident, $x:ident, $y:ident| $body:expr) => {
        let mut group = $c.benchmark_group(concat!("math/", $name));
        group.throughput(Throughput::Elements((VECTORS * LANES * PLANES / 2) as u64));
        for level in SimdLevel::available() {
            group.bench_function(BenchmarkId::from_parameter(level), |b| {
                b.iter(|| {
                    let inputs: &[Planes] = black_box($inputs);
                    overcoat_core::dispatch!(level, $l => {
                        let mut sum = $l.zero();
                        for planes in inputs {
                            for pair in planes.chunks_exact(2) {
                                let ($x, $y) = ($l.load(&pair[0]), $l.load(&pair[1]));
                                sum = sum + $body;
                            }
                        }
                        sum.to_array()
                    })
                });
            });
        }
        group.finish();
    };
}

fn bench_math(c: &mut Criterion) {
    use overcoat_core::math;
    let inputs = &fragments();
    function!(c, inputs, "exp", |l, x, y| math::exp(l, x - y));
    function!(c, inputs, "exp_transmittance", |l, x, y| math::exp_transmittance(l, x - y));
    function!(c, inputs, "exp2", |l, x, y| math::exp2(l, x - y));
    function!(c, inputs, "ln", |l, x, y| math::ln(l, x + y));
    function!(c, inputs, "log2", |l, x, y| math::log2(l, x + y));
    function!(c, inputs, "pow", |l, x, y| math::pow(l, x, y));
    function!(c, inputs, "sin", |l, x, y| math::sin(l, x - y));
    function!(c, inputs, "acos", |l, x, y| math::acos(l, x - y));
    function!(c, inputs, "atan2", |l, x, y| math::atan2(l, x, y));
}

/// Short runs: a dozen groups times the instruction sets.
fn config() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .sample_size(30)
}

criterion_group!(name = benches; config = config(); targets = bench_urp, bench_math);
criterion_main!(benches);
