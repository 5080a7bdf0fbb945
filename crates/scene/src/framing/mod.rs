//! The automatic camera: up axis and front of a scene, its visible parts, and a view that fits it.

mod convex_hull;
pub(crate) mod crowd;
mod discs;
mod evidence;
pub(crate) mod extent;
mod facing;
mod fit;
mod footing;
mod front;
pub(crate) mod orientation;
mod origin;
mod rest;
pub(crate) mod seen;
mod trees;
mod upright;

pub use crowd::Crowd;
pub use fit::Fit;
pub use footing::Footing;
pub use orientation::{Axis, Orientation};

use crate::{Camera, Intrinsics, Projection, Scene};
use facing::{Estimate, Facing};
use glam::DVec3;

/// Rules by which a camera is placed when the user gives none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Framing {
    /// From the model towards the camera, any length above 0.
    pub direction: [f32; 3],
    /// Up vector.
    pub up: [f32; 3],
    /// Vertical field of view in radians; ignored when orthographic, and with intrinsics.
    pub fov_y: f32,
    /// Intrinsics, in place of field of view and aspect; ignored when orthographic.
    pub intrinsics: Option<Intrinsics>,
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
            intrinsics: None,
            orthographic: false,
            aspect: 1.0,
            margin: Self::MARGIN,
        }
    }
}

impl Framing {
    /// Margin of a picture without a floor.
    pub const MARGIN: f32 = 0.04;
    /// Margin of a picture that shows a model's shadow on a floor: models are 3 percent smaller.
    pub const MARGIN_OVER_FLOOR: f32 = 0.053;

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

    /// A view from the front and above: [`Framing::default`]'s, unless another one from there shows twice as much of
    /// the surface, as of flat models that lie or that it meets edge-on. A view from behind only for surfaces that
    /// show their back to all of those, one-sided planes above all, and one from below only for surfaces that face
    /// down.
    ///
    /// The margin is that of a picture with the default options of the renderer: [`Framing::MARGIN_OVER_FLOOR`] where the model
    /// casts a shadow on a floor.
    ///
    /// The front is +Z of the scene. Where the file's format does not say so ([`Orientation::front_is_known`]) and the model is
    /// a long body whose head is at the other end, it is -Z.
    ///
    /// [`Orientation::front_is_known`]: crate::Orientation::front_is_known
    #[must_use]
    pub fn automatic(scene: &Scene) -> Self {
        let framing = Self { direction: Self::automatic_direction(scene), ..Self::default() };
        if framing.direction[1] >= 0.0 && scene.blocks_light() {
            return Self { margin: Self::MARGIN_OVER_FLOOR, ..framing };
        }
        framing
    }

    /// Direction of [`Framing::automatic`].
    fn automatic_direction(scene: &Scene) -> [f32; 3] {
        let back = !scene.orientation().front_is_known && front::faces_back(scene);
        let turned = |[x, y, z]: [f32; 3]| if back { [-x, y, -z] } else { [x, y, z] };
        let views = VIEWS.map(|views| views.map(turned));
        let [[first, ..], ..] = views;
        if Estimate::new(scene).surely_shows(first, ENOUGH, views.as_flattened()) {
            return first;
        }
        let facing = Facing::new(scene);
        let shown = |view: &[f32; 3]| facing.visible_from(*view);
        let most = |views: &[[f32; 3]]| views.iter().map(shown).fold(0.0, f64::max);
        let all = most(views.as_flattened());
        let chosen = |views: &[[f32; 3]; 6]| {
            let enough = (ENOUGH * most(views)).max(SOMETHING * all);
            views.iter().find(|&view| shown(view) >= enough).copied()
        };
        views.iter().find_map(chosen).unwrap_or(first)
    }

    /// The camera closest to the scene along [`Framing::direction`] that still has every vertex in the picture,
    /// with the margin, and every point with the disc that it is drawn as. Strays that make a scene look much larger than it
    /// is do not count: see [`Scene::crowd`]. An empty scene is seen as if it were a unit cube, a single point likewise.
    #[must_use]
    pub fn camera(&self, scene: &Scene) -> Camera {
        let mut fit = Fit::new(*self);
        fit.include(scene);
        fit.camera()
    }

