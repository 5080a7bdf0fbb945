//! Media that scatter: single scattering, and the semi-infinite medium of Chandrasekhar.

use super::direction;
use super::statistics::{Family, gauss_legendre};
use overcoat_core::math::double::exp;
use overcoat_lab::truth::{Interface, Medium, Outcome, Samples, Stack};
use std::f64::consts::PI;

fn slab(medium: Medium) -> Stack {
    let nothing = Interface::dielectric(1.0);
    Stack::builder().interface(nothing).medium(medium).interface(nothing).build().unwrap()
}

fn phase(g: f64, from: [f64; 3], to: [f64; 3]) -> f64 {
    let cosine = from[0] * to[0] + from[1] * to[1] + from[2] * to[2];
    let x = 1.0 + g * g - 2.0 * g * cosine;
    (1.0 - g * g) / (4.0 * PI * x * x.sqrt())
}

/// Hanrahan and Krueger 1993, section 4: first order reflection and transmission of a slab. The albedo is so small that there
/// is no second.
#[test]
fn single_scattering() {
    let mut family = Family::default();
    let albedo = [1e-6, 2e-6, 1e-7];
    for (depth, g) in [([0.5, 1.0, 2.0], 0.0), ([0.1, 1.0, 5.0], 0.8), ([3.0; 3], -0.5)] {
        let stack = slab(Medium { extinction: depth, albedo, anisotropy: g, thickness: 1.0 });
        for (co, ci) in
            [(0.9, 0.6), (0.3, 0.8), (0.7, 0.1), (0.8, -0.4), (0.2, -0.9), (-0.5, 0.9), (-0.3, -0.4)]
        {
            let (wo, wi) = (direction(co, 0.0), direction(ci, 2.0));
            let p = phase(g, wo.map(|x| -x), wi);
            let (o, i) = (f64::abs(co), f64::abs(ci));
            let expected = [0, 1, 2].map(|c| {
                let tau = depth[c];
                if co * ci > 0.0 {
                    albedo[c] * p * i / (i + o) * (1.0 - exp(-tau * (1.0 / i + 1.0 / o)))
                } else {
                    albedo[c] * p * i / (i - o) * (exp(-tau / i) - exp(-tau / o))
                }
            });
            let found = stack.evaluate(wo, wi, &Samples::new(1 << 14)).unwrap().total;
            for c in 0..3 {
                // In units of the albedo, so that rounding is what it is.
                let scale = 1.0 / albedo[c];
                let (mean, error) = (found.mean()[c] * scale, found.standard_error()[c] * scale);
                let second_order = 1e-5 * expected[c] * scale;
                family.compare(
                    format!("depth {}, g {g}, {co} to {ci}", depth[c]),
                    (mean, error),
                    (expected[c] * scale, second_order),
                );
                assert!(error < 0.06 * expected[c] * scale, "{co} {ci}: {error} of {}", expected[c] * scale);
            }
        }
    }
    family.judge();
}

/// The H function of isotropic scattering, by iteration of `1/H = sqrt(1 - a) + a/2 int H(x) x / (m + x) dx` (Chandrasekhar
/// 1960, section 40).
fn chandrasekhar(albedo: f64) -> impl Fn(f64) -> f64 {
    let nodes = gauss_legendre(64, 0.0, 1.0);
    let root = (1.0 - albedo).sqrt();
    let inverse = move |mu: f64, h: &[f64], nodes: &[(f64, f64)]| {
        root + 0.5 * albedo * nodes.iter().zip(h).map(|((x, w), h)| w * h * x / (mu + x)).sum::<f64>()
    };
    let mut h = vec![1.0; nodes.len()];
    for _ in 0..2000 {
        let next: Vec<f64> = nodes.iter().map(|(mu, _)| 1.0 / inverse(*mu, &h, &nodes)).collect();
        h = next;
    }
    move |mu| 1.0 / inverse(mu, &h, &nodes)
}

/// `f = a / (4 pi) H(o) H(i) / (o + i)` of a medium without end (Chandrasekhar 1960, section 33); a thickness of 40 is one, for
/// albedos below 1.
#[test]
fn medium_without_end() {
    let mut family = Family::default();
    let albedo = [0.3, 0.8, 0.95];
    let stack = slab(Medium { extinction: [40.0; 3], albedo, anisotropy: 0.0, thickness: 1.0 });
    for (o, i) in [(1.0, 0.9), (0.5, 0.3), (0.1, 0.8), (0.9, 0.05)] {
        let found =
            stack.evaluate(direction(o, 0.0), direction(i, 1.0), &Samples::new(1 << 14)).unwrap().total;
        let expected = albedo.map(|a| {
            let h = chandrasekhar(a);
            a / (4.0 * PI) * h(o) * h(i) / (o + i) * i
        });
        family.exact(&format!("{o} to {i}"), &found, expected);
    }
    family.judge();
}

