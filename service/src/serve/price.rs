//! Price of a picture in units, by its options alone: what is asked for is known before a model is read.
//!
//! A unit is about 10 ms of one processor. The terms were fitted to the processor time of pictures of three models of this repository
//! (2,000 to 97,000 triangles) of 64 to 1024 pixels in all tiers; the book has them side by side.
//! Models differ by more than a factor of ten at one size, which no price by options can know.

use overcoat::RenderOptions;

/// Price of a description of a model, and of what every picture has: reading the model and starting to draw.
pub const BASE: u64 = 5;

/// Hundredths of a unit.
const UNIT: u64 = 100;
/// Pixels that the terms of pixels are for: 256 x 256.
const PIXELS: u64 = 1 << 16;
/// Texels that the term of depth maps is for.
const TEXELS: u64 = 1 << 20;

/// Price of a picture with so many lamps.
#[must_use]
pub fn price(options: &RenderOptions, lamps: usize) -> u64 {
    let visibility = options.visibility;
    let [maps, side, rays] = [visibility.maps, visibility.map_size, visibility.rays].map(u64::from);
    let [samples, rate] = [options.samples, options.shading_rate].map(u64::from);
    let lamps = lamps as u64;
    // Rays are for the light that maps let through.
    let rays = if maps == 0 || rays == 0 { 0 } else { 900 + 25 * rays };
    let of_pixel = (120 + 4 * samples + 3 * maps + 150 * (rate.max(1) - 1) + rays)
        .saturating_add(lamps.saturating_mul(15));
    let pixels = u64::from(options.width) * u64::from(options.height);
    let of_picture = pixels.saturating_mul(of_pixel) / PIXELS;
    let of_maps = (200 * maps).saturating_mul(side * side) / TEXELS;
    let of_lamps = lamps.saturating_mul(20);
    let all = of_picture.saturating_add(of_maps).saturating_add(of_lamps).saturating_add(BASE * UNIT);
    all.div_ceil(UNIT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat::render::{Quality, Visibility};

    fn of(size: u32, quality: Quality, samples: u32) -> RenderOptions {
        RenderOptions::new(size, size).with_samples(samples).with_quality(quality)
    }

    /// The table of the documentation has these.
    #[test]
    fn prices_are_those_of_the_table() {
        let table = include_str!("../../../docs/src/service.md");
        for size in [64, 256, 512, 1024, 2048] {
            let prices = Quality::ALL.iter().map(|quality| price(&of(size, *quality, 8), 0).to_string());
            let row = format!("| {size} | {} |", prices.collect::<Vec<_>>().join(" | "));
            assert!(table.contains(&row), "{row}");
        }
    }

    #[test]
    fn more_of_anything_is_dearer() {
        let options = of(512, Quality::Good, 8);
        let base = price(&options, 0);
        let with = |change: &dyn Fn(&mut RenderOptions)| {
            let mut dearer = options.clone();
            change(&mut dearer);
            price(&dearer, 0)
        };
        for dearer in [
            with(&|options| options.width = 1024),
            with(&|options| options.samples = 16),
            with(&|options| options.shading_rate = 8),
            with(&|options| options.visibility = Visibility::new(256, 256, 4)),
            with(&|options| options.visibility = Visibility::new(64, 512, 4)),
            with(&|options| options.visibility = Visibility::new(64, 256, 16)),
        ] {
            assert!(dearer > base, "{dearer}");
        }
        assert!(price(&options, 1) > base);
        // Rays without maps are none.
        let none = options.clone().with_visibility(Visibility::NONE);
        assert_eq!(price(&none.clone().with_visibility(Visibility::new(0, 0, 256)), 0), price(&none, 0));
        assert_eq!(
            (price(&of(1, Quality::Draft, 1), 0), price(&of(32, Quality::Draft, 1), 0)),
            (BASE, BASE + 1)
        );
        // Nothing overflows.
        let mut dearest =
            RenderOptions::new(u32::MAX, u32::MAX).with_visibility(Visibility::new(256, 2048, 256));
        (dearest.samples, dearest.shading_rate) = (16, 16);
        assert!(price(&dearest, usize::MAX) > 1 << 40);
    }
}
