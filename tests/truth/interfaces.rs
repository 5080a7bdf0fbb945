//! Stacks of one interface are that interface, to the last digits: formulas as they are published, written here again.

use super::direction;
use super::statistics::{Family, Points, mean_and_error};
use overcoat_lab::truth::{Estimate, Interface, Masking, Medium, Samples, Stack};
use std::f64::consts::{PI, TAU};

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

fn one(interface: Interface) -> Stack {
    Stack::builder().interface(interface).build().unwrap()
}

/// GGX as Walter et al. 2007 have it, equations 33 and 34.
fn walter(alpha: f64, m: [f64; 3], w: [f64; 3]) -> (f64, f64) {
    let cosine = m[2].abs();
    let tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
    let cosine4 = cosine * cosine * cosine * cosine;
    let d = alpha * alpha / (PI * cosine4 * (alpha * alpha + tan2) * (alpha * alpha + tan2));
    let tan2 = (1.0 - w[2] * w[2]) / (w[2] * w[2]);
    (d, 2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt()))
}

/// For unpolarised light, by the angles: c of incidence, eta of the other side.
fn fresnel(c: f64, eta: f64) -> f64 {
    let g2 = eta * eta - 1.0 + c * c;
    if g2 <= 0.0 {
        return 1.0;
    }
    // Walter et al., equation 22.
    let g = g2.sqrt();
    let (minus, plus) = (g - c, g + c);
    let fraction = (c * plus - 1.0) / (c * minus + 1.0);
    0.5 * minus * minus / (plus * plus) * (1.0 + fraction * fraction)
}

fn close(what: &str, found: [f64; 3], expected: [f64; 3]) {
    for c in 0..3 {
        let error = (found[c] - expected[c]).abs();
        assert!(error <= 1e-11 * (1.0 + expected[c].abs()), "{what}: {found:?} and not {expected:?}");
    }
}

const PAIRS: [(f64, f64, f64); 6] =
    [(1.0, 0.9, 0.0), (0.7, 0.7, PI), (0.5, 0.3, 2.0), (0.1, 0.07, 3.0), (0.02, 0.9, 0.5), (0.8, 0.2, 5.0)];

#[test]
fn rough_reflection_is_that_of_engines() {
    let f0 = [0.04, 0.5, 1.0];
    for alpha in [0.01, 0.3, 1.0] {
        let stack = one(Interface::schlick_conductor(f0).rough(alpha));
        for (co, ci, phi) in PAIRS {
            let (wo, wi) = (direction(co, 0.4), direction(ci, 0.4 + phi));
            let h = unit([wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]]);
            let a2 = alpha * alpha;
            // Lagarde and de Rousiers 2014, listing 2, with the distribution of Walter's paper.
            let d = walter(alpha, h, wo).0;
            let v = ci * (co * co * (1.0 - a2) + a2).sqrt() + co * (ci * ci * (1.0 - a2) + a2).sqrt();
            let x = 1.0 - dot(wo, h);
            let expected = f0.map(|f0| (f0 + (1.0 - f0) * x * x * x * x * x) * d * (0.5 / v) * ci);
            let found = stack.evaluate(wo, wi, &Samples::new(3)).unwrap();
            close("reflection", found.total.mean(), expected);
            assert_eq!(found.total.variance(), [0.0; 3]);
            assert_eq!((found.coat.mean(), found.base.mean()), (found.total.mean(), [0.0; 3]));
            // The other side of a conductor is dark, and its back is like its front.
            let below = stack.evaluate(wo, [wi[0], wi[1], -wi[2]], &Samples::new(3)).unwrap();
            assert_eq!(below.total.mean(), [0.0; 3]);
            let flipped = |w: [f64; 3]| [w[0], w[1], -w[2]];
            close(
                "back",
                stack.evaluate(flipped(wo), flipped(wi), &Samples::new(1)).unwrap().total.mean(),
                expected,
            );
        }
    }
}

