//! SOG, the splats of PlayCanvas as pictures (developer.playcanvas.com, *The SOG Format*; where that says less, the reader of
//! PlayCanvas's `splat-transform`): versions 1 and 2, in a ZIP archive or as `meta.json` with its pictures beside it.
//!
//! A texel of each picture is a splat: positions as 16 bits of a logarithm, quaternions of which the largest number is left out
//! (in the order w, x, y, z), bytes that are places in tables of numbers (version 2) or between two ends (version 1). Harmonics
//! are those of a palette, 64 to a row. Axes are those of the PLY files that they are made from.

use super::with_largest;
use crate::archive::{Archive, MAGIC};
use crate::budget::Budget;
use crate::image::{decode, probe};
use crate::mesh_formats::check_input;
use crate::nearby::Nearby;
use crate::splat_clouds::{Cloud, DEGREE_0, UP_OF_CAPTURES, coefficients};
use crate::text::{quoted, without_mark};
use crate::warnings::Warnings;
use crate::zipped::ZipResolver;
use crate::{Context, LoadError, Loaded};
use overcoat_core::math::double;
use overcoat_core::math::scalar::exp;
use overcoat_scene::{Image, Splat};
use serde::Deserialize;

const FORMAT: &str = "SOG";
/// Description of the pictures.
const META: &str = "meta.json";
/// Bytes at the beginning of a description in which its keys are looked for.
const HEAD: usize = 1 << 16;
/// Entries of the palette in a row.
const ROW: usize = 64;
/// Number that the alpha of quaternions with the largest number first has.
const FIRST_LARGEST: u8 = 252;

/// The numbers that the bytes of a channel stand for.
type Table = [f32; 256];

/// Range or table of an attribute, and its pictures.
#[derive(Debug, Default, Deserialize)]
struct Attribute {
    #[serde(default)]
    shape: Vec<u64>,
    #[serde(default)]
    mins: Vec<f32>,
    #[serde(default)]
    maxs: Vec<f32>,
    #[serde(default)]
    codebook: Vec<f32>,
    files: Vec<String>,
}

/// The palette of harmonics.
#[derive(Debug, Deserialize)]
struct Palette {
    mins: Option<f32>,
    maxs: Option<f32>,
    #[serde(default)]
    codebook: Vec<f32>,
    /// Centroids, and then labels.
    files: Vec<String>,
}

/// The description.
#[derive(Debug, Deserialize)]
struct Meta {
    version: Option<u64>,
    count: Option<u64>,
    means: Attribute,
    scales: Attribute,
    quats: Attribute,
    sh0: Attribute,
    #[serde(rename = "shN")]
    harmonics: Option<Palette>,
}

/// True for the text of a description.
pub(crate) fn is_one(text: &[u8]) -> bool {
    let head = text.get(..HEAD).unwrap_or(text);
    let has = |key: &[u8]| head.windows(key.len()).any(|word| word == key);
    text.starts_with(b"{") && has(b"\"means\"") && has(b"\"quats\"") && has(b"\"sh0\"")
}

/// True for the names of the parts of an archive (in lower case) that hold a description and pictures.
pub(crate) fn is_bundle(names: &[String]) -> bool {
    names.iter().any(|name| is_meta(name)) && names.iter().any(|name| name.ends_with(".webp"))
}

fn is_meta(name: &str) -> bool {
    name.rsplit('/').next() == Some(META)
}

/// Reads an archive, or a description with its pictures beside it.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut warnings = Warnings::default();
    if !bytes.starts_with(MAGIC) {
        return read(without_mark(bytes), context, warnings);
    }
    let archive = Archive::open(FORMAT, bytes, context.limits, &mut warnings)?;
    let places = archive.names().filter(|name| is_meta(name));
    let Some(place) = places.min_by_key(|name| name.len()).map(str::to_owned) else {
        return Err(LoadError::malformed(FORMAT, format!("the archive has no {META} in it")));
    };
    let mut budget = Budget::new(context.limits);
    let text = archive.read(&place, &mut budget)?;
    let resolver = ZipResolver::new(archive, place, budget);
    read(&text, &Context { resolver: &resolver, ..*context }, warnings)
}

