//! The XML section of an E57 file: its scans, their poses, and the fields of their points.

use super::FORMAT;
use crate::text::double;
use crate::xml::{Tag, Xml};
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;

/// Contents of the section that a picture needs.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) scans: Vec<Header>,
    /// Pictures in the file.
    pub(super) images: u64,
}

/// A scan.
#[derive(Debug)]
pub(super) struct Header {
    /// Rotation as a quaternion (w, x, y, z).
    pub(super) rotation: [f64; 4],
    pub(super) translation: [f64; 3],
    /// Physical place of the points.
    pub(super) place: u64,
    /// Points by the file.
    pub(super) count: u64,
    pub(super) fields: Vec<Field>,
    /// Largest code of a colour by the file; 0 if it does not say.
    pub(super) color_limit: f64,
    /// Fields of fields, which points do not have.
    pub(super) is_nested: bool,
}

/// A field of a point.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// With the prefix of an extension.
    pub(super) name: String,
    pub(super) kind: Kind,
}

/// Type of a field.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Single,
    Double,
    /// Difference to the least number, in as many bits as the largest takes.
    Integer {
        minimum: i64,
        maximum: i64,
        scale: f64,
        offset: f64,
    },
}

impl Kind {
    /// Bits of a value.
    pub(super) fn bits(self) -> u32 {
        match self {
            Self::Single => 32,
            Self::Double => 64,
            Self::Integer { minimum, maximum, .. } => {
                let range = maximum.wrapping_sub(minimum) as u64;
                u64::BITS.saturating_sub(range.leading_zeros())
            }
        }
    }

    /// The value of some bits.
    pub(super) fn value(self, bits: u64) -> f64 {
        match self {
            Self::Single => f32::from_bits(bits as u32).into(),
            Self::Double => f64::from_bits(bits),
            Self::Integer { minimum, scale, offset, .. } => {
                minimum.wrapping_add(bits as i64) as f64 * scale + offset
            }
        }
    }
}

impl Document {
    /// Reads the section.
    pub(super) fn read(text: &str, context: &Context<'_>) -> Result<Self, LoadError> {
        let mut document = Self::default();
        let limit = context.limits.nodes;
        Xml::new(FORMAT, "", text).root(|xml, _| {
            xml.children(|xml, tag| match (tag.prefix(), tag.name()) {
                ("", "data3D") => xml.children(|xml, _| {
                    let count = (document.scans.len() as u64).saturating_add(1);
                    Limits::check(|| format!("{FORMAT}: the number of scans"), count, limit, "nodes")?;
                    document.scans.push(Header::read(xml, context)?);
                    Ok(())
                }),
                ("", "images2D") => xml.children(|_, _| {
                    document.images = document.images.saturating_add(1);
                    Ok(())
                }),
                _ => Ok(()),
            })
        })?;
        Ok(document)
    }
}

impl Header {
    fn read(xml: &mut Xml<'_>, context: &Context<'_>) -> Result<Self, LoadError> {
        let mut scan = Self {
            rotation: [1.0, 0.0, 0.0, 0.0],
            translation: [0.0; 3],
            place: 0,
            count: 0,
            fields: Vec::new(),
            color_limit: 0.0,
            is_nested: false,
        };
        xml.children(|xml, tag| match (tag.prefix(), tag.name()) {
            ("", "pose") => xml.children(|xml, tag| match tag.name() {
                "rotation" => numbers(xml, &["w", "x", "y", "z"], &mut scan.rotation),
                "translation" => numbers(xml, &["x", "y", "z"], &mut scan.translation),
                _ => Ok(()),
            }),
            ("", "colorLimits") => {
                let mut limits = [0.0; 3];
                numbers(xml, &["colorRedMaximum", "colorGreenMaximum", "colorBlueMaximum"], &mut limits)?;
                scan.color_limit = limits.iter().fold(0.0, |most, &v| if v > most { v } else { most });
                Ok(())
            }
            ("", "points") => {
                let number = |name: &str| tag.attribute(name).and_then(|text| text.trim().parse().ok());
                let (Some(place), Some(count)) = (number("fileOffset"), number("recordCount")) else {
                    return Err(xml.error("points without fileOffset or recordCount"));
                };
                (scan.place, scan.count) = (place, count);
                xml.children(|xml, tag| match tag.name() {
                    "prototype" => scan.prototype(xml, context),
                    _ => Ok(()),
                })
            }
            _ => Ok(()),
        })?;
        Ok(scan)
    }

    fn prototype(&mut self, xml: &mut Xml<'_>, context: &Context<'_>) -> Result<(), LoadError> {
        let limit = context.limits.nodes;
        xml.children(|xml, tag| {
            let count = (self.fields.len() as u64).saturating_add(1);
            Limits::check(|| format!("{FORMAT}: the number of fields"), count, limit, "nodes")?;
            match kind(tag) {
                Some(kind) => {
                    let name = match tag.prefix() {
                        "" => tag.name().to_owned(),
                        prefix => format!("{prefix}:{}", tag.name()),
                    };
                    self.fields.push(Field { name, kind });
                }
                None => {
                    if !matches!(tag.attribute("type").as_deref(), Some("Structure" | "Vector")) {
                        let name = crate::text::quoted(tag.name().as_bytes());
                        return Err(xml.error(format!("field {name} has a type or range that is not known")));
                    }
                    self.is_nested = true;
                }
            }
            Ok(())
        })
    }
}

/// Type of a field of a point; `None` if it is none of numbers.
fn kind(tag: &Tag<'_>) -> Option<Kind> {
    let whole = |name: &str, otherwise: i64| match tag.attribute(name) {
        Some(text) => text.trim().parse().ok(),
        None => Some(otherwise),
    };
    let number = |name: &str, otherwise: f64| match tag.attribute(name) {
        Some(text) => double(text.trim().as_bytes()).filter(|v| v.is_finite()),
        None => Some(otherwise),
    };
    match tag.attribute("type")?.as_str() {
        "Float" => match tag.attribute("precision").as_deref() {
            None | Some("double") => Some(Kind::Double),
            Some("single") => Some(Kind::Single),
            _ => None,
        },
        name @ ("Integer" | "ScaledInteger") => {
            let (minimum, maximum) = (whole("minimum", i64::MIN)?, whole("maximum", i64::MAX)?);
            let is_scaled = name == "ScaledInteger";
            let (scale, offset) =
                if is_scaled { (number("scale", 1.0)?, number("offset", 0.0)?) } else { (1.0, 0.0) };
            (minimum <= maximum).then_some(Kind::Integer { minimum, maximum, scale, offset })
        }
        _ => None,
    }
}

/// Numbers of child elements by their names. An element without content is 0 (ASTM E2807, 6.3.2).
fn numbers(xml: &mut Xml<'_>, names: &[&str], out: &mut [f64]) -> Result<(), LoadError> {
    xml.children(|xml, tag| {
        let slot = names.iter().zip(&mut *out).find(|(name, _)| **name == tag.name());
        if let Some((name, slot)) = slot {
            let text = xml.content()?;
            *slot = match text.trim() {
                "" => 0.0,
                text => {
                    let number = double(text.as_bytes()).filter(|v| v.is_finite());
                    number.ok_or_else(|| xml.error(format!("element {name} is no number")))?
                }
            };
        }
        Ok(())
    })
}
