//! Binary files that are written here: compressed by blocks that copy, and integers that are all written out.

use super::{SQUARE, corners, file, warnings};
use crate::Format;
use crate::hostile::{attack, load};

/// A file in the making.
struct Writer {
    version: [u8; 3],
    tokens: Vec<String>,
    /// Index of the path above, token, whether it is a property.
    paths: Vec<(usize, usize, bool)>,
    fields: Vec<(u32, u64)>,
    sets: Vec<u32>,
    /// Path, set, kind.
    specs: Vec<[u32; 3]>,
    bytes: Vec<u8>,
}

const INLINED: u64 = 1 << 62;
const ARRAY: u64 = 1 << 63;
const COMPRESSED: u64 = 1 << 61;

/// A block of LZ4 that has no matches.
fn copied(bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![0];
    match bytes.len() {
        length @ 0..15 => out.push((length as u8) << 4),
        length => {
            out.push(0xf0);
            out.extend(vec![255; (length - 15) / 255]);
            out.push(((length - 15) % 255) as u8);
        }
    }
    out.extend(bytes);
    out
}

/// Integers as differences of four bytes each.
fn coded(integers: &[u32]) -> Vec<u8> {
    let mut plain = 7_i32.to_le_bytes().to_vec();
    plain.extend(vec![0xff; integers.len().div_ceil(4)]);
    let mut last = 0_u32;
    for &integer in integers {
        plain.extend(integer.wrapping_sub(last).to_le_bytes());
        last = integer;
    }
    let packed = copied(&plain);
    [&(packed.len() as u64).to_le_bytes()[..], &packed].concat()
}

impl Writer {
    fn new(version: [u8; 3]) -> Self {
        Self {
            version,
            // A negative index of zero cannot mark a property.
            tokens: vec![";-)".to_owned()],
            paths: vec![(0, 0, false)],
            fields: Vec::new(),
            sets: Vec::new(),
            specs: Vec::new(),
            bytes: vec![0; 88],
        }
    }

    fn token(&mut self, text: &str) -> u64 {
        let found = self.tokens.iter().position(|token| token == text);
        found.unwrap_or_else(|| {
            self.tokens.push(text.to_owned());
            self.tokens.len() - 1
        }) as u64
    }

    fn token_value(&mut self, text: &str) -> u64 {
        self.token(text) | INLINED | 11 << 48
    }

    /// Writes values; gives their place.
    fn written(&mut self, kind: u64, bytes: &[u8]) -> u64 {
        let place = self.bytes.len() as u64;
        self.bytes.extend(bytes);
        place | kind << 48
    }

    fn count(&self, count: usize) -> Vec<u8> {
        match self.version {
            version if version < [0, 5, 0] => [1_u32.to_le_bytes(), (count as u32).to_le_bytes()].concat(),
            version if version < [0, 7, 0] => (count as u32).to_le_bytes().to_vec(),
            _ => (count as u64).to_le_bytes().to_vec(),
        }
    }

    fn floats(&mut self, kind: u64, width: usize, values: &[f32]) -> u64 {
        let mut bytes = self.count(values.len() / width);
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        self.written(kind, &bytes) | ARRAY
    }

    fn ints(&mut self, values: &[u32]) -> u64 {
        let mut bytes = self.count(values.len());
        if values.len() < 16 || self.version < [0, 5, 0] {
            bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
            return self.written(3, &bytes) | ARRAY;
        }
        bytes.extend(coded(values));
        self.written(3, &bytes) | ARRAY | COMPRESSED
    }

    fn path(&mut self, parent: usize, name: &str, is_property: bool) -> usize {
        let token = self.token(name) as usize;
        self.paths.push((parent, token, is_property));
        self.paths.len() - 1
    }

    fn spec(&mut self, path: usize, kind: u32, fields: &[(&str, u64)]) {
        self.specs.push([path as u32, self.sets.len() as u32, kind]);
        for (name, rep) in fields {
            let name = self.token(name) as u32;
            self.sets.push(self.fields.len() as u32);
            self.fields.push((name, *rep));
        }
        self.sets.push(u32::MAX);
    }

    /// A prim of a type, and its path.
    fn prim(&mut self, parent: usize, name: &str, type_name: &str, more: &[(&str, u64)]) -> usize {
        let path = self.path(parent, name, false);
        let kind = self.token_value(type_name);
        self.spec(path, 6, &[&[("specifier", INLINED | 42 << 48), ("typeName", kind)], more].concat());
        path
    }

    fn attribute(&mut self, prim: usize, name: &str, fields: &[(&str, u64)]) {
        let path = self.path(prim, name, true);
        self.spec(path, 1, fields);
    }

