//! Lights (UsdLux) as those of a scene.
//!
//! A light of USD has a radiance: intensity times 2 to the power of exposure, over its area where it is normalized (*UsdLux Schema*,
//! "Physical units"). A sun's becomes illuminance and a ball's luminous intensity, by the solid angle and the area that they show;
//! rectangles and tubes keep it. Discs are squares of their area. Of lights of geometry and profiles nothing is drawn.

use super::FORMAT;
use super::compose::Composed;
use crate::text::quoted;
use overcoat_core::math::double::{pow, sin_cos};
use overcoat_scene::{Light, LightKind, Transform};
use std::f64::consts::PI;

/// Largest intensity and colour that a scene takes.
const MAX_INTENSITY: f64 = 1e9;
const MAX_COLOR: f64 = 1e6;
/// Angle of the sun that a distant light has by default, in degrees.
const SUN: f64 = 0.53;

/// True for prims that are lights.
pub(super) fn is_light(type_name: &str) -> bool {
    type_name.ends_with("Light") || type_name == "DomeLight_1"
}

/// A light and what of it has no effect, or why there is none.
pub(super) fn read(prim: &Composed, transform: &Transform) -> Result<(Light, Option<&'static str>), String> {
    let number = |name: &str, default: f64| number(prim, name, default);
    let kind = prim.type_name();
    if !matches!(kind, "DistantLight" | "SphereLight" | "DiskLight" | "RectLight" | "CylinderLight") {
        return Err("lights of this type are not drawn".to_owned());
    }
    let is_normalized = number("normalize", 0.0) != 0.0;
    let default = if kind == "DistantLight" { 50_000.0 } else { 1.0 };
    let radiance = radiance(prim, default);
    // Lengths before and after the transform.
    let scale = transform.uniform_scale();
    let [radius, width, height, length] = [("radius", 0.5), ("width", 1.0), ("height", 1.0), ("length", 1.0)]
        .map(|(name, default)| number(name, default).abs());
    let position = transform.point([0.0; 3]).map(|v| v as f32);
    let axis = |v: [f64; 3]| transform.direction(v).map(|v| v as f32);
    let normalized = |area: f64| if is_normalized && area > 0.0 { radiance / area } else { radiance };
    let (kind, intensity) = match kind {
        "DistantLight" => {
            let (sin, _) = sin_cos(number("angle", SUN).clamp(0.0, 180.0).to_radians() / 2.0);
            let solid = PI * sin * sin;
            // Without an extent, intensity is illuminance.
            let lux = if is_normalized || solid == 0.0 { radiance } else { radiance * solid };
            (LightKind::Directional { direction: axis([0.0, 0.0, -1.0]) }, lux)
        }
        "SphereLight" => {
            let is_point = number("treatAsPoint", 0.0) != 0.0 || radius == 0.0;
            let shown = if is_normalized || is_point { 0.25 } else { PI * radius * radius } * scale * scale;
            (bulb(prim, position, axis([0.0, 0.0, -1.0]), &number), radiance * shown)
        }
        "CylinderLight" => {
            let half = 0.5 * length;
            let ends = [-half, half].map(|x| transform.point([x, 0.0, 0.0]).map(|v| v as f32));
            let kind = LightKind::Tube { ends, radius: (radius * scale) as f32 };
            (kind, normalized(2.0 * PI * radius * length))
        }
        kind => {
            let disc = radius * PI.sqrt();
            let [width, height] = if kind == "DiskLight" { [disc; 2] } else { [width, height] };
            // Its front faces -Z.
            let kind = LightKind::Rect {
                position,
                half_width: axis([-0.5 * width, 0.0, 0.0]),
                half_height: axis([0.0, 0.5 * height, 0.0]),
                two_sided: false,
            };
            (kind, normalized(width * height))
        }
    };
    let color = color(prim);
    let has_texture =
        ["inputs:texture:file", "texture:file"].into_iter().any(|name| prim.text(name).is_some());
    let has_profile = prim.text("inputs:shaping:ies:file").is_some_and(|file| !file.is_empty());
    let lost = match (has_texture, has_profile) {
        (true, _) => Some("its picture"),
        (_, true) => Some("its profile"),
        _ => None,
    };
    let within = |v: f64, most: f64| if v > 0.0 { v.min(most) as f32 } else { 0.0 };
    let light = Light::new(kind).with(|l| {
        l.color = color.map(|c| within(c, MAX_COLOR));
        l.intensity = within(intensity, MAX_INTENSITY);
    });
    Ok((light, lost))
}

