//! Deformers at rest: shapes by the weights that the file has, and skins in the pose in which its models stand.

use super::document::{Document, Kind, Object};
use super::geometry::Geometry;
use super::record::{FORMAT, Record};
use super::transform::matrix;
use crate::LoadError;
use crate::budget::Budget;
use overcoat_scene::Transform;

/// Moves the vertices of a mesh by the shapes of an object, as far as their weights say.
pub(super) fn shapes(
    document: &Document<'_>,
    number: usize,
    geometry: &mut Geometry,
    budget: &mut Budget,
) -> Result<(), LoadError> {
    let mut deltas = Deltas::default();
    for (blend, _) in
        document.linked(number, Kind::Deformer).filter(|(_, object)| object.class == b"BlendShape")
    {
        for (channel, object) in document.linked(blend, Kind::Deformer) {
            let percent = percent_of(object);
            if percent == 0.0 {
                continue;
            }
            let shapes: Vec<&Object<'_>> =
                document.linked(channel, Kind::Geometry).map(|(_, shape)| shape).collect();
            let full: Vec<f64> = object.record.list("FullWeights", budget)?;
            let mut before = 0.0;
            for (k, shape) in shapes.iter().enumerate() {
                let at = full.get(k).copied().filter(|_| shapes.len() > 1).unwrap_or(100.0);
                let next =
                    full.get(k.saturating_add(1)).copied().filter(|_| k.saturating_add(1) < shapes.len());
                let weight = between(percent, before, at, next);
                deltas.add(shape.record, weight, geometry.points, budget)?;
                before = at;
            }
        }
    }
    // Before version 7 shapes are in the record of the model, and their weights are properties of it.
    if let Some(object) = document.objects.get(number) {
        for shape in object.record.children("Shape") {
            let name = String::from_utf8_lossy(shape.text(0).unwrap_or_default());
            let weight = object.properties.number(&name).unwrap_or(0.0) / 100.0;
            deltas.add(shape, weight, geometry.points, budget)?;
        }
    }
    deltas.apply(geometry);
    Ok(())
}

fn percent_of(channel: &Object<'_>) -> f64 {
    let own = channel.record.child("DeformPercent").and_then(|record| record.float(0));
    channel.properties.number("DeformPercent").or(own).unwrap_or(0.0)
}

/// Weight of a shape that is whole at `at`, nothing at the shape before, and nothing at the next.
fn between(percent: f64, before: f64, at: f64, next: Option<f64>) -> f64 {
    match next {
        Some(next) if percent > at && next > at => {
            let left = (next - percent) / (next - at);
            if left > 0.0 { left } else { 0.0 }
        }
        _ if at == before => 0.0,
        _ => {
            let part = (percent - before) / (at - before);
            if before != 0.0 && part < 0.0 { 0.0 } else { part }
        }
    }
}

/// Ways of control points and changes of their normals; empty without.
#[derive(Default)]
struct Deltas {
    points: Vec<[[f64; 3]; 2]>,
}

impl Deltas {
    fn add(
        &mut self,
        shape: &Record<'_>,
        weight: f64,
        points: usize,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        if weight == 0.0 || !weight.is_finite() {
            return Ok(());
        }
        let indices: Vec<i32> = shape.list("Indexes", budget)?;
        let ways: Vec<f64> = shape.list("Vertices", budget)?;
        let normals: Vec<f64> = shape.list("Normals", budget)?;
        if self.points.is_empty() {
            budget.charge(|| format!("{FORMAT}: a shape"), points as u64, 48)?;
            self.points = vec![[[0.0; 3]; 2]; points];
        }
        let mut normals = normals.as_chunks::<3>().0.iter();
        for (index, way) in indices.iter().zip(ways.as_chunks::<3>().0) {
            let normal = normals.next().copied().unwrap_or_default();
            let point = usize::try_from(*index).ok().and_then(|index| self.points.get_mut(index));
            let Some([sum, turned]) = point else { continue };
            sum.iter_mut().zip(way).for_each(|(sum, v)| *sum += weight * v);
            turned.iter_mut().zip(normal).for_each(|(sum, v)| *sum += weight * v);
        }
        Ok(())
    }

