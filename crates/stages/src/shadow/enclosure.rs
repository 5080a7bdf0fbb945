//! Enclosed spaces: rooms, caves and boxes, whose walls few directions of light reach.

use super::depth_map::{DepthMaps, MARGIN};

/// Surface points that are tested along a side of a map.
const SAMPLES: usize = 8;

/// Points that a map must have for it to count.
const FEWEST: u32 = 8;

/// Sines of the elevations from which a scene is looked at: rarely from below or from straight above.
const ELEVATIONS: std::ops::RangeInclusive<f64> = -0.35..=0.9;

/// Part of the sphere of directions of which a point of an enclosed space sees less.
const OPEN: f32 = 0.1;

/// Distance off its surface at which a point is tested, in texels towards the map that sees it.
const LIFT: f64 = 2.0;

impl DepthMaps {
    /// Share of what is seen of the scene that lies in enclosed spaces, from the direction of the maps from which that is most,
    /// +Y up: points that less than a tenth of the sphere of directions reaches. The maps stand for these solid angles. About a
    /// half for a box without a lid on its side, below a quarter for most objects; 0 without maps.
    #[must_use]
    pub fn enclosed_share(&self, solid_angles: &[f32]) -> f32 {
        let most = OPEN * solid_angles.iter().sum::<f32>();
        let share = |map: usize| {
            let (mut seen, mut enclosed) = (0_u32, 0_u32);
            for point in self.surface_points(map) {
                seen += 1;
                enclosed += u32::from(self.is_enclosed(&point, solid_angles, most));
            }
            if seen < FEWEST { 0.0 } else { enclosed as f32 / seen as f32 }
        };
        let sideways = (0..self.len()).filter(|map| ELEVATIONS.contains(&self.elevation(*map)));
        sideways.map(share).fold(0.0, |most, share| if share > most { share } else { most })
    }

    /// Sine of the elevation of a map's direction.
    fn elevation(&self, map: usize) -> f64 {
        let [x, y, z, _] = self.frame(map).rows[2].map(f64::from);
        y / ((x * x + y * y) + z * z).sqrt()
    }

    /// Points just outside of the surface that a map sees, on a grid of its texels.
    fn surface_points(&self, map: usize) -> impl Iterator<Item = [f32; 3]> + '_ {
        let rows = self.frame(map).rows.map(|row| row.map(f64::from));
        let squares = rows.map(|[x, y, z, _]| (x * x + y * y) + z * z);
        let lift = LIFT * squares[2].sqrt() * f64::from(self.texel());
        let texels = self.texels_of(map);
        let side = self.size() - 2 * MARGIN;
        (0..SAMPLES * SAMPLES).filter_map(move |number| {
            let at = |k: usize| MARGIN + (2 * k + 1) * side / (2 * SAMPLES);
            let (column, row) = (at(number % SAMPLES), at(number / SAMPLES));
            let depth = texels[row * self.size() + column] & 0xffff;
            if depth == 0 {
                return None;
            }
            // Rows are perpendicular to each other.
            let of_rows = [column as f64, row as f64, f64::from(depth) + 0.5 + lift];
            let parts: [f64; 3] = std::array::from_fn(|k| (of_rows[k] - rows[k][3]) / squares[k]);
            let place = |axis: usize| (0..3).map(|k| parts[k] * rows[k][axis]).sum::<f64>() as f32;
            Some([place(0), place(1), place(2)])
        })
    }

    /// True if directions of no more than a solid angle reach a point.
    fn is_enclosed(&self, point: &[f32; 3], solid_angles: &[f32], most: f32) -> bool {
        let mut open = 0.0;
        for (map, solid_angle) in solid_angles.iter().enumerate().take(self.len()) {
            let [column, row, depth] = self.frame(map).project_one(point);
            let last = (self.size() - 1) as f32;
            let inside = |v: f32| if v > 0.0 { if v < last { v } else { last } } else { 0.0 };
            let texel = (inside(row) + 0.5) as usize * self.size() + (inside(column) + 0.5) as usize;
            if ((self.texels_of(map)[texel] & 0xffff) as f32) <= depth {
                open += solid_angle;
                if open > most {
                    return false;
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::blockers::Blockers;
    use super::*;
    use overcoat_core::jobs::Jobs;
    use overcoat_core::math::double;
    use overcoat_core::math::lanes::SimdLevel;
    use overcoat_scene::primitives;

    const SIZE: usize = 96;

    /// Directions all over the sphere, none along an axis, each for as much of it: the golden spiral.
    fn directions() -> Vec<[f32; 3]> {
        let turn = |k: f64| double::sin_cos(2.399_963_23 * k);
        let direction = |k: u32| {
            let y = (f64::from(k) + 0.5) / 24.0 - 1.0;
            let ((sin, cos), radius) = (turn(f64::from(k)), (1.0 - y * y).sqrt());
            [(radius * cos) as f32, y as f32, (radius * sin) as f32]
        };
        (0..48).map(direction).collect()
    }

    fn share(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> f32 {
        let blockers = Blockers { positions, triangles, ..Blockers::default() };
        let directions = directions();
        let maps = DepthMaps::new(&blockers, &directions, SIZE, &Jobs::new(1), SimdLevel::best());
        maps.enclosed_share(&vec![1.0; directions.len()])
    }

    /// The sides of a cube but those whose normals point along these axes.
    fn walls(open: &[[f32; 3]]) -> f32 {
        let cube = primitives::cuboid([2.0; 3]).unwrap();
        let is_there = |corners: &&[u32; 3]| {
            let normal = cube.normals()[corners[0] as usize];
            !open.iter().any(|axis| (0..3).map(|k| axis[k] * normal[k]).sum::<f32>() > 0.5)
        };
        share(cube.positions().to_vec(), cube.triangles().iter().filter(is_there).copied().collect())
    }

    #[test]
    fn rooms_are_enclosed_and_solids_are_not() {
        assert_eq!(share(Vec::new(), Vec::new()), 0.0);
        let ball = primitives::sphere(1.0, 32).unwrap();
        assert_eq!(share(ball.positions().to_vec(), ball.triangles().to_vec()), 0.0);
        assert_eq!(walls(&[]), 0.0);
        // A room without a wall, one without another, and one that only has a floor and two walls.
        for open in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] {
            let found = walls(&[open]);
            assert!(found > 0.3, "{found}");
        }
        let corner = walls(&[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        assert!(corner < 0.1, "{corner}");
    }
}
