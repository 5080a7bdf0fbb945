//! Rays of neighbouring pixels, taken together.
//!
//! Rays are turned from pixel to pixel, so that those of sixteen pixels are as good as one set of sixteen times as many
//! (interleaved sampling: Keller and Heidrich 2001). Where neighbours are alike (of one material, on one plane, with lobes of
//! nearly one direction and width), what their rays have found counts for each of them. They are every other pixel along rows
//! and columns (as the holes of Dammertz et al. 2010): what noise is left then differs from each pixel to the next, and not
//! from patch to patch, where it would be seen.
//!
//! **Invariant:** pixels have neighbours only in their own cell of 16 x 16, which lies in one tile whatever the tiles' size.

use super::reach::CELL;
use crate::gbuffer::Fragment;
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use crate::reuse::reserve_like;
use crate::scene::Material;
use crate::shade::{Found, TracedLobe};

/// Neighbours along a side of their square, and the step from each to the next.
const SIDE: u32 = 4;
const STEP: u32 = 2;

/// Pixels along a row of the largest tile.
const COLUMNS: usize = 64;

/// How a surface receives light, as far as neighbours have to be alike.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Receiver {
    material: u32,
    position: [f32; 3],
    face: [f32; 3],
    /// Of base and coat.
    normals: [[f32; 3]; 2],
    /// Squares of the perceptual roughness, likewise.
    alpha: [f32; 2],
    pub(super) roughness: [f32; 2],
}

impl Receiver {
    /// One lane of the G-buffer.
    #[inline(always)]
    pub(super) fn new(material: u32, planes: &SurfacePlanes, lane: usize) -> Self {
        let at = |plane: Plane, k: usize| planes.rows[plane.first + k][lane];
        let vector = |plane: Plane| [at(plane, 0), at(plane, 1), at(plane, 2)];
        let roughness = [at(layout::ROUGHNESS, 0), at(layout::COAT_ROUGHNESS, 0)];
        Self {
            material,
            position: vector(layout::FACE_POSITION),
            face: vector(layout::FACE_NORMAL),
            normals: [vector(layout::NORMAL), vector(layout::COAT_NORMAL)],
            alpha: roughness.map(|r| r * r),
            roughness,
        }
    }

}

/// Square of the sine of the angle by which a neighbour may lie above or below the plane of a surface.
const PLANE: f32 = 0.1;

/// From this alpha on reflections are taken together, and over how much of it it becomes all.
const NARROW: [f32; 2] = [0.04, 0.15];

/// Square of the length of the difference of unit normals from which on diffuse light is another one.
const TURNED: f32 = 0.3;

/// The same for reflections, in units of the square of their alpha; and the share of alpha by which they may be rougher.
const LOBE: [f32; 2] = [0.5, 0.3];

/// What a receiver asks of its neighbours.
struct Likeness<'a> {
    of: &'a Receiver,
    /// How much its lobes take of others at the most: none, if they have sent no rays.
    most: [f32; TracedLobe::COUNT],
    /// For base and coat, how fast that sinks with the square of the difference of normals, and with the difference of alpha.
    slopes: [[f32; 2]; 2],
}

impl<'a> Likeness<'a> {
    #[inline(always)]
    fn new(of: &'a Receiver, own: &Found, material: &Material) -> Self {
        let mut likeness = Self { of, most: [0.0; TracedLobe::COUNT], slopes: [[0.0; 2]; 2] };
        for &lobe in TracedLobe::of(material) {
            if !own.has_sent(lobe) {
                continue;
            }
            likeness.most[lobe as usize] = match lobe {
                TracedLobe::Diffuse => 1.0,
                TracedLobe::Base | TracedLobe::Coat => {
                    let k = usize::from(lobe == TracedLobe::Coat);
                    let alpha = of.alpha[k];
                    let wide = (alpha - NARROW[0]) * (1.0 / NARROW[1]);
                    if wide <= 0.0 {
                        continue;
                    }
                    likeness.slopes[k] = [1.0 / (LOBE[0] * alpha * alpha), 1.0 / (LOBE[1] * alpha)];
                    if wide < 1.0 { wide } else { 1.0 }
                }
            };
        }
        likeness
    }

    /// Whether any lobe takes something.
    #[inline(always)]
    fn is_some(&self) -> bool {
        self.most.iter().any(|most| *most > 0.0)
    }

