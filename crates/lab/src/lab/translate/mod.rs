//! Parameters of one model whose pictures are nearest to another's.
//!
//! Both are asked for the radiance of a flat surface from five angles of view under light from one direction, from a soft
//! box and from everywhere ([`Distance`]). What is made small is the sum of squares of differences of lightness: the cube
//! root (CIE 1976 L* is 116 times that, less 16) of x / (1 + x), since light brighter than white is white in pictures.
//! Views count by their cosine, which is the area that a surface seen from there has in pictures. That is done by the
//! method of Levenberg (1944) and Marquardt (1963) with derivatives from differences, from a few starts; the best end
//! counts, and the first of equal ones.
//!
//! *Lacks.* Features that a goal has no place for (flakes, films, orange peel, textures; [`Goal`]) are replaced before the fit by
//! numbers that it has, and the fit is to the mean over it, so that no number of the goal stays as it was because
//! something that it cannot have lay over it.
//!
//! *Textures* that the goal keeps multiply what is found. It is found for three of their texels at once: at the 5th, the
//! 50th and the 95th percentile of the lightness that they give the material.
//!
//! *Numbers that no light shows* are held where they were: a number that moves over its whole range costs as much as a difference of
//! lightness of [`HOLD`] everywhere.

mod fit;
mod mean;
mod measures;
mod positions;
mod solve;

pub use fit::{Fit, Residual};
pub use measures::Distance;

use super::{Bench, LabError, Light, luminance};
use mean::{Spot, bare, loses_color, replaced, seen_at, starts};
use measures::{distance, lightness, measures, residuals, total_weight};
use overcoat_scene::parameters::{PARAMETERS, Parameter, slots};
use overcoat_scene::{Material, ShadingModel, Texture};
use positions::places;
use solve::stepped;

/// Steps of a descent at most.
const STEPS: usize = 60;

/// Difference of lightness that a number costs that is as far as it can be from where it was.
const HOLD: f64 = 1e-3;

/// Texels along each side of the grid of which those are chosen that are looked at.
const GRID: u16 = 12;

/// Angle of view in degrees at which the colour of a base is read.
const MIDDLE_VIEW: f64 = 25.0;

/// Model and file that a material is for.
#[derive(Clone, Copy)]
pub struct Goal<'a> {
    /// Shading model.
    pub model: ShadingModel,
    /// True of parameters that the file has a place for.
    pub holds: &'a dyn Fn(&Parameter) -> bool,
}

impl std::fmt::Debug for Goal<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Goal").field("model", &self.model).finish_non_exhaustive()
    }
}

impl Goal<'static> {
    /// A material file: it has all that the model reads. Flakes, orange peel, scratches and swirl marks are of this project, and no
    /// engine has them: they are in files for its own models, `standard` and `stacklit-d`.
    #[must_use]
    pub fn of_a_file(model: ShadingModel) -> Self {
        let all: &dyn Fn(&Parameter) -> bool = &|_| true;
        let no_paint: &dyn Fn(&Parameter) -> bool = &|parameter| !is_of_paint(parameter.name);
        let is_ours = matches!(model, ShadingModel::Standard | ShadingModel::StackLitD);
        Self { model, holds: if is_ours { all } else { no_paint } }
    }
}

impl Goal<'_> {
    /// True if a parameter of a material for it means something.
    #[must_use]
    pub fn has(&self, parameter: &Parameter) -> bool {
        parameter.models().contains(&self.model) && (self.holds)(parameter)
    }

    /// Names of what a material has and the goal has no place for.
    #[must_use]
    pub fn lacks(&self, material: &Material) -> Vec<&'static str> {
        let held = |name: &str| PARAMETERS.iter().any(|p| p.name == name && (self.holds)(p));
        let coated = material.coat > 0.0;
        let is_absorbing = coated
            && material.lobes.coat.thickness.factor > 0.0
            && material.lobes.coat.extinction != [0.0; 3];
        let is_filmed = material.has_flakes() && material.lobes.flakes.film_thickness > 0.0;
        let textured = slots().any(|(p, slot)| slot.get(material).is_some() && !(self.holds)(p));
        let mut names: Vec<&'static str> = self.model.leaves_out(material).collect();
        for (name, is_there) in [
            ("coat absorption", is_absorbing && !held("coat_extinction")),
            ("flakes", material.has_flakes() && !held("flakes")),
            ("films on flakes", is_filmed && !held("flakes") && !self.knows("iridescence")),
            ("orange peel", material.has_orange_peel() && !held("coat_peel")),
            ("scratches", material.has_scratches() && !held("coat_scratches")),
            ("swirl marks", material.has_swirl() && !held("coat_swirl")),
            ("textures", textured),
        ] {
            if is_there && !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// True if it has the parameter of a name.
    pub(super) fn knows(&self, name: &str) -> bool {
        PARAMETERS.iter().any(|parameter| parameter.name == name && self.has(parameter))
    }
}

