//! The values behind the header, one after the other.

use super::header::{Encoding, Scalar};
use crate::text::{Tokens, double, float, integer};
use overcoat_core::math::half::half_to_f32;

/// Reads values of either encoding.
#[derive(Clone, Debug)]
pub(super) enum Values<'a> {
    Ascii(Tokens<'a>),
    LittleEndian(&'a [u8]),
    BigEndian(&'a [u8]),
}

/// Reason why there is no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    /// The file has ended.
    End,
    /// There is something that is not a number, or not a whole one where it must be.
    NotANumber,
}

impl<'a> Values<'a> {
    pub(super) fn new(encoding: Encoding, bytes: &'a [u8]) -> Self {
        match encoding {
            Encoding::Ascii => Self::Ascii(Tokens::new(bytes)),
            Encoding::LittleEndian => Self::LittleEndian(bytes),
            Encoding::BigEndian => Self::BigEndian(bytes),
        }
    }

    /// The next value, as a number; NaN for a word that is none.
    #[inline]
    pub(super) fn number(&mut self, scalar: Scalar) -> Result<f32, Missing> {
        match self {
            // Tokens that are no numbers become NaN, which is not finite either.
            Self::Ascii(tokens) => Ok(float(tokens.next().ok_or(Missing::End)?).unwrap_or(f32::NAN)),
            Self::LittleEndian(bytes) => binary(bytes, scalar, false).map(|v| v.0),
            Self::BigEndian(bytes) => binary(bytes, scalar, true).map(|v| v.0),
        }
    }

    /// The next value, as well as double precision knows it; NaN for a word that is no number.
    pub(super) fn double(&mut self, scalar: Scalar) -> Result<f64, Missing> {
        match self {
            Self::Ascii(tokens) => Ok(double(tokens.next().ok_or(Missing::End)?).unwrap_or(f64::NAN)),
            Self::LittleEndian(bytes) => binary_double(bytes, scalar, false),
            Self::BigEndian(bytes) => binary_double(bytes, scalar, true),
        }
    }

    /// The next value, as a whole number.
    #[inline]
    pub(super) fn integer(&mut self, scalar: Scalar) -> Result<i64, Missing> {
        match self {
            Self::Ascii(tokens) => {
                let token = tokens.next().ok_or(Missing::End)?;
                // Some programs write counts and indices with a fraction of zero.
                let whole = |v: &f32| *v == v.trunc() && v.abs() < 16_777_216.0;
                integer(token)
                    .or_else(|| float(token).filter(whole).map(|v| v as i64))
                    .ok_or(Missing::NotANumber)
            }
            Self::LittleEndian(bytes) => binary(bytes, scalar, false).map(|v| v.1),
            Self::BigEndian(bytes) => binary(bytes, scalar, true).map(|v| v.1),
        }
    }

    /// Bytes that have not been read.
    pub(super) fn rest(&self) -> &'a [u8] {
        match self {
            Self::Ascii(tokens) => tokens.rest(),
            Self::LittleEndian(bytes) | Self::BigEndian(bytes) => bytes,
        }
    }

    /// True if nothing follows in a binary file.
    pub(super) fn is_empty(&self) -> bool {
        matches!(self, Self::LittleEndian([]) | Self::BigEndian([]))
    }

    /// Passes over the rest of a line that has something else than it should. False where there are no lines.
    pub(super) fn skip_line(&mut self) -> bool {
        match self {
            Self::Ascii(tokens) => {
                tokens.rest_of_line();
                true
            }
            Self::LittleEndian(_) | Self::BigEndian(_) => false,
        }
    }

    /// Skips values of one type.
    pub(super) fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Missing> {
        match self {
            Self::Ascii(tokens) => (0..count).try_for_each(|_| tokens.next().map(drop).ok_or(Missing::End)),
            Self::LittleEndian(bytes) | Self::BigEndian(bytes) => {
                let size = count.saturating_mul(scalar.size() as u64);
                let size = usize::try_from(size).map_err(|_| Missing::End)?;
                *bytes = bytes.get(size..).ok_or(Missing::End)?;
                Ok(())
            }
        }
    }
}

/// A binary value, as well as double precision knows it.
#[inline]
pub(super) fn binary_double(bytes: &mut &[u8], scalar: Scalar, big: bool) -> Result<f64, Missing> {
    if scalar == Scalar::F64 {
        let (&value, rest) = bytes.split_first_chunk().ok_or(Missing::End)?;
        *bytes = rest;
        return Ok(if big { f64::from_be_bytes(value) } else { f64::from_le_bytes(value) });
    }
    let (number, whole) = binary(bytes, scalar, big)?;
    Ok(if scalar.is_float() { f64::from(number) } else { whole as f64 })
}

/// A binary value, as a number and as a whole number (saturating).
#[inline]
pub(super) fn binary(bytes: &mut &[u8], scalar: Scalar, big: bool) -> Result<(f32, i64), Missing> {
    macro_rules! read {
        ($type:ty) => {{
            let (&value, rest) = bytes.split_first_chunk().ok_or(Missing::End)?;
            *bytes = rest;
            let value = if big { <$type>::from_be_bytes(value) } else { <$type>::from_le_bytes(value) };
            (value as f32, value as i64)
        }};
    }
    Ok(match scalar {
        Scalar::I8 => read!(i8),
        Scalar::U8 => read!(u8),
        Scalar::I16 => read!(i16),
        Scalar::U16 => read!(u16),
        Scalar::I32 => read!(i32),
        Scalar::U32 => read!(u32),
        Scalar::I64 => read!(i64),
        Scalar::U64 => read!(u64),
        Scalar::F16 => {
            let (&value, rest) = bytes.split_first_chunk().ok_or(Missing::End)?;
            *bytes = rest;
            let value = if big { u16::from_be_bytes(value) } else { u16::from_le_bytes(value) };
            let value = half_to_f32(value);
            (value, value as i64)
        }
        Scalar::F32 => read!(f32),
        Scalar::F64 => read!(f64),
    })
}
