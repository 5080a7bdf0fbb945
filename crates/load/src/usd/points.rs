//! Points as a cloud: positions with colours, and the discs that their widths ask for (UsdGeomPoints).

use super::compose::Composed;
use super::mesh::{Counts, Reads, Values, primvar, unit};
use crate::mesh_formats::drawable;
use overcoat_core::jobs::Jobs;
use overcoat_scene::{Mesh, MeshData, PrimitiveKind, estimate_surfels};

/// Least radius in pixels of points whose width the file gives.
const LEAST_RADIUS: f32 = 0.5;

/// The points of a prim.
#[derive(Default)]
pub(super) struct Cloud {
    pub(super) data: MeshData,
    /// Radius of each; empty without widths.
    radii: Vec<f32>,
    /// Points that cannot be drawn.
    pub(super) bad: u64,
}

impl Cloud {
    pub(super) fn read(prim: &Composed, reads: &Reads) -> Self {
        let points: Vec<[f32; 3]> = prim.value("points").map(|v| v.tuples()).unwrap_or_default();
        let sizes = Counts([points.len(), 0, 0]);
        let widths =
            Values::<1>::read(prim, "primvars:widths", sizes).or_else(|| Values::read(prim, "widths", sizes));
        let normals = Values::<3>::read(prim, "primvars:normals", sizes)
            .or_else(|| Values::read(prim, "normals", sizes));
        let colors = reads.color.as_ref().and_then(|name| Values::<3>::read(prim, &primvar(name), sizes));
        let opacities = Values::<1>::read(prim, "primvars:displayOpacity", sizes);
        let mut cloud = Self::default();
        cloud.data.kind = PrimitiveKind::Points;
        for (k, point) in points.into_iter().enumerate() {
            if !drawable(point) {
                cloud.bad = cloud.bad.saturating_add(1);
                continue;
            }
            cloud.data.positions.push(point);
            if let Some(widths) = &widths {
                let [width] = widths.of_point(k).unwrap_or_default();
                cloud.radii.push(if width > 0.0 && width < 1e15 { 0.5 * width } else { 0.0 });
            }
            if let Some(normals) = &normals {
                let normal = normals.of_point(k).filter(|n| n.iter().all(|v| v.is_finite()));
                cloud.data.normals.push(normal.unwrap_or_default());
            }
            if let Some(colors) = &colors {
                let [r, g, b] = colors.of_point(k).unwrap_or([1.0; 3]).map(unit);
                let opacity = opacities.as_ref().and_then(|values| values.of_point(k));
                cloud.data.colors.push([r, g, b, opacity.map_or(1.0, |[v]| unit(v))]);
            }
        }
        if cloud.data.normals.iter().flatten().all(|&v| v == 0.0) {
            cloud.data.normals.clear();
        }
        cloud
    }

    /// Sizes of the discs of a mesh of these points; without widths, the distances between them decide.
    pub(super) fn size(radii: Vec<f32>, mesh: &Mesh, jobs: &Jobs) {
        if radii.is_empty() {
            return;
        }
        let mut surfels = estimate_surfels(mesh, jobs);
        (surfels.radii, surfels.least_radius) = (radii, LEAST_RADIUS);
        mesh.set_surfels(surfels);
    }

    pub(super) fn into_parts(self) -> (MeshData, Vec<f32>) {
        (self.data, self.radii)
    }
}