    /// Paths in depth first, and jumps: -2 ends, -1 has a child only, 0 a sibling only.
    fn tree(&self, index: usize, is_last: bool, out: &mut Vec<[u32; 3]>) {
        let (_, token, is_property) = self.paths[index];
        let below: Vec<usize> = (1..self.paths.len()).filter(|&k| self.paths[k].0 == index).collect();
        let place = out.len();
        let name = if is_property { -(token as i32) } else { token as i32 };
        out.push([index as u32, name as u32, 0]);
        for (k, &child) in below.iter().enumerate() {
            self.tree(child, k + 1 == below.len(), out);
        }
        let jump = match (below.is_empty(), is_last) {
            (true, true) => -2,
            (true, false) => 0,
            (false, true) => -1,
            (false, false) => (out.len() - place) as i32,
        };
        out[place][2] = jump as u32;
    }

    fn finish(mut self) -> Vec<u8> {
        let long = |v: usize| (v as u64).to_le_bytes().to_vec();
        let text: Vec<u8> = self.tokens.iter().flat_map(|t| [t.as_bytes(), b"\0"].concat()).collect();
        let packed = copied(&text);
        let tokens = [long(self.tokens.len()), long(text.len()), long(packed.len()), packed].concat();
        let names: Vec<u32> = self.fields.iter().map(|field| field.0).collect();
        let reps = copied(&self.fields.iter().flat_map(|field| field.1.to_le_bytes()).collect::<Vec<u8>>());
        let fields = [long(names.len()), coded(&names), long(reps.len()), reps].concat();
        let sets = [long(self.sets.len()), coded(&self.sets)].concat();
        let mut tree = Vec::new();
        self.tree(0, true, &mut tree);
        let column =
            |list: &[[u32; 3]], k: usize| coded(&list.iter().map(|item| item[k]).collect::<Vec<_>>());
        let three = |list: &[[u32; 3]]| [0, 1, 2].map(|k| column(list, k)).concat();
        let paths = [long(tree.len()), long(tree.len()), three(&tree)].concat();
        let specs = [long(self.specs.len()), three(&self.specs)].concat();
        let all: Vec<u32> = (0..self.tokens.len() as u32).collect();
        let strings = [long(all.len()), all.iter().flat_map(|v| v.to_le_bytes()).collect()].concat();
        let mut contents = Vec::new();
        for (name, bytes) in [
            ("TOKENS", tokens),
            ("STRINGS", strings),
            ("FIELDS", fields),
            ("FIELDSETS", sets),
            ("PATHS", paths),
            ("SPECS", specs),
        ] {
            let mut head = name.as_bytes().to_vec();
            head.resize(16, 0);
            contents.extend([head, long(self.bytes.len()), long(bytes.len())].concat());
            self.bytes.extend(bytes);
        }
        let place = self.bytes.len() as u64;
        self.bytes.extend(long(6));
        self.bytes.extend(contents);
        self.bytes[..8].copy_from_slice(b"PXR-USDC");
        self.bytes[8..11].copy_from_slice(&self.version);
        self.bytes[16..24].copy_from_slice(&place.to_le_bytes());
        self.bytes
    }
}

/// The square of the texts, moved by (3, 0, 0) and turned by 90 degrees.
fn square(version: [u8; 3]) -> Vec<u8> {
    let mut file = Writer::new(version);
    let unit = u64::from(1.0_f32.to_bits()) | INLINED | 9 << 48;
    file.spec(0, 7, &[("metersPerUnit", unit)]);
    let mesh = file.prim(0, "Square", "Mesh", &[]);
    let scheme = file.token_value("none");
    file.attribute(mesh, "subdivisionScheme", &[("default", scheme)]);
    let counts = file.ints(&[4]);
    file.attribute(mesh, "faceVertexCounts", &[("default", counts)]);
    let indices = file.ints(&[0, 1, 2, 3]);
    file.attribute(mesh, "faceVertexIndices", &[("default", indices)]);
    let points = file.floats(24, 3, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 2.0, 0.0]);
    file.attribute(mesh, "points", &[("default", points)]);
    // Whole numbers of a byte in the payload.
    file.attribute(mesh, "xformOp:translate", &[("default", 3 | INLINED | 23 << 48)]);
    // Two samples: times, and after them the values.
    let start = file.bytes.len() as u64;
    let mut samples = 16_u64.to_le_bytes().to_vec();
    samples.extend(0_u64.to_le_bytes());
    samples.extend((48_u64 << 48).to_le_bytes());
    samples.extend(8_u64.to_le_bytes());
    samples.extend(2_u64.to_le_bytes());
    for angle in [90.0_f32, 45.0] {
        samples.extend((u64::from(angle.to_bits()) | INLINED | 8 << 48).to_le_bytes());
    }
    file.bytes.extend(samples);
    file.attribute(mesh, "xformOp:rotateZ", &[("timeSamples", start | 46 << 48)]);
    let mut order = 2_u64.to_le_bytes().to_vec();
    if version < [0, 7, 0] {
        order = file.count(2);
    }
    for name in ["xformOp:translate", "xformOp:rotateZ"] {
        let token = file.token(name) as u32;
        order.extend(token.to_le_bytes());
    }
    let order = file.written(11, &order) | ARRAY;
    file.attribute(mesh, "xformOpOrder", &[("default", order)]);
    file.finish()
}

