//! A small alphabet of strokes.

use glam::DVec2;

use super::angle;
use super::outline::{Distance, stroke_distance};

/// Height of lower-case letters; ascenders reach 1.5.
const ROUND: f64 = 0.5;
/// Advance from letter to letter.
const ADVANCE: f64 = 1.32;

/// The strokes of a word, centred about the origin horizontally, lower-case letters 1 high from y = 0.
pub fn word(text: &str) -> Vec<Vec<DVec2>> {
    let mut strokes: Vec<Vec<DVec2>> = Vec::new();
    let mut pen = 0.0;
    for letter in text.chars() {
        for stroke in glyph(letter) {
            strokes.push(stroke.iter().map(|p| *p + DVec2::new(pen, 0.0)).collect());
        }
        pen += match letter {
            'r' | 't' => 0.8 * ADVANCE,
            ' ' => 0.6 * ADVANCE,
            _ => ADVANCE,
        };
    }
    // The last letter leaves its spacing behind.
    let middle = 0.5 * (pen - (ADVANCE - 1.0));
    for stroke in &mut strokes {
        for point in stroke {
            point.x -= middle;
        }
    }
    strokes
}

/// Distance of a point to the nearest stroke of half width `half`.
pub fn distance(strokes: &[Vec<DVec2>], half: f64, point: DVec2) -> Distance {
    let mut best = Distance { value: f64::MAX, gradient: DVec2::ZERO };
    for stroke in strokes {
        let candidate = stroke_distance(stroke, half, point);
        if candidate.value < best.value {
            best = candidate;
        }
    }
    best
}

/// An arc about (`x`, `y`) from one part of a turn to another, counter-clockwise from the right.
fn arc(x: f64, y: f64, radius: f64, from: f64, to: f64) -> Vec<DVec2> {
    const STEPS: u32 = 20;
    (0..=STEPS)
        .map(|i| {
            let turns = from + (to - from) * f64::from(i) / f64::from(STEPS);
            DVec2::new(x, y) + angle::unit(turns) * radius
        })
        .collect()
}

/// A straight stroke.
fn bar(points: &[(f64, f64)]) -> Vec<DVec2> {
    points.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
}

/// Strokes of one letter in a cell 1 wide.
fn glyph(letter: char) -> Vec<Vec<DVec2>> {
    match letter {
        'o' => vec![arc(ROUND, ROUND, ROUND, 0.0, 1.0)],
        'v' => vec![bar(&[(0.04, 1.0), (0.5, 0.0), (0.96, 1.0)])],
        'e' => {
            let mut stroke = bar(&[(0.0, 0.5), (1.0, 0.5)]);
            stroke.extend(arc(ROUND, ROUND, ROUND, 0.0, 0.89));
            vec![stroke]
        }
        'r' => vec![bar(&[(0.1, 0.0), (0.1, 1.0)]), arc(0.5, 0.6, 0.4, 0.5, 0.17)],
        'c' => vec![arc(ROUND, ROUND, ROUND, 0.13, 0.87)],
        'a' => vec![arc(ROUND, ROUND, ROUND, 0.0, 1.0), bar(&[(1.0, 1.0), (1.0, 0.0)])],
        't' => {
            let mut stem = bar(&[(0.35, 1.5), (0.35, 0.3)]);
            stem.extend(arc(0.65, 0.3, 0.3, 0.5, 0.78));
            vec![stem, bar(&[(0.05, 1.0), (0.75, 1.0)])]
        }
        _ => Vec::new(),
    }
}
