//! Files of records, in both encodings.

use base64::Engine as _;
use flate2::Compression;
use flate2::read::ZlibEncoder;
use std::io::Read as _;

/// A value to be written.
#[derive(Clone, Debug)]
pub(super) enum V {
    I(i64),
    D(f64),
    S(String),
    R(Vec<u8>),
    Floats(Vec<f64>),
    Integers(Vec<i32>),
}

/// A record to be written.
#[derive(Clone, Debug)]
pub(super) struct R(pub(super) &'static str, pub(super) Vec<V>, pub(super) Vec<Self>);

pub(super) fn s(text: &str) -> V {
    V::S(text.to_owned())
}

/// A record with one value.
pub(super) fn one(name: &'static str, value: V) -> R {
    R(name, vec![value], vec![])
}

pub(super) fn floats(name: &'static str, values: &[f64]) -> R {
    one(name, V::Floats(values.to_vec()))
}

pub(super) fn integers(name: &'static str, values: &[i32]) -> R {
    one(name, V::Integers(values.to_vec()))
}

/// A property with numbers.
pub(super) fn p(name: &str, values: &[f64]) -> R {
    let mut all = vec![s(name), s("double"), s("Number"), s("A")];
    all.extend(values.iter().map(|v| V::D(*v)));
    R("P", all, vec![])
}

pub(super) fn properties(list: Vec<R>) -> R {
    R("Properties70", vec![], list)
}

/// An object: kind, number, name and class.
pub(super) fn object(kind: &'static str, id: i64, name: &str, class: &str, records: Vec<R>) -> R {
    R(kind, vec![V::I(id), s(&format!("{name}\0\u{1}{kind}")), s(class)], records)
}

pub(super) fn model(id: i64, name: &str, list: Vec<R>) -> R {
    object("Model", id, name, "Mesh", vec![properties(list)])
}

pub(super) fn connection(from: i64, to: i64) -> R {
    R("C", vec![s("OO"), V::I(from), V::I(to)], vec![])
}

pub(super) fn to_property(from: i64, to: i64, name: &str) -> R {
    R("C", vec![s("OP"), V::I(from), V::I(to), s(name)], vec![])
}

pub(super) fn layer(name: &'static str, mapping: &str, reference: &str, records: Vec<R>) -> R {
    let mut all =
        vec![one("MappingInformationType", s(mapping)), one("ReferenceInformationType", s(reference))];
    all.extend(records);
    R(name, vec![V::I(0)], all)
}

pub(super) const SQUARE: [f64; 12] = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 2.0, 0.0];

/// A square with more records.
pub(super) fn square(id: i64, more: Vec<R>) -> R {
    let mut records = vec![floats("Vertices", &SQUARE), integers("PolygonVertexIndex", &[0, 1, 2, !3])];
    records.extend(more);
    object("Geometry", id, "square", "Mesh", records)
}

pub(super) fn normals_and_uvs() -> Vec<R> {
    let up: Vec<f64> = (0..4).flat_map(|_| [0.0, 0.0, 1.0]).collect();
    vec![
        layer("LayerElementNormal", "ByPolygonVertex", "Direct", vec![floats("Normals", &up)]),
        layer(
            "LayerElementUV",
            "ByPolygonVertex",
            "IndexToDirect",
            vec![
                one("Name", s("first")),
                floats("UV", &[0.0, 0.0, 1.0, 0.0, 1.0, 0.25]),
                integers("UVIndex", &[0, 1, 2, 0]),
            ],
        ),
        layer("LayerElementMaterial", "AllSame", "IndexToDirect", vec![integers("Materials", &[0])]),
    ]
}

/// A file of settings, objects and connections. Units are metres, if nothing else is said.
pub(super) fn file(settings: Vec<R>, objects: Vec<R>, connections: Vec<R>) -> Vec<R> {
    let mut all = vec![p("UnitScaleFactor", &[100.0])];
    all.extend(settings);
    vec![
        R("FBXHeaderExtension", vec![], vec![one("FBXVersion", V::I(7400)), one("Creator", s("test"))]),
        R("GlobalSettings", vec![], vec![properties(all)]),
        R("Objects", vec![], objects),
        R("Connections", vec![], connections),
    ]
}

