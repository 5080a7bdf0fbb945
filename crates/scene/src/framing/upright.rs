//! Up axis of models whose file does not define it.

use super::evidence::Rise;
use super::rest::{Body, Triangle};
use crate::{Axis, PrimitiveKind, Scene};

/// Number of triangles that are tested, at most: of larger models, each second, third, and so on.
const MOST: usize = 32_768;

impl Scene {
    /// The axis that is up by the shape of a scene in the coordinates of its file, before [`Scene::stand_up`]: of +Y and
    /// +Z the `usual` one of the format, unless the evidence is strong that the model stands on the other. Evidence is the floor of
    /// the file, the plane through zero; the contact with a floor, and the place of the centre of mass above it; surface that is
    /// flat, sloped or hangs over, by its height and side; the side that open surfaces show; edges; proportions; and the direction
    /// in which textures are upright. Boosted trees weigh it, fitted to models whose up axis is known, and turn a model at
    /// odds of 9 to 1, or of 4 to 1 if it would fall over as it is usual. What is alike in both poses stays. Where `usual` is another axis, or the scene has no triangles or
    /// is flat, it is `usual`.
    ///
    /// Seven of ten models that break the custom of their format are found, of sources to which the trees are not fitted (one of four
    /// where the middle of the model is zero), and fewer than two of a hundred that follow it are turned, mostly parts of other
    /// models and what hangs on a wall.
    ///
    /// Colours and the order of the triangles do not count, but of more than 32,768 triangles a part is tested.
    #[must_use]
    pub fn up_by_shape(&self, usual: Axis) -> Axis {
        let (other, z_is_usual) = match usual {
            Axis::PositiveY => (Axis::PositiveZ, false),
            Axis::PositiveZ => (Axis::PositiveY, true),
            _ => return usual,
        };
        let (triangles, bounds, rise) = self.sampled_triangles();
        match Body::new(&triangles, bounds) {
            Some(body) if body.stands_on_other(z_is_usual, &rise) => other,
            _ => usual,
        }
    }

    /// Triangles of the scene, the box around all of them, and the direction in which their textures are upright, in the
    /// coordinates of the file.
    fn sampled_triangles(&self) -> (Vec<Triangle>, [[f64; 3]; 2], Rise) {
        let surfaces = || {
            let drawn = self.instances.iter().map(|i| (i, &self.meshes[i.mesh.index()]));
            drawn.filter(|(_, mesh)| mesh.kind() == PrimitiveKind::Triangles)
        };
        let count: usize = surfaces().map(|(_, mesh)| mesh.triangles().len()).sum();
        let step = count.div_ceil(MOST).max(1);
        let mut triangles = Vec::with_capacity(count.div_ceil(step));
        let [mut min, mut max] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let mut rise = Rise::default();
        let mut number = 0;
        for (instance, mesh) in surfaces() {
            let uvs = mesh.uvs(0);
            for corners in mesh.triangles() {
                let triangle = corners.map(|v| {
                    let p = instance.transform.point(mesh.positions()[v as usize].map(f64::from));
                    let p: [f64; 3] = std::array::from_fn(|k| p[k] + self.origin[k]);
                    for k in 0..3 {
                        min[k] = if p[k] < min[k] { p[k] } else { min[k] };
                        max[k] = if p[k] > max[k] { p[k] } else { max[k] };
                    }
                    p
                });
                if number % step == 0 {
                    triangles.push(triangle);
                    if !uvs.is_empty() {
                        rise.add(&triangle, corners.map(|v| uvs[v as usize].map(f64::from)));
                    }
                }
                number += 1;
            }
        }
        (triangles, [min, max], rise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, Mesh, MeshData, Transform, primitives};

    /// A box, as its smallest and its largest corner.
    type Cuboid = [[f32; 3]; 2];

    /// Axes of models that are built +Y up: copies that follow the custom of OBJ and of STL, and copies that break it.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum File {
        YUp,
        ZUp,
    }

