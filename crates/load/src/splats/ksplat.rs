//! KSPLAT, the splats of the viewer GaussianSplats3D (M. Kellogg; its class `SplatBuffer` is the specification).
//!
//! A header of 4096 bytes, a header of 1024 for each section, and the sections: lengths of buckets that are not full, centres
//! of buckets, splats. At compression level 0 splats are floats; at levels 1 and 2 positions are 16 bits about the centre of
//! their bucket, the rest are half floats, harmonics of level 2 bytes. Axes are those of the PLY files that they are made from.

use super::{Bytes, f32_at, u16_at, u32_at};
use crate::mesh_formats::check_input;
use crate::splat_clouds::{Cloud, UP_OF_CAPTURES, coefficients};
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};
use overcoat_core::math::half::half_to_f32;
use overcoat_scene::Splat;

const FORMAT: &str = "KSPLAT";
const HEADER: u64 = 4096;
const SECTION: u64 = 1024;
/// Bytes of the centre of a bucket.
const CENTER: u64 = 12;
/// Range of harmonics where the file gives none.
const HARMONICS: f32 = 1.5;

/// Header of a file.
struct Header {
    sections: u64,
    level: u16,
    harmonics: [f32; 2],
}

/// Header of a section.
struct Section {
    splats: u64,
    /// Places for splats, some of which may be empty.
    places: u64,
    per_bucket: u64,
    buckets: u64,
    /// Buckets that are full, and others, whose lengths are stored.
    full: u64,
    others: u64,
    /// Step of a position, and the number that stands for the centre.
    step: f32,
    middle: f32,
    degree: u8,
}

impl Header {
    fn read(bytes: &mut Bytes<'_>) -> Result<Self, LoadError> {
        let header = bytes.take(HEADER, "header")?;
        let (version, level) = (u16_at(header, 0).to_le_bytes(), u16_at(header, 20));
        if version[0] != 0 || version[1] < 1 {
            let [major, minor] = version;
            return Err(LoadError::unsupported(FORMAT, format!("version {major}.{minor}; 0.1 is read")));
        }
        if level > 2 {
            return Err(LoadError::unsupported(
                FORMAT,
                format!("compression level {level}; 0 to 2 are read"),
            ));
        }
        let or = |value: f32, other: f32| if value == 0.0 || !value.is_finite() { other } else { value };
        let harmonics = [or(f32_at(header, 36), -HARMONICS), or(f32_at(header, 40), HARMONICS)];
        Ok(Self { sections: u32_at(header, 4).into(), level, harmonics })
    }

    /// Bytes of a position and of each of the other numbers but colours.
    fn sizes(&self) -> (u64, u64) {
        if self.level == 0 { (12, 4) } else { (6, 2) }
    }

    /// Bytes of a coefficient of the harmonics.
    fn coefficient(&self) -> u64 {
        match self.level {
            0 => 4,
            1 => 2,
            _ => 1,
        }
    }

    /// Bytes of a splat.
    fn splat(&self, degree: u8) -> u64 {
        let (position, number) = self.sizes();
        let harmonics = self.coefficient().saturating_mul(3).saturating_mul(coefficients(degree) as u64);
        position.saturating_add(7_u64.saturating_mul(number)).saturating_add(4).saturating_add(harmonics)
    }
}

impl Section {
    fn read(bytes: &[u8], number: u64, level: u16) -> Result<Self, LoadError> {
        let word = |place: usize| u64::from(u32_at(bytes, place));
        let degree = u16_at(bytes, 40);
        let stored = u16_at(bytes, 20);
        let steps = if u32_at(bytes, 24) == 0 { 32767 } else { u32_at(bytes, 24) } as f32;
        let section = Self {
            splats: word(0),
            places: word(4),
            per_bucket: word(8),
            buckets: word(12),
            full: word(32),
            others: word(36),
            step: f32_at(bytes, 16) / 2.0 / steps,
            middle: steps,
            degree: u8::try_from(degree).unwrap_or(u8::MAX),
        };
        let problem = if degree > 3 {
            format!("harmonics of degree {degree}, more than 3")
        } else if section.splats > section.places {
            format!("{} splats in {} places", section.splats, section.places)
        } else if level > 0 && section.buckets > 0 && u64::from(stored) != CENTER {
            format!("{stored} bytes for the centre of a bucket, not {CENTER}")
        } else {
            return Ok(section);
        };
        Err(LoadError::malformed(FORMAT, format!("section {number}: {problem}")))
    }

