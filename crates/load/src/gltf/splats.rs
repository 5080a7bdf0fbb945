//! KHR_gaussian_splatting: primitives of points that are Gaussian splats.
//!
//! As of the release candidate of 2026: scales are linear, opacities from 0 to 1, quaternions (x, y, z, w), colours those
//! of a display. Drafts had logarithms for scales, which cannot be negative now; what has negative ones is read as such, with a
//! warning. The material and COLOR_0, which are for programs that draw points, have no effect.

use super::FORMAT;
use super::accessor::{self, Pick};
use super::buffers::Buffers;
use super::list::Index;
use super::mesh::{inside, name};
use super::model::{GaussianSplatting, Kind, Primitive, Root};
use crate::budget::Budget;
use crate::splat_clouds::DEGREE_0;
use crate::warnings::Warnings;
use crate::warnings::counted;
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use overcoat_scene::{Splat, SplatCloud, SplatCloudBuilder, SplatColorSpace, SplatOrder};

/// Before the names of its attributes.
pub(super) const PREFIX: &str = "KHR_gaussian_splatting:";

/// Orders of degrees 1, 2 and 3.
const ORDERS: [(u8, usize); 3] = [(1, 3), (2, 5), (3, 7)];

/// The attributes of splats, beside POSITION.
#[derive(Clone, Debug, Default)]
pub(super) struct Attributes {
    rotation: Option<Index>,
    scale: Option<Index>,
    opacity: Option<Index>,
    /// Degree and number of coefficients.
    harmonics: Vec<((u8, u8), Index)>,
}

impl Attributes {
    /// Takes an attribute by its name without the prefix.
    pub(super) fn set(&mut self, name: &str, index: Index) {
        let coefficient = || {
            let (degree, coefficient) = name.strip_prefix("SH_DEGREE_")?.split_once("_COEF_")?;
            Some((degree.parse().ok()?, coefficient.parse().ok()?))
        };
        match name {
            "ROTATION" => self.rotation = Some(index),
            "SCALE" => self.scale = Some(index),
            "OPACITY" => self.opacity = Some(index),
            // Four degrees have no more.
            _ if self.harmonics.len() < 64 => {
                self.harmonics.extend(coefficient().map(|place| (place, index)));
            }
            _ => {}
        }
    }

    fn harmonic(&self, degree: u8, coefficient: usize) -> Option<Index> {
        let is = |place: &(u8, u8)| place.0 == degree && usize::from(place.1) == coefficient;
        self.harmonics.iter().find(|(place, _)| is(place)).map(|(_, index)| *index)
    }

    /// The highest degree of which, and of all below, every coefficient is there.
    fn degree(&self) -> u8 {
        let whole = |&(degree, orders): &(u8, usize)| (0..orders).all(|k| self.harmonic(degree, k).is_some());
        ORDERS.iter().take_while(|degree| whole(degree)).map(|(degree, _)| *degree).last().unwrap_or(0)
    }
}

/// A cloud to be read.
#[derive(Clone, Debug)]
pub(super) struct Source {
    /// Mesh and primitive.
    of: (usize, usize),
    position: Index,
    rotation: Index,
    scale: Index,
    opacity: Index,
    base: Index,
    /// Coefficients of spherical harmonics of degrees 1 and above, order by order.
    harmonics: Vec<Index>,
    degree: u8,
    color_space: SplatColorSpace,
    order: SplatOrder,
    /// Number of splats.
    pub count: u64,
}

impl Source {
    pub(super) fn name(&self, root: &Root) -> String {
        name(root, self.of.0, self.of.1)
    }
}

/// Bytes of a splat while it is read, but for its harmonics: what is read, and what is kept.
const SPLAT_BYTES: u64 = 2 * size_of::<Splat>() as u64;

/// Bytes of a coefficient: as read, and as kept.
const COEFFICIENT_BYTES: u64 = 12 + 6;

