//! Boxes, and cameras that fit what is in them.

use super::extent::{self, Extent};
use super::facing::{Estimate, Facing};
use super::front;
use super::{Camera, Mesh, MeshId, Projection, Scene, SplatCloud, Transform};
use glam::DVec3;

/// An axis-aligned box in double precision; empty where `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: [f64; 3],
    /// Largest corner.
    pub max: [f64; 3],
}

impl Bounds {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// True if it contains nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|k| self.min[k] > self.max[k])
    }

    /// Grows to contain a point.
    pub fn include(&mut self, p: [f32; 3]) {
        for k in 0..3 {
            let v = f64::from(p[k]);
            if v < self.min[k] {
                self.min[k] = v;
            }
            if v > self.max[k] {
                self.max[k] = v;
            }
        }
    }

    /// The box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let mut out = *self;
        for k in 0..3 {
            if other.min[k] < out.min[k] {
                out.min[k] = other.min[k];
            }
            if other.max[k] > out.max[k] {
                out.max[k] = other.max[k];
            }
        }
        out
    }

    /// The box around the eight transformed corners.
    #[must_use]
    pub fn transformed(&self, transform: &Transform) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let mut out = Self::EMPTY;
        for corner in 0..8 {
            let p = transform
                .point(std::array::from_fn(|k| if corner >> k & 1 == 1 { self.max[k] } else { self.min[k] }));
            out = out.union(&Self { min: p, max: p });
        }
        out
    }

    /// True if every coordinate's magnitude is at most `limit`.
    #[must_use]
    pub fn within(&self, limit: f64) -> bool {
        self.min.iter().chain(&self.max).all(|v| v.abs() <= limit)
    }

    /// Midpoint.
    #[must_use]
    pub fn center(&self) -> [f64; 3] {
        std::array::from_fn(|k| 0.5 * (self.min[k] + self.max[k]))
    }

    /// Edge lengths.
    #[must_use]
    pub fn size(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.max[k] - self.min[k])
    }
}

/// How a camera is placed when the user gives none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Framing {
    /// From the model towards the camera, any length above 0.
    pub direction: [f32; 3],
    /// Which way is up.
    pub up: [f32; 3],
    /// Vertical field of view in radians; ignored when orthographic.
    pub fov_y: f32,
    /// Parallel projection.
    pub orthographic: bool,
    /// Width of the picture divided by its height.
    pub aspect: f32,
    /// Part of the picture left free at each border, 0 to 0.45.
    pub margin: f32,
}

impl Default for Framing {
    /// A three-quarter view from slightly above with the field of view of a short telephoto lens.
    fn default() -> Self {
        Self {
            direction: [0.62, 0.42, 1.0],
            up: [0.0, 1.0, 0.0],
            fov_y: std::f32::consts::FRAC_PI_6,
            orthographic: false,
            aspect: 1.0,
            margin: 0.04,
        }
    }
}

impl Framing {
    /// The same with another [`Framing::direction`].
    #[must_use]
    pub fn with_direction(self, direction: [f32; 3]) -> Self {
        Self { direction, ..self }
    }

    /// The same with another [`Framing::aspect`].
    #[must_use]
    pub fn with_aspect(self, aspect: f32) -> Self {
        Self { aspect, ..self }
    }