    /// Bytes of what comes before the splats: lengths of buckets, and centres.
    fn before(&self, stored: u64) -> u64 {
        self.others.saturating_mul(4).saturating_add(self.buckets.saturating_mul(stored))
    }
}

/// True if the headers of the file account for all of its bytes: there is no other mark.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    if !bytes.starts_with(&[0, 1]) {
        return false;
    }
    let mut reader = Bytes { format: FORMAT, rest: bytes };
    let sizes = || -> Result<u64, LoadError> {
        let header = Header::read(&mut reader)?;
        let all = reader.take(header.sections.saturating_mul(SECTION), "headers of sections")?;
        let mut total = 0_u64;
        for section in all.chunks_exact(SECTION as usize) {
            let stored = u64::from(u16_at(section, 20));
            let section = Section::read(section, 0, header.level)?;
            let splats = section.places.saturating_mul(header.splat(section.degree));
            total = total.saturating_add(section.before(stored)).saturating_add(splats);
        }
        Ok(total)
    }();
    let rest = reader.rest.len() as u64;
    matches!(sizes, Ok(total) if total == rest && total > 0)
}

/// Reads a file. One that ends early is drawn as far as it goes, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut warnings = Warnings::default();
    let mut reader = Bytes { format: FORMAT, rest: bytes };
    let header = Header::read(&mut reader)?;
    let headers = reader.take(header.sections.saturating_mul(SECTION), "headers of sections")?;
    let headers = headers.chunks_exact(SECTION as usize);
    let mut sections = Vec::with_capacity(headers.len());
    for (number, section) in headers.enumerate() {
        let stored = u64::from(u16_at(section, 20));
        sections.push((Section::read(section, number as u64, header.level)?, stored));
    }
    let degree = sections.iter().map(|(section, _)| section.degree).max().unwrap_or(0);
    let claimed = sections.iter().fold(0_u64, |sum, (section, _)| sum.saturating_add(section.splats));
    // No more than the file can hold.
    let least = header.splat(0).max(1);
    let held = (reader.rest.len() as u64).checked_div(least).unwrap_or(0);
    let mut cloud = Cloud::new(FORMAT, claimed.min(held), degree, context)?;
    let mut read = 0_u64;
    for (section, stored) in &sections {
        let lengths = reader.take(section.others.saturating_mul(4), "lengths of buckets");
        let centers = reader.take(section.buckets.saturating_mul(*stored), "centres of buckets");
        let (Ok(lengths), Ok(centers)) = (lengths, centers) else { break };
        let each = header.splat(section.degree);
        let there = (reader.rest.len() as u64).checked_div(each).unwrap_or(0).min(section.places);
        let splats = reader.take(there.saturating_mul(each), "splats")?;
        let count = section.splats.min(there);
        read = read.saturating_add(count);
        add(&mut cloud, &header, section, [lengths, centers, splats], degree, count)?;
        if there < section.places {
            break;
        }
    }
    if read == 0 && claimed > 0 {
        return Err(LoadError::malformed(FORMAT, "the file ends before the first splat"));
    }
    if read < claimed {
        let all = counted(claimed, "splat");
        warnings.add(|| format!("{FORMAT}: the file ends after {read} of {all}"));
    }
    cloud.finish(UP_OF_CAPTURES, warnings)
}

