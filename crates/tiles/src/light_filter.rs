//! A filter over the findings of the rays of neighbouring pixels: cross-bilateral (Eisemann and Durand 2004; over
//! interleaved samples, Segovia et al. 2006) over sums, so that what comes of it is a ratio of sums.
//!
//! Weights are a tent of the distance in pixels, times how alike surfaces are in material, plane, normal and roughness. Rays are
//! turned in a pattern of blocks that repeats, and half the width of the tent is its period: a box as wide, taken twice, which weights
//! all of the pattern alike, wherever it stands, and leaves nothing of it in the picture. More rays have a shorter period, so that
//! what is found is more and more a pixel's own.
//!
//! **Invariant:** what is found of a pixel depends on the pixels around it alone, whatever tiles they lie in. No weight reaches further
//! than a tile is wide.

use super::light_pool::{PLANE, Receiver, Shares, TURNED, TracedTile};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use overcoat_core::reuse::reserve_like;
use overcoat_stages::shade::{Found, TracedLobe};
use overcoat_stages::tile::TileGrid;

/// Blocks beside a tile that are looked at.
const BESIDE: usize = 4;

/// Pixels beside a tile that are looked at, at the most.
pub const MARGIN: usize = 2 * BESIDE;

/// Half the width of the tent for the light of lamps, whose points repeat after two pixels: the edges of shadows stay where they are.
const OF_LAMPS: f32 = 2.0;

/// Blocks along a side of the square that is looked at, and pairs of its rows: sixteen blocks.
const SIDE: usize = 2 * BESIDE;
const PAIRS: usize = SIDE / 2;

/// Numbers of a block: material, position, normals and alphas, then the sums of each lobe and of lamps.
const MATERIAL: usize = 0;
const POSITION: usize = 1;
const NORMALS: [usize; 2] = [4, 7];
const ALPHA: usize = 10;
const SUMS: [usize; TracedLobe::COUNT] = [12, 21, 32];
const LAMPS: usize = 17;
const NUMBERS: usize = 43;

/// Material of blocks without a surface.
const NO_MATERIAL: f32 = -1.0;

/// Weights of blocks around a pixel, which is the first or the second of its own along each axis. Lanes alternate between the two
/// rows of a pair.
type Weights = [[f32; LANES]; PAIRS];

/// A tent over blocks.
#[derive(Clone, Copy)]
struct Tent {
    /// For pixels at each column and row of their block.
    weights: [[Weights; 2]; 2],
    /// Weights of their own blocks.
    own: [[f32; 2]; 2],
}

impl Tent {
    /// A tent of half so many pixels, over blocks of so many pixels along a side.
    fn new(half_width: f32, block: u32) -> Self {
        let middle = 0.5 * (block - 1) as f32;
        let weight = |at: usize, pixel: usize| {
            let off = (at + pixel) as f32 - BESIDE as f32;
            let distance = (off * block as f32 + middle - pixel as f32).abs();
            let weight = 1.0 - distance / half_width;
            if weight > 0.0 { weight } else { 0.0 }
        };
        let of = |column: usize, row: usize| -> Weights {
            std::array::from_fn(|pair| {
                std::array::from_fn(|lane| weight(lane / 2, column) * weight(pair + lane % 2 * PAIRS, row))
            })
        };
        let own = |column: usize, row: usize| weight(BESIDE - column, column) * weight(BESIDE - row, row);
        Self {
            weights: each!(row in [0, 1] => each!(column in [0, 1] => of(column, row))),
            own: each!(row in [0, 1] => each!(column in [0, 1] => own(column, row))),
        }
    }
}

/// The tiles around one, with what their rays have found.
#[derive(Clone, Copy)]
pub struct Neighbourhood<'a> {
    /// All tiles of the picture.
    pub grid: &'a TileGrid,
    /// Tiles of the known rows, each at its number modulo their count.
    pub tiles: &'a [TracedTile],
}

