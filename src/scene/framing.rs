//! Boxes, and cameras that fit what is in them.

use super::{Camera, Projection, Scene, Transform};
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
            fov_y: 0.523_598_8,
            orthographic: false,
            aspect: 1.0,
            margin: 0.04,
        }
    }
}

impl Framing {
    /// The camera closest to the scene along [`Framing::direction`] that still has every vertex in the picture,
    /// with the margin. An empty scene is seen as if it were a unit cube, a single point likewise.
    #[must_use]
    pub fn camera(&self, scene: &Scene) -> Camera {
        let bounds = scene.bounds();
        let size = bounds.size();
        let diagonal = (size[0] * size[0] + size[1] * size[1] + size[2] * size[2]).sqrt();
        let magnitude = bounds.min.iter().chain(&bounds.max).fold(0.0_f64, |m, v| m.max(v.abs()));
        // A model without extent (or with less than its coordinates resolve) is framed as a unit cube around it.
        let degenerate = bounds.is_empty() || diagonal < magnitude * 1e-6 || diagonal < 1e-12;
        let center = if bounds.is_empty() { [0.0; 3] } else { bounds.center() };
        let [right, up, back] = self.axes();

        // Along each of the four side planes of the view pyramid, how far out the vertices reach.
        let keep = 1.0 - 2.0 * f64::from(self.margin.clamp(0.0, 0.45));
        let aspect = f64::from(self.aspect).clamp(1e-4, 1e4);
        let tan_y = if self.orthographic { 0.0 } else { crate::math::tan_half(f64::from(self.fov_y)) * keep };
        let tan_x = tan_y * aspect;
        let mut reach = [f64::NEG_INFINITY; 4];
        let mut depth = [f64::INFINITY, f64::NEG_INFINITY];
        let mut visit = |p: [f64; 3]| {
            let d = DVec3::from(p) - DVec3::from(center);
            let (x, y, z) = (d.dot(right), d.dot(up), d.dot(back));
            for (r, v) in reach.iter_mut().zip([x + tan_x * z, -x + tan_x * z, y + tan_y * z, -y + tan_y * z])
            {
                *r = if v > *r { v } else { *r };
            }
            depth = [if z < depth[0] { z } else { depth[0] }, if z > depth[1] { z } else { depth[1] }];
        };
        if degenerate {
            for k in 0..8 {
                visit(std::array::from_fn(|a| center[a] + if k >> a & 1 == 1 { 0.5 } else { -0.5 }));
            }
        } else {
            for instance in scene.instances() {
                let mesh = &scene.meshes()[instance.mesh.index()];
                for triangle in mesh.triangles() {
                    for &v in triangle {
                        visit(instance.transform.point(mesh.positions()[v as usize].map(f64::from)));
                    }
                }
            }
        }

        // Each pair of opposite planes fixes the eye's place across the view and a least distance.
        let extent =
            (reach[0] + reach[1]).max((reach[2] + reach[3]) * aspect).max(depth[1] - depth[0]).max(1e-12);
        let x = 0.5 * (reach[0] - reach[1]);
        let y = 0.5 * (reach[2] - reach[3]);
        let (distance, projection) = if self.orthographic {
            let height = ((reach[0] + reach[1]) / aspect).max(reach[2] + reach[3]).max(extent * 1e-6) / keep;
            (depth[1] + extent, Projection::Orthographic { height: height as f32 })
        } else {
            let across = 0.5 * ((reach[0] + reach[1]) / tan_x).max((reach[2] + reach[3]) / tan_y);
            (across.max(depth[1] + extent * 1e-3), Projection::Perspective { fov_y: self.fov_y })
        };
        let eye = DVec3::from(center) + right * x + up * y + back * distance;
        let target = eye - back * (distance - 0.5 * (depth[0] + depth[1])).max(extent * 1e-3);
        Camera {
            eye: eye.to_array().map(|v| v as f32),
            target: target.to_array().map(|v| v as f32),
            up: up.to_array().map(|v| v as f32),
            projection,
            near: (((distance - depth[1]) * 0.5).max(extent * 1e-4) as f32).max(1e-6),
        }
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