/// Walter et al. 2007, equations 16, 20 and 21, in their own words: indices and not their quotient, `h_t = -(n_i i + n_o o)`.
#[test]
fn rough_refraction_is_walters() {
    for (n_above, n_below, alpha) in [(1.0, 1.5, 0.5), (1.0, 0.6, 0.2), (1.3, 2.6, 1.0)] {
        let stack = one(Interface::dielectric(n_below / n_above).rough(alpha).masking(Masking::Separable));
        for from_below in [false, true] {
            for (co, ci, phi) in PAIRS {
                for transmitted in [false, true] {
                    let side = if from_below { -1.0 } else { 1.0 };
                    let wo = direction(side * co, 0.4);
                    let wi = direction(if transmitted { -side * ci } else { side * ci }, 0.4 + phi);
                    let (n_i, n_o) = if from_below { (n_below, n_above) } else { (n_above, n_below) };
                    // Light from wo, as the energy goes.
                    let (i, o) = (wo, wi);
                    let expected = if transmitted {
                        let ht = unit([0, 1, 2].map(|k| -(n_i * i[k] + n_o * o[k])));
                        // The normal on the side of i; for n_o < n_i that is -h_t.
                        let m = if ht[2] * side > 0.0 { ht } else { ht.map(|x| -x) };
                        if dot(i, m) <= 0.0 || dot(o, m) >= 0.0 {
                            0.0
                        } else {
                            let (d, g_i) = walter(alpha, m, i);
                            let g = g_i * walter(alpha, m, o).1;
                            let t = 1.0 - fresnel(dot(i, m), n_o / n_i);
                            let sum = n_i * dot(i, ht) + n_o * dot(o, ht);
                            (dot(i, m) * dot(o, m) / (i[2] * o[2])).abs() * n_o * n_o * t * g * d
                                / (sum * sum)
                                * o[2].abs()
                        }
                    } else {
                        let m = unit([0, 1, 2].map(|k| i[k] + o[k]));
                        let (d, g_i) = walter(alpha, m, i);
                        let g = g_i * walter(alpha, m, o).1;
                        fresnel(dot(i, m).abs(), n_o / n_i) * d * g / (4.0 * (i[2] * o[2]).abs()) * o[2].abs()
                    };
                    let found = stack.evaluate(wo, wi, &Samples::new(2)).unwrap();
                    close(
                        &format!(
                            "{n_below} of {n_above}, {alpha}, {from_below} {transmitted} {co} {ci} {phi}"
                        ),
                        found.total.mean(),
                        [expected; 3],
                    );
                    assert_eq!(found.total.variance(), [0.0; 3]);
                }
            }
        }
    }
}

/// A rotation of roughness is a rotation of directions the other way.
#[test]
fn anisotropy_turns_with_the_surface() {
    let of = |rotation| one(Interface::dielectric(1.5).anisotropic([0.5, 0.1], rotation));
    let (plain, turned) = (of(0.0), of(0.8));
    for (co, ci, phi) in PAIRS {
        let at = |stack: &Stack, turn| {
            let (wo, wi) = (direction(co, 0.3 + turn), direction(-ci, 0.3 + phi + turn));
            stack.evaluate(wo, wi, &Samples::new(1)).unwrap().total.mean()
        };
        close("turned", at(&turned, 0.8), at(&plain, 0.0));
        assert!(at(&turned, 0.0) != at(&plain, 0.0) || at(&plain, 0.0) == [0.0; 3]);
    }
    // Swapped axes are a quarter of a turn.
    let swapped = one(Interface::dielectric(1.5).anisotropic([0.1, 0.5], 0.0));
    let quarter = of(0.25 * TAU);
    let (wo, wi) = (direction(0.4, 1.0), direction(0.6, 3.0));
    let value = |stack: &Stack| stack.evaluate(wo, wi, &Samples::new(1)).unwrap().total.mean();
    close("swapped", value(&quarter), value(&swapped));
}

