//! The triangles that light cannot pass.

use crate::jobs::Jobs;

/// Triangles in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blockers {
    /// Corners, finite.
    pub positions: Vec<[f32; 3]>,
    /// Three positions each.
    pub triangles: Vec<[u32; 3]>,
}

/// Corners that are looked at by one thread.
const POSITIONS_PER_JOB: usize = 1 << 16;

impl Blockers {
    /// The middle of the box around all corners, and half the length of its diagonal; `None` if there are none.
    #[must_use]
    pub fn bounding_sphere(&self, jobs: &Jobs) -> Option<([f32; 3], f32)> {
        let parts = jobs.map(self.positions.len().div_ceil(POSITIONS_PER_JOB), |part| {
            let first = part * POSITIONS_PER_JOB;
            let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
            for position in self.positions[first..].iter().take(POSITIONS_PER_JOB) {
                extend(&mut bounds, position, position);
            }
            bounds
        });
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for [low, high] in &parts {
            extend(&mut bounds, low, high);
        }
        if self.positions.is_empty() {
            return None;
        }
        let [low, high] = bounds;
        let centre = std::array::from_fn(|k| low[k] * 0.5 + high[k] * 0.5);
        let mut square = 0.0;
        for k in 0..3 {
            let half = f64::from(high[k] - low[k]) * 0.5;
            square += half * half;
        }
        Some((centre, square.sqrt() as f32))
    }
}

/// Makes a box large enough for another.
fn extend(bounds: &mut [[f32; 3]; 2], low: &[f32; 3], high: &[f32; 3]) {
    for k in 0..3 {
        if low[k] < bounds[0][k] {
            bounds[0][k] = low[k];
        }
        if high[k] > bounds[1][k] {
            bounds[1][k] = high[k];
        }
    }
}
