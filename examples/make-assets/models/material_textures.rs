//! Tileable textures of the built-in materials: small, since they are part of the program. Few tones and little
//! noise keep the files small.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::angle;
use super::model::Image;
use super::random::{Random, hash};
use super::textures::{byte, carbon_color, carbon_normal, flakes, normal, twill};

/// Every texture by its file stem.
pub fn all() -> BTreeMap<&'static str, Image> {
    BTreeMap::from([
        ("brushed-normal", brushed()),
        ("carbon-anisotropy", carbon_anisotropy()),
        ("carbon-color", carbon_color()),
        ("carbon-normal", carbon_normal()),
        ("flakes-normal", flakes(128, 44)),
        ("frost-normal", relief(128, 0.9, |u, v| noise(u, v, 24, 3) + 0.5 * noise(u, v, 48, 4))),
        ("leaf-color", leaf_color()),
        ("leaf-normal", relief(128, 1.0, wrinkles)),
        ("oak-color", oak()),
        ("skin-normal", relief(128, 0.7, pores)),
        ("stone-color", stone()),
        ("stone-normal", relief(128, 2.2, |u, v| fractal(u, v, 6, 21))),
        ("stone-wet", stone_wet()),
    ])
}

/// Values of a lattice of `cells` x `cells` random numbers from 0 to 1, smoothly between.
fn noise(u: f64, v: f64, cells: i64, seed: u64) -> f64 {
    stretched_noise(u, v, [cells, cells], seed)
}

/// The same with another number of cells each way.
fn stretched_noise(u: f64, v: f64, cells: [i64; 2], seed: u64) -> f64 {
    let (x, y) = (u * cells[0] as f64, v * cells[1] as f64);
    let (column, row) = (x.floor(), y.floor());
    let at = |dx: i64, dy: i64| {
        let column = (column as i64 + dx).rem_euclid(cells[0]);
        let row = (row as i64 + dy).rem_euclid(cells[1]);
        Random::new(hash((row * cells[0] + column) as u64, seed)).unit()
    };
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(x - column), ease(y - row));
    let along = |dy: i64| at(0, dy) * (1.0 - s) + at(1, dy) * s;
    along(0) * (1.0 - t) + along(1) * t
}

/// Four octaves, 0 to 1.
fn fractal(u: f64, v: f64, cells: i64, seed: u64) -> f64 {
    let octave = |k: u32| noise(u, v, cells << k, seed + u64::from(k)) / f64::from(1 << k);
    (octave(0) + octave(1) + octave(2) + octave(3)) / 1.875
}

/// Normals of a height field; `height` is in widths of the picture times 1/32.
fn relief(size: u32, scale: f64, height: impl Fn(f64, f64) -> f64) -> Image {
    let step = 1.0 / f64::from(size);
    Image::draw(size, |u, v| {
        let wrap = |t: f64| t - t.floor();
        let slope = |du: f64, dv: f64| {
            let there = height(wrap(u + du * step), wrap(v + dv * step));
            let back = height(wrap(u - du * step), wrap(v - dv * step));
            (back - there) / (64.0 * step)
        };
        // v runs downwards, +Y of the normal upwards.
        normal(DVec3::new(slope(1.0, 0.0) * scale, -slope(0.0, 1.0) * scale, 1.0))
    })
}

/// A colour between two, in `tones` steps.
fn between(dark: [f64; 3], light: [f64; 3], t: f64, tones: f64) -> [u8; 3] {
    let t = (t.clamp(0.0, 1.0) * tones + 0.5).floor() / tones;
    std::array::from_fn(|c| byte((dark[c] + (light[c] - dark[c]) * t) / 255.0))
}

/// Brushed along u: grooves that lean across only, each a few centimetres long.
fn brushed() -> Image {
    const SIZE: usize = 128;
    let mut rows = vec![0.0; SIZE * SIZE];
    let mut random = Random::new(17);
    for _ in 0..1600 {
        let (row, start) = (random.below(SIZE as u64) as usize, random.below(SIZE as u64) as usize);
        let length = 40 + random.below(80) as usize;
        let lean = (random.unit() - 0.5) * 0.10;
        for step in 0..length {
            rows[row * SIZE + (start + step) % SIZE] += lean;
        }
    }
    Image::draw(SIZE as u32, |u, v| {
        let index = (v * SIZE as f64) as usize * SIZE + (u * SIZE as f64) as usize;
        normal(DVec3::new(0.0, (rows[index] * 32.0).floor() / 32.0, 1.0))
    })
}

