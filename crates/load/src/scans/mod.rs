//! Files of laser scanners and depth cameras: clouds of points.

pub(crate) mod e57;
pub(crate) mod las;
mod laz;
mod lzf;
pub(crate) mod pcd;
pub(crate) mod ptx;
#[cfg(test)]
mod tests;
pub(crate) mod xyz;

use crate::mesh_formats::{check_mesh, finish};
use crate::origin::Region;
use crate::point_clouds::{self, Points, add};
use crate::warnings::Warnings;
use crate::{Context, LoadError, Loaded};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_scene::Scene;

/// Points in double precision, before they have an origin.
#[derive(Debug, Default)]
struct Scan {
    /// In the coordinates of the file.
    positions: Vec<[f64; 3]>,
    /// All but the positions.
    rest: Points,
}

impl Scan {
    /// Checks that so many points are within the limits.
    fn check(context: &Context<'_>, count: u64) -> Result<(), LoadError> {
        // Positions in double precision count as another set of vertices.
        check_mesh(context, 0, count.saturating_mul(2))
    }

    /// Step through so many points that takes as many of them as the limits allow: 1 for all, 2 for every second one... Beyond 1
    /// there is a warning.
    fn stride(
        format: &str,
        context: &Context<'_>,
        count: u64,
        warnings: &mut Warnings,
    ) -> Result<u64, LoadError> {
        let limits = context.limits;
        // As `check_mesh` counts them.
        let most = limits.vertices.min(limits.decoded_bytes / 24) / 2;
        let stride = point_clouds::stride(format, context, count, most, warnings)?;
        Self::check(context, count.div_ceil(stride))?;
        Ok(stride)
    }

    /// The scene of the scan alone, about an origin in a region far away if there is one.
    fn finish(self, format: &str, region: Option<&Region>, warnings: Warnings) -> Result<Loaded, LoadError> {
        Self::finish_all(vec![self], format, region, warnings)
    }

    /// The scene of scans whose points differ in what is known of them, likewise.
    fn finish_all(
        scans: Vec<Self>,
        format: &str,
        region: Option<&Region>,
        mut warnings: Warnings,
    ) -> Result<Loaded, LoadError> {
        let mut scene = Scene::new();
        let all = scans.iter().flat_map(|scan| scan.positions.iter().copied());
        let origin = region.map(|region| region.origin(all)).unwrap_or_default();
        scene.set_origin(origin.0);
        for (scan, object) in scans.into_iter().zip(0..) {
            let positions = scan.positions.iter().map(|&position| origin.relative(position)).collect();
            add(&mut scene, format, Points { positions, ..scan.rest }, object, &mut warnings)?;
        }
        if scene.instances().is_empty() {
            warnings.add(|| format!("{format}: the file has no points"));
        }
        Ok(finish(scene, warnings.finish()))
    }
}

/// Linear colour of codes of 8 bits.
fn color_of_8([r, g, b]: [u8; 3]) -> [f32; 4] {
    [srgb8_to_linear(r), srgb8_to_linear(g), srgb8_to_linear(b), 1.0]
}

/// Largest number among colours, which tells what they are codes of: 1 for fractions, 255 or 65535.
fn range_of(largest: f32) -> f32 {
    if largest <= 1.0 {
        1.0
    } else if largest <= 255.0 {
        255.0
    } else {
        65535.0
    }
}

/// Linear colour of codes up to the range.
fn color_within(codes: [f32; 3], range: f32) -> [f32; 4] {
    if range == 255.0 {
        return color_of_8(codes.map(|code| (code + 0.5) as u8));
    }
    let [r, g, b] = codes.map(|code| {
        let part = code / range;
        srgb_to_linear(if part > 0.0 { if part < 1.0 { part } else { 1.0 } } else { 0.0 })
    });
    [r, g, b, 1.0]
}
