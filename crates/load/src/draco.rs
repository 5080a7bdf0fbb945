//! DRC, a Draco stream that is a file of its own (Google, *Draco Bitstream Specification*, version 2.2): a mesh, or a cloud of points.
//!
//! Positions, normals and colours are drawn; colours are sRGB, as in the files that such streams are made of. What else a stream
//! has (coordinates of textures, numbers of materials) has no effect, since there are no textures or materials with it.

use super::mesh_formats::{
    add_object, check_input, check_mesh, default_material, drawable, finish, white_material,
};
use super::normals::add_smooth_normals;
use super::point_clouds::{Points, add};
use super::warnings::{Warnings, counted};
use super::{Context, LoadError, Loaded};
use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, ErrorKind, GeometryAttributeType, Mesh, MeshDecoder,
    PointAttribute,
};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_scene::{AlphaMode, CREASE_ANGLE, MeshData, Scene};

const FORMAT: &str = "DRC";
/// Bytes that decoding takes for a while, for each triangle: tables of neighbours.
const TRIANGLE_BYTES: u64 = 400;
/// Bytes of the attributes of a point that are drawn, and what they become.
const POINT_BYTES: u64 = 80;

/// Reads a file.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mesh = decode(FORMAT, bytes, context)?;
    let mut warnings = Warnings::default();
    let points = mesh.num_points();
    let named = |kind| mesh.named_attribute(kind);
    let Some(positions) = named(GeometryAttributeType::Position).filter(|a| a.num_components() == 3) else {
        return Err(LoadError::malformed(FORMAT, "there are no positions of three numbers"));
    };
    let positions = triples(positions, points);
    let normals = named(GeometryAttributeType::Normal).filter(|a| a.num_components() == 3);
    let normals = normals.map(|attribute| triples(attribute, points)).unwrap_or_default();
    let colors = named(GeometryAttributeType::Color).and_then(|attribute| colors(attribute, points));
    let colors = colors.unwrap_or_default();
    let mut scene = Scene::new();
    if mesh.num_faces() == 0 {
        let points = Points { positions, normals, colors, ..Points::default() };
        add(&mut scene, FORMAT, points, 0, &mut warnings)?;
        return Ok(finish(scene, warnings.finish()));
    }
    let mut data = MeshData::new(positions, Vec::new());
    (data.normals, data.colors) = (normals, colors);
    let there = |v: &u32| data.positions.get(*v as usize).is_some_and(|&p| drawable(p));
    let faces = mesh.faces().iter().map(|face| face.map(|point| point.0));
    data.triangles = faces.filter(|triangle| triangle.iter().all(there)).collect();
    let lost = mesh.num_faces().saturating_sub(data.triangles.len());
    if lost > 0 {
        let lost = counted(lost as u64, "triangle");
        warnings.add(|| format!("{FORMAT}: {lost} left out: vertices missing, not finite or beyond 1e15"));
    }
    data.positions.iter_mut().filter(|p| !drawable(**p)).for_each(|p| *p = [0.0; 3]);
    if data.triangles.is_empty() {
        return Ok(finish(scene, warnings.finish()));
    }
    data.normals.iter_mut().filter(|n| n.iter().any(|v| !v.is_finite())).for_each(|n| *n = [0.0; 3]);
    if data.normals.iter().flatten().all(|&v| v == 0.0) {
        add_smooth_normals(&mut data, CREASE_ANGLE, context.jobs);
    }
    let mut material = if data.colors.is_empty() { default_material() } else { white_material() };
    if data.colors.iter().any(|c| c[3] > 0.0) && data.colors.iter().any(|c| c[3] < 1.0) {
        material.alpha_mode = AlphaMode::Blend;
    } else {
        data.colors.iter_mut().for_each(|c| c[3] = 1.0);
    }
    let material = scene.add_material(material).map_err(LoadError::scene("DRC: material"))?;
    add_object(&mut scene, "DRC: mesh", data, material, 0)?;
    Ok(finish(scene, warnings.finish()))
}

/// Decodes a stream in a file of a format, within the limits.
pub(super) fn decode(format: &'static str, bytes: &[u8], context: &Context<'_>) -> Result<Mesh, LoadError> {
    let limits = context.limits;
    let decoded = limits.decoded_bytes;
    let bounds = DecodeLimits::default()
        .with_max_faces(limits.triangles.min(decoded / TRIANGLE_BYTES))
        .with_max_points(limits.vertices.min(decoded / POINT_BYTES))
        .with_max_decoded_bytes(decoded / 2);
    let mut buffer = DecoderBuffer::new(bytes).with_limits(bounds);
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(|error| match error.kind() {
        ErrorKind::LimitExceeded => LoadError::malformed(
            format,
            "it holds more than the limits of triangles, vertices and bytes allow",
        ),
        _ => LoadError::malformed(format, format!("the Draco stream is damaged: {error}")),
    })?;
    check_mesh(context, mesh.num_faces() as u64, mesh.num_points() as u64)?;
    Ok(mesh)
}

