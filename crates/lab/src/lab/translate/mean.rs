//! Means of what a goal has no place for, and where descents start.
//!
//! Flakes, orange peel and textures are looked at from so far that a pixel shows all of them: flakes together are a
//! metal whose GGX has the sum of the squares of both alphas (that of each flake, and that of their tilt), peel widens
//! the lobe of the coat by twice the square of its slopes, a texture has its coarsest level, and a map of normals
//! widens the lobes by its variance. So what a fit sees is the mean over view and light, drawn by the renderer's own
//! formulas, and a film's colour at each angle is in it.

use super::Goal;
use super::positions::places;
use overcoat_core::math::double;
use overcoat_scene::parameters::{Kind, PARAMETERS, slots};
use overcoat_scene::{Flakes, Iridescence, Material, Workflow};

/// Scale of the coordinates of textures at which a pixel shows the whole of each.
const FAR: f32 = 1e4;

/// Texels that a look is at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Spot {
    /// All: the coarsest level.
    Mean,
    /// Texels at these texture coordinates, before each texture's own transform.
    At([f32; 2]),
}

/// A material as it looks at a spot, from where neither flakes nor waves of peel are told apart.
pub(super) fn seen_at(material: &Material, spot: Spot) -> Material {
    let mut far = material.clone();
    far.lobes.flakes.size = Flakes::LEAST_SIZE;
    let surface = &mut far.lobes.coat_surface;
    surface.peel_size = Flakes::LEAST_SIZE;
    surface.swirl_size = Flakes::LEAST_SIZE;
    // Scratches fade with the distance.
    surface.scratches = 0.0;
    for (_, slot) in slots() {
        let is_of_normals = matches!(slot.holds, overcoat_scene::parameters::Holds::Normals);
        if let Spot::At(_) = spot
            && is_of_normals
            && slot.get(&far).is_some()
        {
            slot.set(&mut far, None);
        }
        if let Some(texture) = slot.get_mut(&mut far) {
            let rows = texture.transform.rows;
            texture.transform.rows = match spot {
                Spot::Mean => rows.map(|[a, b, c]| [a * FAR, b * FAR, c]),
                Spot::At([u, v]) => rows.map(|[a, b, c]| [0.0, 0.0, a * u + b * v + c]),
            };
        }
    }
    far
}

/// True if the goal has no place for something that decides the colour of the base: flakes, a film, or a texture.
pub(super) fn loses_color(material: &Material, goal: &Goal<'_>) -> bool {
    let film = material.lobes.iridescence.mask.factor > 0.0 && !goal.knows("iridescence");
    let flakes = material.has_flakes() && !goal.knows("flakes");
    let lost_texture = |name: &str, is_there: bool| is_there && !goal.knows(name);
    film || flakes
        || lost_texture("base_color_texture", material.base_color_texture.is_some())
        || lost_texture("metallic_roughness_texture", has_workflow_texture(material))
}

fn has_workflow_texture(material: &Material) -> bool {
    match &material.workflow {
        Workflow::MetallicRoughness { texture, .. } | Workflow::SpecularGlossiness { texture, .. } => {
            texture.is_some()
        }
    }
}

/// The base without coat, whose colour under white light is that of what takes its place.
pub(super) fn bare(material: &Material) -> Material {
    seen_at(material, Spot::Mean).with(|m| m.coat = 0.0)
}

