//! Scans that are written byte by byte, and read again.

use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, LoadError, Loaded, MemoryResolver};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_scene::{Axis, Mesh, PrimitiveKind};

fn cloud(loaded: &Loaded) -> &Mesh {
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!(mesh.kind(), PrimitiveKind::Points);
    mesh
}

fn rgb(r: u8, g: u8, b: u8) -> [f32; 4] {
    [srgb8_to_linear(r), srgb8_to_linear(g), srgb8_to_linear(b), 1.0]
}

fn pcd_header(data: &str) -> String {
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb normal_x normal_y normal_z _ ring\n\
         SIZE 4 4 4 4 4 4 4 1 2\nTYPE F F F F F F F U U\nCOUNT 1 1 1 1 1 1 1 4 1\nWIDTH 3\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA {data}\n"
    )
}

/// Position and colour of three points, of which one was not measured.
const PCD: [([f32; 3], [u8; 3]); 3] =
    [([0.0, 0.0, 0.0], [255, 0, 0]), ([f32::NAN; 3], [0, 0, 0]), ([1.0, 2.0, 3.0], [0, 128, 255])];

fn pcd_fields() -> Vec<Vec<u8>> {
    let mut fields = vec![Vec::new(); 9];
    for ([x, y, z], [r, g, b]) in PCD {
        for (field, value) in [x, y, z].into_iter().enumerate() {
            fields[field].extend(value.to_le_bytes());
        }
        fields[3].extend([b, g, r, 0]);
        for (field, value) in [0.0_f32, 0.0, 1.0].into_iter().enumerate() {
            fields[4 + field].extend(value.to_le_bytes());
        }
        fields[7].extend([0; 4]);
        fields[8].extend([7, 0]);
    }
    fields
}

fn pcd_binary() -> Vec<u8> {
    let (fields, sizes) = (pcd_fields(), [4, 4, 4, 4, 4, 4, 4, 4, 2]);
    let mut bytes = pcd_header("binary").into_bytes();
    for point in 0..3 {
        for (field, size) in fields.iter().zip(sizes) {
            bytes.extend(&field[point * size..(point + 1) * size]);
        }
    }
    bytes
}

fn pcd_compressed() -> Vec<u8> {
    let content = pcd_fields().concat();
    let packed: Vec<u8> =
        content.chunks(32).flat_map(|run| [&[run.len() as u8 - 1][..], run].concat()).collect();
    let mut bytes = pcd_header("binary_compressed").into_bytes();
    bytes.extend((packed.len() as u32).to_le_bytes());
    bytes.extend((content.len() as u32).to_le_bytes());
    [bytes, packed].concat()
}

fn pcd_text() -> Vec<u8> {
    let mut text = pcd_header("ascii");
    for ([x, y, z], [r, g, b]) in PCD {
        let color = f32::from_le_bytes([b, g, r, 0]);
        text += &format!("{x} {y} {z} {color:e} 0 0 1 0 0 0 0 7\n");
    }
    text.into_bytes()
}

#[test]
fn pcd_of_every_kind() {
    for bytes in [pcd_text(), pcd_binary(), pcd_compressed()] {
        assert_eq!(Format::detect(&bytes), Some(Format::Pcd));
        let loaded = load(&bytes, Format::Pcd).unwrap();
        assert_eq!(warnings(&loaded), ["PCD: fields without effect: 'ring'"]);
        let mesh = cloud(&loaded);
        assert_eq!(mesh.positions(), [[0.0; 3], [1.0, 2.0, 3.0]]);
        assert_eq!(mesh.colors(), [rgb(255, 0, 0), rgb(0, 128, 255)]);
        assert_eq!(mesh.normals(), [[0.0, 0.0, 1.0]; 2]);
        assert_eq!(loaded.scene.orientation().up, Axis::PositiveZ);
        attack(&bytes, Format::Pcd);
    }
}

