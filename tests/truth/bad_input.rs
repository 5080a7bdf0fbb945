//! Whatever is asked: a finite answer, or an error that says which layer, what, and which values there may be.

use super::direction;
use overcoat_lab::truth::{CHUNK, Interface, MAX_INTERFACES, Medium, Outcome, Samples, Stack, StackBuilder};

fn refused(builder: StackBuilder, expected: &str) {
    let error = builder.build().map(|_| ()).unwrap_err().to_string();
    assert_eq!(error, expected);
}

#[test]
fn stacks_that_are_none() {
    let glass = Interface::dielectric(1.5);
    let white = Interface::lambertian([1.0; 3]);
    let with = |interface| Stack::builder().interface(glass).interface(interface);
    let medium = |medium| Stack::builder().interface(glass).medium(medium).interface(white);
    refused(Stack::builder(), "a stack has 0 interfaces; allowed are 1 to 128");
    let many = (0..=MAX_INTERFACES).fold(Stack::builder(), |builder, _| builder.interface(glass));
    refused(many, "a stack has 129 interfaces; allowed are 1 to 128");
    let order = "is not between two interfaces: a medium follows an interface, and an interface a medium";
    refused(Stack::builder().medium(Medium::CLEAR).interface(glass), &format!("medium 0 {order}"));
    refused(with(glass).medium(Medium::CLEAR), &format!("medium 1 {order}"));
    refused(with(glass).medium(Medium::CLEAR).medium(Medium::CLEAR), &format!("medium 1 {order}"));

    for (eta, found) in [(0.0, "0"), (-1.5, "-1.5"), (11.0, "11"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")]
    {
        let text = format!("interface 1: relative index of refraction is {found}; allowed is 0.1 to 10");
        refused(with(Interface::dielectric(eta)), &text);
    }
    refused(
        with(Interface::schlick_dielectric(1.5, [0.0, 1.5, 0.0])),
        "interface 1: reflectance at normal incidence is 1.5; allowed is 0 to 1",
    );
    refused(
        with(Interface::schlick_conductor([-0.1; 3])),
        "interface 1: reflectance at normal incidence is -0.1; allowed is 0 to 1",
    );
    refused(
        with(Interface::conductor([0.0; 3], [1.0; 3])),
        "interface 1: index of refraction n is 0; allowed is above 0 to 100",
    );
    refused(
        with(Interface::conductor([1.0; 3], [-1.0; 3])),
        "interface 1: extinction k of the index is -1; allowed is 0 to 100",
    );
    refused(with(Interface::lambertian([2.0; 3])), "interface 1: reflectance is 2; allowed is 0 to 1");
    refused(
        with(Interface::diffuser([0.5; 3], [0.75; 3])),
        "interface 1: reflectance + transmittance is 1.25; allowed is at most 1",
    );
    for (alpha, found) in [(-0.1, "-0.1"), (1.5, "1.5"), (1e-6, "0.000001"), (f64::NAN, "NaN")] {
        refused(
            with(glass.rough(alpha)),
            &format!("interface 1: alpha is {found}; allowed is 0, or 0.0001 to 1"),
        );
    }
    refused(
        with(glass.anisotropic([0.5, 0.0], 0.0)),
        "interface 1: alpha must be 0 along both axes or along none",
    );
    refused(
        with(glass.anisotropic([0.5; 2], f64::NAN)),
        "interface 1: rotation in radians is NaN; allowed is -1000 to 1000",
    );
    refused(with(white.rough(0.5)), "interface 1: alpha is of dielectrics and conductors");
    refused(with(glass.multiple_scattering()), "interface 1: multiple scattering needs an alpha above 0");
    let unrefracted = Interface::schlick_dielectric(1.0, [0.04; 3]).rough(0.5).multiple_scattering();
    refused(
        with(unrefracted),
        "interface 1: multiple scattering of a dielectric needs a relative index other than 1",
    );
    let separable = glass.rough(0.5).masking(overcoat_lab::truth::Masking::Separable).multiple_scattering();
    refused(with(separable), "interface 1: multiple scattering needs correlated masking");

    let clear = Medium::CLEAR;
    refused(
        medium(Medium { extinction: [0.0, -1.0, 0.0], ..clear }),
        "medium 0: extinction is -1; allowed is at least 0",
    );
    refused(
        medium(Medium { extinction: [f64::INFINITY; 3], ..clear }),
        "medium 0: extinction is inf; allowed is at least 0",
    );
    refused(
        medium(Medium { thickness: f64::NAN, ..clear }),
        "medium 0: thickness is NaN; allowed is at least 0",
    );
    refused(medium(Medium { albedo: [1.1; 3], ..clear }), "medium 0: albedo is 1.1; allowed is 0 to 1");
    refused(
        medium(Medium { anisotropy: 1.0, ..clear }),
        "medium 0: anisotropy is 1; allowed is -0.999 to 0.999",
    );
    let thick = Medium { extinction: [1e9; 3], thickness: 100.0, ..clear };
    refused(medium(thick), "medium 0: extinction times thickness is 100000000000; allowed is 0 to 10^10");
}

#[test]
fn directions_that_are_none() {
    let stack = Stack::builder().interface(Interface::lambertian([0.5; 3])).build().unwrap();
    let (up, samples) = ([0.0, 0.0, 1.0], Samples::new(1));
    let bad = [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 1e-7],
        [0.0, 0.0, 1.01],
        [f64::NAN, 0.0, 1.0],
        [0.0, f64::INFINITY, 1.0],
        [f64::MAX; 3],
    ];
    for w in bad {
        for error in [
            stack.evaluate(w, up, &samples).map(|_| ()).unwrap_err(),
            stack.evaluate(up, w, &samples).map(|_| ()).unwrap_err(),
            stack.density(up, w, &samples).map(|_| ()).unwrap_err(),
            stack.directional_albedo(w, &samples).map(|_| ()).unwrap_err(),
            stack.reflected(w, &samples, |_| [1.0; 3]).map(|_| ()).unwrap_err(),
            stack.sample(w, 0, 0).map(|_| ()).unwrap_err(),
        ] {
            let text = error.to_string();
            assert!(text.starts_with("direction w") && text.contains("allowed are unit vectors"), "{text}");
        }
    }
    for samples in [Samples::new(0), Samples { first: 1, count: 5, seed: 0 }, Samples::new(u64::MAX)] {
        let error = stack.evaluate(up, up, &samples).unwrap_err().to_string();
        assert!(error.starts_with("samples begin at"), "{error}");
        assert!(stack.directional_albedo(up, &samples).is_err());
    }
    // Parts of what is no range are none either, and few.
    let none = Samples { first: u64::MAX, count: u64::MAX, seed: 0 };
    assert!(
        none.parts(7).len() <= 7 && none.parts(7).iter().all(|part| stack.evaluate(up, up, part).is_err())
    );
    // Single precision is good enough.
    let w = [0.577_350_3_f32; 3].map(f64::from);
    assert!(stack.evaluate(w, w, &samples).is_ok());
}

/// The ends of all ranges together: finite, not negative, within energy.
#[test]
fn extremes() {
    let ends: Vec<Interface> = [0.1, 0.999_999, 1.0, 1.000_001, 10.0]
        .into_iter()
        .flat_map(|eta| {
            [0.0, 1e-4, 1.0].into_iter().flat_map(move |alpha| {
                let multiple = if alpha > 0.0 && eta != 1.0 {
                    Interface::dielectric(eta).rough(alpha).multiple_scattering()
                } else {
                    Interface::dielectric(eta).rough(alpha)
                };
                [multiple, Interface::schlick_dielectric(eta, [0.0, 0.5, 1.0]).rough(alpha)]
            })
        })
        .chain([
            Interface::conductor([1e-3, 1.0, 100.0], [0.0, 100.0, 1.0]).anisotropic([1e-4, 1.0], 1000.0),
            Interface::schlick_conductor([0.0, 0.5, 1.0]).rough(1e-4).multiple_scattering(),
            Interface::lambertian([0.0, 0.5, 1.0]),
            Interface::lambertian([0.0; 3]),
            Interface::diffuser([0.7, 0.0, 0.0], [0.3, 1.0, 0.0]),
        ])
        .collect();
    let media = [
        Medium::CLEAR,
        Medium { thickness: 0.0, ..Medium::absorbing([1e9; 3]) },
        Medium::absorbing([1e9, 0.0, 1e-9]),
        Medium { extinction: [1e9, 1.0, 0.0], albedo: [0.9, 1.0, 1.0], anisotropy: 0.999, thickness: 1.0 },
        Medium { extinction: [5.0; 3], albedo: [1.0, 0.0, 0.5], anisotropy: -0.999, thickness: 1.0 },
    ];
    let horizon = direction(1e-6, 0.4);
    let directions = [[0.0, 0.0, 1.0], direction(0.5, 1.0), horizon, horizon.map(|x| -x), [0.0, 0.0, -1.0]];
    let samples = Samples::new(4);
    let mut answers = 0;
    for (number, &top) in ends.iter().enumerate() {
        // Each with every third, so that all meet each other's kinds.
        for (k, &bottom) in ends.iter().enumerate().skip(number % 3).step_by(3) {
            let medium = media[(number + k) % media.len()];
            let stack = Stack::builder().interface(top).medium(medium).interface(bottom).build().unwrap();
            for &wo in &directions {
                let albedo = stack.directional_albedo(wo, &samples).unwrap();
                for estimate in [&albedo.coat, &albedo.base, &albedo.reflectance, &albedo.transmittance] {
                    for value in estimate.mean() {
                        assert!(
                            value.is_finite() && value >= 0.0,
                            "{top:?} {medium:?} {bottom:?} {wo:?}: {value}"
                        );
                    }
                }
                for &wi in &directions {
                    let found = stack.evaluate(wo, wi, &samples).unwrap().total;
                    let good =
                        found.mean().iter().chain(&found.variance()).all(|v| v.is_finite() && *v >= 0.0);
                    assert!(good, "{top:?} {medium:?} {bottom:?} {wo:?} {wi:?}: {found:?}");
                    answers += 1;
                }
                for index in 0..4 {
                    if let Outcome::Left(sample) = stack.sample(wo, 0, index).unwrap() {
                        assert!(
                            sample.weight.iter().chain(&sample.direction).all(|v| v.is_finite()),
                            "{sample:?}"
                        );
                    }
                }
            }
        }
    }
    assert!(answers > 5_000);
}

/// As many interfaces as there may be.
#[test]
fn a_hundred_interfaces() {
    let glass = |k: usize| Interface::dielectric(if k.is_multiple_of(2) { 1.2 } else { 1.0 / 1.2 });
    let builder =
        (0..MAX_INTERFACES - 1).fold(Stack::builder(), |builder, k| builder.interface(glass(k).rough(0.1)));
    let stack = builder.interface(Interface::lambertian([0.5; 3])).build().unwrap();
    let albedo = stack.directional_albedo(direction(0.7, 0.0), &Samples::new(100)).unwrap();
    assert!(albedo.reflectance.mean().iter().all(|r| *r > 0.0 && *r < 1.0));
    let value = stack.evaluate(direction(0.7, 0.0), direction(0.5, 0.0), &Samples::new(100)).unwrap().total;
    assert!(value.mean().iter().all(|v| v.is_finite()));
}

/// Walks that never end are given up, and counted. Without absorption in a medium without end, one of some thousands is as
/// long.
#[test]
fn walks_without_end_are_counted() {
    let fog = |albedo| Medium { extinction: [1e9; 3], albedo: [albedo; 3], anisotropy: 0.0, thickness: 1.0 };
    let stack = |albedo| {
        let nothing = Interface::dielectric(1.0);
        Stack::builder().interface(nothing).medium(fog(albedo)).interface(nothing).build().unwrap()
    };
    let samples = Samples::new(16 * CHUNK);
    let found = stack(1.0).directional_albedo([0.0, 0.0, 1.0], &samples).unwrap();
    let truncated = found.reflectance.truncated();
    assert!(truncated > 0 && truncated < 20, "{truncated}");
    // The missing light is that of the walks that were given up.
    let missing = 1.0 - found.reflectance.mean()[0];
    assert!((missing - truncated as f64 / samples.count as f64).abs() < 1e-9, "{missing}");
    // With absorption they end.
    let found = stack(0.99).directional_albedo([0.0, 0.0, 1.0], &samples).unwrap();
    assert_eq!(found.reflectance.truncated(), 0);
}
