//! The lights of a picture, and depth maps of what is in their way: kept for as long as neither changes, whatever the camera.

use super::occlusion::OcclusionMemory;
use super::options::RenderOptions;
use super::reach::Reach;
use super::timed_pool::TimedPool;
use overcoat_core::built::{AreaLights, Shadows};
use overcoat_core::each;
use overcoat_core::limits::LimitExceeded;
use overcoat_scene::{Light, LightKind, Scene};
use overcoat_stages::geometry::View;
use overcoat_stages::light::{AreaLight, AreaShape, PunctualLight};
use overcoat_stages::shade::{LampOcclusion, LampPart};
use overcoat_stages::shadow::{LampMaps, LampPlace, LampSource, LampTints};

/// The lights of a picture.
#[derive(Debug, Default)]
pub struct LightMemory {
    /// Lights without extent.
    pub punctual: Vec<PunctualLight>,
    /// Rectangles and tubes.
    pub areas: Vec<AreaLight>,
    /// Reach on the picture of the lights without extent.
    pub reach: Reach,
    shadows: LampShadows,
    /// Number of times that the lights or their occluders have changed.
    changes: u64,
}

/// Shadows of lights.
#[derive(Debug, Default)]
struct LampShadows {
    /// Without the sizes of their maps.
    sources: Vec<LampSource>,
    parts: Vec<LampPart>,
    /// Sources and parts of the picture that is begun, until they are known to be others.
    asked: (Vec<LampSource>, Vec<LampPart>),
    /// Version of the occluders that the maps were made of, and the size of the environment's maps, which theirs
    /// follow.
    made_of: (u64, usize),
    maps: LampMaps,
    tints: LampTints,
    /// Lights without maps, since these would pass a limit.
    left_out: usize,
    /// Surfaces are shaded with them.
    is_on: bool,
}

/// The tangent of half the angle that the sun is seen under (its radius over its distance): light from afar is taken to come from
/// such a disc, since files do not say.
const SUN: f32 = 0.004_65;

/// Maps of lamps have this many times as many texels along a side as those of the environment: they throw sharp shadows.
const FINER: usize = 8;

/// The same of parts of lamps with an extent, whose shadows are soft: large maps would show the few places that are looked up.
const FINER_OF_PARTS: usize = 2;

/// Most texels along their sides.
const LARGEST: usize = 2048;

/// Texels of all of them, for each along a side of those of the environment.
const TEXELS: usize = 1 << 15;

/// Parts of a lamp: as many as begun sixty-fourths of a side of the environment's maps, squared; and at most.
const PART: usize = 64;
const MOST_PARTS: usize = 16;

impl LightMemory {
    /// Takes over the lights of a scene.
    pub fn list(&mut self, scene: &Scene, view: &View) {
        let lights = || scene.lights().iter().filter_map(PunctualLight::new);
        let punctual = || lights().enumerate().map(|(k, light)| light.with_number(k as u32));
        let areas = || scene.lights().iter().filter(|_| AreaLights::IS_BUILT).filter_map(AreaLight::new);
        if !(punctual().eq(self.punctual.iter().copied()) && areas().eq(self.areas.iter().copied())) {
            self.changes += 1;
            self.punctual.clear();
            self.punctual.extend(punctual());
            self.areas.clear();
            self.areas.extend(areas());
        }
        self.reach.find(&self.punctual, view);
    }

