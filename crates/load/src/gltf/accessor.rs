//! Typed arrays: accessors, with quantisation, interleaving, sparse replacement and zero filling.
//!
//! Everything is checked once when an accessor is resolved; the copy loops then cannot fail.

use super::FORMAT;
use super::buffers::Buffers;
use super::list::Index;
use super::model::{Accessor, Kind, Root};
use super::source::{Part, Source};
use crate::budget::Budget;
use crate::{Context, LoadError};
use std::borrow::Cow;
use std::num::NonZeroUsize;
use std::ops::Range;

/// Bytes that are read from a file at a time where they cannot be read to where they stay: few enough for the cache,
/// and many for one call.
const PIECE: usize = 1 << 17;

/// Largest gap in bytes between single elements that is read with them, instead of a call for each.
const GAP: usize = 1 << 12;

/// Elements that are read.
#[derive(Clone, Debug)]
pub(super) enum Pick {
    /// A run of them.
    Range(Range<usize>),
    /// Single ones, in ascending order.
    List(Vec<u32>),
}

impl Pick {
    /// Number of picked elements.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Range(range) => range.len(),
            Self::List(list) => list.len(),
        }
    }
    /// The place in the picked order of element `index`.
    fn place(&self, index: usize) -> Option<usize> {
        match self {
            Self::Range(range) => index.checked_sub(range.start).filter(|&place| place < range.len()),
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
    /// Bytes of one number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
    /// Bytes of an element of so many numbers; `None` of one without numbers.
    pub(super) fn element(self, numbers: usize) -> Option<NonZeroUsize> {
        NonZeroUsize::new(self.size().checked_mul(numbers)?)
    }
}

/// Elements at a fixed distance. `bytes` holds them all.
#[derive(Clone, Copy)]
struct Strided<'a> {
    bytes: Source<'a>,
    stride: NonZeroUsize,
}

/// Elements that replace others.
struct Replacement<'a> {
    indices: Vec<u32>,
    values: Cow<'a, [u8]>,
    stride: NonZeroUsize,
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
    root.accessors.at(index.get())
}

/// Finds the bytes of an accessor and checks that every element lies inside them.
///
/// # Errors
/// [`LoadError::Malformed`] naming the accessor; [`LoadError::Io`].
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
    let element = component
        .element(accessor.kind.components())
        .ok_or_else(|| malformed("neither scalars nor vectors".to_owned()))?;
    let strided =
        |view: Option<Index>, offset: u64, count: usize, size: NonZeroUsize, declared: bool, part: &str| {
            let Some(view) = view else { return Ok(None) };
            let bytes = buffers.view(view)?;
            let least = size.get() as u64;
            let stride = match root.buffer_views.at(view.get())?.byte_stride {
                Some(stride) if declared && stride.0 != 0 => stride.0,
                // Compressed data of padded elements stays padded where its view has no stride.
                _ if declared => buffers.compressed_stride(view).unwrap_or(least),
                _ => least,
            };
            if stride < least {
                return Err(malformed(format!(
                    "byteStride {stride} of bufferView {view} is less than the {size} bytes of an element"
                )));
            }
            let Some(others) = (count as u64).checked_sub(1) else {
                return Ok(Some(Strided { bytes: Source::Memory(&[]), stride: size }));
            };
            // The last element need not fill its stride.
            let length = others.saturating_mul(stride).saturating_add(least);
            let stride = usize::try_from(stride).ok().and_then(NonZeroUsize::new).unwrap_or(size);
            match bytes.slice(offset, length) {
                Some(bytes) => Ok(Some(Strided { bytes, stride })),
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
            let (index_type, size) = Component::new(code)
                .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
                .and_then(|c| Some((c, c.element(1)?)))
                .ok_or_else(|| malformed(format!("componentType {code} for sparse indices")))?;
            let at = (sparse.indices.buffer_view, sparse.indices.byte_offset.0);
            let indices = strided(at.0, at.1, replaced, size, false, "sparse indices")?
                .ok_or_else(|| malformed("its sparse indices have no bufferView".to_owned()))?;
            let at = (sparse.values.buffer_view, sparse.values.byte_offset.0);
            let values = strided(at.0, at.1, replaced, element, false, "sparse values")?
                .ok_or_else(|| malformed("its sparse values have no bufferView".to_owned()))?;
            let mut list = vec![0u32; replaced];
            read_integers(index_type, &indices.bytes.bytes()?, indices.stride, &mut list);
            if let Some(outside) = list.iter().find(|&&k| k as usize >= count) {
                return Err(malformed(format!("sparse index {outside} of {count} elements")));
            }
            Some(Replacement { indices: list, values: values.bytes.bytes()?, stride: values.stride })
        }
    };
    Ok(Elements { count, kind: accessor.kind, component, normalized: accessor.normalized, base, sparse })
}