impl<'a> Neighbourhood<'a> {
    /// The known findings of a tile.
    #[inline(always)]
    pub fn tile(&self, number: usize) -> Option<&'a TracedTile> {
        self.tiles.get(number % self.tiles.len().max(1))
    }
}

/// The blocks of a tile and those around it, a plane for each of their numbers. Each block stands there twice: beside the one so many
/// rows below it that both are read at once, and beside the one as far above.
#[derive(Debug, Default)]
pub struct LightWindow {
    planes: Vec<f32>,
    stride: usize,
    plane: usize,
}

impl LightWindow {
    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.planes, &other.planes);
    }

    /// Fills it with the blocks of a tile, whose corner and size in pixels these are, and those around it.
    pub fn fill(&mut self, of: Neighbourhood<'_>, corner: [u32; 2], size: [u32; 2], block: u32) {
        let [width, height] = size.map(|v| v.div_ceil(block) as usize + SIDE);
        self.stride = 2 * width;
        self.plane = self.stride * height;
        // Numbers of other windows may stay: only those of blocks with a material are read.
        self.planes.resize(NUMBERS * self.plane, 0.0);
        self.planes[..self.plane].fill(NO_MATERIAL);
        let picture = [of.grid.width(), of.grid.height()];
        let beside = BESIDE as u32 * block;
        let first: [u32; 2] = each!(k => corner[k].saturating_sub(beside));
        let end: [u32; 2] = each!(k => (corner[k] + size[k] + beside).min(picture[k]));
        let [left, top, right, bottom] = of.grid.tiles_of_pixels([first[0], first[1], end[0], end[1]]);
        for row in top..bottom {
            for column in left..right {
                let number = (row * of.grid.columns() + column) as usize;
                let Some(tile) = of.tile(number) else { continue };
                let [tile_x, tile_y, w, h] = of.grid.pixels(number);
                // Corners of tiles are corners of blocks.
                let blocks = |from: u32, to: u32| from / block..to.div_ceil(block);
                for y in blocks(tile_y.max(first[1]), (tile_y + h).min(end[1])) {
                    for x in blocks(tile_x.max(first[0]), (tile_x + w).min(end[0])) {
                        if let Some((receiver, found)) = tile.shown(x - tile_x / block, y - tile_y / block) {
                            let row = (y + BESIDE as u32 - corner[1] / block) as usize;
                            let column = (x + BESIDE as u32 - corner[0] / block) as usize;
                            let at = row * self.stride + 2 * column;
                            self.put(at, receiver, found);
                            if let Some(above) = at.checked_sub(PAIRS * self.stride) {
                                self.put(above + 1, receiver, found);
                            }
                        }
                    }
                }
            }
        }
    }

    /// Writes one block.
    #[inline(always)]
    fn put(&mut self, at: usize, of: &Receiver, found: &Found) {
        let Self { planes, plane, .. } = self;
        // Weights of zero have to make zero of everything.
        let mut write = |number: usize, value: f32| {
            planes[number * *plane + at] = if value.is_finite() { value } else { 0.0 };
        };
        write(MATERIAL, of.material as f32);
        for k in 0..3 {
            write(POSITION + k, of.position[k]);
            write(NORMALS[0] + k, of.normals[0][k]);
            write(NORMALS[1] + k, of.normals[1][k]);
        }
        write(ALPHA, of.alpha[0]);
        write(ALPHA + 1, of.alpha[1]);
        for lobe in TracedLobe::ALL {
            for (k, sum) in found.of_rays(lobe).iter().enumerate() {
                write(SUMS[lobe as usize] + k, *sum);
            }
        }
        for (k, sum) in found.of_lamps().iter().enumerate() {
            write(LAMPS + k, *sum);
        }
    }

    /// Sixteen numbers of a pair of rows, the first at a place.
    #[inline(always)]
    fn load<L: Lanes>(&self, l: L, number: usize, at: usize) -> L::F {
        let values = &self.planes[number * self.plane + at..];
        l.load(values.first_chunk().unwrap_or(&[0.0; LANES]))
    }
}

