//! Places, directions, extents.

use super::Kind;
use super::numbers::{query_vector, write_double, write_float};
use crate::value::Value;
use serde_json::{Value as Json, json};
use std::str::FromStr;

/// Three values with commas between them, each of which passes.
fn three<T: FromStr>(text: &str, passes: impl Fn(&T) -> bool) -> Result<[T; 3], String> {
    let parts: Vec<T> = text
        .split(',')
        .map(|t| t.trim().parse::<T>().ok().filter(&passes))
        .collect::<Option<_>>()
        .unwrap_or_default();
    <[T; 3]>::try_from(parts).map_err(|_| "expected three numbers x,y,z".to_owned())
}

/// `x,y,z`, each of them finite.
pub(super) fn vector(text: &str) -> Result<[f32; 3], String> {
    three(text, |v: &f32| v.is_finite())
}

/// A place, `x,y,z`: of double precision, for models far from zero.
///
/// # Errors
/// A message that names the expected form.
pub fn position(text: &str) -> Result<[f64; 3], String> {
    three(text, |v: &f64| v.abs() <= f64::from(f32::MAX))
}

/// Numbers of double precision within the range of single precision.
fn doubles<const N: usize>(value: &Value<'_>, names: &str) -> Result<[f64; N], String> {
    let wrong = || value.expected(format_args!("a list of {N} numbers, {names}"));
    let list = value.node.list().ok_or_else(wrong)?;
    let numbers: Vec<f64> = list
        .iter()
        .map(|node| node.number().filter(|v| (*v as f32).is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(wrong)?;
    <[f64; N]>::try_from(numbers).map_err(|_| wrong())
}

/// A list of `N` numbers of single precision.
pub(super) fn read_floats<const N: usize>(value: &Value<'_>, names: &str) -> Result<[f32; N], String> {
    doubles(value, names).map(|numbers| numbers.map(|v| v as f32))
}

/// A list of numbers.
pub(super) fn write_floats(list: &[f32]) -> Result<Json, String> {
    list.iter().copied().map(write_float).collect()
}

/// Schema of a list of numbers.
pub(super) fn list_schema(count: usize) -> Json {
    json!({"type": "array", "items": {"type": "number"}, "minItems": count, "maxItems": count})
}

/// A place or direction of single precision.
pub(crate) struct Vector;

impl Kind for Vector {
    type Value = [f32; 3];

    fn parse(&self, text: &str) -> Result<[f32; 3], String> {
        vector(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<[f32; 3], String> {
        read_floats(value, "x, y and z")
    }

    fn write(&self, value: &[f32; 3]) -> Result<Json, String> {
        write_floats(value)
    }

    fn schema(&self) -> Json {
        list_schema(3)
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        query_vector(text)
    }
}

/// `x,y,z` of any length but zero.
pub(crate) struct Direction;

impl Kind for Direction {
    type Value = [f32; 3];

    fn parse(&self, text: &str) -> Result<[f32; 3], String> {
        let given = vector(text).ok().filter(|v| *v != [0.0; 3]);
        given.ok_or_else(|| "expected a direction x,y,z other than 0,0,0".to_owned())
    }

    /// A direction of length zero is refused with the camera or light that it belongs to.
    fn read(&self, value: &Value<'_>) -> Result<[f32; 3], String> {
        Vector.read(value)
    }

    fn write(&self, value: &[f32; 3]) -> Result<Json, String> {
        Vector.write(value)
    }

    fn schema(&self) -> Json {
        Vector.schema()
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        query_vector(text)
    }
}

/// A place of double precision, for models far from zero.
pub(crate) struct Position;

impl Kind for Position {
    type Value = [f64; 3];

    fn parse(&self, text: &str) -> Result<[f64; 3], String> {
        position(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<[f64; 3], String> {
        doubles(value, "x, y and z")
    }

    fn write(&self, value: &[f64; 3]) -> Result<Json, String> {
        value.iter().copied().map(write_double).collect()
    }

    fn schema(&self) -> Json {
        list_schema(3)
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        query_vector(text)
    }
}

/// Width and height of a rectangle.
pub(crate) struct Extent;

impl Kind for Extent {
    type Value = [f32; 2];

    fn parse(&self, text: &str) -> Result<[f32; 2], String> {
        let sides = text.split_once(['x', ',']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        sides.ok_or_else(|| "expected width and height".to_owned())
    }

    fn read(&self, value: &Value<'_>) -> Result<[f32; 2], String> {
        read_floats(value, "width and height")
    }

    fn write(&self, value: &[f32; 2]) -> Result<Json, String> {
        write_floats(value)
    }

    fn schema(&self) -> Json {
        list_schema(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors() {
        assert_eq!(vector("-1, 2.5,3e2"), Ok([-1.0, 2.5, 300.0]));
        for bad in ["", "1,2", "1,2,3,4", "nan,0,0", "inf,0,0", "a,b,c"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
        assert_eq!(Direction.parse("0,-1,0"), Ok([0.0, -1.0, 0.0]));
        assert!(Direction.parse("0,-0,0").is_err());
    }
}
