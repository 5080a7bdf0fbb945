//! Stacks under light from afar.

use super::direction;
use super::statistics::Family;
use overcoat_lab::truth::{Interface, Medium, Outcome, Samples, Stack};

/// Rough lacquer that absorbs, over grey.
fn lacquer() -> Stack {
    Stack::builder()
        .interface(Interface::dielectric(1.5).rough(0.2).multiple_scattering())
        .medium(Medium::absorbing([0.1, 0.3, 0.9]))
        .interface(Interface::lambertian([0.6; 3]))
        .build()
        .unwrap()
}

#[test]
fn under_white_light_it_is_the_albedo_to_the_bit() {
    let (wo, samples) = (direction(0.6, 0.3), Samples::new(1000));
    let white = lacquer().reflected(wo, &samples, |_| [1.0; 3]).unwrap();
    assert_eq!(white, lacquer().directional_albedo(wo, &samples).unwrap().reflectance);
    // From below it is the other side of the matt surface.
    let below = lacquer().reflected(direction(-0.6, 0.3), &samples, |w| [0.5, w[2], -w[2]]).unwrap().mean();
    assert!((below[0] - 0.3).abs() < 1e-12 && below[1] < 0.0 && below[1] == -below[2], "{below:?}");
}

#[test]
fn matt_surfaces_have_formulas_and_mirrors_show_what_is_there() {
    // The cosine's part of a radiance of 1 + x, y, z is 1 + 2/3 n; here n is z.
    let light = |w: [f64; 3]| w.map(|c| 1.0 + c);
    let matt = Stack::builder().interface(Interface::lambertian([0.5; 3])).build().unwrap();
    let found = matt.reflected(direction(0.5, 1.0), &Samples::new(1 << 14), light).unwrap();
    let mut family = Family::default();
    for (c, expected) in [0.5, 0.5, 0.5 * (1.0 + 2.0 / 3.0)].into_iter().enumerate() {
        let value = (found.mean()[c], found.standard_error()[c]);
        family.compare(format!("channel {c}"), value, (expected, 0.0));
    }
    family.judge();
    let mirror = Stack::builder().interface(Interface::schlick_conductor([1.0; 3])).build().unwrap();
    let [x, y, z] = direction(0.5, 1.0);
    let found = mirror.reflected([x, y, z], &Samples::new(2), light).unwrap();
    let seen = light([-x, -y, z]);
    assert!((0..3).all(|c| (found.mean()[c] - seen[c]).abs() < 1e-12), "{:?} is not {seen:?}", found.mean());
}

/// Another way to the same: walks that end in one direction.
#[test]
fn it_agrees_with_sampled_directions() {
    let light = |[x, _, z]: [f64; 3]| if x > 0.2 { [1.0, z, 2.0] } else { [0.0; 3] };
    let (stack, count) = (lacquer(), 1 << 15);
    let mut family = Family::default();
    for cosine in [0.95, 0.3] {
        let wo = direction(cosine, 2.5);
        let found = stack.reflected(wo, &Samples::new(count), light).unwrap();
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        for index in 0..count {
            if let Outcome::Left(sample) = stack.sample(wo, 1, index).unwrap() {
                let seen = light(sample.direction);
                for c in 0..3 {
                    let value = sample.weight[c] * seen[c];
                    sum[c] += value;
                    squares[c] += value * value;
                }
            }
        }
        let n = count as f64;
        for c in 0..3 {
            let mean = sum[c] / n;
            let error = ((squares[c] / n - mean * mean) / n).sqrt();
            let value = (found.mean()[c], found.standard_error()[c]);
            family.compare(format!("{cosine}, channel {c}"), value, (mean, error));
        }
    }
    family.judge();
}