impl<'a> Elements<'a> {
    /// Elements that lie one after the other. `bytes` holds all of them. `None` of a kind that nothing reads.
    pub(super) fn of_array(
        bytes: &'a [u8],
        count: usize,
        kind: Kind,
        component: Component,
        normalized: bool,
    ) -> Option<Self> {
        let stride = component.element(kind.components())?;
        let base = Some(Strided { bytes: Source::Memory(bytes), stride });
        Some(Self { count, kind, component, normalized, base, sparse: None })
    }

    /// Picked elements as floats. `N` must be the number of components.
    ///
    /// # Errors
    /// [`LoadError::Io`].
    pub(super) fn floats<const N: usize>(&self, pick: &Pick) -> Result<Vec<[f32; N]>, LoadError> {
        debug_assert_eq!(N, self.kind.components());
        let mut out = vec![[0.0; N]; pick.len()];
        if let Some(Strided { bytes, stride }) = self.base {
            match (bytes, pick) {
                (Source::Memory(bytes), Pick::Range(range)) => {
                    self.convert(from_element(bytes, range.start, stride), stride, &mut out);
                }
                (Source::Memory(bytes), Pick::List(list)) => {
                    for (out, &k) in out.iter_mut().zip(list) {
                        self.convert(
                            from_element(bytes, k as usize, stride),
                            stride,
                            std::slice::from_mut(out),
                        );
                    }
                }
                (Source::File(part), Pick::Range(range)) => {
                    self.read(&part, range.start, stride, &mut out)?;
                }
                (Source::File(part), Pick::List(list)) => self.read_list(&part, list, stride, &mut out)?,
            }
        }
        if let Some(sparse) = &self.sparse {
            for (k, &index) in sparse.indices.iter().enumerate() {
                if let Some(out) = pick.place(index as usize).and_then(|place| out.get_mut(place)) {
                    let value = from_element(&sparse.values, k, sparse.stride);
                    self.convert(value, sparse.stride, std::slice::from_mut(out));
                }
            }
        }
        Ok(out)
    }

    /// All elements as integers, for indices: `out` has at most as many numbers as there are elements.
    ///
    /// # Errors
    /// [`LoadError::Io`].
    pub(super) fn integers(&self, out: &mut [u32]) -> Result<(), LoadError> {
        debug_assert_eq!(self.kind, Kind::Scalar);
        let component = self.component;
        if let (Some(Strided { bytes, stride }), Some(size)) = (self.base, component.element(1)) {
            match bytes {
                Source::Memory(bytes) => read_integers(component, bytes, stride, out),
                Source::File(part) if is_plain(component == Component::U32, stride, 4) => {
                    part.read(0, bytemuck::cast_slice_mut(out))?;
                }
                Source::File(part) => pieces(&part, 0, stride, size, out, |bytes, out| {
                    read_integers(component, bytes, stride, out);
                })?,
            }
        }
        if let Some(sparse) = &self.sparse {
            for (k, &index) in sparse.indices.iter().enumerate() {
                if let Some(out) = out.get_mut(index as usize) {
                    let value = from_element(&sparse.values, k, sparse.stride);
                    read_integers(component, value, sparse.stride, std::slice::from_mut(out));
                }
            }
        }
        Ok(())
    }

    /// Consecutive elements from number `first` of a file.
    fn read<const N: usize>(
        &self,
        part: &Part<'_>,
        first: usize,
        stride: NonZeroUsize,
        out: &mut [[f32; N]],
    ) -> Result<(), LoadError> {
        if is_plain(self.component == Component::F32, stride, size_of::<[f32; N]>()) {
            return part.read(place(first, stride), bytemuck::cast_slice_mut(out.as_flattened_mut()));
        }
        let Some(size) = self.component.element(N) else { return Ok(()) };
        pieces(part, first, stride, size, out, |bytes, out| self.convert(bytes, stride, out))
    }

    /// Single elements of a file; those that lie close to each other at once.
    fn read_list<const N: usize>(
        &self,
        part: &Part<'_>,
        list: &[u32],
        stride: NonZeroUsize,
        out: &mut [[f32; N]],
    ) -> Result<(), LoadError> {
        let (Some(size), Some(mut first)) = (self.component.element(N), list.first().copied()) else {
            return Ok(());
        };
        let distance = |a: u32, b: u32| (a.abs_diff(b) as usize).saturating_mul(stride.get());
        let end = |first: u32, last: u32| distance(first, last).saturating_add(size.get());
        let runs = list.chunk_by(|&before, &next| {
            let together = distance(before, next) <= GAP && end(first, next) <= PIECE;
            if !together {
                first = next;
            }
            together
        });
        let mut bytes = Vec::new();
        let mut out = out.iter_mut();
        for run in runs {
            let (Some(&first), Some(&last)) = (run.first(), run.last()) else { continue };
            bytes.resize(end(first, last), 0);
            part.read(place(first as usize, stride), &mut bytes)?;
            for (&k, out) in run.iter().zip(out.by_ref()) {
                let element = from_element(&bytes, first.abs_diff(k) as usize, stride);
                self.convert(element, stride, std::slice::from_mut(out));
            }
        }
        Ok(())
    }

