//! Curves as tubes, or as lines where they have no width (UsdGeomBasisCurves): linear ones, and cubic ones of Bezier, B-spline and
//! Catmull-Rom bases, open, closed or pinned to their ends.

use super::compose::Composed;
use super::mesh::{Reads, primvar, unit};
use super::tube::{Ring, add_tube};
use crate::mesh_formats::{check_mesh, drawable};
use crate::{Context, LoadError};
use overcoat_scene::{MeshData, PrimitiveKind};

/// Steps along a segment of a cubic curve, and sides of a tube, by how many segments there are at most: a curve is a few pixels
/// wide where there are many.
const DETAIL: [(usize, usize, u32); 4] =
    [(2_000, 8, 12), (20_000, 6, 8), (200_000, 3, 4), (usize::MAX, 2, 3)];

/// Ways between the control points of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Basis {
    Linear,
    Bezier,
    BSpline,
    CatmullRom,
}

/// Ends of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrap {
    Open,
    Closed,
    Pinned,
}

/// Points of a curve that a sample depends on, each with its weight, by their numbers in the curve.
type Weights = [(usize, f64); 6];

/// Segments of a curve.
#[derive(Clone, Copy, Debug)]
struct Curve {
    basis: Basis,
    wrap: Wrap,
    /// Its control points, and the number of the first of all.
    count: usize,
    first: usize,
    /// Number of the curve, and of its first value that varies by segment.
    number: usize,
    first_varying: usize,
}

impl Curve {
    fn segments(&self) -> usize {
        let n = self.count;
        match (self.basis, self.wrap) {
            (_, Wrap::Closed) if n < 3 => 0,
            (Basis::Linear, Wrap::Closed) => n,
            (Basis::Linear, _) => n.saturating_sub(1),
            (Basis::Bezier, Wrap::Closed) => n / 3,
            (Basis::Bezier, _) => n.saturating_sub(1) / 3,
            (_, Wrap::Closed) => n,
            (_, Wrap::Pinned) => n.saturating_sub(1),
            (_, Wrap::Open) => n.saturating_sub(3),
        }
    }

    /// Values that vary by segment.
    fn varying(&self) -> usize {
        let segments = self.segments();
        if self.wrap == Wrap::Closed { segments } else { segments.saturating_add(1) }
    }

    /// Weights at a place of a segment, 0 to 1.
    fn weights(&self, segment: usize, t: f64) -> Weights {
        let s = 1.0 - t;
        let four = match self.basis {
            Basis::Linear => [s, t, 0.0, 0.0],
            Basis::Bezier => [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t],
            Basis::BSpline => [
                s * s * s / 6.0,
                (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0,
                t * t * t / 6.0,
            ],
            Basis::CatmullRom => [
                0.5 * (-t + 2.0 * t * t - t * t * t),
                0.5 * (2.0 - 5.0 * t * t + 3.0 * t * t * t),
                0.5 * (t + 4.0 * t * t - 3.0 * t * t * t),
                0.5 * (t * t * t - t * t),
            ],
        };
        let step = if self.basis == Basis::Bezier { 3 } else { 1 };
        let first = segment.saturating_mul(step);
        // Pinned curves have a point before the first and one behind the last, as far from these as the next.
        let is_pinned = self.wrap == Wrap::Pinned && matches!(self.basis, Basis::BSpline | Basis::CatmullRom);
        let last = self.count.saturating_sub(1);
        let mut out: Weights = [(0, 0.0); 6];
        let mut spare = 4;
        for (k, (slot, weight)) in [0_usize, 1, 2, 3].into_iter().zip(four).enumerate() {
            let point = first.saturating_add(slot);
            let (index, mirrored) = match () {
                () if !is_pinned => (
                    if self.wrap == Wrap::Closed { point.checked_rem(self.count) } else { Some(point) },
                    None,
                ),
                () if point == 0 => (Some(0), Some(1)),
                () if point.saturating_sub(1) > last => (Some(last), Some(last.saturating_sub(1))),
                () => (Some(point.saturating_sub(1)), None),
            };
            let index = index.unwrap_or(0).min(last);
            let own = if mirrored.is_some() { 2.0 * weight } else { weight };
            if let Some(place) = out.get_mut(k) {
                *place = (index, own);
            }
            if let (Some(mirrored), Some(place)) = (mirrored, out.get_mut(spare)) {
                *place = (mirrored, -weight);
                spare = spare.saturating_add(1);
            }
        }
        out
    }
}

/// Elements that values belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Per {
    All,
    Curve,
    Varying,
    Point,
}

/// Values of an attribute.
struct Values<const N: usize> {
    per: Per,
    values: Vec<[f32; N]>,
    indices: Vec<i32>,
}

