//! Triangles that rays are traced through: those of meshes that stand once as a list, the others by their meshes and places.

use overcoat_core::jobs::Jobs;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{Instance, Mesh, PrimitiveKind, Scene, Transform};
use overcoat_stages::bvh::{Hierarchy, Shared, can_be_shared};
use overcoat_stages::shade::{Emitters, TracedDraw};
use overcoat_stages::shadow;
use std::collections::BTreeMap;

/// Lengths below this part of a scene's size mean nothing: rays start so far off their surface.
const EPSILON: f32 = 3e-6;

/// Bytes that a triangle takes for rays: its corners, and its share of the hierarchy while that is built.
const BYTES_PER_TRIANGLE: u64 = 200;

/// Up to so many triangles all are listed, whatever meshes stand at several places: rays through those of meshes that are kept once
/// take several times as long, since corners are placed anew for each.
const MOST_LISTED: u64 = 1 << 20;

/// Beyond that, triangles that copies of a mesh must have beside the first for it to be kept once.
const LEAST_COPIED: usize = 1 << 14;

/// Bytes that a place of a mesh takes that is kept once.
const BYTES_PER_PLACE: u64 = 512;

/// Triangles of a scene for rays.
#[derive(Debug, Default)]
pub struct TracedScene {
    /// Corners of the triangles that stand once, in world space.
    pub corners: Vec<[[f32; 3]; 3]>,
    /// Draws with triangles, in the order of these.
    pub draws: Vec<TracedDraw>,
    pub hierarchy: Hierarchy,
    /// Distance by which rays start off their surface.
    pub epsilon: f32,
    /// Clear surfaces, which rays pass: triangles in world space, their draws, their hierarchy.
    pub clear_corners: Vec<[[f32; 3]; 3]>,
    pub clear_draws: Vec<TracedDraw>,
    pub clear: Hierarchy,
}

/// The draws whose triangles rays can hit: number, mesh, instance.
fn blocking(scene: &Scene) -> impl Iterator<Item = (u32, &Mesh, &Instance)> {
    shadow::blocking_draws(scene)
        .map(|(draw, instance, _)| (draw, &scene.meshes()[instance.mesh.index()], instance))
}

/// Their numbers, first triangles, and where the corners of these are listed.
fn numbered(scene: &Scene, limits: &Limits) -> Vec<TracedDraw> {
    let mut places = BTreeMap::<usize, usize>::new();
    for (_, _, instance) in blocking(scene) {
        *places.entry(instance.mesh.index()).or_default() += 1;
    }
    let most_listed = MOST_LISTED.min(limits.frame_bytes / (4 * BYTES_PER_TRIANGLE));
    let all = blocking(scene).fold(0_u64, |sum, (_, mesh, _)| sum + mesh.triangles().len() as u64);
    let (mut first, mut listed) = (0_u32, 0_u32);
    let next = |(draw, mesh, instance): (u32, &Mesh, &Instance)| {
        let count = mesh.triangles().len();
        let copies = places.get(&instance.mesh.index()).map_or(0, |places| places - 1);
        let is_copied = all > most_listed && copies.saturating_mul(count) >= LEAST_COPIED;
        let is_shared = is_copied && can_be_shared(&instance.transform);
        let rows = is_shared.then(|| *instance.transform.rows());
        let own = TracedDraw { draw, first, listed, rows };
        first = first.wrapping_add(count as u32);
        listed = listed.wrapping_add(if is_shared { 0 } else { count as u32 });
        own
    };
    blocking(scene).map(next).collect()
}

/// The draws of clear surfaces: blended ones, and those that transmit light.
fn clear(scene: &Scene) -> impl Iterator<Item = (u32, &Mesh, &Instance)> {
    scene.seen_draws().filter_map(|(draw, instance)| {
        let mesh = &scene.meshes()[instance.mesh.index()];
        let is_clear = shadow::tints(&scene.materials()[instance.material.index()]);
        (is_clear && mesh.kind() == PrimitiveKind::Triangles).then_some((draw, mesh, instance))
    })
}

