//! Area lights by linearly transformed cosines against integration over the light.

use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::{dispatch_baseline, each};
use overcoat_shading::brdf::linearly_transformed_cosine::{LightFrame, Lobe, rectangle, tube};
use overcoat_shading::brdf::microfacet_light::Facets;
use overcoat_shading::brdf::{integrate, tables};

type Point = [f64; 3];

fn add(a: Point, b: Point, scale: f64) -> Point {
    [0, 1, 2].map(|k| a[k] + b[k] * scale)
}
fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn unit(v: Point) -> Point {
    add([0.0; 3], v, 1.0 / dot(v, v).sqrt())
}

/// The vertices of a parallelogram.
fn outline(corner: Point, [u, v]: [Point; 2]) -> [Point; 4] {
    [corner, add(corner, u, 1.0), add(add(corner, u, 1.0), v, 1.0), add(corner, v, 1.0)]
}

/// A surface with the normal +Z, seen from the plane of x and z.
struct Surface {
    /// `None`: Lambert.
    perceptual_roughness: Option<f64>,
    view: Point,
    albedo: f64,
}

impl Surface {
    fn new(perceptual_roughness: Option<f64>, n_dot_v: f64) -> Self {
        let albedo = perceptual_roughness.map_or(1.0, |p| integrate::ggx_albedo(p, &[n_dot_v])[0][1]);
        Self { perceptual_roughness, view: [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v], albedo }
    }

    /// BRDF times cosine over albedo, towards a unit vector.
    fn lobe(&self, light: Point) -> f64 {
        if light[2] <= 0.0 {
            return 0.0;
        }
        let Some(p) = self.perceptual_roughness else { return light[2] / std::f64::consts::PI };
        let a2 = p * p * p * p;
        let half = unit(add(light, self.view, 1.0));
        let d = half[2] * half[2] * (a2 - 1.0) + 1.0;
        let smith = |cosine: f64| (cosine * cosine * (1.0 - a2) + a2).sqrt();
        let (l, v) = (light[2], self.view[2]);
        let visibility = 0.5 / (l * smith(v) + v * smith(l));
        a2 / (std::f64::consts::PI * d * d) * visibility * l / self.albedo
    }

    /// Integral by linearly transformed cosines: the code under test.
    fn evaluate(&self, light: &Light) -> f64 {
        let l = Scalar;
        let point = |p: Point| Vec3::splat(l, p.map(|v| v as f32));
        let frame = LightFrame::new(l, point([0.0, 0.0, 1.0]), point(self.view));
        let lobe = match self.perceptual_roughness {
            Some(p) => Lobe::ggx(
                l,
                tables::linearly_transformed_ggx(),
                l.splat(p as f32),
                l.splat(self.view[2] as f32),
            ),
            None => Lobe::lambert(l),
        };
        let share = match light {
            Light::Rectangle { corner, sides } => {
                rectangle(l, &frame, &lobe, outline(*corner, *sides).map(point))
            }
            Light::Tube { ends, radius } => tube(l, &frame, &lobe, ends.map(point), l.splat(*radius as f32)),
        };
        f64::from(share.to_array()[0])
    }

    /// Integral by [`Facets`], in `parts` pieces a side.
    fn facets(&self, light: &Light, parts: usize) -> f64 {
        let l = Scalar;
        let point = |p: Point| Vec3::splat(l, p.map(|v| v as f32));
        let frame = LightFrame::new(l, point([0.0, 0.0, 1.0]), point(self.view));
        let alpha = self.perceptual_roughness.map_or(1.0, |p| p * p);
        let facets =
            Facets::new(l, &frame, [l.splat(alpha as f32); 2], point(self.view), l.splat(self.albedo as f32));
        let share = match light {
            Light::Rectangle { corner, sides } => {
                facets.rectangle(l, outline(*corner, *sides).map(point), [parts; 2])
            }
            Light::Tube { ends, radius } => {
                facets.tube(l, ends.map(point), l.splat(*radius as f32), parts * parts)
            }
        };
        f64::from(share.to_array()[0])
    }

    /// The integral over the light.
    fn integrate(&self, light: &Light) -> f64 {
        match light {
            Light::Rectangle { corner, sides: [u, v] } => {
                let steps = 200;
                let area = cross(*u, *v);
                let mut sum = 0.0;
                for i in 0..steps {
                    for j in 0..steps {
                        let at = |k: usize| (k as f64 + 0.5) / steps as f64;
                        let point = add(add(*corner, *u, at(i)), *v, at(j));
                        let direction = unit(point);
                        sum += self.lobe(direction) * dot(direction, area).abs() / dot(point, point);
                    }
                }
                sum / (steps * steps) as f64
            }
            Light::Tube { ends: [a, b], radius } => {
                let steps = 4000;
                let axis = add(*b, *a, -1.0);
                let mut sum = 0.0;
                for k in 0..steps {
                    let point = add(*a, axis, (f64::from(k) + 0.5) / f64::from(steps));
                    let direction = unit(point);
                    let across = cross(direction, axis);
                    sum += self.lobe(direction) * dot(across, across).sqrt() / dot(point, point);
                }
                sum / f64::from(steps) * 2.0 * radius
            }
        }
    }
}

