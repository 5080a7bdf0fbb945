//! Parameters of one model whose pictures are nearest to another's.
//!
//! Both are asked for the radiance of a flat surface from [`VIEWS`] under light from one direction, from a soft box
//! and from everywhere. What is made small is the sum of squares of differences of lightness: the cube root (CIE 1976
//! L* is 116 times that, less 16) of x / (1 + x), since light brighter than white is white in pictures. Views count by
//! their cosine, which is the area that a surface seen from there has in pictures. That is done by the method of
//! Levenberg (1944) and Marquardt (1963) with derivatives from differences, from a few starts; the best end counts,
//! and the first of equal ones. Textures are kept as they are, and what they multiply is found where they are white.

use super::{Bench, LabError, Light};
use overcoat_scene::parameters::{Kind, PARAMETERS, Parameter, slots};
use overcoat_scene::{Material, ShadingModel, Workflow};

/// Angles of view, in degrees from the normal.
const VIEWS: [f64; 5] = [0.0, 25.0, 50.0, 68.0, 80.0];

/// Degrees between the mirrored view and light of a highlight. At 0 a sharp highlight would outweigh all else; what of it falls
/// between them a soft box shows.
const HIGHLIGHTS: [f64; 4] = [2.0, 5.0, 10.0, 18.0];

/// Degrees between the mirrored view and other light.
const AWAY: [f64; 3] = [35.0, 60.0, 95.0];

/// White light counts as much as half of the highlights of its view under light from one direction.
const WHITE_WEIGHT: f64 = 2.0;

/// A soft box, as much as all of them.
const SOFT_WEIGHT: f64 = 4.0;

/// Steps of a descent at most.
const STEPS: usize = 60;

/// Parameters that are found, of those that the model reads and the material has. Others keep their values.
const FOUND: [&str; 13] = [
    "base_color",
    "metallic",
    "roughness",
    "specular_f0",
    "glossiness",
    "specular",
    "specular_color",
    "coat",
    "coat_roughness",
    "coat_ior",
    "coat_extinction",
    "coat_color",
    "sheen_color",
];

/// Distance between two models: root mean squares of the differences of lightness, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// Weighted mean over all measures.
    pub all: f64,
    /// Under white light from everywhere.
    pub white: f64,
    /// Around the mirrored view.
    pub highlights: f64,
    /// Under light from elsewhere.
    pub body: f64,
}

/// A material for another model.
#[derive(Clone, Debug, PartialEq)]
pub struct Translation {
    /// Material with the model that it is for. Parameters that the model does not read have their defaults.
    pub material: Material,
    /// Distance of the original material, shaded by the other model.
    pub before: Distance,
    /// Distance of this material.
    pub after: Distance,
}

/// View and light of a comparison, its weight, and the part of the distance it counts in.
struct Measure {
    view: f64,
    light: Light,
    weight: f64,
    part: usize,
}

/// Finds parameters for another model.
#[derive(Debug)]
pub struct Translator {
    bench: Bench,
}

impl Translator {
    /// For pictures of one pixel each.
    #[must_use]
    pub fn new() -> Self {
        Self { bench: Bench::new(1) }
    }

    /// The parameters for `to` whose pictures come nearest to those of a material by `from`. For the same model they
    /// are those of the material.
    ///
    /// # Errors
    /// [`LabError`] if the material is not valid or a model is not built.
    pub fn translate(
        &mut self,
        material: &Material,
        from: ShadingModel,
        to: ShadingModel,
    ) -> Result<Translation, LabError> {
        let target = self.look(&untextured(material), from)?;
        let before = distance(&target, &self.look(&untextured(material), to)?);
        let mut same = material.clone();
        same.model = Some(to);
        if from == to {
            return Ok(Translation { material: same, before, after: before });
        }
        let same = without_unread(&same, to);
        let mut best = (self.off(&same, to, &target)?, same.clone());
        for start in starts(material, &same) {
            let found = self.descend(start, to, &target)?;
            if found.0 < best.0 {
                best = found;
            }
        }
        let after = distance(&target, &self.look(&untextured(&best.1), to)?);
        Ok(Translation { material: best.1, before, after })
    }

    /// Distance between a material under a model and another material under another model.
    ///
    /// # Errors
    /// As [`Translator::translate`].
    pub fn distance(
        &mut self,
        (a, of): (&Material, ShadingModel),
        (b, by): (&Material, ShadingModel),
    ) -> Result<Distance, LabError> {
        Ok(distance(&self.look(&untextured(a), of)?, &self.look(&untextured(b), by)?))
    }