/// Adds the first splats of a section.
fn add(
    cloud: &mut Cloud,
    header: &Header,
    section: &Section,
    [lengths, centers, splats]: [&[u8]; 3],
    degree: u8,
    count: u64,
) -> Result<(), LoadError> {
    let each = usize::try_from(header.splat(section.degree)).unwrap_or(usize::MAX).max(1);
    let mut own = [[0.0; 3]; 15];
    let own = own.get_mut(..coefficients(degree)).unwrap_or_default();
    let mut buckets = Buckets { section, lengths, bucket: 0, left: 0 };
    for record in splats.chunks_exact(each).take(usize::try_from(count).unwrap_or(usize::MAX)) {
        let place = buckets.next();
        let center = [0, 4, 8]
            .map(|k: usize| f32_at(centers, place.saturating_mul(CENTER as usize).saturating_add(k)));
        if header.level > 0 && place as u64 >= section.buckets {
            let message = format!("a splat of bucket {place} of {}", section.buckets);
            return Err(LoadError::malformed(FORMAT, message));
        }
        own.fill([0.0; 3]);
        harmonics(record, header, section.degree, own);
        cloud.push(splat(record, header, section, center), own);
    }
    Ok(())
}

/// Numbers of buckets, splat by splat: full ones first.
struct Buckets<'a> {
    section: &'a Section,
    lengths: &'a [u8],
    bucket: usize,
    /// Splats of the bucket that are still to come.
    left: u64,
}

impl Buckets<'_> {
    fn next(&mut self) -> usize {
        let Section { per_bucket, full, others, .. } = *self.section;
        while self.left == 0 {
            let number = self.bucket as u64;
            let other = number.saturating_sub(full);
            self.left = if number < full {
                per_bucket
            } else if other < others {
                u32_at(self.lengths, usize::try_from(other).unwrap_or(usize::MAX).saturating_mul(4)).into()
            } else {
                // Splats beyond all buckets are of the one after the last.
                u64::MAX
            };
            self.bucket = self.bucket.saturating_add(1);
        }
        self.left = self.left.saturating_sub(1);
        self.bucket.saturating_sub(1)
    }
}

fn splat(record: &[u8], header: &Header, section: &Section, center: [f32; 3]) -> Splat {
    let (position, number) = header.sizes();
    let (position, number) = (position as usize, number as usize);
    let at = |k: usize| {
        let place = position.saturating_add(k.saturating_mul(number));
        if header.level == 0 { f32_at(record, place) } else { half_to_f32(u16_at(record, place)) }
    };
    let [x, y, z] = center;
    let stepped = |k: usize, center: f32| {
        (f32::from(u16_at(record, k.saturating_mul(2))) - section.middle) * section.step + center
    };
    let colors = position.saturating_add(number.saturating_mul(7));
    let part = |k: usize| record.get(colors.saturating_add(k)).copied().map_or(0.0, f32::from) / 255.0;
    Splat {
        position: if header.level == 0 {
            [f32_at(record, 0), f32_at(record, 4), f32_at(record, 8)]
        } else {
            [stepped(0, x), stepped(1, y), stepped(2, z)]
        },
        scale: [at(0), at(1), at(2)],
        rotation: [at(4), at(5), at(6), at(3)],
        opacity: part(3),
        color: [part(0), part(1), part(2)],
    }
}

/// Reads the harmonics: those of each degree together, all of red before all of green and blue.
fn harmonics(record: &[u8], header: &Header, degree: u8, out: &mut [[f32; 3]]) {
    let (position, number) = header.sizes();
    let first = position.saturating_add(7_u64.saturating_mul(number)).saturating_add(4) as usize;
    let size = header.coefficient() as usize;
    let value = |k: usize| {
        let place = first.saturating_add(k.saturating_mul(size));
        match header.level {
            0 => f32_at(record, place),
            1 => half_to_f32(u16_at(record, place)),
            _ => {
                let [low, high] = header.harmonics;
                low + record.get(place).copied().map_or(0.0, f32::from) / 255.0 * (high - low)
            }
        }
    };
    for degree in 1..=degree {
        let (before, until) = (coefficients(degree.saturating_sub(1)), coefficients(degree));
        let orders = until.saturating_sub(before);
        for (n, coefficient) in out.get_mut(before..until).unwrap_or_default().iter_mut().enumerate() {
            for (c, stored) in coefficient.iter_mut().enumerate() {
                let own = c.saturating_mul(orders).saturating_add(n);
                *stored = value(before.saturating_mul(3).saturating_add(own));
            }
        }
    }
}
