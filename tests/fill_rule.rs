//! Every sample of a mesh with shared edges is covered exactly once: inside, at tile seams, at the near plane and at
//! the guard band.

use overcoat::scene::{Camera, Mesh, MeshData, Projection, Transform};
use overcoat_core::math::lanes::SimdLevel;
use overcoat_stages::geometry::{
    Chunk, ChunkJob, ScreenVertex, ScreenVertices, View, process_chunk, transform_vertices,
};
use overcoat_stages::raster::{SamplePattern, TileOrigin, Triangle, VisibilityBuffer};
use overcoat_stages::tile::TileGrid;

/// A generator of small random numbers with a fixed seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }
    fn below(&mut self, n: i32) -> i32 {
        (self.next() % n as u32) as i32
    }
    /// -1 to 1.
    fn unit(&mut self) -> f32 {
        self.next() as f32 / (1_u64 << 30) as f32 - 1.0
    }
}

/// Number of triangles that cover each sample of a tile, each drawn on its own.
fn count_in_tile(
    triangles: &[Triangle],
    origin: TileOrigin,
    side: usize,
    samples: u32,
    level: SimdLevel,
) -> Vec<u32> {
    let pattern = SamplePattern::new(samples).unwrap();
    let mut counts = vec![0; side * side * samples as usize];
    let mut buffer = VisibilityBuffer::default();
    for triangle in triangles {
        buffer.clear(side, side, samples as usize, f32::NEG_INFINITY);
        overcoat_core::dispatch!(level, l => buffer.draw(l, triangle, 0, origin, &pattern, None));
        for block in 0..buffer.block_count() {
            let (column, row) = (block % buffer.block_columns() * 4, block / buffer.block_columns() * 4);
            for (sample, seen) in buffer.block_triangles(block).iter().enumerate() {
                for (k, &t) in seen.iter().enumerate() {
                    if t == 0 {
                        let pixel = (row + k / 4) * side + column + k % 4;
                        counts[pixel * samples as usize + sample] += 1;
                    }
                }
            }
        }
    }
    counts
}

/// The definition: a sample is inside if it is inside all edges, where left and top edges count as inside.
fn covers(corners: &[[i32; 2]; 3], sample: [i32; 2]) -> bool {
    let cross = |a: [i32; 2], b: [i32; 2], p: [i32; 2]| {
        i64::from(b[0] - a[0]) * i64::from(p[1] - a[1]) - i64::from(b[1] - a[1]) * i64::from(p[0] - a[0])
    };
    let [a, mut b, mut c] = *corners;
    let area = cross(a, b, c);
    if area == 0 {
        return false;
    }
    if area < 0 {
        (b, c) = (c, b);
    }
    [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| {
        // With y down and positive area, going up is a left edge, going right along a level a top edge.
        let left_or_top = q[1] < p[1] || (q[1] == p[1] && q[0] > p[0]);
        let e = cross(p, q, sample);
        e > 0 || (e == 0 && left_or_top)
    })
}

/// Output of the geometry stage for triangles between points of a picture of `size` x `size` pixels, in sub-pixels from
/// its corner.
fn set_up(points: &[[i32; 2]], triangles: Vec<[u32; 3]>, size: u32, samples: u32, level: SimdLevel) -> Chunk {
    let half = size as i32 * 128;
    let vertices: ScreenVertices =
        points.iter().map(|p| ScreenVertex { x: p[0] - half, y: p[1] - half, depth: 1.0 }).collect();
    let mut chunk = Chunk { range: 0..triangles.len(), ..Chunk::default() };
    let data = MeshData::default().with(|d| {
        d.positions = vec![[0.0; 3]; points.len()];
        d.triangles = triangles;
    });
    let view = View::new(&camera(Projection::Orthographic { height: 1.0 }), size, size).unwrap();
    let job = ChunkJob {
        mesh: &Mesh::new(data).unwrap(),
        vertices: vertices.slice(0..points.len()),
        view: &view.of_draw(&Transform::IDENTITY),
        cull_back_faces: false,
        mirrored: false,
        max_bins: usize::MAX,
    };
    let (grid, pattern) = (TileGrid::new(size, size, 16), SamplePattern::new(samples).unwrap());
    overcoat_core::dispatch!(level, l => process_chunk(l, &mut chunk, &job, &grid, &pattern));
    chunk
}

