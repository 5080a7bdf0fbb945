//! Refraction: the effect that looks up the [`Backdrop`] behind refracting surfaces.
//!
//! Source: `getIBLVolumeRefraction`, `getVolumeTransmissionRay` and `applyIorToRoughness` of the Khronos glTF Sample Renderer
//! 1.1, KHR_materials_dispersion. Deviations:
//!
//! - Blur is a share of the picture, that of the original's buffer of 1024 pixels, whatever the picture's size.
//! - Where the blurred picture has nothing opaque, a rough surface shows the environment, by as much as it is rough, and only
//!   the rest of what is behind the picture. The wider the blur, the more of it lies beyond everything opaque: with
//!   nothing in that place the roughest glass is as dark as the page behind the picture (three.js has white there,
//!   half transparent).
//! - How much of what is behind is opaque is asked of a narrower place than its colour ([`OPACITY_ROUGHNESS`]): glass before a
//!   board shows the board's light, not that of the surroundings which the board hides from it.

use super::effects::Effect;
use super::record::{get, get_vector, put};
use super::variation::shaded_roughness;
use super::{Backdrop, ShadeContext};
use crate::gbuffer::layout::{self, SurfacePlanes};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::log2;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;

impl Effect for Backdrop {
    fn is_read(&self, material: &Material) -> bool {
        material.refracts()
    }

    /// Reads position, normal, view, roughness and thickness of the volume; fills the planes of the backdrop.
    #[inline(never)]
    fn fill<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        planes: &mut SurfacePlanes,
    ) {
        l.run(
            #[inline(always)]
            || {
                let [color, opacity] = refracted(l, context, self, material, planes);
                put(planes, layout::BACKDROP_COLOR, color.to_array());
                put(planes, layout::BACKDROP_OPACITY, opacity.at_most(1.0).to_array());
            },
        )
    }
}

/// An index of 1 does not scatter, one of 1.5 and more as the roughness has it (`applyIorToRoughness`).
#[inline(always)]
pub(super) fn refracted_roughness<F: Float>(material: &Material, roughness: F) -> F {
    let share = material.ior * 2.0 - 2.0;
    roughness * if share > 0.0 { if share < 1.0 { share } else { 1.0 } } else { 0.0 }
}

/// Roughness from which the opacity of the backdrop is blurred less than its colour.
const OPACITY_ROUGHNESS: f32 = 0.5;

/// Share of the blur that opacity has beyond [`OPACITY_ROUGHNESS`]. The widest is then a tenth of the picture: the lobe of
/// the roughest glass, about 27 degrees to each side, on a board as far behind it as a tenth of the picture.
const OPACITY_SHARE: f32 = 0.3;

/// Roughness for whose blur the backdrop's opacity is taken. A blur over the whole picture would say how much of the picture
/// is opaque, wherever the surface is.
#[inline(always)]
fn opacity_roughness<F: Float>(roughness: F) -> F {
    let beyond = (roughness - OPACITY_ROUGHNESS).at_least(0.0);
    roughness - beyond * (1.0 - OPACITY_SHARE)
}

/// Light that is seen through the surface (`getIBLVolumeRefraction`): premultiplied colour, and the opacity of red,
/// green and blue.
#[inline(always)]
fn refracted<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    backdrop: &Backdrop,
    material: &Material,
    planes: &SurfacePlanes,
) -> [V3<L>; 2] {
    let position = get_vector(l, planes, layout::POSITION);
    let normal = get_vector(l, planes, layout::NORMAL);
    let view = get_vector(l, planes, layout::VIEW);
    let [roughness, _] = shaded_roughness(l, context, material, planes);
    let [thickness] = get(l, planes, layout::VOLUME_THICKNESS);
    let roughness = refracted_roughness(material, roughness);
    let levels = each!(r in [roughness, opacity_roughness(roughness)] => blur(l, backdrop, r).to_array());
    let scattered = if context.environment.is_dark() { l.zero() } else { roughness };
    let scatters = scattered.gt(l.zero()).any();
    let is_thin = thickness.le(l.zero());
    let transmission = &material.lobes.transmission;
    let ior = if material.ior > 1.0 { material.ior } else { 1.0 };
    // Half of what red and blue lie apart: KHR_materials_dispersion.
    let spread = (ior - 1.0) * 0.025 * transmission.dispersion;
    let n_dot_v = normal.dot(view).saturate();
    let (mut color, mut opacity) = ([l.zero(); 3], [l.zero(); 3]);
    let count = if spread > 0.0 { 3 } else { 1 };
    for k in 0..count {
        let ior = if count == 1 { ior } else { ior + spread * (k as f32 - 1.0) };
        // GLSL's refract; no index is below 1, so there is no total reflection.
        let eta = 1.0 / if ior > 1.0 { ior } else { 1.0 };
        let inside = (n_dot_v.squared().one_minus() * (eta * eta)).one_minus().at_least(0.0).sqrt();
        let along_normal = n_dot_v * eta - inside;
        let inside = normal * along_normal - view * eta;
        let exit = position + inside * thickness;
        let screen = context.rays.project(l, exit);
        let seen = backdrop.sample([screen[0].to_array(), screen[1].to_array()], levels);
        let [r, g, b, mut own_opacity] = each!(k => l.load(&seen[k]));
        let mut own_color = Vec3::new(r, g, b);
        if scatters {
            let direction = Vec3::select(is_thin, -view, inside);
            let share = own_opacity.one_minus().at_least(0.0) * scattered;
            own_color += context.environment.radiance(l, direction, roughness) * share;
            own_opacity = own_opacity + share;
        }
        if count == 1 {
            return [own_color, Vec3::uniform(own_opacity)];
        }
        color[k] = own_color.to_array()[k];
        opacity[k] = own_opacity;
    }
    [Vec3::from_array(color), Vec3::from_array(opacity)]
}

