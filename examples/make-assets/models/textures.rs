//! Tileable textures.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::angle;
use super::model::Image;
use super::random::{Random, hash};

/// Every texture by its file stem.
pub fn all() -> BTreeMap<&'static str, Image> {
    BTreeMap::from([
        ("checker", checker()),
        ("flakes-normal", flakes(256, 64)),
        ("carbon-color", carbon_color()),
        ("carbon-normal", carbon_normal()),
        ("brushed-roughness", brushed()),
        ("scratches-roughness", scratches_roughness()),
        ("scratches-normal", scratches_normal()),
    ])
}

/// 0 to 1 as a byte.
pub fn byte(value: f64) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5).floor() as u8
}

/// A grey pixel.
fn grey(value: f64) -> [u8; 3] {
    [byte(value); 3]
}

/// A tangent-space normal.
pub fn normal(direction: DVec3) -> [u8; 3] {
    direction.normalize().to_array().map(|c| byte(c * 0.5 + 0.5))
}

/// glTF's packing of a dielectric's or coat's roughness: green, with metallic 1 in blue.
fn roughness(value: f64) -> [u8; 3] {
    [255, byte(value), 255]
}

/// 8 x 8 squares with a thin lighter line between them, sRGB.
fn checker() -> Image {
    Image::draw(256, |u, v| {
        let (x, y) = (u * 8.0, v * 8.0);
        let edge = |t: f64| (t - t.floor() - 0.5).abs() > 0.47;
        let dark = (x.floor() + y.floor()) as i64 % 2 == 0;
        match (edge(x) || edge(y), dark) {
            (true, _) => grey(0.62),
            (false, true) => grey(0.30),
            (false, false) => grey(0.80),
        }
    })
}

/// Metal flakes: Voronoi cells on a torus, each with one random tilt.
pub fn flakes(size: u32, cells: i64) -> Image {
    let site = |column: i64, row: i64| {
        let cell = (row.rem_euclid(cells) * cells + column.rem_euclid(cells)) as u64;
        let mut random = Random::new(hash(cell, 1));
        (DVec2::new(column as f64 + random.unit(), row as f64 + random.unit()), cell)
    };
    Image::draw(size, |u, v| {
        let point = DVec2::new(u, v) * cells as f64;
        let (column, row) = (point.x.floor() as i64, point.y.floor() as i64);
        let mut best = (f64::MAX, 0);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let (centre, cell) = site(column + dx, row + dy);
                let distance = centre.distance_squared(point);
                if distance < best.0 {
                    best = (distance, cell);
                }
            }
        }
        let mut random = Random::new(hash(best.1, 2));
        let tilt = 0.28 * random.unit().sqrt();
        let direction = angle::unit(random.unit()) * tilt;
        normal(DVec3::new(direction.x, direction.y, 1.0))
    })
}

/// A point of a 2 x 2 twill: (place across the tow from -1 to 1, place along its float from -1 to 1, warp or weft).
pub fn twill(u: f64, v: f64) -> (f64, f64, bool) {
    const TOWS: f64 = 8.0;
    let (x, y) = (u * TOWS, v * TOWS);
    let (column, row) = (x.floor(), y.floor());
    let phase = (column + row).rem_euclid(4.0);
    let across = |t: f64| (t - t.floor()) * 2.0 - 1.0;
    // A warp tow lies on top for two rows, then dips below for two; so does the weft, shifted by two.
    if phase < 2.0 {
        (across(x), across(y) * 0.5 + if phase < 1.0 { -0.5 } else { 0.5 }, true)
    } else {
        (across(y), across(x) * 0.5 + if phase < 3.0 { -0.5 } else { 0.5 }, false)
    }
}

/// Carbon weave, sRGB: tows of two tones, darker where they dive.
pub fn carbon_color() -> Image {
    Image::draw(256, |u, v| {
        let (across, along, warp) = twill(u, v);
        let fibre =
            (hash(((if warp { u } else { v }) * 256.0) as u64, u64::from(warp)) % 1000) as f64 / 1000.0;
        let tone = if warp { 0.27 } else { 0.20 };
        let shade = 1.0 - 0.45 * along * along * along * along - 0.3 * across * across;
        grey(tone * shade + 0.03 * fibre)
    })
}

/// Carbon weave, normals of bulging tows.
pub fn carbon_normal() -> Image {
    Image::draw(256, |u, v| {
        let (across, along, warp) = twill(u, v);
        let (a, b) = (across * 0.45, along * along * along * 0.5);
        // v runs downwards, +Y of the normal upwards.
        if warp { normal(DVec3::new(a, -b, 1.0)) } else { normal(DVec3::new(b, -a, 1.0)) }
    })
}

/// Brushed metal: streaks along u whose roughness varies.
fn brushed() -> Image {
    const SIZE: usize = 256;
    let mut rows = vec![0.0; SIZE * SIZE];
    let mut random = Random::new(7);
    for _ in 0..9000 {
        let (row, start) = (random.below(SIZE as u64) as usize, random.below(SIZE as u64) as usize);
        let length = 20 + random.below(160) as usize;
        let strength = random.unit() - 0.5;
        for step in 0..length {
            let fade = 1.0 - (2.0 * step as f64 / length as f64 - 1.0).abs();
            rows[row * SIZE + (start + step) % SIZE] += strength * fade * 0.22;
        }
    }
    Image::draw(SIZE as u32, |u, v| {
        let index = (v * SIZE as f64) as usize * SIZE + (u * SIZE as f64) as usize;
        roughness(0.36 + rows[index])
    })
}

/// A straight scratch on the torus.
struct Scratch {
    start: DVec2,
    direction: DVec2,
    length: f64,
    half_width: f64,
}

impl Scratch {
    /// Signed place across the scratch from -1 to 1, if `point` lies on it.
    fn across(&self, point: DVec2) -> Option<f64> {
        let offset = point - self.start;
        let offset = offset - (offset + DVec2::splat(0.5)).floor();
        let along = offset.dot(self.direction);
        let across = offset.dot(self.direction.perp()) / self.half_width;
        (along.abs() < 0.5 * self.length && across.abs() < 1.0).then_some(across)
    }
}

fn scratches() -> Vec<Scratch> {
    let mut random = Random::new(11);
    (0..90)
        .map(|_| Scratch {
            start: DVec2::new(random.unit(), random.unit()),
            direction: angle::unit(random.unit()),
            length: 0.08 + 0.5 * random.unit() * random.unit(),
            half_width: 0.0022 + 0.002 * random.unit(),
        })
        .collect()
}

/// Scratches in a polished surface, as roughness.
fn scratches_roughness() -> Image {
    let scratches = scratches();
    Image::draw(512, |u, v| {
        let point = DVec2::new(u, v);
        let worn = scratches.iter().any(|s| s.across(point).is_some());
        roughness(if worn { 0.55 } else { 0.12 })
    })
}

/// Scratches in a polished surface, as V-shaped grooves.
fn scratches_normal() -> Image {
    let scratches = scratches();
    Image::draw(512, |u, v| {
        let point = DVec2::new(u, v);
        let mut slope = DVec2::ZERO;
        for scratch in &scratches {
            if let Some(across) = scratch.across(point) {
                slope += scratch.direction.perp() * if across < 0.0 { 0.35 } else { -0.35 };
            }
        }
        normal(DVec3::new(slope.x, -slope.y, 1.0))
    })
}
