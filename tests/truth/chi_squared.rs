//! Directions that are sampled against the values that are evaluated, bin by bin: Pearson's test, as Mitsuba and pbrt have
//! it, with Sidak's correction. The two share no code but the interfaces: evaluation connects two walks with weights,
//! sampling follows one.

use super::direction;
use super::reciprocity::stacks;
use super::statistics::{Family, Points, gamma_q};
use overcoat_lab::truth::{Interface, Outcome, Samples, Stack};
use std::f64::consts::TAU;

const RINGS: usize = 6;
const TURNS: usize = 8;

/// Histogram of samples: the number in each bin of both hemispheres, of absorbed ones, and of sharp ones.
fn histogram(stack: &Stack, wo: [f64; 3], count: u64) -> (Vec<f64>, f64, f64) {
    let mut bins = vec![0.0; 2 * RINGS * TURNS];
    let (mut absorbed, mut sharp) = (0.0, 0.0);
    for index in 0..count {
        match stack.sample(wo, 3, index).unwrap() {
            Outcome::Absorbed => absorbed += 1.0,
            Outcome::Truncated => panic!("a walk without end"),
            Outcome::Left(sample) if sample.delta => sharp += 1.0,
            Outcome::Left(sample) => {
                assert!((sample.weight.iter().sum::<f64>() - 3.0).abs() < 1e-9, "{sample:?}");
                let [x, y, z] = sample.direction;
                assert!((x * x + y * y + z * z - 1.0).abs() < 1e-12);
                let turn = overcoat_core::math::double::atan2(y, x) / TAU + 0.5;
                let ring = (((z + 1.0) * RINGS as f64) as usize).min(2 * RINGS - 1);
                bins[ring * TURNS + ((turn * TURNS as f64) as usize).min(TURNS - 1)] += 1.0;
            }
        }
    }
    (bins, absorbed, sharp)
}

/// Expected number of samples in each bin by the density, with its variance.
fn expected(stack: &Stack, wo: [f64; 3], count: u64, seed: u64, samples: u64) -> Vec<(f64, f64)> {
    let mut points = Points::new(seed);
    let mut bins = Vec::new();
    for ring in 0..2 * RINGS {
        for turn in 0..TURNS {
            // A grid within the bin, each point anywhere in its cell.
            let cells = 8;
            let (mut sum, mut squares) = (0.0, 0.0);
            for cell in 0..cells * cells {
                let (u, v) = (
                    (f64::from(cell % cells) + points.next()) / f64::from(cells),
                    (f64::from(cell / cells) + points.next()) / f64::from(cells),
                );
                let z = (ring as f64 + u) / RINGS as f64 - 1.0;
                let z = if z.abs() < 1e-5 { 1e-5 } else { z };
                let phi = ((turn as f64 + v) / TURNS as f64 - 0.5) * TAU;
                let value = stack.density(wo, direction(z, phi), &Samples::new(samples)).unwrap().mean()[0];
                sum += value;
                squares += value * value;
            }
            let n = f64::from(cells * cells);
            let (mean, solid_angle) = (sum / n, TAU / (RINGS * TURNS) as f64);
            let variance = (squares / n - mean * mean) / (n - 1.0);
            let scale = count as f64 * solid_angle;
            bins.push((mean * scale, variance * scale * scale));
        }
    }
    bins
}

fn compare(family: &mut Family, what: &str, found: &[f64], expected: &[(f64, f64)]) {
    let (mut statistic, mut freedom) = (0.0, 0);
    let (mut rest_found, mut rest_expected, mut rest_variance) = (0.0, 0.0, 0.0);
    let mut add = |found: f64, expected: f64, variance: f64| {
        // Counts are Poisson's, and what is expected is estimated too.
        statistic += (found - expected) * (found - expected) / (expected + variance);
        freedom += 1;
    };
    for (found, &(expected, variance)) in found.iter().zip(expected) {
        if expected < 10.0 {
            (rest_found, rest_expected, rest_variance) =
                (rest_found + found, rest_expected + expected, rest_variance + variance);
        } else {
            add(*found, expected, variance);
        }
    }
    if rest_expected > 10.0 {
        add(rest_found, rest_expected, rest_variance);
    } else {
        assert!(rest_found < 40.0, "{what}: {rest_found} where there should be {rest_expected}");
    }
    let p = gamma_q(0.5 * f64::from(freedom), 0.5 * statistic);
    family.probability(what, p, format!("chi squared {statistic:.1} of {freedom} degrees of freedom"));
}

#[test]
fn what_is_sampled_is_what_is_evaluated() {
    let mut family = Family::default();
    let single = |interface: Interface| Stack::builder().interface(interface).build().unwrap();
    let glass = Interface::dielectric(1.5);
    let mut all = stacks();
    all.push(("rough glass", single(glass.anisotropic([0.8, 0.3], 0.4))));
    all.push(("rough glass, all facets", single(glass.anisotropic([0.9, 0.5], 0.4).multiple_scattering())));
    all.push(("bubble, all facets", single(Interface::dielectric(0.7).rough(0.6).multiple_scattering())));
    all.push((
        "conductor, all facets",
        single(Interface::schlick_conductor([1.0, 0.8, 0.2]).rough(1.0).multiple_scattering()),
    ));
    all.push(("sheet", single(Interface::diffuser([0.1, 0.5, 0.5], [0.9, 0.2, 0.0]))));
    for (number, (name, stack)) in all.iter().enumerate() {
        for cosine in [0.95, 0.4, -0.7] {
            let wo = direction(cosine, 0.5);
            let count = 30_000;
            let (found, absorbed, sharp) = histogram(stack, wo, count);
            let left: f64 = found.iter().sum();
            assert_eq!(left + absorbed + sharp, count as f64);
            // Values at rough interfaces with all facets are few and large, or small.
            let samples = if name.contains("facets") { 16 } else { 8 };
            let expected = expected(stack, wo, count, number as u64, samples);
            compare(&mut family, &format!("{name} at {cosine}"), &found, &expected);
        }
    }
    family.judge();
}

/// The test sees an error of five percent.
#[test]
fn errors_are_seen() {
    let stack = Stack::builder()
        .interface(Interface::dielectric(1.5))
        .interface(Interface::lambertian([0.9; 3]))
        .build()
        .unwrap();
    let (wo, count) = (direction(0.9, 0.5), 30_000);
    let (found, ..) = histogram(&stack, wo, count);
    for (factor, passes) in [(1.0, true), (1.05, false)] {
        let values: Vec<_> =
            expected(&stack, wo, count, 0, 40).iter().map(|(e, v)| (factor * e, *v)).collect();
        let mut family = Family::default();
        compare(&mut family, "values times a factor", &found, &values);
        assert_eq!(std::panic::catch_unwind(|| family.judge()).is_ok(), passes);
    }
}
