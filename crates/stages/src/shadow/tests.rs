//! Depth maps against geometry.

use super::{Blockers, Cutout, DepthMaps, Masked};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_core::math::lanes::{Float, Lanes, Scalar, SimdLevel};
use overcoat_scene::{Mesh, Wrap, primitives};

mod of_scene;
mod pyramid;
mod tints;

fn blockers(mesh: &Mesh, lift: f32) -> Blockers {
    let positions = mesh.positions().iter().map(|p| [p[0], p[1] + lift, p[2]]).collect();
    Blockers { positions, triangles: mesh.triangles().to_vec(), ..Blockers::default() }
}

/// Both.
fn joined(mut a: Blockers, b: &Blockers) -> Blockers {
    let first = a.positions.len() as u32;
    a.positions.extend(&b.positions);
    a.triangles.extend(b.triangles.iter().map(|triangle| triangle.map(|v| v + first)));
    a
}

fn visibility(maps: &DepthMaps, map: usize, position: [f32; 3]) -> f32 {
    let position = position.map(|c| Scalar.splat(c));
    maps.visibility(Scalar, map, &position, Scalar.splat(2.0 * maps.texel())).to_array()[0]
}

/// Visibility of a point of a surface with a geometric normal.
fn on_surface(maps: &DepthMaps, map: usize, position: [f32; 3], normal: [f32; 3]) -> f32 {
    let [position, normal] = [position, normal].map(|v| v.map(|c| Scalar.splat(c)));
    let lifted = maps.lifted(Scalar, &position, &normal);
    maps.visibility(Scalar, map, &lifted, Scalar.zero()).to_array()[0]
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

/// Directions all over the sphere: points of a cube's grid.
fn directions(steps: i32) -> Vec<[f32; 3]> {
    let grid = || -steps..=steps;
    let all = grid().flat_map(|x| grid().flat_map(move |y| grid().map(move |z| [x, y, z])));
    // None looks exactly along an axis or a plane of the meshes.
    all.filter(|v| v.iter().any(|c| c.abs() == steps))
        .map(|v| unit([v[0] as f32 + 0.013, v[1] as f32 - 0.027, v[2] as f32 + 0.041]))
        .collect()
}

fn of(blockers: &Blockers, directions: &[[f32; 3]], size: usize) -> DepthMaps {
    DepthMaps::new(blockers, directions, size, &Jobs::new(2), SimdLevel::best())
}

const DIAGONAL: f32 = std::f32::consts::FRAC_1_SQRT_2;

fn maps(blockers: &Blockers, size: usize) -> DepthMaps {
    let directions = [[0.0, 1.0, 0.0], [DIAGONAL, DIAGONAL, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    DepthMaps::new(blockers, &directions, size, &Jobs::new(2), SimdLevel::best())
}

#[test]
fn a_roof_shades_what_is_below() {
    let roof = primitives::plane([2.0, 2.0]).unwrap();
    let maps = maps(&blockers(&roof, 1.0), 128);
    for x in [-0.9, -0.3, -0.1, 0.1, 0.5, 0.9] {
        assert_eq!(visibility(&maps, 0, [x, 0.0, 0.0]), 0.0, "{x}");
        // Light from 45 degrees reaches under it from the side.
        let expected = if x > 0.0 { 1.0 } else { 0.0 };
        assert_eq!(visibility(&maps, 1, [x, 0.0, 0.0]), expected, "{x}");
        // From below, and from the side on.
        assert_eq!(visibility(&maps, 2, [x, 0.0, 0.0]), 1.0);
        assert_eq!(visibility(&maps, 3, [x, 0.0, 0.0]), 1.0);
        // Its own upper side, and what is above.
        assert_eq!(visibility(&maps, 0, [x, 1.0, 0.0]), 1.0);
        assert_eq!(visibility(&maps, 0, [x, 2.0, 0.0]), 1.0);
    }
    // Far away, beside all maps.
    assert_eq!(visibility(&maps, 0, [50.0, -3.0, 0.0]), 1.0);
}

#[test]
fn a_mesh_has_no_holes() {
    let knot = primitives::sphere(1.0, 96).unwrap();
    for size in [16, 64, 200] {
        let maps = maps(&blockers(&knot, 0.0), size);
        for map in 0..maps.len() {
            let depths = maps.depths(map);
            for (index, depth) in depths.iter().enumerate() {
                let [x, y] = [index % size, index / size].map(|k| k as f32 + 0.5 - size as f32 * 0.5);
                let square = (x * x + y * y) * maps.texel() * maps.texel();
                // Of the ball and its faces, the border is in between.
                if !(0.996..=1.0).contains(&square) {
                    assert_eq!(depth.is_finite(), square < 0.998, "{size} {map} {x} {y}");
                }
                if square < 0.9 {
                    assert!((depth - (1.0 - square).sqrt()).abs() < 0.02, "{depth} {square}");
                }
            }
        }
    }
}

#[test]
fn threads_give_the_same_bits() {
    let knot = blockers(&primitives::torus_knot([2, 3], 1.0, 0.4, [200, 24]).unwrap(), 0.0);
    // Triangles of all sizes, and some with holes.
    let mut knot = joined(knot, &blockers(&primitives::plane([3.0, 2.0]).unwrap(), -1.0));
    knot.cutouts.push(checker(8));
    knot.masked = sheet(&mut knot.positions, 1.3, 4.0);
    let directions =
        [[0.36, 0.48, 0.8], [-0.8, 0.0, 0.6], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.6, 0.8]];
    for size in [16, 99, 100] {
        let new = |threads| DepthMaps::new(&knot, &directions, size, &Jobs::new(threads), SimdLevel::best());
        let (expected, found) = (new(1), new(3));
        for map in 0..expected.len() {
            assert!(found.depths(map) == expected.depths(map));
        }
        // A map is the same whatever is drawn with it.
        for (map, direction) in directions.iter().enumerate() {
            assert!(of(&knot, &[*direction], size).depths(0) == expected.depths(map));
        }
    }
}

/// Squares that are there and not, as many as `size` along a side.
fn checker(size: usize) -> Cutout {
    let alphas =
        (0..size * size).map(|k| if (k % size + k / size).is_multiple_of(2) { 255 } else { 0 }).collect();
    Cutout { size: [size; 2], alphas, wrap: [Wrap::Repeat; 2], cutoff: 0.5 }
}

/// A square of two triangles with holes, 2 along a side, at a height; its texture `turns` times along a side.
fn sheet(positions: &mut Vec<[f32; 3]>, height: f32, turns: f32) -> Vec<Masked> {
    let first = positions.len() as u32;
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]];
    positions.extend(corners.map(|[u, v]| [2.0 * u - 1.0, height, 2.0 * v - 1.0]));
    [[0, 1, 2], [0, 2, 3]]
        .map(|triangle| Masked {
            corners: triangle.map(|k: u32| first + k),
            uvs: triangle.map(|k| corners[k as usize].map(|c| c * turns)),
            alphas: [1.0; 3],
            two_sided: true,
            cutout: 0,
        })
        .to_vec()
}

