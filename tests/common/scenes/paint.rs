//! Car paint: what is made where the surface is.

use super::Entry;
use super::materials::grid;
use crate::common::stage::{Built, plastic};
use overcoat::scene::{CoatSurface, Flakes, Material};

pub const SCENES: &[Entry] = &[("car-paint", car_paint)];

/// Flakes from a third of a pixel to many to the right; downwards: flakes that cover everything, a fifth of it under a coloured coat, with a film
/// over white and over black, orange peel of that size, and scratches over a fifth of flakes.
fn car_paint() -> Built {
    grid(5, 6, |_, x, y| {
        let row = (y * 5.0 + 0.5) as u32;
        let power = (x * 4.0 + 0.5) as i32;
        let size = 0.01 * (1_u32 << (2 * power) as u32) as f32 / 4.0;
        let flakes = Flakes { share: 1.0, size, ..Flakes::default() };
        let mut material = Material { coat: 1.0, coat_roughness: 0.03, ..plastic(0.02, 0.03, 0.06, 0.5) };
        let lobes = &mut material.lobes;
        match row {
            0 => lobes.flakes = flakes,
            1 => {
                lobes.flakes = Flakes { share: 0.2, spread: 0.7, ..flakes };
                lobes.coat.color.factor = [0.9, 0.3, 0.1];
            }
            2 | 3 => {
                let film = Flakes { color: [0.05; 3], film_thickness: 140.0, transparency: 1.0, ..flakes };
                lobes.flakes = film;
            }
            4 => {
                lobes.coat_surface =
                    CoatSurface { peel: 0.04, peel_size: 2.0 * size, ..CoatSurface::default() }
            }
            _ => {
                lobes.flakes = Flakes { share: 0.2, ..flakes };
                lobes.coat_surface =
                    CoatSurface { scratches: 0.1, scratch_length: 4.0 * size, ..CoatSurface::default() };
            }
        }
        if row == 2 {
            material.base_color = [0.8, 0.8, 0.8, 1.0];
        }
        Ok(material)
    })
}
