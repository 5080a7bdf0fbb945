//! Front of a model whose file does not define it.

use crate::Scene;
use glam::DVec3;

/// A body is long if it is so many times as long, along Z, as it is wide.
const LONG: f64 = 1.25;

/// Largest distance of the surface's centre from the middle of the width, in widths, of a body whose sides are alike.
const ALIKE: f64 = 0.02;

/// The end of a body that has so many times as much surface, and as many triangles, as the other is a head, and the other
/// a tail, if it is thin.
const HEADY: f64 = 3.0;

/// Half the width of a thin part, in widths of the body.
const THIN: f64 = 0.25;

/// Distance of the highest quarter from the middle towards an end, in lengths, if it is a head. Less may be a roof,
/// and more a headboard, a backrest or a fin.
const RAISED: std::ops::RangeInclusive<f64> = 0.15..=0.4;

/// Number of triangles that are tested, at most: of larger models, each second, third, and so on.
const MOST: u64 = 1 << 16;

/// True if the model is a long body whose head is at its -Z end. OBJ and PLY do not define the front of a model. Most
/// face +Z as glTF's do; animals, above all, come either way, and are recognised by a head that is held high or has a
/// tail at the other end. A model that is as wide as it is long, or whose sides differ, is left alone.
pub(crate) fn faces_back(scene: &Scene) -> bool {
    let bounds = scene.bounds();
    let [width, height, length] = bounds.size();
    // Not where these are infinite, or no numbers.
    if bounds.is_empty() || !(length >= LONG * width && width > 0.0 && height > 0.0) {
        return false;
    }
    let step = scene.triangle_count().div_ceil(MOST).max(1) as usize;
    let [middle_x, _, middle_z] = bounds.center();
    let high = bounds.max[1] - 0.25 * height;
    let (front, back) = (bounds.max[2] - 0.2 * length, bounds.min[2] + 0.2 * length);
    let (mut area, mut across) = (0.0, 0.0);
    // Surface, triangles, and half of the width.
    let mut ends = [[0.0_f64; 3]; 2];
    let mut top = [0.0; 2];
    for instance in scene.instances() {
        let mesh = &scene.meshes()[instance.mesh.index()];
        let point =
            |v: u32| DVec3::from(instance.transform.point(mesh.positions()[v as usize].map(f64::from)));
        for &[a, b, c] in mesh.triangles().iter().step_by(step) {
            let [a, b, c] = [point(a), point(b), point(c)];
            let n = (b - a).cross(c - a);
            let own = (n.x * n.x + n.y * n.y + n.z * n.z).sqrt();
            let center = (a + b + c) * (1.0 / 3.0);
            area += own;
            across += own * (center.x - middle_x);
            for (end, inside) in ends.iter_mut().zip([center.z > front, center.z < back]) {
                if inside && own > 0.0 {
                    let wide = [a, b, c].iter().fold(end[2], |wide, p| wide.max((p.x - middle_x).abs()));
                    *end = [end[0] + own, end[1] + 1.0, wide];
                }
            }
            if center.y > high {
                top = [top[0] + own, top[1] + own * (center.z - middle_z)];
            }
        }
    }
    if !(area > 0.0 && across.abs() <= ALIKE * width * area) {
        return false;
    }
    let heady = |[area, count, _]: [f64; 3], [others, fewer, wide]: [f64; 3]| {
        area > HEADY * others && count > HEADY * fewer && wide < THIN * width
    };
    let [front, back] = ends;
    match (heady(front, back), heady(back, front)) {
        (true, _) => false,
        (_, true) => true,
        _ => RAISED.contains(&(-top[1] / (top[0] * length))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, Mesh, MeshData, Orientation, Transform};

    /// Boxes, each as its smallest and its largest corner.
    fn boxes(boxes: &[[[f32; 3]; 2]], turned: bool) -> Scene {
        let mut data = MeshData::default();
        for [low, high] in boxes {
            let first = data.positions.len() as u32;
            for k in 0..8 {
                let corner = |a: usize| if k >> a & 1 == 1 { high[a] } else { low[a] };
                data.positions.push([corner(0), corner(1), corner(2)]);
            }
            for [a, b, c, d] in
                [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
            {
                data.triangles.extend([[a, b, c], [a, c, d]].map(|t| t.map(|v| v + first)));
            }
        }
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let turn = if turned { [0.0, 1.0, 0.0, 0.0] } else { [0.0, 0.0, 0.0, 1.0] };
        let transform = Transform::from_parts([0.0; 3], turn, [1.0; 3]).unwrap();
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        scene.stand_up(Orientation { front_is_known: false, ..Orientation::default() });
        scene
    }

    /// A body, a head in front of and above it, and legs.
    const COW: [[[f32; 3]; 2]; 4] = [
        [[-1.0, 1.0, -2.0], [1.0, 3.0, 2.0]],
        [[-0.6, 2.6, 1.2], [0.6, 4.2, 2.6]],
        [[-1.0, 0.0, 1.0], [1.0, 1.0, 1.6]],
        [[-1.0, 0.0, -1.6], [1.0, 1.0, -1.0]],
    ];

    #[test]
    fn heads_tell_where_the_front_is() {
        assert!(!faces_back(&boxes(&COW, false)));
        assert!(faces_back(&boxes(&COW, true)));
        // Cars, in either direction: the cabin is near the middle.
        let car = [[[-0.9, 0.2, -2.2], [0.9, 0.9, 2.2]], [[-0.8, 0.9, -1.6], [0.8, 1.5, 0.9]]];
        assert!(!faces_back(&boxes(&car, false)) && !faces_back(&boxes(&car, true)));
        // A bed: what is high is a board at the end.
        let bed = [[[-0.7, 0.0, -1.0], [0.7, 0.5, 1.0]], [[-0.7, 0.5, -1.0], [0.7, 1.2, -0.95]]];
        assert!(!faces_back(&boxes(&bed, false)) && !faces_back(&boxes(&bed, true)));
        // A chair is as wide as it is long.
        let chair = [[[-0.5, 0.0, -0.5], [0.5, 0.5, 0.5]], [[-0.5, 0.5, -0.5], [0.5, 1.0, -0.2]]];
        assert!(!faces_back(&boxes(&chair, false)) && !faces_back(&boxes(&chair, true)));
        // A head at one side only is none.
        let lopsided = [COW[0], [[0.2, 2.6, -2.6], [1.0, 4.2, -1.2]]];
        assert!(!faces_back(&boxes(&lopsided, false)));
    }

    #[test]
    fn nothing_faces_nowhere() {
        assert!(!faces_back(&Scene::new()));
        assert!(!faces_back(&boxes(&[[[0.0; 3]; 2]], false)));
        assert!(!faces_back(&boxes(&[[[0.0; 3], [0.0, 1.0, 5.0]]], false)));
    }
}