#[test]
fn pcd_has_colours_in_words_and_in_parts() {
    let of = |fields: &str, kind: &str, count: usize, points: [&str; 2]| {
        let repeated = |word: &str| [word, " "].concat().repeat(count);
        let [sizes, counts] = [repeated("4"), repeated("1")];
        let [a, b] = points;
        format!(
            "VERSION .7\nFIELDS x y z {fields}\nSIZE 4 4 4 {sizes}\nTYPE F F F {kind}\nCOUNT 1 1 1 {counts}\nWIDTH 2\n\
             HEIGHT 1\nPOINTS 2\nDATA ascii\n0 0 0 {a}\n1 2 3 {b}\n"
        )
    };
    // A whole number in a field of floats is the word itself.
    let (red, word) = (rgb(255, 128, 0), "16744448");
    for text in [
        of("rgb", "U", 1, [word, "0"]),
        of("rgb", "F", 1, [word, "0"]),
        of("red green blue", "U U U", 3, ["255 128 0", "0 0 0"]),
        of("b g r", "F F F", 3, ["0 128 255", "0 0 0"]),
    ] {
        let loaded = load(text.as_bytes(), Format::Pcd).unwrap();
        assert!(loaded.warnings.is_empty(), "{text}: {:?}", loaded.warnings);
        assert_eq!(cloud(&loaded).colors(), [red, rgb(0, 0, 0)], "{text}");
        attack(text.as_bytes(), Format::Pcd);
    }
    let wide = load(of("r g b", "U U U", 3, ["65535 0 0", "0 0 0"]).as_bytes(), Format::Pcd).unwrap();
    assert_eq!(cloud(&wide).colors()[0], rgb(255, 0, 0));
}

