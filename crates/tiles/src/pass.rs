//! Parameters of a run over all tiles: those that never change in a frame, and the kind of run.

use super::draws::DrawState;
use super::ground_pixels::GroundView;
use super::light_filter::Neighbourhood;
use super::reach::Reach;
use super::relief::Relief;
use super::shading_rate::Finer;
use super::splats::SplatScene;
use super::work::Work;
use overcoat_core::built::Splats;
use overcoat_core::frame::{Aov, Developer, TargetWriter};
use overcoat_scene::{AlphaMode, Texture};
use overcoat_stages::geometry::Chunk;
use overcoat_stages::raster::{Disc, SamplePattern, TileOrigin};
use overcoat_stages::shade::{Effects, ShadeContext, ShadingCost};
use overcoat_stages::tile::{Run, TileBins, TileGrid};

/// State that all tiles of a frame share, in every pass.
pub struct FrameContext<'a> {
    /// Tiles of the picture.
    pub grid: TileGrid,
    /// Samples of a pixel.
    pub pattern: &'a SamplePattern,
    /// Depth of the camera's far limit, see [`View::least_depth`](overcoat_stages::geometry::View::least_depth).
    pub least_depth: f32,
    /// Triangles on the screen, by draw.
    pub chunks: &'a [Chunk],
    /// The triangles of each tile.
    pub bins: &'a TileBins,
    /// State of each draw.
    pub states: &'a [DrawState],
    /// Splats of the scene, and those of each tile.
    pub splats: SplatScene<'a>,
    /// Scene and lights as shading reads them.
    pub shade: ShadeContext<'a>,
    /// Shading cost of each material.
    pub costs: &'a [ShadingCost],
    /// Reach of the lights on the picture.
    pub reach: &'a Reach,
    /// The environment is the background.
    pub show_environment: bool,
    /// The floor, if it is seen.
    pub ground: Option<GroundView<'a>>,
    /// Factors of the light of opaque surfaces, if any differ from 1.
    pub relief: Option<&'a Relief>,
    /// Something may tint what is behind the picture.
    pub tints: bool,
    /// Least square of the cosine between the normals of small triangles that are shaded as one, if any are.
    pub merge: Option<f32>,
    /// Rule of each material for where the samples of a pixel are shaded in groups: none at one shading a pixel.
    pub finer: &'a [Finer],
    /// Columns and rows of the tiles that are drawn, and the ends; others may be, where something refracts what is in them.
    pub drawn: [u32; 4],
}

/// Kind of a pass: the surfaces that it draws, and what it draws them over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassKind {
    /// Opaque surfaces alone: the picture that refracting ones show of what is behind them.
    Backdrop,
    /// All surfaces and splats, of a scene without refracting ones.
    Whole,
    /// All surfaces and splats, into the pixels of [`PassKind::Backdrop`], which stay wherever nothing else is drawn.
    ///
    /// The other tiles are drawn anew, opaque surfaces included. Keeping what the first pass has of these would save 1, 5 and 9
    /// percent of the tiles' time at the most (the materials' sphere, SunglassesKhronos, AttenuationTest; 512 x 512 pixels, 8
    /// samples, one thread), without what keeping costs: blending needs depth and triangle of each sample and the radiance of
    /// each fragment, some 100 bytes a pixel, six times what its own pixels take, and 6 GB in the largest picture.
    OverBackdrop,
}

impl PassKind {
    /// The passes of a frame, in their order.
    pub fn of(states: &[DrawState]) -> &'static [Self] {
        if states.iter().any(|state| state.refracts) {
            &[Self::Backdrop, Self::OverBackdrop]
        } else {
            &[Self::Whole]
        }
    }
}

/// Purpose of a pass.
#[derive(Clone, Copy)]
pub enum Purpose<'a> {
    /// Linear pixels, and the outputs beside them.
    Draw(Wanted<'a>),
    /// Work is counted and not done, and there will be no picture: to find out which limit is passed first.
    Count,
    /// Texture feedback: nothing is shaded, fragments ask lazy textures for the levels that they read.
    Feedback,
    /// Nothing is shaded: opaque fragments send their rays, before those of any tile around are shaded.
    Trace,
    /// Nothing is shaded: the opaque fragments of few pixels send their rays, to find out what those of all would take.
    Probe,
}

