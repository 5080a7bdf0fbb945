//! Models that lie far from the origin of their coordinates, as those in coordinates of a map do.
//!
//! Single precision has 24 bits: at 4,600 km it knows half metres. So a file whose model lies many times its own size away
//! from zero is read a second time, in double precision and about an origin in its middle, before numbers become single
//! ones. [`Scene::origin`] says where that is.

use super::text::{Tokens, double};
use super::{LoadError, Loaded};
use overcoat_scene::{Bounds, MeshData, Scene};

/// Powers of ten by which decimals become whole numbers.
const POWERS: [f64; 10] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

/// Point that positions are relative to, in the coordinates of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Origin(pub [f64; 3]);

impl Origin {
    /// A position as seen from there.
    pub(super) fn relative(&self, position: [f64; 3]) -> [f32; 3] {
        let [x, y, z] = position;
        let [ox, oy, oz] = self.0;
        [difference(x, ox), difference(y, oy), difference(z, oz)]
    }
}

/// A number of a file less another, rounded to single precision once.
///
/// A double is off from the decimal that was written by half a unit in its last place, which after the subtraction may be
/// many units of the single. What was written is the shortest decimal within that reach: the model of the same decimals
/// about zero has the same bits.
fn difference(value: f64, origin: f64) -> f32 {
    let plain = value - origin;
    let larger = if value.abs() > origin.abs() { value.abs() } else { origin.abs() };
    let unit = larger * f64::EPSILON;
    let decimal = POWERS.iter().map(|power| (plain * power + 0.5).floor() / power);
    decimal.into_iter().find(|decimal| (decimal - plain).abs() <= unit).unwrap_or(plain) as f32
}

/// The box in which a scene can be seen, in the coordinates of its file, as well as single precision knows them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    bounds: Bounds,
}

impl Region {
    /// The region itself.
    pub(super) fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The region of a scene that is too far away to be drawn well.
    fn of(scene: &Scene) -> Option<Self> {
        let mut bounds = scene.bounds();
        if bounds.is_empty() || bounds.size().iter().all(|&side| side == 0.0) {
            // A model smaller than a step of single precision at that distance may have lost its extent.
            bounds = scene.instances().iter().fold(Bounds::EMPTY, |all, instance| {
                let Some(mesh) = scene.meshes().get(instance.mesh.index()) else { return all };
                let mut own = Bounds::EMPTY;
                mesh.positions().iter().for_each(|&position| own.include(position));
                all.union(&own.transformed(&instance.transform))
            });
        }
        bounds.is_far().then_some(Self { bounds })
    }

    /// The origin for the model, of the points that are in the region: the first of a relief, which is made from a corner, and
    /// the middle of anything else, with few decimals. A model that was moved there is then drawn from the numbers that it
    /// had before.
    pub(super) fn origin(&self, points: impl Iterator<Item = [f64; 3]>) -> Origin {
        let Bounds { min, max } = self.bounds;
        let largest = min.iter().chain(&max).fold(0.0_f64, |m, v| if v.abs() > m { v.abs() } else { m });
        let slack = largest * f64::from(f32::EPSILON);
        let mut found = Bounds::EMPTY;
        let mut first = None;
        for point in points {
            let mut inside = point.iter().zip(min.iter().zip(&max));
            if inside.all(|(v, (low, high))| (low - slack..=high + slack).contains(v)) {
                found = found.union(&Bounds { min: point, max: point });
                first.get_or_insert(point);
            }
        }
        match first {
            None => Origin(self.bounds.round_center()),
            Some(first) if is_corner_of_relief(&first, &found) => Origin(first),
            Some(_) => Origin(found.round_center()),
        }
    }
}

/// True for a corner of the long sides of a box that is neither its highest nor its lowest point.
fn is_corner_of_relief(point: &[f64; 3], Bounds { min, max }: &Bounds) -> bool {
    let sides = point.iter().zip(min.iter().zip(max)).map(|(&v, (&low, &high))| {
        let inside = low < v && v < high || low == high;
        (high - low, inside)
    });
    let (mut height, mut inside_lowest, mut insides) = (f64::INFINITY, false, 0_u8);
    for (size, inside) in sides {
        insides = insides.saturating_add(u8::from(inside));
        if size < height {
            (height, inside_lowest) = (size, inside);
        }
    }
    inside_lowest && insides == 1
}

/// Reads a file as it is and, if the model lies far away, again about an origin in the region where it is.
pub(super) fn load_about(
    load: impl Fn(Option<&Region>) -> Result<Loaded, LoadError>,
) -> Result<Loaded, LoadError> {
    let loaded = load(None)?;
    match Region::of(&loaded.scene) {
        None => Ok(loaded),
        Some(region) => {
            drop(loaded);
            load(Some(&region))
        }
    }
}

/// The numbers behind each of some keyword in a text, in threes.
pub(super) fn points_of_text<'a>(
    bytes: &'a [u8],
    keyword: &'a [u8],
) -> impl Iterator<Item = [f64; 3]> + use<'a> {
    let mut tokens = Tokens::new(bytes);
    std::iter::from_fn(move || {
        loop {
            if !tokens.next()?.eq_ignore_ascii_case(keyword) {
                continue;
            }
            // Tokens that are no point may hold the keyword of the next one.
            let mut ahead = tokens.clone();
            if let [Some(x), Some(y), Some(z)] = [(); 3].map(|()| ahead.next().and_then(double)) {
                tokens = ahead;
                return Some([x, y, z]);
            }
        }
    })
}