/// Plan of a primitive of splats; `None`, with a warning, if an attribute is missing: it is drawn as points then. Reads
/// no data yet, but makes sure of the buffers.
///
/// # Errors
/// [`LoadError`] naming the primitive.
pub(super) fn plan(
    root: &Root,
    of: (usize, usize),
    given: &Primitive,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Option<Source>, LoadError> {
    let Some(extension) = given.extensions.as_deref().and_then(|e| e.splats.as_ref()) else {
        return Ok(None);
    };
    let name = || name(root, of.0, of.1);
    let attributes = given.attributes.splats.as_deref().cloned().unwrap_or_default();
    let needed = (
        given.attributes.position,
        attributes.rotation,
        attributes.scale,
        attributes.opacity,
        attributes.harmonic(0, 0),
    );
    let (Some(position), Some(rotation), Some(scale), Some(opacity), Some(base)) = needed else {
        warnings.add(|| format!("{}: splats without all attributes are drawn as points", name()));
        return Ok(None);
    };
    if given.mode.map(|mode| mode.0) != Some(0) {
        warnings.add(|| format!("{}: splats that are not POINTS are drawn without being splats", name()));
        return Ok(None);
    }
    if given.indices.is_some() {
        warnings.add(|| format!("{}: indices of splats have no effect", name()));
    }
    let (color_space, order) = conventions(extension, &name, warnings);
    let degree = attributes.degree();
    let orders = ORDERS.iter().filter(|(own, _)| *own <= degree);
    let places = orders.flat_map(|&(degree, orders)| (0..orders).map(move |k| (degree, k)));
    let harmonics: Vec<Index> = places.filter_map(|(degree, k)| attributes.harmonic(degree, k)).collect();
    if attributes.harmonics.len() > harmonics.len().saturating_add(1) {
        warnings.add(|| format!("{}: of its spherical harmonics those of degree {degree} are drawn", name()));
    }
    let count = accessor::get(root, position).map_err(|e| inside(name(), e))?.count.0;
    Limits::check(|| format!("{}: splats", name()), count, context.limits.vertices, "vertices")?;
    let each = SPLAT_BYTES.saturating_add(COEFFICIENT_BYTES.saturating_mul(harmonics.len() as u64));
    budget.charge(|| format!("{}: splats", name()), count, each)?;
    for &index in [position, rotation, scale, opacity, base].iter().chain(&harmonics) {
        accessor::require(root, index, buffers, context, budget).map_err(|e| inside(name(), e))?;
        let own = accessor::get(root, index).map_err(|e| inside(name(), e))?.count.0;
        if own != count {
            let message = format!("{}: {own} elements of accessor {index} for {count} splats", name());
            return Err(LoadError::malformed(FORMAT, message));
        }
    }
    Ok(Some(Source {
        of,
        position,
        rotation,
        scale,
        opacity,
        base,
        harmonics,
        degree,
        color_space,
        order,
        count,
    }))
}

/// Colour space and sorting order that the extension gives. Unknown ones are warned of and replaced by the default.
fn conventions(
    extension: &GaussianSplatting,
    name: &impl Fn() -> String,
    warnings: &mut Warnings,
) -> (SplatColorSpace, SplatOrder) {
    let mut unknown = |what: &str, value: &str, instead: &str| {
        let value: String = value.escape_debug().take(64).collect();
        warnings.add(|| format!("{}: {what} '{value}' of splats is not known: {instead}", name()));
    };
    if let Some(kernel) = extension.kernel.as_deref().filter(|&kernel| kernel != "ellipse") {
        unknown("kernel", kernel, "drawn as ellipses");
    }
    if let Some(projection) = extension.projection.as_deref().filter(|&p| p != "perspective") {
        unknown("projection", projection, "drawn by the linear approximation of the camera's");
    }
    let color_space = match extension.color_space.as_deref() {
        // The others are names of drafts.
        None | Some("srgb_rec709_display" | "BT.709" | "BT.709-sRGB") => SplatColorSpace::Srgb,
        Some("lin_rec709_display" | "linear" | "BT.709-linear") => SplatColorSpace::Linear,
        Some(other) => {
            unknown("colorSpace", other, "taken as sRGB");
            SplatColorSpace::Srgb
        }
    };
    let order = match extension.sorting_method.as_deref() {
        None | Some("cameraDistance") => SplatOrder::Distance,
        Some("zDepth") => SplatOrder::Depth,
        Some(other) => {
            unknown("sortingMethod", other, "sorted by the distance from the camera");
            SplatOrder::Distance
        }
    };
    (color_space, order)
}

/// Reads a cloud. Adds what was left out to `repaired`.
///
/// # Errors
/// [`LoadError`] naming the primitive.
pub(super) fn read(
    root: &Root,
    buffers: &Buffers<'_>,
    source: &Source,
    repaired: &mut Vec<String>,
) -> Result<SplatCloud, LoadError> {
    let name = || source.name(root);
    let count = usize::try_from(source.count).unwrap_or(0);
    let [positions, mut scales, bases] = [source.position, source.scale, source.base]
        .map(|index| attribute::<3>(root, buffers, index, Kind::Vec3, count).map_err(|e| inside(name(), e)));
    let rotations = attribute::<4>(root, buffers, source.rotation, Kind::Vec4, count);
    let rotations = rotations.map_err(|e| inside(name(), e))?;
    let opacities = attribute::<1>(root, buffers, source.opacity, Kind::Scalar, count);
    let opacities = opacities.map_err(|e| inside(name(), e))?;
    let harmonics = source
        .harmonics
        .iter()
        .map(|&index| attribute::<3>(root, buffers, index, Kind::Vec3, count).map_err(|e| inside(name(), e)))
        .collect::<Result<Vec<_>, LoadError>>()?;
    if let Ok(scales) = &mut scales
        && scales.as_flattened().iter().any(|&v| v < 0.0)
    {
        repaired
            .push(format!("{}: negative scales of splats: read as logarithms, as drafts had them", name()));
        scales.as_flattened_mut().iter_mut().for_each(|v| *v = overcoat_core::math::scalar::exp(*v));
    }
    let builder = SplatCloudBuilder::new(source.degree, source.color_space, source.order);
    let mut builder = builder.map_err(LoadError::scene(name()))?;
    builder.reserve(count);
    let (mut bad, mut own) = (0_u64, Vec::with_capacity(harmonics.len()));
    let splats = positions?.into_iter().zip(scales?).zip(bases?).zip(rotations).zip(opacities);
    for (k, ((((position, scale), base), rotation), [opacity])) in splats.enumerate() {
        own.clear();
        own.extend(harmonics.iter().filter_map(|list| list.get(k)).copied());
        let rotation = if rotation == [0.0; 4] { [0.0, 0.0, 0.0, 1.0] } else { rotation };
        let color = base.map(|v| 0.5 + DEGREE_0 * v);
        // Quantised numbers may be a little beyond.
        let opacity = opacity.clamp(0.0, 1.0);
        if builder.push(&Splat { position, scale, rotation, opacity, color }, &own).is_err() {
            bad = bad.saturating_add(1);
        }
    }
    if bad > 0 {
        let splats = counted(bad, "splat");
        repaired.push(format!("{}: {splats} left out: not finite or too large", name()));
    }
    Ok(builder.finish())
}

fn attribute<const N: usize>(
    root: &Root,
    buffers: &Buffers<'_>,
    index: Index,
    kind: Kind,
    count: usize,
) -> Result<Vec<[f32; N]>, LoadError> {
    let elements = accessor::resolve(root, buffers, index)?;
    if elements.kind != kind {
        let message = format!("accessor {index} has elements of the wrong type for splats");
        return Err(LoadError::malformed(FORMAT, message));
    }
    elements.floats(&Pick::Range(0..count))
}
