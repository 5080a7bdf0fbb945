//! Relief of a picture: creases of clay that are told by their tone, and outlines of white models that stand out from a white page.
//!
//! Both are found of planes at the centres of pixels, which a pass without light draws before the picture. Every factor is that of
//! its pixel and of some around it, whatever the tiles are.
//!
//! *Cavity*: the change of the normal across a pixel, in the plane of the picture, is negative in a valley and positive on a ridge:
//! the idea of the "curvature" of Blender's Workbench, whose shader adds the differences of the normals to the right and upwards.
//! Here pairs with a step in depth between them say nothing, which would be outlines and no creases.
//!
//! *Rim*: the share of a neighbourhood that shows nothing, as a photographer's black flags beside white things on white.

use super::centered;
use super::picture::{Memory, Request};
use super::rendered::RenderStats;
use overcoat_core::frame::{Aov, AovPlane, PlaneSample};
use overcoat_core::jobs::Jobs;
use overcoat_scene::{Camera, EnvironmentSource, Instance, Lobes, Material, Scene, Workflow};
use overcoat_tiles::options::{RenderError, RenderOptions};
use overcoat_tiles::relief::Relief;

/// Most that a valley is darkened and that a ridge is lightened by, at strength 1.
const VALLEY: f32 = 0.45;
const RIDGE: f32 = 0.22;

/// Change of the normal at which both have reached their most.
const FULL_TURN: f32 = 0.9;

/// Side of a picture, in pixels, for which normals are compared from one pixel to the next; larger ones compare as many more.
const SIDE_PER_STEP: u32 = 300;
const MOST_STEPS: usize = 8;

/// Half the change of slope, as depth over distance, up to which there is a crease, and from which on there is a step alone.
const CREASE: f32 = 2.0;
const STEP: f32 = 5.0;

/// Part of the outline's light that the rim takes, at strength 1.
const RIM: f32 = 0.4;

/// Radius of the rim's neighbourhood, in parts of the picture's shorter side.
const RIM_RADIUS: f32 = 0.012;

/// Least base colour that is white, linear (sRGB #c0), and the most by which its channels differ.
const WHITE: f32 = 0.527;
const TINT: f32 = 0.08;

/// Factors of a picture, and what finding them took.
pub(super) struct Found {
    pub factors: Relief,
    pub cost: RenderStats,
}

/// Places of the two strengths of a material.
const CAVITY: usize = 0;
const OUTLINE: usize = 1;

/// Strengths by which the surfaces of each material change: of the cavity and of the rim.
struct Strengths {
    of_materials: Vec<[f32; 2]>,
    /// The rim is that of white models, if what is seen is one.
    rim_if_white: bool,
}

impl Strengths {
    /// Strengths that options and materials ask for. `None` if there are none.
    fn of(scene: &Scene, options: &RenderOptions) -> Option<Self> {
        let is_lit = options.visibility.is_on();
        let in_studio =
            matches!(scene.environment().source, EnvironmentSource::Studio) && scene.lights().is_empty();
        let rim_if_white = options.rim.is_none();
        let of = |material: &Material| {
            if material.unlit || material.transmits() {
                return [0.0; 2];
            }
            let when = |condition: bool| if condition { 1.0 } else { 0.0 };
            let cavity = options.cavity.unwrap_or_else(|| when(is_lit && material.has_edges));
            let rim = options.rim.unwrap_or_else(|| when(is_lit && in_studio && is_white(material)));
            [cavity, rim]
        };
        // Nearly all pictures end here, without memory of their own.
        let changes = |instance: &Instance| {
            scene.materials().get(instance.material.index()).is_some_and(|material| of(material) != [0.0; 2])
        };
        if !scene.instances().iter().any(changes) {
            return None;
        }
        let mut of_materials: Vec<[f32; 2]> = scene.materials().iter().map(of).collect();
        if rim_if_white {
            // Colours of vertices multiply those of materials.
            for instance in scene.instances() {
                let is_colored =
                    scene.meshes().get(instance.mesh.index()).is_some_and(|m| !m.colors().is_empty());
                if let (true, Some(own)) = (is_colored, of_materials.get_mut(instance.material.index())) {
                    own[1] = 0.0;
                }
            }
        }
        let used = |number: usize| of_materials.get(number).is_some_and(|own| *own != [0.0; 2]);
        let any = scene.instances().iter().any(|instance| used(instance.material.index()));
        any.then_some(Self { of_materials, rim_if_white })
    }

