//! Tests of soft shadows against the shares of a cone that simple shapes cover.

use crate::shadow::{Blockers, DepthMaps, Pyramids};
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Float, Lanes, Scalar, SimdLevel};
use overcoat_scene::primitives;

const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// A plate of a side of 4 at a height, and a speck that the maps reach down to.
fn plate(height: f32) -> Blockers {
    let speck = super::blockers(&primitives::cuboid([1e-3; 3]).unwrap(), 0.0);
    super::joined(speck, &super::blockers(&primitives::plane([4.0, 4.0]).unwrap(), height))
}

fn visibility(maps: &DepthMaps, position: [f32; 3], spread: f32) -> f32 {
    let pyramids = Pyramids::new(maps, 0.0, &Jobs::new(2), SimdLevel::best());
    let position = position.map(|c| Scalar.splat(c));
    pyramids.soft_visibility(Scalar, 0, &position, spread, Scalar.splat(4.0)).to_array()[0]
}

#[test]
fn the_edge_of_a_shadow_is_as_wide_as_the_light() {
    for size in [64, 128, 256, 512] {
        let maps = super::of(&plate(1.0), &[UP], size);
        for spread in [0.1, 0.2, 0.4] {
            // Below the edge one half is open; a radius of the cone's disc aside, next to nothing or next to all. The
            // filter has the variance of the disc and is smoother.
            let radius = 1.15 * spread;
            // The plate's edge lies between two texels.
            let between = 0.25 * maps.texel() / radius;
            for (off, expected, tolerance) in
                [(0.0, 0.5, 0.08), (-1.0, 0.0, 0.12), (1.0, 1.0, 0.12), (-2.5, 0.0, 0.01), (2.5, 1.0, 0.01)]
            {
                let found = visibility(&maps, [2.0 + off * radius, 0.0, 0.1], spread);
                assert!((found - expected).abs() <= tolerance + between, "{size} {spread} {off}: {found}");
            }
            // Monotonic across.
            let across: Vec<f32> =
                (0..64).map(|k| visibility(&maps, [1.2 + k as f32 / 40.0, 0.0, 0.1], spread)).collect();
            assert!(across.windows(2).all(|pair| pair[0] <= pair[1] + 1e-3), "{size} {spread}: {across:?}");
        }
    }
}

/// The shadow of a thin bar is as smooth as the light is wide, wherever it lies between texels: no mottle.
#[test]
fn thin_occluders_leave_no_mottle() {
    for height in [1.0, 2.0] {
        let bar = super::blockers(&primitives::cuboid([8.0, 0.2, 0.2]).unwrap(), height);
        let maps = super::of(&super::joined(plate(0.0), &bar), &[UP], 128);
        let at = |k: i32| visibility(&maps, [2.5 + k as f32 / 97.0, 0.0, k as f32 / 40.0], 0.3);
        let across: Vec<f32> = (-40..=40).map(at).collect();
        let steps = across.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        assert!(steps < 0.04 / height, "{steps} {across:?}");
        assert!((0.35..0.9).contains(&across[40]) && across[0] > 0.9, "{across:?}");
    }
}

/// A plate at the floor's height is the floor, and places aside are open.
#[test]
fn a_plate_in_the_floor_throws_no_shadow() {
    let maps = super::of(&plate(1e-4), &[UP], 128);
    for x in [0.0, 1.9, 2.0, 2.1, 3.0, 100.0] {
        let found = visibility(&maps, [x, 0.0, 0.3], 0.3);
        assert!(found > 0.98, "{x}: {found}");
    }
    assert_eq!(visibility(&super::of(&plate(1.0), &[UP], 128), [40.0, 0.0, 0.0], 0.3), 1.0);
    assert_eq!(visibility(&DepthMaps::default(), [0.0; 3], 0.3), 1.0);
}
