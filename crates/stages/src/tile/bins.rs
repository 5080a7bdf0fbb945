//! Lists of the triangles that each tile may see, in the order of the triangles.

/// The (tile, triangle) pairs of one chunk of triangles, sorted by tile, triangles in order.
#[derive(Clone, Debug, Default)]
pub struct ChunkBins {
    /// Pairs as they were found: triangles in order.
    found: Vec<(u32, u32)>,
    /// Triangles of all tiles, tile by tile.
    triangles: Vec<u32>,
    /// Each tile that has triangles: tile, first and end index in `triangles`.
    runs: Vec<(u32, u32, u32)>,
    /// Working memory of the sort: number of triangles of each tile.
    counts: Vec<u32>,
}

impl ChunkBins {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.found.clear();
        self.triangles.clear();
        self.runs.clear();
    }

    /// Adds a triangle to the list of a tile that may see it. Triangles must come in order.
    #[inline(always)]
    pub fn push(&mut self, tile: u32, triangle: u32) {
        self.found.push((tile, triangle));
    }

    /// Number of pairs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.found.len()
    }

    /// True if no tile sees a triangle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Sorts by tile; triangles stay in order.
    pub fn sort(&mut self) {
        self.triangles.clear();
        self.runs.clear();
        let tiles = || self.found.iter().map(|&(tile, _)| tile);
        let (Some(first), Some(last)) = (tiles().min(), tiles().max()) else { return };
        let span = (last - first) as usize + 1;
        // A chunk's triangles are neighbours, so counting is almost always less work than comparing.
        if span > 4 * self.found.len() + 256 {
            self.sort_by_comparison();
            return;
        }
        self.counts.clear();
        self.counts.resize(span, 0);
        for &(tile, _) in &self.found {
            self.counts[(tile - first) as usize] += 1;
        }
        let mut next = 0;
        for (count, tile) in self.counts.iter_mut().zip(first..) {
            if *count > 0 {
                self.runs.push((tile, next, next + *count));
            }
            // From here on, where the tile's next triangle goes.
            (*count, next) = (next, next + *count);
        }
        self.triangles.resize(self.found.len(), 0);
        for &(tile, triangle) in &self.found {
            let place = &mut self.counts[(tile - first) as usize];
            self.triangles[*place as usize] = triangle;
            *place += 1;
        }
    }

    /// Puts pairs in place of what is there, without a list of them in between: `pairs` calls its argument with the tile and
    /// the number of each, numbers of a tile in order, twice in the same way. Tiles are below `tiles`.
    pub fn collect(&mut self, tiles: usize, pairs: impl Fn(&mut dyn FnMut(u32, u32))) {
        self.clear();
        self.counts.clear();
        self.counts.resize(tiles, 0);
        let counts = &mut self.counts;
        pairs(&mut |tile, _| counts[tile as usize] += 1);
        let mut next = 0;
        for (count, tile) in counts.iter_mut().zip(0..) {
            if *count > 0 {
                self.runs.push((tile, next, next + *count));
            }
            (*count, next) = (next, next + *count);
        }
        self.triangles.resize(next as usize, 0);
        let triangles = &mut self.triangles;
        pairs(&mut |tile, number| {
            let place = &mut counts[tile as usize];
            triangles[*place as usize] = number;
            *place += 1;
        });
    }

    /// The pairs are distinct, so an unstable sort has one result.
    fn sort_by_comparison(&mut self) {
        self.found.sort_unstable();
        for &(tile, triangle) in &self.found {
            let at = self.triangles.len() as u32;
            match self.runs.last_mut() {
                Some(run) if run.0 == tile => run.2 = at + 1,
                _ => self.runs.push((tile, at, at + 1)),
            }
            self.triangles.push(triangle);
        }
    }

    /// The triangles of a run.
    #[inline(always)]
    #[must_use]
    pub fn triangles(&self, run: &Run) -> &[u32] {
        &self.triangles[run.first as usize..run.end as usize]
    }
}

/// The triangles of one chunk that one tile may see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Number of the chunk.
    pub chunk: u32,
    first: u32,
    end: u32,
}

/// For each tile, its runs in the order of the chunks: triangle order by construction, however many threads made
/// the chunks.
#[derive(Clone, Debug, Default)]
pub struct TileBins {
    /// First run of each tile, and the end.
    offsets: Vec<u32>,
    runs: Vec<Run>,
}

impl TileBins {
    /// Collects the runs of all chunks.
    pub fn build<'a>(&mut self, tiles: usize, chunks: impl Iterator<Item = &'a ChunkBins> + Clone) {
        self.offsets.clear();
        self.offsets.resize(tiles + 1, 0);
        for chunk in chunks.clone() {
            for &(tile, ..) in &chunk.runs {
                self.offsets[tile as usize + 1] += 1;
            }
        }
        for tile in 0..tiles {
            self.offsets[tile + 1] += self.offsets[tile];
        }
        self.runs.clear();
        self.runs.resize(self.offsets[tiles] as usize, Run { chunk: 0, first: 0, end: 0 });
        for (number, chunk) in chunks.enumerate() {
            for &(tile, first, end) in &chunk.runs {
                let slot = &mut self.offsets[tile as usize];
                self.runs[*slot as usize] = Run { chunk: number as u32, first, end };
                *slot += 1;
            }
        }
        // Filling moved every offset to the next tile's: move them back.
        self.offsets.rotate_right(1);
        self.offsets[0] = 0;
    }

    /// The runs of a tile.
    #[must_use]
    pub fn runs(&self, tile: usize) -> &[Run] {
        &self.runs[self.offsets[tile] as usize..self.offsets[tile + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_get_their_triangles_in_order() {
        let mut chunks = vec![ChunkBins::default(); 3];
        chunks[0].push(2, 0);
        chunks[0].push(0, 0);
        chunks[0].push(2, 1);
        chunks[2].push(2, 5);
        chunks.iter_mut().for_each(ChunkBins::sort);
        let mut bins = TileBins::default();
        bins.build(4, chunks.iter());
        let of = |tile: usize| -> Vec<(u32, Vec<u32>)> {
            bins.runs(tile)
                .iter()
                .map(|r| (r.chunk, chunks[r.chunk as usize].triangles(r).to_vec()))
                .collect()
        };
        assert_eq!(of(0), [(0, vec![0])]);
        assert_eq!(of(1), []);
        assert_eq!(of(2), [(0, vec![0, 1]), (2, vec![5])]);
        assert_eq!(of(3), []);
    }

    #[test]
    fn pairs_are_collected_as_they_are_sorted() {
        let pairs = [(4, 0), (1, 0), (4, 2), (0, 3), (4, 3), (1, 9)];
        let (mut sorted, mut collected) = (ChunkBins::default(), ChunkBins::default());
        pairs.iter().for_each(|&(tile, number)| sorted.push(tile, number));
        sorted.sort();
        collected.collect(9, |each| pairs.iter().for_each(|&(tile, number)| each(tile, number)));
        assert_eq!((&sorted.triangles, &sorted.runs), (&collected.triangles, &collected.runs));
    }

    #[test]
    fn counting_and_comparing_sort_alike() {
        let mut state = 7_u32;
        for spread in [1, 3, 50, 900, 100_000] {
            let mut counted = ChunkBins::default();
            for triangle in 0..200 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let tile = 5 + (state >> 8) % spread;
                counted.push(tile, triangle);
                counted.push(tile + 1, triangle);
            }
            let mut compared = counted.clone();
            counted.sort();
            compared.sort_by_comparison();
            assert_eq!((counted.triangles, counted.runs), (compared.triangles, compared.runs), "{spread}");
        }
    }
}