fn read(text: &[u8], context: &Context<'_>, warnings: Warnings) -> Result<Loaded, LoadError> {
    let malformed = |message: String| LoadError::malformed(FORMAT, message);
    let meta: Meta = serde_json::from_slice(text).map_err(|error| malformed(format!("{META}: {error}")))?;
    let version = meta.version.unwrap_or(1);
    if !(1..=2).contains(&version) {
        return Err(LoadError::unsupported(FORMAT, format!("version {version}; 1 and 2 are read")));
    }
    let Some(count) = meta.count.or(meta.means.shape.first().copied()) else {
        return Err(malformed("the number of splats is missing".to_owned()));
    };
    let mut pictures = Pictures { context, budget: Budget::new(context.limits), count };
    let palette = match &meta.harmonics {
        Some(palette) => Some(Harmonics::read(palette, &mut pictures)?),
        None => None,
    };
    let degree = palette.as_ref().map_or(0, |palette| palette.degree);
    let mut cloud = Cloud::new(FORMAT, count, degree, context)?;
    let splats = Splats::read(&meta, version, &mut pictures)?;
    let mut own = [[0.0; 3]; 15];
    let own = own.get_mut(..coefficients(degree)).unwrap_or_default();
    for number in 0..usize::try_from(count).unwrap_or(0) {
        if let Some(palette) = &palette {
            palette.fill(number, own);
        }
        cloud.push(splats.splat(number), own);
    }
    cloud.finish(UP_OF_CAPTURES, warnings)
}

/// Reads the pictures that a description names.
struct Pictures<'a> {
    context: &'a Context<'a>,
    budget: Budget,
    /// Splats that each has.
    count: u64,
}

impl Pictures<'_> {
    /// Picture of an attribute, which is the `place`th that it names.
    fn read(&mut self, files: &[String], place: usize, what: &str) -> Result<Image, LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let Some(file) = files.get(place) else {
            return Err(malformed(format!("picture {place} of the {what} is missing")));
        };
        let limits = self.context.limits;
        let found = Nearby::default().read(self.context, "", [file.as_str()], limits.input_bytes)?;
        let name = format!("{FORMAT}: picture {}", quoted(file.as_bytes()));
        let damaged = |error: crate::image::ImageError| match error.loss() {
            Ok(reason) => malformed(format!("picture {}: {reason}", quoted(file.as_bytes()))),
            Err(limit) => limit.into(),
        };
        let header = probe(&name, &found.bytes, limits).map_err(damaged)?;
        // Texels, and what decoding takes for a while.
        self.budget.charge(|| name.clone(), header.texels(), header.transient.saturating_add(4))?;
        Ok(decode(&found.bytes, &header).map_err(damaged)?.image)
    }

    /// A picture of which each texel is a splat.
    fn of_splats(&mut self, files: &[String], place: usize, what: &str) -> Result<Image, LoadError> {
        let image = self.read(files, place, what)?;
        let there = image.texels().len();
        if (there as u64) < self.count {
            let count = self.count;
            let message = format!("the picture of the {what} has {there} texels for {count} splats");
            return Err(LoadError::malformed(FORMAT, message));
        }
        Ok(image)
    }
}

/// The tables of so many channels of an attribute.
fn tables(attribute: &Attribute, version: u64, channels: usize, what: &str) -> Result<Vec<Table>, LoadError> {
    (0..channels)
        .map(|channel| {
            let ends = || Some((*attribute.mins.get(channel)?, *attribute.maxs.get(channel)?));
            match if version == 1 { ends().map(between) } else { from_codebook(&attribute.codebook) } {
                Some(table) => Ok(table),
                None => {
                    Err(LoadError::malformed(FORMAT, format!("the {what} have no range or table of 256")))
                }
            }
        })
        .collect()
}

fn from_codebook(codebook: &[f32]) -> Option<Table> {
    codebook.first_chunk().copied()
}

/// Bytes as parts of the way from one number to another.
fn between((low, high): (f32, f32)) -> Table {
    std::array::from_fn(|k| low + (high - low) * (k as f32 / 255.0))
}

fn number(table: Option<&Table>, byte: u8) -> f32 {
    table.and_then(|table| table.get(usize::from(byte))).copied().unwrap_or(f32::NAN)
}

/// Attributes of all splats.
struct Splats {
    means: [Image; 2],
    ends: Vec<[f64; 2]>,
    quaternions: Image,
    scales: Image,
    /// Standard deviations.
    scale_tables: Vec<Table>,
    colors: Image,
    color_tables: Vec<Table>,
    /// By the byte.
    opacities: Table,
}

