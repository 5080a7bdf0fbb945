//! Dome lights (UsdLuxDomeLight) as the environment of a scene.
//!
//! Their pictures lie as those of OpenEXR do: +Y is above, the centre looks to +Z and what is right of it to -X (`ImfEnvmap.h`, which
//! *UsdLux* refers to). Turns of the light about any axis, intensity, exposure and colour are put into the picture. One whose
//! texels are all alike, or a dome without one, says nothing of surroundings.

use super::compose::Composed;
use super::files::Files;
use super::lights::{color, radiance};
use crate::nearby::folder_of;
use crate::text::quoted;
use crate::{Context, NoResolver};
use overcoat_core::math::double::{atan2, sin_cos};
use overcoat_scene::{EquirectImage, Transform};
use std::f64::consts::{PI, TAU};

/// True for lights that surround the scene.
pub(super) fn is_dome(type_name: &str) -> bool {
    matches!(type_name, "DomeLight" | "DomeLight_1")
}

/// The picture of a dome as environments lie, or why there is none.
pub(super) fn read(
    prim: &Composed,
    transform: &Transform,
    is_z_up: bool,
    files: &mut Files<'_>,
) -> Result<EquirectImage, String> {
    let name = ["inputs:texture:file", "texture:file"].into_iter().find(|name| prim.text(name).is_some());
    let file = name.and_then(|name| prim.text(name)).filter(|file| !file.is_empty());
    let Some((file, name)) = file.zip(name) else {
        return Err("it has no picture, so that the usual environment stays".to_owned());
    };
    let what = quoted(file.as_bytes());
    let format = prim.text("inputs:texture:format").or_else(|| prim.text("texture:format"));
    if let Some(format) = format.filter(|format| !matches!(format.as_str(), "automatic" | "latlong" | "")) {
        return Err(format!("pictures of the format {} are not read", quoted(format.as_bytes())));
    }
    let folder = prim.property(name).and_then(|found| found.file);
    let folder = folder.as_deref().map(folder_of).unwrap_or_default();
    let (context, limits) = (files.context, files.context.limits);
    let failed = |error: &dyn std::fmt::Display| format!("its picture {what} is left out: {error}");
    let found = files.nearby.read(context, folder, [file.as_str()], limits.input_bytes);
    let found = found.map_err(|error| failed(&error))?;
    let alone = Context { resolver: &NoResolver, limits, jobs: context.jobs };
    let loaded = crate::load_environment(&found.bytes, &alone).map_err(|error| failed(&error))?;
    for warning in &loaded.warnings {
        files.say(|| format!("{}: {what}: {}", super::FORMAT, warning.message));
    }
    let pixels = loaded.image.pixels();
    let first = pixels.first().copied().unwrap_or_default();
    if pixels.iter().all(|&pixel| alike(pixel, first)) {
        return Err(format!("its picture {what} is of one colour, so that the usual environment stays"));
    }
    let bytes = (pixels.len() as u64).saturating_mul(12);
    files.budget.charge(|| format!("{}: picture {what}", super::FORMAT), bytes, 2).map_err(|e| failed(&e))?;
    let pole = prim.text("poleAxis");
    let has_z_pole = prim.type_name() == "DomeLight_1"
        && match pole.as_deref() {
            Some("Z") => true,
            Some("Y") => false,
            _ => is_z_up,
        };
    let axes = Axes::new(transform, is_z_up, has_z_pole).ok_or("it is scaled to nothing")?;
    let strength = radiance(prim, 1.0);
    let tint = color(prim).map(|c| (c * strength) as f32);
    axes.turned(&loaded.image, tint, context).map_err(|error| failed(&error))
}

/// True for colours that rounding sets apart at most.
fn alike(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.01 * b.abs())
}

/// Axes of a dome, as its picture has them, in the directions of an environment.
struct Axes([[f64; 3]; 3]);

impl Axes {
    /// `None` for a transform in which an axis has no length.
    fn new(transform: &Transform, is_z_up: bool, has_z_pole: bool) -> Option<Self> {
        let unit = |v: [f64; 3]| {
            let [x, y, z] = transform.direction(v);
            let length = (x * x + y * y + z * z).sqrt();
            let [x, y, z] = [x, y, z].map(|v| v / length);
            // Directions of a scene of +Z stand upright in the picture.
            let upright = if is_z_up { [x, z, -y] } else { [x, y, z] };
            (length > 1e-150 && length.is_finite()).then_some(upright)
        };
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [x, y, z] = [unit(axes[0])?, unit(axes[1])?, unit(axes[2])?];
        // About +X by a quarter turn.
        Some(Self(if has_z_pole { [x, z, y.map(|v| -v)] } else { [x, y, z] }))
    }

    /// The picture of an environment, by bilinear interpolation in that of the dome.
    fn turned(
        &self,
        image: &EquirectImage,
        tint: [f32; 3],
        context: &Context<'_>,
    ) -> Result<EquirectImage, overcoat_scene::SceneError> {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let angles = |count: usize, whole: f64, first: f64| -> Vec<(f64, f64)> {
            (0..count).map(|k| sin_cos(first + (k as f64 + 0.5) / count as f64 * whole)).collect()
        };
        // An environment's centre looks to +X, and what is right of it to +Z.
        let (columns, rows) = (angles(width, TAU, -PI), angles(height, PI, 0.0));
        let mut pixels = vec![[0.0; 3]; image.pixels().len()];
        context.jobs.for_each_chunk_mut(&mut pixels, width, |row, out| {
            let (across, up) = rows.get(row).copied().unwrap_or_default();
            for (pixel, &(sin, cos)) in out.iter_mut().zip(&columns) {
                let direction = [across * cos, up, across * sin];
                let [x, y, z] = self.0.map(|axis| {
                    let [a, b, c] = axis;
                    let [x, y, z] = direction;
                    a * x + b * y + c * z
                });
                let u = 0.5 - atan2(x, z) / TAU;
                let v = atan2((x * x + z * z).sqrt(), y) / PI;
                let sample = sample(image, u * width as f64 - 0.5, v * height as f64 - 0.5);
                for ((pixel, sample), tint) in pixel.iter_mut().zip(sample).zip(tint) {
                    *pixel = sample * tint;
                }
            }
        });
        EquirectImage::new(image.width(), image.height(), pixels)
    }
}

/// The light at a place in texels, of which the first's centre is 0; columns go on around, rows end.
fn sample(image: &EquirectImage, x: f64, y: f64) -> [f32; 3] {
    let (width, height) = (i64::from(image.width()), i64::from(image.height()));
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = ((x - left) as f32, (y - top) as f32);
    let texel = |dx: i64, dy: i64| {
        let column = (left as i64).saturating_add(dx).rem_euclid(width);
        let row = (top as i64).saturating_add(dy).clamp(0, height.saturating_sub(1));
        let place = row.saturating_mul(width).saturating_add(column);
        image.pixels().get(place as usize).copied().unwrap_or_default()
    };
    let mix = |a: [f32; 3], b: [f32; 3], t: f32| -> [f32; 3] {
        let [[a0, a1, a2], [b0, b1, b2]] = [a, b];
        [a0 + (b0 - a0) * t, a1 + (b1 - a1) * t, a2 + (b2 - a2) * t]
    };
    mix(mix(texel(0, 0), texel(1, 0), fx), mix(texel(0, 1), texel(1, 1), fx), fy)
}
