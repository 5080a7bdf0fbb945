//! Lists of the document whose elements are named in messages, and the numbers that say which of them is meant.

use super::FORMAT;
use crate::LoadError;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Unexpected, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// A whole number of at least 0. Some exporters write `24.0`, which JSON does not tell from `24`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Uint(pub u64);

impl<'de> Deserialize<'de> for Uint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct V;
        impl Visitor<'_> for V {
            type Value = Uint;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number of at least 0")
            }
            fn visit_u64<E: Error>(self, v: u64) -> Result<Uint, E> {
                Ok(Uint(v))
            }
            fn visit_i64<E: Error>(self, v: i64) -> Result<Uint, E> {
                u64::try_from(v).map(Uint).map_err(|_| E::invalid_value(Unexpected::Signed(v), &self))
            }
            fn visit_f64<E: Error>(self, v: f64) -> Result<Uint, E> {
                // Whole numbers up to 2^53 have an exact double.
                if (0.0..9_007_199_254_740_992.0).contains(&v) && v.floor() == v {
                    Ok(Uint(v as u64))
                } else {
                    Err(E::invalid_value(Unexpected::Float(v), &self))
                }
            }
        }
        deserializer.deserialize_any(V)
    }
}

/// The number of an element in one of the lists. Numbers beyond 32 bits are no element's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Index(pub u32);

impl Index {
    pub(super) fn get(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for Index {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Uint(v) = Uint::deserialize(deserializer)?;
        u32::try_from(v).map(Self).map_err(|_| {
            D::Error::invalid_value(Unexpected::Unsigned(v), &"the number of an element, below 2^32")
        })
    }
}

/// An element of a list, named in messages.
pub(super) trait Element {
    /// Name of this kind of element in messages.
    const KIND: &'static str;

    /// Name that the file gives this element.
    fn name(&self) -> Option<&str> {
        None
    }
}

/// A list whose parse errors name the element.
#[derive(Clone, Debug)]
pub(super) struct List<T>(pub Vec<T>);

impl<T> Default for List<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> std::ops::Deref for List<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T: Element> List<T> {
    /// The element with this number.
    ///
    /// # Errors
    /// [`LoadError::Malformed`] if there is none.
    pub(super) fn at(&self, index: usize) -> Result<&T, LoadError> {
        let missing = || LoadError::malformed(FORMAT, format!("there is no {} {index}", T::KIND));
        self.0.get(index).ok_or_else(missing)
    }

    /// The element with this number in messages.
    pub(super) fn label(&self, index: usize) -> String {
        label::<T>(index, self.0.get(index).and_then(T::name))
    }
}

impl<'de, T: Deserialize<'de> + Element> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct V<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + Element> Visitor<'de> for V<T> {
            type Value = List<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list with elements of the kind {}", T::KIND)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<List<T>, A::Error> {
                let mut list = Vec::new();
                loop {
                    match seq.next_element() {
                        Ok(Some(element)) => list.push(element),
                        Ok(None) => return Ok(List(list)),
                        Err(e) => {
                            return Err(A::Error::custom(format_args!("{} {}: {e}", T::KIND, list.len())));
                        }
                    }
                }
            }
        }
        deserializer.deserialize_seq(V(PhantomData))
    }
}

/// `element 3 'name'`, with the name cut short and made fit for one line.
pub(super) fn label<T: Element>(index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => {
            let mut short: String =
                name.chars().take(48).map(|c| if c.is_control() { '?' } else { c }).collect();
            if short.len() < name.len() {
                short.push_str("...");
            }
            format!("{} {index} '{short}'", T::KIND)
        }
        _ => format!("{} {index}", T::KIND),
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::{Mesh, Root};
    use super::*;

    #[test]
    fn errors_in_lists_name_the_element() {
        let e = serde_json::from_str::<Root>(r#"{"accessors":[{},{"byteOffset":-4}]}"#).unwrap_err();
        assert_eq!(
            e.to_string(),
            "accessor 1: invalid value: integer `-4`, expected a whole number of at least 0 at line 1 column 33"
        );
    }

    #[test]
    fn whole_numbers_may_have_a_decimal_point() {
        assert_eq!(serde_json::from_str::<Uint>("24.0").unwrap(), Uint(24));
        serde_json::from_str::<Uint>("24.5").unwrap_err();
        serde_json::from_str::<Uint>("-1.0").unwrap_err();
        serde_json::from_str::<Uint>("1e300").unwrap_err();
    }

    #[test]
    fn labels_fit_on_one_line() {
        assert_eq!(label::<Mesh>(2, Some("a\nb")), "mesh 2 'a?b'");
        assert_eq!(label::<Mesh>(2, None), "mesh 2");
        assert!(label::<Mesh>(2, Some(&"x".repeat(10_000))).len() < 80);
        let root: Root = serde_json::from_str(r#"{"meshes":[{"name":"a"},{}]}"#).unwrap();
        assert_eq!([0, 1, 2].map(|k| root.meshes.label(k)), ["mesh 0 'a'", "mesh 1", "mesh 2"]);
        assert!(root.meshes.at(2).unwrap_err().to_string().contains("there is no mesh 2"));
    }
}