#[test]
fn binary_files_of_all_versions_are_the_same_model() {
    for version in [[0, 4, 0], [0, 5, 0], [0, 6, 0], [0, 7, 0], [0, 8, 0], [0, 10, 0]] {
        let loaded = load(&square(version), Format::Usd).unwrap();
        let text = load(file("", SQUARE).as_bytes(), Format::Usd).unwrap();
        assert_eq!(loaded.scene.meshes()[0].positions(), text.scene.meshes()[0].positions(), "{version:?}");
        assert_eq!(loaded.scene.meshes()[0].triangles(), text.scene.meshes()[0].triangles());
        assert_eq!(corners(&loaded), [[3.0, 0.0, 0.0]]);
        let turned = loaded.scene.instances()[0].transform.direction([1.0, 0.0, 0.0]);
        assert!((turned[1] - 1.0).abs() < 1e-12, "{turned:?}");
        assert_eq!(warnings(&loaded), ["USD: animations have no effect: the first sample is drawn"]);
    }
    assert_eq!(Format::detect(&square([0, 8, 0])), Some(Format::Usd));
    let error = load(&square([0, 99, 0]), Format::Usd).unwrap_err().to_string();
    assert_eq!(error, "USD: binary files of version 0.99.0 are not known");
}

#[test]
fn compressed_arrays_are_read() {
    let mut file = Writer::new([0, 8, 0]);
    let mesh = file.prim(0, "M", "Mesh", &[]);
    let counts = file.ints(&[3; 20]);
    file.attribute(mesh, "faceVertexCounts", &[("default", counts)]);
    let indices = file.ints(&(0..60).map(|k| k % 4).collect::<Vec<_>>());
    file.attribute(mesh, "faceVertexIndices", &[("default", indices)]);
    let points = file.floats(24, 3, &[0.0, 0.0, 0.0, 100.0, 0.0, 0.0, 100.0, 100.0, 0.0, 0.0, 100.0, 50.0]);
    file.attribute(mesh, "points", &[("default", points)]);
    // Opacities as a table with indices.
    let mut bytes = file.count(20);
    bytes.push(b't');
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend([0.25_f32, 1.0].iter().flat_map(|v| v.to_le_bytes()));
    bytes.extend(coded(&[0; 20]));
    let opacity = file.written(8, &bytes) | ARRAY | COMPRESSED;
    let uniform = file.token_value("uniform");
    let per_face = [("default", opacity), ("interpolation", uniform)];
    file.attribute(mesh, "primvars:displayOpacity", &per_face);
    let white = file.floats(24, 3, &[1.0, 1.0, 1.0]);
    file.attribute(mesh, "primvars:displayColor", &[("default", white)]);
    let file = file.finish();
    let loaded = load(&file, Format::Usd).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 20);
    assert!(loaded.scene.meshes()[0].colors().iter().all(|color| *color == [1.0, 1.0, 1.0, 0.25]));
    attack(&file, Format::Usd);
}

#[test]
fn binary_files_with_changed_bits_are_read_or_refused() {
    attack(&square([0, 8, 0]), Format::Usd);
    attack(&square([0, 4, 0]), Format::Usd);
}

#[test]
fn lists_of_references_and_variants_are_read() {
    let mut file = Writer::new([0, 8, 0]);
    let unit = u64::from(1.0_f32.to_bits()) | INLINED | 9 << 48;
    file.spec(0, 7, &[("metersPerUnit", unit)]);
    let cube = file.prim(0, "Cube", "Cube", &[]);
    // Prepended: no file, a path, offset and scale, no dictionary.
    let empty = file.token("") as u32;
    let mut list = vec![1 << 5];
    list.extend(1_u64.to_le_bytes());
    list.extend([empty.to_le_bytes(), (cube as u32).to_le_bytes()].concat());
    list.extend([0.0_f64.to_le_bytes(), 1.0_f64.to_le_bytes()].concat());
    list.extend(0_u64.to_le_bytes());
    let references = file.written(35, &list);
    let [set, chosen] = ["v", "x"].map(|text| file.token(text) as u32);
    let selection = [&1_u64.to_le_bytes()[..], &set.to_le_bytes(), &chosen.to_le_bytes()].concat();
    let selection = file.written(45, &selection);
    let prim = file.prim(0, "A", "", &[("references", references), ("variantSelection", selection)]);
    let variant = file.path(prim, "{v=x}", false);
    file.spec(variant, 10, &[]);
    file.prim(variant, "Inner", "Sphere", &[]);
    let loaded = load(&file.finish(), Format::Usd).unwrap();
    assert_eq!(loaded.scene.instances().len(), 3);
    assert_eq!(warnings(&loaded), [""; 0]);
}
