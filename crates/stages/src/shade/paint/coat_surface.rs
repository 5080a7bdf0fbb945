//! Imperfections of a coat: the waves of orange peel, scratches, and swirl marks.

use super::cells::{Footprint, Hash};
use overcoat_core::math::cos;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::TAU;

/// One of the waves of orange peel.
struct Wave {
    /// Unit vector along which it runs.
    along: [f32; 3],
    /// Waves in the length that the material states.
    number: f32,
    /// Largest slope.
    slope: f32,
    /// Place of the origin in the wave, 0 to 1.
    phase: f32,
}

const fn wave(along: [f32; 3], number: f32, slope: f32, phase: f32) -> Wave {
    Wave { along, number, slope, phase }
}

/// Waves .75 to 2.4 times as long as the material states, the longer ones the steeper: directions of a Fibonacci lattice on half a
/// sphere, slopes whose variance is 1 along each axis.
///
/// A sum of plane waves is band-limited exactly (spectral synthesis; Max 1981, "Vectorized Procedural Models for Natural Terrain: Waves
/// and Islands in the Sunset"), and its slopes are those of a height. Numbers that are interpolated from cell to cell have steep places
/// and flat ones within a cell, at which reflections are torn into islands.
const WAVES: [Wave; 12] = [
    wave([0.285652, 0.0, 0.958333], 0.416667, 0.915159, 0.0),
    wave([-0.356977, -0.32702, 0.875], 0.706972, 0.70257, 0.754878),
    wave([0.053413, 0.608614, 0.791667], 1.199544, 0.539365, 0.509755),
    wave([0.429484, -0.560185, 0.708333], 0.572212, 0.780931, 0.264633),
    wave([-0.768692, 0.135971, 0.625], 0.970891, 0.599523, 0.019511),
    wave([0.709255, 0.45117, 0.541667], 0.463139, 0.868031, 0.774388),
    wave([-0.230731, -0.858309, 0.458333], 0.785824, 0.66639, 0.529266),
    wave([-0.427272, 0.822687, 0.375], 1.333333, 0.511589, 0.284144),
    wave([0.89848, -0.328123, 0.291667], 0.636033, 0.740715, 0.039021),
    wave([-0.904063, -0.373184, 0.208333], 1.079179, 0.568649, 0.793899),
    wave([0.420522, 0.89863, 0.125], 0.514795, 0.82333, 0.548777),
    wave([0.299024, -0.953335, 0.041667], 0.87347, 0.632073, 0.303654),
];

/// Sum of the squares of their slopes.
const SQUARES: f32 = 6.0;

/// Slopes of the waves at sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Waves<L: Lanes> {
    /// Slope in units of its root mean square, in the space of the footprint.
    pub(super) slope: V3<L>,
    /// Share of the variance of slopes that pixels are too large to show, 0 to 1.
    pub(super) lost: L::F,
}

/// Looks at waves of the length of a cell.
#[inline(always)]
pub(super) fn waves<L: Lanes>(l: L, footprint: &Footprint<L>) -> Waves<L> {
    let (mut slope, mut kept) = (Vec3::zero(l), l.zero());
    for wave in &WAVES {
        // A pixel half as long as a wave shows nothing of it.
        let shown = ((footprint.width * (-2.0 * wave.number)) * 1.5 + 1.5).saturate();
        if !shown.gt(l.zero()).any() {
            continue;
        }
        let turns = footprint.place.dot(Vec3::splat(l, wave.along)) * wave.number + wave.phase;
        let angle = (turns - (turns + 0.5).floor()) * TAU;
        slope += Vec3::splat(l, wave.along) * (cos(l, angle) * shown * wave.slope);
        kept = kept + shown * shown * (wave.slope * wave.slope / SQUARES);
    }
    Waves { slope, lost: kept.one_minus().saturate() }
}

/// Scratches at sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Scratches<L: Lanes> {
    /// Share of the footprint that a scratch covers, 0 to 1.
    pub(super) share: L::F,
    /// Slope of the groove's wall that is seen, in the space of the footprint.
    pub(super) slope: V3<L>,
}

/// Scratches in one cell.
const PER_CELL: usize = 3;

/// Slope of the walls of scratches.
const STEEPNESS: f32 = 0.35;

/// Least perceptual roughness of the walls.
pub(super) const WALL_ROUGHNESS: f32 = 0.4;

