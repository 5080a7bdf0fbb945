//! Six faces of a cube, spread as latitude and longitude.
//!
//! Layouts: OpenEXR, `ImfEnvmap.h`; the strips of OpenGL's cube maps (OpenGL 4.6, section 8.13, table 8.19); crosses as they are
//! cut out and folded. Directions are told by what is right, up and ahead of an eye that looks to the centre of the panorama, from
//! within the cube: no layout is mirrored.

use super::super::LoadError;
use super::Picture;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_core::math::double::sin_cos;
use overcoat_image::decode::Projection;
use overcoat_scene::EquirectImage;
use std::f64::consts::{PI, TAU};

/// Samples of a pixel in each direction.
const SAMPLES: usize = 2;

/// Place of a face, in faces from the top left, and whether it stands on its head.
type Cell = (usize, usize, bool);

/// Places of the six faces in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    /// Pixels of a face in each direction, at least 1.
    side: usize,
    /// Faces to the right, to the left, above, below, ahead and behind.
    cells: [Cell; 6],
    /// True if the centres of the outermost pixels lie on the edges of the cube.
    on_edges: bool,
}

/// Faces one below the other, as OpenEXR has them: +X, -X, +Y, -Y, +Z, -Z. Ahead is +Z, and -X to the right of it.
const OPENEXR: [Cell; 6] =
    [(0, 1, false), (0, 0, false), (0, 2, true), (0, 3, true), (0, 4, false), (0, 5, false)];
/// Faces one below the other, as OpenGL has them: +X, -X, +Y, -Y, +Z, -Z. Ahead is +Z, and +X to the right of it.
const COLUMN: [Cell; 6] =
    [(0, 0, false), (0, 1, false), (0, 2, false), (0, 3, false), (0, 4, false), (0, 5, false)];
/// The same side by side.
const ROW: [Cell; 6] =
    [(0, 0, false), (1, 0, false), (2, 0, false), (3, 0, false), (4, 0, false), (5, 0, false)];
/// A cross that lies: what is behind comes last in the middle row.
const LYING_CROSS: [Cell; 6] =
    [(2, 1, false), (0, 1, false), (1, 0, false), (1, 2, false), (1, 1, false), (3, 1, false)];
/// A cross that stands: what is behind is at the bottom, on its head.
const STANDING_CROSS: [Cell; 6] =
    [(2, 1, false), (0, 1, false), (1, 0, false), (1, 2, false), (1, 1, false), (1, 3, true)];

impl Layout {
    /// The layout of a picture; `None` if it shows latitude and longitude.
    ///
    /// # Errors
    /// [`LoadError::Unsupported`] for what is no panorama and no known layout.
    pub(super) fn of(picture: &mut Picture) -> Result<Option<Self>, LoadError> {
        let [width, height] = [picture.width, picture.height].map(|side| side as usize);
        let is = |columns: usize, rows: usize| {
            width.checked_div(columns).is_some_and(|side| {
                side > 0 && side.checked_mul(columns) == Some(width) && side.checked_mul(rows) == Some(height)
            })
        };
        let refuse = |what: &str| {
            let size = format!("{width} x {height} pixels");
            Err(LoadError::unsupported(picture.format, format!("an environment of {size}, {what}")))
        };
        let on_edges = picture.projection == Some(Projection::Cube);
        let cells = match picture.projection {
            Some(Projection::LatitudeLongitude) => return Ok(None),
            Some(Projection::Cube) if is(1, 6) => OPENEXR,
            Some(Projection::Cube) => {
                return refuse("which is a cube by its attribute envmap and not six times as high as wide");
            }
            None if is(1, 6) => COLUMN,
            None if is(6, 1) => ROW,
            None if is(4, 3) && picture.is_blank_around(LYING_CROSS, 4, 3) => LYING_CROSS,
            None if is(3, 4) && picture.is_blank_around(STANDING_CROSS, 3, 4) => STANDING_CROSS,
            None if is(3, 4) => {
                return refuse("neither a panorama nor the cross of a cube, whose corners would be blank");
            }
            None => {
                if is(4, 3) {
                    picture.warnings.push(format!(
                        "{}: the environment of {width} x {height} pixels is no cross of a cube, whose corners would be blank: it \
                         is taken as latitude and longitude",
                        picture.format
                    ));
                }
                return Ok(None);
            }
        };
        if cells == ROW || cells == COLUMN {
            picture.warnings.push(format!(
                "{}: the environment of {width} x {height} pixels is taken as the six faces of a cube, +X, -X, +Y, -Y, +Z and -Z \
                 as OpenGL has them",
                picture.format
            ));
        }
        let columns = cells.iter().map(|&(column, ..)| column).fold(0, usize::max).saturating_add(1);
        Ok(Some(Self { side: width.checked_div(columns).unwrap_or(1), cells, on_edges }))
    }

