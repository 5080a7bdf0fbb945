//! Vertices and faces of a large file. Those of binary files that have no lists, beside the one of the corners, are read from known
//! places; all others value by value.

use crate::ply::body::{COLOR, SLOTS, Slots, cut, skip_property, store};
use crate::ply::header::{Element, Encoding, Kind, Scalar};
use crate::ply::places::{List, Run};
use crate::ply::stream::Stream;
use crate::ply::values::{Missing, Values};
use std::ops::Range;

/// Values by their slots, as [`store`] has them.
pub(super) type Item = [f32; SLOTS];

/// The colour among the values of an item.
pub(super) fn color(item: &Item) -> [f32; 3] {
    let [.., r, g, b, _, _] = *item;
    [r, g, b]
}

/// Slots of a colour, if it is wanted.
fn colors(is_wanted: bool) -> Range<usize> {
    if is_wanted { COLOR..COLOR + 3 } else { 0..0 }
}

/// The items of an element: values by their slots, positions in double precision.
pub(super) struct Items<'a> {
    element: &'a Element,
    encoding: Encoding,
    slots: Slots,
}

impl<'a> Items<'a> {
    pub(super) fn new(element: &'a Element, encoding: Encoding) -> Self {
        Self { element, encoding, slots: Slots::new(element) }
    }

    pub(super) fn has_colors(&self) -> bool {
        self.slots.has(COLOR..COLOR + 3)
    }

    /// True where the values of a colour are fractions.
    pub(super) fn has_fractions(&self) -> bool {
        let is_fraction = |slot: &(usize, Scalar)| (COLOR..COLOR + 3).contains(&slot.0) && slot.1.is_float();
        self.slots.0.iter().flatten().any(is_fraction)
    }

    /// Calls `take` with the position of each vertex, and its colour if that is wanted. Returns the reason if there are fewer than the
    /// header says.
    pub(super) fn each_vertex(
        &self,
        with_colors: bool,
        stream: &mut Stream<'_>,
        mut take: impl FnMut([f64; 3], &Item),
    ) -> std::io::Result<Option<String>> {
        let count = self.element.count;
        let run = |wanted| Run::new(self.element, self.encoding, 0..self.slots.0.len(), &self.slots, wanted);
        let (read, missing) = match (run(0..3), run(colors(with_colors))) {
            (Some(positions), Some(colors)) => stream.each_in_bytes(count, |bytes| {
                let mut item = [0.0; SLOTS];
                let (bytes, _) = colors.split(bytes)?;
                colors.read(bytes, &mut item)?;
                take(positions.position(bytes)?, &item);
                Ok(bytes.len())
            })?,
            _ => stream.each(count, |values| {
                let (position, item) = self.vertex(values)?;
                take(position, &item);
                Ok(())
            })?,
        };
        Ok(missing.map(|missing| cut(self.element, read, missing)))
    }

    /// Calls `take` with the corners of each face, and its colour if that is wanted; `at` is the property of the corners. Returns the
    /// reason if there are fewer than the header says.
    pub(super) fn each_face(
        &self,
        at: usize,
        with_colors: bool,
        stream: &mut Stream<'_>,
        mut take: impl FnMut(&[i64], &Item),
    ) -> std::io::Result<Option<String>> {
        let mut corners = Vec::new();
        let count = self.element.count;
        let list = List::new(self.element, self.encoding, at, &self.slots, colors(with_colors));
        let (read, missing) = match list {
            Some(list) => stream.each_in_bytes(count, |bytes| {
                let mut item = [0.0; SLOTS];
                let size = list.read(bytes, &mut corners, &mut item)?;
                take(&corners, &item);
                Ok(size)
            })?,
            None => stream.each(count, |values| {
                let item = self.face(at, values, &mut corners)?;
                take(&corners, &item);
                Ok(())
            })?,
        };
        Ok(missing.map(|missing| cut(self.element, read, missing)))
    }

    fn vertex(&self, values: &mut Values<'_>) -> Result<([f64; 3], Item), Missing> {
        let (mut position, mut item) = ([f64::NAN; 3], [0.0; SLOTS]);
        for (property, &slot) in self.element.properties.iter().zip(&self.slots.0) {
            match (property.kind, slot) {
                (Kind::One(scalar), Some((slot @ 0..3, _))) => {
                    let value = values.double(scalar)?;
                    position.iter_mut().skip(slot).take(1).for_each(|v| *v = value);
                }
                (Kind::One(scalar), slot) => store(&mut item, slot, values.number(scalar)?),
                (list, _) => skip_property(list, values)?,
            }
        }
        Ok((position, item))
    }