/// A number of a light, also by the name that it had before inputs.
pub(super) fn number(prim: &Composed, name: &str, default: f64) -> f64 {
    let value = prim.number(&format!("inputs:{name}")).or_else(|| prim.number(name));
    value.filter(|v| v.is_finite()).unwrap_or(default)
}

/// Intensity, times 2 to the power of exposure.
pub(super) fn radiance(prim: &Composed, default: f64) -> f64 {
    let exposure = number(prim, "exposure", 0.0).clamp(-100.0, 100.0);
    number(prim, "intensity", default) * pow(2.0, exposure)
}

/// Linear colour, with that of a temperature.
pub(super) fn color(prim: &Composed) -> [f64; 3] {
    let color = prim.value("inputs:color").or_else(|| prim.value("color")).and_then(|v| v.tuple::<3>());
    let mut color = color.unwrap_or([1.0; 3]);
    if number(prim, "enableColorTemperature", 0.0) != 0.0 {
        let warm = blackbody(number(prim, "colorTemperature", 6500.0));
        color.iter_mut().zip(warm).for_each(|(c, w)| *c *= w);
    }
    color
}

/// A bulb, or a spot where its light is shaped to a cone.
fn bulb(
    prim: &Composed,
    position: [f32; 3],
    direction: [f32; 3],
    number: &dyn Fn(&str, f64) -> f64,
) -> LightKind {
    let angle = number("shaping:cone:angle", 90.0).clamp(0.0, 180.0);
    let has_cone =
        ["inputs:shaping:cone:angle", "shaping:cone:angle"].iter().any(|name| prim.number(name).is_some());
    if !has_cone || angle >= 90.0 {
        return LightKind::Point { position, range: None };
    }
    let softness = number("shaping:cone:softness", 0.0).clamp(0.0, 1.0);
    let cosine = |degrees: f64| sin_cos(degrees.to_radians()).1 as f32;
    let outer = angle.max(0.1);
    LightKind::Spot {
        position,
        direction,
        range: None,
        inner_cone_cosine: cosine(outer * (1.0 - softness)),
        outer_cone_cosine: cosine(outer),
    }
}

/// Linear Rec. 709 colour of a black body, of luminance 1: the locus of Y. Kim et al., *Design of Advanced Color Temperature Control
/// System for HDTV Applications* (2002).
fn blackbody(kelvin: f64) -> [f64; 3] {
    let t = 1000.0 / kelvin.clamp(1667.0, 25_000.0);
    let cubic = |[a, b, c, d]: [f64; 4], v: f64| ((a * v + b) * v + c) * v + d;
    let is_warm = t > 0.25;
    let x = if is_warm {
        cubic([-0.266_123_9, -0.234_358_9, 0.877_695_6, 0.179_910], t)
    } else {
        cubic([-3.025_846_9, 2.107_037_9, 0.222_634_7, 0.240_390], t)
    };
    let y = if t > 1000.0 / 2222.0 {
        cubic([-1.106_381_4, -1.348_110_2, 2.185_558_32, -0.202_196_83], x)
    } else if is_warm {
        cubic([-0.954_947_6, -1.374_185_93, 2.091_370_15, -0.167_488_67], x)
    } else {
        cubic([3.081_758_0, -5.873_386_7, 3.751_129_97, -0.370_014_83], x)
    };
    let (cx, cz) = (x / y, (1.0 - x - y) / y);
    // IEC 61966-2-1, from XYZ of luminance 1.
    [
        3.240_969_9 * cx - 1.537_383_2 - 0.498_610_8 * cz,
        -0.969_243_6 * cx + 1.875_967_5 + 0.041_555_1 * cz,
        0.055_630_1 * cx - 0.203_977 + 1.056_971_5 * cz,
    ]
    .map(|v| if v > 0.0 { v } else { 0.0 })
}

/// The name of a light, in messages.
pub(super) fn label(prim: &Composed) -> String {
    format!("{FORMAT}: {} {}", prim.type_name(), quoted(prim.path.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_bodies_are_white_at_daylight_and_red_below() {
        let [r, g, b] = blackbody(6500.0);
        assert!([r, g, b].iter().all(|v| (v - 1.0).abs() < 0.06), "{r} {g} {b}");
        let [r, g, b] = blackbody(2700.0);
        assert!(r > 1.8 && g > 0.7 && b < 0.3, "{r} {g} {b}");
        let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        assert!((luminance - 1.0).abs() < 1e-3, "{luminance}");
        let [r, _, b] = blackbody(f64::INFINITY);
        assert!(b > 1.5 && r < 0.8, "{r} {b}");
    }
}
