//! Numbers of a material that a translation finds.

use super::Goal;
use overcoat_scene::parameters::{Kind, PARAMETERS, Parameter};
use overcoat_scene::{Material, Workflow};

/// Parameters that are found, of those that the model reads and the material has. Others keep their values.
const FOUND: [&str; 19] = [
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
    "coat_darkening",
    "sheen_color",
    "iridescence",
    "iridescence_ior",
    "iridescence_thickness",
    "flake_color",
    "flake_spread",
];

/// Thickest film that is looked for, in nanometres: of thicker ones the eye sees no colour.
const THICKEST_FILM: f32 = 2000.0;

/// One number of a parameter, from 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Position {
    pub(super) parameter: &'static Parameter,
    component: usize,
}

impl Position {
    /// The largest value that is looked for; colours may be brighter in files, and extinctions larger.
    fn most(&self) -> f32 {
        let high = self.parameter.range().high;
        match self.parameter.name {
            "specular_color" => 1.0,
            "iridescence_thickness" => THICKEST_FILM,
            _ if high > 100.0 => 8.0,
            _ => high,
        }
    }

    pub(super) fn read(&self, material: &Material) -> f64 {
        let low = self.parameter.range().low;
        let value = self.parameter.numbers(material)[self.component];
        let share = f64::from(((value - low) / (self.most() - low)).clamp(0.0, 1.0));
        if self.is_color() { share.sqrt() } else { share }
    }

    pub(super) fn write(&self, material: &mut Material, x: f64) {
        let (low, most) = (f64::from(self.parameter.range().low), f64::from(self.most()));
        let share = if self.is_color() { x * x } else { x };
        let mut numbers = self.parameter.numbers(material);
        numbers[self.component] = (low + (most - low) * share) as f32;
        self.parameter.set_numbers(material, numbers);
    }

    /// Dark colours differ more than bright ones.
    pub(super) fn is_color(&self) -> bool {
        matches!(self.parameter.kind, Kind::Color(..) | Kind::ColorAndAlpha(..) | Kind::Triple(..))
    }
}

/// Parameters of a material that the search may change for a goal.
pub(super) fn places(material: &Material, goal: &Goal<'_>) -> Vec<Position> {
    // A feature that a material does not use is not added to make up for something else.
    let metal = matches!(material.workflow, Workflow::MetallicRoughness { metallic: 1.0, .. });
    let has = |parameter: &Parameter| match parameter.name {
        "specular" | "specular_color" => !metal,
        "metallic" => !matches!(material.workflow, Workflow::MetallicRoughness { metallic: 0.0, .. }),
        "sheen_color" => material.lobes.sheen.color.factor != [0.0; 3],
        "coat_extinction" => material.coat > 0.0 && material.lobes.coat.thickness.factor > 0.0,
        name if name.starts_with("iridescence") => material.lobes.iridescence.mask.factor > 0.0,
        name if name.starts_with("flake") => material.has_flakes(),
        name => material.coat > 0.0 || !name.starts_with("coat"),
    };
    let is_free = |parameter: &&Parameter| {
        FOUND.contains(&parameter.name) && parameter.is_in(material) && goal.has(parameter) && has(parameter)
    };
    let of = |parameter: &'static Parameter| {
        let range = match parameter.kind {
            // The first one is for texels of 0.
            Kind::Pair(..) => 1..2,
            // Alpha stays.
            _ => 0..parameter.width().min(3),
        };
        range.map(move |component| Position { parameter, component })
    };
    PARAMETERS.iter().filter(is_free).flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::ShadingModel;

    #[test]
    fn positions_read_what_they_wrote() {
        let material = Material::default().with(|m| m.coat = 1.0);
        let all = places(&material, &Goal::of_a_file(ShadingModel::StackLit));
        assert!(all.len() >= 8, "{}", all.len());
        for place in all {
            for x in [0.0, 0.3, 1.0] {
                let mut changed = material.clone();
                place.write(&mut changed, x);
                assert!((place.read(&changed) - x).abs() < 1e-6, "{} {x}", place.parameter.name);
            }
        }
    }
}
