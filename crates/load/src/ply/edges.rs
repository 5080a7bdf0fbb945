//! Edges: pairs of vertices, drawn as lines.
//!
//! They have colours of their own or those of their vertices. Sides of the faces that are drawn are no lines unless edges have
//! colours: programs that list all edges do not mean them to be seen on the surface. Lines have no normals, so they are drawn
//! without light, as those of OBJ and glTF are.

use super::body::{ALPHA, COLOR, SLOTS, Slots, Vertices, cut, existing, settle_colors, skip_property, store};
use super::header::{Element, Kind, Property};
use super::values::{Missing, Values};
use super::{FORMAT, settle_alpha};
use crate::mesh_formats::{add_object, check_mesh, default_material, white_material};
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError};
use overcoat_scene::{MeshData, PrimitiveKind, Scene};

/// Names of the elements.
pub(super) const EDGES: [&str; 2] = ["edge", "edges"];
/// Names of the two ends.
const ENDS: [[&str; 5]; 2] = [
    ["vertex1", "vertex_1", "v1", "vertex_index1", "start"],
    ["vertex2", "vertex_2", "v2", "vertex_index2", "end"],
];

/// Edges as they are in the file.
#[derive(Debug, Default)]
pub(super) struct Edges {
    ends: Vec<[i64; 2]>,
    /// One per edge; empty without.
    colors: Vec<[f32; 4]>,
    /// Reason why there are fewer than the header says.
    pub(super) cut: Option<String>,
}

/// Reads edges: two numbers each, or a list of the vertices that a line goes through. What is complete when the file ends is
/// kept; what has no ends is passed over.
pub(super) fn edges(
    element: &Element,
    values: &mut Values<'_>,
    context: &Context<'_>,
) -> Result<Edges, LoadError> {
    let slots = Slots::new(element);
    let with_colors = slots.has(COLOR..ALPHA);
    let end = |p: &Property| ENDS.iter().position(|names| names.contains(&p.name.as_str()));
    let is_path = |p: &&Property| matches!(p.kind, Kind::List(_, scalar) if !scalar.is_float());
    let path = element.properties.iter().find(is_path).map(|property| property.name.as_str());
    let mut out = Edges::default();
    let mut item = [0.0; SLOTS];
    let mut points: Vec<i64> = Vec::new();
    for number in 0..element.count {
        item[ALPHA] = 1.0;
        points.clear();
        let mut ends = [None; 2];
        let mut read = || -> Result<(), Missing> {
            for (property, &slot) in element.properties.iter().zip(&slots.0) {
                match property.kind {
                    Kind::One(scalar) => match end(property).and_then(|end| ends.get_mut(end)) {
                        Some(end) => *end = Some(values.integer(scalar)?),
                        None => store(&mut item, slot, values.number(scalar)?),
                    },
                    Kind::List(count, scalar) if Some(property.name.as_str()) == path => {
                        // Grows with what is there, whatever the count says.
                        for _ in 0..values.integer(count)? {
                            points.push(values.integer(scalar)?);
                        }
                    }
                    list @ Kind::List(..) => skip_property(list, values)?,
                }
            }
            Ok(())
        };
        match read() {
            Ok(()) if element.by_line => drop(values.skip_line()),
            Ok(()) => {}
            Err(Missing::NotANumber) if values.skip_line() => {
                // An edge between vertices that do not exist is counted where all are.
                ends = [Some(-1); 2];
                points.clear();
            }
            Err(missing) => {
                out.cut = Some(cut(element, number, missing));
                break;
            }
        }
        if let [Some(a), Some(b)] = ends {
            out.ends.push([a, b]);
        }
        out.ends.extend(points.iter().zip(points.iter().skip(1)).map(|(&a, &b)| [a, b]));
        if with_colors {
            let color = [item[COLOR], item[COLOR + 1], item[COLOR + 2], item[ALPHA]];
            out.colors.resize(out.ends.len(), color);
        }
        if number % 1024 == 0 || points.len() > 1024 {
            check_mesh(context, out.ends.len() as u64, 0)?;
        }
    }
    settle_colors(&slots, &mut out.colors);
    check_mesh(context, out.ends.len() as u64, 0)?;
    Ok(out)
}