/// The level of the backdrop for a perceptual roughness: as wide a share of the picture as that of a buffer of 1024 pixels
/// (`log2(framebufferSize) * roughness`), but sharp where the surface is smooth.
#[inline(always)]
fn blur<L: Lanes>(l: L, backdrop: &Backdrop, roughness: L::F) -> L::F {
    const LEVELS: f32 = 10.0;
    let larger = log2(l, l.splat(backdrop.side() as f32)) - LEVELS;
    roughness * LEVELS + larger * (roughness * LEVELS).saturate()
}

#[cfg(test)]
mod tests {
    use super::super::Effects;
    use super::*;
    use crate::light::{EnvironmentLight, PrefilteredEnvironment};
    use crate::shade::ViewRays;
    use overcoat_core::math::lanes::{LANES, SimdLevel};
    use overcoat_scene::AreaLightMethod;

    const VIEW: ViewRays = ViewRays {
        eye: [0.0, 0.0, 4.0],
        right: [0.25, 0.0, 0.0],
        down: [0.0, -0.25, 0.0],
        centre: [0.0, 0.0, -1.0],
        forward: [0.0, 0.0, -1.0],
        principal: [0.0; 2],
        perspective: true,
    };

    fn context<'a>(environment: &'a EnvironmentLight<'a>) -> ShadeContext<'a> {
        ShadeContext {
            draws: &[],
            materials: &[],
            textures: &[],
            rays: VIEW,
            environment,
            lights: &[],
            area_lights: &[],
            model: None,
            area_light_method: AreaLightMethod::default(),
            anisotropy: 1,
            maps: 0,
            lamps: None,
            lobe_rays: 0,
            emitter_rays: 0,
            specular_antialiasing: false,
        }
    }

    fn backdrop() -> Backdrop {
        let pixels: Vec<[f32; 4]> = (0..64).map(|k| [k as f32, 2.0, 0.5, 1.0]).collect();
        let mut backdrop = Backdrop::default();
        backdrop.start(8, 8, &pixels);
        while let Some((last, rows)) = backdrop.halve() {
            rows.into_iter().enumerate().for_each(|(y, row)| last.halved_row(y, row));
        }
        backdrop
    }

    /// Rough glass shows the environment where nothing opaque is behind it, the more the rougher it is; smooth glass
    /// and darkness leave what is behind the picture.
    #[test]
    fn rough_glass_shows_the_environment_where_nothing_is_behind() {
        let white = PrefilteredEnvironment::reference([0.5; 3]);
        let dark = PrefilteredEnvironment::black();
        let mut empty = Backdrop::default();
        empty.start(8, 8, &[[0.0; 4]; 64]);
        while let Some((last, rows)) = empty.halve() {
            rows.into_iter().enumerate().for_each(|(y, row)| last.halved_row(y, row));
        }
        let mut glass = Material::default();
        glass.lobes.transmission.factor = 1.0.into();
        let opacity = |environment: &PrefilteredEnvironment, roughness: f32| {
            let light = EnvironmentLight::new(environment, 0.0, 1.0);
            let context = context(&light);
            let mut planes = SurfacePlanes::default();
            planes.rows[layout::ROUGHNESS.first] = [roughness; LANES];
            (planes.rows[layout::NORMAL.first + 2], planes.rows[layout::VIEW.first + 2]) =
                ([1.0; LANES], [1.0; LANES]);
            let effects = Effects { backdrop: Some(&empty), ..Effects::default() };
            overcoat_core::dispatch!(SimdLevel::best(), l => effects.fill(l, &context, &glass, &mut planes));
            let color = planes.rows[layout::BACKDROP_COLOR.first][3];
            let opacity = planes.rows[layout::BACKDROP_OPACITY.first][3];
            assert_eq!(color > 0.0, opacity > 0.0);
            opacity
        };
        assert_eq!([0.0, 0.25, 0.5, 1.0].map(|roughness| opacity(&white, roughness)), [0.0, 0.25, 0.5, 1.0]);
        assert_eq!([0.0, 0.5, 1.0].map(|roughness| opacity(&dark, roughness)), [0.0; 3]);
    }

