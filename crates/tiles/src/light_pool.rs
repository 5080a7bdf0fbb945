//! Rays of neighbouring pixels, taken together.
//!
//! Rays are turned from pixel to pixel, so that those of many pixels are as good as one set of so many times as many
//! (interleaved sampling: Keller and Heidrich 2001). Where neighbours are alike (of one material, on one plane, with lobes of
//! nearly one direction and width), what their rays have found counts for each of them: first in squares of 2 x 2 pixels, of
//! which those that are alike have one sum, and then over 4 x 4 of such squares.
//!
//! **Invariant:** pixels have neighbours only in their own cell of 16 x 16, which lies in one tile whatever the tiles' size.

use super::reach::CELL;
use overcoat_core::math::triple::{difference, dot};
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::Fragment;
use overcoat_stages::gbuffer::layout::{self, Plane, SurfacePlanes};
use overcoat_stages::shade::{Found, TracedLobe};

/// Squares of 2 x 2 pixels along a side of the neighbourhood.
const SIDE: u32 = 4;

/// Squares along a side of a cell.
const SQUARES: u32 = CELL / 2;

/// Squares along a row of the largest tile.
const COLUMNS: u32 = 64 / 2;

/// No receiver.
const NONE: u32 = u32::MAX;

/// Sums that a square has at the most: receivers that are like none of these have what their own rays have found.
const MOST_LEADERS: usize = 8;

/// Receivers of a square that are as like as this have one sum.
const ALIKE: f32 = 0.8;

/// How a surface receives light, as far as neighbours have to be alike.
#[derive(Clone, Copy, Debug, Default)]
pub struct Receiver {
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
    pub fn new(material: u32, planes: &SurfacePlanes, lane: usize) -> Self {
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
const NARROW: [f32; 2] = [0.02, 0.06];

/// Square of the length of the difference of unit normals from which on diffuse light is another one.
const TURNED: f32 = 0.3;

/// The same for reflections, in units of the square of their alpha; and the share of alpha by which they may be rougher.
const LOBE: [f32; 2] = [0.5, 0.3];

/// What a receiver asks of its neighbours.
struct Likeness<'a> {
    of: &'a Receiver,
    /// How much its lobes take of others at the most.
    most: Shares,
    /// For base and coat, how fast that sinks with the square of the difference of normals, and with the difference of alpha.
    slopes: [[f32; 2]; 2],
}

/// A share for each lobe.
type Shares = [f32; TracedLobe::COUNT];

/// How much the lobes of a receiver take of others at the most: nothing if they have sent no rays, or if they are narrow.
#[inline(always)]
fn most_taken(of: &Receiver, own: &Found) -> Shares {
    let mut most = [0.0; TracedLobe::COUNT];
    for lobe in TracedLobe::ALL {
        if own.has_sent(lobe) {
            most[lobe as usize] = match lobe {
                TracedLobe::Diffuse => 1.0,
                TracedLobe::Base => at_most_1((of.alpha[0] - NARROW[0]) * (1.0 / NARROW[1])),
                TracedLobe::Coat => at_most_1((of.alpha[1] - NARROW[0]) * (1.0 / NARROW[1])),
            };
        }
    }
    most
}

impl<'a> Likeness<'a> {
    #[inline(always)]
    fn new(of: &'a Receiver, most: Shares) -> Self {
        let slopes = of.alpha.map(|alpha| {
            let alpha = if alpha > NARROW[0] { alpha } else { NARROW[0] };
            [1.0 / (LOBE[0] * alpha * alpha), 1.0 / (LOBE[1] * alpha)]
        });
        Self { of, most, slopes }
    }

    /// Whether another of the same square has what it has.
    #[inline(always)]
    fn is_alike(&self, other: &Receiver, most: Shares) -> bool {
        let shares = self.with(other);
        let own = self.most;
        own == most && (0..shares.len()).all(|k| own[k] == 0.0 || (own[k] == 1.0 && shares[k] > ALIKE))
    }

