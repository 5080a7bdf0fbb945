//! Parameters of a model for a BRDF that was measured.
//!
//! Views, lights and the distance are those of translations. No material says here which features the surface has, so each
//! [`Form`] is tried, the simple ones first, and one with more features is taken only where that pays ([`Form::pays`]). What is left is
//! told twice: as the distance that was made small, and as errors of radiance at other angles ([`Residual`]).

use super::measures::{distance, lightness, measures};
use super::{Distance, Goal, MIDDLE_VIEW, Spot, Translator, Wanted, squares};
use crate::lab::{LabError, Light, MeasuredBrdf, luminance};
use overcoat_scene::{Material, ShadingModel, Workflow};

/// Views of the residual in degrees, between those of the fit.
const VIEWS: [f64; 6] = [10.0, 20.0, 35.0, 45.0, 60.0, 75.0];

/// Lights of the residual from one direction, in degrees from the mirrored view.
const LIGHTS: [f64; 13] = [-75.0, -50.0, -30.0, -15.0, -7.5, -3.0, -1.5, 1.5, 3.0, 7.5, 15.0, 40.0, 65.0];

/// Material of a model that comes nearest to a measured BRDF.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Material with the model that it is for.
    pub material: Material,
    /// Distance between both, by lightness.
    pub distance: Distance,
    /// Error of directional albedos under white light.
    pub white: Residual,
    /// Error of radiance under light from one direction, in the plane of the view.
    pub direct: Residual,
}

/// Errors of radiance over directions that the fit has not seen. Directions that were not measured are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Root mean square of the differences of all three channels.
    pub rms: f64,
    /// Sum of the differences of luminance without sign over the sum of the measured luminance.
    pub relative: f64,
    /// Pairs of view and light.
    pub directions: usize,
}

/// Features of a surface that a fit may use.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Form {
    coat: bool,
    sheen: bool,
    film: bool,
}

impl Form {
    /// Share of the sum of squares that it has to take away. A film can be made to look like many things that are none.
    fn pays(self) -> f64 {
        if self.film { 0.5 } else { 0.15 }
    }
}

/// Forms that a goal knows, from simple ones to those with more features.
fn forms(goal: &Goal<'_>) -> Vec<Form> {
    let plain = Form { coat: false, sheen: false, film: false };
    let [coat, sheen, film] = ["coat", "sheen_color", "iridescence"].map(|name| goal.knows(name));
    let all = [
        (plain, true),
        (Form { coat: true, ..plain }, coat),
        (Form { sheen: true, ..plain }, sheen),
        (Form { coat: true, film: true, ..plain }, coat && film),
    ];
    all.into_iter().filter(|(_, known)| *known).map(|(form, _)| form).collect()
}

/// Start points of one form: metals, plastics and something between them, smooth and rough; of a form with more features than the
/// nearest so far, that one and fewer others.
fn starts(form: Form, albedo: [f64; 3], goal: &Goal<'_>, nearest: Option<&Material>) -> Vec<Material> {
    let mut found: Vec<Material> = nearest.cloned().into_iter().collect();
    let (metals, roughnesses): (&[f32], &[f32]) = match nearest {
        None => (&[0.0, 0.5, 1.0], &[0.2, 0.5]),
        // Sheen is of cloth, and nothing to make up for a metal with.
        Some(_) if form.sheen => (&[0.0], &[0.5]),
        Some(_) => (&[0.0, 1.0], &[0.4]),
    };
    for &metallic in metals {
        for &roughness in roughnesses {
            let [r, g, b] = albedo.map(|c| c.clamp(0.0, 1.0) as f32);
            found.push(Material::default().with(|m| {
                m.model = Some(goal.model);
                m.base_color = [r, g, b, 1.0];
                m.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
            }));
        }
    }
    for material in &mut found {
        if form.coat && material.coat == 0.0 {
            (material.coat, material.coat_roughness) = (1.0, 0.1);
        }
        if form.sheen {
            material.lobes.sheen.color.factor = [0.2; 3];
        }
        if form.film {
            material.lobes.iridescence.mask.factor = 0.5;
        }
    }
    if form.sheen {
        found
            .retain(|m| matches!(m.workflow, Workflow::MetallicRoughness { metallic, .. } if metallic < 0.5));
    }
    found
}

