//! G-buffer planes for users to see.

use super::center_place::CenterRay;
use overcoat_core::frame::{Aov, AovPlane};
use overcoat_scene::PrimitiveKind;
use overcoat_stages::gbuffer::layout::{self, SurfacePlanes};
use overcoat_stages::gbuffer::{Batch, Draw};
use overcoat_stages::raster::TileOrigin;
use overcoat_stages::shade::ViewRays;

/// The rows of the G-buffer that a quantity shows; `None` where it is not of the surface. Depth maps know some better.
fn rows(aov: Aov, has_maps: bool) -> Option<std::ops::Range<usize>> {
    let first = match aov {
        Aov::Depth => layout::DISTANCE,
        Aov::Position => layout::POSITION,
        Aov::Normal | Aov::CameraNormal => layout::NORMAL,
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
        Aov::MaterialId | Aov::ObjectId | Aov::InstanceId => return None,
        Aov::Coverage | Aov::Visibility | Aov::Shadow | Aov::Ground => return None,
    };
    Some(first.first..first.first + aov.channels())
}

/// The planes of one tile. Geometry and identities are those of one opaque fragment of each pixel, its leader, which is the nearest;
/// other quantities are sums over the opaque fragments, weighted by coverage.
#[derive(Clone, Debug, Default)]
pub struct TileAovs {
    /// Depth maps tell what light reaches surfaces, but unlit ones.
    has_maps: bool,
    /// Depth or position is among the planes.
    wants_places: bool,
    width: usize,
    planes: Vec<AovPlane>,
    /// Coverage summed so far.
    coverage: Vec<f32>,
    /// Depth of the leader so far.
    leader: Vec<f32>,
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
    /// Rays of the view.
    pub rays: &'a ViewRays,
    /// Corner of the tile.
    pub origin: TileOrigin,
}

/// True of draws whose fragments lie on triangles of their mesh.
fn is_flat(draw: &Draw<'_>) -> bool {
    draw.edges.is_none() && draw.mesh.kind() == PrimitiveKind::Triangles
}

impl TileAovs {
    /// Planes for a tile of `width` x `height` pixels.
    pub fn new(wanted: &[Aov], width: usize, height: usize, has_maps: bool) -> Self {
        let pixels = if wanted.is_empty() { 0 } else { width * height };
        Self {
            has_maps,
            wants_places: wanted.iter().any(|aov| matches!(aov, Aov::Depth | Aov::Position)),
            width,
            planes: wanted.iter().map(|&aov| AovPlane::empty(aov, pixels)).collect(),
            coverage: vec![0.0; pixels],
            leader: vec![f32::NEG_INFINITY; pixels],
            splats: Vec::new(),
        }
    }

    /// True if any plane was asked for.
    pub fn is_wanted(&self) -> bool {
        !self.planes.is_empty()
    }

    /// True if some plane is one of the material's lobes.
    pub fn wants_lobes(&self) -> bool {
        let is_lobe = |aov: Aov| rows(aov, false).is_some_and(|rows| rows.end > layout::LOBES.start);
        self.planes.iter().any(|plane| is_lobe(plane.aov))
    }