/// Directional albedo, by sampling visible normals, against the integral of the value.
#[test]
fn albedo_is_the_integral() {
    let mut family = Family::default();
    let interfaces = [
        ("conductor", Interface::conductor([0.2, 1.1, 1.5], [3.9, 2.6, 1.9]).rough(0.5)),
        ("glass", Interface::dielectric(1.5).rough(0.6)),
        ("separable glass", Interface::dielectric(0.8).rough(0.8).masking(Masking::Separable)),
        ("Schlick's", Interface::schlick_dielectric(1.6, [0.02, 0.1, 0.4]).anisotropic([0.7, 0.4], 0.5)),
        ("unrefracted", Interface::schlick_dielectric(1.0, [0.02, 0.1, 0.4]).rough(0.5)),
        ("sheet", Interface::diffuser([0.1, 0.2, 0.3], [0.4, 0.8, 0.0])),
    ];
    for (name, interface) in interfaces {
        let stack = one(interface);
        for cosine in [0.9, 0.3, -0.5] {
            let wo = direction(cosine, 0.3);
            let albedo = stack.directional_albedo(wo, &Samples::new(1 << 15)).unwrap();
            // At random: refracted light ends abruptly where the facets that send it would be upright.
            let mut points = Points::new(1);
            let mut side = |sign: f64| {
                let mut values = [vec![], vec![], vec![]];
                for _ in 0..20_000 {
                    let (z, phi) = (1e-6 + (1.0 - 1e-6) * points.next(), TAU * points.next());
                    let value =
                        stack.evaluate(wo, direction(sign * z, phi), &Samples::new(1)).unwrap().total.mean();
                    for c in 0..3 {
                        values[c].push(value[c] * TAU);
                    }
                }
                values.map(|values| mean_and_error(&values))
            };
            let sign = if cosine > 0.0 { 1.0 } else { -1.0 };
            let (reflected, transmitted) = (side(sign), side(-sign));
            for c in 0..3 {
                let of = |e: &Estimate| (e.mean()[c], e.standard_error()[c]);
                family.compare(
                    format!("{name} at {cosine}, {c} reflected"),
                    of(&albedo.reflectance),
                    reflected[c],
                );
                // Unrefracted light has no density.
                if name != "unrefracted" {
                    let found = of(&albedo.transmittance);
                    family.compare(format!("{name} at {cosine}, {c} transmitted"), found, transmitted[c]);
                }
            }
        }
    }
    family.judge();
}

/// The coat's part is the reflection of the first interface, whatever is below it.
#[test]
fn the_coat_is_the_first_interface() {
    let coats = [
        Interface::dielectric(1.5).rough(0.2),
        Interface::schlick_dielectric(1.0, [0.04, 0.1, 0.2]).anisotropic([0.3, 0.6], 0.4),
        Interface::diffuser([0.2, 0.4, 0.1], [0.3, 0.3, 0.9]),
    ];
    let mut family = Family::default();
    for coat in coats {
        let stack = Stack::builder()
            .interface(coat)
            .medium(Medium::absorbing([0.1, 0.5, 0.0]))
            .interface(Interface::lambertian([0.9; 3]))
            .build()
            .unwrap();
        let alone = one(coat);
        for (co, ci, phi) in PAIRS {
            let (wo, wi) = (direction(co, 0.4), direction(ci, 0.4 + phi));
            let found = stack.evaluate(wo, wi, &Samples::new(300)).unwrap();
            let expected = alone.evaluate(wo, wi, &Samples::new(1)).unwrap().total.mean();
            assert_eq!((found.coat.mean(), found.coat.variance()), (expected, [0.0; 3]));
            assert!(found.base.mean().iter().all(|base| *base > 0.0));
            let sum = |c: usize| found.coat.mean()[c] + found.base.mean()[c];
            close("both lobes", found.total.mean(), [sum(0), sum(1), sum(2)]);
        }
        let albedo = stack.directional_albedo(direction(0.6, 0.4), &Samples::new(1 << 14)).unwrap();
        let expected = alone.directional_albedo(direction(0.6, 0.4), &Samples::new(1 << 14)).unwrap();
        for c in 0..3 {
            let of = |e: &Estimate| (e.mean()[c], e.standard_error()[c]);
            family.compare(format!("{coat:?}, channel {c}"), of(&albedo.coat), of(&expected.reflectance));
        }
    }
    family.judge();
}
