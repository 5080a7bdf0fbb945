//! Golden pictures: what a renderer drew once, was looked at, and must draw again. For any project: nothing here knows
//! how pictures are made.
//!
//! * [`Golden`] is one line in a test: a folder of pictures, compared by name.
//! * The command `overcoat golden` compares folders, writes a page that shows where pictures differ and takes new ones.
//! * [`GoldenFolder`] holds goldens that describe themselves, as this crate's own do: `<name>.toml` says what is drawn
//!   and, in one sentence, what would be wrong if it changed, and holds the hash of the linear frame; `<name>.png` shows it.
//!
//! All three compare in one way ([`check`]): by [`metrics`], from equality to FLIP, against [`thresholds`] by file name. What a
//! test draws is a [`DisplayImage`](overcoat_core::frame::DisplayImage) or the bytes of a file, which is read within
//! [`Limits`](overcoat_core::limits::Limits).
//!
//! Accepting never passes the same run: [`Golden`] with `UPDATE_GOLDENS=1` and [`DescribedGolden::accept`] record the
//! present picture and give an error all the same. Whoever accepts a golden has looked at it, and runs the tests again.
//!
//! ```no_run
//! # mod overcoat { pub use {overcoat_core::frame, overcoat_golden as golden}; }
//! use overcoat::frame::DisplayImage;
//! use overcoat::golden::GoldenFolder;
//!
//! # fn render(_: &str) -> (String, DisplayImage) { unimplemented!() }
//! let folder = GoldenFolder::open("golden".as_ref())?;
//! for golden in folder.goldens() {
//!     let (frame_hash, picture) = render(golden.description());
//!     if std::env::var_os("UPDATE_GOLDENS").is_some_and(|v| v == "1") {
//!         return Err(golden.accept(&frame_hash, &picture));
//!     }
//!     golden.check(&frame_hash, &picture, "target/golden-failures".as_ref())?;
//! }
//! # Ok::<(), overcoat::golden::GoldenError>(())
//! ```

#[doc(hidden)]
pub mod accept;
mod assertion;
pub mod check;
#[cfg(feature = "compress")]
#[doc(hidden)]
pub mod compress;
mod described;
mod error;
#[doc(hidden)]
pub mod junit;
pub mod metrics;
mod preset;
#[doc(hidden)]
pub mod report;
pub mod thresholds;
#[doc(hidden)]
pub mod walk;

pub use assertion::Golden;
pub use described::{DescribedGolden, GoldenFolder};
pub use error::GoldenError;
