//! Choice of the surfaces that are shaded more than once a pixel.
//!
//! Asked for a rate above one, a picture has it where one shading a pixel shows: highlights that are sharper than what normals
//! turn within a pixel, colours that shrink, alpha masks and normal maps under a shine. The rest,
//! most of most pictures, is shaded once. Decided triangle by triangle of material, screen and vertices alone.
//!
//! Pictures with shadows have that rate along narrow edges at least: a sill, a frame or the lip of a panel gap turns by a right angle
//! within a pixel, and one shading takes a lamp's mirror image for all of it in one pixel and for nothing in the next, a
//! row of white dots.

use super::options::RenderOptions;
use super::pass::FrameContext;
use super::tile_triangles::TileTriangles;
use overcoat_core::each;
use overcoat_core::math::triple::dot;
use overcoat_scene::{AlphaMode, Filter, Material, Mesh, MipFilter, Texture, TextureRef};
use overcoat_stages::gbuffer::{Draw, SourceTriangle, TriangleSource};
use overcoat_stages::raster::SUBPIXELS;
use overcoat_stages::shade::{NormalFilter, least_roughness};

/// Condition under which triangles of one material are shaded more than once a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finer {
    /// Never.
    Never,
    /// Always.
    Always,
    /// Only above one of these thresholds.
    Where {
        /// Change of the unit normal from pixel to pixel, its length squared.
        turn: f32,
        /// Area of its colours' texture in texels, and by which coordinates it is read: how far that shrinks.
        colors: Option<(f32, usize)>,
    },
    /// Only along edges whose unit normal changes by more than this from pixel to pixel, its length squared. Triangles smaller than
    /// two pixels are left out: their neighbours sample the edge in the same pixel.
    Edges(f32),
}

/// Normals that turn by this share of the width of a highlight (its alpha) a pixel move it by so much that it shows.
const SHARE_OF_LOBE: f32 = 0.25;

/// The least alpha that counts: sharper reflections are smooth again as far as the environment is.
const LEAST_ALPHA: f32 = 0.04;

/// From this perceptual roughness on, normal maps have no highlights that are narrower than their texels' turns.
const MATT: f32 = 0.6;

/// Texels a pixel, as areas, from which on mip levels blur colours too much: those of 2 x 2 texels are a level that has lost
/// nothing yet of what a pixel shows.
const SHRUNK: f32 = 4.0;

impl Finer {
    /// Rule of a material of the scene.
    fn of(material: &Material, textures: &[Texture]) -> Self {
        let unfiltered = |texture: &Texture| {
            let sampler = texture.sampler();
            sampler.minification == Filter::Nearest || sampler.mip == MipFilter::None
        };
        let mut read = material.textures().map(|place| &textures[place.texture.index()]);
        if matches!(material.alpha_mode, AlphaMode::Mask { .. }) || read.any(unfiltered) {
            return Self::Always;
        }
        let least = least_roughness(material);
        if material.has_normal_maps() && least < MATT && !material.unlit {
            return Self::Always;
        }
        let turn = if material.unlit { f32::INFINITY } else { least_turn(least) };
        let colors = [&material.base_color_texture, &material.emissive_texture].into_iter().flatten();
        let colors = colors.map(|place| (area(place, textures), usize::from(place.uv_set & 1)));
        let colors = colors.reduce(|a, b| if b.0 > a.0 { b } else { a });
        if material.unlit && colors.is_none() { Self::Never } else { Self::Where { turn, colors } }
    }

    /// Rule of a material that is shaded more than once along narrow edges alone.
    fn of_edges(material: &Material) -> Self {
        let turn = least_turn(least_roughness(material));
        if material.unlit {
            Self::Never
        } else {
            Self::Edges(if turn > NormalFilter::NARROW { turn } else { NormalFilter::NARROW })
        }
    }

    /// Lists the rules of all materials of a scene, in their order, in place of what was there: none at a rate of one.
    pub fn list(materials: &[Material], textures: &[Texture], options: &RenderOptions, out: &mut Vec<Self>) {
        out.clear();
        if options.shading_rate > 1 {
            let of = |material| {
                if options.shade_everywhere { Self::Always } else { Self::of(material, textures) }
            };
            out.extend(materials.iter().map(of));
        } else if options.shading_groups() > 1 {
            out.extend(materials.iter().map(Self::of_edges));
        }
    }
}

/// Change of the unit normal from pixel to pixel, its length squared, from which on highlights of a perceptual roughness show that
/// they are shaded once.
fn least_turn(roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    let turn = SHARE_OF_LOBE * if alpha > LEAST_ALPHA { alpha } else { LEAST_ALPHA };
    turn * turn
}

