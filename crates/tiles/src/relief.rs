//! Relief: factors by which surfaces are drawn darker or lighter, of the shape around them, found before the picture is drawn.

use overcoat_core::math::lanes::LANES;
use overcoat_stages::gbuffer::{Batch, Draw};

/// A factor for each pixel, and the instance whose surface it is for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Relief {
    width: usize,
    /// Factor of the light, and the number of the instance plus 1; 0 where nothing changes.
    pixels: Vec<(f32, u32)>,
}

impl Relief {
    /// Factors of a picture that is `width` pixels wide, row by row, each with the number of the instance plus 1, or 0.
    #[must_use]
    pub fn new(width: usize, pixels: Vec<(f32, u32)>) -> Self {
        Self { width, pixels }
    }

    /// Factor for a surface of an instance at a pixel: that of the pixel's centre, or, where the centre shows another instance, the
    /// least of the pixels around that show this one, so that outlines are as dark as what they belong to. 1 elsewhere.
    #[must_use]
    pub fn factor(&self, [x, y]: [u32; 2], instance: u32) -> f32 {
        let (x, y, wanted) = (x as usize, y as usize, instance.saturating_add(1));
        let at = |x: usize, y: usize| {
            let pixel = (x < self.width).then(|| self.pixels.get(y * self.width + x)).flatten();
            pixel.filter(|(_, own)| *own == wanted).map(|(factor, _)| *factor)
        };
        if let Some(own) = at(x, y) {
            return own;
        }
        let around =
            (y.saturating_sub(1)..=y + 1).flat_map(|y| (x.saturating_sub(1)..=x + 1).map(move |x| (x, y)));
        let least = around
            .filter_map(|(x, y)| at(x, y))
            .fold(f32::INFINITY, |least, f| if f < least { f } else { least });
        if least.is_finite() { least } else { 1.0 }
    }

    /// Factors of the fragments of a batch in the tile with this corner: those before `opaque` in the list, and 1 for others and for
    /// the lines of edges.
    pub(super) fn factors(
        &self,
        corner: [u32; 2],
        batch: &Batch,
        draws: &[Draw<'_>],
        indices: &[u32],
        opaque: usize,
    ) -> [f32; LANES] {
        let mut factors = [1.0; LANES];
        for (k, (factor, index)) in factors.iter_mut().zip(indices).enumerate() {
            let draw = &draws[batch.vertices.draw(k) as usize];
            if (*index as usize) < opaque && draw.edges.is_none() {
                let fragment = &batch.fragments[k];
                let pixel = [corner[0] + fragment.column(), corner[1] + fragment.row()];
                *factor = self.factor(pixel, draw.instance);
            }
        }
        factors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_that_of_the_instance() {
        let nothing = (1.0, 0);
        let relief = Relief::new(3, vec![(0.5, 1), (0.75, 1), nothing, (0.9, 2), (0.8, 2), nothing]);
        assert_eq!(relief.factor([0, 0], 0), 0.5);
        assert_eq!(relief.factor([1, 1], 1), 0.8);
        // Beside it, the least of those around; farther away and outside of the picture, none.
        assert_eq!(relief.factor([2, 0], 0), 0.75);
        assert_eq!(relief.factor([0, 1], 0), 0.5);
        assert_eq!(relief.factor([2, 0], 1), 0.8);
        assert_eq!(relief.factor([2, 1], 2), 1.0);
        assert_eq!(relief.factor([9, 9], 0), 1.0);
        assert_eq!(Relief::default().factor([0, 0], 0), 1.0);
        assert_eq!(relief.factor([0, 0], u32::MAX), 1.0);
    }
}