    fn apply(&self, geometry: &mut Geometry) {
        let data = &mut geometry.data;
        let of = |source: &u32| self.points.get(*source as usize);
        for (position, source) in data.positions.iter_mut().zip(&geometry.sources) {
            if let Some([way, _]) = of(source) {
                let moved = added(*position, *way);
                if crate::mesh_formats::drawable(moved) {
                    *position = moved;
                }
            }
        }
        for (normal, source) in data.normals.iter_mut().zip(&geometry.sources) {
            if let Some([_, change]) = of(source) {
                let turned = added(*normal, *change);
                if turned.iter().all(|v| v.is_finite()) {
                    *normal = turned;
                }
            }
        }
    }
}

fn added(v: [f32; 3], by: [f64; 3]) -> [f32; 3] {
    let ([a, b, c], [x, y, z]) = (v.map(f64::from), by);
    [(a + x) as f32, (b + y) as f32, (c + z) as f32]
}

/// Moves the vertices of a mesh to where the bones of its skin have them in the world. False if it has no skin, or none of
/// which a bone is there. `mesh` places what no bone holds; `shape` comes before all bones.
pub(super) fn skin(
    document: &Document<'_>,
    number: usize,
    geometry: &mut Geometry,
    [mesh, shape]: [&Transform; 2],
    world: impl Fn(usize) -> Option<Transform>,
    budget: &mut Budget,
) -> Result<bool, LoadError> {
    let mut sums: Vec<Sum> = Vec::new();
    for (skin, _) in document.linked(number, Kind::Deformer).filter(|(_, object)| object.class == b"Skin") {
        for (cluster, object) in document.linked(skin, Kind::Deformer) {
            let Some(bone) = document.linked(cluster, Kind::Model).find_map(|(bone, _)| world(bone)) else {
                continue;
            };
            let bound: Vec<f64> = object.record.list("Transform", budget)?;
            let Some(map) = matrix(&bound).and_then(|bound| bone.after(&bound).ok()?.after(shape).ok())
            else {
                continue;
            };
            let indices: Vec<i32> = object.record.list("Indexes", budget)?;
            let weights: Vec<f64> = object.record.list("Weights", budget)?;
            if sums.is_empty() {
                let size = size_of::<Sum>() as u64;
                budget.charge(|| format!("{FORMAT}: a skin"), geometry.points as u64, size)?;
                sums = vec![Sum::default(); geometry.points];
            }
            for (index, weight) in indices.iter().zip(weights) {
                let sum = usize::try_from(*index).ok().and_then(|index| sums.get_mut(index));
                if let Some(sum) = sum.filter(|_| weight > 0.0 && weight.is_finite()) {
                    sum.add(&map, weight);
                }
            }
        }
    }
    if sums.is_empty() {
        return Ok(false);
    }
    let rest = mesh.after(shape).unwrap_or(*mesh);
    for (k, source) in geometry.sources.iter().enumerate() {
        let map = sums.get(*source as usize).and_then(Sum::mean).unwrap_or(rest);
        if let Some(position) = geometry.data.positions.get_mut(k) {
            let moved = map.point(position.map(f64::from)).map(|v| v as f32);
            *position = if crate::mesh_formats::drawable(moved) { moved } else { [0.0; 3] };
        }
        if let Some(normal) = geometry.data.normals.get_mut(k) {
            let [x, y, z] = *normal;
            *normal = map.normal_matrix().map(|[a, b, c]| a * x + b * y + c * z);
        }
    }
    Ok(true)
}

/// Sum of the weighted matrices of a control point.
#[derive(Clone, Copy, Default)]
struct Sum {
    rows: [[f64; 4]; 3],
    weight: f64,
}

impl Sum {
    fn add(&mut self, map: &Transform, weight: f64) {
        let all = self.rows.as_flattened_mut().iter_mut().zip(map.rows().as_flattened());
        all.for_each(|(sum, v)| *sum += weight * v);
        self.weight += weight;
    }

    fn mean(&self) -> Option<Transform> {
        if self.weight <= 0.0 {
            return None;
        }
        Transform::from_rows(self.rows.map(|row| row.map(|v| v / self.weight))).ok()
    }
}