impl Edges {
    pub(super) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The lines that are drawn; none if there are no edges to draw. `triangles` are those of the faces.
    ///
    /// # Errors
    /// [`LoadError::Limit`].
    pub(super) fn lines(
        self,
        vertices: &Vertices,
        triangles: &[[u32; 3]],
        context: &Context<'_>,
        warnings: &mut Warnings,
    ) -> Result<Option<MeshData>, LoadError> {
        let before = self.ends.len();
        let with_colors = !self.colors.is_empty();
        let positions = &vertices.positions;
        let drawn = |&[a, b]: &[i64; 2]| {
            existing(a, positions)?;
            existing(b, positions).map(|_| [a as u32, b as u32])
        };
        let colors = self.colors.into_iter().map(Some).chain(std::iter::repeat(None));
        let mut segments: Vec<([u32; 2], Option<[f32; 4]>)> =
            self.ends.iter().zip(colors).filter_map(|(ends, color)| Some((drawn(ends)?, color))).collect();
        if segments.len() < before {
            let lost = counted(before.abs_diff(segments.len()) as u64, "edge");
            warnings
                .add(|| format!("{FORMAT}: {lost} left out: vertices missing, not finite or beyond 1e15"));
        }
        if !with_colors {
            leave_out_sides(&mut segments, triangles);
        }
        if segments.is_empty() {
            return Ok(None);
        }
        let count = segments.len() as u64;
        check_mesh(context, (triangles.len() as u64).saturating_add(count), count.saturating_mul(2))?;
        let mut data = MeshData::default().with(|d| d.kind = PrimitiveKind::Lines);
        for (ends, color) in segments {
            let first = data.positions.len() as u32;
            for end in ends {
                data.positions.extend(positions.get(end as usize));
                data.colors.extend(color.or_else(|| vertices.colors.get(end as usize).copied()));
            }
            let second = first.saturating_add(1);
            data.triangles.push([first, second, second]);
        }
        Ok(Some(data))
    }
}

/// Leaves out the segments that are sides of triangles.
fn leave_out_sides<T>(segments: &mut Vec<([u32; 2], T)>, triangles: &[[u32; 3]]) {
    if segments.is_empty() || triangles.is_empty() {
        return;
    }
    let ordered = |[a, b]: [u32; 2]| if a < b { [a, b] } else { [b, a] };
    let mut known: Vec<([u32; 2], bool)> = segments.iter().map(|(ends, _)| (ordered(*ends), false)).collect();
    known.sort_unstable();
    known.dedup();
    for &[a, b, c] in triangles {
        for side in [[a, b], [b, c], [c, a]].map(ordered) {
            if let Ok(place) = known.binary_search_by_key(&side, |(ends, _)| *ends)
                && let Some((_, is_side)) = known.get_mut(place)
            {
                *is_side = true;
            }
        }
    }
    segments.retain(|(ends, _)| {
        let place = known.binary_search_by_key(&ordered(*ends), |(ends, _)| *ends);
        place.ok().and_then(|place| known.get(place)).is_none_or(|(_, is_side)| !is_side)
    });
}