/// A medium that does not scatter is a factor along the way. One that scatters next to nothing is walked through by collisions and has the
/// same means, with more noise.
#[test]
fn absorption_is_that_of_collisions() {
    let lambert = Interface::lambertian([0.8, 0.5, 0.2]);
    let metal = Interface::schlick_conductor([0.9, 0.6, 0.3]).rough(0.2).multiple_scattering();
    let glass = Interface::dielectric(1.5);
    let depth = [0.1, 0.4, 1.0];
    let mut family = Family::default();
    let (mut quieter, mut all) = (0, 0);
    for (name, coat, base) in [
        ("smooth on metal", glass, metal),
        ("rough on metal", glass.rough(0.25).multiple_scattering(), metal),
        ("rough on lambert", glass.rough(0.25), lambert),
    ] {
        let stack = |albedo: f64| {
            let medium = Medium { albedo: [albedo; 3], ..Medium::absorbing(depth) };
            let clear = Interface::dielectric(1.2).rough(0.3);
            let builder = Stack::builder().interface(coat).medium(medium).interface(clear).medium(medium);
            builder.interface(base).build().unwrap()
        };
        let (factor, collisions) = (stack(0.0), stack(1e-30));
        let samples = Samples::new(1 << 14);
        for wo in [direction(0.9, 0.2), direction(0.3, 0.0)] {
            let wi = direction(0.7, 2.5);
            let of = |stack: &Stack| {
                let albedo = stack.directional_albedo(wo, &samples).unwrap().reflectance;
                [albedo, stack.evaluate(wo, wi, &samples).unwrap().total]
            };
            for (what, (a, b)) in
                ["albedo", "value"].iter().zip(of(&factor).iter().zip(of(&collisions).iter()))
            {
                for c in 0..3 {
                    let [x, y] = [a, b].map(|e| (e.mean()[c], e.standard_error()[c]));
                    family.compare(format!("{name}, {what}, channel {c}"), x, y);
                    quieter += u32::from(x.1 < y.1);
                    all += 1;
                }
            }
            // Walks one by one: the share that leaves is the mean of the albedo's channels.
            let leave = |stack: &Stack| {
                let left =
                    (0..20_000).filter(|&k| matches!(stack.sample(wo, 3, k).unwrap(), Outcome::Left(_)));
                let p = left.count() as f64 / 20_000.0;
                (p, (p * (1.0 - p) / 20_000.0).sqrt())
            };
            family.compare(format!("{name}, share that leaves"), leave(&factor), leave(&collisions));
        }
    }
    family.judge();
    assert!(4 * quieter > 3 * all, "{quieter} of {all}");
}

/// Media that nothing gets through end walks, and leave no number that is none.
#[test]
fn what_is_opaque_shows_the_coat_alone() {
    for depth in [800.0, 1e10] {
        let stack = Stack::builder()
            .interface(Interface::dielectric(1.5).rough(0.2).multiple_scattering())
            .medium(Medium::absorbing([depth; 3]))
            .interface(Interface::lambertian([1.0; 3]))
            .build()
            .unwrap();
        let (wo, wi) = (direction(0.8, 0.0), direction(0.6, 2.0));
        let albedo = stack.directional_albedo(wo, &Samples::new(512)).unwrap();
        assert_eq!((albedo.base.mean(), albedo.base.standard_error()), ([0.0; 3], [0.0; 3]));
        assert_eq!(stack.evaluate(wo, wi, &Samples::new(512)).unwrap().base.mean(), [0.0; 3]);
        let outcomes = (0..500).map(|k| stack.sample(wo, 1, k).unwrap());
        let left = outcomes.filter(|outcome| matches!(outcome, Outcome::Left(_))).count();
        assert!((1..100).contains(&left), "{left}");
    }
}

/// Extinction and thickness count by their product alone.
#[test]
fn thickness_times_extinction() {
    let medium = |extinction: f64, thickness| Medium {
        extinction: [extinction; 3],
        albedo: [0.5; 3],
        anisotropy: 0.3,
        thickness,
    };
    let at =
        |medium| slab(medium).evaluate(direction(0.5, 0.0), direction(0.5, 1.0), &Samples::new(256)).unwrap();
    assert_eq!(at(medium(4.0, 0.5)), at(medium(1.0, 2.0)));
    assert_ne!(at(medium(4.0, 0.5)), at(medium(1.0, 1.0)));
}
