//! Reach of lights with a range on the picture.
//!
//! A light with a range adds exactly nothing at and beyond that distance. Its reach on the picture is a rectangle of cells of
//! 16 x 16 pixels around the projected sphere: tiles leave out the lights whose rectangles they lie outside of, and the
//! limit on shading counts a light in the cells of its own. Both follow from the camera and the light alone, and no tile is
//! smaller than a cell.

use overcoat_stages::geometry::View;
use overcoat_stages::light::PunctualLight;

/// The side of a cell in pixels.
pub const CELL: u32 = 16;

/// Columns and rows of cells, half open: first column, first row, ends.
type Cells = [u32; 4];

/// The reaches of all lights of a picture.
#[derive(Debug, Default)]
pub struct Reach {
    /// The cells of each light; `None` if it shines everywhere.
    lights: Vec<Option<Cells>>,
    /// Number of lights that shine everywhere.
    everywhere: u64,
    /// Number of the other lights that shine on each cell; empty if there are none.
    cells: Vec<u32>,
    columns: u32,
}

impl Reach {
    /// Finds them, in place of what was there.
    pub fn find(&mut self, lights: &[PunctualLight], view: &View) {
        let Self { lights: reaches, everywhere, cells, columns } = self;
        let rows = view.height.div_ceil(CELL);
        *columns = view.width.div_ceil(CELL);
        reaches.clear();
        reaches.extend(lights.iter().map(|light| {
            let (position, range) = light.reach()?;
            cells_of(view, position, range)
        }));
        *everywhere = reaches.iter().filter(|reach| reach.is_none()).count() as u64;
        cells.clear();
        if *everywhere == lights.len() as u64 {
            return;
        }
        cells.resize(*columns as usize * rows as usize, 0);
        for [left, top, right, bottom] in reaches.iter().flatten() {
            for row in *top..*bottom {
                let start = row as usize * *columns as usize;
                for count in &mut cells[start + *left as usize..start + *right as usize] {
                    *count += 1;
                }
            }
        }
    }

    /// True if every light shines everywhere.
    #[inline(always)]
    pub fn is_uniform(&self) -> bool {
        self.cells.is_empty()
    }

    /// Number of lights that shine on all pixels.
    #[inline(always)]
    pub fn everywhere(&self) -> u64 {
        self.everywhere
    }

    /// Number of lights that shine on a pixel.
    #[inline(always)]
    pub fn count(&self, x: u32, y: u32) -> u64 {
        if self.cells.is_empty() {
            return self.everywhere;
        }
        self.everywhere + u64::from(self.cells[((y / CELL) * self.columns + x / CELL) as usize])
    }

    /// The lights that shine on a rectangle of pixels (left, top, width, height), in their order.
    pub fn lights_of(
        &self,
        [left, top, width, height]: [u32; 4],
        lights: &[PunctualLight],
        out: &mut Vec<PunctualLight>,
    ) {
        let [right, bottom] = [(left + width).div_ceil(CELL), (top + height).div_ceil(CELL)];
        let [left, top] = [left / CELL, top / CELL];
        out.clear();
        out.extend(lights.iter().zip(&self.lights).filter_map(|(light, reach)| match reach {
            Some(of) if of[0] >= right || of[1] >= bottom || of[2] <= left || of[3] <= top => None,
            _ => Some(*light),
        }));
    }
}

