//! Memory of numpy's arrays that pictures are drawn into, without the interpreter.
//!
//! The only unsafe code written by hand in this package: an array whose rows do not follow each other has no
//! safe slice.

use crate::errors::Kind;
use numpy::{
    BorrowError, Element, PyArray, PyArray2, PyArray3, PyArrayMethods, PyReadwriteArray, PyUntypedArray,
    PyUntypedArrayMethods,
};
use overcoat::frame::{PixelFormat, Target};
use pyo3::prelude::*;
use pyo3::types::PyModule;

/// An array that is borrowed for writing, as long as this lives: nobody else of this package may write to it, and numpy neither
/// frees nor moves it, as there is a reference to it, and a weak one to the array that owns the memory, with which
/// `resize(refcheck=False)` is refused too.
pub(crate) struct Memory<'py> {
    _borrow: Borrow<'py>,
    _owner: Bound<'py, PyAny>,
    address: *mut u8,
    length: usize,
    stride: usize,
    format: PixelFormat,
}

#[allow(dead_code, reason = "kept until the picture is drawn")]
enum Borrow<'py> {
    Bytes(PyReadwriteArray<'py, u8, numpy::Ix3>),
    Floats(PyReadwriteArray<'py, f32, numpy::Ix3>),
    Words(PyReadwriteArray<'py, u32, numpy::Ix2>),
}

/// A shape in the words of numpy.
fn tuple<T: ToString>(shape: &[T]) -> String {
    format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
}

/// Exception for an array that is refused as `out`.
fn wrong(reason: std::fmt::Arguments<'_>) -> PyErr {
    Kind::Option.error(format_args!("out: {reason}"))
}

/// Which format pixels of an array have, of what was asked for.
fn format_of(name: Option<&str>, is_float: bool, is_words: bool) -> PyResult<PixelFormat> {
    let of = |format: PixelFormat| (format.is_linear(), format == PixelFormat::Xrgb8);
    let fitting = || PixelFormat::ALL.iter().filter(|format| of(**format) == (is_float, is_words));
    let known = || fitting().map(|format| format.name()).collect::<Vec<_>>().join(", ");
    let kind = if is_float {
        "float32"
    } else if is_words {
        "uint32"
    } else {
        "uint8"
    };
    let Some(name) = name else {
        // What `Image.array` and `Image.linear` are.
        return Ok(if is_float {
            PixelFormat::RgbaF32Premultiplied
        } else if is_words {
            PixelFormat::Xrgb8
        } else {
            PixelFormat::Rgba8
        });
    };
    fitting().find(|format| format.name() == name).copied().ok_or_else(|| {
        Kind::Option.error(format_args!("format '{name}': expected, of {kind}, one of {}", known()))
    })
}

/// Borrows an array for writing.
fn borrow<'py, T: Element, D: numpy::ndarray::Dimension>(
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    array.try_readwrite().map_err(|error| match error {
        BorrowError::NotWriteable => wrong(format_args!("the array cannot be written to")),
        _ => wrong(format_args!("another picture is being drawn into its memory, or into columns beside it")),
    })
}

impl<'py> Memory<'py> {
    /// Memory of an array for a picture, or a part of one, of that size.
    pub(crate) fn new(
        out: &Bound<'py, PyAny>,
        format: Option<&str>,
        [width, height]: [u32; 2],
    ) -> PyResult<Self> {
        let Ok(array) = out.cast::<PyUntypedArray>() else {
            return Err(wrong(format_args!("expected a numpy array, found {}", out.get_type().name()?)));
        };
        let (width, height) = (width as usize, height as usize);
        let (borrow, item, of) = if let Ok(array) = out.cast::<PyArray3<u8>>() {
            (Borrow::Bytes(borrow(array)?), 1, format_of(format, false, false)?)
        } else if let Ok(array) = out.cast::<PyArray3<f32>>() {
            (Borrow::Floats(borrow(array)?), 4, format_of(format, true, false)?)
        } else if let Ok(array) = out.cast::<PyArray2<u32>>() {
            (Borrow::Words(borrow(array)?), 4, format_of(format, false, true)?)
        } else {
            return Err(wrong(format_args!(
                "expected (H, W, 4) uint8 or float32, or (H, W) uint32, found {} {}",
                tuple(array.shape()),
                array.dtype()
            )));
        };
        let wanted = [height, width, 4];
        let wanted = if of == PixelFormat::Xrgb8 { &wanted[..2] } else { &wanted[..] };
        if array.shape() != wanted {
            return Err(wrong(format_args!(
                "expected shape {}, found {}",
                tuple(wanted),
                tuple(array.shape())
            )));
        }
        let strides = array.strides();
        let pixel = of.bytes();
        let row = width * pixel;
        let packed = (width == 1 || strides[1] == pixel as isize)
            && strides.get(2).is_none_or(|channel| *channel == item);
        let stride = if height == 1 { Some(row) } else { usize::try_from(strides[0]).ok() };
        let Some(stride) = stride.filter(|stride| packed && *stride >= row) else {
            return Err(wrong(format_args!(
                "its pixels must follow each other in a row, and its rows from the top on; found strides of {} bytes",
                tuple(strides)
            )));
        };
        let address = match &borrow {
            Borrow::Bytes(array) => array.data(),
            Borrow::Floats(array) => array.data().cast(),
            Borrow::Words(array) => array.data().cast(),
        };
        let mut owner = out.clone();
        loop {
            match owner.getattr("base") {
                Ok(base) if base.cast::<PyUntypedArray>().is_ok() => owner = base,
                _ => break,
            }
        }
        let weak = PyModule::import(out.py(), "weakref")?.getattr("ref")?.call1((owner,))?;
        // Not beyond the last row, as the array may end there.
        let length = stride * (height - 1) + row;
        Ok(Self { _borrow: borrow, _owner: weak, address, length, stride, format: of })
    }

    /// The memory, to be drawn into.
    #[allow(unsafe_code)]
    pub(crate) fn target(&mut self) -> Target<'_> {
        // SAFETY: the array has `height` rows that lie `stride` bytes apart, each of `row` bytes that follow each other, and
        // `stride` is not negative: all bytes from the first of the first row to the last of the last one are within one
        // allocation, that of the array or of the one that it is a view of, and initialized, as numbers of numpy are to be looked
        // at as bytes. It lives as long as `self`, by the references that are kept. `self` is borrowed for as long as the
        // slice lives, and numpy's borrow, which is kept as well, is refused to every other array with memory in the same range of
        // addresses: no other slice of this package has a byte of it. Python itself may read or write there meanwhile, as it
        // may with any array that an extension works on without the interpreter; that is said in the documentation.
        let bytes = unsafe { std::slice::from_raw_parts_mut(self.address, self.length) };
        Target::new(bytes, self.stride, self.format)
    }
}
