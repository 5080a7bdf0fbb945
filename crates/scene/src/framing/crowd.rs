//! Bounds of nearly all of a scene, if a few stray parts make it look much larger.
//!
//! Every triangle, line and point has a *reach*: its largest distance, along an axis, from the median of their middles.
//! Strays are the parts of largest reach, if the scene is so much smaller without them as their number asks for:
//!
//! * Points of a cloud: [`LEAST`] times for one of very many, and more for a larger share of up to a tenth. Reconstructions from
//!   photographs have such points. A mast that rises from a cloud is none: what hangs together with the crowd by cells of
//!   a quarter of its reach belongs to it.
//! * Triangles and lines: [`SPECK`] times for one in a hundred (or a single one) with next to no area, and [`PLATE`] times for a
//!   sixth of them, whatever their area: a plate under a model, or a sky around it.

use crate::{Bounds, Mesh, PrimitiveKind, Scene, Transform};
use std::collections::BTreeSet;

/// Nearly all of a scene's triangles, lines and points, close together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crowd {
    /// World-space box around them.
    pub bounds: Bounds,
    /// Triangles, lines and points of the scene that are not among them, at least one.
    pub strays: u64,
    /// All of them.
    pub all: u64,
}

/// Number of primitives that decide whether there can be a crowd, and that decide its reach, at most.
const GLANCE: u64 = 4096;
const LOOKED_AT: u64 = 200_000;

/// Least ratio of the reach of a cloud to that of its crowd, and what a share of strays adds to it, from 0 to 1.
const LEAST: f64 = 3.0;
const SHARE: f64 = 200.0;

/// Ratio for few triangles without area, and for any.
const SPECK: f64 = 20.0;
const PLATE: f64 = 200.0;

/// Largest area of the triangles of a speck, in areas of a side of the cube around the scene.
const NO_AREA: f64 = 0.02;

/// Parts of a mesh follow each other without a gap if the reach of the next is no more than so many times as large.
const GAP: f64 = 1.25;

/// Cells along the reach of a crowd that find what hangs together with it, and their number at most.
const CELLS: f64 = 4.0;
const MOST_CELLS: usize = 1 << 20;

/// A mesh where it stands.
type Part<'a> = (&'a Mesh, &'a Transform);

/// The corners of a triangle; of lines and points, some of them are equal.
type Corners = [[f64; 3]; 3];

impl Scene {
    /// Nearly all of the scene, if that is much smaller than the rest makes it: as a camera frames it, a few far points
    /// or triangles do not count. `None` for others, and for scenes with splats, whose strays are left out of
    /// [`Scene::shown_bounds`].
    #[must_use]
    pub fn crowd(&self) -> Option<Crowd> {
        if !self.splat_instances().is_empty() {
            return None;
        }
        let parts: Vec<Part<'_>> =
            self.seen_instances().map(|i| (&self.meshes[i.mesh.index()], &i.transform)).collect();
        crowd_of(&parts)
    }
}