/// Looks at scratches as long as a cell, which together cover this share of the surface.
///
/// A scratch is where a thin slab at a random angle cuts the surface of its cell. Grooves narrower than the pixel cover a part of
/// it; where pixels are longer than scratches they fade away, since nobody sees them there.
#[inline(always)]
pub(super) fn scratches<L: Lanes>(l: L, share: f32, footprint: &Footprint<L>) -> Scratches<L> {
    let there = footprint.place;
    let floor = overcoat_core::vec3!(x in there => x.floor());
    let cell = [floor.x.to_int(), floor.y.to_int(), floor.z.to_int()];
    let inside = there - floor - Vec3::splat(l, [0.5; 3]);
    // Slabs cover of a cell's cut about what they do of its volume.
    let width = share * (1.0 / PER_CELL as f32);
    let pixel = footprint.width;
    let faded = (pixel.one_minus() * 2.0).saturate();
    let (mut most, mut slope) = (l.zero(), Vec3::zero(l));
    for k in 0..PER_CELL {
        let x = Hash::new(cell, l.splat_i(32 + k as i32));
        let y = x.next();
        let z = y.next();
        let across = Vec3::new(x.deviation(), y.deviation(), z.deviation());
        let across = across * across.dot(across).at_least(1e-6).sqrt().recip();
        let middle = (z.next().uniform() - 0.5) * 0.8;
        let off = inside.dot(across) - middle;
        let reach = (pixel + width) * 0.5;
        let narrow = pixel.at_most(width);
        let covered = ((reach - off.abs()).at_least(0.0).min(narrow) / pixel) * faded;
        let wins = covered.gt(most);
        let side = off.lt(l.zero()).select(l.splat(-STEEPNESS), l.splat(STEEPNESS));
        slope = Vec3::select(wins, across * side, slope);
        most = covered.max(most);
    }
    Scratches { share: most.saturate(), slope }
}

/// Swirl marks at sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Swirls<L: Lanes> {
    /// Share of the footprint that one of them covers, 0 to 1.
    pub(super) line: L::F,
    /// Slope at which its groove is seen, in the space of the footprint.
    pub(super) slope: V3<L>,
    /// Share of the footprint that marks cover of which the pixel is too large to show one.
    pub(super) haze: L::F,
}

/// Arcs looked up at a place, each in a grid of its own.
const ARCS: usize = 6;

/// Slope of grooves: the median is .58 of it. And alpha of the lobe that one slope of a groove has.
const GROOVE: f32 = 0.06;
const ALONG_GROOVE: f32 = 0.02;

/// Growth of the coat's alpha squared in one mark, and in many that a pixel does not tell apart.
pub(super) const LINE_VARIANCE: f32 = ALONG_GROOVE * ALONG_GROOVE;
pub(super) const HAZE_VARIANCE: f32 = GROOVE * GROOVE;

/// Looks at swirl marks as long as a cell, which together cover this share of the surface.
///
/// Washing scratches the coat finely in all directions. A groove has normals that lean across it and none along it, so that it mirrors a light
/// only where it runs at right angles to the direction in which the light's reflection lies: of all grooves those shine that are tangent
/// to circles about the reflection (Merillou, Dischler and Ghazanfarpour 2001, "Surface scratches: measuring, modeling and rendering";
/// Raymond, Guennebaud and Barla 2016, "Multi-Scale Rendering of Scratched Materials using a Structured SV-BRDF Model"). Each arc has one slope of
/// a distribution with a long tail: together they are the fan, and rings grow fainter with their radius.
///
/// An arc is where a thin spherical shell cuts the surface of its cell.
#[inline(always)]
pub(super) fn swirls<L: Lanes>(l: L, share: f32, footprint: &Footprint<L>) -> Swirls<L> {
    let pixel = footprint.width;
    // Single marks are seen while a pixel is shorter than a quarter of one.
    let shown = ((pixel * -1.0 + 0.6) * 3.0).saturate();
    let (mut line, mut slope) = (l.zero(), Vec3::zero(l));
    let width = share * (1.0 / ARCS as f32);
    let narrow = pixel.at_most(width);
    let reach = (pixel + width) * 0.5;
    let share_of_pixel = shown / pixel;
    for k in 0..ARCS {
        let there = footprint.place + Vec3::splat(l, [0.37 * k as f32, 0.61 * k as f32, 0.83 * k as f32]);
        let floor = overcoat_core::vec3!(x in there => x.floor());
        let inside = there - floor - Vec3::splat(l, [0.5; 3]);
        let x = Hash::new(floor.to_array().map(|x| x.to_int()), l.splat_i(64 + k as i32));
        let y = x.next();
        let z = y.next();
        let towards = Vec3::new(x.deviation(), y.deviation(), z.deviation());
        let towards = towards * towards.dot(towards).at_least(1e-6).sqrt().recip();
        let at = z.next();
        let leaning = at.next();
        // The shell's centre lies outside of the cell, and it passes near the cell's middle.
        let radius = leaning.next().uniform() + 0.6;
        let from = inside + towards * (radius + (at.uniform() - 0.5) * 0.7);
        let distance = from.dot(from).at_least(1e-6).sqrt();
        let off = (distance - radius).abs();
        let covered = (reach - off).at_least(0.0).min(narrow) * share_of_pixel;
        let wins = covered.gt(line);
        let u = leaning.uniform() * 2.0 - 1.0;
        let steepness = u * GROOVE * (u * u * -1.0 + 1.02).sqrt().recip();
        slope = Vec3::select(wins, from * (steepness / distance), slope);
        line = covered.max(line);
    }
    Swirls { line: line.saturate(), slope, haze: shown.one_minus() * share }
}
