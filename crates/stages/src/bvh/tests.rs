//! Hierarchies against looking at every triangle.

use super::{Hierarchy, Hit, Ray, Shared, Traversal, can_be_shared};
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Scalar, SimdLevel};
use overcoat_scene::{Transform, primitives};

type Triangle = [[f32; 3]; 3];

/// Numbers from -1 to 1.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.next())
    }

    /// Triangles of this size anywhere.
    fn triangles(&mut self, count: usize, size: f32) -> Vec<Triangle> {
        let mut near = |centre: [f32; 3]| std::array::from_fn(|k| centre[k] + size * self.next());
        let mut centres = Numbers(7);
        (0..count)
            .map(|_| {
                let centre = centres.point();
                std::array::from_fn(|_| near(centre))
            })
            .collect()
    }

    fn ray(&mut self) -> Ray {
        Ray { origin: self.point(), direction: self.point(), near: 0.0, far: f32::INFINITY }
    }
}

fn nearest(hierarchy: &Hierarchy, ray: &Ray) -> Option<Hit> {
    hierarchy.nearest(Scalar, ray, &mut Traversal::default(), |_| true)
}

/// One hierarchy for each triangle: no boxes decide.
fn nearest_of_all(triangles: &[Triangle], ray: &Ray) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    for (number, triangle) in triangles.iter().enumerate() {
        let alone = Hierarchy::new(&[*triangle], &Jobs::new(1));
        if let Some(hit) = nearest(&alone, ray)
            && best.is_none_or(|best| hit.distance < best.distance)
        {
            best = Some(Hit { triangle: number as u32, ..hit });
        }
    }
    best
}

#[test]
fn the_nearest_of_all_triangles_is_found() {
    let mut numbers = Numbers(1);
    for (count, size) in [(1, 1.0), (16, 0.5), (17, 0.5), (300, 0.2), (300, 2.0)] {
        let triangles = numbers.triangles(count, size);
        let hierarchy = Hierarchy::new(&triangles, &Jobs::new(1));
        let mut hits = 0;
        for _ in 0..200 {
            let ray = numbers.ray();
            let expected = nearest_of_all(&triangles, &ray);
            assert_eq!(nearest(&hierarchy, &ray), expected, "{count} {ray:?}");
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 3, "{count}: {hits}");
    }
}

#[test]
fn hits_lie_on_triangle_and_ray() {
    let mut numbers = Numbers(2);
    let triangles = numbers.triangles(100, 0.5);
    let hierarchy = Hierarchy::new(&triangles, &Jobs::new(1));
    for _ in 0..500 {
        let ray = numbers.ray();
        let Some(Hit { distance, triangle, barycentrics: [v, w] }) = nearest(&hierarchy, &ray) else {
            continue;
        };
        let [a, b, c] = triangles[triangle as usize];
        for k in 0..3 {
            let on_ray = ray.origin[k] + distance * ray.direction[k];
            let on_triangle = a[k] * (1.0 - v - w) + b[k] * v + c[k] * w;
            assert!((on_ray - on_triangle).abs() < 1e-4, "{on_ray} {on_triangle}");
        }
        assert!(v >= 0.0 && w >= 0.0 && v + w <= 1.000_001);
    }
}

#[test]
fn levels_and_threads_give_the_same_bits() {
    let mut numbers = Numbers(3);
    let triangles = numbers.triangles(30_000, 0.05);
    let one = Hierarchy::new(&triangles, &Jobs::new(1));
    let several = Hierarchy::new(&triangles, &Jobs::new(3));
    assert_eq!(format!("{one:?}"), format!("{several:?}"));
    let mut traversal = Traversal::default();
    for _ in 0..500 {
        let ray = numbers.ray();
        let expected = nearest(&one, &ray);
        for level in SimdLevel::available() {
            let found = overcoat_core::dispatch!(level, l => one.nearest(l, &ray, &mut traversal, |_| true));
            assert_eq!(found, expected, "{level}");
            let blocked =
                overcoat_core::dispatch!(level, l => one.is_blocked(l, &ray, &mut traversal, |_| true));
            assert_eq!(blocked, expected.is_some(), "{level}");
        }
    }
    assert!(traversal.take_visited() > 1000);
    assert_eq!(traversal.take_visited(), 0);
}

/// The triangles of a mesh.
fn of_mesh(mesh: &overcoat_scene::Mesh) -> Vec<Triangle> {
    mesh.triangles().iter().map(|t| t.map(|v| mesh.positions()[v as usize])).collect()
}

