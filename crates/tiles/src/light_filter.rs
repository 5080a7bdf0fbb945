//! A filter over the findings of the rays of neighbouring pixels: cross-bilateral (Eisemann and Durand 2004; over
//! interleaved samples, Segovia et al. 2006) over sums, so that what comes of it is a ratio of sums.
//!
//! Weights are a tent of the distance in pixels, times how alike surfaces are in material, plane, normal and roughness. Rays are
//! turned in a pattern that repeats, and half the width of the tent is its period: a box as wide, taken twice, which weights all of
//! the pattern alike, wherever it stands, and leaves nothing of it in the picture. More rays have a shorter period, so that
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

/// Half the width of the widest tent, and pixels beside a tile that are looked at. The widest has one pixel less on each side.
pub const MARGIN: usize = 8;

/// Half the width of the tent for the light of lamps, whose points repeat after two pixels: the edges of shadows stay where they are.
const OF_LAMPS: usize = 2;

/// Rows of the widest tent.
const ROWS: usize = 2 * MARGIN - 1;

/// Numbers of a pixel: material, position, normals and alphas, then the sums of each lobe and of lamps.
const MATERIAL: usize = 0;
const POSITION: usize = 1;
const NORMALS: [usize; 2] = [4, 7];
const ALPHA: usize = 10;
const SUMS: [usize; TracedLobe::COUNT] = [12, 21, 32];
const LAMPS: usize = 17;
const NUMBERS: usize = 43;

/// Material of pixels without a surface.
const NO_MATERIAL: f32 = -1.0;

/// A tent about the middle lane.
#[derive(Clone, Copy)]
struct Tent {
    half_width: usize,
    weights: [f32; LANES],
}

impl Tent {
    fn new(half_width: usize) -> Self {
        let weight = |lane: usize| {
            let off = lane.abs_diff(MARGIN);
            half_width.saturating_sub(off) as f32 / half_width as f32
        };
        Self { half_width, weights: std::array::from_fn(weight) }
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

/// The pixels of a tile and those around it, a plane for each of their numbers.
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

    /// Fills it with the pixels of a tile, whose corner and size these are, and those around it.
    pub fn fill(&mut self, of: Neighbourhood<'_>, corner: [u32; 2], size: [u32; 2]) {
        let [width, height] = size.map(|v| v as usize + 2 * MARGIN);
        self.stride = width;
        self.plane = width * height;
        // Numbers of other windows may stay: only those of pixels with a material are read.
        self.planes.resize(NUMBERS * self.plane, 0.0);
        self.planes[..self.plane].fill(NO_MATERIAL);
        let picture = [of.grid.width(), of.grid.height()];
        let first: [u32; 2] = each!(k => corner[k].saturating_sub(MARGIN as u32));
        let end: [u32; 2] = each!(k => (corner[k] + size[k] + MARGIN as u32).min(picture[k]));
        let [left, top, right, bottom] = of.grid.tiles_of_pixels([first[0], first[1], end[0], end[1]]);
        for row in top..bottom {
            for column in left..right {
                let number = (row * of.grid.columns() + column) as usize;
                let Some(tile) = of.tile(number) else { continue };
                let [tile_x, tile_y, w, h] = of.grid.pixels(number);
                for y in tile_y.max(first[1])..(tile_y + h).min(end[1]) {
                    for x in tile_x.max(first[0])..(tile_x + w).min(end[0]) {
                        if let Some((receiver, found)) = tile.shown(x - tile_x, y - tile_y) {
                            let at = (y as usize + MARGIN - corner[1] as usize) * width
                                + (x as usize + MARGIN - corner[0] as usize);
                            self.put(at, receiver, found);
                        }
                    }
                }
            }
        }
    }

    /// Writes one pixel.
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

    /// Sixteen numbers of a row, the first at a place.
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
    rays: Tent,
    lamps: Tent,
}

/// Likeness of a receiver and sixteen neighbours of a row, lobe by lobe.
type Likeness<L> = [<L as Lanes>::F; TracedLobe::COUNT];

impl<'a> LightFilter<'a> {
    /// A filter for rays whose turns repeat after so many pixels, at most [`MARGIN`].
    pub fn new(window: &'a LightWindow, period: u32) -> Self {
        let half_width = (period as usize).clamp(1, MARGIN);
        Self { window, rays: Tent::new(half_width), lamps: Tent::new(OF_LAMPS) }
    }