    /// Strengths at a pixel that shows a material, by its number plus 1.
    fn at(&self, material: u32) -> [f32; 2] {
        let own = (material as usize).checked_sub(1).and_then(|number| self.of_materials.get(number));
        own.copied().unwrap_or_default()
    }

    /// Leaves out the rim of white models unless four fifths of what is seen are white.
    fn judge(&mut self, materials: &[u32]) {
        if !self.rim_if_white {
            return;
        }
        let (mut seen, mut white) = (0_u64, 0_u64);
        for &material in materials.iter().filter(|material| **material != 0) {
            seen += 1;
            white += u64::from(self.at(material)[1] > 0.0);
        }
        if white * 5 < seen * 4 {
            self.of_materials.iter_mut().for_each(|own| own[1] = 0.0);
        }
    }

    /// True if some material asks for one of the two.
    fn any(&self, which: usize) -> bool {
        self.of_materials.iter().any(|own| own.get(which).is_some_and(|strength| *strength > 0.0))
    }

    fn is_nothing(&self) -> bool {
        self.of_materials.iter().all(|own| *own == [0.0; 2])
    }
}

/// True of surfaces that are plain white all over, as far as the material tells: paint and cloth have highlights of their own.
fn is_white(material: &Material) -> bool {
    let [r, g, b, _] = material.base_color;
    let (least, most) = (r.min(g).min(b), r.max(g).max(b));
    let is_dielectric = match material.workflow {
        Workflow::MetallicRoughness { metallic, .. } => metallic < 0.5,
        Workflow::SpecularGlossiness { .. } => false,
    };
    let is_plain = material.coat == 0.0 && material.lobes == Lobes::default();
    let is_even = material.base_color_texture.is_none();
    is_dielectric && is_plain && is_even && least >= WHITE && most - least <= TINT
}