    /// Finds what is in the way of the lights of a scene, unless it is known.
    pub fn find_shadows(
        &mut self,
        pool: &TimedPool<'_>,
        scene: &Scene,
        occlusion: &OcclusionMemory,
        options: &RenderOptions,
    ) -> Result<(), LimitExceeded> {
        let shadows = &mut self.shadows;
        shadows.is_on = options.visibility.is_on();
        if !Shadows::IS_BUILT {
            return Ok(());
        }
        let Some((blockers, tinted, made)) = occlusion.occluders(options) else { return Ok(()) };
        let map_size = super::occlusion::asked_for(options).map_size as usize;
        let (mut sources, mut parts) = std::mem::take(&mut shadows.asked);
        list_sources(scene.lights(), &self.areas, parts_of_lamp(map_size), (&mut sources, &mut parts));
        if shadows.made_of == (made, map_size) && shadows.sources == sources {
            shadows.asked = (sources, parts);
            return Ok(());
        }
        self.changes += 1;
        shadows.made_of = (0, 0);
        let (limits, jobs, simd) = (&options.limits, pool.jobs, options.simd);
        let counts = LampMaps::counts(blockers, &sources, jobs);
        let middle = scene.bounds().center();
        let light = scene.lights().iter().filter(|light| source(&light.kind).is_some());
        let light: Vec<f64> = light.map(|light| light_at(light, middle)).collect();
        let most = LampMaps::most(limits, blockers);
        let draw = |most: u64| {
            let mut kept = counts.clone();
            let left_out = leave_out(&mut kept, &light, most);
            let sized = sized(&sources, self.punctual.len(), map_size, [&counts, &kept]);
            Ok((left_out, LampMaps::within(limits, blockers, &sized, jobs, simd)?, sized))
        };
        // Large triangles take more than one look each: then fewer lamps have maps.
        let drawn = draw(most).or_else(|limit: LimitExceeded| match limit.field {
            "blocks" => draw(most / 8),
            _ => Err(limit),
        });
        let (left_out, maps, sized) = drawn?;
        shadows.tints = LampTints::within(limits, tinted, &sized, jobs, simd)?;
        (shadows.maps, shadows.left_out) = (maps, left_out);
        (shadows.sources, shadows.parts) = (sources, parts);
        shadows.made_of = (made, map_size);
        Ok(())
    }

    /// Occlusion of lights, if surfaces are shaded with it.
    pub fn shadows(&self) -> Option<LampOcclusion<'_>> {
        self.shadows_of_ground().filter(|_| self.shadows.is_on)
    }

    /// Sixteens of triangles and texels that drawing the maps has looked at.
    pub fn work(&self) -> u64 {
        self.shadows.maps.work()
    }

    /// Number of lights whose shadows are left out to stay within a limit.
    pub fn without_shadow(&self) -> usize {
        if self.shadows_of_ground().is_some() { self.shadows.left_out } else { 0 }
    }

    /// Number of times that the lights or their occluders have changed until now.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// The same for a floor, whether surfaces are shaded with it or not.
    pub fn shadows_of_ground(&self) -> Option<LampOcclusion<'_>> {
        let LampShadows { parts, maps, tints, .. } = &self.shadows;
        let built = Shadows::BUILT.filter(|_| !(maps.is_empty() && tints.is_empty()))?;
        Some(LampOcclusion { maps, tints, punctual: self.punctual.len(), parts, built })
    }
}

/// Light that a lamp without extent sends to a place, about: the largest of red, green and blue.
fn light_at(light: &Light, place: [f64; 3]) -> f64 {
    let largest = light.color.iter().fold(0.0, |most, c| if *c > most { *c } else { most });
    let power = f64::from(light.intensity * largest);
    match &light.kind {
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
            let to: [f64; 3] = each!(k => f64::from(position[k]) - place[k]);
            let square = (to[0] * to[0] + to[1] * to[1]) + to[2] * to[2];
            power / if square > 1e-6 { square } else { 1e-6 }
        }
        _ => power,
    }
}

/// Lamps with the sizes of their maps: those without extent, so many, come first. Of the numbers of maps that each has, the first
/// are those before some were left out.
fn sized(sources: &[LampSource], punctual: usize, map_size: usize, counts: [&[usize]; 2]) -> Vec<LampSource> {
    let [all, kept] = counts;
    let mut sized = sources.to_vec();
    let middle = punctual.min(kept.len());
    for (range, finer) in [(0..middle, FINER), (middle..kept.len(), FINER_OF_PARTS)] {
        let size = side(finer * map_size, map_size, kept[range.clone()].iter().sum());
        for number in range {
            let is_left_out = all[number] > 0 && kept[number] == 0;
            sized[number].size = if is_left_out { 0 } else { size };
        }
    }
    sized
}