impl<const N: usize> Values<N> {
    fn read(prim: &Composed, name: &str, [curves, varying, points]: [usize; 3]) -> Option<Self> {
        let found = prim.property(name)?;
        let values = found.value?.tuples::<N>();
        let indices = prim.value(&format!("{name}:indices")).map(|v| v.ints().to_vec()).unwrap_or_default();
        let count = if indices.is_empty() { values.len() } else { indices.len() };
        let per = match found.interpolation.as_deref() {
            Some("constant") => Per::All,
            Some("uniform") => Per::Curve,
            Some("varying") if count != points => Per::Varying,
            // Files that do not say tell by their number.
            _ if count == points => Per::Point,
            _ if count == varying => Per::Varying,
            _ if count == curves => Per::Curve,
            _ => Per::All,
        };
        (!values.is_empty()).then_some(Self { per, values, indices })
    }

    fn get(&self, place: usize) -> [f64; N] {
        let place = match self.indices.get(place) {
            Some(&index) => usize::try_from(index).unwrap_or(usize::MAX),
            None => place,
        };
        self.values.get(place).or(self.values.last()).map_or([0.0; N], |value| value.map(f64::from))
    }

    /// The value at a place of a curve.
    fn at(&self, curve: &Curve, segment: usize, t: f64, weights: &Weights) -> [f64; N] {
        match self.per {
            Per::All => self.get(0),
            Per::Curve => self.get(curve.number),
            Per::Varying => {
                let varying = curve.varying();
                let after = segment.saturating_add(1);
                let after = if after >= varying && curve.wrap == Wrap::Closed { 0 } else { after };
                let [a, b] = [segment, after].map(|k| self.get(curve.first_varying.saturating_add(k)));
                mixed(&[(a, 1.0 - t), (b, t)])
            }
            Per::Point => {
                mixed(&weights.map(|(point, by)| (self.get(curve.first.saturating_add(point)), by)))
            }
        }
    }
}

fn mixed<const N: usize>(parts: &[([f64; N], f64)]) -> [f64; N] {
    let mut out = [0.0; N];
    for (values, by) in parts.iter().filter(|(_, by)| *by != 0.0) {
        out.iter_mut().zip(values).for_each(|(sum, value)| *sum += value * by);
    }
    out
}

/// The curves of a prim as a mesh.
pub(super) struct Curves {
    pub(super) data: MeshData,
    /// Curves that cannot be drawn.
    pub(super) bad: u64,
}

impl Curves {
    pub(super) fn read(prim: &Composed, reads: &Reads, context: &Context<'_>) -> Result<Self, LoadError> {
        let points: Vec<[f32; 3]> = prim.value("points").map(|v| v.tuples()).unwrap_or_default();
        let curves = curves_of(prim, points.len());
        let segments = curves.iter().map(Curve::segments).fold(0, usize::saturating_add);
        let varying = curves.iter().map(Curve::varying).fold(0, usize::saturating_add);
        let sizes = [curves.len(), varying, points.len()];
        let positions = Values { per: Per::Point, values: points, indices: Vec::new() };
        let widths =
            Values::<1>::read(prim, "primvars:widths", sizes).or_else(|| Values::read(prim, "widths", sizes));
        let colors = reads.color.as_ref().and_then(|name| Values::<3>::read(prim, &primvar(name), sizes));
        let opacities = Values::<1>::read(prim, "primvars:displayOpacity", sizes);
        let (_, steps, sides) = DETAIL.into_iter().find(|(most, ..)| segments <= *most).unwrap_or((0, 2, 3));
        let mut out = Self { data: MeshData::default(), bad: 0 };
        // Before any of it is made.
        let rings = (segments as u64).saturating_mul(steps as u64).saturating_add(curves.len() as u64);
        let around = if widths.is_some() { u64::from(sides) } else { 1 };
        check_mesh(
            context,
            rings.saturating_mul(around).saturating_mul(2),
            rings.saturating_mul(around.saturating_add(1)),
        )?;
        if widths.is_none() {
            out.data.kind = PrimitiveKind::Lines;
        }
        for curve in &curves {
            let steps = if curve.basis == Basis::Linear { 1 } else { steps };
            let mut rings = Vec::new();
            for segment in 0..curve.segments() {
                let is_last = segment.saturating_add(1) == curve.segments();
                let end = if is_last { steps.saturating_add(1) } else { steps };
                for step in 0..end {
                    let t = step as f64 / steps as f64;
                    let weights = curve.weights(segment, t);
                    let color = colors.as_ref().map(|values| {
                        let [r, g, b] = values.at(curve, segment, t, &weights).map(|v| unit(v as f32));
                        let opacity = opacities.as_ref().map(|values| values.at(curve, segment, t, &weights));
                        [r, g, b, opacity.map_or(1.0, |[v]| unit(v as f32))]
                    });
                    let width = widths.as_ref().map(|values| values.at(curve, segment, t, &weights)[0]);
                    rings.push(Ring {
                        center: positions.at(curve, segment, t, &weights),
                        radius: width.filter(|width| *width > 0.0).map_or(0.0, |width| 0.5 * width.min(1e15)),
                        color,
                    });
                }
            }
            if rings.is_empty() || !rings.iter().all(|ring| drawable(ring.center.map(|v| v as f32))) {
                out.bad = out.bad.saturating_add(1);
                continue;
            }
            if widths.is_some() {
                add_tube(&mut out.data, &rings, sides, curve.wrap == Wrap::Closed);
            } else {
                add_line(&mut out.data, &rings);
            }
        }
        Ok(out)
    }
}

