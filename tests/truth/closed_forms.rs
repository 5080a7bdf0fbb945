//! Smooth stacks whose sums over all paths are known.

use super::statistics::{Family, gauss_legendre};
use super::{direction, fresnel};
use overcoat_core::math::double::exp;
use overcoat_lab::truth::{Interface, Medium, Samples, Stack};
use std::f64::consts::FRAC_1_PI;

/// 2 times the integral of f(cosine) cosine over the hemisphere, below an interface whose critical angle is at a cosine.
fn diffuse(critical: f64, f: impl Fn(f64) -> f64) -> f64 {
    let part = |a: f64, b: f64| {
        // Squares, because reflectance has the slope of a root beyond the critical angle.
        let nodes = gauss_legendre(200, 0.0, 1.0);
        let at =
            |(t, w): (f64, f64)| w * 2.0 * t * (b - a) * 2.0 * f(a + (b - a) * t * t) * (a + (b - a) * t * t);
        nodes.into_iter().map(at).sum::<f64>()
    };
    (if critical > 0.0 { part(0.0, critical) } else { 0.0 }) + part(critical, 1.0)
}

struct Coated {
    eta: f64,
    /// Optical thickness and reflectance of what is below, by channel.
    depth: [f64; 3],
    albedo: [f64; 3],
}

impl Coated {
    fn stack(&self) -> Stack {
        Stack::builder()
            .interface(Interface::dielectric(self.eta))
            .medium(Medium::absorbing(self.depth))
            .interface(Interface::lambertian(self.albedo))
            .build()
            .unwrap()
    }

    fn critical(&self) -> f64 {
        let square = 1.0 - 1.0 / (self.eta * self.eta);
        if square > 0.0 { square.sqrt() } else { 0.0 }
    }

    /// Share of the light leaving the lower surface that comes back to it.
    fn returns(&self, c: usize) -> f64 {
        diffuse(self.critical(), |mu| fresnel(mu, 1.0 / self.eta).0 * exp(-2.0 * self.depth[c] / mu))
    }

    /// Share of the light leaving the lower surface that leaves the coat.
    fn leaves(&self, c: usize) -> f64 {
        diffuse(self.critical(), |mu| (1.0 - fresnel(mu, 1.0 / self.eta).0) * exp(-self.depth[c] / mu))
    }

    /// Share of the arriving light that reaches the lower surface.
    fn enters(&self, cosine: f64, c: usize) -> f64 {
        let (f, beyond) = fresnel(cosine, self.eta);
        if beyond == 0.0 { 0.0 } else { (1.0 - f) * exp(-self.depth[c] / beyond) }
    }

    fn value(&self, co: f64, ci: f64) -> [f64; 3] {
        std::array::from_fn(|c| {
            let both = self.enters(co, c) * self.enters(ci, c) / (self.eta * self.eta);
            both * self.albedo[c] * FRAC_1_PI / (1.0 - self.albedo[c] * self.returns(c)) * ci
        })
    }

    fn base(&self, cosine: f64) -> [f64; 3] {
        std::array::from_fn(|c| {
            let all = self.albedo[c] / (1.0 - self.albedo[c] * self.returns(c));
            self.enters(cosine, c) * all * self.leaves(c)
        })
    }
}

const COATED: [Coated; 5] = [
    Coated { eta: 1.5, depth: [0.0; 3], albedo: [0.2, 0.8, 1.0] },
    Coated { eta: 1.5, depth: [0.3, 1.0, 0.05], albedo: [0.9, 0.5, 1.0] },
    Coated { eta: 2.5, depth: [0.0; 3], albedo: [0.2, 0.8, 1.0] },
    Coated { eta: 0.7, depth: [0.0, 0.2, 0.0], albedo: [0.5, 0.5, 0.99] },
    Coated { eta: 1.0, depth: [0.0, 0.2, 2.0], albedo: [0.5, 0.5, 0.99] },
];

