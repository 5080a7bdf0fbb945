//! The instruction sets by name, as values that a user can choose and a test can loop over.

#[cfg(any(
    target_arch = "x86_64",
    target_arch = "aarch64",
    all(target_arch = "wasm32", target_feature = "simd128")
))]
use super::Vector;
use fearless_simd::Level;
use std::fmt;
use std::str::FromStr;

/// An instruction set. Every one gives the same bits; they differ in speed only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SimdLevel {
    /// Plain arrays, the definition of all others; slow. The renderer offers it on processors without other lanes, and
    /// with the feature `scalar-lanes`: it would be a third of the program.
    Scalar,
    /// x86-64 baseline, 128 bits.
    Sse2,
    /// x86-64-v3, 256 bits.
    Avx2,
    /// AVX-512 as of Ice Lake, 512 bits.
    Avx512,
    /// 64-bit ARM, 128 bits.
    Neon,
    /// WebAssembly with 128-bit vectors: of modules that are compiled with it, since a module cannot ask.
    Simd128,
}

impl SimdLevel {
    /// Every level by its name, weakest first.
    pub const ALL: &[Self] = &[Self::Scalar, Self::Sse2, Self::Avx2, Self::Avx512, Self::Neon, Self::Simd128];

    /// The fastest level of this machine.
    #[must_use]
    pub fn best() -> Self {
        Self::ALL.iter().copied().rev().find(|level| level.is_available()).unwrap_or(Self::Scalar)
    }

    /// All levels that this machine can run, weakest first.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.iter().copied().filter(|level| level.is_available())
    }

    /// True if this machine can run it.
    #[must_use]
    pub fn is_available(self) -> bool {
        let machine = Level::new();
        match self {
            Self::Scalar => {
                cfg!(any(
                    feature = "scalar-lanes",
                    not(any(
                        target_arch = "x86_64",
                        target_arch = "aarch64",
                        all(target_arch = "wasm32", target_feature = "simd128")
                    ))
                ))
            }
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => {
                cfg!(any(not(overcoat_one_level), not(feature = "wide-lanes"))) && machine.as_sse2().is_some()
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => cfg!(feature = "wide-lanes") && machine.as_avx2().is_some(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                cfg!(all(feature = "wide-lanes", not(overcoat_one_level))) && machine.as_avx512().is_some()
            }
            #[cfg(target_arch = "aarch64")]
            Self::Neon => machine.as_neon().is_some(),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Self::Simd128 => machine.as_wasm_simd128().is_some(),
            #[allow(unreachable_patterns)]
            _ => {
                let _ = machine;
                false
            }
        }
    }

    /// The name, as `--simd` takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
            Self::Simd128 => "simd128",
        }
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no instruction set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown instruction set '{0}'; known are scalar, sse2, avx2, avx512, neon and simd128")]
pub struct UnknownLevel(String);

impl FromStr for SimdLevel {
    type Err = UnknownLevel;
    fn from_str(name: &str) -> Result<Self, UnknownLevel> {
        Self::ALL
            .iter()
            .copied()
            .find(|level| level.name() == name)
            .ok_or_else(|| UnknownLevel(name.to_owned()))
    }
}

/// Code for AVX-512, if that is compiled in: decided by the features of this crate and not of the one that uses
/// [`dispatch!`](crate::dispatch).
#[cfg(all(feature = "wide-lanes", not(overcoat_one_level)))]
#[doc(hidden)]
#[macro_export]
macro_rules! with_avx512 {
    ($($code:tt)*) => { $($code)* };
}

/// Not compiled in.
#[cfg(not(all(feature = "wide-lanes", not(overcoat_one_level))))]
#[doc(hidden)]
#[macro_export]
macro_rules! with_avx512 {
    ($($code:tt)*) => {};
}

/// Code for AVX2, if that is compiled in: decided by the features of this crate and not of the one that uses
/// [`dispatch!`](crate::dispatch).
#[cfg(feature = "wide-lanes")]
#[doc(hidden)]
#[macro_export]
macro_rules! with_avx2 {
    ($($code:tt)*) => { $($code)* };
}

/// Not compiled in.
#[cfg(not(feature = "wide-lanes"))]
#[doc(hidden)]
#[macro_export]
macro_rules! with_avx2 {
    ($($code:tt)*) => {};
}