    /// A view from the front and above: [`Framing::default`]'s, unless another one from there shows twice as much of the
    /// surface, as of flat models that lie or that it meets edge-on. A view from behind only for what shows its back to all of
    /// those, one-sided planes above all, and one from below only for what faces down.
    ///
    /// The front is +Z of the scene. Where the file's format does not say so ([`Orientation::front_is_known`]) and the model is
    /// a long body whose head is at the other end, it is -Z.
    ///
    /// [`Orientation::front_is_known`]: super::Orientation::front_is_known
    #[must_use]
    pub fn automatic(scene: &Scene) -> Self {
        let back = !scene.orientation().front_is_known && front::faces_back(scene);
        let turned = |[x, y, z]: [f32; 3]| if back { [-x, y, -z] } else { [x, y, z] };
        let views = VIEWS.map(|views| views.map(turned));
        let [[first, ..], ..] = views;
        let default = Self { direction: first, ..Self::default() };
        if Estimate::new(scene).surely_shows(first, ENOUGH, views.as_flattened()) {
            return default;
        }
        let facing = Facing::new(scene);
        let shown = |view: &[f32; 3]| facing.visible_from(*view);
        let most = |views: &[[f32; 3]]| views.iter().map(shown).fold(0.0, f64::max);
        let all = most(views.as_flattened());
        let chosen = |views: &[[f32; 3]; 6]| {
            let enough = (ENOUGH * most(views)).max(SOMETHING * all);
            views.iter().find(|&view| shown(view) >= enough).copied()
        };
        Self { direction: views.iter().find_map(chosen).unwrap_or(first), ..default }
    }

    /// The camera closest to the scene along [`Framing::direction`] that still has every vertex in the picture,
    /// with the margin. An empty scene is seen as if it were a unit cube, a single point likewise.
    #[must_use]
    pub fn camera(&self, scene: &Scene) -> Camera {
        let mut fit = Fit::new(*self);
        fit.include(scene);
        fit.camera()
    }

    /// Width and height of the picture's half, seen from one metre, without the margin; 0 for parallel views.
    fn tangents(&self) -> [f64; 2] {
        let fov_y = f64::from(self.fov_y).clamp(1e-3, std::f64::consts::PI - 1e-3);
        let tan_y = if self.orthographic { 0.0 } else { overcoat_core::math::tan_half(fov_y) * self.keep() };
        [tan_y * self.clamped_aspect(), tan_y]
    }

    /// Part of the picture that is not margin.
    fn keep(&self) -> f64 {
        1.0 - 2.0 * f64::from(self.margin.clamp(0.0, 0.45))
    }

    fn clamped_aspect(&self) -> f64 {
        f64::from(self.aspect).clamp(1e-4, 1e4)
    }

    /// Right, up and back of the view, of unit length.
    fn axes(&self) -> [DVec3; 3] {
        let camera = Camera {
            eye: self.direction,
            target: [0.0; 3],
            up: self.up,
            projection: Projection::Perspective { fov_y: 1.0 },
            near: 1.0,
        };
        let axes = camera.axes().unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        axes.map(DVec3::from)
    }
}

/// Finds the camera that fits several scenes, for pictures that follow each other: poses of one model, or a model that
/// turns.
#[derive(Debug)]
pub struct Fit {
    framing: Framing,
    bounds: Bounds,
    /// Centre of the first scene that is not empty: what everything is measured from.
    center: [f64; 3],
    reach: Reach,
}

impl Fit {
    /// Nothing to fit yet.
    #[must_use]
    pub fn new(framing: Framing) -> Self {
        let center = [0.0; 3];
        let reach = Reach::new(framing.axes(), center, framing.tangents());
        Self { framing, bounds: Bounds::EMPTY, center, reach }
    }

    /// Takes in a scene.
    pub fn include(&mut self, scene: &Scene) {
        self.include_moved(scene, &Transform::IDENTITY);
    }