#[test]
fn light_passes_through_holes() {
    let mut blockers = Blockers { cutouts: vec![checker(8)], ..Blockers::default() };
    blockers.masked = sheet(&mut blockers.positions, 1.0, 1.0);
    let maps = of(&blockers, &[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], 256);
    for row in 0..8 {
        for column in 0..8 {
            let middle = |k: usize| (k as f32 + 0.5) * 0.25 - 1.0;
            let expected = if (row + column) % 2 == 0 { 0.0 } else { 1.0 };
            let [x, z] = [middle(column), middle(row)];
            assert_eq!(visibility(&maps, 0, [x, 0.0, z]), expected, "{column} {row}");
            assert_eq!(visibility(&maps, 1, [x, 2.0, z]), expected, "{column} {row}");
        }
    }
    // What alpha is multiplied by counts; a list of cutouts that is too short blocks nothing.
    for alphas in [[0.4; 3], [1.0; 3]] {
        blockers.masked.iter_mut().for_each(|masked| masked.alphas = alphas);
        let maps = of(&blockers, &[[0.0, 1.0, 0.0]], 64);
        assert_eq!(maps.depths(0).iter().any(|depth| depth.is_finite()), alphas[0] == 1.0);
    }
    blockers.cutouts.clear();
    assert!(of(&blockers, &[[0.0, 1.0, 0.0]], 64).depths(0).iter().all(|depth| !depth.is_finite()));
}

