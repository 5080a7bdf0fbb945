//! A palette of a picture's colours by median cut, in integers alone: the same on every machine.

/// Colour and the number of pixels that have it.
type Entry = ([u8; 3], u64);

/// The registers of a picture's colours.
#[derive(Debug)]
pub(super) struct Palette {
    /// Colour of each register, the mean of the colours in it. The darkest is the first: decoders without transparency
    /// show that one where nothing is drawn.
    pub(super) registers: Vec<[u8; 3]>,
    /// Every colour of the picture with its register, in the order of the colours.
    of_colors: Vec<([u8; 3], u8)>,
}

impl Palette {
    /// At most 256 registers for the colours of pixels. Pictures of no more colours keep all of them.
    pub(super) fn new(pixels: impl Iterator<Item = [u8; 3]>) -> Self {
        let mut colors: Vec<[u8; 3]> = pixels.collect();
        colors.sort_unstable();
        let mut entries: Vec<Entry> = Vec::new();
        for color in colors {
            match entries.last_mut() {
                Some((last, count)) if *last == color => *count += 1,
                _ => entries.push((color, 1)),
            }
        }
        let mut boxes = cut(entries);
        boxes.sort_by_cached_key(|cut| {
            let mean = mean(&cut.entries);
            (mean.map(u32::from).iter().sum::<u32>(), mean)
        });
        let registers = boxes.iter().map(|cut| mean(&cut.entries)).collect();
        let mut of_colors: Vec<([u8; 3], u8)> = (0..=u8::MAX)
            .zip(&boxes)
            .flat_map(|(k, cut)| cut.entries.iter().map(move |&(color, _)| (color, k)))
            .collect();
        of_colors.sort_unstable();
        Self { registers, of_colors }
    }

    /// The register of a colour of the picture.
    pub(super) fn register(&self, color: [u8; 3]) -> Option<u8> {
        let at = self.of_colors.binary_search_by_key(&color, |&(known, _)| known).ok()?;
        Some(self.of_colors[at].1)
    }
}

/// Colours that share a register.
struct Cut {
    entries: Vec<Entry>,
    /// The channel in which they differ most.
    channel: usize,
    /// The sum of squared differences from the mean in it: what a cut can win.
    spread: u64,
}

impl Cut {
    fn new(entries: Vec<Entry>) -> Self {
        let count: u64 = entries.iter().map(|entry| entry.1).sum();
        let spread = |channel: usize| {
            let value = |entry: &Entry| u64::from(entry.0[channel]);
            let sum: u64 = entries.iter().map(|e| value(e) * e.1).sum();
            let squares: u64 = entries.iter().map(|e| value(e) * value(e) * e.1).sum();
            // The square of the sum is beyond 64 bits for pictures of 2^24 pixels.
            let of_mean = u128::from(sum) * u128::from(sum) / u128::from(count.max(1));
            squares - of_mean as u64
        };
        let spreads = [0, 1, 2].map(spread);
        // The first of equal ones.
        let channel = (0..3).rev().max_by_key(|&k| spreads[k]).unwrap_or_default();
        Self { channel, spread: spreads[channel], entries }
    }

    /// The colours up to the mean, and those above it.
    fn halves(mut self) -> [Self; 2] {
        let channel = self.channel;
        let middle = mean(&self.entries)[channel];
        let upper = self.entries.extract_if(.., |entry| entry.0[channel] > middle).collect();
        [Self::new(self.entries), Self::new(upper)]
    }
}

/// Cuts where colours differ most, as often as there are registers.
fn cut(entries: Vec<Entry>) -> Vec<Cut> {
    if entries.is_empty() {
        return Vec::new();
    }
    let mut boxes = vec![Cut::new(entries)];
    while boxes.len() < 256 {
        // The first of equal ones. Colours that are alike in every channel are one.
        let Some(widest) = (0..boxes.len()).rev().max_by_key(|&k| boxes[k].spread) else { break };
        if boxes[widest].entries.len() < 2 {
            break;
        }
        let [lower, upper] = boxes.swap_remove(widest).halves();
        boxes.extend([lower, upper]);
    }
    boxes
}

/// The mean colour, rounded down: never beyond the colours that it is of, so that a cut has something on both sides.
fn mean(entries: &[Entry]) -> [u8; 3] {
    let count: u64 = entries.iter().map(|entry| entry.1).sum();
    [0, 1, 2].map(|channel| {
        let sum: u64 = entries.iter().map(|entry| u64::from(entry.0[channel]) * entry.1).sum();
        (sum / count.max(1)) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_and_many_become_256() {
        let few: Vec<[u8; 3]> = (0..=255).map(|k| [k, k / 2, 255 - k]).collect();
        let palette = Palette::new(few.iter().copied().chain(few.iter().copied()));
        assert_eq!(palette.registers.len(), 256);
        for color in few {
            let register = palette.register(color).unwrap();
            assert_eq!(palette.registers[usize::from(register)], color);
        }
        let many = || (0..40_000_u32).map(|k| [(k % 200) as u8, (k / 200) as u8, 7]);
        let palette = Palette::new(many());
        assert_eq!(palette.registers.len(), 256);
        for color in many() {
            let found = palette.registers[usize::from(palette.register(color).unwrap())];
            // 200 x 200 colours in 256 boxes: about 12.5 of each channel in one.
            assert!(color.iter().zip(found).all(|(&a, b)| a.abs_diff(b) <= 20), "{color:?} {found:?}");
        }
        assert_eq!(palette.register([1, 2, 3]), None);
        assert!(Palette::new(std::iter::empty()).registers.is_empty());
    }

    /// The widest box must be one that can be cut: a count as of a whole picture of one colour is no spread.
    #[test]
    fn one_colour_that_nearly_all_pixels_have_takes_one_register() {
        let pixels = std::iter::repeat_n([9, 9, 9], 5_000_000).chain([[9, 9, 10], [255, 0, 0]]);
        let mut registers = Palette::new(pixels).registers;
        registers.sort_unstable();
        assert_eq!(registers, [[9, 9, 9], [9, 9, 10], [255, 0, 0]]);
    }
}
