//! From a frame to files: tone mapping, PNG, OpenEXR, Radiance. Single-threaded, 512 x 512.

use criterion::{Criterion, criterion_group, criterion_main};
use overcoat::color::ToneCurve;
use overcoat::frame::Frame;
use overcoat::frame::{DisplayImage, DisplayOptions};
use overcoat::output::{ExrPrecision, encode_exr, encode_hdr, encode_png};
use overcoat_core::math::lanes::SimdLevel;
use std::hint::black_box;
use std::time::Duration;

/// A lit sphere with some texture that covers half of a transparent picture, as a thumbnail does.
fn frame() -> Frame {
    const SIDE: u32 = 512;
    let pixels = (0..SIDE * SIDE)
        .map(|k| {
            let [x, y] = [k % SIDE, k / SIDE].map(|v| v as f32 / 256.0 - 1.0);
            let z2 = 0.64 - x * x - y * y;
            if z2 <= 0.0 {
                return [0.0; 4];
            }
            let z = z2.sqrt();
            let light = 0.9 * (0.5 * x - 0.6 * y + 0.6 * z).max(0.05);
            let highlight = (0.2 * x - 0.5 * y + 0.9 * z).max(0.0);
            let highlight = 3.0 * highlight * highlight * highlight * highlight;
            // Fine grain from an integer hash.
            let grain = (k.wrapping_mul(0x9e37_79b9) >> 16) as f32 / 65536.0 * 0.04 + 0.96;
            let alpha = (z2 * 40.0).min(1.0);
            [0.8, 0.3, 0.1]
                .map(|c| (c * light * grain + highlight) * alpha)
                .iter()
                .copied()
                .chain([alpha])
                .fold([0.0; 4], |mut out, v| {
                    out.rotate_left(1);
                    out[3] = v;
                    out
                })
        })
        .collect();
    Frame { width: SIDE, height: SIDE, pixels, transmittance: Vec::new(), aovs: Vec::new() }
}

fn output(c: &mut Criterion) {
    let frame = frame();
    let mut group = c.benchmark_group("output 512x512");
    group.sample_size(20).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(1));
    for simd in SimdLevel::available().filter(|&level| level != SimdLevel::Scalar) {
        for &tone_curve in ToneCurve::ALL {
            let options = DisplayOptions::default().with_tone_curve(tone_curve).with_simd(simd);
            group.bench_function(format!("to 8 bits, {tone_curve}, {simd}"), |b| {
                b.iter(|| DisplayImage::new(black_box(&frame), &options));
            });
        }
    }
    for (name, background) in [("rgba", None), ("rgb", Some([255; 3]))] {
        let image = DisplayImage::new(&frame, &DisplayOptions::default().with_background(background));
        group.bench_function(format!("png, {name}"), |b| b.iter(|| encode_png(black_box(&image))));
    }
    for precision in [ExrPrecision::Half, ExrPrecision::Float] {
        group.bench_function(format!("exr, {precision:?}"), |b| {
            b.iter(|| encode_exr(black_box(&frame), precision));
        });
    }
    group.bench_function("hdr", |b| b.iter(|| encode_hdr(black_box(&frame))));
    group.finish();
}

criterion_group!(benches, output);
criterion_main!(benches);
