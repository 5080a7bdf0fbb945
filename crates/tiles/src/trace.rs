//! Hashes of what each stage hands to the next: the first that differs between two machines names the stage to look
//! into.
//!
//! A stage's hash is the sum, modulo 2^128, of the hashes of its items (a triangle, a fragment's samples, a fragment's
//! surface), each with a key that says where it belongs. A sum, because the order of items depends on threads and
//! tiles and their bits must not.

use super::draws::DrawState;
use super::tile_shading::ShadedFragment;
use overcoat_core::frame::Frame;
use overcoat_scene::Scene;
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::gbuffer::layout::{self, SurfacePlanes};
use overcoat_stages::geometry::{Chunk, ScreenVertices};
use overcoat_stages::light::PrefilteredEnvironment;
use overcoat_stages::shade::{LampOcclusion, LightOcclusion, TracedLight};
use overcoat_stages::splat::ScreenSplat;
use std::ops::Range;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Hashes of the stages of one picture, in the order of the stages. Equal for equal input and options on every machine,
/// whatever the number of threads, the size of tiles and the instruction set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct StageHashes {
    /// Meshes, splats and textures as they were loaded.
    pub scene: u128,
    /// The filtered environment.
    pub environment: u128,
    /// Directions of the environment's light, and the depth maps of each; 0 without.
    pub depth_maps: u128,
    /// Parts of rectangles and tubes, and the depth maps of all lamps; 0 without.
    pub lamp_maps: u128,
    /// Triangles that rays can hit, and in which order they are listed for that; 0 without rays.
    pub hierarchy: u128,
    /// Light that reaches the floor, from above; 0 without a floor.
    pub ground: u128,
    /// Vertices on the screen, triangles that are clipped, culled and set up, and splats in their order.
    pub geometry: u128,
    /// Visibility: the triangle that each sample sees.
    pub raster: u128,
    /// Surfaces of the fragments, every plane of the G-buffer that their models read.
    pub gbuffer: u128,
    /// Occlusion of the fragments by other surfaces, and the light that those send; 0 without maps.
    pub visibility: u128,
    /// Radiance and opacity of the fragments.
    pub shading: u128,
    /// The frame: see [`Frame::frame_hash`], which is this number.
    pub resolve: u128,
}

impl StageHashes {
    /// Names and hashes, in the order of the stages.
    pub fn stages(&self) -> impl Iterator<Item = (&'static str, u128)> + use<> {
        [
            ("scene", self.scene),
            ("environment", self.environment),
            ("depth_maps", self.depth_maps),
            ("lamp_maps", self.lamp_maps),
            ("hierarchy", self.hierarchy),
            ("ground", self.ground),
            ("geometry", self.geometry),
            ("raster", self.raster),
            ("gbuffer", self.gbuffer),
            ("visibility", self.visibility),
            ("shading", self.shading),
            ("resolve", self.resolve),
        ]
        .into_iter()
    }

    /// Name of the first stage whose hash is another one.
    #[must_use]
    pub fn first_difference(&self, other: &Self) -> Option<&'static str> {
        self.stages().zip(other.stages()).find(|(a, b)| a != b).map(|((name, _), _)| name)
    }
}

/// Key of a fragment, in terms that no tile decides: column and row in the picture, chunk, triangle in the chunk.
pub type FragmentKey = [u32; 4];

/// Sums over the fragments of one tile, or of all.
#[derive(Clone, Debug, Default)]
pub struct FragmentHashes {
    raster: u128,
    gbuffer: u128,
    visibility: u128,
    shading: u128,
    bytes: Vec<u8>,
}

impl FragmentHashes {
    /// Adds the samples of a fragment.
    pub fn add_samples(&mut self, key: FragmentKey, mask: u16) {
        self.start(key).extend(mask.to_le_bytes());
        self.raster = self.raster.wrapping_add(xxh3_128(&self.bytes));
    }

    /// Adds what lane `lane` has in some rows of the G-buffer.
    pub fn add_surface(&mut self, key: FragmentKey, planes: &SurfacePlanes, rows: Range<usize>, lane: usize) {
        let rows = planes.rows[rows].iter();
        self.start(key).extend(rows.flat_map(|row| row[lane].to_le_bytes()));
        self.gbuffer = self.gbuffer.wrapping_add(xxh3_128(&self.bytes));
    }

    /// Adds what lane `lane` has of light that reaches a fragment past others.
    pub fn add_visibility(&mut self, key: FragmentKey, planes: &SurfacePlanes, has_coat: bool, lane: usize) {
        let coat = [layout::COAT_SEEN, layout::COAT_BOUNCE];
        let planes_read =
            [layout::DIFFUSE_SEEN, layout::DIFFUSE_BOUNCE, layout::BASE_SEEN, layout::BASE_BOUNCE]
                .into_iter()
                .chain(coat.into_iter().filter(|_| has_coat));
        let rows = planes_read.flat_map(|plane| planes.plane(plane));
        self.start(key).extend(rows.flat_map(|row| row[lane].to_le_bytes()));
        self.visibility = self.visibility.wrapping_add(xxh3_128(&self.bytes));
    }