#[test]
fn small_triangles_follow_the_definition() {
    const SIZE: usize = 5;
    // Steps of lattices between whose points triangles lie, so that edges often pass through samples, and places of the
    // lattices. With one sample a pixel all are small, with several those of a box below two pixels.
    let lattices = [(128, 192), (48, 232), (16, 350), (16, 500), (7, 371), (131, 100)];
    let triangles: Vec<[u32; 3]> =
        (0..25_u32.pow(3)).filter(|k| k % 7 == 0).map(|k| [k / 625, k / 25 % 25, k % 25]).collect();
    let origin = TileOrigin { x: SIZE as i32 * -128, y: SIZE as i32 * -128 };
    let cases = [1, 4, 8, 16].into_iter().flat_map(|s| SimdLevel::available().map(move |l| (s, l)));
    for (samples, level) in cases {
        let pattern = SamplePattern::new(samples).unwrap();
        let mut small = 0;
        for (step, first) in lattices {
            let points: Vec<[i32; 2]> =
                (0..25).map(|k| [k % 5 * step + first, k / 5 * step + first + 7]).collect();
            let chunk = set_up(&points, triangles.clone(), SIZE as u32, samples, level);
            let mut kept = chunk.triangles.iter().peekable();
            for triangle in &triangles {
                let corners = triangle.map(|v| points[v as usize]);
                let set_up = kept.next_if(|t| t.vertices() == *triangle);
                small += usize::from(set_up.is_some_and(|t| t.small_samples != 0));
                let counts = set_up.map(|&t| count_in_tile(&[t], origin, SIZE, samples, level));
                for pixel in 0..SIZE * SIZE {
                    for (s, offset) in pattern.offsets().iter().enumerate() {
                        let corner = [(pixel % SIZE) as i32 * 256, (pixel / SIZE) as i32 * 256];
                        let at = [corner[0] + offset[0], corner[1] + offset[1]];
                        let found = counts.as_ref().is_some_and(|c| c[pixel * samples as usize + s] == 1);
                        assert_eq!(found, covers(&corners, at), "{level} {samples}: {corners:?} {at:?}");
                    }
                }
            }
            assert!(kept.next().is_none());
        }
        assert!(small > 2000, "{small} at {samples} samples");
    }
}

#[test]
fn large_and_thin_triangles_follow_the_definition_at_every_level() {
    let mut random = Random(5);
    let pattern = SamplePattern::new(8).unwrap();
    for round in 0..300 {
        // Up to the guard band, seen by a tile that some of them cross.
        let reach = [300, 4000, 60_000, (1 << 22) - 1][round % 4];
        let corners: [[i32; 2]; 3] =
            std::array::from_fn(|_| std::array::from_fn(|_| random.below(2 * reach) - reach));
        let Some(triangle) = Triangle::new(corners.map(|c| (c[0], c[1], 1.0)), [0, 1, 2], true) else {
            continue;
        };
        let origin =
            TileOrigin { x: random.below(2000) / 256 * 256 - 1024, y: random.below(2000) / 256 * 256 - 1152 };
        for level in SimdLevel::available() {
            let counts = count_in_tile(&[triangle], origin, 64, 8, level);
            for pixel in (0..64 * 64_i32).step_by(if round % 10 == 0 { 1 } else { 37 }) {
                for (s, offset) in pattern.offsets().iter().enumerate() {
                    let at =
                        [origin.x + pixel % 64 * 256 + offset[0], origin.y + pixel / 64 * 256 + offset[1]];
                    let expected = u32::from(covers(&corners, at));
                    assert_eq!(counts[pixel as usize * 8 + s], expected, "{level} {corners:?} {at:?}");
                }
            }
        }
    }
}

#[test]
fn fans_with_shared_edges_cover_each_sample_once() {
    let mut random = Random(11);
    for _ in 0..200 {
        // A star-shaped polygon around a point, in directions that go round once.
        let center = [random.below(8192) + 4096, random.below(8192) + 4096];
        let directions = [[5, 0], [4, 3], [1, 5], [-2, 4], [-5, 2], [-4, -2], [0, -5], [3, -4]];
        let ring: Vec<[i32; 2]> = directions
            .iter()
            .map(|d| {
                let r = random.below(700) + 50;
                [center[0] + d[0] * r + random.below(9), center[1] + d[1] * r + random.below(9)]
            })
            .collect();
        let mut triangles = Vec::new();
        for k in 0..8 {
            let corners = [center, ring[k], ring[(k + 1) % 8]];
            // Vertices in any order and direction.
            let turn = random.below(3) as usize;
            let mut c = [corners[turn], corners[(turn + 1) % 3], corners[(turn + 2) % 3]];
            if random.below(2) == 0 {
                c.swap(1, 2);
            }
            triangles.extend(Triangle::new(c.map(|c| (c[0], c[1], 1.0)), [0, 1, 2], true));
        }
        for samples in [1, 4, 8, 16] {
            let pattern = SamplePattern::new(samples).unwrap();
            let counts = count_in_tile(&triangles, TileOrigin { x: 0, y: 0 }, 64, samples, SimdLevel::best());
            for (k, &count) in counts.iter().enumerate() {
                let (pixel, s) = ((k / samples as usize) as i32, k % samples as usize);
                let at =
                    [pixel % 64 * 256 + pattern.offsets()[s][0], pixel / 64 * 256 + pattern.offsets()[s][1]];
                assert!(count <= 1, "a sample is covered {count} times");
                // The centre's neighbourhood is inside for certain.
                let near = (at[0] - center[0]).abs() + (at[1] - center[1]).abs() < 40;
                assert!(!near || count == 1, "a hole at {at:?} around {center:?}");
            }
        }
    }
}

