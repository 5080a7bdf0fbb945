//! Files of MERL: isotropic BRDFs over half and difference angles.
//!
//! Matusik, Pfister, Brand and McMillan 2003, "A Data-Driven Reflectance Model", section 3; the angles are those of Rusinkiewicz
//! 1998, "A New Change of Variables for Efficient BRDF Representation". Three 32-bit integers are the numbers of half angles,
//! difference angles and difference azimuths (90, 90, 180; others are read alike), then three planes of doubles follow, red, green
//! and blue, azimuths fastest. All is little endian. The half angle is `(k / 90)^2` times 90 degrees, so that the highlight has more
//! of them; azimuths cover half a turn, for by reciprocity the other half is the same. Factors on the planes are those of the
//! authors' reader. A negative number says that nothing was measured there.
//!
//! *Deviation.* The authors' reader takes the cell that an angle falls into. Values here stand in the middle of their cells, and
//! between them they are interpolated, over those that were measured. Between half angles that is done with fourth roots, since the
//! tails of highlights fall with the fourth power of the angle: linear in the value they would be 4 percent too bright at 2.5 degrees.

use super::{MeasuredError, halfway, spherical, turned};
use std::f64::consts::{FRAC_PI_2, PI};

/// Factors on red, green and blue.
pub(super) const SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// Bytes before the first plane.
const HEADER: usize = 12;

/// Largest dimension: a thousand times the cells of the database.
const LARGEST: u64 = 4096;

const PLANES: [&str; 3] = ["red plane", "green plane", "blue plane"];

#[derive(Clone, Debug)]
pub(super) struct Merl {
    /// The whole file, whose numbers are read where they are.
    bytes: Vec<u8>,
    /// Half angles, difference angles, difference azimuths.
    size: [usize; 3],
}

impl Merl {
    pub(super) fn new(bytes: Vec<u8>) -> Result<Self, MeasuredError> {
        let dimension = |k: usize| {
            let four = bytes.get(4 * k..4 * k + 4)?.first_chunk()?;
            u64::try_from(i32::from_le_bytes(*four)).ok().filter(|n| (1..=LARGEST).contains(n))
        };
        let (Some(a), Some(b), Some(c)) = (dimension(0), dimension(1), dimension(2)) else {
            return Err(MeasuredError::Unknown);
        };
        // At most 2^36 cells.
        let (length, expected) = (bytes.len() as u64, HEADER as u64 + 24 * a * b * c);
        if length != expected {
            return Err(MeasuredError::Length { dimensions: vec![a, b, c], expected, length });
        }
        let merl = Self { bytes, size: [a, b, c].map(|n| n as usize) };
        for (plane, what) in PLANES.into_iter().enumerate() {
            for index in 0..merl.cells() {
                let value = merl.number(plane, index);
                if !value.is_finite() {
                    let expected = "a finite number";
                    return Err(MeasuredError::Number { what, index: index as u64, value, expected });
                }
            }
        }
        Ok(merl)
    }

    fn cells(&self) -> usize {
        self.size[0] * self.size[1] * self.size[2]
    }

    fn number(&self, plane: usize, index: usize) -> f64 {
        let at = HEADER + 8 * (plane * self.cells() + index);
        self.bytes
            .get(at..at + 8)
            .and_then(|eight| eight.first_chunk())
            .map_or(0.0, |b| f64::from_le_bytes(*b))
    }

    /// A cell, where it was measured.
    fn cell(&self, index: usize) -> Option<[f64; 3]> {
        let color: [f64; 3] = std::array::from_fn(|plane| self.number(plane, index) * SCALE[plane]);
        color.iter().all(|c| *c >= 0.0).then_some(color)
    }

    pub(super) fn evaluate(&self, view: [f64; 3], light: [f64; 3]) -> Option<[f64; 3]> {
        let half = halfway(view, light);
        let [half_angle, half_azimuth] = spherical(half);
        // The light about the half vector: first the half vector goes to the plane of x and z, then to +Z.
        let [x, y, z] = turned(light, -half_azimuth);
        let [z, x, y] = turned([z, x, y], -half_angle);
        let [angle, azimuth] = spherical([x, y, z]);
        // Half a turn is a whole period.
        let azimuth = if azimuth < 0.0 { azimuth + PI } else { azimuth };
        let [n_half, n_angle, n_azimuth] = self.size;
        let along = |share: f64, n: usize| Between::new(share * n as f64 - 0.5, n);
        let half = along((half_angle / FRAC_PI_2).sqrt(), n_half).clamped(n_half);
        let angle = along(angle / FRAC_PI_2, n_angle).clamped(n_angle);
        let azimuth = along(azimuth / PI, n_azimuth).wrapped(n_azimuth);
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for (i, weight) in half {
            // Over difference angles and azimuths at this half angle.
            let (mut row, mut known) = ([0.0; 3], 0.0);
            for (j, wj) in angle {
                for (k, wk) in azimuth {
                    if let Some(color) = self.cell((i * n_angle + j) * n_azimuth + k) {
                        row = std::array::from_fn(|c| row[c] + wj * wk * color[c]);
                        known += wj * wk;
                    }
                }
            }
            if weight * known > 0.0 {
                sum = std::array::from_fn(|c| sum[c] + weight * (row[c] / known).sqrt().sqrt());
                weights += weight;
            }
        }
        (weights > 0.0).then(|| {
            sum.map(|root| {
                let square = (root / weights) * (root / weights);
                square * square
            })
        })
    }
}

/// A position between the middles of two cells of a row.
struct Between {
    /// The cell before it, -1 before the first middle.
    before: i64,
    share: f64,
}

impl Between {
    fn new(position: f64, cells: usize) -> Self {
        let low = position.floor();
        let before = if low < -1.0 { -1 } else { low as i64 };
        Self { before: before.min(cells as i64 - 1), share: position - low }
    }

    /// Cells and weights; beyond the ends the last cell counts.
    fn clamped(&self, cells: usize) -> [(usize, f64); 2] {
        let cell = |k: i64| k.clamp(0, cells as i64 - 1) as usize;
        [(cell(self.before), 1.0 - self.share), (cell(self.before + 1), self.share)]
    }

    /// Cells and weights of a row whose ends meet.
    fn wrapped(&self, cells: usize) -> [(usize, f64); 2] {
        let cell = |k: i64| k.rem_euclid(cells as i64) as usize;
        [(cell(self.before), 1.0 - self.share), (cell(self.before + 1), self.share)]
    }
}
