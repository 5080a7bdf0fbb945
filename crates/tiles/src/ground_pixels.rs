//! The floor in the pixels of a tile: behind the surfaces, and before what is behind the picture.

use super::ground::Ground;
use super::ground_lamps::GroundLamps;
use super::ground_light::{GroundLight, share, smooth};
use super::lamps::LightMemory;
use super::mirror::Mirror;
use super::occlusion::asked_for;
use super::options::RenderOptions;
use super::resolve::{Distant, TilePixels};
use overcoat_core::built::Shadows;
use overcoat_core::color::srgb::SRGB8_TO_LINEAR;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask};
use overcoat_scene::Footing;
use overcoat_stages::geometry::View;
use overcoat_stages::light::LUMINANCE;
use overcoat_stages::raster::{SUBPIXELS, TileOrigin};
use overcoat_stages::shade::ViewRays;
use std::f32::consts::FRAC_1_PI;

/// Units of shading (about a nanosecond) for one pixel.
const PIXEL: u64 = 4;

/// The floor as one picture sees it.
#[derive(Clone, Copy, Debug)]
pub struct GroundView<'a> {
    light: &'a GroundLight,
    /// About the middle of the floor, in lengths of its reach.
    rays: ViewRays,
    /// Linear colour of a matt floor; `None` of a shadow.
    color: Option<[f32; 3]>,
    /// Lamps that are not in `light`.
    lamps: Option<GroundLamps<'a>>,
    /// Border of the picture, towards which it fades.
    edge: Option<Edge>,
    /// Mirrored picture of the model, if it reflects one.
    mirror: Option<Mirror<'a>>,
    /// Work of finding its light, in units of shading.
    pub units: u64,
    /// Shadows are compiled in.
    _built: Shadows,
}

/// Fade of the floor near the border of the picture.
///
/// The border is that of a rounded rectangle, (x^4 + y^4)^(1/4) = 1 in halves of the picture's width and height: a straight
/// one shows as a line, however softly the floor fades.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// 1 / half of the picture's width and height in pixels.
    scale: [f32; 2],
    /// 1 / the part of the way to the middle over which it fades.
    slope: f32,
}

impl Edge {
    /// `None` if it does not fade there.
    fn new(view: &View, part: f32) -> Option<Self> {
        let scale = [view.width, view.height].map(|side| 2.0 / side as f32);
        (part > 0.0).then(|| Self { scale, slope: 1.0 / part })
    }

    /// The part that is there, at a place from the middle of the picture in pixels.
    #[inline(always)]
    fn fade<L: Lanes>(&self, _: L, place: [L::F; 2]) -> L::F {
        let [x, y]: [L::F; 2] = each!(k => (place[k] * self.scale[k]).squared().squared());
        let distance = (x + y).sqrt().sqrt();
        smooth((distance.one_minus() * self.slope).saturate())
    }
}

/// Appearance of the floor in sixteen pixels: premultiplied colour and opacity.
struct Seen<L: Lanes> {
    color: [L::F; 3],
    opacity: L::F,
}

impl<L: Lanes> Seen<L> {
    /// With `over` before it.
    #[inline(always)]
    fn under(self, over: Self) -> Self {
        let open = over.opacity.one_minus();
        Self {
            color: each!(c => self.color[c] * open + over.color[c]),
            opacity: (self.opacity.one_minus() * open).one_minus(),
        }
    }
}

impl<'a> GroundView<'a> {
    /// `None` if nothing is seen of it.
    pub fn new(
        light: &'a GroundLight,
        lights: &'a LightMemory,
        options: &RenderOptions,
        view: &View,
        mirror: Option<Mirror<'a>>,
    ) -> Option<Self> {
        let footing = light.footing()?;
        let rays = rays_about(view, footing);
        let is_above = if rays.perspective { rays.eye[1] > 0.0 } else { true };
        let color = match options.ground {
            Ground::None => return None,
            Ground::Shadow => None,
            Ground::Color(color) => Some(each!(c in color => SRGB8_TO_LINEAR[usize::from(c)])),
        };
        let edge = Edge::new(view, options.ground_edge);
        let units = GroundLight::units(&asked_for(options));
        let _built = Shadows::BUILT.filter(|_| is_above)?;
        let lamps = GroundLamps::new(lights, footing, &rays).filter(|_| light.has_lamps_apart());
        Some(Self { light, rays, color, lamps, edge, mirror, units, _built })
    }

    /// Work of a tile of so many pixels, in units of shading.
    pub fn units_of_tile(&self, [width, height]: [u32; 2]) -> u64 {
        let of_pixel = PIXEL + self.lamps.as_ref().map_or(0, GroundLamps::units);
        of_pixel * u64::from(width) * u64::from(height)
    }