/// Texels in a square of texture coordinates of side 1.
fn area(place: &TextureRef, textures: &[Texture]) -> f32 {
    let texture = &textures[place.texture.index()];
    let [[a, b, _], [c, d, _]] = place.transform.rows;
    (texture.width() as f32 * texture.height() as f32) * (a * d - b * c).abs()
}

/// True if the fragments of a triangle or point are shaded more than once a pixel. The rate is above one.
#[inline(never)]
pub fn is_finer(frame: &FrameContext<'_>, triangles: &TileTriangles<'_>, identity: u32) -> bool {
    let (chunk, index) = triangles.identities[identity as usize];
    let chunk = &frame.chunks[chunk as usize];
    let draw = &frame.shade.draws[chunk.draw as usize];
    match frame.finer[draw.material as usize] {
        Finer::Never => false,
        Finer::Always if chunk.points => true,
        // Points have one value each of everything.
        _ if chunk.points => false,
        // Where triangles are merged, one answers for the pixel.
        rule if (frame.merge.is_some() || matches!(rule, Finer::Edges(_)))
            && chunk.triangles[index as usize].small_samples != 0 =>
        {
            false
        }
        Finer::Always => true,
        Finer::Edges(turn) => {
            let on_screen = OnScreen { draw, source: triangles.triangle(identity) };
            // A change that is no number is none that is small.
            let is_even = on_screen.turn() <= turn;
            !is_even
        }
        Finer::Where { turn, colors } => {
            let on_screen = OnScreen { draw, source: triangles.triangle(identity) };
            // A change that is no number is none that is small.
            let is_even = on_screen.turn() <= turn
                && colors.is_none_or(|(texels, set)| on_screen.area(set) * texels <= SHRUNK);
            !is_even
        }
    }
}

/// A triangle as it changes from pixel to pixel: on its plane on the screen, perspective left out.
struct OnScreen<'a> {
    draw: &'a Draw<'a>,
    source: SourceTriangle<'a>,
}

impl OnScreen<'_> {
    /// Change of the unit normal from pixel to pixel, along the axis along which it is more: length squared.
    fn turn(&self) -> f32 {
        let normals = self.attribute(Mesh::shading_normals);
        let normals = each!(v in normals => {
            let square = dot(v, v);
            let length = if square > 0.0 { square.sqrt() } else { 1.0 };
            each!(c in v => c / length)
        });
        let [across, down] = self.changes(&normals);
        let [across, down] = [dot(across, across), dot(down, down)];
        if across > down { across } else { down }
    }

    /// Area that a pixel has in a set of texture coordinates.
    fn area(&self, set: usize) -> f32 {
        let uvs = self.attribute(if set == 0 { |mesh| mesh.uvs(0) } else { |mesh| mesh.uvs(1) });
        let [across, down] = self.changes(&uvs);
        (across[0] * down[1] - across[1] * down[0]).abs()
    }

    /// A vertex attribute, in the order of the mesh; 0 where there is none.
    #[inline(always)]
    fn attribute<const N: usize>(&self, of: fn(&Mesh) -> &[[f32; N]]) -> [[f32; N]; 3] {
        let values = of(self.draw.mesh);
        each!(vertex in self.source.screen.vertices() => {
            values.get(vertex as usize).copied().unwrap_or([0.0; N])
        })
    }

    /// Change of what the vertices have, per pixel to the right and per pixel down.
    #[inline(always)]
    fn changes<const N: usize>(&self, own: &[[f32; N]; 3]) -> [[f32; N]; 2] {
        let SourceTriangle { screen, clip, .. } = &self.source;
        let mut corners = match clip {
            Some(corners) => each!(at in **corners => {
                each!(k => own[0][k] + at[0] * (own[1][k] - own[0][k]) + at[1] * (own[2][k] - own[0][k]))
            }),
            None => *own,
        };
        if screen.is_swapped() {
            corners.swap(1, 2);
        }
        let side = |to: i32, from: i32| (to - from) as f32 * (1.0 / SUBPIXELS as f32);
        let [x1, x2] = [side(screen.x[1], screen.x[0]), side(screen.x[2], screen.x[0])];
        let [y1, y2] = [side(screen.y[1], screen.y[0]), side(screen.y[2], screen.y[0])];
        let area = x1 * y2 - x2 * y1;
        let sides: [[f32; N]; 2] =
            [each!(k => corners[1][k] - corners[0][k]), each!(k => corners[2][k] - corners[0][k])];
        [
            each!(k => (sides[0][k] * y2 + sides[1][k] * -y1) / area),
            each!(k => (sides[0][k] * -x2 + sides[1][k] * x1) / area),
        ]
    }
}