impl Memory {
    /// Finds the factors of a picture, if its options and its scene ask for any. A picture without memory for that has none.
    pub(super) fn find_relief(&mut self, request: &Request<'_>) -> Result<Option<Found>, RenderError> {
        let &Request { jobs, scene, options, only_planes, .. } = request;
        if only_planes {
            return Ok(None);
        }
        let Some(mut strengths) = Strengths::of(scene, options) else { return Ok(None) };
        let mut wanted = vec![Aov::MaterialId, Aov::InstanceId];
        if strengths.any(CAVITY) {
            wanted.extend([Aov::Position, Aov::CameraNormal]);
        }
        let centered = options.clone().with_aov_sample(PlaneSample::Center);
        let own = centered::of_planes(&centered, wanted);
        // The picture reads more of the textures.
        let fed_back = self.textures.fed_back;
        let drawn =
            self.draw_into(&Request { options: &own, display: None, only_planes: true, ..*request }, None);
        self.textures.fed_back = fed_back;
        let drawn = match drawn {
            Ok(drawn) => drawn,
            Err(RenderError::Limit(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        let mut planes = drawn.frame.aovs;
        let cost = drawn.stats;
        let mut take = |aov: Aov| {
            let found = planes.iter().position(|plane| plane.aov == aov);
            found.map_or_else(|| AovPlane::empty(aov, 0), |place| planes.swap_remove(place))
        };
        let surfaces = Surfaces {
            size: [options.width as usize, options.height as usize],
            positions: take(Aov::Position).data,
            normals: take(Aov::CameraNormal).data,
            materials: take(Aov::MaterialId).ids,
            instances: take(Aov::InstanceId).ids,
        };
        strengths.judge(&surfaces.materials);
        if strengths.is_nothing() {
            return Ok(None);
        }
        let factors = surfaces.relief(jobs, request.camera, &strengths)?;
        Ok(Some(Found { factors, cost }))
    }
}

/// Surfaces at the centres of pixels, row by row.
struct Surfaces {
    size: [usize; 2],
    positions: Vec<f32>,
    normals: Vec<f32>,
    materials: Vec<u32>,
    instances: Vec<u32>,
}

impl Surfaces {
    fn relief(mut self, jobs: &Jobs, camera: &Camera, strengths: &Strengths) -> Result<Relief, RenderError> {
        let [width, height] = self.size;
        let axes = camera.axes()?.map(|axis| axis.map(|v| v as f32));
        let side = width.min(height);
        let steps = ((side as u32).div_ceil(SIDE_PER_STEP) as usize).clamp(1, MOST_STEPS);
        let turns = strengths.any(CAVITY).then(|| self.turns(jobs, &axes, steps));
        // Six of eight numbers of a pixel, of which nothing else is found.
        (self.positions, self.normals) = (Vec::new(), Vec::new());
        let rim = strengths.any(OUTLINE).then(|| self.openness(jobs, side));
        let mut pixels = vec![(1.0, 0); width * height];
        jobs.for_each_chunk_mut(&mut pixels, width.max(1), |y, row| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let place = y * width + x;
                let [cavity, outline] = strengths.at(self.materials[place]);
                let mut factor = 1.0;
                if let (Some(turns), true) = (&turns, cavity > 0.0) {
                    factor *= toned(self.smoothed(turns, [x, y]), cavity);
                }
                if let (Some(open), true) = (&rim, outline > 0.0) {
                    // Half of what is around a straight outline is open.
                    let open = (open[place] * 2.0).min(1.0);
                    factor *= (1.0 - RIM * outline * open).max(0.0);
                }
                if cavity > 0.0 || outline > 0.0 {
                    *pixel = (factor, self.instances[place]);
                }
            }
        });
        Ok(Relief::new(width, pixels))
    }

    /// [`Self::turn`] of every pixel.
    fn turns(&self, jobs: &Jobs, axes: &[[f32; 3]; 3], steps: usize) -> Vec<f32> {
        let [width, height] = self.size;
        let mut turns = vec![0.0; width * height];
        jobs.for_each_chunk_mut(&mut turns, width.max(1), |y, row| {
            row.iter_mut().enumerate().for_each(|(x, turn)| *turn = self.turn(axes, [x, y], steps));
        });
        turns
    }

    /// Mean of the turns around a pixel, weighted by a tent, of those that show a surface: centres of pixels make creases jagged.
    fn smoothed(&self, turns: &[f32], [x, y]: [usize; 2]) -> f32 {
        let [width, height] = self.size;
        let (mut sum, mut weights) = (0.0, 0.0);
        for (row, across) in [(y.wrapping_sub(1), 1.0), (y, 2.0), (y + 1, 1.0)] {
            for (column, along) in [(x.wrapping_sub(1), 1.0), (x, 2.0), (x + 1, 1.0)] {
                let place = row.wrapping_mul(width).wrapping_add(column);
                if row < height && column < width && self.instances[place] != 0 {
                    sum += turns[place] * (across * along);
                    weights += across * along;
                }
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }

    /// Change of the normal across a pixel, in the plane of the picture: the mean over pairs of pixels up to `steps` away.
    fn turn(&self, axes: &[[f32; 3]; 3], [x, y]: [usize; 2], steps: usize) -> f32 {
        let [width, height] = self.size;
        // Background, which is most of many pictures, has none.
        if self.instances[y * width + x] == 0 {
            return 0.0;
        }
        let mut sum = 0.0;
        for step in 1..=steps {
            if x >= step && x + step < width {
                let [left, right] = [x - step, x + step].map(|x| y * width + x);
                sum += self.change(axes, 0, [left, y * width + x, right]);
            }
            if y >= step && y + step < height {
                let [above, below] = [y - step, y + step].map(|y| y * width + x);
                sum += self.change(axes, 1, [below, y * width + x, above]);
            }
        }
        sum / steps as f32
    }

    /// Change of a component of the normal from the first to the last of three pixels along that axis; 0 if one shows nothing or
    /// there is a step in depth.
    fn change(&self, axes: &[[f32; 3]; 3], axis: usize, [from, here, to]: [usize; 3]) -> f32 {
        if [from, here, to].iter().any(|place| self.instances[*place] == 0) {
            return 0.0;
        }
        let along = |place: usize, axis: &[f32; 3]| {
            let p = &self.positions[place * 3..][..3];
            p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2]
        };
        let [a, b, c] = [from, here, to].map(|place| along(place, &axes[2]));
        let distance = (along(to, &axes[axis]) - along(from, &axes[axis])).abs();
        let slope = (a + c - 2.0 * b).abs() / distance;
        let change = self.normals[to * 3 + axis] - self.normals[from * 3 + axis];
        // Nothing of a slope that is not a number, too.
        if slope < STEP { change * ((STEP - slope) * (1.0 / (STEP - CREASE))).min(1.0) } else { 0.0 }
    }

    /// Share of the neighbourhood of each pixel that shows nothing: three means over squares, which are nearly a Gaussian (the
    /// central limit theorem). Outside of the picture, its border goes on.
    fn openness(&self, jobs: &Jobs, side: usize) -> Vec<f32> {
        let [width, height] = self.size;
        let radius = ((side as f32 * RIM_RADIUS + 0.5) as usize).max(1);
        let mut open: Vec<f32> =
            self.instances.iter().map(|instance| if *instance == 0 { 1.0 } else { 0.0 }).collect();
        let mut turned = vec![0.0; open.len()];
        for _ in 0..3 {
            for (width, height) in [(width, height), (height, width)] {
                jobs.for_each_chunk_mut(&mut open, width.max(1), |_, row| smooth(row, radius));
                // Columns become rows, and rows again.
                jobs.for_each_chunk_mut(&mut turned, height.max(1), |x, column| {
                    column.iter_mut().enumerate().for_each(|(y, value)| *value = open[y * width + x]);
                });
                std::mem::swap(&mut open, &mut turned);
            }
        }
        open
    }
}

/// Replaces numbers by the means of those up to `radius` away.
fn smooth(row: &mut [f32], radius: usize) {
    let Some(last) = row.len().checked_sub(1) else { return };
    let mut sums = Vec::with_capacity(row.len() + 1);
    let mut sum = 0.0_f64;
    sums.push(sum);
    for value in row.iter() {
        sum += f64::from(*value);
        sums.push(sum);
    }
    let (first_value, last_value) = (f64::from(row[0]), f64::from(row[last]));
    let count = (2 * radius + 1) as f64;
    for (x, value) in row.iter_mut().enumerate() {
        let before = radius.saturating_sub(x) as f64;
        let after = (x + radius).saturating_sub(last) as f64;
        let inside = sums[(x + radius).min(last) + 1] - sums[x.saturating_sub(radius)];
        *value = ((inside + before * first_value + after * last_value) / count) as f32;
    }
}

/// Factor for a change of the normal: below 1 in valleys, above on ridges, up to a limit that is reached without a kink.
fn toned(turn: f32, strength: f32) -> f32 {
    let part = (turn.abs() * (1.0 / FULL_TURN)).min(1.0);
    let part = part * (2.0 - part);
    let change = if turn < 0.0 { -VALLEY } else { RIDGE };
    (1.0 + change * strength * part).max(0.0)
}
