//! Plates of a slicer's project, which lie a printer's width apart in the file: put side by side, or one of them chosen.

use super::model::Reference;
use super::slicer::Settings;
use crate::{LoadError, Plate};
use overcoat_scene::{Bounds, Scene};
use std::collections::BTreeMap;

/// Room between plates, in sides of the largest.
const GAP: f64 = 0.1;

/// Number of what lies on no plate: behind all.
const NO_PLATE: u32 = u32::MAX;

/// Leaves those items in a list that lie on the plate of a number.
///
/// # Errors
/// [`LoadError::NoSuch`] with the plates that there are, or if there is nothing on the one that is asked for.
pub(super) fn choose(
    number: u32,
    plates: &[Plate],
    build: &mut Vec<Reference>,
    settings: &Settings,
) -> Result<(), LoadError> {
    let count = plates.len();
    let Some(plate) = plates.iter().find(|plate| plate.number == number) else {
        let last = plates.last().map_or(0, |plate| plate.number);
        let found = match count {
            0 => "the file has no plates".to_owned(),
            1 => format!("the file has 1 plate, {last}"),
            // They are numbered from 1 without a gap, but where a file has lost some.
            _ if last as usize == count => format!("the file has {count} plates, 1 to {last}"),
            _ => format!("the file has {count} plates, the last of them {last}"),
        };
        return Err(LoadError::no_such(format!("there is no plate {number}: {found}")));
    };
    let on = plates_of(build, settings);
    let mut on = on.iter();
    build.retain(|_| on.next() == Some(&number));
    if build.is_empty() {
        let Plate { number, .. } = plate;
        return Err(LoadError::no_such(format!("there is nothing on plate {number} of {count}")));
    }
    Ok(())
}

/// The plate of each item that is built; empty for files in which all lie on one.
pub(super) fn of_items(build: &[Reference], settings: &Settings) -> Vec<u32> {
    if settings.has_plates() { plates_of(build, settings) } else { Vec::new() }
}

/// The plate of each item that is built.
fn plates_of(build: &[Reference], settings: &Settings) -> Vec<u32> {
    let mut instances: BTreeMap<u32, u32> = BTreeMap::new();
    let plate = |item: &Reference| {
        let instance = instances.entry(item.object).or_default();
        let plate = settings.plate(item.object, *instance);
        *instance = instance.saturating_add(1);
        plate.unwrap_or(NO_PLATE)
    };
    build.iter().map(plate).collect()
}

/// Moves the plates of a scene, Z up, into rows that begin at the back: as near each other as their sizes allow. A scene
/// with a single plate that has anything on it stays as it is.
///
/// # Errors
/// [`LoadError`] if a plate leaves the range of coordinates.
pub(super) fn arrange(scene: &mut Scene, plates: &[u32]) -> Result<(), LoadError> {
    let plate_of = |object: u32| plates.get(object as usize).copied().unwrap_or(NO_PLATE);
    let mut boxes: BTreeMap<u32, Bounds> = BTreeMap::new();
    for instance in scene.instances() {
        let Some(mesh) = scene.meshes().get(instance.mesh.index()) else { continue };
        let own = mesh.bounds().transformed(&instance.transform);
        let all = boxes.entry(plate_of(instance.object)).or_insert(Bounds::EMPTY);
        *all = all.union(&own);
    }
    boxes.retain(|_, own| !own.is_empty());
    if boxes.len() < 2 {
        return Ok(());
    }
    let moves = moves(&boxes);
    for number in 0..scene.instances().len() {
        let Some(instance) = scene.instances().get(number) else { continue };
        let Some((x, y)) = moves.get(&plate_of(instance.object)) else { continue };
        let transform = instance.transform.less([-x, -y, 0.0]);
        scene.set_instance_transform(number, transform).map_err(LoadError::scene("3MF: plate"))?;
    }
    Ok(())
}

/// Distances along X and Y by which plates move. The first one stays on the left.
fn moves(boxes: &BTreeMap<u32, Bounds>) -> BTreeMap<u32, (f64, f64)> {
    let largest = boxes.values().fold(0.0_f64, |m, b| m.max(b.size()[0]).max(b.size()[1]));
    let gap = GAP * largest;
    let columns = (1..=boxes.len()).find(|n| n.saturating_mul(*n) >= boxes.len()).unwrap_or(1);
    let Some(first) = boxes.values().next() else { return BTreeMap::new() };
    let (left, mut back) = (first.min[0], first.max[1]);
    let mut moves = BTreeMap::new();
    let all: Vec<(&u32, &Bounds)> = boxes.iter().collect();
    for row in all.chunks(columns) {
        let depth = row.iter().fold(0.0_f64, |m, (_, b)| m.max(b.size()[1]));
        let mut x = left;
        for (plate, own) in row {
            // In the middle of the row.
            moves.insert(**plate, (x - own.min[0], back - 0.5 * depth - own.center()[1]));
            x += own.size()[0] + gap;
        }
        back -= depth + gap;
    }
    moves
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, width: f64, depth: f64) -> Bounds {
        Bounds { min: [x, y, 0.0], max: [x + width, y + depth, 1.0] }
    }

    #[test]
    fn plates_move_together_and_do_not_overlap() {
        let boxes: BTreeMap<u32, Bounds> = (1..6)
            .map(|k: u32| {
                let n = f64::from(k);
                (k, at(300.0 * n, -200.0 * n, 10.0 + n, 30.0 - 2.0 * n))
            })
            .collect();
        let moves = moves(&boxes);
        let moved: Vec<Bounds> = boxes
            .iter()
            .map(|(plate, b)| {
                let (x, y) = moves[plate];
                at(b.min[0] + x, b.min[1] + y, b.size()[0], b.size()[1])
            })
            .collect();
        let all = moved.iter().fold(Bounds::EMPTY, |all, own| all.union(own));
        assert!(all.size()[0] < 60.0 && all.size()[1] < 70.0, "{all:?}");
        for (k, a) in moved.iter().enumerate() {
            for b in &moved[k + 1..] {
                let apart = |axis: usize| a.max[axis] < b.min[axis] || b.max[axis] < a.min[axis];
                assert!(apart(0) || apart(1), "{a:?} {b:?}");
            }
        }
        assert_eq!(moved[0].min[0], 300.0);
        // From left to right, from back to front.
        assert!(moved[1].min[0] > moved[0].max[0] && moved[3].max[1] < moved[0].min[1]);
    }
}
