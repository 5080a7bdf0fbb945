//! A figure: the right ball, the wrong one, and what has become of the light, side by side.

use super::ball::{Ball, SIDE};
use overcoat::color::srgb::linear_to_srgb8;
use overcoat::frame::DisplayImage;
use overcoat::limits::Limits;
use overcoat::output::{OutputFormat, OutputOptions, encode_image};
use overcoat_golden::compress::{Effort, compress_png};
use overcoat_lab::lab::luminance;

const GAP: usize = 4;
const BEHIND: [u8; 4] = [128, 128, 128, 255];

/// Relative change that has the full colour.
const FULL: f64 = 0.5;

pub struct Figure {
    pub name: &'static str,
    /// As a file.
    pub png: Vec<u8>,
    /// Luminance over the whole ball, then of single pixels: least and most. Wrong over right, less 1.
    pub change: [f64; 3],
}

impl Figure {
    pub fn new(name: &'static str, ball: &Ball, right: Vec<[f32; 3]>, wrong: Vec<[f32; 3]>) -> Self {
        let mut pixels = vec![BEHIND; width() * SIDE];
        let (mut sums, mut least, mut most) = ([0.0; 2], f64::MAX, f64::MIN);
        for (k, (right, wrong)) in ball.coarse(&right).into_iter().zip(ball.coarse(&wrong)).enumerate() {
            let (Some(right), Some(wrong)) = (right, wrong) else { continue };
            let [a, b] = [right, wrong].map(luminance);
            let off = b / a - 1.0;
            (least, most) = (least.min(off), most.max(off));
            sums = [sums[0] + a, sums[1] + b];
            for (column, color) in [shown(right), shown(wrong), tint(off)].into_iter().enumerate() {
                pixels[k / SIDE * width() + column * (SIDE + GAP) + k % SIDE] = color;
            }
        }
        Self { name, png: png(pixels), change: [sums[1] / sums[0] - 1.0, least, most] }
    }

    /// In a line.
    pub fn numbers(&self) -> String {
        let [all, least, most] = self.change.map(said);
        format!("Light of the whole ball: {all}; of its points: {least} to {most}.")
    }

    /// The change of the whole ball.
    pub fn whole(&self) -> String {
        said(self.change[0])
    }
}

fn png(pixels: Vec<[u8; 4]>) -> Vec<u8> {
    let image = DisplayImage { width: width() as u32, height: SIDE as u32, pixels };
    let png = encode_image(&image, OutputFormat::Png, &OutputOptions::default()).unwrap();
    compress_png(&png, Effort::Strongest, &Limits::default()).unwrap()
}

fn said(change: f64) -> String {
    // Many times over is no number of percent.
    if change < 10.0 { format!("{:+.1} %", 100.0 * change) } else { format!("{:.0} times", change + 1.0) }
}

fn width() -> usize {
    3 * SIDE + 2 * GAP
}

/// In steps of 4 of 255: the page carries its pictures, and they are a third of the bytes.
fn shown(linear: [f64; 3]) -> [u8; 4] {
    let [r, g, b] = linear.map(|c| linear_to_srgb8(c as f32).saturating_add(2) & 0xfc);
    [r, g, b, 255]
}

/// White where nothing has changed, red where there is more light, blue where there is less.
fn tint(off: f64) -> [u8; 4] {
    let t = (off.abs() / FULL).clamp(0.0, 1.0);
    // In steps, too.
    let t = (t * 32.0).round() / 32.0;
    let fade = |to: f64| (255.0 + (to - 255.0) * t) as u8;
    let to = if off >= 0.0 { [190.0, 20.0, 30.0] } else { [10.0, 70.0, 170.0] };
    let [r, g, b] = to.map(fade);
    [r, g, b, 255]
}
