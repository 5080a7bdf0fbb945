//! Triangles that are painted in a slicer with the filaments that print them: PrusaSlicer's `mmu_segmentation`, Bambu
//! Studio's and OrcaSlicer's `paint_color`.
//!
//! The attribute is a tree of hexadecimal digits, read from its end. The lower two bits of a digit are the number of
//! sides of a triangle that are cut in half; the upper two say at which corner that begins, or, of one that is not cut,
//! by which extruder it is printed: none, the first, the second, or 3 plus what the next digit says. Parts follow in
//! reverse.

use overcoat_scene::MeshData;
use std::collections::BTreeMap;

/// Cuts within cuts: slicers stop at a fraction of a millimetre.
const DEEPEST: usize = 32;

/// Paints triangles of one mesh with positions and normals.
pub(super) struct Painter<'a> {
    pub(super) mesh: &'a mut MeshData,
    /// Middles of edges, by their ends in the order of their numbers.
    middles: BTreeMap<(u32, u32), u32>,
    /// Parts of the triangle, and the extruders that print them: 0 is that of the object.
    pub(super) parts: Vec<([u32; 3], u32)>,
}

impl<'a> Painter<'a> {
    pub(super) fn new(mesh: &'a mut MeshData) -> Self {
        Self { mesh, middles: BTreeMap::new(), parts: Vec::new() }
    }

    /// Fills `parts` with those of a triangle; false if the code makes no sense.
    pub(super) fn paint(&mut self, triangle: [u32; 3], code: &str) -> bool {
        self.parts.clear();
        let mut digits = code.bytes().rev().map(|b| char::from(b).to_digit(16));
        self.read(triangle, &mut || digits.next().flatten(), DEEPEST).is_some()
    }

    fn read(
        &mut self,
        triangle: [u32; 3],
        next: &mut impl FnMut() -> Option<u32>,
        depth: usize,
    ) -> Option<()> {
        let digit = next()?;
        let start = digit >> 2;
        let sides = digit & 3;
        if sides == 0 {
            let extruder = if start == 3 { next()?.saturating_add(3) } else { start };
            self.parts.push((triangle, extruder));
            return Some(());
        }
        let depth = depth.checked_sub(1)?;
        let [first, second, third] = triangle;
        let [a, b, c] = match start {
            0 => [first, second, third],
            1 => [second, third, first],
            2 => [third, first, second],
            _ => return None,
        };
        let parts = match sides {
            1 => {
                let bc = self.middle(b, c)?;
                [Some([a, b, bc]), Some([bc, c, a]), None, None]
            }
            2 => {
                let (ab, ca) = (self.middle(a, b)?, self.middle(c, a)?);
                [Some([a, ab, ca]), Some([ab, b, ca]), Some([b, c, ca]), None]
            }
            _ => {
                let (ab, bc, ca) = (self.middle(a, b)?, self.middle(b, c)?, self.middle(c, a)?);
                [Some([a, ab, ca]), Some([ab, b, bc]), Some([bc, c, ca]), Some([ab, bc, ca])]
            }
        };
        parts.into_iter().rev().flatten().try_for_each(|part| self.read(part, next, depth))
    }

    /// The vertex between two others, one for neighbours too; `None` if there are no such vertices.
    fn middle(&mut self, p: u32, q: u32) -> Option<u32> {
        let edge = (p.min(q), p.max(q));
        if let Some(&middle) = self.middles.get(&edge) {
            return Some(middle);
        }
        let mesh = &mut *self.mesh;
        let (p, q) = (p as usize, q as usize);
        let half = |a: [f32; 3], b: [f32; 3]| {
            let ([a, b, c], [d, e, f]) = (a.map(|v| v * 0.5), b.map(|v| v * 0.5));
            [a + d, b + e, c + f]
        };
        let middle = u32::try_from(mesh.positions.len()).ok()?;
        mesh.positions.push(half(*mesh.positions.get(p)?, *mesh.positions.get(q)?));
        // Normals of the vertices, so that paint does not change how round a surface looks.
        if let (Some(&a), Some(&b)) = (mesh.normals.get(p), mesh.normals.get(q)) {
            mesh.normals.push(half(a, b));
        }
        self.middles.insert(edge, middle);
        Some(middle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> MeshData {
        MeshData::default().with(|d| {
            d.positions = vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
            d.normals = vec![[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
            d.triangles = vec![[0, 1, 2]];
        })
    }

    fn paint(code: &str) -> Option<Vec<([u32; 3], u32)>> {
        let mut mesh = mesh();
        let mut painter = Painter::new(&mut mesh);
        painter.paint([0, 1, 2], code).then(|| painter.parts.clone())
    }

    #[test]
    fn whole_triangles_have_one_digit_or_two() {
        for (code, extruder) in [("0", 0), ("4", 1), ("8", 2), ("0C", 3), ("1C", 4), ("DC", 16)] {
            assert_eq!(paint(code), Some(vec![([0, 1, 2], extruder)]), "{code}");
        }
        for code in ["", "C", "G", "43", "D", "\u{e9}"] {
            assert_eq!(paint(code), None, "{code}");
        }
        assert_eq!(paint(&"3".repeat(1_000_000)), None);
    }

    #[test]
    fn cut_triangles_cover_the_whole() {
        let area = |mesh: &MeshData, [a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|v| mesh.positions[v as usize]);
            ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) * 0.5
        };
        for (code, parts) in
            [("481", 2), ("485", 2), ("809", 2), ("0482", 3), ("480A", 3), ("40483", 4), ("4804813", 5)]
        {
            let mut mesh = mesh();
            let mut painter = Painter::new(&mut mesh);
            assert!(painter.paint([0, 1, 2], code), "{code}");
            let found = std::mem::take(&mut painter.parts);
            assert_eq!(found.len(), parts, "{code}");
            let whole: f32 = found.iter().map(|part| area(&mesh, part.0)).sum();
            assert_eq!(whole, 8.0, "{code}");
            assert!(found.iter().all(|part| area(&mesh, part.0) > 0.0), "{code}: {found:?}");
        }
    }

    #[test]
    fn neighbours_share_the_middles_of_edges() {
        let mut mesh = mesh();
        mesh.positions.push([4.0, 4.0, 0.0]);
        mesh.normals.push([0.0; 3]);
        let mut painter = Painter::new(&mut mesh);
        assert!(painter.paint([0, 1, 2], "40483") && painter.paint([2, 1, 3], "40483"));
        assert_eq!(mesh.positions.len(), 4 + 5);
        assert_eq!(mesh.normals[5], [0.5, 0.0, 0.5]);
    }
}