#[test]
fn smooth_coat_on_a_diffuse_base() {
    let mut family = Family::default();
    for coated in &COATED {
        let stack = coated.stack();
        let name = format!("eta {}", coated.eta);
        for (co, ci) in [(1.0, 0.8), (0.75, 0.75), (0.9, 0.15), (0.05, 0.95)] {
            let found =
                stack.evaluate(direction(co, 0.0), direction(ci, 2.0), &Samples::new(1 << 14)).unwrap();
            family.exact(&format!("{name}, {co} to {ci}"), &found.total, coated.value(co, ci));
            assert_eq!(found.coat.mean(), [0.0; 3]);
        }
        for cosine in [1.0, 0.75, 0.2] {
            let found = stack.directional_albedo(direction(cosine, 1.0), &Samples::new(1 << 14)).unwrap();
            family.exact(
                &format!("{name}, coat at {cosine}"),
                &found.coat,
                [fresnel(cosine, coated.eta).0; 3],
            );
            family.exact(&format!("{name}, base at {cosine}"), &found.base, coated.base(cosine));
        }
    }
    family.judge();
}

/// OpenPBR Surface 1.1, section "Coat", darkening of a rough base: `(1 - K) E / (1 - E K)` below a coat that transmits `1 -
/// F`, with `K` of the reflectance of the coat from outside. For a smooth coat without colour on a diffuse base that is
/// exact.
#[test]
fn darkening_of_openpbr() {
    let mut family = Family::default();
    for eta in [1.3, 1.5, 1.8] {
        let coated = Coated { eta, depth: [0.0; 3], albedo: [0.1, 0.5, 0.9] };
        let outside = diffuse(0.5, |mu| fresnel(mu, eta).0);
        let k = 1.0 - (1.0 - outside) / (eta * eta);
        for cosine in [1.0, 0.5, 0.2] {
            let f = fresnel(cosine, eta).0;
            let expected = coated.albedo.map(|e| f + (1.0 - f) * (1.0 - k) * e / (1.0 - e * k));
            for c in 0..3 {
                assert!((f + coated.base(cosine)[c] - expected[c]).abs() < 1e-6, "{eta} {cosine} {c}");
            }
            let found =
                coated.stack().directional_albedo(direction(cosine, 0.0), &Samples::new(1 << 18)).unwrap();
            family.exact(&format!("eta {eta} at {cosine}"), &found.reflectance, expected);
            assert!(found.reflectance.standard_error().iter().all(|&error| error < 1e-3));
        }
    }
    family.judge();
}

/// A pane: `R + T^2 R a^2 / (1 - R^2 a^2)` comes back, `T^2 a / (1 - R^2 a^2)` goes through.
#[test]
fn panes() {
    let mut family = Family::default();
    for (eta, depth) in [(1.5, [0.0, 0.1, 1.0]), (3.0, [0.0, 0.01, 0.3]), (0.6, [0.2, 0.1, 0.0])] {
        let stack = Stack::builder()
            .interface(Interface::dielectric(eta))
            .medium(Medium::absorbing(depth))
            .interface(Interface::dielectric(1.0 / eta))
            .build()
            .unwrap();
        assert!((stack.index_below() - 1.0).abs() < 1e-15);
        for cosine in [1.0, 0.85, 0.3, -0.9] {
            let (r, beyond) = fresnel(f64::abs(cosine), eta);
            let pass = |c: usize| if beyond > 0.0 { exp(-depth[c] / beyond) } else { 0.0 };
            let t = 1.0 - r;
            let back = |c| r + t * t * r * pass(c) * pass(c) / (1.0 - r * r * pass(c) * pass(c));
            let through = |c| t * t * pass(c) / (1.0 - r * r * pass(c) * pass(c));
            let found = stack.directional_albedo(direction(cosine, 0.0), &Samples::new(4096)).unwrap();
            let name = format!("eta {eta} at {cosine}");
            if r < 1.0 {
                // All walks are the same for five events. Then few go on, each with a quarter of the light, and where none of all samples
                // does, they cannot tell the error: it is that of the chance to go on.
                let least = |c: usize| {
                    let inside = r * pass(c);
                    (0.25 * t * inside * inside * inside * inside / 4096.0).sqrt()
                };
                for c in 0..3 {
                    let sides = [
                        ("back", &found.reflectance, back(c)),
                        ("through", &found.transmittance, through(c)),
                    ];
                    for (side, estimate, expected) in sides {
                        assert_eq!(estimate.truncated(), 0, "{name}");
                        let error = f64::max(estimate.standard_error()[c], least(c));
                        let what = format!("{name}, {side}, channel {c}");
                        family.compare(what, (estimate.mean()[c], error), (expected, 0.0));
                    }
                }
            } else {
                assert_eq!(found.reflectance.mean(), [1.0; 3]);
            }
            let nothing =
                stack.evaluate(direction(cosine, 0.0), direction(cosine, 3.0), &Samples::new(10)).unwrap();
            assert_eq!(nothing.total.mean(), [0.0; 3]);
        }
    }
    family.judge();
}

