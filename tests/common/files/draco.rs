//! Draco streams.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder,
    PointAttribute, PointIndex,
};
use overcoat::scene::MeshData;

/// A mesh as a stream: positions, normals and texture coordinates have the numbers 0, 1 and 2. Method 0 is sequential,
/// 1 edgebreaker; `bits` of 0 leaves floats as they are.
pub fn stream(mesh: &MeshData, method: i32, speed: i32, bits: i32) -> Vec<u8> {
    let count = mesh.positions.len();
    let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut points = Mesh::new();
    points.set_num_points(count);
    for (kind, components, values) in [
        (GeometryAttributeType::Position, 3, bytes(mesh.positions.as_flattened())),
        (GeometryAttributeType::Normal, 3, bytes(mesh.normals.as_flattened())),
        (GeometryAttributeType::TexCoord, 2, bytes(mesh.uvs[0].as_flattened())),
    ] {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, components, DataType::Float32, false, count);
        attribute.buffer_mut().write(0, &values);
        points.add_attribute(attribute);
    }
    for (k, corners) in mesh.triangles.iter().enumerate() {
        points.set_face(FaceIndex(k as u32), corners.map(PointIndex));
    }
    let mut options = EncoderOptions::new();
    options.set_encoding_method(method);
    options.set_global_int("encoding_speed", speed);
    options.set_global_int("decoding_speed", speed);
    if bits > 0 {
        for attribute in 0..3 {
            options.set_attribute_quantization(attribute, bits);
        }
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(points);
    let mut out = EncoderBuffer::new();
    encoder.encode(&options, &mut out).expect("the mesh can be encoded");
    out.data().to_vec()
}