#[test]
fn cutouts_wrap_as_samplers_do() {
    let cutout = |wrap| Cutout { size: [2, 1], alphas: vec![255, 0], wrap: [wrap; 2], cutoff: 1.0 };
    let is_present = |wrap, u| cutout(wrap).is_present([u, 0.5], 1.0);
    for (u, expected) in [(0.2, [true; 3]), (0.7, [false; 3]), (1.2, [true, false, false])] {
        let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
        assert_eq!(wraps.map(|wrap| is_present(wrap, u)), expected, "{u}");
    }
    for (u, expected) in
        [(-0.2, [false, true, true]), (-0.7, [true, false, true]), (2.2, [true, true, false])]
    {
        let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
        assert_eq!(wraps.map(|wrap| is_present(wrap, u)), expected, "{u}");
    }
    for u in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -3e38] {
        let _ = is_present(Wrap::Repeat, u) | is_present(Wrap::MirroredRepeat, u);
    }
}

/// A square of `cells` along a side whose inner corners are moved about, so that its triangles are of all shapes.
fn crumpled(cells: usize, amount: f32) -> Blockers {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    };
    let side = cells + 1;
    let mut out = Blockers::default();
    for index in 0..side * side {
        let [column, row] = [index % side, index / side];
        let inner = |k: usize| (1..cells).contains(&k);
        let moved = if inner(column) && inner(row) { amount } else { 0.0 };
        let at = |k: usize, by: f32| {
            let place = (k as f32 + by * moved) * 2.0 / cells as f32 - 1.0;
            if place.abs() < 1.0 { place } else { 0.9 }
        };
        let at = |k: usize, by: f32| {
            if k == 0 {
                -1.0
            } else if k == cells {
                1.0
            } else {
                at(k, by)
            }
        };
        out.positions.push([at(column, next()), 0.0, at(row, next())]);
        if column < cells && row < cells {
            let [a, b, c, d] = [index, index + 1, index + side, index + side + 1].map(|k| k as u32);
            out.triangles.extend(if next() > 0.0 { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] });
        }
    }
    out
}

#[test]
fn triangles_of_all_shapes_leave_no_holes() {
    let looks: Vec<_> = directions(1).into_iter().filter(|d| d[1].abs() > 0.2).collect();
    // The last is folded over itself, which covers no less.
    for (cells, amount) in [(1, 0.0), (3, 0.4), (20, 0.49), (60, 0.45), (30, 3.0)] {
        let square = crumpled(cells, amount);
        let found = of(&square, &looks, 128);
        let whole = of(&crumpled(1, 0.0), &looks, 128);
        for map in 0..found.len() {
            // Corners are where they were, so the frames are the same.
            for (a, b) in found.depths(map).iter().zip(whole.depths(map)) {
                assert!(a.is_finite() || !b.is_finite(), "{cells} {amount} {map}");
                assert!(!b.is_finite() || (a - b).abs() < 2e-3 * found.texel().max(0.05), "{a} {b}");
            }
        }
    }
}

