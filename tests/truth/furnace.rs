//! White furnace: without absorption no light is lost.

use super::direction;
use super::statistics::Family;
use overcoat_lab::truth::{Interface, Medium, Samples, Stack};

const WHITE: [f64; 3] = [1.0; 3];
const COSINES: [f64; 4] = [1.0, 0.6, 0.2, 0.02];

/// Interfaces without absorption.
fn lossless() -> Vec<(String, Interface)> {
    let mut all = Vec::new();
    for alpha in [0.0, 0.01, 0.1, 0.4, 1.0] {
        let mut rough = |name: &str, interface: Interface| {
            let interface = interface.rough(alpha);
            let interface = if alpha > 0.0 { interface.multiple_scattering() } else { interface };
            all.push((format!("{name}, alpha {alpha}"), interface));
        };
        rough("white conductor", Interface::schlick_conductor(WHITE));
        rough("glass", Interface::dielectric(1.5));
        rough("dense glass", Interface::dielectric(2.4));
        rough("bubble", Interface::dielectric(1.0 / 1.5));
        rough("Schlick's glass", Interface::schlick_dielectric(1.5, [0.04, 0.2, 0.7]));
    }
    let glass = Interface::dielectric(1.5).anisotropic([0.6, 0.05], 0.7).multiple_scattering();
    all.push(("anisotropic glass".into(), glass));
    all.push(("white sheet".into(), Interface::lambertian(WHITE)));
    all.push(("thin white sheet".into(), Interface::diffuser([0.3, 0.5, 1.0], [0.7, 0.5, 0.0])));
    all
}

#[test]
fn one_interface() {
    let mut family = Family::default();
    for (name, interface) in lossless() {
        let stack = Stack::builder().interface(interface).build().unwrap();
        for cosine in COSINES.into_iter().flat_map(|cosine| [cosine, -cosine]) {
            let albedo = stack.directional_albedo(direction(cosine, 0.3), &Samples::new(2048)).unwrap();
            // Both ways on of a sample are correlated, so each sample is looked at: energy is conserved in every single one.
            for c in 0..3 {
                let sum = albedo.reflectance.mean()[c] + albedo.transmittance.mean()[c];
                family.compare(
                    format!("{name} at {cosine}, channel {c}"),
                    (sum, error(&albedo, c)),
                    (1.0, 0.0),
                );
            }
        }
    }
    family.judge();
}

/// Standard error of reflectance and transmittance together, at most.
fn error(albedo: &overcoat_lab::truth::Albedo, c: usize) -> f64 {
    // The error is 0 where every sample adds up to 1, but for rounding.
    let (r, t) = (albedo.reflectance.standard_error()[c], albedo.transmittance.standard_error()[c]);
    if (r - t).abs() < 1e-9 { 0.0 } else { (r * r + t * t).sqrt() }
}

#[test]
fn stacks_of_many() {
    let fog = |depth, g| Medium {
        extinction: [depth, 0.5 * depth, 0.0],
        albedo: WHITE,
        anisotropy: g,
        thickness: 1.0,
    };
    let rough = |eta, alpha| Interface::dielectric(eta).rough(alpha).multiple_scattering();
    let stacks = [
        (
            "smooth coat on white",
            Stack::builder().interface(Interface::dielectric(1.5)).interface(Interface::lambertian(WHITE)),
        ),
        (
            "rough coat on white",
            Stack::builder().interface(rough(1.5, 0.5)).interface(Interface::lambertian(WHITE)),
        ),
        (
            "rough coat with fog on a rough white conductor",
            Stack::builder()
                .interface(rough(1.5, 0.3))
                .medium(fog(2.0, 0.7))
                .interface(Interface::schlick_conductor(WHITE).rough(0.4).multiple_scattering()),
        ),
        (
            "fog between glass, with a way out",
            Stack::builder()
                .interface(rough(1.4, 0.2))
                .medium(fog(3.0, -0.4))
                .interface(rough(1.3, 0.8))
                .medium(fog(0.5, 0.0))
                .interface(Interface::dielectric(0.7)),
        ),
        (
            "unrefracted coat as engines have it",
            Stack::builder()
                .interface(Interface::schlick_dielectric(1.0, [0.04; 3]))
                .interface(Interface::lambertian(WHITE)),
        ),
    ];
    let mut family = Family::default();
    for (name, builder) in stacks {
        let stack = builder.build().unwrap();
        for cosine in COSINES {
            let albedo = stack.directional_albedo(direction(cosine, 0.3), &Samples::new(8192)).unwrap();
            for c in 0..3 {
                let sum = albedo.reflectance.mean()[c] + albedo.transmittance.mean()[c];
                family.compare(
                    format!("{name} at {cosine}, channel {c}"),
                    (sum, error(&albedo, c)),
                    (1.0, 0.0),
                );
            }
        }
    }
    family.judge();
}

/// With absorption no light is gained.
#[test]
fn energy_is_conserved() {
    for (name, stack) in super::reciprocity::stacks() {
        for cosine in COSINES.into_iter().flat_map(|cosine| [cosine, -cosine]) {
            let albedo = stack.directional_albedo(direction(cosine, 0.3), &Samples::new(2048)).unwrap();
            for c in 0..3 {
                let (r, t) = (&albedo.reflectance, &albedo.transmittance);
                let error = r.standard_error()[c] + t.standard_error()[c];
                let sum = r.mean()[c] + t.mean()[c];
                assert!(sum <= 1.0 + 4.0 * error && sum > 0.0, "{name} at {cosine}: {sum}");
                assert!((r.mean()[c] - albedo.coat.mean()[c] - albedo.base.mean()[c]).abs() < 1e-12);
            }
        }
    }
}
