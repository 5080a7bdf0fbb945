//! Bases of plastic in the lab: closed forms, energy, and what is the same as what.

use overcoat::scene::ShadingModel;
use overcoat_lab::lab::{Base, Bench, LabError, Light, Referee, Specimen};
use overcoat_lab::truth::Samples;

const LIGHTS: [Light; 3] = [Light::White, Light::Overhead, Light::Direct(25.0)];

fn plastic(base: Base) -> Specimen {
    Specimen { base, color: [0.05, 0.3, 0.8], ..Specimen::default() }
}

/// Radiance from 40 degrees, with its error, to the last bit.
fn of(specimen: &Specimen, light: Light) -> overcoat_lab::lab::Measured {
    Referee::new(specimen).unwrap().radiance(40.0, light, &Samples::new(512)).unwrap()
}

/// Reflectance of a smooth interface by Fresnel's equations.
pub fn fresnel(cosine: f64, index: f64) -> f64 {
    let beyond = (1.0 - (1.0 - cosine * cosine) / (index * index)).sqrt();
    let s = (cosine - index * beyond) / (cosine + index * beyond);
    let p = (index * cosine - beyond) / (index * cosine + beyond);
    0.5 * (s * s + p * p)
}

/// Share of even light inside of a smooth interface that escapes.
pub fn escapes(index: f64) -> f64 {
    let steps = 20_000;
    let mean = (0..steps).map(|k| (f64::from(k) + 0.5) / f64::from(steps));
    (1.0 - mean.map(|u| 2.0 * u * fresnel(u, index)).sum::<f64>() / f64::from(steps)) / (index * index)
}

#[test]
fn a_base_of_the_coat_s_index_has_no_interface() {
    for (ior, coat_roughness) in [(1.5, 0.0), (1.5, 0.4), (1.9, 0.2), (1.0, 0.3)] {
        let coated = |base| Specimen { coat_ior: ior, base_ior: ior, coat_roughness, ..plastic(base) };
        for light in LIGHTS {
            let lambert = of(&coated(Base::Lambert), light);
            assert_eq!(of(&coated(Base::Interface), light), lambert, "{ior} {light:?}");
            // Rough facets or not: there are none.
            let smooth = Specimen { base_roughness: 0.0, ..coated(Base::Interface) };
            assert_eq!(of(&smooth, light), lambert);
            assert_ne!(of(&coated(Base::Convention), light), lambert);
            // The color that is seen without a coat is darker than the substrate.
            let seen = of(&coated(Base::Seen), light).mean();
            assert!(ior == 1.0 || (0..3).all(|c| seen[c] > lambert.mean()[c]), "{seen:?} {lambert:?}");
        }
    }
    let near = Specimen { base_ior: 1.500_01, ..plastic(Base::Interface) };
    assert_eq!(of(&near, Light::White), of(&plastic(Base::Lambert), Light::White));
    let other = Specimen { base_ior: 1.6, ..plastic(Base::Interface) };
    assert_ne!(of(&other, Light::White), of(&plastic(Base::Lambert), Light::White));
}

#[test]
fn without_specular_strength_all_bases_are_lambert() {
    for coat in [0.0, 0.5, 1.0] {
        let bare = |base| Specimen { coat, specular: 0.0, base_ior: 1.8, ..plastic(base) };
        for light in LIGHTS {
            let lambert = of(&bare(Base::Lambert), light);
            assert!(Base::ALL.iter().all(|&base| of(&bare(base), light) == lambert), "{coat} {light:?}");
        }
        // Nor have models a lobe over Lambert, whatever the strength says.
        let strong = Specimen { specular: 1.0, ..bare(Base::Lambert) };
        assert_eq!(strong.material(), bare(Base::Lambert).material());
        assert_eq!(of(&strong, Light::White), of(&bare(Base::Lambert), Light::White));
    }
}

/// The numbers in the book: dark plastic from above, by each truth.
#[test]
fn dark_lacquered_plastic_has_the_numbers_of_the_book() {
    let dark = |base| Specimen {
        base,
        color: [0.05; 3],
        base_roughness: 0.3,
        coat_roughness: 0.0,
        ..Specimen::default()
    };
    let from_above = |specimen: &Specimen| {
        let found =
            Referee::new(specimen).unwrap().radiance(0.0, Light::White, &Samples::new(1 << 16)).unwrap();
        (found.mean()[1], found.standard_error()[1])
    };
    let e = escapes(1.5);
    let physics = 0.04 + 0.96 * 0.05 * e / (1.0 - 0.05 * (1.0 - e));
    assert!((physics - 0.0600).abs() < 1e-4, "{physics}");
    for (base, expected) in [(Base::Lambert, physics), (Base::Interface, physics), (Base::Convention, 0.0931)]
    {
        let (mean, error) = from_above(&dark(base));
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-3,
            "{base:?}: {mean} +- {error} is not {expected}"
        );
    }
    // Lacquer of the same index changes nothing of what is seen but the reflection of the surface, which is the same.
    let (mean, error) = from_above(&dark(Base::Seen));
    assert!((mean - (0.04 + 0.96 * 0.05)).abs() < 4.0 * error + 1e-4, "{mean} +- {error}");
}

