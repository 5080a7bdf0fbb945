//! Values between key frames: appendix C of the specification.

use overcoat_core::math::double::{atan2, sin};
use std::num::NonZeroUsize;

/// Interpolation between key frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// The value of the key frame before.
    Step,
    /// Along a line; rotations along the shorter arc.
    Linear,
    /// Along a Hermite spline; each key frame has an in-tangent, a value and an out-tangent.
    CubicSpline,
}

impl Interpolation {
    /// Values of a key frame.
    pub(super) fn parts(self) -> usize {
        match self {
            Self::Step | Self::Linear => 1,
            Self::CubicSpline => 3,
        }
    }
}

/// Values over time.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// Ascending, finite; at least one.
    times: Vec<f32>,
    /// `width` numbers for each time, or three times as many.
    values: Vec<f32>,
    width: NonZeroUsize,
    interpolation: Interpolation,
    /// Values are unit quaternions.
    rotation: bool,
}

impl Curve {
    /// A curve of the key frames whose times are ascending: one that is not later than all before, or no finite number,
    /// is left out. Also gives how many were. `None` if none is left, or if they have no numbers. There are as many
    /// values as there have to be.
    pub(super) fn new(
        mut times: Vec<f32>,
        mut values: Vec<f32>,
        width: usize,
        interpolation: Interpolation,
        rotation: bool,
    ) -> (Option<Self>, usize) {
        let Some(width) = NonZeroUsize::new(width) else { return (None, 0) };
        let mut last = f32::NEG_INFINITY;
        let mut ascends = |&time: &f32| {
            let later = time.is_finite() && time > last;
            last = if later { time } else { last };
            later
        };
        let kept: Vec<bool> = times.iter().map(&mut ascends).collect();
        let lost = kept.iter().filter(|&&kept| !kept).count();
        if lost > 0 {
            let each = width.get().saturating_mul(interpolation.parts());
            let mut of_times = kept.iter();
            let mut of_values = kept.iter().flat_map(|kept| std::iter::repeat_n(kept, each));
            times.retain(|_| of_times.next() == Some(&true));
            values.retain(|_| of_values.next() == Some(&true));
        }
        let curve = (!times.is_empty()).then_some(Self { times, values, width, interpolation, rotation });
        (curve, lost)
    }

    /// Seconds of the key frames, ascending.
    pub(super) fn times(&self) -> &[f32] {
        &self.times
    }

    /// The time of the last key frame.
    pub(super) fn end(&self) -> f64 {
        self.times.last().copied().map_or(0.0, f64::from)
    }

    /// The values at a time. Before the first key frame they are that one's, after the last that one's.
    pub(super) fn at(&self, time: f64) -> Vec<f64> {
        // The first key frame that is later.
        let next = self.times.partition_point(|&t| f64::from(t) <= time);
        let (before, next) = (next.checked_sub(1).and_then(|k| self.key(k)), self.key(next));
        match (before, next) {
            (Some(before), Some(next)) => self.between(&before, &next, time),
            (Some(only), None) | (None, Some(only)) => self.finished(numbers(only.value).collect()),
            (None, None) => Vec::new(),
        }
    }

    /// The values at a time between those of two key frames.
    fn between(&self, before: &Key<'_>, next: &Key<'_>, time: f64) -> Vec<f64> {
        let step = next.time - before.time;
        let u = (time - before.time) / step;
        let values = numbers(before.value).zip(numbers(next.value));
        match self.interpolation {
            Interpolation::Step => self.finished(numbers(before.value).collect()),
            Interpolation::Linear => match (before.value.first_chunk(), next.value.first_chunk()) {
                (Some(from), Some(to)) if self.rotation => {
                    slerp(from.map(f64::from), to.map(f64::from), u).to_vec()
                }
                _ => values.map(|(a, b)| a + (b - a) * u).collect(),
            },
            Interpolation::CubicSpline => {
                let (square, cube) = (u * u, u * u * u);
                let tangents = numbers(before.leaving).zip(numbers(next.arriving));
                let mix = |((p0, p1), (m0, m1)): ((f64, f64), (f64, f64))| {
                    let (m0, m1) = (step * m0, step * m1);
                    (2.0 * cube - 3.0 * square + 1.0) * p0
                        + (cube - 2.0 * square + u) * m0
                        + (3.0 * square - 2.0 * cube) * p1
                        + (cube - square) * m1
                };
                self.finished(values.zip(tangents).map(mix).collect())
            }
        }
    }

