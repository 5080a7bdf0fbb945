//! Environments that belong to the program, by name: the one table of which help, schemas, services and bindings are made.
//!
//! All but the studio are painted when they are asked for, which takes some milliseconds once a process, and are filtered as pictures
//! are. Programs that do not use them hold the formulas alone.

use overcoat_core::math::{double, scalar};
use overcoat_scene::{EnvironmentSource, EquirectImage};
use std::sync::{Arc, OnceLock};

/// An environment by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum NamedEnvironment {
    /// The built-in studio.
    #[default]
    Studio,
    /// A studio for cars.
    CarStudio,
    /// A clear sky.
    Sky,
    /// Darkness.
    None,
}

impl NamedEnvironment {
    /// All there are.
    pub const ALL: &'static [Self] = &[Self::Studio, Self::CarStudio, Self::Sky, Self::None];

    /// Its name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::CarStudio => "car-studio",
            Self::Sky => "sky",
            Self::None => "none",
        }
    }

    /// Words for it.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Studio => "soft boxes in a grey room",
            Self::CarStudio => "long graded strips over a bright horizon and a dark floor",
            Self::Sky => "a clear sky with a soft sun",
            Self::None => "darkness",
        }
    }

    /// The one of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|environment| environment.name() == name)
    }

    /// Names of all, and of others that a program knows, as a sentence lists them.
    #[must_use]
    pub fn sentence<'a>(others: impl IntoIterator<Item = &'a str>) -> String {
        let mut names: Vec<&str> = Self::names().collect();
        names.extend(others);
        let last = names.pop().unwrap_or_default();
        format!("{} or {last}", names.join(", "))
    }

    /// Names of all.
    pub fn names() -> impl ExactSizeIterator<Item = &'static str> + Clone {
        Self::ALL.iter().map(|environment| environment.name())
    }

    /// Its light.
    #[must_use]
    pub fn source(self) -> EnvironmentSource {
        static CAR_STUDIO: OnceLock<EnvironmentSource> = OnceLock::new();
        static SKY: OnceLock<EnvironmentSource> = OnceLock::new();
        match self {
            Self::Studio => EnvironmentSource::Studio,
            Self::CarStudio => CAR_STUDIO.get_or_init(|| painted(car_studio)).clone(),
            Self::Sky => SKY.get_or_init(|| painted(sky)).clone(),
            Self::None => EnvironmentSource::None,
        }
    }
}

/// Rows of paintings; they have twice as many columns.
const ROWS: u32 = 512;

/// A picture of radiance by direction.
fn painted(radiance: impl Fn([f32; 3]) -> [f32; 3]) -> EnvironmentSource {
    use std::f64::consts::PI;
    // Sine and cosine in the middle of each of so many parts of a half or whole turn.
    let turns = |count: u32, whole: f64| -> Vec<[f32; 2]> {
        let of = |k: u32| double::sin_cos((f64::from(k) + 0.5) * whole / f64::from(count));
        (0..count).map(|k| of(k).into()).map(|[sin, cos]: [f64; 2]| [sin as f32, cos as f32]).collect()
    };
    let (rows, columns) = (turns(ROWS, PI), turns(2 * ROWS, 2.0 * PI));
    let mut pixels = Vec::with_capacity((2 * ROWS * ROWS) as usize);
    for [ring, up] in &rows {
        // The first column looks to -X.
        pixels.extend(columns.iter().map(|[sin, cos]| radiance([-cos * ring, *up, -sin * ring])));
    }
    // Always possible: the numbers agree.
    let image = EquirectImage::new(2 * ROWS, ROWS, pixels);
    image.map_or(EnvironmentSource::None, |image| EnvironmentSource::Image(Arc::new(image)))
}

/// Smooth step from 0 at or below 0 to 1 at or above 1.
fn smooth(x: f32) -> f32 {
    let x = if x > 0.0 { if x < 1.0 { x } else { 1.0 } } else { 0.0 };
    x * x * (3.0 - 2.0 * x)
}