    /// Lightness, three numbers for each measure.
    fn look(&mut self, material: &Material, model: ShadingModel) -> Result<Vec<f64>, LabError> {
        let mut seen = Vec::new();
        for Measure { view, light, .. } in measures() {
            let shown = self.bench.material_radiance(material, model, view, light)?;
            seen.extend(shown.map(lightness));
        }
        Ok(seen)
    }

    /// The weighted sum of squares that is made small.
    fn off(&mut self, material: &Material, model: ShadingModel, target: &[f64]) -> Result<f64, LabError> {
        Ok(residuals(target, &self.look(&untextured(material), model)?).iter().map(|r| r * r).sum())
    }

    /// From a material down to the nearest minimum.
    fn descend(
        &mut self,
        start: Material,
        to: ShadingModel,
        target: &[f64],
    ) -> Result<(f64, Material), LabError> {
        let places = places(&start, to);
        let plain = untextured(&start);
        let mut x: Vec<f64> = places.iter().map(|place| place.read(&plain)).collect();
        let mut look = |x: &[f64]| -> Result<Vec<f64>, LabError> {
            let mut material = plain.clone();
            places.iter().zip(x).for_each(|(place, x)| place.write(&mut material, *x));
            Ok(residuals(target, &self.look(&material, to)?))
        };
        let squares = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        let mut r = look(&x)?;
        let mut damping = 1e-2;
        for _ in 0..STEPS {
            let mut columns = Vec::new();
            for k in 0..x.len() {
                // Away from the nearer end of the range.
                let step = if x[k] > 0.5 { -1e-3 } else { 1e-3 };
                let mut moved = x.clone();
                moved[k] += step;
                let there = look(&moved)?;
                columns.push(there.iter().zip(&r).map(|(a, b)| (a - b) / step).collect::<Vec<f64>>());
            }
            let mut gained = 0.0;
            while gained == 0.0 && damping < 1e6 {
                let next = stepped(&x, &columns, &r, damping);
                let there = look(&next)?;
                gained = squares(&r) - squares(&there);
                if gained > 0.0 {
                    (x, r) = (next, there);
                    damping *= 0.3;
                } else {
                    gained = 0.0;
                    damping *= 4.0;
                }
            }
            if gained <= 1e-9 * squares(&r) {
                break;
            }
        }
        let mut material = start;
        places.iter().zip(&x).for_each(|(place, x)| place.write(&mut material, *x));
        Ok((squares(&r), material))
    }
}

impl Default for Translator {
    fn default() -> Self {
        Self::new()
    }
}

fn measures() -> impl Iterator<Item = Measure> {
    VIEWS.into_iter().flat_map(|view| {
        let area = overcoat_core::math::double::cos(view.to_radians());
        let highlights =
            HIGHLIGHTS.map(|off| Measure { view, light: Light::Direct(view - off), weight: area, part: 1 });
        // On the viewer's side, where that is above the horizon.
        let lit = move |off: f64| Measure { view, light: Light::Direct(view - off), weight: area, part: 2 };
        let body = AWAY.into_iter().filter(move |off| (view - off).abs() < 85.0).map(lit);
        // A sharp highlight is found by its energy: of a soft box in the mirrored view, or not.
        let soft = Measure { view, light: Light::Overhead, weight: SOFT_WEIGHT * area, part: 1 };
        let white = Measure { view, light: Light::White, weight: WHITE_WEIGHT * area, part: 0 };
        [white, soft].into_iter().chain(highlights).chain(body)
    })
}

/// Lightness of a radiance that is not negative, 0 to 1.
fn lightness(x: f64) -> f64 {
    if x <= 0.0 { 0.0 } else { overcoat_core::math::double::pow(x / (1.0 + x), 1.0 / 3.0) }
}

fn residuals(target: &[f64], seen: &[f64]) -> Vec<f64> {
    let weights = measures().flat_map(|measure| [measure.weight.sqrt(); 3]);
    target.iter().zip(seen).zip(weights).map(|((a, b), weight)| (b - a) * weight).collect()
}