/// Takes their maps from lamps where all would be more than `most`, until they are not: first from those of which least light
/// arrives. Returns the number of these lamps; parts of lamps with an extent, which come after those in `light`, keep theirs.
fn leave_out(counts: &mut [usize], light: &[f64], most: u64) -> usize {
    let mut all: u64 = counts.iter().map(|count| *count as u64).sum();
    let mut faintest: Vec<usize> = (0..light.len().min(counts.len())).collect();
    // Equally bright ones: the last goes first.
    faintest.sort_by(|a, b| light[*a].total_cmp(&light[*b]).then(b.cmp(a)));
    let mut left_out = 0;
    for lamp in faintest {
        if all <= most {
            break;
        }
        all -= counts[lamp] as u64;
        left_out += usize::from(counts[lamp] > 0);
        counts[lamp] = 0;
    }
    left_out
}

/// Texels along a side of each of so many maps, of so many that are wanted.
fn side(wanted: usize, map_size: usize, maps: usize) -> usize {
    let most = TEXELS * map_size / maps.max(1);
    let mut side = wanted.min(LARGEST);
    while side > 32 && side * side > most {
        side /= 2;
    }
    side
}

/// Parts that a lamp with an extent is taken in.
fn parts_of_lamp(map_size: usize) -> usize {
    map_size.div_ceil(PART).pow(2).clamp(1, MOST_PARTS)
}

/// Lists the sources of shadows: all lights without extent, then the parts of those with one.
fn list_sources(
    lights: &[Light],
    areas: &[AreaLight],
    count: usize,
    (sources, parts): (&mut Vec<LampSource>, &mut Vec<LampPart>),
) {
    sources.clear();
    sources.extend(lights.iter().filter_map(|light| source(&light.kind)));
    parts.clear();
    for (number, area) in areas.iter().enumerate() {
        let first = parts.len();
        let (radius, cone) = add_parts(number as u32, &area.shape, count, parts);
        sources.extend(parts[first..].iter().map(|part| {
            let place = LampPlace::Near { position: part.position, cone };
            LampSource { place, radius, size: 0, places: 8 }
        }));
    }
}

/// A light without extent, as it throws shadows.
fn source(light: &LightKind) -> Option<LampSource> {
    Some(match *light {
        LightKind::Directional { direction } => LampSource {
            place: LampPlace::Distant(each!(c in direction => -c)),
            radius: SUN,
            size: 0,
            places: 16,
        },
        LightKind::Point { position, .. } => {
            LampSource { place: LampPlace::Near { position, cone: None }, radius: 0.0, size: 0, places: 16 }
        }
        LightKind::Spot { position, direction, outer_cone_cosine, .. } => {
            let cone = Some((direction, outer_cone_cosine));
            LampSource { place: LampPlace::Near { position, cone }, radius: 0.0, size: 0, places: 16 }
        }
        LightKind::Rect { .. } | LightKind::Tube { .. } => return None,
    })
}

/// The cone that a lamp shines in: its axis and the cosine of half its angle.
type Cone = Option<([f32; 3], f32)>;

