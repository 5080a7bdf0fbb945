//! Light can be followed either way; and what is evaluated is what is sampled.

use super::direction;
use super::statistics::{Family, Points, mean_and_error};
use overcoat_lab::truth::{Interface, Medium, Samples, Stack};
use std::f64::consts::TAU;

/// Stacks of all kinds that spread light, each with what it is.
pub fn stacks() -> Vec<(&'static str, Stack)> {
    let fog =
        |depth: [f64; 3], albedo, g| Medium { extinction: depth, albedo, anisotropy: g, thickness: 1.0 };
    let gold = Interface::conductor([0.2, 0.4, 1.5], [3.9, 2.4, 1.9]);
    let glass = |eta: f64, alpha| Interface::dielectric(eta).rough(alpha);
    let builders = [
        (
            "rough coat on a rough conductor",
            Stack::builder()
                .interface(glass(1.5, 0.3))
                .medium(Medium::absorbing([0.1, 0.5, 1.0]))
                .interface(gold.rough(0.5)),
        ),
        (
            "the same with all facets",
            Stack::builder()
                .interface(glass(1.5, 0.6).multiple_scattering())
                .interface(gold.rough(0.8).multiple_scattering()),
        ),
        (
            "rough coat on fog on a diffuse base",
            Stack::builder()
                .interface(glass(1.5, 0.4))
                .medium(fog([1.0, 2.0, 0.2], [0.9, 0.5, 1.0], 0.6))
                .interface(Interface::lambertian([0.8, 0.2, 0.5])),
        ),
        (
            "two coats on metal",
            Stack::builder()
                .interface(
                    Interface::schlick_dielectric(1.4, [0.03, 0.04, 0.05]).anisotropic([0.5, 0.2], 0.5),
                )
                .medium(fog([0.3; 3], [0.5; 3], -0.3))
                .interface(glass(1.3, 0.5))
                .medium(fog([0.5, 0.1, 0.0], [1.0; 3], 0.0))
                .interface(Interface::schlick_conductor([0.9, 0.6, 0.3]).anisotropic([0.2, 0.6], -0.4)),
        ),
        (
            "fog that lets light through, below all facets",
            Stack::builder()
                .interface(glass(1.5, 0.5))
                .medium(fog([1.0, 0.5, 2.0], [0.9, 1.0, 0.3], 0.4))
                .interface(glass(0.8, 0.7).multiple_scattering()),
        ),
        (
            "unrefracted rough coat on a diffuse sheet",
            Stack::builder()
                .interface(Interface::schlick_dielectric(1.0, [0.1, 0.2, 0.3]).rough(0.5))
                .interface(Interface::diffuser([0.5, 0.3, 0.1], [0.2, 0.3, 0.4])),
        ),
        (
            "smooth coat on a rough one on a sheet",
            Stack::builder()
                .interface(Interface::dielectric(1.5))
                .interface(glass(1.2, 0.6))
                .medium(fog([0.5; 3], [0.7; 3], 0.2))
                .interface(Interface::diffuser([0.5, 0.3, 0.9], [0.4, 0.6, 0.0])),
        ),
    ];
    builders.map(|(name, builder)| (name, builder.build().unwrap())).to_vec()
}

#[test]
fn evaluation_is_reciprocal() {
    let mut family = Family::default();
    let (a, b, below) = (direction(0.8, 0.2), direction(0.25, 1.9), direction(-0.6, 4.0));
    for (name, stack) in stacks() {
        for (wo, wi) in [(a, b), (b, a), (a, below), (b, below)] {
            let samples = Samples::new(1 << 13);
            let there = stack.evaluate(wo, wi, &samples).unwrap().total;
            let back = stack.evaluate(wi, wo, &samples).unwrap().total;
            // Reciprocity of radiance: f(wo, wi) over the square of the index at wo is symmetric (Veach 1997, section
            // 5.2).
            let index = |w: [f64; 3]| if w[2] > 0.0 { 1.0 } else { stack.index_below() };
            let scale =
                |wo, wi: [f64; 3]| stack.radiance_scale(wo, wi) / (wi[2].abs() * index(wo) * index(wo));
            for c in 0..3 {
                let of =
                    |e: &overcoat_lab::truth::Estimate, s: f64| (e.mean()[c] * s, e.standard_error()[c] * s);
                let (x, y) = (of(&there, scale(wo, wi)), of(&back, scale(wi, wo)));
                family.compare(format!("{name}, {wo:.2?} {wi:.2?}, channel {c}"), x, y);
            }
        }
    }
    family.judge();
}

#[test]
fn albedo_is_the_integral_of_the_value() {
    let mut family = Family::default();
    for (number, (name, stack)) in stacks().into_iter().enumerate() {
        for cosine in [0.9, 0.3, -0.6] {
            let wo = direction(cosine, 1.0);
            let albedo = stack.directional_albedo(wo, &Samples::new(1 << 14)).unwrap();
            let mut points = Points::new(number as u64);
            let count = 6000;
            let mut values = [[vec![], vec![], vec![]], [vec![], vec![], vec![]]];
            for _ in 0..count {
                // By cosine, which the value goes as.
                let z = points.next().sqrt();
                let phi = TAU * points.next();
                let z = if z < 1e-5 { 1e-5 } else { z };
                for (side, sign) in [(0, 1.0), (1, -1.0)] {
                    let wi = direction(sign * z * if cosine > 0.0 { 1.0 } else { -1.0 }, phi);
                    let value = stack.evaluate(wo, wi, &Samples::new(2)).unwrap().total.mean();
                    for c in 0..3 {
                        values[side][c].push(value[c] * std::f64::consts::PI / z);
                    }
                }
            }
            // Light that a smooth coat reflects has no density.
            let smooth = name.starts_with("smooth") && cosine > 0.0;
            let reflected = if smooth { &albedo.base } else { &albedo.reflectance };
            let passes_straight = name.starts_with("unrefracted");
            for c in 0..3 {
                let of = |e: &overcoat_lab::truth::Estimate| (e.mean()[c], e.standard_error()[c]);
                family.compare(
                    format!("{name} at {cosine}, reflected, channel {c}"),
                    of(reflected),
                    mean_and_error(&values[0][c]),
                );
                if !passes_straight {
                    family.compare(
                        format!("{name} at {cosine}, transmitted, channel {c}"),
                        of(&albedo.transmittance),
                        mean_and_error(&values[1][c]),
                    );
                }
            }
        }
    }
    family.judge();
}