fn distance(target: &[f64], seen: &[f64]) -> Distance {
    let (mut sums, mut weights) = ([0.0; 3], [0.0; 3]);
    for (measure, (a, b)) in measures().zip(target.chunks(3).zip(seen.chunks(3))) {
        let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
        sums[measure.part] += measure.weight * square;
        weights[measure.part] += 3.0 * measure.weight;
    }
    let [white, highlights, body] = std::array::from_fn(|part| (sums[part] / weights[part]).sqrt());
    let all = (sums.iter().sum::<f64>() / weights.iter().sum::<f64>()).sqrt();
    Distance { all, white, highlights, body }
}

/// One number of a parameter, from 0 to 1.
#[derive(Clone, Copy)]
struct Position {
    parameter: &'static Parameter,
    component: usize,
}

impl Position {
    /// The largest value that is looked for; colours may be brighter in files, and extinctions larger.
    fn most(&self) -> f32 {
        let high = self.parameter.range().high;
        match self.parameter.name {
            "specular_color" => 1.0,
            _ if high > 100.0 => 8.0,
            _ => high,
        }
    }

    fn read(&self, material: &Material) -> f64 {
        let low = self.parameter.range().low;
        let value = self.parameter.numbers(material)[self.component];
        let share = f64::from(((value - low) / (self.most() - low)).clamp(0.0, 1.0));
        if self.is_color() { share.sqrt() } else { share }
    }

    fn write(&self, material: &mut Material, x: f64) {
        let (low, most) = (f64::from(self.parameter.range().low), f64::from(self.most()));
        let share = if self.is_color() { x * x } else { x };
        let mut numbers = self.parameter.numbers(material);
        numbers[self.component] = (low + (most - low) * share) as f32;
        self.parameter.set_numbers(material, numbers);
    }

    /// Dark colours differ more than bright ones.
    fn is_color(&self) -> bool {
        matches!(self.parameter.kind, Kind::Color(..) | Kind::ColorAndAlpha(..) | Kind::Triple(..))
    }
}

/// Parameters of a material that the search may change for a model.
fn places(material: &Material, model: ShadingModel) -> Vec<Position> {
    // A feature that a material does not use is not added to make up for something else.
    let metal = matches!(material.workflow, Workflow::MetallicRoughness { metallic: 1.0, .. });
    let has = |parameter: &Parameter| match parameter.name {
        "specular" | "specular_color" => !metal,
        "metallic" => !matches!(material.workflow, Workflow::MetallicRoughness { metallic: 0.0, .. }),
        "sheen_color" => material.lobes.sheen.color.factor != [0.0; 3],
        "coat_extinction" => material.coat > 0.0 && material.lobes.coat.thickness.factor > 0.0,
        name => material.coat > 0.0 || !name.starts_with("coat"),
    };
    let is_free = |parameter: &&Parameter| {
        FOUND.contains(&parameter.name)
            && parameter.is_in(material)
            && parameter.models().contains(&model)
            && has(parameter)
    };
    let of = |parameter: &'static Parameter| {
        // Alpha stays.
        let width = parameter.width().min(3);
        (0..width).map(move |component| Position { parameter, component })
    };
    PARAMETERS.iter().filter(is_free).flat_map(of).collect()
}

/// The material without its textures.
fn untextured(material: &Material) -> Material {
    let mut plain = material.clone();
    for (_, slot) in slots() {
        if slot.get(&plain).is_some() {
            slot.set(&mut plain, None);
        }
    }
    plain
}

/// Material with defaults for the parameters that the model does not read.
fn without_unread(material: &Material, model: ShadingModel) -> Material {
    let (mut plain, default) = (material.clone(), Material::default());
    for parameter in PARAMETERS {
        if parameter.width() > 0 && parameter.is_in(material) && !parameter.models().contains(&model) {
            parameter.set_numbers(&mut plain, parameter.numbers(&default));
        }
    }
    // An extinction needs a thickness; a coat without one absorbs nothing.
    let coat = &mut plain.lobes.coat;
    if coat.thickness.factor > 0.0 && coat.thickness.texture.is_none() {
        coat.extinction = coat.extinction.map(|c| c * coat.thickness.factor);
        coat.thickness.factor = 1.0;
    } else if coat.thickness.factor == 0.0
        && reads(model, "coat_extinction")
        && !reads(model, "coat_color")
        && material.lobes.coat.color.factor != [1.0; 3]
    {
        (coat.thickness.factor, coat.extinction) = (1.0, [0.0; 3]);
    }
    plain
}