    /// View without the margin.
    fn cone(&self) -> Cone {
        if let Some(own) = self.intrinsics.filter(|_| !self.orthographic) {
            let [width, height] = [own.width, own.height].map(|side| f64::from(side) * 0.5);
            let tangents = [width / own.fx * self.keep(), height / own.fy * self.keep()];
            return Cone { tangents, middle: [(width - own.cx) / own.fx, (own.cy - height) / own.fy] };
        }
        Cone { tangents: self.tangents(), middle: [0.0; 2] }
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
        let projection = Projection::Perspective { fov_y: 1.0 };
        let camera = Camera::new(self.direction, [0.0; 3], self.up, projection, 1.0);
        let axes = camera.axes().unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        axes.map(DVec3::from)
    }
}

/// Pyramid of a view, seen from one metre; 0 for parallel views.
#[derive(Clone, Copy, Debug)]
struct Cone {
    /// Half its width and height.
    tangents: [f64; 2],
    /// Middle of the picture, to the right of and above the view direction.
    middle: [f64; 2],
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

/// A view is good that shows at least this share of the area that the best of its kind shows,
const ENOUGH: f64 = 0.5;

/// and this share of the area that the best of all shows: there is one from the front and above for everything that is
/// closed.
const SOMETHING: f64 = 0.35;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, Mesh, MeshData, Transform};

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
                    Projection::Intrinsics(_) => unreachable!("none was asked for"),
                };
                let x = d.dot(right) / (half_height * f64::from(aspect));
                let y = d.dot(up) / half_height;
                largest = largest.max(x.abs()).max(y.abs());
                clearance = clearance.min(distance / f64::from(camera.near));
            }
        }
        (largest, clearance)
    }

    /// Largest part of the way from the middle of the picture to a border at which a vertex is seen.
    fn reach_of_k(scene: &Scene, camera: &Camera, [width, height]: [u32; 2]) -> f64 {
        let [[fx, _, cx], [_, fy, cy], _] = camera.matrix_k(width, height).unwrap();
        let [right, up, back] = camera.axes().unwrap().map(DVec3::from);
        let (w, h) = (f64::from(width) * 0.5, f64::from(height) * 0.5);
        let places = scene.meshes()[0].positions().iter().map(|p| {
            let d = DVec3::from(p.map(f64::from)) - DVec3::from(camera.eye.map(f64::from));
            let z = -d.dot(back);
            let (x, y) = (fx * d.dot(right) / z + cx, cy - fy * d.dot(up) / z);
            ((x - w) / w).abs().max(((y - h) / h).abs())
        });
        places.fold(0.0, f64::max)
    }

    #[test]
    fn a_shifted_view_is_filled_as_others_are() {
        let scene = scene(&BOX, Transform::IDENTITY);
        let size = [640, 480];
        for (direction, up) in DIRECTIONS {
            for four in [
                [600.0, 600.0, 320.0, 240.0],
                [600.0, 400.0, 100.0, 400.0],
                [900.0, 900.0, -500.0, 240.0],
                [300.0, 700.0, 400.5, 1500.0],
            ] {
                let intrinsics = Some(Intrinsics::new(four, size).unwrap());
                let framing = Framing { direction, up, intrinsics, ..Framing::default() };
                let largest = reach_of_k(&scene, &framing.camera(&scene), size);
                let keep = 1.0 - 2.0 * f64::from(Framing::MARGIN);
                assert!(largest <= keep + 1e-6 && largest > keep * 0.999, "{largest} of {keep}: {framing:?}");
            }
        }
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
                    intrinsics: None,
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
        let over_floor = Framing { margin: Framing::MARGIN_OVER_FLOOR, ..Framing::default() };
        assert_eq!(Framing::automatic(&scene(&BOX, Transform::IDENTITY)), over_floor);
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