/// Measures positions that were stored in single precision from the middle of their box.
pub(super) fn move_positions(data: &mut MeshData, origin: &Origin) {
    for position in &mut data.positions {
        *position = origin.relative(position.map(f64::from));
    }
}

/// Part of a model's extent that the steps of its numbers may take before its shape suffers: half a pixel of a picture
/// of 512.
const COARSE: f64 = 1e-3;

/// Warning about details that a file has lost by storing positions in single precision far from zero; `None` if the
/// loss cannot be seen. `bounds` are those of the model in the file.
pub(super) fn lost_steps(what: &str, bounds: &Bounds) -> Option<String> {
    let extent = bounds.size().into_iter().fold(0.0_f64, |m, v| if v > m { v } else { m });
    let step = bounds.min.iter().zip(&bounds.max).fold(0.0_f64, |most, (low, high)| {
        let larger = (if low.abs() > high.abs() { low.abs() } else { high.abs() }) as f32;
        let step = f64::from(larger.next_up()) - f64::from(larger);
        if step > most { step } else { most }
    });
    (extent > 0.0 && step > COARSE * extent).then(|| {
        format!(
            "{what} are stored in single precision and far from zero, in steps of {step}: {:.2} percent of the model's \
             size, of which the file has lost the details",
            100.0 * step / extent
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_those_of_the_decimals() {
        for (value, origin, expected) in [
            ("652431.45", 652431.25, 0.2_f32),
            ("-6861204.3", -6861204.5, 0.2),
            ("499999.949507", 500000.0, -0.050493),
            ("4599999.019215", 4600000.0, -0.980785),
            ("12", 12.0, 0.0),
            ("1e7", 9999999.5, 0.5),
            // More digits than doubles have there: as well as they know it.
            ("500000.61803398874", 500000.0, 0.618_034),
        ] {
            let found = difference(value.parse().unwrap(), origin);
            assert_eq!(found.to_bits(), expected.to_bits(), "{value} - {origin}: {found}");
        }
        assert!(difference(f64::NAN, 1.0).is_nan() && difference(f64::INFINITY, 1.0).is_infinite());
    }

    /// Singles that were moved in double precision come back.
    #[test]
    fn singles_come_back() {
        let mut state = 1_u32;
        for k in 0..2000_u32 {
            state = state.wrapping_mul(0x9e37_79b1).wrapping_add(0x85eb_ca6b);
            let single = (state >> 8) as f32 / (1 << 20) as f32 - 8.0;
            // Smaller ones have digits that the sum does not.
            if single.abs() < 0.05 {
                continue;
            }
            let origin = f64::from(k) * 4321.0 + 500_000.0;
            assert_eq!(difference(f64::from(single) + origin, origin), single, "{single} {origin}");
        }
    }

    #[test]
    fn reliefs_are_measured_from_their_first_corner() {
        let at = |x: f64, y: f64, z: f64| [652_431.25 + x, 35.1 + y, z - 6_861_204.5];
        let grid = |height: f64| {
            let points = (0..9).map(move |k| [f64::from(k % 3), f64::from(k / 3), f64::from(k)]);
            points.map(move |[x, z, n]| at(x, if n == 0.0 { 0.0 } else { (n - 4.0) * height }, -z))
        };
        let mut bounds = Bounds::EMPTY;
        grid(0.1).for_each(|p| bounds = bounds.union(&Bounds { min: p, max: p }));
        let region = Region { bounds };
        assert_eq!(region.origin(grid(0.1)), Origin(at(0.0, 0.0, 0.0)));
        // From the middle: a block that begins with a corner.
        let block =
            (0..8).map(|k| at(f64::from(k & 1), f64::from(k >> 1 & 1) * 0.25, f64::from(k >> 2) - 1.0));
        assert_eq!(region.origin(block), Origin(at(0.5, 0.125, -0.5)));
    }

    #[test]
    fn numbers_are_found_behind_their_keyword() {
        let text = b"# v 1 2\nv 1 2.5 -3e2\nvn 0 0 1\nv x 1 2\nV 4 5 6 7\nv 1 2";
        let points: Vec<_> = points_of_text(text, b"v").collect();
        assert_eq!(points, [[1.0, 2.5, -300.0], [4.0, 5.0, 6.0]]);
    }

    #[test]
    fn what_is_lost_is_said_where_it_shows() {
        let of = |center: f64, half: f64| Bounds { min: [center - half; 3], max: [center + half; 3] };
        assert_eq!(lost_steps("positions", &of(0.0, 1.0)), None);
        assert_eq!(lost_steps("positions", &of(1000.0, 1.0)), None);
        let said = lost_steps("positions", &of(4_600_000.0, 1.0)).unwrap();
        assert!(said.contains("in steps of 0.5: 25.00 percent"), "{said}");
    }
}
