//! Finds places on the skin, so that details sit on it whatever its shape.

use glam::{DVec2, DVec3};

use super::super::mesh::Mesh;

/// A place on the skin.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// On the surface.
    pub position: DVec3,
    /// Unit length, outwards.
    pub normal: DVec3,
}

impl Place {
    /// The point `depth` below the surface.
    pub fn inside(&self, depth: f64) -> DVec3 {
        self.position - self.normal * depth
    }
}

/// Shoots rays along the axes at the right half of the skin.
pub struct Probe {
    skin: Mesh,
}

impl Probe {
    /// Over the uncut skin.
    pub fn new(skin: Mesh) -> Self {
        Self { skin }
    }

    /// Seen from the right at (x, y).
    pub fn side(&self, x: f64, y: f64) -> Place {
        self.shoot(DVec2::new(x, y), 2, 1.0)
    }

    /// Seen from above at (x, z).
    pub fn top(&self, x: f64, z: f64) -> Place {
        self.shoot(DVec2::new(x, z), 1, 1.0)
    }

    /// Seen from the front at (z, y); z may be negative.
    pub fn front(&self, z: f64, y: f64) -> Place {
        self.end(z, y, 1.0)
    }

    /// Seen from the rear at (z, y); z may be negative.
    pub fn rear(&self, z: f64, y: f64) -> Place {
        self.end(z, y, -1.0)
    }

    fn end(&self, z: f64, y: f64, side: f64) -> Place {
        let mut place = self.shoot(DVec2::new(z.abs(), y), 0, side);
        if z < 0.0 {
            place.position.z = -place.position.z;
            place.normal.z = -place.normal.z;
        }
        place
    }

    /// The outermost point along an axis. Rays that miss are mistakes in the model.
    fn shoot(&self, at: DVec2, axis: usize, side: f64) -> Place {
        let flat = |p: DVec3| match axis {
            0 => DVec2::new(p.z, p.y),
            1 => DVec2::new(p.x, p.z),
            _ => DVec2::new(p.x, p.y),
        };
        let mut best: Option<Place> = None;
        for triangle in &self.skin.triangles {
            let v = triangle.map(|i| self.skin.vertices[i as usize]);
            let [a, b, c] = v.map(|v| flat(v.position));
            let area = (b - a).perp_dot(c - a);
            if area == 0.0 {
                continue;
            }
            let weights = [(b - at).perp_dot(c - at), (c - at).perp_dot(a - at), (a - at).perp_dot(b - at)]
                .map(|w| w / area);
            if weights.iter().any(|w| *w < -1e-9) {
                continue;
            }
            let sum = |f: fn(&super::super::mesh::Vertex) -> DVec3| {
                f(&v[0]) * weights[0] + f(&v[1]) * weights[1] + f(&v[2]) * weights[2]
            };
            let (position, normal) = (sum(|v| v.position), sum(|v| v.normal).normalize());
            if best.is_none_or(|best| position[axis] * side > best.position[axis] * side) {
                best = Some(Place { position, normal });
            }
        }
        best.expect("the ray meets the skin")
    }
}