    /// Adds what shading made of a fragment.
    pub fn add_shaded(&mut self, key: FragmentKey, shaded: &ShadedFragment) {
        let ShadedFragment { radiance: [r, g, b], alpha, depth } = *shaded;
        self.start(key).extend([r, g, b, alpha, depth].into_iter().flat_map(f32::to_le_bytes));
        self.shading = self.shading.wrapping_add(xxh3_128(&self.bytes));
    }

    /// Adds another tile's sums.
    pub fn add(&mut self, other: &Self) {
        self.raster = self.raster.wrapping_add(other.raster);
        self.gbuffer = self.gbuffer.wrapping_add(other.gbuffer);
        self.visibility = self.visibility.wrapping_add(other.visibility);
        self.shading = self.shading.wrapping_add(other.shading);
    }

    fn start(&mut self, key: FragmentKey) -> &mut Vec<u8> {
        self.bytes.clear();
        self.bytes.extend(key.into_iter().flat_map(u32::to_le_bytes));
        &mut self.bytes
    }
}

/// Feeds numbers to a hash as little-endian bytes.
fn feed<const N: usize>(hasher: &mut Xxh3, numbers: impl IntoIterator<Item = [u8; N]>) {
    let mut bytes = Vec::with_capacity(1 << 12);
    for number in numbers {
        if bytes.len() + N > bytes.capacity() {
            hasher.update(&bytes);
            bytes.clear();
        }
        bytes.extend_from_slice(&number);
    }
    hasher.update(&bytes);
}

/// The hash of meshes, splats and textures.
fn scene(scene: &Scene) -> u128 {
    let mut hasher = Xxh3::new();
    for mesh in scene.meshes() {
        for attribute in [
            mesh.positions().as_flattened(),
            mesh.normals().as_flattened(),
            mesh.tangents().as_flattened(),
            mesh.uvs(0).as_flattened(),
            mesh.uvs(1).as_flattened(),
            mesh.colors().as_flattened(),
        ] {
            feed(&mut hasher, attribute.iter().map(|v| v.to_le_bytes()));
        }
        feed(&mut hasher, mesh.triangles().as_flattened().iter().map(|v| v.to_le_bytes()));
    }
    for cloud in scene.splats() {
        feed(&mut hasher, cloud.words().map(u32::to_le_bytes));
    }
    for texture in scene.textures() {
        hasher.update(texture.image().texels().as_flattened());
    }
    hasher.digest128()
}

/// The hash of a filtered environment.
fn environment(filtered: &PrefilteredEnvironment) -> u128 {
    let mut hasher = Xxh3::new();
    feed(&mut hasher, filtered.texels().iter().map(|v| v.to_le_bytes()));
    hasher.digest128()
}

/// The hash of what light from afar is taken to come from, and of what is seen from there.
pub fn depth_maps(of: &LightOcclusion<'_>) -> u128 {
    let mut hasher = Xxh3::new();
    let lights = of.lights.iter().flat_map(|light| {
        light.direction.into_iter().chain(light.flux).chain([light.solid_angle]).map(f32::to_le_bytes)
    });
    feed(&mut hasher, lights);
    feed(&mut hasher, of.maps.texels().iter().map(|word| word.to_le_bytes()));
    feed(&mut hasher, of.tints.texels().iter().map(|word| word.to_le_bytes()));
    hasher.digest128()
}

/// The hash of what lamps see.
pub fn lamp_maps(of: &LampOcclusion<'_>) -> u128 {
    let mut hasher = Xxh3::new();
    let parts = of.parts.iter().flat_map(|part| part.position.into_iter().chain([part.area]));
    feed(&mut hasher, parts.map(f32::to_le_bytes));
    feed(&mut hasher, of.maps.texels().iter().map(|word| word.to_le_bytes()));
    feed(&mut hasher, of.tints.texels().iter().map(|word| word.to_le_bytes()));
    hasher.digest128()
}

/// The hash of what rays can hit.
pub fn hierarchy(of: &TracedLight<'_>) -> u128 {
    let mut hasher = Xxh3::new();
    let corners = of.corners.as_flattened().as_flattened();
    feed(&mut hasher, corners.iter().map(|v| v.to_le_bytes()));
    feed(&mut hasher, of.draws.iter().flat_map(|of| [of.draw, of.first]).map(u32::to_le_bytes));
    let rows = of.draws.iter().filter_map(|of| of.rows.as_ref()).flatten().flatten();
    feed(&mut hasher, rows.map(|v| v.to_le_bytes()));
    feed(&mut hasher, of.hierarchy.triangles().map(u32::to_le_bytes));
    hasher.digest128()
}