/// The crowd among the primitives of some meshes.
pub(crate) fn crowd_of(parts: &[Part<'_>]) -> Option<Crowd> {
    let all: u64 = parts.iter().map(|(mesh, _)| mesh.primitive_count() as u64).sum();
    if all < 4 {
        return None;
    }
    let rule = Rule { cloud: parts.iter().all(|(mesh, _)| mesh.kind() == PrimitiveKind::Points) };
    let around = parts.iter().fold(Bounds::EMPTY, |b, (mesh, at)| b.union(&mesh.bounds().transformed(at)));
    let glance = Look::new(parts, all.div_ceil(GLANCE));
    let quarter = glance.reaches.len() / 4;
    if reach_of(&around, &glance.middle) <= rule.least() * glance.reaches[3 * quarter] {
        return None;
    }
    let Look { middle, reaches } = Look::new(parts, all.div_ceil(LOOKED_AT));
    let mut farthest = 0.0_f64;
    for_each(parts, 1, |corners| farthest = farthest.max(reach(corners, &middle)));
    let radius = rule.radius(&reaches, farthest)?;
    let crowd = if rule.cloud {
        connected(parts, &middle, radius, all)?
    } else {
        before_gap(parts, &middle, [radius, farthest], all)?
    };
    (crowd.strays > 0).then_some(crowd)
}

/// The rule by which strays are told from a crowd.
struct Rule {
    /// There are only points.
    cloud: bool,
}

impl Rule {
    /// Least ratio of the reach of all to that of a crowd.
    fn least(&self) -> f64 {
        if self.cloud { LEAST } else { SPECK }
    }

    /// Least ratio for a number of strays among `all`; `None` if these are too many.
    fn ratio(&self, strays: usize, all: usize) -> Option<f64> {
        if self.cloud {
            (strays <= (all / 10).max(1)).then(|| LEAST + SHARE * strays as f64 / all as f64)
        } else if strays <= (all / 100).max(1) {
            Some(SPECK)
        } else {
            (strays <= all / 6).then_some(PLATE)
        }
    }

    /// The reach of the crowd that stands out most, among sorted reaches.
    fn radius(&self, reaches: &[f64], farthest: f64) -> Option<f64> {
        let all = reaches.len();
        let mut best = (1.0, None);
        for (strays, &radius) in reaches.iter().rev().enumerate() {
            let Some(ratio) = self.ratio(strays, all) else { break };
            let score = farthest / (radius * ratio);
            // A crowd in one place cannot be framed.
            if radius > 0.0 && radius < farthest && score > best.0 {
                best = (score, Some(radius));
            }
        }
        best.1
    }
}

/// Some primitives, evenly chosen.
struct Look {
    /// Medians of the middles of their boxes.
    middle: [f64; 3],
    /// Sorted.
    reaches: Vec<f64>,
}

impl Look {
    /// Looks at every `step`-th primitive, at least at one.
    fn new(parts: &[Part<'_>], step: u64) -> Self {
        let step = usize::try_from(step).unwrap_or(usize::MAX);
        let mut boxes: Vec<Bounds> = Vec::new();
        for_each(parts, step, |corners| boxes.push(around(corners)));
        let middle = std::array::from_fn(|k| {
            let mut values: Vec<f64> = boxes.iter().map(|b| b.center()[k]).collect();
            let half = values.len() / 2;
            *values.select_nth_unstable_by(half, f64::total_cmp).1
        });
        let mut reaches: Vec<f64> = boxes.iter().map(|b| reach_of(b, &middle)).collect();
        reaches.sort_unstable_by(f64::total_cmp);
        Self { middle, reaches }
    }
}

/// Calls `f` with every `step`-th primitive of all, beginning with the first.
fn for_each(parts: &[Part<'_>], step: usize, mut f: impl FnMut(&Corners)) {
    let mut skip = 0;
    for (mesh, transform) in parts {
        let at = |v: u32| transform.point(mesh.positions()[v as usize].map(f64::from));
        let count = mesh.primitive_count();
        for number in (skip..count).step_by(step) {
            let corners = match (mesh.kind(), mesh.triangles().get(number)) {
                (PrimitiveKind::Triangles, Some(&[a, b, c])) => [at(a), at(b), at(c)],
                (PrimitiveKind::Lines, Some(&[a, b, _])) => [at(a), at(b), at(b)],
                _ => [at(mesh.point(number)); 3],
            };
            f(&corners);
        }
        // The next one of all, wherever it is.
        let looked_at = count.saturating_sub(skip).div_ceil(step);
        skip = skip.saturating_add(looked_at.saturating_mul(step)).saturating_sub(count);
    }
}

/// The box around a triangle.
fn around(corners: &Corners) -> Bounds {
    corners.iter().fold(Bounds::EMPTY, |all, p| all.union(&Bounds { min: *p, max: *p }))
}

/// The largest distance of a corner along an axis.
fn reach(corners: &Corners, middle: &[f64; 3]) -> f64 {
    reach_of(&around(corners), middle)
}

fn reach_of(b: &Bounds, middle: &[f64; 3]) -> f64 {
    (0..3).fold(0.0_f64, |m, k| m.max((b.max[k] - middle[k]).abs()).max((b.min[k] - middle[k]).abs()))
}

/// The points within a reach, and those that hang together with them.
fn connected(parts: &[Part<'_>], middle: &[f64; 3], radius: f64, all: u64) -> Option<Crowd> {
    let density = CELLS / radius;
    // Conversions saturate: what is so far is alone.
    let cell =
        |p: &[f64; 3]| -> [i32; 3] { std::array::from_fn(|k| ((p[k] - middle[k]) * density).floor() as i32) };
    let mut far: BTreeSet<[i32; 3]> = BTreeSet::new();
    let mut outside = 0_u64;
    for_each(parts, 1, |corners| {
        if reach(corners, middle) > radius {
            outside += 1;
            if far.len() <= MOST_CELLS {
                far.insert(cell(&corners[0]));
            }
        }
    });
    if outside > all / 8 + 1 || far.len() > MOST_CELLS {
        return None;
    }
    let last = CELLS as i32;
    let touches = |cell: &[i32; 3]| cell.iter().all(|c| (-last - 1..=last).contains(c));
    let mut open: Vec<[i32; 3]> = far.iter().copied().filter(touches).collect();
    let mut own: BTreeSet<[i32; 3]> = open.iter().copied().collect();
    while let Some(from) = open.pop() {
        for k in 0..27 {
            let step = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            let next = std::array::from_fn(|a| from[a].saturating_add(step[a]));
            if far.contains(&next) && own.insert(next) {
                open.push(next);
            }
        }
    }
    let mut crowd = Crowd { bounds: Bounds::EMPTY, strays: 0, all };
    for_each(parts, 1, |corners| {
        if reach(corners, middle) <= radius || own.contains(&cell(&corners[0])) {
            crowd.bounds = crowd.bounds.union(&around(corners));
        } else {
            crowd.strays += 1;
        }
    });
    // No gap, if that is nearly all of the cloud's size.
    let whole = parts.iter().fold(Bounds::EMPTY, |b, (mesh, at)| b.union(&mesh.bounds().transformed(at)));
    (reach_of(&crowd.bounds, middle) * LEAST < reach_of(&whole, middle)).then_some(crowd)
}

/// The triangles and lines within a reach, and those that follow without a gap.
fn before_gap(
    parts: &[Part<'_>],
    middle: &[f64; 3],
    [mut radius, farthest]: [f64; 2],
    all: u64,
) -> Option<Crowd> {
    let mut outside: Vec<f64> = Vec::new();
    let most = usize::try_from(all / 6).unwrap_or(usize::MAX).max(1);
    for_each(parts, 1, |corners| {
        let own = reach(corners, middle);
        // One more tells that there are too many.
        if own > radius && outside.len() <= most {
            outside.push(own);
        }
    });
    if outside.len() > most {
        return None;
    }
    outside.sort_unstable_by(f64::total_cmp);
    for own in outside {
        if own <= radius * GAP {
            radius = own;
        }
    }
    let mut crowd = Crowd { bounds: Bounds::EMPTY, strays: 0, all };
    let mut area = 0.0;
    for_each(parts, 1, |corners| {
        if reach(corners, middle) <= radius {
            crowd.bounds = crowd.bounds.union(&around(corners));
        } else {
            crowd.strays += 1;
            area += area_of(corners);
        }
    });
    let strays = usize::try_from(crowd.strays).unwrap_or(usize::MAX);
    let ratio = Rule { cloud: false }.ratio(strays, usize::try_from(all).unwrap_or(usize::MAX))?;
    let covers = area > NO_AREA * (2.0 * farthest) * (2.0 * farthest);
    (radius * if covers { PLATE } else { ratio } <= farthest).then_some(crowd)
}

fn area_of([a, b, c]: &Corners) -> f64 {
    let between = |p: &[f64; 3], q: &[f64; 3]| [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
    let (u, v) = (between(a, b), between(a, c));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    0.5 * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, MeshData};

    fn placed(data: MeshData) -> Scene {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let transform = Transform::IDENTITY;
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        scene
    }

    /// Triangles with a leg of this length at these places, one after the other.
    fn triangles(places: impl Iterator<Item = ([f32; 3], f32)>) -> Scene {
        let corners = |([x, y, z], leg): ([f32; 3], f32)| [[x, y, z], [x + leg, y, z], [x, y + leg, z]];
        let positions: Vec<[f32; 3]> = places.flat_map(corners).collect();
        let triangles = (0..positions.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        placed(MeshData { positions, triangles, ..MeshData::default() })
    }

    fn scene(places: impl Iterator<Item = f32>) -> Scene {
        triangles(places.map(|x| ([x, 0.0, 0.0], 0.1)))
    }

    #[test]
    fn a_stray_triangle_is_told_from_the_crowd() {
        let near = |k: u32| (k % 10) as f32 * 0.1;
        assert_eq!(scene((0..1000).map(near)).crowd(), None);
        let crowd = scene((0..1000).map(near).chain([5000.0])).crowd().unwrap();
        assert_eq!((crowd.strays, crowd.all), (1, 1001));
        assert!(crowd.bounds.max[0] < 1.1, "{crowd:?}");
        // Evenly spread, halves far from each other, and very few are no crowd.
        assert_eq!(scene((0..1000).map(|k| k as f32)).crowd(), None);
        assert_eq!(scene((0..1000).map(|k| near(k) + (k % 2) as f32 * 5000.0)).crowd(), None);
        assert_eq!(scene([0.0, 0.0, 9000.0].into_iter()).crowd(), None);
        // Scenes that are sampled: on average less than one stray is among the samples.
        for strays in [1, 30] {
            let crowd = scene((0..500_000).map(near).chain((0..strays).map(|_| 5000.0))).crowd().unwrap();
            assert_eq!(crowd.strays, strays, "{crowd:?}");
        }
    }

    #[test]
    fn a_plate_counts_up_to_two_hundred_times_the_size_of_its_model() {
        let model = |k: u32| ([k % 10, k / 10 % 10, k / 100].map(|v| v as f32 * 0.1 - 0.5), 0.1);
        let on_plate = |size: f32| {
            let corner = ([-0.5 * size, -0.5 * size, -0.5], size);
            triangles((0..1000).map(model).chain([corner, corner])).crowd()
        };
        for size in [2.0, 20.0, 100.0] {
            assert_eq!(on_plate(size), None, "{size}");
        }
        let crowd = on_plate(1000.0).unwrap();
        assert_eq!((crowd.strays, crowd.bounds.size()[0] < 1.2), (2, true), "{crowd:?}");
        // Small triangles that far are specks, and not a plate.
        for (distance, strays) in [(5.0, None), (50.0, Some(2))] {
            let far = ([distance, 0.0, 0.0], 0.1);
            let crowd = triangles((0..1000).map(model).chain([far, far])).crowd();
            assert_eq!(crowd.map(|crowd| crowd.strays), strays, "{distance}");
        }
    }

    /// Numbers from -1 to 1.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1_u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        }
    }

    fn cloud(count: u32, mut position: impl FnMut(u32) -> [f32; 3]) -> Option<Crowd> {
        let positions = (0..count).map(&mut position).collect();
        placed(MeshData { positions, kind: PrimitiveKind::Points, ..MeshData::default() }).crowd()
    }

    #[test]
    fn far_points_of_a_cloud_are_strays_in_proportion() {
        let mut next = numbers();
        // Numbers of strays of 4000, and ratios of size.
        let mut with = |strays: u32, reach: f32| {
            cloud(4000, |k| {
                let own = if k < strays { reach } else { 1.0 };
                [own * next(), own * next(), own * next()]
            })
        };
        for (strays, reach) in [(1, 8.0), (20, 8.0), (20, 60.0), (200, 60.0), (4, 1e6)] {
            let crowd = with(strays, reach).unwrap_or_else(|| panic!("{strays} within {reach}"));
            // A few lie within the cloud all the same.
            let expected = u64::from(strays) * 3 / 4..=u64::from(strays);
            assert!(expected.contains(&crowd.strays), "{crowd:?}");
            assert!(crowd.bounds.size().iter().all(|v| *v < 3.5), "{crowd:?} of {strays} within {reach}");
        }
        for (strays, reach) in [(0, 1.0), (20, 2.0), (200, 4.0), (2000, 60.0)] {
            assert_eq!(with(strays, reach), None, "{strays} within {reach}");
        }
    }

    #[test]
    fn what_hangs_together_with_a_cloud_belongs_to_it() {
        let mut next = numbers();
        // A mast of one point in fifty, ten times as high as the house.
        let mut house = |k: u32, mast: u32| match k {
            k if k < mast => [0.0, 10.0 * (k as f32 / mast as f32), 0.0],
            _ => [next(), next(), next()],
        };
        assert_eq!(cloud(5000, |k| house(k, 100)), None);
        // Scans are dense about the scanner: distances from 1 to 256.
        let mut next = numbers();
        let scan = cloud(20_000, |_| {
            let (x, z, mut r) = (next(), next(), 1.0_f32);
            for _ in 0..8 {
                r *= 1.5 + 0.5 * next().signum();
            }
            [r * x, 0.1 * next(), r * z]
        });
        assert_eq!(scan, None);
        // Points in one place, and another.
        assert_eq!(cloud(1000, |k| [if k == 5 { 7.0 } else { 0.0 }; 3]), None);
    }
}