/// True of parameters of flakes, orange peel, scratches and swirl marks.
fn is_of_paint(name: &str) -> bool {
    ["flake", "coat_peel", "coat_scratch", "coat_swirl"].iter().any(|start| name.starts_with(start))
}

/// A material for another model.
#[derive(Clone, Debug, PartialEq)]
pub struct Translation {
    /// Material with the model that it is for. Parameters that the goal does not have are at their defaults.
    pub material: Material,
    /// Distance of the original material, shaded by the other model.
    pub before: Distance,
    /// Distance of this material.
    pub after: Distance,
}

/// Finds parameters for another model.
#[derive(Debug)]
pub struct Translator {
    bench: Bench,
}

/// Looks that are to be had.
struct Wanted<'a> {
    goal: &'a Goal<'a>,
    textures: &'a [Texture],
    spots: Vec<Spot>,
    target: Vec<f64>,
}

impl Translator {
    /// For pictures of one pixel each.
    #[must_use]
    pub fn new() -> Self {
        Self { bench: Bench::new(1) }
    }

    /// The parameters for `to` whose pictures come nearest to those of a material by `from`, without its textures. For the
    /// same model they are those of the material.
    ///
    /// # Errors
    /// [`LabError`] if the material is not valid, a model is not built, or the material is black under all light.
    pub fn translate(
        &mut self,
        material: &Material,
        from: ShadingModel,
        to: ShadingModel,
    ) -> Result<Translation, LabError> {
        let found = self.translate_for(&untextured(material), &[], from, &Goal::of_a_file(to))?;
        Ok(Translation { material: with_textures_of(found.material, material), ..found })
    }

    /// Parameters for any goal, of a material that reads these textures.
    ///
    /// # Errors
    /// As [`Translator::translate`], and [`LabError::Dark`] for a material that reflects nothing.
    // For the program: goals are told by the table of parameters, which the library does not show.
    #[doc(hidden)]
    pub fn translate_for(
        &mut self,
        material: &Material,
        textures: &[Texture],
        from: ShadingModel,
        goal: &Goal<'_>,
    ) -> Result<Translation, LabError> {
        let mut same = material.clone();
        same.model = Some(goal.model);
        let spots = self.spots(material, textures, from, goal)?;
        let target = self.look(material, from, textures, &spots)?;
        let before = distance(&target, &self.look(&same, goal.model, textures, &spots)?);
        if from == goal.model && same == without_lacks(&same, goal) {
            return Ok(Translation { material: same, before, after: before });
        }
        if target.iter().all(|lightness| *lightness == 0.0) {
            return Err(LabError::Dark);
        }
        let albedo = if loses_color(material, goal) {
            let bare = bare(material);
            Some(self.bench.textured_radiance(&bare, textures, from, MIDDLE_VIEW, Light::White)?)
        } else {
            None
        };
        let same = replaced(material, goal, albedo);
        let wanted = Wanted { goal, textures, spots, target };
        let mut best = (self.off(&same, &wanted)?, same.clone());
        for start in starts(material, &same, goal) {
            let found = self.descend(start, &same, &wanted)?;
            if found.0 < best.0 {
                best = found;
            }
        }
        let after = distance(&wanted.target, &self.look(&best.1, goal.model, textures, &wanted.spots)?);
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
        let spots = [Spot::Mean];
        let (a, b) = (untextured(a), untextured(b));
        Ok(distance(&self.look(&a, of, &[], &spots)?, &self.look(&b, by, &[], &spots)?))
    }

