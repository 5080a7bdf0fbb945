//! Parts told from scans, figures and terrain by the angles of their edges.

use super::{CREASE_COSINE, SLIVER, face_normal, size_of_mesh};
use crate::{Mesh, PrimitiveKind};

/// Cosines of 20 degrees and of 1.
const UNCLEAR_COSINE: f32 = 0.939_692_6;
const FLAT_COSINE: f32 = 0.999_847_7;

/// Faces of a mesh up to which it is not worth while to look at some of its edges before all of them, and about as many of which edges are
/// looked at in a larger one.
const FEW: usize = 1 << 15;

/// Lengths of edges by their angle.
#[derive(Default)]
pub(super) struct Angles {
    /// Below 1 degree.
    flat: f64,
    /// 20 degrees up to a crease.
    unclear: f64,
    creases: f64,
    /// Edges of one face, or of more than two.
    open: f64,
    all: f64,
}

impl Angles {
    /// Adds an edge, by the cosine between its faces if there are two.
    pub(super) fn add(&mut self, cosine: Option<f32>, length: f64) {
        self.all += length;
        match cosine {
            None => self.open += length,
            Some(cosine) if cosine < CREASE_COSINE => self.creases += length,
            Some(cosine) if cosine < UNCLEAR_COSINE => self.unclear += length,
            Some(cosine) if cosine > FLAT_COSINE => self.flat += length,
            Some(_) => {}
        }
    }

    /// True if the angles are those of a part. Of 9 parts (plates, housings, gears, heat sinks), unclear edges were 0 to 0.01 of the
    /// length of the creases, and 0.5 to 0.9 of all edges lay in a plane; of 12 figures, scans and terrains 0.4 and more, and 0.02 to 0.47.
    /// Small cylinders of few sides are parts whose edges are unclear and plane.
    pub(super) fn are_of_part(&self) -> bool {
        let most = if self.flat > 0.5 * self.all { 4.0 } else { 0.3 };
        self.unclear <= most * self.creases && self.open <= 0.5 * self.all
    }
}

type Key = [u32; 3];

/// False if some of the edges of a large mesh, those at vertices that a hash of their position chooses, are not those of a part.
/// True for small ones, of which all edges are looked at anyway.
pub(crate) fn may_be_part(mesh: &Mesh) -> bool {
    let faces = if mesh.kind() == PrimitiveKind::Triangles { mesh.triangles() } else { &[] };
    if faces.len() <= FEW {
        return true;
    }
    let one_in = (faces.len() / FEW).next_power_of_two() as u64;
    let corner = |v: u32| mesh.positions()[v as usize];
    let mut sides: Vec<(Key, Key, u32, bool)> = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        let keys = face.map(|v| corner(v).map(|x| (x + 0.0).to_bits()));
        let is_chosen = keys.map(|key| super::weld::hash(key) >> 40 & (one_in - 1) == 0);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let forwards = keys[a] < keys[b];
            let (low, high) = if forwards { (a, b) } else { (b, a) };
            if is_chosen[low] && keys[a] != keys[b] {
                sides.push((keys[low], keys[high], number as u32, forwards));
            }
        }
    }
    sides.sort_unstable();
    let least = size_of_mesh(mesh) * SLIVER;
    let normal = |face: u32| face_normal(faces[face as usize].map(corner), least);
    let mut angles = Angles::default();
    for sides in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let cosine = match sides {
            [a, b] => {
                let ([ax, ay, az], [bx, by, bz]) = (normal(a.2), normal(b.2));
                let dot = ax * bx + ay * by + az * bz;
                Some(if a.3 == b.3 { -dot } else { dot })
            }
            _ => None,
        };
        let place = |key: Key| key.map(f32::from_bits);
        angles.add(cosine, super::distance(place(sides[0].0), place(sides[0].1)));
    }
    angles.are_of_part()
}
