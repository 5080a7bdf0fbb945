//! G-buffer planes for users to see.

use overcoat_core::frame::Aov;
use overcoat_core::math::lanes::LANES;
use overcoat_stages::gbuffer::layout::{self, SurfacePlanes};
use overcoat_stages::gbuffer::{Batch, Draw};

/// The rows of the G-buffer that a quantity shows; `None` where it is not of the surface. Depth maps know some better.
fn rows(aov: Aov, has_maps: bool) -> Option<std::ops::Range<usize>> {
    let first = match aov {
        Aov::Depth => layout::DISTANCE,
        Aov::Position => layout::POSITION,
        Aov::Normal => layout::NORMAL,
        Aov::CoatNormal => layout::COAT_NORMAL,
        Aov::Tangent => layout::TANGENT,
        Aov::BaseColor => layout::BASE_COLOR,
        Aov::Roughness => layout::ROUGHNESS,
        Aov::Metallic => layout::METALLIC,
        Aov::SpecularColor => layout::SPECULAR_COLOR,
        Aov::Occlusion => layout::OCCLUSION,
        Aov::Emissive => layout::EMISSIVE,
        // These show neighbouring planes.
        Aov::Coat => layout::COAT,
        Aov::Iridescence => layout::IRIDESCENCE,
        Aov::SecondLobe => layout::SECOND_ROUGHNESS,
        Aov::Subsurface => layout::SUBSURFACE,
        Aov::CoatThickness => layout::COAT_THICKNESS,
        Aov::CoatColor => layout::COAT_COLOR,
        Aov::SheenColor => layout::SHEEN_COLOR,
        Aov::SheenRoughness => layout::SHEEN_ROUGHNESS,
        Aov::Anisotropy => layout::ANISOTROPY,
        Aov::SpecularOcclusion => layout::SPECULAR_OCCLUSION,
        Aov::BentNormal if has_maps => layout::COMPUTED_BENT_NORMAL,
        Aov::BentNormal => layout::BENT_NORMAL,
        Aov::Visibility if has_maps => layout::DIFFUSE_SEEN,
        Aov::Shadow if has_maps => layout::LIT_SHARE,
        Aov::Uv => layout::UV,
        Aov::MaterialId | Aov::ObjectId | Aov::Coverage | Aov::Visibility | Aov::Shadow | Aov::Ground => {
            return None;
        }
    };
    Some(first.first..first.first + aov.channels())
}

/// The planes of one tile: sums over the opaque fragments of each pixel, weighted by coverage.
#[derive(Clone, Debug, Default)]
pub struct TileAovs {
    wanted: Vec<Aov>,
    /// Depth maps tell what light reaches surfaces, but unlit ones.
    has_maps: bool,
    width: usize,
    planes: Vec<Vec<f32>>,
    /// Coverage summed so far, and the largest coverage of a single fragment with its depth, for identities.
    coverage: Vec<f32>,
    leader: Vec<(f32, f32)>,
    splats: Vec<PixelSplats>,
}

/// Change of a pixel by splats.
#[derive(Clone, Copy, Debug)]
struct PixelSplats {
    pixel: usize,
    /// The part of the pixel that they cover.
    coverage: f32,
    /// Distance and object of the splat behind which less than half of the light passes.
    front: Option<(f32, u32)>,
}

/// Sixteen fragments of one material, as they were shaded.
pub struct AovBatch<'a> {
    /// Sixteen fragments.
    pub batch: &'a Batch,
    /// Surfaces of the fragments.
    pub planes: &'a SurfacePlanes,
    /// Index of their material.
    pub material: u32,
    /// Material that emits and reflects nothing.
    pub unlit: bool,
    /// Draws of the frame.
    pub draws: &'a [Draw<'a>],
    /// The places of the fragments in the list of the tile.
    pub indices: &'a [u32],
    /// Number of opaque fragments: the first in that list.
    pub opaque: usize,
    /// Samples of a pixel.
    pub samples: usize,
}

impl TileAovs {
    /// Planes for a tile of `width` x `height` pixels.
    pub fn new(wanted: &[Aov], width: usize, height: usize, has_maps: bool) -> Self {
        let pixels = if wanted.is_empty() { 0 } else { width * height };
        Self {
            wanted: wanted.to_vec(),
            has_maps,
            width,
            planes: wanted.iter().map(|aov| vec![0.0; aov.channels() * pixels]).collect(),
            coverage: vec![0.0; pixels],
            leader: vec![(0.0, f32::NEG_INFINITY); pixels],
            splats: Vec::new(),
        }
    }

    /// True if any plane was asked for.
    pub fn is_wanted(&self) -> bool {
        !self.wanted.is_empty()
    }

    /// True if some plane is one of the material's lobes.
    pub fn wants_lobes(&self) -> bool {
        self.wanted.iter().any(|&aov| rows(aov, false).is_some_and(|rows| rows.end > layout::LOBES.start))
    }

