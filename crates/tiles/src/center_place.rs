//! Places of pixels' centres on their triangles, as exact as the scene's coordinates are.
//!
//! The rasterizer moves vertices to the nearest 1/256 of a pixel, and depth that is interpolated between them lies that much off the
//! surface. Planes of depth and position are to be points of it: here the ray through the centre meets the plane of the triangle.

use overcoat_core::each;
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::raster::{SUBPIXELS, TileOrigin};
use overcoat_stages::shade::ViewRays;

/// Ray of a pixel's centre, whose direction is one unit deep.
#[derive(Clone, Copy, Debug)]
pub struct CenterRay {
    start: [f64; 3],
    direction: [f64; 3],
}

impl CenterRay {
    /// The ray of a pixel of a tile.
    pub fn new(rays: &ViewRays, origin: TileOrigin, [column, row]: [u32; 2]) -> Self {
        let center = |corner: i32, pixel: u32| {
            f64::from(corner + pixel as i32 * SUBPIXELS + SUBPIXELS / 2) / f64::from(SUBPIXELS)
        };
        let (x, y) = (center(origin.x, column), center(origin.y, row));
        let [eye, right, down, ahead] =
            [rays.eye, rays.right, rays.down, rays.centre].map(|v| v.map(f64::from));
        let across: [f64; 3] = each!(k => right[k] * x + down[k] * y);
        if rays.perspective {
            Self { start: eye, direction: each!(k => ahead[k] + across[k]) }
        } else {
            Self { start: each!(k => eye[k] + across[k]), direction: ahead }
        }
    }

    /// Distance along the view, and position, of the point at which the ray meets the plane of a triangle: no nearer and no farther
    /// than its corners, since at a border the centre may lie a little beside it. `None` if the triangle has no plane.
    pub fn meet(&self, rays: &ViewRays, draw: &Draw<'_>, vertices: [u32; 3]) -> Option<(f32, [f32; 3])> {
        let corner = |vertex: u32| -> Option<[f64; 3]> {
            let [x, y, z] = draw.mesh.positions().get(vertex as usize)?.map(f64::from);
            let row = |[a, b, c, d]: [f32; 4]| {
                f64::from(a) * x + f64::from(b) * y + f64::from(c) * z + f64::from(d)
            };
            Some(draw.position_matrix.map(row))
        };
        let (a, b, c) = (corner(vertices[0])?, corner(vertices[1])?, corner(vertices[2])?);
        let normal = cross(less(b, a), less(c, a));
        let met = dot(normal, less(a, self.start)) / dot(normal, self.direction);
        let (eye, forward) = (rays.eye.map(f64::from), rays.forward.map(f64::from));
        let distances = [a, b, c].map(|corner| dot(forward, less(corner, eye)));
        let nearest = distances.into_iter().fold(f64::INFINITY, |least, d| if d < least { d } else { least });
        let farthest =
            distances.into_iter().fold(f64::NEG_INFINITY, |most, d| if d > most { d } else { most });
        let distance = if met < nearest {
            nearest
        } else if met > farthest {
            farthest
        } else {
            met
        };
        let place = each!(k => (self.start[k] + self.direction[k] * distance) as f32);
        distance.is_finite().then_some((distance as f32, place))
    }
}

fn less(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    each!(k => a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
