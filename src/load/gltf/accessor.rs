//! Typed arrays: accessors, with quantisation, interleaving, sparse replacement and zero filling.
//!
//! Everything is checked once when an accessor is resolved; the copy loops then cannot fail.

use super::FORMAT;
use super::buffers::{Buffers, slice};
use super::model::{Accessor, Index, Kind, Root};
use crate::load::budget::Budget;
use crate::load::{Context, LoadError};
use std::ops::Range;

/// Which elements are read.
#[derive(Clone, Debug)]
pub(super) enum Pick {
    /// A run of them.
    Range(Range<usize>),
    /// Single ones, in ascending order.
    List(Vec<u32>),
}

impl Pick {
    /// How many.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Range(range) => range.len(),
            Self::List(list) => list.len(),
        }
    }
    /// The place in the picked order of element `index`.
    fn place(&self, index: usize) -> Option<usize> {
        match self {
            Self::Range(range) => range.contains(&index).then(|| index - range.start),
            Self::List(list) => u32::try_from(index).ok().and_then(|index| list.binary_search(&index).ok()),
        }
    }
}

/// Storage of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Elements at a fixed distance. `bytes` holds them all.
#[derive(Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that replace others.
struct Replacement<'a> {
    indices: Vec<u32>,
    values: Strided<'a>,
}

/// An accessor whose bytes have been found and whose bounds have been checked.
pub(super) struct Elements<'a> {
    /// Number of elements.
    pub count: usize,
    /// Shape of an element.
    pub kind: Kind,
    /// Storage of its numbers.
    pub component: Component,
    /// Integers stand for 0 to 1 or -1 to 1.
    pub normalized: bool,
    /// `None`: zeros.
    base: Option<Strided<'a>>,
    sparse: Option<Replacement<'a>>,
}

/// Reads the buffers that an accessor needs. Serial, before [`resolve`].
///
/// # Errors
/// [`LoadError`] naming the accessor, the view or the buffer.
pub(super) fn require(
    root: &Root,
    index: Index,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<(), LoadError> {
    let accessor = get(root, index)?;
    let sparse = accessor.sparse.as_deref();
    let views = [
        accessor.buffer_view,
        sparse.and_then(|s| s.indices.buffer_view),
        sparse.and_then(|s| s.values.buffer_view),
    ];
    for view in views.into_iter().flatten() {
        buffers.require(view, context, budget)?;
    }
    Ok(())
}

/// The accessor with this number.
///
/// # Errors
/// [`LoadError::Malformed`] if there is none.
pub(super) fn get(root: &Root, index: Index) -> Result<&Accessor, LoadError> {
    root.accessors
        .get(index.get())
        .ok_or_else(|| LoadError::malformed(FORMAT, format!("there is no accessor {index}")))
}

/// Finds the bytes of an accessor and checks that every element lies inside them.
///
/// # Errors
/// [`LoadError::Malformed`] naming the accessor.
pub(super) fn resolve<'a>(
    root: &Root,
    buffers: &'a Buffers<'_>,
    index: Index,
) -> Result<Elements<'a>, LoadError> {
    let accessor = get(root, index)?;
    let malformed = |message: String| LoadError::malformed(FORMAT, format!("accessor {index}: {message}"));
    let component = Component::new(accessor.component_type.0)
        .ok_or_else(|| malformed(format!("unknown componentType {}", accessor.component_type.0)))?;
    let count = usize::try_from(accessor.count.0)
        .ok()
        .filter(|&count| u32::try_from(count).is_ok())
        .ok_or_else(|| malformed(format!("a count of {}", accessor.count.0)))?;
    let element = accessor.kind.components() * component.size();
    if element == 0 {
        return Err(malformed("neither scalars nor vectors".to_owned()));
    }
    let strided =
        |view: Option<Index>, offset: u64, count: usize, size: usize, declared: bool, part: &str| {
            let Some(view) = view else { return Ok(None) };
            let bytes = buffers.view(view)?;
            let stride = match root.buffer_views[view.get()].byte_stride {
                Some(stride) if declared && stride.0 != 0 => stride.0,
                _ => size as u64,
            };
            if stride < size as u64 {
                return Err(malformed(format!(
                    "byteStride {stride} of bufferView {view} is less than the {size} bytes of an element"
                )));
            }
            if count == 0 {
                return Ok(Some(Strided { bytes: &[], stride: size }));
            }
            // The last element need not fill its stride.
            let length = (count as u64 - 1).saturating_mul(stride).saturating_add(size as u64);
            match slice(bytes, offset, length) {
                Some(bytes) => Ok(Some(Strided { bytes, stride: usize::try_from(stride).unwrap_or(size) })),
                None => Err(malformed(format!(
                    "{count} {part} from byte {offset} lie outside bufferView {view} of {} bytes",
                    bytes.len()
                ))),
            }
        };
    let base = strided(accessor.buffer_view, accessor.byte_offset.0, count, element, true, "elements")?;
    let sparse = match accessor.sparse.as_deref() {
        None => None,
        Some(sparse) => {
            if sparse.count.0 > accessor.count.0 {
                return Err(malformed(format!("{} sparse elements of {count}", sparse.count.0)));
            }
            let replaced = sparse.count.0 as usize;
            let code = sparse.indices.component_type.0;
            let index_type = Component::new(code)
                .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
                .ok_or_else(|| malformed(format!("componentType {code} for sparse indices")))?;
            let at = (sparse.indices.buffer_view, sparse.indices.byte_offset.0);
            let indices = strided(at.0, at.1, replaced, index_type.size(), false, "sparse indices")?
                .ok_or_else(|| malformed("its sparse indices have no bufferView".to_owned()))?;
            let at = (sparse.values.buffer_view, sparse.values.byte_offset.0);
            let values = strided(at.0, at.1, replaced, element, false, "sparse values")?
                .ok_or_else(|| malformed("its sparse values have no bufferView".to_owned()))?;
            let mut list = vec![0u32; replaced];
            read_integers(index_type, indices, 0, &mut list);
            if let Some(outside) = list.iter().find(|&&k| k as usize >= count) {
                return Err(malformed(format!("sparse index {outside} of {count} elements")));
            }
            Some(Replacement { indices: list, values })
        }
    };
    Ok(Elements { count, kind: accessor.kind, component, normalized: accessor.normalized, base, sparse })
}

