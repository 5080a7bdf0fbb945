//! Default floating-point arithmetic for as long as a library works, in threads of processes where others have changed it.
//!
//! A library that was linked with `-ffast-math` switches the processor to flush subnormal numbers to zero, in the thread that
//! loads it and, on Linux, in every thread that is started from there. The renderer refuses to draw then, since its
//! bits would not be those of other machines. Who calls it from C or Python has done nothing wrong, so the state is put right on
//! entry, for the calling thread and for the workers that are started meanwhile, and is put back on return.
//!
//! The only unsafe code of the bindings beside that of `bindings/c/src/raw.rs` and `bindings/python/src/memory.rs`.

/// Default arithmetic on this thread until it is dropped.
#[derive(Debug)]
pub struct DefaultArithmetic {
    before: Option<Control>,
    /// The state belongs to one thread.
    _not_send: std::marker::PhantomData<*const ()>,
}

impl DefaultArithmetic {
    /// Makes this thread's arithmetic the default one.
    #[must_use]
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        let now = read();
        let before = (now & DEFAULT_MASK != DEFAULT).then(|| {
            write(now & !DEFAULT_MASK | DEFAULT);
            now
        });
        Self { before, _not_send: std::marker::PhantomData }
    }
}

impl Drop for DefaultArithmetic {
    fn drop(&mut self) {
        if let Some(before) = self.before {
            write(before);
        }
    }
}

/// True if this thread rounds to nearest and keeps subnormal numbers.
#[must_use]
pub fn is_default() -> bool {
    read() & DEFAULT_MASK == DEFAULT
}

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
use x86::{Control, DEFAULT, DEFAULT_MASK, read, write};

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
mod x86 {
    pub(super) type Control = u32;

    /// Bits of MXCSR that change results: flush to zero (15), rounding (14, 13), denormals are zeros (6). Masks of exceptions
    /// (12 to 7) are not touched: who has them unmasked wants the traps. Flags (5 to 0) say what has happened.
    pub(super) const DEFAULT_MASK: Control = 0b1110_0000_0100_0000;
    pub(super) const DEFAULT: Control = 0;

    #[allow(unsafe_code)]
    pub(super) fn read() -> Control {
        let mut control: Control = 0;
        // SAFETY: stmxcsr stores four bytes where it is told to, and the pointer is that of a u32 of this function. Every
        // processor that this is compiled for has SSE.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack, preserves_flags));
        }
        control
    }

    #[allow(unsafe_code)]
    pub(super) fn write(control: Control) {
        // SAFETY: ldmxcsr reads four bytes of a u32 of this function; a fault comes only of reserved bits, and `control` is
        // what stmxcsr has given, with bits changed that are not reserved. Compiled code assumes the default state, so that
        // entering it is right by definition; what is put back is what the caller's thread had before.
        unsafe {
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const control, options(nostack, readonly, preserves_flags));
        }
    }
}

#[cfg(target_arch = "aarch64")]
use aarch64::{Control, DEFAULT, DEFAULT_MASK, read, write};

#[cfg(target_arch = "aarch64")]
mod aarch64 {
    pub(super) type Control = u64;

    /// Bits of FPCR that change results: default NaN (25), flush to zero (24), rounding (23, 22).
    pub(super) const DEFAULT_MASK: Control = 0b1111 << 22;
    pub(super) const DEFAULT: Control = 0;

    #[allow(unsafe_code)]
    pub(super) fn read() -> Control {
        let control: Control;
        // SAFETY: reads a register that every program may read.
        unsafe {
            std::arch::asm!("mrs {}, fpcr", out(reg) control, options(nomem, nostack, preserves_flags))
        };
        control
    }

    #[allow(unsafe_code)]
    pub(super) fn write(control: Control) {
        // SAFETY: as on x86: the state that compiled code assumes, or the one that was there before.
        unsafe { std::arch::asm!("msr fpcr, {}", in(reg) control, options(nostack, preserves_flags)) };
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "x86", target_arch = "aarch64")))]
use other::{Control, DEFAULT, DEFAULT_MASK, read, write};

/// Elsewhere the library's own check is all there is.
#[cfg(not(any(target_arch = "x86_64", target_arch = "x86", target_arch = "aarch64")))]
mod other {
    pub(super) type Control = u32;
    pub(super) const DEFAULT_MASK: Control = 0;
    pub(super) const DEFAULT: Control = 0;

    pub(super) fn read() -> Control {
        0
    }

    pub(super) fn write(_: Control) {}
}
