//! Budget of memory: bytes granted to a file so far, held against its limit.
use overcoat_core::limits::{LimitExceeded, Limits};

/// From so many bytes on the system is asked whether it has them.
const LARGE: u64 = 1 << 20;

/// Counts decoded bytes against [`Limits::decoded_bytes`]. Charged before memory is allocated, in the order of the
/// file and never from a worker thread, so that the same file meets the limit at the same element every time.
#[derive(Debug)]
pub(crate) struct Budget {
    used: u64,
    limit: u64,
    /// Pixels of textures, against [`Limits::total_texture_pixels`].
    pixels: u64,
    pixel_limit: u64,
}

impl Budget {
    /// Budget of which nothing is used yet.
    pub(crate) fn new(limits: &Limits) -> Self {
        Self { used: 0, limit: limits.decoded_bytes, pixels: 0, pixel_limit: limits.total_texture_pixels }
    }

    /// Grants `count` elements of `size` bytes.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming `what` if that is more than what is left.
    pub(crate) fn charge(
        &mut self,
        what: impl FnOnce() -> String,
        count: u64,
        size: u64,
    ) -> Result<(), LimitExceeded> {
        let bytes = count.saturating_mul(size);
        let asked = self.used.saturating_add(bytes);
        if asked <= self.limit && bytes >= LARGE {
            Limits::check_memory(what, bytes)?;
        } else {
            Limits::check(what, asked, self.limit, "decoded_bytes")?;
        }
        self.used = asked;
        Ok(())
    }

    /// Grants a texture of so many pixels, each of which takes `size` bytes.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming `what` if those are too many together with the textures before.
    pub(crate) fn charge_texture(
        &mut self,
        what: impl Fn() -> String,
        pixels: u64,
        size: u64,
    ) -> Result<(), LimitExceeded> {
        let asked = self.pixels.saturating_add(pixels);
        Limits::check(&what, asked, self.pixel_limit, "total_texture_pixels")?;
        self.charge(what, pixels, size)?;
        self.pixels = asked;
        Ok(())
    }

    /// Bytes that can still be granted.
    pub(crate) fn left(&self) -> u64 {
        self.limit.saturating_sub(self.used)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grants_up_to_the_limit_and_not_one_byte_more() {
        let mut budget = Budget::new(&Limits::default().with_decoded_bytes(100));
        budget.charge(|| "a".into(), 10, 6).unwrap();
        assert_eq!(budget.left(), 40);
        let error = budget.charge(|| "accessor 3".into(), 41, 1).unwrap_err();
        assert_eq!(error.to_string(), "accessor 3: 101 exceeds the limit of 100 (decoded_bytes)");
        // A refusal takes nothing.
        budget.charge(|| "b".into(), 40, 1).unwrap();
        assert_eq!(budget.left(), 0);
        budget.charge(|| "c".into(), u64::MAX, u64::MAX).unwrap_err();
    }

    #[test]
    fn textures_are_counted_in_pixels_too() {
        let mut budget = Budget::new(&Limits::default().with_total_texture_pixels(100));
        budget.charge_texture(|| "a".into(), 60, 4).unwrap();
        let error = budget.charge_texture(|| "image 1".into(), 41, 4).unwrap_err();
        assert_eq!(error.to_string(), "image 1: 101 exceeds the limit of 100 (total_texture_pixels)");
        budget.charge_texture(|| "b".into(), 40, 4).unwrap();
        budget.charge_texture(|| "c".into(), u64::MAX, u64::MAX).unwrap_err();
    }
}