    /// Adds a batch of fragments. Blended ones are not part of the G-buffer.
    pub fn add(&mut self, added: &AovBatch<'_>) {
        let &AovBatch {
            batch,
            planes: surface,
            material,
            unlit,
            draws,
            indices,
            opaque,
            samples,
            rays,
            origin,
        } = added;
        // Effects fill nothing for unlit surfaces.
        let has_maps = self.has_maps && !unlit;
        let depth = &surface.rows[layout::DEPTH.first];
        // One after the other: a batch may hold several fragments of a pixel, and how they fall into batches depends on the
        // tile.
        for k in (0..batch.len).filter(|&k| (indices[k] as usize) < opaque) {
            let fragment = &batch.fragments[k];
            let pixel = fragment.row() as usize * self.width + fragment.column() as usize;
            let weight = fragment.mask.count_ones() as f32 / samples as f32;
            self.coverage[pixel] += weight;
            let draw = &draws[batch.vertices.draw(k) as usize];
            // The first in the list stays among equal depths.
            let leads = depth[k] > self.leader[pixel];
            let mut place = None;
            if leads {
                self.leader[pixel] = depth[k];
                // The only sample of a pixel is its centre.
                if samples == 1 && self.wants_places && is_flat(draw) {
                    let ray = CenterRay::new(rays, origin, [fragment.column(), fragment.row()]);
                    place = ray.meet(rays, draw, batch.vertices.corners(k));
                }
            }
            for plane in &mut self.planes {
                let aov = plane.aov;
                if aov.is_identity() {
                    if leads {
                        let number = match aov {
                            Aov::MaterialId => material,
                            Aov::ObjectId => draw.object,
                            _ => draw.instance,
                        };
                        // Scenes have no number that is the last one.
                        plane.ids[pixel] = number.saturating_add(1);
                    }
                    continue;
                }
                let out = &mut plane.data[pixel * aov.channels()..][..aov.channels()];
                match rows(aov, has_maps) {
                    Some(_) if aov.is_of_one_surface() && !leads => {}
                    Some(rows) if aov.is_of_one_surface() => {
                        out.iter_mut().zip(&surface.rows[rows]).for_each(|(v, row)| *v = row[k]);
                        match (aov, place) {
                            (Aov::CameraNormal, _) => rays.to_camera(out),
                            (Aov::Depth, Some((distance, _))) => out.fill(distance),
                            (Aov::Position, Some((_, position))) => out.copy_from_slice(&position),
                            _ => {}
                        }
                    }
                    Some(rows) => {
                        out.iter_mut().zip(&surface.rows[rows]).for_each(|(v, row)| *v += row[k] * weight);
                    }
                    None if aov != Aov::Ground => out.iter_mut().for_each(|v| *v += weight),
                    None => {}
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
        self.planes.iter().any(|plane| plane.aov == Aov::Ground)
    }

    /// Sets the opacity of the floor in a pixel.
    pub fn set_ground(&mut self, pixel: usize, opacity: f32) {
        for plane in self.planes.iter_mut().filter(|plane| plane.aov == Aov::Ground) {
            plane.data[pixel] = opacity;
        }
    }

    /// Divides by coverage, makes directions unit length, and hands the planes over, in the order of the request.
    pub fn finish(mut self) -> Vec<AovPlane> {
        for plane in &mut self.planes {
            let aov = plane.aov;
            let is_direction = matches!(
                aov,
                Aov::Normal | Aov::CameraNormal | Aov::CoatNormal | Aov::BentNormal | Aov::Tangent
            );
            let is_sum = !aov.is_of_one_surface() && !matches!(aov, Aov::Coverage | Aov::Ground);
            if !is_direction && !is_sum {
                continue;
            }
            for (values, &coverage) in plane.data.chunks_exact_mut(aov.channels()).zip(&self.coverage) {
                let divisor = if is_direction {
                    (values[0] * values[0] + values[1] * values[1] + values[2] * values[2]).sqrt()
                } else {
                    coverage
                };
                if divisor > 0.0 {
                    values.iter_mut().for_each(|v| *v /= divisor);
                }
            }
        }
        for plane in &mut self.planes {
            for &PixelSplats { pixel, coverage, front } in &self.splats {
                match (plane.aov, front) {
                    (Aov::Coverage, _) => {
                        plane.data[pixel] = 1.0 - (1.0 - plane.data[pixel]) * (1.0 - coverage)
                    }
                    (Aov::Depth, Some((distance, _))) => plane.data[pixel] = distance,
                    (Aov::ObjectId, Some((_, object))) => plane.ids[pixel] = object.saturating_add(1),
                    // A splat is made of no material and belongs to no instance of a mesh.
                    (Aov::MaterialId | Aov::InstanceId, Some(_)) => plane.ids[pixel] = 0,
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
                Aov::CameraNormal => &["normal"],
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
