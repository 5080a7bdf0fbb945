//! Depth maps against geometry.

use super::{Blockers, DepthMaps};
use crate::jobs::Jobs;
use crate::math::lanes::{Float, Lanes, Scalar, SimdLevel};
use crate::scene::{Mesh, primitives};

fn blockers(mesh: &Mesh, lift: f32) -> Blockers {
    let positions = mesh.positions().iter().map(|p| [p[0], p[1] + lift, p[2]]).collect();
    Blockers { positions, triangles: mesh.triangles().to_vec() }
}

fn visibility(maps: &DepthMaps, map: usize, position: [f32; 3]) -> f32 {
    let position = position.map(|c| Scalar.splat(c));
    maps.visibility(Scalar, map, &position, Scalar.splat(2.0 * maps.texel())).to_array()[0]
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
                assert_eq!(depth.is_finite(), square < 0.998, "{size} {map} {x} {y}");
                if square < 0.9 {
                    assert!((depth - (1.0 - square).sqrt()).abs() < 0.02, "{depth} {square}");
                }
            }
        }
    }
}

#[test]
fn levels_and_threads_give_the_same_bits() {
    let knot = blockers(&primitives::torus_knot([2, 3], 1.0, 0.4, [200, 24]).unwrap(), 0.0);
    let directions = [[0.36, 0.48, 0.8], [-0.8, 0.0, 0.6], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let new = |threads, level| DepthMaps::new(&knot, &directions, 100, &Jobs::new(threads), level);
    let expected = new(1, SimdLevel::best());
    // The renderer has the definition only where there is nothing else.
    for level in SimdLevel::available().filter(|level| *level != SimdLevel::Scalar) {
        let found = new(3, level);
        for map in 0..found.len() {
            assert!(found.depths(map) == expected.depths(map), "{level}");
        }
    }
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
    ] {
        let triangles = if positions.is_empty() { vec![] } else { vec![[0, 1, 2]] };
        let maps = maps(&Blockers { positions: positions.clone(), triangles }, 32);
        for map in 0..maps.len() {
            assert!(maps.depths(map).iter().all(|depth| !depth.is_nan()), "{positions:?}");
            let seen = visibility(&maps, map, positions[0]);
            assert!((0.0..=1.0).contains(&seen), "{positions:?}: {seen}");
        }
    }
}