    /// Appearance of the floor in sixteen neighbouring pixels of a row; `None` if it is seen in none of them.
    #[inline(always)]
    fn seen<L: Lanes>(&self, l: L, origin: TileOrigin, block: usize, row: usize) -> Option<Seen<L>> {
        const HALF: i32 = SUBPIXELS / 2;
        const PIXELS: f32 = 1.0 / SUBPIXELS as f32;
        let y = (origin.y + row as i32 * SUBPIXELS + HALF) as f32 * PIXELS;
        let x = (l.lane_indices().to_float() + (block * LANES) as f32) + (origin.x + HALF) as f32 * PIXELS;
        let on_screen = [x, l.splat(y)];
        let (from, ray) = self.rays.ray(l, on_screen);
        // From above: downwards, and before the viewer.
        let falls = ray.y.lt(l.zero()) & from.y.gt(l.zero());
        let distance = from.y / falls.select(-ray.y, l.splat(1.0));
        let place = from + ray * distance;
        let square = place.x.squared() + place.z.squared();
        let is_floor = falls & square.lt(l.splat(1.0));
        if !is_floor.any() {
            return None;
        }
        let place = each!(v in [place.x, place.z] => is_floor.select(v, l.zero()));
        let mut there = is_floor.select(GroundLight::fade(l, is_floor.select(square, l.zero())), l.zero());
        if let Some(edge) = &self.edge {
            there = there * edge.fade(l, on_screen);
        }
        let floor = self.lit(l, place, is_floor.select(distance, l.zero()), there);
        let Some(mirror) = &self.mirror else { return Some(floor) };
        let [r, g, b, opacity] = mirror.sixteen(l, origin, block, row);
        Some(floor.under(Seen { color: each!(c in [r, g, b] => c * there), opacity: opacity * there }))
    }

    /// The floor itself at places of which so much is there, as light arrives.
    #[inline(always)]
    fn lit<L: Lanes>(&self, l: L, place: [L::F; 2], distance: L::F, there: L::F) -> Seen<L> {
        let of_lamps = match &self.lamps {
            Some(lamps) => Some(lamps.irradiance(l, place, distance)),
            None => None,
        };
        match (self.color, of_lamps) {
            (None, None) => {
                let [shadow] = self.light.look_up(l, place);
                Seen { color: [l.zero(); 3], opacity: shadow * there }
            }
            (None, Some(of_lamps)) => {
                let known: [L::F; 2] = self.light.look_up(l, place);
                let [arriving, all] = each!(k => {
                    let [r, g, b]: [L::F; 3] = each!(c => of_lamps[k][c] * LUMINANCE[c]);
                    known[k] + ((r + g) + b)
                });
                Seen { color: [l.zero(); 3], opacity: share(l, arriving, all).one_minus() * there }
            }
            (Some(own), of_lamps) => {
                let mut open: [L::F; 3] = self.light.look_up(l, place);
                if let Some([of_lamps, _]) = of_lamps {
                    open = each!(c => open[c] + of_lamps[c] * FRAC_1_PI);
                }
                Seen { color: each!(c => open[c] * there * own[c]), opacity: there }
            }
        }
    }

    /// Puts the floor behind the pixels of a tile, but for those that have it behind them. Tells `see` what is seen of it in each
    /// pixel.
    #[inline(always)]
    pub fn composite<L: Lanes>(
        &self,
        l: L,
        origin: TileOrigin,
        pixels: &mut TilePixels,
        mut see: Option<impl FnMut(usize, f32)>,
    ) {
        let TilePixels { width, linear, transmittance, has_ground } = pixels;
        for (y, row) in linear.chunks_mut(*width).enumerate() {
            for (block, pixels) in row.chunks_mut(LANES).enumerate() {
                if pixels.iter().all(|p| p[3] >= 1.0) {
                    continue;
                }
                let Some(Seen { color, opacity }) = self.seen(l, origin, block, y) else { continue };
                let (color, opacity) = (each!(c in color => c.to_array()), opacity.to_array());
                let first = y * *width + block * LANES;
                for (k, pixel) in pixels.iter_mut().enumerate() {
                    if opacity[k] == 0.0 || has_ground.get(first + k).is_some_and(|has| *has) {
                        continue;
                    }
                    let open = 1.0 - pixel[3];
                    for c in 0..3 {
                        pixel[c] += color[c][k] * open;
                    }
                    pixel[3] += opacity[k] * open;
                    if let Some(see) = &mut see {
                        see(first + k, opacity[k] * open);
                    }
                    if let Some(open) = transmittance.get_mut(first + k) {
                        *open = open.map(|open| open * (1.0 - opacity[k]));
                    }
                }
            }
        }
    }

    /// Puts the floor before what is behind all surfaces.
    #[inline(always)]
    pub fn cover<L: Lanes>(&self, l: L, origin: TileOrigin, width: u32, behind: &mut [Distant]) {
        for (y, row) in behind.chunks_mut(width as usize).enumerate() {
            for (block, pixels) in row.chunks_mut(LANES).enumerate() {
                let Some(Seen { color, opacity }) = self.seen(l, origin, block, y) else { continue };
                let (color, opacity) = (each!(c in color => c.to_array()), opacity.to_array());
                for (k, pixel) in pixels.iter_mut().enumerate() {
                    let keep = 1.0 - opacity[k];
                    pixel.color = each!(c => color[c][k] + pixel.color[c] * keep);
                    pixel.open *= keep;
                }
            }
        }
    }
}

/// The view's rays about the middle of the floor, in lengths of its reach, rounded once.
fn rays_about(view: &View, footing: &Footing) -> ViewRays {
    let [right, up, back] = view.axes;
    let reach = GroundLight::reach(footing);
    let scaled = |axis: [f64; 3], scale: f64| axis.map(|v| (v * scale / reach) as f32);
    ViewRays {
        eye: std::array::from_fn(|k| ((view.eye[k] - footing.center[k]) / reach) as f32),
        right: scaled(right, 1.0 / view.scale[0]),
        down: scaled(up, -1.0 / view.scale[1]),
        centre: scaled(view.through_centre(), 1.0),
        forward: scaled(back, -1.0),
        principal: view.principal.map(|v| v as f32),
        perspective: view.perspective,
    }
}