/// The filter for surfaces of a tile.
#[derive(Clone, Copy)]
pub struct LightFilter<'a> {
    window: &'a LightWindow,
    block: u32,
    rays: Tent,
    lamps: Tent,
}

/// Likeness of a receiver and sixteen blocks, lobe by lobe.
type Likeness<L> = [<L as Lanes>::F; TracedLobe::COUNT];

impl<'a> LightFilter<'a> {
    /// A filter for rays whose turns repeat after so many blocks, of so many pixels along a side each.
    pub fn new(window: &'a LightWindow, period: u32, block: u32) -> Self {
        let half_width = (period as usize).clamp(1, BESIDE) as f32 * block as f32;
        Self { window, block, rays: Tent::new(half_width, block), lamps: Tent::new(OF_LAMPS, block) }
    }

    /// Light of a receiver in this column and row of the tile takes: of what its own group has found, and of what the blocks around its
    /// own have; and what it has found itself of lobes that take less than all.
    #[inline(always)]
    pub fn taken<L: Lanes>(
        &self,
        l: L,
        of: &Receiver,
        [column, row]: [u32; 2],
        (own, group): (&Found, &Found),
    ) -> Found {
        let (most, has_lamps) = (of.most_taken(), own.has_direct());
        let [x, y] = [column, row].map(|v| (v % self.block) as usize);
        let [column, row] = [column / self.block, row / self.block].map(|v| v as usize);
        let place = |pair: usize| (row + y + pair) * self.window.stride + 2 * (column + x);
        // The lane of the receiver's own block, and its pair of rows.
        let lane = 2 * (BESIDE - x) + (BESIDE - y) / PAIRS;
        let pair_of_own = (BESIDE - y) % PAIRS;
        let surroundings = Surroundings::new(l, of, most, !(1_u16 << lane));
        let mut weights = [[l.zero(); PAIRS]; TracedLobe::COUNT];
        let mut of_lamps = [l.zero(); PAIRS];
        for pair in 0..PAIRS {
            let alike = surroundings.of(l, self.window, place(pair), pair == pair_of_own);
            let rays = l.load(&self.rays.weights[y][x][pair]);
            for lobe in TracedLobe::ALL {
                weights[lobe as usize][pair] = rays * alike[lobe as usize];
            }
            of_lamps[pair] = l.load(&self.lamps.weights[y][x][pair]) * alike[0];
        }
        let mut taken = *own;
        let weight = self.rays.own[y][x];
        for lobe in TracedLobe::ALL {
            let most = most[lobe as usize];
            if most > 0.0 {
                let sums = taken.of_rays_mut(lobe);
                for (sum, group) in sums.iter_mut().zip(group.of_rays(lobe)) {
                    *sum = if most < 1.0 { *sum } else { 0.0 } + most * (weight * group);
                }
                self.add_up(l, (&weights[lobe as usize], most), place, SUMS[lobe as usize], sums);
            }
        }
        if has_lamps {
            let weight = self.lamps.own[y][x];
            let sums = taken.of_lamps_mut();
            sums.iter_mut().zip(group.of_lamps()).for_each(|(sum, group)| *sum = weight * group);
            self.add_up(l, (&of_lamps, 1.0), place, LAMPS, sums);
        }
        taken
    }

    /// Adds the sums of blocks, which lie at these places, by their weights.
    #[inline(always)]
    fn add_up<L: Lanes>(
        &self,
        l: L,
        (weights, most): (&[L::F; PAIRS], f32),
        place: impl Fn(usize) -> usize,
        first: usize,
        sums: &mut [f32],
    ) {
        for (k, sum) in sums.iter_mut().enumerate() {
            let mut all = l.zero();
            for (pair, weight) in weights.iter().enumerate() {
                all = all + self.window.load(l, first + k, place(pair)) * *weight;
            }
            *sum += most * added(all.to_array());
        }
    }
}

