//! Scenes of what the engines' models have beyond a coat: grids of spheres over the parameters of one feature, all
//! models in one picture, and area lights.

use super::Entry;
use super::materials::grid;
use crate::common::shapes::{ground, sphere};
use crate::common::stage::{Built, Stage, at, look, metal, plastic};
use overcoat::scene::{
    Anisotropy, CoatMedium, Iridescence, Light, LightKind, Lobes, SceneError, SecondLobe, ShadingModel,
    Sheen, Subsurface,
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
        let coat = CoatMedium::default().with(|c| c.ior = 1.0 + 1.2 * x);
        Ok(metal(0.9, 0.45, 0.25, 0.3).with(|m| {
            m.coat = 1.0;
            m.coat_roughness = y;
            m.lobes = Lobes::default().with(|l| l.coat = coat);
        }))
    })
}

/// Thickness to the right, extinction downwards from none to strong in green and blue (StackLit); the colour of the coat
/// follows it for OpenPBR.
fn coat_extinction_grid() -> Built {
    grid(5, 5, |_, x, y| {
        let coat = CoatMedium::default().with(|c| {
            c.thickness = x.into();
            c.extinction = [0.2 * y, 1.5 * y, 2.5 * y];
            c.color = [1.0 - 0.1 * x * y, 1.0 - 0.7 * x * y, 1.0 - 0.9 * x * y].into();
        });
        Ok(metal(0.9, 0.88, 0.85, 0.35).with(|m| {
            m.coat = 1.0;
            m.lobes = Lobes::default().with(|l| l.coat = coat);
        }))
    })
}

/// Anisotropy from -0.75 to 0.75 to the right, roughness downwards; the last row is turned by 45 degrees. Beyond, highlights
/// of the lamp are thinner than a pixel and show as dots.
fn anisotropy_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let rotation = if y == 1.0 { std::f32::consts::FRAC_PI_4 } else { 0.0 };
        let anisotropy = Anisotropy::default().with(|a| {
            a.strength = 1.5 * x - 0.75;
            a.rotation = rotation;
            a.texture = None;
        });
        Ok(metal(0.9, 0.75, 0.5, 0.35 + 0.45 * y).with(|m| {
            m.coat = if x > 0.9 { 1.0 } else { 0.0 };
            m.coat_roughness = 0.2;
            m.lobes = Lobes::default().with(|l| l.anisotropy = anisotropy);
        }))
    })
}

/// Thickness of the film from 100 to 900 nm to the right; downwards mask 0.5 and 1 on black plastic, 1 on metal, and 1
/// on metal under a coat.
fn iridescence_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let row = (y * 3.0 + 0.5) as u32;
        let nm = 100.0 + 800.0 * x;
        let iridescence = Iridescence::default().with(|i| {
            i.mask = if row == 0 { 0.5 } else { 1.0 }.into();
            i.thickness = [nm, nm];
        });
        let base = if row < 2 { plastic(0.02, 0.02, 0.03, 0.2) } else { metal(0.8, 0.8, 0.82, 0.25) };
        Ok(base.with(|m| {
            m.coat = if row == 3 { 1.0 } else { 0.0 };
            m.lobes = Lobes::default().with(|l| l.iridescence = iridescence);
        }))
    })
}

/// Lobe mix (two upper rows, the lower of them with a coat) and haziness (two lower rows, likewise) to the right.
fn lobe_haze_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let row = (y * 3.0 + 0.5) as u32;
        let mut second = SecondLobe::default().with(|s| {
            s.roughness = 0.7.into();
            s.anisotropy = 0.4;
        });
        if row < 2 {
            second.mix = x.into();
        } else {
            second.haziness = x.into();
        }
        Ok(plastic(0.05, 0.07, 0.12, 0.2).with(|m| {
            m.coat = if row % 2 == 1 { 1.0 } else { 0.0 };
            m.lobes = Lobes::default().with(|l| l.second = second);
        }))
    })
}

/// Roughness of the sheen to the right, its strength downwards.
fn sheen_grid() -> Built {
    grid(5, 4, |_, x, y| {
        let sheen = Sheen::default().with(|s| {
            s.color = [y, 0.8 * y, 0.6 * y].into();
            s.roughness = x.into();
        });
        Ok(plastic(0.3, 0.03, 0.05, 0.7).with(|m| m.lobes = Lobes::default().with(|l| l.sheen = sheen)))
    })
}

/// Thickness to the right; downwards the mask of scattering without and with transmission, before and after the blur,
/// lit from behind as well.
fn subsurface_grid() -> Built {
    let (mut scene, camera) = grid(5, 3, |_, x, y| {
        let subsurface = Subsurface::default().with(|s| {
            s.mask = 1.0.into();
            s.scattering_distance = [2.0, 0.6, 0.3];
            s.transmission = if y > 0.0 { [0.9, 0.5, 0.35] } else { [0.0; 3] };
            s.thickness = (0.1 + 3.0 * x).into();
            s.post_scatter = y == 1.0;
        });
        Ok(plastic(0.8, 0.5, 0.4, 0.5)
            .with(|m| m.lobes = Lobes::default().with(|l| l.subsurface = subsurface)))
    })?;
    let kind = LightKind::Directional { direction: [0.0, 0.0, 1.0] };
    scene.add_light(Light::new(kind).with(|l| l.intensity = 3.0))?;
    Ok((scene, camera))
}

/// One ball for each model, of the same paint: models that shade one picture together.
fn mixed_models() -> Built {
    let models = ShadingModel::ALL;
    grid(5, 3, |_, x, y| {
        let index = (y * 2.0 + 0.5) as usize * 5 + (x * 4.0 + 0.5) as usize;
        let lobes = Lobes::default().with(|l| {
            l.sheen = Sheen::default().with(|s| {
                s.color = [0.2, 0.2, 0.25].into();
                s.roughness = 0.4.into();
            });
            l.coat = CoatMedium::default().with(|c| {
                c.thickness = 0.5.into();
                c.extinction = [0.1, 0.6, 0.6];
            });
        });
        Ok(plastic(0.5, 0.05, 0.04, 0.4).with(|m| {
            m.model = models.get(index).copied();
            m.coat = 1.0;
            m.coat_roughness = 0.2;
            m.lobes = lobes;
        }))
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
        let made = metal(0.9, 0.7, 0.4, 0.1 + 0.6 * part).with(|m| {
            m.coat = if k > 2 { 1.0 } else { 0.0 };
            m.coat_roughness = 0.15;
        });
        let made = s.material(made)?;
        s.place(ball, made, at([f64::from(k) * 1.2 - 2.4, 0.5, 0.0], 0.5)?)?;
    }
    let mut lamp = |kind, color| -> Result<(), SceneError> {
        s.scene.add_light(Light::new(kind).with(|l| {
            l.color = color;
            l.intensity = 4.0;
        }))
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