    /// Consecutive elements, from the first byte of the first one.
    fn convert<const N: usize>(&self, bytes: &[u8], stride: NonZeroUsize, out: &mut [[f32; N]]) {
        match (self.component, self.normalized) {
            (Component::F32, _) if is_plain(true, stride, size_of::<[f32; N]>()) => {
                copy_bytes(bytes, bytemuck::cast_slice_mut(out.as_flattened_mut()));
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

/// True if elements lie in the file as they do in memory.
fn is_plain(same_type: bool, stride: NonZeroUsize, size: usize) -> bool {
    same_type && stride.get() == size && cfg!(target_endian = "little")
}

/// Byte offset of element number `first` of a file. It saturates on overflow, and thus lies behind the end of every
/// file.
fn place(first: usize, stride: NonZeroUsize) -> u64 {
    (first as u64).saturating_mul(stride.get() as u64)
}

/// The bytes from element number `first` on; none behind the last element.
fn from_element(bytes: &[u8], first: usize, stride: NonZeroUsize) -> &[u8] {
    first.checked_mul(stride.get()).and_then(|start| bytes.get(start..)).unwrap_or(&[])
}

/// Fills `out` with bytes that are as they stay.
fn copy_bytes(bytes: &[u8], out: &mut [u8]) {
    out.iter_mut().zip(bytes).for_each(|(out, byte)| *out = *byte);
}

/// Reads consecutive elements of `size` bytes from number `first` on, some at a time, and has them converted.
fn pieces<T>(
    part: &Part<'_>,
    first: usize,
    stride: NonZeroUsize,
    size: NonZeroUsize,
    out: &mut [T],
    convert: impl Fn(&[u8], &mut [T]),
) -> Result<(), LoadError> {
    let count = (PIECE / stride).max(1);
    let mut bytes = Vec::new();
    let mut start = place(first, stride);
    for out in out.chunks_mut(count) {
        // The last element need not fill its stride.
        let others = out.len().saturating_sub(1).saturating_mul(stride.get());
        bytes.resize(others.saturating_add(size.get()), 0);
        part.read(start, &mut bytes)?;
        convert(&bytes, out);
        start = start.saturating_add(place(out.len(), stride));
    }
    Ok(())
}

/// The most negative integer stands for -1 too.
fn signed(value: f32, scale: f32) -> f32 {
    let v = value / scale;
    if v < -1.0 { -1.0 } else { v }
}

fn copy<const N: usize, const S: usize>(
    bytes: &[u8],
    stride: NonZeroUsize,
    out: &mut [[f32; N]],
    convert: impl Fn([u8; S]) -> f32,
) {
    for (out, element) in out.iter_mut().zip(bytes.chunks(stride.get())) {
        let (numbers, _) = element.as_chunks::<S>();
        for (out, number) in out.iter_mut().zip(numbers) {
            *out = convert(*number);
        }
    }
}

fn read_integers(component: Component, bytes: &[u8], stride: NonZeroUsize, out: &mut [u32]) {
    match component {
        Component::U32 if is_plain(true, stride, 4) => copy_bytes(bytes, bytemuck::cast_slice_mut(out)),
        Component::U16 if stride.get() == 2 => {
            let (numbers, _) = bytes.as_chunks::<2>();
            for (out, number) in out.iter_mut().zip(numbers) {
                *out = u16::from_le_bytes(*number).into();
            }
        }
        Component::U8 | Component::I8 => copy_integers(bytes, stride, out, |[byte]| byte.into()),
        Component::U16 | Component::I16 => {
            copy_integers(bytes, stride, out, |number| u16::from_le_bytes(number).into());
        }
        Component::U32 | Component::F32 => copy_integers(bytes, stride, out, u32::from_le_bytes),
    }
}

fn copy_integers<const S: usize>(
    bytes: &[u8],
    stride: NonZeroUsize,
    out: &mut [u32],
    convert: impl Fn([u8; S]) -> u32,
) {
    for (out, element) in out.iter_mut().zip(bytes.chunks(stride.get())) {
        if let Some(number) = element.first_chunk() {
            *out = convert(*number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strided(bytes: Source<'_>, stride: usize) -> Option<Strided<'_>> {
        Some(Strided { bytes, stride: NonZeroUsize::new(stride)? })
    }

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
            base: strided(Source::Memory(bytes), stride),
            sparse: None,
        }
    }

    /// KHR_mesh_quantization and section 3.6.2.2 of the specification: the ends of every integer range.
    #[test]
    fn integers_become_floats() {
        let all = Pick::Range(0..2);
        let i8s = [127u8, 0x80, 0x81, 1];
        let as_i8 = |n| elements(&i8s, 2, Component::I8, n, Kind::Vec2).floats::<2>(&all).unwrap();
        assert_eq!(as_i8(true), [[1.0, -1.0], [-1.0, 1.0 / 127.0]]);
        assert_eq!(as_i8(false), [[127.0, -128.0], [-127.0, 1.0]]);
        let as_u8 = |n| elements(&i8s, 2, Component::U8, n, Kind::Vec2).floats::<2>(&all).unwrap();
        assert_eq!(as_u8(true), [[127.0 / 255.0, 128.0 / 255.0], [129.0 / 255.0, 1.0 / 255.0]]);
        assert_eq!(as_u8(false), [[127.0, 128.0], [129.0, 1.0]]);
        let shorts = [0xff, 0x7f, 0x00, 0x80, 0xff, 0xff, 0x00, 0x00];
        let as_i16 = |n| elements(&shorts, 4, Component::I16, n, Kind::Vec2).floats::<2>(&all).unwrap();
        assert_eq!(as_i16(true), [[1.0, -1.0], [-1.0 / 32767.0, 0.0]]);
        assert_eq!(as_i16(false), [[32767.0, -32768.0], [-1.0, 0.0]]);
        let as_u16 = |n| elements(&shorts, 4, Component::U16, n, Kind::Vec2).floats::<2>(&all).unwrap();
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
            let picked = tight.floats::<3>(&pick).unwrap();
            assert_eq!(picked, loose.floats::<3>(&pick).unwrap());
            assert_eq!(picked.len(), pick.len());
            for (k, n) in numbers.iter().enumerate() {
                if let Some(place) = pick.place(k) {
                    assert_eq!(picked[place], *n);
                }
            }
        }
    }

    #[test]
    fn a_file_reads_as_memory_does() {
        use crate::gltf::source::Shared;
        let bytes: Vec<u8> =
            (0..400_000_u32).map(|k| (k.wrapping_mul(0x9e37_79b1) >> 13 ^ k >> 3) as u8).collect();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bytes");
        // The elements begin at some place of the file.
        std::fs::write(&path, [&[1; 77], bytes.as_slice()].concat()).unwrap();
        let file = std::fs::File::open(&path).unwrap();
        let shared = Shared::new(&file);
        let part = Part::new(&shared, 77, bytes.len() as u64);
        let all =
            [Component::I8, Component::U8, Component::I16, Component::U16, Component::U32, Component::F32];
        for component in all {
            for gap in [0, 3, 4000] {
                let stride = 3 * component.size() + gap;
                let memory = elements(&bytes, stride, component, true, Kind::Vec3);
                let base = strided(Source::File(part), stride);
                let from_file = Elements { base, sparse: None, ..memory };
                let count = (bytes.len() - 3 * component.size()) / stride + 1;
                let last = count as u32 - 1;
                let close = (0..last.min(3000)).filter(|k| k % 7 < 3);
                let list: Vec<u32> = close.chain([last.max(3001) - 1, last]).filter(|&k| k <= last).collect();
                for pick in [Pick::Range(0..count), Pick::Range(5..count - 2), Pick::List(list)] {
                    let bits = |elements: &Elements<'_>| -> Vec<[u32; 3]> {
                        elements.floats::<3>(&pick).unwrap().iter().map(|e| e.map(f32::to_bits)).collect()
                    };
                    assert_eq!(bits(&from_file), bits(&memory), "{component:?} {stride}");
                }
                let scalar = |of: Source<'_>| {
                    let stride = component.size() + gap;
                    let base = strided(of, stride);
                    let elements = Elements {
                        count: 0,
                        kind: Kind::Scalar,
                        component,
                        normalized: false,
                        base,
                        sparse: None,
                    };
                    let mut out = vec![0; (bytes.len() - component.size()) / stride];
                    elements.integers(&mut out).unwrap();
                    out
                };
                assert_eq!(scalar(Source::File(part)), scalar(Source::Memory(&bytes)));
            }
        }
        // Bytes that no longer exist are an error.
        let base = strided(Source::File(Part::new(&shared, 399_000, 3000)), 12);
        let cut = Elements { base, ..elements(&[], 12, Component::F32, false, Kind::Vec3) };
        assert!(matches!(cut.floats::<3>(&Pick::Range(0..250)), Err(LoadError::Io(_))));
    }
}