    /// How much what the rays of another have found counts, lobe by lobe.
    #[inline(always)]
    fn with(&self, other: &Receiver) -> Shares {
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

/// From 0 to 1; 0 of what is no number.
#[inline(always)]
fn at_most_1(x: f32) -> f32 {
    at_least_0(if x > 1.0 { 1.0 } else { x })
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

/// The receivers of a tile, and what those that are alike have found.
#[derive(Debug, Default)]
pub struct Pool {
    /// For each square the first of those that lead, and for each of those the next.
    first: Vec<u32>,
    next: Vec<u32>,
    /// For each receiver, the one of its square whose sum it has.
    leader: Vec<u32>,
    /// How much the lobes of each take at the most.
    most: Vec<Shares>,
    /// Sums of those that have one leader, and of all around them.
    squares: Vec<Found>,
    sums: Vec<Found>,
}

impl Pool {
    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.first, &other.first);
        reserve_like(&mut self.next, &other.next);
        reserve_like(&mut self.leader, &other.leader);
        reserve_like(&mut self.most, &other.most);
        reserve_like(&mut self.squares, &other.squares);
        reserve_like(&mut self.sums, &other.sums);
    }

    /// Adds up what the rays of receivers have found, each of a fragment of a tile of this size.
    pub fn add_up(
        &mut self,
        fragments: &[Fragment],
        receivers: &[Receiver],
        found: &[Found],
        size: [u32; 2],
    ) {
        self.squares.clear();
        self.squares.extend_from_slice(found);
        self.most.clear();
        self.most.extend(receivers.iter().zip(found).map(|(receiver, own)| most_taken(receiver, own)));
        self.lead(fragments, receivers, found);
        self.sums.clear();
        self.sums.extend_from_slice(&self.squares);
        for (number, fragment) in fragments.iter().enumerate() {
            if self.leader[number] == number as u32 {
                self.add_neighbours(number, fragment, receivers, size);
            }
        }
    }

    /// Finds a leader for each receiver that takes anything, and adds up what those of one have found.
    fn lead(&mut self, fragments: &[Fragment], receivers: &[Receiver], found: &[Found]) {
        self.first.clear();
        self.first.resize((COLUMNS * COLUMNS) as usize, NONE);
        self.next.clear();
        self.next.resize(receivers.len(), NONE);
        self.leader.clear();
        self.leader.resize(receivers.len(), NONE);
        for (number, fragment) in fragments.iter().enumerate() {
            if self.most[number] == [0.0; TracedLobe::COUNT] {
                continue;
            }
            let square = (fragment.row() / 2 * COLUMNS + fragment.column() / 2) as usize;
            let (mut leader, mut leaders) = (self.first[square], 0);
            while leader != NONE {
                leaders += 1;
                let k = leader as usize;
                if Likeness::new(&receivers[k], self.most[k]).is_alike(&receivers[number], self.most[number])
                {
                    break;
                }
                leader = self.next[k];
            }
            if leader == NONE {
                if leaders == MOST_LEADERS {
                    continue;
                }
                leader = number as u32;
                self.next[number] = std::mem::replace(&mut self.first[square], leader);
            } else {
                for lobe in TracedLobe::ALL {
                    self.squares[leader as usize].add_share(lobe, &found[number], 1.0);
                }
            }
            self.leader[number] = leader;
        }
    }

    /// Adds what those around a leader have found.
    fn add_neighbours(&mut self, number: usize, fragment: &Fragment, receivers: &[Receiver], size: [u32; 2]) {
        let Self { first, next, most, squares, sums, .. } = self;
        let likeness = Likeness::new(&receivers[number], most[number]);
        let sum = &mut sums[number];
        for row in window(fragment.row() / 2, size[1].div_ceil(2)) {
            for column in window(fragment.column() / 2, size[0].div_ceil(2)) {
                let mut other = first[(row * COLUMNS + column) as usize];
                while other != NONE {
                    let k = other as usize;
                    other = next[k];
                    if k == number {
                        continue;
                    }
                    let shares = likeness.with(&receivers[k]);
                    for lobe in TracedLobe::ALL {
                        if shares[lobe as usize] > 0.0 {
                            sum.add_share(lobe, &squares[k], shares[lobe as usize]);
                        }
                    }
                }
            }
        }
    }

    /// What counts for a receiver, whose own rays have found `own`.
    #[inline(always)]
    pub fn sum(&self, place: u32, own: &Found) -> Found {
        let mut sum = *own;
        if let Some(all) = self.sums.get(self.leader[place as usize] as usize) {
            for lobe in TracedLobe::ALL {
                if self.most[place as usize][lobe as usize] > 0.0 {
                    sum.take(lobe, all);
                }
            }
        }
        sum
    }
}

/// The neighbours of a square along one axis, in a tile of this size in squares: moved into the cell where they would pass its
/// sides.
#[inline(always)]
fn window(at: u32, size: u32) -> std::ops::Range<u32> {
    let (cell, number) = (at / SQUARES * SQUARES, at % SQUARES);
    let count = (size - cell).min(SQUARES);
    // By turns one more on the one side and on the other.
    let first = number.saturating_sub(SIDE / 2 - number % 2).min(count.saturating_sub(SIDE));
    cell + first..cell + count.min(first + SIDE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_lie_in_the_cell_and_every_square_is_its_own() {
        for size in [1, 2, 5, 8, 10, 32] {
            for at in 0..size {
                let found = window(at, size);
                let cell = |square: u32| square / SQUARES;
                assert!(found.contains(&at) && found.end <= size, "{at} {size} {found:?}");
                assert!(found.clone().all(|k| cell(k) == cell(at)), "{at} {size} {found:?}");
                assert_eq!(found.len() as u32, (size - cell(at) * SQUARES).min(SIDE));
            }
        }
    }
}