/// An attribute of three numbers, a value for each point.
pub(super) fn triples(attribute: &PointAttribute, points: usize) -> Vec<[f32; 3]> {
    attribute.read_f32s(points, 3).as_chunks().0.to_vec()
}

/// Linear colours of an attribute of one, three or four sRGB codes; `None` for what is none.
pub(super) fn colors(attribute: &PointAttribute, points: usize) -> Option<Vec<[f32; 4]>> {
    let count = attribute.num_components();
    let range = match attribute.data_type() {
        DataType::Uint8 => 255.0,
        DataType::Uint16 => 65535.0,
        DataType::Float32 => 1.0,
        _ => return None,
    };
    let part = |v: f32| {
        let part = v / range;
        if part > 0.0 { if part < 1.0 { part } else { 1.0 } } else { 0.0 }
    };
    let linear = |v: f32| if range == 255.0 { srgb8_to_linear(v as u8) } else { srgb_to_linear(part(v)) };
    let values = attribute.read_f32s(points, count.into());
    let of = |code: &[f32]| match *code {
        [v] => Some([linear(v), linear(v), linear(v), 1.0]),
        [r, g, b] => Some([linear(r), linear(g), linear(b), 1.0]),
        [r, g, b, a] => Some([linear(r), linear(g), linear(b), part(a)]),
        _ => None,
    };
    values.chunks_exact(usize::from(count).max(1)).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Format;
    use crate::hostile::{attack, load, warnings};
    use draco_core::{
        EncoderBuffer, EncoderOptions, FaceIndex, MeshEncoder, PointCloud, PointCloudEncoder, PointIndex,
    };

    /// An attribute of a value for each point.
    fn attribute(kind: GeometryAttributeType, count: u8, of: DataType, bytes: &[u8]) -> PointAttribute {
        let mut attribute = PointAttribute::new();
        let points = bytes.len() / (usize::from(count) * of.byte_length());
        attribute.init(kind, count, of, of == DataType::Uint8, points);
        attribute.buffer_mut().update(bytes, None);
        attribute
    }

    fn floats(values: &[[f32; 3]]) -> Vec<u8> {
        values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    fn fill(cloud: &mut PointCloud, with_colors: bool) {
        cloud.set_num_points(4);
        cloud.add_attribute(attribute(
            GeometryAttributeType::Position,
            3,
            DataType::Float32,
            &floats(&SQUARE),
        ));
        if with_colors {
            let codes = [255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 255];
            cloud.add_attribute(attribute(GeometryAttributeType::Color, 4, DataType::Uint8, &codes));
        }
    }

    fn mesh(method: i32, with_colors: bool) -> Vec<u8> {
        let mut mesh = Mesh::new();
        fill(&mut mesh, with_colors);
        mesh.set_num_faces(2);
        mesh.set_face(FaceIndex(0), [0, 1, 2].map(PointIndex));
        mesh.set_face(FaceIndex(1), [0, 2, 3].map(PointIndex));
        let mut options = EncoderOptions::new();
        options.set_global_int("encoding_method", method);
        options.set_attribute_int(0, "quantization_bits", 14);
        let mut encoder = MeshEncoder::new();
        encoder.set_mesh(mesh);
        let mut out = EncoderBuffer::new();
        encoder.encode(&options, &mut out).unwrap();
        out.data().to_vec()
    }

    fn cloud() -> Vec<u8> {
        let mut cloud = PointCloud::new();
        fill(&mut cloud, true);
        let mut encoder = PointCloudEncoder::new();
        encoder.set_point_cloud(cloud);
        let mut out = EncoderBuffer::new();
        encoder.encode(&EncoderOptions::new(), &mut out).unwrap();
        out.data().to_vec()
    }

    #[test]
    fn meshes_and_clouds_are_drawn_in_their_colors() {
        for method in [0, 1] {
            let bytes = mesh(method, true);
            assert_eq!(Format::detect(&bytes), Some(Format::Draco));
            let loaded = load(&bytes, Format::Draco).unwrap();
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            let mesh = &loaded.scene.meshes()[0];
            assert_eq!(loaded.scene.triangle_count(), 2);
            let red = mesh.colors().iter().position(|c| *c == [1.0, 0.0, 0.0, 1.0]).unwrap();
            assert!(mesh.positions()[red].iter().all(|v| v.abs() < 1e-3));
            assert!(mesh.normals().iter().all(|n| n[2] > 0.99), "{:?}", mesh.normals());
            attack(&bytes, Format::Draco);
        }
        let loaded = load(&cloud(), Format::Draco).unwrap();
        assert!(warnings(&loaded).is_empty());
        assert_eq!(loaded.scene.meshes()[0].positions().len(), 4);
        assert_eq!(loaded.scene.meshes()[0].colors().len(), 4);
        attack(&cloud(), Format::Draco);
    }

    #[test]
    fn meshes_without_colors_are_clay() {
        let loaded = load(&mesh(0, false), Format::Draco).unwrap();
        assert!(loaded.scene.meshes()[0].colors().is_empty());
        let error = load(b"DRACO\x02\x02", Format::Draco).unwrap_err().to_string();
        assert!(error.contains("DRC: the Draco stream is damaged"), "{error}");
    }
}
