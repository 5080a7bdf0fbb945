//! Gain maps of JPEG pictures ("Ultra HDR"): a second picture in the file, which says by how much the light of the first is
//! to be multiplied.
//!
//! Sources: Google, "Ultra HDR Image Format v1.1" (metadata of Adobe's namespace `hdrgm`, section "Decoding"), and ISO
//! 21496-1:2025, whose bytes are those that libultrahdr writes (`gainmapmetadata.cpp`). The map is applied in full, as for a
//! display of `HDRCapacityMax` or more: environments have no upper end.
//!
//! The map is looked for among the pictures that follow the first, one after the other, and known by its own metadata. Numbers
//! of bytes that the index of the multi-picture format or the container's directory state are not needed.

use overcoat_core::limits::Limits;
use overcoat_core::math::scalar::{exp2, pow};
use overcoat_image::decode::DecodedPicture;

/// Namespace of the metadata in XMP.
const NAMESPACE: &str = "http://ns.adobe.com/hdr-gain-map/1.0/";

/// First bytes of segments with XMP, and with metadata of ISO 21496-1.
const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";
const ISO: &[u8] = b"urn:iso:std:iso:ts:21496:-1\0";

/// Pictures of a file that are looked at.
const MOST_PICTURES: usize = 16;

/// Gains are at most this power of two, up and down.
const MOST_STOPS: f32 = 32.0;

/// Numbers of a gain map, for red, green and blue each.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gains {
    /// Powers of two where the map is 0, and where it is 1.
    least: [f32; 3],
    most: [f32; 3],
    gamma: [f32; 3],
    /// Added to the light before the gain, taken from it after.
    before: [f32; 3],
    after: [f32; 3],
}

/// Multiplies the linear light of a JPEG's first picture by its gain map; `None` if there is none.
///
/// # Errors
/// A text that says why it cannot be; the light is what it was.
pub(super) fn apply(
    jpeg: &[u8],
    (width, height): (u32, u32),
    light: &mut [[f32; 3]],
    limits: &Limits,
) -> Option<Result<(), String>> {
    let mut rest = following(jpeg);
    for _ in 0..MOST_PICTURES {
        let Some(picture) = rest else { break };
        if let Some(gains) = Gains::of(picture) {
            let map = gains.and_then(|gains| Ok((gains, decoded(picture, limits)?)));
            return Some(map.and_then(|(gains, map)| gains.multiply(&map, [width, height], light)));
        }
        rest = following(picture);
    }
    let is_announced = segments(jpeg).any(|payload| {
        payload.starts_with(ISO)
            || (payload.starts_with(XMP) && find(payload, NAMESPACE.as_bytes()).is_some())
    });
    is_announced.then(|| Err("it is not in the file".to_owned()))
}

fn decoded(picture: &[u8], limits: &Limits) -> Result<DecodedPicture, String> {
    DecodedPicture::from_bytes(picture, limits).map_err(|error| error.to_string())
}

/// Place of some bytes.
fn find(bytes: &[u8], what: &[u8]) -> Option<usize> {
    bytes.windows(what.len()).position(|window| window == what)
}

/// Payloads of the application segments before the first scan of a JPEG.
fn segments(jpeg: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = jpeg.get(2..).unwrap_or_default();
    std::iter::from_fn(move || {
        loop {
            let (marker, payload, after) = segment(rest)?;
            rest = after;
            match marker {
                0xe0..=0xef => return Some(payload),
                0xda => return None,
                _ => {}
            }
        }
    })
}

/// The marker, the payload, and what follows, of a segment that bytes begin with.
fn segment(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    match bytes {
        [0xff, 0xff, ..] => segment(bytes.get(bytes.iter().position(|b| *b != 0xff)?.checked_sub(1)?..)?),
        [0xff, marker, high, low, rest @ ..] => {
            let length = usize::from(u16::from_be_bytes([*high, *low])).checked_sub(2)?;
            let (payload, after) = rest.split_at_checked(length)?;
            Some((*marker, payload, after))
        }
        _ => None,
    }
}

/// The bytes from the next picture on, behind the end of the one that bytes begin with.
fn following(jpeg: &[u8]) -> Option<&[u8]> {
    let mut rest = jpeg.get(2..)?;
    loop {
        match rest {
            // Codes of a scan, in which these stand for a byte, a restart, and padding.
            [0xff, 0x00 | 0xd0..=0xd7, after @ ..] => rest = after,
            [0xff, 0xff, ..] => rest = rest.get(1..)?,
            [0xff, 0xd9, after @ ..] => return after.get(find(after, &[0xff, 0xd8, 0xff])?..),
            [0xff, ..] => rest = segment(rest)?.2,
            _ => rest = rest.get(rest.iter().position(|byte| *byte == 0xff)?..)?,
        }
    }
}