    /// Spots to look at: three texels where the goal keeps textures, else the mean.
    fn spots(
        &mut self,
        material: &Material,
        textures: &[Texture],
        from: ShadingModel,
        goal: &Goal<'_>,
    ) -> Result<Vec<Spot>, LabError> {
        let keeps = slots().any(|(parameter, slot)| slot.get(material).is_some() && goal.has(parameter));
        if !keeps {
            return Ok(vec![Spot::Mean]);
        }
        let mut seen = Vec::new();
        for k in 0..GRID * GRID {
            let at = [k % GRID, k / GRID].map(|c| (f32::from(c) + 0.5) / f32::from(GRID));
            let spot = Spot::At(at);
            let there = seen_at(material, spot);
            let shown = self.bench.textured_radiance(&there, textures, from, MIDDLE_VIEW, Light::White)?;
            seen.push((luminance(shown), spot));
        }
        // Stable, so that of equal ones the first counts.
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        let last = seen.len() - 1;
        let mut spots: Vec<Spot> = [5, 50, 95].map(|percent| seen[last * percent / 100].1).to_vec();
        if seen[0].0 == seen[last].0 {
            spots.truncate(1);
        }
        Ok(spots)
    }

    /// Lightness, three numbers for each measure, of one spot after the other.
    fn look(
        &mut self,
        material: &Material,
        model: ShadingModel,
        textures: &[Texture],
        spots: &[Spot],
    ) -> Result<Vec<f64>, LabError> {
        let (measures, mut seen) = (measures(), Vec::new());
        for spot in spots {
            let there = seen_at(material, *spot);
            for measure in &measures {
                let shown =
                    self.bench.textured_radiance(&there, textures, model, measure.view, measure.light)?;
                seen.extend(shown.map(lightness));
            }
        }
        Ok(seen)
    }

    /// The differences of a material.
    fn residuals(&mut self, material: &Material, wanted: &Wanted<'_>) -> Result<Vec<f64>, LabError> {
        let seen = self.look(material, wanted.goal.model, wanted.textures, &wanted.spots)?;
        Ok(residuals(&wanted.target, &seen))
    }

    /// The weighted sum of squares that is made small.
    fn off(&mut self, material: &Material, wanted: &Wanted<'_>) -> Result<f64, LabError> {
        Ok(squares(&self.residuals(material, wanted)?))
    }

    /// From a material down to the nearest minimum, held near to another.
    fn descend(
        &mut self,
        start: Material,
        held: &Material,
        wanted: &Wanted<'_>,
    ) -> Result<(f64, Material), LabError> {
        let places = places(&start, wanted.goal);
        let mut x: Vec<f64> = places.iter().map(|place| place.read(&start)).collect();
        let anchor: Vec<f64> = places.iter().map(|place| place.read(held)).collect();
        let hold = HOLD * total_weight(wanted.target.len()).sqrt();
        let mut look = |x: &[f64]| -> Result<Vec<f64>, LabError> {
            let mut material = start.clone();
            places.iter().zip(x).for_each(|(place, x)| place.write(&mut material, *x));
            let mut all = self.residuals(&material, wanted)?;
            all.extend(x.iter().zip(&anchor).map(|(x, anchor)| (x - anchor) * hold));
            Ok(all)
        };
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

fn squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

/// The material without what the goal has no place for.
fn without_lacks(material: &Material, goal: &Goal<'_>) -> Material {
    let mut plain = material.clone();
    let default = Material::default();
    for parameter in PARAMETERS.iter().filter(|parameter| !(goal.holds)(parameter)) {
        if parameter.width() > 0 && parameter.is_in(material) {
            parameter.set_numbers(&mut plain, parameter.numbers(&default));
        }
    }
    for (_, slot) in slots().filter(|(parameter, _)| !(goal.holds)(parameter)) {
        if slot.get(&plain).is_some() {
            slot.set(&mut plain, None);
        }
    }
    plain
}

/// The material without its textures.
#[must_use]
pub fn untextured(material: &Material) -> Material {
    let mut plain = material.clone();
    for (_, slot) in slots() {
        if slot.get(&plain).is_some() {
            slot.set(&mut plain, None);
        }
    }
    plain
}

/// A material with the textures of another one of its workflow.
fn with_textures_of(mut material: Material, other: &Material) -> Material {
    for (parameter, slot) in slots() {
        if let Some(texture) = slot.get(other)
            && parameter.is_in(&material)
        {
            slot.set(&mut material, Some(*texture));
        }
    }
    material
}
