//! Stanford polygon files: text and binary of either byte order.
//!
//! Parsed here and not by a crate, which would hand over every value in a map of names: a hundred times the memory of
//! the file, and no say in what a damaged one gives.
//!
//! Colours are sRGB: codes in whole numbers, 0 to 1 in fractions. Coloured faces win over coloured vertices unless all
//! faces have one colour. `comment TextureFile` names the texture of vertex (`s t`, `u v`, `texture_u texture_v`) or
//! face (`texcoord`) coordinates. Files of Gaussian splats are known by their properties.
mod body;
mod edges;
mod header;
mod packed;
mod places;
mod reduced;
mod splats;
mod stream;
mod textures;
mod values;

pub(crate) use reduced::load_file;

use super::mesh_formats::{
    add_object, check_input, check_mesh, default_material, drawable, finish, of_corners, separate_triangles,
    white_material,
};
use super::normals::{add_missing_normals, add_smooth_normals};
use super::origin::{Origin, Region, load_about, lost_steps};
use super::point_clouds::{Points, cloud};
use super::shares::Shares;
use super::text::quoted;
use super::warnings::Warnings;
use super::warnings::counted;
use super::{Context, LoadError, Loaded, TextureLoading};
use body::{Faces, Vertices};
use edges::{EDGES, Edges};
use header::{Element, Encoding, Header};
use overcoat_core::jobs::Jobs;
use overcoat_scene::{AlphaMode, CREASE_ANGLE, MeshData, Scene};
use values::Values;

const FORMAT: &str = "PLY";
/// Names of elements of vertices.
const VERTICES: [&str; 2] = ["vertex", "vertices"];
/// Names of elements of faces.
const FACES: [&str; 3] = ["face", "faces", "tristrips"];

/// Reads a PLY file, and the texture that it names.
///
/// One that ends early is drawn as far as it goes, with a warning. Faces with vertices that do not exist or are not finite are
/// left out, with a warning; words that are no numbers are not finite. Meshes and clouds beyond the limits are reduced, with a
/// warning.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    loading: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    match load_about(|region| load_in(bytes, region, context, loading, shares)) {
        Err(LoadError::Limit(error)) => reduced::load_bytes(bytes, error, context),
        loaded => loaded,
    }
}

/// Reads a file, about an origin where its model is in a region far away.
fn load_in(
    bytes: &[u8],
    region: Option<&Region>,
    context: &Context<'_>,
    loading: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    let mut warnings = Warnings::default();
    let mut header = Header::read(bytes, &mut warnings)?;
    if !header.longs.is_empty() && header.encoding != Encoding::Ascii && !fits(&header) {
        header.shorten_longs();
    }
    if header.encoding == Encoding::Ascii && items_on_lines(&header) {
        header.elements.iter_mut().for_each(|element| element.by_line = true);
    }
    splats::take_prefixes_away(&mut header);
    if let Some(layout) = splats::layout(&header) {
        return splats::load(&layout, &header, context, warnings);
    }
    load_read(&header, region, context, loading, shares, warnings)
}

/// Reads the elements of a file without splats, whose header is known.
fn load_read(
    header: &Header<'_>,
    region: Option<&Region>,
    context: &Context<'_>,
    loading: TextureLoading,
    shares: &Shares,
    mut warnings: Warnings,
) -> Result<Loaded, LoadError> {
    let mut origin = Origin::default();
    let (mut vertices, mut faces, edges) =
        read_body(header, region.map(|region| (region, &mut origin)), context, &mut warnings)?;
    let lines = edges.lines(&vertices, &faces.triangles, context, &mut warnings)?;
    let mut scene = Scene::new();
    scene.set_origin(origin.0);
    let is_cloud = faces.triangles.is_empty();
    // A file with faces, even bad ones, or with edges is not shown by its vertices alone.
    let has_others = faces.bad > 0 || faces.short > 0 || lines.is_some();
    let is_something = !(is_cloud && (vertices.positions.is_empty() || has_others));
    if is_something {
        if vertices.normals.iter().all(is_no_normal) {
            vertices.normals = Vec::new();
        }
        let of_faces = std::mem::take(&mut faces.textures);
        let mut data = if is_cloud {
            cloud(FORMAT, vertices.into(), &mut warnings)
        } else {
            build(vertices, faces, context)?
        };
        if !is_cloud {
            add_normals(&mut data, context.jobs);
        }
        let names = &header.textures;
        let reader = textures::Reader::new(context, loading, shares);
        let parts = textures::by_texture(data, names, &of_faces, &mut scene, reader, &mut warnings)?;
        add_parts(&mut scene, parts)?;
    }
    lines.map(|lines| edges::add(&mut scene, lines)).transpose()?;
    Ok(finish(scene, warnings.finish()))
}

