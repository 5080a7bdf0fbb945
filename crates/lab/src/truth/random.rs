//! Random numbers by counters: those of a sample depend on its index alone, so that samples can be taken in any order,
//! on any number of threads.
//!
//! Philox4x32-10: Salmon, Moraes, Dror and Shaw 2011, "Parallel Random Numbers: As Easy as 1, 2, 3".

/// Events (at interfaces, in media, on microfacets) after which a walk is given up, and says so.
pub(super) const MAX_EVENTS: u32 = 1_000_000;

/// One block of Philox4x32 with ten rounds.
fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let a = u64::from(counter[0]) * 0xd251_1f53;
        let b = u64::from(counter[2]) * 0xcd9e_8d57;
        counter = [
            (b >> 32) as u32 ^ counter[1] ^ key[0],
            b as u32,
            (a >> 32) as u32 ^ counter[3] ^ key[1],
            a as u32,
        ];
        key = [key[0].wrapping_add(0x9e37_79b9), key[1].wrapping_add(0xbb67_ae85)];
    }
    counter
}

/// Sixty-four bits of which each depends on all of both arguments: the finalizer of SplitMix64 (Steele, Lea and Flood 2014).
pub(super) fn mix(state: u64, value: u64) -> u64 {
    let mut z = (state ^ value).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The same of numbers.
pub(super) fn mix_numbers(state: u64, values: &[f64]) -> u64 {
    values.iter().fold(state, |state, value| mix(state, value.to_bits()))
}

/// One sample: its random numbers, and the number of its events.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    key: [u32; 2],
    index: u64,
    block: u64,
    words: [u32; 4],
    left: usize,
    events: u32,
    truncated: bool,
}

impl Trial {
    pub fn new(key: u64, index: u64) -> Self {
        let key = [key as u32, (key >> 32) as u32];
        Self { key, index, block: 0, words: [0; 4], left: 0, events: 0, truncated: false }
    }

    /// A number above 0 and below 1, of 52 bits.
    pub fn uniform(&mut self) -> f64 {
        if self.left == 0 {
            let counter =
                [self.index as u32, (self.index >> 32) as u32, self.block as u32, (self.block >> 32) as u32];
            self.words = philox(counter, self.key);
            self.block += 1;
            self.left = 4;
        }
        self.left -= 2;
        let bits = u64::from(self.words[self.left]) << 32 | u64::from(self.words[self.left + 1]);
        ((bits >> 12) as f64 + 0.5) * (1.0 / 4_503_599_627_370_496.0)
    }

    /// Counts an event; true if there may be one more.
    #[must_use]
    pub fn spend(&mut self) -> bool {
        self.events += 1;
        self.truncated |= self.events > MAX_EVENTS;
        !self.truncated
    }

    /// True if the walk was given up, so that its further events are missing.
    pub fn truncated(&self) -> bool {
        self.truncated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers that come with the authors' library, Random123.
    #[test]
    fn philox_has_the_known_answers() {
        assert_eq!(philox([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(
            philox([u32::MAX; 4], [u32::MAX; 2]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        let counter = [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344];
        let expected = [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1];
        assert_eq!(philox(counter, [0xa409_3822, 0x299f_31d0]), expected);
    }

    #[test]
    fn trials_are_independent_of_each_other_and_even() {
        let (mut sum, mut squares, mut products) = (0.0, 0.0, 0.0);
        let count = 20_000;
        for index in 0..count {
            let (mut a, mut b) = (Trial::new(7, index), Trial::new(7, index + 1));
            let (x, y) = (a.uniform() - 0.5, b.uniform() - 0.5);
            assert!(x > -0.5 && x < 0.5);
            sum += x;
            squares += x * x;
            products += x * y;
        }
        let n = count as f64;
        // Five standard errors each.
        assert!((sum / n).abs() < 5.0 * (1.0 / 12.0 / n).sqrt());
        assert!((squares / n - 1.0 / 12.0).abs() < 5.0 * (1.0 / 180.0 / n).sqrt());
        assert!((products / n).abs() < 5.0 * (1.0 / 144.0 / n).sqrt());
    }

    #[test]
    fn a_trial_ends() {
        let mut trial = Trial::new(0, 0);
        assert!((0..MAX_EVENTS).all(|_| trial.spend()) && !trial.truncated());
        assert!(!trial.spend() && trial.truncated());
    }
}
