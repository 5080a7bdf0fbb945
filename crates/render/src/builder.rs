//! Settings of a renderer that stay the same for all of its pictures.

use super::{RenderError, RenderOptions, Renderer};
use overcoat_core::jobs::MAX_THREADS;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_tiles::options::{check_simd, check_tile_size};
use std::borrow::Cow;

/// Settings of a [`Renderer`] that never change a picture, see [`Renderer::builder`]. Limits do (with them there may be
/// none): they are given with each picture, [`RenderOptions::limits`].
///
/// ```
/// # mod overcoat { pub use {overcoat_render as render, overcoat_render::Renderer}; }
/// use overcoat::Renderer;
/// use overcoat::render::RenderError;
///
/// let renderer = Renderer::builder().threads(2).tile_size(32).build()?;
/// assert!(renderer.jobs().threads() <= 2);
/// assert!(matches!(Renderer::builder().tile_size(33).build(), Err(RenderError::Option { .. })));
/// # Ok::<(), RenderError>(())
/// ```
#[derive(Clone, Debug, Default)]
#[must_use]
pub struct RendererBuilder {
    threads: usize,
    fixed: Fixed,
}

/// Options of all pictures, in place of those that each has.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fixed {
    simd: Option<SimdLevel>,
    tile_size: Option<u32>,
}

impl RendererBuilder {
    /// Worker threads, up to [`MAX_THREADS`]; 0, the default, stands for one per processor. Where the system does not give
    /// so many there are fewer, [`Jobs::missing`](overcoat_core::jobs::Jobs::missing).
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Instruction set of all pictures, in place of [`RenderOptions::simd`]. Default: what each picture says.
    pub fn simd(mut self, level: SimdLevel) -> Self {
        self.fixed.simd = Some(level);
        self
    }

    /// Side of a tile in pixels of all pictures, 16, 32 or 64, in place of [`RenderOptions::tile_size`]. Default: what each
    /// picture says.
    pub fn tile_size(mut self, side: u32) -> Self {
        self.fixed.tile_size = Some(side);
        self
    }

    /// Starts the threads.
    ///
    /// # Errors
    /// [`RenderError::Option`] naming the setting that is out of its range, or that this machine does not have.
    pub fn build(self) -> Result<Renderer, RenderError> {
        let Self { threads, fixed } = self;
        if threads > MAX_THREADS {
            return Err(RenderError::Option {
                option: "threads",
                value: threads.to_string(),
                allowed: "0 to 256",
            });
        }
        check_tile_size(fixed.tile_size)?;
        fixed.simd.map_or(Ok(()), check_simd)?;
        Ok(Renderer { fixed, ..Renderer::new(threads) })
    }
}

impl Fixed {
    /// The options of a picture with these in their place.
    pub(super) fn among<'a>(&self, options: &'a RenderOptions) -> Cow<'a, RenderOptions> {
        let simd = self.simd.unwrap_or(options.simd);
        let tile_size = self.tile_size.or(options.tile_size);
        if (simd, tile_size) == (options.simd, options.tile_size) {
            return Cow::Borrowed(options);
        }
        let mut fixed = options.clone();
        (fixed.simd, fixed.tile_size) = (simd, tile_size);
        Cow::Owned(fixed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_out_of_range_are_errors() {
        let refused = |builder: RendererBuilder| match builder.build() {
            Err(RenderError::Option { option, .. }) => option,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(Renderer::builder().threads(MAX_THREADS + 1)), "threads");
        assert_eq!(refused(Renderer::builder().tile_size(0)), "tile size");
        if let Some(missing) = SimdLevel::ALL.iter().find(|level| !level.is_available()) {
            assert_eq!(refused(Renderer::builder().simd(*missing)), "simd");
        }
        assert!(format!("0 to {MAX_THREADS}") == "0 to 256");
    }

    #[test]
    fn settings_of_the_renderer_come_before_those_of_a_picture() {
        let options = RenderOptions::draft(512, 512).with_tile_size(Some(64));
        assert!(matches!(Fixed::default().among(&options), Cow::Borrowed(_)));
        let fixed = Fixed { simd: Some(SimdLevel::Scalar), tile_size: Some(16) };
        let expected = options.clone().with_simd(SimdLevel::Scalar).with_tile_size(Some(16));
        assert_eq!(*fixed.among(&options), expected);
    }
}