/// Number of a mesh's triangles that cover each sample of a picture, through the whole geometry stage.
fn count_in_picture(data: MeshData, camera: &Camera, size: u32, side: u32, samples: u32) -> Vec<u32> {
    let mesh = Mesh::new(data).unwrap();
    let view = View::new(camera, size, size).unwrap().of_draw(&Transform::IDENTITY);
    let mut vertices = ScreenVertices::default();
    vertices.resize(mesh.positions().len());
    let ScreenVertices { places, depths } = &mut vertices;
    overcoat_core::dispatch!(SimdLevel::best(), l => transform_vertices(l, &view, mesh.positions(), places, depths));
    let grid = TileGrid::new(size, size, side);
    let pattern = SamplePattern::new(samples).unwrap();
    let mut chunk = Chunk { range: 0..mesh.triangles().len(), ..Chunk::default() };
    let job = ChunkJob {
        mesh: &mesh,
        vertices: vertices.slice(0..mesh.positions().len()),
        view: &view,
        cull_back_faces: false,
        mirrored: false,
        max_bins: usize::MAX,
    };
    overcoat_core::dispatch!(SimdLevel::best(), l => process_chunk(l, &mut chunk, &job, &grid, &pattern));
    let mut bins = overcoat_stages::tile::TileBins::default();
    bins.build(grid.len(), std::iter::once(&chunk.bins));
    let mut counts = vec![0; (size * size * samples) as usize];
    for tile in 0..grid.len() {
        let [x, y, width, height] = grid.pixels(tile);
        let of_tile: Vec<Triangle> = bins
            .runs(tile)
            .iter()
            .flat_map(|run| chunk.bins.triangles(run).iter().map(|&t| chunk.triangles[t as usize]))
            .collect();
        let found = count_in_tile(&of_tile, grid.origin(tile), side as usize, samples, SimdLevel::best());
        for row in 0..height {
            for column in 0..width {
                for s in 0..samples {
                    let from = (row * side + column) * samples + s;
                    let to = ((y + row) * size + x + column) * samples + s;
                    counts[to as usize] += found[from as usize];
                }
            }
        }
    }
    counts
}

fn camera(projection: Projection) -> Camera {
    Camera::new([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], projection, 0.05)
}

/// The same triangles, each with vertices of its own and starting at another corner, as in an STL file.
fn unshared(data: &MeshData, random: &mut Random) -> MeshData {
    let mut out = MeshData::default();
    for t in &data.triangles {
        let turn = random.below(3) as usize;
        let first = out.positions.len() as u32;
        out.positions.extend((0..3).map(|k| data.positions[t[(k + turn) % 3] as usize]));
        out.triangles.push([first, first + 1, first + 2]);
    }
    out
}