    /// Triangles of boxes that are built +Y up, as a file of these axes has them.
    fn boxes(boxes: &[Cuboid], file: File) -> Vec<[[f32; 3]; 3]> {
        let mut all = Vec::new();
        for [low, high] in boxes {
            let corner = |k: usize| std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] });
            for [a, b, c, d] in
                [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
            {
                all.extend([[a, b, c], [a, c, d]].map(|t| t.map(corner)));
            }
        }
        placed(&all, file)
    }

    /// Triangles that are built +Y up, as a file of these axes has them.
    fn placed(triangles: &[[[f32; 3]; 3]], file: File) -> Vec<[[f32; 3]; 3]> {
        let place = |[x, y, z]: [f32; 3]| if file == File::YUp { [x, y, z] } else { [x, -z, y] };
        triangles.iter().map(|t| t.map(place)).collect()
    }

    /// The scene of triangles, none of which shares a vertex.
    fn scene(triangles: &[[[f32; 3]; 3]]) -> Scene {
        let positions = triangles.iter().flatten().copied().collect();
        let triangles = (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mut scene = Scene::new();
        let mesh = Mesh::new(MeshData { positions, triangles, ..MeshData::default() }).unwrap();
        let mesh = scene.add_mesh(mesh).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        scene.add_instance(Instance { mesh, material, transform: Transform::IDENTITY, object: 0 }).unwrap();
        scene
    }

    /// Up axes found in a file of the usual axis +Y, and in one of +Z.
    fn found(triangles: &[[[f32; 3]; 3]]) -> [Axis; 2] {
        let scene = scene(triangles);
        [Axis::PositiveY, Axis::PositiveZ].map(|usual| scene.up_by_shape(usual))
    }

    const BY_CUSTOM: [Axis; 2] = [Axis::PositiveY, Axis::PositiveZ];
    const Y: [Axis; 2] = [Axis::PositiveY; 2];
    const Z: [Axis; 2] = [Axis::PositiveZ; 2];

    /// A top on four legs.
    const TABLE: [Cuboid; 5] = [
        [[-0.8, 0.68, -0.5], [0.8, 0.72, 0.5]],
        [[-0.75, 0.0, -0.45], [-0.69, 0.68, -0.39]],
        [[0.69, 0.0, -0.45], [0.75, 0.68, -0.39]],
        [[-0.75, 0.0, 0.39], [-0.69, 0.68, 0.45]],
        [[0.69, 0.0, 0.39], [0.75, 0.68, 0.45]],
    ];

    /// Two feet, longer in front, two legs, a trunk with a belly, arms and a head.
    const FIGURE: [Cuboid; 9] = [
        [[-0.2, 0.0, -0.1], [-0.06, 0.08, 0.2]],
        [[0.06, 0.0, -0.1], [0.2, 0.08, 0.2]],
        [[-0.19, 0.08, -0.08], [-0.07, 0.85, 0.08]],
        [[0.07, 0.08, -0.08], [0.19, 0.85, 0.08]],
        [[-0.24, 0.85, -0.12], [0.24, 1.45, 0.12]],
        [[-0.12, 0.95, 0.12], [0.12, 1.1, 0.16]],
        [[-0.34, 0.8, -0.06], [-0.24, 1.42, 0.06]],
        [[0.24, 0.8, -0.06], [0.34, 1.42, 0.06]],
        [[-0.1, 1.5, -0.1], [0.1, 1.75, 0.14]],
    ];

    /// Walls with a gable roof, and a porch in front.
    fn house() -> Vec<[[f32; 3]; 3]> {
        let mut all =
            boxes(&[[[-3.0, 0.0, -4.0], [3.0, 3.0, 4.0]], [[-1.0, 0.0, 4.0], [1.0, 2.2, 5.0]]], File::YUp);
        for x in [-3.4, 3.4] {
            let [a, b, c, d] = [[x, 2.8, -4.0], [x, 2.8, 4.0], [0.0, 5.5, 4.0], [0.0, 5.5, -4.0]];
            all.extend([[a, b, c], [a, c, d]]);
        }
        all
    }

    #[test]
    fn what_stands_on_the_floor_of_its_file_is_upright() {
        for (name, model) in
            [("table", boxes(&TABLE, File::YUp)), ("figure", boxes(&FIGURE, File::YUp)), ("house", house())]
        {
            assert_eq!(found(&model), Y, "{name}");
            assert_eq!(found(&placed(&model, File::ZUp)), Z, "{name}");
        }
    }

    /// Away from the plane through zero, balance alone tells, or nothing does.
    #[test]
    fn what_would_fall_over_is_stood_up() {
        // A lamp: a broad foot, and an arm that holds its shade far out in front.
        let lamp = |file| {
            let parts = [
                [[9.0, 9.0, 9.0], [11.0, 9.4, 11.0]],
                [[9.9, 9.4, 9.9], [10.1, 12.8, 10.1]],
                [[9.9, 12.7, 9.2], [10.1, 12.9, 11.6]],
                [[9.6, 12.4, 10.9], [10.4, 12.8, 11.7]],
            ];
            boxes(&parts, file)
        };
        assert_eq!(found(&lamp(File::YUp)), Y);
        assert_eq!(found(&lamp(File::ZUp)), Z);
        // A house rests on its back as well: no file is turned onto it.
        let away = |file| {
            let model = house().into_iter().map(|t| t.map(|[x, y, z]| [x, y + 10.0, z + 20.0]));
            placed(&model.collect::<Vec<_>>(), file)
        };
        assert_eq!([found(&away(File::YUp)), found(&away(File::ZUp))], [BY_CUSTOM, Z]);
    }

    /// A shape that rests equally in both poses stays as the custom of its format has it.
    #[test]
    fn ambiguous_shapes_keep_the_custom() {
        let sphere = {
            let mesh = primitives::sphere(2.0, 24).unwrap();
            let corner = |v: u32| mesh.positions()[v as usize];
            mesh.triangles().iter().map(|t| t.map(corner)).collect::<Vec<_>>()
        };
        let ambiguous = [
            ("sphere", sphere),
            ("cube", boxes(&[[[-1.0; 3], [1.0; 3]]], File::YUp)),
            ("cube on the floor", boxes(&[[[-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]]], File::YUp)),
            ("cube in a corner", boxes(&[[[0.0; 3], [1.0; 3]]], File::YUp)),
            (
                "cross",
                boxes(
                    &[[[-3.0, -1.0, -1.0], [3.0, 1.0, 1.0]], [[-1.0, -3.0, -1.0], [1.0, 3.0, 1.0]]],
                    File::YUp,
                ),
            ),
        ];
        for (name, model) in ambiguous {
            for file in [File::YUp, File::ZUp] {
                assert_eq!(found(&placed(&model, file)), BY_CUSTOM, "{name} {file:?}");
            }
        }
        // A plate with a rim, which may be a tray or hang on a wall, unless it lies on the floor.
        let tray = [[[-2.0, 0.0, -1.5], [2.0, 0.1, 1.5]], [[-2.0, 0.1, -1.5], [2.0, 0.3, -1.4]]];
        for file in [File::YUp, File::ZUp] {
            assert_eq!(found(&centred(&boxes(&tray, file))), BY_CUSTOM, "{file:?}");
            assert_eq!(found(&boxes(&tray, file)), if file == File::YUp { Y } else { Z }, "{file:?}");
        }
    }

    #[test]
    fn only_the_two_usual_axes_are_weighed() {
        let model = scene(&boxes(&TABLE, File::ZUp));
        for usual in [Axis::PositiveX, Axis::NegativeX, Axis::NegativeY, Axis::NegativeZ] {
            assert_eq!(model.up_by_shape(usual), usual);
        }
    }

    #[test]
    fn degenerate_shapes_keep_the_custom() {
        assert_eq!(Scene::new().up_by_shape(Axis::PositiveZ), Axis::PositiveZ);
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let standing = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let models = [
            vec![],
            vec![triangle],
            vec![standing],
            vec![[[1.0; 3]; 3]; 5],
            vec![[[0.0, 0.0, -1.0], [1.0, 1.0, 1.0], [2.0, 2.0, 3.0]]],
            boxes(&[[[-1.0, 0.0, -1.0], [1.0, 0.0, 1.0]]], File::YUp),
        ];
        for model in models {
            assert_eq!(found(&model), BY_CUSTOM, "{model:?}");
        }
        // Numbers that no mesh has.
        for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
            let triangles = [[[bad; 3], [0.0; 3], [1.0, 0.0, 2.0]]];
            for box_ in [[[0.0; 3], [bad; 3]], [[0.0; 3], [1.0; 3]]] {
                let body = Body::new(&triangles, box_);
                assert!(
                    !body.is_some_and(|body| body.stands_on_other(false, &Rise::default())),
                    "{bad} {box_:?}"
                );
            }
        }
    }

    /// Scale does not count, up to the largest numbers of a file.
    #[test]
    fn size_does_not_count() {
        for scale in [1e-30_f32, 1e-6, 1e6, 5e14] {
            for (file, expected) in [(File::YUp, Y), (File::ZUp, Z)] {
                let model = boxes(&FIGURE, file);
                let model: Vec<_> = model.iter().map(|t| t.map(|p| p.map(|v| v * scale))).collect();
                assert_eq!(found(&model), expected, "{scale} {file:?}");
            }
        }
    }

    #[test]
    fn the_order_of_triangles_does_not_count() {
        for (file, expected) in [(File::YUp, Y), (File::ZUp, Z)] {
            for model in [boxes(&TABLE, file), boxes(&FIGURE, file), placed(&house(), file)] {
                for (step, turn) in [(1, 1), (5, 2), (7, 0), (11, 1)] {
                    let count = model.len();
                    // Coprime to the count, or with a rest that is left out of none.
                    let mut order: Vec<usize> = (0..count).collect();
                    order.sort_by_key(|k| (k * step % 13, k % (step + 1), *k));
                    let mixed: Vec<_> = order
                        .iter()
                        .map(|&k| {
                            let mut triangle = model[k];
                            triangle.rotate_left(turn);
                            triangle
                        })
                        .collect();
                    assert_eq!(found(&mixed), expected, "{step} {turn} {file:?}");
                }
            }
        }
    }

    /// A body of revolution about +Y, as radii at heights.
    fn turned(profile: &[[f32; 2]]) -> Vec<[[f32; 3]; 3]> {
        // Directions of a circle in twelve parts.
        let (h, r) = (0.5, 0.75_f32.sqrt());
        let quarter = [[1.0, 0.0], [r, h], [h, r]];
        let around: Vec<[f32; 2]> = (0..4)
            .scan([[1.0, 0.0], [0.0, 1.0]], |[x, y], _| {
                let own = [*x, *y];
                [*x, *y] = [*y, x.map(|v| -v)];
                Some(quarter.map(|[u, v]| std::array::from_fn(|k| u * own[0][k] + v * own[1][k])))
            })
            .flatten()
            .collect();
        let point = |[radius, y]: [f32; 2], k: usize| {
            let [u, v]: [f32; 2] = around[k % around.len()];
            [radius * u, y, radius * v]
        };
        let mut all = Vec::new();
        for pair in profile.windows(2) {
            for k in 0..around.len() {
                let [a, b] = [k, k + 1].map(|k| point(pair[0], k));
                let [c, d] = [k, k + 1].map(|k| point(pair[1], k));
                all.extend([[a, c, d], [a, d, b]]);
            }
        }
        all
    }

    /// Moves a model that is built +Y up so that no floor of its file tells anything.
    fn centred(model: &[[[f32; 3]; 3]]) -> Vec<[[f32; 3]; 3]> {
        let corners = || model.iter().flatten();
        let middle: [f32; 3] = std::array::from_fn(|k| {
            let low = corners().fold(f32::INFINITY, |low, p| low.min(p[k]));
            0.5 * (low + corners().fold(f32::NEG_INFINITY, |high, p| high.max(p[k])))
        });
        model.iter().map(|t| t.map(|p| std::array::from_fn(|k| p[k] - middle[k]))).collect()
    }

    /// Tables, vases, cars and printed brackets stand without a floor in their file; what is alike either way stays.
    #[test]
    fn shapes_stand_or_stay_and_never_lie_down() {
        let vase = turned(&[[0.0, 0.0], [0.5, 0.0], [0.8, 0.7], [0.35, 1.5], [0.5, 1.8]]);
        let car = boxes(
            &[
                [[-0.9, 0.3, -2.2], [0.9, 0.8, 2.2]],
                [[-0.8, 0.8, -1.4], [0.8, 1.4, 0.8]],
                [[-0.9, 0.0, -1.7], [-0.7, 0.6, -1.1]],
                [[0.7, 0.0, -1.7], [0.9, 0.6, -1.1]],
                [[-0.9, 0.0, 1.1], [-0.7, 0.6, 1.7]],
                [[0.7, 0.0, 1.1], [0.9, 0.6, 1.7]],
            ],
            File::YUp,
        );
        let bracket =
            boxes(&[[[-2.0, 0.0, -1.5], [2.0, 0.4, 1.5]], [[-2.0, 0.4, -1.5], [2.0, 2.0, -1.1]]], File::YUp);
        let rod = boxes(&[[[-3.0, -0.2, -0.2], [3.0, 0.2, 0.2]]], File::YUp);
        let bodies = [
            ("table", boxes(&TABLE, File::YUp)),
            ("figure", boxes(&FIGURE, File::YUp)),
            ("vase", vase),
            ("car", car),
            ("bracket", bracket),
            ("rod", rod),
        ];
        for (name, model) in bodies {
            for (place, model) in [("on the floor", model.clone()), ("centred", centred(&model))] {
                let [of_y, _] = found(&model);
                let [_, of_z] = found(&placed(&model, File::ZUp));
                assert_eq!([of_y, of_z], BY_CUSTOM, "{name} {place}: what follows the custom is not turned");
                if place == "on the floor" && !["rod", "bracket"].contains(&name) {
                    assert_eq!(found(&model), Y, "{name}");
                    assert_eq!(found(&placed(&model, File::ZUp)), Z, "{name}");
                }
            }
        }
    }

    /// A vase in the middle of its file, whose textures run upwards around it.
    #[test]
    fn textures_tell_what_the_floor_does_not() {
        let profile = [[0.0, -1.0], [0.5, -1.0], [0.8, -0.2], [0.35, 0.7], [0.5, 1.0]];
        let model = turned(&profile);
        let textured = |file: File, is_upright: bool| {
            let positions = placed(&model, file).into_iter().flatten().collect::<Vec<_>>();
            let uvs = model
                .iter()
                .flat_map(|t| {
                    // Around the vase and down it, but for the seam.
                    t.map(
                        |[x, y, z]| if is_upright { [x + z, 0.5 - 0.5 * y] } else { [0.5 - 0.5 * y, x + z] },
                    )
                })
                .collect();
            let triangles = (0..model.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
            let mesh = MeshData { positions, triangles, uvs: [uvs, Vec::new()], ..MeshData::default() };
            let mut scene = Scene::new();
            let mesh = scene.add_mesh(Mesh::new(mesh).unwrap()).unwrap();
            let material = scene.add_material(Material::default()).unwrap();
            scene
                .add_instance(Instance { mesh, material, transform: Transform::IDENTITY, object: 0 })
                .unwrap();
            [Axis::PositiveY, Axis::PositiveZ].map(|usual| scene.up_by_shape(usual))
        };
        assert_eq!(textured(File::YUp, true), Y);
        assert_eq!(textured(File::ZUp, true), Z);
        // Without textures, or with ones that lie, it stays.
        assert_eq!(found(&model)[0], Axis::PositiveY);
        assert_eq!(textured(File::ZUp, false), BY_CUSTOM);
    }

    /// A wall and a ground with textures: sheets stay, for they may lie or stand.
    #[test]
    fn sheets_stay() {
        let at = |i: usize, j: usize| [i as f32, 0.3 * ((i * 7 + j * 5) % 4) as f32, j as f32];
        let cells = (0..64).map(|k| (k % 8, k / 8));
        let ground: Vec<_> = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        for file in [File::YUp, File::ZUp] {
            let model = centred(&placed(&ground, file));
            assert_eq!(found(&model), BY_CUSTOM, "{file:?}");
        }
    }

    /// More triangles than are tested.
    #[test]
    fn large_models_are_sampled() {
        // Each face of each box as a grid of small triangles.
        let fine = |file| {
            let coarse = boxes(&FIGURE, file);
            let mut all = Vec::new();
            for [a, b, c] in coarse {
                let at = |i: u32, j: u32| -> [f32; 3] {
                    let (u, v) = (i as f32 / 32.0, j as f32 / 32.0);
                    std::array::from_fn(|k| (1.0 - u - v) * a[k] + u * b[k] + v * c[k])
                };
                for i in 0..32 {
                    for j in 0..32 - i {
                        all.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                        if i + j < 31 {
                            all.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                        }
                    }
                }
            }
            all
        };
        let model = fine(File::YUp);
        assert!(model.len() > MOST);
        let (sampled, bounds, _) = scene(&model).sampled_triangles();
        assert!(sampled.len() <= MOST && sampled.len() * 2 >= MOST, "{}", sampled.len());
        let (_, coarse, _) = scene(&boxes(&FIGURE, File::YUp)).sampled_triangles();
        let pairs = bounds.iter().flatten().zip(coarse.iter().flatten());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6), "{bounds:?} {coarse:?}");
        assert_eq!([found(&model), found(&fine(File::ZUp))], [Y, Z]);
    }
}
