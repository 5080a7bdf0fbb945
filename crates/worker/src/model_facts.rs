//! Counts, size and colours of a model, for catalogues of many.

use crate::picture_task::Pixels;
use overcoat_core::frame::{DisplayImage, DisplayOptions};
use overcoat_scene::{PrimitiveKind, Scene};
use serde::{Deserialize, Serialize};

/// Colours that are told at most.
const COLORS: usize = 5;
/// Least share of a colour that is told, in hundredths of the object's pixels.
const LEAST: u64 = 4;
/// Pixels that are looked at, about: those of a picture of 256 x 256.
const PIXELS: usize = 1 << 16;

/// Counts, size and colours of a model. Fields are only ever added.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelFacts {
    /// Triangles, every instance counted.
    pub triangles: u64,
    /// Lines, every instance counted.
    pub lines: u64,
    /// Points, every instance counted.
    pub points: u64,
    /// Gaussian splats, every instance counted.
    pub splats: u64,
    /// Vertices of all meshes, each counted once.
    pub vertices: u64,
    /// Meshes.
    pub meshes: u64,
    /// Places at which meshes stand.
    pub instances: u64,
    /// Materials.
    pub materials: u64,
    /// Textures.
    pub textures: u64,
    /// Width, height and depth in metres, Y up; absent if nothing is drawn.
    pub extent: Option<[f64; 3]>,
    /// Colours that most of the object has in the picture, the commonest first.
    pub colors: Vec<DominantColor>,
}

/// A colour of a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DominantColor {
    /// Mean of the pixels, sRGB: `#rrggbb`.
    pub color: String,
    /// Their share of the object's pixels, 0 to 1.
    pub share: f64,
}

impl ModelFacts {
    /// Facts of a model, and of its picture.
    #[must_use]
    pub fn new(scene: &Scene, pixels: &Pixels, display: &DisplayOptions) -> Self {
        let bounds = scene.bounds();
        let count = |kind| scene.count_of(kind);
        let colors = match pixels {
            Pixels::Image(image) => dominant(image.as_bytes()),
            Pixels::Frame(frame) => dominant(DisplayImage::new(frame, display).as_bytes()),
        };
        Self {
            triangles: count(PrimitiveKind::Triangles),
            lines: count(PrimitiveKind::Lines),
            points: count(PrimitiveKind::Points),
            splats: scene.splat_count(),
            vertices: scene.meshes().iter().map(|mesh| mesh.positions().len() as u64).sum(),
            meshes: scene.meshes().len() as u64,
            instances: scene.instances().len() as u64,
            materials: scene.materials().len() as u64,
            textures: scene.textures().len() as u64,
            extent: (!bounds.is_empty()).then(|| std::array::from_fn(|k| bounds.max[k] - bounds.min[k])),
            colors,
        }
    }
}

/// Sum of the pixels of one cell of the colour cube.
#[derive(Clone, Copy, Default)]
struct Cell {
    count: u64,
    sum: [u64; 3],
}

/// The commonest colours of the pixels that are more opaque than not and unlike the picture's corner: means of the fullest cells of a cube
/// of 8 x 8 x 8 (the popularity algorithm; Heckbert, "Color Image Quantization for Frame Buffer Display", 1982), where cells that touch one
/// already taken count to that.
fn dominant(pixels: &[u8]) -> Vec<DominantColor> {
    let corner = pixels.get(..4).unwrap_or_default();
    let mut cells = vec![Cell::default(); 512];
    let mut all = 0;
    let step = (pixels.len() / 4 / PIXELS).max(1);
    let object = pixels.chunks_exact(4).step_by(step).filter(|pixel| pixel[3] >= 128 && *pixel != corner);
    for pixel in object {
        let index = pixel[..3].iter().fold(0, |index, value| index << 3 | usize::from(value >> 5));
        cells[index].count += 1;
        (0..3).for_each(|k| cells[index].sum[k] += u64::from(pixel[k]));
        all += 1;
    }
    let mut order: Vec<usize> = (0..cells.len()).filter(|index| cells[*index].count > 0).collect();
    order.sort_by_key(|index| (std::cmp::Reverse(cells[*index].count), *index));
    let mut taken: Vec<(usize, Cell)> = Vec::new();
    for index in order {
        match taken.iter_mut().find(|(other, _)| touch(*other, index)) {
            Some((_, cell)) => {
                cell.count += cells[index].count;
                (0..3).for_each(|k| cell.sum[k] += cells[index].sum[k]);
            }
            None => taken.push((index, cells[index])),
        }
    }
    taken.sort_by_key(|(index, cell)| (std::cmp::Reverse(cell.count), *index));
    let common = taken.iter().map(|(_, cell)| cell).filter(|cell| cell.count * 100 >= all * LEAST);
    common
        .take(COLORS)
        .map(|Cell { count, sum }| {
            let [r, g, b] = sum.map(|sum| (sum + count / 2) / count);
            let share = (count * 1000 + all / 2) / all;
            DominantColor { color: format!("#{r:02x}{g:02x}{b:02x}"), share: share as f64 / 1000.0 }
        })
        .collect()
}

/// True if two cells of the cube have a face, an edge or a corner in common.
fn touch(a: usize, b: usize) -> bool {
    [0, 3, 6].iter().all(|shift| ((a >> shift) & 7).abs_diff((b >> shift) & 7) <= 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(pixel: impl Fn(usize) -> [u8; 4]) -> Vec<(String, f64)> {
        let pixels: Vec<u8> = (0..64).flat_map(pixel).collect();
        dominant(&pixels).into_iter().map(|color| (color.color, color.share)).collect()
    }

    #[test]
    fn common_colors_of_the_object_are_told() {
        // Half of the picture is transparent, a quarter red, a quarter of two blues that touch.
        let colors = of(|k| match k / 16 {
            0 | 1 => [0, 0, 0, 20],
            2 => [255, 0, 0, 255],
            _ => [0, 0, if k % 2 == 0 { 220 } else { 250 }, 255],
        });
        let [red, blue] =
            [("#ff0000", 0.5), ("#0000eb", 0.5)].map(|(color, share)| (color.to_owned(), share));
        assert!(colors.len() == 2 && colors.contains(&red) && colors.contains(&blue), "{colors:?}");
        // A ground of one colour is none of the object's, and rare colours are none.
        assert_eq!(of(|k| if k == 40 { [255; 4] } else { [51, 51, 51, 255] }), [("#ffffff".to_owned(), 1.0)]);
        assert!(of(|_| [51, 51, 51, 255]).is_empty() && of(|_| [0; 4]).is_empty());
        let rare = of(|k| match k {
            0 => [0; 4],
            1 => [255; 4],
            _ => [0, 255, 0, 255],
        });
        assert_eq!(rare, [("#00ff00".to_owned(), 0.984)]);
    }
}