/// Curves of a prim with so many points.
fn curves_of(prim: &Composed, points: usize) -> Vec<Curve> {
    let is_cubic = prim.text("type").is_none_or(|kind| kind == "cubic");
    let basis = match prim.text("basis").as_deref() {
        _ if !is_cubic => Basis::Linear,
        Some("bspline") => Basis::BSpline,
        Some("catmullRom") => Basis::CatmullRom,
        _ => Basis::Bezier,
    };
    let wrap = match prim.text("wrap").as_deref() {
        Some("periodic") => Wrap::Closed,
        Some("pinned") => Wrap::Pinned,
        _ => Wrap::Open,
    };
    let counts = prim.value("curveVertexCounts");
    let (mut first, mut first_varying) = (0_usize, 0_usize);
    let mut curves = Vec::new();
    for (number, &count) in counts.as_ref().map(|v| v.ints()).unwrap_or_default().iter().enumerate() {
        let count = usize::try_from(count).unwrap_or(0);
        let after = first.saturating_add(count);
        if after > points {
            break;
        }
        let curve = Curve { basis, wrap, count, first, number, first_varying };
        (first, first_varying) = (after, first_varying.saturating_add(curve.varying()));
        curves.push(curve);
    }
    curves
}

/// Adds lines from ring to ring.
fn add_line(data: &mut MeshData, rings: &[Ring]) {
    for (k, ring) in rings.iter().enumerate() {
        let vertex = data.positions.len() as u32;
        data.positions.push(ring.center.map(|v| v as f32));
        data.colors.extend(ring.color);
        if k > 0 {
            data.triangles.push([vertex.saturating_sub(1), vertex, vertex]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(basis: Basis, wrap: Wrap, count: usize) -> Curve {
        Curve { basis, wrap, count, first: 0, number: 0, first_varying: 0 }
    }

    /// The place of a curve whose points are the squares of their numbers.
    fn place(curve: &Curve, segment: usize, t: f64) -> f64 {
        curve.weights(segment, t).into_iter().map(|(k, by)| (k * k) as f64 * by).sum()
    }

    #[test]
    fn curves_have_the_segments_of_their_kind() {
        for (basis, wrap, count, segments, varying) in [
            (Basis::Linear, Wrap::Open, 4, 3, 4),
            (Basis::Linear, Wrap::Closed, 4, 4, 4),
            (Basis::Bezier, Wrap::Open, 7, 2, 3),
            (Basis::Bezier, Wrap::Closed, 6, 2, 2),
            (Basis::BSpline, Wrap::Open, 5, 2, 3),
            (Basis::BSpline, Wrap::Closed, 5, 5, 5),
            (Basis::CatmullRom, Wrap::Pinned, 5, 4, 5),
            (Basis::CatmullRom, Wrap::Open, 3, 0, 1),
            (Basis::Linear, Wrap::Closed, 2, 0, 0),
            (Basis::Bezier, Wrap::Open, 0, 0, 1),
        ] {
            let curve = curve(basis, wrap, count);
            assert_eq!((curve.segments(), curve.varying()), (segments, varying), "{curve:?}");
        }
    }

    #[test]
    fn weights_are_those_of_the_bases() {
        for basis in [Basis::Linear, Basis::Bezier, Basis::BSpline, Basis::CatmullRom] {
            for wrap in [Wrap::Open, Wrap::Closed, Wrap::Pinned] {
                let curve = curve(basis, wrap, 9);
                for segment in 0..curve.segments() {
                    let sum: f64 = curve.weights(segment, 0.3).iter().map(|(_, by)| by).sum();
                    assert!((sum - 1.0).abs() < 1e-12, "{curve:?} {segment} {sum}");
                }
            }
        }
        // Pinned curves begin at the first point and end at the last.
        for basis in [Basis::BSpline, Basis::CatmullRom] {
            let curve = curve(basis, Wrap::Pinned, 5);
            assert!(place(&curve, 0, 0.0).abs() < 1e-12, "{basis:?}");
            assert!((place(&curve, 3, 1.0) - 16.0).abs() < 1e-12, "{basis:?}");
        }
        // Squares are squares again: Catmull-Rom keeps parabolas.
        let through = curve(Basis::CatmullRom, Wrap::Open, 6);
        assert!((place(&through, 1, 0.5) - 6.25).abs() < 1e-12);
        let closed = curve(Basis::Bezier, Wrap::Closed, 6);
        assert_eq!((place(&closed, 1, 0.0), place(&closed, 1, 1.0)), (9.0, 0.0));
    }
}