/// Replaces what the goal has no place for by numbers that it has: where descents start, and what they are held near to.
///
/// `albedo` is the reflectance of [`bare`]; without one the base stays as it is.
pub(super) fn replaced(material: &Material, goal: &Goal<'_>, albedo: Option<[f64; 3]>) -> Material {
    let mut plain = material.clone();
    let peel = f64::from(plain.lobes.coat_surface.peel);
    if peel > 0.0 && !goal.knows("coat_peel") {
        let alpha = f64::from(plain.coat_roughness) * f64::from(plain.coat_roughness);
        let wider = (alpha * alpha + 2.0 * peel * peel).sqrt().sqrt();
        plain.coat_roughness = wider.min(1.0) as f32;
    }
    if let Some(albedo) = albedo {
        for (own, found) in plain.base_color.iter_mut().zip(albedo) {
            *own = found.clamp(0.0, 1.0) as f32;
        }
    }
    if plain.has_flakes() && !goal.knows("flakes") {
        let flakes = plain.lobes.flakes;
        let [of_each, spread] = [flakes.roughness, flakes.spread].map(f64::from);
        let squares = [of_each, spread].map(|x| (x * x) * (x * x));
        let roughness = (squares[0] + squares[1]).sqrt().sqrt().min(1.0) as f32;
        let (own, metallic) = match plain.workflow {
            Workflow::MetallicRoughness { metallic, roughness, .. } => (roughness, metallic),
            Workflow::SpecularGlossiness { glossiness, .. } => (1.0 - glossiness, 0.0),
        };
        let share = flakes.share;
        plain.workflow = Workflow::MetallicRoughness {
            metallic: share + (1.0 - share) * metallic,
            roughness: share * roughness + (1.0 - share) * own,
            texture: None,
        };
        if flakes.film_thickness > 0.0 && goal.knows("iridescence") {
            // A film in air has the phase of one in paint: both bend light by the same law from the air above.
            plain.lobes.iridescence = plain.lobes.iridescence.with(|i| {
                i.mask = share.into();
                i.ior = flakes.film_ior;
                i.thickness = [flakes.film_thickness; 2];
            });
        }
    }
    let mut plain = without_unread(&plain, goal);
    for (parameter, slot) in slots() {
        if slot.get(&plain).is_some() && !goal.has(parameter) {
            slot.set(&mut plain, None);
        }
    }
    // Switches of a model that the file does not hold.
    let default = Material::default();
    for parameter in PARAMETERS.iter().filter(|parameter| !(goal.holds)(parameter)) {
        match parameter.kind {
            Kind::Switch(access) => (access.set)(&mut plain, (access.get)(&default)),
            Kind::Name { get, set, .. } => set(&mut plain, get(&default)),
            _ => {}
        }
    }
    plain.model = Some(goal.model);
    plain
}

/// Material with defaults for the parameters that the goal does not have.
pub(super) fn without_unread(material: &Material, goal: &Goal<'_>) -> Material {
    let (mut plain, default) = (material.clone(), Material::default());
    for parameter in PARAMETERS {
        if parameter.width() > 0 && parameter.is_in(material) && !goal.has(parameter) {
            parameter.set_numbers(&mut plain, parameter.numbers(&default));
        }
    }
    // An extinction needs a thickness; a coat without one absorbs nothing.
    let coat = &mut plain.lobes.coat;
    if coat.thickness.factor > 0.0 && coat.thickness.texture.is_none() {
        coat.extinction = coat.extinction.map(|c| c * coat.thickness.factor);
        coat.thickness.factor = 1.0;
    } else if coat.thickness.factor == 0.0
        && goal.knows("coat_extinction")
        && !goal.knows("coat_color")
        && material.lobes.coat.color.factor != [1.0; 3]
    {
        (coat.thickness.factor, coat.extinction) = (1.0, [0.0; 3]);
    }
    plain
}

/// Start points of the descents: the material as it is; with the colour of the coat in the base and in the coat; and
/// from the middle of all.
pub(super) fn starts(material: &Material, same: &Material, goal: &Goal<'_>) -> Vec<Material> {
    let coat = &material.lobes.coat;
    let passes: [f32; 3] = std::array::from_fn(|c| {
        let absorbed = f64::from(coat.extinction[c]) * f64::from(coat.thickness.factor);
        (double::exp(-2.0 * absorbed) as f32) * coat.color.factor[c]
    });
    let mut dyed = same.clone();
    for c in 0..3 {
        let coated = material.coat * passes[c] + (1.0 - material.coat);
        dyed.base_color[c] *= if coated < 1.0 { coated } else { 1.0 };
    }
    dyed.lobes.coat.color.factor = [1.0; 3];
    let mut tinted = same.clone();
    // Colours of a coat go into the coat, for models that have one.
    if goal.knows("coat_color") {
        tinted.lobes.coat.color.factor = passes.map(|c| c.clamp(0.0, 1.0));
    }
    for start in [&mut dyed, &mut tinted] {
        if start.lobes.coat.thickness.factor > 0.0 {
            start.lobes.coat.extinction = [0.0; 3];
        }
    }
    let mut middle = dyed.clone();
    for place in places(&middle, goal) {
        if !place.is_color() && !place.parameter.name.starts_with("iridescence") {
            place.write(&mut middle, 0.5);
        }
    }
    let mut starts = vec![same.clone(), dyed, tinted, middle];
    let flakes = &material.lobes.flakes;
    if same.lobes.iridescence.mask.factor > 0.0 && material.lobes.iridescence.mask.factor == 0.0 {
        // The colour of the replaced base has the film in it.
        let mut filmed = same.clone();
        filmed.base_color[..3].copy_from_slice(&flakes.color);
        starts.push(filmed.clone());
        filmed.lobes.iridescence.mask = 0.5.into();
        starts.push(filmed);
        starts.push(
            same.clone().with(|m| m.lobes = same.lobes.with(|l| l.iridescence = Iridescence::default())),
        );
    }
    starts
}