impl From<Vertices> for Points {
    /// Vertices without faces.
    fn from(vertices: Vertices) -> Self {
        let Vertices { positions, normals, uvs, colors, values, measure, .. } = vertices;
        Self { positions, normals, uvs, colors, values, measure }
    }
}

/// Adds the parts of a mesh or cloud, each with a material.
fn add_parts(scene: &mut Scene, parts: Vec<textures::Part>) -> Result<(), LoadError> {
    // Programs write some colour for every vertex; one that is the same everywhere is not meant to tint a texture.
    let mut colors = parts.iter().flat_map(|(data, _)| &data.colors);
    let first = colors.next().copied();
    let is_uniform = colors.all(|color| Some(*color) == first);
    for (mut data, texture) in parts {
        if data.positions.is_empty() {
            continue;
        }
        let mut material = default_material();
        if texture.is_some() {
            (material.base_color, material.has_edges) = ([1.0; 4], false);
            if is_uniform {
                data.colors = Vec::new();
            }
        }
        if !data.colors.is_empty() {
            material = white_material();
            material.alpha_mode = settle_alpha(&mut data.colors);
        }
        material.base_color_texture = texture;
        let material = scene.add_material(material).map_err(LoadError::scene("PLY: material"))?;
        add_object(scene, "PLY: mesh", data, material, 0)?;
    }
    Ok(())
}

/// Coverage of the colours of vertices. All transparent is what programs write that do not know alpha: they become opaque.
fn settle_alpha(colors: &mut [[f32; 4]]) -> AlphaMode {
    let any = |a: fn(f32) -> bool| colors.iter().any(|c| a(c[3]));
    if !any(|a| a > 0.0) {
        colors.iter_mut().for_each(|c| c[3] = 1.0);
        AlphaMode::Opaque
    } else if any(|a| a < 1.0) {
        AlphaMode::Blend
    } else {
        AlphaMode::Opaque
    }
}

/// True for what programs write that have no normals: zeros, which is also what is made of those that are no numbers.
fn is_no_normal(normal: &[f32; 3]) -> bool {
    normal.iter().all(|&v| v == 0.0)
}

/// Gives the vertices of a mesh smooth normals that the file has none for.
fn add_normals(data: &mut MeshData, jobs: &Jobs) {
    if data.normals.is_empty() {
        add_smooth_normals(data, CREASE_ANGLE, jobs);
        return;
    }
    let missing: Vec<bool> = data.normals.iter().map(is_no_normal).collect();
    if missing.contains(&true) {
        add_missing_normals(data, CREASE_ANGLE, |v| missing.get(v) == Some(&true), jobs);
    }
}

/// True if the values of a binary file end where the file does.
fn fits(header: &Header<'_>) -> bool {
    let mut values = Values::new(header.encoding, header.body);
    header.elements.iter().all(|element| body::skip(element, &mut values).is_ok()) && values.is_empty()
}

