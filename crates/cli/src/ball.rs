//! A ball to show materials on.

use super::failure::Failure;
use overcoat_core::frame::{DisplayImage, DisplayOptions};
use overcoat_core::math::double::sin_cos;
use overcoat_description::{Description, ViewDirection};
use overcoat_load::MaterialFile;
use overcoat_render::{Ground, RenderOptions, Renderer};
use overcoat_scene::{Instance, Material, Mesh, MeshData, Scene, SceneError, Transform};
use std::f64::consts::{PI, TAU};

/// Steps around the axis.
const AROUND: u32 = 96;
/// Steps from pole to pole.
const ALONG: u32 = 48;

/// A scene with a ball of radius 1 about the origin. Its texture coordinates run twice around the equator and once
/// from pole to pole, so that texels are square on the equator. Its poles lie on the X axis.
pub(super) fn scene() -> Result<Scene, SceneError> {
    let mut data = MeshData::default();
    for row in 0..=ALONG {
        let (ring, axis) = sin_cos(PI * f64::from(row) / f64::from(ALONG));
        for column in 0..=AROUND {
            // The last column is the first again, with other texture coordinates.
            let (y, z) = sin_cos(TAU * f64::from(column % AROUND) / f64::from(AROUND));
            let point = [-axis as f32, (ring * y) as f32, (ring * z) as f32];
            data.positions.push(point);
            data.normals.push(point);
            data.uvs[0].push([2.0 * column as f32 / AROUND as f32, row as f32 / ALONG as f32]);
        }
    }
    for row in 0..ALONG {
        for column in 0..AROUND {
            let a = row * (AROUND + 1) + column;
            let b = a + AROUND + 1;
            // At the poles one of the two has no area.
            if row > 0 {
                data.triangles.push([a, b, a + 1]);
            }
            if row + 1 < ALONG {
                data.triangles.push([a + 1, b, b + 1]);
            }
        }
    }
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(data)?)?;
    let material = scene.add_material(Material::default().with(|m| m.name = "ball".to_owned()))?;
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
    Ok(scene)
}

/// Scene file of a material ball, for pictures of that size.
pub(super) fn description(size: [u64; 2]) -> Description {
    let mut description = Description { size: Some(size), ..Description::default() };
    // The picture is about the material: the ball stands nowhere.
    description.ground = Some(Ground::None);
    // A little from above, with the poles at the sides.
    description.camera.view = Some(ViewDirection { direction: [0.0, 0.35, 1.0], up: [0.0, 1.0, 0.0] });
    description
}

/// The ball with one material, and the hash of its picture.
pub(super) fn picture(
    description: &Description,
    ball: &mut Scene,
    file: &MaterialFile,
    options: &RenderOptions,
    display: &DisplayOptions,
    renderer: &mut Renderer,
) -> Result<(DisplayImage, String), Failure> {
    file.assign(ball, None, &options.limits).map_err(|e| Failure::assign(&e))?;
    let camera = description.camera(ball, options)?;
    let rendered = renderer.render(ball, &camera, options).map_err(|e| Failure::render(&e))?;
    Ok((DisplayImage::new(&rendered.frame, display), rendered.frame.frame_hash()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_seen_from_outside() {
        let scene = scene().unwrap();
        let mesh = &scene.meshes()[0];
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|v| mesh.positions()[v as usize].map(f64::from));
            let (p, q) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
            let normal = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
            let outwards: f64 = (0..3).map(|k| normal[k] * (a[k] + b[k] + c[k])).sum();
            assert!(outwards > 0.0, "{t:?}");
        }
    }
}
