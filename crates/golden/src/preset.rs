//! Limits that go together, by name.

use overcoat_image::decode::SampleKind;

/// Limits that go together.
///
/// | preset | limits | for |
/// |---|---|---|
/// | `exact` | none: every sample is equal | renderers that draw the same bytes everywhere |
/// | `gpu` | `max_abs` of 3 codes of 255 (771 of 65535; 0.012 of linear light), and 12 `pixels` that differ by more | pictures of a GPU |
///
/// Both reject what mean measures forgive: sixteen red pixels in a large picture, edges that moved by a pixel. `gpu` does not see
/// what changes no channel by more than 3 codes, over however many pixels; a least `psnr` beside it does (42 dB are an error
/// of 2 codes in every sample).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Preset {
    /// Equality.
    Exact,
    /// Last codes and a few pixels at edges may differ.
    Gpu,
}

/// Codes of 255 in which pictures of GPUs may differ anywhere.
const GPU_CODES: f64 = 3.0;
/// Pixels of theirs that may differ by more.
const GPU_PIXELS: u64 = 12;

impl Preset {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Exact, Self::Gpu];

    /// The word in threshold files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Gpu => "gpu",
        }
    }

    /// The preset of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|preset| preset.name() == name)
    }

    /// `max_abs` and `pixels` for pictures of this kind; `None` for equality.
    pub(super) fn limits(self, kind: SampleKind) -> Option<(f64, u64)> {
        let max_abs = match kind {
            SampleKind::Unsigned8 => GPU_CODES,
            SampleKind::Unsigned16 => GPU_CODES * 257.0,
            _ => 0.012,
        };
        (self == Self::Gpu).then_some((max_abs, GPU_PIXELS))
    }
}

#[cfg(test)]
mod tests;