#[test]
fn no_ray_leaves_a_closed_surface() {
    let sphere = of_mesh(&primitives::sphere(1.0, 24).unwrap());
    let hierarchy = Hierarchy::new(&sphere, &Jobs::new(1));
    let mut numbers = Numbers(4);
    // From anywhere inside to anywhere, through corners and through the middles of edges.
    for _ in 0..300 {
        let origin = numbers.point().map(|v| v * 0.5);
        let triangle = sphere[(numbers.next().abs() * sphere.len() as f32) as usize % sphere.len()];
        let towards = |target: [f32; 3]| std::array::from_fn(|k| target[k] - origin[k]);
        let middle = std::array::from_fn(|k| (triangle[0][k] + triangle[1][k]) * 0.5);
        for target in [numbers.point(), triangle[0], triangle[1], triangle[2], middle] {
            let ray = Ray { origin, direction: towards(target), near: 0.0, far: f32::INFINITY };
            assert!(nearest(&hierarchy, &ray).is_some(), "{ray:?}");
        }
    }
}

#[test]
fn of_equally_near_triangles_the_first_is_hit() {
    let triangle = [[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]];
    let hierarchy = Hierarchy::new(&[triangle; 100], &Jobs::new(1));
    let ray = Ray { origin: [0.1, 0.2, 2.0], direction: [0.0, 0.0, -4.0], near: 0.0, far: 10.0 };
    let hit = nearest(&hierarchy, &ray).unwrap();
    assert_eq!((hit.triangle, hit.distance), (0, 0.5));
    let refused =
        hierarchy.nearest(Scalar, &ray, &mut Traversal::default(), |hit| hit.triangle > 41).unwrap();
    assert_eq!(refused.triangle, 42);
    // From behind as from the front.
    let behind = Ray { origin: [0.1, 0.2, -2.0], direction: [0.0, 0.0, 4.0], ..ray };
    assert_eq!(nearest(&hierarchy, &behind).unwrap().distance, 0.5);
    // The ends are outside.
    for (near, far) in [(0.5, 10.0), (0.0, 0.5), (0.6, 10.0), (0.0, 0.4)] {
        assert_eq!(nearest(&hierarchy, &Ray { near, far, ..ray }), None, "{near} {far}");
    }
}

#[test]
fn rays_along_axes_meet_flat_boxes() {
    let floor = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]],
    ];
    let hierarchy = Hierarchy::new(&floor, &Jobs::new(1));
    for x in [0.0, 0.25, 0.5, 1.0] {
        for z in [0.0, 0.25, 0.5, 1.0] {
            let ray = Ray { origin: [x, 1.0, z], direction: [0.0, -1.0, 0.0], near: 0.0, far: f32::INFINITY };
            assert_eq!(nearest(&hierarchy, &ray).map(|hit| hit.distance), Some(1.0), "{x} {z}");
            let along = Ray { origin: [x, 0.0, z], direction: [1.0, 0.0, 0.0], ..ray };
            assert_eq!(nearest(&hierarchy, &along), None);
        }
    }
}

#[test]
fn degenerate_triangles_are_never_hit_and_hostile_ones_do_not_deepen_the_tree() {
    let jobs = Jobs::new(1);
    assert!(Hierarchy::new(&[], &jobs).is_empty());
    assert!(Hierarchy::new(&[[[f32::NAN; 3]; 3], [[f32::INFINITY; 3]; 3]], &jobs).is_empty());
    let points = Hierarchy::new(&vec![[[0.5; 3]; 3]; 1000], &jobs);
    let line = Hierarchy::new(&vec![[[0.0; 3], [1.0; 3], [0.25; 3]]; 1000], &jobs);
    let ray = Ray { origin: [0.0; 3], direction: [1.0; 3], near: 0.0, far: f32::INFINITY };
    assert_eq!(nearest(&points, &ray), None);
    assert_eq!(nearest(&line, &ray), None);
    // Each twice as far away as the one before: the surface area heuristic takes them off one by one.
    let mut far = Vec::new();
    for k in 0..5000 {
        let x = 2.0_f32.powi_exact(k % 120 - 60);
        far.push([[x, -x, -x], [x, x, -x], [x, 0.0, x]]);
    }
    let hierarchy = Hierarchy::new(&far, &jobs);
    let ray = Ray { origin: [0.0; 3], direction: [1.0, 0.0, 0.0], near: 0.0, far: f32::INFINITY };
    assert!(nearest(&hierarchy, &ray).is_some());
}