/// The cells that may see points closer to a position than `range`; `None` for all.
fn cells_of(view: &View, position: [f32; 3], range: f64) -> Option<Cells> {
    let from_eye: [f64; 3] = std::array::from_fn(|k| f64::from(position[k]) - view.eye[k]);
    let along = |axis: &[f64; 3]| axis[0] * from_eye[0] + axis[1] * from_eye[1] + axis[2] * from_eye[2];
    let [right, up, back] = &view.axes;
    let [x, y, depth] = [along(right), -along(up), -along(back)];
    // Surfaces lie where single precision has them.
    let size = view.eye.iter().chain(&from_eye).fold(0.0_f64, |most, v| most.max(v.abs()));
    let radius = range * 1.001 + size * 1e-5;
    let (near, far) = (depth - radius, depth + radius);
    if !(x.is_finite() && y.is_finite() && far.is_finite()) {
        return None;
    }
    let distances = if view.perspective {
        if far <= 0.0 {
            return Some([0; 4]);
        }
        // The sphere must lie in front of the eye, or its outline is no ellipse.
        if near <= far * 1e-6 {
            return None;
        }
        [near, far]
    } else {
        [1.0; 2]
    };
    // The box around the sphere holds it.
    let span = |center: f64, side: u32, axis: usize| {
        let scales = distances.map(|distance| view.scale[axis] / distance);
        let (low, high) = (center - radius, center + radius);
        let principal = f64::from(side) * 0.5 + view.principal[axis];
        let first = (low * scales[0]).min(low * scales[1]) + principal - 1.0;
        let end = (high * scales[0]).max(high * scales[1]) + principal + 1.0;
        let cells = f64::from(side.div_ceil(CELL));
        let cell = f64::from(CELL);
        [(first / cell).floor().clamp(0.0, cells) as u32, (end / cell).ceil().clamp(0.0, cells) as u32]
    };
    let ([left, end_column], [top, end_row]) = (span(x, view.width, 0), span(y, view.height, 1));
    Some([left, top, end_column, end_row])
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::{Camera, Light, LightKind, Projection};

    fn view(perspective: bool) -> View {
        let projection = if perspective {
            Projection::Perspective { fov_y: std::f32::consts::FRAC_PI_2 }
        } else {
            Projection::Orthographic { height: 20.0 }
        };
        let camera = Camera::new([0.0, 0.0, 10.0], [0.0; 3], [0.0, 1.0, 0.0], projection, 0.1);
        View::new(&camera, 128, 96).unwrap()
    }

    fn lamp(position: [f32; 3], range: Option<f32>) -> PunctualLight {
        PunctualLight::new(&Light::new(LightKind::Point { position, range })).unwrap()
    }

    #[test]
    fn lights_are_listed_where_they_shine() {
        let sun = LightKind::Directional { direction: [0.0, 0.0, -1.0] };
        let sun = PunctualLight::new(&Light::new(sun)).unwrap();
        let lights = [
            lamp([0.0, 0.0, 0.0], Some(1.0)),
            sun,
            lamp([9.0, 0.0, 0.0], Some(0.5)),
            lamp([0.0, 0.0, 9.5], Some(1.0)),
            lamp([0.0, 0.0, 30.0], Some(1.0)),
            lamp([0.0; 3], None),
        ];
        for perspective in [false, true] {
            let mut reach = Reach::default();
            reach.find(&lights, &view(perspective));
            let list = |pixels| {
                let mut out = Vec::new();
                reach.lights_of(pixels, &lights, &mut out);
                let number = |light: &PunctualLight| lights.iter().position(|l| l == light).unwrap();
                out.iter().map(number).collect::<Vec<_>>()
            };
            // That around the eye is everywhere in perspective; without perspective what is behind the eye is not told
            // apart.
            let middle = if perspective { vec![0, 1, 3, 5] } else { vec![0, 1, 3, 4, 5] };
            assert_eq!(list([48, 32, 32, 32]), middle, "{perspective}");
            let corner = if perspective { vec![1, 3, 5] } else { vec![1, 5] };
            assert_eq!(list([0, 0, 16, 16]), corner, "{perspective}");
            assert_eq!(list([96, 32, 32, 32])[..2], [1, 2], "{perspective}");
            assert_eq!(reach.count(0, 0), corner.len() as u64);
            assert_eq!(reach.count(64, 48), middle.len() as u64);
            // A tile has what its cells have.
            let all = list([0, 0, 128, 96]).len() as u64;
            assert!((0..128).all(|x| (0..96).all(|y| reach.count(x, y) <= all)));
        }
    }

    #[test]
    fn without_ranges_nothing_is_listed_by_cells() {
        let mut reach = Reach::default();
        let lights = [lamp([0.0; 3], None), lamp([5.0; 3], Some(1e30))];
        reach.find(&lights, &view(true));
        assert!(reach.is_uniform() && reach.count(100, 3) == 2);
    }
}