impl Elements<'_> {
    /// Picked elements as floats. `N` must be the number of components.
    pub(super) fn floats<const N: usize>(&self, pick: &Pick) -> Vec<[f32; N]> {
        debug_assert_eq!(N, self.kind.components());
        let mut out = vec![[0.0; N]; pick.len()];
        if let Some(base) = self.base {
            match pick {
                Pick::Range(range) => self.read(base, range.start, &mut out),
                Pick::List(list) => {
                    for (out, &k) in out.iter_mut().zip(list) {
                        self.read(base, k as usize, std::slice::from_mut(out));
                    }
                }
            }
        }
        if let Some(sparse) = &self.sparse {
            for (k, &index) in sparse.indices.iter().enumerate() {
                if let Some(place) = pick.place(index as usize) {
                    self.read(sparse.values, k, &mut out[place..=place]);
                }
            }
        }
        out
    }

    /// All elements as integers, for indices: `out` has at most as many numbers as there are elements.
    pub(super) fn integers(&self, out: &mut [u32]) {
        debug_assert_eq!(self.kind, Kind::Scalar);
        if let Some(base) = self.base {
            read_integers(self.component, base, 0, out);
        }
        if let Some(sparse) = &self.sparse {
            for (k, &index) in sparse.indices.iter().enumerate() {
                if let Some(out) = out.get_mut(index as usize) {
                    read_integers(self.component, sparse.values, k, std::slice::from_mut(out));
                }
            }
        }
    }

    /// Consecutive elements from number `first`.
    fn read<const N: usize>(&self, from: Strided<'_>, first: usize, out: &mut [[f32; N]]) {
        let bytes = from.bytes.get(first * from.stride..).unwrap_or(&[]);
        let stride = from.stride;
        match (self.component, self.normalized) {
            (Component::F32, _) if stride == 4 * N && cfg!(target_endian = "little") => {
                let out: &mut [u8] = bytemuck::cast_slice_mut(out.as_flattened_mut());
                let length = out.len().min(bytes.len());
                out[..length].copy_from_slice(&bytes[..length]);
            }
            (Component::F32, _) => copy(bytes, stride, out, f32::from_le_bytes),
            (Component::U8, false) => copy(bytes, stride, out, |[b]: [u8; 1]| f32::from(b)),
            (Component::U8, true) => copy(bytes, stride, out, |[b]: [u8; 1]| f32::from(b) / 255.0),
            (Component::I8, false) => copy(bytes, stride, out, |b| f32::from(i8::from_le_bytes(b))),
            (Component::I8, true) => copy(bytes, stride, out, |b| signed(i8::from_le_bytes(b).into(), 127.0)),
            (Component::U16, false) => copy(bytes, stride, out, |b| f32::from(u16::from_le_bytes(b))),
            (Component::U16, true) => {
                copy(bytes, stride, out, |b| f32::from(u16::from_le_bytes(b)) / 65535.0)
            }
            (Component::I16, false) => copy(bytes, stride, out, |b| f32::from(i16::from_le_bytes(b))),
            (Component::I16, true) => {
                copy(bytes, stride, out, |b| signed(i16::from_le_bytes(b).into(), 32767.0));
            }
            (Component::U32, _) => copy(bytes, stride, out, |b| u32::from_le_bytes(b) as f32),
        }
    }
}

/// The most negative integer stands for -1 too.
fn signed(value: f32, scale: f32) -> f32 {
    let v = value / scale;
    if v < -1.0 { -1.0 } else { v }
}

