//! Setup and raster of triangles by size, filling the G-buffer, and the whole frame.
//!
//! `cargo bench -p overcoat-benches --bench pipeline`

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{
    Camera, Framing, Instance, Material, Mesh, MeshData, Projection, Scene, Transform, Workflow,
};
use overcoat_core::math::lanes::{Float, SimdLevel};
use overcoat_stages::gbuffer::{
    Batch, Draw, Fragment, SourceTriangle, TriangleSource, extract_fragments, locate,
};
use overcoat_stages::geometry::{Chunk, ChunkJob, ScreenVertices, View, process_chunk, transform_vertices};
use overcoat_stages::raster::{SamplePattern, TileOrigin, Triangle, VisibilityBuffer};
use overcoat_stages::tile::{TileBins, TileGrid};
use std::hint::black_box;

/// A sheet of `columns` x `rows` cells, two triangles each, between -1 and 1, tilted a little in depth.
fn sheet(columns: u32, rows: u32) -> MeshData {
    let mut data = MeshData::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (x, y) = (i as f32 / columns as f32, j as f32 / rows as f32);
            data.positions.push([2.0 * x - 1.0, 2.0 * y - 1.0, 0.1 * x - 0.05 * y]);
            data.normals.push([0.0, 0.0, 1.0]);
            data.uvs[0].push([x, y]);
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let b = a + columns + 1;
            data.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    data
}

/// A camera that sees the sheet fill the picture.
fn facing() -> Camera {
    Camera::new([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0], Projection::Orthographic { height: 2.0 }, 0.01)
}

/// One frame's visibility buffer of a mesh, as the renderer makes it, in one thread.
struct Rasterizer {
    mesh: Mesh,
    grid: TileGrid,
    pattern: SamplePattern,
    vertices: ScreenVertices,
    chunk: Chunk,
    bins: TileBins,
    buffer: VisibilityBuffer,
}

impl Rasterizer {
    fn new(data: MeshData, size: u32, samples: u32) -> Self {
        let mesh = Mesh::new(data).expect("the sheet is valid");
        let mut vertices = ScreenVertices::default();
        vertices.resize(mesh.positions().len());
        Self {
            vertices,
            chunk: Chunk { range: 0..mesh.triangles().len(), ..Chunk::default() },
            mesh,
            grid: TileGrid::new(size, size, 32),
            pattern: SamplePattern::new(samples).expect("a number of samples that exists"),
            bins: TileBins::default(),
            buffer: VisibilityBuffer::default(),
        }
    }

    fn run(&mut self, level: SimdLevel) {
        let view = View::new(&facing(), self.grid.width(), self.grid.height()).expect("a camera that looks");
        let view = view.of_draw(&Transform::IDENTITY);
        let mesh = &self.mesh;
        let ScreenVertices { places, depths } = &mut self.vertices;
        overcoat_core::dispatch!(level, l => transform_vertices(l, &view, mesh.positions(), places, depths));
        let job = ChunkJob {
            mesh,
            vertices: self.vertices.slice(0..mesh.positions().len()),
            view: &view,
            cull_back_faces: true,
            mirrored: false,
            max_bins: usize::MAX,
        };
        let (job, chunk) = (&job, &mut self.chunk);
        overcoat_core::dispatch!(SimdLevel::best(), l => process_chunk(l, chunk, job, &self.grid, &self.pattern));
        self.bins.build(self.grid.len(), std::iter::once(&self.chunk.bins));
        let samples = self.pattern.len();
        for tile in 0..self.grid.len() {
            let [_, _, width, height] = self.grid.pixels(tile);
            self.buffer.clear(width as usize, height as usize, samples, f32::NEG_INFINITY);
            for run in self.bins.runs(tile) {
                for &t in self.chunk.bins.triangles(run) {
                    let (triangle, origin) = (&self.chunk.triangles[t as usize], self.grid.origin(tile));
                    let (buffer, pattern) = (&mut self.buffer, &self.pattern);
                    overcoat_core::dispatch!(level, l => buffer.draw(l, triangle, t, origin, pattern, None));
                }
            }
        }
        black_box(&self.buffer);
    }
}

/// Triangles of a given size, at 1 and 8 samples: elements are triangles.
fn raster(c: &mut Criterion) {
    let mut group = c.benchmark_group("setup and raster");
    group.sample_size(20);
    // Two triangles a cell: 4 x 4 pixels make 8-pixel triangles, 14.14 x 14.14 make 100-pixel ones.
    for (name, size, cells) in [("8 pixels", 512, 128), ("100 pixels", 512, 36), ("full screen", 1024, 1)] {
        for samples in [1, 8] {
            let mut rasterizer = Rasterizer::new(sheet(cells, cells), size, samples);
            group.throughput(Throughput::Elements(u64::from(cells * cells * 2)));
            group.bench_function(format!("{name}, {samples} samples"), |b| {
                b.iter(|| rasterizer.run(SimdLevel::best()));
            });
        }
    }
    let mut rasterizer = Rasterizer::new(sheet(1, 1), 1024, 1);
    group.throughput(Throughput::Elements(1024 * 1024));
    group.bench_function("pixels of full-screen triangles", |b| b.iter(|| rasterizer.run(SimdLevel::best())));
    group.finish();
}