/// Outputs of a pass beside linear pixels.
#[derive(Clone, Copy, Default)]
pub struct Wanted<'a> {
    /// Tone mapping to the screen's pixels, if they are wanted.
    pub developer: Option<Developer>,
    /// Writer of a target's pixels, if there is one.
    pub target: Option<TargetWriter>,
    /// White and black pixels of the screen are counted.
    pub clipping: bool,
    /// Planes of the G-buffer.
    pub aovs: &'a [Aov],
    /// Hashes of the fragments.
    pub hashes: bool,
    /// Nothing but planes of the G-buffer is wanted: surfaces are not shaded.
    pub only_planes: bool,
}

/// One run over all tiles.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// The frame that it is a pass of.
    pub frame: &'a FrameContext<'a>,
    /// Surfaces that it draws.
    pub kind: PassKind,
    /// Purpose of the run.
    pub purpose: Purpose<'a>,
    /// The effects, as far as they are prepared.
    pub effects: Effects<'a>,
    /// Counters of the work, and its limits.
    pub work: &'a Work<'a>,
    /// Findings of the rays in the tiles around those that are drawn, if rays are sent.
    pub traced_tiles: Option<Neighbourhood<'a>>,
}

/// Side of the square of pixels of which one sends rays for all in [`Purpose::Probe`].
pub const PROBED: u32 = 8;

impl<'a> Pass<'a> {
    /// True if nothing is drawn.
    #[inline(always)]
    pub fn only_counts(&self) -> bool {
        !matches!(self.purpose, Purpose::Draw(_))
    }

    /// True if opaque fragments send their rays, and that is all.
    #[inline(always)]
    pub fn traces(&self) -> bool {
        matches!(self.purpose, Purpose::Trace | Purpose::Probe)
    }

    /// True if only few pixels do, whose work counts for all.
    #[inline(always)]
    pub fn probes(&self) -> bool {
        matches!(self.purpose, Purpose::Probe)
    }

    /// True if the fragments of a pixel of the picture send rays.
    #[inline(always)]
    pub fn sends_from(&self, [x, y]: [u32; 2]) -> bool {
        !self.probes() || (y % PROBED == PROBED / 2 && (x + 3 * (y / PROBED)).is_multiple_of(PROBED))
    }

    /// True if fragments ask for the textures that they read, and that is all.
    #[inline(always)]
    pub fn gives_feedback(&self) -> bool {
        matches!(self.purpose, Purpose::Feedback)
    }

    /// True if surfaces are described by planes of the G-buffer, and that is all.
    #[inline(always)]
    pub fn only_describes(&self) -> bool {
        matches!(&self.purpose, Purpose::Draw(Wanted { only_planes: true, .. }))
    }

