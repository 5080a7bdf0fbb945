//! KHR_draco_mesh_compression: triangles and vertex attributes of a primitive in one Draco stream.
//!
//! The stream is decoded to arrays as accessors have them; what the accessors of such a primitive say about their own
//! data does not matter, except for what the numbers stand for.

use super::accessor::{Component, Elements};
use super::list::Index;
use super::model::Kind;
#[cfg(feature = "compression")]
use draco_core::{DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute};

/// Bytes of all attributes of a point that are allowed: twice what a vertex can have that a picture shows.
pub(super) const POINT_BYTES: u64 = 240;

/// Bytes that decoding takes for a while, for each triangle: the tables of what is next to what, of the positions and
/// of each attribute with seams of its own.
pub(super) const TRIANGLE_BYTES: u64 = 400;

/// Contents of a decoded Draco stream.
#[derive(Debug)]
pub(super) struct Decoded {
    /// Number of vertices.
    pub points: usize,
    attributes: Vec<Attribute>,
}

#[derive(Debug)]
struct Attribute {
    id: Index,
    kind: Kind,
    component: Component,
    /// One element after the other.
    bytes: Vec<u8>,
}

/// Most triangles and points that a stream may have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Most {
    pub triangles: u64,
    pub points: u64,
}

/// Refuses the stream.
///
/// # Errors
/// Always.
#[cfg(not(feature = "compression"))]
pub(super) fn decode(_: &[u8], _: Most, _: &[Index]) -> Result<(Vec<[u32; 3]>, Decoded), String> {
    Err(format!("its data are compressed with Draco: {}", overcoat_core::formats::LEFT_OUT))
}

/// Decodes the triangles, and the attributes with the numbers `ids`.
///
/// # Errors
/// What is wrong with the stream.
#[cfg(feature = "compression")]
pub(super) fn decode(stream: &[u8], most: Most, ids: &[Index]) -> Result<(Vec<[u32; 3]>, Decoded), String> {
    let limits = DecodeLimits::default()
        .with_max_faces(most.triangles)
        .with_max_points(most.points)
        .with_max_decoded_bytes(most.points.saturating_mul(POINT_BYTES));
    let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(|error| match error.kind() {
        ErrorKind::LimitExceeded => "its Draco data holds more than its accessors say".to_owned(),
        _ => format!("its Draco data is damaged: {error}"),
    })?;
    let points = mesh.num_points();
    // Draco leaves degenerate triangles out, so there may be fewer than the accessor says; and an attribute that tears
    // a vertex apart makes more points of it.
    if mesh.num_faces() as u64 > most.triangles || points as u64 > most.points {
        return Err("its Draco data holds more than its accessors say".to_owned());
    }
    let triangles = mesh.faces().iter().map(|face| face.map(|point| point.0)).collect();
    let mut attributes: Vec<Attribute> = Vec::new();
    for &id in ids {
        if attributes.iter().any(|known| known.id == id) {
            continue;
        }
        let found = mesh.attribute_by_unique_id(id.0);
        let found = found.ok_or_else(|| format!("its Draco data has no attribute {id}"))?;
        let attribute = read(found, id, points);
        attributes.push(attribute.ok_or_else(|| format!("attribute {id} of its Draco data cannot be used"))?);
    }
    Ok((triangles, Decoded { points, attributes }))
}

/// An attribute with one element for each point. `None` for those of numbers that accessors do not know, and for those
/// that leave a point without.
#[cfg(feature = "compression")]
fn read(attribute: &PointAttribute, id: Index, points: usize) -> Option<Attribute> {
    let component = match attribute.data_type() {
        DataType::Int8 => Component::I8,
        DataType::Uint8 => Component::U8,
        DataType::Int16 => Component::I16,
        DataType::Uint16 => Component::U16,
        DataType::Uint32 => Component::U32,
        DataType::Float32 => Component::F32,
        _ => return None,
    };
    let kind = match attribute.num_components() {
        1 => Kind::Scalar,
        2 => Kind::Vec2,
        3 => Kind::Vec3,
        4 => Kind::Vec4,
        _ => return None,
    };
    let size = component.element(kind.components())?.get();
    let all = size.checked_mul(points)?;
    let stride = usize::try_from(attribute.byte_stride()).ok()?;
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(all);
    match attribute.explicit_mapping() {
        None if stride == size => bytes.extend_from_slice(data.get(..all)?),
        map => {
            for point in 0..points {
                let value = match map {
                    Some(map) => map.get(point)?.0 as usize,
                    None => point,
                };
                let start = value.checked_mul(stride)?;
                bytes.extend_from_slice(data.get(start..)?.get(..size)?);
            }
        }
    }
    Some(Attribute { id, kind, component, bytes })
}

impl Decoded {
    /// The elements of the attribute with this number; `normalized` as their accessor says.
    pub(super) fn elements(&self, id: Index, normalized: bool) -> Option<Elements<'_>> {
        let found = self.attributes.iter().find(|known| known.id == id)?;
        Elements::of_array(&found.bytes, self.points, found.kind, found.component, normalized)
    }
}
