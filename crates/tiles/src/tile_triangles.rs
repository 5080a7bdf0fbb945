//! The triangles and points of a tile by their identities.

use super::pass::FrameContext;
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::{Fragment, SourceTriangle, TriangleSource};
use overcoat_stages::geometry::Chunk;
use overcoat_stages::raster::{Disc, Triangle};
use prefetch_index::prefetch_index;

/// Chunks and a tile's identities.
pub struct TileTriangles<'a> {
    pub chunks: &'a [Chunk],
    /// Chunk of each, and which of its triangles or points.
    pub identities: &'a [(u32, u32)],
    /// The discs of points that are seen, as triangles around them; and which is that of an identity.
    pub discs: &'a Discs,
}

impl TileTriangles<'_> {
    /// Prefetches the triangle of an identity. Changes no result.
    #[inline(always)]
    pub fn prefetch(&self, identity: u32) {
        let (chunk, index) = self.identities[identity as usize];
        prefetch_index(&self.chunks[chunk as usize].triangles, index as usize);
    }

    /// The draw that an identity belongs to.
    #[inline(always)]
    pub fn draw(&self, identity: u32) -> u32 {
        self.chunks[self.identities[identity as usize].0 as usize].draw
    }
}

impl TriangleSource for TileTriangles<'_> {
    #[inline(always)]
    fn triangle(&self, identity: u32) -> SourceTriangle<'_> {
        let (chunk, index) = self.identities[identity as usize];
        let chunk = &self.chunks[chunk as usize];
        if chunk.points {
            let place = self.discs.places[identity as usize];
            return SourceTriangle {
                screen: &self.discs.triangles[place as usize],
                draw: chunk.draw,
                clip: None,
            };
        }
        let screen = &chunk.triangles[index as usize];
        SourceTriangle { screen, draw: chunk.draw, clip: chunk.clip(index) }
    }
}

/// Points of a tile that some sample sees.
#[derive(Debug, Default)]
pub struct Discs {
    triangles: Vec<Triangle>,
    /// For each identity, its place in the list or [`Discs::NONE`].
    places: Vec<u32>,
    /// The tile has points.
    pub wanted: bool,
}

impl Discs {
    /// In place of a disc's place: it has not been listed.
    const NONE: u32 = u32::MAX;

    /// Forgets all.
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.places.clear();
        self.wanted = false;
    }

    /// Lists the disc of an identity.
    pub fn add(&mut self, identity: u32, disc: &Disc) {
        let identity = identity as usize;
        if self.places.len() <= identity {
            self.places.resize(identity + 1, Self::NONE);
        }
        self.places[identity] = self.triangles.len() as u32;
        self.triangles.push(Triangle::around(disc));
    }

    /// Forgets the disc that was listed last, of the largest identity so far.
    pub fn remove_last(&mut self, identity: u32) {
        self.triangles.pop();
        self.places.truncate(identity as usize);
    }

    /// Lists the discs of the points among fragments.
    pub fn list(&mut self, frame: &FrameContext<'_>, identities: &[(u32, u32)], fragments: &[Fragment]) {
        for fragment in if self.wanted { fragments } else { &[] } {
            let (chunk, index) = identities[fragment.triangle as usize];
            let known = self.places.get(fragment.triangle as usize).is_some_and(|place| *place != Self::NONE);
            if known || !frame.chunks[chunk as usize].points {
                continue;
            }
            if let Some(disc) = frame.disc(&frame.chunks[chunk as usize], index) {
                self.add(fragment.triangle, &disc);
            }
        }
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.triangles, &other.triangles);
        reserve_like(&mut self.places, &other.places);
    }
}
