//! G-buffer planes for users to see.

use crate::frame::Aov;
use crate::gbuffer::{Batch, Draw};
use crate::math::lanes::{Float, LANES, Lanes};
use crate::math::vec3::V3;
use crate::shade::{Reflectance, Surface};

/// The planes of one tile: sums over the opaque fragments of each pixel, weighted by coverage.
#[derive(Clone, Debug, Default)]
pub(super) struct TileAovs {
    wanted: Vec<Aov>,
    width: usize,
    planes: Vec<Vec<f32>>,
    /// Coverage summed so far, and the largest coverage of a single fragment with its depth, for identities.
    coverage: Vec<f32>,
    leader: Vec<(f32, f32)>,
}

impl TileAovs {
    /// Planes for a tile of `width` x `height` pixels.
    pub(super) fn new(wanted: &[Aov], width: usize, height: usize) -> Self {
        let pixels = if wanted.is_empty() { 0 } else { width * height };
        Self {
            wanted: wanted.to_vec(),
            width,
            planes: wanted.iter().map(|aov| vec![0.0; aov.channels() * pixels]).collect(),
            coverage: vec![0.0; pixels],
            leader: vec![(0.0, f32::NEG_INFINITY); pixels],
        }
    }

    pub(super) fn is_wanted(&self) -> bool {
        !self.wanted.is_empty()
    }

    /// Adds a batch of fragments. Blended fragments (index `opaque` and above) are not part of the G-buffer.
    #[inline(always)]
    pub(super) fn add<L: Lanes>(
        &mut self,
        batch: &Batch,
        surface: &Surface<L>,
        material: u32,
        draws: &[Draw<'_>],
        indices: &[u32],
        opaque: usize,
        samples: usize,
    ) {
        let arrays = |v: V3<L>| v.map(|c| c.to_array());
        let depth = surface.depth.to_array();
        let metallic = match surface.reflectance {
            Reflectance::Metallic { metallic, .. } => metallic.to_array(),
            Reflectance::Specular { .. } => [0.0; LANES],
        };
        let pixel_of = |k: usize| {
            let fragment = &batch.fragments[k];
            fragment.row() as usize * self.width + fragment.column() as usize
        };
        let weight_of = |k: usize| batch.fragments[k].mask.count_ones() as f32 / samples as f32;
        let members: Vec<usize> = (0..batch.len).filter(|&k| (indices[k] as usize) < opaque).collect();
        for (aov, plane) in self.wanted.iter().zip(&mut self.planes) {
            let values: Vec<[f32; LANES]> = match aov {
                Aov::Depth => vec![surface.distance.to_array()],
                Aov::Normal => arrays(surface.normal).to_vec(),
                Aov::CoatNormal => arrays(surface.coat_normal).to_vec(),
                Aov::BaseColor => arrays(surface.base_color).to_vec(),
                Aov::Roughness => vec![surface.roughness.to_array()],
                Aov::Metallic => vec![metallic],
                Aov::Coat => vec![surface.coat.to_array(), surface.coat_roughness.to_array()],
                Aov::Uv => surface.uv.map(|c| c.to_array()).to_vec(),
                Aov::Coverage => vec![[1.0; LANES]],
                Aov::MaterialId | Aov::ObjectId => continue,
            };
            for &k in &members {
                for (channel, value) in values.iter().enumerate() {
                    plane[pixel_of(k) * aov.channels() + channel] += value[k] * weight_of(k);
                }
            }
        }
        for &k in &members {
            let (pixel, weight) = (pixel_of(k), weight_of(k));
            self.coverage[pixel] += weight;
            let leader = &mut self.leader[pixel];
            // One after the other: a batch may hold several fragments of a pixel, and how they fall into batches
            // depends on the tile.
            if weight > leader.0 || (weight == leader.0 && depth[k] > leader.1) {
                *leader = (weight, depth[k]);
                for (aov, plane) in self.wanted.iter().zip(&mut self.planes) {
                    let id = match aov {
                        Aov::MaterialId => material,
                        Aov::ObjectId => draws[batch.vertices.draws[k] as usize].object,
                        _ => continue,
                    };
                    plane[pixel] = id as f32 + 1.0;
                }
            }
        }
    }

    /// Divides by coverage, makes normals unit length, and hands the planes over, in the order of the request.
    pub(super) fn finish(mut self) -> Vec<Vec<f32>> {
        for (aov, plane) in self.wanted.iter().zip(&mut self.planes) {
            if matches!(aov, Aov::Coverage | Aov::MaterialId | Aov::ObjectId) {
                continue;
            }
            for (values, &coverage) in plane.chunks_exact_mut(aov.channels()).zip(&self.coverage) {
                let divisor = match aov {
                    Aov::Normal | Aov::CoatNormal => {
                        (values[0] * values[0] + values[1] * values[1] + values[2] * values[2]).sqrt()
                    }
                    _ => coverage,
                };
                if divisor > 0.0 {
                    values.iter_mut().for_each(|v| *v /= divisor);
                }
            }
        }
        self.planes
    }
}
