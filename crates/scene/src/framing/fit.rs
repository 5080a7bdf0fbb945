//! Fit of the camera to the visible parts of scenes.

use super::discs::{Disc, Discs};
use super::extent::{self, Extent};
use super::{Cone, Framing};
use crate::{
    Bounds, Camera, Mesh, MeshId, PrimitiveKind, Projection, Revision, Scene, SplatCloud, Transform,
};
use glam::DVec3;

/// Finds the camera that fits several scenes, for pictures that follow each other: poses of one model, or a model that
/// turns.
#[derive(Debug)]
pub struct Fit {
    framing: Framing,
    bounds: Bounds,
    /// Centre of the first scene that is not empty: origin of all measures.
    center: [f64; 3],
    reach: Reach,
    /// Crowd of the scene of this name.
    crowd: Option<(Revision, Option<Bounds>)>,
}

impl Fit {
    /// Nothing to fit yet.
    #[must_use]
    pub fn new(framing: Framing) -> Self {
        let center = [0.0; 3];
        let reach = Reach::new(framing.axes(), center, framing.cone());
        Self { framing, bounds: Bounds::EMPTY, center, reach, crowd: None }
    }

    /// Takes in a scene: of one whose strays make it look much larger than it is, its crowd ([`Scene::crowd`]).
    pub fn include(&mut self, scene: &Scene) {
        self.include_moved(scene, &Transform::IDENTITY);
    }

    /// Takes in a scene that stands elsewhere.
    pub fn include_moved(&mut self, scene: &Scene, by: &Transform) {
        // Numbers that overflow there cannot be drawn either.
        let placed = |transform: &Transform| by.after(transform).unwrap_or(*transform);
        let crowd = self.crowd_of(scene);
        let bounds = match &crowd {
            Some(crowd) => crowd.transformed(by),
            None => scene.seen_instances().fold(Bounds::EMPTY, |all, instance| {
                let mesh = &scene.meshes()[instance.mesh.index()];
                all.union(&mesh.bounds().transformed(&placed(&instance.transform)))
            }),
        };
        let bounds = scene.splat_instances().iter().fold(bounds, |all, instance| {
            let cloud = &scene.splats()[instance.cloud.index()];
            all.union(&cloud.shown_bounds().transformed(&placed(&instance.transform)))
        });
        if bounds.is_empty() {
            return;
        }
        if self.bounds.is_empty() {
            self.center = bounds.center();
            self.reach = Reach::new(self.framing.axes(), self.center, self.framing.cone());
        }
        self.bounds = self.bounds.union(&bounds);
        let mut used: Option<(MeshId, Option<Vec<bool>>)> = None;
        for instance in scene.seen_instances() {
            let mesh = &scene.meshes()[instance.mesh.index()];
            let transform = placed(&instance.transform);
            if mesh.kind() == PrimitiveKind::Points && Discs::count_in(mesh) {
                let discs = Discs::new(mesh, &transform);
                let counts = |p| crowd.is_none_or(|crowd| crowd.contains(instance.transform.point(p)));
                self.reach.visit_discs(&discs, counts);
                continue;
            }
            let measures = self.reach.measures(&transform);
            let bounds = mesh.bounds();
            if bounds.is_empty() || !self.reach.grows(&measures, bounds) {
                continue;
            }
            // Copies of a mesh often follow each other.
            if used.as_ref().is_none_or(|(id, _)| *id != instance.mesh) {
                used = Some((instance.mesh, mesh.used_vertices()));
            }
            let used = used.as_ref().and_then(|(_, used)| used.as_deref());
            match &crowd {
                None => self.reach.visit(&measures, mesh, used),
                Some(crowd) => {
                    let inside = inside(crowd, mesh, &instance.transform, used);
                    self.reach.visit(&measures, mesh, Some(&inside));
                }
            }
        }
        for instance in scene.splat_instances() {
            let cloud = &scene.splats()[instance.cloud.index()];
            self.reach.visit_splats(&self.reach.measures(&placed(&instance.transform)), cloud);
        }
    }

    /// Box of the crowd of a scene, found once for all that follow in which it does not change.
    fn crowd_of(&mut self, scene: &Scene) -> Option<Bounds> {
        let revision = scene.revision();
        match self.crowd {
            Some((known, crowd)) if known == revision => crowd,
            _ => {
                let crowd = scene.crowd().map(|crowd| crowd.bounds);
                self.crowd = Some((revision, crowd));
                crowd
            }
        }
    }