    /// Takes in a scene that stands elsewhere.
    pub fn include_moved(&mut self, scene: &Scene, by: &Transform) {
        // What overflows there cannot be drawn either.
        let placed = |transform: &Transform| by.after(transform).unwrap_or(*transform);
        let bounds = scene.seen_instances().fold(Bounds::EMPTY, |all, instance| {
            let mesh = &scene.meshes()[instance.mesh.index()];
            all.union(&mesh.bounds().transformed(&placed(&instance.transform)))
        });
        let bounds = scene.splat_instances().iter().fold(bounds, |all, instance| {
            let cloud = &scene.splats()[instance.cloud.index()];
            all.union(&cloud.shown_bounds().transformed(&placed(&instance.transform)))
        });
        if bounds.is_empty() {
            return;
        }
        if self.bounds.is_empty() {
            self.center = bounds.center();
            self.reach = Reach::new(self.framing.axes(), self.center, self.framing.tangents());
        }
        self.bounds = self.bounds.union(&bounds);
        let mut used: Option<(MeshId, Option<Vec<bool>>)> = None;
        for instance in scene.seen_instances() {
            let mesh = &scene.meshes()[instance.mesh.index()];
            let measures = self.reach.measures(&placed(&instance.transform));
            let bounds = mesh.bounds();
            if bounds.is_empty() || !self.reach.grows(&measures, bounds) {
                continue;
            }
            // Copies of a mesh often follow each other.
            if used.as_ref().is_none_or(|(id, _)| *id != instance.mesh) {
                used = Some((instance.mesh, mesh.used_vertices()));
            }
            let used = used.as_ref().and_then(|(_, used)| used.as_deref());
            self.reach.visit(&measures, mesh, used);
        }
        for instance in scene.splat_instances() {
            let cloud = &scene.splats()[instance.cloud.index()];
            self.reach.visit_splats(&self.reach.measures(&placed(&instance.transform)), cloud);
        }
    }

    /// The camera closest to the scenes that has every vertex of each in the picture, as [`Framing::camera`].
    #[must_use]
    pub fn camera(self) -> Camera {
        let Self { framing, bounds, center, mut reach } = self;
        let size = bounds.size();
        let diagonal = (size[0] * size[0] + size[1] * size[1] + size[2] * size[2]).sqrt();
        let magnitude = center.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let axes = framing.axes();
        let [_, tan_y] = framing.tangents();
        let (keep, aspect) = (framing.keep(), framing.clamped_aspect());
        // A model without extent, or with less than its coordinates resolve, is framed as a cube around it: of
        // 1 m, or larger where single precision could not hold the camera apart from the model.
        let degenerate = bounds.is_empty() || diagonal < magnitude * 3e-7 || diagonal < SMALLEST;
        if degenerate {
            reach = Reach::new(axes, center, framing.tangents());
            let half = 0.5 * (magnitude * 1e-3).max(1.0);
            let measures = reach.measures(&Transform::IDENTITY);
            for k in 0..8 {
                let corner = |a: usize| center[a] + if k >> a & 1 == 1 { half } else { -half };
                reach.include(&measures, [corner(0), corner(1), corner(2)]);
            }
        }

        let Reach { planes: [right, left, top, bottom], depth: [far, near], .. } = reach;
        let extent = (right + left).max((top + bottom) * aspect).max(near - far).max(SMALLEST);
        // The camera is rounded to single precision; its error must not push a vertex out of the picture.
        let slack = 2.0 * 5e-7 * (magnitude + extent);
        let (width, height) = (right + left + slack, top + bottom + slack);
        let x = 0.5 * (right - left);
        let y = 0.5 * (top - bottom);
        let (distance, projection) = if framing.orthographic {
            let height = (width / aspect).max(height) / keep;
            (near + extent, Projection::Orthographic { height: height as f32 })
        } else {
            let fov_y = f64::from(framing.fov_y).clamp(1e-3, std::f64::consts::PI - 1e-3);
            // Each pair of opposite planes fixes the eye's place across the view and a least distance.
            let distance = 0.5 * (width / (tan_y * aspect)).max(height / tan_y);
            (distance.max(near + extent * 1e-3), Projection::Perspective { fov_y: fov_y as f32 })
        };
        let [axis_x, axis_y, back] = axes;
        let eye = DVec3::from(center) + axis_x * x + axis_y * y + back * distance;
        let target = eye - back * (distance - 0.5 * (far + near)).max(extent * 1e-3);
        Camera {
            eye: eye.to_array().map(|v| v as f32),
            target: target.to_array().map(|v| v as f32),
            up: axis_y.to_array().map(|v| v as f32),
            projection,
            near: ((distance - near) * 0.5).max(extent * 1e-4) as f32,
        }
    }
}