    /// A key frame by its number.
    fn key(&self, k: usize) -> Option<Key<'_>> {
        let time = f64::from(*self.times.get(k)?);
        let mut parts =
            self.values.chunks_exact(self.width.get()).skip(k.checked_mul(self.interpolation.parts())?);
        let nothing: &[f32] = &[];
        Some(match self.interpolation {
            Interpolation::Step | Interpolation::Linear => {
                Key { time, arriving: nothing, value: parts.next()?, leaving: nothing }
            }
            Interpolation::CubicSpline => {
                Key { time, arriving: parts.next()?, value: parts.next()?, leaving: parts.next()? }
            }
        })
    }

    /// A rotation at length 1, other values as they are.
    fn finished(&self, mut values: Vec<f64>) -> Vec<f64> {
        if self.rotation
            && let Some(four) = values.first_chunk_mut::<4>()
        {
            *four = normalized(*four);
        }
        values
    }
}

/// A time with its values.
struct Key<'a> {
    time: f64,
    /// The in-tangent.
    arriving: &'a [f32],
    value: &'a [f32],
    /// The out-tangent.
    leaving: &'a [f32],
}

fn numbers(values: &[f32]) -> impl Iterator<Item = f64> {
    values.iter().copied().map(f64::from)
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

/// A quaternion at length 1; the identity in place of one without a direction.
fn normalized(q: [f64; 4]) -> [f64; 4] {
    let length = dot(q, q).sqrt();
    if length > 1e-150 && length.is_finite() { q.map(|v| v / length) } else { [0.0, 0.0, 0.0, 1.0] }
}

/// Spherical linear interpolation along the shorter arc.
fn slerp(a: [f64; 4], b: [f64; 4], u: f64) -> [f64; 4] {
    let (a, b) = (normalized(a), normalized(b));
    let b = if dot(a, b) < 0.0 { b.map(|v| -v) } else { b };
    let norm = |q: [f64; 4]| dot(q, q).sqrt();
    let difference = norm(combine(a, b, |a, b| b - a));
    let sum = norm(combine(a, b, |a, b| b + a));
    // Well-conditioned for every angle, unlike the arc cosine (W. Kahan).
    let angle = 2.0 * atan2(difference, sum);
    let whole = sin(angle);
    // The line deviates from the arc by less than the rounding of double precision.
    let (from, to) =
        if angle < 1e-7 { (1.0 - u, u) } else { (sin((1.0 - u) * angle) / whole, sin(u * angle) / whole) };
    normalized(combine(a, b, |a, b| from * a + to * b))
}

/// `f` of each number of two quaternions.
fn combine([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4], f: impl Fn(f64, f64) -> f64) -> [f64; 4] {
    [f(ax, bx), f(ay, by), f(az, bz), f(aw, bw)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(times: &[f32], values: &[f32], width: usize, interpolation: Interpolation) -> Curve {
        Curve::new(times.to_vec(), values.to_vec(), width, interpolation, false).0.unwrap()
    }

    #[test]
    fn steps_lines_and_ends() {
        let values = [1.0, 10.0, 3.0, 20.0, 7.0, -20.0];
        let step = curve(&[1.0, 2.0, 4.0], &values, 2, Interpolation::Step);
        let line = curve(&[1.0, 2.0, 4.0], &values, 2, Interpolation::Linear);
        for (time, stepped, linear) in [
            (-5.0, [1.0, 10.0], [1.0, 10.0]),
            (1.0, [1.0, 10.0], [1.0, 10.0]),
            (1.5, [1.0, 10.0], [2.0, 15.0]),
            (2.0, [3.0, 20.0], [3.0, 20.0]),
            (3.5, [3.0, 20.0], [6.0, -10.0]),
            (4.0, [7.0, -20.0], [7.0, -20.0]),
            (1e300, [7.0, -20.0], [7.0, -20.0]),
        ] {
            assert_eq!(step.at(time), stepped, "{time}");
            assert_eq!(line.at(time), linear, "{time}");
        }
        assert_eq!((step.end(), line.end()), (4.0, 4.0));
    }

    /// A cubic polynomial is its own spline: p(t) = t^3 - 2 t, with tangents 3 t^2 - 2.
    #[test]
    fn splines_reproduce_cubics() {
        let p = |t: f64| t * t * t - 2.0 * t;
        let d = |t: f64| 3.0 * t * t - 2.0;
        let times = [0.0, 1.5, 2.0_f32];
        let keys: Vec<f32> =
            times.iter().flat_map(|&t| [d(t.into()), p(t.into()), d(t.into())].map(|v| v as f32)).collect();
        let spline = curve(&times, &keys, 1, Interpolation::CubicSpline);
        for k in 0..=40 {
            let t = f64::from(k) * 0.05;
            assert!((spline.at(t)[0] - p(t)).abs() < 1e-6, "{t}");
        }
        assert_eq!(spline.at(9.0), [4.0]);
    }

    fn about_z(degrees: f64) -> [f32; 4] {
        let (s, c) = overcoat_core::math::double::sin_cos(degrees.to_radians() * 0.5);
        [0.0, 0.0, s as f32, c as f32]
    }

    #[test]
    fn rotations_turn_evenly_the_short_way() {
        let turn = |from: f64, to: f64, flip: f32, u: f64| {
            let mut values = about_z(from).to_vec();
            values.extend(about_z(to).map(|v| flip * v));
            let curve = Curve::new(vec![0.0, 1.0], values, 4, Interpolation::Linear, true).0.unwrap();
            let q = curve.at(u);
            // Both signs of a quaternion are the same rotation.
            let sign = if q[3] < 0.0 { -1.0 } else { 1.0 };
            (2.0 * atan2(sign * q[2], sign * q[3])).to_degrees()
        };
        for flip in [1.0, -1.0] {
            for u in [0.0, 0.1, 0.5, 0.75, 1.0] {
                assert!((turn(0.0, 120.0, flip, u) - 120.0 * u).abs() < 1e-4, "{flip} {u}");
            }
            // 350 degrees forwards are 10 backwards.
            assert!((turn(0.0, 350.0, flip, 0.5) + 5.0).abs() < 1e-4);
            assert!((turn(10.0, 10.0 + 1e-6, flip, 0.5) - 10.0).abs() < 1e-4);
        }
    }

    #[test]
    fn rotations_are_normalised_and_zero_is_none() {
        let values = vec![0.0, 0.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0];
        let curve = Curve::new(vec![0.0, 1.0], values, 4, Interpolation::Step, true).0.unwrap();
        assert_eq!(curve.at(0.5), [0.0, 0.0, 0.6, 0.8]);
        assert_eq!(curve.at(1.5), [0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn key_frames_that_go_back_are_left_out() {
        let times = vec![f32::NAN, 1.0, 0.5, 1.0, f32::INFINITY, 2.0, 1.5];
        let values = (0..7).map(|v| v as f32).collect();
        let (curve, lost) = Curve::new(times, values, 1, Interpolation::Linear, false);
        let curve = curve.unwrap();
        assert_eq!(
            (curve.times.as_slice(), curve.values.as_slice(), lost),
            (&[1.0, 2.0][..], &[1.0, 5.0][..], 5)
        );
        // All numbers of a key frame go with it: tangents too.
        let values = (0..18).map(|v| v as f32).collect();
        let (spline, lost) = Curve::new(vec![1.0, 0.0, 3.0], values, 2, Interpolation::CubicSpline, false);
        let spline = spline.unwrap();
        assert_eq!((spline.at(1.0), spline.at(3.0), lost), (vec![2.0, 3.0], vec![14.0, 15.0], 1));
        let (none, lost) = Curve::new(vec![f32::NAN], vec![0.0], 1, Interpolation::Step, false);
        assert!(none.is_none() && lost == 1);
        assert!(Curve::new(Vec::new(), Vec::new(), 1, Interpolation::Step, false).0.is_none());
    }
}