/// Code for SSE2, if that is compiled in: decided by the features of this crate and not of the one that uses
/// [`dispatch!`](crate::dispatch).
#[cfg(any(not(overcoat_one_level), not(feature = "wide-lanes")))]
#[doc(hidden)]
#[macro_export]
macro_rules! with_sse2 {
    ($($code:tt)*) => { $($code)* };
}

/// Not compiled in.
#[cfg(not(any(not(overcoat_one_level), not(feature = "wide-lanes"))))]
#[doc(hidden)]
#[macro_export]
macro_rules! with_sse2 {
    ($($code:tt)*) => {};
}

/// The arms of [`dispatch!`](crate::dispatch): the instruction sets that are compiled in, and what is done without any of them.
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_or {
    ($level:expr, $l:ident => $body:expr, $otherwise:expr) => {{
        use $crate::math::lanes::Lanes as _;
        let level: $crate::math::lanes::SimdLevel = $level;
        // Without instruction sets to choose from, nothing leaves the block early.
        #[allow(unused_labels, clippy::let_and_return)]
        let done = 'done: {
            #[cfg(target_arch = "x86_64")]
            {
                $crate::with_avx512! {
                    if let Some($l) = $crate::math::lanes::avx512(level) {
                        break 'done $l.run(
                            #[inline(always)]
                            || $body,
                        );
                    }
                }
                $crate::with_avx2! {
                    if let Some($l) = $crate::math::lanes::avx2(level) {
                        break 'done $l.run(
                            #[inline(always)]
                            || $body,
                        );
                    }
                }
                $crate::with_sse2! {
                    if let Some($l) = $crate::math::lanes::sse2(level) {
                        break 'done $l.run(
                            #[inline(always)]
                            || $body,
                        );
                    }
                }
            }
            #[cfg(target_arch = "aarch64")]
            if let Some($l) = $crate::math::lanes::neon(level) {
                break 'done $l.run(
                    #[inline(always)]
                    || $body,
                );
            }
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            if let Some($l) = $crate::math::lanes::simd128(level) {
                break 'done $l.run(
                    #[inline(always)]
                    || $body,
                );
            }
            let _ = level;
            $otherwise
        };
        done
    }};
}

/// Runs an expression compiled for the given level: `dispatch!(level, l => kernel(l, ...))`, where `l` is the
/// [`Lanes`](super::Lanes) token. A level that the machine lacks runs as [`SimdLevel::Scalar`], with the same bits;
/// who lets users choose a level checks [`SimdLevel::is_available`] first.
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $l:ident => $body:expr) => {
        $crate::dispatch_or!($level, $l => $body, {
            let $l = $crate::math::lanes::Scalar;
            $l.run(
                #[inline(always)]
                || $body,
            )
        })
    };
}

/// [`dispatch!`](crate::dispatch) where the renderer has scalar lanes: decided by the features of this crate.
#[cfg(any(
    feature = "scalar-lanes",
    not(any(
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    ))
))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_built {
    ($level:expr, $l:ident => $body:expr) => { $crate::dispatch!($level, $l => $body) };
}

/// The instruction sets that are compiled in, without scalar lanes.
#[cfg(not(any(
    feature = "scalar-lanes",
    not(any(
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    ))
)))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_built {
    ($level:expr, $l:ident => $body:expr) => {
        $crate::dispatch_or!($level, $l => $body, unreachable!("the instruction set was checked before"))
    };
}

/// The instruction sets that no package of its own is compiled for: on x86-64 scalar lanes, if there are any; else all.
#[cfg(any(not(target_arch = "x86_64"), feature = "scalar-lanes"))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_elsewhere {
    ($level:expr, $l:ident => $body:expr) => {{
        use $crate::math::lanes::Lanes as _;
        #[cfg(target_arch = "x86_64")]
        {
            let _: $crate::math::lanes::SimdLevel = $level;
            let $l = $crate::math::lanes::Scalar;
            $l.run(
                #[inline(always)]
                || $body,
            )
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            $crate::dispatch_built!($level, $l => $body)
        }
    }};
}

/// No other instruction set is there.
#[cfg(not(any(not(target_arch = "x86_64"), feature = "scalar-lanes")))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_elsewhere {
    ($level:expr, $l:ident => $body:expr) => {{
        let _: $crate::math::lanes::SimdLevel = $level;
        unreachable!("the instruction set was checked before")
    }};
}

