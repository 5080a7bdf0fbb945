//! The context: options, threads, worlds and the message of the last call.

use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use overcoat_float_mode::DefaultArithmetic;
use renderer::jobs::MAX_THREADS;
use renderer::limits::Limits;
use renderer::render::{Cancellation, Renderer};
use renderer::viewport::Viewport;
use renderer::world::World;
use std::collections::BTreeMap;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Context of all calls: owns the threads, the worlds, and what is in them.
#[allow(non_camel_case_types)]
pub struct overcoat {
    inner: Mutex<Inner>,
    /// Cancellation of the picture that is drawn now.
    cancellation: Mutex<Cancellation>,
    message: Mutex<CString>,
}

/// State that one thread uses at a time, behind a lock.
pub(crate) struct Inner {
    pub viewport: Viewport,
    pub worlds: BTreeMap<u64, World>,
    pub limits: Limits,
    next_world: u64,
    /// A panic has left it half done.
    is_broken: bool,
}

/// Options of overcoat_new().
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_options {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// Worker threads, up to 256; 0: one for each processor. With 1 there are none: all is done by the calling thread.
    pub threads: u32,
    /// Bytes of a file, and of what it unpacks to, at most; 0: 1 GiB.
    pub input_bytes: u64,
    /// Triangles of a world at most; 0: as many as the library allows by default.
    pub triangles: u64,
    /// Pixels of a picture at most; 0: as many as the library allows by default.
    pub output_pixels: u64,
}

// SAFETY: begins with its size, and zeros are numbers.
unsafe impl Sized32 for overcoat_options {}

impl Inner {
    fn new(options: &overcoat_options) -> Result<Self, Failure> {
        let threads = options.threads as usize;
        if threads > MAX_THREADS {
            let message = format!("threads: {threads} is not 0 to {MAX_THREADS}");
            return Err(Failure::new(Status::OVERCOAT_OUT_OF_RANGE, message));
        }
        let mut limits = Limits::default();
        for (asked, limit) in [
            (options.input_bytes, &mut limits.input_bytes),
            (options.triangles, &mut limits.triangles),
            (options.output_pixels, &mut limits.output_pixels),
        ] {
            if asked > 0 {
                *limit = asked;
            }
        }
        let viewport = Viewport::new(Renderer::builder().threads(threads).build()?);
        Ok(Self { viewport, worlds: BTreeMap::new(), limits, next_world: 1, is_broken: false })
    }

    /// A world by its number.
    pub fn world(&mut self, number: u64) -> Result<&mut World, Failure> {
        let gone =
            || Failure::new(Status::OVERCOAT_GONE, "the world is not there: it has been freed, or never was");
        self.worlds.get_mut(&number).ok_or_else(gone)
    }