/// 1 between two values, 0 beyond, with edges of a width.
fn between(x: f32, [low, high]: [f32; 2], edge: f32) -> f32 {
    smooth((x - low) / edge + 0.5) * smooth((high - x) / edge + 0.5)
}

/// A studio for cars, whose length lies along Z: a dark floor up to a bright horizon, which draws a line along the flanks; over the roof
/// a weak panel between two long strips, and at each side a low one. Strips are graded along the car, so that its curves show.
fn car_studio([x, y, z]: [f32; 3]) -> [f32; 3] {
    let room = if y > 0.0 { 0.06 + 0.8 * scalar::exp(-9.0 * y) } else { 0.035 + 0.3 * scalar::exp(7.0 * y) };
    let mut sum = [room, room * 1.01, room * 1.03];
    let mut add = |light: f32, color: [f32; 3]| {
        for (sum, color) in sum.iter_mut().zip(color) {
            *sum += light * color;
        }
    };
    // At the ceiling.
    if y > 0.1 {
        let (across, along) = ((x / y).abs(), z / y);
        let graded = 0.35 + 0.65 * smooth(along * 0.25 + 0.5);
        let length = between(along, [-2.6, 2.6], 0.3);
        add(between(across, [-1.0, 0.55], 0.1) * length * graded, [1.6, 1.58, 1.52]);
        add(between(across, [0.83, 1.12], 0.1) * length * graded, [6.0, 5.9, 5.7]);
    }
    // On the walls at both sides, weaker towards the floor.
    let beside = x.abs();
    if beside > 0.1 {
        let (up, along) = (y / beside, z / beside);
        let strip = between(up, [0.24, 0.42], 0.05) * between(along, [-1.9, 1.9], 0.2);
        let graded = (0.25 + 0.75 * smooth(along * 0.3 + 0.5)) * (0.4 + 0.6 * smooth((up - 0.24) * 7.0));
        add(strip * graded, [4.4, 4.5, 4.7]);
    }
    // Before and behind.
    let before = z.abs();
    if before > 0.1 {
        let (up, along) = (y / before, x / before);
        add(between(up, [0.45, 0.62], 0.06) * between(along, [-0.75, 0.75], 0.08), [2.6, 2.6, 2.6]);
    }
    sum
}

/// Unit vector towards the sun: 40 degrees high, at the left of a camera that looks from +Z.
const SUN: [f32; 3] = [-0.541_675_2, 0.642_787_6, 0.541_675_2];

