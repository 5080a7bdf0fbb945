//! Box on the screen around geometry, also of what the picture does not show.

use overcoat_scene::{Bounds, Mesh, Transform};
use overcoat_stages::geometry::View;

/// Box around projected points, in pixels from the middle of the picture. Empty at first.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProjectedBox {
    least: [f64; 2],
    most: [f64; 2],
}

impl Default for ProjectedBox {
    fn default() -> Self {
        Self { least: [f64::INFINITY; 2], most: [f64::NEG_INFINITY; 2] }
    }
}

/// Edges of a triangle, and of a box whose corners are numbered by the bits of their axes.
const OF_TRIANGLE: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];
const OF_BOX: [[usize; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

impl ProjectedBox {
    /// Adds the primitives of a mesh at a place.
    pub(super) fn add_mesh(&mut self, view: &View, mesh: &Mesh, transform: &Transform) {
        let project = |place: &[f32; 3]| view.project(transform.point(place.map(f64::from)));
        let points: Vec<[f64; 3]> = mesh.positions().iter().map(project).collect();
        if mesh.triangles().is_empty() {
            points.iter().filter(|point| is_between(view, point)).for_each(|point| self.add(view, point));
        }
        for triangle in mesh.triangles() {
            let corners = triangle.map(|vertex| points[vertex as usize]);
            if corners.iter().all(|corner| is_between(view, corner)) {
                corners.iter().for_each(|corner| self.add(view, corner));
            } else {
                self.add_edges(view, &corners, &OF_TRIANGLE);
            }
        }
    }

    /// Adds a box of object space at a place.
    pub(super) fn add_bounds(&mut self, view: &View, bounds: &Bounds, transform: &Transform) {
        if bounds.is_empty() {
            return;
        }
        let corner = |k: usize| {
            let axis = |axis: usize| if k >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            view.project(transform.point([axis(0), axis(1), axis(2)]))
        };
        let corners: [[f64; 3]; 8] = std::array::from_fn(corner);
        self.add_edges(view, &corners, &OF_BOX);
    }

    /// Adds edges as far as they lie between the near and the far limit: the rest of a convex outline begins where its edges are
    /// cut.
    fn add_edges(&mut self, view: &View, corners: &[[f64; 3]], edges: &[[usize; 2]]) {
        for &[from, to] in edges {
            let (a, b) = (corners[from], corners[to]);
            let along = b[2] - a[2];
            let (mut start, mut end) = (0.0, 1.0);
            for (limit, keeps_greater) in [(f64::from(view.near), true), (f64::from(view.far), false)] {
                let at = (limit - a[2]) / along;
                match (along == 0.0 || !limit.is_finite(), (along > 0.0) == keeps_greater) {
                    (true, _) => {
                        if (a[2] < limit) == keeps_greater {
                            end = -1.0;
                        }
                    }
                    (false, true) => start = if at > start { at } else { start },
                    (false, false) => end = if at < end { at } else { end },
                }
            }
            if start <= end {
                let point = |t: f64| -> [f64; 3] { std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t) };
                [start, end].iter().for_each(|&t| self.add(view, &point(t)));
            }
        }
    }

    /// Adds a point before the viewer, in homogeneous coordinates of the screen.
    fn add(&mut self, view: &View, &[x, y, distance]: &[f64; 3]) {
        let w = if view.perspective { distance } else { 1.0 };
        for (k, value) in [x / w, y / w].into_iter().enumerate() {
            self.least[k] = if value < self.least[k] { value } else { self.least[k] };
            self.most[k] = if value > self.most[k] { value } else { self.most[k] };
        }
    }

    /// The box in pixels from the upper left corner: left, top, width and height. `None` if it is empty.
    pub(super) fn finish(self, view: &View) -> Option<[f64; 4]> {
        let Self { least, most } = self;
        let [left, top] = [least[0] + f64::from(view.width) * 0.5, least[1] + f64::from(view.height) * 0.5];
        (most[0] >= least[0]).then(|| [left, top, most[0] - least[0], most[1] - least[1]])
    }
}

/// True if a projected point lies between the near and the far limit.
fn is_between(view: &View, point: &[f64; 3]) -> bool {
    point[2] >= f64::from(view.near) && point[2] <= f64::from(view.far)
}