    /// Adds to what a group has found what the pixels around its own have, which lies in this column and row of the tile.
    #[inline(always)]
    pub fn add_neighbours<L: Lanes>(
        &self,
        l: L,
        of: &Receiver,
        most: Shares,
        [column, row]: [u32; 2],
        sum: &mut Found,
    ) {
        let has_lamps = sum.has_direct();
        let takes = most.iter().any(|most| *most > 0.0);
        let reach = self.rays.half_width.max(if has_lamps { OF_LAMPS } else { 1 });
        if reach < 2 || !(takes || has_lamps) {
            return;
        }
        let [column, row] = [column as usize, row as usize];
        let place = |line: usize| (row + line + MARGIN + 1 - reach) * self.window.stride + column;
        let mut weights = [[l.zero(); ROWS]; TracedLobe::COUNT];
        let mut of_lamps = [l.zero(); ROWS];
        let lines = 2 * reach - 1;
        let surroundings = Surroundings::new(l, of, most);
        for line in 0..lines {
            let off = line + MARGIN + 1 - reach;
            let alike = surroundings.of(l, self.window, place(line), off == MARGIN);
            let own = self.rays.weights[off];
            let columns = l.load(&self.rays.weights) * own;
            for lobe in TracedLobe::ALL {
                let most = most[lobe as usize];
                weights[lobe as usize][line] = columns * alike[lobe as usize] * most;
            }
            of_lamps[line] = l.load(&self.lamps.weights) * self.lamps.weights[off] * alike[0];
        }
        for lobe in TracedLobe::ALL {
            if most[lobe as usize] > 0.0 {
                let weights = &weights[lobe as usize][..lines];
                self.add_up(l, weights, place, SUMS[lobe as usize], sum.of_rays_mut(lobe));
            }
        }
        if has_lamps {
            self.add_up(l, &of_lamps[..lines], place, LAMPS, sum.of_lamps_mut());
        }
    }

    /// Adds the sums of neighbours, which lie in lines at these places, by their weights.
    #[inline(always)]
    fn add_up<L: Lanes>(
        &self,
        l: L,
        weights: &[L::F],
        place: impl Fn(usize) -> usize,
        first: usize,
        sums: &mut [f32],
    ) {
        for (k, sum) in sums.iter_mut().enumerate() {
            let mut all = l.zero();
            for (line, weight) in weights.iter().enumerate() {
                all = all + self.window.load(l, first + k, place(line)) * *weight;
            }
            *sum += added(all.to_array());
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
    /// All lanes but that of its own pixel.
    others: L::M,
}

impl<L: Lanes> Surroundings<L> {
    #[inline(always)]
    fn new(l: L, of: &Receiver, most: Shares) -> Self {
        Self {
            material: l.splat(of.material as f32),
            position: each!(v in of.position => l.splat(v)),
            face: each!(v in of.face => l.splat(v)),
            normals: each!(normal in of.normals => each!(v in normal => l.splat(v))),
            alpha: each!(v in of.alpha => l.splat(v)),
            slopes: of.slopes(),
            most,
            others: l.mask(!(1_u16 << MARGIN)),
        }
    }

    /// Likeness of sixteen pixels; `is_own` says that its own is the middle one of them.
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
        let squared = |v: &[L::F; 3]| (v[0].squared() + v[1].squared()) + v[2].squared();
        let apart: [L::F; 3] = each!(k => window.load(l, POSITION + k, at) - self.position[k]);
        let height = (apart[0] * self.face[0] + apart[1] * self.face[1]) + apart[2] * self.face[2];
        let room = squared(&apart) * PLANE;
        let some = room.gt(zero);
        let level = some.select((room - height.squared()) / some.select(room, one), one);
        let level = (same & level.gt(zero)).select(level, zero);
        let turned = |k: usize| -> L::F {
            let apart: [L::F; 3] = each!(c => window.load(l, NORMALS[k] + c, at) - self.normals[k][c]);
            squared(&apart)
        };
        let base = turned(0);
        let reflected = |k: usize, turned: L::F| {
            let [turn, rougher] = self.slopes[k];
            let rougher = (window.load(l, ALPHA + k, at) - self.alpha[k]).abs() * rougher;
            level * (turned * turn).one_minus().at_least(0.0) * rougher.one_minus().at_least(0.0)
        };
        [
            level * (base * (1.0 / TURNED)).one_minus().at_least(0.0),
            if self.most[1] > 0.0 { reflected(0, base) } else { zero },
            if self.most[2] > 0.0 { reflected(1, turned(1)) } else { zero },
        ]
    }
}
