//! Clouds of points, as the readers of their formats fill them.
//!
//! Points without colours are grey by what else the file says of them: the intensity of their reflection, any other
//! quantity, or the number of their class. The 1st percentile of a quantity is dark ([`DARK`], an sRGB code) and the 99th
//! white, since a few bright reflections must not leave the rest black; classes run from the smallest number to the
//! largest.

use super::mesh_formats::{add_object, default_material, drawable, white_material};
use super::warnings::{Warnings, counted};
use super::{Context, LoadError};
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_scene::{MeshData, PrimitiveKind, Scene};

/// Points of a file; lists are empty where it has none.
#[derive(Debug, Default)]
pub(crate) struct Points {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) colors: Vec<[f32; 4]>,
    /// Numbers that stand in for colours.
    pub(crate) values: Vec<f32>,
    /// Meaning of the values.
    pub(crate) measure: Measure,
}

/// Meaning of a point's scalar that is no position, direction or colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Measure {
    /// The number of a class: those of neighbouring classes have nothing in common.
    #[default]
    Class,
    /// A quantity.
    Quantity,
    /// Reflectance of the point: the best substitute for a colour.
    Intensity,
}

impl Measure {
    /// Meaning of a property by its name. CloudCompare puts `scalar_` before the names that its users give.
    pub(crate) fn of(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        let (given, name) = match name.strip_prefix("scalar_") {
            Some(rest) => (true, rest),
            None => (false, name.as_str()),
        };
        match name {
            "intensity" | "reflectance" | "reflectivity" | "remission" => Some(Self::Intensity),
            "class" | "classification" | "label" => Some(Self::Class),
            "scalar" | "quality" | "value" => Some(Self::Quantity),
            _ => given.then_some(Self::Quantity),
        }
    }
}

/// Bytes of a frame that drawing a point takes: some forty, and those of the picture.
const FRAME: u64 = 64;

/// The least grey: black points on black say nothing.
const DARK: f32 = 0.15;

/// Step through so many points that takes `most` of them, and no more than one frame can draw: 1 for all, 2 for every second one...
/// Beyond 1 there is a warning.
pub(crate) fn stride(
    format: &str,
    context: &Context<'_>,
    count: u64,
    most: u64,
    warnings: &mut Warnings,
) -> Result<u64, LoadError> {
    let most = most.min(context.limits.vertices).min(context.limits.frame_bytes / FRAME);
    let stride = count.div_ceil(most.max(1)).max(1);
    if stride > 1 {
        let points = counted(count, "point");
        warnings.add(|| format!("{format}: of {points} one in {stride} is drawn: the limits allow no more"));
    }
    Ok(stride)
}

/// The points of a file, without those that cannot be drawn.
pub(crate) fn cloud(format: &str, points: Points, warnings: &mut Warnings) -> MeshData {
    let Points { mut positions, mut normals, mut uvs, mut colors, mut values, measure } = points;
    let before = positions.len();
    if !positions.iter().all(|p| drawable(*p)) {
        let keep: Vec<bool> = positions.iter().map(|p| drawable(*p)).collect();
        retain(&mut normals, &keep);
        retain(&mut uvs, &keep);
        retain(&mut colors, &keep);
        retain(&mut values, &keep);
        retain(&mut positions, &keep);
        let lost = counted(before.abs_diff(positions.len()) as u64, "point");
        warnings.add(|| format!("{format}: {lost} left out: not finite or beyond 1e15"));
    }
    if colors.is_empty() {
        colors = greys(&values, measure);
    }
    MeshData::default().with(|d| {
        d.positions = positions;
        d.normals = normals;
        d.uvs = [uvs, Vec::new()];
        d.colors = colors;
        d.kind = PrimitiveKind::Points;
    })
}

/// Adds a cloud of opaque points as an object; nothing if there are none.
pub(crate) fn add(
    scene: &mut Scene,
    format: &str,
    points: Points,
    object: u32,
    warnings: &mut Warnings,
) -> Result<(), LoadError> {
    let mut data = cloud(format, points, warnings);
    if data.positions.is_empty() {
        return Ok(());
    }
    if data.normals.iter().flatten().all(|&v| v == 0.0) {
        data.normals = Vec::new();
    }
    let material = if data.colors.is_empty() { default_material() } else { white_material() };
    let material = scene.add_material(material).map_err(LoadError::scene(format!("{format}: material")))?;
    add_object(scene, &format!("{format}: points"), data, material, object)
}

/// Leaves out the items of a list that are not to be kept.
fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    list.retain(|_| keep.next().is_some_and(|keep| *keep));
}

/// A grey for each value; none if there are none, or all are alike.
fn greys(values: &[f32], measure: Measure) -> Vec<[f32; 4]> {
    let mut known: Vec<f32> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let Some(last) = known.len().checked_sub(1) else { return Vec::new() };
    // In hundredths of the list.
    let cut = if measure == Measure::Class { 0 } else { last / 100 };
    let mut ranked = |place: usize| *known.select_nth_unstable_by(place, f32::total_cmp).1;
    let (mut low, mut high) = (ranked(cut), ranked(last.saturating_sub(cut)));
    if low >= high {
        (low, high) = (ranked(0), ranked(last));
    }
    // In double precision no difference of two numbers is infinite.
    let (low, size) = (f64::from(low), f64::from(high) - f64::from(low));
    if size <= 0.0 {
        return Vec::new();
    }
    let grey = |value: &f32| {
        // Values that are no numbers are dark.
        let part = if value.is_finite() { ((f64::from(*value) - low) / size) as f32 } else { 0.0 };
        let part = if part > 0.0 { if part < 1.0 { part } else { 1.0 } } else { 0.0 };
        let v = srgb_to_linear(DARK + (1.0 - DARK) * part);
        [v, v, v, 1.0]
    };
    values.iter().map(grey).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn red(values: &[f32], measure: Measure) -> Vec<f32> {
        greys(values, measure).iter().map(|c| c[0]).collect()
    }

    #[test]
    fn quantities_are_grey_between_their_percentiles_and_classes_between_their_ends() {
        let dark = srgb_to_linear(DARK);
        let mut values: Vec<f32> = (0..200).map(|k| k as f32).collect();
        values.push(1e9);
        let found = red(&values, Measure::Quantity);
        assert!(
            found[0] == dark && found[2] == dark && found[3] > dark && found[200] == 1.0 && found[198] == 1.0
        );
        assert!((found[100] - srgb_to_linear(0.575)).abs() < 0.01);
        assert_eq!(red(&[2.0, 5.0, f32::NAN, 2.0], Measure::Class), [dark, 1.0, dark, dark]);
        assert!(red(&[3.0; 5], Measure::Quantity).is_empty() && red(&[], Measure::Class).is_empty());
        // One bright point among many equal ones.
        let mut values = vec![1.0; 500];
        values[7] = 2.0;
        assert_eq!(red(&values, Measure::Quantity)[6..8], [dark, 1.0]);
    }
}
