//! Scenes of what the engines' models have beyond a coat: grids of spheres over the parameters of one feature, all
//! models in one picture, and area lights.

use super::Entry;
use super::materials::grid;
use crate::common::shapes::{ground, sphere};
use crate::common::stage::{Built, Stage, at, look, metal, plastic};
use overcoat::scene::{
    Anisotropy, CoatMedium, Iridescence, Light, LightKind, Lobes, Material, SceneError, SecondLobe,
    ShadingModel, Sheen, Subsurface,
};

pub const SCENES: &[Entry] = &[
    ("coat-ior-grid", coat_ior_grid),
    ("coat-extinction-grid", coat_extinction_grid),
    ("anisotropy-grid", anisotropy_grid),
    ("iridescence-grid", iridescence_grid),
    ("lobe-haze-grid", lobe_haze_grid),
    ("sheen-grid", sheen_grid),
    ("subsurface-grid", subsurface_grid),
    ("mixed-models", mixed_models),
    ("area-lights", area_lights),
];

/// Index of the coat from 1 to 2.2 to the right, its roughness downwards, over a copper base.
fn coat_ior_grid() -> Built {
    grid(5, 5, |_, x, y| {
        let coat = CoatMedium { ior: 1.0 + 1.2 * x, ..CoatMedium::default() };
        Ok(Material {
            coat: 1.0,
            coat_roughness: y,
            lobes: Lobes { coat, ..Lobes::default() },
            ..metal(0.9, 0.45, 0.25, 0.3)
        })
    })
}

/// Thickness to the right, extinction downwards from none to strong in green and blue (StackLit); the colour of the coat
/// follows it for OpenPBR.
fn coat_extinction_grid() -> Built {
    grid(5, 5, |_, x, y| {
        let coat = CoatMedium {
            thickness: x.into(),
            extinction: [0.2 * y, 1.5 * y, 2.5 * y],
            color: [1.0 - 0.1 * x * y, 1.0 - 0.7 * x * y, 1.0 - 0.9 * x * y].into(),
            ..CoatMedium::default()
        };
        Ok(Material { coat: 1.0, lobes: Lobes { coat, ..Lobes::default() }, ..metal(0.9, 0.88, 0.85, 0.35) })
    })
}

/// Anisotropy from -0.75 to 0.75 to the right, roughness downwards; the last row is turned by 45 degrees. Beyond, highlights
/// of the lamp are thinner than a pixel and show as dots.
fn anisotropy_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let rotation = if y == 1.0 { std::f32::consts::FRAC_PI_4 } else { 0.0 };
        let anisotropy = Anisotropy { strength: 1.5 * x - 0.75, rotation, texture: None };
        Ok(Material {
            coat: if x > 0.9 { 1.0 } else { 0.0 },
            coat_roughness: 0.2,
            lobes: Lobes { anisotropy, ..Lobes::default() },
            ..metal(0.9, 0.75, 0.5, 0.35 + 0.45 * y)
        })
    })
}

/// Thickness of the film from 100 to 900 nm to the right; downwards mask 0.5 and 1 on black plastic, 1 on metal, and 1
/// on metal under a coat.
fn iridescence_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let row = (y * 3.0 + 0.5) as u32;
        let nm = 100.0 + 800.0 * x;
        let iridescence = Iridescence {
            mask: if row == 0 { 0.5 } else { 1.0 }.into(),
            thickness: [nm, nm],
            ..Iridescence::default()
        };
        let base = if row < 2 { plastic(0.02, 0.02, 0.03, 0.2) } else { metal(0.8, 0.8, 0.82, 0.25) };
        Ok(Material {
            coat: if row == 3 { 1.0 } else { 0.0 },
            lobes: Lobes { iridescence, ..Lobes::default() },
            ..base
        })
    })
}

/// Lobe mix (two upper rows, the lower of them with a coat) and haziness (two lower rows, likewise) to the right.
fn lobe_haze_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let row = (y * 3.0 + 0.5) as u32;
        let mut second = SecondLobe { roughness: 0.7.into(), anisotropy: 0.4, ..SecondLobe::default() };
        if row < 2 {
            second.mix = x.into();
        } else {
            second.haziness = x.into();
        }
        Ok(Material {
            coat: if row % 2 == 1 { 1.0 } else { 0.0 },
            lobes: Lobes { second, ..Lobes::default() },
            ..plastic(0.05, 0.07, 0.12, 0.2)
        })
    })
}

