//! True picture of a scene by the referee, with its variance.

use super::light::{IRRADIANCE, LAMP, Sky};
use super::scenes::Scene;
use super::view::{Hit, View, cross, dot, normalized};
use crate::truth::{Samples, Stack, StackError};
use overcoat_core::jobs::Jobs;

/// Places of a pixel, in rows and columns: the mean over their grid is that over the square but for a sixteenth of
/// [`Truth::footprint`].
const GRID: usize = 4;

/// Pixels between the scored area and the edge of the ball: those that [`footprint`] looks at are all of the ball.
const MARGIN: usize = 2;

/// Cosine to the lamp within which nothing is scored: balls of triangles end there in their shadow, sooner or later.
const TERMINATOR: f64 = 0.05;

/// A picture, row by row from the top; 0 where a pixel is not all of the ball.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Radiance, mean over the square of each pixel.
    pub mean: Vec<[f64; 3]>,
    /// Variance of that mean.
    pub variance: Vec<[f64; 3]>,
    /// Tolerance for a picture of triangles that are shaded in the middle of each pixel.
    pub footprint: Vec<[f64; 3]>,
    /// Which pixels are scored.
    pub mask: Vec<bool>,
}

impl Truth {
    /// Walks for a picture of `size` pixels a side: `samples` a pixel, times [`Scene::effort`], from a lamp a quarter
    /// of that. Another seed is another, independent picture. `done` is called with the number of finished rows.
    ///
    /// # Errors
    /// [`StackError`] of the scene's numbers.
    pub fn new(
        scene: &Scene,
        size: usize,
        [samples, seed]: [u32; 2],
        jobs: &Jobs,
        done: impl FnMut(usize),
    ) -> Result<Self, StackError> {
        Self::walked(&Parts::new(scene, samples, |coated| scene.stack(coated))?, size, seed, jobs, done)
    }

    /// The same with one bounce between the facets of each interface, in which single-scattering GGX is right: for scenes with
    /// [`Scene::has_truth_of_one_bounce`], others having one truth.
    ///
    /// # Errors
    /// [`StackError`] of the scene's numbers.
    pub fn of_one_bounce(
        scene: &Scene,
        size: usize,
        [samples, seed]: [u32; 2],
        jobs: &Jobs,
        done: impl FnMut(usize),
    ) -> Result<Self, StackError> {
        let stack = |coated| scene.specimen.stack_of_one_bounce(coated);
        Self::walked(&Parts::new(scene, samples, stack)?, size, seed, jobs, done)
    }

    fn walked(
        parts: &Parts,
        size: usize,
        seed: u32,
        jobs: &Jobs,
        mut done: impl FnMut(usize),
    ) -> Result<Self, StackError> {
        let view = View::new(size);
        let (mut mean, mut variance, mut mask) = (Vec::new(), Vec::new(), Vec::new());
        for y in 0..size {
            let row = jobs.map(size, |x| {
                if view.is_inside(x, y, 0.0) {
                    parts.pixel(&view, [x, y], u64::from(seed) << 32 | (y * size + x) as u64)
                } else {
                    Ok([[0.0; 3]; 2])
                }
            });
            for (x, pixel) in row.into_iter().enumerate() {
                let [value, error] = pixel?;
                mean.push(value);
                variance.push(error);
                mask.push(is_scored(parts.sky, &view, x, y));
            }
            done(y + 1);
        }
        let footprint = footprint(&mean, &mask, size);
        Ok(Self { mean, variance, footprint, mask })
    }
}

fn is_scored(sky: Sky, view: &View, x: usize, y: usize) -> bool {
    let away = |hit: Hit| sky != Sky::Lamp || dot(hit.normal, LAMP).abs() >= TERMINATOR;
    view.is_inside(x, y, MARGIN as f64) && view.hit(x as f64 + 0.5, y as f64 + 0.5).is_some_and(away)
}