/// Cuts a rectangle or a tube into about as many parts as asked for, about as long as wide. Returns the radius of a disc of the
/// size of one.
fn add_parts(light: u32, shape: &AreaShape, count: usize, parts: &mut Vec<LampPart>) -> (f32, Cone) {
    let length = |v: [f32; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    match *shape {
        AreaShape::Rect { corners: [a, b, c, _], .. } => {
            let (up, left): ([f32; 3], [f32; 3]) = (each!(k => b[k] - a[k]), each!(k => c[k] - b[k]));
            let (height, width) = (length(up), length(left));
            let columns = ((count as f32 * width / height).sqrt() + 0.5) as usize;
            let columns = columns.clamp(1, count);
            let rows = (count / columns).max(1);
            let area = width * height / (columns * rows) as f32;
            for k in 0..columns * rows {
                let x = ((k % columns) as f32 + 0.5) / columns as f32;
                let y = ((k / columns) as f32 + 0.5) / rows as f32;
                let position = each!(c => a[c] + up[c] * y + left[c] * x);
                parts.push(LampPart { light, position, area });
            }
            ((area * std::f32::consts::FRAC_1_PI).sqrt(), None)
        }
        AreaShape::Tube { ends: [a, b], radius } => {
            // In one row: so many would be longer than those of a rectangle.
            let count = (2 * count).min(MOST_PARTS);
            let axis: [f32; 3] = each!(k => b[k] - a[k]);
            let part = length(axis) / count as f32;
            for k in 0..count {
                let x = (k as f32 + 0.5) / count as f32;
                let position = each!(c => a[c] + axis[c] * x);
                parts.push(LampPart { light, position, area: 2.0 * radius * part });
            }
            let half = 0.5 * part;
            (if half > radius { half } else { radius }, None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(kind: LightKind) -> AreaLight {
        AreaLight::new(&Light::new(kind)).unwrap()
    }

    #[test]
    fn parts_make_up_the_whole() {
        let rect = |x: f32, y: f32| {
            let (half_width, half_height) = ([x, 0.0, 0.0], [0.0, y, 0.0]);
            area(LightKind::Rect { position: [1.0, 2.0, 3.0], half_width, half_height, two_sided: false })
        };
        let tube = area(LightKind::Tube { ends: [[0.0, 2.0, 3.0], [2.0, 2.0, 3.0]], radius: 0.1 });
        for (light, whole) in
            [(rect(1.0, 1.0), 4.0), (rect(5.0, 0.1), 2.0), (rect(0.1, 5.0), 2.0), (tube, 0.4)]
        {
            for count in [1, 4, 16] {
                let mut parts = Vec::new();
                list_sources(&[], &[light], count, (&mut Vec::new(), &mut parts));
                assert!(!parts.is_empty() && parts.len() <= 2 * count);
                let sum: f32 = parts.iter().map(|part| part.area).sum();
                assert!((sum / whole - 1.0).abs() < 1e-5, "{sum} of {whole}");
                for (k, middle) in [1.0, 2.0, 3.0].into_iter().enumerate() {
                    let mean: f32 =
                        parts.iter().map(|part| part.position[k]).sum::<f32>() / parts.len() as f32;
                    assert!((mean - middle).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn the_faintest_lamps_lose_their_shadows() {
        let light = [3.0, 1.0, 5.0, 1.0];
        for (most, expected, left_out) in [
            (22, [6, 6, 1, 6, 3], 0),
            (21, [6, 6, 1, 0, 3], 1),
            (15, [6, 0, 1, 0, 3], 2),
            (4, [0, 0, 1, 0, 3], 3),
            (0, [0, 0, 0, 0, 3], 4),
        ] {
            let mut counts = [6, 6, 1, 6, 3];
            assert_eq!((leave_out(&mut counts, &light, most), counts), (left_out, expected), "{most}");
        }
        let near = Light::new(LightKind::Point { position: [0.0, 2.0, 0.0], range: None })
            .with(|l| l.intensity = 4.0);
        assert_eq!(light_at(&near, [0.0; 3]), 1.0);
        assert_eq!(light_at(&Light::directional([0.0, -1.0, 0.0], 3.0), [0.0; 3]), 3.0);
    }

    #[test]
    fn more_lamps_have_smaller_maps() {
        assert_eq!([1, 4, 6, 256 * 6].map(|maps| side(1024, 128, maps)), [1024, 1024, 512, 32]);
        assert_eq!([1, 6].map(|maps| side(4096, 512, maps)), [2048, 1024]);
        assert_eq!([32, 128, 256, 512].map(parts_of_lamp), [1, 4, 16, 16]);
    }
}
