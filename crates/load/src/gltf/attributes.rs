//! Vertex attributes of a primitive, or of one of its morph targets.

use super::list::Index;
use super::splats;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// Accessors by the names of what they hold, of a primitive or of one of its morph targets.
#[derive(Clone, Debug, Default)]
pub(super) struct Attributes {
    pub position: Option<Index>,
    pub normal: Option<Index>,
    pub tangent: Option<Index>,
    pub uv0: Option<Index>,
    pub uv1: Option<Index>,
    /// TEXCOORD_n from 2 on, with their numbers, in ascending order.
    pub uvs: Vec<(u32, Index)>,
    pub color: Option<Index>,
    /// JOINTS_n with their numbers, in ascending order.
    pub joints: Vec<(u32, Index)>,
    /// WEIGHTS_n with their numbers, in ascending order.
    pub weights: Vec<(u32, Index)>,
    /// Attributes of KHR_gaussian_splatting, if there are any.
    pub splats: Option<Box<splats::Attributes>>,
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Attributes;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of attributes")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Attributes, A::Error> {
                let mut out = Attributes::default();
                while let Some(key) = map.next_key::<Cow<'de, str>>()? {
                    let numbered =
                        |prefix: &str| key.strip_prefix(prefix).and_then(|n| n.parse::<u32>().ok());
                    let place = match key.as_ref() {
                        "POSITION" => &mut out.position,
                        "NORMAL" => &mut out.normal,
                        "TANGENT" => &mut out.tangent,
                        "TEXCOORD_0" => &mut out.uv0,
                        "TEXCOORD_1" => &mut out.uv1,
                        "COLOR_0" => &mut out.color,
                        _ => {
                            if let Some(name) = key.strip_prefix(splats::PREFIX) {
                                if let Some(index) = map.next_value::<Option<Index>>()? {
                                    out.splats.get_or_insert_default().set(name, index);
                                }
                                continue;
                            }
                            let sets = ["JOINTS_", "WEIGHTS_", "TEXCOORD_"].map(numbered);
                            let (list, number) = match sets {
                                [Some(number), ..] => (&mut out.joints, number),
                                [_, Some(number), _] => (&mut out.weights, number),
                                [.., Some(number)] => (&mut out.uvs, number),
                                _ => {
                                    map.next_value::<IgnoredAny>()?;
                                    continue;
                                }
                            };
                            list.extend(map.next_value::<Option<Index>>()?.map(|index| (number, index)));
                            continue;
                        }
                    };
                    *place = map.next_value()?;
                }
                for list in [&mut out.joints, &mut out.weights, &mut out.uvs] {
                    list.sort_unstable();
                    list.dedup_by_key(|(number, _)| *number);
                }
                Ok(out)
            }
        }
        deserializer.deserialize_map(V)
    }
}

impl Attributes {
    /// By the name that the specification gives them.
    pub(super) fn named(&self, name: &str) -> Option<Index> {
        match name {
            "POSITION" => self.position,
            "NORMAL" => self.normal,
            "TANGENT" => self.tangent,
            "COLOR_0" => self.color,
            _ => name.strip_prefix("TEXCOORD_").and_then(|set| self.uv(set.parse().ok()?)),
        }
    }

    /// Texture coordinates by their number.
    pub(super) fn uv(&self, set: u32) -> Option<Index> {
        match set {
            0 => self.uv0,
            1 => self.uv1,
            _ => self.uvs.iter().find(|(number, _)| *number == set).map(|(_, index)| *index),
        }
    }

    /// Joints and weights of a primitive (`self`), and what its Draco data calls them.
    pub(super) fn influences_in<'a>(
        &'a self,
        compressed: &'a Self,
    ) -> impl Iterator<Item = (Index, Index)> + 'a {
        let pairs = |own: &'a [(u32, Index)], other: &'a [(u32, Index)]| {
            own.iter().filter_map(move |&(set, accessor)| {
                Some((accessor, other.iter().find(|&&(number, _)| number == set)?.1))
            })
        };
        pairs(&self.joints, &compressed.joints).chain(pairs(&self.weights, &compressed.weights))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_by_name_and_number() {
        let text = r#"{"POSITION": 4, "_ID": {"a": [1]}, "JOINTS_1": 2, "JOINTS_0": 1, "WEIGHTS_0": 3.0, "JOINTS_x": 9,
            "TEXCOORD_7": 5, "NORMAL": null, "JOINTS_1": 8}"#;
        let found: Attributes = serde_json::from_str(text).unwrap();
        assert_eq!(found.position, Some(Index(4)));
        assert_eq!((found.normal, found.uv0), (None, None));
        assert_eq!(found.joints, [(0, Index(1)), (1, Index(2))]);
        assert_eq!(found.weights, [(0, Index(3))]);
        assert_eq!(
            (found.uv(7), found.named("TEXCOORD_7"), found.uv(2)),
            (Some(Index(5)), Some(Index(5)), None)
        );
        serde_json::from_str::<Attributes>(r#"{"JOINTS_0": -1}"#).unwrap_err();
        serde_json::from_str::<Attributes>("[]").unwrap_err();
    }
}
