//! Pointers of callers: the only place that looks at what they point to.
//!
//! **What callers promise**, as the header says: a pointer is null, or it points to as many values as its length, or the `size` at
//! the beginning of a structure, says, which nobody changes while a function runs, and which for output may be written. C cannot
//! check that, nor can this. What can be checked is: null, sizes, lengths that no memory has, texts that are no UTF-8.

use std::ffi::{CStr, c_char};

/// A structure that begins with its size.
///
/// # Safety
/// `#[repr(C)]`, its first field is `size: u32`, and bytes of 0 are a value of it.
pub unsafe trait Sized32: Copy {
    /// Values of the fields that a caller does not know: 0 unless the structure says otherwise.
    fn defaults() -> Self {
        // SAFETY: zeros are a value.
        unsafe { std::mem::zeroed() }
    }
}

/// Reads a structure of which the caller knows the first `size` bytes: what comes after has its default.
///
/// `None` if the pointer is null or the size is less than that of the size itself.
pub unsafe fn structure<T: Sized32>(pointer: *const T) -> Option<T> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: it points to at least the size, by the caller's promise; not necessarily aligned.
    let size = unsafe { pointer.cast::<u32>().read_unaligned() } as usize;
    if size < size_of::<u32>() {
        return None;
    }
    let known = size.min(size_of::<T>());
    let mut own = T::defaults();
    // SAFETY: as many bytes are read as the caller has and `T` takes.
    unsafe {
        std::ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut own).cast::<u8>(), known);
        Some(own)
    }
}

/// Reads a list of structures, which are as far from each other as the first says that it is long. `None` as of [`structure`], and if
/// there are more than memory has. An empty one may be null.
pub unsafe fn structures<T: Sized32>(pointer: *const T, count: usize) -> Option<Vec<T>> {
    if count == 0 {
        return Some(Vec::new());
    }
    if pointer.is_null() {
        return None;
    }
    // SAFETY: as in `structure`.
    let stride = unsafe { pointer.cast::<u32>().read_unaligned() } as usize;
    if stride < size_of::<u32>() {
        return None;
    }
    let bytes = stride.checked_mul(count).filter(|bytes| isize::try_from(*bytes).is_ok())?;
    // SAFETY: within the list, whose length was checked to be one that memory can have.
    (0..bytes).step_by(stride).map(|at| unsafe { structure(pointer.cast::<u8>().add(at).cast()) }).collect()
}

/// Writes a structure, as much as the caller knows of it; nothing to null. Its size stays the caller's.
pub unsafe fn write_structure<T: Sized32>(pointer: *mut T, value: &T) {
    if pointer.is_null() {
        return;
    }
    // SAFETY: as in `structure`.
    let size = unsafe { pointer.cast::<u32>().read_unaligned() } as usize;
    let known = size.min(size_of::<T>());
    let after = size_of::<u32>();
    if known <= after {
        return;
    }
    // SAFETY: as many bytes are written as the caller has and `T` has, after the size.
    unsafe {
        let from = std::ptr::from_ref(value).cast::<u8>().add(after);
        std::ptr::copy_nonoverlapping(from, pointer.cast::<u8>().add(after), known - after);
    }
}

/// Place of one of a list of structures, which are as far from each other as the first says that it is long.
pub unsafe fn item<T: Sized32>(pointer: *mut T, number: usize) -> *mut T {
    if pointer.is_null() || number == 0 {
        return pointer;
    }
    // SAFETY: as in `structure`.
    let stride = unsafe { pointer.cast::<u32>().read_unaligned() } as usize;
    pointer.cast::<u8>().wrapping_add(stride.wrapping_mul(number)).cast()
}

/// A list. `None` if there is none or its length is more than memory has; an empty one of null and 0.
pub unsafe fn slice<'a, T: Copy>(pointer: *const T, length: usize) -> Option<&'a [T]> {
    if length == 0 {
        return Some(&[]);
    }
    let fits = length.checked_mul(size_of::<T>()).is_some_and(|bytes| isize::try_from(bytes).is_ok());
    if pointer.is_null() || !fits || !pointer.is_aligned() {
        return None;
    }
    // SAFETY: not null, aligned, no longer than an allocation can be, and there by the caller's promise.
    Some(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// Memory to be written. As `slice`.
pub unsafe fn slice_mut<'a>(pointer: *mut u8, length: usize) -> Option<&'a mut [u8]> {
    if length == 0 {
        return Some(&mut []);
    }
    if pointer.is_null() || isize::try_from(length).is_err() {
        return None;
    }
    // SAFETY: as in `slice`; bytes are always aligned.
    Some(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

/// A text that ends with 0. `None` of null and of what is no UTF-8.
pub unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a str> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: not null, and ended by a 0 by the caller's promise.
    unsafe { CStr::from_ptr(pointer) }.to_str().ok()
}

/// Writes a value; nothing to null.
pub unsafe fn write<T: Copy>(pointer: *mut T, value: T) {
    if !pointer.is_null() {
        // SAFETY: it may be written by the caller's promise; not necessarily aligned.
        unsafe { pointer.write_unaligned(value) }
    }
}

/// Shared reference to an object that this library has handed out; `None` if the pointer is null.
pub unsafe fn shared<'a, T>(pointer: *const T) -> Option<&'a T> {
    // SAFETY: null or handed out by `Box::into_raw` and not taken back.
    unsafe { pointer.as_ref() }
}

/// Takes back what was handed out, and leaves null in its place.
pub unsafe fn take<T>(place: *mut *mut T) -> Option<Box<T>> {
    if place.is_null() {
        return None;
    }
    // SAFETY: the place may be read and written; what is in it is null or was handed out by `Box::into_raw` and not taken back.
    unsafe {
        let pointer = place.replace(std::ptr::null_mut());
        if pointer.is_null() { None } else { Some(Box::from_raw(pointer)) }
    }
}

/// Hands bytes out, to be given to [`take_back`] with their length.
pub fn give(bytes: Box<[u8]>) -> *mut u8 {
    Box::into_raw(bytes).cast::<u8>()
}

/// Frees bytes that [`give`] has handed out; nothing of null.
pub unsafe fn take_back(bytes: *mut u8, length: usize) {
    if !bytes.is_null() {
        // SAFETY: of the caller: made by `give` of a slice of that length, and not freed.
        drop(unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(bytes, length)) });
    }
}