/// The mean over a square less the value in its middle is a 24th of the second derivatives, in pixels, by Taylor's series. These
/// are differences over [`MARGIN`] pixels, which hold a quarter of the noise that those over one would; what they miss of narrow
/// highlights is less than the half that is added. Triangles in place of a ball, and vertices on a grid, shift what is seen by less
/// than a 64th of a pixel, which counts by the first derivatives.
fn footprint(mean: &[[f64; 3]], mask: &[bool], size: usize) -> Vec<[f64; 3]> {
    let square = (MARGIN * MARGIN) as f64;
    let of = |k: usize, c: usize| {
        let second = |step: usize| mean[k - step][c] + mean[k + step][c] - 2.0 * mean[k][c];
        let first = |step: usize| (mean[k + step][c] - mean[k - step][c]).abs() / (2 * MARGIN) as f64;
        let shift = (first(MARGIN) + first(MARGIN * size)) / 64.0;
        1.5 * (second(MARGIN) + second(MARGIN * size)).abs() / (24.0 * square) + shift
    };
    let pixels = mask.iter().enumerate();
    pixels.map(|(k, scored)| if *scored { [0, 1, 2].map(|c| of(k, c)) } else { [0.0; 3] }).collect()
}

/// Scene as the referee walks it: stacks, each with its share of the surface.
struct Parts {
    stacks: Vec<(f64, Stack)>,
    sky: Sky,
    /// Walks from each point of a pixel.
    samples: u64,
}

impl Parts {
    fn new(
        scene: &Scene,
        samples: u32,
        stack: impl Fn(bool) -> Result<Stack, StackError>,
    ) -> Result<Self, StackError> {
        let specimen = &scene.specimen;
        let mut stacks = Vec::new();
        for (share, coated) in [(specimen.coat, true), (1.0 - specimen.coat, false)] {
            if share > 0.0 {
                stacks.push((share, stack(coated)?));
            }
        }
        let each = samples / (GRID * GRID) as u32;
        // Connecting two walks takes some five times the time of one, and has less noise.
        let each = each * scene.effort / if scene.sky == Sky::Lamp { 4 } else { 1 };
        // Two at least: one has no variance.
        Ok(Self { stacks, sky: scene.sky, samples: each.max(2).into() })
    }

    /// Mean and variance of a pixel. Its number gives it random numbers of its own, though other pixels see the same angles.
    fn pixel(&self, view: &View, [x, y]: [usize; 2], number: u64) -> Result<[[f64; 3]; 2], StackError> {
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        let places = (GRID * GRID) as u64;
        for place in 0..places {
            let part = |k: u64| (k as f64 + 0.5) / GRID as f64;
            let (dx, dy) = (part(place % GRID as u64), part(place / GRID as u64));
            let Some(hit) = view.hit(x as f64 + dx, y as f64 + dy) else { continue };
            let samples = Samples { first: 0, count: self.samples, seed: number * places + place };
            for (share, stack) in &self.stacks {
                let [mean, error] = self.place(&hit, stack, &samples)?;
                for c in 0..3 {
                    sum[c] += share * mean[c];
                    squares[c] += share * share * error[c] * error[c];
                }
            }
        }
        let n = places as f64;
        Ok([sum.map(|s| s / n), squares.map(|s| s / (n * n))])
    }

    /// Radiance of a place, and its standard error.
    fn place(&self, hit: &Hit, stack: &Stack, samples: &Samples) -> Result<[[f64; 3]; 2], StackError> {
        let axes = axes(hit);
        let local = |d| axes.map(|axis| dot(d, axis));
        let wo = local(hit.view);
        let found = if self.sky == Sky::Lamp {
            let wi = local(LAMP);
            if wi[2] < 1e-6 {
                return Ok([[0.0; 3]; 2]);
            }
            let found = stack.evaluate(wo, wi, samples)?.total;
            return Ok([found.mean(), found.standard_error()].map(|v| v.map(|c| IRRADIANCE * c)));
        } else {
            let world = |d: [f64; 3]| [0, 1, 2].map(|c| (0..3).map(|k| d[k] * axes[k][c]).sum());
            stack.reflected(wo, samples, |d| self.sky.radiance(world(d)))?
        };
        Ok([found.mean(), found.standard_error()])
    }
}

/// Tangent, bitangent and normal, the view being in the plane of the first and the last.
fn axes(hit: &Hit) -> [[f64; 3]; 3] {
    let n = hit.normal;
    let cosine = dot(hit.view, n);
    let along = [0, 1, 2].map(|k| hit.view[k] - cosine * n[k]);
    // In the middle of the ball the view is the normal, and any tangent will do.
    let along = if dot(along, along) > 1e-20 { along } else { cross([0.0, 1.0, 0.0], n) };
    let tangent = normalized(along);
    [tangent, cross(n, tangent), n]
}