/// Their numbers and first triangles: each is listed where it stands.
fn clear_numbered(scene: &Scene) -> impl Iterator<Item = TracedDraw> {
    let mut first = 0_u32;
    clear(scene).map(move |(draw, mesh, _)| {
        let own = TracedDraw { draw, first, listed: first, rows: None };
        first = first.wrapping_add(mesh.triangles().len() as u32);
        own
    })
}

/// Corners of a mesh's triangles, as a transform places them.
fn placed(mesh: &Mesh, transform: &Transform) -> impl Iterator<Item = [[f32; 3]; 3]> {
    let place = |p: &[f32; 3]| transform.point(p.map(f64::from)).map(|c| c as f32);
    let positions: Vec<[f32; 3]> = mesh.positions().iter().map(place).collect();
    mesh.triangles().iter().map(move |triangle| triangle.map(|v| positions[v as usize]))
}

/// A number, or the largest coordinate of a triangle if that is larger.
fn larger(most: f32, corners: &[[f32; 3]; 3]) -> f32 {
    corners.as_flattened().iter().fold(most, |most, c| if c.abs() > most { c.abs() } else { most })
}

impl TracedScene {
    /// Lists the triangles of opaque and alpha-masked surfaces, and builds their hierarchy.
    pub fn of(scene: &Scene, limits: &Limits, jobs: &Jobs) -> Result<Self, LimitExceeded> {
        let what = || "triangles that rays can hit".to_owned();
        let count: u64 = blocking(scene).map(|(_, mesh, _)| mesh.triangles().len() as u64).sum();
        Limits::check(what, count, Hierarchy::MAX_TRIANGLES as u64, "triangles")?;
        let draws = numbered(scene, limits);
        let mut shared = BTreeMap::<usize, Shared>::new();
        let (mut listed, mut places) = (0, 0);
        for (of, (_, mesh, instance)) in draws.iter().zip(blocking(scene)) {
            let is_known = of.rows.is_some() && shared.contains_key(&instance.mesh.index());
            if of.rows.is_some() {
                let empty = || Shared { triangles: Vec::new(), places: Vec::new() };
                let shared = shared.entry(instance.mesh.index()).or_insert_with(empty);
                shared.places.push((instance.transform, of.first));
                places += 1;
            }
            listed += if is_known { 0 } else { mesh.triangles().len() as u64 };
        }
        let clear_count: u64 = clear(scene).map(|(_, mesh, _)| mesh.triangles().len() as u64).sum();
        Limits::check(what, clear_count, Hierarchy::MAX_TRIANGLES as u64, "triangles")?;
        let bytes = (listed + clear_count)
            .saturating_mul(BYTES_PER_TRIANGLE)
            .saturating_add(places * BYTES_PER_PLACE);
        Limits::check(what, bytes, limits.frame_bytes, "frame_bytes")?;
        for (mesh, shared) in &mut shared {
            shared.triangles.extend(placed(&scene.meshes()[*mesh], &Transform::IDENTITY));
        }
        let once = || draws.iter().zip(blocking(scene)).filter(|(of, _)| of.rows.is_none());
        let mut corners = Vec::new();
        corners.reserve_exact(once().map(|(_, (_, mesh, _))| mesh.triangles().len()).sum());
        for (_, (_, mesh, instance)) in once() {
            corners.extend(placed(mesh, &instance.transform));
        }
        let firsts: Vec<(u32, u32)> = once().map(|(of, _)| (of.listed, of.first)).collect();
        let number_of = |number: u32| {
            let after = firsts.partition_point(|(listed, _)| *listed <= number);
            after
                .checked_sub(1)
                .and_then(|k| firsts.get(k))
                .map_or(0, |(listed, first)| first + (number - listed))
        };
        let shared: Vec<Shared> = shared.into_values().collect();
        let hierarchy = Hierarchy::with_shared(&corners, number_of, &shared, jobs);
        let copies: Vec<_> = draws.iter().zip(blocking(scene)).filter(|(of, _)| of.rows.is_some()).collect();
        let of_copies = jobs.map_each(&copies, |(_, (_, mesh, instance))| {
            placed(mesh, &instance.transform).fold(0.0, |most, corners| larger(most, &corners))
        });
        let listed = corners.iter().fold(0.0, larger);
        let largest = of_copies.into_iter().fold(listed, |most, own| if own > most { own } else { most });
        let mut clear_corners = Vec::new();
        clear_corners.reserve_exact(clear_count as usize);
        for (_, mesh, instance) in clear(scene) {
            clear_corners.extend(placed(mesh, &instance.transform));
        }
        let clear = Hierarchy::new(&clear_corners, jobs);
        let clear_draws = clear_numbered(scene).collect();
        let epsilon = largest * EPSILON;
        Ok(Self { corners, draws, hierarchy, epsilon, clear_corners, clear_draws, clear })
    }