/// A pane on a mirror, and a smooth conductor alone.
#[test]
fn mirrors() {
    let mut family = Family::default();
    let f0 = [0.9, 0.5, 0.2];
    let mirror = Stack::builder().interface(Interface::schlick_conductor(f0)).build().unwrap();
    let coated = Stack::builder()
        .interface(Interface::dielectric(1.5))
        .medium(Medium::absorbing([0.1, 0.0, 0.5]))
        .interface(Interface::schlick_conductor(f0))
        .build()
        .unwrap();
    let schlick =
        |f0: f64, c: f64| f0 + (1.0 - f0) * (1.0 - c) * (1.0 - c) * (1.0 - c) * (1.0 - c) * (1.0 - c);
    for cosine in [1.0, 0.4, 0.1] {
        let found = mirror.directional_albedo(direction(cosine, 0.0), &Samples::new(100)).unwrap();
        family.exact("mirror", &found.reflectance, f0.map(|f0| schlick(f0, cosine)));
        let (r, beyond) = fresnel(cosine, 1.5);
        let expected = [0, 1, 2].map(|c| {
            let m = schlick(f0[c], beyond) * exp(-2.0 * [0.1, 0.0, 0.5][c] / beyond);
            r + (1.0 - r) * (1.0 - r) * m / (1.0 - r * m)
        });
        let found = coated.directional_albedo(direction(cosine, 0.0), &Samples::new(1 << 14)).unwrap();
        family.exact("coated mirror", &found.reflectance, expected);
    }
    family.judge();
}

/// An unrefracted coat of Schlick on a diffuse base, as engines mean it, with all that goes to and fro.
#[test]
fn unrefracted_coats() {
    let mut family = Family::default();
    let (f0, albedo) = ([0.04, 0.3, 0.1], [0.5, 0.9, 0.2]);
    let stack = |alpha: f64| {
        Stack::builder()
            .interface(Interface::schlick_dielectric(1.0, f0).rough(alpha))
            .interface(Interface::lambertian(albedo))
            .build()
            .unwrap()
    };
    let smooth = stack(0.0);
    let schlick =
        |f0: f64, c: f64| f0 + (1.0 - f0) * (1.0 - c) * (1.0 - c) * (1.0 - c) * (1.0 - c) * (1.0 - c);
    for (co, ci) in [(0.9, 0.8), (0.3, 0.7)] {
        let expected = [0, 1, 2].map(|c| {
            let back = diffuse(0.5, |mu| schlick(f0[c], mu));
            let passes = (1.0 - schlick(f0[c], co)) * (1.0 - schlick(f0[c], ci));
            passes * albedo[c] * FRAC_1_PI / (1.0 - albedo[c] * back) * ci
        });
        let found = smooth.evaluate(direction(co, 0.0), direction(ci, 2.0), &Samples::new(1 << 14)).unwrap();
        family.exact("smooth", &found.total, expected);
        // A little rough is nearly the same: the base to half a percent.
        let rough =
            stack(0.01).evaluate(direction(co, 0.0), direction(ci, 2.0), &Samples::new(1 << 16)).unwrap();
        for c in 0..3 {
            let ratio = rough.base.mean()[c] / expected[c];
            assert!((ratio - 1.0).abs() < 0.005, "{ratio}");
        }
    }
    family.judge();
}
