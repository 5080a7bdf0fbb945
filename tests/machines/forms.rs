//! Meshes of recipes.

use super::dice::Dice;
use super::shapes;
use overcoat::scene::MeshData;
use overcoat_core::math::double;

/// A mesh that has every attribute that its triangles can have.
pub fn random_mesh(dice: &mut Dice) -> MeshData {
    match dice.below(10) {
        0..4 => triangles(dice),
        4 | 5 => shapes::square(1 + dice.below(3) as u32),
        6 | 7 => shapes::sphere(6 + 2 * dice.below(4) as u32),
        8 => shapes::torus(f64::from(dice.between(0.15, 0.6)), 8),
        _ => shapes::cube(),
    }
}

/// Triangles anywhere: small, large, thin, degenerate, sharing corners or not.
fn triangles(dice: &mut Dice) -> MeshData {
    let count = 1 + dice.below(12) as u32;
    let shared = dice.percent(50);
    let vertices = if shared { 3 + count } else { 3 * count };
    let reach = dice.pick(&[0.02, 0.4, 1.0, 1.0, 1.5, 40.0]);
    let mut mesh = MeshData::default();
    for _ in 0..vertices {
        mesh.positions.push(dice.triple(-reach, reach));
        mesh.normals.push(if dice.percent(3) { [0.0; 3] } else { dice.triple(-1.0, 1.0) });
        let [x, y, z] = unit(dice);
        mesh.tangents.push([x, y, z, if dice.percent(50) { 1.0 } else { -1.0 }]);
        mesh.uvs[0].push([dice.between(-1.5, 2.5), dice.between(-1.5, 2.5)]);
    }
    mesh.triangles = (0..count)
        .map(|k| {
            let corner = |j: u32, dice: &mut Dice| {
                if shared { dice.below(vertices as usize) as u32 } else { 3 * k + j }
            };
            std::array::from_fn(|j| corner(j as u32, dice))
        })
        .collect();
    if dice.percent(10) {
        // In one plane with many more, so that depths are equal.
        mesh.positions.iter_mut().for_each(|p| p[2] = 0.25);
    }
    mesh
}

/// A second set of texture coordinates.
pub fn add_second_set(mesh: &mut MeshData, dice: &mut Dice) {
    let turn = dice.between(-1.0, 1.0);
    mesh.uvs[1] = mesh.positions.iter().map(|[x, y, z]| [x * 0.5 + z * turn, y * 0.5 - x * turn]).collect();
}

/// Vertex colours with alpha.
pub fn add_colors(mesh: &mut MeshData, dice: &mut Dice) {
    mesh.colors = mesh
        .positions
        .iter()
        .map(|_| {
            let [r, g, b] = dice.triple(0.0, 1.0);
            [r, g, b, dice.between(0.2, 1.0)]
        })
        .collect();
}

/// A direction.
pub fn unit(dice: &mut Dice) -> [f32; 3] {
    let z = f64::from(dice.between(-1.0, 1.0));
    let (sin, cos) = double::sin_cos(f64::from(dice.between(0.0, 6.25)));
    let r = (1.0 - z * z).max(0.0).sqrt();
    [(r * cos) as f32, (r * sin) as f32, z as f32]
}

/// A turn as a unit quaternion.
pub fn turn(dice: &mut Dice) -> [f64; 4] {
    let [x, y, z] = unit(dice).map(f64::from);
    let (sin, cos) = double::sin_cos(f64::from(dice.between(0.0, 3.125)));
    let q = [x * sin, y * sin, z * sin, cos];
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    q.map(|c| c / length)
}