/// Views from the front and above, from behind and above, and from below; of each the preferred ones first.
const VIEWS: [[[f32; 3]; 6]; 3] = [
    [
        [0.62, 0.42, 1.0],
        [0.62, 1.0, 1.0],
        [-0.62, 0.42, 1.0],
        [0.5, 1.6, 0.8],
        [0.1, 0.15, 1.0],
        [-1.0, 0.3, 0.3],
    ],
    [
        [-0.62, 0.42, -1.0],
        [0.62, 0.42, -1.0],
        [1.0, 0.42, -0.2],
        [-1.0, 0.42, -0.2],
        [0.1, 0.15, -1.0],
        [0.5, 1.6, -0.8],
    ],
    [
        [0.62, -0.7, 1.0],
        [0.5, -1.6, 0.8],
        [-0.62, -0.7, 1.0],
        [-0.62, -0.7, -1.0],
        [0.1, -0.15, 1.0],
        [0.5, -1.6, -0.8],
    ],
];

/// A view is good that shows at least this part of what the best of its kind shows,
const ENOUGH: f64 = 0.5;

/// and this part of what the best of all shows: there is one from the front and above for everything that is closed.
const SOMETHING: f64 = 0.35;

/// Smallest extent in metres of a model that is framed as it is.
const SMALLEST: f64 = 1e-12;

/// How far points reach beyond the four side planes of a view pyramid that stands at the centre of the scene.
#[derive(Debug)]
struct Reach {
    /// For the right, left, upper and lower plane and for the depth: what it measures, as (direction, offset).
    measures: [(DVec3, f64); 5],
    /// Largest measure of right, left, top and bottom, in metres across the view.
    planes: [f64; 4],
    /// Farthest and nearest depth, in metres towards the viewer.
    depth: [f64; 2],
}