    /// Adds a batch of fragments. Blended ones are not part of the G-buffer.
    pub fn add(&mut self, added: &AovBatch<'_>) {
        let &AovBatch { batch, planes: surface, material, unlit, draws, indices, opaque, samples } = added;
        // Effects fill nothing for unlit surfaces.
        let has_maps = self.has_maps && !unlit;
        let depth = &surface.rows[layout::DEPTH.first];
        let pixel_of = |k: usize| {
            let fragment = &batch.fragments[k];
            fragment.row() as usize * self.width + fragment.column() as usize
        };
        let weight_of = |k: usize| batch.fragments[k].mask.count_ones() as f32 / samples as f32;
        let members: Vec<usize> = (0..batch.len).filter(|&k| (indices[k] as usize) < opaque).collect();
        for (aov, plane) in self.wanted.iter().zip(&mut self.planes) {
            let whole = [[1.0; LANES]; 3];
            let values: &[[f32; LANES]] = match rows(*aov, has_maps) {
                Some(rows) => &surface.rows[rows],
                None if matches!(aov, Aov::Coverage | Aov::Visibility | Aov::Shadow) => {
                    &whole[..aov.channels()]
                }
                None => continue,
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
                        Aov::ObjectId => draws[batch.vertices.draw(k) as usize].object,
                        _ => continue,
                    };
                    plane[pixel] = id as f32 + 1.0;
                }
            }
        }
    }

    /// Adds the splats before a pixel: the part of it that they cover, and distance and object of the splat behind
    /// which less than half of the light passes.
    pub fn add_splats(&mut self, pixel: usize, coverage: f32, front: Option<(f32, u32)>) {
        if self.is_wanted() {
            self.splats.push(PixelSplats { pixel, coverage, front });
        }
    }

    /// True if the plane of the floor is wanted.
    pub fn wants_ground(&self) -> bool {
        self.wanted.contains(&Aov::Ground)
    }

    /// Sets the opacity of the floor in a pixel.
    pub fn set_ground(&mut self, pixel: usize, opacity: f32) {
        for (_, plane) in self.wanted.iter().zip(&mut self.planes).filter(|(aov, _)| **aov == Aov::Ground) {
            plane[pixel] = opacity;
        }
    }

    /// Divides by coverage, makes normals unit length, and hands the planes over, in the order of the request.
    pub fn finish(mut self) -> Vec<Vec<f32>> {
        for (aov, plane) in self.wanted.iter().zip(&mut self.planes) {
            if matches!(aov, Aov::Coverage | Aov::MaterialId | Aov::ObjectId | Aov::Ground) {
                continue;
            }
            for (values, &coverage) in plane.chunks_exact_mut(aov.channels()).zip(&self.coverage) {
                let divisor = match aov {
                    Aov::Normal | Aov::CoatNormal | Aov::BentNormal | Aov::Tangent => {
                        (values[0] * values[0] + values[1] * values[1] + values[2] * values[2]).sqrt()
                    }
                    _ => coverage,
                };
                if divisor > 0.0 {
                    values.iter_mut().for_each(|v| *v /= divisor);
                }
            }
        }
        for (aov, plane) in self.wanted.iter().zip(&mut self.planes) {
            for &PixelSplats { pixel, coverage, front } in &self.splats {
                match (aov, front) {
                    (Aov::Coverage, _) => plane[pixel] = 1.0 - (1.0 - plane[pixel]) * (1.0 - coverage),
                    (Aov::Depth, Some((distance, _))) => plane[pixel] = distance,
                    (Aov::ObjectId, Some((_, object))) => plane[pixel] = object as f32 + 1.0,
                    // A splat is not made of a material.
                    (Aov::MaterialId, Some(_)) => plane[pixel] = 0.0,
                    _ => {}
                }
            }
        }
        self.planes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantities of several numbers are neighbouring planes of the layout, in the order of the documentation.
    #[test]
    fn quantities_are_whole_planes() {
        for &aov in Aov::ALL {
            let Some(rows) = rows(aov, false) else { continue };
            let planes: Vec<_> = layout::PLANES
                .iter()
                .filter(|p| rows.contains(&p.first))
                .map(|p| (p.name, p.channels))
                .collect();
            assert_eq!(planes.iter().map(|p| p.1).sum::<usize>(), aov.channels(), "{}", aov.name());
            let expected: &[&str] = match aov {
                Aov::Coat => &["coat", "coat-roughness"],
                Aov::Iridescence => &["iridescence", "iridescence-thickness"],
                Aov::SecondLobe => &["second-roughness", "lobe-mix", "haziness"],
                Aov::Subsurface => &["subsurface", "subsurface-thickness"],
                _ => &[aov.name()],
            };
            assert_eq!(planes.iter().map(|p| p.0).collect::<Vec<_>>(), expected);
        }
    }

    /// With maps there are others: as many planes of other names.
    #[test]
    fn maps_know_better() {
        for &aov in Aov::ALL {
            let (without, with) = (rows(aov, false), rows(aov, true));
            match aov {
                Aov::Visibility => assert_eq!((without, with.map(|rows| rows.len())), (None, Some(3))),
                Aov::Shadow => assert_eq!((without, with.map(|rows| rows.len())), (None, Some(1))),
                Aov::BentNormal => assert!(without != with && with.map(|rows| rows.len()) == Some(3)),
                _ => assert_eq!(without, with),
            }
        }
    }
}