    /// Replaces the faces by a panorama four faces wide and two high.
    ///
    /// # Errors
    /// [`LoadError::Limit`] if that is larger than the limits allow.
    pub(super) fn spread(
        &self,
        picture: &mut Picture,
        limits: &Limits,
        jobs: &Jobs,
    ) -> Result<(), LoadError> {
        let side = self.side as u64;
        let [width, height] = [side.saturating_mul(4), side.saturating_mul(2)];
        let what = || format!("{}: {width} x {height} pixels of the cube", picture.format);
        let area = width.saturating_mul(height);
        Limits::check(what, area, limits.texture_pixels, "texture_pixels")?;
        let bytes = area.saturating_add(picture.pixels.len() as u64).saturating_mul(12);
        Limits::check(what, bytes, limits.decoded_bytes, "decoded_bytes")?;
        let too_wide = |_| LoadError::malformed(picture.format, "a side of 2^32 pixels");
        let size = [u32::try_from(width).map_err(too_wide)?, u32::try_from(height).map_err(too_wide)?];
        let [width, height] = size.map(|side| side as usize);

        // Sine and cosine of the angles of all samples.
        let angles = |count: usize, whole: f64, first: f64| -> Vec<(f64, f64)> {
            let count = count.saturating_mul(SAMPLES);
            (0..count).map(|k| sin_cos(first + (k as f64 + 0.5) / count as f64 * whole)).collect()
        };
        let (columns, rows) = (angles(width, TAU, -PI), angles(height, PI, 0.0));
        let mut pixels = vec![[0.0; 3]; width.saturating_mul(height)];
        jobs.for_each_chunk_mut(&mut pixels, width, |y, row| {
            for (pixel, longitudes) in row.iter_mut().zip(columns.chunks(SAMPLES)) {
                let latitudes = rows.iter().skip(y.saturating_mul(SAMPLES)).take(SAMPLES);
                for &(across, up) in latitudes {
                    for &(sin, cos) in longitudes {
                        let sample = self.sample(picture, [across * sin, up, across * cos]);
                        let weight = 1.0 / (SAMPLES * SAMPLES) as f32;
                        pixel.iter_mut().zip(sample).for_each(|(sum, v)| *sum += v * weight);
                    }
                }
            }
        });
        picture.pixels = pixels;
        [picture.width, picture.height] = size;
        Ok(())
    }

    /// The light from a direction: how far right, up and ahead it leads.
    fn sample(&self, picture: &Picture, [right, up, ahead]: [f64; 3]) -> [f32; 3] {
        let [x, y, z] = [right.abs(), up.abs(), ahead.abs()];
        // The face, and how far to the right and down the place on it is, -1 to 1.
        let (face, (s, t)) = if x >= y && x >= z {
            if right > 0.0 { (0, (-ahead / x, -up / x)) } else { (1, (ahead / x, -up / x)) }
        } else if y >= z {
            if up > 0.0 { (2, (right / y, ahead / y)) } else { (3, (right / y, -ahead / y)) }
        } else if ahead > 0.0 {
            (4, (right / z, -up / z))
        } else {
            (5, (-right / z, -up / z))
        };
        let Some(&(column, row, is_turned)) = self.cells.get(face) else { return [0.0; 3] };
        let (s, t) = if is_turned { (-s, -t) } else { (s, t) };
        let last = self.side.saturating_sub(1);
        // Column or row of the pixel below, of that above, and how far the place is from the one to the other.
        let place = |v: f64| {
            let n = self.side as f64;
            let v = if self.on_edges { (v + 1.0) * 0.5 * (n - 1.0) } else { (v + 1.0) * 0.5 * n - 0.5 };
            let v = if v > 0.0 { v } else { 0.0 };
            let low = (v as usize).min(last);
            (low, low.saturating_add(1).min(last), (v - low as f64) as f32)
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (place(s), place(t));
        let texel = |x: usize, y: usize| {
            let x = column.saturating_mul(self.side).saturating_add(x);
            picture.pixel(x, row.saturating_mul(self.side).saturating_add(y))
        };
        let mix = |a: [f32; 3], b: [f32; 3], f: f32| {
            let ([a0, a1, a2], [b0, b1, b2]) = (a, b);
            [a0 + (b0 - a0) * f, a1 + (b1 - a1) * f, a2 + (b2 - a2) * f]
        };
        mix(mix(texel(x0, y0), texel(x1, y0), fx), mix(texel(x0, y1), texel(x1, y1), fx), fy)
    }
}

impl Picture {
    /// A pixel as environments keep it: finite.
    fn pixel(&self, x: usize, y: usize) -> [f32; 3] {
        let pixel = self.pixels.get(y.saturating_mul(self.width as usize).saturating_add(x));
        let most = EquirectImage::MAX_RADIANCE;
        pixel
            .copied()
            .unwrap_or_default()
            .map(|v| if v > 0.0 { if v < most { v } else { most } } else { 0.0 })
    }

    /// True if all places of a picture of so many faces that have none are of one colour.
    fn is_blank_around(&self, cells: [Cell; 6], columns: usize, rows: usize) -> bool {
        let side = (self.width as usize).checked_div(columns).unwrap_or(0);
        // Compression lets faces run over their edges, and no colour stay as it was.
        let (inset, tolerance) = if self.has_noise { (side / 8, 0.05) } else { (0, 0.0) };
        let mut first = None;
        let blank = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        blank.filter(|place| !cells.iter().any(|&(column, row, _)| (column, row) == *place)).all(
            |(column, row)| {
                let range = |cell: usize| {
                    let start = cell.saturating_mul(side);
                    start.saturating_add(inset)..start.saturating_add(side).saturating_sub(inset)
                };
                range(row).all(|y| {
                    range(column).all(|x| {
                        let pixel = self.pixel(x, y);
                        let first = *first.get_or_insert(pixel);
                        pixel.iter().zip(first).all(|(a, b)| (a - b).abs() <= tolerance)
                    })
                })
            },
        )
    }
}

#[cfg(test)]
mod tests;
