//! Where a scene stands.

use super::Scene;

/// Where a floor lies under a scene, and how large the scene is over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footing {
    /// The place on the floor that is below the middle of the box around the scene.
    pub center: [f64; 3],
    /// Height of the box, above 0.
    pub height: f64,
    /// Half of the box's diagonal, above 0.
    pub radius: f64,
}

impl Scene {
    /// Where the scene stands: at its lowest vertex that can be seen, of splats the lowest that a camera is to show. `None` of
    /// an empty one, and of one that is a point.
    pub(crate) fn footing(&self) -> Option<Footing> {
        let bounds = self.shown_bounds();
        if bounds.is_empty() {
            return None;
        }
        let low = self.lowest();
        let low = if low.is_finite() { low } else { bounds.min[1] };
        let [x, y, z] = bounds.center();
        let [width, _, depth] = bounds.size();
        let height = bounds.max[1] - low;
        let radius = 0.5 * (width * width + height * height + depth * depth).sqrt();
        let magnitude = [x, y, z].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let least = (magnitude * 1e-6).max(1e-12);
        let height = if height > least { height } else { least };
        (radius > least).then_some(Footing { center: [x, low, z], height, radius })
    }

    /// The least height of vertices. Boxes of instances that are turned reach lower than what is in them.
    fn lowest(&self) -> f64 {
        let mut low = f64::INFINITY;
        let reach = |low: f64, y: f64| if y < low { y } else { low };
        for instance in self.splat_instances() {
            let cloud = &self.splats()[instance.cloud.index()];
            low = reach(low, cloud.shown_bounds().transformed(&instance.transform).min[1]);
        }
        for instance in self.seen_instances() {
            let mesh = &self.meshes()[instance.mesh.index()];
            let [_, row, _] = instance.transform.rows();
            let own = mesh.bounds().transformed(&instance.transform).min[1];
            let is_turned = row[..3].iter().filter(|c| **c != 0.0).count() > 1;
            if !is_turned {
                low = reach(low, own);
                continue;
            }
            if own > low {
                continue;
            }
            let used = mesh.used_vertices();
            for (k, p) in mesh.positions().iter().enumerate() {
                if used.as_ref().is_none_or(|used| used[k]) {
                    let [x, y, z] = p.map(f64::from);
                    let y = row[0] * x + row[1] * y + row[2] * z + row[3];
                    low = reach(low, y);
                }
            }
        }
        low
    }
}