    /// The camera closest to the scenes that has every vertex of each in the picture, as [`Framing::camera`].
    #[must_use]
    pub fn camera(self) -> Camera {
        let Self { framing, bounds, center, mut reach, .. } = self;
        let size = bounds.size();
        let diagonal = (size[0] * size[0] + size[1] * size[1] + size[2] * size[2]).sqrt();
        let magnitude = center.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let axes = framing.axes();
        let Cone { tangents: [tan_x, tan_y], middle } = framing.cone();
        let (keep, aspect) = (framing.keep(), framing.clamped_aspect());
        // A model without extent, or with less than its coordinates resolve, is framed as a cube around it: of
        // 1 m, or larger where single precision could not hold the camera apart from the model.
        let degenerate = bounds.is_empty() || diagonal < magnitude * 3e-7 || diagonal < SMALLEST;
        if degenerate {
            reach = Reach::new(axes, center, framing.cone());
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
            let projection = match framing.intrinsics {
                Some(intrinsics) => Projection::Intrinsics(intrinsics),
                None => Projection::Perspective { fov_y: fov_y as f32 },
            };
            // Each pair of opposite planes fixes the eye's place across the view and a least distance.
            let distance = 0.5 * (width / tan_x).max(height / tan_y);
            (distance.max(near + extent * 1e-3), projection)
        };
        let (x, y) = (x - middle[0] * distance, y - middle[1] * distance);
        let [axis_x, axis_y, back] = axes;
        let eye = DVec3::from(center) + axis_x * x + axis_y * y + back * distance;
        let target = eye - back * (distance - 0.5 * (far + near)).max(extent * 1e-3);
        let single = |v: DVec3| v.to_array().map(|v| v as f32);
        let near = ((distance - near) * 0.5).max(extent * 1e-4) as f32;
        Camera::new(single(eye), single(target), single(axis_y), projection, near)
    }
}

/// Mask of the vertices of a mesh that count and lie in a box of the world.
fn inside(bounds: &Bounds, mesh: &Mesh, transform: &Transform, used: Option<&[bool]>) -> Vec<bool> {
    let lies_inside = |p: &[f32; 3]| bounds.contains(transform.point(p.map(f64::from)));
    let places = mesh.positions().iter().enumerate();
    places.map(|(k, p)| used.is_none_or(|used| used[k]) && lies_inside(p)).collect()
}

/// Smallest extent in metres of a model that is framed as it is.
const SMALLEST: f64 = 1e-12;

/// Extent of points beyond the four side planes of a view pyramid that stands at the centre of the scene.
#[derive(Debug)]
struct Reach {
    /// Measures of the right, left, upper and lower plane and of the depth, as (direction, offset).
    measures: [(DVec3, f64); 5],
    /// Largest measure of right, left, top and bottom, in metres across the view.
    planes: [f64; 4],
    /// Farthest and nearest depth, in metres towards the viewer.
    depth: [f64; 2],
}

impl Reach {
    /// Nothing seen yet.
    fn new([right, up, back]: [DVec3; 3], center: [f64; 3], cone: Cone) -> Self {
        let Cone { tangents: [tan_x, tan_y], middle: [x, y] } = cone;
        let directions = [
            right + back * (tan_x + x),
            back * (tan_x - x) - right,
            up + back * (tan_y + y),
            back * (tan_y - y) - up,
            back,
        ];
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

    /// Takes in the vertices of an instance; `used` is the mask of those that count, unless all do.
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

    /// Takes in the discs that points are drawn as, of those that count by their positions in the mesh.
    fn visit_discs(&mut self, discs: &Discs<'_>, counts: impl Fn([f64; 3]) -> bool) {
        let world = self.measures(&Transform::IDENTITY);
        discs.for_each(|place, Disc { center, radius, normal }| {
            // Most discs lie among others.
            let around = Bounds { min: center.map(|v| v - radius), max: center.map(|v| v + radius) };
            if !self.grows(&world, &around) || !counts(place) {
                return;
            }
            let half = |k: usize| {
                let d = DVec3::from(world.0[k].0);
                let across = d.dot(d) - d.dot(normal) * d.dot(normal);
                if across > 0.0 { radius * across.sqrt() } else { 0.0 }
            };
            for (k, plane) in self.planes.iter_mut().enumerate() {
                let m = world.of(k, center) + half(k);
                *plane = if m > *plane { m } else { *plane };
            }
            let (depth, half) = (world.of(4, center), half(4));
            self.depth[0] = if depth - half < self.depth[0] { depth - half } else { self.depth[0] };
            self.depth[1] = if depth + half > self.depth[1] { depth + half } else { self.depth[1] };
        });
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

    /// False if no point of a box can change anything. Rounding keeps the order of numbers, so the measure computed
    /// for the corner that lies farthest along it is at least that of any point of the box.
    fn grows(&self, measures: &Measures, bounds: &Bounds) -> bool {
        let farthest = |k: usize, sign: f64| {
            let d = measures.0[k].0;
            let corner = |a: usize| if d[a] * sign > 0.0 { bounds.max[a] } else { bounds.min[a] };
            measures.of(k, [corner(0), corner(1), corner(2)])
        };
        // NaN decides nothing.
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

/// The five measures as functions of an instance's points, as (direction, offset).
struct Measures([([f64; 3], f64); 5]);

impl Measures {
    /// Measure `k` of a point.
    fn of(&self, k: usize, p: [f64; 3]) -> f64 {
        let (d, offset) = &self.0[k];
        d[0] * p[0] + d[1] * p[1] + d[2] * p[2] + offset
    }

    /// Half the extent of an ellipsoid with these half axes along measure `k`.
    fn spread(&self, k: usize, axes: &[[f64; 3]; 3]) -> f64 {
        let (d, _) = &self.0[k];
        let along = |axis: &[f64; 3]| d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
        let [a, b, c] = [along(&axes[0]), along(&axes[1]), along(&axes[2])];
        (a * a + b * b + c * c).sqrt()
    }
}