/// The vertices of a file whose faces come first, which the format allows: they are read ahead.
fn vertices_behind_faces(
    header: &Header<'_>,
    far: &mut Option<(&Region, &mut Origin)>,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Option<Vertices>, LoadError> {
    let is_of = |names: &[&str], element: &Element| names.contains(&element.name.as_str());
    let Some(at) = header.elements.iter().position(|e| is_of(&VERTICES, e)) else { return Ok(None) };
    let Some((before, [element, ..])) = header.elements.split_at_checked(at) else { return Ok(None) };
    if !before.iter().any(|e| is_of(&FACES, e)) {
        return Ok(None);
    }
    let mut values = Values::new(header.encoding, header.body);
    if before.iter().any(|e| body::skip(e, &mut values).is_err()) {
        return Ok(None);
    }
    check_mesh(context, 0, element.count)?;
    let start = values.clone();
    let mut vertices = body::vertices(element, &mut values, header.encoding, header.body.len())?;
    bring_near(element, start, far.take(), &mut vertices, warnings);
    Ok(Some(vertices))
}

/// Measures vertices, whose values begin here, from an origin among them if they are in a region far away.
fn bring_near(
    element: &Element,
    values: Values<'_>,
    far: Option<(&Region, &mut Origin)>,
    vertices: &mut Vertices,
    warnings: &mut Warnings,
) {
    let Some((region, origin)) = far else { return };
    let (found, single) = body::place(element, values, region, &mut vertices.positions);
    *origin = found;
    let lost = lost_steps("PLY: positions", region.bounds()).filter(|_| single);
    lost.into_iter().for_each(|message| warnings.add(|| message));
}

/// True if a text file has as many lines as items.
fn items_on_lines(header: &Header<'_>) -> bool {
    let lines =
        header.body.split(|b| matches!(b, b'\n' | b'\r')).filter(|line| !line.trim_ascii().is_empty());
    let with_values = header.elements.iter().filter(|element| !element.properties.is_empty());
    lines.count() as u64 == with_values.map(|element| element.count).fold(0, u64::saturating_add)
}

/// Reads the elements in the order of the header. Where the model is in a region far away, its vertices are about an origin
/// there.
fn read_body(
    header: &Header<'_>,
    mut far: Option<(&Region, &mut Origin)>,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<(Vertices, Faces, Edges), LoadError> {
    let mut values = Values::new(header.encoding, header.body);
    let mut vertices = vertices_behind_faces(header, &mut far, context, warnings)?.unwrap_or_default();
    let (mut faces, mut edges) = (Faces::default(), Edges::default());
    for element in &header.elements {
        let cut = match element.name.as_str() {
            name if VERTICES.contains(&name) && vertices.positions.is_empty() => {
                check_mesh(context, 0, element.count)?;
                let before = values.clone();
                vertices = body::vertices(element, &mut values, header.encoding, header.body.len())?;
                bring_near(element, before, far.take(), &mut vertices, warnings);
                vertices.cut.take()
            }
            name if FACES.contains(&name) && faces.triangles.is_empty() => {
                let (read, given_up) = body::faces(element, &mut values, &vertices.positions, context)?;
                faces = read;
                if let Some(name) = &faces.unusual {
                    let name = quoted(name.as_bytes());
                    warnings.add(|| format!("PLY: the list {name} of faces is taken for their vertices"));
                }
                if faces.bad > 0 {
                    let bad = counted(faces.bad, "face");
                    warnings
                        .add(|| format!("PLY: {bad} left out: vertices missing, not finite or beyond 1e15"));
                }
                if faces.short > 0 {
                    let short = counted(faces.short, "face");
                    warnings.add(|| format!("PLY: {short} of less than three vertices left out"));
                }
                if given_up > 0 {
                    let polygons = counted(given_up, "concave polygon");
                    warnings.add(|| format!("PLY: {polygons} with too many corners may be drawn wrongly"));
                }
                faces.cut.take()
            }
            name if EDGES.contains(&name) && edges.is_empty() => {
                edges = edges::edges(element, &mut values, context)?;
                edges.cut.take()
            }
            _ => body::skip(element, &mut values).err(),
        };
        if let Some(cut) = cut {
            // Points without faces are something to draw, where no faces are announced.
            let announced = header.elements.iter().any(|e| FACES.contains(&e.name.as_str()) && e.count > 0);
            if vertices.positions.is_empty() || announced && faces.triangles.is_empty() {
                return Err(LoadError::malformed(FORMAT, cut));
            }
            warnings.add(|| format!("PLY: {cut}; what comes before is drawn"));
            break;
        }
    }
    Ok((vertices, faces, edges))
}

/// One mesh of vertices and faces: with vertices of their own for each triangle where faces or corners have colours
/// or texture coordinates.
fn build(vertices: Vertices, faces: Faces, context: &Context<'_>) -> Result<MeshData, LoadError> {
    let varies = faces.colors.iter().any(|c| Some(c) != faces.colors.first());
    let face_colors = !faces.colors.is_empty() && (varies || vertices.colors.is_empty());
    let Vertices { mut positions, normals, uvs, colors, .. } = vertices;
    // Vertices that cannot be drawn have lost their faces; they stand where another one does.
    let other = positions.iter().copied().find(|&position| drawable(position)).unwrap_or_default();
    positions.iter_mut().filter(|position| !drawable(**position)).for_each(|position| *position = other);
    if !face_colors && faces.corner_uvs.is_empty() {
        let triangles = faces.triangles;
        return Ok(MeshData::default().with(|d| {
            d.positions = positions;
            d.normals = normals;
            d.uvs = [uvs, Vec::new()];
            d.colors = colors;
            d.triangles = triangles;
        }));
    }
    let count = faces.triangles.len() as u64;
    check_mesh(context, count, count.saturating_mul(3))?;
    let triangles = &faces.triangles;
    Ok(MeshData::default().with(|d| {
        d.positions = of_corners(&positions, triangles);
        d.normals = of_corners(&normals, triangles);
        d.uvs = [
            if faces.corner_uvs.is_empty() {
                of_corners(&uvs, triangles)
            } else {
                faces.corner_uvs.as_flattened().to_vec()
            },
            Vec::new(),
        ];
        d.colors = if face_colors {
            faces.colors.iter().flat_map(|&c| [c; 3]).collect()
        } else {
            of_corners(&colors, triangles)
        };
        d.triangles = separate_triangles(triangles.len());
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MemoryResolver;
    use overcoat_core::limits::Limits;
    use overcoat_scene::PrimitiveKind;

    fn load_with(bytes: &[u8], limits: &Limits) -> Result<Loaded, LoadError> {
        let context = Context { resolver: &MemoryResolver::default(), limits, jobs: &Jobs::new(1) };
        load(bytes, &context, TextureLoading::Whole, &Shares::default())
    }

    fn load_bytes(bytes: impl AsRef<[u8]>) -> Result<Loaded, LoadError> {
        load_with(bytes.as_ref(), &Limits::default())
    }

    const TRIANGLE: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                            element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn binary(header: &str, body: &[&[u8]]) -> Vec<u8> {
        [header.as_bytes(), &body.concat()].concat()
    }

    #[test]
    fn every_encoding_and_type_reads_the_same() {
        let types = ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"];
        for scalar in types {
            let elements = format!(
                "element vertex 3\nproperty {scalar} x\nproperty {scalar} y\nproperty {scalar} z\n\
                 element face 1\nproperty list ushort {scalar} vertex_index\nend_header\n"
            );
            let values = [0, 0, 0, 2, 0, 0, 0, 3, 0];
            let encode = |v: i32, big: bool| -> Vec<u8> {
                let mut bytes = match scalar {
                    "char" | "uchar" => (v as u8).to_be_bytes().to_vec(),
                    "short" | "ushort" => (v as u16).to_be_bytes().to_vec(),
                    "int" | "uint" => v.to_be_bytes().to_vec(),
                    "float" => (v as f32).to_be_bytes().to_vec(),
                    _ => f64::from(v).to_be_bytes().to_vec(),
                };
                if !big {
                    bytes.reverse();
                }
                bytes
            };
            let body = |big: bool| -> Vec<u8> {
                let count = if big { [0, 3] } else { [3, 0] };
                let mut bytes: Vec<u8> = values.iter().flat_map(|&v| encode(v, big)).collect();
                bytes.extend(count);
                bytes.extend([0, 1, 2].iter().flat_map(|&v| encode(v, big)));
                bytes
            };
            let ascii =
                format!("ply\nformat ascii 1.0\n{elements}0 0 0\n2 0 0\n0 3 0\n3 0 1 2\n").into_bytes();
            let little =
                binary(&format!("ply\nformat binary_little_endian 1.0\n{elements}"), &[&body(false)]);
            let big = binary(&format!("ply\nformat binary_big_endian 1.0\n{elements}"), &[&body(true)]);
            for bytes in [ascii, little, big] {
                let loaded = load_bytes(bytes).unwrap();
                assert!(loaded.warnings.is_empty(), "{scalar}: {:?}", loaded.warnings);
                let mesh = &loaded.scene.meshes()[0];
                assert_eq!(mesh.positions(), [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]], "{scalar}");
                assert_eq!(mesh.triangles(), [[0, 1, 2]]);
            }
        }
    }

    #[test]
    fn numbers_beyond_an_item_are_no_part_of_the_next() {
        let text = format!("ply\nformat ascii 1.0\n{TRIANGLE}0 0 0 9\n1 0 0 9 9\n\n0 1 0\n3 0 1 2 7");
        let loaded = load_bytes(&text).unwrap();
        assert_eq!(loaded.scene.meshes()[0].positions(), [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        // Without lines it is one number after the other.
        let text = format!("ply\nformat ascii 1.0\n{TRIANGLE}0 0 0 1 0 0\n0 1\n0 3 0 1 2");
        assert_eq!(load_bytes(&text).unwrap().scene.triangle_count(), 1);
    }

    #[test]
    fn faces_may_come_first() {
        let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\n\
                    property float x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
        let loaded = load_bytes(text).unwrap();
        assert_eq!(loaded.scene.triangle_count(), 1);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }

    #[test]
    fn lines_end_in_three_ways() {
        for end in ["\n", "\r\n", "\r"] {
            let header =
                format!("ply\nformat binary_little_endian 1.0\ncomment\n{TRIANGLE}").replace('\n', end);
            // The first value looks like an end of line.
            let positions: Vec<u8> =
                [f32::from_le_bytes([10, 13, 10, 13]), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
                    .iter()
                    .flat_map(|v| v.to_le_bytes())
                    .collect();
            let loaded =
                load_bytes(binary(&header, &[&positions, &[3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]])).unwrap();
            assert_eq!(loaded.scene.triangle_count(), 1, "{end:?}");
        }
    }

    #[test]
    fn colours_of_codes_and_of_fractions_are_srgb() {
        let vertex = |scalar: &str, values: [&str; 3]| {
            let [a, b, c] = values;
            format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 property {scalar} red\nproperty {scalar} green\nproperty {scalar} blue\nelement face 1\n\
                 property list uchar int vertex_indices\nend_header\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n"
            )
        };
        let colors = |text: String| load_bytes(text).unwrap().scene.meshes()[0].colors().to_vec();
        let codes = colors(vertex("uchar", ["255 0 188", "0 0 0", "0 0 0"]));
        assert_eq!(codes[0][..2], [1.0, 0.0]);
        assert!((codes[0][2] - 0.503).abs() < 1e-3 && codes[0][3] == 1.0);
        let half = overcoat_core::color::srgb::srgb_to_linear(0.5);
        assert_eq!(colors(vertex("float", ["0.5 2 nan", "0 0 0", "0 0 0"]))[0], [half, 1.0, 0.0, 1.0]);
        assert_eq!(colors(vertex("ushort", ["65535 0 0", "0 0 0", "0 0 0"]))[0], [1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn coloured_faces_have_their_own_vertices_and_shared_normals() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n\
                    property uchar blue\nend_header\n0 0 0\n1 0 0\n1 1 0.1\n0 1 0\n3 0 1 2 255 0 0\n3 0 2 3 0 255 0\n";
        let loaded = load_bytes(text).unwrap();
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!(mesh.positions().len(), 6);
        assert_eq!(mesh.colors()[2], [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(mesh.colors()[3], [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(mesh.normals()[0], mesh.normals()[3]);
    }

    #[test]
    fn polygons_strips_and_coordinates() {
        let text = "ply\nformat ascii 1.0\ncomment TextureFile a b.png \nelement vertex 4\nproperty float x\n\
                    property float y\nproperty float z\nproperty float s\nproperty float t\nelement tristrips 1\n\
                    property list int int vertex_indices\nelement face 0\nend_header\n\
                    0 0 0 0 0.25\n1 0 0 1 0\n0 1 0 0 1\n1 1 0 1 1\n8 0 1 2 3 -1 0 1 2\n";
        let loaded = load_bytes(text).unwrap();
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!(mesh.triangles(), [[0, 1, 2], [2, 1, 3], [0, 1, 2]]);
        assert_eq!(mesh.uvs(0)[0], [0.0, 0.75]);
        assert_eq!(loaded.warnings.len(), 1);
        assert!(loaded.warnings[0].message.contains("'a b.png'"), "{:?}", loaded.warnings);
    }

    #[test]
    fn damage_is_an_error_that_names_the_element() {
        let ascii = format!("ply\nformat ascii 1.0\n{TRIANGLE}");
        for (bytes, message) in [
            (b"plx\n".to_vec(), "does not begin with 'ply'"),
            (
                b"ply\nformat ascii 1.0\nelement vertex 3\n".to_vec(),
                "line 4: the header ends without 'end_header'",
            ),
            (b"ply\nend_header\n".to_vec(), "no 'format' line"),
            (
                b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty odd x\n".to_vec(),
                "cannot be",
            ),
            (b"ply\nformat martian 1.0\nend_header\n".to_vec(), "unknown format 'martian'"),
            (b"ply\nformat ascii 1.0\nproperty float x\n".to_vec(), "'property float x' cannot be"),
            (b"ply\nformat ascii 1.0\nelement vertex -1\n".to_vec(), "cannot be"),
            (b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n".to_vec(), "no x, y and z"),
            (ascii.replace("vertex 3", "vertex 4000000000").into_bytes(), "exceeds the limit"),
        ] {
            let error = load_bytes(&bytes).unwrap_err().to_string();
            assert!(error.contains(message) && !error.contains('\n'), "{message}: {error}");
        }
    }

    #[test]
    fn damaged_values_cost_what_depends_on_them() {
        let ascii = format!("ply\nformat ascii 1.0\n{}", TRIANGLE.replace("face 1", "face 2"));
        let good = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        for (body, triangles, warning) in [
            (&format!("{good}3 0 1"), 1, "the file ends within element 'face', item 1 of 2"),
            (&format!("{good}3 0 1 1.5"), 1, "1 face left out"),
            (&format!("{good}-3 0 1 2"), 1, "1 face left out"),
            (&format!("{good}x"), 1, "1 face left out"),
            (&format!("{}3 0 1 2\n", good.replace("3 0 1 2", "3 zero 1 2")), 1, "1 face left out"),
            (&format!("{}3 0 1 2\n", good.replace("1 0 0", "1 -nan(ind) 0")), 0, "2 faces left out"),
            (&format!("{}3 0 1 2\n", good.replace("1 0 0", "1 x 0")), 0, "2 faces left out"),
        ] {
            let loaded = load_bytes(format!("{ascii}{body}")).unwrap();
            assert_eq!(loaded.scene.triangle_count(), triangles, "{body}");
            assert!(loaded.warnings[0].message.contains(warning), "{body}: {:?}", loaded.warnings);
        }
        // A mesh without a face cannot be drawn; a cloud is drawn with the points that exist. Claimed counts cost
        // nothing.
        let claims = ascii.replace("vertex 3", "vertex 40000000");
        for (text, message) in [
            (format!("{ascii}0 0 0 1 0 0 0 1"), "the file ends within element 'vertex', item 2 of 3"),
            (format!("{ascii}0 0 0 1 0 0 0 1 0"), "the file ends within element 'face', item 0 of 2"),
            (format!("{claims}{good}"), "the file ends within element 'vertex', item 4 of 40000000"),
        ] {
            let error = load_bytes(text).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
        let points = ascii.replace("face 2", "face 0") + "0 0 0 1 0 0 0 1";
        let warnings = load_bytes(points).unwrap().warnings;
        assert!(warnings[0].message.contains("ends within element 'vertex', item 2 of 3"), "{warnings:?}");
        let binary = |body: &[&[u8]]| {
            binary(
                &format!("ply\nformat binary_little_endian 1.0\n{}", TRIANGLE.replace("face 1", "face 2")),
                body,
            )
        };
        let corners: Vec<u8> =
            [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let face: Vec<u8> = [&[3_u8][..], &[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]].concat();
        for cut in [0, 1, 12] {
            let loaded = load_bytes(binary(&[&corners, &face, &face[..cut]])).unwrap();
            assert_eq!((loaded.scene.triangle_count(), loaded.warnings.len()), (1, 1), "{cut}");
        }
    }

    /// A triangle whose third corner is out of the way of its first two, so that what is behind the header is read aright.
    fn assert_triangle(bytes: impl AsRef<[u8]>, warnings: usize) {
        let loaded = load_bytes(bytes).unwrap();
        assert_eq!(loaded.warnings.len(), warnings, "{:?}", loaded.warnings);
        assert_eq!(loaded.scene.meshes()[0].positions(), [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
        assert_eq!(loaded.scene.meshes()[0].triangles(), [[0, 1, 2]]);
    }

    #[test]
    fn headers_as_programs_write_them() {
        let header = format!("ply\nformat ascii 1.0\n{TRIANGLE}");
        let body = "0 0 0\n2 0 0\n0 3 0\n3 0 1 2\n";
        let plain = header.clone() + body;
        for (from, to, warnings) in [
            ("ply\n", "\u{feff}ply\n", 0),
            ("ply\n", "PLY\r\n", 0),
            ("ply\n", "ply  \n", 0),
            ("ply\n", "ply\r", 0),
            ("end_header\n", "end_header\r\n", 0),
            ("element face", "comment\nComment of no use\nOBJ_INFO x\n\nelement face", 0),
            ("format ascii 1.0\n", "format ascii 1.0\nCreated by someone\ndate 2024-01-01\n", 1),
            ("property float x", "PROPERTY Float X", 0),
            ("element vertex 3", "Element Vertex 3", 0),
            ("property float y", "property float32_t y", 0),
            ("property float y", "property fixed y", 0),
            ("list uchar int vertex_indices", "LIST UChar Int32 Vertex_Index", 0),
            ("list uchar int vertex_indices", "list uint8 uint64 corners", 1),
            ("element vertex", "element face", 1),
        ] {
            let text = plain.replacen(from, to, 1);
            if to.starts_with("element face") {
                // No vertices at all.
                assert!(load_bytes(text).is_ok());
                continue;
            }
            assert_triangle(text, warnings);
        }
    }

    #[test]
    fn numbers_of_64_and_16_bits_and_longs_of_both_kinds() {
        let header = |extra: &str| {
            let list = "property list uchar int vertex_indices";
            let text =
                TRIANGLE.replace("property float z\n", &format!("property float z\nproperty {extra}\n"));
            let text = text.replace(list, "property list uchar int64 vertex_indices");
            format!("ply\nformat binary_little_endian 1.0\n{text}")
        };
        let corners = [[0.0_f32, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
        for (name, size) in
            [("int64", 8), ("UINT64", 8), ("long", 8), ("long", 4), ("ulong", 4), ("float16", 2)]
        {
            let mut bytes = header(&format!("{name} id")).into_bytes();
            for corner in corners {
                bytes.extend(corner.iter().flat_map(|v| v.to_le_bytes()));
                bytes.extend(std::iter::repeat_n(1, size));
            }
            bytes.push(3);
            bytes.extend([0_i64, 1, 2].iter().flat_map(|v| v.to_le_bytes()));
            assert_triangle(bytes, 0);
        }
    }

    #[test]
    fn vertices_that_are_no_numbers_cost_their_faces_only() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 2\nproperty list uchar int vertex_indices\nend_header\n\
                    -nan(ind) nan 1.#QNAN\n0 0 0\n1 0 0\n0 1 0\n3 1 2 3\n3 0 1 2\n";
        let loaded = load_bytes(text).unwrap();
        assert_eq!((loaded.scene.triangle_count(), loaded.warnings.len()), (1, 1), "{:?}", loaded.warnings);
    }

    #[test]
    fn fractions_above_2_are_codes() {
        let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                    property float red\nproperty float green\nproperty float blue\nproperty float alpha\nelement face 1\n\
                    property list uchar int vertex_indices\nend_header\n0 0 0 255 0 188 255\n1 0 0 0 0 0 255\n0 1 0 1 1 nan 255\n3 0 1 2\n";
        let loaded = load_bytes(text).unwrap();
        let colors = loaded.scene.meshes()[0].colors();
        assert!(colors[0][0] == 1.0 && (colors[0][2] - 0.503).abs() < 1e-3 && colors[0][3] == 1.0);
        assert!(colors[2][0] < 0.001 && colors[2][2] == 0.0);
    }

    #[test]
    fn what_can_be_drawn_is() {
        let ascii = format!("ply\nformat ascii 1.0\n{}", TRIANGLE.replace("face 1", "face 5"));
        let loaded =
            load_bytes(format!("{ascii}0 0 0 1 0 0 0 1 0 3 0 1 2 3 0 1 7 2 0 1 3 0 -1 2 4 0")).unwrap();
        assert_eq!(loaded.scene.triangle_count(), 1);
        assert_eq!(loaded.warnings.len(), 3, "{:?}", loaded.warnings);
        assert!(loaded.warnings[2].message.contains("ends within element 'face', item 4 of 5"));
        let points = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                      element thing 2\nproperty list uchar uint a\nproperty float b\nend_header\n1 2 3\n2 1 1 0.5\n0 1\n";
        let loaded = load_bytes(points).unwrap();
        assert_eq!(loaded.scene.meshes()[0].kind(), PrimitiveKind::Points);
        assert_eq!(loaded.scene.meshes()[0].primitive_count(), 1);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }

    #[test]
    fn vertices_without_faces_are_points() {
        let cloud = |properties: &str, values: &str| {
            let count = values.lines().count();
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
                 {properties}element face 0\nproperty list uchar int vertex_indices\nend_header\n{values}"
            );
            load_bytes(text).unwrap()
        };
        let loaded = cloud("property float intensity\n", "0 0 0 7\n0 nan 0 9\n1 0 0 8\n2 0 0 inf\n");
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!((mesh.kind(), mesh.primitive_count()), (PrimitiveKind::Points, 3));
        assert_eq!(mesh.positions(), [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        let [a, b, c] = [0, 1, 2].map(|k| mesh.colors()[k][0]);
        assert!(a < b && b == 1.0 && c == a, "{a} {b} {c}");
        assert!(loaded.warnings.len() == 1 && loaded.warnings[0].message.contains("1 point left out"));

        // The colour wins; among others the intensity.
        let loaded =
            cloud("property uchar label\nproperty float scalar_Intensity\n", "0 0 0 1 5\n1 0 0 2 3\n");
        let colors = loaded.scene.meshes()[0].colors();
        assert!(colors[0][0] > colors[1][0]);
        let rgb = "property uchar label\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n";
        let loaded = cloud(rgb, "0 0 0 1 255 0 0\n1 0 0 2 0 255 0\n");
        assert_eq!(loaded.scene.meshes()[0].colors(), [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]]);
        // Nothing to tell them apart: the default material.
        let loaded = cloud("property uchar label\n", "0 0 0 1\n1 0 0 1\n");
        assert!(loaded.scene.meshes()[0].colors().is_empty());
        // Faces that cannot be drawn do not make points of their vertices.
        let text = format!("ply\nformat ascii 1.0\n{TRIANGLE}0 0 0 1 0 0 0 1 0 3 0 1 7");
        assert!(load_bytes(text).unwrap().scene.meshes().is_empty());
    }

    #[test]
    fn splats_may_have_the_prefix_of_cloudcompare() {
        let names = [
            "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
            "rot_2", "rot_3",
        ];
        let file = |prefix: &str, rest: usize, more: &str| {
            let rest = (0..rest).map(|k| format!("f_rest_{k}"));
            let names = names.iter().map(|name| (*name).to_owned()).chain(rest);
            let properties: Vec<String> =
                names.map(|name| format!("property float {prefix}{name}\n")).collect();
            let values = "0.5 ".repeat(properties.len() + more.lines().count());
            format!(
                "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n{}{more}\
                 end_header\n1 2 3 {values}\n4 5 6 {values}\n",
                properties.concat()
            )
        };
        let plain = load_bytes(file("", 9, "")).unwrap();
        for prefix in ["scalar_", "Scalar_", "scal_"] {
            let loaded = load_bytes(file(prefix, 9, "property float scalar_error\n")).unwrap();
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            assert_eq!(loaded.scene.splats(), plain.scene.splats(), "{prefix}");
            assert_eq!(loaded.scene.splat_count(), 2);
        }
        // Other clouds stay clouds.
        let cloud = file("scalar_", 0, "").replace("scalar_f_dc_0", "scalar_other");
        assert_eq!(load_bytes(cloud).unwrap().scene.splat_count(), 0);
    }

    #[test]
    fn normals_of_zeros_are_none() {
        let file = |normals: [&str; 4], faces: &str| {
            let vertices: Vec<String> = normals
                .iter()
                .zip(["0 0 0", "1 0 0", "0 1 0", "1 1 0"])
                .map(|(n, p)| format!("{p} {n}"))
                .collect();
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                 property float nx\nproperty float ny\nproperty float nz\nelement face {}\n\
                 property list uchar int vertex_indices\nend_header\n{}\n{faces}",
                faces.lines().count(),
                vertices.join("\n"),
            );
            let loaded = load_bytes(text).unwrap();
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            loaded.scene.meshes()[0].normals().to_vec()
        };
        assert!(file(["0 0 0", "nan nan nan", "0 0 0", "-0 0 0"], "").is_empty());
        // If some have normals, the renderer finds the others.
        let some = ["1 0 0", "nan 0 0", "0 0 0", "1 0 0"];
        assert_eq!(file(some, ""), [[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]]);
        let up = [0.0, 0.0, 1.0];
        let faces = "3 0 1 2\n3 1 3 2\n";
        assert_eq!(file(["0 0 0"; 4], faces), [up; 4]);
        assert_eq!(file(some, faces), [[1.0, 0.0, 0.0], up, up, [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn lists_that_claim_too_much_cost_nothing() {
        let header =
            format!("ply\nformat binary_little_endian 1.0\n{}", TRIANGLE.replace("uchar int", "uint uint"));
        let error = load_bytes(binary(&header, &[&[0; 36], &[255; 4], &[0; 12]])).unwrap_err().to_string();
        assert!(error.contains("ends within element 'face', item 0 of 1"), "{error}");
        let limits = Limits::default().with_vertices(2);
        let ascii = format!("ply\nformat ascii 1.0\n{TRIANGLE}0 0 0 1 0 0 0 1 0 3 0 1 2");
        assert!(matches!(load_with(ascii.as_bytes(), &limits), Err(LoadError::Limit(_))));
    }
}