/// The hash of the light on the floor.
pub fn ground(texels: &[u32]) -> u128 {
    let mut hasher = Xxh3::new();
    feed(&mut hasher, texels.iter().map(|bits| bits.to_le_bytes()));
    hasher.digest128()
}

/// The hash of vertices, triangles, points and splats on the screen.
pub fn geometry<'a>(
    vertices: &ScreenVertices,
    chunks: &[Chunk],
    states: &[DrawState],
    draws: &[Draw<'_>],
    splats: impl Iterator<Item = &'a ScreenSplat>,
) -> u128 {
    let mut hasher = Xxh3::new();
    let parts = vertices.places.iter().zip(&vertices.depths);
    let words = parts.flat_map(|([x, y], depth)| [*x as u32, *y as u32, depth.to_bits()]);
    feed(&mut hasher, words.map(u32::to_le_bytes));
    for chunk in chunks {
        let words = chunk.triangles.iter().flat_map(|t| {
            let flags = [t.is_back_facing(), t.is_swapped(), t.is_clipped()].map(u32::from);
            let places = [t.x, t.y].into_iter().flatten().map(|v| v as u32);
            let depths = t.depth.into_iter().chain(t.depth_gradient).map(f32::to_bits);
            places.chain(depths).chain(t.vertices()).chain(flags)
        });
        feed(&mut hasher, words.map(u32::to_le_bytes));
        let corners = chunk.pieces.iter().flat_map(|piece| piece.barycentrics).flatten();
        feed(&mut hasher, corners.map(f32::to_le_bytes));
        if let Some(points) = &states[chunk.draw as usize].points {
            let mesh = draws[chunk.draw as usize].mesh;
            let words = chunk.range.clone().filter_map(|point| points.disc(mesh, point)).flat_map(|disc| {
                let places = [disc.x as u32, disc.y as u32, disc.vertex, disc.back_facing.into()];
                let [a, b, c] = disc.conic;
                let [x, y] = disc.depth_gradient;
                places.into_iter().chain([a, b, c, disc.depth, x, y].map(f32::to_bits))
            });
            feed(&mut hasher, words.map(u32::to_le_bytes));
        }
    }
    let words = splats.flat_map(|splat| {
        let ScreenSplat { center: [x, y], shear, scale: [u, v], least, opacity, color: [r, g, b], .. } =
            *splat;
        let numbers = [x, y, shear, u, v, least, opacity, r, g, b, splat.distance].map(f32::to_bits);
        numbers.into_iter().chain(splat.pixels.map(u32::from)).chain([splat.object])
    });
    feed(&mut hasher, words.map(u32::to_le_bytes));
    hasher.digest128()
}

/// Hashes of the stages before the tiles are drawn.
pub fn before_tiles(of: &Scene, filtered: &PrefilteredEnvironment, geometry: u128) -> StageHashes {
    StageHashes { scene: scene(of), environment: environment(filtered), geometry, ..StageHashes::default() }
}

/// The same with what the tiles found and what became of it.
pub fn after_tiles(before: StageHashes, fragments: &FragmentHashes, frame: &Frame) -> StageHashes {
    StageHashes {
        raster: fragments.raster,
        gbuffer: fragments.gbuffer,
        visibility: fragments.visibility,
        shading: fragments.shading,
        resolve: frame.digest(),
        ..before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_stage_that_differs_is_named() {
        let a = StageHashes { scene: 1, geometry: 5, shading: 7, resolve: 9, ..StageHashes::default() };
        assert_eq!(a.first_difference(&a), None);
        assert_eq!(StageHashes { resolve: 8, ..a }.first_difference(&a), Some("resolve"));
        assert_eq!(StageHashes { resolve: 8, shading: 1, ..a }.first_difference(&a), Some("shading"));
        assert_eq!(StageHashes::default().first_difference(&a), Some("scene"));
    }

    #[test]
    fn sums_do_not_depend_on_order_and_see_every_bit() {
        let keys = [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 2, 3]];
        let sum = |order: &[usize], mask: u16| {
            let mut hashes = FragmentHashes::default();
            order.iter().for_each(|&k| hashes.add_samples(keys[k], mask));
            hashes.raster
        };
        assert_eq!(sum(&[0, 1, 2], 3), sum(&[2, 0, 1], 3));
        assert_ne!(sum(&[0, 1, 2], 3), sum(&[0, 1, 2], 2));
        assert_ne!(sum(&[0, 1], 3), sum(&[0, 2], 3));
        let one = ShadedFragment { radiance: [1.0, 2.0, 3.0], alpha: 1.0, depth: 0.5 };
        let next = ShadedFragment { radiance: [1.0, 2.0, f32::from_bits(3.0_f32.to_bits() + 1)], ..one };
        let hash = |shaded| {
            let mut hashes = FragmentHashes::default();
            hashes.add_shaded(keys[2], &shaded);
            hashes.shading
        };
        assert_ne!(hash(one), hash(next));
    }
}