fn reads(model: ShadingModel, name: &str) -> bool {
    PARAMETERS.iter().any(|p| p.name == name && p.models().contains(&model))
}

/// Start points of the descents: the material as it is; with the colour of the coat in the base and in the coat; and
/// from the middle of all.
fn starts(material: &Material, same: &Material) -> Vec<Material> {
    let coat = &material.lobes.coat;
    let passes: [f32; 3] = std::array::from_fn(|c| {
        let absorbed = f64::from(coat.extinction[c]) * f64::from(coat.thickness.factor);
        (overcoat_core::math::double::exp(-2.0 * absorbed) as f32) * coat.color.factor[c]
    });
    let mut dyed = same.clone();
    for c in 0..3 {
        let coated = material.coat * passes[c] + (1.0 - material.coat);
        dyed.base_color[c] *= if coated < 1.0 { coated } else { 1.0 };
    }
    dyed.lobes.coat.color.factor = [1.0; 3];
    let mut tinted = same.clone();
    // Where the model has both, a tint in the one and nothing in the other.
    if reads(same.model.unwrap_or_default(), "coat_color") {
        tinted.lobes.coat.color.factor = passes.map(|c| c.clamp(0.0, 1.0));
    }
    for start in [&mut dyed, &mut tinted] {
        if start.lobes.coat.thickness.factor > 0.0 {
            start.lobes.coat.extinction = [0.0; 3];
        }
    }
    let mut middle = dyed.clone();
    for place in places(&middle, middle.model.unwrap_or_default()) {
        if !place.is_color() {
            place.write(&mut middle, 0.5);
        }
    }
    vec![same.clone(), dyed, tinted, middle]
}

/// A step of Levenberg and Marquardt's within 0 to 1. A parameter at an end of its range that would leave it stays.
fn stepped(x: &[f64], columns: &[Vec<f64>], r: &[f64], damping: f64) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let gradient: Vec<f64> = columns.iter().map(|column| dot(column, r)).collect();
    let free: Vec<usize> = (0..x.len())
        .filter(|&k| !(x[k] <= 0.0 && gradient[k] > 0.0 || x[k] >= 1.0 && gradient[k] < 0.0))
        .collect();
    let matrix: Vec<Vec<f64>> = free
        .iter()
        .map(|&i| {
            let damp = |j: usize| if i == j { 1.0 + damping } else { 1.0 };
            let row = free
                .iter()
                .map(|&j| damp(j) * dot(&columns[i], &columns[j]) + if i == j { 1e-9 } else { 0.0 });
            row.collect()
        })
        .collect();
    let step = solved(matrix, free.iter().map(|&k| -gradient[k]).collect());
    let mut next = x.to_vec();
    for (&k, step) in free.iter().zip(step) {
        next[k] = (x[k] + step).clamp(0.0, 1.0);
    }
    next
}

/// The solution of a symmetric system with a positive diagonal, by elimination.
fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = a[k][k];
        for i in k + 1..n {
            let factor = a[i][k] / pivot;
            if factor != 0.0 {
                for j in k..n {
                    a[i][j] -= factor * a[k][j];
                }
                b[i] -= factor * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        let value = (b[k] - sum) / a[k][k];
        b[k] = if value.abs() < 1e6 { value } else { 0.0 };
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_solved() {
        let a = vec![vec![4.0, 1.0, 0.5], vec![1.0, 3.0, -1.0], vec![0.5, -1.0, 5.0]];
        let expected = [1.0, -2.0, 0.25];
        let b = a.iter().map(|row| row.iter().zip(expected).map(|(a, x)| a * x).sum()).collect();
        for (found, expected) in solved(a, b).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn positions_read_what_they_wrote() {
        let material = Material { coat: 1.0, ..Material::default() };
        let all = places(&material, ShadingModel::StackLit);
        assert!(all.len() >= 8, "{}", all.len());
        for place in all {
            for x in [0.0, 0.3, 1.0] {
                let mut changed = material.clone();
                place.write(&mut changed, x);
                assert!((place.read(&changed) - x).abs() < 1e-6, "{} {x}", place.parameter.name);
            }
        }
    }

    #[test]
    fn lights_are_above_the_horizon() {
        for measure in measures() {
            if let Light::Direct(degrees) = measure.light {
                assert!(degrees.abs() < 89.0);
            }
        }
        assert!(measures().count() > 30);
    }
}