/// AVX2 alone, whatever level is asked for: for unit tests, where three copies of a large kernel take half again as long to build.
#[cfg(feature = "wide-lanes")]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_in_unit_tests {
    ($level:expr, $l:ident => $body:expr) => {{
        use $crate::math::lanes::Lanes as _;
        let _: $crate::math::lanes::SimdLevel = $level;
        let Some($l) = $crate::math::lanes::avx2($crate::math::lanes::SimdLevel::Avx2) else {
            panic!("unit tests of the renderer need a processor with AVX2; the tests in tests/ do not")
        };
        $l.run(
            #[inline(always)]
            || $body,
        )
    }};
}

/// The instruction sets that are compiled in, without AVX2.
#[cfg(not(feature = "wide-lanes"))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_in_unit_tests {
    ($level:expr, $l:ident => $body:expr) => { $crate::dispatch_built!($level, $l => $body) };
}

/// [`dispatch!`](crate::dispatch) without the scalar lanes where the renderer has none: for kernels so large that a copy
/// which nobody runs counts. The level must be available. Unit tests compile AVX2 alone; `tests/determinism.rs`, which runs the
/// code that is shipped, compares the levels.
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_available {
    ($level:expr, $l:ident => $body:expr) => {{
        #[cfg(all(test, target_arch = "x86_64"))]
        {
            $crate::dispatch_in_unit_tests!($level, $l => $body)
        }
        #[cfg(not(all(test, target_arch = "x86_64")))]
        {
            $crate::dispatch_built!($level, $l => $body)
        }
    }};
}

/// Runs an expression compiled for one instruction set alone: the least that every processor of the machine's kind has. For tests
/// of formulas, which take about twice as long to compile with [`dispatch!`](crate::dispatch); that all give the same bits is
/// shown of the operations, and of whole pictures.
#[macro_export]
#[doc(hidden)]
macro_rules! dispatch_baseline {
    ($l:ident => $body:expr) => {{
        use $crate::math::lanes::Lanes as _;
        #[cfg(target_arch = "x86_64")]
        let Some($l) = $crate::math::lanes::sse2($crate::math::lanes::SimdLevel::Sse2) else {
            unreachable!("every processor of the kind has it")
        };
        #[cfg(target_arch = "aarch64")]
        let Some($l) = $crate::math::lanes::neon($crate::math::lanes::SimdLevel::Neon) else {
            unreachable!("every processor of the kind has it")
        };
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let $l = $crate::math::lanes::Scalar;
        $l.run(
            #[inline(always)]
            || $body,
        )
    }};
}

/// The AVX-512 token, if that is the level asked for and the machine has it.
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
#[must_use]
pub fn avx512(level: SimdLevel) -> Option<Vector<fearless_simd::x86::Avx512>> {
    (level == SimdLevel::Avx512).then(|| Level::new().as_avx512()).flatten().map(Vector)
}

/// The AVX2 token, if that is the level asked for and the machine has it.
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
#[must_use]
pub fn avx2(level: SimdLevel) -> Option<Vector<fearless_simd::x86::Avx2>> {
    (level == SimdLevel::Avx2).then(|| Level::new().as_avx2()).flatten().map(Vector)
}

/// The SSE2 token, if that is the level asked for and the machine has it.
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
#[must_use]
pub fn sse2(level: SimdLevel) -> Option<Vector<fearless_simd::x86::Sse2>> {
    (level == SimdLevel::Sse2).then(|| Level::new().as_sse2()).flatten().map(Vector)
}

/// The NEON token, if that is the level asked for and the machine has it.
#[cfg(target_arch = "aarch64")]
#[doc(hidden)]
#[must_use]
pub fn neon(level: SimdLevel) -> Option<Vector<fearless_simd::aarch64::Neon>> {
    (level == SimdLevel::Neon).then(|| Level::new().as_neon()).flatten().map(Vector)
}

/// The token of WebAssembly's vectors, if that is the level asked for. The module has them, or would not have been loaded.
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
#[doc(hidden)]
#[must_use]
pub fn simd128(level: SimdLevel) -> Option<Vector<fearless_simd::wasm32::WasmSimd128>> {
    (level == SimdLevel::Simd128).then(|| Level::new().as_wasm_simd128()).flatten().map(Vector)
}