/// Bare plastic: `R + (1 - R) d e / (1 - d (1 - e))`, and `R + (1 - R) color` where the color is what is seen.
#[test]
fn bare_plastic_is_its_closed_form() {
    let angles = [0.0_f64, 45.0, 70.0];
    for (ior, base_roughness, bound) in [(1.5, 0.0, 2e-4), (1.8, 0.0, 2e-4), (1.5, 0.6, 6e-3)] {
        let e = escapes(ior);
        for base in [Base::Interface, Base::Seen] {
            let bare = Specimen { coat: 0.0, base_ior: ior, base_roughness, ..plastic(base) };
            let referee = Referee::new(&bare).unwrap();
            for view in angles {
                let found = referee.radiance(view, Light::White, &Samples::new(1 << 14)).unwrap();
                let r = if base_roughness == 0.0 {
                    fresnel(overcoat_core::math::double::cos(view.to_radians()), ior)
                } else {
                    // All that black plastic reflects.
                    let black = Specimen { color: [0.0; 3], ..bare };
                    let black = Referee::new(&black).unwrap();
                    black.radiance(view, Light::White, &Samples::new(1 << 14)).unwrap().mean()[0]
                };
                for (c, color) in bare.color.into_iter().enumerate() {
                    let shown =
                        if base == Base::Seen { color } else { color * e / (1.0 - color * (1.0 - e)) };
                    let (mean, error) = (found.mean()[c], found.standard_error()[c]);
                    let expected = r + (1.0 - r) * shown;
                    assert!(
                        (mean - expected).abs() < 5.0 * error + bound,
                        "{base:?} {ior} {base_roughness} {view}: {mean} +- {error}, not {expected}"
                    );
                }
            }
        }
    }
}

/// Plastic that absorbs nothing returns all.
#[test]
fn white_plastic_loses_nothing() {
    for base in [Base::Interface, Base::Seen] {
        for (coat, coat_ior, coat_roughness, base_roughness) in [
            (0.0, 1.5, 0.0, 0.7),
            (1.0, 1.3, 0.0, 0.0),
            (1.0, 1.3, 0.4, 0.6),
            (1.0, 1.9, 0.2, 0.8),
            (0.5, 1.9, 0.6, 0.3),
        ] {
            let white = Specimen {
                base,
                color: [1.0; 3],
                coat,
                coat_ior,
                coat_roughness,
                base_roughness,
                ..Specimen::default()
            };
            for view in [0.0, 60.0, 85.0] {
                let found =
                    Referee::new(&white).unwrap().radiance(view, Light::White, &Samples::new(4096)).unwrap();
                let (mean, error) = (found.mean()[0], found.standard_error()[0]);
                assert!((mean - 1.0).abs() < 5.0 * error + 1e-9, "{white:?} from {view}: {mean} +- {error}");
            }
        }
    }
}

#[test]
fn numbers_of_bases_out_of_range_are_named() {
    for base in Base::ALL.iter().map(|&base| plastic(base)) {
        for (specimen, name) in [
            (Specimen { specular: 1.5, ..base }, "specular"),
            (Specimen { specular: f64::NAN, ..base }, "specular"),
            (Specimen { base_ior: 0.9, ..base }, "base_ior"),
            (Specimen { base_ior: f64::INFINITY, ..base }, "base_ior"),
        ] {
            let said = Referee::new(&specimen).map(|_| ());
            assert!(
                matches!(said, Err(LabError::OutOfRange { what, .. }) if what == name),
                "{specimen:?}: {said:?}"
            );
        }
    }
}

/// Engines' reading of the base colour: without a coat all show the color itself, and below one of the same index OpenPBR shows a substrate's.
#[test]
fn engines_mean_what_is_seen_and_openpbr_s_coat_the_substrate() {
    let mut bench = Bench::new(1);
    let specimen =
        |coat, base| Specimen { coat, base, color: [0.5; 3], coat_roughness: 0.0, ..Specimen::default() };
    let mut off = |model, coat, base| {
        let specimen = specimen(coat, base);
        let truth =
            Referee::new(&specimen).unwrap().radiance(20.0, Light::White, &Samples::new(1 << 14)).unwrap();
        bench.radiance(&specimen, model, 20.0, Light::White).unwrap()[1] / truth.mean()[1] - 1.0
    };
    for model in [ShadingModel::Gltf, ShadingModel::OpenPbr, ShadingModel::Standard, ShadingModel::Three] {
        let (seen, substrate) = (off(model, 0.0, Base::Seen), off(model, 0.0, Base::Interface));
        assert!(seen.abs() < 0.05 && substrate > 0.4, "{model:?}: {seen} {substrate}");
    }
    let (seen, substrate) =
        (off(ShadingModel::OpenPbr, 1.0, Base::Seen), off(ShadingModel::OpenPbr, 1.0, Base::Interface));
    assert!(seen < -0.3 && substrate.abs() < 0.06, "{seen} {substrate}");
    let (seen, substrate) =
        (off(ShadingModel::Gltf, 1.0, Base::Seen), off(ShadingModel::Gltf, 1.0, Base::Interface));
    assert!(seen.abs() < 0.12 && substrate > 0.5, "{seen} {substrate}");
}