/// The sum of all lanes.
#[inline(always)]
fn added(lanes: [f32; LANES]) -> f32 {
    let eight: [f32; 8] = std::array::from_fn(|k| lanes[k] + lanes[k + 8]);
    let four: [f32; 4] = std::array::from_fn(|k| eight[k] + eight[k + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}

/// The receiver's own numbers, to which those around it are compared.
struct Surroundings<L: Lanes> {
    material: L::F,
    position: [L::F; 3],
    face: [L::F; 3],
    normals: [[L::F; 3]; 2],
    alpha: [L::F; 2],
    slopes: [[f32; 2]; 2],
    most: Shares,
    /// All lanes but that of its own block.
    others: L::M,
}

impl<L: Lanes> Surroundings<L> {
    #[inline(always)]
    fn new(l: L, of: &Receiver, most: Shares, others: u16) -> Self {
        Self {
            material: l.splat(of.material as f32),
            position: each!(v in of.position => l.splat(v)),
            face: each!(v in of.face => l.splat(v)),
            normals: each!(normal in of.normals => each!(v in normal => l.splat(v))),
            alpha: each!(v in of.alpha => l.splat(v)),
            slopes: of.slopes(),
            most,
            others: l.mask(others),
        }
    }

    /// Likeness of sixteen blocks; `is_own` says that its own is one of them.
    #[inline(always)]
    fn of(&self, l: L, window: &LightWindow, at: usize, is_own: bool) -> Likeness<L> {
        let (zero, one) = (l.zero(), l.splat(1.0));
        let mut same = window.load(l, MATERIAL, at).eq(self.material);
        if is_own {
            same = same & self.others;
        }
        if !same.any() {
            return [zero; TracedLobe::COUNT];
        }
        let apart: [L::F; 3] = each!(k => window.load(l, POSITION + k, at) - self.position[k]);
        let height = (apart[0] * self.face[0] + apart[1] * self.face[1]) + apart[2] * self.face[2];
        let room = squared(&apart) * PLANE;
        let some = room.gt(zero);
        let level = some.select((room - height.squared()) / some.select(room, one), one);
        let level = (same & level.gt(zero)).select(level, zero);
        let base = self.turned(l, window, at, 0);
        let mut alike = [level * (base * (1.0 / TURNED)).one_minus().at_least(0.0), zero, zero];
        if self.most[1] > 0.0 {
            alike[1] = self.reflects_alike(l, window, at, 0, (level, base));
        }
        if self.most[2] > 0.0 {
            alike[2] = self.reflects_alike(l, window, at, 1, (level, self.turned(l, window, at, 1)));
        }
        alike
    }

    /// Squared distance of the unit normals of blocks, of the base or the coat, from its own.
    #[inline(always)]
    fn turned(&self, l: L, window: &LightWindow, at: usize, which: usize) -> L::F {
        let apart: [L::F; 3] = each!(c => window.load(l, NORMALS[which] + c, at) - self.normals[which][c]);
        squared(&apart)
    }

    /// Likeness of the lobes of blocks, of the base or the coat, that lie in one plane by `level` and whose normals are so far
    /// [`turned`](Self::turned).
    #[inline(always)]
    fn reflects_alike(
        &self,
        l: L,
        window: &LightWindow,
        at: usize,
        which: usize,
        (level, turned): (L::F, L::F),
    ) -> L::F {
        let [turn, rougher] = self.slopes[which];
        let rougher = (window.load(l, ALPHA + which, at) - self.alpha[which]).abs() * rougher;
        level * (turned * turn).one_minus().at_least(0.0) * rougher.one_minus().at_least(0.0)
    }
}

#[inline(always)]
fn squared<F: Float>(v: &[F; 3]) -> F {
    (v[0].squared() + v[1].squared()) + v[2].squared()
}