enum Light {
    Rectangle { corner: Point, sides: [Point; 2] },
    Tube { ends: [Point; 2], radius: f64 },
}

/// A square of the given side about a point in the direction of the mirror, turned towards the surface and about itself,
/// and the tube of twice its side through the same point.
fn lights(surface: &Surface, side: f64, sink: f64) -> [Light; 2] {
    let mirror = [-surface.view[0], 0.0, surface.view[2]];
    let centre = add(add([0.0; 3], mirror, 2.0), [0.0, sink, -sink], 1.0);
    let facing = unit(centre);
    let u = unit(cross(facing, [0.3, 1.0, 0.2]));
    let v = cross(facing, u);
    let corner = add(add(centre, u, -0.5 * side), v, -0.5 * side);
    let sides = [add([0.0; 3], u, side), add([0.0; 3], v, side)];
    let ends = [add(centre, u, -side), add(centre, u, side)];
    [Light::Rectangle { corner, sides }, Light::Tube { ends, radius: 0.003 * side }]
}

/// Error relative to the share, but no stricter than for a rectangle that fills a tenth of the lobe, and a tube that
/// fills 3 thousandths.
fn error(light: &Light, found: f64, expected: f64) -> f64 {
    let least = match light {
        Light::Rectangle { .. } => 0.1,
        Light::Tube { .. } => 0.003,
    };
    (found - expected).abs() / expected.max(least)
}

/// Worst errors of rectangles and tubes over roughnesses, sizes and places, some partly below the horizon.
fn worst(n_dot_v: f64, roughnesses: &[Option<f64>], evaluate: impl Fn(&Surface, &Light) -> f64) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for p in roughnesses {
        let surface = Surface::new(*p, n_dot_v);
        for side in [0.3, 1.0, 2.5] {
            for sink in [0.0, 0.2, 0.5] {
                for (light, worst) in lights(&surface, side, sink).iter().zip(&mut worst) {
                    let error = error(light, evaluate(&surface, light), surface.integrate(light));
                    *worst = worst.max(error);
                }
            }
        }
    }
    worst
}

const ROUGH: [Option<f64>; 6] = [Some(0.2), Some(0.3), Some(0.45), Some(0.6), Some(0.8), Some(1.0)];

#[test]
fn lambert_is_exact() {
    for n_dot_v in [1.0, 0.5, 0.15] {
        let [rectangle, tube] = worst(n_dot_v, &[None], Surface::evaluate);
        assert!(rectangle < 2e-4 && tube < 2e-4, "{n_dot_v}: {rectangle} {tube}");
    }
}

/// One transformed cosine: the error of the method, as engines have it.
#[test]
fn transformed_cosines_are_near_ggx() {
    let bounds = [(1.0, 0.022), (0.9, 0.022), (0.7, 0.03), (0.5, 0.06), (0.3, 0.15), (0.15, 0.28)];
    for (n_dot_v, bound) in bounds {
        let [rectangle, tube] = worst(n_dot_v, &ROUGH, Surface::evaluate);
        assert!(rectangle < bound && tube < bound, "{n_dot_v}: {rectangle} {tube}");
    }
}

/// Facets: within a hundredth, and the closer the more pieces.
#[test]
fn facets_are_ggx() {
    for n_dot_v in [1.0, 0.7, 0.3] {
        let [rectangle, _] = worst(n_dot_v, &ROUGH, |surface, light| surface.facets(light, 8));
        let [_, tube] = worst(n_dot_v, &ROUGH, |surface, light| surface.facets(light, 4));
        assert!(rectangle < 0.01 && tube < 0.01, "{n_dot_v}: {rectangle} {tube}");
    }
    for (parts, bound) in [(2, 0.06), (3, 0.03), (4, 0.015)] {
        let [rectangle, _] = worst(0.5, &ROUGH, |surface, light| surface.facets(light, parts));
        assert!(rectangle < bound, "{parts}: {rectangle}");
    }
}