    /// Glass before the middle of a board shows the board at every roughness, whatever surrounds it and however small it is.
    #[test]
    fn rough_glass_before_a_board_shows_the_board() {
        const SIDE: usize = 128;
        let near = |k: usize| k.abs_diff(SIDE / 2) < SIDE / 5;
        let pixels: Vec<[f32; 4]> = (0..SIDE * SIDE)
            .map(|k| if near(k % SIDE) && near(k / SIDE) { [0.5, 0.5, 0.5, 1.0] } else { [0.0; 4] })
            .collect();
        let mut board = Backdrop::default();
        board.start(SIDE, SIDE, &pixels);
        while let Some((last, rows)) = board.halve() {
            rows.into_iter().enumerate().for_each(|(y, row)| last.halved_row(y, row));
        }
        let mut glass = Material::default();
        glass.lobes.transmission.factor = 1.0.into();
        for surroundings in [0.001, 4.0] {
            let surroundings = PrefilteredEnvironment::reference([surroundings; 3]);
            let light = EnvironmentLight::new(&surroundings, 0.0, 1.0);
            let context = context(&light);
            for step in 0..=20 {
                let mut planes = SurfacePlanes::default();
                planes.rows[layout::ROUGHNESS.first] = [step as f32 * 0.05; LANES];
                (planes.rows[layout::NORMAL.first + 2], planes.rows[layout::VIEW.first + 2]) =
                    ([1.0; LANES], [1.0; LANES]);
                let effects = Effects { backdrop: Some(&board), ..Effects::default() };
                overcoat_core::dispatch!(SimdLevel::best(), l => effects.fill(l, &context, &glass, &mut planes));
                let color = planes.rows[layout::BACKDROP_COLOR.first][3];
                let opacity = planes.rows[layout::BACKDROP_OPACITY.first][3];
                assert!((color - 0.5).abs() < 0.01 && opacity > 0.98, "step {step}: {color} {opacity}");
            }
        }
    }

    /// The planes of its own are filled for materials that refract, and no others are written, at every instruction set alike.
    #[test]
    fn the_backdrop_fills_its_own_planes_and_no_others() {
        let dark = PrefilteredEnvironment::black();
        let light = EnvironmentLight::new(&dark, 0.0, 1.0);
        let context = context(&light);
        let mut glass = Material::default();
        glass.lobes.transmission.factor = 1.0.into();
        glass.lobes.transmission.dispersion = 0.5;
        let mut before = SurfacePlanes::default();
        for (plane, value) in [(layout::NORMAL, 0.0), (layout::VIEW, 0.0), (layout::ROUGHNESS, 0.3)] {
            before.rows[plane.first] = [value; LANES];
        }
        (before.rows[layout::NORMAL.first + 2], before.rows[layout::VIEW.first + 2]) =
            ([1.0; LANES], [1.0; LANES]);
        before.rows[layout::POSITION.first] = std::array::from_fn(|k| k as f32 * 0.1 - 0.8);
        let backdrop = backdrop();
        let effects = Effects { backdrop: Some(&backdrop), ..Effects::default() };
        let fill = |level, effects: Effects<'_>, material: &Material| {
            let mut planes = before.clone();
            overcoat_core::dispatch!(level, l => effects.fill(l, &context, material, &mut planes));
            planes
        };
        let filled = fill(SimdLevel::Scalar, effects, &glass);
        let own = |plane: layout::Plane| filled.plane(plane).to_vec();
        assert!(own(layout::BACKDROP_COLOR).windows(2).all(|rows| rows[0] != rows[1]));
        assert_eq!(own(layout::BACKDROP_OPACITY), [[1.0; LANES]; 3]);
        let others = 0..layout::EFFECTS.start;
        assert_eq!(filled.rows[others.clone()], before.rows[others]);
        for level in SimdLevel::available() {
            assert_eq!(fill(level, effects, &glass).rows, filled.rows, "{level}");
        }
        assert_eq!(fill(SimdLevel::Scalar, Effects::default(), &glass).rows, before.rows);
        assert_eq!(fill(SimdLevel::Scalar, effects, &Material::default()).rows, before.rows);
    }
}