impl Gains {
    /// The numbers in a picture's metadata; `None` if it has none.
    fn of(picture: &[u8]) -> Option<Result<Self, String>> {
        let iso = segments(picture).find_map(|payload| payload.strip_prefix(ISO));
        if let Some(bytes) = iso {
            return Some(Self::of_iso(bytes).unwrap_or_else(|| Err("its metadata ends early".to_owned())));
        }
        let mut texts = segments(picture).filter_map(|payload| payload.strip_prefix(XMP));
        texts.find_map(|text| Self::of_xmp(&String::from_utf8_lossy(text)))
    }

    /// Metadata of ISO 21496-1, as JPEG files have them; `None` if bytes are missing.
    fn of_iso(bytes: &[u8]) -> Option<Result<Self, String>> {
        let (&[high, low, _, _, flags], mut rest) = bytes.split_first_chunk()?;
        if [high, low] != [0, 0] {
            return Some(Err(format!(
                "its metadata needs a reader of version {}",
                u16::from_be_bytes([high, low])
            )));
        }
        let mut word = || {
            let (word, after) = rest.split_first_chunk()?;
            rest = after;
            Some(u32::from_be_bytes(*word))
        };
        let common = if flags & 8 == 0 { None } else { Some(word()?) };
        let mut fraction = |is_signed: bool| {
            let part = word()?;
            let whole = common.map_or_else(&mut word, Some)?;
            let part = if is_signed { f64::from(part.cast_signed()) } else { f64::from(part) };
            Some((part / f64::from(whole)) as f32)
        };
        let [base, alternate] = [fraction(false)?, fraction(false)?];
        let channels = if flags & 0x80 == 0 { 1 } else { 3 };
        let mut rows = [[0.0; 5]; 3];
        for row in rows.iter_mut().take(channels) {
            *row = [fraction(true)?, fraction(true)?, fraction(false)?, fraction(true)?, fraction(true)?];
        }
        let [red, others @ ..] = &mut rows;
        if channels == 1 {
            *others = [*red; 2];
        }
        let [least, most, gamma, before, after] =
            std::array::from_fn(|k| rows.map(|row| row.get(k).copied().unwrap_or(0.0)));
        let is_hdr = flags & 4 != 0 || base > alternate;
        Some(Self { least, most, gamma, before, after }.checked(is_hdr))
    }

    /// Metadata of XMP; `None` if it has none of its namespace, or says nothing but its version.
    fn of_xmp(text: &str) -> Option<Result<Self, String>> {
        // The prefix that stands for the namespace, before `="` and behind `xmlns:`.
        let before = text.get(..text.find(NAMESPACE)?)?.trim_end_matches(['=', '"', '\'', ' ']);
        let prefix = before.get(before.rfind("xmlns:")?..)?.strip_prefix("xmlns:")?;
        let value = |name: &str| value(text, &format!("{prefix}:{name}"));
        value("GainMapMax")?;
        let numbers = |name: &str, default: Option<f32>| match (value(name), default) {
            (Some(text), _) => {
                three(&text).ok_or_else(|| format!("{name}: '{text}' is not one number or three"))
            }
            (None, Some(default)) => Ok([default; 3]),
            (None, None) => Err(format!("{name} is missing")),
        };
        let read = || {
            let gains = Self {
                least: numbers("GainMapMin", Some(0.0))?,
                most: numbers("GainMapMax", None)?,
                gamma: numbers("Gamma", Some(1.0))?,
                before: numbers("OffsetSDR", Some(1.0 / 64.0))?,
                after: numbers("OffsetHDR", Some(1.0 / 64.0))?,
            };
            gains.checked(value("BaseRenditionIsHDR").is_some_and(|v| v.eq_ignore_ascii_case("true")))
        };
        Some(read())
    }

