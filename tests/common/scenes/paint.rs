//! Car paint: what is made where the surface is.

use super::Entry;
use super::materials::grid;
use crate::common::stage::{Built, plastic};
use overcoat::scene::{CoatSurface, Flakes};

pub const SCENES: &[Entry] = &[("car-paint", car_paint)];

/// Flakes from a third of a pixel to many to the right; downwards: flakes that cover everything, a fifth of it under a coloured coat, with a film
/// over white and over black, orange peel of that size, and scratches over a fifth of flakes.
fn car_paint() -> Built {
    grid(5, 6, |_, x, y| {
        let row = (y * 5.0 + 0.5) as u32;
        let power = (x * 4.0 + 0.5) as i32;
        let size = 0.01 * (1_u32 << (2 * power) as u32) as f32 / 4.0;
        let flakes = Flakes::default().with(|f| {
            f.share = 1.0;
            f.size = size;
        });
        let mut material = plastic(0.02, 0.03, 0.06, 0.5).with(|m| {
            m.coat = 1.0;
            m.coat_roughness = 0.03;
        });
        let lobes = &mut material.lobes;
        match row {
            0 => lobes.flakes = flakes,
            1 => {
                lobes.flakes = flakes.with(|f| {
                    f.share = 0.2;
                    f.spread = 0.7;
                });
                lobes.coat.color.factor = [0.9, 0.3, 0.1];
            }
            2 | 3 => {
                let film = flakes.with(|f| {
                    f.color = [0.05; 3];
                    f.film_thickness = 140.0;
                    f.transparency = 1.0;
                });
                lobes.flakes = film;
            }
            4 => {
                lobes.coat_surface = CoatSurface::default().with(|c| {
                    c.peel = 0.04;
                    c.peel_size = 2.0 * size;
                })
            }
            _ => {
                lobes.flakes = flakes.with(|f| f.share = 0.2);
                lobes.coat_surface = CoatSurface::default().with(|c| {
                    c.scratches = 0.1;
                    c.scratch_length = 4.0 * size;
                });
            }
        }
        if row == 2 {
            material.base_color = [0.8, 0.8, 0.8, 1.0];
        }
        Ok(material)
    })
}