impl Reach {
    /// Nothing seen yet. `tangents`: of the half angles across and up; 0 for a parallel view.
    fn new([right, up, back]: [DVec3; 3], center: [f64; 3], [tan_x, tan_y]: [f64; 2]) -> Self {
        let directions =
            [right + back * tan_x, back * tan_x - right, up + back * tan_y, back * tan_y - up, back];
        let center = DVec3::from(center);
        Self {
            measures: directions.map(|d| (d, -d.dot(center))),
            planes: [f64::NEG_INFINITY; 4],
            depth: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    /// The measures of an instance's transformed point, as measures of the point.
    fn measures(&self, transform: &Transform) -> Measures {
        let rows = transform.rows();
        Measures(self.measures.map(|(d, offset)| {
            let along = |k: usize| d.x * rows[0][k] + d.y * rows[1][k] + d.z * rows[2][k];
            ([along(0), along(1), along(2)], along(3) + offset)
        }))
    }

    /// Takes in the vertices of an instance; `used` says which of them count, unless all do.
    fn visit(&mut self, measures: &Measures, mesh: &Mesh, used: Option<&[bool]>) {
        for (block, points) in mesh.positions().chunks(extent::BLOCK).enumerate() {
            let Extent { low, high } = Extent::of(points);
            let bounds = Bounds { min: low.map(f64::from), max: high.map(f64::from) };
            if !self.grows(measures, &bounds) {
                continue;
            }
            for (k, p) in points.iter().enumerate() {
                if used.is_none_or(|used| used[block * extent::BLOCK + k]) {
                    self.include(measures, p.map(f64::from));
                }
            }
        }
    }

    /// Takes in the splats of an instance that a picture is to show.
    fn visit_splats(&mut self, measures: &Measures, cloud: &SplatCloud) {
        cloud.for_each_solid(|index, p, reach| {
            // Most splats lie within others' reach.
            let radius = reach * cloud.largest_scale(index);
            let around = Bounds { min: p.map(|v| v - radius), max: p.map(|v| v + radius) };
            if !self.grows(measures, &around) {
                return;
            }
            let axes = cloud.axes(index);
            let half = |k: usize| reach * measures.spread(k, &axes);
            for (k, plane) in self.planes.iter_mut().enumerate() {
                let m = measures.of(k, p) + half(k);
                *plane = if m > *plane { m } else { *plane };
            }
            let (depth, half) = (measures.of(4, p), half(4));
            self.depth[0] = if depth - half < self.depth[0] { depth - half } else { self.depth[0] };
            self.depth[1] = if depth + half > self.depth[1] { depth + half } else { self.depth[1] };
        });
    }

    /// False if no point of a box can change anything. Rounding keeps the order of numbers, so what is computed for
    /// the corner that lies farthest along a measure is at least what is computed for any point of the box.
    fn grows(&self, measures: &Measures, bounds: &Bounds) -> bool {
        let farthest = |k: usize, sign: f64| {
            let d = measures.0[k].0;
            let corner = |a: usize| if d[a] * sign > 0.0 { bounds.max[a] } else { bounds.min[a] };
            measures.of(k, [corner(0), corner(1), corner(2)])
        };
        // What is no number decides nothing.
        let within = |k: usize| farthest(k, 1.0) <= self.planes[k];
        let between = farthest(4, 1.0) <= self.depth[1] && farthest(4, -1.0) >= self.depth[0];
        !(within(0) && within(1) && within(2) && within(3) && between)
    }

    /// Takes in a point.
    fn include(&mut self, measures: &Measures, p: [f64; 3]) {
        for (k, reach) in self.planes.iter_mut().enumerate() {
            let m = measures.of(k, p);
            *reach = if m > *reach { m } else { *reach };
        }
        let depth = measures.of(4, p);
        self.depth[0] = if depth < self.depth[0] { depth } else { self.depth[0] };
        self.depth[1] = if depth > self.depth[1] { depth } else { self.depth[1] };
    }
}

/// What the five measures are for points of an instance, as (direction, offset).
struct Measures([([f64; 3], f64); 5]);

impl Measures {
    /// Measure `k` of a point.
    fn of(&self, k: usize, p: [f64; 3]) -> f64 {
        let (d, offset) = &self.0[k];
        d[0] * p[0] + d[1] * p[1] + d[2] * p[2] + offset
    }

    /// How far an ellipsoid with these half axes reaches along measure `k`.
    fn spread(&self, k: usize, axes: &[[f64; 3]; 3]) -> f64 {
        let (d, _) = &self.0[k];
        let along = |axis: &[f64; 3]| d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
        let [a, b, c] = [along(&axes[0]), along(&axes[1]), along(&axes[2])];
        (a * a + b * b + c * c).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, MeshData};

    fn scene(positions: &[[f32; 3]], transform: Transform) -> Scene {
        let triangles = (0..positions.len().saturating_sub(2) as u32).map(|k| [k, k + 1, k + 2]).collect();
        let mesh = Mesh::new(MeshData { positions: positions.to_vec(), triangles, ..MeshData::default() });
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(mesh.unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        scene
    }

    /// Largest magnitude of the vertices' normalised device coordinates, and the smallest distance before the near
    /// plane in units of the near distance.
    fn reach(scene: &Scene, camera: &Camera, aspect: f32) -> (f64, f64) {
        let [right, up, back] = camera.axes().unwrap().map(DVec3::from);
        let (mut largest, mut clearance) = (0.0_f64, f64::INFINITY);
        for instance in scene.instances() {
            for p in scene.meshes()[instance.mesh.index()].positions() {
                let p = instance.transform.point(p.map(f64::from));
                let d = DVec3::from(p) - DVec3::from(camera.eye.map(f64::from));
                let distance = -d.dot(back);
                let half_height = match camera.projection {
                    Projection::Perspective { fov_y } => {
                        overcoat_core::math::tan_half(f64::from(fov_y)) * distance
                    }
                    Projection::Orthographic { height } => 0.5 * f64::from(height),
                };
                let x = d.dot(right) / (half_height * f64::from(aspect));
                let y = d.dot(up) / half_height;
                largest = largest.max(x.abs()).max(y.abs());
                clearance = clearance.min(distance / f64::from(camera.near));
            }
        }
        (largest, clearance)
    }

    const BOX: [[f32; 3]; 8] = [
        [-1.0, -0.5, -2.0],
        [1.0, -0.5, -2.0],
        [-1.0, 0.5, -2.0],
        [1.0, 0.5, -2.0],
        [-1.0, -0.5, 2.0],
        [1.0, -0.5, 2.0],
        [-1.0, 0.5, 2.0],
        [1.0, 0.5, 2.0],
    ];

    const DIRECTIONS: [([f32; 3], [f32; 3]); 5] = [
        ([0.62, 0.42, 1.0], [0.0, 1.0, 0.0]),
        ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        ([-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([0.0, 1.0, 0.0], [0.0, 0.0, -1.0]),
        ([0.3, -0.8, -0.2], [0.0, 1.0, 0.0]),
    ];

    fn framings() -> impl Iterator<Item = Framing> {
        DIRECTIONS.into_iter().flat_map(|(direction, up)| {
            [0.25, 1.0, 1.7, 6.0].into_iter().flat_map(move |aspect| {
                [(0.1, false), (0.5, false), (1.0, false), (0.5, true)].map(|(fov_y, orthographic)| Framing {
                    direction,
                    up,
                    fov_y,
                    orthographic,
                    aspect,
                    margin: 0.04,
                })
            })
        })
    }

    /// Every vertex lies within the margin, before the near plane, and at least one touches the margin.
    fn assert_tight(scene: &Scene, framing: &Framing, tolerance: f64) {
        let camera = framing.camera(scene);
        camera.validate().unwrap_or_else(|e| panic!("{e}: {camera:?} by {framing:?}"));
        let (largest, clearance) = reach(scene, &camera, framing.aspect);
        let keep = 1.0 - 2.0 * f64::from(framing.margin);
        assert!(largest <= keep + 1e-6, "{largest} > {keep}: {camera:?} by {framing:?}");
        // A very wide view may have to stay away from the nearest vertex.
        let wide = !framing.orthographic && framing.fov_y * framing.aspect > 2.0;
        assert!(wide || largest >= keep * (1.0 - tolerance), "{largest} < {keep}: {camera:?} by {framing:?}");
        assert!(clearance > 1.0, "{clearance}: {camera:?} by {framing:?}");
    }

    #[test]
    fn boxes_fill_the_picture_from_every_side() {
        for framing in framings() {
            assert_tight(&scene(&BOX, Transform::IDENTITY), &framing, 1e-4);
        }
    }

    #[test]
    fn tiny_huge_and_distant_models_fill_the_picture() {
        let placed = |scale: f64, offset: f64| {
            Transform::from_parts([offset, -offset, offset], [0.1, 0.2, 0.3, 0.9], [scale; 3]).unwrap()
        };
        for framing in framings() {
            for (scale, offset) in [(1e-9, 0.0), (1e-5, 0.0), (1e6, 0.0), (3e14, 0.0), (1.0, 1000.0)] {
                assert_tight(&scene(&BOX, placed(scale, offset)), &framing, 2e-2);
            }
        }
    }

    #[test]
    fn flat_models_fill_the_picture() {
        let flat = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
        for framing in framings() {
            assert_tight(&scene(&flat, Transform::IDENTITY), &framing, 1e-4);
        }
    }

    #[test]
    fn models_without_extent_and_empty_scenes_have_a_camera() {
        for framing in framings() {
            framing.camera(&Scene::new()).validate().unwrap();
            for at in [0.0, 1.0, 1e5, 1e9, 5e14] {
                let point = scene(&[[at; 3]; 3], Transform::IDENTITY);
                let camera = framing.camera(&point);
                camera.validate().unwrap_or_else(|e| panic!("{e}: {camera:?}"));
                let (largest, clearance) = reach(&point, &camera, framing.aspect);
                assert!(largest < 0.3 && clearance > 1.0, "{largest} {clearance} {camera:?}");
            }
        }
    }

    /// Whichever way a sheet faces, its picture is an area and not a line.
    #[test]
    fn flat_models_are_not_seen_edge_on() {
        // Its front faces -Y.
        let flat = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, 1.0]];
        for k in 0..64_u32 {
            let [x, y, z] = [k % 4, k / 4 % 4, k / 16].map(|v| f64::from(v) - 1.4);
            let turned = Transform::from_parts([0.0; 3], [x, y, z, 0.7], [1.0; 3]).unwrap();
            let normal = turned.direction([0.0, -1.0, 0.0]).map(|v| v as f32);
            let direction = Framing::automatic(&scene(&flat, turned)).direction;
            let dot: f32 = (0..3).map(|k| normal[k] * direction[k]).sum();
            let square: f32 = direction.iter().map(|v| v * v).sum();
            // The default material is one-sided, so it has to be seen from the front.
            assert!(dot / square.sqrt() > 0.25, "{normal:?} from {direction:?}");
        }
        assert_eq!(Framing::automatic(&scene(&BOX, Transform::IDENTITY)), Framing::default());
        assert_eq!(Framing::automatic(&Scene::new()), Framing::default());
    }

    /// A closed box with its middle at the origin.
    fn closed(size: [f64; 3], turn: [f64; 4]) -> Scene {
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let corner = |k: usize| std::array::from_fn(|a| if k >> a & 1 == 1 { 0.5 } else { -0.5 });
        let data = MeshData { positions: (0..8).map(corner).collect(), triangles, ..MeshData::default() };
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let transform = Transform::from_parts([0.0; 3], turn, size).unwrap();
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        scene
    }

    /// However thin a thing is and whichever way it lies, it is seen from the front and above if it has a back.
    #[test]
    fn closed_models_are_seen_from_the_front_and_above() {
        for k in 0..512_u32 {
            let [x, y, z] = [k % 4, k / 4 % 4, k / 16 % 4].map(|v| f64::from(v) - 1.4);
            let size = std::array::from_fn(|a| if k >> (6 + a) & 1 == 1 { 1.0 } else { 0.004 });
            let [right, up, towards] = Framing::automatic(&closed(size, [x, y, z, 0.7])).direction;
            assert!(up > 0.0 && towards > 0.0, "{size:?} turned by {x} {y} {z} from {right} {up} {towards}");
        }
        let direction = |size| Framing::automatic(&closed(size, [0.0; 4])).direction;
        for size in [[1.0; 3], [1.0, 1.0, 0.01], [0.01, 1.0, 1.0], [0.1, 2.0, 0.1], [1.0, 0.3, 1.0]] {
            assert_eq!(direction(size), Framing::default().direction, "{size:?}");
        }
        // What lies flat shows twice as much from higher up.
        assert_eq!(direction([1.0, 0.01, 1.0]), [0.62, 1.0, 1.0]);
    }

    #[test]
    fn vertices_without_a_triangle_do_not_count() {
        let mut data =
            MeshData { positions: BOX.to_vec(), triangles: vec![[0, 3, 6]], ..MeshData::default() };
        data.positions.push([100.0; 3]);
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let transform = Transform::IDENTITY;
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        let camera = Framing::default().camera(&scene);
        assert!(camera.eye.iter().all(|v| v.abs() < 20.0), "{camera:?}");
    }
}