/// A room of light fills every lobe, from each of five walls its part; nothing comes from below.
#[test]
fn a_room_fills_the_lobe() {
    let wall = |x: Point, y: Point, z: Point| {
        let corner = add(add(z, x, -1.0), y, -1.0);
        Light::Rectangle { corner, sides: [add([0.0; 3], x, 2.0), add([0.0; 3], y, 2.0)] }
    };
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let minus = |v: Point| v.map(|c| -c);
    let walls = [wall(x, y, z), wall(y, z, x), wall(z, y, minus(x)), wall(x, z, y), wall(z, x, minus(y))];
    for p in [None, Some(0.0), Some(0.1), Some(0.3), Some(0.7), Some(1.0)] {
        for n_dot_v in [0.01, 0.2, 0.6, 1.0] {
            let surface = Surface::new(p, n_dot_v);
            let all: f64 = walls.iter().map(|light| surface.evaluate(light)).sum();
            assert!((all - 1.0).abs() < 2e-4, "{p:?} {n_dot_v}: {all}");
            assert_eq!(surface.evaluate(&wall(x, y, minus(z))), 0.0);
            assert_eq!(surface.facets(&wall(x, y, minus(z)), 2), 0.0);
        }
    }
}

/// Far away a light is a point: share = lobe times area times its cosine over the square of the distance.
#[test]
fn far_lights_are_points() {
    for p in [Some(0.3), Some(0.8)] {
        let surface = Surface::new(p, 0.6);
        let centre = [-70.0, 20.0, 60.0];
        let [u, v] = [[2.0, 1.0, 0.0], [0.0, 1.0, 2.0]];
        let light = Light::Rectangle { corner: add(add(centre, u, -0.5), v, -0.5), sides: [u, v] };
        let direction = unit(centre);
        let expected = surface.lobe(direction) * dot(direction, cross(u, v)).abs() / dot(centre, centre);
        let found = surface.facets(&light, 1);
        assert!((found - expected).abs() < 0.01 * expected, "{found} {expected}");
    }
}

/// A light turned over, and a tube from its other end, is the same light.
#[test]
fn the_sense_of_rotation_does_not_matter() {
    let surface = Surface::new(Some(0.4), 0.5);
    for [light, tube] in [lights(&surface, 1.0, 0.0), lights(&surface, 2.5, 0.5)] {
        let (Light::Rectangle { corner, sides: [u, v] }, Light::Tube { ends: [a, b], radius }) =
            (&light, &tube)
        else {
            panic!("a rectangle and a tube")
        };
        let turned = Light::Rectangle { corner: *corner, sides: [*v, *u] };
        let back = Light::Tube { ends: [*b, *a], radius: *radius };
        for (one, other) in [(&light, &turned), (&tube, &back)] {
            assert!((surface.evaluate(one) - surface.evaluate(other)).abs() < 1e-5);
            assert!((surface.facets(one, 2) - surface.facets(other, 2)).abs() < 1e-5);
        }
    }
}

/// No light, wherever it is, gives anything but a share: degenerate ones, through the surface, at the point itself.
#[test]
fn shares_are_numbers_from_0_to_1() {
    let rounds = if cfg!(debug_assertions) { 500 } else { 30_000 };
    let bad = dispatch_baseline!(l => hunt(l, rounds));
    assert_eq!(bad, 0);
}

#[inline(always)]
fn hunt<L: Lanes>(l: L, rounds: usize) -> usize {
    let mut state = 0x9e37_79b9_u32;
    let mut next = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    let mut bad = 0;
    for _ in 0..rounds {
        // Coordinates from -1 to 1, every fourth of them -1, 0 or 1.
        let mut number = || {
            let mut lanes = [0.0; LANES];
            for v in &mut lanes {
                let r = next();
                *v = if r & 3 == 0 {
                    ((r >> 2) % 3) as f32 - 1.0
                } else {
                    (r >> 2) as f32 / 2_097_152.0 - 1.0
                };
            }
            l.load(&lanes)
        };
        let [normal, view]: [V3<L>; 2] = each!(_k => {
            let v = Vec3::new(number(), number(), number());
            let none = v.length().lt(l.splat(1e-3));
            Vec3::select(none, Vec3::splat(l, [0.0, 1.0, 0.0]), v.normalize())
        });
        let vertices: [V3<L>; 4] = each!(_k => Vec3::new(number(), number(), number()));
        let [p, radius]: [L::F; 2] = each!(_k => number().abs());
        let n_dot_v = normal.dot(view).saturate();
        let frame = LightFrame::new(l, normal, view);
        let lobe = Lobe::ggx(l, tables::linearly_transformed_ggx(), p, n_dot_v);
        let facets = Facets::new(l, &frame, [p * p; 2], view, l.splat(0.5));
        let ends = [vertices[0], vertices[1]];
        for share in [
            rectangle(l, &frame, &lobe, vertices),
            rectangle(l, &frame, &Lobe::lambert(l), vertices),
            tube(l, &frame, &lobe, ends, radius),
            tube(l, &frame, &Lobe::lambert(l), ends, radius),
            facets.rectangle(l, vertices, [2, 2]),
            facets.tube(l, ends, radius, 2),
        ] {
            bad += share.to_array().iter().filter(|s| !(0.0..=1.0).contains(*s)).count();
        }
    }
    bad
}