/// Directions across the fibres of the weave, which is where a tow is rougher: warp runs along v, weft along u.
fn carbon_anisotropy() -> Image {
    Image::draw(256, |u, v| if twill(u, v).2 { [255, 128, 255] } else { [128, 255, 255] })
}

/// Plain-sawn oak: rings cut at a slant along v, and pores.
fn oak() -> Image {
    Image::draw(256, |u, v| {
        let sway = stretched_noise(u, v, [4, 2], 31) * 0.16 + stretched_noise(u, v, [10, 3], 32) * 0.035;
        let ring = (u + sway) * 9.0;
        let ring = ring - ring.floor();
        // Early wood begins abruptly and fades into late wood.
        let late = ring * ring;
        let streak = stretched_noise(u, v, [128, 6], 33);
        // Vessels: short dark lines, most of them in early wood.
        let pore = stretched_noise(u, v, [256, 36], 34);
        let porous = if ring < 0.35 { 0.72 } else { 0.90 };
        let tone = 0.86 - 0.42 * late + 0.22 * (streak - 0.5);
        let tone = if pore > porous { tone - 0.3 } else { tone };
        between([88.0, 54.0, 28.0], [206.0, 162.0, 108.0], tone, 22.0)
    })
}

/// Grey stone with darker and lighter grains.
fn stone() -> Image {
    Image::draw(256, |u, v| {
        let grain = noise(u, v, 96, 27);
        let speck = if grain > 0.80 {
            0.22
        } else if grain < 0.2 {
            -0.25
        } else {
            0.0
        };
        between([52.0, 50.0, 48.0], [158.0, 152.0, 142.0], fractal(u, v, 6, 21) * 1.3 - 0.2 + speck, 18.0)
    })
}

/// Wetness of the stone, in sixteen steps: puddles fill the low parts.
fn stone_wet() -> Image {
    Image::draw(128, |u, v| {
        let low = (0.50 - fractal(u, v, 6, 21)) * 7.0;
        let wet = (low.clamp(0.0, 1.0) * 15.0 + 0.5).floor() / 15.0;
        [byte(wet); 3]
    })
}

/// Sheets of gold leaf on red bole, which shows where they are torn.
fn leaf_color() -> Image {
    Image::draw(256, |u, v| {
        let torn = noise(u, v, 14, 41) * 0.6 + noise(u, v, 56, 42) * 0.4;
        let (x, y) = (u * 3.0, v * 3.0);
        // Sheets overlap; their edges are worn.
        let edge = |t: f64| (t - t.floor() - 0.5).abs() > 0.475;
        let worn = if edge(x + 0.06 * noise(u, v, 9, 43)) || edge(y + 0.06 * noise(u, v, 9, 44)) {
            0.2
        } else {
            0.0
        };
        if torn - worn < 0.24 {
            return between([92.0, 26.0, 16.0], [128.0, 44.0, 28.0], noise(u, v, 48, 45), 4.0);
        }
        between([232.0, 178.0, 84.0], [255.0, 214.0, 132.0], noise(u, v, 7, 46), 8.0)
    })
}

/// Creases of thin metal.
fn wrinkles(u: f64, v: f64) -> f64 {
    let ridge = |cells: i64, seed: u64| 1.0 - (noise(u, v, cells, seed) * 2.0 - 1.0).abs();
    ridge(7, 51) * 0.6 + ridge(15, 52) * 0.3
}

/// Skin between pores: cells with furrows between them.
fn pores(u: f64, v: f64) -> f64 {
    const CELLS: i64 = 22;
    let point = DVec2::new(u, v) * CELLS as f64;
    let (column, row) = (point.x.floor() as i64, point.y.floor() as i64);
    let (mut first, mut second) = (f64::MAX, f64::MAX);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let (c, r) = (column + dx, row + dy);
            let cell = (r.rem_euclid(CELLS) * CELLS + c.rem_euclid(CELLS)) as u64;
            let offset = angle::unit(Random::new(hash(cell, 61)).unit()) * 0.35;
            let centre = DVec2::new(c as f64 + 0.5, r as f64 + 0.5) + offset;
            let distance = centre.distance(point);
            (first, second) =
                if distance < first { (distance, first) } else { (first, second.min(distance)) };
        }
    }
    ((second - first) * 3.0).min(1.0) * 0.5
}