    /// The corners of a face, and its other values.
    fn face(&self, at: usize, values: &mut Values<'_>, corners: &mut Vec<i64>) -> Result<Item, Missing> {
        let mut item = [0.0; SLOTS];
        corners.clear();
        for (k, (property, &slot)) in self.element.properties.iter().zip(&self.slots.0).enumerate() {
            match property.kind {
                Kind::One(scalar) => store(&mut item, slot, values.number(scalar)?),
                Kind::List(count, scalar) if k == at => {
                    for _ in 0..values.integer(count)? {
                        corners.push(values.integer(scalar)?);
                    }
                }
                list => skip_property(list, values)?,
            }
        }
        Ok(item)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ply::header::Property;
    use proptest::collection::vec;
    use proptest::prelude::*;
    use std::io::Cursor;

    const SCALARS: [Scalar; 11] = [
        Scalar::I8,
        Scalar::U8,
        Scalar::I16,
        Scalar::U16,
        Scalar::I32,
        Scalar::U32,
        Scalar::I64,
        Scalar::U64,
        Scalar::F16,
        Scalar::F32,
        Scalar::F64,
    ];
    const NAMES: [&str; 9] = ["x", "y", "z", "red", "green", "blue", "alpha", "nx", "quality"];

    fn property(name: &str, kind: Kind) -> Property {
        Property { name: name.to_owned(), kind }
    }

    /// Values of some of these names and types.
    fn values() -> impl Strategy<Value = Vec<Property>> {
        let value = (0..NAMES.len(), 0..SCALARS.len())
            .prop_map(|(name, scalar)| property(NAMES[name], Kind::One(SCALARS[scalar])));
        vec(value, 0..7)
    }

    /// Bits of the positions and colours, as the public function has them or as they come value by value.
    fn vertices(items: &Items<'_>, bytes: &[u8], one_by_one: bool) -> (Vec<[u64; 6]>, Option<String>) {
        let mut source = Cursor::new(bytes);
        let mut stream = Stream::new(&mut source, 0, items.encoding).unwrap();
        let mut all = Vec::new();
        let mut take = |[x, y, z]: [f64; 3], item: &Item| {
            let [r, g, b] = color(item).map(|v| u64::from(v.to_bits()));
            all.push([x.to_bits(), y.to_bits(), z.to_bits(), r, g, b]);
        };
        let cut = if one_by_one {
            let read = |values: &mut Values<'_>| {
                let (position, item) = items.vertex(values)?;
                take(position, &item);
                Ok(())
            };
            let (number, missing) = stream.each(items.element.count, read).unwrap();
            missing.map(|missing| cut(items.element, number, missing))
        } else {
            items.each_vertex(true, &mut stream, take).unwrap()
        };
        (all, cut)
    }

    /// Corners, and bits of a colour.
    type Face = (Vec<i64>, [u32; 3]);

    /// Faces, likewise.
    fn faces(items: &Items<'_>, at: usize, bytes: &[u8], one_by_one: bool) -> (Vec<Face>, Option<String>) {
        let mut source = Cursor::new(bytes);
        let mut stream = Stream::new(&mut source, 0, items.encoding).unwrap();
        let mut all = Vec::new();
        let mut take = |corners: &[i64], item: &Item| {
            all.push((corners.to_vec(), color(item).map(f32::to_bits)));
        };
        let cut = if one_by_one {
            let mut corners = Vec::new();
            let read = |values: &mut Values<'_>| {
                let item = items.face(at, values, &mut corners)?;
                take(&corners, &item);
                Ok(())
            };
            let (number, missing) = stream.each(items.element.count, read).unwrap();
            missing.map(|missing| cut(items.element, number, missing))
        } else {
            items.each_face(at, true, &mut stream, take).unwrap()
        };
        (all, cut)
    }

    fn element(properties: Vec<Property>, count: u64) -> Element {
        Element { by_line: false, name: "item".to_owned(), count, properties }
    }

    fn order(is_big: bool) -> Encoding {
        if is_big { Encoding::BigEndian } else { Encoding::LittleEndian }
    }

    proptest! {
        #[test]
        fn vertices_at_known_places_are_those_read_one_by_one(
            properties in values(), is_big: bool, count in 0_u64..20, bytes in vec(any::<u8>(), 0..400)
        ) {
            prop_assume!(!properties.is_empty());
            let element = element(properties, count);
            let items = Items::new(&element, order(is_big));
            prop_assert_eq!(vertices(&items, &bytes, false), vertices(&items, &bytes, true));
        }

        /// Counts of whatever comes, less than nothing included.
        #[test]
        fn faces_at_known_places_are_those_read_one_by_one(
            before in values(), behind in values(), types in (0..8_usize, 0..8_usize), is_big: bool, count in 0_u64..40,
            bytes in vec(prop_oneof![0..5_u8, any::<u8>()], 0..400)
        ) {
            let (at, list) = (before.len(), Kind::List(SCALARS[types.0], SCALARS[types.1]));
            let element = element([before, vec![property("vertex_index", list)], behind].concat(), count);
            let items = Items::new(&element, order(is_big));
            prop_assert_eq!(faces(&items, at, &bytes, false), faces(&items, at, &bytes, true));
        }
    }

    #[test]
    fn items_may_go_on_in_the_next_part() {
        let bytes: Vec<u8> =
            (0..2_500_000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        for is_big in [false, true] {
            let xyz = ["x", "y", "z", "red"].map(|name| property(name, Kind::One(Scalar::F32)));
            let vertex = element([&xyz[..], &[property("flag", Kind::One(Scalar::U8))]].concat(), 1 << 40);
            let items = Items::new(&vertex, order(is_big));
            let (all, cut) = vertices(&items, &bytes, false);
            assert_eq!((all.len(), cut.is_some()), (bytes.len() / 17, true));
            assert!((all, cut) == vertices(&items, &bytes, true));
            for corner in [Scalar::U8, Scalar::U16, Scalar::I32, Scalar::U32] {
                let list = property("vertex_index", Kind::List(Scalar::U8, corner));
                let face = element(vec![list, property("red", Kind::One(Scalar::U16))], 1 << 40);
                let items = Items::new(&face, order(is_big));
                let (all, cut) = faces(&items, 0, &bytes, false);
                assert!(all.len() > 4000 && cut.is_some());
                assert!((all, cut) == faces(&items, 0, &bytes, true));
            }
        }
    }
}