#[test]
fn pcd_says_what_is_wrong() {
    let cut = pcd_binary();
    let loaded = load(&cut[..cut.len() - 40], Format::Pcd).unwrap();
    assert!(warnings(&loaded).contains(&"PCD: the file has 1 of 3 points"), "{:?}", loaded.warnings);
    for (from, to, message) in [
        ("FIELDS x y z", "FIELDS x y q", "there are no fields x, y and z"),
        ("DATA ascii", "DATA zip", "DATA 'zip' is not known"),
        ("SIZE 4", "SIZE 3", "field 'x' has a SIZE, TYPE or COUNT that is not known"),
        ("DATA ascii", "DATO ascii", "the header has no line DATA"),
    ] {
        let text = String::from_utf8(pcd_text()).unwrap().replace(from, to);
        let error = load(text.as_bytes(), Format::Pcd).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let text = "VERSION .7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 2\nHEIGHT 1\n\
                VIEWPOINT 1 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n0 0 0 1\n1 0 0 9\n";
    let loaded = load(text.as_bytes(), Format::Pcd).unwrap();
    assert_eq!(warnings(&loaded), ["PCD: the viewpoint has no effect"]);
    assert_eq!(cloud(&loaded).colors()[1], [1.0; 4]);
    // A bomb: the sizes must be those of the header.
    let mut bytes = pcd_compressed();
    let place = bytes.windows(11).position(|w| w == b"compressed\n").unwrap() + 15;
    bytes[place..place + 4].fill(0xff);
    let error = load(&bytes, Format::Pcd).unwrap_err().to_string();
    assert!(error.contains("claim 4294967295 bytes, not 102"), "{error}");
}

#[test]
fn columns_of_text_are_told() {
    let red = rgb(255, 0, 0);
    let wide = [srgb_to_linear(40_000.0 / 65535.0), 0.0, 0.0, 1.0];
    let cases: [(&str, [f32; 4], bool); 9] = [
        ("1 2 3 255 0 0\n4 5 6 255 0 0\n", red, false),
        ("x;y;z;r;g;b\n1,0;2;3;255;0;0\n4;5;6,0;255;0;0\n", red, false),
        ("//X Y Z R G B Nx Ny Nz\n1 2 3 255 0 0 0 0 1\n4 5 6 255 0 0 0 0 1\n", red, true),
        ("2\n1,2,3,-500,255,0,0\n4,5,6,-500,255,0,0\n", red, false),
        ("# c\n1\t2\t3\t1.0\t0\t0\t0\t0\t-1\n4\t5\t6\t1.0\t0\t0\t0\t0\t-1\n", red, true),
        ("1 2 3 40000 0 0\n4 5 6 40000 0 0\n", wide, false),
        ("1 2 3 0 0.6 0.8\r\n4 5 6 1 0 0\r\n", [0.0; 4], true),
        ("1 2 3\n4 5 6\n", [0.0; 4], false),
        ("x y z nx ny nz\n1 2 3 0 0 2\n4 5 6 0 0 2\n", [0.0; 4], true),
    ];
    for (text, color, normals) in cases {
        let loaded = load(text.as_bytes(), Format::Xyz).unwrap();
        assert!(loaded.warnings.is_empty(), "{text}: {:?}", loaded.warnings);
        let mesh = cloud(&loaded);
        assert_eq!(mesh.positions(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{text}");
        let expected = if color == [0.0; 4] { vec![] } else { vec![color; 2] };
        assert_eq!((mesh.colors(), !mesh.normals().is_empty()), (&expected[..], normals), "{text}");
        attack(text.as_bytes(), Format::Xyz);
    }
}

#[test]
fn text_of_other_things_is_no_cloud() {
    for text in ["3\nwater\nO 0 0 0\nH 1 0 0\nH 0 1 0\n", "a b c\nd e f\n", "1 2\n3 4\n"] {
        let error = load(text.as_bytes(), Format::Xyz).unwrap_err().to_string();
        assert!(error.contains("no line has three numbers"), "{error}");
    }
    let mixed = format!("1 2 3\n{}", "once upon a time\n".repeat(3));
    let error = load(mixed.as_bytes(), Format::Xyz).unwrap_err().to_string();
    assert!(error.contains("it is of another format"), "{error}");
    assert!(load(b"1 2 3\n\0\x01", Format::Xyz).unwrap_err().to_string().contains("it is no text"));
    let loaded = load(b"1 2 3 9\n1 2 x 9\n2 2 2 8\n", Format::Xyz).unwrap();
    assert_eq!(warnings(&loaded), ["XYZ: 1 line left out: numbers missing, or words in their place"]);
}

/// Fields of a point of LAS.
struct Point {
    at: [i32; 3],
    intensity: u16,
    class: u8,
    color: [u16; 3],
}

fn las(minor: u8, format: u8, points: &[Point]) -> Vec<u8> {
    let (length, color) = super::las::layout_of(format);
    let size = if minor >= 4 { 375_u16 } else { 227 };
    let mut bytes = vec![0; usize::from(size)];
    let mut put = |place: usize, value: &[u8]| bytes[place..place + value.len()].copy_from_slice(value);
    put(0, b"LASF");
    put(24, &[1, minor]);
    put(94, &size.to_le_bytes());
    put(96, &u32::from(size).to_le_bytes());
    put(104, &[format]);
    put(105, &(length as u16).to_le_bytes());
    put(107, &(if minor >= 4 { 0 } else { points.len() as u32 }).to_le_bytes());
    for k in 0..3 {
        put(131 + 8 * k, &0.01_f64.to_le_bytes());
        put(155 + 8 * k, &[500_000.0_f64, 4_600_000.0, 0.0][k].to_le_bytes());
    }
    if minor >= 4 {
        put(247, &(points.len() as u64).to_le_bytes());
    }
    for point in points {
        let mut record = vec![0; length];
        for (k, value) in point.at.iter().enumerate() {
            record[4 * k..4 * k + 4].copy_from_slice(&value.to_le_bytes());
        }
        record[12..14].copy_from_slice(&point.intensity.to_le_bytes());
        record[if format >= 6 { 16 } else { 15 }] = point.class;
        if let Some(place) = color {
            for (k, value) in point.color.iter().enumerate() {
                record[place + 2 * k..place + 2 * k + 2].copy_from_slice(&value.to_le_bytes());
            }
        }
        bytes.extend(record);
    }
    bytes
}

fn points(color: [u16; 3]) -> [Point; 2] {
    [
        Point { at: [0, 0, 0], intensity: 10, class: 2, color },
        Point { at: [150, -50, 25], intensity: 90, class: 5, color },
    ]
}

#[test]
fn las_of_every_point_format() {
    for format in 0..=10_u8 {
        let minor = if format >= 6 { 4 } else { 2 };
        let bytes = las(minor, format, &points([65535, 0, 0]));
        assert_eq!(Format::detect(&bytes), Some(Format::Las));
        let loaded = load(&bytes, Format::Las).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let mesh = cloud(&loaded);
        // In coordinates of a map, and as exact as the file has them.
        let [a, b] = *mesh.positions().first_chunk().unwrap();
        assert_eq!([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [1.5, -0.5, 0.25]);
        assert!(loaded.scene.origin().iter().any(|v| v.abs() > 400_000.0));
        if super::las::layout_of(format).1.is_some() {
            assert_eq!(mesh.colors(), [rgb(255, 0, 0); 2]);
        } else {
            assert_eq!(mesh.colors()[1], [1.0; 4]);
            assert!(mesh.colors()[0][0] < 0.1);
        }
        assert_eq!(loaded.scene.orientation().up, Axis::PositiveZ);
    }
    attack(&las(2, 3, &points([255, 0, 0])), Format::Las);
    attack(&las(4, 7, &points([255, 0, 0])), Format::Las);
}

#[test]
fn las_as_programs_write_it() {
    // Codes of 8 bits, no colours at all, no intensities either.
    let loaded = load(&las(2, 2, &points([255, 128, 0])), Format::Las).unwrap();
    assert_eq!(cloud(&loaded).colors()[0], rgb(255, 128, 0));
    let loaded = load(&las(2, 2, &points([0; 3])), Format::Las).unwrap();
    assert!(cloud(&loaded).colors()[0] != cloud(&loaded).colors()[1]);
    let mut withheld = las(2, 0, &points([0; 3]));
    withheld[227 + 15] |= 0x80;
    let loaded = load(&withheld, Format::Las).unwrap();
    assert_eq!(
        (cloud(&loaded).positions().len(), warnings(&loaded)),
        (1, vec!["LAS: 1 withheld point left out"])
    );
    let bytes = las(2, 0, &points([0; 3]));
    let loaded = load(&bytes[..bytes.len() - 1], Format::Las).unwrap();
    assert_eq!(warnings(&loaded), ["LAS: the file ends after 1 of 2 points"]);
    let mut packed = bytes;
    packed[104] |= 0x80;
    let error = load(&packed, Format::Las).unwrap_err();
    assert_eq!(error.to_string(), "LAZ: the description of the compression is missing");
    let bytes = las(2, 0, &points([0; 3]));
    let within = |vertices: u64| {
        let limits = limits().with_vertices(vertices);
        load_beside(&bytes, Format::Las, &MemoryResolver::default(), &limits)
    };
    let loaded = within(3).unwrap();
    assert_eq!(warnings(&loaded), ["LAS: of 2 points one in 2 is drawn: the limits allow no more"]);
    assert!(matches!(within(1), Err(LoadError::Limit(_))));
}

/// Two scans of two points and a miss; the second stands 10 further along x, turned by 90 degrees about z.
fn ptx(colors: bool) -> String {
    let identity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n";
    let color = if colors { " 255 0 0" } else { "" };
    let points = format!("1 0 0 0.25{color}\n0 0 0 0.5{color}\n0 2 1 0.75{color}\n");
    format!(
        "3\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n{identity}0 0 0 1\n{points}\
         3\r\n1\r\n10 0 0\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 0 0 1\n{points}"
    )
}

#[test]
fn scans_of_ptx_stand_where_they_were_taken() {
    for colors in [false, true] {
        let text = ptx(colors);
        let loaded = load(text.as_bytes(), Format::Ptx).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let mesh = cloud(&loaded);
        let expected = [[1.0, 0.0, 0.0], [0.0, 2.0, 1.0], [10.0, 1.0, 0.0], [8.0, 0.0, 1.0]];
        assert_eq!(mesh.positions(), expected);
        assert_eq!(mesh.colors()[3], if colors { rgb(255, 0, 0) } else { [1.0; 4] });
        attack(text.as_bytes(), Format::Ptx);
    }
    let text = ptx(false);
    let cut = &text[..text.len() - 11];
    let loaded = load(cut.as_bytes(), Format::Ptx).unwrap();
    assert_eq!(warnings(&loaded), ["PTX: scan 2 ends after 2 of 3 points"]);
    let error = load(b"3 1\n0 0\n", Format::Ptx).unwrap_err().to_string();
    assert!(error.contains("scan 1: its position or matrix ends early"), "{error}");
    let error = load(b"hello world\n", Format::Ptx).unwrap_err().to_string();
    assert!(error.contains("scan 1: it does not begin with its columns and rows"), "{error}");
}