impl Splats {
    fn read(meta: &Meta, version: u64, pictures: &mut Pictures<'_>) -> Result<Self, LoadError> {
        let means = &meta.means;
        let ends: Vec<[f64; 2]> = means
            .mins
            .iter()
            .zip(&means.maxs)
            .map(|(low, high)| [f64::from(*low), f64::from(*high)])
            .collect();
        if ends.len() < 3 {
            return Err(LoadError::malformed(FORMAT, "the range of the positions is missing"));
        }
        let mut scale_tables = tables(&meta.scales, version, 3, "scales")?;
        scale_tables.as_flattened_mut().iter_mut().for_each(|v| *v = exp(*v));
        let channels = if version == 1 { 4 } else { 3 };
        let color_tables = tables(&meta.sh0, version, channels, "colours")?;
        // Version 1 has opacities before the logistic function.
        let opacities = match color_tables.get(3) {
            Some(logits) => logits.map(|v| 1.0 / (1.0 + exp(-v))),
            None => between((0.0, 1.0)),
        };
        Ok(Self {
            means: [
                pictures.of_splats(&means.files, 0, "positions")?,
                pictures.of_splats(&means.files, 1, "positions")?,
            ],
            ends,
            quaternions: pictures.of_splats(&meta.quats.files, 0, "rotations")?,
            scales: pictures.of_splats(&meta.scales.files, 0, "scales")?,
            scale_tables,
            colors: pictures.of_splats(&meta.sh0.files, 0, "colours")?,
            color_tables,
            opacities,
        })
    }

    fn splat(&self, number_of: usize) -> Splat {
        let texel = |image: &Image| image.texels().get(number_of).copied().unwrap_or_default();
        let [low, high] = &self.means;
        let (low, high) = (texel(low), texel(high));
        let codes = [0, 1, 2].map(|k: usize| {
            let byte = |texel: [u8; 4]| texel.get(k).copied().unwrap_or(0);
            u16::from_le_bytes([byte(low), byte(high)])
        });
        let mut position = [f32::NAN; 3];
        for ((v, code), [from, to]) in position.iter_mut().zip(codes).zip(&self.ends) {
            *v = position_of(from + (to - from) * (f64::from(code) / 65535.0));
        }
        let [r, g, b, a] = texel(&self.colors);
        let [x, y, z, _] = texel(&self.scales);
        let color = |k: usize, byte: u8| 0.5 + DEGREE_0 * number(self.color_tables.get(k), byte);
        let scale = |k: usize, byte: u8| number(self.scale_tables.get(k), byte);
        Splat {
            position,
            scale: [scale(0, x), scale(1, y), scale(2, z)],
            rotation: rotation(texel(&self.quaternions)),
            opacity: number(Some(&self.opacities), a),
            color: [color(0, r), color(1, g), color(2, b)],
        }
    }
}

/// Positions are stored as sign(x) ln(1 + |x|).
fn position_of(stored: f64) -> f32 {
    let distance = double::exp(stored.abs()) - 1.0;
    (if stored < 0.0 { -distance } else { distance }) as f32
}

/// A quaternion in the order x, y, z, w; zeros for one that is none.
fn rotation([a, b, c, largest]: [u8; 4]) -> [f32; 4] {
    let Some(place) = largest.checked_sub(FIRST_LARGEST) else { return [0.0; 4] };
    let small = [a, b, c].map(|byte| (f32::from(byte) / 127.5 - 1.0) * std::f32::consts::FRAC_1_SQRT_2);
    let [w, x, y, z] = with_largest(small, place.into());
    [x, y, z, w]
}

/// Harmonics of all splats.
struct Harmonics {
    degree: u8,
    table: Table,
    centroids: Image,
    labels: Image,
}

impl Harmonics {
    fn read(palette: &Palette, pictures: &mut Pictures<'_>) -> Result<Self, LoadError> {
        let ends = palette.mins.zip(palette.maxs);
        let Some(table) = from_codebook(&palette.codebook).or(ends.map(between)) else {
            return Err(LoadError::malformed(FORMAT, "the harmonics have no range or table of 256"));
        };
        let centroids = pictures.read(&palette.files, 0, "harmonics")?;
        let labels = pictures.of_splats(&palette.files, 1, "labels of harmonics")?;
        let width = centroids.width() as usize;
        let Some(degree) = (1..=3).find(|&degree| coefficients(degree).saturating_mul(ROW) == width) else {
            let message =
                format!("the palette of harmonics is {width} texels wide; 192, 512 or 960 are read");
            return Err(LoadError::malformed(FORMAT, message));
        };
        Ok(Self { degree, table, centroids, labels })
    }

    /// The coefficients of a splat; zeros for one whose label does not exist.
    fn fill(&self, number_of: usize, own: &mut [[f32; 3]]) {
        let [low, high, ..] = self.labels.texels().get(number_of).copied().unwrap_or_default();
        let start = usize::from(u16::from_le_bytes([low, high])).saturating_mul(own.len());
        for (k, coefficient) in own.iter_mut().enumerate() {
            let texel = self.centroids.texels().get(start.saturating_add(k));
            *coefficient = match texel {
                Some(&[r, g, b, _]) => [r, g, b].map(|byte| number(Some(&self.table), byte)),
                None => [0.0; 3],
            };
        }
    }
}

#[cfg(test)]
mod tests;