/// A hierarchy over triangles that stand once and two meshes at many places, and one over a list of all triangles.
fn shared_and_listed(numbers: &mut Numbers, spread: f32) -> ([Hierarchy; 2], Vec<Triangle>) {
    let jobs = Jobs::new(2);
    let once = numbers.triangles(50, 0.3);
    let meshes = [of_mesh(&primitives::sphere(0.2, 10).unwrap()), numbers.triangles(40, 0.1)];
    let mut all = Vec::new();
    let mut shared = meshes.map(|triangles| Shared { triangles, places: Vec::new() });
    // Places of both meshes take turns, and half of what stands once comes in the middle.
    all.extend(&once[..25]);
    for k in 0..60 {
        let Shared { triangles, places } = &mut shared[k % 2];
        let at = numbers.point().map(|v| f64::from(v * spread));
        let [x, y, z] = numbers.point().map(f64::from);
        let scale = [0.5 + 0.4 * x, if k % 5 == 0 { -0.7 } else { 0.7 }, 1.1 + z];
        let place = Transform::from_parts(at, [x, y, z, 0.4], scale).unwrap();
        assert!(can_be_shared(&place));
        places.push((place, all.len() as u32));
        let corner = |p: [f32; 3]| place.point(p.map(f64::from)).map(|c| c as f32);
        all.extend(triangles.iter().map(|triangle| triangle.map(corner)));
        if k == 29 {
            all.extend(&once[25..]);
        }
    }
    let after = all.iter().position(|triangle| *triangle == once[25]).unwrap() as u32;
    let number_of = |number: u32| if number < 25 { number } else { number - 25 + after };
    let shared = Hierarchy::with_shared(&once, number_of, &shared, &jobs);
    ([shared, Hierarchy::new(&all, &jobs)], all)
}

/// Hits of meshes that are kept once have the bits of those of a list of all triangles.
#[test]
fn places_of_a_mesh_are_hit_as_copies_of_it() {
    let mut numbers = Numbers(11);
    for spread in [0.5, 1.0, 300.0] {
        let ([shared, listed], all) = shared_and_listed(&mut numbers, spread);
        let mut traversal = Traversal::default();
        let mut hits = 0;
        for k in 0..3000 {
            let mut ray = numbers.ray();
            ray.origin = ray.origin.map(|v| v * spread);
            if k % 2 == 0 {
                // Through a corner, from far away too.
                let target = all[k * 7 % all.len()][k % 3];
                ray.direction = std::array::from_fn(|k| target[k] - ray.origin[k]);
            }
            if k % 4 == 0 {
                ray.far = 1.0 + numbers.next();
            }
            if k % 14 == 7 {
                ray.direction[k % 3] = 0.0;
            }
            let expected = nearest(&listed, &ray);
            hits += usize::from(expected.is_some());
            for level in SimdLevel::available() {
                let (found, blocked) = overcoat_core::dispatch!(level, l => (
                    shared.nearest(l, &ray, &mut traversal, |_| true),
                    shared.is_blocked(l, &ray, &mut traversal, |_| true),
                ));
                assert_eq!((found, blocked), (expected, expected.is_some()), "{spread} {level} {ray:?}");
            }
        }
        assert!(hits > 500, "{spread}: {hits}");
    }
}

/// Equally near triangles of several places: the first is hit, wherever it is listed.
#[test]
fn of_equally_near_places_the_first_is_hit() {
    let triangle = [[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]];
    let places = [900, 500, 700].map(|first| (Transform::IDENTITY, first));
    let shared = Shared { triangles: vec![triangle; 100], places: places.to_vec() };
    let ray = Ray { origin: [0.1, 0.2, 2.0], direction: [0.0, 0.0, -4.0], near: 0.0, far: 10.0 };
    for (number, expected) in [(0, 0), (600, 500)] {
        let hierarchy =
            Hierarchy::with_shared(&[triangle], |_| number, std::slice::from_ref(&shared), &Jobs::new(1));
        assert_eq!(nearest(&hierarchy, &ray).unwrap().triangle, expected);
    }
    // Places that squeeze everything to a plane, or lie too far away, are to be listed.
    for rows in [
        [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        [[1.0, 0.0, 0.0, 1e16], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1e-9, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    ] {
        assert!(!can_be_shared(&Transform::from_rows(rows).unwrap()), "{rows:?}");
    }
}

/// Memory grows with the places and not with their triangles.
#[test]
fn places_take_no_triangles() {
    let triangles = of_mesh(&primitives::sphere(1.0, 24).unwrap());
    let bytes = |count: u32| {
        let at =
            |k: u32| Transform::translation([f64::from(k % 64) * 3.0, f64::from(k / 64) * 3.0, 0.0]).unwrap();
        let places = (0..count).map(|k| (at(k), k * triangles.len() as u32)).collect();
        let shared = Shared { triangles: triangles.clone(), places };
        Hierarchy::with_shared(&[], |number| number, &[shared], &Jobs::new(2)).bytes()
    };
    let (one, many) = (bytes(1), bytes(4096));
    assert!(many - one < 4096 * 512 && one > triangles.len() * 40, "{one} {many}");
}

trait PowiExact {
    fn powi_exact(self, n: i32) -> f32;
}

impl PowiExact for f32 {
    /// Powers of two by their bits.
    fn powi_exact(self, n: i32) -> f32 {
        f32::from_bits(((n + 127) as u32) << 23)
    }
}