fn copy<const N: usize, const S: usize>(
    bytes: &[u8],
    stride: usize,
    out: &mut [[f32; N]],
    convert: impl Fn([u8; S]) -> f32,
) {
    for (out, element) in out.iter_mut().zip(bytes.chunks(stride)) {
        let (numbers, _) = element.as_chunks::<S>();
        for (out, number) in out.iter_mut().zip(numbers) {
            *out = convert(*number);
        }
    }
}

fn read_integers(component: Component, from: Strided<'_>, first: usize, out: &mut [u32]) {
    let bytes = from.bytes.get(first * from.stride..).unwrap_or(&[]);
    let stride = from.stride;
    match component {
        Component::U32 if stride == 4 && cfg!(target_endian = "little") => {
            let out: &mut [u8] = bytemuck::cast_slice_mut(out);
            let length = out.len().min(bytes.len());
            out[..length].copy_from_slice(&bytes[..length]);
        }
        Component::U16 if stride == 2 => {
            let (numbers, _) = bytes.as_chunks::<2>();
            for (out, number) in out.iter_mut().zip(numbers) {
                *out = u16::from_le_bytes(*number).into();
            }
        }
        Component::U8 | Component::I8 => {
            for (out, element) in out.iter_mut().zip(bytes.chunks(stride)) {
                *out = element[0].into();
            }
        }
        Component::U16 | Component::I16 => {
            for (out, element) in out.iter_mut().zip(bytes.chunks(stride)) {
                *out = u16::from_le_bytes([element[0], element[1]]).into();
            }
        }
        Component::U32 | Component::F32 => {
            for (out, element) in out.iter_mut().zip(bytes.chunks(stride)) {
                *out = u32::from_le_bytes([element[0], element[1], element[2], element[3]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elements<'a>(
        bytes: &'a [u8],
        stride: usize,
        component: Component,
        normalized: bool,
        kind: Kind,
    ) -> Elements<'a> {
        Elements {
            count: 0,
            kind,
            component,
            normalized,
            base: Some(Strided { bytes, stride }),
            sparse: None,
        }
    }

    /// KHR_mesh_quantization and section 3.6.2.2 of the specification: the ends of every integer range.
    #[test]
    fn integers_become_floats() {
        let all = Pick::Range(0..2);
        let i8s = [127u8, 0x80, 0x81, 1];
        let as_i8 = |n| elements(&i8s, 2, Component::I8, n, Kind::Vec2).floats::<2>(&all);
        assert_eq!(as_i8(true), [[1.0, -1.0], [-1.0, 1.0 / 127.0]]);
        assert_eq!(as_i8(false), [[127.0, -128.0], [-127.0, 1.0]]);
        let as_u8 = |n| elements(&i8s, 2, Component::U8, n, Kind::Vec2).floats::<2>(&all);
        assert_eq!(as_u8(true), [[127.0 / 255.0, 128.0 / 255.0], [129.0 / 255.0, 1.0 / 255.0]]);
        assert_eq!(as_u8(false), [[127.0, 128.0], [129.0, 1.0]]);
        let shorts = [0xff, 0x7f, 0x00, 0x80, 0xff, 0xff, 0x00, 0x00];
        let as_i16 = |n| elements(&shorts, 4, Component::I16, n, Kind::Vec2).floats::<2>(&all);
        assert_eq!(as_i16(true), [[1.0, -1.0], [-1.0 / 32767.0, 0.0]]);
        assert_eq!(as_i16(false), [[32767.0, -32768.0], [-1.0, 0.0]]);
        let as_u16 = |n| elements(&shorts, 4, Component::U16, n, Kind::Vec2).floats::<2>(&all);
        assert_eq!(as_u16(true), [[32767.0 / 65535.0, 32768.0 / 65535.0], [1.0, 0.0]]);
        assert_eq!(as_u16(false), [[32767.0, 32768.0], [65535.0, 0.0]]);
    }

    #[test]
    fn the_fast_path_equals_the_slow_one() {
        let numbers: Vec<[f32; 3]> = (0..50).map(|k| [k as f32, -1.5 * k as f32, 0.1 * k as f32]).collect();
        let tight: Vec<u8> = numbers.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        // The same elements with four bytes between them, at an odd address.
        let mut loose = vec![0u8];
        for element in tight.chunks(12) {
            loose.extend_from_slice(element);
            loose.extend_from_slice(&[9; 4]);
        }
        let tight = elements(&tight, 12, Component::F32, false, Kind::Vec3);
        let loose = elements(&loose[1..loose.len() - 4], 16, Component::F32, false, Kind::Vec3);
        for pick in [Pick::Range(0..50), Pick::Range(7..50), Pick::Range(3..3), Pick::List(vec![0, 4, 49])] {
            let picked = tight.floats::<3>(&pick);
            assert_eq!(picked, loose.floats::<3>(&pick));
            assert_eq!(picked.len(), pick.len());
            for (k, n) in numbers.iter().enumerate() {
                if let Some(place) = pick.place(k) {
                    assert_eq!(picked[place], *n);
                }
            }
        }
    }
}