impl Translator {
    /// The parameters for a model whose pictures come nearest to a measured BRDF, of an anisotropic one to its mean over all
    /// azimuths.
    ///
    /// # Errors
    /// [`LabError::Dark`] for a BRDF that reflects nothing or has nothing measured; [`LabError`] if the model is not built.
    pub fn fit(&mut self, brdf: &MeasuredBrdf, to: ShadingModel) -> Result<Fit, LabError> {
        let goal = &Goal::of_a_file(to);
        let mut target = Vec::new();
        for measure in measures() {
            // Filtered environments blur the edge of a soft box by more than a sharp coat does: between two models that is
            // the same on both sides, against a measurement it would be taken for roughness.
            let seen = if measure.is_edge() { None } else { brdf.radiance(measure.view, measure.light)? };
            // NaN: unknown, and counts for nothing.
            target.extend(seen.map_or([f64::NAN; 3], |color| color.map(lightness)));
        }
        if target.iter().all(|lightness| lightness.is_nan() || *lightness == 0.0) {
            return Err(LabError::Dark);
        }
        let albedo = brdf.radiance(MIDDLE_VIEW, Light::White)?.unwrap_or([0.5; 3]);
        let wanted = Wanted { goal, textures: &[], spots: vec![Spot::Mean], target };
        let mut best: Option<(f64, Material)> = None;
        for form in forms(goal) {
            let bound = best.as_ref().map_or(f64::INFINITY, |(off, _)| off * (1.0 - form.pays()));
            let mut nearest = (bound, None);
            let so_far = best.as_ref().map(|(_, material)| material);
            for start in starts(form, albedo, goal, so_far) {
                let (_, material) = self.descend(start.clone(), &start, &wanted)?;
                // Sums of a descent have the distance from its start in them.
                let off = squares(&self.residuals(&material, &wanted)?);
                if off < nearest.0 {
                    nearest = (off, Some(material));
                }
            }
            if let (off, Some(material)) = nearest {
                best = Some((off, material));
            }
        }
        // Always there: the first form has no bound, and differences of lightness are finite.
        let (_, material) = best.ok_or(LabError::Dark)?;
        let distance = distance(&wanted.target, &self.look(&material, to, &[], &wanted.spots)?);
        let [white, direct] = self.left(brdf, &material, to)?;
        Ok(Fit { material, distance, white, direct })
    }

    /// Errors under white light and under light from one direction.
    fn left(
        &mut self,
        brdf: &MeasuredBrdf,
        material: &Material,
        model: ShadingModel,
    ) -> Result<[Residual; 2], LabError> {
        let mut sums = [Sums::default(), Sums::default()];
        for view in VIEWS {
            let direct = LIGHTS.into_iter().map(|off| view + off).filter(|light| light.abs() < 85.0);
            for light in direct.map(Light::Direct).chain([Light::White]) {
                if let Some(measured) = brdf.radiance(view, light)? {
                    let shown = self.bench.material_radiance(material, model, view, light)?;
                    sums[usize::from(light != Light::White)].add(measured, shown);
                }
            }
        }
        Ok(sums.map(Sums::residual))
    }
}

#[derive(Default)]
struct Sums {
    squares: f64,
    off: f64,
    all: f64,
    count: usize,
}

impl Sums {
    fn add(&mut self, measured: [f64; 3], shown: [f64; 3]) {
        self.squares += (0..3).map(|c| (shown[c] - measured[c]) * (shown[c] - measured[c])).sum::<f64>();
        self.off += (luminance(shown) - luminance(measured)).abs();
        self.all += luminance(measured);
        self.count += 1;
    }

    fn residual(self) -> Residual {
        let share = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        Residual {
            rms: share(self.squares, 3.0 * self.count as f64).sqrt(),
            relative: share(self.off, self.all),
            directions: self.count,
        }
    }
}