/// Roughness of the sheen to the right, its strength downwards.
fn sheen_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let sheen = Sheen { color: [y, 0.8 * y, 0.6 * y].into(), roughness: x.into() };
        Ok(Material { lobes: Lobes { sheen, ..Lobes::default() }, ..plastic(0.3, 0.03, 0.05, 0.7) })
    })
}

/// Thickness to the right; downwards the mask of scattering without and with transmission, before and after the blur,
/// lit from behind as well.
fn subsurface_grid() -> Built {
    let (mut scene, camera) = grid(5, 3, |_, x, y| {
        let subsurface = Subsurface {
            mask: 1.0.into(),
            scattering_distance: [2.0, 0.6, 0.3],
            transmission: if y > 0.0 { [0.9, 0.5, 0.35] } else { [0.0; 3] },
            thickness: (0.1 + 3.0 * x).into(),
            post_scatter: y == 1.0,
            ..Subsurface::default()
        };
        Ok(Material { lobes: Lobes { subsurface, ..Lobes::default() }, ..plastic(0.8, 0.5, 0.4, 0.5) })
    })?;
    let kind = LightKind::Directional { direction: [0.0, 0.0, 1.0] };
    scene.add_light(Light { intensity: 3.0, ..Light::new(kind) })?;
    Ok((scene, camera))
}

/// One ball for each model, of the same paint: models that shade one picture together.
fn mixed_models() -> Built {
    let models = ShadingModel::ALL;
    grid(5, 3, |_, x, y| {
        let index = (y * 2.0 + 0.5) as usize * 5 + (x * 4.0 + 0.5) as usize;
        let lobes = Lobes {
            sheen: Sheen { color: [0.2, 0.2, 0.25].into(), roughness: 0.4.into() },
            coat: CoatMedium { thickness: 0.5.into(), extinction: [0.1, 0.6, 0.6], ..CoatMedium::default() },
            ..Lobes::default()
        };
        Ok(Material {
            model: models.get(index).copied(),
            coat: 1.0,
            coat_roughness: 0.2,
            lobes,
            ..plastic(0.5, 0.05, 0.04, 0.4)
        })
    })
}

/// A white rectangle above, a red tube on the left that crosses the horizon, a blue rectangle seen from its dark back on
/// the right; balls of growing roughness, the last two coated, on a glossy ground.
fn area_lights() -> Built {
    let mut s = Stage::dark()?;
    let (ball, floor) = (s.mesh(sphere(48))?, s.mesh(ground(1))?);
    let glossy = s.material(plastic(0.4, 0.4, 0.42, 0.25))?;
    s.place(floor, glossy, at([0.0; 3], 5.0)?)?;
    for k in 0..5_u8 {
        let part = f32::from(k) / 4.0;
        let made = Material {
            coat: if k > 2 { 1.0 } else { 0.0 },
            coat_roughness: 0.15,
            ..metal(0.9, 0.7, 0.4, 0.1 + 0.6 * part)
        };
        let made = s.material(made)?;
        s.place(ball, made, at([f64::from(k) * 1.2 - 2.4, 0.5, 0.0], 0.5)?)?;
    }
    let mut lamp = |kind, color| -> Result<(), SceneError> {
        s.scene.add_light(Light { color, intensity: 4.0, ..Light::new(kind) })
    };
    lamp(
        LightKind::Rect {
            position: [0.0, 2.5, -0.5],
            half_width: [1.2, 0.0, 0.0],
            half_height: [0.0, 0.0, 0.6],
            two_sided: false,
        },
        [1.0; 3],
    )?;
    lamp(LightKind::Tube { ends: [[-2.5, -0.5, 1.5], [-2.5, 1.8, 1.2]], radius: 0.05 }, [1.0, 0.2, 0.1])?;
    lamp(
        LightKind::Rect {
            position: [3.5, 1.0, 0.0],
            half_width: [0.0, 0.0, 0.5],
            half_height: [0.0, -0.8, 0.0],
            two_sided: false,
        },
        [0.1, 0.2, 1.0],
    )?;
    s.seen(look([0.0, 2.2, 7.0], [0.0, 0.4, 0.0], 32.0))
}