/// A clear sky over grey ground, by the CIE's general sky of type 12 (ISO 15469, "clear, low turbidity"; a = -1, b = -.32, c = 10, d = -3,
/// e = .45). The sun is six times as wide as it is and so much weaker, so that it lights as much.
fn sky([x, y, z]: [f32; 3]) -> [f32; 3] {
    let [sun_x, sun_y, sun_z] = SUN;
    let toward = x * sun_x + y * sun_y + z * sun_z;
    // Rounding puts cosines beyond 1; the function holds them there.
    let angle = scalar::acos(toward);
    let gradation = |cosine: f32| 1.0 - scalar::exp(-0.32 / if cosine > 0.01 { cosine } else { 0.01 });
    let indicatrix = |angle: f32, cosine: f32| {
        1.0 + 10.0 * (scalar::exp(-3.0 * angle) - 0.008_983) + 0.45 * cosine * cosine
    };
    let up = if y > 0.0 { y } else { 0.0 };
    // Value at the zenith, whose angle from the sun is 50 degrees.
    let zenith = gradation(1.0) * indicatrix(0.872_664_6, sun_y);
    let luminance = 0.26 * gradation(up) * indicatrix(angle, toward) / zenith;
    // Blue where light is scattered once, white towards the horizon and about the sun.
    let white = 0.25 + 0.75 * scalar::exp(-4.5 * up) + 0.35 * scalar::exp(-5.0 * angle);
    let white = if white < 1.0 { white } else { 1.0 };
    let mix = |blue: f32, pale: f32| (blue + (pale - blue) * white) * luminance;
    let mut sum = [mix(0.58, 0.97), mix(0.98, 1.0), mix(1.75, 1.1)];
    let disc = smooth((0.028 - angle) * 250.0 + 0.5);
    let below = smooth(y * -60.0 + 0.2);
    for (sum, (of_sun, ground)) in sum.iter_mut().zip([(950.0, 0.17), (880.0, 0.16), (780.0, 0.145)]) {
        *sum += disc * of_sun;
        *sum += (ground - *sum) * below;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_again() {
        for &environment in NamedEnvironment::ALL {
            assert_eq!(NamedEnvironment::named(environment.name()), Some(environment));
        }
        assert_eq!(NamedEnvironment::named("Sky"), None);
        assert_eq!(NamedEnvironment::sentence([]), "studio, car-studio, sky or none");
        assert_eq!(NamedEnvironment::sentence(["dusk"]), "studio, car-studio, sky, none or dusk");
    }

    /// Irradiance over pi on a surface of that normal.
    fn irradiance(picture: &EquirectImage, normal: [f32; 3]) -> [f64; 3] {
        let (mut sum, mut all) = ([0.0; 3], 0.0);
        let step = std::f64::consts::PI / f64::from(ROWS);
        for (k, pixel) in picture.pixels().iter().enumerate() {
            let (row, column) = (k as u32 / picture.width(), k as u32 % picture.width());
            let (ring, y) = double::sin_cos((f64::from(row) + 0.5) * step);
            let (z, x) = double::sin_cos((f64::from(column) + 0.5 - f64::from(ROWS)) * step);
            let d = [x * ring, y, z * ring];
            let cosine: f64 = (0..3).map(|k| d[k] * f64::from(normal[k])).sum();
            let weight = cosine.max(0.0) * ring;
            all += weight;
            (0..3).for_each(|k| sum[k] += weight * f64::from(pixel[k]));
        }
        sum.map(|s| s / all)
    }

    #[test]
    fn paintings_light_as_much_as_photographs_of_middle_exposure() {
        for (environment, range) in
            [(NamedEnvironment::CarStudio, 0.4..1.3), (NamedEnvironment::Sky, 0.7..1.3)]
        {
            let EnvironmentSource::Image(picture) = environment.source() else { panic!("painted") };
            let [_, from_above, _] = irradiance(&picture, [0.0, 1.0, 0.0]);
            let [_, from_below, _] = irradiance(&picture, [0.0, -1.0, 0.0]);
            println!("{environment:?}: {from_above} {from_below}");
            assert!(range.contains(&from_above) && from_below < 0.3 * from_above, "{environment:?}");
            // Painted once.
            let EnvironmentSource::Image(again) = environment.source() else { panic!("painted") };
            assert!(Arc::ptr_eq(&picture, &again));
        }
    }

    #[test]
    fn the_sun_is_where_it_should_be() {
        let EnvironmentSource::Image(picture) = NamedEnvironment::Sky.source() else { panic!("painted") };
        let brightest =
            picture.pixels().iter().enumerate().max_by(|a, b| a.1[1].total_cmp(&b.1[1])).unwrap().0;
        let (row, column) = (brightest as u32 / (2 * ROWS), brightest as u32 % (2 * ROWS));
        // 50 degrees from the top; z = -x at u = atan2(z, x) / 2 pi + .5 = 7/8.
        assert!((f64::from(row) / f64::from(ROWS) - 50.0 / 180.0).abs() < 0.02, "{row}");
        assert!((f64::from(column) / f64::from(2 * ROWS) - 0.875).abs() < 0.01, "{column}");
        assert!(picture.pixels().iter().flatten().all(|&v| v < 1000.0));
    }
}