    /// Outputs beside linear pixels.
    pub fn wanted(&self) -> Wanted<'a> {
        match self.purpose {
            Purpose::Draw(wanted) => wanted,
            Purpose::Count | Purpose::Feedback | Purpose::Trace | Purpose::Probe => Wanted::default(),
        }
    }

    /// Tone mapping to the screen's pixels, if they are wanted.
    #[inline(always)]
    pub fn developer(&self) -> Option<&Developer> {
        match &self.purpose {
            Purpose::Draw(wanted) => wanted.developer.as_ref(),
            Purpose::Count | Purpose::Feedback | Purpose::Trace | Purpose::Probe => None,
        }
    }

    /// Writer of a target's pixels, if there is one.
    #[inline(always)]
    pub fn target(&self) -> Option<&TargetWriter> {
        match &self.purpose {
            Purpose::Draw(wanted) => wanted.target.as_ref(),
            Purpose::Count | Purpose::Feedback | Purpose::Trace | Purpose::Probe => None,
        }
    }

    /// True if a tile is drawn.
    #[inline(always)]
    pub fn draws(&self, tile: usize) -> bool {
        let FrameContext { grid, drawn: [left, top, right, bottom], .. } = self.frame;
        let (column, row) = (tile as u32 % grid.columns(), tile as u32 / grid.columns());
        self.kind == PassKind::Backdrop
            || ((*left..*right).contains(&column) && (*top..*bottom).contains(&row))
    }

    /// True if white and black pixels of the screen are counted.
    #[inline(always)]
    pub fn counts_clipping(&self) -> bool {
        matches!(&self.purpose, Purpose::Draw(Wanted { clipping: true, .. }))
    }

    /// Alpha mode by which a draw covers what is behind it; `None` if the pass leaves it out.
    #[inline(always)]
    pub fn alpha_mode(&self, state: &DrawState) -> Option<AlphaMode> {
        match if state.transmissive { AlphaMode::Blend } else { state.alpha_mode } {
            AlphaMode::Blend if self.kind == PassKind::Backdrop => None,
            mode => Some(mode),
        }
    }

    /// The tile of a number.
    #[inline(always)]
    pub fn tile(&self, number: usize) -> Tile<'a> {
        let FrameContext { grid, bins, splats, .. } = self.frame;
        let [left, top, width, height] = grid.pixels(number);
        // Like blended surfaces they are no part of what refracting ones see behind them.
        let splats = if self.kind == PassKind::Backdrop { &[] } else { splats.runs(number) };
        let runs = bins.runs(number);
        let transmissive =
            self.kind != PassKind::Backdrop && runs.iter().any(|run| self.frame.state(run).transmissive);
        let (corner, size, origin) = ([left, top], [width, height], grid.origin(number));
        Tile { corner, size, origin, runs, splats, transmissive }
    }

    /// True if the pixels of a tile are final already, because the pass before has drawn all there is in it, and no
    /// more than pixels is wanted.
    pub fn keeps(&self, tile: &Tile<'_>) -> bool {
        let blends = || tile.runs.iter().any(|run| self.frame.state(run).alpha_mode == AlphaMode::Blend);
        let wanted = match &self.purpose {
            Purpose::Draw(wanted) => wanted.hashes || !wanted.aovs.is_empty(),
            Purpose::Count | Purpose::Probe => false,
            // Its fragments are wanted.
            Purpose::Feedback | Purpose::Trace => true,
        };
        self.kind == PassKind::OverBackdrop
            && !wanted
            && tile.splats().is_empty()
            && !tile.transmissive
            && !blends()
    }
}

impl<'a> FrameContext<'a> {
    /// The same frame, with other forms of the scene's textures.
    pub fn with_textures<'b>(&self, textures: &'b [Texture]) -> FrameContext<'b>
    where
        'a: 'b,
    {
        let frame: &FrameContext<'b> = self;
        FrameContext { shade: ShadeContext { textures, ..frame.shade }, ..*frame }
    }

    /// The draw that a run's triangles belong to.
    #[inline(always)]
    pub fn state(&self, run: &Run) -> &DrawState {
        &self.states[self.chunks[run.chunk as usize].draw as usize]
    }

    /// The disc of a point of a chunk.
    #[inline(always)]
    pub fn disc(&self, chunk: &Chunk, index: u32) -> Option<Disc> {
        let points = self.states[chunk.draw as usize].points.as_ref()?;
        points.disc(self.shade.draws[chunk.draw as usize].mesh, chunk.range.start + index as usize)
    }

    /// The material of all triangles of some runs, if it is one.
    pub fn one_material(&self, runs: &[Run]) -> Option<u32> {
        let of = |run: &Run| self.shade.draws[self.chunks[run.chunk as usize].draw as usize].material;
        let first = of(runs.first()?);
        runs.iter().all(|run| of(run) == first).then_some(first)
    }
}

/// One tile, and what a pass draws in it.
#[derive(Clone, Copy)]
pub struct Tile<'a> {
    /// Left and top pixel.
    pub corner: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The corner as the rasterizer has it.
    pub origin: TileOrigin,
    /// Its triangles and points.
    pub runs: &'a [Run],
    /// Its splats.
    splats: &'a [Run],
    /// Something that is drawn is transmissive.
    pub transmissive: bool,
}

impl<'a> Tile<'a> {
    /// Its splats.
    #[inline(always)]
    pub fn splats(&self) -> &'a [Run] {
        if Splats::IS_BUILT { self.splats } else { &[] }
    }
}