    /// Adds a world, under a number that no other has had.
    pub fn add_world(&mut self, world: World) -> u64 {
        let number = self.next_world;
        self.next_world += 1;
        self.worlds.insert(number, world);
        number
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does something with an overcoat, and keeps the sentence of what fails. Panics end here.
///
/// # Safety
/// As in [`raw`].
pub(crate) unsafe fn run(
    overcoat: *mut overcoat,
    what: impl FnOnce(&mut Inner, &Mutex<Cancellation>) -> Result<(), Failure>,
) -> overcoat_status {
    // SAFETY: of the caller.
    let Some(overcoat) = (unsafe { raw::shared(overcoat) }) else { return Status::OVERCOAT_INVALID_ARGUMENT };
    let mut inner = lock(&overcoat.inner);
    let done = if inner.is_broken {
        Err(Failure::new(
            Status::OVERCOAT_INTERNAL,
            "an earlier call has failed in the middle: only overcoat_free() is left",
        ))
    } else {
        // For as long as the library works, and of the workers that are started meanwhile.
        let _arithmetic = DefaultArithmetic::new();
        let own = &mut *inner;
        catch_unwind(AssertUnwindSafe(|| what(own, &overcoat.cancellation))).unwrap_or_else(|_| {
            inner.is_broken = true;
            Err(Failure::new(
                Status::OVERCOAT_INTERNAL,
                "a mistake of the library; please report it with what led to it",
            ))
        })
    };
    let (status, message) = match done {
        Ok(()) => (Status::OVERCOAT_OK, String::new()),
        Err(failure) => (failure.status, failure.message),
    };
    // Names in files may have any characters.
    *lock(&overcoat.message) = CString::new(message.replace('\0', " ")).unwrap_or_default();
    status
}

/// The version of the library, 10000 * major + 100 * minor + patch.
#[unsafe(no_mangle)]
pub extern "C" fn overcoat_version() -> u32 {
    let part = |text: &str| text.parse::<u32>().unwrap_or(0);
    part(env!("CARGO_PKG_VERSION_MAJOR")) * 10_000
        + part(env!("CARGO_PKG_VERSION_MINOR")) * 100
        + part(env!("CARGO_PKG_VERSION_PATCH"))
}

/// Makes an overcoat, with its threads. `options` may be null: all defaults. There is no message if that fails.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_new(
    options: *const overcoat_options,
    overcoat_out: *mut *mut overcoat,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        if overcoat_out.is_null() {
            return Status::OVERCOAT_INVALID_ARGUMENT;
        }
        raw::write(overcoat_out, std::ptr::null_mut());
        let defaults =
            overcoat_options { size: 0, threads: 0, input_bytes: 0, triangles: 0, output_pixels: 0 };
        let own = if options.is_null() { Some(defaults) } else { raw::structure(options) };
        let Some(own) = own else { return Status::OVERCOAT_INVALID_ARGUMENT };
        let _arithmetic = DefaultArithmetic::new();
        match catch_unwind(|| Inner::new(&own)) {
            Ok(Ok(inner)) => {
                let made = overcoat {
                    inner: Mutex::new(inner),
                    cancellation: Mutex::default(),
                    message: Mutex::default(),
                };
                raw::write(overcoat_out, Box::into_raw(Box::new(made)));
                Status::OVERCOAT_OK
            }
            Ok(Err(failure)) => failure.status,
            Err(_) => Status::OVERCOAT_INTERNAL,
        }
    }
}

/// Frees an overcoat with all that belongs to it, and sets the pointer to null, which all functions take for an invalid argument.
/// Null, or a pointer to null, is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_free(overcoat: *mut *mut overcoat) {
    // SAFETY: of the caller.
    let taken = unsafe { raw::take(overcoat) };
    let _ = catch_unwind(AssertUnwindSafe(|| drop(taken)));
}

/// Error message of the last call with this overcoat, a sentence without a line break; empty if the call succeeded. The
/// text stays until the next call with it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_message(overcoat: *const overcoat) -> *const c_char {
    // SAFETY: of the caller.
    match unsafe { raw::shared(overcoat) } {
        Some(overcoat) => lock(&overcoat.message).as_ptr(),
        None => c"there is no overcoat".as_ptr(),
    }
}

/// Stops the picture that another thread draws with this overcoat: that call returns OVERCOAT_CANCELLED soon. Without one, nothing
/// happens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_cancel(overcoat: *const overcoat) {
    // SAFETY: of the caller.
    if let Some(overcoat) = unsafe { raw::shared(overcoat) } {
        lock(&overcoat.cancellation).cancel();
    }
}

/// Lets a picture be stopped by overcoat_cancel() while it is drawn.
pub(crate) fn drawing<T>(
    viewport: &mut Viewport,
    shared: &Mutex<Cancellation>,
    draw: impl FnOnce(&mut Viewport) -> T,
) -> T {
    let own = Cancellation::new();
    *lock(shared) = own.clone();
    viewport.renderer().cancel_by(Some(own));
    let drawn = draw(viewport);
    viewport.renderer().cancel_by(None);
    *lock(shared) = Cancellation::new();
    drawn
}