    /// Itself, if it makes sense.
    fn checked(self, base_is_hdr: bool) -> Result<Self, String> {
        if base_is_hdr {
            return Err("the first picture is the one of more range".to_owned());
        }
        for ((least, most), gamma) in self.least.iter().zip(&self.most).zip(&self.gamma) {
            // No NaN passes.
            let is_right = -MOST_STOPS <= *least && least <= most && *most <= MOST_STOPS;
            if !(is_right && *gamma > 1e-3 && *gamma < 1e3) {
                return Err(format!("gains of 2 to the power {least} to {most} with a gamma of {gamma}"));
            }
        }
        let offsets = self.before.iter().chain(&self.after);
        match offsets.copied().find(|offset| !(-1.0..=1.0).contains(offset)) {
            Some(offset) => Err(format!("an offset of {offset}")),
            None => Ok(self),
        }
    }

    /// Multiplies light by the gains of a map, which is stretched over it.
    fn multiply(&self, map: &DecodedPicture, size: [u32; 2], light: &mut [[f32; 3]]) -> Result<(), String> {
        if map.kind.is_linear() || map.width == 0 || map.height == 0 {
            return Err(format!("a map of {} a channel", map.kind));
        }
        let [columns, rows] =
            [(size[0], map.width), (size[1], map.height)].map(|(all, own)| places(all, own));
        let stride = map.width as usize;
        let texel = |row: usize, column: usize| {
            map.pixels.get(row.saturating_mul(stride).saturating_add(column)).map_or([0.0; 4], |texel| *texel)
        };
        let white = 1.0 / map.kind.white();
        for (line, [top, bottom, down]) in light.chunks_mut(size[0].max(1) as usize).zip(rows) {
            for (pixel, [left, right, across]) in line.iter_mut().zip(&columns) {
                let corners = [(top, left), (top, right), (bottom, left), (bottom, right)];
                let [a, b, c, d] = corners.map(|(row, column)| texel(row as usize, *column as usize));
                for (k, value) in pixel.iter_mut().enumerate() {
                    let of = |texel: [f32; 4]| texel.get(k).copied().unwrap_or(0.0);
                    let above = of(a) + (of(b) - of(a)) * across;
                    let below = of(c) + (of(d) - of(c)) * across;
                    *value = self.gained(k, *value, (above + (below - above) * down) * white);
                }
            }
        }
        Ok(())
    }

    /// Light of a channel (0 to 2) multiplied by the gain of a map's value, 0 to 1: the section "Gain map application" of
    /// the specification, with a weight of 1.
    fn gained(&self, channel: usize, light: f32, value: f32) -> f32 {
        let of = |numbers: &[f32; 3]| numbers.get(channel).copied().unwrap_or(0.0);
        let gamma = of(&self.gamma);
        let value = if gamma == 1.0 { value } else { pow(value, 1.0 / gamma) };
        let power = of(&self.least) * (1.0 - value) + of(&self.most) * value;
        let light = (light + of(&self.before)) * exp2(power) - of(&self.after);
        if light > 0.0 { light } else { 0.0 }
    }
}

/// For each pixel of a side, the two texels of another that its centre lies between, and the share of the second.
fn places(pixels: u32, texels: u32) -> Vec<[f32; 3]> {
    let last = texels.saturating_sub(1) as f32;
    let place = |pixel: u32| {
        let at = (f64::from(pixel) + 0.5) * f64::from(texels) / f64::from(pixels.max(1)) - 0.5;
        let at = (at as f32).clamp(0.0, last);
        let first = at.floor();
        [first, (first + 1.0).min(last), at - first]
    };
    (0..pixels).map(place).collect()
}

/// The value of a property in XMP: of an attribute, or what stands in an element, tags taken as spaces.
fn value(text: &str, name: &str) -> Option<String> {
    for (at, _) in text.match_indices(name) {
        let rest = text.get(at..)?.strip_prefix(name)?.trim_start();
        if let Some(quoted) = rest.strip_prefix('=') {
            let mut parts = quoted.trim_start().split(['"', '\'']);
            return parts.nth(1).map(str::to_owned);
        }
        if let Some(content) = rest.strip_prefix('>') {
            let content = content.get(..content.find(&format!("</{name}"))?)?;
            let parts = content.split('<').filter_map(|part| part.rsplit('>').next());
            return Some(parts.map(str::trim).collect::<Vec<_>>().join(" ").trim().to_owned());
        }
    }
    None
}

/// One number for all, or three.
fn three(text: &str) -> Option<[f32; 3]> {
    let numbers: Option<Vec<f32>> = text.split_ascii_whitespace().map(|part| part.parse().ok()).collect();
    match numbers?.as_slice() {
        [one] => Some([*one; 3]),
        [r, g, b] => Some([*r, *g, *b]),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