    /// True if it is that of a scene whose blocking triangles are the same: they may be those of other draws.
    pub fn is_of(&self, scene: &Scene, limits: &Limits) -> bool {
        self.draws == numbered(scene, limits) && clear_numbered(scene).eq(self.clear_draws.iter().copied())
    }

    /// Lists the triangles that shine, by materials as they are now.
    pub fn list_emitters(&self, scene: &Scene, emitters: &mut Emitters) {
        emitters.clear(scene.materials().len());
        let shining = || {
            let draws = self.draws.iter().zip(blocking(scene));
            draws.filter_map(|(of, (_, mesh, instance))| {
                let number = instance.material.index();
                let material = &scene.materials()[number];
                let range = of.listed as usize..of.listed as usize + mesh.triangles().len();
                let listed = self.corners.get(range).filter(|_| of.rows.is_none());
                Emitters::shines(material).then_some((instance, mesh, number, material, listed))
            })
        };
        let each = |mesh: &Mesh,
                    instance: &Instance,
                    listed: Option<&[[[f32; 3]; 3]]>,
                    f: &mut dyn FnMut(&[[f32; 3]; 3]) -> bool| {
            match listed {
                Some(listed) => listed.iter().all(f),
                None => placed(mesh, &instance.transform).all(|triangle| f(&triangle)),
            }
        };
        for (instance, mesh, number, _, listed) in shining() {
            each(mesh, instance, listed, &mut |triangle| {
                emitters.count(triangle, number);
                true
            });
        }
        let [x, y, z] = scene.bounds().size();
        emitters.choose((2.0 * (x * y + y * z + z * x)) as f32);
        for (instance, mesh, number, material, listed) in shining() {
            let mirrored = instance.transform.determinant() < 0.0;
            let goes_on = each(mesh, instance, listed, &mut |&[a, b, c]| {
                let corners = if mirrored { [a, c, b] } else { [a, b, c] };
                emitters.add(&corners, number, material)
            });
            if !goes_on {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::jobs::Jobs;
    use overcoat_scene::primitives;

    /// The limit counts enough for the corners, the boxes that they are sorted by, and the hierarchy, whatever the
    /// triangles are like.
    #[test]
    fn triangles_take_no_more_than_is_counted() {
        let mut state = 1_u32;
        let mut number = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut soup = |size: f32| -> Vec<[[f32; 3]; 3]> {
            let corner = |centre: [f32; 3], by: [f32; 3]| std::array::from_fn(|k| centre[k] + size * by[k]);
            let mut point = || std::array::from_fn(|_| number());
            let mut triangle = || {
                let centre = point();
                [(); 3].map(|()| corner(centre, point()))
            };
            (0..20_000).map(|_| triangle()).collect()
        };
        let sphere = primitives::sphere(1.0, 128).unwrap();
        let corners = |t: &[u32; 3]| t.map(|v| sphere.positions()[v as usize]);
        let shapes = [
            ("sphere", sphere.triangles().iter().map(corners).collect()),
            ("small", soup(0.001)),
            ("large", soup(1.0)),
            ("alike", vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 20_000]),
        ];
        let jobs = Jobs::new(2);
        for (name, triangles) in shapes {
            let count = triangles.len() as u64;
            let bytes = Hierarchy::new(&triangles, &jobs).bytes() as u64;
            let own = size_of_val(&triangles[0]) as u64;
            let sorted = 28;
            let all = bytes / count + own + sorted;
            assert!(all <= BYTES_PER_TRIANGLE, "{name}: {all} bytes for each of {count} triangles");
            assert!(all > BYTES_PER_TRIANGLE / 4, "{name}: {all} bytes for each of {count} triangles");
        }
    }
}