/// One triangle for all identities.
struct Single(Triangle);

impl TriangleSource for Single {
    fn triangle(&self, _: u32) -> SourceTriangle<'_> {
        SourceTriangle { screen: &self.0, draw: 0, clip: None }
    }
}

/// From a tile's visibility buffer to located fragments with normals and texture coordinates: elements are fragments.
fn gbuffer(c: &mut Criterion) {
    let mut group = c.benchmark_group("G-buffer");
    let mesh = Mesh::new(sheet(1, 1)).expect("the sheet is valid");
    let draws = [Draw {
        mesh: &mesh,
        material: 0,
        object: 0,
        instance: 0,
        position_matrix: Transform::IDENTITY.rows().map(|row| row.map(|c| c as f32)),
        normal_matrix: Transform::IDENTITY.normal_matrix(),
        tangent_matrix: Transform::IDENTITY.normal_matrix(),
        handedness: 1.0,
        scale: 1.0,
        uv_sets: [false; 2],
        edges: None,
    }];
    let corners = [(-9000, -9000, 1.0), (30_000, -9000, 1.1), (-9000, 30_000, 0.9)];
    let source = Single(Triangle::new(corners, [0, 1, 2], true).expect("it has an area"));
    let (origin, pattern) = (TileOrigin { x: 0, y: 0 }, SamplePattern::new(8).expect("8 samples exist"));
    let mut buffer = VisibilityBuffer::default();
    buffer.clear(32, 32, 8, f32::NEG_INFINITY);
    overcoat_core::dispatch!(SimdLevel::best(), l => buffer.draw(l, &source.0, 0, origin, &pattern, None));
    let mut fragments: Vec<Fragment> = Vec::new();
    let mut batch = Batch::default();
    group.throughput(Throughput::Elements(32 * 32));
    for level in SimdLevel::available() {
        group.bench_function(format!("extract fragments, {level}"), |b| {
            b.iter(|| {
                fragments.clear();
                overcoat_core::dispatch!(level, l => {
                    extract_fragments(l, &buffer, 32, 32, 8, None::<(&Single, _, _)>, &mut fragments);
                });
                fragments.len()
            });
        });
    }
    let indices: Vec<u32> = (0..fragments.len() as u32).collect();
    for level in SimdLevel::available() {
        group.bench_function(format!("fill, {level}"), |b| {
            b.iter(|| {
                let mut sum = 0.0;
                for run in indices.chunks(16) {
                    batch.gather(&fragments, run, &source, origin, &pattern);
                    sum += overcoat_core::dispatch!(level, l => {
                        let location = locate(l, &batch, true);
                        let normals = batch.vertices.attribute(l, &draws, [0.0; 3], Mesh::normals);
                        let uvs = batch.vertices.attribute(l, &draws, [0.0; 2], |m| m.uvs(0));
                        let normal = location.interpolate(&normals);
                        let uv = location.interpolate(&uvs);
                        let [dx, dy] = location.derivatives(&uvs);
                        (normal[2] + uv[0] + dx[0] + dy[1]).to_array()[0]
                    });
                }
                sum
            });
        });
    }
    group.finish();
}

/// A coated ball in the studio, 512 x 512, all threads: elements are pixels.
fn frame(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame");
    group.sample_size(20);
    let mut data = sheet(128, 64);
    for (position, normal) in data.positions.iter_mut().zip(&mut data.normals) {
        let turn = overcoat_core::math::scalar::cos(position[0] * std::f32::consts::PI);
        let side = overcoat_core::math::scalar::sin(position[0] * std::f32::consts::PI);
        let ring = (1.0 - position[1] * position[1]).max(0.0).sqrt();
        *position = [ring * side, position[1], ring * turn];
        *normal = *position;
    }
    let mut scene = Scene::new();
    let material = Material::default().with(|m| {
        m.base_color = [0.7, 0.05, 0.03, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.3, roughness: 0.4, texture: None };
        m.coat = 1.0;
        m.coat_roughness = 0.05;
    });
    let mesh = scene.add_mesh(Mesh::new(data).expect("the ball is valid")).expect("one mesh");
    let material = scene.add_material(material).expect("factors in range");
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).expect("mesh and material exist");
    let camera = Framing::default().camera(&scene);
    let mut renderer = Renderer::new(0);
    group.throughput(Throughput::Elements(512 * 512));
    for samples in [1, 8] {
        let options = RenderOptions::draft(512, 512).with_samples(samples);
        group.bench_function(format!("coated ball, {samples} samples"), |b| {
            b.iter(|| renderer.render(&scene, &camera, &options).expect("it renders"));
        });
    }
    group.finish();
}

criterion_group!(benches, raster, gbuffer, frame);
criterion_main!(benches);