pub(super) fn plain() -> Vec<R> {
    let material =
        object("Material", 3, "red", "", vec![properties(vec![p("DiffuseColor", &[0.5, 0.0, 0.0])])]);
    file(
        vec![],
        vec![square(1, normals_and_uvs()), model(2, "thing", vec![]), material],
        vec![connection(2, 0), connection(1, 2), connection(3, 2)],
    )
}

/// The bytes of a binary file; `packed` ones have arrays compressed.
pub(super) fn binary(records: &[R], version: u32, packed: bool) -> Vec<u8> {
    let mut out = b"Kaydara FBX Binary  \0\x1a\0".to_vec();
    out.extend(version.to_le_bytes());
    let wide = version >= 7500;
    records.iter().for_each(|record| write(record, wide, packed, &mut out));
    out.extend(vec![0; if wide { 25 } else { 13 }]);
    out
}

pub(super) fn write(R(name, values, records): &R, wide: bool, packed: bool, out: &mut Vec<u8>) {
    let start = out.len();
    let number =
        |v: usize| if wide { (v as u64).to_le_bytes().to_vec() } else { (v as u32).to_le_bytes().to_vec() };
    let mut list = Vec::new();
    values.iter().for_each(|value| list.extend(bytes_of(value, packed)));
    out.extend([number(0), number(values.len()), number(list.len()), vec![name.len() as u8]].concat());
    out.extend(name.as_bytes());
    out.extend(list);
    if !records.is_empty() {
        records.iter().for_each(|record| write(record, wide, packed, out));
        out.extend(vec![0; if wide { 25 } else { 13 }]);
    }
    let end = number(out.len());
    out[start..start + end.len()].copy_from_slice(&end);
}

pub(super) fn bytes_of(value: &V, packed: bool) -> Vec<u8> {
    let text = |kind: u8, bytes: &[u8]| [&[kind], &(bytes.len() as u32).to_le_bytes()[..], bytes].concat();
    let array = |kind: u8, count: usize, bytes: Vec<u8>| {
        let mut data = bytes;
        if packed {
            let plain = std::mem::take(&mut data);
            ZlibEncoder::new(&plain[..], Compression::fast()).read_to_end(&mut data).unwrap();
        }
        let head = [count as u32, u32::from(packed), data.len() as u32].map(u32::to_le_bytes).concat();
        [vec![kind], head, data].concat()
    };
    match value {
        V::I(v) => [&b"L"[..], &v.to_le_bytes()].concat(),
        V::D(v) => [&b"D"[..], &v.to_le_bytes()].concat(),
        V::S(v) => text(b'S', v.as_bytes()),
        V::R(v) => text(b'R', v),
        V::Floats(v) => array(b'd', v.len(), v.iter().flat_map(|v| v.to_le_bytes()).collect()),
        V::Integers(v) => array(b'i', v.len(), v.iter().flat_map(|v| v.to_le_bytes()).collect()),
    }
}

/// The text of a file.
pub(super) fn text(records: &[R]) -> String {
    let mut out = "; FBX 7.4.0 project file\n; ---\n".to_owned();
    records.iter().for_each(|record| lines(record, &mut out));
    out
}

pub(super) fn lines(R(name, values, records): &R, out: &mut String) {
    let list = |values: Vec<String>| format!("*{} {{\n a: {}\n}}", values.len(), values.join(","));
    let shown: Vec<String> = values
        .iter()
        .map(|value| match value {
            V::I(v) => v.to_string(),
            V::D(v) => v.to_string(),
            V::S(v) => match v.split_once("\0\u{1}") {
                Some((name, class)) => format!("\"{class}::{name}\""),
                None => format!("\"{}\"", v.replace('"', "&quot;")),
            },
            V::R(v) => format!("\n\"{}\"", base64::engine::general_purpose::STANDARD.encode(v)),
            V::Floats(v) => list(v.iter().map(f64::to_string).collect()),
            V::Integers(v) => list(v.iter().map(i32::to_string).collect()),
        })
        .collect();
    *out += &format!("{name}: {}", shown.join(", "));
    if !records.is_empty() || values.is_empty() {
        *out += " {\n";
        records.iter().for_each(|record| lines(record, out));
        *out += "}";
    }
    *out += "\n";
}