    /// How much what the rays of another have found counts, lobe by lobe.
    #[inline(always)]
    fn with(&self, other: &Receiver) -> [f32; TracedLobe::COUNT] {
        let none = [0.0; TracedLobe::COUNT];
        if self.of.material != other.material {
            return none;
        }
        let mut likeness = none;
        let turned = square(difference(self.of.normals[0], other.normals[0]));
        likeness[0] = self.most[0] * at_least_0(1.0 - turned * (1.0 / TURNED));
        let reflected = |k: usize, turned: f32| {
            let [turn, rougher] = self.slopes[k];
            let rougher = (self.of.alpha[k] - other.alpha[k]).abs() * rougher;
            self.most[k + 1] * at_least_0(1.0 - turned * turn) * at_least_0(1.0 - rougher)
        };
        likeness[1] = reflected(0, turned);
        if self.most[2] > 0.0 {
            likeness[2] = reflected(1, square(difference(self.of.normals[1], other.normals[1])));
        }
        let apart = difference(other.position, self.of.position);
        let height = dot(apart, self.of.face);
        if height * height > PLANE * square(apart) { none } else { likeness }
    }
}

/// Not less than 0; 0 of what is no number.
#[inline(always)]
fn at_least_0(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

#[inline(always)]
fn square(a: [f32; 3]) -> f32 {
    dot(a, a)
}

#[inline(always)]
fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// The receivers of each pixel of a tile.
#[derive(Debug, Default)]
pub(super) struct Pool {
    /// The first of each pixel and, after those of each row, of the next.
    first: Vec<u32>,
}

impl Pool {
    /// Takes as much memory as `other` has.
    pub(super) fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.first, &other.first);
    }

    /// Finds the first fragment of each pixel; those of a pixel follow each other.
    pub(super) fn list(&mut self, fragments: &[Fragment]) {
        self.first.clear();
        self.first.resize(COLUMNS * COLUMNS, u32::MAX);
        for (number, fragment) in fragments.iter().enumerate().rev() {
            self.first[usize::from(fragment.pixel)] = number as u32;
        }
    }

    /// What the rays of a receiver and of those around it have found.
    #[inline(always)]
    pub(super) fn sum(
        &self,
        material: &Material,
        fragments: &[Fragment],
        place: u32,
        receivers: &[Receiver],
        found: &[Found],
        size: [u32; 2],
    ) -> Found {
        let own = &found[place as usize];
        let likeness = Likeness::new(&receivers[place as usize], own, material);
        let mut sum = *own;
        if !likeness.is_some() {
            return sum;
        }
        let fragment = &fragments[place as usize];
        let columns = window(fragment.column(), size[0]);
        for row in window(fragment.row(), size[1]) {
            for column in columns.clone() {
                let pixel = Fragment::pixel_at(column, row);
                let first = self.first[usize::from(pixel)] as usize;
                let is_same = |k: &usize| fragments.get(*k).is_some_and(|other| other.pixel == pixel);
                for k in (first..).take_while(is_same) {
                    if k == place as usize {
                        continue;
                    }
                    let shares = likeness.with(&receivers[k]);
                    for &lobe in TracedLobe::of(material) {
                        if shares[lobe as usize] > 0.0 {
                            sum.add_share(lobe, &found[k], shares[lobe as usize]);
                        }
                    }
                }
            }
        }
        sum
    }
}

/// The neighbours of a pixel along one axis, in a tile of this size: moved into the cell where they would pass its sides.
#[inline(always)]
fn window(at: u32, size: u32) -> impl Iterator<Item = u32> + Clone {
    let (cell, place) = (at / CELL * CELL, at % CELL);
    let (odd, number) = (place % STEP, place / STEP);
    let count = ((size - cell).min(CELL) - odd).div_ceil(STEP);
    // By turns one more on the one side and on the other.
    let first = number.saturating_sub(SIDE / 2 - number % 2).min(count.saturating_sub(SIDE));
    (first..count.min(first + SIDE)).map(move |k| cell + odd + k * STEP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_lie_in_the_cell_and_every_pixel_is_its_own() {
        for size in [1, 2, 5, 16, 20, 64] {
            for at in 0..size {
                let found: Vec<u32> = window(at, size).collect();
                let cell = |pixel: u32| pixel / CELL;
                assert!(found.contains(&at), "{at} {size} {found:?}");
                assert!(found.iter().all(|k| *k < size && cell(*k) == cell(at) && k % STEP == at % STEP));
                let most = ((size - cell(at) * CELL).min(CELL) - at % STEP).div_ceil(STEP);
                assert_eq!(found.len() as u32, most.min(SIDE));
            }
        }
    }
}