#[test]
fn no_plane_shades_itself() {
    let plane = crumpled(7, 0.4);
    for (size, looks) in [(32, directions(2)), (128, directions(1))] {
        let maps = of(&plane, &looks, size);
        for (map, direction) in looks.iter().enumerate() {
            let side = if direction[1] > 0.0 { 1.0 } else { -1.0 };
            let margin = 4.0 * maps.texel() / direction[1].abs();
            for k in 0..100 {
                let at = |m: usize| (k * m % 199) as f32 / 99.5 - 1.0;
                let point = [at(7), 0.0, at(31)];
                let lit = on_surface(&maps, map, point, [0.0, side, 0.0]);
                assert_eq!(lit, 1.0, "{size} {direction:?} {point:?}");
                // Its other side is dark, but for what is as close to its border as the texels are large there.
                let inside = [point[0], point[2]].iter().all(|c| c.abs() < 1.0 - margin);
                if inside {
                    let dark = on_surface(&maps, map, point, [0.0, -side, 0.0]);
                    assert!(dark < 0.1, "{direction:?} {dark}");
                }
            }
        }
    }
}

#[test]
fn a_ball_of_few_faces_is_lit_where_it_faces_the_light() {
    let ball = blockers(&primitives::sphere(1.0, 10).unwrap(), 0.0);
    let looks = directions(2);
    for size in [64, 256] {
        let maps = of(&ball, &looks, size);
        for triangle in &ball.triangles {
            let [a, b, c] = triangle.map(|v| ball.positions[v as usize]);
            let edge = |p: [f32; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
            let (ab, ac) = (edge(b), edge(c));
            let normal = unit([
                ab[1] * ac[2] - ab[2] * ac[1],
                ab[2] * ac[0] - ab[0] * ac[2],
                ab[0] * ac[1] - ab[1] * ac[0],
            ]);
            for (map, direction) in looks.iter().enumerate() {
                for [s, t] in [[0.01, 0.01], [0.33, 0.33], [0.98, 0.01], [0.01, 0.98], [0.5, 0.49]] {
                    let point = std::array::from_fn(|k| a[k] + s * ab[k] + t * ac[k]);
                    let cosine = dot(normal, *direction);
                    let lit = on_surface(&maps, map, point, normal);
                    if cosine > 0.0 {
                        assert_eq!(lit, 1.0, "{size} {direction:?} {point:?}");
                    } else if cosine < -0.8 {
                        assert_eq!(lit, 0.0, "{size} {direction:?} {point:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn shadows_begin_where_things_stand_and_end_where_they_should() {
    // A box of 1 x 1 x 1 on a floor, under light along X.
    let floor = blockers(&primitives::plane([8.0, 8.0]).unwrap(), 0.0);
    let scene = joined(floor, &blockers(&primitives::cuboid([1.0; 3]).unwrap(), 0.5));
    for (slope, size) in [(1.0, 128), (1.0, 512), (0.5, 256), (0.2, 512), (3.0, 256)] {
        let direction = unit([-1.0, slope, 0.0]);
        let maps = of(&scene, &[direction], size);
        let length = 1.0 / slope;
        let texel = maps.texel();
        // On the floor, behind the box: from 1.5 texels off it, nearly as far as it throws its shadow; then light again.
        let lit = |x: f32, z: f32| on_surface(&maps, 0, [x, 0.0, z], [0.0, 1.0, 0.0]);
        let (start, end) = (0.5 + 1.5 * texel, 0.5 + length);
        // The diagonal of a texel on the floor; and what is lifted comes out of the shadow earlier.
        let soft = texel * (1.42 / direction[1] + LIFT_SHIFT / slope);
        for k in 0..50 {
            let share = k as f32 / 49.0;
            let z = (k as f32 / 49.0 - 0.5) * (1.0 - 3.0 * texel);
            let dark = start + share * (end - soft - start);
            assert_eq!(lit(dark, z), 0.0, "{slope} {size} {dark} {z}");
            let bright = end + soft + share * 0.2;
            if bright < 3.9 {
                assert_eq!(lit(bright, z), 1.0, "{slope} {size} {bright} {z}");
            }
            // Beside it.
            assert_eq!(lit(start + share * length, 0.5 + 1.5 * texel), 1.0);
            assert_eq!(lit(-0.5 - 1.5 * texel, z), 1.0);
        }
    }
}

/// Distance off surfaces at which points are looked up, in texels.
const LIFT_SHIFT: f32 = 1.0;

#[test]
fn a_ball_over_a_floor_shades_a_disc() {
    let floor = blockers(&primitives::plane([6.0, 6.0]).unwrap(), 0.0);
    let scene = joined(floor, &blockers(&primitives::sphere(0.5, 96).unwrap(), 0.5));
    let maps = of(&scene, &[[0.0, 1.0, 0.0]], 256);
    let texel = maps.texel();
    let mut mean = 0.0;
    let steps = 100;
    for k in 0..steps * steps {
        let at = |k: usize| ((k as f32 + 0.5) / steps as f32 - 0.5) * 2.0;
        let [x, z] = [at(k % steps), at(k / steps)];
        let distance = (x * x + z * z).sqrt();
        let lit = on_surface(&maps, 0, [x, 0.0, z], [0.0, 1.0, 0.0]);
        if (distance - 0.5).abs() > 1.5 * texel {
            assert_eq!(lit, if distance < 0.5 { 0.0 } else { 1.0 }, "{x} {z}");
        }
        mean += (1.0 - lit) * 4.0 / (steps * steps) as f32;
    }
    let disc = std::f32::consts::PI * 0.25;
    assert!((mean / disc - 1.0).abs() < 0.02, "{mean} {disc}");
}

/// Points inside of a hollow box of a side of 2, each with the normal of its wall.
fn inside_of_a_box() -> Vec<([f32; 3], [f32; 3])> {
    let mut out = Vec::new();
    for wall in 0..6 {
        let (axis, sign) = (wall % 3, if wall < 3 { 1.0 } else { -1.0 });
        for k in 0..11 * 11 {
            let at = |k: usize| k as f32 / 5.0 - 1.0;
            let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
            point[axis] = sign;
            point[(axis + 1) % 3] = at(k % 11) * 0.998;
            point[(axis + 2) % 3] = at(k / 11) * 0.998;
            normal[axis] = -sign;
            out.push((point, normal));
        }
    }
    out
}

#[test]
fn a_closed_box_is_dark_inside() {
    let looks = directions(1);
    let inner = blockers(&primitives::cuboid([2.0; 3]).unwrap(), 0.0);
    // Walls as thick as a texel and a half: dark everywhere.
    let size = 128;
    let thick = joined(inner.clone(), &blockers(&primitives::cuboid([2.0 + 0.09; 3]).unwrap(), 0.0));
    let maps = of(&thick, &looks, size);
    assert!(1.5 * maps.texel() < 0.045, "{}", maps.texel());
    for (point, normal) in inside_of_a_box() {
        for map in 0..maps.len() {
            assert_eq!(on_surface(&maps, map, point, normal), 0.0, "{point:?} {:?}", looks[map]);
        }
    }
    // Walls without thickness: dark but for a texel along the edges, where up to half of the light comes in.
    let looks = directions(2);
    let maps = of(&inner, &looks, size);
    let (mut worst, mut sum) = (0.0, 0.0);
    let points = inside_of_a_box();
    let count = points.len() as f32;
    for (point, normal) in points {
        let (mut light, mut all) = (0.0, 0.0);
        for (map, direction) in looks.iter().enumerate() {
            let cosine = dot(normal, *direction);
            if cosine <= 0.0 {
                continue;
            }
            let lit = on_surface(&maps, map, point, normal);
            let edge =
                (0..3).filter(|k| point[*k].abs() < 1.0).all(|k| point[k].abs() < 1.0 - 1.5 * maps.texel());
            assert!(!edge || lit * cosine < 0.005, "{point:?} {direction:?} {lit}");
            light += lit * cosine;
            all += cosine;
        }
        sum += light / all;
        if light / all > worst {
            worst = light / all;
        }
    }
    // A third of the points lie within a texel of an edge.
    assert!(worst < 0.6 && sum / count < 0.1, "{worst} {}", sum / count);
}

#[test]
fn hostile_geometry_makes_maps_of_numbers() {
    for positions in [
        vec![],
        vec![[0.0; 3]; 3],
        vec![[1e9, 1e9, 1e9], [1e9, -1e9, 0.0], [-1e9, 0.0, 1e9]],
        vec![[3e38, 0.0, 0.0], [-3e38, 0.0, 0.0], [0.0, 3e38, 0.0]],
        vec![[1e-40, 0.0, 0.0], [0.0, 1e-40, 0.0], [0.0, 0.0, 1e-40]],
        vec![[1e6, 1e6, 1e6], [1e6, 1e6, 1e6], [1e6, 1e6, 1e6]],
        vec![[1e15, 1e15, 1e15], [-1e15, 1e15, 1e15], [1e15, -1e15, 1e15]],
        vec![[f32::NAN, 0.0, 0.0], [1.0, f32::INFINITY, 0.0], [0.0, 0.0, f32::NEG_INFINITY]],
        vec![[f32::NAN, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 0.0, f32::NEG_INFINITY]],
    ] {
        let triangles = if positions.is_empty() { vec![] } else { vec![[0, 1, 2], [0, 1, 7], [1, 0, 0]] };
        let masked = triangles.iter().map(|corners| Masked {
            corners: *corners,
            two_sided: false,
            uvs: [[f32::NAN, 1e30], [0.0; 2], [-1e30, 1.0]],
            alphas: [1.0, f32::NAN, 1e30],
            cutout: 0,
        });
        let masked = masked.collect();
        let cutouts = vec![checker(2)];
        let one_sided = triangles.clone();
        let (positions, repeated) = (positions.clone(), Vec::new());
        let blockers = Blockers { positions, triangles, one_sided, masked, cutouts, repeated };
        let maps = maps(&blockers, 32);
        let positions = blockers.positions;
        for map in 0..maps.len() {
            assert!(maps.depths(map).iter().all(|depth| !depth.is_nan()), "{positions:?}");
            let seen = visibility(&maps, map, positions[0]);
            assert!((0.0..=1.0).contains(&seen), "{positions:?}: {seen}");
        }
    }
}

#[test]
fn scenes_of_any_size_have_the_same_shadows() {
    let roof = primitives::plane([2.0, 2.0]).unwrap();
    for scale in [1e-9, 1.0, 1e9_f32] {
        let mut scene = joined(blockers(&roof, 1.0), &blockers(&roof, -1.0));
        scene.positions.iter_mut().flatten().for_each(|c| *c *= scale);
        let maps = of(&scene, &[[0.0, 1.0, 0.0]], 128);
        for (point, expected) in [([0.3, -1.0, 0.4], 0.0), ([0.3, 1.0, 0.4], 1.0)] {
            let lit = on_surface(&maps, 0, point.map(|c: f32| c * scale), [0.0, 1.0, 0.0]);
            assert_eq!(lit, expected, "{scale}");
        }
    }
}

#[test]
fn maps_stay_within_limits() {
    let knot = blockers(&primitives::torus_knot([2, 3], 1.0, 0.4, [100, 12]).unwrap(), 0.0);
    let looks = directions(1);
    let within = |limits: &Limits, threads| {
        DepthMaps::within(limits, &knot, &looks, 64, &Jobs::new(threads), SimdLevel::best())
    };
    let expected = of(&knot, &looks, 64);
    let found = within(&Limits::default(), 2).unwrap();
    assert!((0..looks.len()).all(|map| found.depths(map) == expected.depths(map)));
    for threads in [1, 3] {
        let few_bytes =
            within(&Limits::default().with_frame_bytes(64 * 64 * 4 * looks.len() as u64), threads);
        assert_eq!(few_bytes.unwrap_err().field, "frame_bytes");
        let little_work = within(&Limits::default().with_blocks(1000), threads);
        assert_eq!(little_work.unwrap_err().field, "blocks");
    }
}