/// A closed surface around the eye, of random shape: a cube of `n` x `n` cells a side with jittered radius.
fn surrounding_mesh(n: i32, random: &mut Random) -> MeshData {
    let mut data = MeshData::default();
    let mut index = std::collections::BTreeMap::new();
    let mut vertex = |p: [i32; 3], data: &mut MeshData, random: &mut Random| {
        *index.entry(p).or_insert_with(|| {
            let r = 1.0 + 0.4 * random.unit();
            data.positions.push(p.map(|v| v as f32 / n as f32 * r));
            data.positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [-n, n] {
            for i in (-n..n).step_by(2) {
                for j in (-n..n).step_by(2) {
                    let corner = |di: i32, dj: i32| {
                        let mut p = [0; 3];
                        p[axis] = side;
                        p[(axis + 1) % 3] = i + di;
                        p[(axis + 2) % 3] = j + dj;
                        p
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(2, 0), corner(2, 2), corner(0, 2)]
                        .map(|p| vertex(p, &mut data, random));
                    data.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    data
}

#[test]
fn a_closed_mesh_around_the_eye_covers_every_sample_once() {
    let mut random = Random(3);
    for round in 0..12 {
        let mesh = surrounding_mesh(1 + round % 4, &mut random);
        let fov_y = [0.6, 1.5, 2.6][round as usize % 3];
        let mut camera = camera(Projection::Perspective { fov_y });
        camera.target = [random.unit(), random.unit() * 0.7, random.unit() - 1.5];
        for data in [mesh.clone(), unshared(&mesh, &mut random)] {
            let counts = count_in_picture(data, &camera, 96, 32, 4);
            let wrong = counts.iter().filter(|&&c| c != 1).count();
            assert_eq!(wrong, 0, "round {round}: {wrong} samples are not covered exactly once");
        }
    }
}

#[test]
fn tile_size_does_not_show() {
    let mut random = Random(9);
    let mesh = surrounding_mesh(3, &mut random);
    let camera = camera(Projection::Perspective { fov_y: 1.2 });
    let expected = count_in_picture(mesh.clone(), &camera, 100, 64, 8);
    for side in [16, 32] {
        assert!(count_in_picture(mesh.clone(), &camera, 100, side, 8) == expected, "{side}");
    }
}

/// The cases of the Vulkan conformance suite (`rasterization.fill_rules`): quads of two triangles, in clip space.
mod vulkan {
    use super::*;

    /// Quads that cover the picture together or overlap nowhere, as triangles of the given corner lists.
    fn quad(corners: [[f32; 3]; 4], reversed: bool) -> MeshData {
        let triangles = if reversed { vec![[0, 1, 2], [3, 2, 0]] } else { vec![[0, 1, 2], [2, 3, 0]] };
        MeshData::new(corners.to_vec(), triangles)
    }

    fn assert_once(data: MeshData, camera: &Camera, all: bool) {
        for samples in [1, 4, 8, 16] {
            let counts = count_in_picture(data.clone(), camera, 64, 32, samples);
            assert!(counts.iter().all(|&c| c <= 1), "covered twice");
            assert!(counts.contains(&1), "nothing drawn");
            assert!(!all || counts.iter().all(|&c| c == 1), "a hole");
        }
    }

    fn parallel() -> Camera {
        camera(Projection::Orthographic { height: 2.0 })
    }

    #[test]
    fn basic() {
        let mut random = Random(21);
        for _ in 0..40 {
            let z = -1.0;
            let (x0, y0) = (random.unit() * 0.5 - 0.5, random.unit() * 0.5 - 0.5);
            let (x1, y1) = (x0 + 0.9, y0 + 0.8);
            assert_once(
                quad([[x0, y0, z], [x0, y1, z], [x1, y1, z], [x1, y0, z]], false),
                &parallel(),
                false,
            );
        }
    }

    #[test]
    fn reversed() {
        let mut random = Random(22);
        for _ in 0..40 {
            let p = |random: &mut Random| 0.2 + 0.7 * random.unit().abs();
            let [a, b, c, d] = std::array::from_fn(|_| p(&mut random));
            let corners = [[-a, -a, -1.0], [b, -b, -1.0], [c, c, -1.0], [-d, d, -1.0]];
            assert_once(quad(corners, true), &parallel(), false);
        }
    }

    #[test]
    fn clipped_full() {
        let corners = [[-4.0, -3.0, -1.0], [-4.0, 5.0, -1.0], [6.0, 3.0, -1.0], [3.0, -7.0, -1.0]];
        assert_once(quad(corners, false), &parallel(), true);
        // Far beyond the guard band.
        let far = corners.map(|p| [p[0] * 1e4, p[1] * 1e4, p[2]]);
        assert_once(quad(far, false), &parallel(), true);
        assert_once(quad(far, false), &camera(Projection::Perspective { fov_y: 1.0 }), true);
    }

    #[test]
    fn clipped_partial() {
        let mut random = Random(24);
        for _ in 0..20 {
            let angle = [random.unit(), random.unit()];
            let corners =
                [[-9.0, -0.3, -1.0], [angle[0], 0.6, -1.0], [9.0, angle[1] * 0.1, -1.0], [0.1, -0.9, -1.0]];
            assert_once(quad(corners, false), &parallel(), false);
        }
    }

    #[test]
    fn projected() {
        let mut random = Random(25);
        for _ in 0..20 {
            let t = random.unit() * 0.3;
            // From behind the near plane into the distance.
            let corners = [[-2.0, -0.5, 0.5], [2.0, -0.5 + t, 0.5], [2.0, -0.6, -8.0], [-2.0, -0.4, -8.0]];
            assert_once(quad(corners, false), &camera(Projection::Perspective { fov_y: 1.4 }), false);
        }
    }
}