/// Adds lines to a scene.
pub(super) fn add(scene: &mut Scene, mut lines: MeshData) -> Result<(), LoadError> {
    let mut material = if lines.colors.is_empty() { default_material() } else { white_material() };
    material.alpha_mode = settle_alpha(&mut lines.colors);
    let material = material.with(|m| m.unlit = true);
    let material = scene.add_material(material).map_err(LoadError::scene("PLY: material of edges"))?;
    add_object(scene, "PLY: edges", lines, material, 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Loaded, NoResolver};
    use overcoat_core::jobs::Jobs;
    use overcoat_core::limits::Limits;

    fn load(edges: &str, items: &str, faces: &str, color: bool) -> Loaded {
        let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
        let (properties, white) = if color { (colors, " 255 255 255") } else { ("", "") };
        let vertices: String =
            ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "nan 0 0"].map(|p| format!("{p}{white}\n")).concat();
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n{properties}\
             element face {}\nproperty list uchar int vertex_indices\nelement edge {}\n{edges}end_header\n{vertices}{faces}{items}",
            faces.lines().count(),
            items.lines().count(),
        );
        let limits = Limits::default();
        let context = Context { resolver: &NoResolver, limits: &limits, jobs: &Jobs::new(1) };
        super::super::load(
            text.as_bytes(),
            &context,
            crate::TextureLoading::Whole,
            &crate::shares::Shares::default(),
        )
        .unwrap()
    }

    const ENDS: &str = "property int vertex1\nproperty int vertex2\n";

    fn segments(loaded: &Loaded) -> Vec<[[f32; 3]; 2]> {
        let lines = loaded.scene.meshes().iter().filter(|mesh| mesh.kind() == PrimitiveKind::Lines);
        let ends = lines.flat_map(|mesh| {
            mesh.triangles().iter().map(|[a, b, _]| [a, b].map(|&v| mesh.positions()[v as usize]))
        });
        ends.collect()
    }

    #[test]
    fn edges_are_lines_in_their_colours() {
        let colored = format!("{ENDS}property uchar red\nproperty uchar green\nproperty uchar blue\n");
        let loaded = load(&colored, "0 1 255 0 0\n1 2 0 255 0\n", "", true);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let (x, corner) = ([1.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
        assert_eq!(segments(&loaded), [[[0.0; 3], x], [x, corner]]);
        let mesh = &loaded.scene.meshes()[0];
        let [red, green] = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]];
        assert_eq!((mesh.colors(), loaded.scene.meshes().len()), (&[red, red, green, green][..], 1));
        assert!(loaded.scene.materials()[0].unlit);
        // Colours of the vertices, or none.
        assert_eq!(load(ENDS, "0 1\n", "", true).scene.meshes()[0].colors(), [[1.0; 4]; 2]);
        assert!(load(ENDS, "0 1\n", "", false).scene.meshes()[0].colors().is_empty());
        // A list is a path.
        let path = load("property list uchar int vertex_indices\n", "3 0 1 2\n", "", false);
        assert_eq!(segments(&path), segments(&loaded));
    }

    #[test]
    fn sides_of_faces_are_lines_where_they_have_colours() {
        let loaded = load(ENDS, "0 1\n2 1\n0 2\n3 0\n", "3 0 1 2\n", false);
        assert_eq!(segments(&loaded), [[[0.0, 1.0, 0.0], [0.0; 3]]]);
        assert_eq!(loaded.scene.meshes().len(), 2);
        assert!(segments(&load(ENDS, "0 1\n2 1\n0 2\n", "3 0 1 2\n", false)).is_empty());
        let colored = format!("{ENDS}property uchar red\nproperty uchar green\nproperty uchar blue\n");
        assert_eq!(segments(&load(&colored, "0 1 255 0 0\n", "3 0 1 2\n", false)).len(), 1);
    }

    #[test]
    fn edges_that_cannot_be_drawn_are_counted() {
        let loaded = load(ENDS, "0 1\n0 9\n-1 2\n4 0\n? 0\n", "", false);
        assert_eq!(segments(&loaded).len(), 1);
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        assert_eq!(warning.message, "PLY: 4 edges left out: vertices missing, not finite or beyond 1e15");
        // With none of them the vertices are what there is.
        let loaded = load(ENDS, "0 9\n", "", false);
        assert_eq!(loaded.scene.meshes()[0].kind(), PrimitiveKind::Points);
    }
}
